//! The scene's bodies as the fine step needs them, each built when it is first asked for.

use std::sync::OnceLock;

use umbriel_geometry::{Aabb, Approx, Facets, Placement, Sphere, SphereForm};
use umbriel_scene::{Object, Scene, Shape};

/// A placed body.
#[derive(Debug)]
pub(crate) enum Body {
    /// Planar faces.
    Flat(Facets),
    /// A sphere.
    Round(Box<Round>),
}

/// A placed sphere.
#[derive(Debug)]
pub(crate) struct Round {
    pub(crate) sphere: Sphere,
    pub(crate) placement: Placement,
    pub(crate) form: SphereForm<Approx>,
}

/// All bodies of a scene.
#[derive(Debug)]
pub(crate) struct Bodies<'a> {
    pub(crate) scene: &'a Scene,
    /// World boxes, rounded outward.
    pub(crate) boxes: Vec<Aabb>,
    bodies: Vec<OnceLock<Body>>,
}

impl<'a> Bodies<'a> {
    /// Computes the boxes; nothing else yet.
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let boxes = scene.objects.iter().map(Object::bounds).collect();
        Self { scene, boxes, bodies: scene.objects.iter().map(|_| OnceLock::new()).collect() }
    }

    /// The object's body.
    pub(crate) fn get(&self, object: usize) -> &Body {
        self.bodies[object].get_or_init(|| {
            let object = &self.scene.objects[object];
            match (&object.shape, object.facets()) {
                (Shape::Sphere(sphere), _) => Body::Round(Box::new(Round {
                    sphere: *sphere,
                    placement: object.placement,
                    form: sphere.form(&object.placement),
                })),
                (_, facets) => Body::Flat(facets.unwrap_or_default()),
            }
        })
    }

    /// Whether a face can be lit on one side only.
    pub(crate) fn is_one_sided(&self, object: usize, face: usize) -> bool {
        let closed = match self.get(object) {
            Body::Flat(facets) => facets.is_closed(face),
            Body::Round(_) => true,
        };
        self.scene.objects[object].is_one_sided(closed)
    }
}
