//! `umbriel render`: the scene with its computed shadows, as a picture.

use std::path::Path;

use umbriel_io::write::{Picture, Staged, write_png, write_png_parts};
use umbriel_scene::Scene;
use umbriel_shadow::{Progress, Request, bake_hours};
use umbriel_visibility::{
    CostModel, RayCaster, View,
    two_pass::{ShadowPolygons, TwoPassDefect},
};

use crate::{
    cli::{
        Failure, acceleration, lines,
        plan::{self, CellUse},
        reach,
        render_args::{RenderArgs, ShadowsChoice, SurfaceMethod},
        suns, surfaces,
    },
    output::{
        self, Format, hours_picture,
        lamplight::Lamplight,
        legend,
        picture::{Studio, Undecided},
        viewpoint,
    },
    progress::{Bar, Interrupt},
};

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    if let Some(table) = &args.suns.suns {
        return run_hours(args, table);
    }
    let draws_lines = args.lines || args.method == Some(SurfaceMethod::Lines);
    if args.dashed && !draws_lines || args.undecided.is_some() && draws_lines {
        let text = "--dashed is for drawings (--lines or --method lines), --undecided for pictures of surfaces";
        return Err(Failure::Unusable(text.to_owned()));
    }
    if draws_lines {
        return lines::run(args);
    }
    let files = output::targets(&args.output, &[Format::Png], &[&args.scene.scene])?;
    let mut loaded = plan::load(&args.scene)?;
    output::check_unread(&files, &loaded.file.files)?;
    let interrupt = &Interrupt::install();
    let lights = plan::choose_lights(&mut loaded.file, &args.lights, &args.scene.scene)?;
    let detail = plan::choose_detail(&args.detail, &loaded.file, CellUse::Cells)?;
    loaded.file.scene.camera = args.camera.or(loaded.file.scene.camera);
    let scene = &loaded.file.scene;
    plan::tell_findings(scene, args.scene.quiet);
    let (view, objects, mut caster) = stand(args, scene, &lights)?;
    interrupt.check()?;
    if args.method.is_none() {
        let is_looked_at = args.shadows == ShadowsChoice::Cells && view.width.max(view.height) <= LOOK;
        prepare(&mut caster, &view, args, u32::from(is_looked_at));
    }
    let bar = Bar::new(interrupt, args.scene.quiet);
    let lamplight = Lamplight::new(scene, &lights);
    let asked = (&lamplight, &caster);
    let studio = match args.shadows {
        ShadowsChoice::Polygons => polygons(scene, asked, &lights)?,
        ShadowsChoice::Cells => {
            let own = plan::own_details(&args.detail, &loaded.file, CellUse::Cells)?;
            let effort = plan::effort(&args.detail, &loaded.file, lights.len());
            let request = Request { own, lights, effort, ..Request::everything(scene, detail) };
            baked(args, scene, asked, (&view, request), &bar)?
        }
    };
    draw(args, (scene, &objects), (&studio, view), &files, &bar)
}

/// A studio with the cells of a bake.
fn baked<'a>(
    args: &RenderArgs,
    scene: &Scene,
    (lamplight, caster): (&'a Lamplight<'a>, &'a RayCaster),
    (view, request): (&View, Request),
    bar: &Bar,
) -> Result<Studio<'a>, Failure> {
    let undecided = args.undecided.map_or(Undecided::Decide, Undecided::Show);
    let coverage = coverage(caster, view);
    let receivers = worth_baking(scene, &coverage, undecided, args.aa);
    let request = Request { receivers, keep_cells: true, ..request };
    let report = umbriel_shadow::bake(scene, &request, bar)?;
    plan::tell_work(&report.work, args.scene.quiet);
    let mut studio = Studio::new(scene, (lamplight, caster), &report, undecided);
    if undecided == Undecided::Decide {
        let points: Vec<u64> = coverage.iter().map(|pixels| pixels * u64::from(args.aa * args.aa)).collect();
        let choices = studio.prepare(&report, &points, args.acceleration.of_rays());
        if !args.scene.quiet {
            let names = report.lights.iter().map(|light| scene.lights[light.light].name.as_str());
            acceleration::tell_lights(names.zip(&choices));
        }
    }
    Ok(studio)
}

