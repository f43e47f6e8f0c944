//! What a face is in the picture: which pixel centres it covers and how near it is there, affine in the pixel, with bounds.
//!
//! **Covering** (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997). A ray along q meets a convex
//! polygon with corners p₀, p₁, … exactly where det(p_k, p_{k+1}, q) has, for every edge, the sign of the side from which the
//! plane is seen, or is zero. That is affine in the pixel, and needs no clipping at the eye's plane: corners behind the eye keep
//! their weight. With a = p_k and e = p_{k+1} − p_k it is (a × e)·q; for parallel rays (a − o)×e in the plane.
//!
//! **Nearness.** Of two points on a ray the one nearer to the eye has the greater 1/z (perspective) or −z (parallel). Over a
//! plane with normal n both are affine in the pixel: n·q/(n·a), and −n·(a − o)/n_z.
//!
//! **Bounds** (u = 2^-53; `frame.rs` has the terms). With |a| for the distance of a corner (and of the rays' origins, if
//! they have many), the edge value is off by S·(|a|·8u|e| + |e|·8u|a| + (16u + 4ω)·|a||e|): points, edges, then 7u for the ray's
//! direction, 4u for the cross product and 5u for evaluating. The frame's `unit` of 32u + 4ω instead of 16u + 4ω leaves room for
//! dividing when a row is solved for its columns. Slacks of corners that are no floats go into both lengths' errors. The normal's
//! error is that of a product of edges; that of the quotient is (error of dividend + greatest quotient · error of divisor)
//! over the least divisor. Where the divisor may be zero, its sign is decided exactly, and nothing is said about nearness.

use std::ops::Range;

use glam::DVec3;
use umbriel_geometry::{Aabb, Sign};

use super::{
    frame::{Frame, U},
    window::Window,
};
use crate::view::corners;

/// A function that is affine in the pixel: x·X + y·Y + constant, off by at most `error` all over the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Affine {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) constant: f64,
    pub(super) error: f64,
}

impl Affine {
    /// The part that stays the same on a row.
    #[inline]
    pub(super) fn on_row(&self, y: f64) -> f64 {
        self.y * y + self.constant
    }

    #[inline]
    pub(super) fn at(&self, x: f64, y: f64) -> f64 {
        self.x * x + self.on_row(y)
    }

    /// Bounds over a rectangle of pixel centres; an affine function is extreme at corners.
    pub(super) fn range(&self, [low_x, high_x]: [f64; 2], [low_y, high_y]: [f64; 2]) -> [f64; 2] {
        let values = [self.at(low_x, low_y), self.at(high_x, low_y), self.at(low_x, high_y), self.at(high_x, high_y)];
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        [low - self.error, high + self.error]
    }

    /// The difference times 1 or −1. An infinite error leaves it open everywhere.
    pub(super) fn minus(&self, other: &Self, factor: f64) -> Self {
        let error =
            (self.error + other.error) * (1.0 + 8.0 * U) + 8.0 * U * (self.constant.abs() + other.constant.abs());
        Self { x: self.x - other.x, y: self.y - other.y, constant: self.constant - other.constant, error }
            .scaled(factor)
    }

    fn scaled(self, factor: f64) -> Self {
        let Self { x, y, constant, error } = self;
        Self { x: x * factor, y: y * factor, constant: constant * factor, error: error * factor.abs() }
    }
}

/// At most four edges, and the eye's plane.
const MOST_EDGES: usize = 5;

/// A planar face is covered where all its edges' functions are positive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    edges: [Affine; MOST_EDGES],
    count: u8,
    /// Larger is nearer.
    pub(super) nearness: Affine,
}

impl Plane {
    pub(super) fn edges(&self) -> &[Affine] {
        &self.edges[..usize::from(self.count)]
    }
}

/// A face in the picture.
#[derive(Clone, Debug)]
pub(super) struct Footprint {
    /// Index into the scene's objects.
    pub(super) object: u32,
    /// The facet; 0 for a curved body, which is one footprint with all its patches.
    pub(super) face: u32,
    /// Outside of it nothing is covered.
    pub(super) window: Window,
    /// Not less than the nearness of any of its points.
    pub(super) nearest: f64,
    /// `None` for a curved body.
    pub(super) plane: Option<Plane>,
}

