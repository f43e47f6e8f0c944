//! The first tetrahedron of a hull: four points that are not in one plane, far apart where that is cheap to tell.
//!
//! Which points are taken only matters for speed. That they span space is decided exactly. O(n).

use glam::DVec3;

use super::surface::points;
use crate::{
    approx::Approx,
    decide::Decide,
    decisions::decide_by_pairs,
    dyadic::Dyadic,
    pair::Pair,
    predicates::{Target, side_value},
    ring::{Ring, Sign},
};

/// Why points have no convex hull with interior.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Flatness {
    /// No points at all.
    #[error("there is no point; four are needed that do not lie in one plane")]
    Nothing,
    /// One position.
    #[error("all points have one position; four are needed that do not lie in one plane")]
    Point,
    /// One line.
    #[error("all points lie on one line; four are needed that do not lie in one plane")]
    Line,
    /// One plane.
    #[error("all points lie in one plane; one is needed that does not")]
    Plane,
}

/// Four of the points, the last one behind the plane of the others. `positions` are distinct.
pub(super) fn tetrahedron(positions: &[DVec3]) -> Result<[u32; 4], Flatness> {
    let last = positions.len().checked_sub(1).ok_or(Flatness::Nothing)? as u32;
    if last == 0 {
        return Err(Flatness::Point);
    }
    let third = off_line(positions, 0, last).ok_or(Flatness::Line)?;
    let [a, b, c] = points(positions, [0, last, third]);
    let volume = |vertex: u32| side_value(&a, &b, &c, Target::Point(&points(positions, [vertex])[0])).value;
    // Volumes carry exact signs, so the largest one is zero only if all are.
    let (fourth, volume) = (0..=last)
        .map(|vertex| (vertex, volume(vertex)))
        .reduce(|best, next| if next.1.abs() > best.1.abs() { next } else { best })
        .unwrap_or((0, 0.0));
    match Sign::of(volume) {
        Sign::Zero => Err(Flatness::Plane),
        Sign::Negative => Ok([0, last, third, fourth]),
        Sign::Positive => Ok([last, 0, third, fourth]),
    }
}

/// A point off the line through two others: the farthest by floats, or the first that is off it exactly.
fn off_line(positions: &[DVec3], from: u32, to: u32) -> Option<u32> {
    let [a, b] = [from, to].map(|vertex| positions[vertex as usize]);
    let along = b - a;
    let distance = |vertex: u32| along.cross(positions[vertex as usize] - a).length_squared();
    let all = 0..positions.len() as u32;
    let is_off = |vertex: &u32| !are_collinear(a, b, positions[*vertex as usize]);
    let farthest = all.clone().reduce(|best, next| if distance(next) > distance(best) { next } else { best });
    farthest.filter(is_off).or_else(|| all.clone().find(is_off))
}

/// Whether three points lie on one line. Exact.
pub(super) fn are_collinear(a: DVec3, b: DVec3, c: DVec3) -> bool {
    normal_signs(a, b, c) == [Sign::Zero; 3]
}

/// The signs of the normal (b − a) × (c − a), axis by axis. Exact.
pub(super) fn normal_signs(a: DVec3, b: DVec3, c: DVec3) -> [Sign; 3] {
    let sign = |i: usize, j: usize| {
        let exact = || minor::<Dyadic>([a, b, c], i, j).sign();
        decide_by_pairs(minor::<Approx>([a, b, c], i, j).decide(), || minor::<Pair>([a, b, c], i, j).decide(), exact)
    };
    [sign(1, 2), sign(2, 0), sign(0, 1)]
}

/// The part of the normal that differences along axes `i` and `j` make.
fn minor<T: Decide>([a, b, c]: [DVec3; 3], i: usize, j: usize) -> T {
    let difference = |p: DVec3, k: usize| T::number(p[k]) - T::number(a[k]);
    difference(b, i) * difference(c, j) - difference(b, j) * difference(c, i)
}
