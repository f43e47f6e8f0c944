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
//! Guarantee: what is listed is exactly so; what is in doubt is not listed. Cost: some 20 ns a triangle of solids, a
//! few of others.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{
    Aabb, Facets, Point, Sign,
    edge_uses::{EdgeUse, EdgeUses, cancel, edges_of},
    gathered::{BLOCK, Gathered},
    predicates::{float_side_filter, rows_filter, side},
    simd::{Kernel, Simd, dispatch},
};

/// What faces belong to that are of no solid.
const NONE: u32 = u32::MAX;

/// Triangles whose corners' mean is taken for the middle of a part.
const CORNERS: usize = 64;

/// Triangles of a closed part at least.
const FEWEST: usize = 4;

/// Parts that a thread takes at a time, at least.
const PARTS: usize = 64;

/// A star-shaped solid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Solid {
    /// Its triangles.
    pub(crate) faces: Range<usize>,
    /// Holds the numbers of its vertices.
    pub(crate) vertices: Range<usize>,
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

impl Solid {
    /// Whether all vertices in the range of numbers are corners of the solid, given that it is convex: then it has by two more of them than half
    /// as many as triangles (Euler).
    pub(crate) fn owns_its_vertices(&self) -> bool {
        self.vertices.len() == self.faces.len() / 2 + 2
    }
}

impl Solids {
    /// Of a mesh by the numbers of its vertices: vertices that only share a position do not join triangles. Bodies that
    /// are no meshes have none.
    /// What `uses` knows of copies seen before is used.
    pub(crate) fn of(facets: &Facets, uses: &mut Uses) -> Self {
        let Some(triangles) = triangles_of(facets) else { return Self::default() };
        let parts = parts(triangles);
        let found: Vec<Option<Solid>> = match &parts[..] {
            [part] => vec![part.solid(facets, triangles, uses)],
            parts => {
                let parts = parts.par_iter().with_min_len(PARTS);
                parts.map_init(Uses::default, |uses, part| part.solid(facets, triangles, uses)).collect()
            }
        };
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

    /// All of them, in the order of their triangles.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Solid> {
        self.solids.iter()
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.solids.len()
    }
}

/// The convex solids of a mesh that are wanted by the range of their vertices; on one thread.
pub(crate) fn convex_solids(facets: &Facets, is_wanted: impl Fn(Range<usize>) -> bool) -> Vec<Solid> {
    let Some(triangles) = triangles_of(facets) else { return Vec::new() };
    let mut uses = Uses::default();
    let parts = parts(triangles).into_iter().filter(|part| is_wanted(part.vertices()));
    parts.filter_map(|part| part.solid(facets, triangles, &mut uses)).filter(|solid| solid.is_convex).collect()
}

/// The triangles of a mesh that may have solids.
pub(crate) fn triangles_of(facets: &Facets) -> Option<&[[u32; 3]]> {
    facets.triangles().filter(|_| facets.are_floats() && !facets.has_holes())
}

/// Consecutive triangles, and their lowest and highest vertex.
struct Run {
    faces: Range<usize>,
    vertices: [u32; 2],
}

impl Run {
    fn vertices(&self) -> Range<usize> {
        self.vertices[0] as usize..self.vertices[1] as usize + 1
    }

