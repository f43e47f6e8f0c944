//! Convex solids that stand on the face's plane: one outline each.
//!
//! Where facets meet the plane their borders are closed by cuts, at which they touch the face and block nothing; corners where several of them end
//! stay open. A convex solid has no need of that: a ray from the plane that meets its inside meets a facet by which it leaves, strictly nearer to the light, also from where it
//! stands, and any other ray but those of its outline misses it. So its outline is drawn once, edges in the plane included, and it counts as one facet. NUMERICS.md, "Borders on a
//! face". Cost: some 20 ns a facet of the solids that have a corner in the plane, and a few of all others.

use umbriel_geometry::Sign;

use super::chain::{BodyChain, place};
use crate::solids::{Solid, convex_solids};

/// The solids of a body that stand on the plane.
#[derive(Default)]
pub(super) struct Standing {
    /// In the order of their facets.
    solids: Vec<Solid>,
    /// Whether a point is of one of them; empty if there are none.
    points: Vec<bool>,
}

impl Standing {
    /// Those of a body of which it is known where its points lie; none where points of several triangles share a position.
    pub(super) fn of(body: &BodyChain) -> Self {
        let BodyChain { facets, turns, states, .. } = body;
        if !states.contains(&place::ON) || facets.firsts().is_some() {
            return Self::default();
        }
        let has_place = |state: u8| state == place::ABOVE || state == place::ON;
        let mut solids = convex_solids(facets, |points| {
            states[points.clone()].contains(&place::ON) && states[points].iter().all(|&state| has_place(state))
        });
        // Seen edge-on, a facet parts the outline in two; and along a side of the face contact is told exactly, facet by facet.
        solids.retain(|solid| {
            let on = solid.vertices.clone().filter(|&point| states[point] == place::ON);
            turns[solid.faces.clone()].iter().all(|&turn| turn != Sign::Zero)
                && on.map(|point| body.image(point as u32)).all(|image| body.is_off_sides(&image))
        });
        let mut points = vec![false; if solids.is_empty() { 0 } else { states.len() }];
        solids.iter().for_each(|solid| points[solid.vertices.clone()].fill(true));
        Self { solids, points }
    }

    /// Whether a point is of one of them.
    #[inline]
    pub(super) fn has(&self, point: u32) -> bool {
        self.points.get(point as usize).is_some_and(|&is_of_one| is_of_one)
    }

    /// The facets of a body that are of none of them.
    pub(super) fn others(&self, facets: usize) -> impl Iterator<Item = u32> {
        let starts = std::iter::once(0).chain(self.solids.iter().map(|solid| solid.faces.end));
        let ends = self.solids.iter().map(|solid| solid.faces.start).chain(std::iter::once(facets));
        starts.zip(ends).flat_map(|(start, end)| start as u32..end as u32)
    }
}
