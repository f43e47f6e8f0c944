//! From what was typed to ready objects: the scene, its lights, receivers, detail, threads.

use std::{collections::BTreeMap, path::Path, time::Instant};

use umbriel_geometry::{LightDefect, LightSource, cut_out::Opacity};
use umbriel_io::{Blend, Colliders, DetailSetting, LoadOptions, LoadedScene, Outside, UpAxis, surface_findings};
use umbriel_scene::{Finding, FindingKind, Light, Scene, Shape, Sides};
use umbriel_shadow::{Detail, OwnDetails, Request, Sampling, Work, most_samples, typical_effort};

use crate::{
    cli::{
        Failure,
        args::{BakeArgs, BlendChoice, DetailArgs, LightArgs, SceneArgs, SidesChoice, Up},
        glob::Pattern,
        reach::{self, VisibleFrom},
    },
    output::{self, findings},
};

/// The source's depth at which decided cells are still stored.
const INTERIOR_DEPTH: u8 = 4;

/// A scene that was read, and how long that took.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) file: LoadedScene,
    pub(crate) seconds: f64,
}

impl Loaded {
    /// What is found on the surfaces themselves: looking at these is part of loading.
    pub(crate) fn find_on_surfaces(&mut self) -> Vec<Finding> {
        let begun = Instant::now();
        let findings = surface_findings(&self.file.scene);
        self.seconds += begun.elapsed().as_secs_f64();
        findings
    }
}

/// What was found while reading, and on the surfaces.
pub(crate) fn all_findings(scene: &Scene, on_surfaces: Vec<Finding>) -> Vec<Finding> {
    scene.findings.iter().cloned().chain(on_surfaces).collect()
}

/// Sets up the threads and reads the scene.
pub(crate) fn load(args: &SceneArgs) -> Result<Loaded, Failure> {
    load_with_layouts(args, None)
}

/// As [`load`]; also the layouts of light maps from that set of texture coordinates, if one is given.
pub(crate) fn load_with_layouts(args: &SceneArgs, lightmap_set: Option<u32>) -> Result<Loaded, Failure> {
    start_threads(args.threads)?;
    let begun = Instant::now();
    let options = LoadOptions {
        up: args.up.map(|up| match up {
            Up::Y => UpAxis::Y,
            Up::Z => UpAxis::Z,
        }),
        north_degrees: args.north,
        outside: if args.allow_outside { Outside::Allowed } else { Outside::Refused },
        sides: args.sides.map(|sides| match sides {
            SidesChoice::Auto => Sides::Auto,
            SidesChoice::One => Sides::One,
            SidesChoice::Two => Sides::Two,
        }),
        blend: match args.blend {
            None | Some(BlendChoice::Block) => Blend::Block,
            Some(BlendChoice::Ignore) => Blend::Ignore,
        },
        colliders: if args.colliders { Colliders::InPlace } else { Colliders::WithoutMesh },
        lightmap_set,
    };
    let file = umbriel_io::load(&args.scene, &options)?;
    Ok(Loaded { file, seconds: begun.elapsed().as_secs_f64() })
}

/// Sets up so many threads, or one a core. This one is among them: small jobs would wait longer for another to wake up than they take.
fn start_threads(wanted: Option<u16>) -> Result<(), Failure> {
    let count = wanted.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).use_current_thread().build_global();
    pool.map_err(|error| match wanted {
        Some(threads) => Failure::Unusable(format!("--threads {threads}: {error}")),
        None => Failure::Unusable(format!("no threads can be started: {error}; --threads 1 needs none")),
    })
}

