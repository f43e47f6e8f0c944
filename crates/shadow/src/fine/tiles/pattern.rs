//! Small lattices as vectors, each made once: faces of a mesh share a handful of them.

use std::sync::OnceLock;

use super::pack::LANES;
use crate::fine::lattice::Lattice;

/// Rows and columns of the largest lattice that is kept.
const MOST: usize = 16;

/// Eight samples of a lattice.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) u: [f32; LANES],
    pub(super) v: [f32; LANES],
    /// Row and column of each.
    pub(super) places: [[u8; 2]; LANES],
    /// Which lanes hold a sample.
    pub(super) used: u32,
}

/// The blocks of a lattice in the order of its rows; `None` for one that is too large.
pub(super) fn blocks(lattice: &Lattice) -> Option<&'static [Block]> {
    static KNOWN: [OnceLock<Vec<Block>>; 2 * (MOST + 1) * (MOST + 1)] =
        [const { OnceLock::new() }; 2 * (MOST + 1) * (MOST + 1)];
    let [rows, columns] = lattice.counts().map(|count| count as usize);
    if rows > MOST || columns > MOST {
        return None;
    }
    let index = (usize::from(lattice.is_triangle()) * (MOST + 1) + rows) * (MOST + 1) + columns;
    Some(KNOWN[index].get_or_init(|| make(lattice)))
}

fn make(lattice: &Lattice) -> Vec<Block> {
    let places = (0..lattice.counts()[0]).flat_map(|row| (0..lattice.row_len(row)).map(move |column| [row, column]));
    let places: Vec<[u32; 2]> = places.collect();
    let block = |places: &[[u32; 2]]| {
        let mut block =
            Block { u: [0.0; LANES], v: [0.0; LANES], places: [[0; 2]; LANES], used: (1 << places.len()) - 1 };
        for (lane, &[row, column]) in places.iter().enumerate() {
            block.u[lane] = lattice.coordinate(0, row) as f32;
            block.v[lane] = lattice.coordinate(1, column) as f32;
            block.places[lane] = [row as u8, column as u8];
        }
        block
    };
    places.chunks(LANES).map(block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fine::lattice::Spacing;

    #[test]
    fn blocks_hold_every_sample_once() {
        for is_triangle in [false, true] {
            for edges in [[1.0, 1.0], [1.0, 5.0], [16.0, 16.0], [7.0, 3.0]] {
                let lattice = Lattice::new(edges, Spacing::AtMost(1.0), is_triangle);
                let blocks = blocks(&lattice).expect("small enough");
                let used: u32 = blocks.iter().map(|block| block.used.count_ones()).sum();
                assert_eq!(u64::from(used), lattice.len());
            }
        }
        assert!(blocks(&Lattice::new([17.0, 1.0], Spacing::AtMost(1.0), false)).is_none());
    }
}
