//! Builds the tree: boxes, a binary tree over them, eight children a node, packs.

mod binary;
mod curve;
mod widen;

use glam::DVec3;
use umbriel_geometry::Mesh;

pub(super) use binary::MAX_DEPTH;

use super::{
    bounds::Bounds,
    frame::{Frame, above},
    layout::{Node, Pack, WIDTH},
};

/// How much time a build takes for rays to be fast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuildQuality {
    /// Along Morton's curve: for a few rays a triangle, or for triangles that move.
    Fast,
    /// By the surface-area heuristic: up to twice and a half the time, and rays are up to 1.6 times as fast where triangles
    /// differ in size.
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
    let frame = Frame::around(&mesh.bounds());
    let bounds = |index: usize| frame.bounds_of(corners(mesh, index)).tagged(index as u32);
    let mut items: Vec<Bounds> = (0..mesh.triangles().len()).map(bounds).collect();
    if items.is_empty() {
        return Parts { frame, nodes: vec![Node::EMPTY], packs: Vec::new(), corner_error: 0.0 };
    }
    let binary = match quality {
        BuildQuality::Fast => curve::build(&mut items),
        BuildQuality::Good => binary::build(&mut items),
    };
    let wide = widen::widen(&binary);
    let mut packer = Packer { mesh, frame, error: 0.0 };
    let pack = |&(first, count): &(u32, u32)| packer.pack(&items[first as usize..(first + count) as usize]);
    let packs = wide.packs.iter().map(pack).collect();
    Parts { frame, nodes: wide.nodes, packs, corner_error: above(packer.error + frame.error(1.0)) }
}

#[inline(always)]
fn corners(mesh: &Mesh, triangle: usize) -> [DVec3; 3] {
    let [a, b, c] = mesh.triangles()[triangle];
    let positions = mesh.positions();
    [positions[a as usize], positions[b as usize], positions[c as usize]]
}

/// Fills packs.
struct Packer<'a> {
    mesh: &'a Mesh,
    frame: Frame,
    /// The greatest rounding of a coordinate so far.
    error: f64,
}

impl Packer<'_> {
    fn pack(&mut self, items: &[Bounds]) -> Pack {
        let mut pack = Pack { corners: [[[0.0; WIDTH]; 3]; 3], triangles: [0; WIDTH] };
        for lane in 0..WIDTH {
            let triangle = items.get(lane).unwrap_or(&items[0]).tag();
            pack.triangles[lane] = triangle;
            for (corner, position) in corners(self.mesh, triangle as usize).into_iter().enumerate() {
                let exact = self.frame.localise(position);
                let rounded = exact.as_vec3();
                self.error = self.error.max((exact - rounded.as_dvec3()).abs().max_element());
                for axis in 0..3 {
                    pack.corners[corner][axis][lane] = rounded[axis];
                }
            }
        }
        pack
    }
}
