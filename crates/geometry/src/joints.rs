//! Which points of triangles lie at one position, and the surfaces that the triangles form by them.
//!
//! Found when first asked for. Instances of a mesh share what is found of the mesh itself: placing rounds, so it may bring vertices together that are apart,
//! but never takes equal ones apart; where the classes of equal vertices are those of the mesh, all else that is made of them is, too.

use std::{iter, sync::OnceLock};

use glam::DVec3;

use crate::{
    edge_uses::{EdgeUses, edges_of, weld},
    topology::Topology,
};

/// Stands for no triangle.
pub(crate) const NONE: u32 = u32::MAX;

/// Triangles that have the corners of earlier ones.
#[derive(Clone, Debug, Default)]
struct Repeats {
    /// For each triangle whether it is one; empty where none is.
    are: Vec<bool>,
    count: usize,
    /// For each triangle whether it has those corners in the order of an earlier one; empty where none is a repeat.
    are_copies: Vec<bool>,
    /// For each triangle the next one that is such a copy of it, or [`NONE`]; empty where none is a repeat.
    next_copies: Vec<u32>,
}

/// Equal points, and what follows from them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Joints {
    /// For each point the first one at its position; nothing where no two points share one.
    firsts: Option<Vec<u32>>,
    topology: OnceLock<Topology>,
    repeats: OnceLock<Repeats>,
    across: OnceLock<Vec<[u32; 3]>>,
}

impl Joints {
    /// One look at all points.
    pub(crate) fn of(positions: &[DVec3]) -> Self {
        Self { firsts: weld(positions), ..Self::default() }
    }

    /// Whether the same points are equal, of as many.
    pub(crate) fn are_those_of(&self, other: &Self) -> bool {
        self.firsts == other.firsts
    }

    /// For each point the first one at its position; `None` where no two share one.
    pub(crate) fn firsts(&self) -> Option<&[u32]> {
        self.firsts.as_deref()
    }

    /// The first point at the position of this one.
    pub(crate) fn first_at(&self, point: u32) -> u32 {
        self.firsts.as_ref().map_or(point, |firsts| firsts[point as usize])
    }

    /// The surfaces that `triangles` form; the same ones each time.
    pub(crate) fn topology(&self, triangles: &[[u32; 3]]) -> &Topology {
        self.topology
            .get_or_init(|| Topology::of(triangles.iter().map(|corners| corners.map(|corner| self.first_at(corner)))))
    }

    /// For each side of each triangle the one beyond it, if these two alone use the edge, in opposite directions, else [`NONE`]; side k runs from corner k to
    /// the next one. Of the same `triangles` each time.
    pub(crate) fn across(&self, triangles: &[[u32; 3]]) -> &[[u32; 3]] {
        self.across.get_or_init(|| across(triangles, |point| self.first_at(point)))
    }

    /// Whether a triangle has the corners of an earlier one, in whichever order; of the same `triangles` each time.
    pub(crate) fn is_repeat(&self, triangles: &[[u32; 3]], triangle: usize) -> bool {
        self.repeats(triangles).are.get(triangle) == Some(&true)
    }

    /// Whether a triangle has the corners of an earlier one in the same order, from the same one on.
    pub(crate) fn is_copy(&self, triangles: &[[u32; 3]], triangle: usize) -> bool {
        self.repeats(triangles).are_copies.get(triangle) == Some(&true)
    }

    /// The later triangles that are copies of this one, ascending.
    pub(crate) fn copies(&self, triangles: &[[u32; 3]], triangle: usize) -> impl Iterator<Item = usize> {
        let next = &self.repeats(triangles).next_copies;
        let after = |&copy: &usize| next.get(copy).filter(|&&copy| copy != NONE).map(|&copy| copy as usize);
        iter::successors(after(&triangle), after)
    }

    /// How many of the same `triangles` are repeats.
    pub(crate) fn repeat_count(&self, triangles: &[[u32; 3]]) -> usize {
        self.repeats(triangles).count
    }

    fn repeats(&self, triangles: &[[u32; 3]]) -> &Repeats {
        self.repeats.get_or_init(|| Repeats::of(triangles, |point| self.first_at(point)))
    }
}

/// [`Joints::across`], points taken for the `first_at` their positions. O(triangles + points) but for points where very many edges meet.
fn across(triangles: &[[u32; 3]], first_at: impl Fn(u32) -> u32 + Copy) -> Vec<[u32; 3]> {
    let points = triangles.iter().flatten().max().map_or(0, |&highest| highest as usize + 1);
    let edges = (0..).zip(triangles).flat_map(|(face, corners)| edges_of(corners.map(first_at), face));
    let mut across = vec![[NONE; 3]; triangles.len()];
    for (low, uses) in EdgeUses::of(points, edges).edges() {
        if let [a, b] = uses
            && a.is_upward() != b.is_upward()
        {
            for [own, other] in [[a, b], [b, a]] {
                let (face, from) = (own.face() as usize, if own.is_upward() { low } else { own.high });
                // Of a triangle with two corners at one point both sides are this edge: nobody asks it for either.
                let side = triangles[face].iter().position(|&corner| first_at(corner) == from);
                across[face][side.expect("a corner of its own")] = other.face();
            }
        }
    }
    across
}

