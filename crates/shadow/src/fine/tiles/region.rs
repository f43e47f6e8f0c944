//! A part of the window: divided while that saves work, then every sample in it against every occluder over it.
//!
//! Parts without occluders are lit, parts that one occluder hides are dark behind it. Cost: about one look at each
//! occluder and receiver a level, and at the leaves some nanoseconds a sample and eight occluders.

use super::{
    leaf::Leaf,
    sampler::Sampler,
    soup::{Area, Occluder, Receiver, margin},
};

/// Occluders up to which a part is not divided for their sake.
const FEW_OCCLUDERS: usize = 64;

/// Samples times packs of occluders up to which a part is not divided.
const FEW_TESTS: f64 = 32768.0;

/// The most parts along an axis.
const MOST_PARTS: usize = 8;

/// How often parts are divided at most.
const DEEPEST: u32 = 12;

/// The occluders and receivers of a tile, and what is needed to divide it.
pub(super) struct Tile<'a, 'b> {
    pub(super) sampler: &'a Sampler<'b>,
    pub(super) occluders: Vec<Occluder>,
    pub(super) receivers: Vec<Receiver>,
    pub(super) leaf: &'a mut Leaf,
}

impl Tile<'_, '_> {
    /// Decides all samples of the tile.
    pub(super) fn run(&mut self, area: Area) {
        let occluders: Vec<u32> = (0..self.occluders.len() as u32).collect();
        let receivers: Vec<u32> = (0..self.receivers.len() as u32).collect();
        self.divide(area, occluders, receivers, 0);
    }

    fn divide(&mut self, area: Area, mut occluders: Vec<u32>, mut receivers: Vec<u32>, level: u32) {
        if occluders.len() > FEW_OCCLUDERS / 2 {
            self.drop_hidden(&area, &mut occluders, &mut receivers);
        }
        if receivers.is_empty() {
            return;
        }
        let samples = if occluders.is_empty() { 0.0 } else { self.samples(&area, &receivers) };
        let tests = samples * (occluders.len() as f64 / 8.0).ceil();
        let is_small = area.half[0].min(area.half[1]) < 64.0 * self.sampler.view.error;
        let is_easy = occluders.len() <= FEW_OCCLUDERS && tests <= FEW_TESTS;
        if occluders.is_empty() || is_easy || is_small || level == DEEPEST {
            return self.finish(&area, &occluders, &receivers);
        }
        let wanted = (occluders.len() as f64 / 32.0).max(tests / FEW_TESTS);
        let parts = (wanted.sqrt().ceil() as usize).clamp(2, MOST_PARTS);
        let (occluder_lists, receiver_lists) = self.deal(&area, &occluders, &receivers, parts);
        let dealt: usize = occluder_lists.iter().map(Vec::len).sum();

        // Where nearly everything is over all parts, dividing does not help.
        if dealt * 10 > occluders.len() * parts * parts * 8 && tests <= 16.0 * FEW_TESTS {
            return self.finish(&area, &occluders, &receivers);
        }
        drop((occluders, receivers));
        for (part, (occluders, receivers)) in occluder_lists.into_iter().zip(receiver_lists).enumerate() {
            self.divide(part_of(&area, parts, part), occluders, receivers, level + 1);
        }
    }

    fn finish(&mut self, area: &Area, occluders: &[u32], receivers: &[u32]) {
        let Self { sampler, occluders: pool, receivers: receiver_pool, leaf } = self;
        leaf.run(sampler, area, (pool, occluders), (receiver_pool, receivers));
    }

    /// Leaves out what lies behind an occluder that hides all of the area.
    fn drop_hidden(&self, area: &Area, occluders: &mut Vec<u32>, receivers: &mut Vec<u32>) {
        let wide = margin(area.half.map(|half| 2.0 * half), &self.sampler.view) + 1.0;
        let low = [0, 1].map(|k| (area.center[k] - area.half[k] - wide) as i64);
        let high = [0, 1].map(|k| (area.center[k] + area.half[k] + wide) as i64);
        let pool = &self.occluders;
        let hides = |&item: &u32| hiding_depth(&pool[item as usize], low, high, self.sampler.view.error);
        let depth = occluders.iter().filter_map(hides).fold(f32::INFINITY, f32::min);
        if depth < f32::INFINITY {
            let nearest =
                |images: &[super::view::Image; 3]| images.iter().map(|image| image.depth).fold(f32::INFINITY, f32::min);
            let hidden = depth + self.sampler.depth_slack(depth);
            occluders.retain(|&item| nearest(&pool[item as usize].corners) <= hidden);
            receivers.retain(|&item| self.receivers[item as usize].depths[0] <= hidden);
        }
    }