/// Adds the lights that were typed to the scene and chooses: the named ones, else all. Some light there must be.
pub(crate) fn choose_lights(loaded: &mut LoadedScene, args: &LightArgs, file: &Path) -> Result<Vec<usize>, Failure> {
    for &[azimuth, elevation] in &args.sun {
        let source = LightSource::sun(loaded.sun_from_angles(azimuth, elevation));
        let typed = || format!("--sun {azimuth},{elevation}");
        add_light(&mut loaded.scene, "sun", source, typed)?;
    }
    for &[x, y, z] in &args.point {
        add_light(&mut loaded.scene, "point", LightSource::point([x, y, z]), || format!("--point {x},{y},{z}"))?;
    }
    let lights = &loaded.scene.lights;
    if lights.is_empty() {
        return Err(Failure::Refused(format!(
            "{}: the scene has no light; give one with --sun AZIMUTH,ELEVATION (degrees) or --point X,Y,Z (metres)",
            file.display()
        )));
    }
    if args.light.is_empty() {
        return Ok((0..lights.len()).collect());
    }
    let mut chosen = args.light.iter().map(|name| find_light(lights, name)).collect::<Result<Vec<usize>, _>>()?;
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

fn add_light(
    scene: &mut Scene,
    name: &str,
    source: Result<LightSource, LightDefect>,
    typed: impl Fn() -> String,
) -> Result<(), Failure> {
    let source = source.map_err(|defect| Failure::Unusable(format!("{}: {defect}", typed())))?;
    let taken = |name: &str| scene.lights.iter().any(|light| light.name == name);
    let mut unique = name.to_owned();
    for number in 2.. {
        if !taken(&unique) {
            break;
        }
        unique = format!("{name}_{number}");
    }
    scene.lights.push(Light::new(unique, source));
    Ok(())
}

fn find_light(lights: &[Light], name: &str) -> Result<usize, Failure> {
    lights.iter().position(|light| light.name == name).ok_or_else(|| {
        let names: Vec<&str> = lights.iter().map(|light| light.name.as_str()).collect();
        Failure::Unusable(format!("--light {name}: there is no such light; there is {}", names.join(", ")))
    })
}

/// The objects whose names match one of the patterns; all without patterns. A pattern without a match is a mistake.
pub(crate) fn choose_receivers(scene: &Scene, patterns: &[String]) -> Result<Vec<usize>, Failure> {
    if patterns.is_empty() {
        return Ok((0..scene.objects.len()).collect());
    }
    let mut is_used = vec![false; patterns.len()];
    let prepared: Vec<Pattern> = patterns.iter().map(|pattern| Pattern::new(pattern)).collect();
    let mut is_chosen = |name: &str| {
        // All are asked, to know which patterns match nothing.
        let matching = prepared.iter().zip(&mut is_used).filter(|(pattern, _)| pattern.matches(name));
        matching.map(|(_, is_used)| *is_used = true).count() > 0
    };
    let chosen = (0..scene.objects.len()).filter(|&object| is_chosen(&scene.objects[object].name)).collect();
    match patterns.iter().zip(is_used).find(|(_, is_used)| !is_used) {
        None => Ok(chosen),
        Some((pattern, _)) => {
            let text = format!("--receiver {pattern}: no object has such a name; `umbriel info` lists the names");
            Err(Failure::Unusable(text))
        }
    }
}

/// Notes that lights with an extent take holes as opaque.
pub(crate) fn add_masks_as_opaque(scene: &mut Scene) {
    let masks = scene.objects.iter().filter_map(|object| {
        let Shape::Mesh(mesh) = &object.shape else { return None };
        let has_hole = |&triangle: &usize| mesh.opacity(triangle) != Opacity::Opaque;
        let count = (0..mesh.triangles().len()).filter(has_hole).count();
        let subject = object.name.clone();
        (count > 0).then_some(Finding { kind: FindingKind::MaskAsOpaque, subject, count, places: Vec::new() })
    });
    let masks: Vec<Finding> = masks.collect();
    scene.findings.extend(masks);
}

/// As many samples as are computed: their answers take a bit each, so a gibibyte.
const MOST_SAMPLES: f64 = 8_589_934_592.0;

/// Refuses a spacing at which the answers would not fit into memory.
pub(crate) fn check_samples(scene: &Scene, request: &Request) -> Result<(), Failure> {
    let most = most_samples(scene, request);
    if most <= MOST_SAMPLES {
        return Ok(());
    }
    Err(Failure::Unusable(format!(
        "up to {most:.0} samples are too many, {MOST_SAMPLES:.0} are possible; take fewer, or a wider spacing"
    )))
}

/// Tells what was taken otherwise than the file says.
pub(crate) fn tell_findings(scene: &Scene, quiet: bool) {
    tell(&scene.findings, quiet);
}

fn tell(found: &[Finding], quiet: bool) {
    if !quiet {
        findings::lines(found).iter().for_each(|line| output::tell(&format!("note: {line}")));
    }
}

/// Whether somebody looks at the single cells, or only at sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CellUse {
    Sums,
    Cells,
}

