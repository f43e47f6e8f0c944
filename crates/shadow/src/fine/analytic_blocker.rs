//! An analytic body as an occluder of one receiver, by the values of its forms alone.
//!
//! A body is a union of pieces {q ≤ 0, planes ≥ 0}. A point on the way from x to the light L, y = α·x + β·L with α, β > 0, has
//! q(y, y) = α²·q(x, x) + 2·α·β·q(x, L) + β²·q(L, L): all that is needed are q and the planes at the receiver's corners,
//! at pairs of them, and at L. Where α is one number and β affine in x, a form at y is a form at x, and over the hull of
//! points it stays within its values at pairs of those points (Bernstein coefficients).
//!
//! *Covered*: x is blocked where such a y lies in the piece: taken on one of the planes, or on the polar plane of L, which holds
//! the outline. These sections together block every line that meets the piece at all (NUMERICS.md, "Analytic bodies as
//! occluders"). *Missed*: no section is met, and x is not inside; or q > 0 all along the part of the way between two
//! planes.

use std::ops::Range;

use umbriel_geometry::{
    Approx, PlacedAnalytic, Sign,
    analytic::{LocalPoint, Piece, linear_value},
};

use super::{field::Weights, light_values::LightValues, passing::passes, receiver::Receiver};
use crate::effort::{BODY, UNDERFLOWING};

type Pairs<const N: usize> = [[Approx; N]; N];

/// How a body stands to all points of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Influence {
    /// It blocks none.
    None,
    /// It blocks all.
    All,
    /// Neither is proved.
    Unknown,
}

/// A quadric at N points and the light.
#[derive(Clone, Copy, Debug)]
struct QuadricValues<const N: usize> {
    pairs: Pairs<N>,
    /// q(x, L).
    polar: [Approx; N],
    /// q(L, L).
    light: Approx,
}

/// A plane at N points and the light.
#[derive(Clone, Copy, Debug)]
struct PlaneValues<const N: usize> {
    points: [Approx; N],
    light: Approx,
}

/// All forms of a body at N points and the light.
#[derive(Clone, Debug)]
struct Values<const N: usize> {
    quadrics: Vec<QuadricValues<N>>,
    planes: Vec<PlaneValues<N>>,
}

/// A point y = α·x + β(x)·L on the way to the light, for each of N points x.
struct Section<const N: usize> {
    alpha: Approx,
    beta: [Approx; N],
    /// The plane that it lies on.
    plane: Option<usize>,
}

/// A body as an occluder of one receiver with N corners.
pub(crate) struct AnalyticBlocker<'a, const N: usize> {
    pub(crate) object: u32,
    body: &'a PlacedAnalytic,
    light: &'a LightValues,
    values: Values<N>,
}

impl<'a, const N: usize> AnalyticBlocker<'a, N> {
    /// The forms at the receiver's corners.
    pub(crate) fn new(object: u32, body: &'a PlacedAnalytic, light: &'a LightValues, receiver: &Receiver<N>) -> Self {
        let forms = body.forms();
        let at: [LocalPoint<Approx>; N] = each(&receiver.points, |point| forms.pull_back_point(point));
        let quadrics = forms.quadrics().iter().zip(&light.quadrics).map(|(form, &at_light)| {
            let polars: [LocalPoint<Approx>; N] = each(&at, |point| form.polar(point));
            QuadricValues {
                pairs: symmetric(|k, l| linear_value(&polars[k], &at[l])),
                polar: each(&polars, |polar| linear_value(polar, &light.local)),
                light: at_light,
            }
        });
        let planes = (0..forms.planes().len()).map(|plane| {
            let values = each(&at, |point| forms.plane(plane, point));
            // A receiver that lies in a plane of the body: its form is zero all over it.
            let may_touch = || !values.iter().any(|&value| positive(value) || negative(value));
            let in_contact =
                receiver.plane.as_ref().is_some_and(|points| may_touch() && body.plane_holds(plane, points));
            let points = if in_contact { [Approx::exact(0.0); N] } else { values };
            PlaneValues { points, light: light.planes[plane] }
        });
        let values = Values { quadrics: quadrics.collect(), planes: planes.collect() };
        Self { object, body, light, values }
    }