/// Whether a pixel's centre, or all of a window's, are covered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cover {
    None,
    All,
    Doubt,
}

/// Which columns of a row are covered: those in `inner` are, those outside of `outer` are not.
#[derive(Clone, Debug)]
pub(super) struct Span {
    pub(super) outer: Range<u32>,
    pub(super) inner: Range<u32>,
}

impl Footprint {
    /// Whether a pixel's centre is covered, as far as floats can tell.
    #[inline]
    pub(super) fn cover(&self, frame: &Frame, [column, row]: [u32; 2]) -> Cover {
        let Some(plane) = &self.plane else { return Cover::Doubt };
        let (x, y) = (frame.x(column), frame.y(row));
        let mut cover = Cover::All;
        for edge in plane.edges() {
            let value = edge.at(x, y);
            if value < -edge.error {
                return Cover::None;
            }
            if value <= edge.error {
                cover = Cover::Doubt;
            }
        }
        cover
    }

    /// The relation to a window: Warnock's disjoint and surrounding; else in doubt.
    pub(super) fn relation(&self, frame: &Frame, window: &Window) -> Cover {
        if self.window.meet(window).is_empty() {
            return Cover::None;
        }
        let Some(plane) = &self.plane else { return Cover::Doubt };
        let (x, y) = centres(frame, window);
        let mut cover = Cover::All;
        for edge in plane.edges() {
            let [low, high] = edge.range(x, y);
            if high < 0.0 {
                return Cover::None;
            }
            if low <= 0.0 {
                cover = Cover::Doubt;
            }
        }
        cover
    }

    /// Bounds on its nearness where it is seen in a window.
    pub(super) fn nearness(&self, frame: &Frame, window: &Window) -> [f64; 2] {
        let Some(plane) = &self.plane else { return [f64::NEG_INFINITY, self.nearest] };
        let (x, y) = centres(frame, window);
        let [low, high] = plane.nearness.range(x, y);
        if low.is_nan() || high.is_nan() {
            return [f64::NEG_INFINITY, self.nearest];
        }
        [low, high.min(self.nearest)]
    }

    /// The columns of a row that are covered, and those that may be; `limits` are the columns asked about.
    pub(super) fn span(&self, frame: &Frame, row: u32, limits: Range<u32>) -> Span {
        let (from, to) = (limits.start.max(self.window.left), limits.end.min(self.window.right));
        let nothing = Span { outer: from..from, inner: from..from };
        if from >= to || !(self.window.top..self.window.bottom).contains(&row) {
            return nothing;
        }
        let Some(plane) = &self.plane else { return Span { outer: from..to, inner: from..from } };
        let y = frame.y(row);
        let [mut outer, mut inner] = [[from, to]; 2];
        for edge in plane.edges() {
            let rest = edge.on_row(y);
            solve(edge.x, rest + edge.error, frame.middle[0], &mut outer);
            solve(edge.x, rest - edge.error, frame.middle[0], &mut inner);
        }
        if outer[0] >= outer[1] {
            return nothing;
        }
        let inner = if inner[0] < inner[1] { inner } else { [outer[0]; 2] };
        Span { outer: outer[0]..outer[1], inner: inner[0]..inner[1] }
    }
}

/// Cuts columns to those with slope·X + rest > 0, X their centre from the middle.
#[inline]
fn solve(slope: f64, rest: f64, middle: f64, columns: &mut [u32; 2]) {
    let [from, to] = columns;
    let within = |place: f64| place.clamp(f64::from(*from), f64::from(*to)) as u32;
    let place = middle - 0.5 - rest / slope;
    if slope > 0.0 {
        *from = within(place.floor() + 1.0);
    } else if slope < 0.0 {
        *to = within(place.ceil());
    } else if rest.is_nan() || rest <= 0.0 {
        *to = *from;
    }
}

/// The outermost pixel centres of a window.
fn centres(frame: &Frame, window: &Window) -> ([f64; 2], [f64; 2]) {
    let Window { left, top, right, bottom } = *window;
    ([frame.x(left), frame.x(right - 1)], [frame.y(top), frame.y(bottom - 1)])
}

