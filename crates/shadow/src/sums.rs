//! Sums that do not depend on the order of their terms.

use umbriel_geometry::{Approx, Dyadic};

use crate::report::LitArea;

/// Terms that are added side by side.
const LANES: usize = 8;

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
    /// Adds a face.
    pub(crate) fn add(&mut self, face: &FaceArea) {
        self.add_whole(face.area);
        self.lower.add(face.lit.lower);
        self.upper.add(face.lit.upper);
        self.estimate.add(face.lit.estimate);
    }

    /// Takes a face out that was added. Exact; what had no bound leaves none.
    pub(crate) fn remove(&mut self, face: &FaceArea) {
        self.add_whole(Approx { value: -face.area.value, error: -face.area.error });
        self.lower.add(-face.lit.lower);
        self.upper.add(-face.lit.upper);
        self.estimate.add(-face.lit.estimate);
    }

    /// Adds a face of which only the area is asked.
    #[inline(always)]
    pub(crate) fn add_whole(&mut self, area: Approx) {
        let is_bounded = area.error.is_finite();
        self.area.add(if area.value.is_finite() { area.value } else { 0.0 });
        self.slack.add(if is_bounded { area.error } else { 0.0 });
        self.is_unbounded |= !is_bounded;
    }

    /// Adds faces of which only the areas are asked, and how far these may be off.
    #[inline(always)]
    pub(crate) fn add_wholes(&mut self, areas: &[f64], errors: &[f64]) {
        let are_bounded = areas.iter().chain(errors).fold(true, |all, number| all & number.is_finite());
        if are_bounded {
            self.area.add_all(areas);
            self.slack.add_all(errors);
        } else {
            let faces = areas.iter().zip(errors);
            faces.for_each(|(&value, &error)| self.add_whole(Approx { value, error }));
        }
    }

    /// A float not below the area.
    pub(crate) fn whole(&self) -> f64 {
        let mut whole = self.area.clone();
        whole.append(self.slack.clone());
        if self.is_unbounded { f64::INFINITY } else { whole.rounded_up() }
    }

    /// The area as a float, and how far that may be off: what the faces may be, and half an ulp where it is rounded.
    pub(crate) fn area(&self) -> (f64, f64) {
        let (area, slack) = (self.area.nearest(), self.slack.rounded_up());
        let error = if self.is_unbounded {
            f64::INFINITY
        } else if self.area.bounded().error > 0.0 {
            (slack + area * f64::EPSILON).next_up()
        } else {
            slack
        };
        (area, error)
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

/// What is known of the area of one face, square metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceArea {
    pub(crate) area: Approx,
    pub(crate) lit: LitArea,
}

impl FaceArea {
    /// The area, what is proved lit of it, what may be lit, what is lit by the estimate.
    pub(crate) fn new(area: Approx, lit: Approx, possible: Approx, likely: Approx) -> Self {
        let estimate = if likely.value.is_finite() { likely.value } else { 0.0 };
        // No more than all of it: the sum over its cells may be bounded less well.
        let upper = possible.upper().min(area.upper());
        Self { area, lit: LitArea { lower: lit.lower().max(0.0), upper, estimate } }
    }

    /// A face of which only the area is known; by the estimate, half of it is lit.
    pub(crate) fn unknown(area: Approx) -> Self {
        Self::new(area, Approx::exact(0.0), area, Approx::exact(0.5 * area.value))
    }

    /// Area that is neither proved lit nor proved shadowed.
    pub(crate) fn undecided(&self) -> f64 {
        self.lit.upper - self.lit.lower
    }

    /// With the tighter bounds of two proofs.
    pub(crate) fn narrowed_by(self, other: &LitArea) -> Self {
        let (lower, upper) = (self.lit.lower.max(other.lower), self.lit.upper.min(other.upper));
        Self { lit: LitArea { lower, upper, estimate: self.lit.estimate.clamp(lower, upper.max(lower)) }, ..self }
    }
}

/// An exact sum of floats: terms of similar size in one wide integer, others in big ones.
#[derive(Clone, Debug)]
pub(crate) struct ExactSum {
    /// A multiple of 2^`low`; holds terms up to 2^100 times that, [`ExactSum::ROOM`] of them.
    window: i128,
    low: i32,
    /// How many terms the window still takes; 0 before the first.
    room: u32,
    rest: Dyadic,
    /// Whether a term was no number: nothing bounds the sum.
    is_unbounded: bool,
}

impl Default for ExactSum {
    fn default() -> Self {
        Self { window: 0, low: 0, room: 0, rest: Dyadic::zero(), is_unbounded: false }
    }
}

impl ExactSum {
    /// 2^100 times this stays below 2^127.
    const ROOM: u32 = 1 << 26;

