//! Which objects are in which cells.
//!
//! An object is left out of a cell only if one plane of the cell has all of it strictly on the outer side, of a mesh each triangle with
//! a plane of its own. It is left out of the outdoors only if its box, an ulp and the greatest slack wider, lies in the union of the other closed cells: the
//! box is divided at the planes of the cells' boxes until each part lies in one cell, which ends for cells that are boxes themselves, and
//! is given up (it belongs to the outdoors) where the cells are slanted.
//!
//! Cost: a look at the cells whose boxes meet an object's. Where these pairs are more than [`ASKED`] and some for each object and cell, an object is in every cell that its box meets, and
//! outdoors: more in a cell than need be changes no answer, only what is looked at for it. What is divided into more than [`PARTS`] parts and some for each cell is given up, too.

use glam::DVec3;
use umbriel_geometry::{Aabb, Brep, ExactPoint, Point};

use super::{CellGraph, Region, SceneCell, is_beyond, is_inside, may_hold};
use crate::{Object, Shape};

/// The convex cells sorted along the axis in which they spread farthest.
#[derive(Clone, Debug, Default)]
pub(super) struct Index {
    axis: usize,
    /// Least coordinate along the axis, and the cell.
    starts: Vec<(f64, u32)>,
    /// Boxes in the order of `starts`.
    boxes: Vec<Aabb>,
    /// The largest extent of a cell along the axis.
    widest: f64,
    /// The largest slack of a cell, metres.
    slack: f64,
}

impl Index {
    pub(super) fn new(cells: &[SceneCell]) -> Self {
        let boxed = |(number, cell): (usize, &SceneCell)| match &cell.region {
            Region::Convex(body) => Some((number as u32, body.bounds().widened(DVec3::splat(cell.slack)))),
            Region::Outdoors => None,
        };
        let mut boxes: Vec<(u32, Aabb)> = cells.iter().enumerate().filter_map(boxed).collect();
        let all = boxes.iter().fold(Aabb::EMPTY, |all, (_, own)| all.union(*own));
        let axis = all.size().max_position();
        boxes.sort_by(|a, b| a.1.min[axis].total_cmp(&b.1.min[axis]).then(a.0.cmp(&b.0)));
        let widest = boxes.iter().fold(0.0_f64, |widest, (_, own)| widest.max(own.max[axis] - own.min[axis]));
        Self {
            axis,
            starts: boxes.iter().map(|&(cell, own)| (own.min[axis], cell)).collect(),
            boxes: boxes.into_iter().map(|(_, own)| own).collect(),
            widest: widest.next_up(),
            slack: cells.iter().fold(0.0, |slack, cell| cell.slack.max(slack)),
        }
    }

    /// All convex cells whose boxes meet a box.
    pub(super) fn for_each_near<'a>(
        &self,
        cells: &'a [SceneCell],
        near: &Aabb,
        mut visit: impl FnMut(usize, &'a Brep),
    ) {
        let from = (near.min[self.axis] - self.widest).next_down();
        let first = self.starts.partition_point(|&(start, _)| start < from);
        let last = self.starts.partition_point(|&(start, _)| start <= near.max[self.axis]);
        for place in first..last.max(first) {
            let cell = self.starts[place].1 as usize;
            if let (true, Region::Convex(body)) = (self.boxes[place].meets(near), &cells[cell].region) {
                visit(cell, body);
            }
        }
    }
}

/// Pairs of an object and a cell whose boxes meet that are asked exactly, some microseconds each: in any scene, and for each object and cell.
const ASKED: usize = 1 << 18;
const ASKED_EACH: usize = 16;

/// Parts that a box is divided into, in any scene and for each cell that it meets.
const PARTS: usize = 1 << 10;
const PARTS_EACH: usize = 16;

/// Whether more boxes of objects and cells meet than are asked exactly.
fn are_many(graph: &CellGraph) -> bool {
    let mut left = ASKED + ASKED_EACH * (graph.bounds.len() + graph.cells.len());
    graph.bounds.iter().filter(|bounds| !bounds.is_empty()).any(|bounds| {
        let mut near = 0;
        graph.index.for_each_near(&graph.cells, bounds, |_, _| near += 1);
        let is_over = near > left;
        left = left.saturating_sub(near);
        is_over
    })
}

/// The objects of each cell, and how many are in none.
pub(super) fn members(graph: &CellGraph, objects: &[Object]) -> (Vec<Vec<u32>>, usize) {
    let are_many = are_many(graph);
    let mut members = vec![Vec::new(); graph.cells.len()];
    let mut loose = 0;
    for (number, object) in objects.iter().enumerate() {
        let bounds = graph.bounds[number];
        if bounds.is_empty() {
            continue;
        }
        let mut surface = None;
        let mut is_loose = true;
        graph.index.for_each_near(&graph.cells, &bounds, |cell, body| {
            if are_many || meets((&graph.cells[cell], body), object, &bounds, &mut surface) {
                members[cell].push(number as u32);
                is_loose = false;
            }
        });
        if let Some(outdoors) = graph.outdoors
            && (are_many || !is_enclosed(graph, &bounds))
        {
            members[outdoors].push(number as u32);
            is_loose = false;
        }
        loose += usize::from(is_loose);
    }
    (members, loose)
}

