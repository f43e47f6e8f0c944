//! `umbriel tradeoff`: what time and memory buy, with bounds, with samples and with the rivals, judged by exact answers.
//!
//! Memory is that of a process for each setting, this program again: in one process the memory that was freed is used again, so that later settings seem to
//! take none.

use std::{env, io::Write, path::Path, process::Command, time::Duration};

use umbriel_geometry::Aabb;
use umbriel_io::{
    MemoryPeak,
    write::{Staged, WriteError, write_png},
};
use umbriel_scene::Scene;
use umbriel_shadow::{
    Detail, Silent,
    rivals::{Literal, PointRays, Polygons, ShadowMap, ShadowVolume},
    tradeoff::{Course, Judge, MeasureDefect, Measurement, Setting, measure, recommend, run as run_alone},
};

use super::{Failure, args::TradeoffArgs, plan};
use crate::{
    output::{
        self, Format, Target, drawing,
        tradeoff::{Row, Tradeoff},
    },
    progress::Interrupt,
};

/// Samples, each time four times as many.
const SAMPLES: [u64; 6] = [4_096, 16_384, 65_536, 262_144, 1_048_576, 4_194_304];

/// Shares of the surface that may stay undecided, times in milliseconds, and bytes of a light's cells.
const SHARES: [f64; 6] = [0.1, 0.03, 0.01, 0.003, 0.001, 0.0003];
const TIMES: [u64; 6] = [10, 30, 100, 300, 1000, 3000];
const SIZES: [u64; 6] = [100_000, 300_000, 1_000_000, 3_000_000, 10_000_000, 30_000_000];

/// The edge of the smallest cell, as parts of the scene's size.
const CELLS: [f64; 6] = [0.1, 0.03, 0.01, 0.003, 0.001, 0.0003];

/// Edges of shadow maps.
const MAPS: [usize; 6] = [256, 512, 1024, 2048, 4096, 8192];

/// Boundary depths of the method read literally, and the rays that it may cast.
const LITERAL_DEPTHS: std::ops::RangeInclusive<u8> = 4..=8;
const LITERAL_RAYS: u64 = 20_000_000;

pub(crate) fn run(args: &TradeoffArgs) -> Result<(), Failure> {
    let inputs = [args.scene.scene.as_path()];
    let known = [Format::Csv, Format::Json, Format::Svg, Format::Png];
    let files = output::targets_and_json(&args.output, args.json.as_deref(), &known, &inputs)?;
    let mut loaded = plan::load(&args.scene)?;
    output::check_unread(&files, &loaded.file.files)?;
    let interrupt = &Interrupt::install();
    let light = plan::choose_lights(&mut loaded.file, &args.lights, &args.scene.scene)?[0];
    let scene = &loaded.file.scene;
    plan::tell_findings(scene, args.scene.quiet);
    let polygons = Polygons::new(scene, args.divisions);
    if let Some(name) = &args.peak_of {
        let judge = Judge::without_answers(scene, &polygons, args.points);
        return print_peak(&Course { scene, polygons: &polygons, light, judge: &judge }, name, args);
    }
    let judge = Judge::new(scene, &polygons, &scene.lights[light].source, args.points);
    interrupt.check()?;
    let course = Course { scene, polygons: &polygons, light, judge: &judge };
    let name = args.scene.scene.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let mut tradeoff = Tradeoff {
        scene: name,
        light: scene.lights[light].name.clone(),
        triangles: polygons.len(),
        judged: judge.len(),
        threads: rayon::current_num_threads(),
        ..Tradeoff::default()
    };
    for ladder in ladders(args, scene).into_iter().enumerate() {
        climb(&course, ladder, args, &mut tradeoff, interrupt)?;
    }
    write(&tradeoff, &files, interrupt)?;
    let to_stdout = args.json.as_deref() == Some(Path::new("-"));
    output::print(&if to_stdout { tradeoff.to_json() } else { tradeoff.to_text() + &advice(&tradeoff, args.error) })
}

/// All settings, from quick to slow in each family.
fn ladders(args: &TradeoffArgs, scene: &Scene) -> Vec<Vec<Setting>> {
    let depth = |boundary: u8| Setting::Bake(Detail::Depth { interior: boundary, boundary });
    let literal = |boundary: u8| {
        Setting::Rival(Box::new(Literal { interior: boundary.min(4), boundary, most_rays: LITERAL_RAYS }))
    };
    let bounds = scene.objects.iter().fold(Aabb::EMPTY, |all, object| all.union(object.bounds()));
    let size = bounds.size().max_element();
    vec![
        (1..=args.max_depth).map(depth).collect(),
        CELLS.into_iter().map(|part| Setting::Bake(Detail::Cell { edge: two_digits(part * size) })).collect(),
        SHARES.into_iter().map(|share| Setting::Bake(Detail::MaxUndecided { share })).collect(),
        TIMES.into_iter().map(|time| Setting::Bake(Detail::Time { limit: Duration::from_millis(time) })).collect(),
        SIZES.into_iter().map(|bytes| Setting::Bake(Detail::Memory { bytes })).collect(),
        vec![Setting::Points],
        SAMPLES.into_iter().map(Setting::Samples).collect(),
        SAMPLES.into_iter().map(Setting::RaySamples).collect(),
        vec![Setting::Rival(Box::new(PointRays))],
        vec![Setting::Rival(Box::new(ShadowVolume::default()))],
        MAPS.into_iter().map(|size| Setting::Rival(Box::new(ShadowMap::new(size)))).collect(),
        LITERAL_DEPTHS.map(literal).collect(),
    ]
}

