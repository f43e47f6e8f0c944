//! The hours of an object's cells: a quadtree a face, its leaves in Morton order, each with an interval of time.
//!
//! Adding a light walks two lists of leaves at once, the tree's and the light's cells, and divides where either does; four
//! parts that end up with the same interval become one cell again. A cell that is proved lit gets the time on both
//! bounds, one proved shadowed on none, any other on the upper one alone. So *every point* of a leaf is lit for at least its lower
//! and at most its upper time. Sums are of whole nanoseconds: exact.
//!
//! Cost: O(leaves of both) a light. Memory: 32 bytes a leaf, and there are no more than cells of the finest level.

use std::time::Duration;

use umbriel_geometry::{Facet, PlacedAnalytic, analytic::Occupied};
use umbriel_octree::{Face, Quadrant};

use crate::{
    bodies::{Bodies, Body},
    levels::{FaceSize, of_face},
    receivers::flat_corners,
    report::{Cell, Verdict},
    request::Detail,
};

/// For how long a cell is lit, nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Interval {
    lower: u64,
    upper: u64,
}

impl Interval {
    /// With a light that shines for so long. The sum of all lights fits (checked before the first).
    fn with(self, verdict: Verdict, nanoseconds: u64) -> Self {
        let sure = if verdict == Verdict::Lit { nanoseconds } else { 0 };
        let possible = if verdict == Verdict::Shadowed { 0 } else { nanoseconds };
        Self { lower: self.lower + sure, upper: self.upper + possible }
    }
}

#[derive(Clone, Copy, Debug)]
struct Leaf {
    place: Quadrant,
    hours: Interval,
}

/// A face of the object, and where its leaves end in the list of all; they begin where those of the face before end.
#[derive(Clone, Copy, Debug)]
struct FaceLeaves {
    face: u32,
    corner: u8,
    domain: Face,
    /// The finest level at which cells are kept apart.
    finest: u8,
    end: usize,
}

/// The hours of one object's cells.
#[derive(Clone, Debug, Default)]
pub(super) struct HourGrid {
    object: usize,
    faces: Vec<FaceLeaves>,
    leaves: Vec<Leaf>,
}

impl HourGrid {
    /// Every face with area as one leaf, never lit.
    pub(super) fn new(bodies: &Bodies, object: usize, detail: Detail) -> Self {
        let finest = |size: &FaceSize| of_face(detail, true, &bodies.bounds(object), size).interior;
        let of_facet = |facets: &umbriel_geometry::Facets, face: usize| {
            let is_triangle = matches!(facets.facet(face), Facet::Triangle(_));
            let corner = facets.base(face).corner;
            let size = FaceSize::of_flat(&flat_corners(facets, face, corner), is_triangle);
            let domain = if is_triangle { Face::Triangle } else { Face::Square };
            FaceLeaves { face: face as u32, corner, domain, finest: finest(&size), end: 0 }
        };
        let of_patch = |body: &PlacedAnalytic, face: usize| {
            let size = FaceSize::of_patch(&body.charts()[face], body.placement());
            FaceLeaves { face: face as u32, corner: 0, domain: Face::Square, finest: finest(&size), end: 0 }
        };
        let mut faces: Vec<FaceLeaves> = match bodies.get(object) {
            Body::Flat(facets) => {
                let with_area = (0..facets.len()).filter(|&face| facets.area(face).upper() > 0.0);
                with_area.map(|face| of_facet(facets, face)).collect()
            }
            Body::Analytic(body) => {
                let with_surface = (0..body.charts().len()).filter(|&face| is_surface(body, face, Quadrant::ROOT));
                with_surface.map(|face| of_patch(body, face)).collect()
            }
        };
        faces.iter_mut().enumerate().for_each(|(index, face)| face.end = index + 1);
        let leaves = vec![Leaf { place: Quadrant::ROOT, hours: Interval::default() }; faces.len()];
        Self { object, faces, leaves }
    }

