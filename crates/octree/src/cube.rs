//! The bounding cube of an object and the lattice of its cells.
//!
//! The cube begins at the least corner of the object's box; its edge is the smallest float that is not below the
//! longest side. Halving it 21 times gives lattice planes at min + edge·i/2^21, which are real numbers, not floats:
//! on which side of a plane a coordinate lies is decided exactly. Both x − min and edge·i/2^21 are rounded, and rounding
//! is monotone, so different rounded numbers tell; equal ones leave the comparison to their errors, which are floats
//! themselves (Knuth's sum of two, a fused multiply-add). Exact in the accepted range of coordinates. O(1) a question.

use std::cmp::Ordering;

use glam::DVec3;
use umbriel_geometry::Aabb;

use crate::morton::Octant;

#[cfg(test)]
mod tests;

/// Lattice planes an axis, less one: the cells of the deepest level.
pub(crate) const CELLS: u32 = 1 << Octant::MAX_LEVEL;

/// The greatest depth, up to `deepest`, at which `edge` halved so often is not below `length`; `None` when even `edge`
/// is. Exact: only powers of two are multiplied.
///
/// A length of zero or below gets `deepest`, NaN gets `None`.
pub fn depth_of_length(edge: f64, length: f64, deepest: u8) -> Option<u8> {
    let fits = |depth: &u8| length * 2f64.powi(i32::from(*depth)) <= edge;
    (0..=deepest).take_while(fits).last()
}

/// An axis-aligned cube, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cube {
    min: DVec3,
    edge: f64,
}

/// The cells of the deepest level that a box meets: a range on each axis, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LatticeBox {
    /// First cell on each axis.
    pub min: [u32; 3],
    /// Last cell on each axis.
    pub max: [u32; 3],
}

impl LatticeBox {
    /// Whether the box meets the closed cell.
    pub fn meets(&self, cell: Octant) -> bool {
        self.along_axes(cell, |[first, last], low, high| low <= last && first <= high)
    }

    /// Whether the box meets every cell of the deepest level in `cell`.
    pub fn covers(&self, cell: Octant) -> bool {
        self.along_axes(cell, |[first, last], low, high| low <= first && last <= high)
    }

    /// Whether `test`, given the cell's range and the box's, holds on all axes.
    fn along_axes(&self, cell: Octant, test: impl Fn([u32; 2], u32, u32) -> bool) -> bool {
        let (below, place) = (Octant::MAX_LEVEL - cell.level(), cell.coordinates());
        (0..3).all(|axis| {
            let first = place[axis] << below;
            test([first, first + ((1 << below) - 1)], self.min[axis], self.max[axis])
        })
    }
}

impl Cube {
    /// The smallest cube at the least corner of `bounds` that holds it, its edge rounded up. `None` when the box is
    /// empty or not finite.
    pub fn around(bounds: &Aabb) -> Option<Self> {
        let sides = (0..3).map(|axis| difference(bounds.max[axis], bounds.min[axis]));
        let rounded_up = sides.map(|(side, error)| if error > 0.0 { side.next_up() } else { side });
        let edge = rounded_up.fold(0.0, f64::max);
        let is_sound = !bounds.is_empty() && bounds.min.is_finite() && edge.is_finite();
        is_sound.then_some(Self { min: bounds.min, edge })
    }

    /// A cube that holds `bounds` and whose lattice planes are floats down to level `depth`, so that its cells are exact
    /// boxes: its edge is a power of two, its least corner a multiple of a power of two. `None` when the box is empty, not
    /// finite or a point, when `depth` is too deep, or when floats are too coarse for such cells so far from the origin.
    ///
    /// The edge is below four times the longest side.
    pub fn on_grid(bounds: &Aabb, depth: u8) -> Option<Self> {
        let mut edge = power_of_two_not_below(Self::around(bounds)?.edge);
        // A grid of a quarter or finer: moving the corner down to it costs at most one more doubling of the edge.
        let step = 2f64.powi(-i32::from(depth.max(2)));
        for _ in 0..2 {
            let grid = edge * step;
            let cube = Self { min: (bounds.min / grid).floor() * grid + DVec3::ZERO, edge };
            let holds = |axis| cube.compare(axis, bounds.max[axis], CELLS).is_some_and(Ordering::is_le);
            if cube.has_float_planes(depth) && (0..3).all(holds) {
                return Some(cube);
            }
            edge *= 2.0;
        }
        None
    }

