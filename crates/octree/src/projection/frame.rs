//! Where the rays come from, and the coordinates in which everything is projected.
//!
//! World points x become local ones, L·(x − o): for rays through a point, o is the point and the depth of p is its largest
//! coordinate, so that depth-1 points form a cube round the viewpoint, six faces with two coordinates in [−1, 1] each; a
//! picture is one such face. For parallel rays, L turns the direction into the z axis and the depth is z. L is scaled by
//! a power of two so that the scene's coordinates are at most 1 in size.
//!
//! *Error.* Which ray meets what is the same before and after a linear map, so L may be any matrix of floats; only its
//! application is rounded. With u = 2^-53 a coordinate has one rounding for x − o, one for the product, two for the sums:
//! 4u·Σ|L_k||x − o|_k. Rows for parallel rays are orthogonal to the direction up to 4u only, which moves points along a ray by as
//! much times √3. Together below 16u·max|L|·|x − o|₁.

use glam::{DMat3, DVec3};
use umbriel_geometry::{LightSource, Mesh};

use super::{ProjectionDefect, footprint::RIM};
use crate::cube::power_of_two_not_below;

/// Where rays come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Viewpoint {
    /// All directions from a point: six faces round it.
    Point(DVec3),
    /// From an eye through a picture: the points `forward + a·right + b·up` seen from `eye`, −1 ≤ a, b ≤ 1.
    Picture {
        /// Where the rays start.
        eye: DVec3,
        /// To the middle of the picture.
        forward: DVec3,
        /// From there to the middle of its right side.
        right: DVec3,
        /// From there to the middle of its upper side.
        up: DVec3,
    },
    /// Parallel rays along a direction, of any length but zero.
    Parallel(DVec3),
}

impl Viewpoint {
    /// Where the light of a source comes from.
    pub fn of_light(light: &LightSource) -> Self {
        if light.is_sun() { Self::Parallel(DVec3::ZERO - light.xyz()) } else { Self::Point(light.xyz()) }
    }

    /// What the rays would be towards: a lamp, or a sun.
    pub(super) fn light(&self) -> Option<LightSource> {
        let light = match *self {
            Self::Point(eye) | Self::Picture { eye, .. } => LightSource::point(eye.to_array()),
            Self::Parallel(direction) => LightSource::sun(direction.to_array()),
        };
        light.ok()
    }

    /// Origin, matrix with its rows in columns.
    fn axes(&self, mesh: &Mesh) -> Option<(DVec3, DMat3)> {
        match *self {
            Self::Point(point) => Some((point, DMat3::IDENTITY)),
            Self::Picture { eye, forward, right, up } => {
                let inverse = DMat3::from_cols(right, up, forward).inverse();
                Some((eye, inverse.transpose()))
            }
            Self::Parallel(direction) => {
                let along = direction.try_normalize()?;
                let (across, beside) = along.any_orthonormal_pair();
                let bounds = mesh.bounds();
                let middle = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
                Some((middle, DMat3::from_cols(across, beside, along)))
            }
        }
    }
}

/// The local coordinates of a viewpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    origin: DVec3,
    /// The rows of L.
    rows: [DVec3; 3],
    /// Bound on a local coordinate's error, over the sum of |x − o|.
    error: f64,
    pub(super) kind: Kind,
}

/// How depth is counted, and which faces there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Six faces.
    Around,
    /// The face towards +z.
    Picture,
    /// One plane; depth is z.
    Parallel,
}

impl Kind {
    /// The faces that have maps: twice the axis, and one more for its negative side.
    pub(super) fn faces(self) -> std::ops::Range<usize> {
        if self == Self::Around { 0..6 } else { 4..5 }
    }

    /// What is greater for nearer points, with its error: 1/depth, or −depth. As floats, rounded outward.
    #[inline(always)]
    pub(super) fn nearness(self, depth: f64, error: f64) -> [f32; 2] {
        if self == Self::Parallel {
            return [below(-(depth + error)), above(error - depth)];
        }
        let nearness = depth.recip();
        let share = error * nearness;
        if share.is_nan() || share > 0.25 {
            return [below((depth + error).recip()), f32::INFINITY];
        }
        // 1/(1 ± s) is within 1 ∓ s and 4s²/3 of that, s ≤ 1/4; rounding to f32 hides the rest.
        [below(nearness * (1.0 - share)), above(nearness * (1.0 + 1.5 * share))]
    }
}

/// A float of 32 bits that is certainly less; no number of what is none. Some steps off, but without the branches of `next_down`. What overflows
/// lies nearer than all planes of which anything is known.
#[inline(always)]
fn below(x: f64) -> f32 {
    (x - x.abs() * OUTWARD - f64::from(f32::MIN_POSITIVE)) as f32
}

/// A float of 32 bits that is certainly greater.
#[inline(always)]
fn above(x: f64) -> f32 {
    -below(-x)
}

/// Twice the relative error of a conversion to 32 bits.
const OUTWARD: f64 = f32::EPSILON as f64;

