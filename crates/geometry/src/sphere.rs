//! The sphere, placed by any regular matrix (so in the world an ellipsoid), without tessellation.
//!
//! All questions are asked of the quadratic form q(x, y) = x'·y' − r²·det²·w_x·w_y, where x' = adj(M)·(x − w_x·t) is
//! the pulled-back point: q(x, x) is negative inside, zero on the surface, positive outside.

use glam::DVec3;

use crate::{
    aabb::Aabb,
    approx::Approx,
    dyadic::Dyadic,
    placement::Placement,
    point::ExactPoint,
    ring::{Ring, Sign, dot},
    surd::Surd,
};

/// A sphere about the local origin.
///
/// Its surface is cut into six patches, the faces of the cube −1..1 projected from the centre, in the order −x, +x, −y,
/// +y, −z, +z. See [`Sphere::direction`] for a patch's parameter square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Radius, metres; positive.
    pub radius: f64,
}

impl Sphere {
    /// The direction (local, not of unit length) of the point (u, v) of a patch, u and v in 0..=1.
    ///
    /// For axis a = patch / 2 and side s = ±1, the direction has s on axis a; for s = +1 it has 2u − 1 on the next axis
    /// (cyclic) and 2v − 1 on the one after; for s = −1 these two change places, so that u × v points outward.
    pub fn direction(patch: usize, u: f64, v: f64) -> DVec3 {
        let (axis, positive) = (patch / 2, patch % 2 == 1);
        let (first, second) = if positive { (u, v) } else { (v, u) };
        let mut direction = DVec3::ZERO;
        direction[axis] = if positive { 1.0 } else { -1.0 };
        direction[(axis + 1) % 3] = 2.0 * first - 1.0;
        direction[(axis + 2) % 3] = 2.0 * second - 1.0;
        direction
    }

    /// The exact world point of a patch's (u, v) under `placement`. The parameters are taken as they are; 2u − 1 and
    /// 2v − 1 are formed exactly.
    pub fn exact_point(&self, placement: &Placement, patch: usize, u: f64, v: f64) -> ExactPoint<Surd> {
        let (axis, positive) = (patch / 2, patch % 2 == 1);
        let centred = |t: f64| Dyadic::new(2.0) * Dyadic::new(t) - Dyadic::new(1.0);
        let (first, second) = if positive { (u, v) } else { (v, u) };
        let mut direction = [Dyadic::zero(), Dyadic::zero(), Dyadic::zero()];
        direction[axis] = Dyadic::new(if positive { 1.0 } else { -1.0 });
        direction[(axis + 1) % 3] = centred(first);
        direction[(axis + 2) % 3] = centred(second);
        self.exact_point_along(placement, &direction)
    }

    /// The exact world point in a local direction (not zero) from the centre.
    fn exact_point_along(&self, placement: &Placement, direction: &[Dyadic; 3]) -> ExactPoint<Surd> {
        // x = t + (r/√(d·d))·M·d, over the common denominator d·d.
        let norm_squared = dot(direction, direction);
        let map = placement.map();
        let xyz = std::array::from_fn(|i| {
            let row = [map.matrix3.x_axis[i], map.matrix3.y_axis[i], map.matrix3.z_axis[i]].map(Dyadic::new);
            let factor = dot(&row, direction) * Dyadic::new(self.radius);
            let center = Dyadic::new(map.translation[i]) * norm_squared.clone();
            Surd::from(center) + Surd::root(factor, norm_squared.clone())
        });
        ExactPoint { xyz, w: Surd::from(norm_squared) }
    }

    /// The point of the surface that lies (in local coordinates) straight from the centre through a world point; `None`
    /// for the centre.
    pub fn radial_point(&self, placement: &Placement, through: &[Dyadic; 3]) -> Option<ExactPoint<Surd>> {
        let (adjugate, determinant) = placement.exact_adjugate::<Dyadic>();
        let translation = placement.map().translation;
        let away: [Dyadic; 3] = std::array::from_fn(|i| through[i].clone() - Dyadic::new(translation[i]));
        let inward = determinant.sign() == Sign::Negative;
        let direction = adjugate.map(|row| if inward { -dot(&row, &away) } else { dot(&row, &away) });
        let is_center = direction.iter().all(|coordinate| coordinate.sign() == Sign::Zero);
        (!is_center).then(|| self.exact_point_along(placement, &direction))
    }

