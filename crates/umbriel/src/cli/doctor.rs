//! `umbriel doctor`: what about a scene limits the answers, and how much surface it concerns.

use std::{io::Write, path::Path};

use umbriel_io::write::Staged;
use umbriel_shadow::doctor::examine;

use crate::{
    cli::{
        Failure,
        args::{DoctorArgs, LightArgs},
        plan::{self, CellUse, Loaded},
    },
    output::{
        self, Format, Target,
        doctor::{Document, text},
    },
    progress::{Bar, Interrupt},
};

pub(crate) fn run(args: &DoctorArgs) -> Result<(), Failure> {
    let json_file = args.json.as_deref().filter(|path| *path != Path::new("-"));
    if let Some(path) = json_file {
        output::check_file(path, &[&args.scene.scene])?;
    }
    let mut loaded = plan::load(&args.scene)?;
    if let Some(path) = json_file {
        output::check_unread(&[Target { path: path.to_owned(), format: Format::Json }], &loaded.file.files)?;
    }
    let interrupt = &Interrupt::install();
    let lights = lights(&mut loaded, &args.lights, &args.scene.scene)?;
    let detail = plan::choose_detail(&args.detail, &loaded.file, CellUse::Sums)?;
    let scene = &loaded.file.scene;
    let diagnosis = examine(scene, &lights, detail, &Bar::new(interrupt, args.scene.quiet))?;
    let json = || Document::new(scene, &diagnosis).to_text();
    if let Some(path) = json_file {
        let staged = Staged::new(path, |out| out.write_all(json().as_bytes()))?;
        interrupt.check()?;
        output::commit_all(vec![staged])?;
    }
    let to_stdout = args.json.is_some() && json_file.is_none();
    output::print(&if to_stdout { json() } else { text(scene, &diagnosis) })
}

/// The chosen lights; a scene without any can be examined all the same.
fn lights(loaded: &mut Loaded, args: &LightArgs, file: &Path) -> Result<Vec<usize>, Failure> {
    let is_dark = loaded.file.scene.lights.is_empty();
    if is_dark && args.sun.is_empty() && args.point.is_empty() && args.light.is_empty() {
        return Ok(Vec::new());
    }
    plan::choose_lights(&mut loaded.file, args, file)
}
