//! The hull of points by brute force: every triple is tried as a face.

use super::number::{Binary, Vector, cross, dot, is_zero, minus, vector};

/// The hull's faces as fans of triangles, wound outward (inward if `mirrored`); empty for points in one plane. Vertices are
/// in the order of the points, a face starts at its first vertex, faces are in the order of their vertices.
pub(crate) fn hull(points: &[[f64; 3]], mirrored: bool) -> Vec<[[f64; 3]; 3]> {
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    for point in points {
        if !vertices.contains(point) {
            vertices.push(*point);
        }
    }
    let exact: Vec<Vector> = vertices.iter().map(|&vertex| vector(vertex)).collect();
    let mut faces: Vec<Vec<usize>> = Vec::new();
    let count = vertices.len();
    for (i, j, k) in (0..count).flat_map(|i| (0..count).flat_map(move |j| (j + 1..count).map(move |k| (i, j, k)))) {
        if i < j
            && let Some(face) = face_through(&exact, [i, j, k])
            && !faces.contains(&face)
        {
            faces.push(face);
        }
    }
    for face in &mut faces {
        if mirrored {
            face.reverse();
        }
        let first = (0..face.len()).min_by_key(|&k| face[k]).expect("a face has corners");
        face.rotate_left(first);
    }
    // Extreme points only, in their order, so that loops compare as the body's do.
    faces.sort();
    let corner = |number: usize| vertices[number];
    let fan = |face: &Vec<usize>| {
        let pairs: Vec<[[f64; 3]; 3]> =
            face[1..].windows(2).map(|pair| [corner(face[0]), corner(pair[0]), corner(pair[1])]).collect();
        pairs
    };
    faces.iter().flat_map(fan).collect()
}

/// The loop of the face in the plane of three points, if all points are on one side.
fn face_through(points: &[Vector], [i, j, k]: [usize; 3]) -> Option<Vec<usize>> {
    let mut normal = cross(&minus(&points[j], &points[i]), &minus(&points[k], &points[i]));
    if is_zero(&normal) {
        return None;
    }
    let sides: Vec<i8> = points.iter().map(|point| dot(&normal, &minus(point, &points[i])).sign()).collect();
    if sides.iter().all(|&side| side == 0) || (sides.contains(&1) && sides.contains(&-1)) {
        return None;
    }
    if sides.contains(&1) {
        normal = normal.each_ref().map(|coordinate| -coordinate);
    }
    let members: Vec<usize> = (0..points.len()).filter(|&number| sides[number] == 0).collect();
    Some(loop_of(points, &members, &normal))
}

/// Gift wrapping in a plane, counter-clockwise about the normal, from the point with the least coordinates, which is extreme.
fn loop_of(points: &[Vector], members: &[usize], normal: &Vector) -> Vec<usize> {
    let turn = |a: usize, b: usize, c: usize| -> Binary {
        dot(normal, &cross(&minus(&points[b], &points[a]), &minus(&points[c], &points[a])))
    };
    let is_farther = |a: usize, b: usize, c: usize| {
        let (near, far) = (minus(&points[b], &points[a]), minus(&points[c], &points[a]));
        (&dot(&far, &far) - &dot(&near, &near)).sign() > 0
    };
    let is_before = |a: usize, b: usize| {
        let order = (0..3).map(|k| (&points[a][k] - &points[b][k]).sign()).find(|&sign| sign != 0);
        order == Some(-1)
    };
    let first = members.iter().copied().reduce(|a, b| if is_before(b, a) { b } else { a }).expect("members");
    let mut border = vec![first];
    loop {
        let from = border[border.len() - 1];
        let others = members.iter().copied().filter(|&to| to != from);
        // The one with all others on its left; of several in one direction the farthest.
        let next = others.reduce(|best, to| {
            let side = turn(from, best, to).sign();
            if side < 0 || (side == 0 && is_farther(from, best, to)) { to } else { best }
        });
        match next {
            Some(next) if next != first => border.push(next),
            _ => return border,
        }
    }
}
