//! A placed sphere as an occluder of one receiver, by its quadratic form alone.
//!
//! With q the sphere's form (negative inside) and the light L, the line from x to L meets the sphere exactly when
//! G(x, x) ≥ 0 for G(x, y) = q(x, L)·q(y, L) − q(x, y)·q(L, L). A quadratic form over the convex hull of points stays
//! within its values at pairs of those points (its Bernstein coefficients), so signs at pairs of cell corners are signs
//! over the cell. The rules and why they hold: NUMERICS.md, "Spheres as occluders".

use umbriel_geometry::{Approx, LightSource, Point, Sign, SphereForm};

use super::field::Weights;

type Pairs<const N: usize> = [[Approx; N]; N];

/// How a sphere stands to all points of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Influence {
    /// It blocks none.
    None,
    /// It blocks all.
    All,
    /// Neither is proved.
    Unknown,
}

/// A sphere as an occluder of one receiver with N corners.
pub(crate) struct SphereBlocker<const N: usize> {
    pub(crate) object: u32,
    is_sun: bool,
    /// q(L, L): positive with the light outside.
    light: Approx,
    /// q(x, L): negative beyond the circle where light rays touch the sphere.
    polar: [Approx; N],
    /// q(x, y): positive outside.
    outside: Pairs<N>,
    /// Half the slope of q from x towards the light: positive when the sphere lies behind x.
    leaving: Pairs<N>,
    /// G(x, y): negative where the line to the light misses the sphere.
    shadow: Pairs<N>,
}

impl<const N: usize> SphereBlocker<N> {
    /// The forms at the receiver's corners.
    pub(crate) fn new(object: u32, form: &SphereForm<Approx>, points: &[Point; N], source: &LightSource) -> Self {
        let one = Approx::exact(1.0);
        let weight = Approx::exact(source.w());
        let local_light = form.pull_back(&source.xyz().to_array().map(Approx::exact), &weight);
        let local = points.map(|point| form.pull_back(&point.coordinates(), &one));
        let light = form.value((&local_light, &weight), (&local_light, &weight));
        let polar: [Approx; N] = std::array::from_fn(|k| form.value((&local[k], &one), (&local_light, &weight)));
        let outside = pairs(|k, l| form.value((&local[k], &one), (&local[l], &one)));
        let half = Approx::exact(0.5);
        let leaving = pairs(|k, l| (polar[k] + polar[l]) * half - weight * outside[k][l]);
        let shadow = pairs(|k, l| polar[k] * polar[l] - outside[k][l] * light);
        Self { object, is_sun: source.is_sun(), light, polar, outside, leaving, shadow }
    }

    /// What is proved of the hull of `corners`.
    pub(crate) fn influence(&self, corners: &[Weights<N>]) -> Influence {
        let light_side = self.light.sign();
        let all = |pairs: &Pairs<N>, test: fn(Approx) -> bool| over_pairs(pairs, corners, test);
        let single = |pairs: &Pairs<N>, test: fn(Approx) -> bool| {
            corners.iter().all(|corner| test(bilinear(pairs, corner, corner)))
        };
        if self.is_sun || light_side == Some(Sign::Positive) {
            let misses = all(&self.shadow, negative)
                || (all(&self.outside, not_negative) && all(&self.leaving, not_negative))
                || (!self.is_sun && corners.iter().all(|c| not_negative(linear(&self.polar, c) - self.light)));
            let beyond = || corners.iter().all(|corner| negative(linear(&self.polar, corner)));
            return if misses {
                Influence::None
            } else if (beyond() && single(&self.shadow, not_negative)) || single(&self.outside, negative) {
                Influence::All
            } else {
                Influence::Unknown
            };
        }
        if light_side != Some(Sign::Negative) {
            return Influence::Unknown;
        }
        if single(&self.outside, |value| value.upper() <= 0.0) {
            Influence::None
        } else if all(&self.outside, |value| value.lower() > 0.0) {
            Influence::All
        } else {
            Influence::Unknown
        }
    }

    /// Whether the sphere blocks the point with these (rounded) weights; `None` where the bounds cannot tell.
    pub(crate) fn blocks(&self, weights: &Weights<N>) -> Option<bool> {
        let spread = |value: Approx, terms: &mut dyn Iterator<Item = Approx>| {
            let magnitude: f64 = terms.map(|term| term.value.abs()).sum();
            Approx { value: value.value, error: value.error + magnitude * (8.0 * f64::EPSILON) }
        };
        let pair = |pairs: &Pairs<N>| spread(bilinear(pairs, weights, weights), &mut pairs.iter().flatten().copied());
        let polar = spread(linear(&self.polar, weights), &mut self.polar.iter().copied());
        let (outside, leaving) = (pair(&self.outside).sign()?, pair(&self.leaving).sign()?);
        let light_outside = self.is_sun || self.light.sign()? == Sign::Positive;
        Some(match (outside, light_outside) {
            (Sign::Zero, _) => return None,
            (Sign::Negative, light_outside) => light_outside,
            (Sign::Positive, false) => self.light.sign()? == Sign::Negative || return None,
            (Sign::Positive, true) => {
                leaving == Sign::Negative
                    && (self.is_sun || (polar - self.light).sign()? == Sign::Negative)
                    && pair(&self.shadow).sign()? != Sign::Negative
            }
        })
    }

    /// The likely answer, for estimates.
    pub(crate) fn probably_blocks(&self, weights: &Weights<N>) -> bool {
        let value = |pairs: &Pairs<N>| bilinear(pairs, weights, weights).value;
        let light_outside = self.is_sun || self.light.value > 0.0;
        if value(&self.outside) < 0.0 {
            return light_outside;
        }
        !light_outside
            || (value(&self.leaving) < 0.0
                && (self.is_sun || linear(&self.polar, weights).value < self.light.value)
                && value(&self.shadow) >= 0.0)
    }
}

fn negative(value: Approx) -> bool {
    value.upper() < 0.0
}

fn not_negative(value: Approx) -> bool {
    value.lower() >= 0.0
}

fn pairs<const N: usize>(value: impl Fn(usize, usize) -> Approx) -> Pairs<N> {
    std::array::from_fn(|k| std::array::from_fn(|l| value(k, l)))
}

/// Whether `test` holds at all pairs of corners.
fn over_pairs<const N: usize>(pairs: &Pairs<N>, corners: &[Weights<N>], test: fn(Approx) -> bool) -> bool {
    corners.iter().enumerate().all(|(i, a)| corners[i..].iter().all(|b| test(bilinear(pairs, a, b))))
}

fn linear<const N: usize>(values: &[Approx; N], weights: &Weights<N>) -> Approx {
    values.iter().zip(weights).fold(Approx::exact(0.0), |sum, (&value, &weight)| {
        if weight == 0.0 { sum } else { sum + value * Approx::exact(weight) }
    })
}

fn bilinear<const N: usize>(pairs: &Pairs<N>, a: &Weights<N>, b: &Weights<N>) -> Approx {
    pairs.iter().zip(a).fold(Approx::exact(0.0), |sum, (row, &weight)| {
        if weight == 0.0 { sum } else { sum + linear(row, b) * Approx::exact(weight) }
    })
}
