//! The placed faces of a scene as rivals take them: triangles, with what they need to know of each.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{
    Aabb, Dyadic, ExactPoint, Facet, Facets, LightSource, Mesh, PlacedAnalytic, Placement, analytic::Occupied,
};
use umbriel_scene::Scene;

use crate::SamplePoint;

/// a + u(b − a) + v(d − a) is rounded six times, each time by u = 2⁻⁵³ of at most five times the largest coordinate M of the corners, and corners
/// that are no floats by u M: 31 u M < 16 · 2⁻⁵² M.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A point of the surface, rounded to floats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RivalPoint {
    /// World coordinates, metres.
    pub position: DVec3,
    /// Towards the front; any length but zero.
    pub normal: DVec3,
    /// Index into the scene's objects.
    pub object: u32,
    /// Face of the object.
    pub face: u32,
    /// Whether only the front can be lit.
    pub is_one_sided: bool,
    /// How far the rounded position may be from the surface on any axis, metres.
    pub slack: f64,
}

impl RivalPoint {
    /// Whether the lit side is turned to the light, in floats.
    pub fn is_turned_to(&self, light: &LightSource) -> bool {
        let along = self.normal.dot(light.xyz() - light.w() * self.position);
        if self.is_one_sided { along > 0.0 } else { along != 0.0 }
    }
}

/// What a triangle belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Owner {
    pub(crate) object: u32,
    /// Face of the object; of a curved body, none.
    pub(crate) face: Option<u32>,
    /// Which way the front of a closed surface looks: 1 along the winding, −1 against it; 0 for what is not closed.
    pub(crate) outward: i8,
}

/// All faces of a scene as triangles in world coordinates.
#[derive(Debug)]
pub struct Polygons<'a> {
    scene: &'a Scene,
    /// Placed faces; of curved bodies, those of the mesh that stands for them.
    facets: Vec<Facets>,
    curved: Vec<Option<PlacedAnalytic>>,
    bounds: Vec<Aabb>,
    mesh: Arc<Mesh>,
    owners: Vec<Owner>,
    /// Per corner of `mesh`: equal within an object where positions are.
    firsts: Vec<u32>,
}

impl<'a> Polygons<'a> {
    /// Places all faces; the patches of curved bodies are cut into 2 × `divisions`² triangles each. O(n log n).
    ///
    /// # Panics
    /// When a placed corner is no accepted number; objects with such corners are refused before.
    pub fn new(scene: &'a Scene, divisions: u32) -> Self {
        let curved: Vec<Option<PlacedAnalytic>> = scene.objects.iter().map(|object| object.analytic()).collect();
        let facets: Vec<Facets> = scene
            .objects
            .par_iter()
            .zip(&curved)
            .map(|(object, body)| match body {
                Some(body) => tessellate(body, divisions.max(1)),
                None => object.facets().unwrap_or_default(),
            })
            .collect();
        let bounds = facets.iter().map(Facets::bounds).collect();
        let (mut positions, mut triangles, mut owners, mut firsts) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (object, facets) in facets.iter().enumerate() {
            let first = positions.len() as u32;
            let cut = triangles_of(facets);
            let outward = outward_signs(facets, &cut);
            positions.extend(facets.positions().iter().map(DVec3::to_array));
            firsts.extend((0..facets.positions().len() as u32).map(|point| facets.first_at(point) + first));
            triangles.extend(cut.iter().map(|(corners, _)| corners.map(|corner| corner + first)));
            owners.extend(cut.iter().zip(outward).map(|(&(_, face), outward)| Owner {
                object: object as u32,
                face: curved[object].is_none().then_some(face),
                outward,
            }));
        }
        let mesh = Arc::new(Mesh::new(positions, triangles).expect("placed faces have accepted corners"));
        Self { scene, facets, curved, bounds, mesh, owners, firsts }
    }

    /// How many triangles.
    pub fn len(&self) -> usize {
        self.owners.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.owners.is_empty()
    }

    /// The triangles.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The box of everything.
    pub fn bounds(&self) -> Aabb {
        self.bounds.iter().fold(Aabb::EMPTY, |all, own| all.union(*own))
    }

    /// The boxes of the objects.
    pub(crate) fn boxes(&self) -> &[Aabb] {
        &self.bounds
    }

    pub(crate) fn facets(&self, object: usize) -> &Facets {
        &self.facets[object]
    }

