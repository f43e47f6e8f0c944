//! The tight world box of a placed body, by its support function: the greatest n·x over the body.
//!
//! A quadric in a box has no formula of reasonable size. Whether it reaches beyond a plane across a world axis is decided
//! exactly instead (is its form ≤ 0 somewhere on its box cut by the plane? see [`polytope`](crate::region::polytope)), and
//! the plane is found by halving: the image of its box to begin with is thinned to the body's, up to
//! 2^-40 of the former. Where the support of an ellipsoid or of the box tells in floats where that will end, the way there is spared, if it is right.
//! Half a millisecond a body, or two where nothing tells; the others take microseconds.

use glam::{DMat3, DVec3};

use super::{Analytic, layout::Layout};
use crate::{
    aabb::{Aabb, above, below},
    approx::Approx,
    decide::Decide,
    dyadic::Dyadic,
    placement::Placement,
    region::polytope::{Frame, Linear, Polytope, Problem, reaches_zero},
};

/// Roundings of a support value: squares, sums, a root, a quotient and products of numbers of the reach's size.
const PADDING: f64 = 8.0 * f64::EPSILON;

/// How often the slack of a quadric's bounds is halved.
const HALVINGS: usize = 40;

/// How many of these are taken on trust, before their outcome is asked for.
const TRUSTED: usize = 34;

/// The box, rounded outward; empty for a quadric that has no point in its box.
pub(crate) fn of(body: &Analytic, placement: &Placement) -> Aabb {
    let bounds = by_support(body, placement);
    match body {
        Analytic::Quadric { matrix, within } => {
            Cut::new(&Layout::of(body), within).thinned(bounds, placement, &Ellipsoid::of(matrix))
        }
        _ => bounds,
    }
}

fn by_support(body: &Analytic, placement: &Placement) -> Aabb {
    let map = placement.map();
    let extent = DVec3::from_array(body.half_extent());
    let mut bounds = Aabb { min: map.translation, max: map.translation };
    for axis in 0..3 {
        let row = map.matrix3.row(axis);
        let reach = row.abs().dot(extent) * PADDING;
        bounds.max[axis] = above(map.translation[axis] + (support(body, row) + reach));
        bounds.min[axis] = below(map.translation[axis] - (support(body, -row) + reach));
    }
    bounds
}

/// The greatest n·x over the body, rounded.
fn support(body: &Analytic, n: DVec3) -> f64 {
    let across = n.x.hypot(n.z);
    let disk = |radius: f64, y: f64| across * radius + n.y * y;
    match *body {
        Analytic::Sphere { radius } => radius * n.length(),
        Analytic::Ellipsoid { radii } => (DVec3::from_array(radii) * n).length(),
        Analytic::Cylinder { radius, height } | Analytic::Hyperboloid { end_radius: radius, height, .. } => {
            disk(radius, 0.5 * height).max(disk(radius, -0.5 * height))
        }
        Analytic::Cone { radius, height } => disk(0.0, 0.5 * height).max(disk(radius, -0.5 * height)),
        Analytic::Frustum { bottom_radius, top_radius, height } => {
            disk(top_radius, 0.5 * height).max(disk(bottom_radius, -0.5 * height))
        }
        Analytic::Capsule { radius, height } => radius * n.length() + 0.5 * height * n.y.abs(),
        Analytic::Disk { radius } => disk(radius, 0.0),
        Analytic::Paraboloid { radius, height } => {
            // On the outline (radius·w, height·(½ − w²)), w in 0..=1, the slope vanishes at w = across·radius/(2·n.y·height).
            let (sideways, upward) = (across * radius, n.y * height);
            let w = if upward > 0.0 && sideways < 2.0 * upward { sideways / (2.0 * upward) } else { 1.0 };
            sideways * w + upward * (0.5 - w * w)
        }
        Analytic::Quadric { within: [low, high], .. } => (0..3).map(|k| (n[k] * low[k]).max(n[k] * high[k])).sum(),
    }
}

/// A quadric's form over a box as a unit cube.
pub(super) struct Cut {
    frame: Frame<Dyadic>,
    unit: f64,
    exact: Problem<Dyadic>,
    approx: Problem<Approx>,
}

impl Cut {
    pub(super) fn new(layout: &Layout, within: &[[f64; 3]; 2]) -> Self {
        let zero = Dyadic::zero;
        let [low, high] = within.map(|corner| corner.map(|x| Dyadic::new(x / layout.unit)));
        let edges = std::array::from_fn(|axis| {
            let mut edge = [zero(), zero(), zero(), zero()];
            edge[axis] = high[axis].clone() - low[axis].clone();
            edge
        });
        let [x, y, z] = low;
        let frame = Frame { corner: [x, y, z, Dyadic::new(1.0)], edges };
        let form = frame.quadratic(&layout.quadrics[0]);
        let approx = form.each_ref().map(|row| row.each_ref().map(Dyadic::to_approx));
        Self {
            frame,
            unit: layout.unit,
            exact: Problem { form, polytope: Polytope::new([], None) },
            approx: Problem { form: approx, polytope: Polytope::new([], None) },
        }
    }