    /// About how many samples there are in the area.
    fn samples(&self, area: &Area, receivers: &[u32]) -> f64 {
        let share = |rect: &super::soup::Rect, k: usize| {
            let (low, high) = (f64::from(rect.min[k]), f64::from(rect.max[k]));
            let overlap = high.min(area.center[k] + area.half[k]) - low.max(area.center[k] - area.half[k]);
            (overlap.max(0.0) + 1.0) / (high - low + 1.0)
        };
        let samples = |&item: &u32| {
            let receiver = &self.receivers[item as usize];
            let count = self.sampler.lattice(receiver).lattice.len_at_most() as f64;
            count * share(&receiver.rect, 0) * share(&receiver.rect, 1)
        };
        receivers.iter().map(samples).sum()
    }

    /// Deals occluders and receivers out to parts × parts parts.
    fn deal(&self, area: &Area, occluders: &[u32], receivers: &[u32], parts: usize) -> (Vec<Vec<u32>>, Vec<Vec<u32>>) {
        let step = area.half.map(|half| 2.0 * half / parts as f64);
        let wide = margin(step, &self.sampler.view);
        let range = |rect: &super::soup::Rect| {
            [0, 1].map(|k| {
                let low = area.center[k] - area.half[k];
                let at = |x: i32, outward: f64| ((f64::from(x) + outward - low) / step[k]).floor();
                let most = parts as f64;
                let (first, end) =
                    (at(rect.min[k], -wide).clamp(0.0, most), (at(rect.max[k], wide) + 1.0).clamp(0.0, most));
                first as usize..end as usize
            })
        };
        let mut lists = (vec![Vec::new(); parts * parts], vec![Vec::new(); parts * parts]);
        for &item in occluders {
            let corners = &self.occluders[item as usize].corners;
            let [columns, rows] = range(&super::soup::Rect::of(corners));
            let is_large = columns.len() * rows.len() > 2;
            for row in rows {
                for column in columns.clone() {
                    let part = row * parts + column;
                    if !is_large || overlaps(corners, &part_of(area, parts, part), wide + 4.0 * self.sampler.view.error)
                    {
                        lists.0[part].push(item);
                    }
                }
            }
        }
        for &item in receivers {
            let [columns, rows] = range(&self.receivers[item as usize].rect);
            for row in rows {
                columns.clone().for_each(|column| lists.1[row * parts + column].push(item));
            }
        }
        lists
    }
}

fn part_of(area: &Area, parts: usize, part: usize) -> Area {
    let place = [part % parts, part / parts];
    let half = area.half.map(|half| half / parts as f64);
    let center = [0, 1].map(|k| area.center[k] - area.half[k] + half[k] * (2 * place[k] + 1) as f64);
    Area { center, half }
}

/// Twice the signed area of (a, b, x).
fn turn(a: [i64; 2], b: [i64; 2], x: [i64; 2]) -> i128 {
    let of = |p: i64, q: i64| i128::from(p) * i128::from(q);
    of(b[0] - a[0], x[1] - a[1]) - of(b[1] - a[1], x[0] - a[0])
}

/// The greatest depth over the box low..high of a triangle that covers all of it for certain.
fn hiding_depth(occluder: &Occluder, low: [i64; 2], high: [i64; 2], error: f64) -> Option<f32> {
    let [a, b, c] = occluder.corners.map(|image| [i64::from(image.x), i64::from(image.y)]);
    let doubled = turn(a, b, c);
    let corners = if doubled < 0 { [a, c, b] } else { [a, b, c] };
    let box_corners = [low, [high[0], low[1]], high, [low[0], high[1]]];
    let length = |k: usize| (0..2).map(|i| (corners[(k + 1) % 3][i] - corners[k][i]).abs()).sum::<i64>();
    // Differences of corners and samples are off by 2·error at most, and no longer than the triangle's border.
    let off = (error * 4.0 * (length(0) + length(1) + length(2)) as f64) as i128 + 1;
    let is_inside = (0..3).all(|k| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        box_corners.iter().all(|&x| turn(a, b, x) > off)
    });
    // Depths over the box lie between those of the corners.
    is_inside.then(|| occluder.corners.iter().map(|image| image.depth).fold(f32::NEG_INFINITY, f32::max))
}

/// Whether a triangle may meet an area widened by `wide`: no edge has the whole area on its outer side.
fn overlaps(corners: &[super::view::Image; 3], area: &Area, wide: f64) -> bool {
    let at = |k: usize| [f64::from(corners[k % 3].x), f64::from(corners[k % 3].y)];
    let [a, b, c] = [at(0), at(1), at(2)];
    let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let sign = if doubled < 0.0 { -1.0 } else { 1.0 };
    (0..3).all(|k| {
        let (a, b) = (at(k), at(k + 1));
        let (dx, dy) = (sign * (b[0] - a[0]), sign * (b[1] - a[1]));
        let middle = dx * (area.center[1] - a[1]) - dy * (area.center[0] - a[0]);
        middle + dx.abs() * (area.half[1] + wide) + dy.abs() * (area.half[0] + wide) >= 0.0
    })
}
