//! Where the number of facets of a body that cover a shadow ray can change: the border edges, for one light.
//!
//! Every facet is turned counter-clockwise in the projection, by its exact side of the light; facets seen edge-on are left
//! out. Along an edge the uses one way and the other cancel; what is left is a border: a silhouette, the rim of a sheet,
//! an edge with a third facet. One look at each edge, about 3 ns (NUMERICS.md, "Winding").

use umbriel_geometry::Sign;

use super::edge_table::EdgeTable;

/// An edge with more facets on its left than on its right, as the light sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BorderEdge {
    /// From, to; numbers of points.
    pub(crate) ends: [u32; 2],
    /// How many more; at least 1.
    pub(crate) net: i32,
}

/// One body as one light sees it.
#[derive(Clone, Debug)]
pub(crate) struct Silhouette {
    pub(crate) borders: Vec<BorderEdge>,
    /// Facets that the light sees edge-on: they cover nothing, but where they are no point is proved lit.
    pub(crate) edge_on: Vec<u32>,
}

impl Silhouette {
    /// `turns` says of each facet which way its corners turn as seen from the light.
    pub(crate) fn new(edges: &EdgeTable, turns: &[Sign]) -> Self {
        let turn = |facet: u32| turns[facet as usize] as i32 - Sign::Zero as i32;
        let mut borders = Vec::new();
        let mut add = |[from, to]: [u32; 2], net: i32| {
            if net != 0 {
                borders.push(BorderEdge { ends: if net > 0 { [from, to] } else { [to, from] }, net: net.abs() });
            }
        };
        for edge in &edges.shared {
            add(edge.ends, turn(edge.facets[0]) - turn(edge.facets[1]));
        }
        for uses in edges.others.chunk_by(|a, b| a.ends == b.ends) {
            let along = uses.iter().map(|usage| if usage.is_forward { turn(usage.facet) } else { -turn(usage.facet) });
            add(uses[0].ends, along.sum());
        }
        let edge_on = (0..turns.len() as u32).filter(|&facet| turn(facet) == 0).collect();
        Self { borders, edge_on }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbriel_geometry::{Cuboid, Facets, LightSource, Placement};

    #[test]
    fn the_silhouette_of_a_box_is_a_hexagon_or_a_rectangle() {
        let facets = Facets::of_cuboid(&Cuboid { size: [1.0, 2.0, 3.0] }, &Placement::IDENTITY);
        let edges = EdgeTable::of(&facets);
        for (direction, borders, edge_on) in [([1.0, -2.0, 0.5], 6, 0), ([0.0, -1.0, 0.0], 8, 4)] {
            let sun = LightSource::sun(direction).expect("a sun");
            let turns: Vec<Sign> = (0..6).map(|facet| facets.turn(facet, &sun)).collect();
            let silhouette = Silhouette::new(&edges, &turns);
            assert_eq!((silhouette.borders.len(), silhouette.edge_on.len()), (borders, edge_on));
        }
    }
}
