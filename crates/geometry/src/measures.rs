//! Sides and areas of many facets at once.
//!
//! The corners of a block of triangles are gathered coordinate by coordinate; what follows is one loop over floats without a branch,
//! which compilers turn into vectors. Guarantee: the same bits as [`Facets::base`] and [`Facets::area`], which share its one step.
//! Cost: some ten nanoseconds a triangle where the caller is compiled for wide vectors, a third of what one by one takes.

use std::ops::Range;

use glam::DVec3;

use crate::{
    approx::Approx,
    facets::{Base, Facets, length_squared},
    gathered::{BLOCK, Gathered},
    parallelogram::float_area,
};

/// What is measured of a triangle.
pub(crate) struct TriangleMeasure {
    /// See [`Base`].
    corner: u32,
    sides: [f64; 2],
    /// Of twice the area.
    doubled: Approx,
    /// Whether no square underflows, so that `doubled` holds.
    is_normal: bool,
}

impl TriangleMeasure {
    /// Of corners with these numbers. Without branches.
    #[inline(always)]
    pub(crate) fn new(numbers: [u32; 3], [a, b, c]: [DVec3; 3]) -> Self {
        let opposite = [length_squared(b - c), length_squared(c - a), length_squared(a - b)];
        let better =
            |k: usize, than: (f64, u32)| (opposite[k] > than.0) | ((opposite[k] == than.0) & (numbers[k] < than.1));
        let takes_b = better(1, (opposite[0], numbers[0]));
        let best = if takes_b { (opposite[1], numbers[1]) } else { (opposite[0], numbers[0]) };
        let takes_c = better(2, best);
        let pick = |[of_a, of_b, of_c]: [f64; 3]| {
            let first = if takes_b { of_b } else { of_a };
            if takes_c { of_c } else { first }
        };
        let corner = if takes_b { 1 } else { 0 };
        let corner = if takes_c { 2 } else { corner };
        let sides = [pick([opposite[2], opposite[0], opposite[1]]), pick([opposite[1], opposite[2], opposite[0]])];
        let at = |p: DVec3, q: DVec3, r: DVec3| {
            DVec3::new(pick([p.x, q.x, r.x]), pick([p.y, q.y, r.y]), pick([p.z, q.z, r.z]))
        };
        let base = at(a, b, c);
        let (doubled, is_normal) = float_area(at(b, c, a) - base, at(c, a, b) - base);
        Self { corner, sides: sides.map(f64::sqrt), doubled, is_normal }
    }

    /// Where the triangle is measured from.
    #[inline(always)]
    pub(crate) fn base(&self) -> Base {
        Base { corner: self.corner as u8, sides: self.sides }
    }

    /// The area; `None` where a square may underflow.
    #[inline(always)]
    pub(crate) fn area(&self) -> Option<Approx> {
        self.is_normal.then_some(Approx { value: 0.5 * self.doubled.value, error: 0.5 * self.doubled.error })
    }
}

/// Measures of consecutive facets.
#[derive(Clone, Debug)]
pub struct Measures {
    /// How many there are.
    len: usize,
    /// The corners, and their numbers.
    corners: Gathered<3>,
    numbers: [[u32; Self::MOST]; 3],
    /// The corner at the base.
    bases: [u32; Self::MOST],
    sides: [[f64; Self::MOST]; 2],
    areas: [f64; Self::MOST],
    errors: [f64; Self::MOST],
    normal: [u32; Self::MOST],
}

impl Default for Measures {
    fn default() -> Self {
        const NONE: [f64; Measures::MOST] = [0.0; Measures::MOST];
        const NO_NUMBERS: [u32; Measures::MOST] = [0; Measures::MOST];
        Self {
            len: 0,
            corners: Gathered::default(),
            numbers: [NO_NUMBERS; 3],
            bases: NO_NUMBERS,
            sides: [NONE; 2],
            areas: NONE,
            errors: NONE,
            normal: NO_NUMBERS,
        }
    }
}

impl Measures {
    /// Most facets that are measured together.
    pub const MOST: usize = BLOCK;

    /// Measures facets, at most [`Measures::MOST`]; what was measured before is forgotten.
    ///
    /// # Panics
    /// If there are no such facets, or if there are too many.
    #[inline(always)]
    pub fn measure(&mut self, facets: &Facets, faces: Range<usize>) {
        self.len = faces.len();
        let Some(triangles) = facets.triangles() else {
            for (lane, face) in faces.enumerate() {
                let (base, area) = (facets.base(face), facets.area(face));
                self.bases[lane] = u32::from(base.corner);
                (self.sides[0][lane], self.sides[1][lane]) = (base.sides[0], base.sides[1]);
                (self.areas[lane], self.errors[lane]) = (area.value, area.error);
            }
            return;
        };
        self.gather(&triangles[faces.clone()], facets.positions());
        if !self.measure_all() {
            for (lane, face) in faces.enumerate().filter(|&(lane, _)| self.normal[lane] == 0) {
                let area = facets.area(face);
                (self.areas[lane], self.errors[lane]) = (area.value, area.error);
            }
        }
    }

