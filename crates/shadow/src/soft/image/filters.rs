//! Shades from a depth map: PCF, PCSS, average depth, and kernels from boxes.
//!
//! - **PCF** (Reeves, Salesin and Cook, SIGGRAPH 1987): the share of the texels in a window that are not nearer than the point.
//! - **PCSS** (Fernando, "Percentage-closer soft shadows", SIGGRAPH 2005 sketches): the mean depth of the nearer texels in a search window is the
//!   blocker's; its penumbra's width is PCF's window.
//! - **Average depth** (VSSM; Yang et al., "Variance soft shadow mapping", Computer Graphics Forum 29(7), 2010): that mean estimated from mean and
//!   variance of the search window, from summed-area tables: O(1) whatever its size.
//! - **Boxes** (Duan, "A fast soft shadows algorithm for dynamic scene in MMOG", Computer Knowledge and Technology 2009(15)): the blocker's depth is
//!   interpolated between two points of the outlines of its boxes, and nothing is done outside of the outlines, grown by the widest penumbra.
//!
//! All share one PCF and the smallest depths of squares of texels: a window with nothing nearer than the point is lit at once, and no estimate of a
//! blocker is nearer than they say (as by the hierarchical map of Yang et al.). PCF's inner loop runs along rows without a branch, so the compiler makes vectors of it. On the map a light of width W seen past a blocker at
//! z_b from a point at z has the slope W·(1/z_b − 1/z): the kernel of all four. Pixels in parallel.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{boxes::Blocker, depth_map::DepthMap};

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
    /// One kernel for all, a slope (half its width).
    Pcf {
        /// Half the kernel's width on the plane of slopes.
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
    /// Edge of the light, metres.
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

/// How many texels a point's depth is granted, for a texel stands for its middle: the steepest receiver that is shaded without
/// shadowing itself rises as much as a texel and a half across one.
const BIAS_TEXELS: f64 = 1.5;

/// Numbers added side by side.
const LANES: usize = 16;

impl SoftShader {
    /// For a square light of this edge, metres.
    pub fn new(map: DepthMap, width: f64) -> Self {
        Self { map, width, tables: None }
    }

    /// The depth map.
    pub fn map(&self) -> &DepthMap {
        &self.map
    }

    /// Makes the summed-area tables, which [`SoftMethod::AverageDepth`] needs; `background` is the depth of what lies behind everything.
    pub fn prepare_average_depth(&mut self, background: f64) {
        let size = self.map.size();
        let mut sums = vec![[0.0; 2]; (size + 1) * (size + 1)];
        sums.par_chunks_mut(size + 1).enumerate().skip(1).for_each(|(row, line)| {
            let mut sum = [0.0; 2];
            for (column, &depth) in self.map.row(row - 1).iter().enumerate() {
                let depth = f64::from(depth).min(background);
                sum = [sum[0] + depth, sum[1] + depth * depth];
                line[column + 1] = sum;
            }
        });
        for row in 1..=size {
            let (before, after) = sums.split_at_mut(row * (size + 1));
            let last = &before[(row - 1) * (size + 1)..];
            for (sum, above) in after[..=size].iter_mut().zip(last) {
                *sum = [sum[0] + above[0], sum[1] + above[1]];
            }
        }
        self.tables = Some(Tables { sums, background });
    }

    /// The share of the light that each point (world coordinates, metres) sees; 1 for no point. Average depth without its tables shades as PCSS.
    pub fn shade(&self, points: &[Option<DVec3>], method: &SoftMethod) -> Vec<f32> {
        points
            .par_iter()
            .with_min_len(256)
            .map(|point| point.map_or(1.0, |point| self.shade_point(point, method)))
            .collect()
    }

    fn shade_point(&self, point: DVec3, method: &SoftMethod) -> f32 {
        let seen = self.map.space.to_light(point);
        if seen.z <= 0.0 {
            return 1.0;
        }
        let place = self.map.space.to_texels(seen);
        match method {
            SoftMethod::Pcf { radius } => self.filter(place, seen.z, *radius),
            SoftMethod::Pcss => self.shade_with(place, seen.z, |window, limit| self.mean_nearer(window, limit)),
            SoftMethod::AverageDepth => self.shade_with(place, seen.z, |window, limit| match &self.tables {
                Some(tables) => tables.mean_nearer(window, seen.z, self.map.size()),
                None => self.mean_nearer(window, limit),
            }),
            SoftMethod::Boxes { kernel, quality, blockers, farthest } => {
                let slope = seen.truncate() / seen.z;
                let receiver = if *kernel == BoxKernel::Fixed { *farthest } else { seen.z };
                let radius =
                    blockers.iter().filter(|blocker| blocker.holds(slope, receiver, self.width)).map(|blocker| {
                        match kernel {
                            BoxKernel::Fixed => blocker.fixed_width(slope, *farthest, self.width) / seen.z,
                            BoxKernel::OwnDistance => self.slope_of_light(blocker.depth_at(slope), seen.z),
                        }
                    });
                match radius.reduce(f64::max) {
                    None => 1.0,
                    Some(width) => self.filter(place, seen.z, 0.5 * quality * width),
                }
            }
        }
    }

    /// The slope that the light has, seen past a blocker.
    fn slope_of_light(&self, blocker: f64, receiver: f64) -> f64 {
        (self.width * (1.0 / blocker - 1.0 / receiver)).max(0.0)
    }

    /// A shade by searching the blocker's depth.
    fn shade_with(
        &self,
        place: DVec2,
        depth: f64,
        search: impl Fn([std::ops::Range<usize>; 2], f32) -> Option<f64>,
    ) -> f32 {
        let nearest = f64::from(self.map.nearest());
        if !nearest.is_finite() || nearest >= depth {
            return 1.0;
        }
        let radius = 0.5 * self.slope_of_light(nearest, depth) / self.map.space.texel();
        let Some(window) = self.map.window(place, radius) else { return 1.0 };
        let (limit, nearest) = (self.limit(depth), self.map.nearest_in(&window));
        if nearest >= limit {
            return 1.0;
        }
        match search(window, limit).map(|blocker| blocker.max(f64::from(nearest))) {
            None => 1.0,
            Some(blocker) => self.filter(place, depth, 0.5 * self.slope_of_light(blocker, depth)),
        }
    }

    /// Texels nearer than this hide a point at `depth`.
    fn limit(&self, depth: f64) -> f32 {
        (depth * (1.0 - BIAS_TEXELS * self.map.space.texel())) as f32
    }

    /// PCF over a window of this radius, a slope.
    fn filter(&self, place: DVec2, depth: f64, radius: f64) -> f32 {
        let Some(window) = self.map.window(place, radius / self.map.space.texel()) else { return 1.0 };
        let limit = self.limit(depth);
        if self.map.nearest_in(&window) >= limit {
            return 1.0;
        }
        let [columns, rows] = window;
        let count = columns.len() * rows.len();
        let hidden: u32 = rows
            .map(|row| self.map.row(row)[columns.clone()].iter().map(|&depth| u32::from(depth < limit)).sum::<u32>())
            .sum();
        1.0 - hidden as f32 / count as f32
    }

    /// The mean depth of the texels in a window that are nearer than `limit`.
    fn mean_nearer(&self, [columns, rows]: [std::ops::Range<usize>; 2], limit: f32) -> Option<f64> {
        let (mut sums, mut counts) = ([0.0f32; LANES], [0u32; LANES]);
        for row in rows {
            let (chunks, rest) = self.map.row(row)[columns.clone()].as_chunks::<LANES>();
            for chunk in chunks {
                for lane in 0..LANES {
                    let is_nearer = chunk[lane] < limit;
                    sums[lane] += if is_nearer { chunk[lane] } else { 0.0 };
                    counts[lane] += u32::from(is_nearer);
                }
            }
            for (lane, &depth) in rest.iter().enumerate().filter(|&(_, &depth)| depth < limit) {
                sums[lane] += depth;
                counts[lane] += 1;
            }
        }
        let count: u32 = counts.iter().sum();
        (count > 0).then(|| f64::from(sums.iter().sum::<f32>()) / f64::from(count))
    }
}

impl Tables {
    /// The estimated mean depth of what is nearer than `depth`; `None` where all is farther.
    fn mean_nearer(&self, [columns, rows]: [std::ops::Range<usize>; 2], depth: f64, size: usize) -> Option<f64> {
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
