//! Solids as octrees see them: where does a closed box lie, inside, outside, or on the surface?
//!
//! A [`Region`] is a surface cut into numbered parts and the solid that it encloses. It answers two questions: does a
//! part meet a closed box, and is a point off the surface enclosed? Everything else follows. A box that no part meets is
//! inside or outside as a whole, because the surface alone separates the two; a box inside another box can only be met
//! by the parts that meet the outer one, so whoever halves boxes passes the list of parts down.
//!
//! [`Facets`](crate::Facets) are a region with one part per facet. What is inside is decided by winding number: see the
//! implementation.

use glam::DVec3;

use crate::aabb::Aabb;

mod analytic;
mod facets;
mod overlap;
pub(crate) mod polytope;
#[cfg(test)]
mod tests;
mod winding;

/// Where a closed box lies, seen from a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Relation {
    /// No point of the box is in the solid or on its surface.
    Outside,
    /// The box meets the surface.
    Boundary,
    /// All points of the box are in the solid, none on its surface.
    Inside,
}

/// A solid and its surface, exact.
///
/// The surface is the union of closed parts, numbered from zero. Open pieces of surface count as surface, though they
/// enclose nothing. Boxes are closed, and their float corners are taken as they are.
pub trait Region {
    /// A box around the surface, rounded outward; empty when there is no surface.
    fn bounds(&self) -> Aabb;

    /// How many parts the surface has.
    fn parts(&self) -> u32;

    /// Whether part number `part` meets the closed box `cell`, which must have an extent on every axis: exact.
    fn meets(&self, part: u32, cell: &Aabb) -> bool;

    /// Whether `point` is in the solid: exact for points off the surface, anything on it.
    fn encloses(&self, point: DVec3) -> bool;

    /// Where the closed box lies. Cost: all parts may be asked.
    fn relation(&self, cell: &Aabb) -> Relation {
        if (0..self.parts()).any(|part| self.meets(part, cell)) {
            Relation::Boundary
        } else if self.encloses(cell.min) {
            Relation::Inside
        } else {
            Relation::Outside
        }
    }
}