    /// The points of the surface on the line from a point along a vector (not zero), both in world coordinates: none, or
    /// two (equal where the line touches).
    pub fn points_on_line(
        &self,
        placement: &Placement,
        start: &[Dyadic; 3],
        along: &[Dyadic; 3],
    ) -> Option<[ExactPoint<Surd>; 2]> {
        let form = self.exact_form::<Dyadic>(placement);
        let (one, nothing) = (Dyadic::new(1.0), Dyadic::zero());
        let (x, way) = (form.pull_back(start, &one), form.pull_back(along, &nothing));
        let (x, way) = ((&x, &one), (&way, &nothing));
        let (a, b, c) = (form.value(way, way), form.value(x, way), form.value(x, x));
        let discriminant = b.clone() * b.clone() - a.clone() * c;
        // The roots are (−b ± √discriminant)/a, with a > 0 as the weight.
        let point = |sign: f64| {
            let root = match discriminant.sign() {
                Sign::Positive => Surd::root(Dyadic::new(sign), discriminant.clone()),
                _ => Surd::from(Dyadic::zero()),
            };
            let step = root - Surd::from(b.clone());
            let xyz = std::array::from_fn(|i| {
                Surd::from(start[i].clone() * a.clone()) + Surd::from(along[i].clone()) * step.clone()
            });
            ExactPoint { xyz, w: Surd::from(a.clone()) }
        };
        (discriminant.sign() != Sign::Negative).then(|| [point(-1.0), point(1.0)])
    }

    /// A vector along the outer normal at a point of the surface: half the gradient of q.
    pub fn outward(&self, placement: &Placement, x: &ExactPoint<Surd>) -> [Surd; 3] {
        let form = self.exact_form::<Surd>(placement);
        let local = form.pull_back(&x.xyz, &x.w);
        std::array::from_fn(|k| dot(&std::array::from_fn(|i| form.adjugate[i][k].clone()), &local))
    }

    /// The tight world box, rounded outward: t ± r·|row of M|.
    pub fn bounds(&self, placement: &Placement) -> Aabb {
        let map = placement.map();
        let m = map.matrix3;
        let rows = [m.row(0), m.row(1), m.row(2)];
        // Squares, two sums, a root and a product: six roundings, below 4 ulp; one more outward for the sum.
        let reach = DVec3::from_array(rows.map(|row| self.radius * row.length() * (1.0 + 4.0 * f64::EPSILON)));
        Aabb { min: map.translation, max: map.translation }.widened(reach)
    }

    /// The quadratic form of the placed sphere, with error bounds, times a power of four: r·det becomes about one, so that
    /// products of its values stay far from underflow whatever the scale.
    pub fn form(&self, placement: &Placement) -> SphereForm<Approx> {
        let adjugate = placement.adjugate();
        let m = placement.map().matrix3;
        // det = first row of M times first column of adj(M).
        let determinant = Approx::exact(m.x_axis.x) * adjugate[0][0]
            + Approx::exact(m.y_axis.x) * adjugate[1][0]
            + Approx::exact(m.z_axis.x) * adjugate[2][0];
        let scaled_radius = Approx::exact(self.radius) * determinant;
        // The exponent with its sign turned.
        let factor = f64::from_bits((2046 << 52) - (scaled_radius.value.abs().to_bits() & (0x7ff << 52)));
        let scaled = |number: Approx| Approx { value: number.value * factor, error: number.error * factor };
        let (determinant, scaled_radius) = (scaled(determinant), scaled(scaled_radius));
        SphereForm {
            adjugate: adjugate.map(|row| row.map(scaled)),
            translation: placement.map().translation.to_array().map(Approx::exact),
            determinant,
            radius_squared: scaled_radius * scaled_radius,
        }
    }

