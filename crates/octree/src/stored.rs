//! Octrees as they are stored: feature `serde`.
//!
//! Leaves in Morton order without gaps are told by their levels alone, so a leaf takes one byte. Version 1 is the struct
//!
//! | field | type | holds |
//! |---|---|---|
//! | `version` | u32 | 1 |
//! | `cube` | 4 × u64 | the least corner x, y, z and the edge, as the bits of f64 (exact in any format) |
//! | `leaves` | bytes | a byte a leaf: bits 0–4 the level, bits 5–6 for a solid: 0 outside, 1 boundary, 2 inside |
//! | `ends` | u32s | only with items: how many items the leaves up to this one hold |
//! | `items` | u32s | only with items: the items, leaf by leaf, ascending in each |
//!
//! What is read is checked: the version, the cube, that the leaves divide it, that a solid is in its simplest form, that
//! items are in order. Nothing larger than the input is allocated.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use umbriel_geometry::Relation;

use crate::{cube::Cube, linear::LinearOctree, morton::Octant, partition::Partition, solid::SolidOctree};

const VERSION: u32 = 1;

/// Bits of a leaf's byte that hold its level.
const LEVEL_BITS: u32 = 5;

/// Why stored data is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StoredDefect {
    /// A version that is not known.
    #[error("version {0} of a stored octree; only 1 is known")]
    Version(u32),
    /// Numbers that are not accepted, or a negative edge.
    #[error("the cube is not one")]
    Cube,
    /// A leaf that does not fit behind the one before it, an unknown byte, or an end before the cube is full.
    #[error("leaf {0} does not fit")]
    Leaf(usize),
    /// Eight siblings that say the same.
    #[error("leaves that should be one are eight")]
    NotSimple,
    /// Ends or items that are out of order, too few or too many.
    #[error("the items of leaf {0} are out of order")]
    Items(usize),
}

/// The stored form of [`SolidOctree`] and [`Partition`].
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Stored {
    version: u32,
    cube: [u64; 4],
    leaves: Vec<u8>,
}

/// The stored form of [`LinearOctree`].
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StoredItems {
    version: u32,
    cube: [u64; 4],
    leaves: Vec<u8>,
    ends: Vec<u32>,
    items: Vec<u32>,
}

fn stored(partition: &Partition, sayings: impl Iterator<Item = u8>) -> Stored {
    let cube = partition.cube();
    let [x, y, z] = cube.min().to_array();
    let leaves = partition.cells().iter().zip(sayings).map(|(cell, said)| cell.level() | said << LEVEL_BITS).collect();
    Stored { version: VERSION, cube: [x, y, z, cube.edge()].map(f64::to_bits), leaves }
}

/// The leaves again, and the upper bits of their bytes.
fn restored(stored: &Stored) -> Result<(Partition, Vec<u8>), StoredDefect> {
    if stored.version != VERSION {
        return Err(StoredDefect::Version(stored.version));
    }
    let [x, y, z, edge] = stored.cube.map(f64::from_bits);
    let cube = Cube::new(DVec3::new(x, y, z), edge).ok_or(StoredDefect::Cube)?;
    let mut next = 0;
    let mut cells = Vec::with_capacity(stored.leaves.len());
    for (leaf, byte) in stored.leaves.iter().enumerate() {
        let level = byte & ((1 << LEVEL_BITS) - 1);
        let above = Octant::MAX_LEVEL.checked_sub(level).ok_or(StoredDefect::Leaf(leaf))?;
        let cell = Octant::from_bits(level, next >> (3 * u32::from(above))).ok_or(StoredDefect::Leaf(leaf))?;
        if *cell.range().start() != next {
            return Err(StoredDefect::Leaf(leaf));
        }
        next = cell.range().end() + 1;
        cells.push(cell);
    }
    let partition = Partition::new(cube, cells).map_err(|gap| StoredDefect::Leaf(gap.leaf))?;
    Ok((partition, stored.leaves.iter().map(|byte| byte >> LEVEL_BITS).collect()))
}

/// The leaves again, where nothing else is in their bytes.
fn restored_bare(stored: &Stored) -> Result<Partition, StoredDefect> {
    let (partition, sayings) = restored(stored)?;
    match sayings.iter().position(|&said| said != 0) {
        Some(leaf) => Err(StoredDefect::Leaf(leaf)),
        None => Ok(partition),
    }
}

impl From<Partition> for Stored {
    fn from(partition: Partition) -> Self {
        stored(&partition, std::iter::repeat(0))
    }
}

impl TryFrom<Stored> for Partition {
    type Error = StoredDefect;

    fn try_from(stored: Stored) -> Result<Self, StoredDefect> {
        restored_bare(&stored)
    }
}

impl From<SolidOctree> for Stored {
    fn from(tree: SolidOctree) -> Self {
        let number = |relation: &Relation| match relation {
            Relation::Outside => 0,
            Relation::Boundary => 1,
            Relation::Inside => 2,
        };
        stored(tree.partition(), tree.relations().iter().map(number))
    }
}

impl TryFrom<Stored> for SolidOctree {
    type Error = StoredDefect;

    fn try_from(stored: Stored) -> Result<Self, StoredDefect> {
        let (partition, sayings) = restored(&stored)?;
        let relation = |(leaf, said): (usize, u8)| match said {
            0 => Ok(Relation::Outside),
            1 => Ok(Relation::Boundary),
            2 => Ok(Relation::Inside),
            _ => Err(StoredDefect::Leaf(leaf)),
        };
        let relations = sayings.into_iter().enumerate().map(relation).collect::<Result<Vec<_>, _>>()?;
        Self::of_leaves(partition, relations).ok_or(StoredDefect::NotSimple)
    }
}

impl From<LinearOctree> for StoredItems {
    fn from(tree: LinearOctree) -> Self {
        let Stored { version, cube, leaves } = stored(tree.partition(), std::iter::repeat(0));
        let (ends, items) = tree.into_items();
        Self { version, cube, leaves, ends, items }
    }
}

impl TryFrom<StoredItems> for LinearOctree {
    type Error = StoredDefect;

    fn try_from(StoredItems { version, cube, leaves, ends, items }: StoredItems) -> Result<Self, StoredDefect> {
        let partition = restored_bare(&Stored { version, cube, leaves })?;
        if ends.len() != partition.cells().len() || ends.last().is_none_or(|&end| end as usize != items.len()) {
            return Err(StoredDefect::Items(ends.len()));
        }
        let mut start = 0;
        for (leaf, &end) in ends.iter().enumerate() {
            let in_order = items.get(start..end as usize).is_some_and(|items| items.is_sorted_by(|a, b| a < b));
            if !in_order {
                return Err(StoredDefect::Items(leaf));
            }
            start = end as usize;
        }
        Ok(Self::of_items(partition, ends, items))
    }
}
