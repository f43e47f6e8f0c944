//! Nodes that are cells or portals, by their names or their `extras`.
//!
//! A node called `cell:NAME`, or with `"cell": true` in its extras, is a cell: its mesh, placed, is a closed convex body and no object;
//! without a mesh it is the outdoors. A node called `portal:ONE|OTHER`, or with `"portal": ["ONE", "OTHER"]`, is a portal between two
//! cells: the hull of the vertices of its flat mesh. Names stand for themselves: no node is asked for its children.

use glam::DAffine3;
use serde_json::Value;

use super::{
    hierarchy::{Placed, place},
    json::Node,
    mesh::LoadedMesh,
};
use crate::{
    model::Model,
    rooms::{CellShape, EntryPlace, ModelCell, ModelPortal, Outline},
};

/// What a node is besides an object.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Role {
    Cell(String),
    Portal([String; 2]),
}

/// The role of a node, if it has one.
pub(super) fn role(node: &Node) -> Result<Option<Role>, String> {
    let name = node.name.as_deref().unwrap_or_default();
    if let Some(cell) = name.strip_prefix("cell:") {
        return Ok(Some(Role::Cell(cell.to_owned())));
    }
    if let Some(cells) = name.strip_prefix("portal:") {
        let ends = cells.split_once('|').ok_or("a portal's name has two cells, portal:ONE|OTHER")?;
        return Ok(Some(Role::Portal([ends.0.to_owned(), ends.1.to_owned()])));
    }
    // What is nested too deep for a value says nothing of cells.
    let extras = node.extras.as_ref().and_then(|extras| serde_json::from_str(extras.get()).ok());
    let Some(Value::Object(extras)) = extras else { return Ok(None) };
    if extras.get("cell") == Some(&Value::Bool(true)) {
        return Ok(Some(Role::Cell(name.to_owned())));
    }
    match extras.get("portal") {
        Some(Value::Array(ends)) => match &ends[..] {
            [Value::String(one), Value::String(other)] => Ok(Some(Role::Portal([one.clone(), other.clone()]))),
            _ => Err("its extras name a portal without two cells, \"portal\": [\"ONE\", \"OTHER\"]".to_owned()),
        },
        _ => Ok(None),
    }
}

/// Adds a cell or a portal with the mesh of its node.
pub(super) fn add(
    model: &mut Model,
    role: Role,
    placed: &Placed,
    node: &Node,
    (map, mesh): (DAffine3, Option<&LoadedMesh>),
) -> Result<(), String> {
    let place = EntryPlace::Element(place(placed.node, node));
    match role {
        Role::Cell(name) => {
            let shape = mesh.map_or(CellShape::Outdoors, |mesh| CellShape::Mesh(mesh.mesh.clone()));
            model.cells.push(ModelCell { name, shape, map, rounding: None, place });
        }
        Role::Portal(cells) => {
            let mesh = mesh.ok_or("a portal needs a flat mesh")?;
            let outline = Outline::HullOf(mesh.mesh.positions().into());
            let name = node.name.clone().unwrap_or_else(|| format!("node{}", placed.node));
            model.portals.push(ModelPortal { name, cells, outline, map, rounding: None, place });
        }
    }
    Ok(())
}
