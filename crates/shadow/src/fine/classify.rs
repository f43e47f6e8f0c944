//! The rules that prove a cell lit or shadowed (design: "What an answer means", "Cells").
//!
//! *Lit*: no blocker is left over the closed cell. *Shadowed*: one blocker covers it; or the winding of all polygons
//! together stays at least one: let W be the number of polygons (each turned counter-clockwise in the projection, and
//! cut off where it is not strictly nearer) that hold a probe point inside, and D the multiplicity of those border edges
//! and cuts that cross the cell and do not have the probe outside. On the straight way from the probe to any other
//! point of the cell each border is crossed at most once, and only those counted in D can take a polygon away. So
//! W − D ≥ 1 proves that polygons cover the cell. Edges inside a sheet cancel and are no borders. (A sharper form of
//! the cancelling rule; NUMERICS.md, "Winding".)
//!
//! A triangle with holes is not part of that winding. Where all texels are opaque that the ways from a cell can meet, it covers
//! the cell alone or not; where all are clear it is not in the way.

use umbriel_geometry::cut_out::{FaceCutOut, Opacity};

use super::{
    analytic_blocker::{AnalyticBlocker, Influence},
    borders::{Border, DirectedEdge, mark_borders},
    field::{Field, Weights},
    outline::ParamBox,
    pattern::POINTS,
    polygon_blocker::{FacetId, NEARER, PolygonBlocker},
};
use crate::{effort, report::Verdict};

/// Everything that may block some point of a receiver.
pub(crate) struct Blockers<'a, const N: usize> {
    pub(crate) polygons: Vec<PolygonBlocker<N>>,
    pub(crate) bodies: Vec<AnalyticBlocker<'a, N>>,
    /// Of the polygons that have holes.
    holes: Vec<FaceCutOut<'a>>,
}

/// A blocker that is still in question over a cell; what is known of it holds for all parts of the cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    index: u32,
    is_body: bool,
    /// Bit f: function f of the polygon is proved on the blocking side over the whole cell.
    known: u8,
}

/// Where an entry's blocker stands in [`Blockers`].
enum Blocker {
    Polygon(usize),
    Body(usize),
}

impl Entry {
    fn blocker(self) -> Blocker {
        if self.is_body { Blocker::Body(self.index as usize) } else { Blocker::Polygon(self.index as usize) }
    }
}

/// A cell as the hull of its corners, given by weights of the receiver's corners.
pub(crate) struct Hull<const N: usize> {
    corners: [Weights<N>; N],
    count: usize,
    pub(crate) center: Weights<N>,
    /// Bounds on the parameters, on a flat face.
    pub(crate) parameters: Option<ParamBox>,
}

impl<const N: usize> Hull<N> {
    /// Of N corners at most.
    #[inline]
    pub(crate) fn new(corners: impl IntoIterator<Item = Weights<N>>, center: Weights<N>) -> Self {
        let mut hull = Self { corners: [[0.0; N]; N], count: 0, center, parameters: None };
        for (place, corner) in hull.corners.iter_mut().zip(corners) {
            *place = corner;
            hull.count += 1;
        }
        hull
    }

    pub(crate) fn corners(&self) -> &[Weights<N>] {
        &self.corners[..self.count]
    }
}

impl<'a, const N: usize> Blockers<'a, N> {
    /// Marks the border edges among all edges of the polygons.
    pub(crate) fn new(
        mut polygons: Vec<PolygonBlocker<N>>,
        bodies: Vec<AnalyticBlocker<'a, N>>,
        holes: Vec<FaceCutOut<'a>>,
        edges: Vec<DirectedEdge>,
    ) -> Self {
        mark_borders(&mut polygons, edges);
        Self { polygons, bodies, holes }
    }

    /// Nothing in the way.
    pub(crate) fn none() -> Self {
        Self { polygons: Vec::new(), bodies: Vec::new(), holes: Vec::new() }
    }

    /// Adds those of other components.
    pub(crate) fn append(&mut self, mut others: Self) {
        // Mostly there is one component: its polygons, 640 bytes each, stay where they are.
        if self.polygons.is_empty() && self.bodies.is_empty() {
            *self = others;
            return;
        }
        let (first, first_hole) = (self.polygons.len() as u32, self.holes.len() as u32);
        for polygon in &mut others.polygons {
            polygon.sheet += first;
            polygon.holes = polygon.holes.map(|holes| holes + first_hole);
        }
        self.polygons.append(&mut others.polygons);
        self.bodies.append(&mut others.bodies);
        self.holes.append(&mut others.holes);
    }

    /// All blockers as entries.
    pub(crate) fn entries(&self) -> Vec<Entry> {
        let polygons = (0..self.polygons.len() as u32).map(|index| Entry { index, is_body: false, known: 0 });
        let bodies = (0..self.bodies.len() as u32).map(|index| Entry { index, is_body: true, known: 0 });
        polygons.chain(bodies).collect()
    }

