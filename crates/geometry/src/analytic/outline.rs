//! Outlines of surfaces of revolution: (radius, y) as v runs from 0 to 1.

use super::jet::Jet;
use crate::{approx::Approx, decide::Decide};

/// Below this asinh(z)/z is 1 − z²/6 to less than z⁴, which is less than a rounding.
const SMALL: f64 = 1.0 / (1 << 20) as f64;

/// A piece of an outline; lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outline {
    /// Straight: a disk, a cylinder, a cone.
    Line { from: [f64; 2], to: [f64; 2] },
    /// From the rim (radius, −height/2) to the apex (0, +height/2); the radius is linear in v.
    Parabola { radius: f64, height: f64 },
    /// From end to end through the waist; y is linear in v.
    Hyperbola { waist: f64, end: f64, height: f64 },
}

impl Outline {
    /// The point at v, rounded.
    pub(crate) fn at(&self, v: f64) -> [f64; 2] {
        match *self {
            Self::Line { from, to } => std::array::from_fn(|k| from[k] * (1.0 - v) + to[k] * v),
            Self::Parabola { radius, height } => {
                let inward = 1.0 - v;
                [radius * inward, height * (0.5 - inward * inward)]
            }
            Self::Hyperbola { waist, end, height } => {
                let along = 2.0 * v - 1.0;
                // waist²·(1 − s²) + end²·s²: no cancellation.
                let squared = waist * waist * (1.0 - along * along) + end * end * along * along;
                [squared.sqrt(), 0.5 * height * along]
            }
        }
    }

    /// The point at v, as exact as the numbers: the radius as factor·√(square), and y.
    pub(crate) fn exact_at<T: Decide>(&self, v: f64) -> (T, T, T) {
        let number = T::number;
        let one = || number(1.0);
        match *self {
            Self::Line { from, to } => {
                let [radius, y] = [0, 1].map(|k| number(from[k]) + number(v) * (number(to[k]) - number(from[k])));
                (radius, one(), y)
            }
            Self::Parabola { radius, height } => {
                let inward = one() - number(v);
                let y = number(height) * (number(0.5) - inward.clone() * inward.clone());
                (number(radius) * inward, one(), y)
            }
            Self::Hyperbola { waist, end, height } => {
                let along = number(v) + number(v) - one();
                let square = |value: f64| number(value) * number(value);
                let along_squared = along.clone() * along.clone();
                let squared = square(waist) + (square(end) - square(waist)) * along_squared;
                (one(), squared, number(0.5) * number(height) * along)
            }
        }
    }

    /// Four corners (radius, y) of a quadrilateral that holds all (f·radius(v), y(v)) for v in from..=to and f from 1 to
    /// `stretch`: two on the axis's side, two on the other.
    pub(crate) fn hull(&self, from: f64, to: f64, stretch: f64) -> [[f64; 2]; 4] {
        let ([a0, y0], [a1, y1]) = (self.at(from), self.at(to));
        match *self {
            Self::Line { .. } => [[a0, y0], [a1, y1], [a0 * stretch, y0], [a1 * stretch, y1]],
            Self::Parabola { height, .. } => {
                // The arc lies above its chord by at most σ = height·(to − from)²/4, with slope 4σ at the rim's end: a line
                // that starts there, stretched, and rises by 4σ more stays outside.
                let rise = height * (to - from) * (to - from);
                [[a0, y0], [a1, y1], [a0 * stretch, y0], [a1 * stretch, y1 + rise]]
            }
            Self::Hyperbola { waist, end, .. } => {
                // The radius is convex in y; its chord is above it by at most Δy²/8 times the greatest second derivative,
                // k·waist²/radius³ ≤ k/waist with k = 4·(end² − waist²)/height².
                let step = 2.0 * (to - from);
                let sag = (step * step * 0.125) * (end - waist) * (end + waist) / waist;
                let inner = |radius: f64| (radius - sag).max(0.0);
                [[inner(a0), y0], [inner(a1), y1], [a0 * stretch, y0], [a1 * stretch, y1]]
            }
        }
    }

