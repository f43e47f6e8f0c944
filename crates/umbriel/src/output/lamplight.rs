//! The part of a scene that a picture's lights reach: all of it, or with cells what portals let through.
//!
//! What a light does not reach is dark by it, and shadows none of what it reaches; so questions about light go to a scene of only what some light reaches.

use umbriel_scene::Scene;
use umbriel_visibility::portals::reach_of_light;

/// Where the lights of a picture are asked about.
pub(crate) enum Lamplight<'a> {
    Whole(&'a Scene),
    Part(Box<Part>),
}

/// What some light reaches.
pub(crate) struct Part {
    scene: Scene,
    /// The objects of that scene, by their indices in the whole one; sorted.
    sources: Vec<usize>,
    /// What each of the lights reaches, sorted.
    reached: Vec<Vec<usize>>,
}

impl<'a> Lamplight<'a> {
    /// For some lights of the scene.
    pub(crate) fn new(scene: &'a Scene, lights: &[usize]) -> Self {
        if scene.cells.is_empty() {
            return Self::Whole(scene);
        }
        let reach = |&light: &usize| reach_of_light(scene, &scene.lights[light].source).indices().collect();
        let reached: Vec<Vec<usize>> = lights.iter().map(reach).collect();
        let mut sources = reached.concat();
        sources.sort_unstable();
        sources.dedup();
        let objects = sources.iter().map(|&source| scene.objects[source].clone()).collect();
        Self::Part(Box::new(Part { scene: Scene { objects, ..Scene::default() }, sources, reached }))
    }

    /// The scene that is asked.
    pub(crate) fn scene(&self) -> &Scene {
        match self {
            Self::Whole(scene) => scene,
            Self::Part(part) => &part.scene,
        }
    }

    /// The place of an object in that scene; `None` if the light, by its number among those of the picture, does not reach it.
    pub(crate) fn place(&self, light: usize, object: usize) -> Option<usize> {
        match self {
            Self::Whole(_) => Some(object),
            Self::Part(part) => {
                part.reached[light].binary_search(&object).ok()?;
                part.sources.binary_search(&object).ok()
            }
        }
    }
}