    /// Adds a term; with an infinite one, or none at all (NaN), the sum has no bound any more.
    #[inline(always)]
    pub(crate) fn add(&mut self, term: f64) {
        let bits = term.to_bits();
        let exponent = ((bits >> 52) & 0x7ff) as i32 - 1075;
        let shift = exponent.wrapping_sub(self.low);
        if self.room == 0 || !(0..=47).contains(&shift) {
            return self.add_beside(term);
        }
        self.add_shifted(term, shift);
    }

    /// Adds terms, at most 2^16. Those of similar size are split in two, t = h + l with h a multiple of 2^(`low` + 48), by adding and
    /// subtracting 1.5·2^(`low` + 100), whose last place that is: |t| < 2^(`low` + 84) and t is a multiple of 2^(`low` + 12), so h and l have
    /// 36 bits each at most, and sums of 2^16 of them are exact floats. Vectors of these sums cost a fraction of adding one by one.
    #[inline(always)]
    pub(crate) fn add_all(&mut self, mut terms: &[f64]) {
        while let (0, Some((&first, others))) = (self.room, terms.split_first()) {
            self.add(first);
            terms = others;
        }
        if (self.room as usize) < terms.len() {
            return terms.iter().for_each(|&term| self.add(term));
        }
        let power = |shift: i32| 2f64.powi(self.low + shift);
        let (least, most, split) = (power(64), power(84), 1.5 * power(100));
        let is_inside = |term: f64| (term.abs() >= least) & (term.abs() < most);
        let (mut high, mut low, mut outside) = ([0.0; LANES], [0.0; LANES], [0_u64; LANES]);
        let (chunks, rest) = terms.as_chunks::<LANES>();
        for chunk in chunks {
            for lane in 0..LANES {
                let is_inside = is_inside(chunk[lane]);
                let term = if is_inside { chunk[lane] } else { 0.0 };
                let part = (term + split) - split;
                high[lane] += part;
                low[lane] += term - part;
                outside[lane] += u64::from(!is_inside);
            }
        }
        let (high, low): (f64, f64) = (high.iter().sum(), low.iter().sum());
        self.window += i128::from((high / power(48)) as i64) << 48;
        self.window += i128::from((low / power(12)) as i64) << 12;
        self.room -= terms.len() as u32;
        rest.iter().for_each(|&term| self.add(term));
        if outside != [0; LANES] {
            let others = chunks.as_flattened().iter().filter(|&&term| !is_inside(term));
            others.for_each(|&term| self.add(term));
        }
    }

    /// Adds a term that the window does not hold, or opens one for it.
    #[cold]
    fn add_beside(&mut self, term: f64) {
        if term == 0.0 || !term.is_finite() {
            self.is_unbounded |= term != 0.0;
            return;
        }
        let exponent = ((term.to_bits() >> 52) & 0x7ff) as i32 - 1075;
        if self.room == 0 {
            self.flush();
            // Powers of two in the middle of the range of floats, so that the window's parts are floats.
            self.low = (exponent - 24).clamp(-900, 800);
            self.room = Self::ROOM;
        }
        let shift = exponent - self.low;
        if (0..=47).contains(&shift) {
            self.add_shifted(term, shift);
        } else {
            self.add_to_rest(Dyadic::new(term));
        }
    }

    /// Adds a term, a multiple of the window's unit shifted this far.
    #[inline(always)]
    fn add_shifted(&mut self, term: f64, shift: i32) {
        let bits = term.to_bits();
        let size = i128::from(bits & ((1 << 52) - 1) | 1 << 52) << shift;
        self.window += if term < 0.0 { -size } else { size };
        self.room -= 1;
    }

    /// Adds another sum.
    pub(crate) fn append(&mut self, other: Self) {
        self.is_unbounded |= other.is_unbounded;
        if self.room > 0
            && self.low == other.low
            && other.window.unsigned_abs() >> 120 == 0
            && self.window.unsigned_abs() >> 120 == 0
        {
            self.window += other.window;
            self.room -= 1;
        } else {
            self.add_to_rest(other.window_value());
        }
        self.add_to_rest(other.rest);
    }

    /// Adds the exact product of a float and a whole number; of no finite one, nothing bounds the sum.
    pub(crate) fn add_product(&mut self, factor: f64, whole: u64) {
        if !factor.is_finite() {
            self.is_unbounded = true;
            return;
        }
        let halves = [(whole >> 32) as f64 * 4_294_967_296.0, (whole & 0xffff_ffff) as f64];
        halves.into_iter().for_each(|half| self.add_to_rest(Dyadic::new(factor) * Dyadic::new(half)));
    }

    fn add_to_rest(&mut self, term: Dyadic) {
        let sum = std::mem::replace(&mut self.rest, Dyadic::zero());
        self.rest = sum + term;
    }

