//! The corners of a mesh in the tree's frame, each rounded to f32 once.

use glam::Vec3A;
use umbriel_geometry::Mesh;

use super::{
    super::{
        bounds::Bounds,
        frame::{Frame, above},
        layout::{Pack, WIDTH},
    },
    tasks::{CHUNK, for_each},
};

/// All corners, rounded.
pub(super) struct Corners<'a> {
    triangles: &'a [[u32; 3]],
    positions: Vec<Vec3A>,
    /// How far a coordinate is from the true one, at most.
    pub(super) error: f32,
}

impl<'a> Corners<'a> {
    pub(super) fn new(mesh: &'a Mesh, frame: &Frame) -> Self {
        let mut positions = vec![Vec3A::ZERO; mesh.positions().len()];
        let chunks = mesh.positions().chunks(CHUNK).zip(positions.chunks_mut(CHUNK));
        let mut tasks: Vec<_> = chunks.map(|(exact, rounded)| (exact, rounded, 0.0f64)).collect();
        for_each(&mut tasks, &|(exact, rounded, error)| {
            for (exact, rounded) in exact.iter().zip(rounded.iter_mut()) {
                let exact = frame.localise(*exact);
                *rounded = exact.as_vec3a();
                // Corners of no triangle may lie outside of the frame, and do not count.
                let off = (exact - rounded.as_dvec3()).abs().max_element();
                *error = if off <= f64::from(f32::EPSILON) { error.max(off) } else { *error };
            }
        });
        let error = tasks.iter().fold(0.0, |most, &(.., error)| error.max(most));
        Self { triangles: mesh.triangles(), positions, error: above(error + frame.error(1.0)) }
    }

    #[inline(always)]
    pub(super) fn of(&self, triangle: u32) -> [Vec3A; 3] {
        let [a, b, c] = self.triangles[triangle as usize];
        [self.positions[a as usize], self.positions[b as usize], self.positions[c as usize]]
    }

    /// The box of a triangle, rounded outward: a corner is within half an ulp of its true place.
    #[inline(always)]
    pub(super) fn bounds_of(&self, triangle: u32) -> Bounds {
        let [a, b, c] = self.of(triangle);
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        Bounds::new(widened(min, -1.0).to_array(), widened(max, 1.0).to_array())
    }

    /// Fills a pack.
    #[inline]
    pub(super) fn pack(&self, triangles: impl ExactSizeIterator<Item = u32>, pack: &mut Pack) {
        let count = triangles.len();
        for (lane, triangle) in triangles.enumerate() {
            pack.triangles[lane % WIDTH] = triangle;
            for (corner, position) in self.of(triangle).into_iter().enumerate() {
                for (row, coordinate) in pack.corners[corner].iter_mut().zip(position.to_array()) {
                    row[lane % WIDTH] = coordinate;
                }
            }
        }
        // What is left over repeats the first one.
        for lane in count..WIDTH {
            pack.triangles[lane] = pack.triangles[0];
            for row in pack.corners.as_flattened_mut() {
                row[lane] = row[0];
            }
        }
    }
}

/// At least the next numbers below (`side` −1) or above (1). A number's distance from the next is at most 2^-23 of its size.
#[inline(always)]
fn widened(numbers: Vec3A, side: f32) -> Vec3A {
    numbers + (numbers.abs() * f32::EPSILON + Vec3A::splat(f32::MIN_POSITIVE)) * side
}
