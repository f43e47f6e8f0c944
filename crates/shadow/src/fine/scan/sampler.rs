//! The samples of flat receivers under one light.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use umbriel_geometry::{Aabb, Facets, LightSource, Sign, simd::dispatch};

use super::{
    batch::{Batch, Storage},
    faces::{Face, Faces, Piece, Rect, Source, depths},
    layout::{FaceLattice, Layout},
    lit_bits::LitBits,
    order::{Order, sorted},
    pack::Pack,
    patch::{EDGE, Extent, Frame, Patch},
    spans::Errors,
    tree::{Tree, WIDTH},
    view::{Image, View},
};
use crate::{
    bodies::Bodies,
    exact::{Own, face_blocks},
    fine::flat::flat_probe,
    progress::{Cancelled, Progress},
    receivers::flat_corners,
};

/// Rows and columns of patches that a large face takes at a time.
const BLOCK: u32 = 4 * EDGE;

/// Blocks of a face up to which one thread takes all.
const FEW_BLOCKS: u32 = 4;

/// Whether a face, which turns like this as seen from the light where that is known, has samples that may be lit.
pub(crate) type IsLit<'a> = dyn Fn(usize, Option<Sign>) -> bool + Sync + 'a;

/// An asked receiver with its samples, or an object that only blocks.
pub(crate) struct Sampled<'a> {
    pub(crate) object: u32,
    pub(crate) facets: &'a Facets,
    /// `None` for an object that only blocks.
    pub(crate) receives: Option<(&'a Layout, &'a IsLit<'a>)>,
    pub(crate) bounds: Aabb,
}

/// One view of a light and everything in it.
pub(super) struct Sampler<'a> {
    bodies: &'a Bodies<'a>,
    light: &'a LightSource,
    objects: &'a [Sampled<'a>],
    lit: &'a [LitBits],
    view: View,
    pub(super) errors: Errors,
    /// How far from a patch's box the images of its blockers are, quanta.
    pub(super) wide: i32,
    pub(super) faces: Faces<'a>,
    order: Order,
    pub(super) packs: Vec<Pack>,
    pub(super) tree: Tree,
    /// Faces whose shadow nothing bounds: asked about every sample.
    pub(super) unbounded: Vec<Face>,
}

/// Storage that the groups of one thread share.
#[derive(Default)]
struct Room {
    storage: Storage,
    patches: Vec<Patch>,
    large: Vec<Face>,
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
    let sources: Vec<Source> =
        objects.iter().map(|&Sampled { object, facets, .. }| Source { object, facets }).collect();
    for view in View::all(light, &bounds, slack) {
        let (faces, order) = sorted(&sources, &view);
        let packs: Vec<Pack> =
            order.pieces.par_chunks(WIDTH).with_min_len(64).map(|pieces| Pack::new(&faces, pieces)).collect();
        let tree = Tree::new(&packs);
        let errors = Errors { image: view.error as f32, depth: view.depth_error };
        let wide = (2.0 * view.error).ceil() as i32 + 2;
        let unbounded = faces.clipped.iter().filter(|(_, images)| images.is_empty()).map(|(&face, _)| face).collect();
        let sampler =
            Sampler { bodies, light, objects, lit: &lit, view, errors, wide, faces, order, packs, tree, unbounded };
        sampler.run(progress)?;
    }
    Ok(lit)
}

