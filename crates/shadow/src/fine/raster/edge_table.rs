//! Which facets of a body share an edge: what border edges are found from, for one light after the other.
//!
//! Points at equal positions are one point. The uses of each edge are brought together by a counting sort over the
//! edge's lower end and small sorts within. Edges of ordinary sheets, used once each way by two facets, take 16 bytes;
//! all others (open, non-manifold, turned neighbours) are kept use by use. O(facets + points) but for points where very
//! many edges meet.

use glam::DVec3;
use umbriel_geometry::Facets;

/// A body with more facets has no table: a facet and a bit share 32 bits.
pub(crate) const MAX_FACETS: usize = 1 << 31;

/// An edge that two facets use, in opposite directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SharedEdge {
    /// In the direction in which the first facet runs along it.
    pub(crate) ends: [u32; 2],
    pub(crate) facets: [u32; 2],
}

/// One use of an edge that is not a [`SharedEdge`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EdgeUse {
    /// Lower number first.
    pub(crate) ends: [u32; 2],
    pub(crate) facet: u32,
    /// From the lower end to the higher.
    pub(crate) is_forward: bool,
}

/// The edges of one body.
#[derive(Clone, Debug, Default)]
pub(crate) struct EdgeTable {
    pub(crate) shared: Vec<SharedEdge>,
    /// Uses of one edge side by side.
    pub(crate) others: Vec<EdgeUse>,
}

impl EdgeTable {
    /// The edges of `facets`, of which there are fewer than [`MAX_FACETS`].
    pub(crate) fn of(facets: &Facets) -> Self {
        // The corners of parallelograms are distinct points even where their floats agree.
        let ids = if facets.triangles().is_some() { weld(facets.positions()) } else { None };
        let id = |point: u32| ids.as_ref().map_or(point, |ids| ids[point as usize]);
        let points = facets.positions().len();
        let uses = LowEnds::of(points, |visit| for_each_edge(facets, id, visit));
        let mut table = Self { shared: Vec::with_capacity(uses.entries.len() / 2), others: Vec::new() };
        for low in 0..points as u32 {
            table.add(low, uses.at(low));
        }
        table
    }

    /// Adds the edges with a common lower end; each entry is the higher end, and the facet with the direction in bit 0.
    fn add(&mut self, low: u32, entries: &[[u32; 2]]) {
        let direction = |entry: &[u32; 2]| entry[1] & 1;
        for uses in entries.chunk_by(|a, b| a[0] == b[0]) {
            match uses {
                [a, b] if direction(a) != direction(b) => {
                    let ends = if direction(a) == 1 { [low, a[0]] } else { [a[0], low] };
                    self.shared.push(SharedEdge { ends, facets: [a[1] >> 1, b[1] >> 1] });
                }
                _ => self.others.extend(uses.iter().map(|entry| EdgeUse {
                    ends: [low, entry[0]],
                    facet: entry[1] >> 1,
                    is_forward: direction(entry) == 1,
                })),
            }
        }
    }
}

/// Calls `visit` with all edges in the direction of their facets: from, to, facet. Edges without length are left out.
fn for_each_edge(facets: &Facets, id: impl Fn(u32) -> u32, mut visit: impl FnMut(u32, u32, u32)) {
    let mut add = |from: u32, to: u32, facet: usize| {
        if from != to {
            visit(from, to, facet as u32);
        }
    };
    if let Some(triangles) = facets.triangles() {
        for (facet, corners) in triangles.iter().enumerate() {
            let [a, b, c] = corners.map(&id);
            add(a, b, facet);
            add(b, c, facet);
            add(c, a, facet);
        }
        return;
    }
    for (facet, corners) in facets.iter().map(|facet| facet.corners()).enumerate() {
        for (k, &from) in corners.iter().enumerate() {
            add(id(from), id(corners[(k + 1) % corners.len()]), facet);
        }
    }
}

/// Edges sorted by their lower end.
struct LowEnds {
    /// Where the entries of each point begin; one more at the end.
    starts: Vec<u32>,
    entries: Vec<[u32; 2]>,
}

impl LowEnds {
    /// `edges` calls what it is given with each edge: from, to, facet.
    fn of(points: usize, edges: impl Fn(&mut dyn FnMut(u32, u32, u32))) -> Self {
        let mut starts = vec![0u32; points + 2];
        edges(&mut |from, to, _| starts[from.min(to) as usize + 2] += 1);
        for point in 2..starts.len() {
            starts[point] += starts[point - 1];
        }
        let mut entries = vec![[0; 2]; starts[points + 1] as usize];
        edges(&mut |from, to, facet| {
            let next = &mut starts[from.min(to) as usize + 1];
            entries[*next as usize] = [from.max(to), facet << 1 | u32::from(from < to)];
            *next += 1;
        });
        let mut sorted = Self { starts, entries };
        for point in 0..points {
            let range = sorted.starts[point] as usize..sorted.starts[point + 1] as usize;
            sorted.entries[range].sort_unstable();
        }
        sorted
    }

    fn at(&self, low: u32) -> &[[u32; 2]] {
        &self.entries[self.starts[low as usize] as usize..self.starts[low as usize + 1] as usize]
    }
}

/// For each point the first one at its position; `None` where no two points share one.
fn weld(positions: &[DVec3]) -> Option<Vec<u32>> {
    const EMPTY: u32 = u32::MAX;
    let size = (2 * positions.len()).next_power_of_two();
    let mut slots = vec![EMPTY; size];
    let mut firsts: Option<Vec<u32>> = None;
    for (point, &position) in positions.iter().enumerate() {
        let mut slot = hash(position) as usize & (size - 1);
        while slots[slot] != EMPTY && positions[slots[slot] as usize] != position {
            slot = (slot + 1) & (size - 1);
        }
        if slots[slot] == EMPTY {
            slots[slot] = point as u32;
        } else {
            firsts.get_or_insert_with(|| (0..positions.len() as u32).collect())[point] = slots[slot];
        }
    }
    firsts
}

/// Mixes the bits of three coordinates (multiplication by odd constants, high half folded down).
fn hash(position: DVec3) -> u64 {
    // Adding zero makes −0 and 0 one number.
    position.to_array().into_iter().fold(0, |hash: u64, coordinate| {
        let mixed = (hash ^ (coordinate + 0.0).to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ (mixed >> 29)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbriel_geometry::{Cuboid, Mesh, Placement};

    #[test]
    fn a_box_has_twelve_shared_edges() {
        let facets = Facets::of_cuboid(&Cuboid { size: [1.0, 2.0, 3.0] }, &Placement::IDENTITY);
        let table = EdgeTable::of(&facets);
        assert_eq!((table.shared.len(), table.others.len()), (12, 0));
    }

    #[test]
    fn equal_positions_join_and_odd_edges_keep_their_uses() {
        let positions =
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let mesh = Mesh::new(positions, vec![[0, 1, 2], [3, 5, 4], [0, 1, 5]]).expect("a mesh");
        let table = EdgeTable::of(&Facets::of_mesh(mesh, &Placement::IDENTITY));
        // 1–2 is shared; 0–1 and 1–5 are used twice the same way; 2–5 and 0–2, 0–5 once.
        assert_eq!(table.shared, [SharedEdge { ends: [1, 2], facets: [0, 1] }]);
        assert_eq!(table.others.len(), 7);
        assert_eq!(table.others.iter().filter(|usage| usage.ends == [0, 1] && usage.is_forward).count(), 2);
    }
}
