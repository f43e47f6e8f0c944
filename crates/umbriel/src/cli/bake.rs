//! `umbriel bake`: lit area of every object under every light, with bounds.

use std::{io::Write, path::Path, time::Instant};

use umbriel_geometry::decisions::Decisions;
use umbriel_io::{
    LoadedScene,
    write::{Staged, WriteError, write_glb, write_gray_png, write_vtu},
};
use umbriel_scene::Scene;
use umbriel_shadow::{CellMethod, Report, Request};

use crate::{
    cli::{
        Failure, acceleration,
        args::{BakeArgs, FormArgs},
        plan::{self, CellUse},
        reach, suns,
    },
    output::{
        self, Format, Target,
        csv::{self, Rows},
        glb,
        json::{Clock, Document},
        lightmap::{Lightmap, Lightmaps},
        table, vtu,
    },
    progress::{Bar, Interrupt},
};

pub(crate) fn run(args: &BakeArgs) -> Result<(), Failure> {
    if let Some(table) = &args.suns.suns {
        return suns::run(args, table);
    }
    let begun = Instant::now();
    let mut outputs = Outputs::new(args, &[&args.scene.scene])?;
    let layouts = outputs.has(Format::Png).then_some(args.forms.lightmap_texcoord);
    let mut loaded = plan::load_with_layouts(&args.scene, layouts)?;
    let on_surfaces = if outputs.has(Format::Json) { loaded.find_on_surfaces() } else { Vec::new() };
    let lights = plan::choose_lights(&mut loaded.file, &args.lights, &args.scene.scene)?;
    outputs.check_lights(lights.len())?;
    let scene = &loaded.file.scene;
    let receivers = reach::choose_receivers(scene, &args.receiver, &lights, args.visible_from, args.scene.quiet)?;
    outputs.name_lightmaps(&loaded.file, &receivers, &args.scene.scene)?;
    outputs.check_unread(&loaded.file)?;
    let interrupt = &Interrupt::install();
    let scene = &loaded.file.scene;
    let cells = outputs.cell_use();
    let (sampling, detail) = plan::choose_samples_and_detail(args, &loaded.file, cells)?;
    let request = Request {
        detail,
        own: plan::own_details(&args.detail, &loaded.file, cells)?,
        sampling,
        effort: plan::effort(&args.detail, &loaded.file, lights.len()),
        lights,
        receivers,
        keep_cells: cells == CellUse::Cells,
        method: CellMethod::Auto,
    };
    plan::check_samples(scene, &request)?;
    plan::tell_findings(scene, args.scene.quiet);
    let bar = Bar::new(interrupt, args.scene.quiet);
    let report = umbriel_shadow::bake(scene, &request, &bar)?;
    let maps = outputs.make_lightmaps(&loaded.file, &report, &bar, args.scene.quiet)?;
    drop(bar);
    outputs.tell_misfits(scene, &report, &maps, args.scene.quiet);
    let clock = Clock { begun, load: loaded.seconds };
    let mut findings = plan::all_findings(scene, on_surfaces);
    findings.extend(plan::tell_work(&report.work, args.scene.quiet));
    let json = Document::new(scene, &request, &report, &findings, clock).to_text();
    outputs.write(&Results { scene, report: &report, json: &json, maps: &maps }, interrupt)?;
    let table = || table::text(scene, &report) + &table::decisions_text(Decisions::of_process());
    output::print(&if outputs.json_to_stdout { json } else { table() })
}

/// All that files are made from.
struct Results<'a> {
    scene: &'a Scene,
    report: &'a Report,
    json: &'a str,
    maps: &'a [Lightmap],
}

/// Where the results go.
pub(super) struct Outputs<'a> {
    /// All files but light maps.
    pub(super) files: Vec<Target>,
    pub(super) json_to_stdout: bool,
    forms: &'a FormArgs,
    /// The light maps as typed.
    lightmaps: Vec<Target>,
    /// The receivers that have layouts, by their places in the list of receivers, ascending.
    mapped: Vec<usize>,
    /// The files of the light maps, those of one receiver after those of another.
    map_files: Vec<Target>,
}

impl<'a> Outputs<'a> {
    /// Checks the files that were typed; `inputs` are read.
    pub(super) fn new(args: &'a BakeArgs, inputs: &[&Path]) -> Result<Self, Failure> {
        let json_to_stdout = args.json.as_deref() == Some(Path::new("-"));
        let known = [Format::Json, Format::Csv, Format::Vtu, Format::Glb, Format::Png];
        let files = output::targets_and_json(&args.output, args.json.as_deref(), &known, inputs)?;
        let (lightmaps, files) = files.into_iter().partition(|file| file.format == Format::Png);
        let (mapped, map_files) = (Vec::new(), Vec::new());
        Ok(Self { files, json_to_stdout, forms: &args.forms, lightmaps, mapped, map_files })
    }

    pub(super) fn has(&self, format: Format) -> bool {
        (self.json_to_stdout && format == Format::Json)
            || self.files.iter().chain(&self.lightmaps).any(|file| file.format == format)
    }

