//! Morton codes: cells of the repeatedly halved square and cube (Morton, "A computer oriented geodetic data base and a
//! new technique in file sequencing", IBM, 1966).
//!
//! A cell of level l has coordinates in 0..2^l; its code interleaves their bits, x lowest. Dropping the last 2 (3) bits
//! gives the parent, so all cells below a cell are one range of codes, and sorted codes are a tree without pointers.
//! Levels: 32 in the plane, 21 in space, which is what 64 bits hold. Everything is exact; every step is O(1).

use std::{cmp::Ordering, ops::RangeInclusive};

use crate::direction::Direction;

#[cfg(test)]
mod tests;

/// Bits of `value` moved apart by one: bit i goes to bit 2i.
fn spread2(value: u32) -> u64 {
    let mut bits = u64::from(value);
    for (shift, mask) in [
        (16, 0x0000_FFFF_0000_FFFF),
        (8, 0x00FF_00FF_00FF_00FF),
        (4, 0x0F0F_0F0F_0F0F_0F0F),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ] {
        bits = (bits | (bits << shift)) & mask;
    }
    bits
}

/// The inverse of [`spread2`]; other bits are ignored.
#[inline]
fn gather2(bits: u64) -> u32 {
    let mut bits = bits & 0x5555_5555_5555_5555;
    for (shift, mask) in [
        (1, 0x3333_3333_3333_3333),
        (2, 0x0F0F_0F0F_0F0F_0F0F),
        (4, 0x00FF_00FF_00FF_00FF),
        (8, 0x0000_FFFF_0000_FFFF),
        (16, 0x0000_0000_FFFF_FFFF),
    ] {
        bits = (bits | (bits >> shift)) & mask;
    }
    bits as u32
}

/// The 21 lower bits of `value` moved apart by two: bit i goes to bit 3i.
fn spread3(value: u32) -> u64 {
    let mut bits = u64::from(value) & 0x001F_FFFF;
    for (shift, mask) in [
        (32, 0x001F_0000_0000_FFFF),
        (16, 0x001F_0000_FF00_00FF),
        (8, 0x100F_00F0_0F00_F00F),
        (4, 0x10C3_0C30_C30C_30C3),
        (2, 0x1249_2492_4924_9249),
    ] {
        bits = (bits | (bits << shift)) & mask;
    }
    bits
}

/// The inverse of [`spread3`]; other bits are ignored.
fn gather3(bits: u64) -> u32 {
    let mut bits = bits & 0x1249_2492_4924_9249;
    for (shift, mask) in [
        (2, 0x10C3_0C30_C30C_30C3),
        (4, 0x100F_00F0_0F00_F00F),
        (8, 0x001F_0000_FF00_00FF),
        (16, 0x001F_0000_0000_FFFF),
        (32, 0x0000_0000_001F_FFFF),
    ] {
        bits = (bits | (bits >> shift)) & mask;
    }
    bits as u32
}

/// Interleaves two coordinates, x lowest.
pub fn encode2([x, y]: [u32; 2]) -> u64 {
    spread2(x) | spread2(y) << 1
}

/// The coordinates of a code of [`encode2`].
#[inline]
pub fn decode2(code: u64) -> [u32; 2] {
    [gather2(code), gather2(code >> 1)]
}

/// Interleaves the 21 lower bits of three coordinates, x lowest; higher bits are dropped.
pub fn encode3([x, y, z]: [u32; 3]) -> u64 {
    spread3(x) | spread3(y) << 1 | spread3(z) << 2
}

/// The coordinates of a code of [`encode3`].
pub fn decode3(code: u64) -> [u32; 3] {
    [gather3(code), gather3(code >> 1), gather3(code >> 2)]
}

/// A cell of the halved square (`D` = 2, [`Quadrant`]) or cube (`D` = 3, [`Octant`]).
///
/// Ordered as a depth-first walk meets them: by position along the Morton curve, a cell before the cells inside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Code<const D: usize> {
    bits: u64,
    level: u8,
}

/// A cell of the halved square.
pub type Quadrant = Code<2>;

/// A cell of the halved cube.
pub type Octant = Code<3>;

impl Code<2> {
    /// The cell of this level with these coordinates; `None` beyond the square or [`Code::MAX_LEVEL`].
    pub fn at(level: u8, coordinates: [u32; 2]) -> Option<Self> {
        Self::within(level, coordinates).then(|| Self { bits: encode2(coordinates), level })
    }

    /// The cell's place among the cells of its level, along u and v.
    #[inline]
    pub fn coordinates(self) -> [u32; 2] {
        decode2(self.bits)
    }
}