    /// Moves the window into the rest.
    fn flush(&mut self) {
        if self.window != 0 {
            self.add_to_rest(self.window_value());
            self.window = 0;
        }
    }

    fn window_value(&self) -> Dyadic {
        let unit = 2f64.powi(self.low);
        let part = |shift: u32| {
            Dyadic::new((self.window.unsigned_abs() >> shift & 0xffff_ffff) as f64 * 2f64.powi(shift as i32))
        };
        let sum = part(0) + part(32) + part(64) + part(96);
        sum * Dyadic::new(if self.window < 0 { -unit } else { unit })
    }

    fn total(&self) -> Dyadic {
        if self.window == 0 { self.rest.clone() } else { self.rest.clone() + self.window_value() }
    }

    /// A float beside the sum, with a bound.
    pub(crate) fn bounded(&self) -> Approx {
        if self.is_unbounded { Approx::UNKNOWN } else { self.total().to_approx() }
    }

    /// The float nearest to the sum of the finite terms.
    pub(crate) fn nearest(&self) -> f64 {
        self.total().to_nearest()
    }

    /// A float not above the sum; the sum itself where it is a float.
    pub(crate) fn rounded_down(&self) -> f64 {
        self.bounded().lower()
    }

    /// A float not below the sum; the sum itself where it is a float.
    pub(crate) fn rounded_up(&self) -> f64 {
        self.bounded().upper()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_term_without_bound_leaves_none() {
        let mut areas = AreaSums::default();
        let [zero, half, one, two] = [0.0, 1.5, 1.0, 2.0].map(Approx::exact);
        areas.add(&FaceArea::new(Approx::UNKNOWN, zero, Approx::UNKNOWN, zero));
        areas.add(&FaceArea::new(two, one, two, half));
        assert_eq!(areas.area(), (2.0, f64::INFINITY));
        assert_eq!((areas.lower.rounded_down(), areas.upper.rounded_up()), (1.0, f64::INFINITY));
        let mut hours = ExactSum::default();
        hours.add_product(f64::INFINITY, 3);
        hours.append(ExactSum::default());
        assert_eq!(hours.rounded_up(), f64::INFINITY);
    }

    #[test]
    fn a_face_that_is_taken_out_leaves_no_trace() {
        let mut areas = AreaSums::default();
        let faces = [3.0, 0.1, 1e-30].map(|area| FaceArea::unknown(Approx { value: area, error: area * 1e-16 }));
        faces.iter().for_each(|face| areas.add(face));
        areas.remove(&faces[0]);
        areas.remove(&faces[2]);
        assert_eq!(areas.area(), (0.1, 0.1 * 1e-16));
        assert_eq!((areas.lower.rounded_down(), areas.upper.rounded_up()), (0.0, faces[1].lit.upper));
    }

    proptest! {
        #[test]
        fn a_sum_is_that_of_big_numbers(
            terms in prop::collection::vec((-1.0..1.0f64, -30i32..30), 0..40), far in -1000i32..900, cut in 0usize..40,
        ) {
            let terms: Vec<f64> = terms.iter().map(|&(x, e)| x * 2f64.powi(e)).chain([2f64.powi(far)]).collect();
            let exact = terms.iter().fold(Dyadic::zero(), |sum, &term| sum + Dyadic::new(term));
            let (first, second) = terms.split_at(cut.min(terms.len()));
            let sum_of = |terms: &[f64]| {
                let mut sum = ExactSum::default();
                terms.iter().for_each(|&term| sum.add(term));
                sum
            };
            let mut sum = sum_of(second);
            sum.append(sum_of(first));
            prop_assert_eq!(sum.nearest(), exact.to_nearest());
            sum = sum_of(second);
            sum.add_all(first);
            prop_assert_eq!(sum.nearest(), exact.to_nearest());
        }

        #[test]
        fn many_terms_are_added_as_one_by_one(
            terms in prop::collection::vec((-1.0..1.0f64, -18i32..10), 100..300), scale in -800i32..800,
        ) {
            // From here on terms leave the part of the window that is summed at once, on both sides.
            let terms: Vec<f64> = terms.iter().map(|&(x, e)| x * 2f64.powi(e) * 2f64.powi(scale)).collect();
            let (mut one_by_one, mut at_once) = (ExactSum::default(), ExactSum::default());
            terms.iter().for_each(|&term| one_by_one.add(term));
            at_once.add_all(&terms[..99]);
            at_once.add_all(&terms[99..]);
            prop_assert_eq!(at_once.nearest(), one_by_one.nearest());
            let exact = terms.iter().fold(Dyadic::zero(), |sum, &term| sum + Dyadic::new(term));
            prop_assert_eq!(at_once.nearest(), exact.to_nearest());
        }
    }
}
