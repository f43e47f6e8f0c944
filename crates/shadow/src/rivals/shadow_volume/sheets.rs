//! The polygons round what a light does not see: caps where light arrives, walls from silhouettes to infinity, and caps there.

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::LightSource;

use crate::rivals::Polygons;

/// A convex polygon of homogeneous corners (weight 0: at infinity in that direction), counter-clockwise seen from outside the volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sheet {
    /// The last repeats for a triangle.
    pub(super) corners: [DVec3; 4],
    pub(super) weights: [f64; 4],
    /// How many volumes end here.
    pub(super) multiplicity: i32,
    pub(super) owner: SheetOwner,
}

/// Which points a sheet is special for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SheetOwner {
    /// None.
    Nobody,
    /// Points of this face lie before it, on the light's side.
    Face { object: u32, face: u32 },
    /// Points of this curved body are not shadowed by it.
    Body { object: u32 },
}

/// A directed edge of a cap.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// The lower and the higher rank of its ends.
    key: u64,
    /// 1 from the lower rank to the higher, −1 the other way.
    way: i32,
    object: u32,
    /// Corners of the mesh, from the lower rank to the higher.
    ends: [u32; 2],
}

/// All sheets for a light. O(n log n).
pub(super) fn of(polygons: &Polygons, light: &LightSource) -> Vec<Sheet> {
    let caps: Vec<(u32, bool)> =
        (0..polygons.len()).into_par_iter().filter_map(|triangle| cap(polygons, light, triangle)).collect();
    let mut edges: Vec<Edge> = caps.iter().flat_map(|&cap| edges(polygons, cap)).collect();
    edges.par_sort_unstable_by_key(|edge| edge.key);
    let mut sheets: Vec<Sheet> =
        edges.chunk_by(|a, b| a.key == b.key).filter_map(|uses| wall(polygons, light, uses)).collect();
    for &(triangle, is_reversed) in &caps {
        let owner = polygons.owner(triangle as usize);
        let mut corners = polygons.corners(triangle as usize);
        if is_reversed {
            corners.swap(1, 2);
        }
        let body = SheetOwner::Body { object: owner.object };
        let near = owner.face.map_or(body, |face| SheetOwner::Face { object: owner.object, face });
        sheets.push(Sheet::triangle(corners, 1.0, near));
        if !light.is_sun() {
            let [a, b, c] = corners.map(|corner| corner - light.xyz());
            sheets.push(Sheet::triangle([a, c, b], 0.0, if owner.face.is_none() { body } else { SheetOwner::Nobody }));
        }
    }
    sheets
}

/// Whether a triangle is a cap, and whether its corners run clockwise seen from the light.
fn cap(polygons: &Polygons, light: &LightSource, triangle: usize) -> Option<(u32, bool)> {
    let [a, b, c] = polygons.corners(triangle);
    let turn = (b - a).cross(c - a).dot(light.xyz() - light.w() * a);
    let owner = polygons.owner(triangle);
    // A light among the walls of a closed surface sees their backs.
    let is_outside = light.is_sun() || !polygons.boxes()[owner.object as usize].contains(light.xyz());
    let is_back = is_outside && turn * f64::from(owner.outward) < 0.0;
    (turn != 0.0 && !is_back).then_some((triangle as u32, turn < 0.0))
}

fn edges(polygons: &Polygons, (triangle, is_reversed): (u32, bool)) -> [Edge; 3] {
    let mut corners = polygons.mesh().triangles()[triangle as usize];
    let mut firsts = polygons.welded(triangle as usize);
    if is_reversed {
        corners.swap(1, 2);
        firsts.swap(1, 2);
    }
    let object = polygons.owner(triangle as usize).object;
    std::array::from_fn(|k| {
        let (from, to) = (k, (k + 1) % 3);
        let is_up = firsts[from] < firsts[to];
        let [low, high] = if is_up { [from, to] } else { [to, from] };
        let key = u64::from(firsts[low]) << 32 | u64::from(firsts[high]);
        Edge { key, way: if is_up { 1 } else { -1 }, object, ends: [corners[low], corners[high]] }
    })
}

/// The wall of an edge whose uses do not cancel.
fn wall(polygons: &Polygons, light: &LightSource, uses: &[Edge]) -> Option<Sheet> {
    let sum: i32 = uses.iter().map(|edge| edge.way).sum();
    let Edge { object, ends, .. } = uses[0];
    let [low, high] = ends.map(|end| polygons.mesh().positions()[end as usize]);
    if sum == 0 || low == high {
        return None;
    }
    // The cap's neighbour runs along the edge the other way.
    let [from, to] = if sum > 0 { [high, low] } else { [low, high] };
    let away = |end: DVec3| light.w() * end - light.xyz();
    let owner = if polygons.is_curved(object as usize) { SheetOwner::Body { object } } else { SheetOwner::Nobody };
    let corners = [from, to, away(to), away(from)];
    Some(Sheet { corners, weights: [1.0, 1.0, 0.0, 0.0], multiplicity: sum.abs(), owner })
}

impl Sheet {
    fn triangle([a, b, c]: [DVec3; 3], weight: f64, owner: SheetOwner) -> Self {
        Self { corners: [a, b, c, c], weights: [weight; 4], multiplicity: 1, owner }
    }
}
