//! Closed surfaces that meet themselves nowhere: each bounds a solid, of which half of the faces tell all that it hides.
//!
//! A component of a mesh is *embedded* if two triangles meet at each of its edges, which run along it in opposite directions, and no others of its triangles have more in common
//! than a corner. It is told so by three tests. Who uses each edge is looked up. Round every corner the triangles, seen along some direction, lie side by side and go round once, so
//! there they have in common what they share. Triangles without a common corner are held apart by a plane; a tree of boxes finds those that are near each other. Then the
//! surface is wound round a point once or not at all (NUMERICS.md, "Solids"), always the same way, which the sign of its volume tells.
//!
//! Guarantee: what is called embedded is; where floats cannot tell, or very many boxes of triangles have points in common, it is not called so. Cost: about a microsecond a triangle, once for all lights.

use std::{
    ops::ControlFlow,
    sync::atomic::{AtomicBool, AtomicUsize, Ordering},
};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Facets, Sign, predicates::rows_filter};

use crate::solids::triangles_of;

/// Corners that a thread takes at a time, at least.
const AT_A_TIME: usize = 256;

/// Parts of a tree that threads share.
const PARTS: usize = 256;

/// Pairs of triangles with boxes that meet up to which they are asked, a triangle (smooth meshes have ten or so), and in any case.
const PAIRS_A_TRIANGLE: usize = 64;
const PAIRS: usize = 1 << 16;

/// So often a direction that sees all triangles round a corner from one side is mended before it is given up.
const MENDED: usize = 16;

/// The solids that the components of a body bound.
#[derive(Debug)]
pub(crate) struct Embedded {
    /// Which way the right-hand normal of each face looks: positive out of its solid, negative into it, zero where its component is not known to bound one.
    pub(crate) outward: Vec<Sign>,
    /// Whether all components bound solids, with boxes that have no point in common, and all fronts look outward.
    pub(crate) are_apart: bool,
}

impl Embedded {
    /// `None` where there are none. `tree` is over the boxes of the faces, and asked for only where it is needed.
    pub(crate) fn of<'a>(facets: &Facets, tree: impl FnOnce() -> &'a BoxTree) -> Option<Self> {
        let triangles = triangles_of(facets)?;
        let surface = Surface::of(facets, triangles);
        surface.tell_edges();
        surface.tell_corners();
        if !(0..triangles.len()).any(|face| surface.may_be(face)) {
            return None;
        }
        surface.tell_pairs(tree());
        let (signs, front) = (surface.signs(), front(facets));
        let outward = (0..triangles.len()).map(|face| signs[surface.component(face)]).collect();
        let are_apart = signs.iter().all(|&sign| sign == front) && surface.boxes_are_apart();
        signs.iter().any(|&sign| sign != Sign::Zero).then_some(Self { outward, are_apart })
    }
}

/// Which way faces turn whose fronts are seen: counter-clockwise, which is positive, unless their placement mirrors.
pub(crate) fn front(facets: &Facets) -> Sign {
    if facets.is_mirrored() { Sign::Negative } else { Sign::Positive }
}

/// The triangles of a mesh, and what is known of its components.
struct Surface<'a> {
    facets: &'a Facets,
    positions: &'a [DVec3],
    /// Corners, as points that are one where their positions are.
    triangles: Vec<[u32; 3]>,
    /// The component of each triangle.
    component_of: &'a [u32],
    /// Of each component whether it may be embedded.
    may_be: Vec<AtomicBool>,
}

impl<'a> Surface<'a> {
    fn of(facets: &'a Facets, triangles: &'a [[u32; 3]]) -> Self {
        let topology = facets.topology();
        let may_be = topology.components.iter().map(|component| AtomicBool::new(component.is_closed())).collect();
        let triangles = triangles.iter().map(|corners| corners.map(|corner| facets.first_at(corner))).collect();
        Self { facets, positions: facets.positions(), triangles, component_of: &topology.component_of, may_be }
    }

    fn component(&self, face: usize) -> usize {
        self.component_of[face] as usize
    }

    fn may_be(&self, face: usize) -> bool {
        self.may_be[self.component(face)].load(Ordering::Relaxed)
    }

    /// Its component is not embedded.
    fn rule_out(&self, face: usize) {
        self.may_be[self.component(face)].store(false, Ordering::Relaxed);
    }

