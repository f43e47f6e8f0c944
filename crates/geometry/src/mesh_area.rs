//! The area of a placed mesh without placing it: what all instances of it may have, for one pass through its triangles.
//!
//! Question: between which bounds does the sum of [`Facets::areas`](crate::Facets::areas) lie, errors included? Between the local area times the least and
//! the greatest stretch of the placement, but for what rounding moves the placed corners (NUMERICS.md, "Areas"). Under similarities the bounds are
//! within roundings of each other. Cost: ten operations a triangle once, some dozen a placement.

use glam::DVec3;

use crate::{
    aabb::Aabb,
    approx::{Approx, UNIT_ROUNDOFF},
    mesh::Mesh,
    placement::Placement,
    stretch::{between, cofactors, stretches},
};

/// Roundings of a triangle's area in floats, and of the area of its image with its bound, in units of the product of two sides.
const ROUNDINGS: f64 = 128.0;

/// Sums over the triangles of a mesh, local coordinates, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshArea {
    triangles: f64,
    /// Of their areas.
    area: f64,
    /// Of the lengths of two sides of each, and of the products of these lengths.
    sides: f64,
    products: f64,
}

impl MeshArea {
    /// Goes through the triangles of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        let mut all = Self { triangles: mesh.triangles().len() as f64, area: 0.0, sides: 0.0, products: 0.0 };
        for corners in mesh.triangles() {
            let [a, b, c] = corners.map(|corner| mesh.positions()[corner as usize]);
            let (to_b, to_c) = (b - a, c - a);
            let sides = [to_b.length(), to_c.length()];
            all.area += 0.5 * to_b.cross(to_c).length();
            all.sides += sides[0] + sides[1];
            all.products += sides[0] * sides[1];
        }
        all
    }

    /// Bounds on the area of the mesh as it is placed, square metres, world; `bounds` holds the placed corners.
    pub fn placed(&self, placement: &Placement, bounds: &Aabb) -> Approx {
        let Self { triangles, area, sides, products } = *self;
        let [least, most] = stretches(&cofactors(placement));
        let matrix = placement.map().matrix3;
        let squared: f64 = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::length_squared).iter().sum();
        // Each coordinate of a corner is off by half an ulp of the largest at most.
        let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
        let moved = 2.0 * UNIT_ROUNDOFF * farthest;
        let off = (ROUNDINGS + 2.0 * triangles) * UNIT_ROUNDOFF * squared * products
            + 2.0 * moved * squared.sqrt() * sides
            + 4.0 * triangles * moved * moved;
        between((least * area - off).max(0.0), (most * area + off) * (1.0 + 4.0 * f64::EPSILON))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DAffine3;
    use proptest::prelude::*;

    use super::*;
    use crate::Facets;

    proptest! {
        #[test]
        fn the_area_of_what_is_placed_is_within(
            corners in proptest::collection::vec(proptest::array::uniform3(-8..8i32), 3..40), fine in -30..1i32, tall in -30..4i32,
            entries in proptest::array::uniform9(-2.0..2.0f64), far in proptest::array::uniform3(-1e9..1e9f64), is_similar: bool, is_near: bool,
        ) {
            let size = DVec3::new(2f64.powi(fine), 2f64.powi(tall), 0.3);
            let positions = corners.iter().map(|corner| (DVec3::from_array(corner.map(f64::from)) * size).to_array()).collect();
            let triangles = (2..corners.len() as u32).map(|k| [k - 2, k - 1, k]).collect();
            let mesh = Arc::new(Mesh::new(positions, triangles).expect("a mesh"));
            let mut map = DAffine3::from_cols_array(&std::array::from_fn(|k| if k < 9 { entries[k] } else { far[k - 9] }));
            if is_similar {
                map.matrix3 = glam::DMat3::from_rotation_y(entries[0]) * entries[1];
            }
            if is_near {
                map.translation *= 1e-9;
            }
            let Ok(placement) = Placement::new(map) else { return Ok(()) };
            let facets = Facets::of_mesh(Arc::clone(&mesh), &placement);
            let rough = MeshArea::of(&mesh).placed(&placement, &facets.bounds());
            let [lower, upper] = [-1.0, 1.0].map(|side| facets.areas().map(|area| (area.value + side * area.error).max(0.0)).sum::<f64>());
            // The sums of the test are rounded, too.
            prop_assert!(rough.lower() <= lower * (1.0 + 1e-14) && upper * (1.0 - 1e-14) <= rough.upper(), "{rough:?} {lower} {upper}");
            // Under similarities nothing but rounding is left, of products of lengths that the bounds hold.
            let reach = facets.bounds().min.abs().max(facets.bounds().max.abs()).max_element();
            let triangles = mesh.triangles().len() as f64;
            prop_assert!(!is_similar || rough.error <= 4e-12 * triangles * reach * reach, "{rough:?}");
        }
    }
}