    /// The quadratic form of the placed sphere, exact.
    pub fn exact_form<R: Ring>(&self, placement: &Placement) -> SphereForm<R> {
        let (adjugate, determinant) = placement.exact_adjugate::<R>();
        let scaled_radius = R::from_f64(self.radius) * determinant.clone();
        SphereForm {
            adjugate,
            translation: placement.map().translation.to_array().map(R::from_f64),
            determinant,
            radius_squared: scaled_radius.clone() * scaled_radius,
        }
    }
}

/// The quadratic form q of a placed sphere over the numbers `T`.
#[derive(Clone, Debug)]
pub struct SphereForm<T> {
    adjugate: [[T; 3]; 3],
    translation: [T; 3],
    determinant: T,
    radius_squared: T,
}

impl SphereForm<Approx> {
    /// The pulled-back point of a local point: itself, times the determinant of the placement.
    pub fn lift(&self, local: &[Approx; 3]) -> [Approx; 3] {
        local.map(|coordinate| coordinate * self.determinant)
    }
}

impl<T> SphereForm<T>
where
    T: Clone + std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Mul<Output = T>,
{
    /// The pulled-back point x' of a homogeneous point.
    pub fn pull_back(&self, xyz: &[T; 3], w: &T) -> [T; 3] {
        let d: [T; 3] = std::array::from_fn(|i| xyz[i].clone() - w.clone() * self.translation[i].clone());
        std::array::from_fn(|i| {
            let row = &self.adjugate[i];
            row[0].clone() * d[0].clone() + row[1].clone() * d[1].clone() + row[2].clone() * d[2].clone()
        })
    }

    /// q(x, y) of two pulled-back points with their weights.
    pub fn value(&self, x: (&[T; 3], &T), y: (&[T; 3], &T)) -> T {
        let product = |i: usize| x.0[i].clone() * y.0[i].clone();
        product(0) + product(1) + product(2) - self.radius_squared.clone() * x.1.clone() * y.1.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DQuat};

    #[test]
    fn points_of_patches_lie_exactly_on_the_surface() {
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0, 2.0, -0.3),
            DQuat::from_xyzw(0.5, 0.1, -0.7, 0.5).normalize(),
            DVec3::new(1e6, -3.0, 0.1),
        );
        let placement = Placement::new(map).expect("regular");
        let sphere = Sphere { radius: 0.7 };
        let form = sphere.exact_form::<Surd>(&placement);
        let bounds = sphere.bounds(&placement);
        for patch in 0..6 {
            for (u, v) in [(0.0, 0.0), (0.3, 0.9), (1.0, 0.5), (1e-9, 0.123)] {
                let x = sphere.exact_point(&placement, patch, u, v);
                let local = form.pull_back(&x.xyz, &x.w);
                let q = form.value((&local, &x.w), (&local, &x.w));
                assert_eq!(q.sign(), Sign::Zero, "patch {patch} at ({u}, {v})");
                let direction = Sphere::direction(patch, u, v).normalize();
                assert!(bounds.contains(map.transform_point3(direction * sphere.radius)));
            }
        }
    }

    #[test]
    fn the_filter_agrees_with_the_exact_form() {
        let placement = Placement::new(DAffine3::from_translation(DVec3::new(3.0, 4.0, 5.0))).expect("regular");
        let sphere = Sphere { radius: 2.0 };
        let (form, exact) = (sphere.form(&placement), sphere.exact_form::<Dyadic>(&placement));
        for (point, sign) in
            [([3.0, 4.0, 7.0], Sign::Zero), ([3.0, 4.0, 7.1], Sign::Positive), ([3.0, 4.0, 6.9], Sign::Negative)]
        {
            let w = Dyadic::new(1.0);
            let x = exact.pull_back(&point.map(Dyadic::new), &w);
            assert_eq!(exact.value((&x, &w), (&x, &w)).sign(), sign);
            let one = Approx::exact(1.0);
            let x = form.pull_back(&point.map(Approx::exact), &one);
            let filtered = form.value((&x, &one), (&x, &one)).sign();
            assert!(filtered.is_none_or(|s| s == sign), "{filtered:?} is not {sign:?}");
        }
    }
}
