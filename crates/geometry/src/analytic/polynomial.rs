//! Polynomials of degree two along a segment, and the signs of such polynomials at each other's roots.
//!
//! A root is kept as (p + q·√d)/e and never computed: the sign of another polynomial there is the sign of α + β·√d, which
//! needs sums, products and signs only. So one code serves the filter ([`crate::Approx`], where a sign may be unknown) and exact
//! numbers.

use crate::{approx::Approx, decide::Decide, dyadic::Dyadic, ring::Sign};

/// Which way a segment goes on: to a point light at s = 1, or for ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// 0 < s < 1.
    ToPoint,
    /// 0 < s.
    ToSun,
}

/// constant + linear·s + quadratic·s².
#[derive(Clone, Debug)]
pub(crate) struct Polynomial<T> {
    pub(crate) constant: T,
    pub(crate) linear: T,
    pub(crate) quadratic: T,
}

/// The number (p + q·√d)/e, d ≥ 0, e > 0: where a line meets a surface of degree one or two.
#[derive(Clone, Debug)]
pub struct Root<T> {
    p: T,
    q: T,
    d: T,
    e: T,
}

impl<T: Decide> Root<T> {
    fn rational(p: T, e: T) -> Self {
        Self { p, q: T::number(0.0), d: T::number(0.0), e }
    }

    /// A quotient; `None` where the divisor is zero, or its sign is not known.
    pub fn quotient(dividend: T, divisor: T) -> Option<Self> {
        match divisor.decide()? {
            Sign::Zero => None,
            Sign::Positive => Some(Self::rational(dividend, divisor)),
            Sign::Negative => Some(Self::rational(-dividend, -divisor)),
        }
    }

    /// The sign of the number, if it is known.
    pub fn sign(&self) -> Option<Sign> {
        T::decide_with_root(self.p.clone(), self.q.clone(), self.d.clone())
    }

    /// The sign of this number less another one, if it is known.
    pub fn sign_of_difference(&self, other: &Self) -> Option<Sign> {
        let alpha = self.p.clone() * other.e.clone() - other.p.clone() * self.e.clone();
        let (beta, gamma) = (self.q.clone() * other.e.clone(), -(other.q.clone() * self.e.clone()));
        T::decide_with_roots(alpha, [beta, self.d.clone()], [gamma, other.d.clone()])
    }

    /// The number in floats, by the nearest floats to its parts: rounded, for pictures.
    pub fn rounded(&self, to_float: impl Fn(&T) -> f64) -> f64 {
        let [p, q, d, e] = [&self.p, &self.q, &self.d, &self.e].map(to_float);
        (p + q * d.max(0.0).sqrt()) / e
    }

    /// The number over other numbers.
    pub(crate) fn map<V>(&self, convert: impl Fn(&T) -> V) -> Root<V> {
        Root { p: convert(&self.p), q: convert(&self.q), d: convert(&self.d), e: convert(&self.e) }
    }

    /// Whether it lies strictly on the way.
    fn is_on(&self, way: Way) -> Option<bool> {
        let after = T::decide_with_root(self.p.clone(), self.q.clone(), self.d.clone())? == Sign::Positive;
        if !after || way == Way::ToSun {
            return Some(after);
        }
        let rest = T::decide_with_root(self.e.clone() - self.p.clone(), -self.q.clone(), self.d.clone())?;
        Some(rest == Sign::Positive)
    }
}

impl Root<Approx> {
    /// The number itself, with its bound.
    pub fn value(&self) -> Approx {
        (self.p + self.q * self.d.square_root()).divided_by(self.e)
    }
}

impl Root<Dyadic> {
    /// The number by floats with bounds.
    pub fn to_approx(&self) -> Root<Approx> {
        self.map(Dyadic::to_approx)
    }
}

impl<T: Decide> Polynomial<T> {
    /// The polynomial with the other sign.
    pub(crate) fn negated(self) -> Self {
        Self { constant: -self.constant, linear: -self.linear, quadratic: -self.quadratic }
    }

    /// The sign at a root, if it is known.
    pub(crate) fn sign_at(&self, root: &Root<T>) -> Option<Sign> {
        let Root { p, q, d, e } = root.clone();
        let (c, b, a) = (self.constant.clone(), self.linear.clone(), self.quadratic.clone());
        // e²·value = a·(p² + q²·d) + b·p·e + c·e² + (2·a·p·q + b·q·e)·√d.
        let ap = a.clone() * p.clone();
        let alpha = ap.clone() * p.clone()
            + a * q.clone() * q.clone() * d.clone()
            + (b.clone() * p + c * e.clone()) * e.clone();
        T::decide_with_root(alpha, (ap.clone() + ap + b * e) * q, d)
    }

