//! Shadows of polygon scenes by two passes: shadow polygons.
//!
//! The first pass is taken from the light. *Self shadow*: faces that are not turned to it. *Cast shadow*: every face that lies before another one is projected
//! from the light onto its plane; the parts of the receiver that projections cover are its shadow polygons, kept with the scene. The second pass is any picture: it
//! looks the polygons up, and a moved eye asks for nothing new ([`ShadowPolygons`]).
//!
//! - Source: a lecture on visible-surface determination, shadows by two passes; Atherton, Weiler and Greenberg, "Polygon shadow generation", SIGGRAPH 1978.
//! - Which faces are turned to the light, and which corners lie before a face, are exact signs. Polygons are made in floats: an occluder is cut by the
//!   receiver's plane and by the planes through the light and a rectangle round the receiver (`projection`), projected, and `i_overlay` unites what comes out (`union`) on a grid of integers. Lit areas
//!   carry a bound: that grid and the floats, along all edges ([`FaceShadow::error`]). It is an estimate of the worst case, not a proof; the pipeline proves, and this is
//!   an independent way to its areas.
//! - Cost: for each lit face the faces of all objects that a shaft finds in its way, and sweeps over their edges. Curved bodies and meshes with
//!   holes are refused.

mod projection;
#[cfg(test)]
mod tests;
mod union;

use std::ops::ControlFlow;

use glam::{DVec2, DVec3};
use i_overlay::{
    core::{fill_rule::FillRule, overlay_rule::OverlayRule},
    float::single::SingleFloatOverlay,
};
use rayon::prelude::*;
use umbriel_bvh::{BoxTree, Shaft};
use umbriel_geometry::{Facets, LightSource, Sign};
use umbriel_scene::{Object, Scene, Shape};

use projection::Receiver;

/// A polygon of a plane, its outline first, then its holes; coordinates of [`FaceShadow::point`].
pub type Region = Vec<Vec<[f64; 2]>>;

/// Why a scene has no shadow polygons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TwoPassDefect {
    /// A body without planar faces.
    #[error("object {object} is curved; shadow polygons are for planar faces")]
    Curved {
        /// Index into the scene's objects.
        object: usize,
    },
    /// A mesh with holes that a texture cuts out.
    #[error("object {object} has triangles with holes")]
    Holes {
        /// Index into the scene's objects.
        object: usize,
    },
}

/// One face with its shadows.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceShadow {
    /// Index into the scene's objects.
    pub object: usize,
    /// Face of the object.
    pub face: usize,
    /// Whether the light is strictly on its lit side; else all of it is self shadow.
    pub is_turned: bool,
    /// What light reaches.
    pub lit: Vec<Region>,
    /// The shadow polygons: what is turned to the light and covered.
    pub shadow: Vec<Region>,
    /// Square metres.
    pub area: f64,
    /// Square metres that light reaches.
    pub lit_area: f64,
    /// By how much the lit area may be off, square metres.
    pub error: f64,
    origin: DVec3,
    axes: [DVec3; 2],
}

impl FaceShadow {
    /// The world point of plane coordinates, metres.
    pub fn point(&self, [u, v]: [f64; 2]) -> DVec3 {
        self.origin + u * self.axes[0] + v * self.axes[1]
    }

    /// The plane coordinates of a point of the face.
    pub fn coordinates(&self, point: DVec3) -> [f64; 2] {
        self.axes.map(|axis| axis.dot(point - self.origin))
    }

    /// Whether a point of the face, in plane coordinates, is in the lit part; points on a border are on either side.
    pub fn is_lit(&self, at: [f64; 2]) -> bool {
        self.lit.iter().any(|region| holds(region, at.into()))
    }
}

/// The shadow polygons of a scene under one light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowPolygons {
    /// All faces with area, in the order of objects and their faces.
    pub faces: Vec<FaceShadow>,
}

impl ShadowPolygons {
    /// Takes the light's pass. Receivers are taken in parallel.
    ///
    /// # Errors
    /// [`TwoPassDefect`].
    pub fn cast(scene: &Scene, light: &LightSource) -> Result<Self, TwoPassDefect> {
        let bodies = scene.objects.iter().enumerate().map(|(object, body)| {
            if matches!(&body.shape, Shape::Mesh(mesh) if mesh.has_holes()) {
                return Err(TwoPassDefect::Holes { object });
            }
            let facets = body.facets().ok_or(TwoPassDefect::Curved { object })?;
            Ok(Body { object: body, facets })
        });
        let bodies = bodies.collect::<Result<Vec<_>, _>>()?;
        let numbered = |(object, body): (usize, &Body)| (0..body.facets.len()).map(move |face| (object, face));
        let faces: Vec<(usize, usize)> = bodies.iter().enumerate().flat_map(numbered).collect();
        let bounds: Vec<_> = faces.iter().map(|&(object, face)| bodies[object].facets.facet_bounds(face)).collect();
        let pass = Pass { bodies: &bodies, faces: &faces, tree: BoxTree::build(&bounds), light };
        let with_area = faces.par_iter().filter(|&&(object, face)| bodies[object].facets.area(face).upper() > 0.0);
        Ok(Self { faces: with_area.map(|&(object, face)| pass.face(object, face)).collect() })
    }

