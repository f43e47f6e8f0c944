//! Numbers for planes: faces of one plane have one number, so sorting finds the faces that may overlap.
//!
//! Planes are compared without rounding by computing modulo the prime p = 2^61 − 1. Every float m·2^e has an exact
//! residue (2^61 ≡ 1, so a power of two is a rotation of bits), and sums and products of residues are those of the
//! exact numbers. The plane through a, b, c is n = (b − a) × (c − a), d = n·a up to a factor; divided by its first
//! component that is not zero, and folded into one residue, it is the same for all faces of the plane. Two planes share
//! a number by chance about once in 2^61 pairs; an exact test follows, so chance costs time and never an answer.
//!
//! A few hundred nanoseconds a face.

use umbriel_geometry::{ExactPoint, Facets, Point, Ring, Sign};

/// p, a Mersenne prime.
const PRIME: u64 = (1 << 61) - 1;

/// How plane coordinates are folded into one number: any factors will do.
const FOLD: [Residue; 4] = [
    Residue(0x0f1e_2d3c_4b5a_6978),
    Residue(0x1234_5678_9abc_def1),
    Residue(0x02d7_1828_1828_4591),
    Residue(0x0314_1592_6535_8979),
];

/// The number of a face's plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum PlaneKey {
    /// A face without area lies in no plane of its own.
    None,
    /// The normal vanishes modulo p although the face has area: it may lie in any plane. Takes a contrived face.
    Any,
    /// The plane's number.
    Plane(u64),
}

impl PlaneKey {
    /// Of a facet that has area.
    pub(super) fn of(facets: &Facets, facet: usize) -> Self {
        let corners = facets.facet(facet).corners();
        let [a, b, c] = [corners[0], corners[1], corners[corners.len() - 1]].map(|k| residues(&facets.point(k)));
        let (u, v): ([Residue; 3], [Residue; 3]) =
            (std::array::from_fn(|i| b[i].minus(a[i])), std::array::from_fn(|i| c[i].minus(a[i])));
        let cross = |i: usize, j: usize| u[i].times(v[j]).minus(u[j].times(v[i]));
        let normal = [cross(1, 2), cross(2, 0), cross(0, 1)];
        let Some(&pivot) = normal.iter().find(|component| component.0 != 0) else { return Self::Any };
        let along = (0..3).fold(Residue(0), |sum, i| sum.plus(normal[i].times(a[i])));
        let plane = [normal[0], normal[1], normal[2], along];
        let folded = plane.iter().zip(FOLD).fold(Residue(0), |sum, (&part, factor)| sum.plus(part.times(factor)));
        Self::Plane(folded.times(pivot.inverse()).0)
    }
}

/// A number modulo p.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Residue(u64);

impl Residue {
    /// Of a finite float, exactly.
    fn of(value: f64) -> Self {
        const FRACTION: u64 = (1 << 52) - 1;
        let bits = value.to_bits();
        let (fraction, biased) = (bits & FRACTION, (bits >> 52 & 0x7ff) as i64);
        // |value| = mantissa·2^(exponent), subnormal numbers without the leading one.
        let (mantissa, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
        let size = Self::reduced(u128::from(mantissa) << exponent.rem_euclid(61));
        if value < 0.0 { Self(0).minus(size) } else { size }
    }

    /// Of any number below 2^122.
    fn reduced(number: u128) -> Self {
        let sum = (number as u64 & PRIME) + (number >> 61) as u64;
        Self(if sum >= PRIME { sum - PRIME } else { sum })
    }

    fn plus(self, other: Self) -> Self {
        let sum = self.0 + other.0;
        Self(if sum >= PRIME { sum - PRIME } else { sum })
    }

    fn minus(self, other: Self) -> Self {
        Self(if self.0 >= other.0 { self.0 - other.0 } else { self.0 + PRIME - other.0 })
    }

    fn times(self, other: Self) -> Self {
        Self::reduced(u128::from(self.0) * u128::from(other.0))
    }

    /// x^(p − 2), by Fermat's little theorem; zero for zero.
    fn inverse(self) -> Self {
        let (mut power, mut square, mut exponent) = (Self(1), self, PRIME - 2);
        while exponent > 0 {
            if exponent & 1 == 1 {
                power = power.times(square);
            }
            square = square.times(square);
            exponent >>= 1;
        }
        power
    }
}

/// A point's coordinates.
fn residues(point: &Point) -> [Residue; 3] {
    match point.exact {
        Some(exact) => of_exact(exact.point()),
        None => point.position.to_array().map(Residue::of),
    }
}

/// An exact point's coordinates; each is the sum of the floats that are nearest to what is left of it.
fn of_exact(point: &ExactPoint) -> [Residue; 3] {
    let of = |number: &umbriel_geometry::Dyadic| {
        let (mut rest, mut sum) = (number.clone(), Residue(0));
        while rest.sign() != Sign::Zero {
            let nearest = rest.to_nearest();
            sum = sum.plus(Residue::of(nearest));
            rest = rest - umbriel_geometry::Dyadic::new(nearest);
        }
        sum
    };
    let weight = of(&point.w).inverse();
    std::array::from_fn(|i| of(&point.xyz[i]).times(weight))
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DQuat, DVec3};
    use proptest::prelude::*;
    use umbriel_geometry::{Cuboid, Mesh, Placement, Rectangle};

