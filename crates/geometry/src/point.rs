//! Points that are known exactly, and the floats that stand for them in filters.

use glam::DVec3;

use crate::{
    approx::Approx,
    dyadic::Dyadic,
    light::LightSource,
    ring::{Ring, Sign},
};

/// A homogeneous point with exact coordinates: (x, y, z)/w, w > 0; w = 0 only for a direction (a sun).
#[derive(Clone, Debug)]
pub struct ExactPoint<R = Dyadic> {
    /// Homogeneous x, y, z.
    pub xyz: [R; 3],
    /// The weight.
    pub w: R,
}

impl<R: Ring> ExactPoint<R> {
    /// The point with these float coordinates.
    pub fn from_position(position: DVec3) -> Self {
        Self { xyz: position.to_array().map(R::from_f64), w: R::from_f64(1.0) }
    }

    /// A light's homogeneous point.
    pub fn from_light(light: &LightSource) -> Self {
        Self { xyz: light.xyz().to_array().map(R::from_f64), w: R::from_f64(light.w()) }
    }
}

impl ExactPoint<Dyadic> {
    /// The point for predicates, floats and all; its weight must be one.
    pub fn bounded(&self) -> Point<'_> {
        let nearest = self.xyz.each_ref().map(Dyadic::to_nearest);
        let slack = std::array::from_fn(|k| {
            let is_exact = (self.xyz[k].clone() - Dyadic::new(nearest[k])).sign() == Sign::Zero;
            // Correctly rounded: at most half an ulp off; a whole one is a safe bound.
            if is_exact { 0.0 } else { nearest[k].abs().next_up() - nearest[k].abs() }
        });
        Point { position: nearest.into(), slack: DVec3::from_array(slack), exact: Some(self) }
    }

    /// The same point over a larger ring.
    pub fn lifted<R: Ring>(&self) -> ExactPoint<R> {
        ExactPoint { xyz: self.xyz.clone().map(R::from), w: R::from(self.w.clone()) }
    }
}

/// A point for the predicates: a float position, how far each coordinate may be off, and the exact point when the
/// position is not it.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a> {
    /// World coordinates, metres.
    pub position: DVec3,
    /// Bound on |exact − position|, per coordinate.
    pub slack: DVec3,
    /// The exact point; `None` means that `position` is exact.
    pub exact: Option<&'a ExactPoint>,
}

impl Point<'static> {
    /// A point whose float coordinates are exact.
    pub fn exact(position: DVec3) -> Self {
        Self { position, slack: DVec3::ZERO, exact: None }
    }
}

impl Point<'_> {
    /// The exact point over the ring `R`.
    pub fn to_exact<R: Ring>(&self) -> ExactPoint<R> {
        match self.exact {
            Some(exact) => exact.lifted(),
            None => ExactPoint::from_position(self.position),
        }
    }

    /// The coordinates as the filters see them.
    pub fn coordinates(&self) -> [Approx; 3] {
        let (p, s) = (self.position, self.slack);
        [Approx { value: p.x, error: s.x }, Approx { value: p.y, error: s.y }, Approx { value: p.z, error: s.z }]
    }
}
