//! Sums that do not depend on the order of their terms.

use umbriel_geometry::Dyadic;

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
