//! From faces that lie together to patches, and from patches to answers.

use umbriel_geometry::{
    decisions::{Level, count},
    simd::{Kernel, Simd},
};

use super::{
    batch::{Batch, Storage},
    faces::{Face, Piece},
    layout::FaceLattice,
    patch::{EDGE, Extent, Frame, Patch},
    sampler::Sampler,
    tree::WIDTH,
    view::Image,
};

/// Storage that the groups of one thread share.
#[derive(Default)]
pub(super) struct Room {
    pub(super) storage: Storage,
    pub(super) patches: Vec<Patch>,
    /// Faces in many patches, and faces that reach beyond the window.
    pub(super) large: Vec<Face>,
}

/// Decides the samples of the small faces of a group, and lists the large ones.
pub(super) struct Group<'a, 'b> {
    pub(super) sampler: &'a Sampler<'b>,
    pub(super) group: usize,
    pub(super) room: &'a mut Room,
}

impl Kernel for Group<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { sampler, group, room } = self;
        room.patches.clear();
        room.large.clear();
        let pieces = sampler.order.group(group);
        for (place, &piece) in (pieces.start..).zip(&sampler.order.pieces[pieces]) {
            if piece != Piece::NONE && piece.place() == 0 {
                add(sampler, piece.face(), place, room);
            }
        }
        Block { sampler, room }.run(simd);
    }
}

/// Decides patches.
pub(super) struct Block<'a, 'b> {
    pub(super) sampler: &'a Sampler<'b>,
    pub(super) room: &'a mut Room,
}

impl Kernel for Block<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Room { storage, patches, .. } = self.room;
        if patches.is_empty() {
            return;
        }
        let samples = patches.iter().map(|patch| u64::from(patch.count_open())).sum();
        count(Level::Single, samples);
        Batch { sampler: self.sampler, storage, patches }.run(simd);
        patches.iter().for_each(|patch| write(self.sampler, patch));
    }
}

/// Adds the patch of a face at a place of the order, or the face where it is large, if it has samples that may be lit.
#[inline(always)]
fn add(sampler: &Sampler, face: Face, place: usize, room: &mut Room) {
    let Some((layout, is_lit)) = sampler.objects[face.source as usize].receives else { return };
    let lattice = layout.face(face.number as usize);
    let [rows, columns] = lattice.lattice.counts();
    if rows == 0 {
        return;
    }
    let is_whole = sampler.faces.clipped(face).is_none();
    let (corners, corner_count) = if is_whole && lattice.lattice.is_triangle() {
        let [a, b, c] = sampler.packs[place / WIDTH].corners(place % WIDTH);
        ([a, b, c, c], 3)
    } else {
        sampler.faces.corners(face)
    };
    let turn = if is_whole { sampler.view.turn(&corners) } else { None };
    if !is_lit(face.number as usize, turn) {
        return;
    }
    let extent = Extent::of_images(&corners[..corner_count]);
    if !is_whole || rows > EDGE || columns > EDGE || !sampler.view.holds(&extent.rect) {
        return room.large.push(face);
    }
    let frame = Frame::of_images(counted_from(&corners, &lattice), &lattice.lattice, &sampler.view);
    let mut patch = Patch::whole(face, &frame, &extent, &lattice);
    if let Some(solid) = sampler.faces.sources[face.source as usize].convex_behind(face.number as usize, turn) {
        patch.solid = solid as i32;
    }
    room.patches.push(patch);
}

/// The corners from which the lattice is counted: first, next, last.
#[inline(always)]
fn counted_from<'a>(corners: &'a [Image; 4], lattice: &FaceLattice) -> [&'a Image; 3] {
    match (lattice.lattice.is_triangle(), lattice.corner) {
        (false, _) => [&corners[0], &corners[1], &corners[3]],
        (true, 0) => [&corners[0], &corners[1], &corners[2]],
        (true, 1) => [&corners[1], &corners[2], &corners[0]],
        (true, _) => [&corners[2], &corners[0], &corners[1]],
    }
}

/// Keeps the answers: open samples are lit.
#[inline(always)]
fn write(sampler: &Sampler, patch: &Patch) {
    let source = patch.face.source as usize;
    let lattice = sampler.lattice(patch.face);
    let row_bytes = lattice.row_bytes();
    let mut byte = lattice.first_byte + u64::from(patch.origin[0]) * row_bytes + u64::from(patch.origin[1] / 8);
    for &open in &patch.open[..patch.rows as usize] {
        if open != 0 {
            sampler.lit[source].set(byte, open as u32);
        }
        byte += row_bytes;
    }
}
