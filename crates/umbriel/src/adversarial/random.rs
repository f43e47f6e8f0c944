//! Reproducible numbers: SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA
//! 2014). Passes the usual statistical tests, which is far more than tests need; a step is three multiplications and shifts.

use glam::DVec3;
use umbriel_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE};

use super::{REACH, accepted};

/// A source of numbers; the same seed gives the same ones everywhere.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// Seeds that follow each other give unrelated numbers.
    pub fn new(seed: u64) -> Self {
        let mut first = Self { state: seed };
        Self { state: first.next() }
    }

    /// The next 64 bits.
    #[expect(clippy::should_implement_trait, reason = "numbers never end")]
    pub fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A whole number below `bound`, which must not be zero.
    pub fn below(&mut self, bound: u64) -> u64 {
        // The high half of the product; small bounds are hit evenly enough.
        ((u128::from(self.next()) * u128::from(bound)) >> 64) as u64
    }

    /// One of these; there must be one.
    pub fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u64) as usize]
    }

    /// A number in `low..high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.next() >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// One of these, or a number in `low..high`: as likely as each of them.
    pub fn pick_or(&mut self, choices: &[f64], low: f64, high: f64) -> f64 {
        let any = self.between(low, high);
        choices.get(self.below(choices.len() as u64 + 1) as usize).copied().unwrap_or(any)
    }

    /// A float at most [`REACH`] places from `value`, and in the accepted range; zero stays, since no neighbour of it is accepted.
    pub fn beside(&mut self, value: f64) -> f64 {
        let steps = self.steps();
        let magnitude = f64::from_bits(value.abs().to_bits().saturating_add_signed(steps));
        let accepted = if value == 0.0 { 0.0 } else { magnitude.clamp(MIN_MAGNITUDE, MAX_MAGNITUDE) };
        accepted.copysign(value)
    }

    /// A point whose coordinates are each [`beside`](Self::beside) those of `point`. Every other time a zero is moved, by places of the
    /// largest coordinate: by as much as what is computed from the point is rounded.
    pub fn beside_point(&mut self, point: DVec3) -> DVec3 {
        let place = point.abs().max_element() * f64::EPSILON;
        let mut moved = |coordinate: f64| match coordinate == 0.0 {
            true => accepted(self.beside_zero() as f64 * place),
            false => self.beside(coordinate),
        };
        DVec3::new(moved(point.x), moved(point.y), moved(point.z))
    }

    /// An odd number of places, or none.
    fn beside_zero(&mut self) -> i64 {
        let steps = self.steps();
        if steps % 2 == 0 { 0 } else { steps }
    }

    /// A number of places, at most [`REACH`] in size.
    fn steps(&mut self) -> i64 {
        self.below(2 * REACH + 1) as i64 - REACH as i64
    }
}