impl Repeats {
    /// Points are taken for the `first_at` their positions. A counting sort by the lowest corners, and small sorts within: O(triangles + points) but for points
    /// where very many triangles meet.
    fn of(triangles: &[[u32; 3]], first_at: impl Fn(u32) -> u32) -> Self {
        let sorted = |corners: &[u32; 3]| {
            let mut corners = corners.map(&first_at);
            corners.sort_unstable();
            corners
        };
        let points = triangles.iter().flatten().max().map_or(0, |&highest| highest as usize + 1);
        let mut stops = vec![0_u32; points + 1];
        triangles.iter().for_each(|corners| stops[sorted(corners)[0] as usize + 1] += 1);
        for point in 0..points {
            stops[point + 1] += stops[point];
        }
        let mut others = vec![[0; 3]; triangles.len()];
        for (number, corners) in (0..).zip(triangles) {
            let [lowest, middle, highest] = sorted(corners);
            // Each start moves to its stop.
            let place = &mut stops[lowest as usize];
            others[*place as usize] = [middle, highest, number];
            *place += 1;
        }
        let (mut repeats, mut start) = (Self::default(), 0);
        for &stop in &stops[..points] {
            let others = &mut others[start..stop as usize];
            others.sort_unstable();
            let classes = others.chunk_by(|first, second| first[..2] == second[..2]);
            classes.filter(|class| class.len() > 1).for_each(|class| repeats.add(class, triangles, &first_at));
            start = stop as usize;
        }
        repeats
    }

    /// Adds triangles, the last numbers of a `class`, that have the same corners.
    fn add(&mut self, class: &[[u32; 3]], triangles: &[[u32; 3]], first_at: impl Fn(u32) -> u32) {
        self.are.resize(triangles.len(), false);
        self.are_copies.resize(triangles.len(), false);
        self.next_copies.resize(triangles.len(), NONE);
        self.count += class.len() - 1;
        class[1..].iter().for_each(|&[.., repeat]| self.are[repeat as usize] = true);
        // Three corners have six orders: the last triangle of each.
        let mut last: Vec<([u32; 3], u32)> = Vec::with_capacity(6);
        for &[.., triangle] in class {
            let corners = triangles[triangle as usize].map(&first_at);
            if let Some((_, last)) = last.iter_mut().find(|(of, _)| *of == corners) {
                self.are_copies[triangle as usize] = true;
                self.next_copies[*last as usize] = triangle;
                *last = triangle;
            } else {
                last.push((corners, triangle));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_across_a_side_is_the_only_other_user_of_it() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::X, DVec3::ONE];
        // Points 1 and 4 are one; three triangles meet at 0-1.
        let triangles = [[0, 1, 2], [2, 4, 5], [0, 2, 3], [1, 0, 3], [4, 0, 5]];
        let across = Joints::of(&positions).across(&triangles).to_vec();
        assert_eq!(across[0], [NONE, 1, 2]);
        assert_eq!(across[1], [0, 4, NONE]);
        assert_eq!(across[2], [0, NONE, 3]);
        assert_eq!(across[3], [NONE, 2, NONE]);
        assert_eq!(across[4], [NONE, NONE, 1]);
        let same_way = Joints::of(&positions).across(&[[0, 1, 2], [0, 1, 3]]).to_vec();
        assert_eq!(same_way, [[NONE; 3]; 2]);
    }

    #[test]
    fn triangles_with_the_corners_of_earlier_ones_are_repeats() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::X];
        let triangles = [[0, 1, 2], [0, 1, 3], [2, 0, 4], [4, 3, 1], [3, 4, 0], [0, 0, 1], [4, 1, 0], [1, 0, 0]];
        let joints = Joints::of(&positions);
        let found: Vec<usize> = (0..triangles.len()).filter(|&k| joints.is_repeat(&triangles, k)).collect();
        // Points 1 and 4 are one: [4, 3, 1] has two corners only, [4, 1, 0] and [1, 0, 0] as well.
        assert_eq!(found, [2, 4, 7]);
        assert_eq!(joints.repeat_count(&triangles), 3);
        assert!(!Joints::of(&[]).is_repeat(&triangles[..1], 0));
    }

    #[test]
    fn copies_are_repeats_in_the_same_order() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::X];
        // Points 1 and 4 are one: the second is a copy of the first, as the last is of the fourth; the third turns it, the fourth reverses it.
        let triangles = [[0, 1, 2], [0, 4, 2], [1, 2, 0], [2, 1, 0], [0, 1, 3], [0, 1, 2], [2, 4, 0]];
        let joints = Joints::of(&positions);
        let copies: Vec<usize> = (0..triangles.len()).filter(|&k| joints.is_copy(&triangles, k)).collect();
        assert_eq!(copies, [1, 5, 6]);
        let of: Vec<Vec<usize>> = (0..triangles.len()).map(|k| joints.copies(&triangles, k).collect()).collect();
        assert_eq!(of, [vec![1, 5], vec![5], vec![], vec![6], vec![], vec![], vec![]]);
        let apart = [[0, 1, 2], [0, 1, 3]];
        let none = Joints::of(&positions);
        assert!((0..2).all(|k| !none.is_copy(&apart, k) && none.copies(&apart, k).next().is_none()));
    }
}
