//! Triangles of a polygon in space, by ear clipping (Meisters, "Polygons have ears", 1975) with exact signs.
//!
//! The polygon is projected along the dominant axis of its Newell normal; every decision is the exact sign of an
//! orientation of input coordinates (`robust`). A polygon of n corners gives n − 2 triangles of its own orientation, two less for
//! each further ring that it falls into where it touches itself (`touches`).
//! Corners are kept, one in the middle of a straight side too: dropping it would open the surface there, which is
//! why no general triangulation library is used; what encloses nothing, as equal corners in a row or a line to and fro, gives
//! triangles without area. A polygon that crosses itself still gives triangles whose signed
//! areas sum to its own; that it does is told. Ears are cut in rounds of every other corner, which keeps triangles short. Corners that
//! spoil an ear are found in a tree: some log n boxes a search where corners lie as on borders of surfaces, √n where they are
//! strewn, all n where they share a few places. So the searches of a file have an account ([`Triangulator`]); what is left of a
//! polygon when that is used up is cut in the order of its corners, which is told too. That keeps the time linear.

mod corner_tree;
mod rings;
mod touches;

use std::cell::Cell;

use glam::DVec3;
use robust::{Coord, orient2d};

use corner_tree::CornerTree;
use rings::Rings;

/// Boxes that the searches of a file may look at: so many (a second or two), and so many for each corner. Outlines of 10^5
/// corners take 70 to 300 each, those of 10^3 take 50.
const WORK: usize = 1 << 25;
const WORK_OF_CORNER: usize = 128;
/// How many boxes a corner at the place of an ear's corner counts for: its sides are compared with those of the ear.
const TOUCH: usize = 8;

/// A polygon in triangles.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Triangulation {
    /// Places in the list of corners; n − 2 triangles for three corners or more, two less for each part that only touches others.
    pub(crate) triangles: Vec<[usize; 3]>,
    /// Whether the polygon crosses itself as it is seen, or was too long to cut, so that some triangles may be turned over or lie
    /// on each other.
    pub(crate) crosses: bool,
}

/// Cuts the polygons of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangulator {
    /// Boxes that searches may still look at.
    work_left: usize,
}

impl Default for Triangulator {
    fn default() -> Self {
        Self { work_left: WORK }
    }
}

impl Triangulator {
    /// The triangles of a polygon.
    pub(crate) fn cut(&mut self, corners: &[DVec3]) -> Triangulation {
        self.work_left = self.work_left.saturating_add(WORK_OF_CORNER * corners.len());
        match corners.len() {
            0..=2 => Triangulation::default(),
            3 => Triangulation { triangles: vec![[0, 1, 2]], crosses: false },
            _ => EarClipping::new(project(corners), &mut self.work_left).run(),
        }
    }
}

/// How far numbers may be off that are written with six significant digits, as exporters do at the least: by up to
/// 5·10⁻⁶ ≤ 2^-17 of the largest one.
pub(crate) const SIX_DIGITS: f64 = 1.0 / 131_072.0;

/// Whether the corners lie in a plane as closely as written decimals can say it: where each is off by [`SIX_DIGITS`], so is its
/// distance from the plane.
pub(crate) fn is_planar(corners: &[DVec3]) -> bool {
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

/// As [`newell_normal`], each triangle of the fan by its size: as much area one way round as the other (a bow tie) is still seen.
fn sizes(corners: &[DVec3]) -> DVec3 {
    let from_first = |i: usize| corners[i] - corners[0];
    (1..corners.len().saturating_sub(1)).map(|i| from_first(i).cross(from_first(i + 1)).abs()).sum()
}

/// The corners seen along the dominant axis of the normal, counter-clockwise.
fn project(corners: &[DVec3]) -> Vec<Coord<f64>> {
    let normal = newell_normal(corners);
    let normal = if normal == DVec3::ZERO { sizes(corners) } else { normal };
    let axis = (0..3).fold(0, |best, axis| if normal[axis].abs() > normal[best].abs() { axis } else { best });
    let (mut first, mut second) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (first, second) = (second, first);
    }
    let seen = |corner: &DVec3| Coord { x: corner[first], y: corner[second] };
    let flat: Vec<_> = corners.iter().map(seen).collect();
    // The sign above is rounded. The lexicographically least corner of a simple polygon is convex: its turn is exact. Where the
    // polygon is there more than once, only the sign tells.
    let least = (0..flat.len()).fold(0, |least, i| {
        let before = (flat[i].x, flat[i].y) < (flat[least].x, flat[least].y);
        if before { i } else { least }
    });
    let n = flat.len();
    let is_alone = flat.iter().filter(|&&at| at == flat[least]).count() == 1;
    let turned = is_alone && orient2d(flat[(least + n - 1) % n], flat[least], flat[(least + 1) % n]) < 0.0;
    if turned { flat.into_iter().map(|at| Coord { x: at.y, y: at.x }).collect() } else { flat }
}

/// Rings of corners from which ears are cut.
struct EarClipping<'a> {
    rings: Rings,
    /// Corners that were not strictly convex at the start and are not cut. Only these can lie in an ear, and no others
    /// join them: cutting an ear makes the angles at its neighbours smaller.
    blockers: CornerTree,
    triangles: Vec<[usize; 3]>,
    /// Boxes that searches may still look at.
    work_left: &'a mut usize,
}

