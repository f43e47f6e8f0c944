//! The samples of flat receivers under one light.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{Aabb, Facet, Facets, LightSource, Sign, predicates::side, simd::dispatch};

use super::{
    beside_lamp::decide_beside_lamp,
    faces::{Face, Faces, Rect, Source},
    group::{Group, LargeBlock, Room},
    images::Images,
    large::{BLOCK, Large},
    layout::{FaceLattice, Layout},
    lit_bits::LitBits,
    order::{Order, sorted},
    pack::{Pack, tree_of},
    patch::Patch,
    spans::Errors,
    tree::{Tree, WIDTH},
    view::View,
    volumes::{Volume, Volumes},
};
use crate::{
    bodies::Bodies,
    exact::{Own, face_blocks},
    fine::flat::flat_probe,
    light_space::power_of_two,
    progress::{Cancelled, Progress},
    receivers::flat_corners,
    solids::Solids,
};

/// Objects are prepared, and groups taken, in so many runs at least: the last threads to end would have others wait.
pub(crate) const RUNS: usize = 128;

/// Blocks of a face up to which one thread takes all.
const FEW_BLOCKS: u32 = 4;

/// Whether a face, which turns like this as seen from the light where that is known, has samples that may be lit.
pub(crate) type IsLit<'a> = dyn Fn(usize, Option<Sign>) -> bool + Sync + 'a;

/// An asked receiver with its samples, or an object that only blocks.
pub(crate) struct Sampled<'a> {
    pub(crate) object: u32,
    pub(crate) facets: &'a Facets,
    /// The facets are those of a box, outward, and a curved body in it is in the way.
    pub(crate) is_box: bool,
    pub(crate) solids: &'a Solids,
    /// `None` for an object that only blocks.
    pub(crate) receives: Option<(&'a Layout, &'a IsLit<'a>)>,
    pub(crate) bounds: Aabb,
}

/// One view of a light and everything in it.
pub(super) struct Sampler<'a> {
    bodies: &'a Bodies<'a>,
    light: &'a LightSource,
    pub(super) objects: &'a [Sampled<'a>],
    pub(super) lit: &'a [LitBits],
    pub(super) view: View,
    pub(super) errors: Errors,
    /// How far from a patch's box the images of its blockers are, quanta.
    pub(super) wide: i32,
    pub(super) faces: Faces<'a>,
    pub(super) order: Order,
    pub(super) packs: Vec<Pack>,
    pub(super) tree: Tree,
    pub(super) volumes: Volumes,
    /// The largest coordinate of anything, metres.
    pub(super) size: f64,
    /// A power of two that makes numbers of about one of lengths of that size: metres may be too large or too small for f32.
    pub(super) scale: f64,
    /// What corners may be off by, metres.
    pub(super) slack: f64,
    /// Faces whose shadow nothing bounds: asked about every sample.
    pub(super) unbounded: Vec<Face>,
}

/// Decides all samples; one set of answers an object, in their order. Exact.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
pub(crate) fn sample(
    bodies: &Bodies,
    light: &LightSource,
    objects: &[Sampled],
    progress: &dyn Progress,
) -> Result<Vec<LitBits>, Cancelled> {
    let bytes = |object: &Sampled| object.receives.map_or(0, |(layout, _)| layout.bytes());
    let lit: Vec<LitBits> = objects.iter().map(|object| LitBits::new(bytes(object))).collect();
    let bounds = objects.iter().fold(Aabb::EMPTY, |bounds, object| bounds.union(object.bounds));
    if bounds.is_empty() {
        return Ok(lit);
    }
    let slack = objects.iter().map(|object| object.facets.slack()).fold(0.0, f64::max);
    let size = bounds.magnitude();
    let sources = Source::all(objects, light);
    for view in View::all(light, &bounds, slack) {
        let images = Images::new(&sources, &view);
        let (volumes, others) = Volumes::new(&sources, &images, light, &view);
        let (faces, order) = sorted(&sources, &others, images, &view);
        let packs: Vec<Pack> =
            order.pieces.par_chunks(WIDTH).with_min_len(64).map(|pieces| Pack::new(&faces, pieces)).collect();
        let tree = tree_of(&packs);
        let errors = Errors { image: view.error as f32, depth: view.depth_error };
        let wide = (2.0 * view.error).ceil() as i32 + 2;
        let unbounded = faces.clipped.iter().filter(|(_, images)| images.is_empty()).map(|(&face, _)| face);
        let unbounded = unbounded.chain(boxes_round_lamp(objects, light)).collect();
        let sampler = Sampler {
            bodies,
            light,
            objects,
            lit: &lit,
            view,
            errors,
            wide,
            faces,
            order,
            packs,
            tree,
            volumes,
            size,
            scale: 1.0 / power_of_two(size),
            slack,
            unbounded,
        };
        sampler.run(progress)?;
    }
    decide_beside_lamp(bodies, light, objects, &lit);
    Ok(lit)
}

/// Boxes that rays to the lamp need not leave.
fn boxes_round_lamp(objects: &[Sampled], light: &LightSource) -> impl Iterator<Item = Face> {
    let is_round = |object: &Sampled| object.is_box && !light.is_sun() && object.facets.bounds().contains(light.xyz());
    (0..).zip(objects).filter(move |(_, object)| is_round(object)).map(|(source, _)| Face { source, number: 0 })
}

