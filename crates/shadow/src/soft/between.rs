//! What curved bodies hide of an area light from a point, by the polyhedra that they lie between.
//!
//! The image of a polyhedron that is wholly between the point and the light lies in the hull of its corners' images, and is that hull if the polyhedron is
//! convex. So a convex body hides all of the inner hull, and no body hides more than the outer one (NUMERICS.md, "Soft shadows"). O(corners · log corners) a body for
//! its hull, which is then taken from all pieces that the bodies before it left: with n bodies that cut each other up, O(n²) and more.

use glam::{DVec2, DVec3};

use super::{
    polygon::{Pieces, Polygon},
    window::{Shape, Window},
};
use crate::{bodies::Body, query::Queries};

/// Roundings of a projected corner: the difference to the eye, the matrix's nine products, the quotient, as many again for the eye.
const IMAGE_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Bounds on the share of the light that bodies leave of what faces left; `doubtful` is one of which nothing is known.
pub(super) fn seen_between(
    queries: &Queries,
    bodies: &[u32],
    window: &Window,
    left: &Pieces,
    doubtful: Option<u32>,
) -> [f64; 2] {
    let (mut least, mut most, mut moved) = (Some(left.clone()), left.clone(), 0.0_f64);
    for &body in bodies {
        let polyhedra = if doubtful == Some(body) { None } else { queries.polyhedra(body) };
        let outer = polyhedra.and_then(|polyhedra| hull_of_images(window, polyhedra.outer.positions()));
        least = least.zip(outer).map(|(mut least, (hull, shift))| {
            least.subtract(&hull);
            moved += shift;
            least
        });
        let is_convex =
            matches!(queries.bodies.get(body as usize), Body::Analytic(placed) if placed.body().is_convex());
        let inner = polyhedra.filter(|_| is_convex).and_then(|it| hull_of_images(window, it.inner.positions()));
        if let Some((hull, shift)) = inner {
            most.subtract(&hull);
            moved += shift;
        }
    }
    // A convex outline in the square is no longer than eight: moved by as much it sweeps no more area, but for its corners.
    let swept = 16.0 * moved * density(window);
    let bound = |pieces: &Pieces, sign: f64| {
        let (share, error) = window.share_of(pieces);
        (share + sign * (error + swept)).clamp(0.0, 1.0)
    };
    [least.map_or(0.0, |least| bound(&least, -1.0)), bound(&most, 1.0)]
}

/// The greatest share of the light that a unit of its image's area is.
pub(super) fn density(window: &Window) -> f64 {
    match window.shape {
        Shape::Square => 0.25,
        Shape::Disk { tangent, cap } => tangent * tangent / cap.solid_angle(),
    }
}

/// The convex hull of the images of points, counter-clockwise, and how far off an image may be. `None` if some point is not certainly between
/// the eye and the light, or nothing is spanned.
fn hull_of_images(window: &Window, points: &[DVec3]) -> Option<(Polygon, f64)> {
    let (stretch, eye) = (window.stretch(), window.eye.abs().max_element());
    let mut shift = 0.0_f64;
    let mut images = Vec::with_capacity(points.len());
    for &point in points {
        let seen = window.homogeneous(point);
        let slack = stretch * IMAGE_ROUNDING * (point.abs().max_element() + eye);
        if seen.z <= 2.0 * slack || seen.z > window.end - slack {
            return None;
        }
        let image = seen.truncate() / seen.z;
        shift = shift.max(slack * (2.0 + image.abs().max_element()) / (seen.z - slack));
        images.push(image);
    }
    let hull = hull(images);
    (hull.len() > 2 && shift < 1.0).then_some((Polygon(hull), shift))
}

/// The convex hull, counter-clockwise (Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(point - a) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let (lower, upper) = (half(&mut points.iter().copied()), half(&mut points.iter().rev().copied()));
    [lower, upper].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hulls_hold_all_points_and_turn_left() {
        let points: Vec<DVec2> = (0..200_u32)
            .map(|k| {
                let random = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 12) / f64::from(1 << 20);
                DVec2::new(random(2 * k + 1), random(2 * k + 2))
            })
            .collect();
        let hull = hull(points.clone());
        assert!(hull.len() > 5);
        let polygon = Polygon(hull);
        for [a, b] in polygon.edges() {
            assert!(points.iter().all(|&point| (b - a).perp_dot(point - a) >= -1e-15), "{a} {b}");
        }
        assert!(super::hull(vec![DVec2::ONE; 4]).len() < 3);
    }
}
