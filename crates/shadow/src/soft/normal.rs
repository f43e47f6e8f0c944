//! Normals of planes, with what rounding may have turned them by.
//!
//! A cross product of two vectors is off by some roundings of the products of their coordinates, however small it is itself: that of
//! a sliver, or of two directions that are nearly one, may be turned by any share of it. So a normal has a bound for each coordinate,
//! and heights over its plane have bounds that hold for the exact one.

use glam::DVec3;
use umbriel_geometry::{Approx, Facets};

/// A vector across a plane, not normalised.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Normal([Approx; 3]);

impl Normal {
    /// A vector as it is.
    pub(crate) fn exact(normal: DVec3) -> Self {
        Self(exact(normal))
    }

    /// The cross product of two vectors, exact ones.
    pub(crate) fn across(u: DVec3, v: DVec3) -> Self {
        Self(cross(&exact(u), &exact(v)))
    }

    /// Of a flat face, to its front: by the winding of the placed corners.
    pub(crate) fn of_face(facets: &Facets, face: usize) -> Self {
        let numbers = facets.facet(face).corners();
        let [a, b, c] = [0, 1, numbers.len() - 1].map(|k| facets.point(numbers[k]));
        let normal = Self(cross(&b.minus(&a), &c.minus(&a)));
        if facets.is_mirrored() { normal.flipped() } else { normal }
    }

    /// To the other side.
    pub(crate) fn flipped(self) -> Self {
        Self(self.0.map(|coordinate| -coordinate))
    }

    /// The vector in floats.
    pub(crate) fn value(&self) -> DVec3 {
        self.0.map(|coordinate| coordinate.value).into()
    }

    /// How far off its coordinates may be.
    pub(crate) fn error(&self) -> DVec3 {
        self.0.map(|coordinate| coordinate.error).into()
    }

    /// The product with a vector: how far that goes to the front, times the normal's length.
    pub(crate) fn along(&self, way: [Approx; 3]) -> Approx {
        Approx::sum_of_three([0, 1, 2].map(|k| self.0[k] * way[k]))
    }

    /// The length.
    pub(crate) fn length(&self) -> Approx {
        Approx::sum_of_three(self.0.map(Approx::squared)).square_root()
    }
}

/// A vector without errors.
pub(crate) fn exact(vector: DVec3) -> [Approx; 3] {
    vector.to_array().map(Approx::exact)
}

fn cross(a: &[Approx; 3], b: &[Approx; 3]) -> [Approx; 3] {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}