    fn corners(&self, face: usize) -> [DVec3; 3] {
        self.triangles[face].map(|corner| self.positions[corner as usize])
    }

    /// At each edge two triangles meet.
    fn tell_edges(&self) {
        for face in 0..self.triangles.len() {
            if (0..3).any(|side| self.facets.across(face, side).is_none()) {
                self.rule_out(face);
            }
        }
    }

    /// Round each corner the triangles lie side by side.
    fn tell_corners(&self) {
        let (faces, ends) = self.faces_round_points();
        (0..ends.len()).into_par_iter().with_min_len(AT_A_TIME).for_each_init(Vec::new, |sides, point| {
            let first = if point == 0 { 0 } else { ends[point - 1] as usize };
            let round = &faces[first..ends[point] as usize];
            if !round.iter().any(|&face| self.may_be(face as usize)) {
                return;
            }
            let apex = self.positions[point];
            sides.clear();
            sides.extend(round.iter().map(|&face| self.sides_from(face as usize, point as u32, apex)));
            if !is_fan(sides) {
                round.iter().for_each(|&face| self.rule_out(face as usize));
            }
        });
    }

    /// The faces at each point, and where those of each end.
    fn faces_round_points(&self) -> (Vec<u32>, Vec<u32>) {
        let mut ends = vec![0u32; self.positions.len() + 1];
        let corners = || (0..self.triangles.len()).flat_map(|face| self.triangles[face].map(|point| (face, point)));
        corners().for_each(|(_, point)| ends[point as usize + 1] += 1);
        for point in 1..ends.len() {
            ends[point] += ends[point - 1];
        }
        let mut faces = vec![0; ends[ends.len() - 1] as usize];
        corners().for_each(|(face, point)| {
            // Each start moves to its end.
            let place = &mut ends[point as usize];
            faces[*place as usize] = face as u32;
            *place += 1;
        });
        ends.pop();
        (faces, ends)
    }

    /// The two sides of a face that begin at one of its corners, which is at `apex`.
    fn sides_from(&self, face: usize, point: u32, apex: DVec3) -> [DVec3; 2] {
        let own = self.triangles[face].iter().position(|&corner| corner == point).unwrap_or_default();
        let corners = self.corners(face);
        [corners[(own + 1) % 3] - apex, corners[(own + 2) % 3] - apex]
    }

