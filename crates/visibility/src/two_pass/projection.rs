//! One receiving face: its plane, and what occluders cover of it.
//!
//! An occluder is a convex polygon. Corners are before the receiver's plane by exact signs; where an edge goes through the plane it is cut
//! in floats. Then it is cut by the planes through the light and each edge of a rectangle round the receiver, so that all of its projection lies in the
//! rectangle, and is projected: along the sun's direction, or from the lamp at height H, which stretches what lies at height h by H/(H − h).
//!
//! The rectangle lies along the plane's axes. All that is cut at an edge of it has one coordinate in common, which stays so on the overlay's grid; cut at the slanted
//! edges of the receiver itself, borders of many covers would lie almost in a line, and a sweep would find them crossing each other thousands of times.

use glam::DVec3;
use umbriel_bvh::Ray;
use umbriel_geometry::{Aabb, Facets, LightSource, Point, Sign, predicates};

use crate::polygon::cut;

/// A face that light falls on.
pub(super) struct Receiver<'a> {
    light: &'a LightSource,
    pub(super) origin: DVec3,
    pub(super) axes: [DVec3; 2],
    /// Towards the light's side.
    normal: DVec3,
    /// Counter-clockwise seen from the light.
    corners: Vec<DVec3>,
    /// Least and greatest plane coordinates of a rectangle round it.
    rectangle: [[f64; 2]; 2],
    /// Three exact corners of the plane, the light in front.
    plane: [Point<'a>; 3],
    pub(super) bounds: Aabb,
}

