//! Where faces cross: the segments that Roberts adds for bodies that run through each other. Faces of one object count, too, unless they share a corner: a file may
//! have several bodies in one object, and a body may run through itself.
//!
//! Each of two faces cuts the other's plane in an interval of their common line; the segment is what both intervals share. Which corners lie on
//! which side is exact, so faces that only touch have no segment; its ends are rounded.

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{
    Facets, Point,
    predicates::{Target, side_value},
};

use super::{Line, hidden::Hiders};

/// The crossings of all faces that share no corner.
pub(super) fn crossings(hiders: &Hiders) -> Vec<Line<'static>> {
    let of = |item: usize| {
        let mut lines = Vec::new();
        let (body, face) = hiders.face(item as u32);
        hiders.tree.for_each_meeting(&hiders.boxes[item], |other| {
            let (other_body, other_face) = hiders.face(other);
            if other as usize > item && (other_body != body || !share_corner(hiders.bodies[body].1, [face, other_face]))
            {
                let [a, b] = [(body, face), (other_body, other_face)].map(|(body, face)| (hiders.bodies[body], face));
                let on = [Some((a.0.0, a.1)), Some((b.0.0, b.1))];
                let ends = segment((a.0.1, a.1 as usize), (b.0.1, b.1 as usize));
                lines.extend(ends.map(|ends| Line { ends: ends.map(Point::exact), on }));
            }
        });
        lines
    };
    // In the order of faces, whatever the order of the tree.
    (0..hiders.boxes.len()).into_par_iter().flat_map_iter(of).collect()
}

fn share_corner(facets: &Facets, faces: [u32; 2]) -> bool {
    let [one, other] = faces.map(|face| facets.facet(face as usize).corners());
    one.iter().any(|&a| other.iter().any(|&b| facets.first_at(a) == facets.first_at(b)))
}

/// The common segment of two faces.
fn segment(a: (&Facets, usize), b: (&Facets, usize)) -> Option<[DVec3; 2]> {
    let ([p, q], [r, s]) = (chord(a, b)?, chord(b, a)?);
    // All four points are on one line; order them along it.
    let along = (q - p).normalize_or_zero();
    let place = |point: DVec3| (point - p).dot(along);
    let (r, s) = if place(r) <= place(s) { (r, s) } else { (s, r) };
    let start = if place(r) > 0.0 { r } else { p };
    let end = if place(s) < place(q) { s } else { q };
    (place(start) < place(end)).then_some([start, end])
}

/// Where a face cuts the plane of another one: two points, or `None` if it stays on one closed side.
fn chord((facets, face): (&Facets, usize), (others, other): (&Facets, usize)) -> Option<[DVec3; 2]> {
    let plane = others.facet(other).corners();
    let [a, b, c] = [0, 1, plane.len() - 1].map(|k| others.point(plane[k]));
    let numbers = facets.facet(face).corners();
    let corner = |k: usize| facets.point(numbers[k % numbers.len()]);
    let value = |k: usize| side_value(&a, &b, &c, Target::Point(&corner(k))).value;
    let values: Vec<f64> = (0..numbers.len()).map(value).collect();
    if !(values.iter().any(|&value| value > 0.0) && values.iter().any(|&value| value < 0.0)) {
        return None;
    }
    let mut points = Vec::with_capacity(2);
    for k in 0..numbers.len() {
        let (from, to) = (values[k], values[(k + 1) % numbers.len()]);
        if from == 0.0 {
            points.push(corner(k).position);
        } else if to != 0.0 && (from < 0.0) != (to < 0.0) {
            points.push(corner(k).position.lerp(corner(k + 1).position, from / (from - to)));
        }
    }
    points.try_into().ok()
}
