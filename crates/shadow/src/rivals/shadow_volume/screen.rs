//! Points as an eye sees them, and how many volumes end beyond each.
//!
//! A polygon with homogeneous corners v is the cone of their directions from the eye; a point in direction s lies behind or before it if s is on
//! the inner side of all v × v′ (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997), and 1/depth is affine in s.
//! So nothing is clipped for its answer, infinity included, and two polygons with a common edge never both miss a point. Points lie in a grid of bins; in every row of
//! it a polygon meets an interval. Bands of rows in parallel, with the same counts for any number of threads.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::sheets::{Sheet, SheetOwner};
use crate::rivals::{RivalPoint, clip::keep_positive};

/// Points a bin, on average.
const POINTS_A_BIN: usize = 2;

/// Bands that rows are cut into.
const BANDS: usize = 16;

/// A screen with its points.
pub(super) struct Screen {
    eye: DVec3,
    /// World to eye: right, up, forward.
    turn: DMat3,
    low: DVec2,
    bin: DVec2,
    bins: [usize; 2],
    /// Where the points of each bin begin; rows after rows.
    starts: Vec<u32>,
    points: Vec<Seen>,
}

/// A point as it is seen.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// x/z, y/z.
    at: DVec2,
    /// 1/z.
    nearness: f64,
    object: u32,
    face: u32,
    /// Its number among all points.
    number: u32,
}

/// A sheet as the eye sees it.
struct Cone {
    /// Inner side positive.
    edges: [DVec3; 4],
    /// What an edge's value must reach: 0, or just above.
    least: [f64; 4],
    /// 1/depth in direction (x, y, 1).
    nearness: DVec3,
    /// Volumes left here minus volumes entered.
    leaves: i32,
    owner: SheetOwner,
    outline: Outline,
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
            Seen { at: at.truncate() / at.z, nearness: 1.0 / at.z, object: point.object, face: point.face, number }
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
        let mut screen = Self { eye, turn, low, bin, bins, starts: Vec::new(), points: Vec::new() };
        if !seen.is_empty() {
            screen.sort(seen);
        }
        screen
    }

    /// Puts the points into their bins.
    fn sort(&mut self, seen: Vec<Seen>) {
        let place = |seen: &Seen| {
            let [column, row] = self.bin_of(seen.at);
            row * self.bins[0] + column
        };
        let mut starts = vec![0u32; self.bins[0] * self.bins[1] + 1];
        seen.iter().for_each(|point| starts[place(point) + 1] += 1);
        (1..starts.len()).for_each(|bin| starts[bin] += starts[bin - 1]);
        let mut next = starts.clone();
        let mut points = seen.clone();
        for point in &seen {
            let slot = &mut next[place(point)];
            points[*slot as usize] = *point;
            *slot += 1;
        }
        (self.starts, self.points) = (starts, points);
    }

    fn bin_of(&self, at: DVec2) -> [usize; 2] {
        let place = (at - self.low) / self.bin;
        [0, 1].map(|axis| (place[axis].max(0.0) as usize).min(self.bins[axis] - 1))
    }

    pub(super) fn bytes(&self) -> u64 {
        (self.starts.len() * 4 + self.points.len() * (size_of::<Seen>() + 4)) as u64
    }

    /// Calls `tell` with every point's number and how many volumes hold it.
    pub(super) fn count(&self, sheets: &[Sheet], mut tell: impl FnMut(u32, i32)) {
        if self.points.is_empty() {
            return;
        }
        let cones: Vec<Cone> = sheets.par_iter().filter_map(|sheet| self.cone(sheet)).collect();
        let rows_a_band = self.bins[1].div_ceil(BANDS);
        let mut counts = vec![0; self.points.len()];
        let mut bands = Vec::new();
        let mut rest = &mut counts[..];
        for first in (0..self.bins[1]).step_by(rows_a_band) {
            let rows = [first, (first + rows_a_band).min(self.bins[1])];
            let [begin, end] = rows.map(|row| self.starts[row * self.bins[0]] as usize);
            let (own, others) = rest.split_at_mut(end - begin);
            bands.push((rows, begin, own));
            rest = others;
        }
        bands.par_iter_mut().for_each(|(rows, begin, counts)| {
            cones.iter().for_each(|cone| self.draw(cone, *rows, *begin, counts));
        });
        self.points.iter().zip(counts).for_each(|(point, count)| tell(point.number, count));
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
        (outline.len >= 3).then_some(Cone { edges, least, nearness, leaves, owner: sheet.owner, outline })
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

    /// Adds a cone to the counts of a band's points, which begin with number `begin`.
    fn draw(&self, cone: &Cone, rows: [usize; 2], begin: usize, counts: &mut [i32]) {
        let outline = &cone.outline.corners[..cone.outline.len];
        let (low, high) = outline.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c.y), h.max(c.y)));
        let row_of = |y: f64| self.bin_of(DVec2::new(self.low.x, y))[1];
        for row in row_of(low).max(rows[0])..(row_of(high) + 1).min(rows[1]) {
            let Some([left, right]) = self.span(outline, row) else { continue };
            let at = |column: usize| self.starts[row * self.bins[0] + column] as usize;
            let (first, last) = (at(left), at(right + 1));
            self.add(cone, &self.points[first..last], &mut counts[first - begin..last - begin]);
        }
    }

    /// The bins of a row that an outline may meet. A millionth of a bin more than it is: what is rounded here only adds tests.
    fn span(&self, outline: &[DVec2], row: usize) -> Option<[usize; 2]> {
        let top = self.low.y + self.bin.y * (row as f64 - 1e-6);
        let bottom = self.low.y + self.bin.y * (row as f64 + 1.0 + 1e-6);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (k, a) in outline.iter().enumerate() {
            let b = outline[(k + 1) % outline.len()];
            if a.y.min(b.y) > bottom || a.y.max(b.y) < top {
                continue;
            }
            let at = |y: f64| if a.y == b.y { a.x } else { a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)) };
            let ends = if a.y == b.y { [a.x, b.x] } else { [at(a.y.clamp(top, bottom)), at(b.y.clamp(top, bottom))] };
            low = low.min(ends[0].min(ends[1]));
            high = high.max(ends[0].max(ends[1]));
        }
        let margin = 1e-6 * self.bin.x;
        let column = |x: f64| self.bin_of(DVec2::new(x, self.low.y))[0];
        (low <= high).then(|| [column(low - margin), column(high + margin)])
    }

    /// Adds a cone to the points that it lies beyond.
    fn add(&self, cone: &Cone, points: &[Seen], counts: &mut [i32]) {
        let [a, b, c, d] = cone.edges;
        let [a0, b0, c0, d0] = cone.least;
        let holds = |at: DVec3| (a.dot(at) >= a0) & (b.dot(at) >= b0) & (c.dot(at) >= c0) & (d.dot(at) >= d0);
        for (point, count) in points.iter().zip(counts) {
            let at = point.at.extend(1.0);
            if !holds(at) {
                continue;
            }
            let is_beyond = match cone.owner {
                // Seen from the light's side, the own face lies beyond.
                SheetOwner::Face { object, face } if point.object == object && point.face == face => cone.leaves < 0,
                SheetOwner::Body { object } if point.object == object => false,
                _ => cone.nearness.dot(at) < point.nearness,
            };
            *count += if is_beyond { cone.leaves } else { 0 };
        }
    }
}