impl Sampler<'_> {
    fn run(&self, progress: &dyn Progress) -> Result<(), Cancelled> {
        let groups = self.order.ends.len() + self.volumes.groups.len();
        let (done, total) = (AtomicU64::new(0), groups as u64);
        let most = groups.div_ceil(RUNS);
        (0..groups).into_par_iter().with_max_len(most).for_each_init(Room::default, |room, group| {
            if !progress.is_cancelled() {
                self.run_group(group, room, progress);
                progress.advance("samples", done.fetch_add(1, Ordering::Relaxed) + 1, total);
            }
        });
        if progress.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Faces that are neighbours in the image.
    fn run_group(&self, group: usize, room: &mut Room, progress: &dyn Progress) {
        dispatch(Group { sampler: self, group, room });
        for face in std::mem::take(&mut room.large) {
            self.run_large(face, room, progress);
        }
    }

    /// A face in many patches, or one that reaches beyond the window.
    fn run_large(&self, face: Face, room: &mut Room, progress: &dyn Progress) {
        let large = Large::new(self, face);
        let [rows, columns] = large.lattice.counts().map(|count| count.div_ceil(BLOCK));
        let blocks = rows * columns;
        let run = |block: u32, room: &mut Room| {
            if progress.is_cancelled() {
                return;
            }
            let origin = [block / columns * BLOCK, block % columns * BLOCK];
            dispatch(LargeBlock { sampler: self, large: &large, origin, room });
        };
        if blocks <= FEW_BLOCKS {
            (0..blocks).for_each(|block| run(block, room));
        } else {
            (0..blocks).into_par_iter().for_each_init(Room::default, |room, block| run(block, room));
        }
    }

    /// The corners from which the lattice of a face is counted: first, next, last.
    #[inline(always)]
    pub(super) fn positions(&self, face: Face, first: u8) -> [DVec3; 3] {
        let facets = self.objects[face.source as usize].facets;
        let [a, b, d] = match (facets.facet(face.number as usize), first) {
            (Facet::Parallelogram([a, b, _, d]), _) => [a, b, d],
            (Facet::Triangle([a, b, c]), 0) => [a, b, c],
            (Facet::Triangle([a, b, c]), 1) => [b, c, a],
            (Facet::Triangle([a, b, c]), _) => [c, a, b],
        };
        let positions = facets.positions();
        [positions[a as usize], positions[b as usize], positions[d as usize]]
    }

    /// The lattice of a receiver's face.
    #[inline(always)]
    pub(super) fn lattice(&self, face: Face) -> FaceLattice {
        let (layout, _) = self.objects[face.source as usize].receives.expect("patches are of receivers");
        layout.face(face.number as usize)
    }

    /// Whether a convex solid blocks a sample of a patch's face at a row and column. Exact.
    pub(super) fn volume_blocks_exactly(&self, patch: &Patch, place: [u32; 2], volume: &Volume) -> bool {
        let rect = patch.rect.widened(self.wide);
        volume.faces.clone().any(|number| {
            let occluder = Face { source: volume.source, number: number as u32 };
            let (corners, count) = self.faces.corners(occluder);
            let is_over = !Rect::of(&corners[..count]).intersection(&rect).is_empty();
            is_over && self.blocks_exactly(patch.face, place, occluder)
        })
    }

    /// Whether a face may block samples of another one: not if it is nowhere before that one's plane as seen from the light, nor if that one is nowhere
    /// behind its own. Exact.
    pub(super) fn may_block(&self, face: Face, occluder: Face) -> bool {
        if self.objects[occluder.source as usize].is_box {
            // What is in a box may block without its face.
            return true;
        }
        let own = (self.objects[face.source as usize].facets, face.number as usize);
        let other = (self.faces.sources[occluder.source as usize].facets, occluder.number as usize);
        let lies = |(facets, number): (&Facets, usize), plane: (&Facets, usize), aside: Sign| {
            let [a, b, _, c] = flat_corners(plane.0, plane.1, 0);
            let corners = facets.facet(number);
            corners.corners().iter().all(|&corner| side(&a, &b, &c, &facets.point(corner)) != aside)
        };
        let [toward, beyond] = [own, other].map(|(facets, number)| facets.turn(number, self.light));
        let is_behind = toward != Sign::Zero && lies(other, own, toward);
        let is_before = beyond != Sign::Zero && lies(own, other, beyond.flipped());
        !is_behind && !is_before
    }

    /// Whether a face blocks the sample of another face at a row and column. Exact.
    pub(super) fn blocks_exactly(&self, face: Face, [row, column]: [u32; 2], occluder: Face) -> bool {
        let Sampled { object, facets, .. } = &self.objects[face.source as usize];
        let FaceLattice { lattice, corner, .. } = self.lattice(face);
        let corners = flat_corners(facets, face.number as usize, corner);
        let probe = flat_probe(&corners, lattice.coordinate(0, row), lattice.coordinate(1, column));
        let own = Own::Face { object: *object as usize, face: face.number as usize };
        let occluder = (self.faces.sources[occluder.source as usize].object as usize, occluder.number as usize);
        face_blocks(self.bodies, occluder, &probe, own, self.light)
    }
}
