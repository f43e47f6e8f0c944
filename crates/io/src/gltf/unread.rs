//! Elements of accessors that nothing reads: normals, joints, motions.
//!
//! They say nothing about surfaces, but a file that is broken there is broken. Only bytes that are at hand are looked at: of buffers
//! that something else has read, as many elements as the scene has left, each one twice at most. What is wrong with them is told. Of sparse accessors the places and values are
//! looked at, too, whether the weights of joints add up, whether each joint moves a vertex once ([`joints`]), the [`values`] of attributes, and
//! the [`extents`] that accessors declare.

mod extents;
mod joints;
mod values;

use std::{
    borrow::Cow,
    collections::{BTreeSet, HashMap, HashSet},
};

use umbriel_scene::FindingKind;

use super::{
    accessor::{Accessors, Component, within},
    json::{Accessor, Document},
};
use crate::{error::LoadProblem, model::Findings};

/// How far the weights of a vertex may be off 1 together: those of 8 bits are off by 1/510 each, and few vertices have more than four. glTF's own rule for floats,
/// 2e-7 a weight, most exporters break.
const WEIGHTS_OFF: f64 = 1e-2;

/// The type of components that are 32-bit floats.
const FLOAT: u32 = 5126;

/// What is wrong with the elements that were not read.
pub(super) fn check(document: &Document, accessors: &Accessors) -> Findings {
    let (joints, times) = (joints_of(document), times_of(document));
    let mut of_view: Vec<Vec<usize>> = vec![Vec::new(); document.buffer_views.len()];
    let unread = (0..document.accessors.len()).filter(|&index| !accessors.is_read(index));
    for (index, view) in unread.filter_map(|index| Some((index, document.accessors[index].buffer_view?))) {
        of_view[view].push(index);
    }
    let mut findings = Findings::default();
    let mut left = accessors.ledger().elements_left();
    for (view, indices) in of_view.iter().enumerate() {
        let is_empty = indices.is_empty() && !accessors.views().is_compressed(view);
        let bytes = if is_empty { None } else { accessors.views().at_hand(view, &mut left) };
        match bytes {
            Some(Ok(bytes)) => {
                let elements = Elements { document, joints: &joints, times: &times, bytes: &bytes };
                indices.iter().for_each(|&index| elements.check(index, &mut left, &mut findings));
            }
            Some(Err(problem)) => tell(&mut findings, &problem, 1),
            None => {}
        }
    }
    for (index, accessor) in document.accessors.iter().enumerate().filter(|&(index, _)| !accessors.is_read(index)) {
        if let Err(problem) = check_sparse(accessors, accessor, &mut left) {
            tell(&mut findings, &within(problem, &format!("accessor {index}")), 1);
        }
        let wrong = wrong_values(document, accessors, accessor, &mut left);
        tell(&mut findings, &format!("accessor {index}: sparse components that are not finite"), wrong);
    }
    check_weights(document, accessors, &mut left, &mut findings);
    joints::check(document, accessors, &mut left, &mut findings);
    values::check(document, accessors, &mut left, &mut findings);
    extents::check(document, accessors, &mut left, &mut findings);
    findings
}

/// Whether the weights of each vertex add up to 1, in all of its sets together.
fn check_weights(document: &Document, accessors: &Accessors, left: &mut u64, findings: &mut Findings) {
    let mut seen = BTreeSet::new();
    let primitives = document.meshes.iter().flat_map(|mesh| &mesh.primitives);
    for primitive in primitives.filter(|primitive| primitive.extensions.draco.is_none()) {
        let weights = primitive.attributes.iter().filter(|(name, _)| name.starts_with("WEIGHTS_"));
        let mut sets: Vec<usize> = weights.map(|(_, &accessor)| accessor).collect();
        sets.sort_unstable();
        let Some(&first) = sets.first().filter(|_| seen.insert(sets.clone())) else { continue };
        let Some(sums) = sums(document, accessors, &sets, left) else { continue };
        let is_off = |sum: &f64| sum.is_finite() && (sum - 1.0).abs() > WEIGHTS_OFF;
        if let Some(vertex) = sums.iter().position(is_off) {
            let subject = format!("unused: accessor {first}: weights that do not add up to 1");
            let count = sums.iter().filter(|sum| is_off(sum)).count();
            findings.add_with(FindingKind::BrokenRule, &subject, count, &format!("vertex {vertex}"));
        }
    }
}

