//! Triangles of a polygon in space, by ear clipping (Meisters, "Polygons have ears", 1975) with exact signs.
//!
//! The polygon is projected along the dominant axis of its Newell normal; every decision is the exact sign of an
//! orientation of input coordinates (`robust`). A polygon of n corners gives n − 2 triangles of its own orientation.
//! Every corner is kept, one in the middle of a straight side too: dropping it would open the surface there, which is
//! why no general triangulation library is used. A polygon that crosses itself still gives n − 2 triangles whose signed
//! areas sum to its own. Ears are cut in rounds of every other corner, which keeps triangles short. Corners that spoil an ear
//! are found in a tree: O(n log n) in practice.

mod corner_tree;

use glam::DVec3;
use robust::{Coord, orient2d};

use corner_tree::CornerTree;

/// The triangles of the polygon, as places in `corners` (three at least).
pub(crate) fn triangulate(corners: &[DVec3]) -> Vec<[usize; 3]> {
    match corners.len() {
        0..=2 => Vec::new(),
        3 => vec![[0, 1, 2]],
        _ => EarClipping::new(project(corners)).run(),
    }
}

/// Whether the corners lie in a plane as closely as written decimals can say it.
///
/// Exporters write six significant digits at the least: every coordinate is then off by up to 5·10⁻⁶ ≤ 2^-17 of the
/// largest one, and so is the distance from the plane.
pub(crate) fn is_planar(corners: &[DVec3]) -> bool {
    const SIX_DIGITS: f64 = 1.0 / 131_072.0;
    let normal = newell_normal(corners);
    let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let largest = corners.iter().map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
    let bound = SIX_DIGITS * largest * normal.length();
    corners.len() < 4 || corners.iter().all(|&corner| normal.dot(corner - centre).abs() <= bound)
}

/// Twice the vector area, taken about the first corner (so that far from the origin nothing cancels).
fn newell_normal(corners: &[DVec3]) -> DVec3 {
    let from_first = |i: usize| corners[i] - corners[0];
    (1..corners.len().saturating_sub(1)).map(|i| from_first(i).cross(from_first(i + 1))).sum()
}

/// The corners seen along the dominant axis of the normal, counter-clockwise.
fn project(corners: &[DVec3]) -> Vec<Coord<f64>> {
    let normal = newell_normal(corners);
    let axis = (0..3).fold(0, |best, axis| if normal[axis].abs() > normal[best].abs() { axis } else { best });
    let (mut first, mut second) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (first, second) = (second, first);
    }
    let seen = |corner: &DVec3| Coord { x: corner[first], y: corner[second] };
    let flat: Vec<_> = corners.iter().map(seen).collect();
    // The sign above is rounded. The lexicographically least corner of a simple polygon is convex: its turn is exact.
    let least = (0..flat.len()).fold(0, |least, i| {
        let before = (flat[i].x, flat[i].y) < (flat[least].x, flat[least].y);
        if before { i } else { least }
    });
    let n = flat.len();
    let turned = orient2d(flat[(least + n - 1) % n], flat[least], flat[(least + 1) % n]) < 0.0;
    if turned { flat.into_iter().map(|at| Coord { x: at.y, y: at.x }).collect() } else { flat }
}

/// A ring of corners from which ears are cut.
struct EarClipping {
    at: Vec<Coord<f64>>,
    next: Vec<usize>,
    previous: Vec<usize>,
    cut: Vec<bool>,
    /// Corners that were not strictly convex at the start and are not cut. Only these can lie in an ear, and no others
    /// join them: cutting an ear makes the angles at its neighbours smaller.
    blockers: CornerTree,
}

impl EarClipping {
    fn new(at: Vec<Coord<f64>>) -> Self {
        let n = at.len();
        let next: Vec<_> = (0..n).map(|i| (i + 1) % n).collect();
        let previous: Vec<_> = (0..n).map(|i| (i + n - 1) % n).collect();
        let convex = |i: usize| orient2d(at[previous[i]], at[i], at[next[i]]) > 0.0;
        let blockers = CornerTree::new(&at, (0..n).filter(|&i| !convex(i)).collect());
        Self { at, next, previous, cut: vec![false; n], blockers }
    }

    /// Tries every corner once, and again when a neighbour was cut: what is no diagonal of the polygon is none of a
    /// part of it, so nothing else can become an ear. In rounds, none of which cuts both of two neighbours: a round
    /// polygon then falls into few long triangles and many short ones, where cutting in a row would make all of them
    /// slivers from one corner, each beside all others.
    fn run(mut self) -> Vec<[usize; 3]> {
        let n = self.at.len();
        let mut triangles = Vec::with_capacity(n - 2);
        let mut candidates: Vec<usize> = (0..n).collect();
        // The last round in which a neighbour was cut.
        let mut touched = vec![0; n];
        for round in 1.. {
            let mut later = Vec::new();
            for tip in candidates {
                let is_free = !self.cut[tip] && touched[tip] != round;
                if triangles.len() < n - 3 && is_free && self.is_ear(tip) {
                    for neighbour in [self.previous[tip], self.next[tip]] {
                        if std::mem::replace(&mut touched[neighbour], round) != round {
                            later.push(neighbour);
                        }
                    }
                    triangles.push(self.cut_ear(tip));
                }
            }
            if later.is_empty() {
                break;
            }
            candidates = later;
        }
        self.cut_rest(&mut triangles);
        triangles
    }

    /// The last triangle; all that is left of a polygon that touches or crosses itself.
    fn cut_rest(&mut self, triangles: &mut Vec<[usize; 3]>) {
        for tip in 0..self.at.len() {
            if triangles.len() < self.at.len() - 2 && !self.cut[tip] {
                triangles.push(self.cut_ear(tip));
            }
        }
    }

    fn cut_ear(&mut self, tip: usize) -> [usize; 3] {
        let (before, after) = (self.previous[tip], self.next[tip]);
        self.next[before] = after;
        self.previous[after] = before;
        self.cut[tip] = true;
        self.blockers.remove(tip);
        [before, tip, after]
    }

    fn is_ear(&self, tip: usize) -> bool {
        let ear = [self.previous[tip], tip, self.next[tip]];
        if self.turn(ear[0], ear[1], ear[2]) <= 0.0 {
            return false;
        }
        !self.blockers.any(ear.map(|corner| self.at[corner]), |blocker| self.blocks(blocker, ear))
    }

    fn turn(&self, a: usize, b: usize, c: usize) -> f64 {
        orient2d(self.at[a], self.at[b], self.at[c])
    }

    /// Whether a corner spoils an ear: it lies in the closed triangle, or, at the place of one of the triangle's
    /// corners, an edge of it leads inside (as where a hole is joined to its border).
    fn blocks(&self, blocker: usize, ear: [usize; 3]) -> bool {
        if ear.contains(&blocker) {
            return false;
        }
        if let Some(place) = (0..3).find(|&place| self.at[ear[place]] == self.at[blocker]) {
            let (corner, left, right) = (ear[place], ear[(place + 1) % 3], ear[(place + 2) % 3]);
            return [self.previous[blocker], self.next[blocker]]
                .into_iter()
                .any(|other| self.turn(corner, left, other) > 0.0 && self.turn(corner, other, right) > 0.0);
        }
        (0..3).all(|place| self.turn(ear[place], ear[(place + 1) % 3], blocker) >= 0.0)
    }
}

#[cfg(test)]
mod tests;
