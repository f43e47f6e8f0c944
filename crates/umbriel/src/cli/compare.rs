//! `umbriel compare`: hard shadows on one picture by the bake, by rays, shadow volumes, shadow maps, and by the source's words.
//!
//! Each way is asked about the points that the middles of the pixels see; shadow volumes look at them from the camera, as their stencil buffers do.

use std::{io::Write, path::Path, time::Instant};

use umbriel_io::write::{Staged, write_png};
use umbriel_scene::Scene;
use umbriel_shadow::{
    Detail, SamplePoint,
    rivals::{Literal, PointRays, Polygons, Rival, ShadowMap, ShadowVolume},
    tradeoff::{Course, Judge, MeasureDefect, Setting, measure_and_state},
};
use umbriel_visibility::{RayCaster, View};

use super::{
    Failure,
    args::{CompareArgs, Way},
    plan::{self, CellUse},
};
use crate::{
    output::{self, Format, Target, compare::Comparison, viewpoint},
    progress::{Bar, Interrupt},
};

/// Rays that the method read literally may cast.
const LITERAL_RAYS: u64 = 50_000_000;

/// Shadow maps that are tried unless somebody says otherwise.
const MAPS: [usize; 2] = [512, 2048];

pub(crate) fn run(args: &CompareArgs) -> Result<(), Failure> {
    let inputs = [args.scene.scene.as_path()];
    let files = output::targets_and_json(&args.output, args.json.as_deref(), &[Format::Png], &inputs)?;
    let mut loaded = plan::load(&args.scene)?;
    output::check_unread(&files, &loaded.file.files)?;
    let interrupt = &Interrupt::install();
    let light = plan::choose_lights(&mut loaded.file, &args.lights, &args.scene.scene)?[0];
    let detail = plan::choose_detail(&args.detail, &loaded.file, CellUse::Cells)?;
    let scene = &loaded.file.scene;
    plan::tell_findings(scene, args.scene.quiet);
    let caster = RayCaster::new(scene);
    let [width, height] = args.size;
    let view = viewpoint::choose(scene, &caster, &[light], width, height);
    let is_asked = |way: &Way| args.method.is_empty() || args.method.contains(way);
    let settings: Vec<Setting> = settings(args, detail, &view)
        .into_iter()
        .filter(|(way, _)| is_asked(way))
        .map(|(_, setting)| setting)
        .collect();
    let bar = Bar::new(interrupt, args.scene.quiet);
    let comparison = compare(scene, light, &caster, &view, args, &settings, &bar)?;
    write(&comparison, &files, interrupt)?;
    let to_stdout = args.json.as_deref() == Some(Path::new("-"));
    output::print(&if to_stdout { comparison.to_json() } else { comparison.to_text() })
}

/// All ways with their settings.
fn settings(args: &CompareArgs, detail: Detail, view: &View) -> Vec<(Way, Setting)> {
    let eye = Some(view.ray(0.5, 0.5).origin);
    let maps = if args.map.is_empty() { MAPS.to_vec() } else { args.map.clone() };
    let rival = |way, rival: Box<dyn Rival>| (way, Setting::Rival(rival));
    let mut settings = vec![
        (Way::Bake, Setting::Bake(detail)),
        (Way::Points, Setting::Points),
        (Way::Points, Setting::PointsOfSolids),
        rival(Way::Rays, Box::new(PointRays)),
        rival(Way::Volume, Box::new(ShadowVolume { eye })),
    ];
    settings.extend(maps.into_iter().map(|size| rival(Way::Map, Box::new(ShadowMap::new(size)))));
    settings.push(rival(Way::Literal, Box::new(Literal { interior: 4, boundary: 8, most_rays: LITERAL_RAYS })));
    settings
}

/// The points that pixels see, and what each setting says of them.
fn compare(
    scene: &Scene,
    light: usize,
    caster: &RayCaster,
    view: &View,
    args: &CompareArgs,
    settings: &[Setting],
    bar: &Bar,
) -> Result<Comparison, Failure> {
    let begun = Instant::now();
    let polygons = Polygons::new(scene, args.divisions);
    let polygons_seconds = begun.elapsed().as_secs_f64();
    let (mut pixels, mut samples, mut shades) = (Vec::new(), Vec::new(), Vec::new());
    for (pixel, hit) in caster.picture(view).into_iter().enumerate() {
        let Some(hit) = hit else { continue };
        let sample = SamplePoint {
            object: hit.object,
            face: hit.face,
            u: hit.u,
            v: hit.v,
            corner: 0,
            from_corner: [hit.u, hit.v],
        };
        if polygons.point(&sample).is_some() {
            let [x, y] = [pixel as u32 % view.width, pixel as u32 / view.width].map(|at| f64::from(at) + 0.5);
            let direction = view.ray(x, y).direction.normalize_or_zero();
            shades.push(hit.normal.normalize_or_zero().dot(direction).abs());
            pixels.push(pixel);
            samples.push(sample);
        }
    }
    let judge = Judge::of_samples(scene, &polygons, &scene.lights[light].source, samples);
    let course = Course { scene, polygons: &polygons, light, judge: &judge };
    let (mut ways, mut refused) = (Vec::new(), Vec::new());
    for setting in settings {
        match measure_and_state(&course, setting, bar) {
            Ok(way) => ways.push(way),
            Err(MeasureDefect::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(reason) => refused.push((setting.name(), reason.to_string())),
        }
    }
    let (light, truth) = (scene.lights[light].name.clone(), judge.lit().to_vec());
    Ok(Comparison { light, size: args.size, pixels, truth, shades, polygons_seconds, ways, refused })
}

fn write(comparison: &Comparison, files: &[Target], interrupt: &Interrupt) -> Result<(), Failure> {
    let mut staged = Vec::new();
    for file in files {
        staged.push(match file.format {
            Format::Png => {
                let strip = comparison.strip();
                Staged::new(&file.path, |out| write_png(&strip, out))?
            }
            _ => Staged::new(&file.path, |out| out.write_all(comparison.to_json().as_bytes()))?,
        });
    }
    interrupt.check()?;
    output::commit_all(staged)
}
