//! A quadric's box without ends that hold nothing of the body.
//!
//! Patches of a quadric divide the sides of its box, down to where its surface is. A box that is 10^60 times as long as the body in it would be divided two
//! hundred times before anything is seen, so quarters at its ends that lie all outside are cut off first, one after the other. Only the longest sides are cut, so
//! that what is left is not much thinner than what was given; and where the form is found negative nowhere in what is left (the
//! body may be a point on the border of the box), all is left as it was.
//!
//! Guarantee: the body stays the same: in what is cut off its form is positive for certain (NUMERICS.md, "Analytic bodies"). Where the body reaches into the
//! outer quarters of the longest sides, nothing changes, and little where its axes run across the box. Cost: some eighty multiplications a quarter, up to a thousand quarters, and
//! four thousand multiplications at the end.

use crate::accept;

/// A box by its least and greatest corner.
type Corners = [[f64; 3]; 2];

/// A term is rounded three times, the sum of ten nine times; this is four times as much.
const ROUNDINGS: f64 = 64.0 * f64::EPSILON;

/// Points along each side of a box at which the form is looked at.
const LOOKS: i32 = 5;

/// The box that is left of `within`.
pub(super) fn trimmed(matrix: &[[f64; 4]; 4], within: &Corners) -> Corners {
    let mut left = *within;
    let mut goes_on = true;
    while goes_on {
        let whole = left;
        goes_on = false;
        let length = |axis: usize| whole[1][axis] - whole[0][axis];
        let longest = (0..3).map(length).fold(0.0, f64::max);
        // Sides that are equally long are cut together: their order does not count.
        for axis in (0..3).filter(|&axis| length(axis) == longest) {
            for (inner, outer) in [(0.25, 0), (0.75, 1)] {
                let cut = (1.0 - inner) * whole[0][axis] + inner * whole[1][axis];
                let mut quarter = whole;
                quarter[1 - outer][axis] = cut;
                let is_shorter = whole[0][axis] < cut && cut < whole[1][axis] && accept(cut).is_ok();
                if is_shorter && is_outside(matrix, &quarter) {
                    left[outer][axis] = cut;
                    goes_on = true;
                }
            }
        }
    }
    let has_extent = (0..3).all(|axis| left[0][axis] < left[1][axis]);
    if has_extent && holds_some(matrix, &left) { left } else { *within }
}

/// What x·y counts in the form, x and y the coordinates of these numbers, of which the second is no less.
fn weight(matrix: &[[f64; 4]; 4], row: usize, column: usize) -> f64 {
    if row == column { matrix[row][row] } else { matrix[row][column] + matrix[column][row] }
}

/// The pairs of coordinates that the form has terms of.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..4).flat_map(|row| (row..4).map(move |column| (row, column)))
}

/// Whether the form is found negative somewhere in a box.
fn holds_some(matrix: &[[f64; 4]; 4], [low, high]: &Corners) -> bool {
    let at = |k: i32| {
        let place =
            [k / (LOOKS * LOOKS), k / LOOKS % LOOKS, k % LOOKS].map(|step| (f64::from(step) + 0.5) / f64::from(LOOKS));
        let [x, y, z] = [0, 1, 2].map(|axis| low[axis] + place[axis] * (high[axis] - low[axis]));
        [x, y, z, 1.0]
    };
    (0..LOOKS.pow(3)).map(at).any(|point| {
        let terms = pairs().map(|(row, column)| weight(matrix, row, column) * (point[row] * point[column]));
        terms.sum::<f64>() < 0.0
    })
}

/// Whether the form is positive all over a box for certain.
fn is_outside(matrix: &[[f64; 4]; 4], within: &Corners) -> bool {
    let range = |axis: usize| if axis < 3 { within.map(|corner| corner[axis]) } else { [1.0; 2] };
    let (mut least, mut size) = (0.0, 0.0);
    for (row, column) in pairs() {
        let weight = weight(matrix, row, column);
        let [[a, b], [c, d]] = range(row).map(|x| range(column).map(|y| weight * (x * y)));
        // A square is no less than 0 where the box has both signs.
        let is_square = row == column && row < 3 && within[0][row] < 0.0 && within[1][row] > 0.0;
        let ends = if row == column { a.min(d) } else { a.min(b).min(c).min(d) };
        least += if is_square { ends.min(0.0) } else { ends };
        size += a.abs().max(b.abs()).max(c.abs()).max(d.abs());
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
