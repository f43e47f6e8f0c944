//! One point, exactly: lit or not, by the definition and without cells.

use umbriel_geometry::{
    ExactPoint, LightSource, Point, Ring, Sign,
    blocking::{Probe, polygon_blocks, sphere_blocks},
};

use crate::bodies::{Bodies, Body};

/// Whether one face (any of a sphere's patches stands for the whole sphere) blocks the way from a point to the light.
pub(crate) fn face_blocks<R: Ring>(
    bodies: &Bodies,
    object: usize,
    face: usize,
    x: &Probe<R>,
    light: &LightSource,
) -> bool {
    match bodies.get(object) {
        Body::Flat(facets) => {
            let corners: Vec<Point> = facets.facet(face).corners().iter().map(|&corner| facets.point(corner)).collect();
            polygon_blocks(&corners, x, light)
        }
        Body::Round(round) => sphere_blocks(&round.form, || round.sphere.exact_form(&round.placement), x, light),
    }
}

/// Whether the light is strictly on the lit side of a flat face.
pub(crate) fn flat_face_is_turned_to(bodies: &Bodies, object: usize, face: usize, light: &LightSource) -> bool {
    let Body::Flat(facets) = bodies.get(object) else { return false };
    match facets.light_side(face, light) {
        Sign::Positive => true,
        Sign::Zero => false,
        Sign::Negative => !bodies.is_one_sided(object, face),
    }
}

/// Whether the light is strictly on the lit side of a placed sphere at a point of its surface.
pub(crate) fn sphere_is_turned_to<R: Ring>(
    bodies: &Bodies,
    object: usize,
    x: &ExactPoint<R>,
    light: &LightSource,
) -> bool {
    let Body::Round(round) = bodies.get(object) else { return false };
    let form = round.sphere.exact_form::<R>(&round.placement);
    let light = ExactPoint::<R>::from_light(light);
    let local_x = form.pull_back(&x.xyz, &x.w);
    let local_light = form.pull_back(&light.xyz, &light.w);
    match form.value((&local_x, &x.w), (&local_light, &light.w)).sign() {
        Sign::Positive => true,
        Sign::Zero => false,
        Sign::Negative => !bodies.is_one_sided(object, 0),
    }
}
