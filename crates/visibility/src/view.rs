//! Views: a camera with a picture's size, and the rays through its pixels.
//!
//! Picture coordinates are pixels from the upper left corner, x to the right, y down; pixel (i, j) covers the square
//! [i, i+1] × [j, j+1].

use glam::DVec3;
use umbriel_bvh::Ray;
use umbriel_geometry::Aabb;
use umbriel_scene::{Camera, Projection};

/// A picture to be taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye.
    pub camera: Camera,
    /// Pixels in a row; at least 1.
    pub width: u32,
    /// Rows; at least 1.
    pub height: u32,
}

/// Vertical field of view of the default camera, degrees: a short telephoto, whose verticals converge little.
const DEFAULT_FIELD_OF_VIEW: f64 = 30.0;

/// Where the default camera stands, seen from the scene: 35 degrees above the horizon, 30 degrees east of south. The
/// eye is turned away from the diagonal so that the two visible sides of a box differ.
const DEFAULT_ELEVATION: f64 = 35.0;
const DEFAULT_TURN: f64 = 30.0;

/// Free border around the scene, as a share of the distance.
const DEFAULT_MARGIN: f64 = 1.06;

impl View {
    /// A three-quarter view from above that frames all of `boxes`: the closest pinhole, along a fixed direction, that
    /// has every corner of every box in its picture. Empty boxes do not count; without any, the eye looks at the
    /// origin. O(boxes).
    pub fn framing(boxes: &[Aabb], width: u32, height: u32) -> Self {
        let (elevation, turn) = (DEFAULT_ELEVATION.to_radians(), DEFAULT_TURN.to_radians());
        let (horizontal, vertical) = (elevation.cos(), elevation.sin());
        let back = DVec3::new(turn.sin() * horizontal, vertical, turn.cos() * horizontal);
        let basis = Basis::looking_along(-back, DVec3::Y);
        let projection = Projection::Perspective { vertical_degrees: DEFAULT_FIELD_OF_VIEW };
        let tangent = (0.5 * DEFAULT_FIELD_OF_VIEW).to_radians().tan();
        let tangents = [tangent * f64::from(width) / f64::from(height), tangent];
        let all = boxes.iter().copied().fold(Aabb::EMPTY, Aabb::union);
        if all.is_empty() {
            return Self { camera: Camera { eye: back, target: DVec3::ZERO, up: DVec3::Y, projection }, width, height };
        }
        let middle = all.center();
        let corners: Vec<DVec3> = boxes
            .iter()
            .filter(|bounds| !bounds.is_empty())
            .flat_map(corners)
            .map(|c| basis.local(c - middle))
            .collect();
        let spans = [span(&corners, 0, tangents[0]), span(&corners, 1, tangents[1])];
        // A scene of one point has no size; the eye then stands one metre away.
        let distance = DEFAULT_MARGIN * spans[0].distance.max(spans[1].distance);
        let distance = if distance > 0.0 { distance } else { 1.0 };
        let target = middle + spans[0].center * basis.right + spans[1].center * basis.up;
        let camera = Camera { eye: target + distance * back, target, up: DVec3::Y, projection };
        Self { camera, width, height }
    }

    /// The ray through a point of the picture, in pixels. Its direction has unit length in perspective and parallel
    /// views alike, so distances along it are metres.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let basis = Basis::looking_along(self.camera.target - self.camera.eye, self.camera.up);
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        // Heights of the picture from its middle, up and to the right.
        let (right, up) = ((x - 0.5 * width) / height, (0.5 * height - y) / height);
        match self.camera.projection {
            Projection::Orthographic { height } => {
                Ray::new(self.camera.eye + height * (right * basis.right + up * basis.up), basis.forward)
            }
            Projection::Perspective { vertical_degrees } => {
                let scale = 2.0 * (0.5 * vertical_degrees).to_radians().tan();
                let direction = basis.forward + scale * (right * basis.right + up * basis.up);
                Ray::new(self.camera.eye, direction.normalize())
            }
            _ => Ray::new(self.camera.eye, basis.forward),
        }
    }
}