impl Sampler<'_> {
    fn run(&self, progress: &dyn Progress) -> Result<(), Cancelled> {
        let (done, total) = (AtomicU64::new(0), self.order.ends.len() as u64);
        (0..self.order.ends.len()).into_par_iter().for_each_init(Room::default, |room, group| {
            if !progress.is_cancelled() {
                self.run_group(self.order.group(group), room, progress);
                progress.advance("samples", done.fetch_add(1, Ordering::Relaxed) + 1, total);
            }
        });
        if progress.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Faces that are neighbours in the image.
    fn run_group(&self, group: &[Piece], room: &mut Room, progress: &dyn Progress) {
        room.patches.clear();
        room.large.clear();
        let firsts = group.iter().filter(|&&piece| piece != Piece::NONE && piece.place() == 0);
        firsts.for_each(|piece| self.add(piece.face(), room));
        self.run_batch(room);
        for face in std::mem::take(&mut room.large) {
            self.run_large(face, room, progress);
        }
    }

    /// Adds the patch of a face, or the face where it is large, if it has samples that may be lit.
    #[inline]
    fn add(&self, face: Face, room: &mut Room) {
        let Some((layout, is_lit)) = self.objects[face.source as usize].receives else { return };
        let lattice = layout.face(face.number as usize);
        let [rows, columns] = lattice.lattice.counts();
        if rows == 0 {
            return;
        }
        let is_whole = self.faces.clipped(face).is_none();
        let (corners, count) = self.faces.corners(face);
        let turn = if is_whole { self.faces.turn(&corners, &self.view) } else { None };
        if !is_lit(face.number as usize, turn) {
            return;
        }
        let extent = Extent::of_images(&corners[..count]);
        if !is_whole || rows > EDGE || columns > EDGE || !self.view.holds(&extent.rect) {
            return room.large.push(face);
        }
        let frame = Frame::of_images(counted_from(&corners, lattice), &lattice.lattice, &self.view);
        room.patches.push(Patch::whole(face, &frame, &extent, lattice));
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
            room.patches.clear();
            large.add(self, [block / columns * BLOCK, block % columns * BLOCK], &mut room.patches);
            self.run_batch(room);
        };
        if blocks <= FEW_BLOCKS {
            (0..blocks).for_each(|block| run(block, room));
        } else {
            (0..blocks).into_par_iter().for_each_init(Room::default, |room, block| run(block, room));
        }
    }

    fn run_batch(&self, room: &mut Room) {
        let Room { storage, patches, .. } = room;
        if patches.is_empty() {
            return;
        }
        dispatch(Batch { sampler: self, storage, patches });
        for patch in patches {
            self.write(patch);
        }
    }

    /// Keeps the answers: open samples are lit.
    #[inline]
    fn write(&self, patch: &Patch) {
        let (layout, _) = self.objects[patch.face.source as usize].receives.expect("patches are of receivers");
        let lattice = layout.face(patch.face.number as usize);
        let row_bytes = lattice.row_bytes();
        let [row, column] = patch.origin;
        let mut byte =
            layout.first_byte(patch.face.number as usize) + u64::from(row) * row_bytes + u64::from(column / 8);
        for &open in &patch.open[..patch.rows as usize] {
            self.lit[patch.face.source as usize].set(byte, open as u32);
            byte += row_bytes;
        }
    }

    /// Whether a face blocks the sample of another face at a row and column. Exact.
    pub(super) fn blocks_exactly(&self, face: Face, [row, column]: [u32; 2], occluder: Face) -> bool {
        let Sampled { object, facets, receives, .. } = &self.objects[face.source as usize];
        let (layout, _) = receives.expect("samples are of receivers");
        let FaceLattice { lattice, corner } = layout.face(face.number as usize);
        let corners = flat_corners(facets, face.number as usize, *corner);
        let probe = flat_probe(&corners, lattice.coordinate(0, row), lattice.coordinate(1, column));
        let own = Own::Face { object: *object as usize, face: face.number as usize };
        let occluder = (self.faces.sources[occluder.source as usize].object as usize, occluder.number as usize);
        face_blocks(self.bodies, occluder, &probe, own, self.light)
    }
}

/// The corners from which the lattice is counted: first, next, last.
#[inline(always)]
fn counted_from<'a>(corners: &'a [Image; 4], lattice: &FaceLattice) -> [&'a Image; 3] {
    if lattice.lattice.is_triangle() {
        let first = usize::from(lattice.corner);
        [&corners[first], &corners[(first + 1) % 3], &corners[(first + 2) % 3]]
    } else {
        [&corners[0], &corners[1], &corners[3]]
    }
}

/// A face in many patches, or one that reaches beyond the window.
struct Large<'a> {
    face: Face,
    lattice: &'a crate::fine::lattice::Lattice,
    frame: Frame,
    extent: Extent,
    /// Whether the view's window holds all of it.
    is_inside: bool,
}

impl<'a> Large<'a> {
    fn new(sampler: &'a Sampler, face: Face) -> Self {
        let Sampled { facets, receives, .. } = &sampler.objects[face.source as usize];
        let (layout, _) = receives.expect("patches are of receivers");
        let FaceLattice { lattice, corner } = layout.face(face.number as usize);
        let view = &sampler.view;
        let corners = flat_corners(facets, face.number as usize, *corner);
        let corners = [corners[0], corners[1], corners[3]].map(|corner| corner.position);
        let points = corners.map(|corner| view.homogeneous(corner));
        let scale =
            if view.is_sun() { 1.0 } else { 1.0 / points.iter().fold(f64::MIN_POSITIVE, |z, point| z.max(point[2])) };
        let homogeneous = [0, 1, 2].map(|k| {
            let depth = if view.is_sun() { view.depth_of_sun(corners[k]) } else { -view.depth_scale_of_lamp() * scale };
            let [x, y, z] = points[k].map(|x| x * scale);
            [x, y, z, depth]
        });
        let extent = match sampler.faces.clipped(face) {
            Some([]) => Extent { rect: Rect::EVERYWHERE, depths: [f32::NEG_INFINITY, f32::INFINITY] },
            Some(images) => Extent { rect: Rect::of(images), depths: depths(images) },
            None => {
                let (corners, count) = sampler.faces.corners(face);
                Extent::of_images(&corners[..count])
            }
        };
        let is_inside = sampler.faces.clipped(face).is_none() && view.holds(&extent.rect);
        Self { face, lattice, frame: Frame::of_corners(homogeneous, lattice), extent, is_inside }
    }

    /// Adds the patches of the block that begins at a row and a column.
    fn add(&self, sampler: &Sampler, [row, column]: [u32; 2], patches: &mut Vec<Patch>) {
        let counts = self.lattice.counts();
        let starts = |k: usize, first: u32| (first..counts[k].min(first + BLOCK)).step_by(EDGE as usize);
        let view = (!self.is_inside).then_some(&sampler.view);
        for row in starts(0, row) {
            for column in starts(1, column) {
                let origin = [row, column];
                patches.extend(Patch::part((self.face, origin), &self.frame, &self.extent, self.lattice, view));
            }
        }
    }
}
