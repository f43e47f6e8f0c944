//! A number of every facet, drawn as by lot, that is the same wherever the facet stands in a list: where all of too many cannot be asked, an even share of them can be.
//!
//! It is made of the digits of the facet's corners and of its object's placement, without signs and exponents and summed in no order. So it does not change
//! with the order of objects, of triangles and of their corners, of the axes and their signs, nor with powers of two. Facets that differ in these alone
//! share a lot, and no others but by chance. Cost: a few nanoseconds a corner.

use umbriel_geometry::{Facets, Placement};
use umbriel_scene::{Object, Shape};

/// The last share that a facet of this lot is in. Share 0 holds all facets, each of the next about half of the one before.
pub(crate) fn last_share(lot: u64) -> u8 {
    lot.leading_zeros() as u8
}

/// The lots of an object's facets. A mesh counts by its own coordinates, so that these do not go by how they are rounded where it stands.
pub(super) fn lots(object: &Object, facets: &Facets) -> Vec<u64> {
    let positions = match &object.shape {
        Shape::Mesh(mesh) => mesh.positions(),
        _ => facets.positions(),
    };
    let placed = of_placement(&object.placement);
    let of_corner = |&corner: &u32| of_numbers(positions[corner as usize].to_array());
    facets.iter().map(|facet| mixed(facet.corners().iter().map(of_corner).fold(placed, u64::wrapping_add))).collect()
}

fn of_placement(placement: &Placement) -> u64 {
    // What is turned and what is moved are other numbers.
    let map = placement.map();
    mixed(of_numbers(map.matrix3.to_cols_array())).wrapping_add(of_numbers(map.translation.to_array()))
}

fn of_numbers<const N: usize>(numbers: [f64; N]) -> u64 {
    let digits = |number: f64| mixed(number.to_bits() & ((1 << (f64::MANTISSA_DIGITS - 1)) - 1));
    numbers.into_iter().map(digits).fold(0, u64::wrapping_add)
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
fn mixed(number: u64) -> u64 {
    let number = (number ^ (number >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let number = (number ^ (number >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ (number >> 31)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, DMat3, DVec3};
    use umbriel_geometry::Mesh;
    use umbriel_scene::Sides;

    use super::*;

    /// Triangles at places of an irrational grid.
    fn strewn() -> Vec<[[f64; 3]; 3]> {
        let at = |k: u32| [0.754_877_666, 0.569_840_291, 0.438_579_021].map(|step: f64| (step * f64::from(k)).fract());
        (0..4096).map(|k| [at(3 * k), at(3 * k + 1), at(3 * k + 2)]).collect()
    }

    fn lots_of(triangles: &[[[f64; 3]; 3]], map: DAffine3) -> Vec<u64> {
        let positions = triangles.as_flattened().to_vec();
        let mesh = Mesh::new(positions, (0..triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect());
        let (shape, placement) = (Shape::Mesh(Arc::new(mesh.expect("a mesh"))), Placement::new(map).expect("regular"));
        let object = Object::new("object".to_owned(), shape, placement, Sides::Two).expect("an object");
        lots(&object, &object.facets().expect("flat faces"))
    }

    #[test]
    fn orders_axes_signs_and_powers_of_two_change_no_lot() {
        let triangles = strewn();
        let map = DAffine3::from_translation(DVec3::new(0.3, 7.0, -2.1));
        let before = lots_of(&triangles, map);
        let changed: Vec<_> = triangles.iter().map(|&[a, b, c]| [c, a, b].map(|[x, y, z]| [8.0 * y, -x, z])).collect();
        let swapped = DMat3::from_cols(DVec3::Z, -DVec3::X, DVec3::Y);
        assert_eq!(lots_of(&changed, DAffine3::from_mat3(swapped) * map), before);
        let moved = DAffine3::from_translation(DVec3::new(0.3, 7.0, -2.2));
        assert!(lots_of(&triangles, moved).iter().zip(&before).all(|(moved, before)| moved != before));
    }

    #[test]
    fn a_share_holds_half_of_the_one_before() {
        let all = lots_of(&strewn(), DAffine3::IDENTITY);
        for share in 0..3 {
            let count = all.iter().filter(|&&lot| last_share(lot) >= share).count() as f64;
            let expected = all.len() as f64 * 0.5f64.powi(i32::from(share));
            // Four standard deviations of a binomial distribution.
            assert!((count - expected).abs() <= 4.0 * expected.sqrt(), "{count} in share {share}");
        }
    }
}