    /// Triangles of a component without a common corner are apart. All are ruled out where too many would have to be asked.
    fn tell_pairs(&self, tree: &BoxTree) {
        let (most, asked) = (PAIRS + PAIRS_A_TRIANGLE * self.triangles.len(), AtomicUsize::new(0));
        let _ = tree.meeting_parts(PARTS).into_par_iter().try_for_each(|part| {
            tree.for_each_meeting_pair(part, |face, other| {
                let [face, other] = [face as usize, other as usize];
                let is_asked = self.component(face) == self.component(other) && self.may_be(face);
                if is_asked && !self.share_corners(face, other) && !are_apart(&self.corners(face), &self.corners(other))
                {
                    self.rule_out(face);
                }
                let are_many = asked.fetch_add(1, Ordering::Relaxed) >= most;
                if are_many { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
        });
        if asked.into_inner() > most {
            self.may_be.iter().for_each(|may_be| may_be.store(false, Ordering::Relaxed));
        }
    }

    fn share_corners(&self, face: usize, other: usize) -> bool {
        let [corners, others] = [face, other].map(|face| &self.triangles[face]);
        corners.iter().any(|corner| others.contains(corner))
    }

    /// Whether the boxes of components have no point in common.
    fn boxes_are_apart(&self) -> bool {
        let mut boxes = vec![Aabb::EMPTY; self.may_be.len()];
        for face in 0..self.triangles.len() {
            let bounds = &mut boxes[self.component(face)];
            *bounds = bounds.union(self.facets.facet_bounds(face));
        }
        let tree = BoxTree::build(&boxes);
        boxes.iter().all(|bounds| is_alone(&tree, bounds))
    }

    /// Which way the normals of each component look: by its volume; zero where that is not known, and of what is not embedded.
    fn signs(&self) -> Vec<Sign> {
        let mut volumes = vec![[0.0; 2]; self.may_be.len()];
        let mut apices = vec![None; self.may_be.len()];
        for face in (0..self.triangles.len()).filter(|&face| self.may_be(face)) {
            let ([a, b, c], component) = (self.corners(face), self.component(face));
            let apex = *apices[component].get_or_insert(a);
            let part = rows_filter(a - apex, b - apex, c - apex);
            let [volume, error] = &mut volumes[component];
            // Each sum is off by half an ulp of itself.
            *volume += part.value;
            *error += part.error + volume.abs() * f64::EPSILON;
        }
        let sign = |&[volume, error]: &[f64; 2]| if volume.abs() > 2.0 * error { Sign::of(volume) } else { Sign::Zero };
        volumes.iter().map(sign).collect()
    }
}

/// Whether a box, which is one of the tree's, has no point in common with any other of them.
pub(crate) fn is_alone(tree: &BoxTree, bounds: &Aabb) -> bool {
    let mut met = 0;
    let found = tree.for_each_where(
        |other| other.meets(bounds),
        |_| {
            met += 1;
            if met > 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        },
    );
    found.is_continue()
}

/// Whether triangles with a common corner, of which these are the sides that begin there, lie side by side round it and go round once: seen along some direction all turn the same way, and one
/// ray from the corner passes beside all but one. Their edges meet in pairs.
fn is_fan(sides: &[[DVec3; 2]]) -> bool {
    let Some(along) = seen_from(sides) else { return false };
    let turns = |a: DVec3, b: DVec3| rows_filter(a, b, along);
    let [a, b] = sides[0];
    let ray = without_traces(a.normalize_or_zero() + b.normalize_or_zero());
    let mut met = 0;
    for &[a, b] in sides {
        let turn = turns(a, b);
        if turn.value <= turn.error {
            return false;
        }
        let [from, to] = [turns(a, ray), turns(ray, b)];
        met += usize::from(from.value >= -from.error && to.value >= -to.error);
    }
    met == 1
}

/// A direction that looks along the normals of all of some triangles, or nearly; `None` if none is found.
fn seen_from(sides: &[[DVec3; 2]]) -> Option<DVec3> {
    let normal = |[a, b]: &[DVec3; 2]| a.cross(*b).normalize_or_zero();
    let mut along: DVec3 = sides.iter().map(normal).sum();
    // A perceptron: what is seen worst moves the direction (Rosenblatt 1958).
    for _ in 0..MENDED {
        let worst = sides.iter().map(normal).min_by(|a, b| a.dot(along).total_cmp(&b.dot(along)))?;
        if worst.dot(along) > 0.0 {
            return Some(without_traces(along));
        }
        along += worst;
    }
    None
}

/// A direction without coordinates so small that products with them, and those of filters, could underflow.
fn without_traces(direction: DVec3) -> DVec3 {
    const TRACE: f64 = 1.0 / (1u128 << 100) as f64;
    let is_kept = direction.abs().cmpge(DVec3::splat(TRACE));
    DVec3::select(is_kept, direction, DVec3::ZERO)
}

/// Whether a plane holds two triangles apart: one parallel to a face, along a side and upright on it, or parallel to a side of each.
fn are_apart(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let origin = a[0];
    let ([p, q], [r, s, t]) = ([a[1] - origin, a[2] - origin], b.map(|corner| corner - origin));
    let reach = [p, q, r, s, t].into_iter().fold(DVec3::ZERO, |reach, point| reach.max(point.abs())).max_element();
    let separates = |axis: DVec3| {
        let [of_p, of_q, of_r, of_s, of_t] = [p, q, r, s, t].map(|point| axis.dot(point));
        let (low, high) = (of_p.min(of_q).min(0.0), of_p.max(of_q).max(0.0));
        let (least, most) = (of_r.min(of_s).min(of_t), of_r.max(of_s).max(of_t));
        // Each is off by less than four roundings: of its difference and of a sum of three products.
        let margin = 8.0 * f64::EPSILON * reach * axis.abs().element_sum() + f64::MIN_POSITIVE;
        (least - high > margin) | (low - most > margin)
    };
    let (sides, others) = ([p, q - p, q], [s - r, t - s, t - r]);
    let (normal, other) = (p.cross(q), others[0].cross(others[1]));
    separates(normal)
        || separates(other)
        || sides.iter().any(|&side| separates(side.cross(normal)))
        || others.iter().any(|&side| separates(side.cross(other)))
        || sides.iter().any(|side| others.iter().any(|&other| separates(side.cross(other))))
}

#[cfg(test)]
mod tests;