    /// `bounds` moved inward to the quadric, which may be that ellipsoid.
    fn thinned(&self, bounds: Aabb, placement: &Placement, guess: &Ellipsoid) -> Aabb {
        if !self.holds_some() {
            return Aabb::EMPTY;
        }
        let mut thin = bounds;
        for axis in 0..3 {
            let row = placement.map().matrix3.row(axis);
            let plane = |x: f64| Plane { normal: row, offset: placement.map().translation[axis], at: x };
            let (min, max) = (bounds.min[axis], bounds.max[axis]);
            let [middle, half] = guess.reach(row);
            let [low, high] = [-half, half].map(|half| placement.map().translation[axis] + middle + half);
            thin.max[axis] = farthest([min, max], high, |x| self.reaches(&plane(x), 1.0));
            thin.min[axis] = farthest([thin.max[axis], min], low, |x| self.reaches(&plane(x), -1.0));
        }
        thin
    }

    /// Whether a point of the quadric lies in the box.
    pub(super) fn holds_some(&self) -> bool {
        reaches_zero(&self.approx, || self.exact.clone())
    }

    /// Whether the quadric has a point on the plane or beyond it, upward if `sign` is 1, downward if it is −1.
    pub(super) fn reaches(&self, plane: &Plane, sign: f64) -> bool {
        let height = self.frame.linear(&plane.local_form(self.unit, sign));
        let approx = self.approx.form_above(height.each_ref().map(Dyadic::to_approx));
        reaches_zero(&approx, || self.exact.form_above(height))
    }
}

impl<T: Decide> Problem<T> {
    /// The same form on the cube cut by one plane.
    fn form_above(&self, height: Linear<T>) -> Self {
        Self { form: self.form.clone(), polytope: Polytope::new([height], None) }
    }
}

/// The plane across a world axis at a coordinate, by the row of the placement that gives this coordinate.
pub(super) struct Plane {
    pub(super) normal: DVec3,
    pub(super) offset: f64,
    pub(super) at: f64,
}

impl Plane {
    /// The height above the plane times `sign`, a form in local coordinates.
    fn local_form(&self, unit: f64, sign: f64) -> Linear<Dyadic> {
        let scale = Dyadic::new(sign * unit);
        let [x, y, z] = self.normal.to_array().map(|factor| Dyadic::new(factor) * scale.clone());
        [x, y, z, (Dyadic::new(self.offset) - Dyadic::new(self.at)) * Dyadic::new(sign)]
    }
}

/// A quadric as an ellipsoid, in floats; where it is not one, of no meaning.
pub(super) struct Ellipsoid {
    pub(super) center: DVec3,
    /// n·x reaches from that of the center as far as √(n·spread·n).
    spread: DMat3,
}

impl Ellipsoid {
    pub(super) fn of(matrix: &[[f64; 4]; 4]) -> Self {
        let entry = |i: usize, j: usize| 0.5 * matrix[i][j] + 0.5 * matrix[j][i];
        let column = |j: usize| DVec3::new(entry(0, j), entry(1, j), entry(2, j));
        let inverse = DMat3::from_cols(column(0), column(1), column(2)).inverse();
        let center = -(inverse * column(3));
        Self { center, spread: inverse * -(entry(3, 3) + column(3).dot(center)) }
    }

    /// The middle of n·x, and how far it reaches to both sides.
    pub(super) fn reach(&self, n: DVec3) -> [f64; 2] {
        [n.dot(self.center), n.dot(self.spread * n).sqrt()]
    }
}

/// A number beyond all those that are reached, near the last of them: between `outer`, which is not passed, and `inner`. The same whatever is guessed.
fn farthest([inner, outer]: [f64; 2], guess: f64, is_reached: impl Fn(f64) -> bool) -> f64 {
    let is_before = |x: f64| if inner < outer { x <= guess } else { x >= guess };
    // What has no guess may end at its box.
    let guessed = halved([inner, outer], TRUSTED, |x| guess.is_nan() || is_before(x));
    let [reached, beyond] = guessed;
    let is_right = (reached == inner || is_reached(reached)) && (beyond == outer || !is_reached(beyond));
    let (range, rest) = if is_right { (guessed, HALVINGS - TRUSTED) } else { ([inner, outer], HALVINGS) };
    halved(range, rest, is_reached)[1]
}

/// The last number that was reached, and the last that was not, after so many halvings.
fn halved([mut reached, mut beyond]: [f64; 2], times: usize, is_reached: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..times {
        let middle = reached * 0.5 + beyond * 0.5;
        *(if is_reached(middle) { &mut reached } else { &mut beyond }) = middle;
    }
    [reached, beyond]
}

#[cfg(test)]
mod tests;
