//! Points of many triangles or edges, coordinate by coordinate: what follows is one loop over floats without a branch, which
//! compilers turn into vectors.

use glam::DVec3;

/// Triangles or edges that are gathered together.
pub const BLOCK: usize = 64;

/// The points of up to `LANES` triangles (`N` = 3), or of whatever has `N` points.
#[derive(Clone, Debug)]
pub struct Gathered<const N: usize, const LANES: usize = BLOCK> {
    x: [[f64; LANES]; N],
    y: [[f64; LANES]; N],
    z: [[f64; LANES]; N],
}

impl<const N: usize, const LANES: usize> Default for Gathered<N, LANES> {
    #[inline(always)]
    fn default() -> Self {
        Self { x: [[0.0; LANES]; N], y: [[0.0; LANES]; N], z: [[0.0; LANES]; N] }
    }
}

impl<const N: usize, const LANES: usize> Gathered<N, LANES> {
    /// The positions of these points, their numbers counted from `first`.
    ///
    /// # Panics
    /// If there are too many, or no such points.
    #[inline(always)]
    pub fn gather(&mut self, points: &[[u32; N]], positions: &[DVec3], first: u32) {
        for (lane, points) in points.iter().enumerate() {
            for (k, &point) in points.iter().enumerate() {
                self.set(k, lane, positions[(first + point) as usize]);
            }
        }
    }

    /// Puts a point into a lane.
    ///
    /// # Panics
    /// If there is no such place.
    #[inline(always)]
    pub fn set(&mut self, k: usize, lane: usize, position: DVec3) {
        self.x[k][lane] = position.x;
        self.y[k][lane] = position.y;
        self.z[k][lane] = position.z;
    }

    /// A point of the triangle or edge in a lane.
    #[inline(always)]
    pub fn at(&self, k: usize, lane: usize) -> DVec3 {
        DVec3::new(self.x[k][lane], self.y[k][lane], self.z[k][lane])
    }
}

impl<const LANES: usize> Gathered<3, LANES> {
    /// The triangle in a lane.
    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> [DVec3; 3] {
        [self.at(0, lane), self.at(1, lane), self.at(2, lane)]
    }
}
