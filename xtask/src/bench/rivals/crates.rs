//! Published crates.

use std::time::Duration;

use anyhow::{Result, anyhow};
use bvh::{
    aabb::{Aabb, Bounded},
    bounding_hierarchy::BHShape,
    bvh::Bvh,
};
use glam::Vec3A;
use nalgebra::{Point3, Vector3};
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    triangle::Triangle,
};
use parry3d::{math::Vector, query::RayCast, shape::TriMesh};

use umbriel_geometry::LightSource;

use super::{Ray, Rival, Soup, Tree};

pub(super) fn all() -> Vec<Rival> {
    vec![
        Rival { name: "obvhs fast", build: |soup| Ok(Box::new(Compressed::build(soup, BvhBuildParams::fast_build()))) },
        Rival {
            name: "obvhs medium",
            build: |soup| Ok(Box::new(Compressed::build(soup, BvhBuildParams::medium_build()))),
        },
        Rival { name: "bvh", build: |soup| Ok(Box::new(Binary::build(soup))) },
        Rival { name: "parry3d", build: |soup| Ok(Box::new(parry(soup)?)) },
    ]
}

fn corners<T>(soup: &Soup, make: impl Fn([f32; 3]) -> T) -> impl Iterator<Item = [T; 3]> {
    soup.triangles.iter().map(move |triangle| triangle.map(|corner| make(soup.positions[corner as usize])))
}

/// `obvhs`: eight-wide compressed nodes, triangles in the order of the leaves.
struct Compressed {
    tree: CwBvh,
    triangles: Vec<Triangle>,
}

impl Compressed {
    fn build(soup: &Soup, parameters: BvhBuildParams) -> Self {
        let triangles: Vec<Triangle> =
            corners(soup, Vec3A::from_array).map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
        let tree = build_cwbvh_from_tris(&triangles, parameters, &mut Duration::default());
        let triangles = tree.primitive_indices.iter().map(|&index| triangles[index as usize]).collect();
        Self { tree, triangles }
    }
}

impl Tree for Compressed {
    fn count_free(&self, _: &LightSource, rays: &mut dyn Iterator<Item = Ray>) -> u64 {
        let is_free = |ray: &Ray| {
            let single = obvhs::ray::Ray::new(ray.origin.as_vec3a(), ray.direction.as_vec3a(), 0.0, ray.t_max as f32);
            self.tree.ray_traverse_miss(single, |ray, index| self.triangles[index].intersect(ray))
        };
        rays.filter(is_free).count() as u64
    }
}

/// `bvh`: a binary tree whose candidates are tested one by one. Its test of a triangle sees one side, so it is asked twice.
struct Binary {
    tree: Bvh<f32, 3>,
    triangles: Vec<Corners>,
}

struct Corners {
    points: [Point3<f32>; 3],
    node: usize,
}

impl Bounded<f32, 3> for Corners {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [a, b, c] = &self.points;
        Aabb::empty().grow(a).grow(b).grow(c)
    }
}

impl BHShape<f32, 3> for Corners {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Binary {
    fn build(soup: &Soup) -> Self {
        let mut triangles: Vec<Corners> =
            corners(soup, Point3::from).map(|points| Corners { points, node: 0 }).collect();
        let tree = Bvh::build(&mut triangles);
        Self { tree, triangles }
    }
}

impl Tree for Binary {
    fn count_free(&self, _: &LightSource, rays: &mut dyn Iterator<Item = Ray>) -> u64 {
        let is_free = |ray: &Ray| {
            let direction = Vector3::from(ray.direction.as_vec3().to_array());
            // Its rays are of unit length.
            let reach = ray.t_max as f32 * direction.norm();
            let single = bvh::ray::Ray::new(Point3::from(ray.origin.as_vec3().to_array()), direction);
            !self.tree.traverse_iterator(&single, &self.triangles).any(|triangle| {
                let [a, b, c] = &triangle.points;
                let distances = [[a, b, c], [a, c, b]].map(|[a, b, c]| single.intersects_triangle(a, b, c).distance);
                distances[0].min(distances[1]) < reach
            })
        };
        rays.filter(is_free).count() as u64
    }
}

/// `parry3d`: its mesh of triangles.
fn parry(soup: &Soup) -> Result<TriMesh> {
    let positions = soup.positions.iter().map(|&[x, y, z]| Vector::new(x, y, z)).collect();
    TriMesh::new(positions, soup.triangles.clone()).map_err(|error| anyhow!("parry3d: {error:?}"))
}

impl Tree for TriMesh {
    fn count_free(&self, _: &LightSource, rays: &mut dyn Iterator<Item = Ray>) -> u64 {
        let is_free = |ray: &Ray| {
            let [origin, direction] = [ray.origin, ray.direction].map(|v| v.as_vec3().to_array().into());
            self.cast_local_ray(&parry3d::query::Ray::new(origin, direction), ray.t_max as f32, true).is_none()
        };
        rays.filter(is_free).count() as u64
    }
}
