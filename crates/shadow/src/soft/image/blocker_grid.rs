//! Which blockers may shade a point: lists by squares of the map.
//!
//! A blocker is listed in the squares that its rectangle meets, grown by the widest penumbra on the farthest receiver. A point asks the blockers of its
//! square only: O(squares covered) to make, O(blockers near) a point.

use glam::DVec2;
use umbriel_visibility::depth_map::LightSpace;

use super::boxes::Blocker;

/// Squares along an edge of the map.
const SQUARES: usize = 64;

/// Lists of blockers, by squares.
#[derive(Clone, Debug, Default)]
pub(super) struct BlockerGrid {
    lists: Vec<Vec<u32>>,
    /// Texels along the edge of a square.
    edge: f64,
}

impl BlockerGrid {
    /// For receivers down to the depth `farthest`.
    pub(super) fn new(space: &LightSpace, blockers: &[Blocker], farthest: f64, width: f64) -> Self {
        let edge = space.size() as f64 / SQUARES as f64;
        let mut grid = Self { lists: vec![Vec::new(); SQUARES * SQUARES], edge };
        for (number, blocker) in blockers.iter().enumerate() {
            let [low, high] = blocker.rectangle(space, farthest, width).map(|place| space.image_to_texels(place));
            let ([left, top], [right, bottom]) = (grid.square(low), grid.square(high));
            for row in top..=bottom {
                grid.lists[row * SQUARES + left..=row * SQUARES + right]
                    .iter_mut()
                    .for_each(|list| list.push(number as u32));
            }
        }
        grid
    }

    /// Those that may shade a place (in texels), ascending.
    pub(super) fn near(&self, place: DVec2) -> &[u32] {
        let [column, row] = self.square(place);
        self.lists.get(row * SQUARES + column).map_or(&[], Vec::as_slice)
    }

    /// The column and row of a place's square; the nearest one for places off the map.
    fn square(&self, place: DVec2) -> [usize; 2] {
        (place / self.edge).to_array().map(|place| place.clamp(0.0, (SQUARES - 1) as f64) as usize)
    }
}
