//! Where the number of facets of a body that cover a shadow ray can change: the border edges, for one light.
//!
//! Every facet is turned counter-clockwise in the projection, by its exact side of the light; facets seen edge-on are left
//! out. Along an edge the uses one way and the other cancel; what is left is a border: a silhouette, the rim of a sheet,
//! an edge with a third facet. One look at each edge, about 3 ns (NUMERICS.md, "Winding").

use umbriel_geometry::{Facets, Sign};

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
#[derive(Clone, Debug, Default)]
pub(crate) struct Silhouette {
    pub(crate) borders: Vec<BorderEdge>,
    /// Facets that the light sees edge-on: they cover nothing, but where they are no point is proved lit.
    pub(crate) edge_on: Vec<u32>,
}

impl Silhouette {
    /// `turns` says of each facet which way its corners turn as seen from the light.
    pub(crate) fn new(edges: &EdgeTable, turns: &[Sign]) -> Self {
        let turn = |facet: u32| turn_of(turns, facet);
        let mut silhouette = Self::default();
        for edge in &edges.shared {
            silhouette.add(edge.ends, turn(edge.facets[0]) - turn(edge.facets[1]));
        }
        for uses in edges.others.chunk_by(|a, b| a.ends == b.ends) {
            let along = uses.iter().map(|usage| if usage.is_forward { turn(usage.facet) } else { -turn(usage.facet) });
            silhouette.add(uses[0].ends, along.sum());
        }
        silhouette.edge_on = (0..turns.len() as u32).filter(|&facet| turn(facet) == 0).collect();
        silhouette
    }

    /// Of some facets alone, as if the body had no others: where it goes on beyond them, it has a rim. Some 100 ns a facet.
    pub(crate) fn of_some(facets: &Facets, turns: &[Sign], some: &[u32]) -> Self {
        let mut uses = Vec::with_capacity(3 * some.len());
        for &facet in some {
            let (corners, turn) = (facets.facet(facet as usize).corners(), turn_of(turns, facet));
            for (k, &corner) in corners.iter().enumerate() {
                let ends = [corner, corners[(k + 1) % corners.len()]].map(|corner| facets.first_at(corner));
                let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
                uses.push((u64::from(low) << 32 | u64::from(high), if ends[0] == low { turn } else { -turn }));
            }
        }
        uses.sort_unstable_by_key(|&(edge, _)| edge);
        let mut silhouette = Self::default();
        for uses in uses.chunk_by(|a, b| a.0 == b.0) {
            let edge = uses[0].0;
            silhouette.add([(edge >> 32) as u32, edge as u32], uses.iter().map(|&(_, net)| net).sum());
        }
        silhouette.edge_on = some.iter().copied().filter(|&facet| turn_of(turns, facet) == 0).collect();
        silhouette
    }

    /// Adds an edge with `net` facets more on its left than on its right.
    fn add(&mut self, [from, to]: [u32; 2], net: i32) {
        if net != 0 {
            self.borders.push(BorderEdge { ends: if net > 0 { [from, to] } else { [to, from] }, net: net.abs() });
        }
    }
}

fn turn_of(turns: &[Sign], facet: u32) -> i32 {
    turns[facet as usize] as i32 - Sign::Zero as i32
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

    #[test]
    fn a_part_of_a_box_has_its_rim_as_border() {
        let facets = Facets::of_cuboid(&Cuboid { size: [1.0, 2.0, 3.0] }, &Placement::IDENTITY);
        let sun = LightSource::sun([1.0, -2.0, 0.5]).expect("a sun");
        let turns: Vec<Sign> = (0..6).map(|facet| facets.turn(facet, &sun)).collect();
        let sorted = |mut silhouette: Silhouette| {
            silhouette.borders.sort_unstable_by_key(|border| border.ends);
            silhouette.borders
        };
        let whole = sorted(Silhouette::new(&EdgeTable::of(&facets), &turns));
        assert_eq!(sorted(Silhouette::of_some(&facets, &turns, &[0, 1, 2, 3, 4, 5])), whole);
        let one = sorted(Silhouette::of_some(&facets, &turns, &[3]));
        let corners = facets.facet(3).corners();
        let mut rim: Vec<[u32; 2]> = (0..4).map(|k| [corners[k], corners[(k + 1) % 4]]).collect();
        if turns[3] == Sign::Negative {
            rim.iter_mut().for_each(|ends| ends.reverse());
        }
        rim.sort_unstable();
        assert_eq!(one.iter().map(|border| border.ends).collect::<Vec<_>>(), rim);
    }
}
