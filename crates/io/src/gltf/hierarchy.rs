//! The node hierarchy: checked to be a forest, walked without recursion, with the matrix of every node.
//!
//! Scenes take no numbers below 2^-200 but 0; in matrices such numbers are what rounding left of 0, and taken as 0.

use glam::{DAffine3, DMat3};
use umbriel_geometry::MIN_MAGNITUDE;

use super::json::{Document, Node, element};
use crate::{
    error::LoadProblem,
    names::brief_name,
    transform::{from_almost_affine, from_parts, rotation_matrix},
};

/// How it is told that a matrix had numbers below 2^-200.
pub(super) const TINY: &str = "numbers of its matrix below 2^-200 are taken as 0";

/// A node of the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// Its index in the document.
    pub(super) node: usize,
    /// Its parent's place among the nodes of the scene.
    pub(super) parent: Option<usize>,
    /// Node to scene coordinates.
    pub(super) map: DAffine3,
    /// What turns directions as the rotations and matrices up to the root do: scales that nodes give apart are left out.
    pub(super) turn: DMat3,
    /// Neither it nor a node above it is hidden (KHR_node_visibility): what it shows counts, its meshes and lights.
    pub(super) is_visible: bool,
}

/// What is kept of a node of the scene: files may have millions.
#[derive(Clone, Copy, Debug)]
struct Walked {
    node: usize,
    parent: Option<usize>,
    /// Which of the turns is its.
    turn: usize,
    is_visible: bool,
}

/// The nodes of the scene, parents before their children.
#[derive(Debug)]
pub(super) struct Hierarchy {
    walked: Vec<Walked>,
    /// First that of the roots, then of each node that turns otherwise than the one above it.
    turns: Vec<DMat3>,
    /// The map of every node of the document, in the scene or not.
    pub(super) maps: Vec<DAffine3>,
    /// Whether a node of the document is in the scene.
    pub(super) is_in_scene: Vec<bool>,
    /// The nodes whose maps had numbers below 2^-200.
    pub(super) tiny: Vec<usize>,
}

/// How messages call a node.
pub(super) fn place(node: usize, declared: &Node) -> String {
    match &declared.name {
        Some(name) => format!("node {node} (\"{}\")", brief_name(name)),
        None => format!("node {node}"),
    }
}

impl Hierarchy {
    /// Checks the hierarchy of all nodes and walks the one of the scene.
    pub(super) fn new(document: &Document) -> Result<Self, LoadProblem> {
        let parents_first = parents_first(document)?;
        let mut maps = vec![DAffine3::IDENTITY; document.nodes.len()];
        let mut tiny = Vec::new();
        for &(node, parent) in &parents_first {
            let declared = &document.nodes[node];
            let own = own_map(declared).map_err(|message| LoadProblem::element(place(node, declared), message))?;
            let (map, count) = without_tiny(parent.map_or(own, |parent| maps[parent] * own));
            maps[node] = map;
            tiny.extend((count > 0).then_some(node));
        }
        let mut has_parent = vec![false; document.nodes.len()];
        parents_first.iter().for_each(|&(node, parent)| has_parent[node] = parent.is_some());
        let roots = roots(document, &has_parent)?;
        let mut open: Vec<(usize, Option<usize>)> = roots.into_iter().rev().map(|root| (root, None)).collect();
        let (mut walked, mut turns): (Vec<Walked>, _) = (Vec::new(), vec![DMat3::IDENTITY]);
        while let Some((node, parent)) = open.pop() {
            open.extend(document.nodes[node].children.iter().rev().map(|&child| (child, Some(walked.len()))));
            let declared = &document.nodes[node];
            let above = parent.map(|parent| walked[parent]);
            let mut turn = above.map_or(0, |above| above.turn);
            let own = own_turn(declared);
            if own != DMat3::IDENTITY {
                turns.push(turns[turn] * own);
                turn = turns.len() - 1;
            }
            let is_visible = above.is_none_or(|above| above.is_visible) && !declared.is_hidden();
            walked.push(Walked { node, parent, turn, is_visible });
        }
        let mut is_in_scene = vec![false; document.nodes.len()];
        walked.iter().for_each(|walked| is_in_scene[walked.node] = true);
        Ok(Self { walked, turns, maps, is_in_scene, tiny })
    }

    /// How many nodes the scene has.
    pub(super) fn len(&self) -> usize {
        self.walked.len()
    }

    /// A node of the scene.
    pub(super) fn placed(&self, number: usize) -> Placed {
        let Walked { node, parent, turn, is_visible } = self.walked[number];
        Placed { node, parent, map: self.maps[node], turn: self.turns[turn], is_visible }
    }

