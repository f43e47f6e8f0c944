//! The mesh files that a scene file names: each is read once, and what is found in it is told once.

use std::{
    collections::{HashMap, HashSet},
    path::PathBuf,
};

use glam::DAffine3;
use umbriel_scene::{FamilyTree, Member, Shape};

use super::objects::Context;
use crate::{
    error::{LoadError, LoadProblem, excerpt},
    folder::Located,
    load::{MeshFormat, Reading, read_mesh},
    model::{Findings, Model},
    names::brief_name,
    rooms::CellShape,
};

/// The files so far.
#[derive(Default)]
pub(super) struct MeshFiles {
    files: Vec<MeshFile>,
    by_path: HashMap<PathBuf, usize>,
    /// Paths as written, so that the system is asked once for each.
    by_name: HashMap<String, usize>,
}

impl MeshFiles {
    /// The file that an entry names. One that turns its mesh has said which way is up, if it is the first to name the file.
    pub(super) fn get(
        &mut self,
        (name, place): (&str, &str),
        is_turned: bool,
        context: &Context,
    ) -> Result<&mut MeshFile, LoadError> {
        let number = match self.by_name.get(name) {
            Some(&number) => number,
            None => {
                let located = context.folder.resolve(name, place).map_err(|problem| problem.in_file(context.path))?;
                let number = self.located((&located, place), is_turned, context)?;
                self.by_name.insert(name.to_owned(), number);
                number
            }
        };
        Ok(&mut self.files[number])
    }

    fn located(
        &mut self,
        (file, place): (&Located, &str),
        is_turned: bool,
        context: &Context,
    ) -> Result<usize, LoadError> {
        if let Some(&number) = self.by_path.get(&file.real) {
            return Ok(number);
        }
        self.files.push(MeshFile::new(read_file(file, place, is_turned, context)?));
        self.by_path.insert(file.real.clone(), self.files.len() - 1);
        Ok(self.files.len() - 1)
    }
}

fn read_file(file: &Located, place: &str, is_turned: bool, context: &Context) -> Result<Model, LoadError> {
    let Some(format) = MeshFormat::of(&file.shown) else {
        let message =
            format!("\"{}\" is no mesh file; .gltf, .glb, .obj, .stl and .ply are read", file.shown.display());
        return Err(LoadProblem::element(place, message).in_file(context.path));
    };
    let bytes = context.folder.ledger().read(file).map_err(|problem| problem.in_file(context.path))?;
    let up_is_stated = context.reading.up_is_stated || is_turned;
    read_mesh(&file.shown, format, &bytes, context.folder, &Reading { up_is_stated, ..context.reading })
}

/// A file, and where its parts are.
pub(super) struct MeshFile {
    /// Without findings; and without families that are but one object.
    model: Model,
    /// What was found and not told yet: about each object by its name, and about the rest.
    of_objects: HashMap<String, Findings>,
    of_rest: Findings,
    objects: HashMap<String, usize>,
    families: HashMap<String, Member>,
    cells: HashMap<String, usize>,
}

impl MeshFile {
    fn new(mut model: Model) -> Self {
        let mut of_rest = std::mem::take(&mut model.findings);
        let names: HashSet<&str> = model.objects.iter().map(|object| object.name.as_str()).collect();
        let of_objects = of_rest.split_off(|subject| names.contains(subject));
        let objects = first_by_name(model.objects.iter().map(|object| object.name.as_str()));
        let cells = first_by_name(model.cells.iter().map(|cell| cell.name.as_str()));
        let below = objects_below(&model.families);
        let families = first_by_name(model.families.families.iter().map(|family| family.name.as_str()));
        let member = |(name, family): (String, usize)| match below[family] {
            (0, _) => None,
            (1, only) => Some((name, Member::Object(only))),
            _ => Some((name, Member::Family(family))),
        };
        let families = families.into_iter().filter_map(member).collect();
        if model.objects.len() == 1 {
            model.families = FamilyTree { families: Vec::new(), roots: vec![Member::Object(0)] };
        }
        Self { model, of_objects, of_rest, objects, families, cells }
    }

    /// All of it, with what was not told yet.
    pub(super) fn whole(&mut self) -> Model {
        let mut findings = std::mem::take(&mut self.of_rest);
        let of_objects = std::mem::take(&mut self.of_objects);
        of_objects.into_values().for_each(|part| findings.absorb(part, str::to_owned));
        Model { findings, ..self.model.clone() }
    }

    /// The object of that name, or all objects of the family, with what was not told yet. `None` if there is neither.
    pub(super) fn node(&mut self, name: &str) -> Option<Model> {
        let name = brief_name(name);
        let object = self.objects.get(&name).copied().map(Member::Object);
        let mut part = self.model.pick(object.or_else(|| self.families.get(&name).copied())?);
        for object in &part.objects {
            let findings = self.of_objects.remove(&object.name).unwrap_or_default();
            part.findings.absorb(findings, str::to_owned);
        }
        Some(part)
    }

    /// Some of its objects by name, for a message.
    pub(super) fn some_names(&self) -> String {
        const SOME: usize = 5;
        let names = self.model.objects.iter().take(SOME).map(|object| format!("\"{}\"", excerpt(&object.name)));
        let more = if self.model.objects.len() > SOME { ", ..." } else { "" };
        names.collect::<Vec<_>>().join(", ") + more
    }

    /// The only mesh, or that of a node, which is a cell or an object.
    pub(super) fn cell(&self, node: Option<&str>) -> Option<(CellShape, DAffine3)> {
        let Model { objects, cells, .. } = &self.model;
        let mesh_of = |object: usize| match &objects[object].shape {
            Shape::Mesh(mesh) => Some((CellShape::Mesh(mesh.clone()), objects[object].map)),
            _ => None,
        };
        let cell = |cell: usize| (cells[cell].shape.clone(), cells[cell].map);
        match (node.map(brief_name), objects.len(), cells.len()) {
            (None, 1, 0) => mesh_of(0),
            (None, 0, 1) => Some(cell(0)),
            (None, ..) => None,
            (Some(name), ..) => {
                let of_cell = self.cells.get(&name).copied().map(cell);
                of_cell.or_else(|| mesh_of(*self.objects.get(&name)?))
            }
        }
    }
}

/// For each name the first that has it.
fn first_by_name<'a>(names: impl Iterator<Item = &'a str>) -> HashMap<String, usize> {
    let mut first = HashMap::new();
    for (number, name) in names.enumerate() {
        first.entry(brief_name(name)).or_insert(number);
    }
    first
}

/// How many objects each family has, smaller families included, and one of them.
fn objects_below(tree: &FamilyTree) -> Vec<(usize, usize)> {
    let mut below = vec![(0, 0); tree.families.len()];
    // A family comes after the one that it belongs to, so the way back meets it first.
    for (number, family) in tree.families.iter().enumerate().rev() {
        below[number] = family.members.iter().fold((0, 0), |(count, kept), &member| {
            let (more, one) = match member {
                Member::Object(object) => (1, object),
                Member::Family(family) => below[family],
            };
            if more > 0 { (count + more, one) } else { (count, kept) }
        });
    }
    below
}
