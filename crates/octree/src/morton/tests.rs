use proptest::prelude::*;

use super::*;

/// The definition, bit by bit.
fn interleave(coordinates: &[u32], bits: usize) -> u64 {
    let dimensions = coordinates.len();
    let bit = |axis: usize, bit: usize| u64::from(coordinates[axis] >> bit & 1) << (bit * dimensions + axis);
    (0..dimensions).flat_map(|axis| (0..bits).map(move |b| (axis, b))).map(|(axis, b)| bit(axis, b)).sum()
}

fn octant() -> impl Strategy<Value = Octant> {
    (0..=Octant::MAX_LEVEL, any::<u64>()).prop_map(|(level, bits)| {
        let mask = (1u64 << (3 * u32::from(level))) - 1;
        Octant::from_bits(level, bits & mask).expect("within its level")
    })
}

fn quadrant() -> impl Strategy<Value = Quadrant> {
    (0..=Quadrant::MAX_LEVEL, any::<[u32; 2]>()).prop_map(|(level, c)| {
        let mask = ((1u64 << level) - 1) as u32;
        Quadrant::at(level, c.map(|c| c & mask)).expect("within its level")
    })
}

proptest! {
    #[test]
    fn codes_interleave(c in any::<[u32; 3]>()) {
        prop_assert_eq!(encode2([c[0], c[1]]), interleave(&c[..2], 32));
        prop_assert_eq!(decode2(encode2([c[0], c[1]])), [c[0], c[1]]);
        let low = c.map(|c| c & 0x001F_FFFF);
        prop_assert_eq!(encode3(c), interleave(&low, 21));
        prop_assert_eq!(decode3(encode3(c)), low);
    }

    #[test]
    fn cells_are_told_apart_by_their_coordinates(cell in octant(), flat in quadrant()) {
        prop_assert_eq!(Octant::at(cell.level(), cell.coordinates()), Some(cell));
        prop_assert_eq!(Quadrant::at(flat.level(), flat.coordinates()), Some(flat));
        prop_assert_eq!(Quadrant::from_bits(flat.level(), flat.bits()), Some(flat));
    }

    #[test]
    fn children_divide_their_parent(cell in octant(), flat in quadrant()) {
        let children: Vec<Octant> = cell.children().collect();
        if let (Some(first), Some(last)) = (children.first(), children.last()) {
            prop_assert_eq!(*first.range().start()..=*last.range().end(), cell.range());
        }
        for pair in children.windows(2) {
            prop_assert_eq!(pair[0].range().end() + 1, *pair[1].range().start());
        }
        for child in children {
            prop_assert!(child.parent() == Some(cell) && cell.contains(child) && !child.contains(cell) && cell < child);
            prop_assert_eq!(child.coordinates().map(|c| c >> 1), cell.coordinates());
        }
        for child in flat.children() {
            prop_assert!(child.parent() == Some(flat) && flat.contains(child) && flat < child);
            prop_assert_eq!(child.coordinates().map(|c| c >> 1), flat.coordinates());
        }
    }

    #[test]
    fn containment_is_that_of_ranges(a in quadrant(), b in quadrant(), level in 0..=32u8) {
        let holds = |a: Quadrant, b: Quadrant| {
            a.range().contains(b.range().start()) && a.range().contains(b.range().end()) && a.level() <= b.level()
        };
        prop_assert_eq!(a.contains(b), holds(a, b));
        match a.ancestor(level) {
            Some(above) => prop_assert!(above.contains(a) && above.level() == level && above <= a),
            None => prop_assert!(level > a.level()),
        }
    }
}

#[test]
fn the_ends_of_the_range_hold() {
    assert_eq!(Quadrant::ROOT.range(), 0..=u64::MAX);
    assert_eq!(Octant::ROOT.range(), 0..=(1 << 63) - 1);
    let last = Quadrant::at(32, [u32::MAX; 2]).expect("the last cell");
    assert_eq!((last.range(), last.child(0)), (u64::MAX..=u64::MAX, None));
    assert_eq!(last.ancestor(0), Some(Quadrant::ROOT));
    assert_eq!(Octant::ROOT.parent(), None);
    assert_eq!(Octant::ROOT.child(8), None);
    assert_eq!(Octant::at(22, [0; 3]), None);
    assert_eq!(Octant::at(1, [2, 0, 0]), None);
    assert_eq!(Octant::from_bits(1, 8), None);
    assert_eq!(Quadrant::from_bits(33, 0), None);
}
