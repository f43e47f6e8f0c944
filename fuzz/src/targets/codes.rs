//! Octree codes: what is named is found again, and stored octrees are read or refused.

use umbriel_octree::{
    Direction, LinearOctree, Octant, Partition, Quadrant, SolidOctree, decode2, decode3, encode2, encode3,
};

pub(super) fn codes(bytes: &[u8]) {
    let (numbers, rest) = bytes.split_at(bytes.len().min(9));
    let mut number = [0; 8];
    let level = numbers.first().copied().unwrap_or(0);
    number[..numbers.len().saturating_sub(1)].copy_from_slice(numbers.get(1..).unwrap_or_default());
    let bits = u64::from_le_bytes(number);
    are_inverse(bits);
    let level = level % (Octant::MAX_LEVEL + 2);
    if let Some(cell) = Octant::from_bits(level, bits) {
        octant(cell);
    }
    if let Some(cell) = Quadrant::from_bits(level, bits) {
        assert_eq!(Quadrant::at(level, cell.coordinates()), Some(cell));
        assert!(cell.children().all(|child| child.parent() == Some(cell) && cell.contains(child)));
    }
    stored(rest);
}

fn are_inverse(bits: u64) {
    assert_eq!(encode2(decode2(bits)), bits);
    let low = bits & (u64::MAX >> 1);
    assert_eq!(encode3(decode3(low)), low);
}

fn octant(cell: Octant) {
    assert_eq!(Octant::at(cell.level(), cell.coordinates()), Some(cell));
    assert!((0..=cell.level()).all(|level| cell.ancestor(level).is_some_and(|above| above.contains(cell))));
    let mut next = *cell.range().start();
    for child in cell.children() {
        assert!(child.parent() == Some(cell) && cell < child && *child.range().start() == next);
        next = child.range().end() + 1;
    }
    for direction in Direction::all() {
        let Some(beside) = cell.neighbour(direction) else { continue };
        assert_eq!(beside.neighbour(direction.opposite()), Some(cell));
        assert!(!beside.contains(cell));
    }
}

/// Leaves and items as a file would hold them.
fn stored(bytes: &[u8]) {
    let items = bytes.first().map_or(0, |&count| usize::from(count)).min(bytes.len());
    let (items, leaves) = bytes.split_at(items);
    let (ends, items) = items.split_at(items.len().min(leaves.len()));
    let cube = [0.0, 0.0, 0.0, 8.0].map(f64::to_bits);
    let bare = serde_json::json!({ "version": 1, "cube": cube, "leaves": leaves });
    let full = serde_json::json!({ "version": 1, "cube": cube, "leaves": leaves, "ends": ends, "items": items });
    if let Ok(partition) = serde_json::from_value::<Partition>(bare.clone()) {
        assert_eq!(partition.check(), Ok(()));
        assert_eq!(serde_json::to_value(&partition).expect("stored"), bare);
    }
    if let Ok(tree) = serde_json::from_value::<SolidOctree>(bare.clone()) {
        assert_eq!(serde_json::to_value(&tree).expect("stored"), bare);
    }
    if let Ok(tree) = serde_json::from_value::<LinearOctree>(full.clone()) {
        assert_eq!(tree.partition().check(), Ok(()));
        assert_eq!(serde_json::to_value(&tree).expect("stored"), full);
    }
}
