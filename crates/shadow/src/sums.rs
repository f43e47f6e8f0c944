//! Sums that do not depend on the order of their terms.

use umbriel_geometry::{Approx, Dyadic};

/// The areas of some faces, square metres.
#[derive(Clone, Debug, Default)]
pub(crate) struct AreaSums {
    pub(crate) area: ExactSum,
    /// How far `area` may be off; of faces whose areas are bounded.
    pub(crate) slack: ExactSum,
    /// Whether the area of some face has no bound: its numbers left the range of floats.
    pub(crate) is_unbounded: bool,
    /// Proved lit, from below.
    pub(crate) lower: ExactSum,
    /// Not proved shadowed, from above.
    pub(crate) upper: ExactSum,
    /// Lit by the estimate.
    pub(crate) estimate: ExactSum,
}

impl AreaSums {
    /// Adds a face: its area, what is proved lit of it, what may be lit, what is lit by the estimate.
    pub(crate) fn add(&mut self, area: Approx, lit: Approx, possible: Approx, likely: Approx) {
        self.area.add(area.value);
        let is_bounded = area.error.is_finite();
        self.slack.add(if is_bounded { area.error } else { 0.0 });
        self.is_unbounded |= !is_bounded;
        self.lower.add(lit.lower().max(0.0));
        self.upper.add(possible.upper());
        self.estimate.add(likely.value);
    }

    /// How far the float nearest to the area may be off: what the faces may be, and half an ulp where it is rounded.
    pub(crate) fn area_error(&self) -> f64 {
        let slack = self.slack.rounded_up();
        if self.is_unbounded {
            f64::INFINITY
        } else if self.area.bounded().error > 0.0 {
            (slack + self.area.nearest() * f64::EPSILON).next_up()
        } else {
            slack
        }
    }

    /// Adds other faces.
    pub(crate) fn append(&mut self, other: Self) {
        self.area.append(other.area);
        self.slack.append(other.slack);
        self.is_unbounded |= other.is_unbounded;
        self.lower.append(other.lower);
        self.upper.append(other.upper);
        self.estimate.append(other.estimate);
    }
}

/// An exact sum of floats.
#[derive(Clone, Debug)]
pub(crate) struct ExactSum(Dyadic);

impl Default for ExactSum {
    fn default() -> Self {
        Self(Dyadic::zero())
    }
}

impl ExactSum {
    /// Adds a finite term.
    pub(crate) fn add(&mut self, term: f64) {
        let sum = std::mem::replace(&mut self.0, Dyadic::zero());
        self.0 = sum + Dyadic::new(term);
    }

    /// Adds another sum.
    pub(crate) fn append(&mut self, other: Self) {
        let sum = std::mem::replace(&mut self.0, Dyadic::zero());
        self.0 = sum + other.0;
    }

    /// Adds the exact product of a finite float and a whole number.
    pub(crate) fn add_product(&mut self, factor: f64, whole: u64) {
        let halves = [(whole >> 32) as f64 * 4_294_967_296.0, (whole & 0xffff_ffff) as f64];
        for half in halves {
            let sum = std::mem::replace(&mut self.0, Dyadic::zero());
            self.0 = sum + Dyadic::new(factor) * Dyadic::new(half);
        }
    }

    /// A float beside the sum, with a bound.
    pub(crate) fn bounded(&self) -> Approx {
        self.0.to_approx()
    }

    /// The float nearest to the sum.
    pub(crate) fn nearest(&self) -> f64 {
        self.0.to_nearest()
    }

    /// A float not above the sum; the sum itself where it is a float.
    pub(crate) fn rounded_down(&self) -> f64 {
        self.0.to_approx().lower()
    }

    /// A float not below the sum; the sum itself where it is a float.
    pub(crate) fn rounded_up(&self) -> f64 {
        self.0.to_approx().upper()
    }
}
