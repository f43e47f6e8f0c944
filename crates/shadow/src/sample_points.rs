//! The points that a bake samples, for programs that set other methods against it.
//!
//! Every face with area carries a lattice over its parameter square, counted from one of its corners (see
//! [`Cell`](crate::Cell)); its points come row by row, the first parameter outside. The spacing of the lattices is common to all
//! receivers of a request. Cost: one look at every face, then a few operations a point.

use umbriel_geometry::{Facet, Facets};
use umbriel_octree::Quadrant;
use umbriel_scene::Scene;

use crate::{
    bodies::{Bodies, Body},
    exact::patch_probe,
    fine::lattice::{Lattice, Spacing},
    levels::FaceSize,
    receivers::flat_corners,
    report::place_in_face,
    request::Request,
    spacing::{Lattices, spacing},
};

/// A sampled point of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplePoint {
    /// Index into the scene's objects.
    pub object: usize,
    /// Face of the object.
    pub face: usize,
    /// First parameter of the face, counted from its own first corner; within an ulp of one of the point that is sampled.
    pub u: f64,
    /// Second parameter.
    pub v: f64,
    /// The corner from which the face's lattice is counted: of a triangle that of [`Facets::base`], else 0.
    pub corner: u8,
    /// The parameters counted from that corner; these floats are the point that is sampled.
    pub from_corner: [f64; 2],
}

/// Calls `visit` with every point that [`bake`](crate::bake) samples for `request`, receiver by receiver, face by face, and on a face in
/// the order of its lattice. Nothing is visited if the request asks for no samples.
///
/// # Panics
/// If the request names an object that the scene does not have.
pub fn for_each_sample(scene: &Scene, request: &Request, mut visit: impl FnMut(SamplePoint)) {
    let bodies = Bodies::new(scene);
    let Some(spacing) = spacing(&bodies, request) else { return };
    for &object in &request.receivers {
        match bodies.get(object) {
            Body::Flat(facets) => for_each_on_flat(facets, spacing, |face, corner, point| {
                let [u, v] = place_in_face(corner, point);
                visit(SamplePoint { object, face, u, v, corner, from_corner: point });
            }),
            Body::Analytic(body) => {
                for (face, chart) in body.charts().iter().enumerate() {
                    let size = FaceSize::of_patch(chart, body.placement());
                    let lattice = Lattice::new(size.edges, spacing, false);
                    // A patch may fill its square in part only.
                    let points =
                        lattice.points(Quadrant::ROOT).filter(|&[u, v]| patch_probe(body, face, u, v).is_some());
                    points.for_each(|[u, v]| visit(SamplePoint { object, face, u, v, corner: 0, from_corner: [u, v] }));
                }
            }
        }
    }
}

/// A number that [`bake`](crate::bake)'s samples for `request` do not exceed; their answers take a bit each, at least. Zero if it asks for
/// none. Cost: one look at every face.
///
/// # Panics
/// If the request names an object that the scene does not have.
pub fn most_samples(scene: &Scene, request: &Request) -> f64 {
    if request.sampling.is_none() {
        return 0.0;
    }
    let bodies = Bodies::new(scene);
    match spacing(&bodies, request) {
        None => 0.0,
        Some(Spacing::AtMost(spacing) | Spacing::About(spacing)) => Lattices::of(&bodies, request).most_points(spacing),
    }
}

/// Calls `visit` with the face of every sample, the corner that its lattice is counted from, and its parameters from there:
/// these floats are the point.
pub(crate) fn for_each_on_flat(facets: &Facets, spacing: Spacing, mut visit: impl FnMut(usize, u8, [f64; 2])) {
    for face in (0..facets.len()).filter(|&face| facets.area(face).upper() > 0.0) {
        let is_triangle = matches!(facets.facet(face), Facet::Triangle(_));
        let corner = facets.base(face).corner;
        let size = FaceSize::of_flat(&flat_corners(facets, face, corner), is_triangle);
        let points = Lattice::new(size.edges, spacing, is_triangle);
        points.points(Quadrant::ROOT).for_each(|point| visit(face, corner, point));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use umbriel_geometry::{Analytic, LightSource, Mesh, Placement};
    use umbriel_scene::{Light, Object, Shape, Sides};

    use super::*;
    use crate::{Detail, Place, Queries, Sampling, Silent, bake};

    /// A thin triangle over a floor, a triangle without area, and a ball.
    fn scene() -> Scene {
        let mesh = |positions: Vec<[f64; 3]>| {
            let triangles = (0..positions.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
            Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")))
        };
        let object =
            |name: &str, shape| Object::new(name.into(), shape, Placement::IDENTITY, Sides::Two).expect("an object");
        let flat = mesh(vec![[0.0, 1.0, 0.0], [0.1, 1.0, 2.0], [1.0, 1.0, 0.0], [0.0; 3], [1.0; 3], [2.0; 3]]);
        let floor = mesh(vec![[-4.0, 0.0, -4.0], [-4.0, 0.0, 4.0], [4.0, 0.0, -4.0]]);
        let ball = Shape::from(Analytic::Sphere { radius: 0.75 });
        let sun = LightSource::sun([0.25, -1.0, 0.125]).expect("a sun");
        Scene {
            objects: [object("flat", flat), object("floor", floor), object("ball", ball)].into(),
            lights: vec![Light::new("sun", sun)],
            ..Scene::default()
        }
    }

    #[test]
    fn the_points_are_those_of_the_bake() {
        let scene = scene();
        let request =
            Request { sampling: Some(Sampling::Count(3000)), ..Request::everything(&scene, Detail::default()) };
        let report = bake(&scene, &request, &Silent).expect("nobody cancels");
        let queries = Queries::new(&scene);
        let (mut samples, mut lit) = ([0; 3], [0; 3]);
        for_each_sample(&scene, &request, |SamplePoint { object, face, u, v, .. }| {
            let place = Place::Surface { object, face, u, v };
            let answer = queries.lit(&place, &scene.lights[0].source).expect("a point of the surface");
            samples[object] += 1;
            lit[object] += u64::from(answer.lit);
        });
        for (object, report) in report.lights[0].objects.iter().enumerate() {
            let counted = report.samples.expect("samples were asked for");
            assert_eq!((samples[object], lit[object]), (counted.samples, counted.lit), "object {object}");
            assert!(lit[object] > 0, "object {object}");
        }
    }
}
