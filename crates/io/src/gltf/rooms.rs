//! Nodes that are cells or portals, by their names or their `extras`.
//!
//! A node called `cell:NAME`, or with `"cell": true` in its extras, is a cell: its mesh, placed, is a closed convex body and no object;
//! without a mesh it is the outdoors. A node called `portal:ONE|OTHER`, or with `"portal": ["ONE", "OTHER"]`, is a portal between two
//! cells: the hull of the vertices of its flat mesh. Names stand for themselves: no node is asked for its children.
//!
//! Names may mean something else, so a name alone refuses no file: what it makes no sound cell or portal is told, and stays what it is
//! without the name; after 64 such the other names are not looked at. What extras state is checked with the scene, and refused where it is
//! unsound; so is what only the entries of a scene file make unsound: the outdoors twice, a cell flattened.

use std::{collections::HashMap, sync::Arc};

use serde_json::Value;
use umbriel_scene::{FindingKind, SceneCell};

use super::{
    accessor::within,
    hierarchy::{Hierarchy, Placed, place},
    json::{Document, Node},
    mesh::Meshes,
};
use crate::{
    error::{LoadProblem, excerpt},
    ledger::{Ledger, Quantity},
    model::Findings,
    names::brief_name,
    rooms::{CellShape, EntryPlace, ModelCell, ModelPortal, Outline, cell_in_file, check_portal},
};

/// Names that may turn out to make no cell or portal; what else is named so is not looked at any more, since each costs exact work.
const MOST_UNSOUND: usize = 64;

/// What a node is besides an object.
#[derive(Clone, Debug, PartialEq)]
enum Role {
    Cell(String),
    Portal([String; 2]),
}

/// A node that is a cell or a portal.
#[derive(Clone, Debug)]
pub(super) enum Room {
    Cell(ModelCell),
    Portal(ModelPortal),
}

/// The cells and portals among the nodes of the scene, in their order.
pub(super) fn of_nodes(
    document: &Document,
    hierarchy: &Hierarchy,
    meshes: &mut Meshes,
    findings: &mut Findings,
    ledger: &Ledger,
) -> Result<Vec<Option<Box<Room>>>, LoadProblem> {
    let place_of = |placed: &Placed| place(placed.node, &document.nodes[placed.node]);
    let mut rooms = Vec::with_capacity(hierarchy.len());
    let mut named = Vec::new();
    for (number, placed) in hierarchy.iter().enumerate() {
        let node = &document.nodes[placed.node];
        let found = match role(node) {
            Ok(None) => Ok(None),
            Ok(Some((role, is_stated))) => match room(role, &placed, node, meshes)? {
                Ok(room) => {
                    named.extend((!is_stated).then_some(number));
                    Ok(Some(Box::new(room)))
                }
                Err(fault) if is_stated => return Err(LoadProblem::element(place_of(&placed), fault)),
                Err(fault) => Err(fault),
            },
            Err(fault) => Err(fault),
        };
        rooms.push(found.unwrap_or_else(|fault| {
            tell(findings, &place_of(&placed), &fault);
            None
        }));
    }
    check_sizes(&rooms, ledger)?;
    for (number, fault) in drop_unsound(&mut rooms, &named) {
        tell(findings, &place_of(&hierarchy.placed(number)), &fault);
    }
    Ok(rooms)
}

/// Whether they do not place too much, before anything exact is asked of them.
fn check_sizes(rooms: &[Option<Box<Room>>], ledger: &Ledger) -> Result<(), LoadProblem> {
    let mesh = |room: &Room| match room {
        Room::Cell(ModelCell { shape: CellShape::Mesh(mesh), .. })
        | Room::Portal(ModelPortal { outline: Outline::HullOf(mesh), .. }) => Some(Arc::clone(mesh)),
        _ => None,
    };
    let meshes = || rooms.iter().flatten().filter_map(|room| mesh(room));
    ledger.check(Quantity::Parts, rooms.iter().flatten().count() as u64)?;
    ledger.check(Quantity::PlacedTriangles, meshes().map(|mesh| mesh.triangles().len() as u64).sum())?;
    ledger.check(Quantity::PlacedVertices, meshes().map(|mesh| mesh.positions().len() as u64).sum())
}

fn tell(findings: &mut Findings, place: &str, fault: &str) {
    findings.add(FindingKind::BrokenRule, &format!("{place}: it is no cell or portal: {fault}"), 1);
}

/// The role of a node, if it has one, and whether its extras state it, so that it has to be sound.
fn role(node: &Node) -> Result<Option<(Role, bool)>, String> {
    let name = node.name.as_deref().unwrap_or_default();
    match stated_role(node, name)? {
        Some(role) => Ok(Some((role, true))),
        None => Ok(named_role(name)?.map(|role| (role, false))),
    }
}

