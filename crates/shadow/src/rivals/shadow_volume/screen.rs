//! Points as an eye sees them, and how many volumes end beyond each.
//!
//! A polygon with homogeneous corners v is the cone of their directions from the eye; a point in direction s lies behind or before it if s is on
//! the inner side of all v × v′ (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997), and 1/depth is affine in s.
//! So nothing is clipped for its answer, infinity included, and two polygons with a common edge never both miss a point. Points lie in a grid of bins; in every row of
//! it a polygon meets an interval, which is filled by [`Run`]. Bands of rows, as many points each as the nearer caches hold, in parallel and with the same counts for any
//! number of threads.

use std::ops::Range;

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::{
    run::{Columns, Run},
    sheets::{Sheet, SheetOwner},
};
use crate::rivals::{RivalPoint, clip::keep_positive};

/// Points a bin, on average.
const POINTS_A_BIN: usize = 2;

/// Points a band, about: 36 bytes each.
const POINTS_A_BAND: usize = 8192;

/// A screen with its points.
pub(super) struct Screen {
    eye: DVec3,
    /// World to eye: right, up, forward.
    turn: DMat3,
    low: DVec2,
    bin: DVec2,
    /// One over the size of a bin.
    bins_a_unit: DVec2,
    bins: [usize; 2],
    /// Where the points of each bin begin; rows after rows.
    starts: Vec<u32>,
    points: Columns,
    /// The number of each among all points.
    numbers: Vec<u32>,
}

/// A point as it is seen.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// x/z, y/z.
    at: DVec2,
    /// 1/z.
    nearness: f64,
    /// Its number among all points.
    number: u32,
}

/// A sheet as the eye sees it.
pub(super) struct Cone {
    /// Inner side positive.
    pub(super) edges: [DVec3; 4],
    /// What an edge's value must reach: 0, or just above.
    pub(super) least: [f64; 4],
    /// 1/depth in direction (x, y, 1).
    pub(super) nearness: DVec3,
    /// Volumes left here minus volumes entered.
    pub(super) leaves: i32,
    pub(super) owner: SheetOwner,
    outline: Outline,
    /// The first and the last row of bins that it meets.
    rows: [usize; 2],
}

/// The part of a polygon on the screen, convex.
#[derive(Clone, Copy, Default)]
struct Outline {
    corners: [DVec2; 8],
    len: usize,
}

