//! Builds the tree: boxes, a binary tree over them, eight children a node, packs.

mod binary;
mod corners;
mod curve;
mod tasks;
mod widen;

use umbriel_geometry::{Aabb, Mesh};

pub(super) use binary::MAX_DEPTH;

use self::{
    corners::Corners,
    tasks::{CHUNK, for_each},
};
use super::{
    bounds::Bounds,
    frame::Frame,
    layout::{Node, Pack, WIDTH},
};

/// How much time a build takes for rays to be fast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuildQuality {
    /// Along Morton's curve: for a few rays a triangle, or for triangles that move.
    Fast,
    /// By the surface-area heuristic: two to four times the time, and rays are up to twice as fast where
    /// triangles differ in size.
    #[default]
    Good,
}

/// What a build makes.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    pub(super) frame: Frame,
    pub(super) nodes: Vec<Node>,
    pub(super) packs: Vec<Pack>,
    /// How far a pack's coordinate is from the true one, at most.
    pub(super) corner_error: f32,
}

pub(super) fn build(mesh: &Mesh, quality: BuildQuality) -> Parts {
    let bounds = bounds_of(mesh);
    let frame = Frame::around(&bounds);
    if bounds.is_empty() {
        return Parts { frame, nodes: vec![Node::EMPTY], packs: Vec::new(), corner_error: 0.0 };
    }
    let corners = Corners::new(mesh, &frame);
    let (nodes, packs) = match quality {
        BuildQuality::Fast => {
            let bounds = Aabb { min: frame.localise(bounds.min), max: frame.localise(bounds.max) };
            let (binary, packs) = curve::build(&corners, mesh.triangles().len(), &bounds);
            (widen::widen(&binary, &|_, leaf| leaf.first), packs)
        }
        BuildQuality::Good => good(&corners, mesh.triangles().len()),
    };
    Parts { frame, nodes, packs, corner_error: corners.error }
}

/// The box of the corners that triangles use.
fn bounds_of(mesh: &Mesh) -> Aabb {
    let mut tasks: Vec<_> = mesh.triangles().chunks(CHUNK).map(|triangles| (triangles, Aabb::EMPTY)).collect();
    for_each(&mut tasks, &|(triangles, bounds)| {
        *bounds = Aabb::of(triangles.iter().flatten().map(|&corner| mesh.positions()[corner as usize]));
    });
    tasks.iter().fold(Aabb::EMPTY, |all, (_, bounds)| all.union(*bounds))
}

fn good(corners: &Corners, count: usize) -> (Vec<Node>, Vec<Pack>) {
    let mut items = vec![Bounds::ZERO; count];
    let mut tasks: Vec<_> = items.chunks_mut(CHUNK).zip((0u32..).step_by(CHUNK)).collect();
    for_each(&mut tasks, &|(items, first)| {
        for (item, triangle) in items.iter_mut().zip(*first..) {
            *item = corners.of(triangle).bounds().tagged(triangle);
        }
    });
    let binary = binary::build(&mut items);
    // Packs lie in the order in which a walk meets them.
    let mut nodes = widen::widen(&binary, &|index, _| index);
    let mut ranges = Vec::with_capacity(binary.len() / 2);
    for node in &mut nodes {
        for lane in (0..WIDTH).filter(|lane| node.leaves >> lane & 1 == 1) {
            let leaf = &binary[node.children[lane] as usize];
            node.children[lane] = ranges.len() as u32;
            ranges.push(leaf.first as usize..(leaf.first + leaf.count) as usize);
        }
    }
    let mut packs = vec![Pack::ZERO; ranges.len()];
    let mut tasks: Vec<_> = packs.chunks_mut(CHUNK / WIDTH).zip(ranges.chunks(CHUNK / WIDTH)).collect();
    for_each(&mut tasks, &|(packs, ranges)| {
        for (pack, range) in packs.iter_mut().zip(*ranges) {
            corners.pack(items[range.clone()].iter().map(Bounds::tag), pack);
        }
    });
    (nodes, packs)
}
