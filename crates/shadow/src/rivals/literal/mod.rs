//! The method of Xie, Yu, Hao and Sun ("The new algorithm of shadow volume with LOD", Journal of the National University of Defense Technology
//! 23(3), 2001) as its words go, to see how far they carry.
//!
//! For each pair of objects [A] → [B] by itself: rays from the eight corners of B's box to the light, against A alone. All meet A: the box is in shadow.
//! Some do: it is divided at its middles, down to the boundary depth. A box in shadow is marked if all its corners lie in or on B, dropped if none does,
//! and divided down to the interior depth otherwise. What the source leaves open is taken in the method's favour: a box without any hit is divided down to
//! the interior depth as long as [A]'s box has an influence on it; at the last depth a box counts as in shadow if half of its corners are, and as
//! part of B if any corner is. Flat boxes are divided along their long axes only.
//!
//! What is wrong with it: eight hits prove nothing for a concave A; eight misses miss what stands between them; a plate slips between eight corners, so
//! tilted or thin B get no marks; a body never shadows itself; two half shadows of two objects do not add up.
//! Cost: eight rays and up to eight tests of membership a box, for each pair anew.

mod faults;

use std::{
    collections::HashSet,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Instant,
};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_bvh::{BoxTree, Influences, TriangleBvh, influences, may_shadow};
use umbriel_geometry::{Aabb, Facets, LightSource, Mesh};

pub use faults::Faults;

use super::{Polygons, Rival, RivalAnswer, RivalPoint, RivalRefusal, polygons::triangles_of};
use crate::{coarse::tree_of_all, query::Precision, slack::SlackBox};

/// The method read literally.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Literal {
    /// Depth down to which the inside of a shadow is divided; the source's is 4.
    pub interior: u8,
    /// Depth down to which its border is divided, 20 at most; the source's is 8.
    pub boundary: u8,
    /// Rays that it may cast before it gives up.
    pub most_rays: u64,
}

/// A marked box: its depth, and where it lies among the boxes of that depth.
type Mark = (u8, [u32; 3]);

/// A body as the method asks about it.
struct Body<'a> {
    facets: &'a Facets,
    bvh: TriangleBvh,
    faces: BoxTree,
    bounds: Aabb,
}

/// All bodies under one light, and which may shadow which.
struct Method<'a> {
    bodies: Vec<Body<'a>>,
    influences: Influences,
    light: &'a LightSource,
}

impl<'a> Method<'a> {
    fn new(polygons: &'a Polygons, light: &'a LightSource) -> Self {
        let objects = polygons.boxes().len();
        let scene = polygons.scene();
        let influences = influences(&tree_of_all(scene), light, |_| true);
        let bodies = (0..objects).into_par_iter().map(|object| Body::new(polygons.facets(object))).collect();
        Self { bodies, influences, light }
    }

    /// The pairs in which an object receives.
    fn pairs<'b>(&'b self, method: Literal, object: usize, rays: &'b AtomicU64) -> impl Iterator<Item = Pair<'b>> {
        let others = self.influences.occluders_of(object as u32).iter().filter(move |&&other| other as usize != object);
        others.map(move |&other| {
            let (occluder, receiver) = (&self.bodies[other as usize], &self.bodies[object]);
            Pair { occluder, receiver, light: self.light, method, rays }
        })
    }

    /// The marked boxes of each object.
    fn marks(&self, method: Literal, rays: &AtomicU64) -> Vec<HashSet<Mark>> {
        let of_object = |object: usize| {
            let mut marks = HashSet::new();
            self.pairs(method, object, rays).for_each(|pair| pair.divide((0, [0; 3]), &mut marks));
            marks
        };
        (0..self.bodies.len()).into_par_iter().map(of_object).collect()
    }
}

/// A pair at work.
struct Pair<'a> {
    occluder: &'a Body<'a>,
    receiver: &'a Body<'a>,
    light: &'a LightSource,
    method: Literal,
    rays: &'a AtomicU64,
}

impl Rival for Literal {
    fn name(&self) -> String {
        format!("literal {}/{}", self.interior, self.boundary)
    }

    fn answer(
        &self,
        polygons: &Polygons,
        light: &LightSource,
        points: &[RivalPoint],
    ) -> Result<RivalAnswer, RivalRefusal> {
        let begun = Instant::now();
        let method = Method::new(polygons, light);
        let rays = AtomicU64::new(0);
        let marks = method.marks(*self, &rays);
        let cast = rays.into_inner();
        if cast > self.most_rays {
            return Err(RivalRefusal::TooManyRays { limit: self.most_rays });
        }
        let build_seconds = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let is_lit = |point: &RivalPoint| {
            let object = point.object as usize;
            point.is_turned_to(light)
                && !is_marked(&marks[object], &method.bodies[object].bounds, self.boundary, point.position)
        };
        let lit = points.par_iter().map(is_lit).collect();
        let pieces = marks.iter().map(|marks| marks.len() as u64).sum();
        let bytes = pieces * size_of::<Mark>() as u64;
        let points_seconds = begun.elapsed().as_secs_f64();
        Ok(RivalAnswer { lit, build_seconds, points_seconds, rays: cast, looked_at: 0, pieces, bytes })
    }
}