/// The eye's axes, orthonormal.
struct Basis {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
}

impl Basis {
    fn looking_along(forward: DVec3, up: DVec3) -> Self {
        let forward = forward.normalize_or(DVec3::NEG_Z);
        // A view along `up` has no right side of its own; any will do.
        let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        Self { right, up: right.cross(forward), forward }
    }

    fn local(&self, vector: DVec3) -> DVec3 {
        DVec3::new(self.right.dot(vector), self.up.dot(vector), self.forward.dot(vector))
    }
}

fn corners(bounds: &Aabb) -> [DVec3; 8] {
    let ends = [bounds.min, bounds.max];
    std::array::from_fn(|i| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2 & 1].z))
}

/// How far back the eye must stand along one axis of the picture, and where its middle then is.
struct Span {
    distance: f64,
    center: f64,
}

/// The point (a, depth) is seen from (c, −d) within the tangent t when |a − c| ≤ (d + depth)·t. So c lies between the
/// greatest a − depth·t, less d·t, and the least a + depth·t, plus d·t; the least d makes both ends equal.
fn span(corners: &[DVec3], axis: usize, tangent: f64) -> Span {
    let ends = |sign: f64| corners.iter().map(move |corner| corner[axis] + sign * corner.z * tangent);
    let low = ends(-1.0).fold(f64::NEG_INFINITY, f64::max);
    let high = ends(1.0).fold(f64::INFINITY, f64::min);
    Span { distance: (low - high) / (2.0 * tangent), center: 0.5 * (low + high) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection) -> Camera {
        Camera { eye: DVec3::new(0.0, 0.0, 10.0), target: DVec3::ZERO, up: DVec3::Y, projection }
    }

    #[test]
    fn rays_go_where_the_pixels_are() {
        let view = View { camera: camera(Projection::Perspective { vertical_degrees: 90.0 }), width: 200, height: 100 };
        assert_eq!(view.ray(100.0, 50.0).direction, DVec3::NEG_Z);
        let corner = view.ray(200.0, 0.0);
        assert!(
            (corner.origin + 10.0 * 6.0_f64.sqrt() * corner.direction - DVec3::new(20.0, 10.0, 0.0)).length() < 1e-12
        );
        let view = View { camera: camera(Projection::Orthographic { height: 4.0 }), width: 200, height: 100 };
        let corner = view.ray(0.0, 100.0);
        assert_eq!((corner.origin, corner.direction), (DVec3::new(-4.0, -2.0, 10.0), DVec3::NEG_Z));
    }

    #[test]
    fn the_default_camera_has_everything_in_its_picture_and_no_room_to_spare() {
        let boxes = [
            Aabb { min: DVec3::new(1e6, 0.0, -5.0), max: DVec3::new(1e6 + 40.0, 0.0, 35.0) },
            Aabb { min: DVec3::new(1e6 + 10.0, 0.0, 10.0), max: DVec3::new(1e6 + 13.0, 30.0, 12.0) },
            Aabb::EMPTY,
        ];
        let view = View::framing(&boxes, 300, 200);
        let basis = Basis::looking_along(view.camera.target - view.camera.eye, view.camera.up);
        let tangent = (0.5 * DEFAULT_FIELD_OF_VIEW).to_radians().tan();
        let mut widest: f64 = 0.0;
        for corner in boxes[..2].iter().flat_map(corners) {
            let seen = basis.local(corner - view.camera.eye);
            let (x, y) = (seen.x / seen.z / tangent / 1.5, seen.y / seen.z / tangent);
            assert!(seen.z > 0.0 && x.abs() <= 1.0 && y.abs() <= 1.0, "({x}, {y})");
            widest = widest.max(x.abs()).max(y.abs());
        }
        assert!(widest > 0.9, "{widest}");
    }
}
