//! The oracle: what is lit, by definition.
//!
//! Slow, exact and without any acceleration: every point is tested against every face with exact arithmetic of its own
//! ([`number`]). It shares nothing with the code it judges but the plain data of a scene: shapes, matrices, lights. A
//! point x is lit by L when L is strictly on its lit side and the open segment between them meets no surface.
//!
//! The environment variable `UMBRIEL_CASES` sets how many cases a judge looks at, in place of its own small number;
//! `UMBRIEL_FIRST` the number of the first one, for judges that count.

pub(crate) mod blocking;
pub(crate) mod body;
pub(crate) mod curved;
pub(crate) mod dice;
pub(crate) mod fixtures;
pub(crate) mod graze;
pub(crate) mod hull;
pub(crate) mod margin;
pub(crate) mod number;
pub(crate) mod patches;
pub(crate) mod sheets;
pub(crate) mod slack;
pub(crate) mod solids;

use std::ops::Range;

use umbriel_geometry::LightSource;
use umbriel_scene::{Object, Scene};
use umbriel_shadow::SamplePoint;

use blocking::{Lamp, Place, Triangle};
use body::Body;
use number::vector;

/// A scene, ready to be asked.
#[derive(Clone, Debug)]
pub(crate) struct Oracle {
    bodies: Vec<Body>,
    triangles: Vec<Triangle>,
}

impl Oracle {
    /// Looks at the objects of a scene.
    pub(crate) fn new(scene: &Scene) -> Self {
        Self::of_objects(&scene.objects)
    }

    /// Looks at these objects.
    pub(crate) fn of_objects(objects: &[Object]) -> Self {
        let bodies: Vec<Body> = objects.iter().map(Body::new).collect();
        let flats = bodies.iter().filter_map(|body| match body {
            Body::Flats(flats) => Some(flats),
            Body::Round(_) | Body::Bent(_) => None,
        });
        let triangles = flats.flatten().flat_map(|flat| flat.triangles()).collect();
        Self { bodies, triangles }
    }

    /// Whether a sample is lit: the point at the floats of its lattice, which are counted from one of the face's corners.
    pub(crate) fn sample_is_lit(&self, sample: &SamplePoint, light: &LightSource) -> bool {
        let &SamplePoint { object, face, corner, from_corner: [u, v], .. } = sample;
        let Body::Flats(flats) = &self.bodies[object] else { return self.lit(object, face, [u, v], light) };
        let (flat, lamp) = (&flats[face], Lamp::new(light));
        flat.faces(&lamp) && self.is_open(&flat.point_from(usize::from(corner), u, v), &lamp)
    }

    /// Whether the point (u, v) of a face is lit.
    pub(crate) fn lit(&self, object: usize, face: usize, [u, v]: [f64; 2], light: &LightSource) -> bool {
        let lamp = Lamp::new(light);
        match &self.bodies[object] {
            Body::Flats(flats) => flats[face].faces(&lamp) && self.is_open(&flats[face].point(u, v), &lamp),
            Body::Round(round) => {
                let x = round.point(face, u, v);
                round.faces(&x, &lamp) && self.is_open(&x, &lamp)
            }
            Body::Bent(bent) => {
                let (piece, x) = bent.point(face, [u, v]).expect("a point of the surface");
                bent.surface.faces(piece, &x, &lamp) && self.is_open(&x, &lamp)
            }
        }
    }

    /// Whether light reaches a point in space.
    pub(crate) fn lit_in_space(&self, position: [f64; 3], light: &LightSource) -> bool {
        self.is_open(&Place::new(vector(position)), &Lamp::new(light))
    }

    /// The exact point (u, v) of a face.
    pub(crate) fn point(&self, object: usize, face: usize, [u, v]: [f64; 2]) -> Place {
        match &self.bodies[object] {
            Body::Flats(flats) => flats[face].point(u, v),
            Body::Round(round) => round.point(face, u, v),
            Body::Bent(bent) => bent.point(face, [u, v]).expect("a point of the surface").1,
        }
    }

    /// Whether a face has a point (u, v): not all of a general quadric's parameters are taken.
    pub(crate) fn has_point(&self, object: usize, face: usize, parameters: [f64; 2]) -> bool {
        match &self.bodies[object] {
            Body::Bent(bent) => bent.point(face, parameters).is_some(),
            _ => true,
        }
    }

    /// A vector towards the front of a face (of a curved body: outward), rounded; zero for a face without area.
    pub(crate) fn front(&self, object: usize, face: usize, [u, v]: [f64; 2]) -> [f64; 3] {
        match &self.bodies[object] {
            Body::Flats(flats) => flats[face].normal.each_ref().map(|coordinate| coordinate.to_nearest()),
            Body::Round(round) => round.outward(&round.point(face, u, v)),
            Body::Bent(bent) => {
                let (piece, x) = bent.point(face, [u, v]).expect("a point of the surface");
                bent.surface.normal(piece, &x)
            }
        }
    }

    /// Whether the open segment between x and the light meets no surface.
    fn is_open(&self, x: &Place, light: &Lamp) -> bool {
        let by_round = self.bodies.iter().any(|body| match body {
            Body::Flats(_) => false,
            Body::Round(round) => round.surface.blocks(x, light),
            Body::Bent(bent) => bent.surface.blocks(x, light),
        });
        !by_round && !self.triangles.iter().any(|triangle| triangle.blocks(x, light))
    }
}

/// How many cases to look at: `UMBRIEL_CASES`, else `default`.
pub(crate) fn cases(default: u64) -> u64 {
    asked_cases().unwrap_or(default)
}

/// The number of cases that was asked for, if any.
pub(crate) fn asked_cases() -> Option<u64> {
    number_from("UMBRIEL_CASES")
}

/// The numbers of the cases to look at: from `UMBRIEL_FIRST`, else zero, as many as [`cases`] says.
pub(crate) fn case_numbers(default: u64) -> Range<u64> {
    let first = number_from("UMBRIEL_FIRST").unwrap_or(0);
    first..first + cases(default)
}

fn number_from(variable: &str) -> Option<u64> {
    std::env::var(variable).ok().and_then(|text| text.parse().ok())
}
