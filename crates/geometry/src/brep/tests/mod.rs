//! Bodies against closed forms, brute force over exact signs, and the blocking of single faces.

use std::collections::BTreeSet;

use glam::DVec3;
use proptest::prelude::*;

use super::{surface::points, *};
use crate::{predicates::side, ring::Sign};

mod half_spaces;
mod hull;
mod mesh;
mod placed;
mod silhouette;
mod validation;

/// Vertices, edges, faces.
fn counts(body: &Brep) -> (usize, usize, usize) {
    (body.vertices().len(), body.edge_count(), body.face_count())
}

fn lattice_point(reach: i32) -> impl Strategy<Value = DVec3> {
    proptest::array::uniform3(-reach..=reach).prop_map(|v| DVec3::from_array(v.map(f64::from)))
}

/// Few points of a small lattice: mostly coplanar, collinear, repeated.
fn lattice_cloud() -> impl Strategy<Value = Vec<DVec3>> {
    (1..=3, 0..14_usize).prop_flat_map(|(reach, count)| proptest::collection::vec(lattice_point(reach), count))
}

/// Faces as sets of vertex positions.
type FaceSets = BTreeSet<BTreeSet<[i64; 3]>>;

fn key(position: DVec3) -> [i64; 3] {
    position.to_array().map(|coordinate| coordinate as i64)
}

fn face_sets(body: &Brep) -> FaceSets {
    (0..body.face_count())
        .map(|face| body.face(face).map(|vertex| key(body.vertices()[vertex as usize])).collect())
        .collect()
}

/// The structure checks that every body must pass, without a hull.
fn check_structure(body: &Brep) {
    let (v, e, f) = counts(body);
    assert_eq!(v as i64 - e as i64 + f as i64, 2, "Euler");
    for (number, half_edge) in (0..).zip(body.half_edges()) {
        let twin = body.half_edges()[half_edge.twin as usize];
        assert_eq!(twin.twin, number, "twins are mutual");
        assert_eq!(body.end(half_edge.twin), half_edge.start, "twins run the other way");
        // Strictly convex at every edge: the next corner across lies strictly behind.
        let [a, b, c] = body.plane(half_edge.face as usize);
        let far = body.vertex(body.end(body.next(half_edge.twin)));
        assert_eq!(side(&a, &b, &c, &far), Sign::Negative, "half-edge {number}");
    }
}

/// Every point lies behind or in the plane of every face, and every corner of a face in its plane.
fn check_holds(body: &Brep, cloud: &[DVec3]) {
    for face in 0..body.face_count() {
        let [a, b, c] = body.plane(face);
        let side_of = |&position: &DVec3| side(&a, &b, &c, &Point::exact(position));
        assert!(cloud.iter().all(|x| side_of(x) != Sign::Positive), "a point in front of face {face}");
        assert!(body.face(face).all(|v| side_of(&body.vertices()[v as usize]) == Sign::Zero), "face {face} is planar");
    }
}

/// A double pyramid over a pentagram: convex at every edge, V − E + F = 2, wound twice.
fn pentagram_pyramids() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let rim = [(0.0, 10.0), (-9.0, 3.0), (-6.0, -8.0), (6.0, -8.0), (9.0, 3.0)];
    let mut vertices: Vec<DVec3> = rim.iter().map(|&(x, z)| DVec3::new(x, 0.0, z)).collect();
    vertices.extend([DVec3::Y * 5.0, DVec3::Y * -5.0]);
    let star = [0, 3, 1, 4, 2];
    let side = |i: usize| {
        let (from, to) = (star[i], star[(i + 1) % 5]);
        [[from, to, 5], [to, from, 6]]
    };
    (vertices, (0..5).flat_map(side).collect())
}
