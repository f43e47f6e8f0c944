//! Bounds of the visible fraction over all points of a cell.
//!
//! Ours. The light is looked at from the middle x₀ of a flat cell C, where what is visible of it is exact ([`super::polygon`]). From another point x of
//! C every corner of an occluder stands elsewhere before the light, by δ at most: with depths e and d of corner and x below the light's plane
//! the shift is e/(d − e)·|ΔX + s·Δd|, s the ray's slope, whose greatest value over C is taken at a corner of C. Two facts bound what
//! that changes (proofs in NUMERICS.md, "Soft shadows"):
//!
//! - Points of the light farther than δ from an object's image at x₀ are nowhere in C hidden by it.
//! - Faces, each turned counter-clockwise in the image at x₀, are a chain that winds about every hidden point. Where x moves, the winding
//!   number of a light point changes only if a *border* edge (one that does not cancel: a silhouette or a rim) passes over it. So points
//!   hidden at x₀ and farther than δ from all borders are hidden from all of C.
//!
//! What is left are bands of half width δ: the visible fraction over C is no less than what is visible at x₀ farther than δ from all images, and no more than what
//! is not hidden at x₀ farther than δ from borders. Bands shrink with C, and the bounds with them. No band on the light: C is lit or umbra, for certain.
//! (Where the shaft cuts a face its image has an edge that is no border: it hides no more from there on, but it may come over the light.)
//! Balls before round lights are bounded by their caps' closed form, other bodies of revolution by the polyhedra that they lie between
//! ([`super::polyhedra`]), what is left by the shaft alone. Cost: a shaft, and for
//! penumbra clipping with the faces in it.

use glam::DVec3;
use umbriel_geometry::{Facets, Point, Sign, predicates::side};
use umbriel_scene::{Extent, Light};

use super::{
    cover::{Cover, Outline, bounds_of},
    fraction::corners,
    hidden::{hidden_by, polyhedra_before},
    horizon::{Above, CurvedSide, LitSide, side_of_light},
    normal::Normal,
    occluders::{HullShaft, InShaft, LightHull, in_shaft},
    views::Views,
};
use crate::{bodies::Body, query::Queries};

/// What is known about the visible fraction in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellBounds {
    /// No point of the cell sees less.
    pub(crate) lower: f64,
    /// No point of the cell sees more.
    pub(crate) upper: f64,
    /// What its middle sees.
    pub(crate) estimate: f64,
}

impl CellBounds {
    pub(super) const UMBRA: Self = Self { lower: 0.0, upper: 0.0, estimate: 0.0 };
    pub(super) const UNKNOWN: Self = Self { lower: 0.0, upper: 1.0, estimate: 0.5 };
}

/// A part of a face: all of it is in the hull of its corners.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    /// World coordinates.
    pub(super) corners: Vec<DVec3>,
    /// How far off each corner may be along every axis, metres, beyond half an ulp.
    pub(super) slack: f64,
    /// A point of the hull; of the surface where that has one there.
    pub(super) middle: DVec3,
}

impl Cell {
    /// A part of a flat face.
    pub(super) fn flat(corners: Vec<DVec3>) -> Self {
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        Self { corners, slack: 0.0, middle }
    }

    /// No point of the cell is farther from its middle, metres.
    pub(super) fn reach(&self) -> f64 {
        let distances = self.corners.iter().map(|&corner| (corner - self.middle).length());
        distances.fold(0.0, f64::max) + 2.0 * self.slack
    }

    /// The corners of boxes round the corners that hold what these may be.
    pub(super) fn widened(&self) -> impl Iterator<Item = DVec3> + '_ {
        let shift = |k: usize, bit: usize| if k >> bit & 1 == 0 { -self.slack } else { self.slack };
        let shifts = (0..8).map(move |k| DVec3::new(shift(k, 0), shift(k, 1), shift(k, 2)));
        self.corners.iter().flat_map(move |&corner| shifts.clone().map(move |shift| corner + shift))
    }
}

/// A face that receives light.
pub(crate) struct Receiver<'a> {
    queries: &'a Queries<'a>,
    light: &'a Light,
    hull: LightHull,
    object: u32,
    face: u32,
    side: LitSide<'a>,
}

impl<'a> Receiver<'a> {
    /// A flat face, and what may shadow it.
    pub(crate) fn flat(
        queries: &'a Queries<'a>,
        light: &'a Light,
        [object, face]: [usize; 2],
        facets: &'a Facets,
    ) -> (Self, InShaft) {
        let hull = LightHull::of(light);
        let side = LitSide::of_flat(facets, face, queries.bodies.is_one_sided(object, face), &hull);
        let receiver = Self { queries, light, hull, object: object as u32, face: face as u32, side };
        if matches!(side, LitSide::Away) {
            return (receiver, InShaft::default());
        }
        let whole = Cell::flat(corners(facets, face).collect());
        let shaft = receiver.shaft(&whole);
        let mut found = in_shaft(queries, &shaft);
        found.faces.retain(|&(object, face)| !receiver.cannot_hide(facets, object, face));
        receiver.add_polyhedra(&shaft, &mut found);
        (receiver, found)
    }

