//! The rectangle: a flat receiver with its own parameter square.

use glam::DVec3;

/// A rectangle in the local xz plane, centred at the origin, normal +y.
///
/// Its parameter square: u runs along +x, v along −z, (0, 0) is the corner (−x, +z).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Edge lengths along x and z, metres; positive.
    pub size: [f64; 2],
}

impl Rectangle {
    /// The corners at (u, v) = (0, 0), (1, 0), (1, 1), (0, 1), local coordinates; exact.
    pub fn corners(&self) -> [DVec3; 4] {
        let [x, z] = [0.5 * self.size[0], 0.5 * self.size[1]];
        [DVec3::new(-x, 0.0, z), DVec3::new(x, 0.0, z), DVec3::new(x, 0.0, -z), DVec3::new(-x, 0.0, -z)]
    }
}
