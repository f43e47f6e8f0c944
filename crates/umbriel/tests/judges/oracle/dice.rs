//! Reproducible chance: one generator a case, seeded by the case's number.

use std::collections::VecDeque;

use proptest::{
    prelude::Rng,
    test_runner::{RngAlgorithm, TestRng},
};

/// A source of random numbers.
#[derive(Clone, Debug)]
pub(crate) struct Dice {
    /// What is left of given bytes; they come before the generator.
    given: VecDeque<u8>,
    generator: TestRng,
}

impl Dice {
    /// The dice of case number `case` of the judge called `judge`.
    pub(crate) fn new(judge: &str, case: u64) -> Self {
        let mut seed = [0_u8; 32];
        for (slot, byte) in seed[8..].iter_mut().zip(judge.bytes()) {
            *slot = byte;
        }
        seed[..8].copy_from_slice(&case.to_le_bytes());
        Self { given: VecDeque::new(), generator: TestRng::from_seed(RngAlgorithm::ChaCha, &seed) }
    }

    /// Dice that throw what the bytes say, one byte a throw of up to 256 sides and eight for more, and go on by chance.
    pub(crate) fn of_bytes(bytes: &[u8]) -> Self {
        Self { given: bytes.iter().copied().collect(), ..Self::new("bytes", 0) }
    }

    /// The next number; of given bytes only as many as it takes.
    fn next(&mut self, bytes: usize) -> u64 {
        if self.given.is_empty() {
            return self.generator.next_u64();
        }
        self.given.drain(..bytes.min(self.given.len())).fold(0, |number, byte| number << 8 | u64::from(byte))
    }

    /// A number below `bound`.
    pub(crate) fn below(&mut self, bound: u64) -> u64 {
        self.next(if bound <= 256 { 1 } else { 8 }) % bound
    }

    /// An index into a list of this length.
    pub(crate) fn index(&mut self, length: usize) -> usize {
        self.below(length as u64) as usize
    }

    /// One of these.
    pub(crate) fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.index(choices.len())]
    }

    /// The numbers below `length` in any order (Fisher and Yates).
    pub(crate) fn order(&mut self, length: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..length).collect();
        (1..length).rev().for_each(|last| order.swap(last, self.index(last + 1)));
        order
    }

    /// True once in `n`.
    pub(crate) fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    /// A float in `low..high`.
    pub(crate) fn float(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.next(8) >> 11) as f64 / 2f64.powi(53);
        low + (high - low) * unit
    }

    /// A multiple of `step`, at most `reach` steps from zero.
    pub(crate) fn grid(&mut self, reach: u64, step: f64) -> f64 {
        (self.below(2 * reach + 1) as f64 - reach as f64) * step
    }

    /// Three of [`Dice::grid`].
    pub(crate) fn grid_point(&mut self, reach: u64, step: f64) -> [f64; 3] {
        std::array::from_fn(|_| self.grid(reach, step))
    }

    /// The value moved by up to two units in its last place, up or down; zero stays.
    pub(crate) fn nudged(&mut self, value: f64) -> f64 {
        let steps = self.below(5) as i64 - 2;
        if value == 0.0 { value } else { f64::from_bits(value.to_bits().wrapping_add_signed(steps)) }
    }

    /// A parameter of a face in 0..=1: ends, simple fractions and plain ones. Always a multiple of 2^-30, so that sums
    /// of two are exact.
    pub(crate) fn parameter(&mut self) -> f64 {
        match self.below(4) {
            0 => self.pick(&[0.0, 1.0, 0.5]),
            1 => self.below(9) as f64 / 8.0,
            _ => self.below((1 << 30) + 1) as f64 / 2f64.powi(30),
        }
    }

    /// Parameters of a point of a triangle (u + v ≤ 1) or of a square face.
    pub(crate) fn parameters(&mut self, triangle: bool) -> [f64; 2] {
        let (u, v) = (self.parameter(), self.parameter());
        if triangle && u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] }
    }
}
