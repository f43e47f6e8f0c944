//! Shades from a depth map: PCF, PCSS, average depth, and kernels from boxes.
//!
//! - **PCF** (Reeves, Salesin and Cook, SIGGRAPH 1987): the share of the texels in a window that are not before the receiver.
//! - **PCSS** (Fernando, "Percentage-closer soft shadows", SIGGRAPH 2005 sketches): the mean depth of the nearer texels in a search window is the
//!   blocker's; its penumbra's width is PCF's window.
//! - **Average depth** (VSSM; Yang et al., "Variance soft shadow mapping", Computer Graphics Forum 29(7), 2010): that mean estimated from mean and
//!   variance of the search window, from summed-area tables: O(1) whatever its size.
//! - **Boxes** (Duan, "A fast soft shadows algorithm for dynamic scene in MMOG", Computer Knowledge and Technology 2009(15)): the blocker's depth is
//!   interpolated between two points of the outlines of its boxes, and nothing is done outside of the outlines, grown by the widest penumbra.
//!
//! All share one PCF, the receiver's plane ([`super::receiver`]) and the smallest depths of squares of texels: a window with nothing before the plane is lit
//! at once, and no estimate of a blocker is nearer than they say (as by the hierarchical map of Yang et al.). Texels are counted sixteen at a time
//! by the widest vectors of the processor ([`umbriel_geometry::simd`]); pixels in parallel.

use std::ops::Range;

use rayon::prelude::*;
use umbriel_geometry::simd::dispatch;
use umbriel_visibility::depth_map::DepthMap;

use super::{
    blocker_grid::BlockerGrid,
    boxes::Blocker,
    receiver::{CountNearer, Limit, Receiver, SurfacePoint},
};

/// Which kernel a receiver gets from boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoxKernel {
    /// Widths fixed once for a frame, for receivers at the greatest depth: the source's way.
    Fixed,
    /// The width at the receiver's own depth, from the interpolated depth of the blocker.
    OwnDistance,
}

/// A way to shade.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum SoftMethod {
    /// One kernel for all.
    Pcf {
        /// Half the kernel's width on the map's image.
        radius: f64,
    },
    /// Blocker search by reading every texel.
    Pcss,
    /// Blocker depth from mean and variance.
    AverageDepth,
    /// Blocker depth from boxes.
    Boxes {
        /// Whether widths are fixed.
        kernel: BoxKernel,
        /// Scales the kernel: the source's η; 1 is the penumbra's width.
        quality: f64,
        /// A pair of extremes for each blocker.
        blockers: Vec<Blocker>,
        /// Depth of the farthest receiver, metres.
        farthest: f64,
    },
}

/// A depth map and the light that it belongs to.
#[derive(Clone, Debug)]
pub struct SoftShader {
    map: DepthMap,
    /// Edge of the light in metres, or of a sun twice the tangent of its radius.
    width: f64,
    tables: Option<Tables>,
}

/// Sums of depths, and of their squares, over all texels before a place in both directions.
#[derive(Clone, Debug)]
struct Tables {
    sums: Vec<[f64; 2]>,
    /// What counts for texels without depth.
    background: f64,
}

/// Columns that one thread sums up at a time.
const COLUMNS: usize = 64;

impl SoftShader {
    /// For a square lamp of this edge in metres, or for a sun of this width: 2·tan(α/2) for the angular diameter α.
    pub fn new(map: DepthMap, width: f64) -> Self {
        Self { map, width, tables: None }
    }

    /// The depth map.
    pub fn map(&self) -> &DepthMap {
        &self.map
    }

    /// Makes the summed-area tables, which [`SoftMethod::AverageDepth`] needs; `background` is the depth of what lies behind everything.
    /// Rows in parallel, then bands of columns: the same bits for any number of threads.
    pub fn prepare_average_depth(&mut self, background: f64) {
        let edge = self.map.size() + 1;
        let mut sums = vec![[0.0; 2]; edge * edge];
        sums.par_chunks_mut(edge).enumerate().skip(1).for_each(|(row, line)| {
            let mut sum = [0.0; 2];
            for (column, &depth) in self.map.row(row - 1).iter().enumerate() {
                let depth = f64::from(depth).min(background);
                sum = [sum[0] + depth, sum[1] + depth * depth];
                line[column + 1] = sum;
            }
        });
        // Every band has its part of every row.
        let mut bands: Vec<Vec<&mut [[f64; 2]]>> = (0..edge.div_ceil(COLUMNS)).map(|_| Vec::new()).collect();
        for line in sums.chunks_mut(edge) {
            bands.iter_mut().zip(line.chunks_mut(COLUMNS)).for_each(|(band, part)| band.push(part));
        }
        bands.into_par_iter().for_each(add_rows_up);
        self.tables = Some(Tables { sums, background });
    }

    /// The share of the light that each point sees; 1 for no point. Average depth without its tables shades as PCSS.
    pub fn shade(&self, points: &[Option<SurfacePoint>], method: &SoftMethod) -> Vec<f32> {
        let grid = match method {
            SoftMethod::Boxes { blockers, farthest, .. } => {
                BlockerGrid::new(&self.map.space, blockers, *farthest, self.width)
            }
            _ => BlockerGrid::default(),
        };
        let shade = |point: &Option<SurfacePoint>| {
            let receiver = point.as_ref().and_then(|point| Receiver::new(&self.map.space, point));
            receiver.map_or(1.0, |receiver| self.shade_point(&receiver, method, &grid))
        };
        points.par_iter().with_min_len(256).map(shade).collect()
    }

