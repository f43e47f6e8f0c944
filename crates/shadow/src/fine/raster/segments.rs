//! What is drawn on a face: directed segments, and veils.

use std::{collections::HashMap, num::NonZeroU64};

use glam::DVec3;
use umbriel_geometry::Point;

use super::blocks::Blocks;

/// A directed segment; more facets cover what is on its left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    pub(crate) from: [f64; 2],
    pub(crate) to: [f64; 2],
    /// The true segment has each point within this of ours, in x and in y.
    pub(crate) margin: f32,
    /// How many facets more; at least 1.
    pub(crate) net: i32,
    /// It lies exactly on the face's own side u = 0, and its facet on the other side of that: it counts for the winding, but
    /// touches no cell.
    pub(crate) is_beside: bool,
}

/// A convex polygon, closed, that may shadow what it touches.
#[derive(Clone, Debug)]
pub(crate) struct Veil {
    pub(crate) corners: Vec<[f64; 2]>,
    pub(crate) margin: f32,
}

/// Segments of a block.
const BLOCK: usize = 1 << 10;

/// Everything that may change verdicts on a face.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chain {
    pub(crate) segments: Blocks<Segment, BLOCK>,
    /// The ends of each segment that are corners of a body clear of the plane. Apart from the rest: hardly any is asked for.
    pub(crate) ends: Blocks<[Option<CornerKey>; 2], BLOCK>,
    pub(crate) veils: Vec<Veil>,
    /// How many bodies there have been.
    pub(super) bodies: u64,
}

impl Chain {
    /// Adds a segment with its ends.
    pub(super) fn push(&mut self, segment: Segment, ends: [Option<CornerKey>; 2]) {
        self.segments.push(segment);
        self.ends.push(ends);
    }

    /// Where sheets of several bodies meet along an edge, it is taken once, or not at all if as many facets are on its right as on its left: rays through it
    /// meet the sheets all the same. Silhouettes of closed bodies, which change the number of facets by two, are left out: they are many and seldom meet so.
    /// Some 50 ns a rim.
    pub(super) fn join_rims(&mut self) {
        if self.bodies < 2 {
            return;
        }
        let mut first_along: HashMap<[CornerKey; 2], usize> = HashMap::new();
        for number in 0..self.segments.len() {
            let [Some(from), Some(to)] = self.ends[number] else { continue };
            if self.segments[number].net % 2 == 0 || self.segments[number].is_beside {
                continue;
            }
            let first = *first_along.entry(if from < to { [from, to] } else { [to, from] }).or_insert(number);
            if first == number {
                continue;
            }
            let is_same_way = self.ends[first] == self.ends[number];
            let Segment { net, margin, .. } = self.segments[number];
            self.segments[number].net = 0;
            let joined = &mut self.segments[first];
            joined.net += if is_same_way { net } else { -net };
            joined.margin = joined.margin.max(margin);
        }
        self.tidy();
    }

    /// Leaves out segments that nothing is on either side of, and turns those that have their facets on the right.
    fn tidy(&mut self) {
        for (segment, ends) in self.segments.iter_mut().zip(self.ends.iter_mut()).filter(|(segment, _)| segment.net < 0)
        {
            (segment.from, segment.to, segment.net) = (segment.to, segment.from, -segment.net);
            ends.reverse();
        }
        let mut nets = self.segments.iter().map(|segment| segment.net);
        self.ends.retain(|_| nets.next() != Some(0));
        self.segments.retain(|segment| segment.net != 0);
    }
}

/// Corners with equal keys are the same point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct CornerKey {
    /// Never zero, so that a corner without a key takes no more room: very many wait.
    first: NonZeroU64,
    others: [u64; 2],
}

impl CornerKey {
    /// Of a body's point. Exact points are known by their positions, whichever bodies they belong to; others by their numbers.
    pub(super) fn new(point: &Point, body: u64, number: u32) -> Self {
        if point.slack == DVec3::ZERO {
            // Adding 0 turns −0 into it.
            let [x, y, z] = (point.position + DVec3::ZERO).to_array().map(f64::to_bits);
            // The bits of a finite number are not all ones.
            return Self { first: NonZeroU64::MIN.saturating_add(x), others: [y, z] };
        }
        Self::numbered(body, number)
    }

    /// The key of no position.
    pub(super) fn numbered(body: u64, number: u32) -> Self {
        Self { first: NonZeroU64::MAX, others: [body, u64::from(number)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rims_of_several_bodies_join() {
        let corner = |number: u32| Some(CornerKey::numbered(1, number));
        let mut chain = Chain { bodies: 3, ..Chain::default() };
        let mut add = |ends: [u32; 2], net: i32| {
            let [from, to] = ends.map(|end| [f64::from(end), 0.0]);
            chain.segments.push(Segment { from, to, margin: net as f32, net, is_beside: false });
            chain.ends.push(ends.map(corner));
        };
        for (ends, net) in [([0, 1], 1), ([1, 0], 1), ([2, 3], 1), ([3, 2], 3), ([4, 5], 2), ([5, 4], 2), ([6, 7], 1)] {
            add(ends, net);
        }
        chain.join_rims();
        let left: Vec<_> = chain.segments.iter().map(|s| (s.from[0], s.to[0], s.net, s.margin)).collect();
        // Once there and once back is nothing; once there and three times back is twice back; silhouettes stay.
        assert_eq!(left, [(3.0, 2.0, 2, 3.0), (4.0, 5.0, 2, 2.0), (5.0, 4.0, 2, 2.0), (6.0, 7.0, 1, 1.0)]);
        let ends: Vec<_> = chain.ends.iter().map(|ends| ends[0]).collect();
        assert_eq!(ends, [3, 4, 5, 6].map(corner));
    }

    #[test]
    fn exact_points_are_known_by_their_positions_and_others_by_their_numbers() {
        let at = |x: f64| Point::exact(DVec3::new(x, 1.0, 2.0));
        assert_eq!(CornerKey::new(&at(0.0), 1, 5), CornerKey::new(&at(-0.0), 2, 7));
        assert_ne!(CornerKey::new(&at(0.0), 1, 5), CornerKey::new(&at(1.0), 1, 5));
        let rounded = Point::within(DVec3::ONE, DVec3::splat(1e-16));
        assert_eq!(CornerKey::new(&rounded, 1, 5), CornerKey::new(&rounded, 1, 5));
        assert_ne!(CornerKey::new(&rounded, 1, 5), CornerKey::new(&rounded, 2, 5));
        assert_ne!(CornerKey::new(&rounded, 1, 5), CornerKey::new(&rounded, 1, 6));
    }
}
