//! `umbriel render`: the scene with its computed shadows, as a picture.

use std::path::Path;

use umbriel_io::write::{Picture, Staged, write_png};
use umbriel_scene::Scene;
use umbriel_shadow::{CellMethod, Progress, Request, bake_hours};
use umbriel_visibility::{CostModel, RayCaster, View};

use crate::{
    cli::{
        Failure, acceleration, lines,
        plan::{self, CellUse},
        reach,
        render_args::{RenderArgs, SurfaceMethod},
        suns, surfaces,
    },
    output::{
        self, Format, hours_picture, legend,
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
    let detail = plan::choose_detail(&args.detail, loaded.file.detail, CellUse::Cells)?;
    loaded.file.scene.camera = args.camera.or(loaded.file.scene.camera);
    let scene = &loaded.file.scene;
    plan::tell_findings(scene, args.scene.quiet);
    let (view, objects, mut caster) = stand(args, scene, &lights)?;
    interrupt.check()?;
    if args.method.is_none() {
        prepare(&mut caster, &view, args);
    }
    let undecided = args.undecided.map_or(Undecided::Decide, Undecided::Show);
    let coverage = caster.coverage(&view);
    let receivers = worth_baking(scene, &coverage, undecided, args.aa);
    let bar = Bar::new(interrupt, args.scene.quiet);
    let request = Request { detail, sampling: None, lights, receivers, keep_cells: true, method: CellMethod::Auto };
    let report = umbriel_shadow::bake(scene, &request, &bar)?;
    let mut studio = Studio::new(scene, &caster, &report, undecided);
    if undecided == Undecided::Decide {
        let points: Vec<u64> = coverage.iter().map(|pixels| pixels * u64::from(args.aa * args.aa)).collect();
        let choices = studio.prepare(&report, &points, args.acceleration.of_rays());
        if !args.scene.quiet {
            let named = report.lights.iter().map(|light| scene.lights[light.light].name.as_str());
            named.zip(&choices).for_each(|(name, choice)| acceleration::tell_light(name, choice));
        }
    }
    let mut picture = match args.method {
        None => studio.picture(&view, args.aa, &bar)?,
        Some(method) => {
            surfaces::Canvas { scene, objects: &objects, studio: &studio, view, subpixels: args.aa, bar: &bar }
                .draw(method)?
        }
    };
    if let Some(undecided) = args.undecided {
        legend::add(&mut picture, undecided);
    }
    write(&picture, &files, &bar)
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
    let detail = plan::choose_detail(&args.detail, loaded.file.detail, CellUse::Cells)?;
    loaded.file.scene.camera = args.camera.or(loaded.file.scene.camera);
    let scene = &loaded.file.scene;
    plan::tell_findings(scene, args.scene.quiet);
    let (view, _, mut caster) = stand(args, scene, &[])?;
    interrupt.check()?;
    prepare(&mut caster, &view, args);
    let coverage = caster.coverage(&view);
    let receivers = (0..scene.objects.len()).filter(|&object| coverage[object] > 0).collect();
    let bar = Bar::new(interrupt, args.scene.quiet);
    let request =
        Request { detail, sampling: None, lights: Vec::new(), receivers, keep_cells: true, method: CellMethod::Auto };
    let report = bake_hours(scene, &request, &lights, &bar).map_err(|error| suns::failure(error, table))?;
    let picture = hours_picture::picture(scene, &caster, &report, &view, args.aa, &bar)?;
    write(&picture, &files, &bar)
}

/// Makes the caster ready for the picture's rays, and says how.
fn prepare(caster: &mut RayCaster, view: &View, args: &RenderArgs) {
    let acceleration = args.acceleration.of_rays();
    let choices = caster.prepare(view, args.aa * args.aa, acceleration, &CostModel::MEASURED);
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