    /// The star-shaped solid that these of all triangles are, if they are one.
    fn solid(&self, facets: &Facets, triangles: &[[u32; 3]], uses: &mut Uses) -> Option<Solid> {
        let triangles = &triangles[self.faces.clone()];
        let solid = Part { triangles, vertices: self.vertices, positions: facets.positions() }.solid(uses)?;
        Some(Solid { faces: self.faces.clone(), ..solid })
    }
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
        if self.triangles.len() < FEWEST {
            return None;
        }
        let middle = self.middle();
        let first = self.triangles[0].map(|corner| self.positions[corner as usize]);
        let target = (first[0] + first[1] + first[2]) / 3.0;
        let is_inward = float_side_filter(first[0], first[1], first[2], middle).sign()? == Sign::Positive;
        let meetings = dispatch(Star { part: self, middle, ray: target - middle, is_inward })?;
        uses.collect(self);
        if !uses.are_closed {
            return None;
        }
        let is_convex = meetings == 1 && uses.are_manifold && dispatch(Edges { part: self, uses, is_inward });
        let [low, high] = self.vertices;
        let bounds = Aabb::of(self.positions[low as usize..=high as usize].iter().copied());
        let (faces, vertices) = (0..self.triangles.len(), low as usize..high as usize + 1);
        Some(Solid { faces, vertices, bounds, is_inward, is_convex })
    }

    /// The mean of some corners: inside where the part is convex.
    fn middle(&self) -> DVec3 {
        let some = self.triangles.iter().step_by(self.triangles.len().div_ceil(CORNERS)).flatten();
        let (sum, count) =
            some.fold((DVec3::ZERO, 0.0), |(sum, count), &corner| (sum + self.positions[corner as usize], count + 1.0));
        sum / count
    }
}

/// How many triangles a ray from the middle meets; `None` unless the middle is strictly on one side of all.
struct Star<'a, 'b> {
    part: &'a Part<'b>,
    middle: DVec3,
    ray: DVec3,
    is_inward: bool,
}

impl Kernel for Star<'_, '_> {
    type Output = Option<u64>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Option<u64> {
        let Self { part, middle, ray, is_inward } = self;
        // With rows p − m, q − m, r − m the determinant is positive where the middle m is behind.
        let outward = if is_inward { -1.0 } else { 1.0 };
        let (mut meetings, mut corners) = (0, Gathered::<3>::default());
        for triangles in part.triangles.chunks(BLOCK) {
            corners.gather(triangles, part.positions, 0);
            let (mut certain, mut met) = (0_u64, 0_u64);
            for lane in 0..triangles.len() {
                let [a, b, c] =
                    [corners.at(0, lane) - middle, corners.at(1, lane) - middle, corners.at(2, lane) - middle];
                let side = rows_filter(c, a, b);
                certain += u64::from(side.value * outward > side.error);
                let [ab, bc, ca] = [rows_filter(ray, a, b), rows_filter(ray, b, c), rows_filter(ray, c, a)];
                let is_beside = (ab.value * outward < -ab.error)
                    | (bc.value * outward < -bc.error)
                    | (ca.value * outward < -ca.error);
                met += u64::from(!is_beside);
            }
            if certain < triangles.len() as u64 {
                return None;
            }
            meetings += met;
        }
        Some(meetings)
    }
}

/// Whether at every edge of a part where two triangles meet neither is before the other.
struct Edges<'a, 'b> {
    part: &'a Part<'b>,
    uses: &'a Uses,
    is_inward: bool,
}

impl Kernel for Edges<'_, '_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> bool {
        let Self { part, uses, is_inward } = self;
        let (outward, before) = if is_inward { (-1.0, Sign::Negative) } else { (1.0, Sign::Positive) };
        let (mut points, mut is_behind) = (Gathered::<4>::default(), [0_u64; BLOCK]);
        for edges in uses.pairs.chunks(BLOCK) {
            points.gather(edges, part.positions, part.vertices[0]);
            let mut behind = 0;
            for (lane, is_behind) in is_behind[..edges.len()].iter_mut().enumerate() {
                let [a, b, c, d] = [points.at(0, lane), points.at(1, lane), points.at(2, lane), points.at(3, lane)];
                let side = rows_filter(a - c, b - c, d - c);
                *is_behind = u64::from(side.value * outward < -side.error);
                behind += *is_behind;
            }
            if behind == edges.len() as u64 {
                continue;
            }
            for lane in (0..edges.len()).filter(|&lane| is_behind[lane] == 0) {
                let [a, b, c, d] = [0, 1, 2, 3].map(|k| points.at(k, lane));
                let is_flat = (0..3).any(|k| a[k] == b[k] && a[k] == c[k] && a[k] == d[k]);
                if !is_flat && float_side(a, b, c, d) == before {
                    return false;
                }
            }
        }
        true
    }
}