    /// What it costs to hold it against a cell.
    pub(crate) fn cost(&self) -> u64 {
        if self.body.forms().underflow() { BODY * UNDERFLOWING } else { BODY }
    }

    /// What is proved of the hull of `corners`.
    pub(crate) fn influence(&self, corners: &[Weights<N>]) -> Influence {
        let is_whole = corners.len() == N && (0..N).all(|k| corners[k][k] == 1.0);
        if is_whole { self.judge(&self.values) } else { self.judge::<N>(&self.values.at(corners, 0.0)) }
    }

    /// Whether the body blocks the point with these weights, each off by two units roundoff of one at most; `None` where
    /// the bounds cannot tell.
    pub(crate) fn blocks(&self, weights: &Weights<N>) -> Option<bool> {
        match self.judge::<1>(&self.values.at(&[*weights], 8.0 * f64::EPSILON)) {
            Influence::None => Some(false),
            Influence::All => Some(true),
            Influence::Unknown => None,
        }
    }

    /// The likely answer, for estimates.
    pub(crate) fn probably_blocks(&self, weights: &Weights<N>) -> bool {
        let mut values: Values<1> = self.values.at(&[*weights], 0.0);
        values.forget_errors();
        self.probably_block(&values)
    }

    /// The same by the values at a point, without errors.
    fn probably_block(&self, values: &Values<1>) -> bool {
        let is_passed = |piece: &Piece| {
            let q = &values.quadrics[piece.quadric];
            let quadric = [q.pairs[0][0], q.polar[0], q.light].map(|value| value.value);
            let plane =
                |&plane: &usize| [values.planes[plane].points[0], values.planes[plane].light].map(|value| value.value);
            passes(quadric, piece.planes.iter().map(plane), piece.flat.as_ref().map(plane))
        };
        match self.judge(values) {
            Influence::None => false,
            Influence::All => true,
            Influence::Unknown => self.body.pieces().iter().any(is_passed),
        }
    }

    /// What the values at some points prove of their hull.
    fn judge<const M: usize>(&self, values: &Values<M>) -> Influence {
        let pieces = self.body.pieces();
        match self.light.side {
            Sign::Positive => self.judge_outside(values),
            Sign::Negative if self.holds(values) => Influence::None,
            Sign::Negative if pieces.iter().all(|piece| values.lies_outside(piece)) => Influence::All,
            Sign::Negative => Influence::Unknown,
            Sign::Zero => match self.judge_contact(values) {
                (true, _) => Influence::None,
                (_, true) => Influence::All,
                _ => Influence::Unknown,
            },
        }
    }

    /// The same with the light outside. The shadow of a convex body is convex, so its corners decide whether it covers; and where one of them is
    /// blocked, nobody need ask any more whether none is.
    fn judge_outside<const M: usize>(&self, values: &Values<M>) -> Influence {
        let misses = || self.body.pieces().iter().all(|piece| values.misses(piece));
        if self.body.body().is_convex() {
            let blocked = (0..M).filter(|&k| self.blocks_corner(values, k)).count();
            match blocked {
                _ if blocked == M => Influence::All,
                0 if misses() => Influence::None,
                _ => Influence::Unknown,
            }
        } else if misses() {
            Influence::None
        } else if self.covers(values) {
            Influence::All
        } else {
            Influence::Unknown
        }
    }

    /// Whether no point is blocked, and whether all are, with the light on the surface.
    fn judge_contact<const M: usize>(&self, values: &Values<M>) -> (bool, bool) {
        let (pieces, is_convex, light) = (self.body.pieces(), self.body.body().is_convex(), self.light);
        let is_missed = |piece: &Piece| {
            if light.is_outside(piece) { values.misses(piece) } else { values.leaves_outwards(piece, light, is_convex) }
        };
        let all_outside = || pieces.iter().all(|piece| values.lies_outside(piece));
        let all_inside = || is_convex && self.holds(values);
        let ends_inside = || pieces.iter().any(|piece| values.ends_inside(piece, light));
        // From a point of a convex body a way that ends in its inside meets its border nowhere else.
        let is_missed = pieces.iter().all(is_missed) || all_inside() && ends_inside();
        (is_missed, all_outside() && ends_inside())
    }

