//! `umbriel bake`: lit area of every object under every light, with bounds.

use std::{io::Write, path::Path, time::Instant};

use umbriel_io::{
    surface_findings,
    write::{ColoredMesh, Staged, WriteError, write_glb},
};
use umbriel_scene::{Finding, Scene};
use umbriel_shadow::{Report, Request, Sampling};

use crate::{
    cli::{
        Failure,
        args::BakeArgs,
        plan::{self, CellUse},
    },
    output::{
        self, Format, Target, csv, glb,
        json::{Clock, Document},
        table,
    },
    progress::{Bar, Interrupt},
};

pub(crate) fn run(args: &BakeArgs) -> Result<(), Failure> {
    let begun = Instant::now();
    let outputs = Outputs::new(args)?;
    let mut loaded = plan::load(&args.scene)?;
    output::check_unread(&outputs.files, &loaded.file.files)?;
    let interrupt = &Interrupt::install();
    let lights = plan::choose_lights(&mut loaded.file, &args.lights, &args.scene.scene)?;
    outputs.check_lights(lights.len())?;
    let scene = &loaded.file.scene;
    let cells = if outputs.has(Format::Glb) { CellUse::Cells } else { CellUse::Sums };
    let request = Request {
        detail: plan::choose_detail(&args.detail, loaded.file.detail, cells)?,
        sampling: args.samples.map(Sampling::Count).or(args.spacing.map(Sampling::Spacing)),
        lights,
        receivers: plan::choose_receivers(scene, &args.receiver)?,
        keep_cells: cells == CellUse::Cells,
    };
    plan::tell_findings(scene, args.scene.quiet);
    let report = umbriel_shadow::bake(scene, &request, &Bar::new(interrupt, args.scene.quiet))?;
    let findings = if outputs.has(Format::Json) { all_findings(scene) } else { Vec::new() };
    let clock = Clock { begun, load: loaded.seconds };
    let json = Document::new(scene, request.detail, &report, &findings, clock).to_text();
    outputs.write(scene, &report, &json, interrupt)?;
    if outputs.json_to_stdout { output::print(&json) } else { output::print(&table::text(scene, &report)) }
}

/// What was found while reading, and on the surfaces themselves.
fn all_findings(scene: &Scene) -> Vec<Finding> {
    let mut findings = scene.findings.clone();
    findings.extend(surface_findings(scene));
    findings
}

/// Where the results go.
struct Outputs {
    files: Vec<Target>,
    json_to_stdout: bool,
}

impl Outputs {
    fn new(args: &BakeArgs) -> Result<Self, Failure> {
        let json_to_stdout = args.json.as_deref() == Some(Path::new("-"));
        let inputs = [args.scene.scene.as_path()];
        let mut files = output::targets(&args.output, &[Format::Json, Format::Csv, Format::Glb], &inputs)?;
        if let Some(path) = args.json.clone().filter(|_| !json_to_stdout) {
            output::check_file(&path, &inputs)?;
            output::add_target(&mut files, Target { path, format: Format::Json })?;
        }
        Ok(Self { files, json_to_stdout })
    }

    fn has(&self, format: Format) -> bool {
        (self.json_to_stdout && format == Format::Json) || self.files.iter().any(|file| file.format == format)
    }

    /// A coloured model shows one light; two would lie on top of each other.
    fn check_lights(&self, lights: usize) -> Result<(), Failure> {
        if lights > 1 && self.has(Format::Glb) {
            let text = format!("a .glb shows one light and there are {lights}; choose one with --light NAME");
            return Err(Failure::Unusable(text));
        }
        Ok(())
    }

    /// Writes all files or none.
    fn write(&self, scene: &Scene, report: &Report, json: &str, interrupt: &Interrupt) -> Result<(), Failure> {
        let stage = |file: &Target| -> Result<Staged, WriteError> {
            Staged::new(&file.path, |out| match file.format {
                Format::Csv => csv::table(scene, report).write(out),
                Format::Glb => write_glb(&meshes(scene, report), out),
                Format::Json | Format::Png => out.write_all(json.as_bytes()),
            })
        };
        let staged = self.files.iter().map(stage).collect::<Result<Vec<_>, _>>()?;
        interrupt.check()?;
        output::commit_all(staged)
    }
}

fn meshes(scene: &Scene, report: &Report) -> Vec<ColoredMesh> {
    report.lights.iter().flat_map(|light| glb::meshes(scene, light)).collect()
}
