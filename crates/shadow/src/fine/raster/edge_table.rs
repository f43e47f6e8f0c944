//! Which facets of a body share an edge: what border edges are found from, for one light after the other.
//!
//! Points at equal positions are one point. Edges of ordinary sheets, used once each way by two facets, take 16 bytes;
//! all others (open, non-manifold, turned neighbours) are kept use by use. O(facets + points) but for points where very
//! many edges meet.

use umbriel_geometry::{
    Facets,
    edge_uses::{EdgeUse, EdgeUses, edges_of},
};

/// A body with more facets has no table.
pub(crate) const MAX_FACETS: usize = EdgeUses::MAX_FACES;

/// An edge that two facets use, in opposite directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SharedEdge {
    /// In the direction in which the first facet runs along it.
    pub(crate) ends: [u32; 2],
    pub(crate) facets: [u32; 2],
}

/// One use of an edge that is not a [`SharedEdge`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OtherUse {
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
    pub(crate) others: Vec<OtherUse>,
}

impl EdgeTable {
    /// The edges of `facets`, of which there are fewer than [`MAX_FACETS`].
    pub(crate) fn of(facets: &Facets) -> Self {
        let points = facets.positions().len();
        let uses = match (facets.triangles(), facets.firsts()) {
            (Some(triangles), None) => {
                EdgeUses::of(points, (0..).zip(triangles).flat_map(|(face, &corners)| edges_of(corners, face)))
            }
            (Some(triangles), Some(firsts)) => {
                let welded = |corners: &[u32; 3]| corners.map(|corner| firsts[corner as usize]);
                EdgeUses::of(points, (0..).zip(triangles).flat_map(|(face, corners)| edges_of(welded(corners), face)))
            }
            (None, _) => {
                let edges = (0..facets.len() as u32).flat_map(|face| {
                    let corners = facets.facet(face as usize).corners();
                    (0..corners.len()).map(move |k| [corners[k], corners[(k + 1) % corners.len()], face])
                });
                EdgeUses::of(points, edges)
            }
        };
        let mut table = Self { shared: Vec::with_capacity(uses.len() / 2), others: Vec::new() };
        uses.edges().for_each(|(low, uses)| table.add(low, uses));
        table
    }

    /// Adds an edge by its lower end.
    fn add(&mut self, low: u32, uses: &[EdgeUse]) {
        match uses {
            [a, b] if a.is_upward() != b.is_upward() => {
                let ends = if a.is_upward() { [low, a.high] } else { [a.high, low] };
                self.shared.push(SharedEdge { ends, facets: [a.face(), b.face()] });
            }
            _ => self.others.extend(uses.iter().map(|usage| OtherUse {
                ends: [low, usage.high],
                facet: usage.face(),
                is_forward: usage.is_upward(),
            })),
        }
    }
}

#[cfg(test)]
mod tests {
    use umbriel_geometry::{Cuboid, Mesh, Placement};

    use super::*;

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