fn named_role(name: &str) -> Result<Option<Role>, String> {
    if let Some(cell) = name.strip_prefix("cell:") {
        return Ok(Some(Role::Cell(brief_name(cell))));
    }
    let Some(cells) = name.strip_prefix("portal:") else { return Ok(None) };
    let (one, other) = cells.split_once('|').ok_or("a portal's name has two cells, portal:ONE|OTHER")?;
    Ok(Some(Role::Portal([one, other].map(brief_name))))
}

fn stated_role(node: &Node, name: &str) -> Result<Option<Role>, String> {
    // What is nested too deep for a value says nothing of cells.
    let extras = node.extras.as_ref().and_then(|extras| serde_json::from_str(extras.get()).ok());
    let Some(Value::Object(extras)) = extras else { return Ok(None) };
    if extras.get("cell") == Some(&Value::Bool(true)) {
        return Ok(Some(Role::Cell(brief_name(name))));
    }
    match extras.get("portal") {
        Some(Value::Array(ends)) => match &ends[..] {
            [Value::String(one), Value::String(other)] => {
                Ok(Some(Role::Portal([one, other].map(|end| brief_name(end)))))
            }
            _ => Err("its extras name a portal without two cells, \"portal\": [\"ONE\", \"OTHER\"]".to_owned()),
        },
        _ => Ok(None),
    }
}

/// The cell or portal that a node is with the mesh that it has, or why it is none.
fn room(role: Role, placed: &Placed, node: &Node, meshes: &mut Meshes) -> Result<Result<Room, String>, LoadProblem> {
    let told = |problem| within(problem, &place(placed.node, node));
    let mesh = node.mesh.map(|mesh| meshes.get(mesh, node.weights.as_deref())).transpose().map_err(told)?;
    let mesh = mesh.map(|mesh| Arc::clone(&mesh.mesh));
    let (map, rounding, place) = (placed.map, None, EntryPlace::Element(place(placed.node, node)));
    Ok(match (role, mesh) {
        (Role::Cell(name), mesh) => {
            let shape = mesh.map_or(CellShape::Outdoors, CellShape::Mesh);
            Ok(Room::Cell(ModelCell { name, shape, map, rounding, place }))
        }
        (Role::Portal(_), None) => Err("a portal needs a flat mesh".to_owned()),
        (Role::Portal(cells), Some(mesh)) => {
            let name = node.name.as_deref().map_or_else(|| format!("node{}", placed.node), brief_name);
            Ok(Room::Portal(ModelPortal { name, cells, outline: Outline::HullOf(mesh), map, rounding, place }))
        }
    })
}

/// The cells that portals may join, by their names; none for a cell that is stated and unsound, which refuses the scene later.
#[derive(Default)]
struct Known {
    cells: HashMap<String, Option<SceneCell>>,
    has_outdoors: bool,
}

/// Leaves out what names alone make unsound cells or portals, and says why.
fn drop_unsound(rooms: &mut [Option<Box<Room>>], named: &[usize]) -> Vec<(usize, String)> {
    let mut faults = Vec::new();
    if named.is_empty() {
        return faults;
    }
    let mut known = Known::default();
    let mut is_stated = vec![true; rooms.len()];
    named.iter().for_each(|&number| is_stated[number] = false);
    for (room, _) in rooms.iter().zip(&is_stated).filter(|&(_, is_stated)| *is_stated) {
        if let Some(Room::Cell(cell)) = room.as_deref() {
            known.has_outdoors |= matches!(cell.shape, CellShape::Outdoors);
            known.cells.insert(cell.name.clone(), cell_in_file(cell).ok());
        }
    }
    // Portals name cells that may come after them.
    for is_cell in [true, false] {
        for &number in named {
            let room = &mut rooms[number];
            let Some(found) = room.as_deref().filter(|room| matches!(room, Room::Cell(_)) == is_cell) else { continue };
            let checked = match faults.len() {
                MOST_UNSOUND.. => Err("so many others are none".to_owned()),
                _ => known.check(found),
            };
            if let Err(fault) = checked {
                faults.push((number, fault));
                *room = None;
            }
        }
    }
    faults
}

impl Known {
    /// Takes a cell, or looks at a portal between cells that are known.
    fn check(&mut self, room: &Room) -> Result<(), String> {
        match room {
            Room::Cell(cell) => {
                let is_outdoors = matches!(cell.shape, CellShape::Outdoors);
                if self.cells.contains_key(&cell.name) {
                    return Err("another cell has this name".to_owned());
                }
                if is_outdoors && self.has_outdoors {
                    return Err("there is an outdoors already, and there can be one only".to_owned());
                }
                self.cells.insert(cell.name.clone(), Some(cell_in_file(cell)?));
                self.has_outdoors |= is_outdoors;
                Ok(())
            }
            Room::Portal(portal) => {
                let cell = |end: usize| {
                    let name = &portal.cells[end];
                    self.cells.get(name).ok_or_else(|| format!("there is no cell \"{}\"", excerpt(name)))
                };
                match (cell(0)?, cell(1)?) {
                    (Some(one), Some(other)) => check_portal(portal, [one, other]),
                    _ => Ok(()),
                }
            }
        }
    }
}
