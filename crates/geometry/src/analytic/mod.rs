//! Analytic bodies: the sphere and its kin, each bounded by parts of quadrics and planes, without tessellation.
//!
//! A body is defined about its local origin with axis +y and placed by any regular matrix; the placed body is the exact
//! image. All questions are signs of quadratic and linear forms at pulled-back points ([`Forms`]): on which side of the
//! surface a point lies, whether a segment meets it ([`PlacedAnalytic::blocks`]), which way it faces a light. For
//! drawing up areas and cells, the surface is cut into patches with a parameter square each ([`Chart`]).

mod area;
mod bounds;
mod chart;
mod crossing;
mod cut;
mod forms;
mod glance;
mod graph;
mod halved;
mod jet;
mod layout;
mod outline;
mod passage;
mod placed;
mod polynomial;
mod ray;
mod trimmed;

#[cfg(test)]
mod tests;

use crate::{aabb::Aabb, number::accept, placement::Placement};

pub use area::PatchArea;
pub use chart::{CellHull, Chart, HULL, Occupied};
pub use crossing::Crossing;
pub use forms::{Forms, LocalPoint, QuadricForm, is_nowhere_zero, linear_value};
pub use glance::Glance;
use graph::Graph;
pub(crate) use graph::HomogeneousPoint;
use layout::symmetric_form;
pub use layout::{Part, Piece, Surface, Trim};
pub use placed::PlacedAnalytic;
pub use polynomial::Root;
pub use ray::SurfaceHit;

/// A body given by formulas, in local coordinates (metres): centred at the origin, axis +y.
///
/// All but [`Analytic::Disk`] are closed. Faces, as queries name them, are patches with parameters u, v in 0..=1:
/// - sphere, ellipsoid: six, the faces −x, +x, −y, +y, −z, +z of the cube −1..1 projected from the centre;
/// - bodies of revolution: four quarters each, around +x, −z, −x, +z, of every piece of the outline from the bottom's centre
///   to the top's: bottom disk, side, top disk (those that exist). u runs counter-clockwise seen from +y, v along the
///   outline;
/// - capsule: five for the lower half sphere (sides −x, +x, −z, +z, then −y), four for the side, five for the upper half
///   sphere (sides, then +y);
/// - quadric: six where its surface looks mostly along −x, +x, −y, +y, −z, +z, with the coordinates of the other two axes in the
///   box as parameters, then the six sides of the box in the same order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Analytic {
    /// All points at most `radius` from the origin.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A sphere stretched along the axes.
    Ellipsoid {
        /// Half axes along x, y, z.
        radii: [f64; 3],
    },
    /// A circular cylinder with two flat ends.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length along y.
        height: f64,
    },
    /// A circular cone with its apex at +height/2 and a flat base.
    Cone {
        /// Radius of the base.
        radius: f64,
        /// Length along y.
        height: f64,
    },
    /// A cone cut off: two flat ends of different radii.
    Frustum {
        /// Radius at −height/2.
        bottom_radius: f64,
        /// Radius at +height/2.
        top_radius: f64,
        /// Length along y.
        height: f64,
    },
    /// A cylinder with a half sphere on either end.
    Capsule {
        /// Radius of all three.
        radius: f64,
        /// Distance between the centres of the half spheres.
        height: f64,
    },
    /// A paraboloid with its apex at +height/2, closed by a disk at −height/2.
    Paraboloid {
        /// Radius of the disk.
        radius: f64,
        /// Length along y.
        height: f64,
    },
    /// A hyperboloid of one sheet, closed by two disks: x² + z² ≤ waist² + (end² − waist²)·(2y/height)².
    Hyperboloid {
        /// Radius in the middle.
        waist_radius: f64,
        /// Radius of the disks; not less than the waist's.
        end_radius: f64,
        /// Length along y.
        height: f64,
    },
    /// A flat disk in the xz plane, front +y. It encloses nothing.
    Disk {
        /// Radius.
        radius: f64,
    },
    /// All points of a box where xᵀQx ≤ 0, x = (x, y, z, 1); closed where the box cuts it.
    Quadric {
        /// Q by rows; only its symmetric part counts.
        matrix: [[f64; 4]; 4],
        /// Least and greatest corner of the box. An object has its body in the [trimmed](Analytic::trimmed) one, over whose sides its faces count u and v.
        within: [[f64; 3]; 2],
    },
}

/// Why an analytic body is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AnalyticDefect {
    /// A radius or height.
    #[error("its {name} is not a positive number between 2^-200 and 2^200")]
    Size {
        /// Which.
        name: &'static str,
    },
    /// A hyperboloid that is thicker in the middle than at its ends.
    #[error("its end radius is smaller than its waist radius")]
    Waist,
    /// An entry of a quadric's matrix.
    #[error("entry {column} of row {row} of its matrix is not an accepted number")]
    Entry {
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
    },
    /// A quadric that is the same everywhere.
    #[error("its matrix has no term of first or second degree")]
    Constant,
    /// A box without extent along an axis.
    #[error("its box has no extent along axis {axis}, or a corner that is not an accepted number")]
    Within {
        /// 0, 1 or 2.
        axis: usize,
    },
}

impl Analytic {
    /// Whether the numbers describe a body.
    ///
    /// # Errors
    /// [`AnalyticDefect`].
    pub fn check(&self) -> Result<(), AnalyticDefect> {
        if let Self::Quadric { matrix, within } = self {
            return check_quadric(matrix, within);
        }
        if let Some(&(name, _)) = self.sizes().iter().find(|(_, size)| accept(*size).is_err() || *size <= 0.0) {
            return Err(AnalyticDefect::Size { name });
        }
        match self {
            Self::Hyperboloid { waist_radius, end_radius, .. } if end_radius < waist_radius => {
                Err(AnalyticDefect::Waist)
            }
            _ => Ok(()),
        }
    }

