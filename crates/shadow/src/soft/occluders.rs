//! What can stand between a point or a cell and an area light.
//!
//! The shaft (Haines and Wallace, "Shaft culling for efficient ray-traced radiosity", Eurographics Workshop on Rendering 1991): the
//! hull of what receives and what shines, as the half spaces whose planes touch both. A box outside of one of them is out; the test
//! never says so in vain, because it grants each plane what rounding may have done to it. O(planes) a box.

use std::ops::ControlFlow;

use glam::DVec3;
use umbriel_geometry::{Aabb, LightSource};
use umbriel_scene::{Extent, Light};

use super::{cell::Cell, normal::Normal, polygon::Polygon, window::Window};
use crate::{
    bodies::Body,
    exact::patch_probe,
    fine::flat::flat_probe,
    query::{Precision, Queries},
    receivers::flat_corners,
    slack::SlackBox,
};

/// Half spaces; what is in none of their outsides may be in the shaft.
#[derive(Clone, Debug, Default)]
pub(crate) struct HullShaft {
    planes: Vec<HalfSpace>,
}

/// Points or directions whose hull holds a light.
#[derive(Clone, Debug)]
pub(crate) enum LightHull {
    /// World coordinates.
    Points(Vec<DVec3>),
    /// Towards a sun.
    Directions(Vec<DVec3>),
}

impl LightHull {
    /// Points or directions whose hull holds the light.
    pub(crate) fn of(light: &Light) -> Self {
        let centre = light.source.xyz();
        match light.extent {
            Extent::Rectangle { u, v } => {
                Self::Points(vec![centre - u - v, centre + u - v, centre + u + v, centre - u + v])
            }
            Extent::Sphere { radius } => {
                // A cube a little larger than the ball, as its corners are rounded.
                let half = radius * (1.0 + 4.0 * f64::EPSILON) + 4.0 * f64::EPSILON * centre.abs().max_element();
                let corner = |k: usize| {
                    let sign = |bit: usize| if k >> bit & 1 == 0 { -half } else { half };
                    centre + DVec3::new(sign(0), sign(1), sign(2))
                };
                Self::Points((0..8).map(corner).collect())
            }
            _ => {
                let window = Window::new(DVec3::ZERO, light);
                let directions =
                    window.map(|window| Polygon::square().0.iter().map(|&corner| window.direction(corner)).collect());
                Self::Directions(directions.unwrap_or_else(|| vec![centre]))
            }
        }
    }

    /// A light at each point, or a sun in each direction.
    pub(crate) fn sources(&self) -> Vec<LightSource> {
        let point = |point: &DVec3| LightSource::point(point.to_array()).ok();
        let sun = |&direction: &DVec3| LightSource::sun((-direction).to_array()).ok();
        match self {
            Self::Points(points) => points.iter().filter_map(point).collect(),
            Self::Directions(directions) => directions.iter().filter_map(sun).collect(),
        }
    }
}

/// The points p with normal · p ≥ offset.
#[derive(Clone, Copy, Debug)]
struct HalfSpace {
    normal: DVec3,
    offset: f64,
    /// What rounding may do to the offset.
    slack: f64,
    /// By how much a coordinate of the normal may be off, where that tells of a plane which one it is.
    error: DVec3,
}

impl HalfSpace {
    /// Not negative for what may be inside, of points no larger than these.
    fn granted(&self, points: &[DVec3]) -> impl Fn(DVec3) -> f64 + use<> {
        let size = points.iter().fold(DVec3::ZERO, |size, point| size.max(point.abs()));
        let (normal, offset) = (self.normal, self.offset - self.slack - self.rounding(size));
        move |point| normal.dot(point) - offset
    }

    /// What rounding may do to the products of points no larger than this.
    fn rounding(&self, size: DVec3) -> f64 {
        (PLANE_ROUNDING * self.normal.abs() + self.error).dot(size)
    }
}

/// Roundings of a scalar product of three terms and of the normal it is made with (six of a cross product of differences), doubled.
const PLANE_ROUNDING: f64 = 32.0 * f64::EPSILON;

