use proptest::prelude::*;

use super::*;

fn cells(face: Face, level: u8) -> Vec<Quadrant> {
    (0..level).fold(vec![Quadrant::ROOT], |cells, _| cells.into_iter().flat_map(|cell| face.children(cell)).collect())
}

/// Area of a polygon by the shoelace rule.
fn area(corners: &[[f64; 2]]) -> f64 {
    let next = |index: usize| corners[(index + 1) % corners.len()];
    corners.iter().enumerate().map(|(index, a)| (a[0] * next(index)[1] - a[1] * next(index)[0]) / 2.0).sum()
}

#[test]
fn a_level_covers_the_face_once_and_in_order() {
    for (face, whole) in [(Face::Square, 1.0), (Face::Triangle, 0.5)] {
        for level in 0..6 {
            let cells = cells(face, level);
            assert!(cells.is_sorted(), "Morton order");
            assert_eq!(cells.iter().map(|&cell| face.share(cell)).sum::<f64>(), 1.0);
            for &cell in &cells {
                let corners: Vec<_> = face.corners(cell).collect();
                assert_eq!(area(&corners), face.share(cell) * whole, "{cell:?}");
                assert!(corners.iter().all(|[u, v]| face == Face::Square || u + v <= 1.0), "{cell:?}");
            }
        }
    }
}

#[test]
fn cells_beyond_the_diagonal_are_no_part_of_a_triangle() {
    let beyond = Quadrant::at(3, [4, 4]).expect("a cell");
    assert!(Face::Square.has(beyond) && !Face::Triangle.has(beyond));
    assert_eq!(Face::Triangle.share(beyond), 0.0);
    assert!(Face::Triangle.halves(Quadrant::ROOT) && !Face::Square.halves(Quadrant::ROOT));
}

proptest! {
    #[test]
    fn children_divide_their_cell_at_any_depth(level in 0u8..32, place in any::<[u32; 2]>()) {
        let mask = ((1u64 << level) - 1) as u32;
        let cell = Quadrant::at(level, place.map(|c| c & mask)).expect("within its level");
        for face in [Face::Square, Face::Triangle] {
            let below: f64 = face.children(cell).map(|child| face.share(child)).sum();
            prop_assert_eq!(below, face.share(cell));
        }
    }
}