impl Code<3> {
    /// The cell of this level with these coordinates; `None` beyond the cube or [`Code::MAX_LEVEL`].
    pub fn at(level: u8, coordinates: [u32; 3]) -> Option<Self> {
        Self::within(level, coordinates).then(|| Self { bits: encode3(coordinates), level })
    }

    /// The cell's place among the cells of its level, along x, y and z.
    pub fn coordinates(self) -> [u32; 3] {
        decode3(self.bits)
    }

    /// Where the cell begins: the start of its range.
    pub(crate) fn start(self) -> u64 {
        self.bits << (3 * u32::from(Self::MAX_LEVEL - self.level))
    }

    /// The cell of the same level that touches this one in `direction`; `None` beyond the cube. One addition to the
    /// spread bits of each axis (Schrack, "Finding neighbors of equal size in linear quadtrees and octrees in constant
    /// time", CVGIP: Image Understanding 55(3), 1992).
    pub fn neighbour(self, direction: Direction) -> Option<Self> {
        let all = (1u64 << (3 * u32::from(self.level))) - 1;
        let mut bits = 0;
        for (axis, step) in direction.steps().into_iter().enumerate() {
            let mask = (0x1249_2492_4924_9249 << axis) & all;
            let along = self.bits & mask;
            bits |= match step {
                0 => along,
                1 if along != mask => ((along | !mask) + 1) & mask, // the carry runs over the bits of other axes
                -1 if along != 0 => (along - 1) & mask,
                _ => return None,
            };
        }
        Some(Self { bits, level: self.level })
    }
}

impl<const D: usize> Code<D> {
    /// The deepest level that 64 bits hold: 32 for the square, 21 for the cube.
    pub const MAX_LEVEL: u8 = {
        assert!(D == 2 || D == 3, "cells are squares or cubes");
        (64 / D) as u8
    };

    /// The whole square or cube.
    pub const ROOT: Self = Self { bits: 0, level: 0 };

    fn within(level: u8, coordinates: [u32; D]) -> bool {
        level <= Self::MAX_LEVEL && coordinates.iter().all(|&c| u64::from(c) < 1 << level)
    }

    /// The cell with this Morton code among the cells of its level; `None` where there is none.
    pub fn from_bits(level: u8, bits: u64) -> Option<Self> {
        let is_there = level <= Self::MAX_LEVEL && bits.checked_shr(D as u32 * u32::from(level)).unwrap_or(0) == 0;
        is_there.then_some(Self { bits, level })
    }

    /// The Morton code among the cells of the same level.
    pub fn bits(self) -> u64 {
        self.bits
    }

    /// How often the whole was halved.
    #[inline]
    pub fn level(self) -> u8 {
        self.level
    }

    /// The cell that this one is a child of; `None` for the whole.
    pub fn parent(self) -> Option<Self> {
        self.ancestor(self.level.checked_sub(1)?)
    }

    /// The cell of `level` that holds this one (itself on its own level); `None` for a deeper level.
    pub fn ancestor(self, level: u8) -> Option<Self> {
        let up = self.level.checked_sub(level)?;
        Some(Self { bits: self.bits.checked_shr(D as u32 * u32::from(up)).unwrap_or(0), level })
    }

    /// Child number `index` in Morton order; `None` at [`Code::MAX_LEVEL`] or beyond the last child.
    pub fn child(self, index: u8) -> Option<Self> {
        let is_there = self.level < Self::MAX_LEVEL && index < 1 << D;
        is_there.then(|| Self { bits: self.bits << D | u64::from(index), level: self.level + 1 })
    }

    /// The children in Morton order; none at [`Code::MAX_LEVEL`].
    #[inline]
    pub fn children(self) -> impl DoubleEndedIterator<Item = Self> {
        (0..1 << D).filter_map(move |index| self.child(index))
    }

    /// The codes, on the deepest level, of the cells in this one.
    pub fn range(self) -> RangeInclusive<u64> {
        let below = D as u32 * u32::from(Self::MAX_LEVEL - self.level);
        let first = self.bits.checked_shl(below).unwrap_or(0);
        // All ones in the bits below; with 64 of them the shift has no result and all bits are ones.
        let last = first | !u64::MAX.checked_shl(below).unwrap_or(0);
        first..=last
    }

    /// Whether `other` is this cell or lies in it.
    pub fn contains(self, other: Self) -> bool {
        other.ancestor(self.level) == Some(self)
    }
}

impl<const D: usize> Ord for Code<D> {
    fn cmp(&self, other: &Self) -> Ordering {
        (*self.range().start(), self.level).cmp(&(*other.range().start(), other.level))
    }
}

impl<const D: usize> PartialOrd for Code<D> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