    /// Whether some file shows single cells, or speeds up with them.
    pub(super) fn cell_use(&self) -> CellUse {
        let in_csv = self.has(Format::Csv) && self.forms.csv == Rows::Cells;
        let shown = [Format::Glb, Format::Vtu, Format::Png].into_iter().any(|format| self.has(format));
        if in_csv || shown { CellUse::Cells } else { CellUse::Sums }
    }

    /// A coloured model shows one light; two would lie on top of each other.
    fn check_lights(&self, lights: usize) -> Result<(), Failure> {
        if lights > 1 && self.has(Format::Glb) {
            let text = format!("a .glb shows one light and there are {lights}; choose one with --light NAME");
            return Err(Failure::Unusable(text));
        }
        Ok(())
    }

    /// Each receiver with a layout has a picture: the file that was typed if there is one such receiver, else files
    /// named after it and them.
    fn name_lightmaps(&mut self, file: &LoadedScene, receivers: &[usize], scene: &Path) -> Result<(), Failure> {
        if self.lightmaps.is_empty() {
            return Ok(());
        }
        self.mapped = (0..receivers.len()).filter(|&place| file.lightmaps[receivers[place]].is_some()).collect();
        if self.mapped.is_empty() {
            return Err(Failure::Refused(format!(
                "{}: a .png holds a light map, and no receiver has texture coordinates for one (in glTF TEXCOORD_{}, \
                 see --lightmap-texcoord; in OBJ vt); for a picture use `umbriel render`",
                scene.display(),
                self.forms.lightmap_texcoord
            )));
        }
        let mut known = self.files.clone();
        for place in &self.mapped {
            for typed in &self.lightmaps {
                let name = &file.scene.objects[receivers[*place]].name;
                let path =
                    if self.mapped.len() == 1 { typed.path.clone() } else { output::file_of_object(&typed.path, name) };
                output::check_file(&path, &[scene])?;
                output::add_target(&mut known, Target { path, format: Format::Png })?;
            }
        }
        self.map_files = known.split_off(self.files.len());
        Ok(())
    }

    pub(super) fn check_unread(&self, loaded: &LoadedScene) -> Result<(), Failure> {
        output::check_unread(&self.files, &loaded.files)?;
        output::check_unread(&self.map_files, &loaded.files)
    }

    /// One picture a receiver with a layout.
    fn make_lightmaps(
        &self,
        file: &LoadedScene,
        report: &Report,
        bar: &Bar,
        quiet: bool,
    ) -> Result<Vec<Lightmap>, Failure> {
        if self.mapped.is_empty() {
            return Ok(Vec::new());
        }
        let mut maps = Lightmaps::new(&file.scene, report, self.forms.lightmap_size);
        let objects: Vec<usize> = self.mapped.iter().map(|&place| report.lights[0].objects[place].object).collect();
        let choices = maps.prepare(&objects, self.forms.acceleration.of_rays());
        if !quiet {
            let names = report.lights.iter().map(|light| file.scene.lights[light.light].name.as_str());
            acceleration::tell_lights(names.zip(&choices));
        }
        let make = |&place: &usize| {
            let layout = file.lightmaps[report.lights[0].objects[place].object].as_deref();
            maps.make(place, layout.unwrap_or(&Default::default()), bar).map_err(Failure::from)
        };
        self.mapped.iter().map(make).collect()
    }

    /// What of the layouts does not fit a light map.
    fn tell_misfits(&self, scene: &Scene, report: &Report, maps: &[Lightmap], quiet: bool) {
        for (map, &place) in maps.iter().zip(&self.mapped).filter(|_| !quiet) {
            let name = &scene.objects[report.lights[0].objects[place].object].name;
            if map.outside > 0 {
                output::tell(&format!("note: {name}: {} triangles reach beyond its light map", map.outside));
            }
            if map.overlaps > 0 {
                let text = "points of its light map lie inside two triangles; the first one has them";
                output::tell(&format!("note: {name}: {} {text}", map.overlaps));
            }
        }
    }

    /// Writes all files or none.
    fn write(&self, results: &Results, interrupt: &Interrupt) -> Result<(), Failure> {
        let Results { scene, report, json, maps } = results;
        let stage = |file: &Target| -> Result<Staged, WriteError> {
            Staged::new(&file.path, |out| match file.format {
                Format::Csv => csv::write(scene, report, self.forms.csv, out),
                Format::Vtu => write_vtu(&vtu::grid(scene, report), out),
                Format::Glb => {
                    let meshes = report.lights.iter().flat_map(|light| glb::meshes(scene, light, self.forms.color));
                    write_glb(&meshes.collect::<Vec<_>>(), out)
                }
                Format::Json | Format::Png | Format::Npy | Format::Svg => out.write_all(json.as_bytes()),
            })
        };
        let mut staged = self.files.iter().map(stage).collect::<Result<Vec<_>, _>>()?;
        for (map, files) in maps.iter().zip(self.map_files.chunks(self.lightmaps.len().max(1))) {
            for file in files {
                staged.push(Staged::new(&file.path, |out| write_gray_png(&map.picture, out))?);
            }
        }
        interrupt.check()?;
        output::commit_all(staged)
    }
}