    /// Adds the stored cells of a light, in the order of faces and Morton codes. Where none is stored, nothing is known.
    pub(super) fn fold(&mut self, bodies: &Bodies, mut cells: &[Cell], nanoseconds: u64) {
        let mut leaves = Vec::with_capacity(self.leaves.len());
        let mut begin = 0;
        for face in &mut self.faces {
            cells = &cells[cells.partition_point(|cell| cell.face < face.face)..];
            let (own, others) = cells.split_at(cells.partition_point(|cell| cell.face == face.face));
            cells = others;
            let has_area = |place: Quadrant| match bodies.get(self.object) {
                Body::Flat(_) => face.domain.has(place),
                Body::Analytic(body) => is_surface(body, face.face as usize, place),
            };
            let (old, finest) = (&self.leaves[begin..face.end], face.finest);
            let mut walk = Walk { old, cells: own, finest, nanoseconds, has_area: &has_area, leaves: &mut leaves };
            walk.visit(Quadrant::ROOT, None, None);
            begin = face.end;
            face.end = leaves.len();
        }
        leaves.shrink_to_fit();
        self.leaves = leaves;
    }
}

/// Whether a cell of a patch has surface in it.
fn is_surface(body: &PlacedAnalytic, face: usize, place: Quadrant) -> bool {
    body.charts()[face].occupied(place.low_corner(), place.edge()) != Occupied::Nowhere
}

/// Two lists of leaves of one face on the way to their sum; what is passed is dropped from their fronts.
struct Walk<'a> {
    old: &'a [Leaf],
    cells: &'a [Cell],
    finest: u8,
    nanoseconds: u64,
    has_area: &'a dyn Fn(Quadrant) -> bool,
    leaves: &'a mut Vec<Leaf>,
}

impl Walk<'_> {
    /// Adds all of `place`; `hours` and `verdict` are those of a leaf or cell that holds it.
    fn visit(&mut self, place: Quadrant, hours: Option<Interval>, verdict: Option<Verdict>) {
        let hours = hours.or_else(|| self.take_leaf(place));
        let verdict = verdict.or_else(|| self.take_cell(place));
        if let (Some(hours), Some(verdict)) = (hours, verdict) {
            let hours = hours.with(verdict, self.nanoseconds);
            return self.leaves.push(Leaf { place, hours });
        }
        let first = self.leaves.len();
        let mut parts = 0;
        for part in place.children().filter(|&part| (self.has_area)(part)) {
            parts += 1;
            self.visit(part, hours, verdict);
        }
        self.merge(place, first, parts);
    }

    /// The hours of the tree's leaf here; `None` where it is divided.
    fn take_leaf(&mut self, place: Quadrant) -> Option<Interval> {
        let (leaf, rest) = self.old.split_first()?;
        if leaf.place != place {
            return None;
        }
        self.old = rest;
        Some(leaf.hours)
    }

    /// The verdict of the light here; `None` where its cells are finer and still told apart.
    fn take_cell(&mut self, place: Quadrant) -> Option<Verdict> {
        let inside = |cell: &Cell| place_of(cell).is_some_and(|cell| place.contains(cell));
        match self.cells.first() {
            Some(cell) if inside(cell) => {
                if cell.level == place.level() {
                    self.cells = &self.cells[1..];
                    return Some(cell.verdict);
                }
                if place.level() < self.finest {
                    return None;
                }
                self.cells = &self.cells[self.cells.partition_point(inside)..];
                Some(Verdict::Undecided)
            }
            _ => Some(Verdict::Undecided),
        }
    }

    /// Makes the leaves from `first` on one, if they are the `parts` of `place` and agree.
    fn merge(&mut self, place: Quadrant, first: usize, parts: usize) {
        let leaves = &self.leaves[first..];
        let Some(hours) = leaves.first().map(|leaf| leaf.hours) else { return };
        let agree = |leaf: &Leaf| leaf.hours == hours && leaf.place.level() == place.level() + 1;
        if leaves.len() == parts && leaves.iter().all(agree) {
            self.leaves.truncate(first);
            self.leaves.push(Leaf { place, hours });
        }
    }
}

fn place_of(cell: &Cell) -> Option<Quadrant> {
    Quadrant::at(cell.level, [cell.i, cell.j])
}

/// A part of a face, and for how long each of its points is lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HourCell {
    /// Face of the object.
    pub face: u32,
    /// The corner of the face from which the parameters are counted; see [`Cell`].
    pub corner: u8,
    /// How often the face's parameter square was halved.
    pub level: u8,
    /// Along u.
    pub i: u32,
    /// Along v.
    pub j: u32,
    /// Every point is lit for this long at least.
    pub lower: Duration,
    /// No point is lit for longer than this.
    pub upper: Duration,
}

