//! Points sorted by the cell they fall into: a counting sort.
//!
//! Rays to one light are points of a plane, so points that are strewn in the list lie together here: what a cell's triangles
//! need is fetched once for all points over it. Cost: some nanoseconds a point.

use crate::loose::seen::BLOCK;

/// A point in its tile.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    /// From −1 to 1 over the tile.
    pub(super) s: f32,
    pub(super) t: f32,
    pub(super) nearness: f32,
    /// Which of the job's points.
    pub(super) index: u32,
}

/// Points that are taken at a time at most; behind the last point there are as many that stand for nothing.
pub(super) const BATCH: usize = 16;

/// The points of a job by bucket. Memory is kept from one job to the next.
#[derive(Debug, Default)]
pub(super) struct Buckets {
    /// In the order of the list.
    listed: Vec<Seen>,
    /// The bucket of each, and how many points of that bucket come before it.
    ranks: Vec<[u32; 2]>,
    sorted: Vec<Seen>,
    /// How many points are in each bucket; once they are sorted, where those of each begin, and the end.
    starts: Vec<u32>,
}

impl Buckets {
    /// Forgets all points.
    pub(super) fn clear(&mut self, buckets: usize) {
        self.listed.clear();
        self.ranks.clear();
        self.starts.clear();
        self.starts.resize(buckets + 1, 0);
    }

    /// Adds points with their buckets.
    #[inline(always)]
    pub(super) fn extend(&mut self, buckets: &[u32; BLOCK], points: &[Seen; BLOCK], count: usize) {
        let mut ranks = [[0; 2]; BLOCK];
        for (rank, &bucket) in ranks.iter_mut().zip(&buckets[..count]) {
            let here = &mut self.starts[bucket as usize];
            *rank = [bucket, *here];
            *here += 1;
        }
        self.ranks.extend_from_slice(&ranks[..count]);
        self.listed.extend_from_slice(&points[..count]);
    }

    /// Sorts what was added. No point waits for one before it, as ranks are known.
    pub(super) fn sort(&mut self) {
        to_starts(&mut self.starts);
        self.sorted.truncate(self.listed.len());
        self.sorted.resize(self.listed.len() + BATCH, Seen::default());
        for (&[bucket, rank], &point) in self.ranks.iter().zip(&self.listed) {
            self.sorted[(self.starts[bucket as usize] + rank) as usize] = point;
        }
    }

    /// Where the points of a bucket begin; they end where those of the next one do.
    #[inline(always)]
    pub(super) fn start(&self, bucket: usize) -> usize {
        self.starts[bucket] as usize
    }

    /// The points of a bucket.
    pub(super) fn of(&self, bucket: usize) -> &[Seen] {
        &self.sorted[self.start(bucket)..self.start(bucket + 1)]
    }

    /// `N` points from one on, of which the last may be of other buckets or stand for nothing.
    ///
    /// # Panics
    /// If there are fewer points than that.
    #[inline(always)]
    pub(super) fn batch<const N: usize>(&self, first: usize) -> &[Seen; N] {
        const { assert!(N <= BATCH) };
        self.sorted[first..].first_chunk().expect("a batch behind the last point")
    }
}

/// Turns counts into the sums of those before.
fn to_starts(counts: &mut [u32]) {
    let mut sum = 0;
    for count in counts {
        (*count, sum) = (sum, sum + *count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_are_used_again_without_what_was_in_them() {
        let mut buckets = Buckets::default();
        for (count, points) in [(5, 100u32), (3, 9), (4, 70)] {
            buckets.clear(count as usize);
            // The last bucket is empty.
            let bucket = |index: u32| index * 7 % (count - 1);
            for first in (0..points).step_by(BLOCK) {
                let indices: [u32; BLOCK] = std::array::from_fn(|lane| first + lane as u32);
                let of_block = indices.map(|index| Seen { index, ..Seen::default() });
                buckets.extend(&indices.map(bucket), &of_block, BLOCK.min((points - first) as usize));
            }
            buckets.sort();
            for number in 0..count {
                let found: Vec<u32> = buckets.of(number as usize).iter().map(|point| point.index).collect();
                assert_eq!(found, (0..points).filter(|&index| bucket(index) == number).collect::<Vec<_>>());
            }
            let indices = buckets.batch::<BATCH>(points as usize - 1).map(|point| point.index);
            assert_eq!(indices[1..], [0; BATCH - 1], "what stands for nothing");
        }
    }
}
