//! One point, exactly: lit or not, by the definition and without cells.

use umbriel_geometry::{LightSource, PlacedAnalytic, Ring, Sign, Surd, analytic::Surface, blocking::Probe};

use crate::bodies::{Bodies, Body};

/// What the surface at a point itself can do to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Own {
    /// The point lies in space.
    Nothing,
    /// It lies on this flat face, which is in contact only.
    Face { object: usize, face: usize },
    /// It lies on an analytic body that is wholly behind it, seen from the light.
    Harmless { object: usize },
    /// It lies on this surface of an analytic body, whose rest may be in the way.
    Surface { object: usize, surface: Surface },
}

/// Whether one face (an analytic body as a whole counts as one) blocks the way from a point to the light.
pub(crate) fn face_blocks<R: Ring>(
    bodies: &Bodies,
    (object, face): (usize, usize),
    x: &Probe<R>,
    own: Own,
    light: &LightSource,
) -> bool {
    match bodies.get(object) {
        Body::Flat(_) if own == (Own::Face { object, face }) => false,
        Body::Flat(facets) => facets.blocks(face, x, light),
        Body::Analytic(_) if own == (Own::Harmless { object }) => false,
        Body::Analytic(body) => {
            let surface = match own {
                Own::Surface { object: number, surface } if number == object => Some(surface),
                _ => None,
            };
            body.blocks(x, surface, light)
        }
    }
}

/// Whether the light is strictly on the lit side of a flat face.
pub(crate) fn flat_face_is_turned_to(bodies: &Bodies, object: usize, face: usize, light: &LightSource) -> bool {
    flat_face_is_lit(bodies, (object, face), light, None)
}

/// Whether the light is strictly on the lit side of a flat face whose corners turn like this as seen from the light;
/// `None` if that is not known.
#[inline]
pub(crate) fn flat_face_is_lit(
    bodies: &Bodies,
    (object, face): (usize, usize),
    light: &LightSource,
    turn: Option<Sign>,
) -> bool {
    let Body::Flat(facets) = bodies.get(object) else { return false };
    if bodies.is_dark(object) {
        return false;
    }
    let turn = turn.unwrap_or_else(|| facets.turn(face, light));
    let side = if facets.is_mirrored() { turn.flipped() } else { turn };
    match side {
        Sign::Positive => true,
        Sign::Zero => false,
        Sign::Negative => !bodies.is_one_sided(object, face),
    }
}

/// What a point on a surface of an analytic body has to fear from that body; `None` when its lit side is turned away.
pub(crate) fn turned_to<R: Ring>(
    bodies: &Bodies,
    object: usize,
    surface: Surface,
    x: &Probe<R>,
    light: &LightSource,
) -> Option<Own> {
    let Body::Analytic(body) = bodies.get(object) else { return None };
    match body.facing(surface, x, light) {
        Sign::Positive if body.body().is_convex() => Some(Own::Harmless { object }),
        Sign::Positive => Some(Own::Surface { object, surface }),
        Sign::Negative if !bodies.is_one_sided(object, 0) => Some(Own::Surface { object, surface }),
        _ => None,
    }
}

/// The exact point (u, v) of a patch, and floats round it; `None` where there is no surface.
pub(crate) fn patch_probe(body: &PlacedAnalytic, face: usize, u: f64, v: f64) -> Option<Probe<'_, Surd>> {
    let chart = &body.charts()[face];
    chart.has_point(u, v).then(|| Probe::on_patch(chart, body.placement(), u, v))
}
