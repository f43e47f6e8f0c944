//! Exact-position topology: which triangles hang together, and which of those surfaces are closed.
//!
//! Vertices with equal coordinates are one vertex. Triangles that share an edge belong to one component. A component is
//! closed when the directed uses of every one of its edges cancel.

use glam::DVec3;

use crate::{
    disjoint_sets::DisjointSets,
    edge_uses::{EdgeUses, cancel, edges_of},
};

/// A set of triangles joined by edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Component {
    /// How many triangles it has.
    pub triangles: usize,
    /// How many of its edges have directed uses that do not cancel; closed means none.
    pub open_edges: usize,
}

impl Component {
    /// Whether every edge's directed uses cancel.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0
    }
}

/// The components of a set of triangles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topology {
    /// The components, in the order of their first triangles.
    pub components: Vec<Component>,
    /// The component of each triangle.
    pub component_of: Vec<u32>,
}

impl Topology {
    /// The components of `triangles` over vertices that are already one per position. O(triangles + vertices).
    pub fn of(triangles: impl ExactSizeIterator<Item = [u32; 3]> + Clone) -> Self {
        let count = triangles.len();
        let vertices = triangles.clone().flatten().max().map_or(0, |highest| highest as usize + 1);
        let edges = (0..).zip(triangles).flat_map(|(triangle, corners)| edges_of(corners, triangle));
        let uses = EdgeUses::of(vertices, edges);
        let mut sets = DisjointSets::new(count);
        for (_, edge) in uses.edges() {
            for pair in edge.windows(2) {
                sets.join(pair[0].face(), pair[1].face());
            }
        }
        let mut number_of_root = vec![u32::MAX; count];
        let mut topology = Self::default();
        for triangle in 0..count as u32 {
            let root = sets.root(triangle) as usize;
            if number_of_root[root] == u32::MAX {
                number_of_root[root] = topology.components.len() as u32;
                topology.components.push(Component::default());
            }
            topology.component_of.push(number_of_root[root]);
            topology.components[number_of_root[root] as usize].triangles += 1;
        }
        for (_, edge) in uses.edges().filter(|(_, edge)| !cancel(edge)) {
            let component = topology.component_of[edge[0].face() as usize];
            topology.components[component as usize].open_edges += 1;
        }
        topology
    }
}

/// Names each distinct position once: the distinct positions in lexicographic order, and each input's place there.
pub(crate) fn unify(positions: &[DVec3]) -> (Vec<DVec3>, Vec<u32>) {
    let key = |index: u32| positions[index as usize].to_array();
    let compare =
        |a: [f64; 3], b: [f64; 3]| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]));
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| compare(key(a), key(b)));
    let mut distinct: Vec<DVec3> = Vec::new();
    let mut place = vec![0; positions.len()];
    for index in order {
        let position = positions[index as usize];
        if distinct.last() != Some(&position) {
            distinct.push(position);
        }
        place[index as usize] = distinct.len() as u32 - 1;
    }
    distinct.shrink_to_fit(); // kept as long as the body
    (distinct, place)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn a_tetrahedron_is_closed_and_a_triangle_is_not() {
        let mut triangles = TETRAHEDRON.to_vec();
        triangles.push([7, 8, 9]);
        let topology = Topology::of(triangles.iter().copied());
        assert_eq!(topology.components.len(), 2);
        assert!(topology.components[0].is_closed());
        assert_eq!(topology.components[1], Component { triangles: 1, open_edges: 3 });
        assert_eq!(topology.component_of, [0, 0, 0, 0, 1]);
    }

    #[test]
    fn one_turned_triangle_opens_the_surface() {
        let mut triangles = TETRAHEDRON;
        triangles[3].swap(0, 1);
        assert_eq!(Topology::of(triangles.iter().copied()).components[0].open_edges, 3);
    }

    #[test]
    fn equal_positions_are_one_vertex() {
        let (distinct, place) = unify(&[DVec3::X, DVec3::Y, DVec3::X, DVec3::ZERO]);
        assert_eq!(distinct, [DVec3::ZERO, DVec3::Y, DVec3::X]);
        assert_eq!(place, [2, 1, 2, 0]);
    }
}
