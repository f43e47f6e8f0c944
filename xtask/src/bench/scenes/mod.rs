//! The scenes of the benchmark, by class: scanned meshes, a dense closed mesh, cities, many meshes, an interior, foliage.
//!
//! All but the scanned ones are made here, the same on every machine. Coordinates and lights are 32-bit floats, so that
//! engines of either precision see the same scene. Each scene has a high sun, a low one, and a lamp.

pub(super) mod bodies;
mod generated;
mod hall;
mod scanned;

use std::sync::Arc;

use anyhow::Result;
use glam::DVec3;
use umbriel_geometry::{Aabb, LightSource, Mesh, Placement};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};

use crate::fixtures::meshes::TriangleMesh;

pub(crate) use generated::{city, knot};
pub(super) use scanned::of_file;

/// A class of scenes, and how its member here is made.
pub(super) struct Class {
    /// What `--scene` names.
    pub(super) name: &'static str,
    /// What it is.
    pub(super) purpose: &'static str,
    /// `None` where its data is absent.
    pub(super) make: fn() -> Result<Option<Scene>>,
}

/// All scenes, in the order of the table.
pub(super) const CLASSES: [Class; 8] = [
    Class { name: "bunny", purpose: "a scanned mesh with holes on a plane", make: scanned::bunny },
    Class { name: "spot", purpose: "a small closed mesh on a plane", make: scanned::spot },
    Class {
        name: "knot",
        purpose: "a dense closed mesh, bumpy and in its own shadow",
        make: || knot(1500, 300).map(Some),
    },
    Class { name: "city", purpose: "20,000 boxes on a plane", make: || city(20_000).map(Some) },
    Class { name: "delft", purpose: "a surveyed town of 570 objects", make: scanned::delft },
    Class {
        name: "field",
        purpose: "1000 spheres of 5120 triangles over a plane",
        make: || generated::field().map(Some),
    },
    Class { name: "hall", purpose: "columns, bricks and drapes round a lamp", make: || hall::hall().map(Some) },
    Class { name: "foliage", purpose: "200,000 leaves over a plane", make: || generated::foliage().map(Some) },
];

/// Degrees of azimuth and elevation of the two suns.
const SUNS: [(&str, f64, f64); 2] = [("high sun", 215.0, 50.0), ("low sun", 248.0, 10.0)];

/// A scene of these objects under the two suns and a lamp.
fn scene(objects: Vec<Object>, lamp: DVec3) -> Result<Scene> {
    let mut lights = Vec::new();
    for (name, azimuth, elevation) in SUNS {
        lights.push(Light { name: name.into(), ..sun_at(azimuth, elevation)? });
    }
    lights.push(Light::new("lamp", LightSource::point(single(lamp).to_array())?));
    Ok(Scene { objects: objects.into(), lights, ..Scene::default() })
}

/// A sun by its angles in degrees; its direction is 32-bit.
pub(super) fn sun_at(azimuth: f64, elevation: f64) -> Result<Light> {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    let level = libm::cos(elevation);
    let towards = DVec3::new(libm::sin(azimuth) * level, libm::sin(elevation), -libm::cos(azimuth) * level);
    Ok(Light::new("sun", LightSource::sun(single(-towards).to_array())?))
}

/// A mesh as an object that stands where its coordinates say.
pub(super) fn object(name: impl Into<String>, mesh: &TriangleMesh, sides: Sides) -> Result<Object> {
    let positions = mesh.positions.iter().map(|&position| single(position).to_array()).collect();
    let shape = Shape::Mesh(Arc::new(Mesh::new(positions, mesh.triangles.clone())?));
    Ok(Object::new(name.into(), shape, Placement::IDENTITY, sides)?)
}

/// The nearest 32-bit numbers.
fn single(vector: DVec3) -> DVec3 {
    DVec3::from_array(vector.to_array().map(|coordinate| f64::from(coordinate as f32)))
}

/// A square plane a little under a body, wide enough for most of its shadow at noon; and a lamp beside and above it.
fn on_a_plane(body: &TriangleMesh) -> Result<Scene> {
    let bounds = Aabb::of(body.positions.iter().copied());
    let (size, middle) = (bounds.size(), bounds.center());
    let half = 0.9 * size.x.max(size.z);
    let height = bounds.min.y - size.y / 8192.0;
    let ground = bodies::ground([middle.x - half, middle.z - half], [middle.x + half, middle.z + half], height);
    let lamp = middle + size * DVec3::new(0.85, 1.15, 0.45);
    scene(vec![object("ground", &ground, Sides::One)?, object("body", body, Sides::One)?], lamp)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_closed_and_wound_outward() {
        for (name, scene, closed) in [
            ("knot", knot(90, 20), vec!["body"]),
            ("city", city(9), vec!["houses"]),
            ("hall", hall::hall(), vec!["columns", "walls"]),
        ] {
            let scene = scene.expect(name);
            for part in closed {
                let object = scene.objects.iter().find(|object| object.name == part).expect(part);
                let facets = object.facets().expect("a mesh");
                assert!((0..facets.len()).all(|facet| facets.is_closed(facet)), "{name}: {part} is closed");
                let corner = |corner: u32| facets.positions()[corner as usize];
                let volume: f64 = facets
                    .iter()
                    .map(|facet| facet.corners().iter().map(|&c| corner(c)).collect::<Vec<_>>())
                    .map(|corners| corners[0].dot(corners[1].cross(corners[2])))
                    .sum();
                assert!(volume > 0.0, "{name}: {part} is wound outward");
            }
        }
    }

    #[test]
    fn suns_stand_where_they_should() {
        let scene = city(1).expect("a city");
        let elevation = |light: usize| scene.lights[light].source.xyz().normalize().y.asin().to_degrees();
        assert!((elevation(0) - 50.0).abs() < 1e-4 && (elevation(1) - 10.0).abs() < 1e-4);
        assert!(!scene.lights[2].source.is_sun());
    }
}