/// A studio with shadow polygons, which do not depend on the view.
fn polygons<'a>(
    scene: &Scene,
    asked: (&'a Lamplight<'a>, &'a RayCaster),
    lights: &[usize],
) -> Result<Studio<'a>, Failure> {
    let cast = |&light: &usize| {
        let source = scene.lights[light].source;
        ShadowPolygons::cast(asked.0.scene(), &source).map(|polygons| (source, polygons))
    };
    let lamps = lights.iter().map(cast).collect::<Result<Vec<_>, _>>();
    let refused = |defect: TwoPassDefect| {
        let named = match defect {
            TwoPassDefect::Curved { object } | TwoPassDefect::Holes { object } => {
                format!(" (\"{}\")", asked.0.scene().objects[object].name)
            }
            _ => String::new(),
        };
        Failure::Refused(format!("--shadows polygons: {defect}{named}"))
    };
    Ok(Studio::with_polygons(asked, lamps.map_err(refused)?))
}

/// Rays along the longer edge of the picture that tell how much is seen of each object.
const LOOK: u32 = 2048;

/// Pixels of each object; of large pictures about so many.
fn coverage(caster: &RayCaster, view: &View) -> Vec<u64> {
    let shrink = view.width.max(view.height).div_ceil(LOOK);
    let small = View { width: view.width.div_ceil(shrink), height: view.height.div_ceil(shrink), ..*view };
    caster.coverage(&small).into_iter().map(|pixels| pixels * u64::from(shrink * shrink)).collect()
}

/// Draws and writes the picture: band by band where it is one picture in one file, else held whole.
fn draw(
    args: &RenderArgs,
    (scene, objects): (&Scene, &[usize]),
    (studio, view): (&Studio, View),
    files: &[output::Target],
    bar: &Bar,
) -> Result<(), Failure> {
    let canvas = surfaces::Canvas { studio, view, subpixels: args.aa, bar };
    let band = canvas.band();
    let is_held = args.method == Some(SurfaceMethod::All) || args.undecided.is_some() || files.len() > 1;
    if is_held && u64::from(view.width) * u64::from(view.height) > MOST_HELD {
        let text =
            format!("a picture of more than {MOST_HELD} pixels goes to one file, by one method, without --undecided");
        return Err(Failure::Unusable(text));
    }
    let Some(method) = args.method else {
        let mut rows = |rows| Ok(studio.rows(&view, args.aa, rows, bar)?);
        if !is_held {
            return write_rows(&view, band, files, &mut rows, bar);
        }
        let mut picture = Picture { width: view.width, height: view.height, pixels: rows(0..view.height)? };
        if let Some(undecided) = args.undecided {
            legend::add(&mut picture, undecided);
        }
        return write(&picture, files, bar);
    };
    let shot = canvas.shot(scene, objects)?;
    let mut drawing = canvas.begin(&shot, method);
    if is_held {
        let mut picture = drawing.whole()?;
        drawing.tell()?;
        if let Some(undecided) = args.undecided {
            legend::add(&mut picture, undecided);
        }
        return write(&picture, files, bar);
    }
    write_rows(&view, band, files, &mut |rows| Ok(drawing.draw(rows)?.concat()), bar)?;
    drawing.tell()
}

/// Pixels of a picture that is held whole.
const MOST_HELD: u64 = 1 << 25;

/// Writes the one file as its rows come.
fn write_rows(
    view: &View,
    band: u32,
    files: &[output::Target],
    rows: &mut dyn FnMut(std::ops::Range<u32>) -> Result<Vec<[u8; 3]>, Failure>,
    bar: &Bar,
) -> Result<(), Failure> {
    let mut failed = None;
    let mut part = |first: u32| {
        rows(first..(first + band).min(view.height)).map_err(|failure| {
            failed = Some(failure);
            std::io::Error::other("the picture was not finished")
        })
    };
    let mut stage = |file: &output::Target| {
        let parts = (0..view.height).step_by(band as usize).map(&mut part);
        Staged::new(&file.path, |out| write_png_parts([view.width, view.height], parts, out))
    };
    let staged = files.iter().map(&mut stage).collect::<Result<Vec<_>, _>>();
    if let Some(failure) = failed {
        return Err(failure);
    }
    if bar.is_cancelled() {
        return Err(Failure::Interrupted);
    }
    output::commit_all(staged?)
}

