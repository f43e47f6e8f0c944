//! The outline of a convex body as a light sees it, and the shadow behind it.
//!
//! A face is seen when the light lies strictly in front of it. The faces that a light outside sees are a disc, whatever
//! faces are seen edge-on, so its border is one simple cycle. With n the planes of the seen faces and e those through
//! the light and an edge of the outline, a point's way to the light is blocked exactly where it lies strictly behind
//! all n and on the inner side of, or on, all e: the way enters the body through the last n that it crosses.

use super::Brep;
use crate::{light::LightSource, point::Point, predicates::light_side, ring::Sign};

/// What a light outside a convex body sees of it.
#[derive(Clone, Debug)]
pub struct Silhouette<'a> {
    body: &'a Brep,
    light: LightSource,
    outline: Vec<u32>,
    seen: Vec<u32>,
}

impl Brep {
    /// The side of a face on which the light lies: positive in front. Exact.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn light_side(&self, face: usize, light: &LightSource) -> Sign {
        let [a, b, c] = self.plane(face);
        light_side(&a, &b, &c, light)
    }

    /// What the light sees of the body; `None` for a light inside it or on its surface, which sees no face. Exact;
    /// O(edges).
    pub fn silhouette(&self, light: &LightSource) -> Option<Silhouette<'_>> {
        let is_seen: Vec<bool> =
            (0..self.face_count()).map(|face| self.light_side(face, light) == Sign::Positive).collect();
        let seen: Vec<u32> = (0..).zip(&is_seen).filter(|&(_, &seen)| seen).map(|(face, _)| face).collect();
        let face_across = |half_edge: u32| self.half_edges[self.twin(half_edge) as usize].face;
        let on_border = |half_edge: u32| !is_seen[face_across(half_edge) as usize];
        let in_seen = |half_edge: &u32| is_seen[self.half_edges[*half_edge as usize].face as usize];
        let first = (0..self.half_edges.len() as u32).filter(in_seen).find(|&half_edge| on_border(half_edge))?;
        let mut outline = vec![first];
        loop {
            // Around the end of the last one, over seen faces, to the next one on the border.
            let mut next = self.next(outline[outline.len() - 1]);
            while !on_border(next) {
                next = self.next(self.twin(next));
            }
            if next == first {
                return Some(Silhouette { body: self, light: *light, outline, seen });
            }
            outline.push(next);
        }
    }

    fn twin(&self, half_edge: u32) -> u32 {
        self.half_edges[half_edge as usize].twin
    }
}

impl Silhouette<'_> {
    /// The outline: half-edges of seen faces whose twins belong to faces that are not seen, edge-on ones among them. One
    /// simple cycle, counter-clockwise from the light, each running to the start of the next; the first has the least
    /// number.
    pub fn outline(&self) -> &[u32] {
        &self.outline
    }

    /// The faces that the light lies strictly in front of, in ascending order.
    pub fn seen_faces(&self) -> &[u32] {
        &self.seen
    }

    /// Whether the body blocks the open segment from `x` to the light. Exact, the body a closed set: a way along the
    /// outline is blocked; contact at `x` alone does not block. O(seen faces + outline).
    pub fn blocks(&self, x: &Point) -> bool {
        let is_behind = |&face: &u32| {
            let [a, b, c] = self.body.plane(face as usize);
            crate::predicates::side(&a, &b, &c, x) == Sign::Negative
        };
        let is_inside = |&half_edge: &u32| {
            let [from, to] = [self.body.half_edges[half_edge as usize].start, self.body.end(half_edge)];
            light_side(&self.body.vertex(from), &self.body.vertex(to), x, &self.light) != Sign::Negative
        };
        self.outline.iter().all(is_inside) && self.seen.iter().all(is_behind)
    }

    /// Whether the body blocks every point of the convex hull of `corners`, so that all of it lies in the body's shadow.
    /// Exact: the shadow of a convex body is convex, so the corners decide. True where there are no corners.
    pub fn covers<'p>(&self, corners: impl IntoIterator<Item = Point<'p>>) -> bool {
        corners.into_iter().all(|corner| self.blocks(&corner))
    }
}
