//! The scene's bodies as the fine step needs them, each built when it is first asked for.

use std::sync::OnceLock;

use rayon::prelude::*;
use umbriel_geometry::{Aabb, Facets, PlacedAnalytic};
use umbriel_scene::{Object, Scene, Shape};

use crate::fine::EdgeTable;

/// A placed body.
#[derive(Debug)]
pub(crate) enum Body {
    /// Planar faces.
    Flat(Facets),
    /// A body given by formulas.
    Analytic(Box<PlacedAnalytic>),
}

/// All bodies of a scene.
#[derive(Debug)]
pub(crate) struct Bodies<'a> {
    pub(crate) scene: &'a Scene,
    /// World boxes, rounded outward.
    pub(crate) boxes: Vec<Aabb>,
    /// Which objects light may reach; all if nothing is said.
    reached: Option<Vec<bool>>,
    bodies: Vec<OnceLock<Body>>,
    edges: Vec<OnceLock<EdgeTable>>,
}

impl<'a> Bodies<'a> {
    /// Computes the boxes; nothing else yet.
    pub(crate) fn new(scene: &'a Scene) -> Self {
        Self::with_boxes(scene, scene.objects.par_iter().map(Object::bounds).collect())
    }

    /// With the world boxes at hand, one an object.
    pub(crate) fn with_boxes(scene: &'a Scene, boxes: Vec<Aabb>) -> Self {
        let bodies = scene.objects.iter().map(|_| OnceLock::new()).collect();
        let edges = scene.objects.iter().map(|_| OnceLock::new()).collect();
        Self { scene, boxes, reached: None, bodies, edges }
    }

    /// With what is known of the objects that light may reach, one entry an object.
    pub(crate) fn reached(self, reached: Vec<bool>) -> Self {
        Self { reached: Some(reached), ..self }
    }

    /// Whether it is known that no light reaches an object.
    pub(crate) fn is_dark(&self, object: usize) -> bool {
        self.reached.as_ref().is_some_and(|reached| !reached[object])
    }

    /// The object's body.
    pub(crate) fn get(&self, object: usize) -> &Body {
        self.bodies[object].get_or_init(|| {
            let object = &self.scene.objects[object];
            match object.analytic() {
                Some(body) => Body::Analytic(Box::new(body)),
                None => Body::Flat(object.facets().unwrap_or_default()),
            }
        })
    }

    /// Whether an object has holes, so that what stands in the way is not all that blocks.
    pub(crate) fn has_holes(&self, object: usize) -> bool {
        matches!(&self.scene.objects[object].shape, Shape::Mesh(mesh) if mesh.has_holes())
    }

    /// Which of an object's flat faces share edges; the same for all lights.
    pub(crate) fn edges(&self, object: usize, facets: &Facets) -> &EdgeTable {
        self.edges[object].get_or_init(|| EdgeTable::of(facets))
    }

    /// Whether a face can be lit on one side only.
    pub(crate) fn is_one_sided(&self, object: usize, face: usize) -> bool {
        let is_closed = || match self.get(object) {
            Body::Flat(facets) => facets.is_closed(face),
            Body::Analytic(body) => body.body().is_closed(),
        };
        self.scene.objects[object].is_one_sided(is_closed)
    }
}