/// The corners of a planar face and all that its footprint is made from.
pub(super) struct Outline<'a> {
    /// World coordinates: three, or four in one plane, convex.
    pub(super) corners: &'a [DVec3],
    /// How far each coordinate may be off.
    pub(super) slack: f64,
}

impl Outline<'_> {
    /// The footprint, and whether its front is seen; `None` where nothing of it is seen: off the picture, between pixel
    /// centres, behind the eye, edge-on. `turn` decides the side exactly.
    pub(super) fn footprint(
        &self,
        frame: &Frame,
        picture: &Window,
        turn: impl FnOnce() -> Sign,
    ) -> Option<(Sign, Footprint)> {
        let mut points = [DVec3::ZERO; 4];
        for (point, corner) in points.iter_mut().zip(self.corners) {
            *point = frame.point(*corner);
        }
        let points = &points[..self.corners.len()];
        let (window, nearest) = window_of(frame, picture, points, self.slack)?;
        let normal = Normal::new(frame, self);
        let divisor = normal.divisor(frame, points[0]);
        let side = if divisor.value.abs() > divisor.error { Sign::of(divisor.value) } else { turn() };
        let factor = match side {
            Sign::Zero => return None,
            Sign::Positive => 1.0,
            Sign::Negative => -1.0,
        };
        let nearness = normal.nearness(frame, points, &divisor);
        let mut plane = Plane { edges: [nearness; MOST_EDGES], count: points.len() as u8, nearness };
        for (k, edge) in plane.edges[..points.len()].iter_mut().enumerate() {
            let next = self.corners[(k + 1) % points.len()];
            *edge = edge_function(frame, points[k], next - self.corners[k], self.slack).scaled(factor);
        }
        let is_ahead = points.iter().all(|&point| point.z > frame.blur(point, self.slack));
        if frame.is_parallel && !is_ahead {
            // Only what is ahead of the rays' origins is seen: −z < 0.
            plane.edges[points.len()] = nearness.scaled(-1.0);
            plane.count += 1;
        }
        Some((side, Footprint { object: 0, face: 0, window, nearest, plane: Some(plane) }))
    }
}

/// The footprint of a curved body: pixels in the picture of its box.
pub(super) fn footprint_of_box(frame: &Frame, picture: &Window, bounds: &Aabb) -> Option<Footprint> {
    if bounds.is_empty() {
        return None;
    }
    let points = corners(bounds).map(|corner| frame.point(corner));
    let (window, nearest) = window_of(frame, picture, &points, 0.0)?;
    Some(Footprint { object: 0, face: 0, window, nearest, plane: None })
}

/// The pixels whose centres the hull of points may cover, and a bound on how near it comes; `None` if there are none.
fn window_of(frame: &Frame, picture: &Window, points: &[DVec3], slack: f64) -> Option<(Window, f64)> {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let (mut is_behind, mut is_ahead, mut least) = (true, true, f64::INFINITY);
    for &point in points {
        let blur = frame.blur(point, slack);
        is_behind &= point.z < -blur;
        is_ahead &= point.z - blur > 0.0;
        least = least.min(point.z - blur);
        // A quotient is off by (error of the dividend + quotient · error of the divisor) over the least divisor.
        let (z, over) = if frame.is_parallel { (1.0, 1.0) } else { (point.z, point.z - blur) };
        for (axis, across) in [point.x, -point.y].into_iter().enumerate() {
            let place = across / (z * frame.scale);
            let error = blur * (1.0 + (across / z).abs()) / (over * frame.scale)
                + 16.0 * U * (place.abs() + frame.middle[axis]);
            low[axis] = low[axis].min(place - error);
            high[axis] = high[axis].max(place + error);
        }
    }
    if is_behind {
        return None;
    }
    let is_bounded = (is_ahead || frame.is_parallel) && (0..2).all(|axis| (high[axis] - low[axis]).is_finite());
    let nearest = match frame.is_parallel {
        true => -least,
        false if is_ahead => (1.0 + 4.0 * U) / least,
        false => f64::INFINITY,
    };
    let window = if is_bounded { pixels_between(frame, picture, low, high) } else { *picture };
    (!window.is_empty()).then_some((window, nearest))
}

