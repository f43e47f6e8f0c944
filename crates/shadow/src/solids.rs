//! Star-shaped solids among the triangles of a mesh: half of their faces are enough to tell what they block.
//!
//! Consecutive triangles over a range of vertices of their own make a part. A part is *star-shaped* if the directed uses of all
//! its edges cancel and one point, the mean of some of its corners, is strictly behind all of its triangles (or strictly before all: then
//! it is turned inside out). It is then wound round no point negatively: round p as often as the ray from p away from the middle meets
//! it, since each meeting leaves it. So a ray to where it is not wound round anything leaves the part at least as often as it
//! enters: if it meets the part at all, it meets a triangle by which it leaves. The part is *convex* if, further, two triangles
//! meet at every edge, neither before the other, and one ray from the middle meets the part once: a closed surface
//! that is convex everywhere locally is convex (Tietze 1928; Nakajima 1928). NUMERICS.md, "Solids".
//!
//! Guarantee: what is listed is exactly so; what is in doubt is not listed. Cost: some 40 ns a triangle of solids, a
//! few of others.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{
    Aabb, Facets, Point, Sign,
    edge_uses::{EdgeUse, EdgeUses, cancel, edges_of},
    predicates::{float_side_filter, side},
};

/// What faces belong to that are of no solid.
const NONE: u32 = u32::MAX;

/// Triangles whose corners' mean is taken for the middle of a part.
const CORNERS: usize = 64;

/// Parts that a thread takes at a time, at least.
const PARTS: usize = 64;

/// A star-shaped solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Solid {
    /// Holds all of it, world metres.
    pub(crate) bounds: Aabb,
    /// Whether the right-hand normals of its triangles point inward.
    pub(crate) is_inward: bool,
    /// Whether it is convex.
    pub(crate) is_convex: bool,
}

/// The star-shaped solids of a body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solids {
    /// The solid of each face; empty if there are none.
    of_face: Vec<u32>,
    solids: Vec<Solid>,
}

impl Solids {
    /// Of a mesh by the numbers of its vertices: vertices that only share a position do not join triangles. Bodies that
    /// are no meshes have none.
    pub(crate) fn of(facets: &Facets) -> Self {
        let (Some(triangles), true) = (facets.triangles(), facets.slack() == 0.0) else { return Self::default() };
        let positions = facets.positions();
        let parts = parts(triangles);
        let found: Vec<Option<Solid>> = parts
            .par_iter()
            .with_min_len(PARTS)
            .map_init(Uses::default, |uses, part| {
                Part { triangles: &triangles[part.faces.clone()], vertices: part.vertices, positions }.solid(uses)
            })
            .collect();
        let mut solids = Self::default();
        for (part, solid) in parts.iter().zip(found) {
            let Some(solid) = solid else { continue };
            solids.of_face.resize(triangles.len(), NONE);
            solids.of_face[part.faces.clone()].fill(solids.solids.len() as u32);
            solids.solids.push(solid);
        }
        solids
    }

    /// The solid that a face belongs to, and its number.
    #[inline]
    pub(crate) fn get(&self, face: usize) -> Option<(u32, &Solid)> {
        let number = *self.of_face.get(face)?;
        (number != NONE).then(|| (number, &self.solids[number as usize]))
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.solids.len()
    }
}

/// Consecutive triangles, and their lowest and highest vertex.
struct Run {
    faces: Range<usize>,
    vertices: [u32; 2],
}

/// Runs of triangles, as short as may be, whose ranges of vertices are apart.
fn parts(triangles: &[[u32; 3]]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (face, &[a, b, c]) in triangles.iter().enumerate() {
        let mut run = Run { faces: face..face + 1, vertices: [a.min(b).min(c), a.max(b).max(c)] };
        while let Some(last) = runs.last().filter(|last| run.vertices[0] <= last.vertices[1]) {
            run.faces.start = last.faces.start;
            run.vertices = [run.vertices[0].min(last.vertices[0]), run.vertices[1].max(last.vertices[1])];
            runs.pop();
        }
        runs.push(run);
    }
    runs
}

/// Some consecutive triangles.
struct Part<'a> {
    triangles: &'a [[u32; 3]],
    /// The lowest and the highest vertex.
    vertices: [u32; 2],
    positions: &'a [DVec3],
}