/// The samples that are asked for, and the detail: cells beside samples only if somebody typed how fine, or looks at them.
pub(crate) fn choose_samples_and_detail(
    args: &BakeArgs,
    file: &LoadedScene,
    cells: CellUse,
) -> Result<(Option<Sampling>, Detail), Failure> {
    let sampling = args.samples.map(Sampling::Count).or(args.spacing.map(Sampling::Spacing));
    let is_typed = args.detail.pixel.is_some() || typed(&args.detail).is_some();
    let are_alone = sampling.is_some() && !is_typed && cells == CellUse::Sums;
    Ok((sampling, if are_alone { Detail::Faces } else { choose_detail(&args.detail, file, cells)? }))
}

/// The detail: as typed, else as the scene file says, else the source's typical depths.
pub(crate) fn choose_detail(args: &DetailArgs, file: &LoadedScene, cells: CellUse) -> Result<Detail, Failure> {
    if let Some(eye) = args.pixel {
        return Ok(Detail::of_pixel(&reach::camera(&file.scene, eye, "--pixel")?, args.pixel_rows));
    }
    let Detail::Depth { boundary: typical, .. } = Detail::default() else { return Ok(Detail::default()) };
    let typical = DetailSetting::Depth { interior: None, boundary: typical };
    match typed(args).or(file.detail).unwrap_or(typical) {
        DetailSetting::Pixel { rows } => {
            Ok(Detail::of_pixel(&reach::camera(&file.scene, VisibleFrom::Scene, "pixel_rows")?, rows))
        }
        setting => detail_of(setting, cells),
    }
}

/// What a bake may take for each of so many lights: where neither somebody typed how fine nor the file says so, the typical effort.
pub(crate) fn effort(args: &DetailArgs, file: &LoadedScene, lights: usize) -> Option<u64> {
    let is_in_file = file.detail.is_some() || !file.own.objects.is_empty() || !file.own.lights.is_empty();
    let is_asked = args.pixel.is_some() || typed(args).is_some() || is_in_file;
    (!is_asked).then(|| typical_effort(&file.scene, lights))
}

/// What is found of a bake itself, told unless `quiet`.
pub(crate) fn tell_work(work: &Work, quiet: bool) -> Vec<Finding> {
    let counts = [(FindingKind::CutShort, work.lights_cut_short), (FindingKind::Crowded, work.objects_crowded)];
    let found = counts.into_iter().filter(|&(_, count)| count > 0);
    let found =
        found.map(|(kind, count)| Finding { kind, subject: String::new(), count: count as usize, places: Vec::new() });
    let found: Vec<Finding> = found.collect();
    tell(&found, quiet);
    found
}

/// What objects and lights have of their own by the scene file; a typed depth, cell or pixel is for all alike.
pub(crate) fn own_details(args: &DetailArgs, file: &LoadedScene, cells: CellUse) -> Result<OwnDetails, Failure> {
    let is_for_all = args.pixel.is_some() || args.boundary_depth.is_some() || args.cell.is_some();
    if is_for_all {
        return Ok(OwnDetails::default());
    }
    let all = |settings: &BTreeMap<usize, DetailSetting>| -> Result<BTreeMap<usize, Detail>, Failure> {
        settings.iter().map(|(&number, &setting)| Ok((number, detail_of(setting, cells)?))).collect()
    };
    Ok(OwnDetails { objects: all(&file.own.objects)?, lights: all(&file.own.lights)? })
}

/// The detail that was typed, but for a pixel.
fn typed(args: &DetailArgs) -> Option<DetailSetting> {
    let &DetailArgs { boundary_depth, interior_depth: interior, cell, max_undecided, time, memory, .. } = args;
    let all = [
        boundary_depth.map(|boundary| DetailSetting::Depth { interior, boundary }),
        cell.map(|edge| DetailSetting::Cell { edge }),
        max_undecided.map(|share| DetailSetting::MaxUndecided { share }),
        time.map(|limit| DetailSetting::Time { limit }),
        memory.map(|bytes| DetailSetting::Memory { bytes }),
    ];
    all.into_iter().flatten().next()
}