    /// A patch of a curved body, and what may shadow the part of it in `whole`.
    pub(crate) fn patch(
        queries: &'a Queries<'a>,
        light: &'a Light,
        [object, face]: [usize; 2],
        side: CurvedSide<'a>,
        whole: &Cell,
    ) -> (Self, InShaft) {
        let (hull, is_convex) = (LightHull::of(light), side.body.body().is_convex());
        let side = LitSide::Patch(side);
        let receiver = Self { queries, light, hull, object: object as u32, face: face as u32, side };
        let shaft = receiver.shaft(whole);
        let mut found = in_shaft(queries, &shaft);
        // A convex body is behind each of its tangent planes.
        found.bodies.retain(|&body| body as usize != object || !is_convex);
        receiver.add_polyhedra(&shaft, &mut found);
        (receiver, found)
    }

    /// Finds the triangles of polyhedra that may be in the shaft.
    fn add_polyhedra(&self, shaft: &HullShaft, found: &mut InShaft) {
        for &body in &found.bodies {
            let Some(polyhedra) = polyhedra_before(self.queries, body, self.light, &self.hull) else { continue };
            let both = [(&polyhedra.inner, &mut found.inner), (&polyhedra.outer, &mut found.outer)];
            // From within the polyhedron round its own body a receiver sees nothing but that.
            let count = if body == self.object { 1 } else { 2 };
            for (facets, list) in both.into_iter().take(count) {
                let in_shaft = (0..facets.len()).filter(|&face| shaft.may_meet(&facets.facet_bounds(face)));
                list.extend(in_shaft.map(|face| (body, face as u32)));
            }
        }
    }

    /// Whether a face is the receiver itself, lies on the closed back side of its plane, or has the receiver and the light on one side of its own plane (the
    /// receiver on the closed one): exact.
    fn cannot_hide(&self, facets: &Facets, object: u32, face: u32) -> bool {
        if (object, face) == (self.object, self.face) {
            return true;
        }
        let Body::Flat(other) = self.queries.bodies.get(object as usize) else { return false };
        let none_beyond = |[facets, other]: [&Facets; 2], [plane, face]: [u32; 2], beyond: Sign| {
            let own = facets.facet(plane as usize).corners();
            let [a, b, c] = [own[0], own[1], own[own.len() - 1]].map(|corner| facets.point(corner));
            other.facet(face as usize).corners().iter().all(|&corner| side(&a, &b, &c, &other.point(corner)) != beyond)
        };
        let is_behind = match self.side {
            LitSide::Plane(plane) => none_beyond([facets, other], [self.face, face], plane.front),
            _ => false,
        };
        is_behind
            || side_of_light(other, face as usize, &self.hull)
                .is_some_and(|of_light| none_beyond([other, facets], [face, self.face], of_light.flipped()))
    }

    fn shaft(&self, cell: &Cell) -> HullShaft {
        let mut shaft = HullShaft::between(cell, &self.hull);
        if let LitSide::Plane(plane) = &self.side {
            shaft.keep_before(cell.corners[0], &plane.normal);
        }
        if let (Extent::Rectangle { u, v }, Some(side)) = (self.light.extent, self.light_plane_side(cell)) {
            let normal = Normal::across(u, v);
            shaft.keep_before(self.light.source.xyz(), &if side < 0.0 { normal.flipped() } else { normal });
        }
        shaft
    }

    /// On which side of a rectangle light's plane the cell lies: 1 or −1 times its normal. `None` if that plane may meet the cell.
    fn light_plane_side(&self, cell: &Cell) -> Option<f64> {
        let Extent::Rectangle { u, v } = self.light.extent else { return Some(1.0) };
        let (normal, centre) = (Normal::across(u, v), Point::exact(self.light.source.xyz()));
        let signs = cell.corners.iter().map(|&corner| {
            // Corners are rounded in world coordinates.
            let slack = DVec3::splat(cell.slack + 4.0 * f64::EPSILON * corner.abs().max_element());
            match normal.along(Point::within(corner, slack).minus(&centre)).sign() {
                Some(Sign::Positive) => 1.0,
                Some(Sign::Negative) => -1.0,
                Some(Sign::Zero) | None => 0.0,
            }
        });
        let sum: f64 = signs.sum();
        (sum.abs() == cell.corners.len() as f64).then(|| sum.signum())
    }

