//! Bounding boxes side by side, so that a loop over many of them takes several at once.
//!
//! Boxes stand in blocks of [`BoxBlock::LANES`], each of their six coordinates in a row of its own: what is asked of a box is asked of a row, in plain loops that a compiler
//! turns into vectors. They are rounded outward to f32, 24 bytes a box: what a box in here does not meet, the box it was made from does not meet.

use crate::Aabb;

const LANES: usize = BoxBlock::LANES;

/// Some boxes, their coordinates in rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxBlock {
    /// For each axis the least coordinates, metres, rounded down.
    pub min: [[f32; LANES]; 3],
    /// For each axis the greatest coordinates, metres, rounded up.
    pub max: [[f32; LANES]; 3],
}

impl BoxBlock {
    /// Boxes of a block.
    pub const LANES: usize = 16;
    const EMPTY: Self = Self { min: [[f32::INFINITY; LANES]; 3], max: [[f32::NEG_INFINITY; LANES]; 3] };
}

/// Boxes, named by their places in the list they were made from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoxColumns {
    blocks: Vec<BoxBlock>,
    len: usize,
}

impl BoxColumns {
    /// In blocks of [`BoxBlock::LANES`]; empty boxes fill the last one up.
    pub fn blocks(&self) -> &[BoxBlock] {
        &self.blocks
    }

    /// How many boxes there are, without those that fill up.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    fn push(&mut self, bounds: &Aabb) {
        let lane = self.len % LANES;
        if lane == 0 {
            self.blocks.push(BoxBlock::EMPTY);
        }
        self.len += 1;
        let Some(block) = self.blocks.last_mut() else { return };
        for axis in 0..3 {
            block.min[axis][lane] = down(bounds.min[axis]);
            block.max[axis][lane] = -down(-bounds.max[axis]);
        }
    }
}

impl FromIterator<Aabb> for BoxColumns {
    fn from_iter<I: IntoIterator<Item = Aabb>>(boxes: I) -> Self {
        let boxes = boxes.into_iter();
        let blocks = Vec::with_capacity(boxes.size_hint().0.div_ceil(LANES));
        boxes.fold(Self { blocks, len: 0 }, |mut columns, bounds| {
            columns.push(&bounds);
            columns
        })
    }
}

/// The greatest f32 that is not above a number.
fn down(number: f64) -> f32 {
    let nearest = number as f32;
    if f64::from(nearest) > number { nearest.next_down() } else { nearest }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// The box of a place, with the next smaller one in f32.
    fn of_place(columns: &BoxColumns, place: usize) -> [Aabb; 2] {
        let (block, lane) = (&columns.blocks()[place / LANES], place % LANES);
        let point =
            |rows: [[f32; LANES]; 3], next: fn(f32) -> f32| DVec3::from_array(rows.map(|row| next(row[lane]).into()));
        let same: fn(f32) -> f32 = |number| number;
        [(same, same), (f32::next_up, f32::next_down)]
            .map(|(up, down)| Aabb { min: point(block.min, up), max: point(block.max, down) })
    }

    #[test]
    fn boxes_keep_their_places_and_the_rest_is_empty() {
        let bounds = |k: usize| Aabb { min: DVec3::new(k as f64, 1.0, -2.0), max: DVec3::new(k as f64, 2.0, 5.0) };
        let columns: BoxColumns = (0..21).map(bounds).collect();
        assert_eq!((columns.len(), columns.blocks().len(), columns.is_empty()), (21, 2, false));
        for place in 0..2 * LANES {
            assert_eq!(of_place(&columns, place)[0], if place < 21 { bounds(place) } else { Aabb::EMPTY });
        }
        assert!(BoxColumns::default().is_empty());
    }

    #[test]
    fn boxes_are_the_smallest_that_hold_those_given() {
        let numbers = [0.1, -0.1, 1e-300, -1e-300, 1e50, -1e50, 3.0, f64::from(f32::MAX) * (1.0 + f64::EPSILON)];
        let bounds = numbers.map(|number| Aabb { min: DVec3::splat(number), max: DVec3::splat(number) });
        let columns: BoxColumns = bounds.into_iter().collect();
        for (place, bounds) in bounds.iter().enumerate() {
            let [held, smaller] = of_place(&columns, place);
            assert!(held.contains(bounds.min), "{bounds:?} in {held:?}");
            assert!(smaller.min.x > bounds.min.x && smaller.max.x < bounds.max.x, "{bounds:?}, {smaller:?}");
        }
    }
}
