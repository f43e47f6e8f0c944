//! A quadric's box without ends that hold nothing of the body.
//!
//! Patches of a quadric divide the sides of its box, down to where its surface is. A box that is 10^60 times as long as the body in it would be divided two
//! hundred times before anything is seen, so ends that hold nothing are cut off first: all beyond an ellipsoid, if it is one, else one quarter after the other. Only the longest
//! sides are cut, so that what is left is not much thinner than what was given; and where the form is found negative nowhere in what is left (the body may be a point),
//! all is left as it was.
//!
//! Guarantee: the body stays the same, as what is cut off is decided exactly; where it reaches into the outer quarters of the longest sides, nothing changes.
//! Cost: a hundred points a quarter, and some forty microseconds for one that none of them shows to be needed.

use std::{cell::LazyCell, ops::Deref};

use glam::{DMat4, DVec3};

use super::{
    Analytic,
    bounds::{Cut, Ellipsoid, Plane},
    layout::Layout,
};
use crate::accept;

/// A box by its least and greatest corner.
type Corners = [[f64; 3]; 2];

/// Points along each side of a box at which the form is looked at.
const LOOKS: i32 = 5;

/// How much farther than an ellipsoid's ends its box is left to reach.
const WIDER: f64 = 1.5;

/// The box that is left of `within`.
pub(super) fn trimmed(matrix: &[[f64; 4]; 4], within: &Corners) -> Corners {
    let quadric = Quadric {
        matrix,
        layout: Layout::of(&Analytic::Quadric { matrix: *matrix, within: *within }),
        guess: Ellipsoid::of(matrix),
    };
    let mut left = *within;
    while let Some(shorter) = quadric.shortened(&left) {
        left = shorter;
    }
    let has_extent = (0..3).all(|axis| left[0][axis] < left[1][axis]);
    if has_extent && quadric.is_seen_in(&left) { left } else { *within }
}

struct Quadric<'a> {
    matrix: &'a [[f64; 4]; 4],
    layout: Layout,
    guess: Ellipsoid,
}