    /// The shadows of a face; `None` for a face without area, or one that is not there. O(log n).
    pub fn of(&self, object: usize, face: usize) -> Option<&FaceShadow> {
        let place = self.faces.binary_search_by_key(&(object, face), |shadow| (shadow.object, shadow.face));
        place.ok().map(|place| &self.faces[place])
    }

    /// The lit area of an object and by how much it may be off, square metres.
    pub fn lit_area(&self, object: usize) -> (f64, f64) {
        let faces = self.faces.iter().filter(|face| face.object == object);
        faces.fold((0.0, 0.0), |(area, error), face| (area + face.lit_area, error + face.error))
    }
}

/// A placed object.
struct Body<'a> {
    object: &'a Object,
    facets: Facets,
}

/// The light's pass.
struct Pass<'a> {
    bodies: &'a [Body<'a>],
    /// All faces: body and face.
    faces: &'a [(usize, usize)],
    tree: BoxTree,
    light: &'a LightSource,
}

impl Pass<'_> {
    /// The faces that may lie between a receiver and the light, in the order of the tree, where neighbours follow each other.
    fn before(&self, receiver: &Receiver) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        let _ = self.tree.for_each_in_shaft(&Shaft::new(&receiver.bounds, self.light), |item| {
            found.push(self.faces[item as usize]);
            ControlFlow::Continue(())
        });
        found
    }

    fn is_turned(&self, object: usize, face: usize) -> bool {
        let Body { object, facets, .. } = &self.bodies[object];
        let turn = facets.turn(face, self.light);
        match if facets.is_mirrored() { turn.flipped() } else { turn } {
            Sign::Positive => true,
            Sign::Zero => false,
            Sign::Negative => !object.is_one_sided(|| facets.is_closed(face)),
        }
    }

    fn face(&self, object: usize, face: usize) -> FaceShadow {
        let receiver = Receiver::new(&self.bodies[object].facets, face, self.light);
        let outline = receiver.outline();
        let area = area_of(&outline);
        let mut found = FaceShadow {
            object,
            face,
            is_turned: self.is_turned(object, face),
            lit: Vec::new(),
            shadow: Vec::new(),
            area,
            lit_area: 0.0,
            error: receiver.slack(&outline, 1.0),
            origin: receiver.origin,
            axes: receiver.axes,
        };
        if !found.is_turned {
            found.error = 0.0;
            return found;
        }
        let (mut covers, mut rounding) = (Vec::new(), 0.0);
        for (other, occluder) in self.before(&receiver).into_iter().filter(|&occluder| occluder != (object, face)) {
            let Some((cover, stretch)) = receiver.project(&self.bodies[other].facets, occluder) else { continue };
            let (slack, covered) = (receiver.slack(&cover, stretch), area_of(&cover));
            // Beside the receiver it covers nothing of it, and a sliver, as of a neighbour that bends up by a rounding, no more than it may be off.
            if covered <= slack || is_beside(&outline, &cover) {
                found.error += slack + covered.min(slack);
            } else {
                rounding += slack;
                covers.push(cover);
            }
        }
        if covers.is_empty() {
            found.lit = vec![vec![outline]];
            found.lit_area = area;
            return found;
        }
        found.error += rounding * f64::from(union::passes(covers.len()));
        let covered = union::union(&covers);
        found.lit = outline.overlay(&covered, OverlayRule::Difference, FillRule::NonZero);
        found.shadow = outline.overlay(&covered, OverlayRule::Intersect, FillRule::NonZero);
        found.lit_area = found.lit.iter().flatten().fold(0.0, |sum, contour| sum + area_of(contour));
        found
    }
}

/// Whether some edge of a convex, counter-clockwise outline has all of a polygon on its outer side or on its line.
fn is_beside(outline: &[[f64; 2]], polygon: &[[f64; 2]]) -> bool {
    let mut edges = outline.iter().zip(outline.iter().cycle().skip(1));
    edges.any(|(&from, &to)| {
        let along = DVec2::from(to) - DVec2::from(from);
        polygon.iter().all(|&point| along.perp_dot(DVec2::from(point) - DVec2::from(from)) <= 0.0)
    })
}

/// The area within a contour, positive where it runs counter-clockwise.
fn area_of(contour: &[[f64; 2]]) -> f64 {
    let first = contour.first().map_or(DVec2::ZERO, |&first| first.into());
    let twice: f64 =
        contour.windows(2).map(|edge| (DVec2::from(edge[0]) - first).perp_dot(DVec2::from(edge[1]) - first)).sum();
    0.5 * twice
}

/// Whether a point lies within the contours of a region, by crossings.
fn holds(region: &Region, point: DVec2) -> bool {
    let crossings = |contour: &Vec<[f64; 2]>| {
        let edges = contour.iter().zip(contour.iter().cycle().skip(1));
        edges.filter(|&(&a, &b)| crosses([a.into(), b.into()], point)).count()
    };
    region.iter().map(crossings).sum::<usize>() % 2 == 1
}

/// Whether an edge crosses the way from a point to the right.
pub(crate) fn crosses([a, b]: [DVec2; 2], point: DVec2) -> bool {
    (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) * (b.x - a.x) / (b.y - a.y)
}