    /// The sign at a point that lies on the way: the middle, or one step towards a sun.
    fn sign_on(&self, way: Way) -> Option<Sign> {
        let twice = |value: &T| value.clone() + value.clone();
        match way {
            Way::ToSun => (self.constant.clone() + self.linear.clone() + self.quadratic.clone()).decide(),
            Way::ToPoint => (twice(&(twice(&self.constant) + self.linear.clone())) + self.quadratic.clone()).decide(),
        }
    }

    /// The roots other than zero; `None` where signs are not known, or where every number is a root.
    pub(crate) fn roots(&self) -> Option<Vec<Root<T>>> {
        let (c, b, a) = (&self.constant, &self.linear, &self.quadratic);
        let turned = |value: T, sign: Sign| if sign == Sign::Negative { -value } else { value };
        let starts_at_zero = c.decide() == Some(Sign::Zero);
        match (a.decide()?, starts_at_zero) {
            (Sign::Zero, starts_at_zero) => match b.decide()? {
                Sign::Zero if starts_at_zero => None,
                Sign::Zero => (c.decide()? != Sign::Zero).then(Vec::new),
                sign => Some(vec![Root::rational(turned(-c.clone(), sign), turned(b.clone(), sign))]),
            },
            // The root at zero is divided out.
            (sign, true) => Some(vec![Root::rational(turned(-b.clone(), sign), turned(a.clone(), sign))]),
            (sign, false) => {
                let twice = a.clone() + a.clone();
                let discriminant = b.clone() * b.clone() - (twice.clone() + twice.clone()) * c.clone();
                let (p, e) = (turned(-b.clone(), sign), turned(twice, sign));
                let root = |q: f64| Root { p: p.clone(), q: T::number(q), d: discriminant.clone(), e: e.clone() };
                Some(match discriminant.decide()? {
                    Sign::Negative => Vec::new(),
                    Sign::Zero => vec![Root::rational(p, e)],
                    Sign::Positive => vec![root(-1.0), root(1.0)],
                })
            }
        }
    }

    /// Whether every number is a root; `None` where it is not known.
    pub(crate) fn vanishes(&self) -> Option<bool> {
        let signs = [&self.quadratic, &self.linear, &self.constant].map(T::decide);
        if signs.iter().any(|&sign| sign.is_some_and(|sign| sign != Sign::Zero)) {
            return Some(false);
        }
        signs.iter().all(Option::is_some).then_some(true)
    }
}

/// Whether the surface, zero of `surface`, is met strictly on the way where all `trims` are ≥ 0: at another place than
/// s = 0. `None` where signs are not known.
pub(crate) fn is_met<T: Decide>(surface: &Polynomial<T>, trims: &[Polynomial<T>], way: Way) -> Option<bool> {
    if surface.vanishes()? {
        return runs_inside(trims, way);
    }
    any_known(surface.roots()?.iter().map(|root| all_known(conditions_at(root, trims, way))))
}

/// Whether some point strictly on the way fulfils all trims; the way lies in the surface.
fn runs_inside<T: Decide>(trims: &[Polynomial<T>], way: Way) -> Option<bool> {
    // A set of such points without a root of any trim on the way is the whole way, or nothing.
    let whole = all_known(trims.iter().map(|trim| Some(trim.sign_on(way)? != Sign::Negative)));
    let ends = trims.iter().map(|trim| {
        if trim.vanishes()? {
            return Some(false);
        }
        any_known(trim.roots()?.iter().map(|root| all_known(conditions_at(root, trims, way))))
    });
    any_known(std::iter::once(whole).chain(ends))
}

fn conditions_at<'a, T: Decide>(
    root: &'a Root<T>,
    trims: &'a [Polynomial<T>],
    way: Way,
) -> impl Iterator<Item = Option<bool>> + 'a {
    let inside = trims.iter().map(|trim| Some(trim.sign_at(root)? != Sign::Negative));
    std::iter::once_with(move || root.is_on(way)).chain(inside)
}

/// Whether any is true: known when one is known to be, or all are known.
pub(crate) fn any_known(conditions: impl Iterator<Item = Option<bool>>) -> Option<bool> {
    let mut answer = Some(false);
    for condition in conditions {
        match condition {
            Some(true) => return Some(true),
            Some(false) => {}
            None => answer = None,
        }
    }
    answer
}

/// Whether all are true: known when one is known not to be, or all are known.
pub(crate) fn all_known(conditions: impl Iterator<Item = Option<bool>>) -> Option<bool> {
    any_known(conditions.map(|condition| condition.map(|value| !value))).map(|value| !value)
}