impl Part<'_> {
    fn solid(&self, uses: &mut Uses) -> Option<Solid> {
        let middle = self.middle();
        let is_inward = self.is_inward(middle)?;
        uses.collect(self);
        if !uses.are_closed {
            return None;
        }
        let is_convex = self.is_met_once(middle, is_inward) && uses.are_convex(self, is_inward);
        let corners = self.triangles.iter().flatten();
        let bounds = corners.fold(Aabb::EMPTY, |bounds, &corner| bounds.with(self.positions[corner as usize]));
        Some(Solid { bounds, is_inward, is_convex })
    }

    /// The mean of some corners: inside where the part is convex.
    fn middle(&self) -> DVec3 {
        let some = self.triangles.iter().step_by(self.triangles.len().div_ceil(CORNERS)).flatten();
        let (sum, count) =
            some.fold((DVec3::ZERO, 0.0), |(sum, count), &corner| (sum + self.positions[corner as usize], count + 1.0));
        sum / count
    }

    #[inline]
    fn corners(&self, [a, b, c]: [u32; 3]) -> [DVec3; 3] {
        [self.positions[a as usize], self.positions[b as usize], self.positions[c as usize]]
    }

    /// Whether the middle is strictly before all triangles; `None` unless it is strictly on one side of all.
    fn is_inward(&self, middle: DVec3) -> Option<bool> {
        let mut common = None;
        for &triangle in self.triangles {
            let [a, b, c] = self.corners(triangle);
            let side = float_side_filter(a, b, c, middle).sign().filter(|&side| side != Sign::Zero)?;
            if common.is_some_and(|common| common != side) {
                return None;
            }
            common = Some(side);
        }
        common.map(|side| side == Sign::Positive)
    }

    /// Whether the ray from the middle through the first triangle meets no other.
    fn is_met_once(&self, middle: DVec3, is_inward: bool) -> bool {
        let Some(&first) = self.triangles.first() else { return false };
        let [a, b, c] = self.corners(first);
        let target = (a + b + c) / 3.0;
        let beside = if is_inward { Sign::Positive } else { Sign::Negative };
        let is_beside = |from: DVec3, to: DVec3| float_side_filter(from, to, middle, target).sign() == Some(beside);
        let mut meetings = 0;
        for &triangle in self.triangles {
            let [a, b, c] = self.corners(triangle);
            meetings += u32::from(!(is_beside(a, b) || is_beside(b, c) || is_beside(c, a)));
        }
        meetings == 1
    }
}

/// The edges of a part; vertices are counted from the part's lowest.
#[derive(Default)]
struct Uses {
    /// The triangles: copies of one body have the same edges.
    triangles: Vec<[u32; 3]>,
    edges: EdgeUses,
    /// Whether the directed uses of every edge cancel.
    are_closed: bool,
}

impl Uses {
    /// Of a part; those of the last part where they are the same.
    fn collect(&mut self, part: &Part) {
        let [low, high] = part.vertices;
        let own = part.triangles.iter().map(|triangle| triangle.map(|corner| corner - low));
        if own.clone().eq(self.triangles.iter().copied()) {
            return;
        }
        self.triangles.clear();
        self.triangles.extend(own);
        let edges = (0..).zip(&self.triangles).flat_map(|(number, &triangle)| edges_of(triangle, number));
        self.edges.gather((high - low) as usize + 1, edges);
        self.are_closed = self.edges.edges().all(|(_, uses)| cancel(uses));
    }

    /// Whether two triangles meet at every edge, neither before the other.
    fn are_convex(&self, part: &Part, is_inward: bool) -> bool {
        let before = if is_inward { Sign::Negative } else { Sign::Positive };
        let at = |corner: u32| part.positions[(part.vertices[0] + corner) as usize];
        self.edges.edges().all(|(low, uses)| {
            let [up, down] = match uses {
                [a, b] if a.is_upward() => [a, b],
                [a, b] => [b, a],
                _ => return false,
            };
            let apex = |usage: &EdgeUse| {
                let corners = self.triangles[usage.face() as usize];
                corners.into_iter().find(|&corner| corner != low && corner != up.high).unwrap_or(low)
            };
            let [a, b, c, d] = [low, up.high, apex(up), apex(down)].map(at);
            let is_flat = (0..3).any(|k| a[k] == b[k] && a[k] == c[k] && a[k] == d[k]);
            is_flat || float_side(a, b, c, d) != before
        })
    }
}