    #[inline(always)]
    fn gather(&mut self, triangles: &[[u32; 3]], positions: &[DVec3]) {
        self.corners.gather(triangles, positions, 0);
        for (lane, triangle) in triangles.iter().enumerate() {
            for (numbers, &corner) in self.numbers.iter_mut().zip(triangle) {
                numbers[lane] = corner;
            }
        }
    }

    /// Measures what was gathered, whole vectors; whether no area may underflow.
    #[inline(always)]
    fn measure_all(&mut self) -> bool {
        let count = self.len.next_multiple_of(8).min(Self::MOST);
        for lane in 0..count {
            let numbers = [self.numbers[0][lane], self.numbers[1][lane], self.numbers[2][lane]];
            let corners = self.corners.triangle(lane);
            let measure = TriangleMeasure::new(numbers, corners);
            self.bases[lane] = measure.corner;
            self.sides[0][lane] = measure.sides[0];
            self.sides[1][lane] = measure.sides[1];
            self.areas[lane] = 0.5 * measure.doubled.value;
            self.errors[lane] = 0.5 * measure.doubled.error;
            self.normal[lane] = u32::from(measure.is_normal);
        }
        self.normal[..self.len].iter().sum::<u32>() == self.len as u32
    }

    /// Where each facet is measured from.
    #[inline(always)]
    pub fn base(&self, lane: usize) -> Base {
        Base { corner: self.bases[lane] as u8, sides: [self.sides[0][lane], self.sides[1][lane]] }
    }

    /// The lengths of the first or second sides at the bases, metres.
    #[inline(always)]
    pub fn sides(&self, which: usize) -> &[f64] {
        &self.sides[which][..self.len]
    }

    /// The areas, square metres.
    #[inline(always)]
    pub fn areas(&self) -> &[f64] {
        &self.areas[..self.len]
    }

    /// How far each area may be off.
    #[inline(always)]
    pub fn errors(&self) -> &[f64] {
        &self.errors[..self.len]
    }

    /// A facet's area.
    #[inline(always)]
    pub fn area(&self, lane: usize) -> Approx {
        Approx { value: self.areas[lane], error: self.errors[lane] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Cuboid, Mesh, Placement,
        simd::{Kernel, Level, Simd, dispatch_at},
    };

    /// The measures of all facets, one after the other.
    struct All<'a>(&'a Facets);

    impl Kernel for All<'_> {
        type Output = Vec<(Base, Approx)>;

        #[inline(always)]
        fn run<S: Simd>(self, _: S) -> Self::Output {
            let (mut measures, mut all) = (Measures::default(), Vec::new());
            for first in (0..self.0.len()).step_by(Measures::MOST) {
                measures.measure(self.0, first..(first + Measures::MOST).min(self.0.len()));
                all.extend((0..measures.areas().len()).map(|lane| (measures.base(lane), measures.area(lane))));
            }
            all
        }
    }

    fn check(facets: &Facets) {
        let alone: Vec<_> = (0..facets.len()).map(|face| (facets.base(face), facets.area(face))).collect();
        for level in Level::ALL {
            assert_eq!(dispatch_at(level, All(facets)), alone, "{level:?}");
        }
    }

    #[test]
    fn together_as_one_by_one() {
        let mut random = 1_u64;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 40) as f64 / f64::from(1 << 24)
        };
        // Whole numbers have ties; from the 90th on areas underflow.
        let mut positions: Vec<[f64; 3]> = Vec::new();
        for k in 0..150 {
            let scale = if k < 90 { 1.0 } else { 2f64.powi(-90) };
            positions.push([next(), next(), next()].map(|x| scale * if k % 2 == 0 { x } else { (4.0 * x).floor() }));
        }
        let corner = |x: f64| (x * 149.0) as u32;
        let triangles: Vec<[u32; 3]> = (0..200).map(|_| [next(), next(), next()].map(corner)).collect();
        let mesh = Mesh::new(positions, triangles).expect("a mesh");
        let facets = Facets::of_mesh(mesh, &Placement::IDENTITY);
        assert!((0..facets.len()).any(|face| facets.area(face).value == 0.0));
        check(&facets);
        check(&Facets::of_cuboid(&Cuboid { size: [2.0, 0.3, 1.0] }, &Placement::IDENTITY));
    }
}
