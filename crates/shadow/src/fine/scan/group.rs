//! From faces that lie together to patches, and from patches to answers.

use std::ops::Range;

use umbriel_geometry::{
    Aabb, Sign,
    decisions::{Level, count},
    simd::{Kernel, Simd},
};

use super::{
    batch::{Batch, Storage},
    bunch::Bunches,
    faces::{Face, Piece},
    large::Large,
    layout::FaceLattice,
    patch::{EDGE, Extent, Frame, Patch},
    sampler::{Sampled, Sampler},
    shade::Whole,
    tree::WIDTH,
    view::Image,
    volumes::{Volume, common_solid},
};
use crate::fine::lattice::first_bits;

/// Faces fewer than this are neither asked together whether all are lit nor put into bunches.
const FEW: usize = 8;

/// Storage that the groups of one thread share.
#[derive(Default)]
pub(super) struct Room {
    pub(super) storage: Storage,
    pub(super) patches: Vec<Patch>,
    /// Small faces with samples that may be lit.
    small: Vec<Small>,
    bunches: Bunches,
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
        room.small.clear();
        room.large.clear();
        // Loops: what is in closures would be compiled for narrow vectors.
        match group.checked_sub(sampler.order.ends.len()) {
            None => {
                let pieces = sampler.order.group(group);
                for (place, &piece) in (pieces.start..).zip(&sampler.order.pieces[pieces]) {
                    if piece != Piece::NONE && piece.place() == 0 {
                        add(sampler, piece.face(), Some(place), None, room);
                    }
                }
                decide(simd, sampler, room);
            }
            Some(group) => {
                for (volume, faces) in &sampler.volumes.groups[group] {
                    add_of_volume(sampler, &sampler.volumes.all[*volume as usize], faces.clone(), room);
                    decide(simd, sampler, room);
                }
            }
        }
    }
}

/// Decides the samples of the small faces, which are then given up.
#[inline(always)]
fn decide<S: Simd>(simd: S, sampler: &Sampler, room: &mut Room) {
    if is_clear(simd, sampler, room) {
        for small in &room.small {
            small.light(sampler);
        }
    } else {
        room.patches.clear();
        let mut first = 0;
        while first < room.small.len() {
            first += bunch(simd, sampler, first, room);
        }
        Block { sampler, room }.run(simd);
    }
    room.small.clear();
}

/// Decides the samples of the next faces in bunches if they have few, or makes patches of them; answers how many faces those are.
#[inline(always)]
fn bunch<S: Simd>(simd: S, sampler: &Sampler, first: usize, room: &mut Room) -> usize {
    let Room { bunches, small, patches, .. } = room;
    let small = &small[first..];
    let in_bunches = if sampler.unbounded.is_empty() { Bunches::taken(small) } else { 0 };
    if in_bunches >= FEW
        && let Some([samples, asked]) = bunches.decide(simd, sampler, &small[..in_bunches])
    {
        count(Level::Single, samples - asked);
        return in_bunches;
    }
    let in_patches = in_bunches.max(1);
    for small in &small[..in_patches] {
        patches.push(small.patch(sampler));
    }
    in_patches
}

/// Whether the small faces are of one convex solid, turned away from it to the light, and nothing else is before them.
#[inline(always)]
fn is_clear<S: Simd>(simd: S, sampler: &Sampler, room: &mut Room) -> bool {
    let Room { storage, small, .. } = room;
    // A few patches are made as soon as they are known not to be needed.
    if small.len() < FEW || !sampler.unbounded.is_empty() {
        return false;
    }
    let Some(solid) = common_solid(small.iter().map(|small| small.solid)) else { return false };
    let (mut whole, mut bounds) = (Extent::EMPTY, Aabb::EMPTY);
    for Small { face, extent, .. } in small.iter() {
        whole = whole.union(extent);
        for position in sampler.positions(*face, 0) {
            bounds = bounds.union(Aabb { min: position, max: position });
        }
    }
    let Extent { rect, depths: [nearest, farthest] } = whole;
    let whole = Whole::new(sampler, rect.widened(sampler.wide), nearest, &bounds);
    storage.is_clear(simd, sampler, solid, &whole, farthest)
}

/// Decides patches.
struct Block<'a, 'b> {
    sampler: &'a Sampler<'b>,
    room: &'a mut Room,
}

impl Kernel for Block<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Room { storage, patches, .. } = self.room;
        if patches.is_empty() {
            return;
        }
        let samples: u64 = patches.iter().map(|patch| u64::from(patch.count_open())).sum();
        let asked = Batch { sampler: self.sampler, storage, patches }.run(simd);
        count(Level::Single, samples - asked);
        for patch in patches.iter() {
            write(self.sampler, patch);
        }
    }
}

/// Decides the patches of a block of a large face.
pub(super) struct LargeBlock<'a, 'b> {
    pub(super) sampler: &'a Sampler<'b>,
    pub(super) large: &'a Large,
    /// The block's first row and column.
    pub(super) origin: [u32; 2],
    pub(super) room: &'a mut Room,
}

impl Kernel for LargeBlock<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { sampler, large, origin, room } = self;
        room.patches.clear();
        large.add(sampler, origin, &mut room.patches);
        Block { sampler, room }.run(simd);
    }
}

