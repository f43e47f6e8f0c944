//! The alpha of a picture as a texture sampler reads it at its finest level, and bounds of it over ranges of texels.
//!
//! Texels, wrap modes and filters are those of glTF 2.0 §3.8.4, which are OpenGL ES 3.2 §8.14 (nearest: the texel that holds the
//! point; linear: the bilinear mean of the four middles round it). Bounds come from a pyramid of least and greatest values, two by
//! two texels a step. Making it is linear in the texels; a bound takes at most [`SPAN`]² looks, whatever the range.

use crate::cut_out::CutOutDefect;

/// How a texture goes on beyond its borders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// It begins again.
    #[default]
    Repeat,
    /// It runs back and forth.
    MirroredRepeat,
    /// Its border goes on.
    ClampToEdge,
}

/// How values between the middles of texels are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Filter {
    /// Each texel is of one value.
    Nearest,
    /// The bilinear mean of four texels.
    #[default]
    Linear,
}

/// Greatest number of blocks along an axis that a bound looks at.
const SPAN: u32 = 8;

/// A picture's alpha, row by row from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaMap {
    size: [u32; 2],
    /// 0 to [`AlphaMap::ONE`].
    texels: Vec<u16>,
    /// Level k has blocks of 2^(k + 1) texels a side.
    levels: Vec<Level>,
}

/// Least and greatest value in each block of a level.
#[derive(Clone, Debug, PartialEq)]
struct Level {
    size: [u32; 2],
    ranges: Vec<[u16; 2]>,
}

impl Wrap {
    /// The texel of `count` that stands for a number of any size.
    pub(super) fn texel(self, index: i64, count: u32) -> u32 {
        let count = i64::from(count);
        // Mostly; a division takes as long as all the rest.
        if (0..count).contains(&index) {
            return index as u32;
        }
        let texel = match self {
            Self::Repeat => index.rem_euclid(count),
            Self::ClampToEdge => index.clamp(0, count - 1),
            Self::MirroredRepeat => {
                let place = index.rem_euclid(2 * count);
                place.min(2 * count - 1 - place)
            }
        };
        texel as u32
    }

    /// The texels, first and last, that stand for the numbers from `first` to `last`: two runs, which may be one.
    fn runs(self, [first, last]: [i64; 2], count: u32) -> [[u32; 2]; 2] {
        let [a, b] = [first, last].map(|index| self.texel(index, count));
        let end = count - 1;
        let period = i64::from(count);
        let once = |run| [run, run];
        match self {
            Self::ClampToEdge => once([a, b]),
            Self::Repeat if last - first >= period - 1 => once([0, end]),
            Self::Repeat if a <= b => once([a, b]),
            Self::Repeat => [[0, b], [a, end]],
            Self::MirroredRepeat => {
                let turn = last.div_euclid(period);
                // With more than one turn a whole period lies between.
                once(match (turn - first.div_euclid(period), turn.rem_euclid(2) == 1) {
                    (0, _) => [a.min(b), a.max(b)],
                    (1, true) => [a.min(b), end],
                    (1, false) => [0, a.max(b)],
                    _ => [0, end],
                })
            }
        }
    }
}

impl AlphaMap {
    /// What stands for an alpha of one. Pictures of 8 bits have 257 times their values: a/255 exactly.
    pub const ONE: u16 = u16::MAX;

    /// Width and height, and an alpha for each texel, row by row from the upper left corner.
    ///
    /// # Errors
    /// [`CutOutDefect::Texels`] unless there is at least one texel, one for each place, and no more than 2^16 along a side.
    pub fn new(size: [u32; 2], texels: Vec<u16>) -> Result<Self, CutOutDefect> {
        let fits = size.iter().all(|side| (1..=1 << 16).contains(side));
        if !fits || texels.len() as u64 != u64::from(size[0]) * u64::from(size[1]) {
            return Err(CutOutDefect::Texels);
        }
        let mut map = Self { size, texels, levels: Vec::new() };
        while let Some(next) = map.coarser() {
            map.levels.push(next);
        }
        Ok(map)
    }

    /// Width and height, texels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The value of a texel.
    pub(super) fn texel(&self, [column, row]: [u32; 2]) -> u16 {
        self.texels[row as usize * self.size[0] as usize + column as usize]
    }