impl HullShaft {
    /// Everything.
    pub(crate) fn unbounded() -> Self {
        Self::default()
    }

    /// The shaft from a cell to a light: each plane through an edge of one and a corner of the other, or side of a sun's cone, that has
    /// both on one side. O(corners⁴), some hundred planes tried.
    pub(crate) fn between(cell: &Cell, light: &LightHull) -> Self {
        let mut shaft = Self::unbounded();
        let corners = &cell.corners;
        let edges = |points: &[DVec3]| -> Vec<[DVec3; 2]> {
            let starts = points.iter().enumerate();
            starts.flat_map(|(k, &a)| points[k + 1..].iter().map(move |&b| [a, b])).collect()
        };
        match light {
            LightHull::Points(points) => {
                for (&corner, [a, b]) in
                    corners.iter().flat_map(|corner| edges(points).into_iter().map(move |edge| (corner, edge)))
                {
                    shaft.add_touching((a - corner).cross(b - corner), cell, light);
                }
                for (&corner, [a, b]) in
                    points.iter().flat_map(|corner| edges(corners).into_iter().map(move |edge| (corner, edge)))
                {
                    shaft.add_touching((a - corner).cross(b - corner), cell, light);
                }
            }
            LightHull::Directions(directions) => {
                for [a, b] in edges(directions) {
                    shaft.add_touching(a.cross(b), cell, light);
                }
                for (&direction, [a, b]) in
                    directions.iter().flat_map(|d| edges(corners).into_iter().map(move |edge| (d, edge)))
                {
                    shaft.add_touching((b - a).cross(direction), cell, light);
                }
            }
        }
        shaft
    }

    /// Adds the plane with this normal, either way round, if it touches both the cell and the light.
    fn add_touching(&mut self, normal: DVec3, cell: &Cell, light: &LightHull) {
        let size = |points: &[DVec3]| points.iter().fold(DVec3::ZERO, |size, point| size.max(point.abs()));
        let slack = |points: &[DVec3]| PLANE_ROUNDING * normal.abs().dot(size(points));
        let cell_slack = slack(&cell.corners) + cell.slack * normal.abs().element_sum();
        let (LightHull::Points(lights) | LightHull::Directions(lights)) = light;
        let light_slack = slack(lights);
        let (of_cell, of_light) = (least_along(normal, &cell.corners), least_along(normal, lights));
        for (way, normal) in [normal, -normal].into_iter().enumerate() {
            let (at_cell, at_light) = (of_cell[way], of_light[way]);
            let (offset, slack) = match light {
                LightHull::Points(_) => {
                    let slack = cell_slack + light_slack;
                    if (at_cell - at_light).abs() > slack {
                        continue;
                    }
                    (at_cell.min(at_light), slack)
                }
                LightHull::Directions(_) => {
                    // What a direction may lose by rounding is as large as the coordinates of what it reaches, and granted to that.
                    if at_light < -light_slack {
                        continue;
                    }
                    (at_cell, cell_slack)
                }
            };
            if normal != DVec3::ZERO {
                // Whichever plane it is, cell and light are on its inner side.
                self.planes.push(HalfSpace { normal, offset, slack, error: DVec3::ZERO });
            }
        }
    }

    /// The part of a convex polygon in the shaft; a little more, by what rounding may do.
    pub(crate) fn cut(&self, polygon: &mut Vec<DVec3>) {
        for plane in &self.planes {
            if polygon.len() < 3 {
                return;
            }
            let value = plane.granted(polygon);
            super::window::cut(polygon, value);
        }
    }

    /// The part of a segment in the shaft; a little more, by what rounding may do.
    pub(crate) fn cut_segment(&self, mut segment: [DVec3; 2]) -> Option<[DVec3; 2]> {
        for plane in &self.planes {
            let value = plane.granted(&segment);
            let [a, b] = segment;
            let (at_a, at_b) = (value(a), value(b));
            if at_a < 0.0 && at_b < 0.0 {
                return None;
            }
            let crossing = || a + (b - a) * (at_a / (at_a - at_b));
            segment = [if at_a < 0.0 { crossing() } else { a }, if at_b < 0.0 { crossing() } else { b }];
        }
        Some(segment)
    }

