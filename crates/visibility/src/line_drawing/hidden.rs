//! What hides a segment from an eye, or from a light: for each face, one interval.
//!
//! With corners c₀, c₁, … counter-clockwise for the eye L, the planes of the volume behind a face have the values
//! det(c_k − p, c_{k+1} − p, L − w·p) ≥ 0 at a point p, and its own plane det(a − c, b − c, p − c) < 0. Both are affine in p. Their signs at
//! the ends of the segment are exact; the volume is closed at the edges (a line behind an edge is hidden) and open at the face (what lies
//! in the face is not).

use umbriel_bvh::{BoxTree, Shaft};
use umbriel_geometry::{
    Aabb, Facets, LightSource, Point, Sign,
    predicates::{Target, side_value},
};

use super::{Line, projection::cut};

/// All flat faces of a scene, ready to hide.
pub(super) struct Hiders<'a> {
    pub(super) bodies: &'a [(u32, &'a Facets)],
    /// Where the faces of each body begin.
    starts: Vec<u32>,
    pub(super) tree: BoxTree,
    pub(super) boxes: Vec<Aabb>,
    eye: LightSource,
    /// The bodies of which something may be seen; the others only hide, from the eye or from lights. Sorted.
    pub(super) drawn: Vec<usize>,
}

impl<'a> Hiders<'a> {
    pub(super) fn new(bodies: &'a [(u32, &'a Facets)], eye: &LightSource, drawn: Vec<usize>) -> Self {
        let mut starts = vec![0];
        let mut boxes = Vec::new();
        for (_, facets) in bodies {
            boxes.extend((0..facets.len()).map(|face| facets.facet_bounds(face)));
            starts.push(boxes.len() as u32);
        }
        Self { bodies, starts, tree: BoxTree::build(&boxes), boxes, eye: *eye, drawn }
    }

    /// A face by its number in the tree: its place among the bodies, and its own number.
    pub(super) fn face(&self, item: u32) -> (usize, u32) {
        let body = self.starts.partition_point(|&start| start <= item) - 1;
        (body, item - self.starts[body])
    }

    /// The intervals of a line that are hidden from the eye, sorted and disjoint.
    pub(super) fn hidden(&self, line: &Line) -> Vec<[f64; 2]> {
        self.hidden_from(line, &self.eye)
    }

    /// The intervals of a line that are hidden from a light.
    pub(super) fn hidden_from(&self, line: &Line, light: &LightSource) -> Vec<[f64; 2]> {
        let bounds = line.ends.iter().map(Point::bounds).fold(Aabb::EMPTY, Aabb::union);
        let shaft = Shaft::new(&bounds, light);
        let mut intervals = Vec::new();
        let _ = self.tree.for_each_in_shaft(&shaft, |item| {
            let (body, face) = self.face(item);
            let (object, facets) = self.bodies[body];
            if !line.on.contains(&Some((object, face))) {
                intervals.extend(hidden_by(facets, face as usize, line, light));
            }
            std::ops::ControlFlow::Continue(())
        });
        joined(intervals)
    }
}

/// The interval that one face hides.
fn hidden_by(facets: &Facets, face: usize, line: &Line, light: &LightSource) -> Option<[f64; 2]> {
    let turn = match facets.turn(face, light) {
        Sign::Positive => 1.0,
        Sign::Negative => -1.0,
        Sign::Zero => return None,
    };
    let numbers = facets.facet(face).corners();
    let corner = |k: usize| facets.point(numbers[k % numbers.len()]);
    let [a, b, c] = [corner(0), corner(1), corner(numbers.len() - 1)];
    let mut range = [0.0, 1.0];
    let behind = line.ends.each_ref().map(|end| -turn * side_value(&a, &b, &c, Target::Point(end)).value);
    if behind.iter().all(|&value| value <= 0.0) {
        return None;
    }
    cut(&mut range, behind[0], behind[1]);
    for k in 0..numbers.len() {
        let (from, to) = (corner(k), corner(k + 1));
        let side = |end: &Point| turn * side_value(&from, &to, end, Target::Light(light)).value;
        let [at_start, at_end] = line.ends.each_ref().map(side);
        cut(&mut range, at_start, at_end);
        if range[0] >= range[1] {
            return None;
        }
    }
    Some(range)
}

/// The union of intervals, sorted.
fn joined(mut intervals: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for [start, end] in intervals {
        match joined.last_mut() {
            Some(last) if start <= last[1] => last[1] = last[1].max(end),
            _ => joined.push([start, end]),
        }
    }
    joined
}
