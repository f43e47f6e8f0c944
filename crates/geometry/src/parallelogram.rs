//! Faces of rectangles and boxes: the corners' numbers, and what does not depend on where the body lies.
//!
//! A side is the matrix times a side of the local body, which lies along an axis: a product a coordinate, where the difference of placed corners would
//! have lost all digits of a body far out. So sides and areas are those of the exact image, wherever that is.

use glam::DVec3;

use crate::{approx::Approx, facets::length_squared, placement::Placement, predicates::symmetric_sum};

/// A face with its corners, counter-clockwise seen from its local front.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parallelogram {
    pub(crate) corners: [u32; 4],
    /// Lengths of the sides at the first corner, to the second and to the last, metres, rounded.
    pub(crate) sides: [f64; 2],
    /// Square metres.
    pub(crate) area: Approx,
}

impl Parallelogram {
    /// Of local corners whose differences along the sides are floats.
    pub(crate) fn new(corners: [u32; 4], local: &[DVec3], placement: &Placement) -> Self {
        let at = |corner: u32| local[corner as usize];
        let [u, v] = [corners[1], corners[3]].map(|end| placement.side(at(end) - at(corners[0])));
        let length =
            |side: [Approx; 3]| length_squared(DVec3::from_array(side.map(|coordinate| coordinate.value))).sqrt();
        Self { corners, sides: [length(u), length(v)], area: area_between(u, v) }
    }
}

/// The length of the cross product of two sides. The squares are added smallest first, so the axes may change places without changing the sum.
pub(crate) fn area_between(u: [Approx; 3], v: [Approx; 3]) -> Approx {
    let floats = |side: [Approx; 3]| DVec3::from_array(side.map(|coordinate| coordinate.value));
    if u.iter().chain(&v).all(|coordinate| coordinate.error == 0.0)
        && let Some(area) = area_between_floats(floats(u), floats(v))
    {
        return area;
    }
    let squares = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
        let component = u[i] * v[j] - u[j] * v[i];
        component * component
    });
    Approx::sum_of_three(squares).square_root()
}

/// The same for sides that were rounded once at most; `None` where a square may underflow.
///
/// With each coordinate, product and sum rounded once (u = 2^-53), a component is off by 4.1u times the sum P of its two
/// products' sizes, a vector by no more than the sum of its components' errors, and squares, sums and root add 3u.
#[inline(always)]
fn area_between_floats(u: DVec3, v: DVec3) -> Option<Approx> {
    let (area, is_normal) = float_area(u, v);
    is_normal.then_some(area)
}

/// As [`area_between_floats`]: a number, and whether it holds. Without branches.
#[inline(always)]
pub(crate) fn float_area(u: DVec3, v: DVec3) -> (Approx, bool) {
    let normal = u.cross(v);
    let (sizes, other) = (u.abs(), v.abs());
    let pairs = DVec3::new(other.y + other.z, other.z + other.x, other.x + other.y);
    let products = symmetric_sum(sizes * pairs);
    let sum = length_squared(normal);
    let value = sum.sqrt();
    let is_normal = (sum > 1e-280) & (sum < 1e280);
    (Approx { value, error: (products * 5.0 + value * 4.0) * (f64::EPSILON / 2.0) }, is_normal)
}

#[cfg(test)]
mod tests {
    use crate::{Cuboid, Facets, Placement, Rectangle};
    use glam::{DAffine3, DVec3};

    fn placed(at: DVec3) -> Placement {
        Placement::new(DAffine3::from_translation(at)).expect("regular")
    }

    #[test]
    fn an_area_is_that_of_the_exact_image_wherever_it_lies() {
        let (slab, sheet) = (Cuboid { size: [2.0, 0.125, 2.0] }, Rectangle { size: [0.3, 0.1] });
        let here: Vec<_> = Facets::of_cuboid(&slab, &Placement::IDENTITY).areas().collect();
        assert_eq!(here.iter().map(|area| area.value).sum::<f64>(), 9.0);
        for far in [1e6, 1e15, 2.0_f64.powi(200)] {
            for at in [DVec3::new(far, 0.0, 0.0), DVec3::new(0.0, -far, 0.0), DVec3::splat(far)] {
                assert!(Facets::of_cuboid(&slab, &placed(at)).areas().eq(here.iter().copied()), "at {at}");
                let area = Facets::of_rectangle(&sheet, &placed(at)).area(0);
                assert!((area.value - 0.03).abs() <= area.error + 1e-17 && area.error < 1e-16, "{area:?} at {at}");
            }
        }
    }
}