/// A setting that needs no camera. Where single cells are looked at, decided ones are stored down to the boundary depth unless somebody said otherwise.
fn detail_of(setting: DetailSetting, cells: CellUse) -> Result<Detail, Failure> {
    match setting {
        DetailSetting::Cell { edge } => Ok(Detail::Cell { edge }),
        DetailSetting::MaxUndecided { share } => Ok(Detail::MaxUndecided { share }),
        DetailSetting::Time { limit } => Ok(Detail::Time { limit }),
        DetailSetting::Memory { bytes } => Ok(Detail::Memory { bytes }),
        DetailSetting::Depth { interior: Some(interior), boundary } if interior > boundary => Err(Failure::Unusable(
            format!("the interior depth {interior} is above the boundary depth {boundary}; lower it or leave it out"),
        )),
        DetailSetting::Depth { interior, boundary } => {
            let coarse = if cells == CellUse::Cells { boundary } else { INTERIOR_DEPTH.min(boundary) };
            Ok(Detail::Depth { interior: interior.unwrap_or(coarse), boundary })
        }
        _ => Ok(Detail::default()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typed(boundary: Option<u8>, interior: Option<u8>) -> DetailArgs {
        DetailArgs { boundary_depth: boundary, interior_depth: interior, ..DetailArgs::default() }
    }

    #[test]
    fn what_is_typed_wins_over_the_file() {
        let file = Some(DetailSetting::Cell { edge: 0.5 });
        let detail = |args: &DetailArgs, detail: Option<DetailSetting>, cells| {
            choose_detail(args, &with_detail(detail), cells).expect("a detail")
        };
        assert_eq!(detail(&typed(None, None), None, CellUse::Sums), Detail::Depth { interior: 4, boundary: 8 });
        assert_eq!(detail(&typed(None, None), None, CellUse::Cells), Detail::Depth { interior: 8, boundary: 8 });
        assert_eq!(detail(&typed(None, None), file, CellUse::Sums), Detail::Cell { edge: 0.5 });
        assert_eq!(detail(&typed(Some(3), None), file, CellUse::Sums), Detail::Depth { interior: 3, boundary: 3 });
        assert_eq!(detail(&typed(Some(9), Some(5)), None, CellUse::Cells), Detail::Depth { interior: 5, boundary: 9 });
        assert!(choose_detail(&typed(Some(3), Some(4)), &with_detail(None), CellUse::Sums).is_err());
        let pixel = DetailArgs { pixel: Some(VisibleFrom::Scene), pixel_rows: 100, ..DetailArgs::default() };
        assert!(choose_detail(&pixel, &with_detail(None), CellUse::Sums).is_err(), "the scene has no camera");
        let eye = crate::cli::render_args::camera("0,1,2,0,0,0,90").expect("a camera");
        let seen = DetailArgs { pixel: Some(VisibleFrom::Typed(eye)), ..pixel };
        let Detail::Pixel { width, .. } = detail(&seen, None, CellUse::Sums) else { panic!("no pixel") };
        assert!((width - 0.02).abs() < 1e-9, "{width}");
    }

    #[test]
    fn own_details_stand_until_a_depth_is_typed() {
        let mut file = with_detail(None);
        file.own.objects.insert(3, DetailSetting::Depth { interior: None, boundary: 11 });
        let own = |args: &DetailArgs| own_details(args, &file, CellUse::Sums).expect("details");
        assert_eq!(own(&typed(None, None)).objects[&3], Detail::Depth { interior: 4, boundary: 11 });
        assert!(own(&typed(Some(5), None)).objects.is_empty());
        let timed = DetailArgs { time: Some(std::time::Duration::from_secs(1)), ..DetailArgs::default() };
        assert_eq!(own(&timed).objects.len(), 1, "a limit divides as far as these let it");
    }

    fn with_detail(detail: Option<DetailSetting>) -> LoadedScene {
        LoadedScene {
            scene: Scene::default(),
            detail,
            own: umbriel_io::OwnSettings::default(),
            north_degrees: 0.0,
            up: UpAxis::Y,
            lightmaps: Vec::new(),
            files: Vec::new(),
        }
    }

    #[test]
    fn added_lights_get_names_of_their_own() {
        let mut scene = Scene::default();
        for _ in 0..3 {
            add_light(&mut scene, "sun", LightSource::sun([0.0, -1.0, 0.0]), String::new).expect("a light");
        }
        let names: Vec<&str> = scene.lights.iter().map(|light| light.name.as_str()).collect();
        assert_eq!(names, ["sun", "sun_2", "sun_3"]);
        assert!(find_light(&scene.lights, "moon").expect_err("no moon").message().is_some_and(|m| m.contains("sun_2")));
    }
}
