//! Boxes in the tree's frame, laid out so that a union is one minimum over eight lanes.

use umbriel_geometry::simd::{Float, Simd};

/// A box as its least coordinates and its negated greatest ones. Lanes 3 and 7 are not part of the box.
// | min x | min y | min z | tag | −max x | −max y | −max z | – |   32 bytes
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(super) struct Bounds([f32; 8]);

const _: () = assert!(size_of::<Bounds>() == 32);

impl Bounds {
    pub(super) const EMPTY: Self = Self([f32::INFINITY; 8]);

    /// The box of the origin.
    pub(super) const ZERO: Self = Self([0.0; 8]);

    pub(super) fn new(min: [f32; 3], max: [f32; 3]) -> Self {
        Self([min[0], min[1], min[2], 0.0, -max[0], -max[1], -max[2], 0.0])
    }

    /// The smallest box around both.
    #[inline(always)]
    pub(super) fn union(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|lane| if self.0[lane] < other.0[lane] { self.0[lane] } else { other.0[lane] }))
    }

    /// Grows the box to hold the other.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, simd: S, other: &Self) {
        self.0 = simd.load(&self.0).min(simd.load(&other.0)).to_array();
    }

    /// Whether the other box lies in this one.
    pub(super) fn holds(&self, other: &Self) -> bool {
        [0, 1, 2, 4, 5, 6].into_iter().all(|lane| self.0[lane] <= other.0[lane])
    }

    pub(super) fn min(&self, axis: usize) -> f32 {
        self.0[axis]
    }

    pub(super) fn max(&self, axis: usize) -> f32 {
        -self.0[axis + 4]
    }

    /// Twice the middle, on each axis.
    #[inline(always)]
    pub(super) fn twice_center(&self) -> [f32; 4] {
        std::array::from_fn(|axis| self.0[axis] - self.0[axis + 4])
    }

    /// Half the surface area; a negative number or NaN for an empty box.
    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| -(self.0[axis] + self.0[axis + 4]));
        x * (y + z) + y * z
    }

    /// A number that travels with the box.
    #[inline(always)]
    pub(super) fn tag(&self) -> u32 {
        self.0[3].to_bits()
    }

    #[inline(always)]
    pub(super) fn tagged(mut self, tag: u32) -> Self {
        self.0[3] = f32::from_bits(tag);
        self
    }
}
