//! What can stand between a point or a cell and an area light.
//!
//! The shaft (Haines and Wallace, "Shaft culling for efficient ray-traced radiosity", Eurographics Workshop on Rendering 1991): the
//! hull of what receives and what shines, as the half spaces whose planes touch both. A box outside of one of them is out; the test
//! never says so in vain, because it grants each plane what rounding may have done to it. O(planes) a box.

use std::ops::ControlFlow;

use glam::DVec3;
use umbriel_geometry::Aabb;

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

/// The points p with normal · p ≥ offset.
#[derive(Clone, Copy, Debug)]
struct HalfSpace {
    normal: DVec3,
    offset: f64,
    /// What rounding may do to the offset.
    slack: f64,
}

/// Roundings of a scalar product of three terms and of the normal it is made with (six of a cross product of differences), doubled.
const PLANE_ROUNDING: f64 = 32.0 * f64::EPSILON;

impl HullShaft {
    /// Everything.
    pub(crate) fn unbounded() -> Self {
        Self::default()
    }

    /// Leaves out what lies behind the plane through `point`.
    pub(crate) fn keep_before(&mut self, point: DVec3, normal: DVec3) {
        let offset = normal.dot(point);
        let slack = PLANE_ROUNDING * normal.abs().dot(point.abs());
        self.planes.push(HalfSpace { normal, offset, slack });
    }

    /// Whether part of the box may be in the shaft. Monotone.
    pub(crate) fn may_meet(&self, bounds: &Aabb) -> bool {
        self.planes.iter().all(|plane| {
            let farthest = DVec3::select(plane.normal.cmpgt(DVec3::ZERO), bounds.max, bounds.min);
            let size = bounds.min.abs().max(bounds.max.abs());
            plane.normal.dot(farthest) - plane.offset >= -plane.slack - PLANE_ROUNDING * plane.normal.abs().dot(size)
        })
    }
}

/// What may be in a shaft.
#[derive(Clone, Debug, Default)]
pub(crate) struct InShaft {
    /// Flat faces as (object, face), in that order.
    pub(crate) faces: Vec<(u32, u32)>,
    /// Curved bodies.
    pub(crate) bodies: Vec<u32>,
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
                if slack.point_on_analytic(body, |_| true).is_some() {
                    found.bodies.push(object);
                }
            }
        });
        found.faces.sort_unstable();
        found.bodies.sort_unstable();
        found
    }
}