/// For each vertex the sum of its weights in some accessors; `None` where these are not all at hand, plain, and of one length.
fn sums(document: &Document, accessors: &Accessors, sets: &[usize], left: &mut u64) -> Option<Vec<f64>> {
    let count = document.accessors[sets[0]].count;
    if sets.iter().any(|&set| document.accessors[set].count != count) {
        return None;
    }
    let sets: Vec<Plain> = sets.iter().map(|&set| Plain::of(document, accessors, set, left)).collect::<Option<_>>()?;
    let mut sums = vec![0.0; count];
    for set in sets {
        set.for_each(|vertex, weights| sums[vertex] += weights.iter().sum::<f64>());
    }
    Some(sums)
}

/// The elements of an accessor without anything sparse: those of a view at hand, or zeros.
struct Plain<'a> {
    bytes: Option<Cow<'a, [u8]>>,
    component: Component,
    normalized: bool,
    offset: usize,
    count: usize,
    stride: usize,
    size: usize,
}

impl<'a> Plain<'a> {
    /// The same with its components as they are stored.
    fn stored(self) -> Self {
        Self { normalized: false, ..self }
    }

    /// Takes what looking at them costs from `left`; `None` where that is too little.
    fn of(document: &Document, accessors: &'a Accessors, index: usize, left: &mut u64) -> Option<Self> {
        let accessor = &document.accessors[index];
        if accessor.sparse.is_some() {
            return None;
        }
        *left = left.checked_sub(accessor.count as u64)?;
        let component = Component::of(accessor.component_type).ok()?;
        let size = super::validate::element_size(&accessor.kind, component)?;
        let bytes = match accessor.buffer_view {
            Some(view) => Some(accessors.views().at_hand(view, left)?.ok()?),
            None => None,
        };
        let view = accessor.buffer_view.map(|view| &document.buffer_views[view]);
        Some(Self {
            bytes,
            component,
            normalized: accessor.normalized,
            offset: accessor.byte_offset(),
            count: accessor.count,
            stride: view.map_or(size, |view| view.stride(size)),
            size,
        })
    }

    /// The components of each vector, up to where they leave the view.
    fn for_each(&self, mut look: impl FnMut(usize, &[f64])) {
        let zeros = vec![0; self.size];
        let element = |number: usize| match &self.bytes {
            Some(bytes) => element_at(bytes, self.offset, number.checked_mul(self.stride)?, self.size),
            None => Some(&zeros[..]),
        };
        for (number, element) in (0..self.count).map_while(element).enumerate() {
            let mut values = [0.0; 4];
            let components = element.chunks_exact(self.component.size());
            let used = components.len().min(values.len());
            for (value, bytes) in values.iter_mut().zip(components) {
                *value = self.component.decode(bytes, self.normalized);
            }
            look(number, &values[..used]);
        }
    }
}

fn tell(findings: &mut Findings, problem: &dyn std::fmt::Display, count: usize) {
    findings.add(FindingKind::BrokenRule, &format!("unused: {problem}"), count);
}

/// For accessors of joints the least number of joints among the skins that they are numbers of.
fn joints_of(document: &Document) -> HashMap<usize, usize> {
    let mut least_of_mesh: HashMap<usize, usize> = HashMap::new();
    for (mesh, skin) in document.nodes.iter().filter_map(|node| Some((node.mesh?, node.skin?))) {
        let joints = least_of_mesh.entry(mesh).or_insert(usize::MAX);
        *joints = document.skins[skin].joints.len().min(*joints);
    }
    let mut least: HashMap<usize, usize> = HashMap::new();
    for (mesh, count) in least_of_mesh {
        let attributes = document.meshes[mesh].primitives.iter().flat_map(|primitive| primitive.attributes.iter());
        for (_, &accessor) in attributes.filter(|(name, _)| name.starts_with("JOINTS_")) {
            let joints = least.entry(accessor).or_insert(usize::MAX);
            *joints = count.min(*joints);
        }
    }
    least
}