/// The pieces of a surface, each the hull of some of its points.
struct Pieces {
    points: Vec<ExactPoint>,
    floats: Vec<DVec3>,
    /// Three corners each; none if all points are one piece.
    triangles: Vec<[u32; 3]>,
}

impl Pieces {
    fn of(object: &Object) -> Self {
        let nothing = Self { points: Vec::new(), floats: Vec::new(), triangles: Vec::new() };
        let local = object.defining_points();
        match &object.shape {
            Shape::Mesh(mesh) => Self {
                floats: local.iter().map(|&point| object.placement.round(point)).collect(),
                triangles: mesh.triangles().to_vec(),
                ..nothing
            },
            Shape::Convex(_) => {
                Self { floats: local.iter().map(|&point| object.placement.round(point)).collect(), ..nothing }
            }
            _ => Self { points: local.iter().map(|&point| object.placement.exact(point)).collect(), ..nothing },
        }
    }

    /// Whether planes of a cell keep all pieces outside.
    fn are_outside(&self, (cell, body): (&SceneCell, &Brep)) -> bool {
        let points = || {
            let floats = self.floats.iter().map(|&position| Point::exact(position));
            floats.chain(self.points.iter().map(ExactPoint::bounded))
        };
        if self.triangles.is_empty() {
            return (0..body.face_count()).any(|face| points().all(|point| is_beyond(cell, body, face, &point)));
        }
        // For each vertex the planes that it is outside of, as bits; planes beyond 64 are not asked.
        let asked = body.face_count().min(64);
        let outside = |point: Point| {
            (0..asked).fold(0_u64, |bits, face| bits | u64::from(is_beyond(cell, body, face, &point)) << face)
        };
        let outside: Vec<u64> = points().map(outside).collect();
        self.triangles.iter().all(|triangle| triangle.iter().fold(u64::MAX, |all, &at| all & outside[at as usize]) != 0)
    }
}

/// Whether an object may have a point in a closed cell.
fn meets((cell, body): (&SceneCell, &Brep), object: &Object, bounds: &Aabb, pieces: &mut Option<Pieces>) -> bool {
    let corners = corners(bounds);
    let misses = |face: usize| corners.iter().all(|&corner| is_beyond(cell, body, face, &Point::exact(corner)));
    if (0..body.face_count()).any(misses) {
        return false;
    }
    if corners.iter().all(|&corner| may_hold(cell, body, corner)) {
        return true;
    }
    !pieces.get_or_insert_with(|| Pieces::of(object)).are_outside((cell, body))
}

/// Whether a box lies in the inside of the union of the convex cells; no where that is not seen by dividing it.
pub(super) fn is_enclosed(graph: &CellGraph, bounds: &Aabb) -> bool {
    let rounded = bounds.widened(DVec3::splat(graph.index.slack));
    let wider = Aabb { min: rounded.min.map(f64::next_down), max: rounded.max.map(f64::next_up) };
    let mut near = Vec::new();
    graph.index.for_each_near(&graph.cells, &wider, |_, body| near.push((body, body.bounds())));
    // Each division takes one plane of one box away from the inside of each part.
    let mut left = PARTS + PARTS_EACH * near.len();
    let mut open = vec![(wider, near)];
    while let Some((part, near)) = open.pop() {
        let Some(rest) = left.checked_sub(1) else { return false };
        left = rest;
        let near: Vec<_> = near.into_iter().filter(|(_, bounds)| bounds.meets(&part)).collect();
        if near.iter().any(|(body, _)| corners(&part).iter().all(|&corner| is_inside(body, corner))) {
            continue;
        }
        let Some((axis, at)) = division(&part, &near) else { return false };
        let (mut low, mut high) = (part, part);
        low.max[axis] = at;
        high.min[axis] = at;
        open.push((high, near.clone()));
        open.push((low, near));
    }
    true
}

/// Of the planes of boxes that divide a part, the one nearest to its middle.
fn division(part: &Aabb, near: &[(&Brep, Aabb)]) -> Option<(usize, f64)> {
    let planes = near
        .iter()
        .flat_map(|(_, bounds)| (0..3).flat_map(move |axis| [bounds.min[axis], bounds.max[axis]].map(|at| (axis, at))));
    let dividing = planes.filter(|&(axis, at)| part.min[axis] < at && at < part.max[axis]);
    let (center, size) = (part.center(), part.size());
    let off = |&(axis, at): &(usize, f64)| (at - center[axis]).abs() / size[axis];
    dividing.min_by(|a, b| off(a).total_cmp(&off(b)))
}

fn corners(bounds: &Aabb) -> [DVec3; 8] {
    let ends = [bounds.min, bounds.max];
    std::array::from_fn(|i| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2 & 1].z))
}