/// The hours of an object's cells, in the order of faces and, within a face, of Morton codes; none if they were not
/// asked for. They divide all faces with area.
#[derive(Clone, Debug, Default)]
pub struct HourCells {
    grid: HourGrid,
}

impl HourCells {
    pub(super) fn new(grid: HourGrid) -> Self {
        Self { grid }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.grid.leaves.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.grid.leaves.is_empty()
    }

    /// All of them, one after the other.
    pub fn iter(&self) -> impl Iterator<Item = HourCell> + '_ {
        let mut begin = 0;
        self.grid.faces.iter().flat_map(move |face| {
            let leaves = &self.grid.leaves[begin..face.end];
            begin = face.end;
            leaves.iter().map(|leaf| cell_of(face, leaf))
        })
    }
}

fn cell_of(face: &FaceLeaves, leaf: &Leaf) -> HourCell {
    let [i, j] = leaf.place.coordinates();
    HourCell {
        face: face.face,
        corner: face.corner,
        level: leaf.place.level(),
        i,
        j,
        lower: Duration::from_nanos(leaf.hours.lower),
        upper: Duration::from_nanos(leaf.hours.upper),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Lit, Shadowed, Undecided};

    const FINEST: u8 = 4;

    fn random_cells(chance: &mut impl FnMut() -> u32) -> Vec<Cell> {
        let (mut open, mut cells) = (vec![Quadrant::ROOT], Vec::new());
        while let Some(place) = open.pop() {
            match chance() % 8 {
                0..4 if place.level() < FINEST + 1 => {
                    open.extend(place.children().rev().filter(|&part| Face::Triangle.has(part)))
                }
                // Decided too deep to be stored.
                4 => {}
                _ => cells.push(Cell::new(0, 1, place, [Lit, Shadowed, Undecided][chance() as usize % 3])),
            }
        }
        cells
    }

    fn folded(lists: &[Vec<Cell>], order: [usize; 3]) -> Vec<Leaf> {
        let mut old = vec![Leaf { place: Quadrant::ROOT, hours: Interval::default() }];
        for index in order {
            let mut leaves = Vec::new();
            let has_area = |place| Face::Triangle.has(place);
            let (cells, nanoseconds) = (&lists[index][..], 1 << (8 * index));
            let mut walk =
                Walk { old: &old, cells, finest: FINEST, nanoseconds, has_area: &has_area, leaves: &mut leaves };
            walk.visit(Quadrant::ROOT, None, None);
            assert!(walk.old.is_empty() && walk.cells.is_empty(), "all are used");
            old = leaves;
        }
        old
    }

    /// Against the plain way: every cell of the finest grid looks up its verdict in every list.
    #[test]
    fn every_cell_has_the_sum_of_its_verdicts() {
        let mut seed = 5u64;
        let mut chance = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as u32
        };
        for _ in 0..200 {
            let lists: Vec<Vec<Cell>> = (0..3).map(|_| random_cells(&mut chance)).collect();
            let leaves = folded(&lists, [0, 1, 2]);
            let other = folded(&lists, [2, 0, 1]);
            assert!(
                leaves
                    .iter()
                    .map(|leaf| (leaf.place, leaf.hours))
                    .eq(other.iter().map(|leaf| (leaf.place, leaf.hours)))
            );
            let codes = (0..1u64 << (2 * FINEST)).filter_map(|code| Quadrant::from_bits(FINEST, code));
            for place in codes.filter(|&place| Face::Triangle.has(place)) {
                let expected = lists.iter().enumerate().fold(Interval::default(), |sum, (index, cells)| {
                    let holding = cells.iter().find(|cell| place_of(cell).is_some_and(|cell| cell.contains(place)));
                    sum.with(holding.map_or(Undecided, |cell| cell.verdict), 1 << (8 * index))
                });
                let holding: Vec<&Leaf> = leaves.iter().filter(|leaf| leaf.place.contains(place)).collect();
                assert!(
                    matches!(holding[..], [leaf] if leaf.hours == expected),
                    "{place:?}: {holding:?}, {expected:?}"
                );
            }
        }
    }
}