    /// What it costs to hold these against a cell.
    pub(crate) fn work(&self, entries: &[Entry]) -> u64 {
        let of_entry = |&entry: &Entry| match entry.blocker() {
            Blocker::Body(index) => self.bodies[index].cost(),
            Blocker::Polygon(index) if self.polygons[index].holes.is_some() => effort::CUT_OUT,
            Blocker::Polygon(_) => 1,
        };
        let are_alike = self.bodies.is_empty() && self.holes.is_empty();
        if are_alike { entries.len() as u64 } else { entries.iter().map(of_entry).sum() }
    }

    /// What it costs to ask floats of these at the points of a cell ([`POINTS`](super::pattern::POINTS)) beside holding them against it: of facets hardly anything.
    pub(crate) fn work_of_points(&self, entries: &[Entry]) -> u64 {
        let of_entry = |&entry: &Entry| match entry.blocker() {
            Blocker::Body(index) => effort::BODIES_AT_POINTS * self.bodies[index].cost(),
            Blocker::Polygon(_) => 0,
        };
        if self.bodies.is_empty() { 0 } else { entries.iter().map(of_entry).sum() }
    }

    /// What an entry stands for: a body is its first facet.
    pub(crate) fn id(&self, entry: Entry) -> FacetId {
        match entry.blocker() {
            Blocker::Polygon(index) => self.polygons[index].id,
            Blocker::Body(index) => FacetId { object: self.bodies[index].object, facet: 0 },
        }
    }

    /// Whether these are proved to cover a cell.
    pub(crate) fn cover(&self, hull: &Hull<N>) -> bool {
        !self.polygons.is_empty() && self.classify(hull, &self.entries(), &mut Vec::new()) == Verdict::Shadowed
    }

    /// What is proved of a cell, given the blockers in question over a cell that holds it. Those still in question are
    /// pushed on `left`; that list is complete when the answer is `Undecided`.
    pub(crate) fn classify(&self, hull: &Hull<N>, parent: &[Entry], left: &mut Vec<Entry>) -> Verdict {
        let first = left.len();
        for &entry in parent {
            match self.influence(entry, hull) {
                (Influence::None, _) => {}
                (Influence::All, _) => return Verdict::Shadowed,
                (Influence::Unknown, entry) => left.push(entry),
            }
        }
        if left.len() == first {
            Verdict::Lit
        } else if self.winding_covers(hull, &left[first..]) {
            Verdict::Shadowed
        } else {
            Verdict::Undecided
        }
    }

    /// Whether a blocker blocks the point with these (rounded) weights; `None` where the bounds cannot tell.
    pub(crate) fn blocks(&self, entry: Entry, weights: &Weights<N>) -> Option<bool> {
        match entry.blocker() {
            Blocker::Polygon(index) => {
                let polygon = &self.polygons[index];
                match (polygon.blocks(weights), polygon.holes) {
                    (Some(true), Some(holes)) => self.holes[holes as usize].is_opaque_on(polygon.way(weights)),
                    (blocks, _) => blocks,
                }
            }
            Blocker::Body(index) => self.bodies[index].blocks(weights),
        }
    }

    /// The likely answer, for estimates.
    pub(crate) fn probably_blocks(&self, entry: Entry, weights: &Weights<N>) -> bool {
        match entry.blocker() {
            Blocker::Polygon(index) => {
                let polygon = &self.polygons[index];
                let is_opaque = |holes: u32| self.holes[holes as usize].probably_opaque_on(polygon.likely_way(weights));
                polygon.probably_blocks(weights) && polygon.holes.is_none_or(is_opaque)
            }
            Blocker::Body(index) => self.bodies[index].probably_blocks(weights),
        }
    }

    /// Those of some points of a flat face, in a cell that an entry is known for, that it likely blocks, a bit each; only `open` ones are looked at. `weights` are those
    /// of a point.
    pub(crate) fn probably_blocked(
        &self,
        entry: Entry,
        (points, open): (&[[f64; POINTS]; 2], u16),
        weights: impl Fn(usize) -> Weights<N>,
    ) -> u16 {
        let those_of = |points: u16, is_blocked: &dyn Fn(usize) -> bool| -> u16 {
            (0..POINTS).filter(|&k| points >> k & 1 == 1 && is_blocked(k)).map(|k| 1 << k).sum()
        };
        let Blocker::Polygon(index) = entry.blocker() else {
            return those_of(open, &|k| self.probably_blocks(entry, &weights(k)));
        };
        let polygon = &self.polygons[index];
        let outlined = polygon.probably_blocked(entry.known, points);
        let Some(holes) = polygon.holes else { return outlined };
        let holes = &self.holes[holes as usize];
        those_of(outlined & open, &|k| holes.probably_opaque_on(polygon.likely_way(&weights(k))))
    }

