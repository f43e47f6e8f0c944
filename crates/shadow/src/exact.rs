//! One point, exactly: lit or not, by the definition and without cells.

use umbriel_geometry::{
    LightSource, Ring, Sign,
    blocking::{Probe, polygon_blocks, sphere_blocks, sphere_light_side},
};

use crate::bodies::{Bodies, Body, Round};

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
            let mut corners = [facets.point(0); 4];
            let numbers = facets.facet(face).corners();
            for (point, &corner) in corners.iter_mut().zip(numbers) {
                *point = facets.point(corner);
            }
            polygon_blocks(&corners[..numbers.len()], x, light)
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

/// How a point of a sphere stands to the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turned {
    /// The light is nowhere strictly on the lit side.
    Away,
    /// It is, and the sphere itself lies behind the point.
    Outward,
    /// It is, on the inner side: the rest of the sphere may be in the way.
    Inward,
}

/// How a point of a placed sphere's surface stands to the light.
pub(crate) fn sphere_turn<R: Ring>(round: &Round, is_one_sided: bool, x: &Probe<R>, light: &LightSource) -> Turned {
    match sphere_light_side(&round.form, || round.sphere.exact_form::<R>(&round.placement), x, light) {
        Sign::Positive => Turned::Outward,
        Sign::Negative if !is_one_sided => Turned::Inward,
        _ => Turned::Away,
    }
}