/// The edges of a part; vertices are counted from the part's lowest.
#[derive(Default)]
pub(crate) struct Uses {
    /// The triangles: copies of one body have the same edges.
    triangles: Vec<[u32; 3]>,
    edges: EdgeUses,
    /// Whether the directed uses of every edge cancel.
    are_closed: bool,
    /// Whether two triangles meet at every edge.
    are_manifold: bool,
    /// If so: the ends of each edge, the third corner of the triangle that runs from the lower to the higher one, and the third corner of the other.
    pairs: Vec<[u32; 4]>,
}

impl Uses {
    /// Of a part; those of the last part where they are the same.
    fn collect(&mut self, part: &Part) {
        let [low, high] = part.vertices;
        let own = part.triangles.iter().map(|&[a, b, c]| [a - low, b - low, c - low]);
        if own.clone().eq(self.triangles.iter().copied()) {
            return;
        }
        self.triangles.clear();
        self.triangles.extend(own);
        let edges = (0..).zip(&self.triangles).flat_map(|(number, &triangle)| edges_of(triangle, number));
        self.edges.gather((high - low) as usize + 1, edges);
        self.are_closed = self.edges.edges().all(|(_, uses)| cancel(uses));
        self.pairs.clear();
        self.are_manifold = self.are_closed && self.edges.edges().all(|(_, uses)| uses.len() == 2);
        if self.are_manifold {
            let triangles = &self.triangles;
            self.pairs.extend(self.edges.edges().map(|(low, uses)| pair(triangles, low, uses)));
        }
    }
}

/// An edge at which two triangles meet, one of which runs up and one down.
fn pair(triangles: &[[u32; 3]], low: u32, uses: &[EdgeUse]) -> [u32; 4] {
    let [up, down] = if uses[0].is_upward() { [uses[0], uses[1]] } else { [uses[1], uses[0]] };
    let apex = |usage: EdgeUse| {
        let corners = triangles[usage.face() as usize];
        corners.into_iter().find(|&corner| corner != low && corner != up.high).unwrap_or(low)
    };
    [low, up.high, apex(up), apex(down)]
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
    use crate::test_bodies::{BOX, bipyramid, box_corners};

    fn found(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Vec<Option<(u32, bool, bool)>> {
        let facets = Facets::of_mesh(Mesh::new(positions, triangles).expect("a mesh"), &Placement::IDENTITY);
        let solids = Solids::of(&facets, &mut Uses::default());
        let flags = |(number, solid): (u32, &Solid)| (number, solid.is_inward, solid.is_convex);
        (0..facets.len()).map(|face| solids.get(face).map(flags)).collect()
    }

    fn turned(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
    }

    #[test]
    fn boxes_are_convex_whichever_way_they_are_turned() {
        assert_eq!(found(box_corners([0.0; 3], 2.0), BOX.to_vec()), [Some((0, false, true)); 12]);
        assert_eq!(found(box_corners([0.1, 7.3, -0.2], 0.7), turned(&BOX)), [Some((0, true, true)); 12]);
    }

    #[test]
    fn parts_of_one_mesh_are_told_apart() {
        let mut positions = box_corners([0.0; 3], 1.0);
        positions.extend(box_corners([0.5; 3], 1.0));
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
        // More than are looked at together.
        assert_eq!(solids(bipyramid(100, 1, 1.0)), Some(true));
        assert_eq!(solids(bipyramid(101, 2, 1.0)), Some(false), "wound twice");
        let (mut positions, triangles) = bipyramid(100, 1, 1.0);
        positions[95] = positions[95].map(|x| 0.5 * x);
        assert_eq!(solids((positions.clone(), triangles.clone())), Some(false), "a dent far down the list");
        positions[95] = positions[50];
        assert_eq!(solids((positions, triangles)), None, "a triangle far down the list is turned");
        let (positions, mut triangles) = bipyramid(8, 1, 1.0);
        triangles[3] = [triangles[3][1], triangles[3][0], triangles[3][2]];
        assert_eq!(solids((positions, triangles)), None, "a triangle is turned");
        let mut dented = box_corners([0.0; 3], 1.0);
        dented[7] = [0.1, 0.1, 0.1];
        assert_eq!(solids((dented, BOX.to_vec())), None, "no one point sees it all");
    }
}
