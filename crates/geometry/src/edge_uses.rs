//! The edges of faces, each with all faces that use it.
//!
//! A counting sort over the edges' lower ends, and small sorts within: O(faces + points) but for points where very many edges
//! meet. Points that are given apart are apart; [`weld`] finds those at one position.

use glam::DVec3;

/// One use of an edge by a face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct EdgeUse {
    /// The end with the higher number.
    pub high: u32,
    /// The face, and whether it runs from the lower to the higher end in bit 0.
    coded: u32,
}

impl EdgeUse {
    /// The face.
    #[inline]
    pub fn face(self) -> u32 {
        self.coded >> 1
    }

    /// Whether the face runs from the lower end to the higher.
    #[inline]
    pub fn is_upward(self) -> bool {
        self.coded & 1 == 1
    }
}

/// The uses of all edges, by their lower ends.
#[derive(Clone, Debug, Default)]
pub struct EdgeUses {
    uses: Vec<EdgeUse>,
    /// Where the uses of each lower end stop.
    stops: Vec<u32>,
}

impl EdgeUses {
    /// More faces have no table: a face and a bit share 32 bits.
    pub const MAX_FACES: usize = 1 << 31;

    /// Of faces over `points` points, fewer than [`EdgeUses::MAX_FACES`]: `edges` yields their edges as from, to, face.
    /// Edges without length are left out.
    pub fn of(points: usize, edges: impl Iterator<Item = [u32; 3]> + Clone) -> Self {
        let mut uses = Self::default();
        uses.gather(points, edges);
        uses
    }

    /// As [`EdgeUses::of`], in the room of what was gathered before.
    pub fn gather(&mut self, points: usize, edges: impl Iterator<Item = [u32; 3]> + Clone) {
        let edges = edges.filter(|[from, to, _]| from != to);
        self.stops.clear();
        self.stops.resize(points + 1, 0);
        edges.clone().for_each(|[from, to, _]| self.stops[from.min(to) as usize + 1] += 1);
        for point in 0..points {
            self.stops[point + 1] += self.stops[point];
        }
        self.uses.clear();
        self.uses.resize(self.stops[points] as usize, EdgeUse::default());
        edges.for_each(|[from, to, face]| {
            // Each start moves to its stop.
            let place = &mut self.stops[from.min(to) as usize];
            self.uses[*place as usize] = EdgeUse { high: from.max(to), coded: face << 1 | u32::from(from < to) };
            *place += 1;
        });
        self.stops.truncate(points);
        let mut start = 0;
        for &stop in &self.stops {
            self.uses[start..stop as usize].sort_unstable();
            start = stop as usize;
        }
    }

    /// How many uses there are.
    pub fn len(&self) -> usize {
        self.uses.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.uses.is_empty()
    }

    /// The edges in ascending order: the lower end, and the uses by ascending face.
    pub fn edges(&self) -> impl Iterator<Item = (u32, &[EdgeUse])> {
        let starts = std::iter::once(0).chain(self.stops.iter().copied());
        (0..).zip(starts.zip(&self.stops)).flat_map(move |(low, (start, &stop))| {
            let uses = self.uses[start as usize..stop as usize].chunk_by(|a, b| a.high == b.high);
            uses.map(move |uses| (low, uses))
        })
    }
}

/// Whether as many uses run up an edge as run down.
pub fn cancel(uses: &[EdgeUse]) -> bool {
    2 * uses.iter().filter(|usage| usage.is_upward()).count() == uses.len()
}

/// The edges of a triangle, with its number.
#[inline]
pub fn edges_of([a, b, c]: [u32; 3], face: u32) -> [[u32; 3]; 3] {
    [[a, b, face], [b, c, face], [c, a, face]]
}

/// For each point the first one at its position; `None` where no two points share one. O(points), by hashing.
pub fn weld(positions: &[DVec3]) -> Option<Vec<u32>> {
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

    #[test]
    fn uses_come_by_edge_and_face() {
        let triangles = [[0, 1, 2], [2, 1, 3], [0, 0, 3]];
        let edges = (0..).zip(triangles).flat_map(|(face, corners)| edges_of(corners, face));
        let uses = EdgeUses::of(4, edges);
        let flat = |(low, uses): (u32, &[EdgeUse])| {
            (low, uses[0].high, uses.iter().map(|usage| (usage.face(), usage.is_upward())).collect::<Vec<_>>())
        };
        let expected = [
            (0, 1, vec![(0, true)]),
            (0, 2, vec![(0, false)]),
            (0, 3, vec![(2, false), (2, true)]),
            (1, 2, vec![(0, true), (1, false)]),
            (1, 3, vec![(1, true)]),
            (2, 3, vec![(1, false)]),
        ];
        assert_eq!(uses.edges().map(flat).collect::<Vec<_>>(), expected);
        assert_eq!(uses.edges().filter(|(_, uses)| cancel(uses)).count(), 2);
        assert_eq!(EdgeUses::of(0, std::iter::empty()).edges().count(), 0);
    }

    #[test]
    fn points_at_one_position_are_the_first_of_them() {
        assert_eq!(weld(&[DVec3::X, DVec3::Y, DVec3::ZERO]), None);
        assert_eq!(weld(&[DVec3::X, DVec3::ZERO, DVec3::X, -DVec3::ZERO]), Some(vec![0, 1, 0, 1]));
    }
}
