//! Builds the tree: boxes, a binary tree over them, eight children a node, packs.

mod binary;
mod widen;

use umbriel_geometry::Mesh;

pub(super) use binary::MAX_DEPTH;

use super::{
    bounds::Bounds,
    frame::{Frame, above},
    layout::{Node, Pack, WIDTH},
};

/// What a build makes.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    pub(super) frame: Frame,
    pub(super) nodes: Vec<Node>,
    pub(super) packs: Vec<Pack>,
    /// How far a pack's coordinate is from the true one, at most.
    pub(super) corner_error: f32,
}

pub(super) fn build(mesh: &Mesh) -> Parts {
    let frame = Frame::around(&mesh.bounds());
    let corners = |triangle: &[u32; 3]| triangle.map(|index| mesh.positions()[index as usize]);
    let bounds = |(index, triangle)| frame.bounds_of(corners(triangle)).tagged(index as u32);
    let mut items: Vec<Bounds> = mesh.triangles().iter().enumerate().map(bounds).collect();
    if items.is_empty() {
        return Parts { frame, nodes: vec![Node::EMPTY], packs: Vec::new(), corner_error: 0.0 };
    }
    let wide = widen::widen(&binary::build(&mut items));
    let mut error = 0.0f64;
    let pack = |&(first, count): &(u32, u32)| {
        let range = &items[first as usize..(first + count) as usize];
        let mut pack = Pack { corners: [[[0.0; WIDTH]; 3]; 3], triangles: [0; WIDTH] };
        for lane in 0..WIDTH {
            let triangle = range.get(lane).unwrap_or(&range[0]).tag();
            pack.triangles[lane] = triangle;
            for (corner, position) in corners(&mesh.triangles()[triangle as usize]).into_iter().enumerate() {
                let exact = frame.localise(position);
                for axis in 0..3 {
                    let rounded = exact[axis] as f32;
                    error = error.max((exact[axis] - f64::from(rounded)).abs());
                    pack.corners[corner][axis][lane] = rounded;
                }
            }
        }
        pack
    };
    let packs = wide.packs.iter().map(pack).collect();
    Parts { frame, nodes: wide.nodes, packs, corner_error: above(error + frame.error(1.0)) }
}
