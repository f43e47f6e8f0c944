//! The convex body of a scene: points, of which the hull is taken after they are placed.

use glam::DVec3;

use super::{Brep, HullDefect};
use crate::{Aabb, Placement, number::accept_point};

/// A convex body given by points in local coordinates, metres.
///
/// The body in the world is the hull of the placed points, each correctly rounded ([`Placement::round`]). So all points
/// are kept: rounding may lift a point out of a face that it lies in.
#[derive(Clone, Debug, PartialEq)]
pub struct Convex {
    points: Vec<DVec3>,
}

impl Convex {
    /// Checks and takes points: accepted numbers, four of which do not lie in one plane. Takes as long as
    /// [`Brep::hull`].
    ///
    /// # Errors
    /// [`HullDefect`], for the points as they are given.
    pub fn new(points: Vec<[f64; 3]>) -> Result<Self, HullDefect> {
        let accepted = points.into_iter().enumerate().map(|(point, position)| {
            accept_point(position).map_err(|(axis, defect)| HullDefect::Coordinate { point, axis, defect })
        });
        let points = accepted.collect::<Result<Vec<_>, _>>()?;
        Brep::hull(points.iter().copied())?;
        Ok(Self { points })
    }

    /// The points, local coordinates, in the order given.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The box of the points, local coordinates.
    pub fn bounds(&self) -> Aabb {
        Aabb::of(self.points.iter().copied())
    }

    /// The body in the world. A mirroring placement needs no care: the hull's faces look outward all the same.
    ///
    /// # Errors
    /// [`HullDefect`] when a placed point leaves the accepted range, or when the placed points lie in one plane after
    /// rounding (a thin body far from the origin). Whoever places the body refuses it then, as a singular matrix.
    pub fn placed(&self, placement: &Placement) -> Result<Brep, HullDefect> {
        Brep::hull(self.points.iter().map(|&point| placement.round(point)))
    }
}