impl<'a> Body<'a> {
    fn new(facets: &'a Facets) -> Self {
        let triangles = triangles_of(facets).into_iter().map(|(corners, _)| corners).collect();
        let positions = facets.positions().iter().map(DVec3::to_array).collect();
        let mesh = Mesh::new(positions, triangles).expect("placed faces have accepted corners");
        let boxes: Vec<Aabb> = (0..facets.len()).map(|face| facets.facet_bounds(face)).collect();
        let bounds = Aabb::of(facets.positions().iter().copied());
        Self { facets, bvh: TriangleBvh::build(Arc::new(mesh)), faces: BoxTree::build(&boxes), bounds }
    }

    /// Whether a point lies in the body, by the side of the first face on some way, or on it.
    fn holds(&self, point: DVec3) -> bool {
        // In no usual plane.
        let way = DVec3::new(0.48, 0.6, 0.64);
        let is_inside = self.bvh.nearest_hit(point, way, f64::INFINITY).is_some_and(|hit| {
            let [a, b, c] = self.bvh.corners(hit.triangle);
            self.facets.is_closed(self.face_of(hit.triangle)) && (b - a).cross(c - a).dot(way) > 0.0
        });
        is_inside || self.is_on(point)
    }

    /// The face of a triangle: parallelograms are two.
    fn face_of(&self, triangle: u32) -> usize {
        if self.facets.len() == self.bvh.len() { triangle as usize } else { triangle as usize / 2 }
    }

    /// Whether some face meets the point within half an ulp.
    fn is_on(&self, point: DVec3) -> bool {
        let slack = SlackBox::new(point, Precision::Double);
        let mut is_on = false;
        self.faces.for_each_meeting(&slack.bounds, |face| {
            is_on = is_on || slack.point_on_face(self.facets, face as usize).is_some();
        });
        is_on
    }
}

impl Pair<'_> {
    /// Marks what is in shadow of a box, or of its parts.
    fn divide(&self, place: Mark, marks: &mut HashSet<Mark>) {
        if self.rays.fetch_add(8, Ordering::Relaxed) > self.method.most_rays {
            return;
        }
        let cell = part(&self.receiver.bounds, place);
        let corners = corners(&cell);
        let mut towards = self.occluder.bvh.towards(*self.light);
        let hits = corners.iter().filter(|&&corner| towards.any_hit(corner)).count();
        let depth = place.0;
        if hits == 8 {
            self.mark(place, marks);
        } else if hits > 0 && depth == self.method.boundary {
            if 2 * hits >= 8 && corners.iter().any(|&corner| self.receiver.holds(corner)) {
                marks.insert(place);
            }
        } else if hits > 0 || (depth < self.method.interior && may_shadow(&self.occluder.bounds, &cell, self.light)) {
            parts(&self.receiver.bounds, place).for_each(|place| self.divide(place, marks));
        }
    }

    /// A box in shadow: marked as far as it is part of the receiver.
    fn mark(&self, place: Mark, marks: &mut HashSet<Mark>) {
        let corners = corners(&part(&self.receiver.bounds, place));
        match corners.iter().filter(|&&corner| self.receiver.holds(corner)).count() {
            0 => {}
            8 => {
                marks.insert(place);
            }
            _ if place.0 >= self.method.interior => {
                marks.insert(place);
            }
            _ => parts(&self.receiver.bounds, place).for_each(|place| self.mark(place, marks)),
        }
    }
}

/// The box at a place.
fn part(whole: &Aabb, (depth, place): Mark) -> Aabb {
    let edge = 0.5f64.powi(i32::from(depth));
    let at = |k: usize, step: f64| {
        let share = (f64::from(place[k]) + step) * edge;
        if share == 1.0 { whole.max[k] } else { whole.min[k] + share * (whole.max[k] - whole.min[k]) }
    };
    let flat = |k: usize| whole.min[k] == whole.max[k];
    Aabb {
        min: DVec3::from_array([0, 1, 2].map(|k| at(k, 0.0))),
        max: DVec3::from_array([0, 1, 2].map(|k| if flat(k) { whole.max[k] } else { at(k, 1.0) })),
    }
}

/// The parts of a box: halved along every axis on which it is not flat.
fn parts(whole: &Aabb, (depth, place): Mark) -> impl Iterator<Item = Mark> + use<> {
    let flat = [0, 1, 2].map(|k| whole.min[k] == whole.max[k]);
    (0..8u32).filter(move |octant| (0..3).all(|k| !flat[k] || octant >> k & 1 == 0)).map(move |octant| {
        let along = |k: usize| if flat[k] { 0 } else { 2 * place[k] + (octant >> k & 1) };
        (depth + 1, [0, 1, 2].map(along))
    })
}

fn corners(cell: &Aabb) -> [DVec3; 8] {
    let ends = [cell.min, cell.max];
    std::array::from_fn(|corner| DVec3::new(ends[corner & 1].x, ends[corner >> 1 & 1].y, ends[corner >> 2 & 1].z))
}

/// Whether a point lies in a marked box.
fn is_marked(marks: &HashSet<Mark>, whole: &Aabb, boundary: u8, point: DVec3) -> bool {
    (0..=boundary).any(|depth| marks.contains(&place_of(whole, depth, point)))
}

/// The box of a depth that holds a point.
fn place_of(whole: &Aabb, depth: u8, point: DVec3) -> Mark {
    let share = (point - whole.min) / (whole.max - whole.min);
    let count = f64::from(1u32 << depth);
    // A flat axis divides nothing by nothing and stays at 0.
    (depth, share.to_array().map(|share| (share * count).max(0.0).min(count - 1.0) as u32))
}