    /// All nodes of the scene.
    pub(super) fn iter(&self) -> impl Iterator<Item = Placed> {
        (0..self.len()).map(|number| self.placed(number))
    }
}

/// All nodes with their parents, parents before their children; refused unless every node has one parent at most and
/// no node is its own ancestor.
fn parents_first(document: &Document) -> Result<Vec<(usize, Option<usize>)>, LoadProblem> {
    let mut parent_of: Vec<Option<usize>> = vec![None; document.nodes.len()];
    for (parent, node) in document.nodes.iter().enumerate() {
        for &child in &node.children {
            let refused = |message: String| LoadProblem::element(place(parent, node), message);
            element(&document.nodes, child, "child node").map_err(refused)?;
            if let Some(other) = parent_of[child].replace(parent) {
                return Err(LoadProblem::element(
                    place(child, &document.nodes[child]),
                    format!("it is a child twice, of node {other} and of node {parent}; a node has one parent at most"),
                ));
            }
        }
    }
    // With one parent each, whatever cannot be reached from a node without parent hangs on a cycle.
    let mut open: Vec<usize> = (0..parent_of.len()).filter(|&node| parent_of[node].is_none()).collect();
    let mut reached = vec![false; parent_of.len()];
    let mut order = Vec::with_capacity(parent_of.len());
    while let Some(node) = open.pop() {
        reached[node] = true;
        order.push((node, parent_of[node]));
        open.extend(document.nodes[node].children.iter());
    }
    match reached.iter().position(|&reached| !reached) {
        Some(node) => Err(LoadProblem::element(
            place(node, &document.nodes[node]),
            "it is, or hangs on, its own ancestor: a cycle",
        )),
        None => Ok(order),
    }
}

/// The roots of the default scene, else of the first, else all nodes without a parent.
fn roots(document: &Document, has_parent: &[bool]) -> Result<Vec<usize>, LoadProblem> {
    if document.scenes.is_empty() && document.scene.is_none() {
        return Ok((0..has_parent.len()).filter(|&node| !has_parent[node]).collect());
    }
    let index = document.scene.unwrap_or(0);
    let scene = element(&document.scenes, index, "scene").map_err(|message| LoadProblem::element("scene", message))?;
    let mut taken = vec![false; has_parent.len()];
    for &root in &scene.nodes {
        let refused = |message: String| LoadProblem::element(format!("scene {index}"), message);
        element(&document.nodes, root, "node").map_err(refused)?;
        if has_parent[root] || std::mem::replace(&mut taken[root], true) {
            return Err(refused(format!("its node {root} is a child of another node or named twice")));
        }
    }
    Ok(scene.nodes.clone())
}

/// A node's own matrix.
pub(super) fn own_map(node: &Node) -> Result<DAffine3, String> {
    match &node.matrix {
        Some(_) if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() => {
            Err("it has both a matrix and translation, rotation or scale; glTF allows one of the two".to_owned())
        }
        Some(matrix) => from_almost_affine(matrix),
        None => from_parts(
            node.translation.as_deref().copied().unwrap_or([0.0; 3]),
            node.rotation.as_deref().copied().unwrap_or([0.0, 0.0, 0.0, 1.0]),
            node.scale.as_deref().copied().unwrap_or([1.0; 3]),
        ),
    }
}

/// How a node turns directions: by its rotation, or its matrix, whose scales cannot be told apart.
fn own_turn(node: &Node) -> DMat3 {
    match (&node.matrix, &node.rotation) {
        (Some(_), _) => own_map(node).map_or(DMat3::ZERO, |map| map.matrix3),
        (None, Some(rotation)) => rotation_matrix(**rotation).unwrap_or(DMat3::ZERO),
        (None, None) => DMat3::IDENTITY,
    }
}

/// The map with 0 for numbers below 2^-200, and how many there were.
pub(super) fn without_tiny(map: DAffine3) -> (DAffine3, usize) {
    let mut entries = map.to_cols_array();
    let count = clear_tiny(&mut entries);
    (DAffine3::from_cols_array(&entries), count)
}

/// Sets numbers below 2^-200 to 0, and counts them.
pub(super) fn clear_tiny(numbers: &mut [f64]) -> usize {
    let mut count = 0;
    for number in numbers.iter_mut().filter(|number| **number != 0.0 && number.abs() < MIN_MAGNITUDE) {
        *number = 0.0;
        count += 1;
    }
    count
}
