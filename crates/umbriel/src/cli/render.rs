//! `umbriel render`: the scene with its computed shadows, as a picture.

use std::path::Path;

use umbriel_io::write::{Picture, Staged, write_png};
use umbriel_scene::Scene;
use umbriel_shadow::{CellMethod, Progress, Request, bake_hours};
use umbriel_visibility::{Acceleration, Choice, CostModel, RayCaster, View};

use crate::{
    cli::{
        Failure, lines,
        plan::{self, CellUse},
        render_args::RenderArgs,
        suns, surfaces,
    },
    output::{
        self, Format, hours_picture,
        picture::{Studio, Undecided},
        viewpoint,
    },
    progress::{Bar, Interrupt},
};

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    if let Some(table) = &args.suns.suns {
        return run_hours(args, table);
    }
    if args.lines {
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
    let mut caster = RayCaster::new(scene);
    let [width, height] = args.size;
    let view = viewpoint::choose(scene, &caster, &lights, width, height);
    interrupt.check()?;
    if args.method.is_none() {
        prepare(&mut caster, &view, args);
    }
    let undecided = args.undecided.map_or(Undecided::Decide, Undecided::Show);
    let receivers = worth_baking(scene, &caster.coverage(&view), undecided, args.aa);
    let bar = Bar::new(interrupt, args.scene.quiet);
    let request = Request { detail, sampling: None, lights, receivers, keep_cells: true, method: CellMethod::Auto };
    let report = umbriel_shadow::bake(scene, &request, &bar)?;
    let studio = Studio::new(scene, &caster, &report, undecided);
    let picture = match args.method {
        None => studio.picture(&view, args.aa, &bar)?,
        Some(method) => {
            surfaces::Canvas { scene, studio: &studio, view, subpixels: args.aa, bar: &bar }.draw(method)?
        }
    };
    write(&picture, &files, &bar)
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
    let mut caster = RayCaster::new(scene);
    let [width, height] = args.size;
    let view = viewpoint::choose(scene, &caster, &[], width, height);
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
        let ways =
            [(Acceleration::Bvh, "BVH"), (Acceleration::Octree, "octree"), (Acceleration::Projection, "projection")];
        let told = ways.into_iter().enumerate().filter_map(|(place, (way, name))| told(&choices, place, way, name));
        told.for_each(|line| output::tell(&line));
    }
}

/// Which meshes get one way, and what the model of costs expects of it and of the best other one.
fn told(choices: &[Choice], place: usize, way: Acceleration, name: &str) -> Option<String> {
    let chosen = || choices.iter().filter(|choice| choice.chosen == way);
    let sum = |number: &dyn Fn(&Choice) -> f64| chosen().map(number).sum::<f64>();
    let other = |choice: &Choice| {
        let others = (0..3).filter(|&other| other != place).map(|other| choice.expected[other]);
        others.fold(f64::INFINITY, f64::min)
    };
    let [own, others] = [sum(&|choice| choice.expected[place]), sum(&other)].map(|nanoseconds| nanoseconds / 1e6);
    let [rays, triangles] = [sum(&|choice| choice.rays as f64), sum(&|choice| choice.triangles as f64)];
    (chosen().count() > 0).then(|| {
        format!(
            "note: rays by {name} for {} meshes, {triangles} triangles, {rays} rays: {own:.0} ms expected on one thread, \
             {others:.0} ms otherwise",
            chosen().count()
        )
    })
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