/// A face in one patch, all of which the view sees.
#[derive(Clone, Copy)]
pub(super) struct Small {
    pub(super) face: Face,
    /// The convex solid whose faces do not block its samples; −2 for none.
    pub(super) solid: i32,
    corners: [Image; 4],
    pub(super) lattice: FaceLattice,
    pub(super) extent: Extent,
}

/// Adds those faces of a volume that have samples that may be lit.
#[inline(always)]
fn add_of_volume(sampler: &Sampler, volume: &Volume, faces: Range<usize>, room: &mut Room) {
    let Some((_, is_lit)) = sampler.objects[volume.source as usize].receives else { return };
    for number in faces {
        let is_left = sampler.volumes.is_left(volume, number);
        // What does not turn outward is turned away or seen from its edge, and then never lit.
        if is_left || is_lit(number, Some(volume.outward.flipped())) {
            let face = Face { source: volume.source, number: number as u32 };
            add(sampler, face, None, is_left.then_some(volume), room);
        }
    }
}

/// Adds a face if it has samples that may be lit; it may be at a place of the order, or one by which rays to the light leave a volume.
#[inline(always)]
fn add(sampler: &Sampler, face: Face, place: Option<usize>, volume: Option<&Volume>, room: &mut Room) {
    let Sampled { facets, receives: Some((layout, is_lit)), .. } = &sampler.objects[face.source as usize] else {
        return;
    };
    let is_whole = sampler.faces.clipped(face).is_none();
    let packed = place.map(|place| (&sampler.packs[place / WIDTH], place % WIDTH));
    let (corners, corner_count) = match packed {
        // What is clear all over is in no pack.
        Some((pack, lane)) if is_whole && facets.triangles().is_some() && pack.face(lane) == face => {
            let [a, b, c] = pack.corners(lane);
            ([a, b, c, c], 3)
        }
        _ => sampler.faces.corners(face),
    };
    let turn = match volume {
        Some(volume) => Some(volume.outward),
        None if is_whole => sampler.view.turn(&corners),
        None => None,
    };
    if !is_lit(face.number as usize, turn) {
        return;
    }
    // Layouts lie scattered in memory: those of faces that are turned away are not looked at.
    let lattice = layout.face(face.number as usize);
    let [rows, columns] = lattice.lattice.counts();
    if rows == 0 {
        return;
    }
    let extent = Extent::of_images(&corners[..corner_count]);
    if place.is_none() && !sampler.view.concerns(&extent.rect) {
        return;
    }
    if !is_whole || rows > EDGE || columns > EDGE || !sampler.view.holds(&extent.rect) {
        return room.large.push(face);
    }
    let solid = volume.map_or_else(|| own_solid(sampler, face, turn), |volume| volume.solid);
    room.small.push(Small { face, solid, corners, lattice, extent });
}

/// The convex solid whose faces do not block the samples of a face that turns like this, if that is known; −2 for none.
#[inline(always)]
pub(super) fn own_solid(sampler: &Sampler, face: Face, turn: Option<Sign>) -> i32 {
    let (source, number) = (&sampler.faces.sources[face.source as usize], face.number as usize);
    let turn = || turn.unwrap_or_else(|| source.turn(number));
    let solid = source.convex(number).and_then(|_| source.convex_behind(number, Some(turn())));
    solid.map_or(-2, |solid| solid as i32)
}

impl Small {
    #[inline(always)]
    fn patch(&self, sampler: &Sampler) -> Patch {
        let Self { face, solid, ref lattice, ref extent, .. } = *self;
        Patch { solid, ..Patch::whole(face, &self.frame(sampler), extent, lattice, sampler.wide as f32) }
    }

    /// Its lattice in light space.
    #[inline(always)]
    pub(super) fn frame(&self, sampler: &Sampler) -> Frame {
        Frame::of_images(counted_from(&self.corners, &self.lattice), &self.lattice.lattice, &sampler.view)
    }

    /// A word a row, a bit a sample.
    #[inline(always)]
    pub(super) fn row(&self, row: u32) -> i32 {
        match self.lattice.lattice.small_rows() {
            Some(triangle) => triangle.words[row as usize],
            None => first_bits(self.lattice.lattice.counts()[1]),
        }
    }

    /// Keeps that all samples are lit.
    #[inline(always)]
    fn light(&self, sampler: &Sampler) {
        let (lattice, [rows, columns]) = (&self.lattice, self.lattice.lattice.counts());
        count(Level::Single, lattice.lattice.len());
        match lattice.lattice.small_rows() {
            Some(triangle) => write_rows(sampler, (self.face, lattice), [0, 0], &triangle.words),
            None => write_rows(
                sampler,
                (self.face, lattice),
                [0, 0],
                &[first_bits(columns); EDGE as usize][..rows as usize],
            ),
        }
    }
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
    let lattice = sampler.lattice(patch.face);
    write_rows(sampler, (patch.face, &lattice), patch.origin, &patch.open[..patch.rows as usize]);
}

/// Keeps which samples of some rows, from a row and column on, are lit.
#[inline(always)]
fn write_rows(sampler: &Sampler, (face, lattice): (Face, &FaceLattice), origin: [u32; 2], rows: &[i32]) {
    let row_bytes = lattice.row_bytes();
    let mut byte = lattice.first_byte + u64::from(origin[0]) * row_bytes + u64::from(origin[1] / 8);
    for &open in rows {
        if open != 0 {
            sampler.lit[face.source as usize].set(byte, open as u32);
        }
        byte += row_bytes;
    }
}