    /// The cube with these numbers; `None` unless all are accepted ([`umbriel_geometry::accept`]) and the edge is not
    /// negative.
    pub fn new(min: DVec3, edge: f64) -> Option<Self> {
        let min = umbriel_geometry::accept_point(min.to_array()).ok()?;
        let edge = umbriel_geometry::accept(edge).ok().filter(|edge| *edge >= 0.0)?;
        Some(Self { min, edge })
    }

    /// Whether the lattice planes down to level `depth` are known to be floats: multiples of one power of two of which
    /// 2^53 reach beyond the cube. [`Cube::bounds_of`] is then exact. False for a cube without an edge.
    pub fn has_float_planes(&self, depth: u8) -> bool {
        depth <= Octant::MAX_LEVEL
            && self.edge > 0.0
            && (0..3).all(|axis| {
                let (low, high) = (self.min[axis], self.min[axis] + self.edge);
                let step = lowest_bit(self.edge) * 2f64.powi(-i32::from(depth));
                let unit = if low == 0.0 { step } else { step.min(lowest_bit(low)) };
                low.abs().max(high.abs()) / unit <= 2f64.powi(f64::MANTISSA_DIGITS as i32)
            })
    }

    /// The least corner.
    pub fn min(&self) -> DVec3 {
        self.min
    }

    /// The edge; zero for the cube of a single point.
    pub fn edge(&self) -> f64 {
        self.edge
    }

    /// The greatest depth at which a cell's edge is not below `length` ([`depth_of_length`]).
    pub fn depth_of(&self, length: f64) -> Option<u8> {
        depth_of_length(self.edge, length, Octant::MAX_LEVEL)
    }

    /// A box that holds the cell, its corners rounded outward by at most an ulp or two, not at all where they are floats.
    pub fn bounds_of(&self, cell: Octant) -> Aabb {
        let below = Octant::MAX_LEVEL - cell.level();
        let first = cell.coordinates().map(|c| c << below);
        let corner = |step: u32, outward: fn(f64) -> f64| {
            DVec3::from_array(std::array::from_fn(|axis| self.near_plane(axis, first[axis] + step, outward)))
        };
        Aabb { min: corner(0, f64::next_down), max: corner(1 << below, f64::next_up) }
    }

    /// The cell of `level` that holds `point`; a point on a plane between cells belongs to the upper one. `None` for a
    /// point outside the closed cube or a level that is too deep.
    pub fn octant_at(&self, point: DVec3, level: u8) -> Option<Octant> {
        let below = Octant::MAX_LEVEL.checked_sub(level)?;
        let mut place = [0; 3];
        for (axis, cell) in place.iter_mut().enumerate() {
            let x = point[axis];
            if let Some(plane) = self.clearly_above(axis, x) {
                *cell = plane >> below;
                continue;
            }
            if self.compare(axis, x, 0)?.is_lt() || self.compare(axis, x, CELLS)?.is_gt() {
                return None;
            }
            *cell = self.planes_below(axis, x).min(CELLS - 1) >> below;
        }
        Octant::at(level, place)
    }

    /// The cells of the deepest level that the closed box meets, cells being closed; `None` where it misses the cube.
    ///
    /// A box in a plane between two cells meets both. On a shallower level the box meets exactly the ancestors of these
    /// cells ([`LatticeBox::meets`]). In the cube of a single point only the first cell counts.
    pub fn lattice_box(&self, bounds: &Aabb) -> Option<LatticeBox> {
        let mut met = LatticeBox { min: [0; 3], max: [0; 3] };
        for axis in 0..3 {
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            if self.compare(axis, high, 0)?.is_lt() || self.compare(axis, low, CELLS)?.is_gt() || high < low {
                return None;
            }
            let first = self.planes_below(axis, low);
            let is_on_plane = self.compare(axis, low, first)?.is_eq();
            met.min[axis] = first.saturating_sub(u32::from(is_on_plane)).min(CELLS - 1);
            met.max[axis] = self.planes_below(axis, high).min(CELLS - 1);
        }
        Some(met)
    }

