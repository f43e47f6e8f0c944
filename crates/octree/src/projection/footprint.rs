//! Where a pack of a leaf is seen on a face: the projection of the leaf's cell, row by row.
//!
//! A box x₀..x₁, y₀..y₁ at depths z₀..z₁ is the union of its sections; the one at depth z projects to the rectangle s·[x₀, x₁] ×
//! s·[y₀, y₁], s = 1/z. Rectangles of all s between 1/z₁ and 1/z₀ together are the upper face's rectangle where that contains the view
//! plane's origin, and the convex polygon around both faces' rectangles otherwise (the source's fact 2); no polygon is
//! needed: in the strip v₀ ≤ v ≤ v₁ are the sections whose s·[y₀, y₁] meets it, s between two bounds, and the least u is that of
//! one of the two. For parallel rays s = 1.
//!
//! Of that, only what the [`Outline`] of the pack's triangles reaches counts.
//!
//! All is rounded outward: each number is a quotient or a product, off by 2u at most; s is widened by 4u of itself, u by as
//! much. A viewpoint inside the box sees it everywhere: s has no upper bound.

use std::ops::Range;

use glam::DVec3;

use super::{frame::Kind, grid::strip, outline::Outline};

/// How far a face's maps reach beyond its border: rays through the border, known to this much, may be looked up on either
/// of the two faces. 2^-20 of half a face.
pub(super) const RIM: f64 = 1.0 / (1 << 20) as f64;

const OUTWARD: f64 = 1.0 + 2.0 * f64::EPSILON;
const INWARD: f64 = 1.0 - 2.0 * f64::EPSILON;

/// A box as a face sees it.
#[derive(Clone, Debug)]
pub(super) struct Footprint {
    x: [f64; 2],
    y: [f64; 2],
    /// Scales of its sections.
    scale: [f64; 2],
    /// Depths of its faces.
    pub(super) depth: [f64; 2],
    outline: Option<Outline>,
}

impl Footprint {
    /// Of the box with these corners (local); `None` where all of it is behind the viewpoint.
    pub(super) fn new(kind: Kind, face: usize, min: DVec3, max: DVec3) -> Option<Self> {
        let axis = face / 2;
        let range = |axis: usize| [min[axis], max[axis]];
        let depth = if face.is_multiple_of(2) { range(axis) } else { [-max[axis], -min[axis]] };
        let (x, y) = (range((axis + 1) % 3), range((axis + 2) % 3));
        if kind == Kind::Parallel {
            return Some(Self { x, y, scale: [1.0; 2], depth, outline: None });
        }
        if depth[1] <= 0.0 {
            return None;
        }
        let nearest = if depth[0] > 0.0 { (depth[0].recip() * OUTWARD).min(f64::MAX) } else { f64::MAX };
        Some(Self { x, y, scale: [depth[1].recip() * INWARD, nearest], depth, outline: None })
    }

    /// With what the pack shows of itself.
    pub(super) fn showing(self, outline: Option<Outline>) -> Self {
        Self { outline, ..self }
    }

    /// How far aside of the viewpoint's foot the middle of its upper face lies.
    pub(super) fn aside(&self) -> f64 {
        let (x, y) = (0.5 * (self.x[0] + self.x[1]), 0.5 * (self.y[0] + self.y[1]));
        (x * x + y * y).sqrt()
    }

    /// The columns and the rows that it meets, from −1 − [`RIM`] to 1 + [`RIM`].
    pub(super) fn reach(&self) -> Option<[[f64; 2]; 2]> {
        let cell = [clip(reach(self.x, self.scale))?, clip(reach(self.y, self.scale))?];
        let Some(outline) = &self.outline else { return Some(cell) };
        Some([common(cell[0], outline.reach[0])?, common(cell[1], outline.reach[1])?])
    }

    /// The area that its triangles cover, where parts of some lie behind others or outside the cell more than that; `None` where that is not known.
    pub(super) fn area(&self) -> Option<f64> {
        self.outline.as_ref().map(|outline| outline.area)
    }

    /// What it covers of each of some rows of so many `cells`: from a column to one, or the other way round where it is not there.
    pub(super) fn columns(&self, cells: u32, rows: Range<u32>, columns: &mut Vec<[f64; 2]>) {
        match &self.outline {
            Some(outline) => outline.columns(cells, rows.clone(), columns),
            None => {
                columns.clear();
                columns.resize(rows.len(), [f64::NEG_INFINITY, f64::INFINITY]);
            }
        }
        for (row, reach) in rows.zip(columns) {
            let cell = self.cell_columns(strip(row, cells)).unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
            *reach = [reach[0].max(cell[0]), reach[1].min(cell[1])];
        }
    }

    /// What the cell covers of the strip between two rows.
    fn cell_columns(&self, rows: [f64; 2]) -> Option<[f64; 2]> {
        let [mut least, mut most] = self.scale;
        let [low, high] = self.y;
        // s·high ≥ rows[0]
        if high > 0.0 {
            least = least.max(rows[0] / high * INWARD);
        } else if rows[0] > 0.0 {
            return None;
        } else if high < 0.0 {
            most = most.min(rows[0] / high * OUTWARD);
        }
        // s·low ≤ rows[1]
        if low < 0.0 {
            least = least.max(rows[1] / low * INWARD);
        } else if rows[1] < 0.0 {
            return None;
        } else if low > 0.0 {
            most = most.min(rows[1] / low * OUTWARD);
        }
        if least > most {
            return None;
        }
        clip(reach(self.x, [least, most]))
    }
}

/// The least and the greatest of s·x, rounded outward.
fn reach([low, high]: [f64; 2], [least, most]: [f64; 2]) -> [f64; 2] {
    let first = low * if low >= 0.0 { least * INWARD } else { most * OUTWARD };
    let last = high * if high >= 0.0 { most * OUTWARD } else { least * INWARD };
    [first, last]
}

/// The part within the face and its rim.
fn clip(range: [f64; 2]) -> Option<[f64; 2]> {
    common(range, [-1.0 - RIM, 1.0 + RIM])
}

/// What two ranges have in common.
fn common(a: [f64; 2], b: [f64; 2]) -> Option<[f64; 2]> {
    let (low, high) = (a[0].max(b[0]), a[1].min(b[1]));
    (low <= high).then_some([low, high])
}
