//! How often a surface winds round a point: signed crossings of the ray from the point along +x.
//!
//! The ray is moved by (0, ε, ε²) for an infinitesimal ε, which keeps it off every edge and vertex without a special
//! case (Edelsbrunner & Mücke, "Simulation of Simplicity", ACM Transactions on Graphics 9(1), 1990); the winding number of
//! a point off the surface does not change when it is moved so little. A triangle is then crossed exactly when the moved
//! point is strictly inside its projection along x and the triangle lies ahead: four signs, each exact. Triangles that
//! are edge-on to the ray are never crossed. Degree 3. O(1) a triangle.

use glam::DVec3;

use crate::{
    decisions::decide,
    dyadic::Dyadic,
    point::Point,
    predicates::side,
    ring::{Ring, Sign},
};

/// 1 where the ray leaves through the triangle's front (its corners then run counter-clockwise as seen from ahead), −1
/// where it enters, 0 where it does not cross. `point` must not lie on the triangle.
pub(super) fn crossing(corners: &[Point; 3], point: DVec3) -> i8 {
    if misses(corners, point) {
        return 0;
    }
    let [a, b, c] = corners;
    let point = Point::exact(point);
    let turn = turn_of(a, b, c);
    if turn == Sign::Zero || [(a, b), (b, c), (c, a)].iter().any(|(from, to)| moved_turn(from, to, &point) != turn) {
        return 0;
    }
    // Ahead: the point is behind a triangle that turns its front ahead, or before one that turns its back.
    if side(a, b, c, &point) != turn.flipped() {
        return 0;
    }
    if turn == Sign::Positive { 1 } else { -1 }
}

/// Whether coordinates alone tell that the ray does not come near.
fn misses(corners: &[Point; 3], point: DVec3) -> bool {
    let below = |axis: usize| corners.iter().all(|c| c.position[axis] + c.slack[axis] * 2.0 < point[axis]);
    let above = |axis: usize| corners.iter().all(|c| c.position[axis] - c.slack[axis] * 2.0 > point[axis]);
    below(0) || below(1) || above(1) || below(2) || above(2)
}

/// Which way (a, b, c) turns in the yz plane: exact.
fn turn_of(a: &Point, b: &Point, c: &Point) -> Sign {
    let ([a_y, a_z], [b_y, b_z], [c_y, c_z]) = (projected(a), projected(b), projected(c));
    let filtered = (b_y - a_y) * (c_z - a_z) - (b_z - a_z) * (c_y - a_y);
    decide(filtered.sign(), || {
        let ([a_y, a_z], [b_y, b_z], [c_y, c_z]) = (exact(a), exact(b), exact(c));
        let first = (b_y - a_y.clone()) * (c_z - a_z.clone());
        (first - (b_z - a_z) * (c_y - a_y)).sign()
    })
}

/// [`turn_of`] for a third point moved by (ε, ε²) in y and z; zero only where the first two are one in the projection.
fn moved_turn(a: &Point, b: &Point, point: &Point) -> Sign {
    let turn = turn_of(a, b, point);
    if turn != Sign::Zero {
        return turn;
    }
    // The turn grows by (z_a − z_b)·ε + (y_b − y_a)·ε².
    match difference(a, b, 2) {
        Sign::Zero => difference(b, a, 1),
        sign => sign,
    }
}

/// The sign of a − b on an axis: exact.
fn difference(a: &Point, b: &Point, axis: usize) -> Sign {
    let filtered = a.coordinates()[axis] - b.coordinates()[axis];
    decide(filtered.sign(), || {
        let [a, b] = [a, b].map(|point| point.to_exact::<Dyadic>().xyz[axis].clone());
        (a - b).sign()
    })
}

fn projected(point: &Point) -> [crate::Approx; 2] {
    let [_, y, z] = point.coordinates();
    [y, z]
}

/// The exact coordinates; the corners of facets have weight 1.
fn exact(point: &Point) -> [Dyadic; 2] {
    let [_, y, z] = point.to_exact::<Dyadic>().xyz;
    [y, z]
}
