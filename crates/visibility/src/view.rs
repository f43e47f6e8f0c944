//! Views: a camera with a picture's size, and the rays through its pixels.
//!
//! Picture coordinates are pixels from the upper left corner, x to the right, y down; pixel (i, j) covers the square
//! [i, i+1] × [j, j+1].

use glam::DVec3;
use umbriel_bvh::Ray;
use umbriel_geometry::Aabb;
use umbriel_scene::{Camera, Object, Projection, Scene, Shape};

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
    /// The scene through its own camera, else framed ([`View::framing`]) by what it holds: mesh vertices, and the corners
    /// of the boxes round other bodies. O(vertices).
    pub fn of(scene: &Scene, width: u32, height: u32) -> Self {
        match scene.camera {
            Some(camera) => Self { camera, width, height },
            None => Self::around(scene, DEFAULT_TURN, DEFAULT_ELEVATION, width, height),
        }
    }

    /// The scene framed from another side: `turn` degrees east of south, `elevation` degrees above the horizon; its own
    /// camera is not asked. O(vertices).
    pub fn around(scene: &Scene, turn: f64, elevation: f64, width: u32, height: u32) -> Self {
        Self::framing_from(scene.objects.iter().flat_map(outline), [turn, elevation], [width, height])
    }

    /// A three-quarter view from above that frames all `points` (metres): the closest pinhole, along a fixed direction,
    /// that has every one of them in its picture. Without points the eye looks at the origin. O(points).
    pub fn framing(points: impl IntoIterator<Item = DVec3>, width: u32, height: u32) -> Self {
        Self::framing_from(points, [DEFAULT_TURN, DEFAULT_ELEVATION], [width, height])
    }

    fn framing_from(points: impl IntoIterator<Item = DVec3>, degrees: [f64; 2], [width, height]: [u32; 2]) -> Self {
        let [turn, elevation] = degrees.map(f64::to_radians);
        let (horizontal, vertical) = (elevation.cos(), elevation.sin());
        let back = DVec3::new(turn.sin() * horizontal, vertical, turn.cos() * horizontal);
        let basis = Basis::looking_along(-back, DVec3::Y);
        let tangent = (0.5 * DEFAULT_FIELD_OF_VIEW).to_radians().tan();
        let mut points = points.into_iter().peekable();
        // Far from the world's origin, differences to a point of the scene keep their digits.
        let anchor = points.peek().copied().unwrap_or(DVec3::ZERO);
        let mut spans = [Span::new(tangent * f64::from(width) / f64::from(height)), Span::new(tangent)];
        for point in points {
            let seen = basis.local(point - anchor);
            spans[0].add(seen.x, seen.z);
            spans[1].add(seen.y, seen.z);
        }
        let distance = DEFAULT_MARGIN * spans[0].distance().max(spans[1].distance());
        let (target, distance) = if distance > 0.0 && distance.is_finite() {
            (anchor + spans[0].center() * basis.right + spans[1].center() * basis.up, distance)
        } else {
            // No point, or all in one place: no size to go by.
            (anchor, 1.0)
        };
        let projection = Projection::Perspective { vertical_degrees: DEFAULT_FIELD_OF_VIEW };
        let camera = Camera { eye: target + distance * back, target, up: DVec3::Y, projection };
        Self { camera, width, height }
    }

    /// The ray through a point of the picture, in pixels. Its direction has unit length in perspective and parallel
    /// views alike, so distances along it are metres. For many, [`View::rays`].
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        self.rays().through(x, y)
    }

    /// All rays of the picture: what they have in common is computed once.
    pub fn rays(&self) -> EyeRays {
        let scale = match self.camera.projection {
            Projection::Orthographic { height } => height,
            Projection::Perspective { vertical_degrees } => 2.0 * (0.5 * vertical_degrees).to_radians().tan(),
            _ => 0.0,
        };
        EyeRays { view: *self, basis: self.basis(), scale }
    }
}

/// The rays through the points of a picture.
#[derive(Clone, Copy, Debug)]
pub struct EyeRays {
    view: View,
    basis: Basis,
    /// Height of the picture, metres; in perspective that at a distance of one.
    scale: f64,
}

impl EyeRays {
    /// The view that they are the rays of.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// [`View::ray`].
    #[inline]
    pub fn through(&self, x: f64, y: f64) -> Ray {
        let Self { view: View { camera, width, height }, basis, scale } = self;
        let (width, height) = (f64::from(*width), f64::from(*height));
        // Heights of the picture from its middle, up and to the right.
        let (right, up) = ((x - 0.5 * width) / height, (0.5 * height - y) / height);
        let across = *scale * (right * basis.right + up * basis.up);
        match camera.projection {
            Projection::Perspective { .. } => Ray::new(camera.eye, (basis.forward + across).normalize()),
            _ => Ray::new(camera.eye + across, basis.forward),
        }
    }