impl<'a> EarClipping<'a> {
    fn new(at: Vec<Coord<f64>>, work_left: &'a mut usize) -> Self {
        let mut triangles = Vec::with_capacity(at.len() - 2);
        let mut rings = Rings::new(at);
        rings.cut_folds(&mut triangles);
        let mut bent = rings.bent();
        // What turns left at all corners comes to no place twice, or encloses some of it twice.
        if !bent.is_empty() && touches::part(&mut rings) {
            rings.cut_folds(&mut triangles);
            bent = rings.bent();
        }
        let blockers = CornerTree::new(&rings.at, bent);
        Self { rings, blockers, triangles, work_left }
    }

    fn run(mut self) -> Triangulation {
        self.cut_ears();
        let crosses = self.cut_rest();
        Triangulation { triangles: self.triangles, crosses }
    }

    /// Tries every corner once, and again when a neighbour was cut: what is no diagonal of the polygon is none of a
    /// part of it, so nothing else can become an ear. In rounds, none of which cuts both of two neighbours: a round
    /// polygon then falls into few long triangles and many short ones, where cutting in a row would make all of them
    /// slivers from one corner, each beside all others.
    fn cut_ears(&mut self) {
        let mut candidates: Vec<usize> = (0..self.rings.at.len()).collect();
        // The last round in which a neighbour was cut.
        let mut touched = vec![0; self.rings.at.len()];
        for round in 1.. {
            let mut later = Vec::new();
            for tip in candidates {
                let is_free = self.rings.is_left(tip) && touched[tip] != round && *self.work_left > 0;
                if is_free && self.is_ear(tip) {
                    for neighbour in self.rings.neighbours(tip) {
                        if std::mem::replace(&mut touched[neighbour], round) != round {
                            later.push(neighbour);
                        }
                    }
                    self.cut(tip);
                }
            }
            if later.is_empty() {
                break;
            }
            candidates = later;
        }
    }

    /// All that is left of a polygon that crosses itself. Whether some of that is turned over.
    fn cut_rest(&mut self) -> bool {
        let mut crosses = false;
        for tip in 0..self.rings.at.len() {
            if self.rings.is_left(tip) {
                let [a, b, c] = self.cut(tip);
                crosses |= self.rings.turn(a, b, c) < 0.0;
            }
        }
        crosses || *self.work_left == 0
    }

    fn cut(&mut self, tip: usize) -> [usize; 3] {
        let [before, after] = self.rings.neighbours(tip);
        // The last triangle of a ring is cut at its first corner, whichever was come to.
        let is_last = self.rings.neighbours(before)[0] == after;
        let ear = self.rings.cut(if is_last { tip.min(before).min(after) } else { tip });
        self.triangles.push(ear);
        for corner in ear.into_iter().filter(|&corner| !self.rings.is_left(corner)) {
            self.blockers.remove(corner);
        }
        ear
    }

    /// Whether a corner can be cut: where the ring folds back, in a triangle, and where nothing lies in the triangle cut off.
    fn is_ear(&mut self, tip: usize) -> bool {
        let [before, after] = self.rings.neighbours(tip);
        let turn = self.rings.turn(before, tip, after);
        if turn <= 0.0 {
            return turn == 0.0 && self.rings.folds_back(tip);
        }
        if self.rings.neighbours(before)[0] == after {
            return true;
        }
        let ear = [before, tip, after];
        let work = Cell::new(0);
        let triangle = ear.map(|corner| self.rings.at[corner]);
        let is_blocked = self.blockers.any(triangle, &work, |blocker| self.blocks(blocker, ear, &work));
        *self.work_left = self.work_left.saturating_sub(work.get());
        !is_blocked
    }

    /// Whether a corner spoils an ear: it lies in the triangle or on its open side; or it touches the triangle from outside, at
    /// a corner or a side that is an edge of the polygon, and an edge of it leads inside (as where a hole is joined to its border).
    fn blocks(&self, blocker: usize, ear: [usize; 3], work: &Cell<usize>) -> bool {
        let turn = |a, b, c| self.rings.turn(a, b, c);
        let mut touched = None;
        for side in 0..3 {
            let [from, to] = [ear[side], ear[(side + 1) % 3]];
            let turn = turn(from, to, blocker);
            if turn < 0.0 {
                return false;
            }
            if turn == 0.0 && side < 2 {
                touched = Some([from, to]);
            }
        }
        if ear.contains(&blocker) {
            return false;
        }
        let neighbours = self.rings.neighbours(blocker);
        if let Some(place) = (0..3).find(|&place| self.rings.at[ear[place]] == self.rings.at[blocker]) {
            work.set(work.get() + TOUCH);
            let (corner, left, right) = (ear[place], ear[(place + 1) % 3], ear[(place + 2) % 3]);
            let leads_inside = |other| turn(corner, left, other) > 0.0 && turn(corner, other, right) > 0.0;
            return neighbours.into_iter().any(leads_inside);
        }
        touched.is_none_or(|[from, to]| neighbours.into_iter().any(|other| turn(from, to, other) > 0.0))
    }
}

#[cfg(test)]
mod tests;
