//! Where the surface nearest to the light is one sheet: what lies on it is lit, without a look at its triangles.
//!
//! The problem: a point of a lit surface is compared with all its neighbours, and none of them hides it. The way: where the nearest triangles over a cell are apart in height from all others,
//! are of closed surfaces and turn one way, every ray from below them towards the light meets as many of them (NUMERICS.md, "Sheets"). So where the ray over the cell's middle meets
//! one, a point on one of them has none before it.
//!
//! Guarantee: no other face hides a point of a flat face that is as near as [`from`] says, or nearer. Cost: a few operations a group and cell.

use crate::loose::tile::Entry;

/// What those of a group that meet a cell are to a sheet there: how many of them the ray over the middle of the cell meets, and which way they turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Share(u8);

impl Share {
    /// One of this is not known, or they turn both ways, or are not all of closed surfaces.
    pub(super) const NONE: Self = Self(u8::MAX);

    #[inline(always)]
    pub(super) fn of(met: u32, is_reversed: bool) -> Self {
        Self(met as u8 | u8::from(is_reversed) << 7)
    }

    fn met(self) -> u32 {
        u32::from(self.0 & 0x7f)
    }

    fn is_reversed(self) -> bool {
        self.0 >> 7 == 1
    }
}

/// From which nearness on a point of a face lies on the sheet over a cell; infinite where there is none. `entries` are all over the cell, the nearest first, but for what is less near than
/// `covered`.
pub(super) fn from(entries: &[Entry], covered: f32) -> f32 {
    let Some(first) = entries.first() else { return f32::INFINITY };
    let (mut farthest, mut met) = (first.nearest, 0);
    for entry in entries {
        if entry.nearest < farthest {
            break;
        }
        if entry.share == Share::NONE || entry.share.is_reversed() != first.share.is_reversed() {
            return f32::INFINITY;
        }
        (farthest, met) = (farthest.min(entry.farthest), met + entry.share.met());
    }
    // Where something is infinitely near nothing is known of how far it reaches.
    if met == 1 && farthest >= covered && first.nearest < f32::INFINITY { farthest } else { f32::INFINITY }
}

#[cfg(test)]
mod tests;
