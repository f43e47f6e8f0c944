//! `umbriel soft`: what area lights light, in cells with bounds; and under the first of them the ways of pictures to shade soft shadows, side by
//! side, with their times and errors against the truth.

use std::{
    io::Write,
    path::{Path, PathBuf},
    time::Instant,
};

use umbriel_io::write::{Staged, write_png};
use umbriel_scene::{Extent, FindingKind, Scene};
use umbriel_shadow::{SoftRequest, soft_bake};

use super::soft_pictures::{self, Compared, Plan};
use crate::{
    cli::{
        Failure,
        args::SoftArgs,
        plan::{self, CellUse},
    },
    output::{
        self, Format, Target,
        soft::{Areas, Document, Seen},
    },
    progress::{Bar, Interrupt},
};

pub(crate) fn run(args: &SoftArgs) -> Result<(), Failure> {
    let files = output::targets(&args.output, &[Format::Png], &[&args.scene.scene])?;
    let json_file = args.json.clone().filter(|path| path != Path::new("-"));
    if let Some(path) = &json_file {
        output::check_file(path, &[&args.scene.scene])?;
    }
    let mut loaded = plan::load(&args.scene)?;
    let mut written = files.clone();
    written.extend(json_file.iter().map(|path| Target { path: path.clone(), format: Format::Json }));
    output::check_unread(&written, &loaded.file.files)?;
    let lights = plan::choose_lights(&mut loaded.file, &args.lights, &args.scene.scene)?;
    let receivers = plan::choose_receivers(&loaded.file.scene, &args.receiver)?;
    let detail = plan::choose_detail(&args.detail, &loaded.file, CellUse::Sums)?;
    loaded.file.scene.findings.retain(|finding| finding.kind != FindingKind::AreaLightAsPoint);
    plan::add_masks_as_opaque(&mut loaded.file.scene);
    let scene = &loaded.file.scene;
    plan::tell_findings(scene, args.scene.quiet);
    let lights = area_lights(scene, &lights, &args.scene.scene)?;
    let interrupt = &Interrupt::install();
    let bar = Bar::new(interrupt, args.scene.quiet);
    let begun = Instant::now();
    let request = SoftRequest { lights: lights.clone(), receivers, ..SoftRequest::everything(scene, detail) };
    let report = soft_bake(scene, &request, &bar)?;
    let areas = Areas::new(scene, detail, &report, begun.elapsed().as_secs_f64());
    let plan = Plan { args, detail, bar: &bar, needs_all: !files.is_empty() && args.method.len() != 1 };
    let compared = soft_pictures::compare(scene, lights[0], &plan)?;
    drop(bar);
    let document = Document::new(&areas, &compared.comparison);
    let json = document.to_json();
    write(&compared, &files, json_file, &json, interrupt)?;
    let to_stdout = args.json.as_deref() == Some(Path::new("-"));
    output::print(&if to_stdout { json } else { document.to_text() })
}

/// The chosen lights that have an extent.
fn area_lights(scene: &Scene, lights: &[usize], file: &Path) -> Result<Vec<usize>, Failure> {
    let wide: Vec<usize> =
        lights.iter().copied().filter(|&light| scene.lights[light].extent != Extent::Point).collect();
    if wide.is_empty() {
        let text = "no chosen light has an extent (a radius, an angular_diameter, a rectangle)";
        return Err(Failure::Refused(format!("{}: {text}", file.display())));
    }
    Ok(wide)
}

/// Writes all files or none.
fn write(
    Compared { comparison, truth, shades, is_surface }: &Compared,
    files: &[Target],
    json_file: Option<PathBuf>,
    json: &str,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let mut staged = Vec::new();
    if !files.is_empty() {
        let picture = comparison.picture(&Seen { truth, shades, is_surface });
        for file in files {
            staged.push(Staged::new(&file.path, |out| write_png(&picture, out))?);
        }
    }
    if let Some(path) = json_file {
        staged.push(Staged::new(&path, |out| out.write_all(json.as_bytes()))?);
    }
    interrupt.check()?;
    output::commit_all(staged)
}
