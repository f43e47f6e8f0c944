//! One shaft against many boxes: the test of [`Shaft::may_meet`], on as many boxes at once as the processor takes.

use umbriel_geometry::{
    BoxBlock, BoxColumns,
    simd::{Kernel, Simd, dispatch},
};

use super::{OUTWARD, Shaft};

const LANES: usize = BoxBlock::LANES;

impl Shaft {
    /// Visits the boxes that may meet the shaft, by their places, ascending: all of which [`Shaft::may_meet`] says so, and some that only do as they are rounded
    /// ([`BoxColumns`]). Cost: about a nanosecond a box that is not visited.
    pub fn for_each_met(&self, boxes: &BoxColumns, visit: impl FnMut(usize)) {
        dispatch(Met { shaft: self, boxes, visit });
    }
}

/// All boxes against a shaft.
struct Met<'a, V> {
    shaft: &'a Shaft,
    boxes: &'a BoxColumns,
    visit: V,
}

impl<V: FnMut(usize)> Kernel for Met<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { shaft, boxes, mut visit } = self;
        for (number, block) in boxes.blocks().iter().enumerate() {
            let met = shaft.meets_lanes(block);
            if met == [false; LANES] {
                continue;
            }
            let first = number * LANES;
            (first..boxes.len()).zip(met).filter(|(_, met)| *met).for_each(|(place, _)| visit(place));
        }
    }
}

impl Shaft {
    /// [`Shaft::may_meet`], lane by lane.
    #[inline(always)]
    fn meets_lanes(&self, block: &BoxBlock) -> [bool; LANES] {
        let (mut lower, mut upper) = ([0.0; LANES], [self.end; LANES]);
        for axis in 0..3 {
            let [low, high] =
                [(self.from_min[axis], self.inverse_min[axis]), (self.from_max[axis], self.inverse_max[axis])];
            bound_lanes(&mut lower, &mut upper, &block.min[axis], low, low.1 > 0.0);
            bound_lanes(&mut lower, &mut upper, &block.max[axis], high, high.1 < 0.0);
        }
        let mut met = [false; LANES];
        for lane in 0..LANES {
            met[lane] = lower[lane] <= upper[lane] * OUTWARD && (upper[lane] > 0.0 || self.end > 1.0);
        }
        met
    }
}

/// Takes one more bound of the parameter in every lane; NaN bounds nothing.
#[inline(always)]
fn bound_lanes(
    lower: &mut [f64; LANES],
    upper: &mut [f64; LANES],
    ends: &[f32; LANES],
    (from, inverse): (f64, f64),
    is_lower: bool,
) {
    if is_lower {
        for lane in 0..LANES {
            let value = (f64::from(ends[lane]) - from) * inverse;
            lower[lane] = if value > lower[lane] { value } else { lower[lane] };
        }
    } else {
        for lane in 0..LANES {
            let value = (f64::from(ends[lane]) - from) * inverse;
            upper[lane] = if value < upper[lane] { value } else { upper[lane] };
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use umbriel_geometry::{Aabb, LightSource};

    use super::*;
    use crate::arbitrary::{boxes, light};

    /// The smallest box around another one whose coordinates are f32.
    fn rounded(bounds: &Aabb) -> Aabb {
        let up = |number: f64| {
            let nearest = number as f32;
            f64::from(if f64::from(nearest) < number { nearest.next_up() } else { nearest })
        };
        Aabb { min: -(-bounds.min).map(up), max: bounds.max.map(up) }
    }

    /// A light seen in other units.
    fn scaled(light: &LightSource, scale: f64) -> LightSource {
        let xyz = (light.xyz() * scale).to_array();
        if light.is_sun() { LightSource::sun(xyz) } else { LightSource::point(xyz) }.expect("a light")
    }

    proptest! {
        #[test]
        fn what_f32_does_not_hold_is_met_as_well(boxes in boxes(), light in light(), power in -160i32..=160) {
            let scale = 2f64.powi(power);
            let scaled_box = |bounds: &Aabb| Aabb { min: bounds.min * scale, max: bounds.max * scale };
            let boxes: Vec<Aabb> = boxes.iter().map(scaled_box).collect();
            let columns: BoxColumns = boxes.iter().copied().collect();
            for receiver in boxes.iter().filter(|receiver| !receiver.is_empty()) {
                let shaft = Shaft::new(receiver, &scaled(&light, scale));
                let mut is_met = vec![false; boxes.len()];
                shaft.for_each_met(&columns, |place| is_met[place] = true);
                let is_left_out = |(bounds, is_met): (&Aabb, &bool)| !is_met && !bounds.is_empty() && shaft.may_meet(bounds);
                prop_assert!(!boxes.iter().zip(&is_met).any(is_left_out));
            }
        }

        #[test]
        fn many_boxes_are_told_as_each_of_them(boxes in boxes(), light in light()) {
            let columns: BoxColumns = boxes.iter().copied().collect();
            for receiver in boxes.iter().filter(|receiver| !receiver.is_empty()) {
                let shaft = Shaft::new(receiver, &light);
                let mut met = Vec::new();
                shaft.for_each_met(&columns, |place| met.push(place));
                // Empty ones may or may not be met.
                met.retain(|&place| !boxes[place].is_empty());
                let may_meet = |bounds: &Aabb| !bounds.is_empty() && shaft.may_meet(&rounded(bounds));
                let expected: Vec<usize> = (0..boxes.len()).filter(|&place| may_meet(&boxes[place])).collect();
                prop_assert_eq!(met, expected);
            }
        }
    }
}
