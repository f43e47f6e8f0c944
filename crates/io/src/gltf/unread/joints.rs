//! Joints that move a vertex (glTF 2.0, 3.7.3.3): none has two weights for one vertex, in all of its sets together.

use std::collections::BTreeSet;

use umbriel_scene::FindingKind;

use super::Plain;
use crate::{
    gltf::{
        accessor::Accessors,
        json::{Document, Primitive},
    },
    model::Findings,
};

/// Looks at the joints of all primitives, each group of accessors once.
pub(super) fn check(document: &Document, accessors: &Accessors, left: &mut u64, findings: &mut Findings) {
    let mut seen = BTreeSet::new();
    let primitives = document.meshes.iter().flat_map(|mesh| &mesh.primitives);
    for primitive in primitives.filter(|primitive| primitive.extensions.draco.is_none()) {
        let sets = sets_of(primitive);
        let Some(&(first, _)) = sets.first().filter(|_| seen.insert(sets.clone())) else { continue };
        let Some(mut moved) = moved(document, accessors, &sets, left) else { continue };
        moved.sort_unstable();
        let mut twice: Vec<usize> = moved.windows(2).filter(|two| two[0] == two[1]).map(|two| two[0].0).collect();
        twice.dedup();
        if let Some(vertex) = twice.first() {
            let subject = format!("unused: accessor {first}: joints that have two weights for a vertex");
            findings.add_with(FindingKind::BrokenRule, &subject, twice.len(), &format!("vertex {vertex}"));
        }
    }
}

/// The accessors of the joints of a primitive, each with that of their weights.
fn sets_of(primitive: &Primitive) -> Vec<(usize, usize)> {
    let joints =
        primitive.attributes.iter().filter_map(|(name, &joints)| Some((name.strip_prefix("JOINTS_")?, joints)));
    let weights = |set: &str| primitive.attributes.get(&format!("WEIGHTS_{set}")).copied();
    joints.filter_map(|(set, joints)| Some((joints, weights(set)?))).collect()
}

/// Every vertex with every joint that has a weight for it; `None` where these are not all at hand.
fn moved(
    document: &Document,
    accessors: &Accessors,
    sets: &[(usize, usize)],
    left: &mut u64,
) -> Option<Vec<(usize, u32)>> {
    let mut moved = Vec::new();
    for &(joints, weights) in sets {
        let (joints, weights) =
            (Plain::of(document, accessors, joints, left)?, Plain::of(document, accessors, weights, left)?);
        let mut weighs: Vec<[bool; 4]> = Vec::new();
        weights.for_each(|_, weights| {
            weighs.push(std::array::from_fn(|place| weights.get(place).is_some_and(|&weight| weight > 0.0)));
        });
        joints.for_each(|vertex, joints| {
            let weighs = weighs.get(vertex).copied().unwrap_or_default();
            let joints = joints.iter().zip(weighs).filter(|(_, weighs)| *weighs);
            moved.extend(joints.map(|(&joint, _)| (vertex, joint as u32)));
        });
    }
    Some(moved)
}
