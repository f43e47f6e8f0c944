//! The eye.

use glam::DVec3;

/// How the camera maps directions to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Projection {
    /// A pinhole; the vertical field of view in degrees, between 0 and 180.
    Perspective {
        /// Vertical field of view, degrees.
        vertical_degrees: f64,
    },
    /// Parallel rays; the height of the picture in metres.
    Orthographic {
        /// Height of the picture, metres.
        height: f64,
    },
}

/// Where the eye stands and what it looks at, world coordinates in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye.
    pub eye: DVec3,
    /// A point in the middle of the picture, other than `eye`.
    pub target: DVec3,
    /// Which way is up; not parallel to the view.
    pub up: DVec3,
    /// Perspective or parallel.
    pub projection: Projection,
}
