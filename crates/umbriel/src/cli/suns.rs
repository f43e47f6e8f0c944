//! Tables of suns, and `umbriel bake --suns`: for how long every object is in the sun, with bounds.

use std::{fs, io, path::Path, time::Instant};

use umbriel_geometry::LightSource;
use umbriel_io::{
    LoadedScene, SunPlace, SunRow, SunsError, read_suns,
    write::{Staged, WriteError, write_glb, write_vtu},
};
use umbriel_scene::{Finding, FindingKind};
use umbriel_shadow::{CellMethod, HoursError, OwnDetails, Request, TimedLight, bake_hours};

use crate::{
    cli::{
        Failure,
        args::{BakeArgs, SunsArgs},
        bake::Outputs,
        plan::{self, CellUse},
    },
    output::{
        self, Format, csv, glb,
        hours::{Day, Row},
        json::{Clock, Document},
        table, vtu,
    },
    progress::{Bar, Interrupt},
};

/// Bakes all suns of a table.
pub(super) fn run(args: &BakeArgs, path: &Path) -> Result<(), Failure> {
    let begun = Instant::now();
    let outputs = Outputs::new(args, &[&args.scene.scene, path])?;
    if outputs.has(Format::Png) {
        let text = "a .png holds light maps of single lights; with --suns write a .glb, .vtu or .csv";
        return Err(Failure::Unusable(text.to_owned()));
    }
    let rows = read(path, &args.suns)?;
    let mut loaded = plan::load(&args.scene)?;
    let on_surfaces = if outputs.has(Format::Json) { loaded.find_on_surfaces() } else { Vec::new() };
    outputs.check_unread(&loaded.file)?;
    let lights = place(&rows, &mut loaded.file, path)?;
    let cells = outputs.cell_use();
    let scene = &loaded.file.scene;
    let (sampling, detail) = plan::choose_samples_and_detail(args, &loaded.file, cells)?;
    let request = Request {
        detail,
        own: OwnDetails::default(),
        sampling,
        lights: Vec::new(),
        receivers: plan::choose_receivers(scene, &args.receiver)?,
        keep_cells: cells == CellUse::Cells,
        method: CellMethod::Auto,
        effort: None,
    };
    let interrupt = &Interrupt::install();
    plan::check_samples(scene, &request)?;
    plan::tell_findings(scene, args.scene.quiet);
    let bar = Bar::new(interrupt, args.scene.quiet);
    let shining: Vec<TimedLight> = lights.iter().flatten().copied().collect();
    let report = bake_hours(scene, &request, &shining, &bar).map_err(|error| failure(error, path))?;
    drop(bar);
    let day = Day { scene, report: &report, rows: days_rows(&rows, &lights) };
    let clock = Clock { begun, load: loaded.seconds };
    let findings = plan::all_findings(scene, on_surfaces);
    let json = Document::of_day(&day, request.detail, &findings, clock).to_text();
    let stage = |file: &output::Target| -> Result<Staged, WriteError> {
        Staged::new(&file.path, |out| match file.format {
            Format::Csv => csv::write_hours(&day, args.forms.csv, out),
            Format::Vtu => write_vtu(&vtu::hours_grid(&day), out),
            Format::Glb => write_glb(&glb::hours_meshes(&day, args.forms.color), out),
            Format::Json | Format::Png | Format::Npy | Format::Svg => io::Write::write_all(out, json.as_bytes()),
        })
    };
    let staged = outputs.files.iter().map(stage).collect::<Result<Vec<_>, _>>()?;
    interrupt.check()?;
    output::commit_all(staged)?;
    if outputs.json_to_stdout { output::print(&json) } else { output::print(&table::day_text(&day)) }
}

/// Reads a table.
pub(super) fn read(path: &Path, args: &SunsArgs) -> Result<Vec<SunRow>, Failure> {
    let unreadable = |error| Failure::Unusable(format!("{} cannot be read: {error}", path.display()));
    // A pipe or a device may never end.
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(unreadable(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file")));
    }
    let file = fs::File::open(path).map_err(unreadable)?;
    read_suns(file, args.hours_each).map_err(|error| match error {
        SunsError::Unreadable(error) => unreadable(error),
        defect => Failure::Refused(format!("{}: {defect}", path.display())),
    })
}

/// The light of every row; `None` where its angles say that it is night. What a user should know of that joins the findings.
pub(super) fn place(rows: &[SunRow], file: &mut LoadedScene, path: &Path) -> Result<Vec<Option<TimedLight>>, Failure> {
    let light = |row: &SunRow| {
        let direction = match row.place {
            SunPlace::Angles { elevation, .. } if elevation <= 0.0 => return Ok(None),
            SunPlace::Angles { azimuth, elevation } => file.sun_from_angles(azimuth, elevation),
            SunPlace::Direction(direction) => file.direction(direction),
        };
        let source = LightSource::sun(direction)
            .map_err(|defect| Failure::Refused(format!("{}: line {}: {defect}", path.display(), row.line)))?;
        Ok(Some(TimedLight { source, duration: row.duration }))
    };
    let lights = rows.iter().map(light).collect::<Result<Vec<_>, Failure>>()?;
    file.scene.findings.extend(findings(rows, &lights));
    Ok(lights)
}

/// Why there are no hours.
pub(super) fn failure(error: HoursError, path: &Path) -> Failure {
    match error {
        HoursError::Cancelled(cancelled) => cancelled.into(),
        error => Failure::Refused(format!("{}: {error}", path.display())),
    }
}

/// What a user should know of the table.
fn findings(rows: &[SunRow], lights: &[Option<TimedLight>]) -> Vec<Finding> {
    let night = lights.iter().filter(|light| light.is_none()).count();
    let is_upward = |(row, light): &(&SunRow, &Option<TimedLight>)| {
        matches!(row.place, SunPlace::Direction(_)) && light.is_some_and(|light| light.source.xyz().y <= 0.0)
    };
    let upward = rows.iter().zip(lights).filter(is_upward).count();
    let counts = [(FindingKind::SunsBelowHorizon, night), (FindingKind::SunsFromBelow, upward)];
    let found = counts.into_iter().filter(|(_, count)| *count > 0);
    found.map(|(kind, count)| Finding { kind, subject: String::new(), count, places: Vec::new() }).collect()
}

/// The rows for results; each that shines has its place in the list of lights.
fn days_rows<'a>(rows: &'a [SunRow], lights: &[Option<TimedLight>]) -> Vec<Row<'a>> {
    let mut next = 0;
    let mut number = |light: &Option<TimedLight>| {
        let number = light.map(|_| next);
        next += usize::from(light.is_some());
        number
    };
    rows.iter().zip(lights).map(|(row, light)| Row { row, light: number(light) }).collect()
}