    fn influence(&self, entry: Entry, hull: &Hull<N>) -> (Influence, Entry) {
        if entry.is_body {
            return (self.bodies[entry.index as usize].influence(hull.corners()), entry);
        }
        let polygon = &self.polygons[entry.index as usize];
        if hull.parameters.as_ref().is_some_and(|parameters| parameters.misses(polygon.reach())) {
            return (Influence::None, entry);
        }
        if polygon.edge_on {
            return (edge_on_influence(polygon, hull), entry);
        }
        let mut known = entry.known;
        let mut covers = true;
        for index in polygon.open_functions(entry.known) {
            let range = polygon.function(index).range(hull.corners());
            if range.max < 0.0 || (index == NEARER && range.max <= 0.0) {
                return (Influence::None, entry);
            }
            if range.min > 0.0 || (index != NEARER && range.min >= 0.0) {
                known |= 1 << index;
            } else {
                covers = false;
            }
        }
        let influence = match (polygon.holes, covers) {
            (None, true) => Influence::All,
            (None, false) => Influence::Unknown,
            (Some(holes), _) => {
                let ways = hull.corners().iter().map(|weights| polygon.way(weights));
                match self.holes[holes as usize].opacity_over(ways) {
                    Opacity::Clear => Influence::None,
                    Opacity::Opaque if covers => Influence::All,
                    Opacity::Opaque | Opacity::Mixed => Influence::Unknown,
                }
            }
        };
        (influence, Entry { known, ..entry })
    }

    /// Whether the winding of some sheet at some probe survives all its borders that cross the cell.
    fn winding_covers(&self, hull: &Hull<N>, entries: &[Entry]) -> bool {
        let Some(crossing) = self.crossing_borders(hull, entries) else { return false };
        let mut balance = Vec::new();
        std::iter::once(&hull.center).chain(hull.corners()).any(|probe| {
            let holding = self.winding(entries).filter(|(known, polygon)| polygon.holds(*known, probe));
            balance.clear();
            balance.extend(holding.map(|(_, polygon)| (polygon.sheet, 1)));
            if balance.is_empty() {
                return false;
            }
            for Crossing { function, lost, sheet } in &crossing {
                let value = function.at(probe);
                if -value.value <= value.error {
                    balance.push((*sheet, -i64::from(*lost)));
                }
            }
            balance.sort_unstable();
            let mut sheets = balance.chunk_by(|a, b| a.0 == b.0);
            sheets.any(|sheet| sheet.iter().map(|&(_, change)| change).sum::<i64>() > 0)
        })
    }

    /// The polygons that are part of a winding, each with what is known of it.
    fn winding(&self, entries: &[Entry]) -> impl Iterator<Item = (u8, &PolygonBlocker<N>)> {
        entries.iter().filter_map(|entry| {
            let Blocker::Polygon(index) = entry.blocker() else { return None };
            let polygon = &self.polygons[index];
            (!polygon.edge_on && polygon.holes.is_none()).then_some((entry.known, polygon))
        })
    }
}

impl<const N: usize> Blockers<'_, N> {
    /// The borders and cuts that may meet the inside of a cell, each once. `None` if each polygon has one that takes away all that it bounds: a polygon that holds a
    /// probe holds it inside of its borders, so that nothing is left over.
    fn crossing_borders(&self, hull: &Hull<N>, entries: &[Entry]) -> Option<Vec<Crossing<'_, N>>> {
        let (mut crossing, mut shared) = (Vec::new(), Vec::new());
        let (mut count, mut bounded) = (0, 0);
        for (known, polygon) in self.winding(entries) {
            let bit = 1u64.checked_shl(count).unwrap_or(0);
            for (index, Border { net, users, edge }) in polygon.crossing(known, hull.parameters.as_ref()) {
                let border = Crossing { function: polygon.function(index), lost: net, sheet: polygon.sheet };
                if users == 1 {
                    crossing.push(border);
                    bounded |= bit;
                } else {
                    shared.push(((polygon.sheet, edge), users, bit, border));
                }
            }
            count += 1;
        }
        // The users of an edge have the same function of it. Those that are missing here are out of the way or settled, and so is the
        // edge.
        shared.sort_by_key(|&(edge, ..)| edge);
        for uses in shared.chunk_by(|a, b| a.0 == b.0).filter(|uses| uses.len() == uses[0].1 as usize) {
            let (_, users, _, border) = uses[0];
            crossing.push(border);
            if border.lost == users {
                uses.iter().for_each(|&(_, _, bit, _)| bounded |= bit);
            }
        }
        (count > bounded.count_ones()).then_some(crossing)
    }
}

/// A border or a cut that may take polygons away within a cell.
#[derive(Clone, Copy)]
struct Crossing<'a, const N: usize> {
    /// Not negative on the inner side.
    function: &'a Field<N>,
    /// How many polygons.
    lost: u32,
    /// Of which sheet.
    sheet: u32,
}

/// A polygon seen edge-on touches a cell only along a line; it never covers.
fn edge_on_influence<const N: usize>(polygon: &PolygonBlocker<N>, hull: &Hull<N>) -> Influence {
    let misses = polygon.function_indices().any(|index| {
        let range = polygon.function(index).range(hull.corners());
        range.min > 0.0 || range.max < 0.0
    });
    if misses { Influence::None } else { Influence::Unknown }
}