/// Where the picture is taken from, the objects that it is drawn from, and what casts its rays.
fn stand(args: &RenderArgs, scene: &Scene, lights: &[usize]) -> Result<(View, Vec<usize>, RayCaster), Failure> {
    let [width, height] = args.size;
    let whole = || RayCaster::new(scene);
    let view = match scene.camera {
        Some(_) => View::of(scene, width, height),
        None => viewpoint::choose(scene, &whole(), lights, width, height),
    };
    let objects = reach::submitted(scene, &view, args.scene.quiet)?;
    let caster = RayCaster::of_objects(scene, &objects);
    Ok((view, objects, caster))
}

/// The picture of a day of suns. Its cells are all that is known: every object that is seen is baked.
fn run_hours(args: &RenderArgs, table: &Path) -> Result<(), Failure> {
    let files = output::targets(&args.output, &[Format::Png], &[&args.scene.scene, table])?;
    let rows = suns::read(table, &args.suns)?;
    let mut loaded = plan::load(&args.scene)?;
    output::check_unread(&files, &loaded.file.files)?;
    let interrupt = &Interrupt::install();
    let lights: Vec<_> = suns::place(&rows, &mut loaded.file, table)?.into_iter().flatten().collect();
    let detail = plan::choose_detail(&args.detail, &loaded.file, CellUse::Cells)?;
    loaded.file.scene.camera = args.camera.or(loaded.file.scene.camera);
    let scene = &loaded.file.scene;
    plan::tell_findings(scene, args.scene.quiet);
    let (view, _, mut caster) = stand(args, scene, &[])?;
    interrupt.check()?;
    prepare(&mut caster, &view, args, 1);
    let coverage = caster.coverage(&view);
    let receivers = (0..scene.objects.len()).filter(|&object| coverage[object] > 0).collect();
    let bar = Bar::new(interrupt, args.scene.quiet);
    let request = Request { lights: Vec::new(), receivers, keep_cells: true, ..Request::everything(scene, detail) };
    let report = bake_hours(scene, &request, &lights, &bar).map_err(|error| suns::failure(error, table))?;
    let picture = hours_picture::picture(scene, &caster, &report, &view, args.aa, &bar)?;
    write(&picture, &files, &bar)
}

/// Makes the caster ready for the picture's rays, and for so many looks at all of it beforehand, and says how.
fn prepare(caster: &mut RayCaster, view: &View, args: &RenderArgs, looks: u32) {
    let acceleration = args.acceleration.of_rays();
    let choices = caster.prepare(view, args.aa * args.aa + looks, acceleration, &CostModel::MEASURED);
    if !args.scene.quiet {
        acceleration::tell_eye(&choices);
    }
}

/// Writes all files or none.
fn write(picture: &Picture, files: &[output::Target], bar: &Bar) -> Result<(), Failure> {
    let stage = |file: &output::Target| Staged::new(&file.path, |out| write_png(picture, out));
    let staged = files.iter().map(stage).collect::<Result<Vec<_>, _>>()?;
    if bar.is_cancelled() {
        return Err(Failure::Interrupted);
    }
    output::commit_all(staged)
}

/// The objects whose cells the picture needs: those seen and, unless their undecided cells are to be shown, not of more
/// faces than pixels. A bake places every face that may cast a shadow, so none is worth it in a scene of more faces than
/// the picture has points. Everything else is answered point by point, which looks only at what its rays come near.
fn worth_baking(scene: &Scene, coverage: &[u64], undecided: Undecided, subpixels: u32) -> Vec<usize> {
    let shown = undecided != Undecided::Decide;
    let faces = |object: usize| scene.objects[object].face_count() as u64;
    let points = coverage.iter().sum::<u64>() * u64::from(subpixels * subpixels);
    let few = (0..scene.objects.len()).map(faces).sum::<u64>() <= points;
    let worth = |&object: &usize| {
        let pixels = coverage[object];
        pixels > 0 && (shown || few && pixels >= faces(object))
    };
    (0..scene.objects.len()).filter(worth).collect()
}