/// A positive number with two digits that count: what somebody would type.
fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// Measures the settings of a ladder, the quickest of some runs each, until one takes longer than it may.
fn climb(
    course: &Course,
    (number, ladder): (usize, Vec<Setting>),
    args: &TradeoffArgs,
    tradeoff: &mut Tradeoff,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    for setting in ladder {
        interrupt.check()?;
        match best(course, &setting, number, args.runs) {
            Err(MeasureDefect::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(reason) => {
                tradeoff.refused.push((setting.name(), reason.to_string()));
                return Ok(());
            }
            Ok(row) => {
                let is_long = row.measured.seconds() > args.limit;
                tradeoff.rows.push(row);
                if is_long {
                    return Ok(());
                }
            }
        }
    }
    Ok(())
}

/// The quickest of some runs, and the memory of another.
fn best(course: &Course, setting: &Setting, ladder: usize, runs: u32) -> Result<Row, MeasureDefect> {
    let mut best: Option<Measurement> = None;
    for _ in 0..runs.max(1) {
        let measured = measure(course, setting, &Silent)?;
        if best.as_ref().is_none_or(|best| measured.seconds() < best.seconds()) {
            best = Some(measured);
        }
    }
    let measured = best.ok_or(MeasureDefect::NoAnswers)?;
    Ok(Row { measured, ladder, peak_bytes: peak_of(setting) })
}

/// The most memory that one run of a setting holds beside the scene and the points, bytes: [`print_peak`] in a process of its own.
fn peak_of(setting: &Setting) -> Option<u64> {
    let mut own = Command::new(env::current_exe().ok()?);
    // With glibc: what is freed goes back to the system, so that reading the scene leaves nothing behind.
    own.env("MALLOC_MMAP_THRESHOLD_", "65536").env("MALLOC_TRIM_THRESHOLD_", "65536");
    own.args(env::args_os().skip(1)).arg("--peak-of").arg(setting.name());
    String::from_utf8(own.output().ok()?.stdout).ok()?.trim().parse().ok()
}

/// Runs the setting of this name and prints what memory it took, if that can be told.
fn print_peak(course: &Course, name: &str, args: &TradeoffArgs) -> Result<(), Failure> {
    let Some(setting) = ladders(args, course.scene).into_iter().flatten().find(|setting| setting.name() == name) else {
        return Err(Failure::Unusable(format!("--peak-of: no setting is named {name}")));
    };
    let mut peak = None;
    let run = run_alone(course, &setting, &Silent, &mut || peak = Some(MemoryPeak::start()));
    run.map_err(|defect| Failure::Refused(format!("{name}: {defect}")))?;
    match peak.and_then(|peak| peak.bytes()) {
        Some(bytes) => output::print(&format!("{bytes}\n")),
        None => Ok(()),
    }
}

/// Which setting serves an error.
fn advice(tradeoff: &Tradeoff, error: f64) -> String {
    let measured: Vec<Measurement> = tradeoff.rows.iter().map(|row| row.measured.clone()).collect();
    let name = |with_bounds| {
        recommend(&measured, error, with_bounds).map_or_else(
            || "nothing that was measured".to_owned(),
            |one| format!("{} ({:.1} ms)", one.name, 1e3 * one.seconds()),
        )
    };
    let percent = 100.0 * error;
    format!(
        "\nat most {percent} % wrong or undecided: {}; with bounds that say so themselves: {}\n",
        name(false),
        name(true)
    )
}

fn write(tradeoff: &Tradeoff, files: &[Target], interrupt: &Interrupt) -> Result<(), Failure> {
    let stage = |file: &Target| -> Result<Staged, WriteError> {
        Staged::new(&file.path, |out| match file.format {
            Format::Csv => out.write_all(tradeoff.to_csv().as_bytes()),
            Format::Svg => out.write_all(tradeoff.chart().to_svg().as_bytes()),
            Format::Png => write_png(&drawing::picture(&tradeoff.chart()), out),
            _ => out.write_all(tradeoff.to_json().as_bytes()),
        })
    };
    let staged = files.iter().map(stage).collect::<Result<Vec<_>, _>>()?;
    interrupt.check()?;
    output::commit_all(staged)
}
