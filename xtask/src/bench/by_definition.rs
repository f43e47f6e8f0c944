//! Lit or not by the definition, in whole numbers: no predicate of the library has a part in it.
//!
//! A float is a whole multiple of 2^-[`BITS`] here, and every product of two is one of the square of that. O(triangles) a point, some
//! microseconds each.

use anyhow::{Result, ensure};
use num_bigint::{BigInt, Sign};

/// What floats are multiples of, as a power of two: enough for coordinates from 2^-100 on.
const BITS: i32 = 160;

type Vector = [BigInt; 3];

/// One-sided triangles under a sun, none of them edge-on.
pub(super) struct Triangles {
    corners: Vec<[Vector; 3]>,
    towards_sun: Vector,
}

impl Triangles {
    pub(super) fn new(corners: impl Iterator<Item = [[f64; 3]; 3]>, towards_sun: [f64; 3]) -> Result<Self> {
        let corners = corners.map(|[a, b, c]| Ok([vector(a)?, vector(b)?, vector(c)?])).collect::<Result<Vec<_>>>()?;
        let triangles = Self { corners, towards_sun: vector(towards_sun)? };
        let is_edge_on = |corners: &[Vector; 3]| triangles.facing(corners) == Sign::NoSign;
        ensure!(!triangles.corners.iter().any(is_edge_on), "a triangle is seen edge-on");
        Ok(triangles)
    }

    /// Whether the sun shines on the front of a triangle, at its point a + u·(b − a) + v·(c − a).
    pub(super) fn is_lit(&self, triangle: usize, [u, v]: [f64; 2]) -> Result<bool> {
        let own = &self.corners[triangle];
        let (one, u, v) = (whole(1.0)?, whole(u)?, whole(v)?);
        let weights = [&one - &u - &v, u, v];
        let point: Vector = std::array::from_fn(|k| (0..3).map(|corner| &own[corner][k] * &weights[corner]).sum());
        let blocks = |corners: &[Vector; 3]| {
            let seen = corners.each_ref().map(|corner| std::array::from_fn(|k| &corner[k] * &one - &point[k]));
            self.is_ahead(&seen)
        };
        Ok(self.facing(own) == Sign::Plus && !self.corners.iter().any(blocks))
    }

    /// Whether the open way from the origin to the sun meets the closed triangle.
    fn is_ahead(&self, corners: &[Vector; 3]) -> bool {
        // At X = t·s = αa + βb + γc, s·(a × b) is γ·det(a, b, c)/t, and det(a, b, c) = t·(n·s): signs of γ and n·s.
        let facing = self.facing(corners);
        let side = |k: usize| dot(&self.towards_sun, &cross(&corners[k], &corners[(k + 1) % 3])).sign();
        let is_inside = (0..3).map(side).all(|side| side == facing || side == Sign::NoSign);
        is_inside && dot(&normal(corners), &corners[0]).sign() == facing
    }

    fn facing(&self, corners: &[Vector; 3]) -> Sign {
        dot(&normal(corners), &self.towards_sun).sign()
    }
}

fn vector(numbers: [f64; 3]) -> Result<Vector> {
    let [x, y, z] = numbers.map(whole);
    Ok([x?, y?, z?])
}

/// The float as a multiple of 2^-[`BITS`].
fn whole(number: f64) -> Result<BigInt> {
    if number == 0.0 {
        return Ok(BigInt::ZERO);
    }
    let bits = number.abs().to_bits();
    let (exponent, fraction) = ((bits >> 52) as i32, bits & ((1 << 52) - 1));
    let shift = exponent - 1075 + BITS;
    ensure!((1..2047).contains(&exponent) && shift >= 0, "{number} has too fine a step");
    let magnitude = BigInt::from(fraction | 1 << 52) << shift;
    Ok(if number < 0.0 { -magnitude } else { magnitude })
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|k| &a[k] - &b[k])
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|k| &a[(k + 1) % 3] * &b[(k + 2) % 3] - &a[(k + 2) % 3] * &b[(k + 1) % 3])
}

fn dot(a: &Vector, b: &Vector) -> BigInt {
    (0..3).map(|k| &a[k] * &b[k]).sum()
}

fn normal([a, b, c]: &[Vector; 3]) -> Vector {
    cross(&minus(b, a), &minus(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0]];

    fn lit_under(corners: [[f64; 3]; 3], at: [f64; 2]) -> bool {
        let triangles = Triangles::new([FLOOR, corners].into_iter(), [0.25, 1.0, 0.0]).expect("short numbers");
        triangles.is_lit(0, at).expect("short numbers")
    }

    #[test]
    fn closed_triangles_hide_what_is_strictly_behind_them() {
        // From (1, 0, 1) the way runs through (1.25, 1, 1).
        let edge = |x: f64| [[x, 1.0, 0.0], [x, 1.0, 3.0], [3.0, 1.0, 1.0]];
        let at = [0.25, 0.25];
        assert!(!lit_under(edge(1.0), at));
        assert!(!lit_under(edge(1.25), at), "through an edge");
        assert!(lit_under(edge(1.25_f64.next_up()), at), "beside it");
        assert!(!lit_under(edge(1.25).map(|[x, y, z]| [x, y, 4.0 - z]), at), "from the other side");
        assert!(lit_under(edge(1.0).map(|[x, y, z]| [x - 0.5, -y, z]), at), "below");
        assert!(lit_under(edge(0.5).map(|[x, _, z]| [x, 0.0, z]), at), "contact");
    }

    #[test]
    fn backs_and_what_no_sun_sees_are_told() {
        let turned = [FLOOR[0], FLOOR[2], FLOOR[1]];
        let alone = Triangles::new([turned].into_iter(), [0.0, 1.0, 0.0]).expect("short numbers");
        assert!(!alone.is_lit(0, [0.25, 0.25]).expect("short numbers"));
        assert!(Triangles::new([FLOOR].into_iter(), [1.0, 0.0, 0.0]).is_err(), "edge-on");
        assert!(whole(1e-60).is_err());
    }

    #[test]
    fn floats_are_whole_numbers() {
        let one = BigInt::from(1) << BITS;
        for (number, expected) in [(-3.0, &one * -3), (0.75, &one * 3 / 4), (0.0, BigInt::ZERO)] {
            assert_eq!(whole(number).expect("short"), expected, "{number}");
        }
    }
}