fn pixels_between(frame: &Frame, picture: &Window, low: [f64; 2], high: [f64; 2]) -> Window {
    let limits = [[picture.left, picture.right], [picture.top, picture.bottom]];
    let range = |axis: usize| {
        let within = |place: f64| place.clamp(f64::from(limits[axis][0]), f64::from(limits[axis][1])) as u32;
        let shift = frame.middle[axis] - 0.5;
        [within((low[axis] + shift).ceil()), within((high[axis] + shift).floor() + 1.0)]
    };
    let ([left, right], [top, bottom]) = (range(0), range(1));
    Window { left, top, right, bottom }
}

/// det(a, a + e, q), positive or zero inside for a face whose front is seen.
fn edge_function(frame: &Frame, point: DVec3, edge: DVec3, slack: f64) -> Affine {
    let length = edge.length();
    let edge = frame.vector(edge);
    let reach = point.length() + frame.spread;
    let (point_error, edge_error) = (8.0 * U * reach + 2.0 * slack, 8.0 * U * length + 4.0 * slack);
    let error = frame.stretch * (reach * edge_error + length * point_error + frame.unit * reach * length);
    let [x, y, constant] = if frame.is_parallel {
        [-edge.y, -edge.x, point.x * edge.y - point.y * edge.x]
    } else {
        let cross = point.cross(edge);
        [cross.x, -cross.y, cross.z]
    };
    Affine { x: x * frame.scale, y: y * frame.scale, constant, error: error * (1.0 + 16.0 * U) }
}

/// The normal of a face in the eye's coordinates, off by `error`.
struct Normal {
    value: DVec3,
    error: f64,
    slack: f64,
}

/// A number off by at most `error`.
struct Divisor {
    value: f64,
    error: f64,
}

impl Normal {
    fn new(frame: &Frame, outline: &Outline) -> Self {
        let [a, b, d] = [0, 1, outline.corners.len() - 1].map(|k| outline.corners[k]);
        let (lengths, edges) = ([(b - a).length(), (d - a).length()], [frame.vector(b - a), frame.vector(d - a)]);
        let errors = lengths.map(|length| 8.0 * U * length + 4.0 * outline.slack);
        let error = lengths[0] * errors[1] + lengths[1] * errors[0] + frame.unit * lengths[0] * lengths[1];
        Self { value: edges[0].cross(edges[1]), error, slack: outline.slack }
    }

    /// n·a, or n_z: positive where the front is seen.
    fn divisor(&self, frame: &Frame, at: DVec3) -> Divisor {
        let length = self.value.length();
        if frame.is_parallel {
            return Divisor { value: self.value.z, error: self.error + 4.0 * U * length };
        }
        let reach = at.length();
        let error = self.error * reach + length * (16.0 * U * reach + 2.0 * self.slack);
        Divisor { value: self.value.dot(at), error: error * (1.0 + 16.0 * U) }
    }

    /// 1/z or −z over the plane.
    fn nearness(&self, frame: &Frame, points: &[DVec3], divisor: &Divisor) -> Affine {
        let (n, length) = (self.value, self.value.length());
        let least = divisor.value.abs() - divisor.error;
        if least.is_nan() || least <= 0.0 {
            return Affine { x: 0.0, y: 0.0, constant: 0.0, error: f64::INFINITY };
        }
        let reach = points.iter().map(|point| point.length()).fold(0.0, f64::max) + frame.spread;
        let (dividend, greatest) = if frame.is_parallel {
            (self.error * reach + length * (32.0 * U * reach + 2.0 * self.slack), reach)
        } else {
            let ahead =
                points.iter().map(|&point| point.z - frame.blur(point, self.slack)).fold(f64::INFINITY, f64::min);
            let anywhere = frame.stretch * length / least;
            let greatest = if ahead > 0.0 { anywhere.min(1.0 / ahead) } else { anywhere };
            (frame.stretch * (self.error + 32.0 * U * length), greatest)
        };
        let error = (dividend + greatest * divisor.error) / least * (1.0 + 32.0 * U);
        let [x, y, constant] = if frame.is_parallel { [n.x, -n.y, -n.dot(points[0])] } else { [n.x, -n.y, n.z] };
        let over = |value: f64| value / divisor.value;
        Affine { x: over(x) * frame.scale, y: over(y) * frame.scale, constant: over(constant), error }
    }
}
