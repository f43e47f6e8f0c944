//! Items sorted into bins by number, an item in one or several: one flat list and where each bin begins.

use std::ops::Range;

/// Item numbers by bin.
#[derive(Clone, Debug)]
pub(crate) struct Bins {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Bins {
    /// Sorts items `0..` into `count` bins; `ranges` gives the bins of each item. Items keep their order.
    pub(crate) fn new(count: usize, ranges: impl Iterator<Item = Range<usize>>) -> Self {
        let ranges: Vec<[u32; 2]> = ranges.map(|range| [range.start, range.end].map(|bin| bin as u32)).collect();
        let mut starts = vec![0u32; count + 2];
        for [first, end] in &ranges {
            for bin in *first..*end {
                starts[bin as usize + 2] += 1;
            }
        }
        for bin in 2..starts.len() {
            starts[bin] += starts[bin - 1];
        }
        let mut items = vec![0; starts[count + 1] as usize];
        for (item, [first, end]) in (0..).zip(ranges) {
            for bin in first..end {
                let next = &mut starts[bin as usize + 1];
                items[*next as usize] = item;
                *next += 1;
            }
        }
        Self { starts, items }
    }

    /// The items of a bin.
    pub(crate) fn of(&self, bin: usize) -> &[u32] {
        &self.items[self.starts[bin] as usize..self.starts[bin + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_found_in_all_their_bins_in_order() {
        let ranges = [0..2, 1..2, 3..3, 0..4];
        let bins = Bins::new(4, ranges.iter().cloned());
        let all: Vec<&[u32]> = (0..4).map(|bin| bins.of(bin)).collect();
        assert_eq!(all, [&[0, 3][..], &[0, 1, 3], &[3], &[3]]);
    }
}