    /// [`Cube::planes_below`] for a coordinate of the cube that is far from every plane: three roundings of a number up to
    /// 2^21 take away less than 2^-29.
    fn clearly_above(&self, axis: usize, x: f64) -> Option<u32> {
        const NEAR: f64 = 1.0 / (1 << 20) as f64;
        let guess = (x - self.min[axis]) / self.edge * f64::from(CELLS);
        let plane = guess as u32; // towards zero; NaN becomes zero and is clear of nothing
        let above = guess - f64::from(plane);
        (plane < CELLS && above > NEAR && above < 1.0 - NEAR).then_some(plane)
    }

    /// The last lattice plane that is not above `x`; the first for any lower x.
    fn planes_below(&self, axis: usize, x: f64) -> u32 {
        if self.edge == 0.0 {
            return 0;
        }
        // Three roundings of a number up to 2^21 put the guess at most one plane off.
        let guess = (x - self.min[axis]) / self.edge * f64::from(CELLS);
        let mut plane = guess.clamp(0.0, f64::from(CELLS)) as u32;
        while plane > 0 && self.compare(axis, x, plane).is_some_and(Ordering::is_lt) {
            plane -= 1;
        }
        while plane < CELLS && self.compare(axis, x, plane + 1).is_some_and(Ordering::is_ge) {
            plane += 1;
        }
        plane
    }

    /// Where `x` lies seen from lattice plane `plane`: exact. `None` for NaN.
    pub(crate) fn compare(&self, axis: usize, x: f64, plane: u32) -> Option<Ordering> {
        let (from_min, error) = difference(x, self.min[axis]);
        let (offset, offset_error) = self.offset(plane);
        match from_min.partial_cmp(&offset)? {
            Ordering::Equal => error.partial_cmp(&offset_error),
            decided => Some(decided),
        }
    }

    /// How far a lattice plane is from the least one, rounded, and what the rounding took away.
    pub(crate) fn offset(&self, plane: u32) -> (f64, f64) {
        let share = f64::from(plane) / f64::from(CELLS);
        let offset = self.edge * share;
        (offset, self.edge.mul_add(share, -offset))
    }

    /// The coordinate of a lattice plane; where it is no float, one step `outward` of the nearest float.
    fn near_plane(&self, axis: usize, plane: u32, outward: fn(f64) -> f64) -> f64 {
        let (offset, offset_error) = self.offset(plane);
        let (sum, error) = difference(self.min[axis], -offset);
        // Where the sum is not exact its terms do not cancel, so both errors are below an ulp of it and the corrected
        // sum is within an ulp of the plane.
        let rest = error + offset_error;
        if rest == 0.0 { sum } else { outward(sum + rest) }
    }
}

/// The least power of two that is not below a positive normal number; zero stays zero.
pub(crate) fn power_of_two_not_below(value: f64) -> f64 {
    let power = f64::from_bits(value.to_bits() >> FRACTION << FRACTION);
    if power < value { power * 2.0 } else { power }
}

/// The value of the last bit that is set in a number other than zero.
fn lowest_bit(value: f64) -> f64 {
    let bits = value.abs().to_bits();
    let ulp = f64::from_bits(bits + 1) - f64::from_bits(bits);
    let fraction = bits & ((1 << FRACTION) - 1) | 1 << FRACTION;
    ulp * (1u64 << fraction.trailing_zeros()) as f64
}

/// Bits of a float's fraction.
const FRACTION: u32 = f64::MANTISSA_DIGITS - 1;

/// a − b rounded, and what the rounding took away (Knuth, "The Art of Computer Programming" 2, section 4.2.2).
pub(crate) fn difference(a: f64, b: f64) -> (f64, f64) {
    let difference = a - b;
    let b_seen = a - difference;
    let a_seen = difference + b_seen;
    let error = (a - a_seen) + (b_seen - b);
    (difference, if error.is_nan() { 0.0 } else { error })
}
