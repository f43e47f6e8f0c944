//! What a placed analytic body does to the light on a cell of its own surface.
//!
//! Problem: which way a cell faces, and whether the ways from all of its points to the light meet the body again. Signs of forms over
//! the hull of the cell's eight points are signs over the cell; every answer is a proof, or [`Facing::Unknown`]. Source: NUMERICS.md,
//! "Self shadow". Cost: at most 36 pairs of corners a form.

use umbriel_geometry::{
    Approx, Dyadic, LightSource, PlacedAnalytic, Point, Sign,
    analytic::{CellHull, HULL, LocalPoint, Piece, Surface},
    blocking::Probe,
};

use super::light_values::LightValues;

/// Whether the light is strictly on the lit side of a cell, and what the body itself does to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Facing {
    /// Everywhere; the own body is in nobody's way.
    Turned,
    /// Nowhere, or the own body shadows all of it.
    Dark,
    /// Neither is proved.
    Unknown,
}

/// One patch and the light.
pub(super) struct SelfShadow<'a> {
    pub(super) body: &'a PlacedAnalytic,
    pub(super) surface: Surface,
    /// Three exact points of the patch's plane, if it is flat.
    pub(super) plane: Option<&'a [Point<'a>; 3]>,
    pub(super) is_one_sided: bool,
    pub(super) source: &'a LightSource,
    pub(super) light: &'a LightValues,
}

/// The corners of a cell's hull, local coordinates.
type Corners = [LocalPoint<Approx>; HULL];