    use super::*;

    #[test]
    fn residues_are_exact() {
        assert_eq!(Residue::of(1.0), Residue(1));
        assert_eq!(Residue::of(f64::powi(2.0, 61)), Residue(1));
        assert_eq!(Residue::of(-1.0), Residue(PRIME - 1));
        assert_eq!(Residue::of(0.5).times(Residue(2)), Residue(1));
        assert_eq!(Residue::of(0.1).times(Residue::of(0.1).inverse()), Residue(1));
        assert_eq!(
            Residue::of(f64::from_bits(1))
                .times(Residue::of(f64::powi(2.0, 1074 / 2)))
                .times(Residue::of(f64::powi(2.0, 1074 / 2))),
            Residue(1)
        );
    }

    proptest! {
        #[test]
        fn triangles_of_one_plane_have_one_number(
            z in proptest::array::uniform6(-1000i32..1000), x in proptest::array::uniform6(-1000i32..1000), slope in -9i32..9, shift in -50i32..50,
        ) {
            // Points (x, z) on y = slope·x − 2z + 7, all times 2^shift: exact in f64.
            let scale = f64::powi(2.0, shift);
            let at = |k: usize| [x[k], slope * x[k] - 2 * z[k] + 7, z[k]].map(|n| f64::from(n) * scale);
            let mesh = Mesh::new((0..6).map(at).collect(), vec![[0, 1, 2], [3, 4, 5]]).expect("a mesh");
            let facets = Facets::of_mesh(mesh, &Placement::IDENTITY);
            prop_assume!((0..2).all(|k| facets.area(k).value > 0.0));
            prop_assert_eq!(PlaneKey::of(&facets, 0), PlaneKey::of(&facets, 1));
            let mut off = (0..6).map(at).collect::<Vec<_>>();
            // Beside zero there is only what counts as zero.
            prop_assume!(off[5][1] != 0.0);
            off[5][1] = off[5][1].next_up();
            let facets = Facets::of_mesh(Mesh::new(off, vec![[0, 1, 2], [3, 4, 5]]).expect("a mesh"), &Placement::IDENTITY);
            prop_assert_ne!(PlaneKey::of(&facets, 0), PlaneKey::of(&facets, 1));
        }
    }

    #[test]
    fn turned_boxes_know_their_planes_exactly() {
        let turned = DAffine3::from_rotation_translation(DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize(), DVec3::ONE);
        let placement = Placement::new(turned).expect("regular");
        let facets = Facets::of_cuboid(&Cuboid { size: [2.0, 4.0, 6.0] }, &placement);
        let keys: Vec<PlaneKey> = (0..6).map(|k| PlaneKey::of(&facets, k)).collect();
        // A rectangle in the plane of the box's top, y = 2.
        let top = Placement::new(turned * DAffine3::IDENTITY).expect("regular");
        let sheet = Facets::of_cuboid(&Cuboid { size: [1.0, 4.0, 1.0] }, &top);
        let other: Vec<PlaneKey> = (0..6).map(|k| PlaneKey::of(&sheet, k)).collect();
        let shared: Vec<usize> = (0..6).filter(|&k| keys.contains(&other[k])).collect();
        assert_eq!(shared, [2, 3], "bottom and top lie in the planes of the larger box");
        assert_eq!(keys.iter().collect::<std::collections::HashSet<_>>().len(), 6);
        let floor = Facets::of_rectangle(&Rectangle { size: [1.0, 1.0] }, &placement);
        assert!(!keys.contains(&PlaneKey::of(&floor, 0)), "through the middle of the box");
    }
}