    pub(crate) fn scene(&self) -> &'a Scene {
        self.scene
    }

    pub(crate) fn is_curved(&self, object: usize) -> bool {
        self.curved[object].is_some()
    }

    pub(crate) fn owner(&self, triangle: usize) -> Owner {
        self.owners[triangle]
    }

    /// The first points at a triangle's corners: equal for equal positions within an object, different between objects.
    pub(crate) fn welded(&self, triangle: usize) -> [u32; 3] {
        self.mesh.triangles()[triangle].map(|corner| self.firsts[corner as usize])
    }

    pub(crate) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.mesh.triangles()[triangle].map(|corner| self.mesh.positions()[corner as usize])
    }

    /// Whether a triangle stands for the surface that a point lies on.
    pub(crate) fn is_own(&self, triangle: usize, point: &RivalPoint) -> bool {
        let owner = self.owners[triangle];
        owner.object == point.object && owner.face.is_none_or(|face| face == point.face)
    }

    /// A sampled point of the surface, rounded; `None` where there is no surface.
    ///
    /// # Panics
    /// If there is no such object or face.
    pub fn point(&self, sample: &SamplePoint) -> Option<RivalPoint> {
        let &SamplePoint { object, face, u, v, .. } = sample;
        let (position, normal, is_closed, size) = match &self.curved[object] {
            None => {
                let facets = &self.facets[object];
                let corners = facets.facet(face).corners();
                let [a, b, d] = [0, 1, corners.len() - 1].map(|k| facets.positions()[corners[k] as usize]);
                let normal = (b - a).cross(d - a) * if facets.is_mirrored() { -1.0 } else { 1.0 };
                let size = [a, b, d].map(|corner| corner.abs().max_element()).into_iter().fold(0.0, f64::max);
                (a + u * (b - a) + v * (d - a), normal, facets.is_closed(face), size)
            }
            Some(body) => {
                let chart = &body.charts()[face];
                let position = body.placement().map().transform_point3(chart.point(u, v));
                let exact = ExactPoint::<Dyadic>::from_position(position);
                let normal = body.outward(chart.surface, &exact).map(|part| part.to_nearest());
                let Aabb { min, max } = self.bounds[object];
                (position, normal.into(), body.body().is_closed(), min.abs().max(max.abs()).max_element())
            }
        };
        let is_one_sided = self.scene.objects[object].is_one_sided(|| is_closed);
        let slack = ROUNDING * size;
        let (object, face) = (object as u32, face as u32);
        (normal != DVec3::ZERO).then_some(RivalPoint { position, normal, object, face, is_one_sided, slack })
    }
}

/// Faces as triangles, each with its face.
pub(crate) fn triangles_of(facets: &Facets) -> Vec<([u32; 3], u32)> {
    let mut triangles = Vec::with_capacity(facets.len());
    for (face, facet) in (0..).zip(facets.iter()) {
        match facet {
            Facet::Triangle(corners) => triangles.push((corners, face)),
            Facet::Parallelogram([a, b, c, d]) => triangles.extend([([a, b, c], face), ([a, c, d], face)]),
        }
    }
    triangles
}

/// Which way the front of each triangle's closed component looks, by the sign of its volume; 0 for open ones.
fn outward_signs(facets: &Facets, triangles: &[([u32; 3], u32)]) -> Vec<i8> {
    let topology = facets.topology();
    let center = facets.bounds().center();
    let mut volumes = vec![0.0; topology.components.len()];
    let component = |face: u32| topology.component_of[face as usize] as usize;
    for &(corners, face) in triangles {
        let [a, b, c] = corners.map(|corner| facets.positions()[corner as usize] - center);
        volumes[component(face)] += a.dot(b.cross(c));
    }
    let sign = |&(_, face): &([u32; 3], u32)| match (topology.components[component(face)], volumes[component(face)]) {
        (component, volume) if component.is_closed() && volume != 0.0 => volume.signum() as i8,
        _ => 0,
    };
    triangles.iter().map(sign).collect()
}

/// The patches of a body on a lattice. Where a patch fills its square in part only, cells that are not surface as a whole are left out.
fn tessellate(body: &PlacedAnalytic, divisions: u32) -> Facets {
    let (mut positions, mut triangles) = (Vec::<[f64; 3]>::new(), Vec::new());
    let step = 1.0 / f64::from(divisions);
    for chart in body.charts() {
        let first = positions.len() as u32;
        for (i, j) in (0..=divisions).flat_map(|i| (0..=divisions).map(move |j| (i, j))) {
            let local = chart.point(f64::from(i) * step, f64::from(j) * step);
            positions.push(body.placement().map().transform_point3(local).to_array());
        }
        for (i, j) in (0..divisions).flat_map(|i| (0..divisions).map(move |j| (i, j))) {
            let middle = [(f64::from(i) + 0.5) * step, (f64::from(j) + 0.5) * step];
            let is_surface = chart.occupied(middle, 0.0) == Occupied::Whole
                || chart.exact_point(body.placement(), middle[0], middle[1]).is_some();
            if is_surface {
                let a = first + i * (divisions + 1) + j;
                let [b, c, d] = [a + divisions + 1, a + divisions + 2, a + 1];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    if positions.iter().flatten().any(|coordinate| !coordinate.is_finite()) {
        return Facets::default();
    }
    Mesh::new(positions, triangles)
        .map_or_else(|_| Facets::default(), |mesh| Facets::of_mesh(mesh, &Placement::IDENTITY))
}
