//! Points sorted by the cell they fall into: a counting sort.
//!
//! Rays to one light are points of a plane, so points that are strewn in the list lie together here: what a cell's triangles
//! need is fetched once for all points over it. Cost: some nanoseconds a point.

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

/// The points of a job by bucket. Memory is kept from one job to the next.
#[derive(Debug, Default)]
pub(super) struct Buckets {
    /// The bucket of each point, in the order of the list.
    keys: Vec<u32>,
    listed: Vec<Seen>,
    sorted: Vec<Seen>,
    /// Where the points of each bucket end.
    ends: Vec<u32>,
}

impl Buckets {
    /// Forgets all points.
    pub(super) fn clear(&mut self, buckets: usize) {
        self.keys.clear();
        self.listed.clear();
        self.ends.clear();
        self.ends.resize(buckets, 0);
    }

    /// Adds points with their buckets.
    #[inline(always)]
    pub(super) fn extend(&mut self, buckets: &[u32], points: &[Seen]) {
        buckets.iter().for_each(|&bucket| self.ends[bucket as usize] += 1);
        self.keys.extend_from_slice(buckets);
        self.listed.extend_from_slice(points);
    }

    /// Sorts what was pushed.
    pub(super) fn sort(&mut self) {
        to_starts(&mut self.ends);
        self.sorted.resize(self.listed.len(), Seen::default());
        for (&bucket, &point) in self.keys.iter().zip(&self.listed) {
            let place = &mut self.ends[bucket as usize];
            self.sorted[*place as usize] = point;
            *place += 1;
        }
    }

    /// Where the points of a bucket begin; they end where those of the next one do.
    #[inline(always)]
    pub(super) fn start(&self, bucket: usize) -> usize {
        if bucket == 0 { 0 } else { self.ends[bucket - 1] as usize }
    }

    /// All points, sorted.
    #[inline(always)]
    pub(super) fn points(&self) -> &[Seen] {
        &self.sorted
    }
}

/// Turns counts into the sums of those before.
fn to_starts(counts: &mut [u32]) {
    let mut sum = 0;
    for count in counts {
        (*count, sum) = (sum, sum + *count);
    }
}
