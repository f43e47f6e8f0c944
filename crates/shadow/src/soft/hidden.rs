//! What a curved body hides of an area light from all of a cell.

use glam::DVec3;
use umbriel_geometry::{Aabb, Dyadic, blocking::Probe};
use umbriel_scene::{Extent, Light};

use super::{
    caps::{Cap, angle, cap_area, common_area},
    cell::Cell,
    fraction::Ball,
    occluders::LightHull,
    polyhedra::Polyhedra,
    views::Views,
    window::Shape,
};
use crate::{bodies::Body, query::Queries};

/// The least and the greatest share of the light that a curved body hides from points of the cell, but for what its polyhedra tell.
pub(super) fn hidden_by(
    queries: &Queries,
    body: u32,
    cell: &Cell,
    views: &Views,
    light: &Light,
    hull: &LightHull,
) -> (f64, f64) {
    if let (Some(ball), Shape::Disk { cap, .. }) = (queries.ball(body), views.centre.shape) {
        return hidden_by_ball(&ball, cap, light, cell);
    }
    let Body::Analytic(placed) = queries.bodies.get(body as usize) else { return (0.0, 1.0) };
    let sources = hull.sources();
    let hides = |corner: DVec3| {
        let probe = Probe::<Dyadic>::at(corner);
        sources.iter().all(|source| placed.blocks(&probe, None, source))
    };
    let hides_all = placed.body().is_convex()
        && cell.corners.iter().all(|&corner| hides(corner))
        && (cell.slack == 0.0 || cell.widened().all(hides));
    match hides_all {
        true => (1.0, 1.0),
        false if polyhedra_before(queries, body, light, hull).is_some() => (0.0, 0.0),
        false => (0.0, 1.0),
    }
}

/// The polyhedra that a curved body lies between, if they tell what it hides: the light must be outside of both. A ball before a
/// round light needs none.
pub(super) fn polyhedra_before<'a>(
    queries: &'a Queries,
    body: u32,
    light: &Light,
    hull: &LightHull,
) -> Option<&'a Polyhedra> {
    if !matches!(light.extent, Extent::Rectangle { .. }) && queries.ball(body).is_some() {
        return None;
    }
    let polyhedra = queries.polyhedra(body)?;
    let is_outside = match hull {
        LightHull::Points(points) => !Aabb::of(points.iter().copied()).meets(&polyhedra.outer.bounds()),
        LightHull::Directions(_) => true,
    };
    is_outside.then_some(polyhedra)
}

/// The least and greatest share of a round light that a ball hides from a cell: the overlap of two caps grows with the ball's cap and falls with
/// their distance; radii and distance change by no more than the cell's reach does to each.
fn hidden_by_ball(ball: &Ball, light_cap: Cap, light: &Light, cell: &Cell) -> (f64, f64) {
    let reach = cell.reach() * (1.0 + 8.0 * f64::EPSILON);
    let to_ball = ball.center - cell.middle;
    let at_ball = to_ball.length();
    if at_ball - reach <= ball.radius {
        return (0.0, 1.0);
    }
    let ball_radii = [at_ball + reach, at_ball - reach].map(|distance| libm::asin(ball.radius / distance));
    let (light_radii, light_turn) = match light.extent {
        Extent::Sphere { radius } => {
            let distance = light_cap.towards.length();
            // A ball beyond the light, or in it, hides what nobody has bounded.
            if distance - reach <= radius || at_ball + ball.radius + 2.0 * reach > distance - radius {
                return (0.0, 1.0);
            }
            let radii = [distance + reach, distance - reach].map(|distance| libm::asin(radius / distance));
            (radii, libm::asin(reach / distance))
        }
        _ => ([light_cap.radius; 2], 0.0),
    };
    let turn = libm::asin(reach / at_ball) + light_turn;
    let apart = angle(to_ball, light_cap.towards);
    let rounding = 64.0 * f64::EPSILON;
    let least = common_area(light_radii[0], ball_radii[0], apart + turn) / cap_area(light_radii[1]);
    let most = common_area(light_radii[1], ball_radii[1], (apart - turn).max(0.0)) / cap_area(light_radii[0]);
    // Hidden altogether, or not at all, from everywhere: no share at all of the other.
    if ball_radii[0] >= apart + turn + light_radii[1] + rounding {
        return (1.0, 1.0);
    }
    if light_radii[1] + ball_radii[1] + rounding <= apart - turn {
        return (0.0, 0.0);
    }
    ((least - rounding).clamp(0.0, 1.0), (most + rounding).clamp(0.0, 1.0))
}