    /// The radius A times the slope (A', B'), as a factor that may vanish and a vector that does not.
    pub(crate) fn slope<const K: usize>(&self, v: Jet<K>) -> (Jet<K>, [Jet<K>; 2]) {
        let bounded = Approx::exact;
        let number = |value: f64| Jet::<K>::constant(bounded(value));
        let difference = |a: f64, b: f64| bounded(a) - bounded(b);
        match *self {
            Self::Line { from, to } => {
                let steps = [0, 1].map(|k| difference(to[k], from[k]));
                (number(from[0]) + v.scaled(steps[0]), steps.map(Jet::constant))
            }
            Self::Parabola { radius, height } => {
                let inward = number(1.0) - v;
                (inward.scaled(bounded(radius)), [number(-radius), inward.scaled(bounded(2.0 * height))])
            }
            // A·A' is half the slope of A².
            Self::Hyperbola { waist, end, height } => {
                let along = v + v - number(1.0);
                let square = |value: f64| bounded(value) * bounded(value);
                let growth = square(end) - square(waist);
                let radius = (Jet::constant(square(waist)) + (along * along).scaled(growth)).square_root();
                (number(1.0), [along.scaled(growth + growth), radius.scaled(bounded(height))])
            }
        }
    }

    /// The area that the piece from one v to another sweeps, for each radian.
    pub(crate) fn turned_area(&self, from: f64, to: f64) -> Approx {
        match *self {
            Self::Line { from: start, to: end } => {
                let steps = [0, 1].map(|k| Approx::exact(end[k]) - Approx::exact(start[k]));
                let slant = (steps[0] * steps[0] + steps[1] * steps[1]).square_root();
                let (from, to) = (Approx::exact(from), Approx::exact(to));
                let mean_radius = Approx::exact(start[0]) + steps[0] * (from + to) * Approx::exact(0.5);
                mean_radius * slant * (to - from)
            }
            Self::Parabola { radius, height } => area_of_parabola(radius, height, [1.0 - to, 1.0 - from]),
            Self::Hyperbola { .. } if from < 0.5 && to > 0.5 => self.turned_area(from, 0.5) + self.turned_area(0.5, to),
            Self::Hyperbola { waist, end, height } => {
                let [from, to] = [from, to].map(|v| (2.0 * v - 1.0).abs());
                area_of_hyperbola(waist, end, height, [from.min(to), from.max(to)])
            }
        }
    }

    pub(crate) fn greatest_radius(&self) -> f64 {
        self.at(0.0)[0].max(self.at(1.0)[0])
    }

    /// Greatest distance from the plane y = 0.
    pub(crate) fn greatest_height(&self) -> f64 {
        self.at(0.0)[1].abs().max(self.at(1.0)[1].abs())
    }

    /// How far a step of one along v goes at most: along the radius, and along y.
    pub(crate) fn step(&self) -> [f64; 2] {
        match *self {
            Self::Line { from, to } => [(to[0] - from[0]).abs(), (to[1] - from[1]).abs()],
            Self::Parabola { radius, height } => [radius, 2.0 * height],
            Self::Hyperbola { waist, end, height } => [2.0 * (end - waist) * (end + waist) / end, height],
        }
    }
}

/// With the distances w from the apex and Q = r² + 4h²w², ∫ r·w·√Q dw is r/(12h²)·Q^(3/2), here without cancellation.
fn area_of_parabola(radius: f64, height: f64, [near, far]: [f64; 2]) -> Approx {
    let [near, far] = [near, far].map(Approx::exact);
    let (radius, twice_height) = (Approx::exact(radius), Approx::exact(2.0 * height));
    let square = |w: Approx| radius * radius + twice_height * twice_height * w * w;
    let (q, p) = (square(near), square(far));
    let (root_q, root_p) = (q.square_root(), p.square_root());
    let growth = (far - near) * (far + near) * (q + root_q * root_p + p);
    (radius * growth).divided_by(Approx::exact(3.0) * (root_q + root_p))
}