    /// The ray through the middle of a pixel, by its column and row.
    #[inline]
    pub(crate) fn of_pixel(&self, (column, row): (u32, u32)) -> Ray {
        self.through(f64::from(column) + 0.5, f64::from(row) + 0.5)
    }
}

/// The rays of a view as a whole.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Beam {
    /// From the eye to the points `forward ± right ± up` seen from it.
    Perspective { eye: DVec3, forward: DVec3, right: DVec3, up: DVec3 },
    /// All along one direction.
    Parallel { direction: DVec3 },
}

impl View {
    /// The axes that [`View::ray`] goes by.
    pub(crate) fn basis(&self) -> Basis {
        Basis::looking_along(self.camera.target - self.camera.eye, self.camera.up)
    }

    /// All its rays: their origin or direction has the very bits that [`View::ray`] gives it.
    pub(crate) fn beam(&self) -> Beam {
        let middle = self.ray(0.5 * f64::from(self.width), 0.5 * f64::from(self.height));
        let Projection::Perspective { vertical_degrees } = self.camera.projection else {
            return Beam::Parallel { direction: middle.direction };
        };
        let basis = self.basis();
        let half = (0.5 * vertical_degrees).to_radians().tan();
        let right = half * f64::from(self.width) / f64::from(self.height) * basis.right;
        Beam::Perspective { eye: middle.origin, forward: basis.forward, right, up: half * basis.up }
    }
}

/// The eye's axes, orthonormal but for rounding.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Basis {
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) forward: DVec3,
}

impl Basis {
    fn looking_along(forward: DVec3, up: DVec3) -> Self {
        let forward = forward.normalize_or(DVec3::NEG_Z);
        // A view along `up` has no right side of its own; any will do.
        let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        Self { right, up: right.cross(forward), forward }
    }

    pub(crate) fn local(&self, vector: DVec3) -> DVec3 {
        DVec3::new(self.right.dot(vector), self.up.dot(vector), self.forward.dot(vector))
    }
}

/// Points whose convex hull holds the object (for meshes, up to rounding).
fn outline(object: &Object) -> Vec<DVec3> {
    let map = object.placement.map();
    match &object.shape {
        Shape::Mesh(mesh) => {
            let corners = mesh.triangles().iter().flatten().map(|&corner| mesh.positions()[corner as usize]);
            corners.map(|position| map.transform_point3(position)).collect()
        }
        _ => Some(object.bounds())
            .filter(|bounds| !bounds.is_empty())
            .map_or(Vec::new(), |bounds| corners(&bounds).to_vec()),
    }
}

/// The corners of a box.
pub(crate) fn corners(bounds: &Aabb) -> [DVec3; 8] {
    let ends = [bounds.min, bounds.max];
    std::array::from_fn(|i| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2 & 1].z))
}

/// How far back the eye must stand along one axis of the picture, and where its middle then is.
///
/// The point (a, depth) is seen from (c, −d) within the tangent t when |a − c| ≤ (d + depth)·t. So c lies between the
/// greatest a − depth·t, less d·t, and the least a + depth·t, plus d·t; the least d makes both ends equal.
struct Span {
    tangent: f64,
    low: f64,
    high: f64,
}

impl Span {
    fn new(tangent: f64) -> Self {
        Self { tangent, low: f64::NEG_INFINITY, high: f64::INFINITY }
    }

    fn add(&mut self, along: f64, depth: f64) {
        self.low = self.low.max(along - depth * self.tangent);
        self.high = self.high.min(along + depth * self.tangent);
    }

    fn distance(&self) -> f64 {
        (self.low - self.high) / (2.0 * self.tangent)
    }

    fn center(&self) -> f64 {
        0.5 * (self.low + self.high)
    }
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
        ];
        let view = View::framing(boxes.iter().flat_map(corners), 300, 200);
        let basis = Basis::looking_along(view.camera.target - view.camera.eye, view.camera.up);
        let tangent = (0.5 * DEFAULT_FIELD_OF_VIEW).to_radians().tan();
        let mut widest: f64 = 0.0;
        for corner in boxes.iter().flat_map(corners) {
            let seen = basis.local(corner - view.camera.eye);
            let (x, y) = (seen.x / seen.z / tangent / 1.5, seen.y / seen.z / tangent);
            assert!(seen.z > 0.0 && x.abs() <= 1.0 && y.abs() <= 1.0, "({x}, {y})");
            widest = widest.max(x.abs()).max(y.abs());
        }
        assert!(widest > 0.9, "{widest}");
    }

    #[test]
    fn a_scene_without_size_still_has_a_view() {
        for points in [vec![], vec![DVec3::splat(7.0)]] {
            let camera = View::framing(points, 3, 2).camera;
            assert!((camera.eye - camera.target).length() > 0.0);
        }
    }
}