/// A ray of the viewpoint, or the one to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Local; its largest component is 1 in size. For parallel rays (u, v, 1).
    pub(super) direction: DVec3,
    /// Which face it crosses.
    pub(super) face: usize,
    /// Bound on the error of a component.
    pub(super) spread: f64,
    /// Depth of the point.
    pub(super) depth: f64,
    /// Bound on its error.
    pub(super) depth_error: f64,
    /// The depth before which nothing matters.
    pub(super) begin: f64,
}

impl Frame {
    pub(super) fn new(viewpoint: &Viewpoint, mesh: &Mesh) -> Result<Self, ProjectionDefect> {
        let kind = match viewpoint {
            Viewpoint::Point(_) => Kind::Around,
            Viewpoint::Picture { .. } => Kind::Picture,
            Viewpoint::Parallel(_) => Kind::Parallel,
        };
        let (origin, axes) = viewpoint.axes(mesh).ok_or(ProjectionDefect::NoView)?;
        if !axes.is_finite() || axes.determinant() == 0.0 {
            return Err(ProjectionDefect::NoView);
        }
        let mut frame = Self { origin, rows: [axes.x_axis, axes.y_axis, axes.z_axis], error: 0.0, kind };
        let reach = mesh.positions().iter().map(|&x| frame.local(x).abs().max_element()).fold(0.0, f64::max);
        if reach > 0.0 {
            let scale = power_of_two_not_below(reach).recip();
            frame.rows = frame.rows.map(|row| row * scale);
        }
        let largest = frame.rows.iter().map(|row| row.abs().max_element()).fold(0.0, f64::max);
        frame.error = 8.0 * f64::EPSILON * largest;
        Ok(frame)
    }

    /// A point in local coordinates.
    #[inline]
    pub(super) fn local(&self, x: DVec3) -> DVec3 {
        self.turn(x - self.origin)
    }

    /// The point with these local coordinates, rounded.
    pub(super) fn world(&self, local: DVec3) -> DVec3 {
        let [x, y, z] = self.rows;
        self.origin + DMat3::from_cols(x, y, z).transpose().inverse() * local
    }

    /// Bound on the error of a point's local coordinates.
    #[inline]
    pub(super) fn error_at(&self, x: DVec3) -> f64 {
        self.error * (x - self.origin).abs().element_sum()
    }

    /// A vector in local coordinates.
    #[inline]
    pub(super) fn turn(&self, vector: DVec3) -> DVec3 {
        DVec3::from_array(self.rows.map(|row| row.dot(vector)))
    }

    /// The ray of the viewpoint to a world point that is within `slack` of `x` on every axis.
    #[inline(always)]
    pub(super) fn sight_to(&self, x: DVec3, slack: f64) -> Sight {
        // What the slack does: it is a difference of points, so its image is L times it.
        let moved = self.error * slack * (3.0 / (8.0 * f64::EPSILON)) * (1.0 + 4.0 * f64::EPSILON);
        let error = self.error_at(x) + if slack > 0.0 { moved + self.error * 3.0 * slack } else { 0.0 };
        self.sight(self.local(x), error)
    }

    /// The ray from the viewpoint along a world vector; its depth is that of the vector. For rays through a point.
    #[inline]
    pub(super) fn sight_along(&self, vector: DVec3) -> Sight {
        self.sight(self.turn(vector), self.error * vector.abs().element_sum())
    }

    #[inline]
    fn sight(&self, local: DVec3, error: f64) -> Sight {
        if self.kind == Kind::Parallel {
            let (direction, begin) = (DVec3::new(local.x, local.y, 1.0), f64::NEG_INFINITY);
            return Sight { direction, face: 4, spread: error, depth: local.z, depth_error: error, begin };
        }
        let size = local.abs();
        let axis = if size.x > size.y && size.x > size.z { 0 } else { 1 + usize::from(size.z >= size.y) };
        let depth = size[axis];
        // A component and the depth are off by `error` each, which is 2s/(1 − s) ≤ 3s for s ≤ 1/4; two roundings.
        let inverse = depth.recip();
        let share = error * inverse;
        let spread = if share <= 0.25 { 3.0 * share + 2.0 * f64::EPSILON } else { f64::INFINITY };
        let face = 2 * axis + usize::from(local[axis] < 0.0);
        Sight { direction: local * inverse, face, spread, depth, depth_error: error, begin: 0.0 }
    }
}

impl Sight {
    /// The local point at a depth.
    #[inline]
    pub(super) fn at(&self, depth: f64, kind: Kind) -> DVec3 {
        if kind == Kind::Parallel { self.direction.with_z(depth) } else { self.direction * depth }
    }

    /// Whether the maps of its face have all places where it may be.
    #[inline]
    pub(super) fn is_within_maps(&self) -> bool {
        let place = self.place();
        place[0].abs().max(place[1].abs()) <= 1.0 + RIM - self.spread
    }

    /// Where on the face, −1 to 1 each.
    #[inline]
    pub(super) fn place(&self) -> [f64; 2] {
        let axis = self.face / 2;
        [self.direction[(axis + 1) % 3], self.direction[(axis + 2) % 3]]
    }
}
