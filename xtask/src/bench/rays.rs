//! The same work for ray engines: triangles, and one ray for every sample.
//!
//! Triangles are 32-bit. Samples lie on the surface in the order of the bake, with the unit normals of their faces;
//! rays start off the surface by [`OFFSET`] of the scene's diagonal, as is usual with such engines. The offset and the
//! rounding are where their answers go wrong: `umbriel` needs neither.

use std::{
    fs::File,
    io::{BufWriter, Seek, SeekFrom, Write},
    ops::Range,
    path::Path,
};

use anyhow::{Context, Result};
use glam::DVec3;
use umbriel_geometry::{Aabb, Facet, Facets, LightSource};
use umbriel_scene::{Scene, Sides};
use umbriel_shadow::{Request, SamplePoint, for_each_sample};

use super::rivals::Ray;

/// How far rays start off the surface, in diagonals of the scene's bounding box.
const OFFSET: f64 = 1e-5;

/// The triangles of a whole scene.
pub(super) struct Soup {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Metres.
    pub(super) offset: f32,
    facets: Vec<Facets>,
    two_sided: Vec<bool>,
}

/// A sample and its number among all of the bake.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbered {
    pub(super) number: usize,
    pub(super) sample: SamplePoint,
}

/// Where a ray starts, before the offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    pub(super) position: DVec3,
    /// Of unit length.
    pub(super) normal: DVec3,
    /// Whether the normal may be turned to the light.
    pub(super) is_two_sided: bool,
}

impl Soup {
    /// Flattens a scene whose bodies are all flat.
    pub(super) fn of(scene: &Scene) -> Result<Self> {
        let facets = scene.objects.iter().map(|object| {
            object.facets().with_context(|| format!("{} is curved: ray engines here know triangles only", object.name))
        });
        let facets = facets.collect::<Result<Vec<_>>>()?;
        let (mut positions, mut triangles, mut bounds) = (Vec::new(), Vec::new(), Aabb::EMPTY);
        for facets in &facets {
            let first = positions.len() as u32;
            bounds = bounds.union(facets.bounds());
            positions.extend(facets.positions().iter().map(|position| position.as_vec3().to_array()));
            for facet in facets.iter() {
                match facet {
                    Facet::Triangle(corners) => triangles.push(corners.map(|corner| first + corner)),
                    Facet::Parallelogram(corners) => {
                        let [a, b, c, d] = corners.map(|corner| first + corner);
                        triangles.extend([[a, b, c], [a, c, d]]);
                    }
                }
            }
        }
        let two_sided = scene.objects.iter().map(|object| object.sides == Sides::Two).collect();
        Ok(Self { positions, triangles, offset: (OFFSET * bounds.size().length()) as f32, facets, two_sided })
    }

    /// Calls `visit` with every sample and its number, in the order of the bake. Slivers whose normal rounds to nothing are left out:
    /// ray engines cannot tell their sides.
    pub(super) fn for_each_start(&self, scene: &Scene, request: &Request, mut visit: impl FnMut(Numbered, Start)) {
        let mut number = 0;
        let mut known = (usize::MAX, usize::MAX);
        let (mut corner, mut along, mut normal) = (DVec3::ZERO, [DVec3::ZERO; 2], DVec3::ZERO);
        for_each_sample(scene, request, |sample| {
            if known != (sample.object, sample.face) {
                known = (sample.object, sample.face);
                let facets = &self.facets[sample.object];
                let corners = facets.facet(sample.face).corners();
                let [a, b, d] = [corners[0], corners[1], corners[corners.len() - 1]]
                    .map(|corner| facets.positions()[corner as usize]);
                (corner, along, normal) = (a, [b - a, d - a], (b - a).cross(d - a).normalize_or_zero());
            }
            let position = corner + along[0] * sample.u + along[1] * sample.v;
            if normal != DVec3::ZERO {
                visit(
                    Numbered { number, sample },
                    Start { position, normal, is_two_sided: self.two_sided[sample.object] },
                );
            }
            number += 1;
        });
    }

    /// Writes triangles and samples in the form that the Embree program reads; answers the number of samples.
    pub(super) fn write(&self, scene: &Scene, request: &Request, path: &Path) -> Result<u64> {
        let mut file = BufWriter::with_capacity(1 << 20, File::create(path)?);
        let mut write = |bytes: &[u8]| file.write_all(bytes);
        let counts = [self.positions.len(), self.triangles.len()];
        counts.iter().try_for_each(|&count| write(&(count as u32).to_le_bytes()))?;
        write(&[0; 16])?;
        write(&self.offset.to_le_bytes())?;
        write(&[0; 4])?;
        self.positions.iter().flatten().try_for_each(|coordinate| write(&coordinate.to_le_bytes()))?;
        self.triangles.iter().flatten().try_for_each(|corner| write(&corner.to_le_bytes()))?;
        let (mut samples, mut outcome) = (0u64, Ok(()));
        let mut ranges: Vec<Range<u64>> = Vec::new();
        self.for_each_start(scene, request, |_, start| {
            let numbers = [start.position.as_vec3(), start.normal.as_vec3()].map(|vector| vector.to_array());
            for number in numbers.as_flattened() {
                if outcome.is_ok() {
                    outcome = write(&number.to_le_bytes());
                }
            }
            match ranges.last_mut() {
                Some(range) if start.is_two_sided && range.end == samples => range.end += 1,
                _ if start.is_two_sided => ranges.push(samples..samples + 1),
                _ => {}
            }
            samples += 1;
        });
        outcome?;
        ranges.iter().flat_map(|range| [range.start, range.end]).try_for_each(|end| write(&end.to_le_bytes()))?;
        file.seek(SeekFrom::Start(8))?;
        file.write_all(&samples.to_le_bytes())?;
        file.write_all(&(ranges.len() as u64).to_le_bytes())?;
        file.flush()?;
        Ok(samples)
    }
}

impl Start {
    /// The normal, of a two-sided face turned to the light.
    fn normal_towards(&self, light: &LightSource) -> DVec3 {
        let is_turned = self.is_two_sided && self.towards(self.position, light).dot(self.normal) < 0.0;
        if is_turned { -self.normal } else { self.normal }
    }

    fn towards(&self, origin: DVec3, light: &LightSource) -> DVec3 {
        if light.is_sun() { light.xyz() } else { light.xyz() - origin }
    }

    /// The ray to a light, off the surface, or `None` where the surface looks away. `t` runs to 1 at a lamp.
    pub(super) fn ray(&self, light: &LightSource, offset: f32) -> Option<Ray> {
        let normal = self.normal_towards(light);
        let origin = self.position + normal * f64::from(offset);
        let direction = self.towards(origin, light);
        let t_max = if light.is_sun() { f64::INFINITY } else { 1.0 };
        (direction.dot(normal) > 0.0).then_some(Ray { origin, direction, t_max })
    }

    /// The same start as a loose point: position and normal, with the roundings of the Embree program.
    pub(super) fn point(&self, light: &LightSource, offset: f32) -> [f32; 6] {
        let (position, normal) = (self.position.as_vec3(), self.normal_towards(light).as_vec3());
        let [x, y, z] = (position + normal * offset).to_array();
        [x, y, z, normal.x, normal.y, normal.z]
    }
}
