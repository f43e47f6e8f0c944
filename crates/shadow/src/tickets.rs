//! A number of every facet, and one of every object, as if drawn, that is the same wherever they stand in a list: where all of too many cannot be asked, every second,
//! fourth or eighth of them can be.
//!
//! It is made of the digits of the facet's corners and of its object's placement, of an object of those of its world box, without signs and exponents, each corner and each row by
//! itself, and summed in no order. So it does not change with the order of objects, of triangles and of their corners, of the axes and their signs, nor with powers of two. Facets that
//! differ in these alone have one ticket, others by chance. Cost: some ten nanoseconds a facet.

use umbriel_geometry::{Aabb, Facets, Placement};
use umbriel_scene::{Object, Shape};

/// How often the facets can be halved until one with this ticket is left out.
pub(crate) fn halvings(ticket: u64) -> u8 {
    ticket.leading_zeros() as u8
}

/// The tickets of an object's facets. A mesh counts by its own coordinates, so that these do not go by how they are rounded where it stands.
pub(crate) fn tickets(object: &Object, facets: &Facets) -> Vec<u64> {
    let positions = match &object.shape {
        Shape::Mesh(mesh) => mesh.positions(),
        _ => facets.positions(),
    };
    let placed = of_placement(&object.placement);
    let of_corner = |&corner: &u32| of_numbers(positions[corner as usize].to_array());
    facets.iter().map(|facet| mixed(facet.corners().iter().map(of_corner).fold(placed, u64::wrapping_add))).collect()
}

/// The ticket of an object, by its world box.
pub(crate) fn of_box(bounds: &Aabb) -> u64 {
    let of_axis = |axis: usize| of_numbers([bounds.min[axis], bounds.max[axis]]);
    mixed((0..3).map(of_axis).fold(0, u64::wrapping_add))
}

fn of_placement(placement: &Placement) -> u64 {
    let map = placement.map();
    let row = |axis: usize| {
        let [x, y, z] = map.matrix3.row(axis).to_array();
        of_numbers([x, y, z, map.translation[axis]])
    };
    (0..3).map(row).fold(0, u64::wrapping_add)
}

fn of_numbers<const N: usize>(numbers: [f64; N]) -> u64 {
    let digits = |number: f64| mixed(number.to_bits() & ((1 << (f64::MANTISSA_DIGITS - 1)) - 1));
    mixed(numbers.into_iter().map(digits).fold(0, u64::wrapping_add))
}

/// The next number of SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
fn mixed(number: u64) -> u64 {
    let number = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
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

    fn tickets_of(triangles: &[[[f64; 3]; 3]], map: DAffine3) -> Vec<u64> {
        let positions = triangles.as_flattened().to_vec();
        let mesh = Mesh::new(positions, (0..triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect());
        let (shape, placement) = (Shape::Mesh(Arc::new(mesh.expect("a mesh"))), Placement::new(map).expect("regular"));
        let object = Object::new("object".to_owned(), shape, placement, Sides::Two).expect("an object");
        tickets(&object, &object.facets().expect("flat faces"))
    }

    #[test]
    fn orders_axes_signs_and_powers_of_two_change_no_ticket() {
        let triangles = strewn();
        let map = DAffine3::from_translation(DVec3::new(0.3, 7.0, -2.1));
        let before = tickets_of(&triangles, map);
        let changed: Vec<_> = triangles.iter().map(|&[a, b, c]| [c, a, b].map(|[x, y, z]| [8.0 * y, -x, z])).collect();
        let swapped = DMat3::from_cols(DVec3::Z, -DVec3::X, DVec3::Y);
        assert_eq!(tickets_of(&changed, DAffine3::from_mat3(swapped) * map), before);
        let moved = DAffine3::from_translation(DVec3::new(0.3, 7.0, -2.2));
        assert!(tickets_of(&triangles, moved).iter().zip(&before).all(|(moved, before)| moved != before));
    }

    #[test]
    fn boxes_have_tickets_of_their_own_whichever_way_they_lie() {
        let boxes: Vec<Aabb> = strewn().into_iter().map(|corners| Aabb::of(corners.map(DVec3::from_array))).collect();
        let before: Vec<u64> = boxes.iter().map(of_box).collect();
        let turned = |point: DVec3| 4.0 * DVec3::new(-point.z, point.x, point.y);
        let after = boxes.iter().map(|bounds| of_box(&Aabb::of([turned(bounds.min), turned(bounds.max)])));
        assert!(after.eq(before.iter().copied()));
        let left = before.iter().filter(|&&ticket| halvings(ticket) >= 4).count();
        assert!((192..320).contains(&left), "{left} of 4096 are a sixteenth");
    }

    #[test]
    fn halves_are_even() {
        let all = tickets_of(&strewn(), DAffine3::IDENTITY);
        for times in 0..3 {
            let count = all.iter().filter(|&&ticket| halvings(ticket) >= times).count() as f64;
            let expected = all.len() as f64 * 0.5f64.powi(i32::from(times));
            // Four standard deviations of a binomial distribution.
            assert!((count - expected).abs() <= 4.0 * expected.sqrt(), "{count} left after {times}");
        }
    }

    #[test]
    fn whole_numbers_are_told_apart() {
        let at = |k: u32| [f64::from(k % 16), 0.0, f64::from(k / 16)];
        let triangles: Vec<_> = (0..240).filter(|k| k % 16 < 15).map(|k| [at(k), at(k + 1), at(k + 16)]).collect();
        let all = tickets_of(&triangles, DAffine3::IDENTITY);
        assert!(all.iter().all(|&ticket| halvings(ticket) < 20), "none is left for ever");
        let distinct: std::collections::HashSet<u64> = all.iter().copied().collect();
        // 3 and 6 have the same digits, and so on: exponents do not count.
        assert!(distinct.len() > 50, "{} of {}", distinct.len(), all.len());
    }
}
