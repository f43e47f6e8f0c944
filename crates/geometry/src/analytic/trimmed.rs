//! A quadric's box without halves that hold nothing of the body.
//!
//! Patches of a quadric divide the sides of its box, down to where its surface is. A box that is 10^60 times as long as the body in it would be divided two
//! hundred times before anything is seen, so halves of it that lie all outside are left out first, one after the other.
//!
//! Guarantee: the body stays the same: in what is left out its form is positive for certain (NUMERICS.md, "Analytic bodies"). Where a box is less
//! than twice too long on each side, nothing changes. Cost: some fifty multiplications a half.

use crate::accept;

/// A box by its least and greatest corner.
type Corners = [[f64; 3]; 2];

/// Some terms are rounded a dozen times before they are added up.
const ROUNDINGS: f64 = 64.0 * f64::EPSILON;

/// The box that is left of `within`; all of it, if nothing of the body is in it.
pub(super) fn trimmed(matrix: &[[f64; 4]; 4], within: &Corners) -> Corners {
    let mut left = *within;
    loop {
        let mut is_done = true;
        for axis in 0..3 {
            let middle = 0.5 * left[0][axis] + 0.5 * left[1][axis];
            if accept(middle).is_err() || !(left[0][axis] < middle && middle < left[1][axis]) {
                continue;
            }
            let half = |side: usize| {
                let mut half = left;
                half[side][axis] = middle;
                half
            };
            match [half(1), half(0)].map(|half| is_outside(matrix, &half)) {
                [true, true] => return *within,
                [true, false] => left = half(0),
                [false, true] => left = half(1),
                [false, false] => continue,
            }
            is_done = false;
        }
        if is_done {
            return left;
        }
    }
}

/// Whether the form is positive all over a box for certain.
fn is_outside(matrix: &[[f64; 4]; 4], within: &Corners) -> bool {
    let range = |axis: usize| if axis < 3 { within.map(|corner| corner[axis]) } else { [1.0; 2] };
    let (mut least, mut size) = (0.0, 0.0);
    for row in 0..4 {
        for column in row..4 {
            let weight = if row == column { matrix[row][row] } else { matrix[row][column] + matrix[column][row] };
            let products = range(row).map(|x| range(column).map(|y| weight * (x * y)));
            let [[a, b], [c, d]] = products;
            // A square is no less than 0 where the box has both signs.
            let is_square = row == column && row < 3 && within[0][row] < 0.0 && within[1][row] > 0.0;
            let ends = if row == column { a.min(d) } else { a.min(b).min(c).min(d) };
            least += if is_square { ends.min(0.0) } else { ends };
            size += a.abs().max(b.abs()).max(c.abs()).max(d.abs());
        }
    }
    least > ROUNDINGS * size
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SPHERE: [[f64; 4]; 4] =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, -1.0]];

    #[test]
    fn a_sphere_in_a_long_box_keeps_what_is_about_it() {
        let [low, high] = trimmed(&SPHERE, &[[-1e60, -2.0, -3.0], [2.0, 2.0, 1e9]]);
        assert!((-4.0..-1.0).contains(&low[0]) && high[0] == 2.0, "{low:?} {high:?}");
        assert!(low[2] >= -3.0 && low[2] <= -1.0 && (1.0..=5.0).contains(&high[2]), "{low:?} {high:?}");
        let tight = [[-1.5; 3], [1.5; 3]];
        assert_eq!(trimmed(&SPHERE, &tight), tight);
        let beside = [[2.0; 3], [9.0; 3]];
        assert_eq!(trimmed(&SPHERE, &beside), beside, "nothing of it is there");
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
