//! The area of a part of a sphere's patch, with a bound.
//!
//! On the cube face, the square [u0, u1] × [v0, v1] (in −1..1) sees the solid angle
//! F(u1, v1) − F(u0, v1) − F(u1, v0) + F(u0, v0), F(u, v) = atan(u·v / √(1 + u² + v²)). A placement M stretches the
//! area at direction n by |cof(M)·n|; for similarities that is one number, otherwise it is bounded over parts of the
//! cell by its Lipschitz constant.

use umbriel_geometry::{Approx, Placement, Sphere};

use glam::{DMat3, DVec3};
use umbriel_octree::Quadrant;

/// Parts of a cell over which the stretch of a placement that is no similarity is bounded: at most 2^-LEVEL of a patch.
const STRETCH_LEVEL: u8 = 7;

/// Areas on one placed sphere.
#[derive(Clone, Debug)]
pub(crate) struct PatchArea {
    radius_squared: Approx,
    cofactors: DMat3,
    /// Least and greatest stretch, when they are equal up to rounding.
    uniform: Option<Approx>,
    greatest: f64,
}

impl PatchArea {
    /// Prepares the stretch of the placement.
    pub(crate) fn new(sphere: &Sphere, placement: &Placement) -> Self {
        let m = placement.map().matrix3;
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        // Squared stretch is nᵀ·C·n; Gershgorin's circles bound its eigenvalues.
        let c = cofactors.transpose() * cofactors;
        let mut least = f64::INFINITY;
        let mut most: f64 = 0.0;
        for k in 0..3 {
            let off = c.col(k).abs().element_sum() - c.col(k)[k].abs();
            least = least.min(c.col(k)[k] - off);
            most = most.max(c.col(k)[k] + off);
        }
        // Products, sums and cancellation in the cofactors: below 32 roundings of the largest entries.
        let rounding = 64.0 * f64::EPSILON * most;
        let (least, most) = ((least - rounding).max(0.0).sqrt(), (most + rounding).sqrt());
        let middle = 0.5 * (least + most);
        let uniform =
            Approx { value: middle, error: (most - least) * (0.5 + f64::EPSILON * 4.0) + middle * f64::EPSILON };
        let is_uniform = most - least <= middle * 1e3 * f64::EPSILON;
        let radius = Approx::exact(sphere.radius);
        Self { radius_squared: radius * radius, cofactors, uniform: is_uniform.then_some(uniform), greatest: most }
    }

    /// The area of a cell of a patch, square metres.
    pub(crate) fn of_cell(&self, patch: usize, cell: Quadrant) -> Approx {
        let (level, [i, j]) = (cell.level(), cell.coordinates());
        if let Some(stretch) = self.uniform {
            return self.radius_squared * stretch * solid_angle(level, i, j);
        }
        let finer = STRETCH_LEVEL.saturating_sub(level);
        let mut area = Approx::exact(0.0);
        for a in 0..1u32 << finer {
            for b in 0..1u32 << finer {
                let (level, i, j) = (level + finer, (i << finer) + a, (j << finer) + b);
                area = area + solid_angle(level, i, j) * self.stretch(patch, level, i, j);
            }
        }
        area * self.radius_squared
    }

    /// The stretch over a small cell: its value in the middle, give or take the greatest stretch times the way to the
    /// corners (directions on the unit sphere are closer together than points of the cube face).
    fn stretch(&self, patch: usize, level: u8, i: u32, j: u32) -> Approx {
        let edge = 1.0 / f64::from(1u32 << level);
        let middle = [i, j].map(|k| (f64::from(k) + 0.5) * edge);
        let direction: DVec3 = Sphere::direction(patch, middle[0], middle[1]).normalize();
        let value = (self.cofactors * direction).length();
        // The half diagonal of a square with edge 2·edge is √2·edge.
        let reach = self.greatest * edge * 1.4143;
        Approx { value, error: reach + self.greatest * 64.0 * f64::EPSILON }
    }
}

fn solid_angle(level: u8, i: u32, j: u32) -> Approx {
    let edge = 2.0 / f64::from(1u32 << level);
    let at = |k: u32| f64::from(k) * edge - 1.0;
    let corner = |i: u32, j: u32| {
        let (u, v) = (at(i), at(j));
        libm::atan(u * v / (1.0 + u * u + v * v).sqrt())
    };
    let value = corner(i + 1, j + 1) - corner(i, j + 1) - corner(i + 1, j) + corner(i, j);
    // Four arcus tangents of at most π/6 ≈ 0.53, each within 8 roundings, and three sums.
    Approx { value, error: 24.0 * f64::EPSILON }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;

    fn total(area: &PatchArea, level: u8) -> Approx {
        let mut sum = Approx::exact(0.0);
        for patch in 0..6 {
            for code in 0..1 << (2 * level) {
                sum = sum + area.of_cell(patch, Quadrant::from_bits(level, code).expect("a cell"));
            }
        }
        sum
    }

    #[test]
    fn the_cells_add_up_to_the_sphere() {
        let turned = DAffine3::from_quat(glam::DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize());
        let area = PatchArea::new(&Sphere { radius: 1.5 }, &Placement::new(turned).expect("regular"));
        let truth = 4.0 * std::f64::consts::PI * 1.5 * 1.5;
        for level in [0, 2, 5] {
            let sum = total(&area, level);
            assert!(sum.lower() <= truth && truth <= sum.upper(), "{sum:?}");
            assert!(sum.error < 1e-8, "{sum:?}");
        }
    }

    #[test]
    fn an_ellipsoid_is_bounded() {
        // The prolate spheroid with half axes 1, 1, 2: 2π(1 + 2/e·asin e), e = √3/2.
        let stretched = DAffine3::from_scale(DVec3::new(1.0, 1.0, 2.0));
        let area = PatchArea::new(&Sphere { radius: 1.0 }, &Placement::new(stretched).expect("regular"));
        let e = 3f64.sqrt() / 2.0;
        let truth = 2.0 * std::f64::consts::PI * (1.0 + 2.0 / e * e.asin());
        let sum = total(&area, 1);
        assert!(sum.lower() <= truth && truth <= sum.upper(), "{sum:?} holds {truth}");
        assert!(sum.error < 0.05 * truth, "{sum:?}");
    }
}
