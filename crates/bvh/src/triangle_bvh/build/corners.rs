//! The corners of a mesh in the tree's frame, each rounded to f32 once.

use glam::{Vec3A, Vec4};
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
    /// The fourth number is of no meaning.
    positions: Vec<[f32; 4]>,
    /// How far a coordinate is from the true one, at most.
    pub(super) error: f32,
}

impl<'a> Corners<'a> {
    pub(super) fn new(mesh: &'a Mesh, frame: &Frame) -> Self {
        let mut positions = vec![[0.0; 4]; mesh.positions().len()];
        let chunks = mesh.positions().chunks(CHUNK).zip(positions.chunks_mut(CHUNK));
        let mut tasks: Vec<_> = chunks.map(|(exact, rounded)| (exact, rounded, 0.0f64)).collect();
        for_each(&mut tasks, &|(exact, rounded, error)| {
            for (exact, rounded) in exact.iter().zip(rounded.iter_mut()) {
                let exact = frame.localise(*exact);
                let nearest = exact.as_vec3a();
                *rounded = Vec4::from((nearest, 0.0)).to_array();
                // Corners of no triangle may lie outside of the frame, and do not count.
                let off = (exact - nearest.as_dvec3()).abs().max_element();
                *error = if off <= f64::from(f32::EPSILON) { error.max(off) } else { *error };
            }
        });
        let error = tasks.iter().fold(0.0, |most, &(.., error)| error.max(most));
        Self { triangles: mesh.triangles(), positions, error: above(error + frame.error(1.0)) }
    }

    /// The corners of a triangle.
    #[inline(always)]
    pub(super) fn of(&self, triangle: u32) -> Triangle {
        let [a, b, c] = self.triangles[triangle as usize];
        Triangle([self.position(a), self.position(b), self.position(c)])
    }

    #[inline(always)]
    fn position(&self, corner: u32) -> Vec3A {
        Vec3A::from_vec4(Vec4::from_array(self.positions[corner as usize]))
    }

    /// Fills a pack with at most eight triangles.
    #[inline]
    pub(super) fn pack(&self, triangles: impl ExactSizeIterator<Item = u32>, pack: &mut Pack) {
        let count = triangles.len();
        for (lane, triangle) in triangles.enumerate() {
            self.of(triangle).put(triangle, lane, pack);
        }
        fill_up(count, pack);
    }
}

/// The corners of a triangle, rounded.
#[derive(Clone, Copy)]
pub(super) struct Triangle(pub(super) [Vec3A; 3]);

impl Triangle {
    /// The least and the greatest coordinates.
    #[inline(always)]
    pub(super) fn extremes(&self) -> [Vec3A; 2] {
        let [a, b, c] = self.0;
        [a.min(b).min(c), a.max(b).max(c)]
    }

    /// The box, rounded outward: a corner is within half an ulp of its true place.
    #[inline(always)]
    pub(super) fn bounds(&self) -> Bounds {
        let [min, max] = self.extremes();
        Bounds::new(widened(min, -1.0).to_array(), widened(max, 1.0).to_array())
    }

    /// Puts the triangle into a lane of a pack.
    #[inline(always)]
    pub(super) fn put(&self, index: u32, lane: usize, pack: &mut Pack) {
        pack.triangles[lane % WIDTH] = index;
        for (rows, corner) in pack.corners.iter_mut().zip(self.0) {
            for (row, coordinate) in rows.iter_mut().zip(corner.to_array()) {
                row[lane % WIDTH] = coordinate;
            }
        }
    }
}

/// Repeats the first triangle in the lanes that are left over.
#[inline(always)]
pub(super) fn fill_up(count: usize, pack: &mut Pack) {
    for lane in count..WIDTH {
        pack.triangles[lane] = pack.triangles[0];
        for row in pack.corners.as_flattened_mut() {
            row[lane] = row[0];
        }
    }
}

/// At least the next numbers below (`side` −1) or above (1): these are within 2^-23 of a number's size, or below
/// the smallest normal number.
#[inline(always)]
fn widened(numbers: Vec3A, side: f32) -> Vec3A {
    numbers + (numbers.abs() * f32::EPSILON + Vec3A::splat(f32::MIN_POSITIVE)) * side
}
