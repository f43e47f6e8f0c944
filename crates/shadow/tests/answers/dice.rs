//! Numbers drawn by chance, the same ones each time.

use glam::{DQuat, DVec3};

/// A small generator of chance.
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn next(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    pub(crate) fn vector(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::new(self.next(low, high), self.next(low, high), self.next(low, high))
    }

    pub(crate) fn turn(&mut self) -> DQuat {
        DQuat::from_xyzw(self.next(-1.0, 1.0), self.next(-1.0, 1.0), self.next(-1.0, 1.0), self.next(0.1, 1.0))
            .normalize()
    }
}