    /// Whether point k is blocked, with the light outside.
    fn blocks_corner<const M: usize>(&self, values: &Values<M>, k: usize) -> bool {
        self.body.pieces().iter().any(|piece| {
            let mut sections = values.sections(piece, k..k + 1);
            values.enters(piece, [k, k]) || sections.any(|section| values.is_section_met(piece, &section, [k, k]))
        })
    }

    /// Whether one piece of any body blocks all points, with the light outside.
    fn covers<const M: usize>(&self, values: &Values<M>) -> bool {
        self.body.pieces().iter().any(|piece| {
            let mut sections = values.sections(piece, 0..M);
            over_pairs::<M>(|pair| values.enters(piece, pair))
                || sections.any(|section| over_pairs::<M>(|pair| values.is_section_met(piece, &section, pair)))
        })
    }

    /// Whether all points lie in the body, with the light strictly inside, and the ways between them do not leave it.
    fn holds<const M: usize>(&self, values: &Values<M>) -> bool {
        let pieces = self.body.pieces();
        if self.body.body().is_convex() {
            (0..M).all(|k| pieces.iter().any(|piece| values.is_inside(piece, [k, k])))
        } else {
            pieces.iter().any(|piece| {
                let q = &values.quadrics[piece.quadric];
                over_pairs::<M>(|pair| values.is_inside(piece, pair))
                    && q.polar.iter().all(|&value| negative(value))
                    && negative(q.light)
                    && piece.planes.iter().all(|&plane| positive(values.planes[plane].light))
            })
        }
    }
}

impl AnalyticBlocker<'_, 1> {
    /// The likely answer for the point that the body was measured against.
    pub(crate) fn probably_blocks_point(mut self) -> bool {
        self.values.forget_errors();
        self.probably_block(&self.values)
    }
}

impl<const N: usize> Values<N> {
    /// Whether x lies in a piece: q ≤ 0 at the pair, planes ≥ 0 at its points.
    fn is_inside(&self, piece: &Piece, [k, l]: [usize; 2]) -> bool {
        not_positive(self.quadrics[piece.quadric].pairs[k][l])
            && piece.planes.iter().all(|&plane| not_negative(self.planes[plane].points[k]))
    }

    /// Whether x lies in a piece, off the quadric, and moves into it where it lies on a plane.
    fn enters(&self, piece: &Piece, [k, l]: [usize; 2]) -> bool {
        let moves_in = |plane: &PlaneValues<N>| {
            positive(plane.points[k]) || (not_negative(plane.points[k]) && positive(plane.light))
        };
        piece.flat.is_none()
            && negative(self.quadrics[piece.quadric].pairs[k][l])
            && piece.planes.iter().all(|&plane| moves_in(&self.planes[plane]))
    }

    /// Whether the ways run inside a piece just before they end at the light on its border: a point outside is blocked then.
    fn ends_inside(&self, piece: &Piece, light: &LightValues) -> bool {
        let q = &self.quadrics[piece.quadric];
        let in_quadric = match light.quadric(piece.quadric) {
            Sign::Negative => true,
            // From a tip the quadric grows with the square of the distance, along all ways.
            Sign::Zero if light.is_tip(piece.quadric) => over_pairs::<N>(|[k, l]| negative(q.pairs[k][l])),
            Sign::Zero => q.polar.iter().all(|&value| negative(value)),
            Sign::Positive => false,
        };
        let in_plane = |plane: usize| match light.plane(plane) {
            Sign::Positive => true,
            Sign::Zero => self.planes[plane].points.iter().all(|&value| positive(value)),
            Sign::Negative => false,
        };
        piece.flat.is_none() && in_quadric && piece.planes.iter().all(|&plane| in_plane(plane))
    }