    /// Leaves out what lies behind the plane through `point`.
    pub(crate) fn keep_before(&mut self, point: DVec3, normal: &Normal) {
        let (normal, error) = (normal.value(), normal.error());
        let plane = HalfSpace { normal, offset: normal.dot(point), slack: 0.0, error };
        self.planes.push(HalfSpace { slack: plane.rounding(point.abs()), ..plane });
    }

    /// Whether part of the box may be in the shaft. Monotone.
    pub(crate) fn may_meet(&self, bounds: &Aabb) -> bool {
        self.planes.iter().all(|plane| {
            let farthest = DVec3::select(plane.normal.cmpgt(DVec3::ZERO), bounds.max, bounds.min);
            let size = bounds.min.abs().max(bounds.max.abs());
            plane.normal.dot(farthest) - plane.offset >= -plane.slack - plane.rounding(size)
        })
    }
}

/// The least products of points with a vector, and with its opposite.
fn least_along(normal: DVec3, points: &[DVec3]) -> [f64; 2] {
    points
        .iter()
        .map(|&point| normal.dot(point))
        .fold([f64::INFINITY; 2], |[a, b], value| [a.min(value), b.min(-value)])
}

/// What may be in a shaft.
#[derive(Clone, Debug, Default)]
pub(crate) struct InShaft {
    /// Flat faces as (object, face), in that order.
    pub(crate) faces: Vec<(u32, u32)>,
    /// Curved bodies.
    pub(crate) bodies: Vec<u32>,
    /// Triangles of the polyhedra in some of them, as (object, triangle), in that order.
    pub(crate) inner: Vec<(u32, u32)>,
    /// Triangles of the polyhedra round the same ones.
    pub(crate) outer: Vec<(u32, u32)>,
}

impl InShaft {
    pub(crate) fn is_empty(&self) -> bool {
        self.faces.is_empty() && self.bodies.is_empty()
    }
}

/// All that may be in the shaft.
pub(crate) fn in_shaft(queries: &Queries, shaft: &HullShaft) -> InShaft {
    let mut found = InShaft::default();
    let _ = queries.objects.for_each_where(
        |bounds| shaft.may_meet(bounds),
        |object| {
            match queries.bodies.get(object as usize) {
                Body::Analytic(_) => found.bodies.push(object),
                Body::Flat(facets) => {
                    let tree = queries.face_tree(object as usize, facets);
                    let _ = tree.for_each_where(
                        |bounds| shaft.may_meet(bounds),
                        |face| {
                            found.faces.push((object, face));
                            ControlFlow::Continue(())
                        },
                    );
                }
            }
            ControlFlow::Continue(())
        },
    );
    found.faces.sort_unstable();
    found.bodies.sort_unstable();
    found
}

impl Queries<'_> {
    /// The point (u, v) of a face, rounded; `None` where there is no surface.
    pub(crate) fn position(&self, object: usize, face: usize, [u, v]: [f64; 2]) -> Option<DVec3> {
        match self.bodies.get(object) {
            Body::Flat(facets) => Some(flat_probe(&flat_corners(facets, face, 0), u, v).bounds.position),
            Body::Analytic(body) => patch_probe(body, face, u, v).map(|probe| probe.bounds.position),
        }
    }

    /// The surfaces that a point stands on: those that its slack box meets.
    pub(crate) fn touched(&self, position: DVec3, precision: Precision) -> InShaft {
        let slack = SlackBox::new(position, precision);
        let mut found = InShaft::default();
        self.objects.for_each_meeting(&slack.bounds, |object| match self.bodies.get(object as usize) {
            Body::Flat(facets) => self.face_tree(object as usize, facets).for_each_meeting(&slack.bounds, |face| {
                if slack.point_on_face(facets, face as usize).is_some() {
                    found.faces.push((object, face));
                }
            }),
            Body::Analytic(body) => {
                if slack.point_on_analytic(body, None).is_some() {
                    found.bodies.push(object);
                }
            }
        });
        found.faces.sort_unstable();
        found.bodies.sort_unstable();
        found
    }
}
