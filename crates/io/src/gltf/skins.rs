//! Skins, taken at their bind pose.
//!
//! A vertex of a skinned mesh lies at the weighted sum of J·B·v over its joints, J being the joint's matrix in the scene
//! and B its inverse bind matrix; the matrix of the node itself is ignored, as glTF says. In the bind pose all J·B are
//! one matrix, and the mesh keeps the shape that it has in the file: that matrix is its placement. Where the nodes do
//! not stand in the bind pose, the mesh takes it up where its first joint stands.

use std::collections::{BTreeSet, HashMap};

use glam::DAffine3;
use umbriel_scene::FindingKind;

use super::{
    accessor::{Accessors, Component, within},
    hierarchy::{Hierarchy, TINY, without_tiny},
    json::{Document, Skin, element, existing},
};
use crate::{
    error::LoadProblem,
    model::Findings,
    transform::{from_almost_affine, is_affine},
};

/// The skins of a document, each looked at when first asked for.
#[derive(Debug)]
pub(super) struct Skins<'a> {
    document: &'a Document,
    hierarchy: &'a Hierarchy,
    accessors: &'a Accessors<'a>,
    bind_maps: HashMap<usize, DAffine3>,
    findings: Findings,
}

impl<'a> Skins<'a> {
    pub(super) fn new(document: &'a Document, hierarchy: &'a Hierarchy, accessors: &'a Accessors<'a>) -> Self {
        Self { document, hierarchy, accessors, bind_maps: HashMap::new(), findings: Findings::default() }
    }

    /// The placement of a mesh with that skin: J·B of the first joint.
    pub(super) fn bind_map(&mut self, index: usize) -> Result<DAffine3, LoadProblem> {
        if let Some(&map) = self.bind_maps.get(&index) {
            return Ok(map);
        }
        let skin = existing(&self.document.skins, index, "skin")?;
        let place = format!("skin {index}");
        let refused = |message: String| LoadProblem::element(&place, message);
        for &joint in &skin.joints {
            element(&self.document.nodes, joint, "joint node").map_err(refused)?;
        }
        let outside = skin.joints.iter().filter(|&&joint| !self.hierarchy.is_in_scene[joint]).count();
        self.findings.add(FindingKind::BrokenRule, &format!("{place}: joints that are not in the scene"), outside);
        let Some(&first) = skin.joints.first() else { return Err(refused("it has no joints".to_owned())) };
        let inverse = self.inverse(skin, &place)?;
        let (map, tiny) = without_tiny(self.hierarchy.maps[first] * inverse);
        self.findings.add(FindingKind::BrokenRule, &format!("{place}: {TINY}"), usize::from(tiny > 0));
        self.bind_maps.insert(index, map);
        Ok(map)
    }

    /// The inverse bind matrix of the first joint.
    fn inverse(&self, skin: &Skin, place: &str) -> Result<DAffine3, LoadProblem> {
        let Some(accessor) = skin.inverse_bind_matrices else { return Ok(DAffine3::IDENTITY) };
        let refused = |message: String| LoadProblem::element(place, message);
        let (_, component) = self.accessors.declared(accessor).map_err(|problem| within(problem, place))?;
        if component != Component::F32 {
            return Err(refused("its inverse bind matrices are not 32-bit floats".to_owned()));
        }
        let matrices = self.accessors.vectors::<16>(accessor).map_err(|problem| within(problem, place))?;
        let Some(matrix) = matrices.first().filter(|_| matrices.len() >= skin.joints.len()) else {
            let (count, joints) = (matrices.len(), skin.joints.len());
            return Err(refused(format!("it has {count} inverse bind matrices for {joints} joints")));
        };
        if !is_finite(matrix) {
            return Err(refused("inverse bind matrix 0 is not finite".to_owned()));
        }
        from_almost_affine(matrix).map_err(|message| refused(format!("inverse bind matrix 0: {message}")))
    }

    /// What was taken otherwise than the file says.
    pub(super) fn into_findings(self) -> Findings {
        self.findings
    }
}

/// What is wrong with the inverse bind matrices that were read. Those of the first joints alone place something.
pub(super) fn check(document: &Document, accessors: &Accessors) -> Findings {
    let mut findings = Findings::default();
    let read = document.skins.iter().filter_map(|skin| skin.inverse_bind_matrices);
    let read: BTreeSet<usize> = read.filter(|&accessor| accessors.is_read(accessor)).collect();
    for accessor in read {
        let Ok(matrices) = accessors.vectors::<16>(accessor) else { continue };
        let mut tell = |rule: &str, count: usize| {
            findings.add(FindingKind::BrokenRule, &format!("accessor {accessor}: inverse bind matrices {rule}"), count);
        };
        let (finite, wild): (Vec<_>, Vec<_>) = matrices.iter().partition(|matrix| is_finite(matrix));
        tell("that are not finite", wild.len());
        let count = finite.iter().filter(|matrix| !is_affine(matrix)).count();
        tell("with a last row that is not quite 0 0 0 1", count);
    }
    findings
}

fn is_finite(matrix: &[f64; 16]) -> bool {
    matrix.iter().all(|entry| entry.is_finite())
}