/// Accessors of the times of animations.
fn times_of(document: &Document) -> HashSet<usize> {
    let samplers = document.animations.iter().flat_map(|animation| &animation.samplers);
    samplers.map(|sampler| sampler.input).collect()
}

/// The bytes of a view, decompressed.
struct Elements<'a> {
    document: &'a Document,
    joints: &'a HashMap<usize, usize>,
    times: &'a HashSet<usize>,
    bytes: &'a [u8],
}

impl Elements<'_> {
    fn check(&self, index: usize, left: &mut u64, findings: &mut Findings) {
        let accessor = &self.document.accessors[index];
        let joints = self.joints.get(&index);
        let Ok(component) = Component::of(accessor.component_type) else { return };
        let Some(rest) = left.checked_sub(accessor.count as u64) else { return };
        if component == Component::F32 {
            *left = rest;
            let wrong = self.count(accessor, component, |value| !value.is_finite());
            tell(findings, &format!("accessor {index}: components that are not finite"), wrong);
            if self.times.contains(&index) {
                let mut last = f64::NEG_INFINITY;
                let wrong = self.count(accessor, component, |time| std::mem::replace(&mut last, time) >= time);
                tell(findings, &format!("accessor {index}: times that do not ascend"), wrong);
                let wrong = self.count(accessor, component, |time| time < 0.0);
                tell(findings, &format!("accessor {index}: times below 0"), wrong);
            }
        } else if let Some(&joints) = joints {
            *left = rest;
            let wrong = self.count(accessor, component, |value| value >= joints as f64);
            tell(findings, &format!("accessor {index}: numbers of joints that its skin does not have"), wrong);
        }
    }

    /// How many components are wrong. What leaves the view was told before.
    fn count(&self, accessor: &Accessor, component: Component, mut is_wrong: impl FnMut(f64) -> bool) -> usize {
        let Some(size) = super::validate::element_size(&accessor.kind, component) else { return 0 };
        let view = accessor.buffer_view.map(|view| &self.document.buffer_views[view]);
        let stride = view.map_or(size, |view| view.stride(size));
        let element = |number: usize| element_at(self.bytes, accessor.byte_offset(), number.checked_mul(stride)?, size);
        let elements = (0..accessor.count).map_while(element);
        let components = elements.flat_map(|element| element.chunks_exact(component.size()));
        components.filter(|bytes| is_wrong(component.decode(bytes, false))).count()
    }
}

fn element_at(bytes: &[u8], offset: usize, from: usize, size: usize) -> Option<&[u8]> {
    let start = offset.checked_add(from)?;
    bytes.get(start..start.checked_add(size)?)
}

/// How many components of the sparse elements are not finite.
fn wrong_values(document: &Document, accessors: &Accessors, accessor: &Accessor, left: &mut u64) -> usize {
    let Some(sparse) = accessor.sparse.as_ref().filter(|_| accessor.component_type == FLOAT) else { return 0 };
    let Some(size) = super::validate::element_size(&accessor.kind, Component::F32) else { return 0 };
    let Some(rest) = left.checked_sub(sparse.count as u64) else { return 0 };
    *left = rest;
    let view = sparse.values.buffer_view;
    let Some(Ok(bytes)) = accessors.views().at_hand(view, left) else { return 0 };
    let stride = document.buffer_views[view].stride(size);
    let element = |number: usize| element_at(&bytes, sparse.values.byte_offset, number.checked_mul(stride)?, size);
    let components = (0..sparse.count).map_while(element).flat_map(|element| element.chunks_exact(4));
    components.filter(|bytes| !Component::F32.decode(bytes, false).is_finite()).count()
}

/// Whether the places of sparse elements ascend.
fn check_sparse(accessors: &Accessors, accessor: &Accessor, left: &mut u64) -> Result<(), LoadProblem> {
    let Some(sparse) = &accessor.sparse else { return Ok(()) };
    let is_at_hand = accessors.views().is_at_hand(sparse.indices.buffer_view);
    match left.checked_sub(sparse.count as u64).filter(|_| is_at_hand) {
        Some(rest) => {
            *left = rest;
            accessors.places(sparse, accessor.count).map(|_| ())
        }
        None => Ok(()),
    }
}
