//! A light as an analytic body sees it.

use umbriel_geometry::{
    Approx, LightSource, PlacedAnalytic, Sign,
    analytic::{Glance, LocalPoint, Piece, is_nowhere_zero},
};

/// A light seen from a body: the values of its forms there, all with known signs.
#[derive(Clone, Debug)]
pub(crate) struct LightValues {
    /// The light in the body's local coordinates.
    pub(crate) local: LocalPoint<Approx>,
    /// Positive: the light is outside; exact.
    pub(super) side: Sign,
    pub(super) quadrics: Vec<Approx>,
    pub(super) planes: Vec<Approx>,
    /// Of which quadrics it is the tip.
    tips: Vec<bool>,
    /// For quadrics with a plane that it lies in, see [`PlacedAnalytic::beside_edge_on`].
    beside_edge_on: Vec<Option<[Approx; 4]>>,
    /// For a light outside.
    glance: Option<Glance>,
}

impl LightValues {
    /// Of a light that lies on this side of the body.
    pub(crate) fn new(body: &PlacedAnalytic, light: &LightSource, side: Sign) -> Self {
        let [quadrics, planes] = body.light_values(light);
        let is_on = |index: usize| quadrics[index].value == 0.0;
        let tips = (0..quadrics.len()).map(|index| is_on(index) && body.is_tip(index, light)).collect();
        let beside = |index: usize| if is_on(index) { body.beside_edge_on(index, light) } else { None };
        let beside_edge_on = (0..quadrics.len()).map(beside).collect();
        let glance = (side == Sign::Positive).then(|| body.glance(light));
        Self { local: body.forms().pull_back_light(light), side, tips, beside_edge_on, quadrics, planes, glance }
    }

    /// Whether it is the tip of a quadric, where there is no tangent plane.
    pub(crate) fn is_tip(&self, quadric: usize) -> bool {
        self.tips[quadric]
    }

    /// Whether a quadric's surface is seen edge-on everywhere in the hull of some of the body's points: it holds the tip, or is a plane that the light is in.
    pub(super) fn is_edge_on(&self, quadric: usize, points: &[LocalPoint<Approx>]) -> bool {
        self.is_tip(quadric)
            || self.beside_edge_on[quadric].as_ref().is_some_and(|other| is_nowhere_zero(other, points))
    }

    /// What floats say of ways to the light, if it is outside.
    pub(super) fn glance(&self) -> Option<&Glance> {
        self.glance.as_ref()
    }

    /// Negative inside.
    pub(super) fn quadric(&self, index: usize) -> Sign {
        Sign::of(self.quadrics[index].value)
    }

    /// Positive inside.
    pub(super) fn plane(&self, index: usize) -> Sign {
        Sign::of(self.planes[index].value)
    }

    /// Whether the light is strictly outside of a piece.
    pub(super) fn is_outside(&self, piece: &Piece) -> bool {
        self.quadric(piece.quadric) == Sign::Positive
            || piece.planes.iter().any(|&plane| self.plane(plane) == Sign::Negative)
            || piece.flat.is_some_and(|plane| self.plane(plane) != Sign::Zero)
    }
}