    /// Whether a plane that touches a piece in the light, on its border, has the piece on its one closed side and all points strictly on the
    /// other one; or, where the light is a tip, no way to it runs in the quadric.
    fn leaves_outwards(&self, piece: &Piece, light: &LightValues, is_convex: bool) -> bool {
        let touches = |plane: usize| light.plane(plane) == Sign::Zero;
        let all_below = |plane: usize| self.planes[plane].points.iter().all(|&value| negative(value));
        let all_above = |plane: usize| self.planes[plane].points.iter().all(|&value| positive(value));
        let is_beside_tip = || {
            let pairs = &self.quadrics[piece.quadric].pairs;
            light.is_tip(piece.quadric) && over_pairs::<N>(|[k, l]| positive(pairs[k][l]))
        };
        piece.planes.iter().any(|&plane| touches(plane) && all_below(plane))
            || is_beside_tip()
            || piece.flat.is_some_and(|plane| touches(plane) && (all_below(plane) || all_above(plane)))
            || is_convex
                && light.quadric(piece.quadric) == Sign::Zero
                && self.quadrics[piece.quadric].polar.iter().all(|&value| positive(value))
    }

    /// Whether all points lie strictly outside a piece.
    fn lies_outside(&self, piece: &Piece) -> bool {
        let beyond = |plane: usize| self.planes[plane].points.iter().all(|&value| negative(value));
        over_pairs::<N>(|[k, l]| positive(self.quadrics[piece.quadric].pairs[k][l]))
            || piece.planes.iter().any(|&plane| beyond(plane))
    }

    /// The sections of a piece that lie strictly between some of the points and the light.
    fn sections<'a>(&'a self, piece: &'a Piece, points: Range<usize>) -> impl Iterator<Item = Section<N>> + 'a {
        let outline = if piece.flat.is_none() { self.outline(piece.quadric, points.clone()) } else { None };
        let planes = piece.planes.iter().chain(&piece.flat);
        planes.filter_map(move |&plane| self.on_plane(plane, points.clone())).chain(outline)
    }

    /// Where the ways cross a plane; `None` unless those of the chosen points do, strictly between their ends.
    fn on_plane(&self, plane: usize, chosen: Range<usize>) -> Option<Section<N>> {
        let PlaneValues { points, light } = &self.planes[plane];
        if positive(*light) && points[chosen.clone()].iter().all(|&value| negative(value)) {
            Some(Section { alpha: *light, beta: points.map(|value| -value), plane: Some(plane) })
        } else if negative(*light) && points[chosen].iter().all(|&value| positive(value)) {
            Some(Section { alpha: -*light, beta: *points, plane: Some(plane) })
        } else {
            None
        }
    }

    /// Where the ways cross the polar plane of the light; `None` unless those of the chosen points do, strictly between
    /// their ends.
    fn outline(&self, quadric: usize, chosen: Range<usize>) -> Option<Section<N>> {
        let QuadricValues { polar, light, .. } = &self.quadrics[quadric];
        let is_between = positive(*light) && polar[chosen].iter().all(|&value| negative(value));
        is_between.then(|| Section { alpha: *light, beta: polar.map(|value| -value), plane: None })
    }

    /// q at a pair of points of two sections.
    fn quadric_at(&self, quadric: usize, (a, k): (&Section<N>, usize), (b, l): (&Section<N>, usize)) -> Approx {
        let QuadricValues { pairs, polar, light } = &self.quadrics[quadric];
        a.alpha * b.alpha * pairs[k][l]
            + a.alpha * b.beta[l] * polar[k]
            + b.alpha * a.beta[k] * polar[l]
            + a.beta[k] * b.beta[l] * *light
    }

    /// A plane at a point of a section.
    fn plane_at(&self, plane: usize, section: &Section<N>, k: usize) -> Approx {
        let values = &self.planes[plane];
        section.alpha * values.points[k] + section.beta[k] * values.light
    }