impl Quadric<'_> {
    /// The box without empty ends of its longest sides; `None` if none is empty, or all of it is.
    fn shortened(&self, within: &Corners) -> Option<Corners> {
        let length = |axis: usize| within[1][axis] - within[0][axis];
        let longest = (0..3).map(length).fold(0.0, f64::max);
        let cut = LazyCell::new(|| Cut::new(&self.layout, within));
        let mut left = *within;
        // Sides that are equally long are cut together: their order does not count.
        for axis in (0..3).filter(|&axis| length(axis) == longest) {
            for end in [0, 1] {
                left[end][axis] = self.empty_beyond(within, &cut, axis, end).unwrap_or(within[end][axis]);
            }
        }
        (left != *within && cut.holds_some()).then_some(left)
    }

    /// Where the lower (0) or upper (1) end of a side of the box is to be cut off; `None` if its quarter holds something.
    fn empty_beyond(&self, within: &Corners, cut: &impl Deref<Target = Cut>, axis: usize, end: usize) -> Option<f64> {
        let outward = [-1.0, 1.0][end];
        let is_empty_beyond = |at: f64| {
            let mut beyond = *within;
            beyond[1 - end][axis] = at;
            let is_part = within[0][axis] < at && at < within[1][axis] && accept(at).is_ok();
            let plane = Plane { normal: DVec3::AXES[axis], offset: 0.0, at };
            is_part && !self.is_seen_in(&beyond) && !cut.reaches(&plane, outward)
        };
        let quarter = 0.75 * within[end][axis] + 0.25 * within[1 - end][axis];
        let [middle, reach] = self.guess.reach(DVec3::AXES[axis]);
        let guess = Some(middle + outward * WIDER * reach).filter(|guess| (quarter - guess) * outward > 0.0);
        guess.into_iter().chain([quarter]).find(|&at| is_empty_beyond(at))
    }

    /// Whether the form is found negative at some point of a box: of a grid, or in its own centre.
    fn is_seen_in(&self, [low, high]: &Corners) -> bool {
        let [low, high] = [low, high].map(|corner| DVec3::from_array(*corner));
        let place = |k: i32| {
            let [x, y, z] = [k / (LOOKS * LOOKS), k / LOOKS % LOOKS, k % LOOKS].map(|step| f64::from(step) + 0.5);
            DVec3::new(x, y, z) / f64::from(LOOKS)
        };
        let center = Some(self.guess.center).filter(|center| (center.cmpge(low) & center.cmple(high)).all());
        let form = DMat4::from_cols_array_2d(self.matrix);
        let mut points = (0..LOOKS.pow(3)).map(|k| low + place(k) * (high - low)).chain(center);
        points.any(|point| {
            let point = point.extend(1.0);
            point.dot(form * point) < 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SPHERE: [[f64; 4]; 4] =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, -1.0]];

    #[test]
    fn a_sphere_in_a_long_box_keeps_what_is_about_it() {
        for within in [[[-1e60, -2.0, -2.0], [2.0; 3]], [[-1e60, -1e60, -1.0], [1e60, 1e60, 1e9]]] {
            let [low, high] = trimmed(&SPHERE, &within);
            assert!(low.iter().all(|low| (-8.0..=-1.0).contains(low)), "{low:?}");
            assert!(high.iter().all(|high| (1.0..=8.0).contains(high)), "{high:?}");
        }
        let tight = [[-1.5; 3], [1.5; 3]];
        assert_eq!(trimmed(&SPHERE, &tight), tight);
        let beside = [[2.0; 3], [9.0; 3]];
        assert_eq!(trimmed(&SPHERE, &beside), beside, "nothing of it is there");
        let touched = [[1.0, -1.0, 0.0], [2.0, 1.0, 2.0]];
        assert_eq!(trimmed(&SPHERE, &touched), touched, "a point of it is there");
    }

    #[test]
    fn an_ellipsoid_across_its_box_keeps_what_is_about_it() {
        // Thin along (1, 1, 1): |x|² + 10⁴(x + y + z)² ≤ 1.
        let entry = |row: usize, column: usize| match (row, column) {
            (3, 3) => -1.0,
            (3, _) | (_, 3) => 0.0,
            _ => 1e4 + f64::from(u8::from(row == column)),
        };
        let matrix = [0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column| entry(row, column)));
        for size in [1e3, 1e60] {
            let [low, high] = trimmed(&matrix, &[[-size; 3], [size; 3]]);
            let reach = (2.0f64 / 3.0).sqrt();
            assert!(high.iter().all(|high| (reach..4.0 * reach).contains(high)), "{high:?}");
            assert_eq!(low, high.map(|high| -high));
        }
    }

    #[test]
    fn what_is_inside_is_kept() {
        // All but a ball: the box closes it.
        let all_but = SPHERE.map(|row| row.map(|entry| -entry));
        let within = [[-1e9, -2.0, -2.0], [2.0; 3]];
        assert_eq!(trimmed(&all_but, &within), within);
    }

    proptest! {
        #[test]
        fn no_point_of_the_body_is_left_out(
            entries in prop::array::uniform16(-2i32..=2),
            (low, size) in (prop::array::uniform3(-40i32..40), prop::array::uniform3(1i32..60)),
            at in prop::array::uniform3(0.0..=1.0f64),
        ) {
            let matrix = [0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column| f64::from(entries[4 * row + column])));
            let low = low.map(f64::from);
            let within = [low, [0, 1, 2].map(|axis| low[axis] + f64::from(size[axis]))];
            let left = trimmed(&matrix, &within);
            let point = [0, 1, 2].map(|axis| low[axis] + at[axis] * f64::from(size[axis]));
            let point = [point[0], point[1], point[2], 1.0];
            let products = (0..16).map(|k| matrix[k / 4][k % 4] * point[k / 4] * point[k % 4]);
            let is_left = (0..3).all(|axis| left[0][axis] <= point[axis] && point[axis] <= left[1][axis]);
            prop_assert!(is_left || products.sum::<f64>() > 0.0, "{matrix:?} {within:?} {left:?} {point:?}");
        }
    }
}
