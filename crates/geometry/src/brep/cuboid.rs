//! Boxes: the convex bodies that need no hull.

use glam::DVec3;

use super::{Brep, BrepDefect};

/// A box centred at the local origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Edge lengths along x, y, z, metres; positive.
    pub size: [f64; 3],
}

impl Cuboid {
    /// The corner loops of the faces −x, +x, −y, +y, −z, +z; bit k of a corner's number picks the upper end of axis k.
    /// A face's parameter square has (0, 0) at its first corner, (1, 0) at its second and (0, 1) at its last.
    pub const FACES: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

    /// The eight corners, local coordinates; exact.
    pub fn corners(&self) -> [DVec3; 8] {
        let half = DVec3::from_array(self.size) * 0.5;
        std::array::from_fn(|i| {
            let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            half * DVec3::new(sign(0), sign(1), sign(2))
        })
    }

    /// The box as a boundary representation: corners in the order of [`Cuboid::corners`], faces in the order of
    /// [`Cuboid::FACES`].
    ///
    /// # Errors
    /// [`BrepDefect`] when a size is not positive or half of it is not accepted.
    pub fn brep(&self) -> Result<Brep, BrepDefect> {
        let faces: Vec<Vec<u32>> = Self::FACES.iter().map(|face| face.to_vec()).collect();
        Brep::new(self.corners().to_vec(), &faces)
    }
}
