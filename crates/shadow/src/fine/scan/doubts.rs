//! What is left to exact arithmetic.

use super::{
    faces::Face,
    patch::{EDGE, Patch},
    sampler::Sampler,
    tree::WIDTH,
};

/// Samples of a row of a patch that something may block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt {
    /// Among the patches of the batch.
    pub(super) patch: u32,
    pub(super) row: u32,
    pub(super) columns: u32,
    pub(super) occluder: Occluder,
}

/// What may block a sample.
#[derive(Clone, Copy, Debug)]
pub(super) enum Occluder {
    Face(Face),
    /// Index into the volumes.
    Volume(u32),
}

/// Keeps samples of eight rows of a patch that something may block.
#[cold]
pub(super) fn doubt(doubts: &mut Vec<Doubt>, patch: u32, occluder: Occluder, first: u32, doubtful: [i32; WIDTH]) {
    let rows = (first..).zip(doubtful).filter(|&(_, columns)| columns != 0);
    doubts.extend(rows.map(|(row, columns)| Doubt { patch, row, columns: columns as u32, occluder }));
}

/// Decides what is in doubt and not blocked by anything else, for patches from number `first` on; how many samples that were. `asked` is room.
pub(super) fn settle(
    sampler: &Sampler,
    (first, patches): (usize, &mut [Patch]),
    doubts: &[Doubt],
    asked: &mut Vec<u32>,
) -> u64 {
    asked.clear();
    if !doubts.is_empty() {
        asked.resize(patches.len() * EDGE as usize, 0);
    }
    // Doubts of one pair follow each other, so it is asked once.
    let mut last = None;
    let mut may_block = |face: Face, occluder: Face| {
        let pair = (face, occluder);
        match last {
            Some((known, may_block)) if known == pair => may_block,
            _ => last.insert((pair, sampler.may_block(face, occluder))).1,
        }
    };
    for doubt in doubts {
        let number = doubt.patch as usize - first;
        let patch = &mut patches[number];
        let mut columns = doubt.columns & patch.open[doubt.row as usize] as u32;
        if matches!(doubt.occluder, Occluder::Face(occluder) if !may_block(patch.face, occluder)) {
            continue;
        }
        asked[number * EDGE as usize + doubt.row as usize] |= columns;
        while columns != 0 {
            let column = columns.trailing_zeros();
            columns &= columns - 1;
            let place = [patch.origin[0] + doubt.row, patch.origin[1] + column];
            let blocks = match doubt.occluder {
                Occluder::Face(face) => sampler.blocks_exactly(patch.face, place, face),
                Occluder::Volume(volume) => {
                    sampler.volume_blocks_exactly(patch, place, &sampler.volumes.all[volume as usize])
                }
            };
            if blocks {
                patch.open[doubt.row as usize] &= !(1 << column);
            }
        }
    }
    asked.iter().map(|columns| u64::from(columns.count_ones())).sum()
}