impl<'a> Receiver<'a> {
    pub(super) fn new(facets: &'a Facets, face: usize, light: &'a LightSource) -> Self {
        let numbers: Vec<u32> = facets.facet(face).corners().iter().copied().collect();
        let mut points: Vec<Point> = numbers.into_iter().map(|number| facets.point(number)).collect();
        let plane = |points: &[Point<'a>]| [points[0], points[1], points[points.len() - 1]];
        let [a, b, c] = plane(&points);
        if predicates::light_side(&a, &b, &c, light) == Sign::Negative {
            points.reverse();
        }
        let corners: Vec<DVec3> = points.iter().map(|point| point.position).collect();
        let (along, across) = (corners[1] - corners[0], corners[corners.len() - 1] - corners[0]);
        let normal = along.cross(across).normalize_or_zero();
        let first = along.normalize_or_zero();
        let axes = [first, normal.cross(first)];
        let bounds = facets.facet_bounds(face);
        let rectangle = [[0.0; 2]; 2];
        let mut receiver =
            Self { light, origin: corners[0], axes, normal, plane: plane(&points), corners, rectangle, bounds };
        receiver.rectangle = around(&receiver.outline());
        receiver
    }

    fn flat(&self, point: DVec3) -> [f64; 2] {
        self.axes.map(|axis| axis.dot(point - self.origin))
    }

    /// Its own outline in plane coordinates.
    pub(super) fn outline(&self) -> Vec<[f64; 2]> {
        self.corners.iter().map(|&corner| self.flat(corner)).collect()
    }

    /// How much area may be off along a contour: by the grid of 2^-28 of the rectangle's extent that the overlay rounds to, and by floats that a projection stretches.
    pub(super) fn slack(&self, contour: &[[f64; 2]], stretch: f64) -> f64 {
        let [low, high] = self.rectangle;
        let extent = (high[0] - low[0]).max(high[1] - low[1]);
        let reach = self.bounds.max.abs().max(self.bounds.min.abs()).max_element();
        let off = extent * GRID + 256.0 * f64::EPSILON * (reach + extent) * stretch;
        let edges = contour.iter().zip(contour.iter().cycle().skip(1));
        4.0 * off * edges.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum::<f64>()
    }

    /// What a face covers, counter-clockwise, and how much the projection stretches it; nothing if it does not lie before the receiver.
    pub(super) fn project(&self, facets: &Facets, face: usize) -> Option<(Vec<[f64; 2]>, f64)> {
        let numbers: Vec<u32> = facets.facet(face).corners().iter().copied().collect();
        let heights: Vec<f64> = numbers.iter().map(|&number| self.exact_height(&facets.point(number))).collect();
        if heights.iter().all(|&height| height <= 0.0) {
            return None;
        }
        let corners: Vec<DVec3> = numbers.iter().map(|&number| facets.point(number).position).collect();
        let mut polygon = cut(&corners, &heights);
        for side in self.side_planes() {
            let values: Vec<f64> = polygon.iter().map(|&point| side.direction.dot(point - side.origin)).collect();
            polygon = cut(&polygon, &values);
        }
        if polygon.len() < 3 {
            return None;
        }
        let mut stretch: f64 = 1.0;
        let mut cover: Vec<[f64; 2]> = Vec::with_capacity(polygon.len());
        for point in polygon {
            let (landed, own) = self.land(point)?;
            stretch = stretch.max(own);
            let [low, high] = self.rectangle;
            let at = self.flat(landed);
            cover.push([0, 1].map(|axis| at[axis].clamp(low[axis], high[axis])));
        }
        let twice: f64 = (1..cover.len() - 1)
            .map(|k| {
                let from = |p: [f64; 2]| [p[0] - cover[0][0], p[1] - cover[0][1]];
                let (p, q) = (from(cover[k]), from(cover[k + 1]));
                p[0] * q[1] - p[1] * q[0]
            })
            .sum();
        if twice < 0.0 {
            cover.reverse();
        }
        Some((cover, stretch))
    }

    /// A number with the exact sign of the side of the receiver's plane, in proportion to the distance.
    fn exact_height(&self, point: &Point) -> f64 {
        let [a, b, c] = &self.plane;
        predicates::side_value(a, b, c, predicates::Target::Point(point)).value
    }

    /// The planes through the light and the edges of the rectangle.
    fn side_planes(&self) -> [Ray; 4] {
        let [[left, low], [right, high]] = self.rectangle;
        let corners = [[left, low], [right, low], [right, high], [left, high]]
            .map(|[u, v]| self.origin + u * self.axes[0] + v * self.axes[1]);
        std::array::from_fn(|k| self.side_plane(corners[k], corners[(k + 1) % 4]))
    }

    /// The plane through the light and an edge, as a point of it and the direction to the receiver's side.
    fn side_plane(&self, from: DVec3, to: DVec3) -> Ray {
        let towards = self.light.xyz() - self.light.w() * from;
        // The receiver is left of the edges, seen from the light.
        Ray::new(from, towards.cross(to - from).normalize_or_zero())
    }

    /// Where the light's ray through a point lands, and how much nearby points are spread; nothing at the light itself.
    fn land(&self, point: DVec3) -> Option<(DVec3, f64)> {
        let height = self.normal.dot(point - self.origin);
        if self.light.is_sun() {
            let climb = self.normal.dot(self.light.xyz());
            let stretch = self.light.xyz().length() / climb;
            return (climb > 0.0).then(|| (point - self.light.xyz() * (height / climb), stretch));
        }
        let lamp = self.normal.dot(self.light.xyz() - self.origin);
        let left = lamp - height;
        let stretch = lamp / left;
        (left > 0.0).then(|| (self.light.xyz() + (point - self.light.xyz()) * stretch, stretch))
    }
}

/// A rectangle round an outline, an eighth of its extent wider on all sides: no border of the outline lies on it.
fn around(outline: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let [low, high] = [f64::min, f64::max]
        .map(|choose| [0, 1].map(|axis| outline.iter().map(|point| point[axis]).reduce(choose).unwrap_or(0.0)));
    let wider = 0.125 * (high[0] - low[0]).max(high[1] - low[1]);
    [low.map(|least| least - wider), high.map(|greatest| greatest + wider)]
}

/// The overlay's integers have 32 bits with a sign, and leave some free: 2^-28 of the extent of what is overlaid is no finer than their grid.
const GRID: f64 = 1.0 / (1 << 28) as f64;