    /// Whether the section's points at a pair lie in the piece.
    fn is_section_met(&self, piece: &Piece, section: &Section<N>, [k, l]: [usize; 2]) -> bool {
        let mut others = piece.planes.iter().filter(|&&plane| section.plane != Some(plane));
        not_positive(self.quadric_at(piece.quadric, (section, k), (section, l)))
            && others.all(|&plane| not_negative(self.plane_at(plane, section, k)))
    }

    /// Whether all of the section's points lie strictly outside the piece.
    fn is_section_missed(&self, piece: &Piece, section: &Section<N>) -> bool {
        let mut others = piece.planes.iter().filter(|&&plane| section.plane != Some(plane));
        over_pairs::<N>(|[k, l]| positive(self.quadric_at(piece.quadric, (section, k), (section, l))))
            || others.any(|&plane| (0..N).all(|k| negative(self.plane_at(plane, section, k))))
    }

    /// Whether no way to the light meets a piece, with the light strictly outside of it.
    fn misses(&self, piece: &Piece) -> bool {
        piece.planes.iter().any(|&plane| self.stays_below(plane))
            || self.is_positive_between_planes(piece)
            || self.misses_all_sections(piece)
    }

    /// Whether a plane's form is negative on all open ways.
    fn stays_below(&self, plane: usize) -> bool {
        let PlaneValues { points, light } = &self.planes[plane];
        points.iter().all(|&value| not_positive(value)) && negative(*light)
            || points.iter().all(|&value| negative(value)) && not_positive(*light)
    }

    fn stays_above(&self, plane: usize) -> bool {
        let PlaneValues { points, light } = &self.planes[plane];
        points.iter().all(|&value| not_negative(value)) && positive(*light)
            || points.iter().all(|&value| positive(value)) && not_negative(*light)
    }

    /// Whether q > 0 from where the ways enter past some plane (or their start) to where they leave (or the light).
    fn is_positive_between_planes(&self, piece: &Piece) -> bool {
        let crossings: Vec<Section<N>> = piece.planes.iter().filter_map(|&plane| self.on_plane(plane, 0..N)).collect();
        let is_entry = |section: &&Section<N>| section.plane.is_some_and(|plane| positive(self.planes[plane].light));
        let (zero, one) = (Approx::exact(0.0), Approx::exact(1.0));
        let start = Section { alpha: one, beta: [zero; N], plane: None };
        let end = Section { alpha: zero, beta: [one; N], plane: None };
        let starts = || std::iter::once(&start).chain(crossings.iter().filter(is_entry));
        let mut ends = std::iter::once(&end).chain(crossings.iter().filter(|section| !is_entry(section)));
        let at = |a: &Section<N>, b: &Section<N>, [k, l]: [usize; 2]| self.quadric_at(piece.quadric, (a, k), (b, l));
        let is_above = |from: &Section<N>, to: &Section<N>| {
            over_pairs::<N>(|pair| positive(at(from, from, pair)))
                // The light is no point of the way; where the ways leave past a plane they may touch.
                && over_pairs::<N>(|pair| match to.plane {
                    Some(_) => positive(at(to, to, pair)),
                    None => not_negative(at(to, to, pair)),
                })
                && over_pairs::<N>(|[k, l]| not_negative(at(from, to, [k, l]) + at(from, to, [l, k])))
        };
        piece.flat.is_none() && ends.any(|to| starts().any(|from| is_above(from, to)))
    }

    /// Whether the points are outside, no plane's section is met, and no way goes in and out through the quadric.
    fn misses_all_sections(&self, piece: &Piece) -> bool {
        let is_missed = |plane: usize| {
            self.stays_above(plane)
                || self.stays_below(plane)
                || self.on_plane(plane, 0..N).is_some_and(|section| self.is_section_missed(piece, &section))
        };
        if let Some(plane) = piece.flat {
            return is_missed(plane);
        }
        self.lies_outside(piece)
            && piece.planes.iter().all(|&plane| is_missed(plane))
            && self.misses_quadric_twice(piece)
    }