    /// Least and greatest value of the texels that stand for numbers in two ranges; both ends count.
    pub(super) fn range(&self, wrap: [Wrap; 2], columns: [i64; 2], rows: [i64; 2]) -> [u16; 2] {
        let mut range = [u16::MAX, u16::MIN];
        for columns in wrap[0].runs(columns, self.size[0]) {
            for rows in wrap[1].runs(rows, self.size[1]) {
                range = join(range, self.range_of(columns, rows));
            }
        }
        range
    }

    fn range_of(&self, columns: [u32; 2], rows: [u32; 2]) -> [u16; 2] {
        let spans = |shift: u32| [columns, rows].iter().all(|[a, b]| (b >> shift) - (a >> shift) < SPAN);
        let shift = (0..=self.levels.len() as u32).find(|&shift| spans(shift)).unwrap_or(self.levels.len() as u32);
        let mut range = [u16::MAX, u16::MIN];
        for row in rows[0] >> shift..=rows[1] >> shift {
            for column in columns[0] >> shift..=columns[1] >> shift {
                range = join(range, self.block(shift, [column, row]));
            }
        }
        range
    }

    /// The values of a block of 2^shift texels a side.
    fn block(&self, shift: u32, [column, row]: [u32; 2]) -> [u16; 2] {
        match shift.checked_sub(1) {
            None => [self.texel([column, row]); 2],
            Some(level) => {
                let level = &self.levels[level as usize];
                level.ranges[row as usize * level.size[0] as usize + column as usize]
            }
        }
    }

    /// The level above the last one; `None` above a single block.
    fn coarser(&self) -> Option<Level> {
        let below = self.levels.last().map_or(self.size, |level| level.size);
        let shift = self.levels.len() as u32;
        if below == [1, 1] {
            return None;
        }
        let size = below.map(|side| side.div_ceil(2));
        let mut ranges = Vec::with_capacity(size[0] as usize * size[1] as usize);
        for row in 0..size[1] {
            for column in 0..size[0] {
                let ends = |first: u32, count: u32| 2 * first..(2 * first + 2).min(count);
                let parts = ends(row, below[1]).flat_map(|row| ends(column, below[0]).map(move |column| [column, row]));
                ranges.push(parts.map(|place| self.block(shift, place)).fold([u16::MAX, u16::MIN], join));
            }
        }
        Some(Level { size, ranges })
    }
}

fn join(a: [u16; 2], b: [u16; 2]) -> [u16; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn wraps_are_those_of_samplers() {
        let texels = |wrap: Wrap| (-5..8).map(|index| wrap.texel(index, 3)).collect::<Vec<_>>();
        assert_eq!(texels(Wrap::Repeat), [1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1]);
        assert_eq!(texels(Wrap::MirroredRepeat), [1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1]);
        assert_eq!(texels(Wrap::ClampToEdge), [0, 0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2, 2]);
    }

    #[test]
    fn maps_have_a_texel_for_each_place() {
        for (size, count) in [([0, 1], 0), ([2, 2], 3), ([2, 2], 5), ([1 << 17, 1], 1 << 17)] {
            assert_eq!(AlphaMap::new(size, vec![0; count]), Err(CutOutDefect::Texels), "{size:?}");
        }
    }

    proptest! {
        #[test]
        fn ranges_hold_what_they_stand_for_and_no_more_where_blocks_are_texels(
            size in prop::array::uniform2(1u32..40),
            seed in prop::collection::vec(any::<u16>(), 1600),
            first in prop::array::uniform2(-90i64..90),
            length in prop::array::uniform2(0i64..60),
            wraps in prop::array::uniform2(0usize..3),
        ) {
            let wrap = wraps.map(|k| [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge][k]);
            let texels = seed[..(size[0] * size[1]) as usize].to_vec();
            let map = AlphaMap::new(size, texels).expect("a map");
            let ranges = [0, 1].map(|axis| [first[axis], first[axis] + length[axis]]);
            let mut truth = [u16::MAX, u16::MIN];
            for column in ranges[0][0]..=ranges[0][1] {
                for row in ranges[1][0]..=ranges[1][1] {
                    let place = [wrap[0].texel(column, size[0]), wrap[1].texel(row, size[1])];
                    truth = join(truth, [map.texel(place); 2]);
                }
            }
            let [least, greatest] = map.range(wrap, ranges[0], ranges[1]);
            prop_assert!(least <= truth[0] && truth[1] <= greatest);
            if length.iter().all(|&length| length < i64::from(SPAN)) {
                prop_assert_eq!([least, greatest], truth);
            }
        }
    }
}