impl Screen {
    /// The `asked` ones of `points` from `eye`.
    pub(super) fn new(eye: DVec3, points: &[RivalPoint], asked: Vec<u32>) -> Self {
        let sum: DVec3 = asked.iter().map(|&number| points[number as usize].position - eye).sum();
        let forward = sum.normalize_or(DVec3::Z);
        let (right, up) = forward.any_orthonormal_pair();
        let turn = DMat3::from_cols(right, up, forward).transpose();
        let seen = |&number: &u32| {
            let point = &points[number as usize];
            let at = turn * (point.position - eye);
            let nearness = 1.0 / at.z;
            Seen { at: at.truncate() * nearness, nearness, number }
        };
        let seen: Vec<Seen> = asked.par_iter().map(seen).filter(|seen| seen.nearness > 0.0).collect();
        let (low, high) = seen
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), seen| (low.min(seen.at), high.max(seen.at)));
        let size = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let count = (seen.len() / POINTS_A_BIN).max(1) as f64;
        let across = (count * size.x / size.y).sqrt().clamp(1.0, 8192.0) as usize;
        let bins = [across, (count as usize / across).clamp(1, 8192)];
        let bin = DVec2::new(size.x / bins[0] as f64, size.y / bins[1] as f64);
        let bins_a_unit = 1.0 / bin;
        let mut screen = Self {
            eye,
            turn,
            low,
            bin,
            bins_a_unit,
            bins,
            starts: Vec::new(),
            points: Columns::default(),
            numbers: Vec::new(),
        };
        if !seen.is_empty() {
            screen.sort(&seen, points);
        }
        screen
    }

    /// Puts the points into their bins.
    fn sort(&mut self, seen: &[Seen], points: &[RivalPoint]) {
        let place = |seen: &Seen| {
            let [column, row] = self.bin_of(seen.at);
            (row * self.bins[0] + column) as u32
        };
        let keys: Vec<u32> = seen.iter().map(place).collect();
        let mut starts = vec![0u32; self.bins[0] * self.bins[1] + 1];
        keys.iter().for_each(|&key| starts[key as usize + 1] += 1);
        (1..starts.len()).for_each(|bin| starts[bin] += starts[bin - 1]);
        let mut next = starts.clone();
        let count = seen.len();
        self.points =
            Columns { x: vec![0.0; count], y: vec![0.0; count], nearness: vec![0.0; count], owner: vec![0; count] };
        self.numbers = vec![0; count];
        for (&key, seen) in keys.iter().zip(seen) {
            let slot = next[key as usize] as usize;
            next[key as usize] += 1;
            let RivalPoint { object, face, .. } = points[seen.number as usize];
            (self.points.x[slot], self.points.y[slot]) = (seen.at.x, seen.at.y);
            (self.points.nearness[slot], self.points.owner[slot]) = (seen.nearness, Columns::owner_of(object, face));
            self.numbers[slot] = seen.number;
        }
        self.starts = starts;
    }

    fn bin_of(&self, at: DVec2) -> [usize; 2] {
        let place = (at - self.low) * self.bins_a_unit;
        [0, 1].map(|axis| (place[axis].max(0.0) as usize).min(self.bins[axis] - 1))
    }

    pub(super) fn bytes(&self) -> u64 {
        // Three floats, an owner, a number and a count a point.
        (self.starts.len() * 4 + self.numbers.len() * 40) as u64
    }

    /// Calls `tell` with every point's number and how many volumes hold it; returns how often a point was looked at.
    pub(super) fn count(&self, sheets: &[Sheet], mut tell: impl FnMut(u32, i32)) -> u64 {
        if self.numbers.is_empty() {
            return 0;
        }
        let cones: Vec<Cone> = sheets.par_iter().filter_map(|sheet| self.cone(sheet)).collect();
        let rows_a_band = self.bins[1].div_ceil(self.numbers.len().div_ceil(POINTS_A_BAND));
        let mut counts = vec![0; self.numbers.len()];
        let mut bands = Vec::new();
        let mut rest = &mut counts[..];
        for first in (0..self.bins[1]).step_by(rows_a_band) {
            let rows = [first, (first + rows_a_band).min(self.bins[1])];
            let [begin, end] = rows.map(|row| self.starts[row * self.bins[0]] as usize);
            let (own, others) = rest.split_at_mut(end - begin);
            bands.push((rows, begin, own));
            rest = others;
        }
        let drawn = bands
            .par_iter_mut()
            .map(|(rows, begin, counts)| cones.iter().map(|cone| self.draw(cone, *rows, *begin, counts)).sum::<u64>());
        let looked_at = drawn.sum();
        self.numbers.iter().zip(counts).for_each(|(&number, count)| tell(number, count));
        looked_at
    }

    /// A sheet as it is seen; `None` where it is seen edge-on or not at all.
    fn cone(&self, sheet: &Sheet) -> Option<Cone> {
        let corners: [DVec3; 4] = std::array::from_fn(|k| self.turn * (sheet.corners[k] - sheet.weights[k] * self.eye));
        let len = if sheet.corners[2] == sheet.corners[3] { 3 } else { 4 };
        let [a, b, c, _] = corners;
        let turn = a.dot(b.cross(c));
        if turn == 0.0 {
            return None;
        }
        let weights = sheet.weights;
        let nearness = (weights[0] * b.cross(c) + weights[1] * c.cross(a) + weights[2] * a.cross(b)) / turn;
        let outline = self.outline(&corners[..len]);
        let (mut edges, mut least) = ([DVec3::ZERO; 4], [0.0; 4]);
        for k in 0..len {
            edges[k] = turn.signum() * corners[k].cross(corners[(k + 1) % len]);
            // Of the two polygons at an edge, the points on it belong to one.
            let first = edges[k].to_array().into_iter().find(|&part| part != 0.0);
            least[k] = if first.is_some_and(|part| part > 0.0) { 0.0 } else { f64::from_bits(1) };
        }
        let leaves = if turn > 0.0 { sheet.multiplicity } else { -sheet.multiplicity };
        if len == 3 {
            (edges[3], least[3]) = (edges[2], least[2]);
        }
        if outline.len < 3 {
            return None;
        }
        let (low, high) = outline.corners[..outline.len]
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), corner| (low.min(corner.y), high.max(corner.y)));
        let rows = [low, high].map(|y| self.bin_of(DVec2::new(self.low.x, y))[1]);
        Some(Cone { edges, least, nearness, leaves, owner: sheet.owner, outline, rows })
    }

    /// The part of a cone that the screen holds.
    fn outline(&self, corners: &[DVec3]) -> Outline {
        let high = self.low + self.bin * DVec2::new(self.bins[0] as f64, self.bins[1] as f64);
        let planes = [
            DVec3::new(1.0, 0.0, -self.low.x),
            DVec3::new(-1.0, 0.0, high.x),
            DVec3::new(0.0, 1.0, -self.low.y),
            DVec3::new(0.0, -1.0, high.y),
        ];
        let mut polygon = corners.to_vec();
        planes.into_iter().for_each(|plane| keep_positive(&mut polygon, |corner| plane.dot(corner)));
        let mut outline = Outline::default();
        for corner in polygon.into_iter().filter(|corner| corner.z > 0.0).take(8) {
            outline.corners[outline.len] = corner.truncate() / corner.z;
            outline.len += 1;
        }
        outline
    }

    /// Adds a cone to the counts of a band's points, which begin with number `begin`; returns how many it looks at.
    fn draw(&self, cone: &Cone, rows: [usize; 2], begin: usize, counts: &mut [i32]) -> u64 {
        let [first, last] = cone.rows;
        let mut looked_at = 0;
        for row in first.max(rows[0])..(last + 1).min(rows[1]) {
            let Some(span) = self.span(cone, row) else { continue };
            let at = |column: usize| self.starts[row * self.bins[0] + column] as usize;
            let [left, inside, border, end] =
                [span.met.start, span.filled.start, span.filled.end, span.met.end].map(at);
            looked_at += (end - left) as u64;
            for (points, is_inside) in [(left..inside, false), (inside..border, true), (border..end, false)] {
                let counts = &mut counts[points.start - begin..points.end - begin];
                Run { cone, points: self.points.of(points), counts, is_inside }.draw();
            }
        }
        looked_at
    }

    /// The bins of a row that an outline may meet, and those that it fills. A millionth of a bin more or less than it is: what is rounded here only adds tests.
    fn span(&self, cone: &Cone, row: usize) -> Option<Span> {
        let outline = &cone.outline.corners[..cone.outline.len];
        let top = self.low.y + self.bin.y * (row as f64 - 1e-6);
        let bottom = self.low.y + self.bin.y * (row as f64 + 1.0 + 1e-6);
        let (mut met, mut at_top, mut at_bottom) = (Interval::EMPTY, Interval::EMPTY, Interval::EMPTY);
        for (k, a) in outline.iter().enumerate() {
            let b = outline[(k + 1) % outline.len()];
            let (low, high) = (a.y.min(b.y), a.y.max(b.y));
            if low > bottom || high < top {
                continue;
            }
            let at = |y: f64| if a.y == b.y { a.x } else { a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)) };
            let ends = if a.y == b.y { [a.x, b.x] } else { [at(a.y.clamp(top, bottom)), at(b.y.clamp(top, bottom))] };
            ends.into_iter().for_each(|x| met.add(x));
            for (y, crossed) in [(top, &mut at_top), (bottom, &mut at_bottom)] {
                if low < y && y < high {
                    crossed.add(at(y));
                }
            }
        }
        let margin = 1e-6 * self.bin.x;
        let column = |x: f64| self.bin_of(DVec2::new(x, self.low.y))[0];
        let met_bins = column(met.low - margin)..column(met.high + margin) + 1;
        // Convex, so whole bins between its crossings above and below are in it.
        let filled = Interval { low: at_top.low.max(at_bottom.low), high: at_top.high.min(at_bottom.high) };
        let is_crossed = [at_top, at_bottom].iter().all(|crossed| crossed.low < crossed.high);
        let from = column(filled.low + margin) + 1;
        let filled = if is_crossed { from..column(filled.high - margin).max(from) } else { 0..0 };
        let is_part = met_bins.start <= filled.start && filled.end <= met_bins.end;
        let filled = if is_part { filled } else { met_bins.start..met_bins.start };
        (met.low <= met.high).then_some(Span { met: met_bins, filled })
    }
}

/// Columns of bins.
struct Span {
    /// All that an outline may meet.
    met: Range<usize>,
    /// Those of them that it fills.
    filled: Range<usize>,
}

/// Coordinates on a line.
#[derive(Clone, Copy)]
struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    const EMPTY: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };

    fn add(&mut self, x: f64) {
        (self.low, self.high) = (self.low.min(x), self.high.max(x));
    }
}
