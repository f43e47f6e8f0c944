//! Bodies over a cell, in the order in which they promise to cover it.
//!
//! Guarantee: no body that may block a point of the cell is left out, and what one promises goes by it and the cell alone. Cost: some ten nanoseconds a body, and
//! sorting.

use umbriel_geometry::{Aabb, Point};

use super::{Occluders, over};

impl Occluders<'_> {
    /// The boxes of the hull of `points` in the frames that see it; the ties last.
    pub(super) fn views_of(&self, points: &[Point]) -> Vec<(usize, Aabb)> {
        let views = self.frames.iter().chain(&self.ties).enumerate();
        views.filter_map(|(number, frame)| Some((number, frame.bounds(points)?))).collect()
    }

    /// What must be met in these frames by what is over the hull of `points`.
    pub(super) fn cells_over(&self, points: &[Point]) -> Vec<(usize, Aabb)> {
        self.views_of(points).into_iter().map(|(number, cell)| (number, over(cell))).collect()
    }

    /// Those of these bodies that are over the hull of `points` as far as boxes tell, each with how far its box reaches beyond that of the hull in light
    /// space; the farthest first.
    pub(in crate::fine) fn over_cell(&self, bodies: &[u32], points: &[Point]) -> Vec<(f64, u32)> {
        let cells = self.cells_over(points);
        let reach = |&object: &u32| Some((self.reach_where_seen(object, &cells)?, object));
        let mut over: Vec<(f64, u32)> = bodies.iter().filter_map(reach).collect();
        over.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        over
    }

    /// How far a body reaches beyond a cell, in the frames that see both; `None` if it is beside or behind it.
    fn reach_where_seen(&self, object: u32, cells: &[(usize, Aabb)]) -> Option<f64> {
        let (mut is_seen, mut least) = (false, f64::INFINITY);
        for (frame, cell) in cells {
            match self.view_of_body(object, *frame).and_then(|body| reach_beyond(body, cell)) {
                Some(beyond) => (is_seen, least) = (true, least.min(beyond)),
                None if *frame >= self.frames.len() => return None,
                None => {}
            }
        }
        is_seen.then_some(least)
    }
}

/// How far a box in light space reaches beyond that of a cell; `None` if it is beside or behind it.
fn reach_beyond(body: &Aabb, cell: &Aabb) -> Option<f64> {
    let beyond = (cell.min - body.min).min(body.max - cell.max);
    body.meets(cell).then(|| beyond.x.min(beyond.y))
}