    /// Whether no way meets the quadric twice before the light within the piece: the polar plane would lie between.
    fn misses_quadric_twice(&self, piece: &Piece) -> bool {
        let QuadricValues { pairs, polar, light } = &self.quadrics[piece.quadric];
        not_positive(*light)
            || over_pairs::<N>(|[k, l]| negative(polar[k] * polar[l] - pairs[k][l] * *light))
            || positive(*light) && polar.iter().all(|&value| not_negative(value))
            || self.outline(piece.quadric, 0..N).is_some_and(|outline| self.is_section_missed(piece, &outline))
    }

    /// The values at M points with these weights (the first fills the rest); `weight_error` bounds the errors of the weights.
    fn at<const M: usize>(&self, corners: &[Weights<N>], weight_error: f64) -> Values<M> {
        let corner = |k: usize| corners.get(k).unwrap_or(&corners[0]);
        let widened = |value: Approx, spread: f64| Approx { error: value.error + spread * weight_error, ..value };
        let magnitude = |values: &[Approx; N]| values.iter().map(|value| value.value.abs()).sum::<f64>();
        let linear_at = |values: &[Approx; N], k: usize| widened(linear(values, corner(k)), magnitude(values));
        let quadrics = self.quadrics.iter().map(|values| {
            let spread = if weight_error > 0.0 { values.pairs.iter().map(magnitude).sum() } else { 0.0 };
            let half: [[Approx; N]; M] =
                std::array::from_fn(|k| std::array::from_fn(|row| linear(&values.pairs[row], corner(k))));
            QuadricValues {
                pairs: symmetric(|k, l| widened(linear(&half[k], corner(l)), spread)),
                polar: std::array::from_fn(|k| linear_at(&values.polar, k)),
                light: values.light,
            }
        });
        let planes = self.planes.iter().map(|values| PlaneValues {
            points: std::array::from_fn(|k| linear_at(&values.points, k)),
            light: values.light,
        });
        Values { quadrics: quadrics.collect(), planes: planes.collect() }
    }

    fn forget_errors(&mut self) {
        let forget = |value: &mut Approx| value.error = 0.0;
        for values in &mut self.quadrics {
            values.pairs.iter_mut().flatten().chain(&mut values.polar).for_each(forget);
            forget(&mut values.light);
        }
        for values in &mut self.planes {
            values.points.iter_mut().for_each(forget);
            forget(&mut values.light);
        }
    }
}

fn positive(value: Approx) -> bool {
    value.value > value.error
}

fn negative(value: Approx) -> bool {
    -value.value > value.error
}

fn not_negative(value: Approx) -> bool {
    value.value >= value.error
}

fn not_positive(value: Approx) -> bool {
    -value.value >= value.error
}

/// A function of each of some things. Written out: arrays made by closures are not inlined.
fn each<T, U: Copy + Default, const N: usize>(things: &[T; N], function: impl Fn(&T) -> U) -> [U; N] {
    let mut values = [U::default(); N];
    for (value, thing) in values.iter_mut().zip(things) {
        *value = function(thing);
    }
    values
}

fn symmetric<const N: usize>(value: impl Fn(usize, usize) -> Approx) -> Pairs<N> {
    let mut pairs = [[Approx::exact(0.0); N]; N];
    for (k, l) in (0..N).flat_map(|k| (k..N).map(move |l| (k, l))) {
        pairs[k][l] = value(k, l);
        pairs[l][k] = pairs[k][l];
    }
    pairs
}

/// Whether `test` holds at all pairs of N points.
fn over_pairs<const N: usize>(test: impl Fn([usize; 2]) -> bool) -> bool {
    (0..N).all(|k| (k..N).all(|l| test([k, l])))
}

fn linear<const N: usize>(values: &[Approx; N], weights: &Weights<N>) -> Approx {
    values.iter().zip(weights).fold(Approx::exact(0.0), |sum, (&value, &weight)| {
        if weight == 0.0 { sum } else { sum + value * Approx::exact(weight) }
    })
}