    /// The same body: a quadric whose box is much longer than what is in it, in a shorter one. The numbers are to be [checked](Self::check).
    pub fn trimmed(&self) -> Self {
        match self {
            Self::Quadric { matrix, within } => {
                Self::Quadric { matrix: *matrix, within: trimmed::trimmed(matrix, within) }
            }
            _ => *self,
        }
    }

    /// What the kind of body is called.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Ellipsoid { .. } => "ellipsoid",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Frustum { .. } => "frustum",
            Self::Capsule { .. } => "capsule",
            Self::Paraboloid { .. } => "paraboloid",
            Self::Hyperboloid { .. } => "hyperboloid",
            Self::Disk { .. } => "disk",
            Self::Quadric { .. } => "quadric",
        }
    }

    /// The radii and heights with their names; none for a quadric.
    fn sizes(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Sphere { radius } | Self::Disk { radius } => vec![("radius", radius)],
            Self::Ellipsoid { radii: [x, y, z] } => {
                vec![("radius along x", x), ("radius along y", y), ("radius along z", z)]
            }
            Self::Cylinder { radius, height }
            | Self::Cone { radius, height }
            | Self::Capsule { radius, height }
            | Self::Paraboloid { radius, height } => vec![("radius", radius), ("height", height)],
            Self::Frustum { bottom_radius, top_radius, height } => {
                vec![("bottom radius", bottom_radius), ("top radius", top_radius), ("height", height)]
            }
            Self::Hyperboloid { waist_radius, end_radius, height } => {
                vec![("waist radius", waist_radius), ("end radius", end_radius), ("height", height)]
            }
            Self::Quadric { .. } => Vec::new(),
        }
    }

    /// The numbers that it is given by, in the order of its fields.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Quadric { matrix, within } => [matrix.as_flattened(), within.as_flattened()].concat(),
            _ => self.sizes().into_iter().map(|(_, size)| size).collect(),
        }
    }

    /// Half the extent along x, y, z of a box about the origin (a quadric: about its box's middle) that holds the body.
    pub fn half_extent(&self) -> [f64; 3] {
        match *self {
            Self::Sphere { radius } => [radius; 3],
            Self::Ellipsoid { radii } => radii,
            Self::Disk { radius } => [radius, 0.0, radius],
            Self::Cylinder { radius, height } | Self::Cone { radius, height } | Self::Paraboloid { radius, height } => {
                [radius, 0.5 * height, radius]
            }
            Self::Frustum { bottom_radius, top_radius, height } => {
                let radius = bottom_radius.max(top_radius);
                [radius, 0.5 * height, radius]
            }
            Self::Capsule { radius, height } => [radius, 0.5 * height + radius, radius],
            Self::Hyperboloid { end_radius, height, .. } => [end_radius, 0.5 * height, end_radius],
            Self::Quadric { within: [low, high], .. } => std::array::from_fn(|k| low[k].abs().max(high[k].abs())),
        }
    }

    /// The tight world box of the placed body, rounded outward.
    pub fn bounds(&self, placement: &Placement) -> Aabb {
        bounds::of(self, placement)
    }

    /// Number of patches of its surface, as faces are numbered.
    pub fn face_count(&self) -> usize {
        match self {
            // Making its patches takes exact arithmetic.
            Self::Quadric { .. } => Graph::COUNT,
            _ => chart::charts(self).len(),
        }
    }

    /// Whether the surface encloses a volume.
    pub fn is_closed(&self) -> bool {
        !matches!(self, Self::Disk { .. })
    }

    /// Whether it has an inside. A disk has none, nor has a quadric that is negative nowhere: its body is a plane, a line or a point counted
    /// twice, or nothing at all. Exact.
    pub fn has_inside(&self) -> bool {
        match self {
            Self::Disk { .. } => false,
            Self::Quadric { matrix, .. } => !symmetric_form(matrix, 1.0).is_nowhere_negative(),
            _ => true,
        }
    }

    /// Whether the body is convex by its kind.
    pub fn is_convex(&self) -> bool {
        match self {
            Self::Hyperboloid { waist_radius, end_radius, .. } => waist_radius == end_radius,
            Self::Quadric { .. } => false,
            _ => true,
        }
    }
}

fn check_quadric(matrix: &[[f64; 4]; 4], within: &[[f64; 3]; 2]) -> Result<(), AnalyticDefect> {
    for (row, entries) in matrix.iter().enumerate() {
        if let Some(column) = entries.iter().position(|&entry| accept(entry).is_err()) {
            return Err(AnalyticDefect::Entry { row, column });
        }
    }
    let is_bad = |axis: usize| {
        let [low, high] = [within[0][axis], within[1][axis]];
        accept(low).is_err() || accept(high).is_err() || low >= high
    };
    if let Some(axis) = (0..3).find(|&axis| is_bad(axis)) {
        return Err(AnalyticDefect::Within { axis });
    }
    let symmetric = |i: usize, j: usize| matrix[i][j] + matrix[j][i];
    let is_constant = (0..3).all(|i| (i..4).all(|j| symmetric(i, j) == 0.0));
    if is_constant { Err(AnalyticDefect::Constant) } else { Ok(()) }
}