/// With the distances s from the waist, as shares of that of the ends, the height h, the waist's radius a and R = √(h²a² + k²s²), ½·∫ R ds is
/// ¼·(s·R + h²a²/k·asinh(k·s/(ha))), here without cancellation: asinh x − asinh y is asinh((x² − y²)/(x√(1 + y²) + y√(1 + x²))).
fn area_of_hyperbola(waist: f64, end: f64, height: f64, [near, far]: [f64; 2]) -> Approx {
    let [waist, end, height, near, far] = [waist, end, height, near, far].map(Approx::exact);
    let growth = (end - waist) * (end + waist);
    let (constant, k_squared) = ((height * waist).squared(), growth * (Approx::exact(4.0) * growth + height * height));
    let [root_near, root_far] = [near, far].map(|s| (constant + k_squared * s * s).square_root());
    let strip = (far - near) * (far + near);
    let straight = constant + k_squared * (near * near + far * far);
    let straight = straight.divided_by(far * root_far + near * root_near);
    let d = far * root_near + near * root_far;
    let bent = constant.divided_by(d) * inverse_sine_share(k_squared.square_root() * strip.divided_by(d));
    strip * (straight + bent) * Approx::exact(0.25)
}

/// asinh(z)/z of a number that is not negative.
fn inverse_sine_share(z: Approx) -> Approx {
    if z.upper() < SMALL {
        let share = Approx::exact(1.0) - z.squared().divided_by(Approx::exact(6.0));
        return Approx { error: share.error + f64::EPSILON, ..share };
    }
    // The slope is one at most, which is far too much for large z, where little hangs on it; a logarithm within eight roundings.
    let value = libm::asinh(z.value);
    Approx { value, error: (z.error + 4.0 * f64::EPSILON * value) * (1.0 + f64::EPSILON) }.divided_by(z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between the sums of the least and of the greatest of slices; and all the same in parts.
    #[test]
    fn turned_areas_are_between_their_slices() {
        let outlines = [
            Outline::Line { from: [0.7, -0.5], to: [0.25, 1.0] },
            Outline::Parabola { radius: 1.2, height: 0.8 },
            Outline::Hyperbola { waist: 0.3, end: 1.0, height: 2.5 },
            Outline::Hyperbola { waist: 1e-6, end: 1.0, height: 1.0 },
            Outline::Hyperbola { waist: 1.0, end: 1.0 + 1e-7, height: 0.75 },
            Outline::Hyperbola { waist: 0.5, end: 0.5, height: 0.75 },
            Outline::Hyperbola { waist: 0.5, end: 0.75, height: 1e-9 },
        ];
        for outline in outlines {
            for (from, to) in [(0.0, 1.0), (0.25, 0.5), (0.5, 0.75), (0.4375, 0.625), (0.875, 1.0)] {
                let slices = 512;
                let width = (to - from) / f64::from(slices);
                let of_slice = |k: i32| {
                    let middle = Approx { value: from + width * (f64::from(k) + 0.5), error: 0.5 * width };
                    let (factor, [along_radius, along_y]) = outline.slope(Jet::<1>::constant(middle));
                    ((along_radius.squared() + along_y.squared()).square_root() * factor).0[0]
                };
                let slices = (0..slices).map(of_slice).fold(Approx::exact(0.0), |sum, area| sum + area);
                let slices = slices * Approx::exact(width);
                let area = outline.turned_area(from, to);
                assert!((area.value - slices.value).abs() <= slices.error, "{outline:?} {area:?} {slices:?}");
                assert!(area.error <= 1e-11 * area.value, "{outline:?} {area:?}");
                let middle = from + 0.25 * (to - from);
                let parts = outline.turned_area(from, middle) + outline.turned_area(middle, to);
                assert!((area.value - parts.value).abs() <= area.error + parts.error, "{outline:?} {area:?} {parts:?}");
                let mirrored = outline.turned_area(1.0 - to, 1.0 - from);
                assert!(!matches!(outline, Outline::Hyperbola { .. }) || mirrored == area, "{outline:?}");
            }
        }
    }
}