impl SelfShadow<'_> {
    /// What is proved of a cell.
    pub(super) fn facing(&self, hull: &CellHull) -> Facing {
        let corners = hull.local(self.body);
        match self.outward(&corners) {
            None => Facing::Unknown,
            Some(Sign::Zero) => Facing::Dark,
            Some(Sign::Positive) => self.on_outer_side(&corners),
            Some(Sign::Negative) if self.is_one_sided => Facing::Dark,
            Some(Sign::Negative) if !self.body.body().is_closed() => Facing::Turned,
            Some(Sign::Negative) => self.on_inner_side(&corners),
        }
    }

    /// On which side of the surface the light lies, seen from all points of a cell alike.
    fn outward(&self, corners: &Corners) -> Option<Sign> {
        match (self.surface, self.plane) {
            (Surface::Quadric(quadric), _) if self.light.is_edge_on(quadric, corners) => Some(Sign::Zero),
            (Surface::Quadric(quadric), _) => all_alike(self.toward(quadric, corners).iter().map(|value| value.sign())),
            (Surface::Plane(_), Some([x, ..])) => {
                Some(self.body.facing(self.surface, &Probe::<Dyadic>::at(x.position), self.source))
            }
            (Surface::Plane(_), None) => None,
        }
    }

    /// A line from x on the quadric q to the light meets it once more, at y = 2·q(x, L)·L − q(L, L)·x, which is on the way only for q(L, L) < 0; beyond
    /// it the way is inside q, so that the body is met exactly when y is within the planes: always for a light in the body.
    fn on_outer_side(&self, corners: &Corners) -> Facing {
        let Surface::Quadric(quadric) = self.surface else { return Facing::Turned };
        if self.body.body().is_convex() || self.light.quadric(quadric) != Sign::Negative {
            return Facing::Turned;
        }
        if self.light.side != Sign::Positive {
            return Facing::Dark;
        }
        let (forms, at_light) = (self.body.forms(), self.light.quadrics[quadric]);
        let planes = || self.body.pieces().iter().flat_map(|piece| piece.planes.iter().copied());
        let at_return = |plane: usize| {
            let plane_at_light = self.light.planes[plane];
            corners.map(|x| {
                let polar = forms.quadric(quadric, &x, &self.light.local);
                (polar + polar) * plane_at_light - at_light * forms.plane(plane, &x)
            })
        };
        if planes().any(|plane| at_return(plane).iter().all(is_negative)) {
            Facing::Turned
        } else if planes().all(|plane| at_return(plane).iter().all(|value| value.lower() >= 0.0)) {
            Facing::Dark
        } else {
            Facing::Unknown
        }
    }

    /// The inner side of a closed surface: only a light in the body reaches it, but for rims that it is in contact with.
    fn on_inner_side(&self, corners: &Corners) -> Facing {
        let is_convex = self.body.body().is_convex();
        match (self.light.side, self.body.pieces()) {
            (Sign::Positive, pieces) if pieces.iter().any(|piece| self.moves_in(piece, corners)) => Facing::Dark,
            (Sign::Negative, _) if is_convex => Facing::Turned,
            (Sign::Zero, _) if is_convex && self.is_smooth() => Facing::Turned,
            (Sign::Negative | Sign::Zero, [piece]) => self.on_inner_side_of(piece, corners),
            _ => Facing::Unknown,
        }
    }

    /// Whether the body, if it is convex, has one tangent plane at each point: a way to a light on it, which is not in that plane, runs inside.
    fn is_smooth(&self) -> bool {
        self.body.parts().iter().all(|part| matches!(part.surface, Surface::Quadric(_)))
    }

    /// Whether the ways from all points, which leave their surface inwards, go on inside a piece: no point lies on another
    /// surface of the piece that its way crosses outwards.
    fn moves_in(&self, piece: &Piece, corners: &Corners) -> bool {
        let is_own = match self.surface {
            Surface::Quadric(quadric) => piece.quadric == quadric,
            Surface::Plane(plane) => {
                let is_falling = || self.toward(piece.quadric, corners).iter().all(is_negative);
                piece.planes.contains(&plane) && (is_falling() || self.is_within(piece.quadric, corners))
            }
        };
        is_own && self.stays_in_planes(piece, corners)
    }

    /// For a light in the only piece, whose planes no way leaves. Of q a way has (1 − t)²·q(x, x) + 2t(1 − t)·q(x, L) + t²·q(L, L), the ends ≤ 0.
    fn on_inner_side_of(&self, piece: &Piece, corners: &Corners) -> Facing {
        let quadric = piece.quadric;
        let (toward, at_light) = (self.toward(quadric, corners), self.light.quadric(quadric));
        let is_within = || self.is_within(quadric, corners);
        let value_at_light = self.light.quadrics[quadric];
        let discriminants = || {
            let forms = self.body.forms();
            pairs()
                .map(|[k, l]| toward[k] * toward[l] - forms.quadric(quadric, &corners[k], &corners[l]) * value_at_light)
        };
        let stays_in_quadric = toward.iter().all(is_negative)
            || at_light == Sign::Negative && toward.iter().all(|value| value.upper() <= 0.0)
            || self.light.is_tip(quadric) && is_within()
            || discriminants().all(|value| is_negative(&value));
        let leaves_quadric = || {
            let rises = toward.iter().all(|value| value.lower() > 0.0);
            let returns = at_light == Sign::Negative && discriminants().all(|value| value.lower() > 0.0);
            rises && (returns || at_light == Sign::Zero && is_within())
        };
        if stays_in_quadric && self.stays_in_planes(piece, corners) {
            Facing::Turned
        } else if !stays_in_quadric && leaves_quadric() {
            Facing::Dark
        } else {
            Facing::Unknown
        }
    }

    /// Whether all ways that leave their surface inwards are strictly within the other planes, first of all or as far as a light there.
    fn stays_in_planes(&self, piece: &Piece, corners: &Corners) -> bool {
        let forms = self.body.forms();
        let is_inside = |plane: usize| {
            self.light.plane(plane) == Sign::Positive || corners.iter().all(|x| forms.plane(plane, x).lower() > 0.0)
        };
        piece.planes.iter().all(|&plane| self.surface == Surface::Plane(plane) || is_inside(plane))
    }

    /// Whether all points lie strictly inside a quadric: a form that is negative for all pairs of corners is so in their hull.
    fn is_within(&self, quadric: usize, corners: &Corners) -> bool {
        let forms = self.body.forms();
        pairs().all(|[k, l]| is_negative(&forms.quadric(quadric, &corners[k], &corners[l])))
    }

    /// q(x, L) at the corners.
    fn toward(&self, quadric: usize, corners: &Corners) -> [Approx; HULL] {
        corners.map(|x| self.body.forms().quadric(quadric, &x, &self.light.local))
    }
}

/// All pairs of corners, once each.
fn pairs() -> impl Iterator<Item = [usize; 2]> {
    (0..HULL).flat_map(|k| (k..HULL).map(move |l| [k, l]))
}

fn is_negative(value: &Approx) -> bool {
    value.upper() < 0.0
}

/// The sign that all have.
fn all_alike(mut signs: impl Iterator<Item = Option<Sign>>) -> Option<Sign> {
    let first = signs.next()??;
    signs.all(|sign| sign == Some(first)).then_some(first)
}
