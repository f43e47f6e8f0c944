//! One object as rays meet it: in its own coordinates, with what its instances share.
//!
//! Of a mesh a BVH without the triangles that repeat others; rectangles, boxes and analytic bodies as they are; the hull of placed points as a mesh of
//! the world. Rounded, as all of ray casting is.

use std::{collections::HashMap, sync::Arc};

use glam::{DAffine3, DVec3};
use umbriel_bvh::{Hit, Ray, TriangleBvh};
use umbriel_geometry::{Aabb, Cuboid, Mesh, PlacedAnalytic, Rectangle};
use umbriel_scene::{Object, Shape};

use crate::{
    acceleration::Prepared,
    local::{self, LocalHit},
};

/// An object pulled into local coordinates.
#[derive(Debug)]
pub(super) struct Body {
    pub(super) shape: LocalShape,
    pub(super) to_local: DAffine3,
    /// World coordinates.
    pub(super) bounds: Aabb,
    /// The object's faces that the triangles of a mesh are, where some were left out.
    pub(super) faces: Option<Arc<[u32]>>,
    /// For the rays of one view.
    pub(super) prepared: Option<Prepared>,
}

#[derive(Debug)]
pub(super) enum LocalShape {
    Mesh(Arc<TriangleBvh>),
    Rectangle(Rectangle),
    Cuboid(Cuboid),
    Analytic(Box<PlacedAnalytic>),
    /// A shape that this layer does not know; no ray meets it.
    Unknown,
}

/// What the instances of a mesh share.
pub(super) struct MeshTree {
    bvh: Arc<TriangleBvh>,
    /// See [`Body::faces`].
    faces: Option<Arc<[u32]>>,
}

impl MeshTree {
    fn of(mesh: &Arc<Mesh>) -> Self {
        let count = mesh.triangles().len();
        let faces: Vec<u32> = (0..count as u32).filter(|&triangle| !mesh.is_repeat(triangle as usize)).collect();
        let distinct = (faces.len() < count).then(|| {
            let positions = mesh.positions().iter().map(|position| position.to_array()).collect();
            Mesh::new(positions, faces.iter().map(|&face| mesh.triangles()[face as usize]).collect()).ok()
        });
        match distinct.flatten() {
            Some(distinct) => Self { bvh: Arc::new(TriangleBvh::build(distinct.into())), faces: Some(faces.into()) },
            None => Self { bvh: Arc::new(TriangleBvh::build(Arc::clone(mesh))), faces: None },
        }
    }
}

impl Body {
    /// No ray meets it.
    pub(super) fn nothing() -> Self {
        let (shape, to_local) = (LocalShape::Unknown, DAffine3::IDENTITY);
        Self { shape, to_local, bounds: Aabb::EMPTY, faces: None, prepared: None }
    }

    pub(super) fn new(object: &Object, meshes: &mut HashMap<*const Mesh, MeshTree>) -> Self {
        let mut faces = None;
        let shape = match &object.shape {
            Shape::Mesh(mesh) => {
                let tree = meshes.entry(Arc::as_ptr(mesh)).or_insert_with(|| MeshTree::of(mesh));
                faces = tree.faces.clone();
                LocalShape::Mesh(Arc::clone(&tree.bvh))
            }
            Shape::Convex(_) => return Self::convex(object),
            Shape::Rectangle(rectangle) => LocalShape::Rectangle(*rectangle),
            Shape::Cuboid(cuboid) => LocalShape::Cuboid(*cuboid),
            _ => object.analytic().map_or(LocalShape::Unknown, |body| LocalShape::Analytic(Box::new(body))),
        };
        Self { shape, to_local: object.placement.map().inverse(), bounds: object.bounds(), faces, prepared: None }
    }

    /// The hull of placed points is a mesh of the world.
    fn convex(object: &Object) -> Self {
        // A mirroring placement turns the loops round: the image through the origin has its fronts outside again.
        let scale = if object.placement.is_mirrored() { -1.0 } else { 1.0 };
        let mesh = object.facets().and_then(|facets| {
            let triangles = facets.triangles()?.to_vec();
            let positions = facets.positions().iter().map(|&position| (position * scale).to_array());
            Mesh::new(positions.collect(), triangles).ok()
        });
        let shape =
            mesh.map_or(LocalShape::Unknown, |mesh| LocalShape::Mesh(Arc::new(TriangleBvh::build(mesh.into()))));
        let to_local = DAffine3::from_scale(DVec3::splat(scale));
        Self { shape, to_local, bounds: object.bounds(), faces: None, prepared: None }
    }

    /// The nearest hit of a local ray.
    pub(super) fn nearest(&self, local: &Ray, t_max: f64) -> Option<LocalHit> {
        let hit = match &self.shape {
            LocalShape::Mesh(bvh) => mesh_hit(bvh, self.prepared.as_ref(), local, t_max),
            LocalShape::Rectangle(rectangle) => local::rectangle(rectangle, local),
            LocalShape::Cuboid(cuboid) => local::cuboid(cuboid, local),
            LocalShape::Analytic(body) => local::analytic(body, local),
            LocalShape::Unknown => None,
        };
        hit.filter(|hit| hit.distance <= t_max)
    }

    /// The ray in local coordinates. Not normalised: distances stay those of the world.
    pub(super) fn pulled(&self, ray: &Ray) -> Ray {
        Ray::new(self.to_local.transform_point3(ray.origin), self.to_local.transform_vector3(ray.direction))
    }

    /// Normals go by the transposed inverse. Under a mirroring map that also keeps the front at the front.
    pub(super) fn world_normal(&self, local: DVec3) -> DVec3 {
        (self.to_local.matrix3.transpose() * local).normalize_or_zero()
    }
}

fn mesh_hit(bvh: &TriangleBvh, prepared: Option<&Prepared>, ray: &Ray, t_max: f64) -> Option<LocalHit> {
    let looked_up = prepared.and_then(|prepared| prepared.nearest_hit(ray, t_max));
    let hit = looked_up.unwrap_or_else(|| bvh.nearest_hit(ray.origin, ray.direction, t_max))?;
    Some(triangle_hit(bvh, hit))
}

/// A hit of a triangle of the BVH, with its parameters and normal.
pub(super) fn triangle_hit(bvh: &TriangleBvh, hit: Hit) -> LocalHit {
    let [a, b, c] = bvh.corners(hit.triangle);
    let (u, v) = into_triangle(hit.u, hit.v);
    LocalHit { distance: hit.t, face: hit.triangle as usize, u, v, normal: (b - a).cross(c - a) }
}

/// Takes back what rounding carried out of u, v ≥ 0, u + v ≤ 1. Where the sum is too large the larger parameter is at
/// least 1/2, and 1 less that is exact (Sterbenz), so the result lies in the closed triangle exactly.
pub(crate) fn into_triangle(u: f64, v: f64) -> (f64, f64) {
    let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
    if u > v { (u, v.min(1.0 - u)) } else { (u.min(1.0 - v), v) }
}

#[cfg(test)]
mod tests {
    use super::into_triangle;

    #[test]
    fn parameters_stay_in_their_triangle() {
        for (u, v) in [(0.3, 0.7000000000000002), (1.0000000000000002, -1e-17), (0.5, 0.5), (0.1, 0.9), (0.25, 0.25)] {
            let (inside_u, inside_v) = into_triangle(u, v);
            assert!(inside_u >= 0.0 && inside_v >= 0.0);
            assert!(1.0 - inside_u.max(inside_v) >= inside_u.min(inside_v));
            assert!((inside_u - u).abs() < 1e-15 && (inside_v - v).abs() < 1e-15);
        }
    }
}