#[inline]
fn float_side(a: DVec3, b: DVec3, c: DVec3, x: DVec3) -> Sign {
    let [p, q, r, y] = [a, b, c, x].map(Point::exact);
    float_side_filter(a, b, c, x).sign().unwrap_or_else(|| side(&p, &q, &r, &y))
}

#[cfg(test)]
mod tests {
    use umbriel_geometry::{Mesh, Placement};

    use super::*;

    const BOX: [[u32; 3]; 12] = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];

    /// The corners of a box, x fastest.
    fn corners(low: [f64; 3], size: f64) -> Vec<[f64; 3]> {
        (0..8).map(|k| [0, 1, 2].map(|axis| low[axis] + size * f64::from(k >> axis & 1))).collect()
    }

    fn found(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Vec<Option<(u32, bool, bool)>> {
        let facets = Facets::of_mesh(Mesh::new(positions, triangles).expect("a mesh"), &Placement::IDENTITY);
        let solids = Solids::of(&facets);
        let flags = |(number, solid): (u32, &Solid)| (number, solid.is_inward, solid.is_convex);
        (0..facets.len()).map(|face| solids.get(face).map(flags)).collect()
    }

    fn turned(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
    }

    /// Two pyramids over a star with `corners` corners that goes round `turns` times.
    fn bipyramid(count: u32, turns: u32, dent: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let mut positions = vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
        positions.extend((0..count).map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k * turns) / f64::from(count);
            let radius = if k % 2 == 0 { 1.0 } else { dent };
            [radius * angle.cos(), radius * angle.sin(), 0.0]
        }));
        let sides = (0..count).map(|k| [2 + k, 2 + (k + 1) % count]);
        (positions, sides.flat_map(|[a, b]| [[a, b, 0], [b, a, 1]]).collect())
    }

    #[test]
    fn boxes_are_convex_whichever_way_they_are_turned() {
        assert_eq!(found(corners([0.0; 3], 2.0), BOX.to_vec()), [Some((0, false, true)); 12]);
        assert_eq!(found(corners([0.1, 7.3, -0.2], 0.7), turned(&BOX)), [Some((0, true, true)); 12]);
    }

    #[test]
    fn parts_of_one_mesh_are_told_apart() {
        let mut positions = corners([0.0; 3], 1.0);
        positions.extend(corners([0.5; 3], 1.0));
        let mut triangles = BOX.to_vec();
        triangles.extend(BOX.map(|triangle| triangle.map(|corner| corner + 8)));
        let both = found(positions.clone(), triangles.clone());
        assert!(both[..12].iter().all(|solid| *solid == Some((0, false, true))));
        assert!(both[12..].iter().all(|solid| *solid == Some((1, false, true))));
        // The second is open, and then the first.
        assert!(found(positions.clone(), triangles[..23].to_vec())[12..].iter().all(Option::is_none));
        let other = found(positions, triangles[1..].to_vec());
        assert!(other[..11].iter().all(Option::is_none) && other[11..].iter().all(|s| *s == Some((0, false, true))));
    }

    #[test]
    fn what_is_not_convex_or_not_seen_from_the_middle() {
        let solids = |(positions, triangles)| found(positions, triangles)[0].map(|(_, _, is_convex)| is_convex);
        assert_eq!(solids(bipyramid(8, 1, 1.0)), Some(true));
        assert_eq!(solids(bipyramid(8, 1, 0.3)), Some(false), "a star with dents");
        assert_eq!(solids(bipyramid(5, 2, 1.0)), Some(false), "convex at every edge, but wound twice");
        let (positions, mut triangles) = bipyramid(8, 1, 1.0);
        triangles[3] = [triangles[3][1], triangles[3][0], triangles[3][2]];
        assert_eq!(solids((positions, triangles)), None, "a triangle is turned");
        let mut dented = corners([0.0; 3], 1.0);
        dented[7] = [0.1, 0.1, 0.1];
        assert_eq!(solids((dented, BOX.to_vec())), None, "no one point sees it all");
    }
}
