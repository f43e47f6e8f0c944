//! The answers of one object, a bit each.

use std::sync::atomic::{AtomicU8, Ordering};

/// Bits, set where a sample is lit. Rows of lattices begin at whole bytes, so that faces share none.
pub(crate) struct LitBits(Vec<AtomicU8>);

impl LitBits {
    /// None set.
    pub(super) fn new(bytes: u64) -> Self {
        Self((0..bytes).map(|_| AtomicU8::new(0)).collect())
    }

    /// Sets the bits of `bits` from a byte on. Only one thread at a time may set bits of a byte.
    #[inline(always)]
    pub(super) fn set(&self, first: u64, bits: u32) {
        for (k, bits) in bits.to_le_bytes().into_iter().enumerate() {
            if bits != 0 {
                let byte = &self.0[first as usize + k];
                byte.store(byte.load(Ordering::Relaxed) | bits, Ordering::Relaxed);
            }
        }
    }

    /// Leaves those set that `other`, of the same lattice, has too.
    pub(crate) fn intersect(&mut self, other: &Self) {
        for (byte, other) in self.0.iter_mut().zip(&other.0) {
            *byte.get_mut() &= other.load(Ordering::Relaxed);
        }
    }

    /// Sets or clears one bit of a byte. Only one thread at a time may do so.
    pub(super) fn assign(&self, at: u64, bit: u32, is_set: bool) {
        let byte = &self.0[at as usize];
        let others = byte.load(Ordering::Relaxed) & !(1 << bit);
        byte.store(others | u8::from(is_set) << bit, Ordering::Relaxed);
    }

    /// Eight bits.
    pub(super) fn byte(&self, at: u64) -> u8 {
        self.0[at as usize].load(Ordering::Relaxed)
    }

    /// The bytes between each of these places and the next one, which ascend from 0.
    pub(super) fn parts(&mut self, places: &[u64]) -> Vec<&mut [AtomicU8]> {
        let mut rest = self.0.as_mut_slice();
        let part = |ends: &[u64]| rest.split_off_mut(..(ends[1] - ends[0]) as usize);
        places.windows(2).map_while(part).collect()
    }
}

/// How many bits of some bytes are set: nobody else can see them, so eight are one word.
#[inline(always)]
pub(super) fn count(bytes: &mut [AtomicU8]) -> u64 {
    let (words, rest) = bytes.as_chunks_mut::<8>();
    let mut count = 0;
    for [a, b, c, d, e, f, g, h] in words {
        let bytes = [*a.get_mut(), *b.get_mut(), *c.get_mut(), *d.get_mut()];
        let more = [*e.get_mut(), *f.get_mut(), *g.get_mut(), *h.get_mut()];
        count += u64::from(u32::from_ne_bytes(bytes).count_ones() + u32::from_ne_bytes(more).count_ones());
    }
    for byte in rest {
        count += u64::from(byte.get_mut().count_ones());
    }
    count
}
