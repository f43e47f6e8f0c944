//! Which edges of a body are drawn: borders, outlines, creases.

use umbriel_geometry::{Facets, LightSource, Sign};

use super::{Line, normal};

/// An edge as a face uses it, by the first points at its ends, in ascending order.
struct Use {
    points: [u32; 2],
    corners: [u32; 2],
    face: usize,
    runs_upward: bool,
}

/// Where a body has creases.
pub(super) enum Creases<'a> {
    /// Where faces bend by more than an angle with this cosine.
    Bends(f64),
    /// Between faces that stand for different pieces of a curved surface.
    Pieces(&'a [u32]),
}

/// The edges of a body that are drawn.
pub(super) fn edges<'a>(facets: &'a Facets, eye: &LightSource, creases: &Creases) -> Vec<Line<'a>> {
    let mut uses: Vec<Use> = (0..facets.len()).flat_map(|face| uses_of(facets, face)).collect();
    uses.sort_by_key(|one| (one.points, one.face));
    let groups = uses.chunk_by(|a, b| a.points == b.points);
    let drawn = groups.filter(|group| is_drawn(facets, group, eye, creases));
    let line = |group: &[Use]| Line { ends: group[0].corners.map(|corner| facets.point(corner)), on: [None; 2] };
    drawn.map(line).collect()
}

fn uses_of(facets: &Facets, face: usize) -> Vec<Use> {
    let numbers = facets.facet(face).corners();
    let edge = |k: usize| {
        let ends = [numbers[k], numbers[(k + 1) % numbers.len()]];
        let [from, to] = ends.map(|corner| facets.first_at(corner));
        let runs_upward = from < to;
        let corners = if runs_upward { ends } else { [ends[1], ends[0]] };
        Use { points: [from.min(to), from.max(to)], corners, face, runs_upward }
    };
    (0..numbers.len()).map(edge).filter(|edge| edge.points[0] != edge.points[1]).collect()
}

/// Edges of one face, or of more than two, are borders; one of two faces is an outline if the eye sees different sides of these, or a
/// crease.
fn is_drawn(facets: &Facets, group: &[Use], eye: &LightSource, creases: &Creases) -> bool {
    let [a, b] = group else { return true };
    // Faces that use the edge the same way have opposite windings.
    let is_turned = a.runs_upward == b.runs_upward;
    let sides = [a, b].map(|one| facets.turn(one.face, eye));
    let other = if is_turned { sides[1].flipped() } else { sides[1] };
    if sides[0] != other && sides.iter().any(|&side| side != Sign::Zero) {
        return true;
    }
    match creases {
        Creases::Bends(limit) => {
            let cosine = normal(facets, a.face).dot(normal(facets, b.face));
            (if is_turned { -cosine } else { cosine }) < *limit
        }
        Creases::Pieces(pieces) => pieces[a.face] != pieces[b.face],
    }
}