    fn shade_point(&self, receiver: &Receiver, method: &SoftMethod, grid: &BlockerGrid) -> f32 {
        match method {
            SoftMethod::Pcf { radius } => self.filter(receiver, *radius),
            SoftMethod::Pcss => self.shade_with(receiver, |window, limit| self.mean_nearer(window, limit)),
            SoftMethod::AverageDepth => self.shade_with(receiver, |window, limit| match &self.tables {
                Some(tables) => tables.mean_nearer(window, receiver.depth, self.map.size()),
                None => self.mean_nearer(window, limit),
            }),
            SoftMethod::Boxes { kernel, quality, blockers, farthest } => {
                let near = grid.near(receiver.place).iter().map(|&number| &blockers[number as usize]);
                match self.width_by_boxes(receiver, *kernel, near, *farthest) {
                    None => 1.0,
                    Some(width) => self.filter(receiver, 0.5 * quality * width),
                }
            }
        }
    }

    /// How wide the penumbra on the receiver is on the image, the mean of those of the blockers that may throw one, each by the share of the light that its
    /// rectangle hides; the widest where none hides any. `None` without blockers.
    fn width_by_boxes<'a>(
        &self,
        receiver: &Receiver,
        kernel: BoxKernel,
        blockers: impl Iterator<Item = &'a Blocker>,
        farthest: f64,
    ) -> Option<f64> {
        let (space, place) = (&self.map.space, receiver.image);
        let deepest = if kernel == BoxKernel::Fixed { farthest } else { receiver.depth };
        let before = blockers.filter(|blocker| blocker.is_before(receiver.depth));
        let near = before.filter(|blocker| blocker.holds(space, place, deepest, self.width));
        let width_by = |blocker: &Blocker| match kernel {
            BoxKernel::Fixed => space.on_image(blocker.fixed_width(space, place, farthest, self.width), receiver.depth),
            BoxKernel::OwnDistance => space.width_on_image(self.width, blocker.depth_at(place), receiver.depth),
        };
        let (mut widest, mut sum, mut weights) = (None::<f64>, 0.0, 0.0);
        for blocker in near {
            let width = width_by(blocker);
            let weight = blocker.share_of_window(place, width);
            (sum, weights) = (sum + weight * width, weights + weight);
            widest = Some(widest.map_or(width, |widest| widest.max(width)));
        }
        if weights > 0.0 { Some(sum / weights) } else { widest }
    }

    /// A shade by searching the blocker's depth.
    fn shade_with(&self, receiver: &Receiver, search: impl Fn(&[Range<usize>; 2], Limit) -> Option<f64>) -> f32 {
        let (space, depth) = (&self.map.space, receiver.depth);
        let nearest = f64::from(self.map.nearest());
        if !nearest.is_finite() || nearest >= depth {
            return 1.0;
        }
        let radius = 0.5 * space.width_on_image(self.width, nearest, depth) / space.texel();
        let Some(window) = self.map.window(receiver.place, radius) else { return 1.0 };
        let (limit, nearest) = (receiver.limit(space, &window), self.map.nearest_in(&window));
        if limit.frees(nearest) {
            return 1.0;
        }
        match search(&window, limit).map(|blocker| blocker.max(f64::from(nearest))) {
            None => 1.0,
            Some(blocker) => self.filter(receiver, 0.5 * space.width_on_image(self.width, blocker, depth)),
        }
    }

    /// PCF over a window of this radius on the image.
    fn filter(&self, receiver: &Receiver, radius: f64) -> f32 {
        let space = &self.map.space;
        let Some(window) = self.map.window(receiver.place, radius / space.texel()) else { return 1.0 };
        let limit = receiver.limit(space, &window);
        if limit.frees(self.map.nearest_in(&window)) {
            return 1.0;
        }
        let hidden = dispatch(CountNearer::<false> { map: &self.map, window: &window, limit }).count;
        1.0 - hidden as f32 / (window[0].len() * window[1].len()) as f32
    }

    /// The mean depth of the texels in a window that hide the receiver.
    fn mean_nearer(&self, window: &[Range<usize>; 2], limit: Limit) -> Option<f64> {
        let nearer = dispatch(CountNearer::<true> { map: &self.map, window, limit });
        (nearer.count > 0).then(|| f64::from(nearer.sum) / f64::from(nearer.count))
    }
}

/// Adds to every row of a band the one above, from above to below.
fn add_rows_up(mut band: Vec<&mut [[f64; 2]]>) {
    for row in 1..band.len() {
        let (above, below) = band.split_at_mut(row);
        for (sum, above) in below[0].iter_mut().zip(above[row - 1].iter()) {
            *sum = [sum[0] + above[0], sum[1] + above[1]];
        }
    }
}

impl Tables {
    /// The estimated mean depth of what is nearer than `depth`; `None` where all is farther.
    fn mean_nearer(&self, [columns, rows]: &[Range<usize>; 2], depth: f64, size: usize) -> Option<f64> {
        let at = |row: usize, column: usize| self.sums[row * (size + 1) + column];
        let count = (columns.len() * rows.len()) as f64;
        let [mean, square] = [0, 1].map(|k| {
            (at(rows.end, columns.end)[k] - at(rows.start, columns.end)[k] - at(rows.end, columns.start)[k]
                + at(rows.start, columns.start)[k])
                / count
        });
        let (variance, beyond) = ((square - mean * mean).max(0.0), depth - mean);
        if beyond <= 0.0 {
            // Chebyshev's bound says nothing here: the window lies behind the point on the whole.
            return (variance > 0.0 && mean < self.background).then_some(mean.min(depth));
        }
        let farther = variance / (variance + beyond * beyond);
        let blocker = (mean - farther * depth) / (1.0 - farther);
        (blocker > 0.0 && farther < 1.0).then_some(blocker.min(depth))
    }
}