    /// Bounds over a cell of the face, by what may shadow it; and what may shadow its parts.
    pub(crate) fn bounds(&self, cell: &Cell, candidates: &InShaft) -> (CellBounds, InShaft) {
        if matches!(self.side, LitSide::Away) {
            return (CellBounds::UMBRA, InShaft::default());
        }
        // From a point in the light's own plane nothing is bounded; smaller cells are off it.
        let views = self.light_plane_side(cell).and_then(|_| Views::new(cell, self.light));
        let Some(views) = views else { return (CellBounds::UNKNOWN, candidates.clone()) };
        let above = self.side.above(cell, self.light, &views.centre);
        if matches!(above, Above::Nothing) {
            return (CellBounds::UMBRA, InShaft::default());
        }
        let mut kept = InShaft::default();
        if candidates.is_empty() {
            return (left_by(&views, &above, &Cover::default()), kept);
        }
        let shaft = self.shaft(cell);
        let mut cover = Cover::default();
        kept.faces = self.add_faces(&views, &shaft, &candidates.faces, &mut cover, |queries, object| {
            match queries.bodies.get(object as usize) {
                Body::Flat(facets) => Some(facets),
                Body::Analytic(_) => None,
            }
        });
        let mut bounds = left_by(&views, &above, &cover);
        if !(candidates.outer.is_empty() && candidates.inner.is_empty()) {
            let mut wider = cover.clone();
            kept.outer = self.add_faces(&views, &shaft, &candidates.outer, &mut wider, |queries, object| {
                queries.polyhedra(object).map(|polyhedra| &polyhedra.outer)
            });
            kept.inner = self.add_faces(&views, &shaft, &candidates.inner, &mut cover, |queries, object| {
                queries.polyhedra(object).map(|polyhedra| &polyhedra.inner)
            });
            let [least, most] = [wider, cover].map(|cover| left_by(&views, &above, &cover));
            bounds = CellBounds {
                lower: least.lower.min(most.upper),
                upper: most.upper,
                estimate: 0.5 * (least.estimate + most.estimate),
            };
        }
        for &body in &candidates.bodies {
            if !shaft.may_meet(&self.queries.bodies.bounds(body as usize)) {
                continue;
            }
            kept.bodies.push(body);
            let (least, most) = hidden_by(self.queries, body, cell, &views, self.light, &self.hull);
            bounds.estimate -= 0.5 * (least + most);
            // What a body that is not convex hides from itself is known from the polyhedron inside only.
            let most = if body == self.object { 1.0 } else { most };
            bounds.lower = (bounds.lower - most).max(0.0);
            bounds.upper = bounds.upper.min(1.0 - least).max(0.0);
        }
        bounds.estimate = bounds.estimate.clamp(bounds.lower, bounds.upper);
        (bounds, kept)
    }

    /// Adds the images of the faces in the shaft and the bands along their borders, object by object; which faces those are.
    fn add_faces(
        &self,
        views: &Views,
        shaft: &HullShaft,
        candidates: &[(u32, u32)],
        cover: &mut Cover,
        facets_of: impl Fn(&'a Queries<'a>, u32) -> Option<&'a Facets>,
    ) -> Vec<(u32, u32)> {
        let mut kept = Vec::new();
        for faces in candidates.chunk_by(|a, b| a.0 == b.0) {
            let Some(facets) = facets_of(self.queries, faces[0].0) else { continue };
            let mut outline = Outline::default();
            for &(object, face) in faces {
                let mut polygon: Vec<DVec3> = corners(facets, face as usize).collect();
                shaft.cut(&mut polygon);
                if polygon.len() < 3 {
                    continue;
                }
                kept.push((object, face));
                outline.add(facets, face as usize, &polygon, views);
            }
            outline.finish(facets, shaft, views, cover);
        }
        kept
    }
}

/// The bounds that the horizon and faces leave.
fn left_by(views: &Views, above: &Above, cover: &Cover) -> CellBounds {
    let whole = || bounds_of(views, &views.centre.whole(), cover);
    match above {
        Above::Nothing => CellBounds::UMBRA,
        Above::All => whole(),
        Above::Between { least, most } => {
            let (low, high) = (bounds_of(views, least, cover), bounds_of(views, most, cover));
            CellBounds { lower: low.lower, upper: high.upper, estimate: 0.5 * (low.estimate + high.estimate) }
        }
        Above::Share([least, most]) => {
            let whole = whole();
            let lower = (whole.lower - (1.0 - least)).max(0.0);
            CellBounds { lower, upper: whole.upper.min(*most), estimate: whole.estimate * 0.5 * (least + most) }
        }
    }
}
