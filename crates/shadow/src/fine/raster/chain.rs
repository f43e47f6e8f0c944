//! The border of a body's shadow on a flat face, as directed segments in the face's own cells.
//!
//! What may block the face is the part of the body strictly above the face's plane and below the light. Each facet is cut to
//! it; its border edges are clipped likewise, and each cut adds a segment. The facets' images, all counter-clockwise, then
//! have the segments as their common border: edges inside a sheet have cancelled before. Which facets are kept and where
//! they are cut follows from exact signs (on which side of the plane each point lies); the segments are only known to
//! their margins, and that is all that is asked of them (NUMERICS.md, "Borders on a face").
//!
//! Facets seen edge-on, and those that meet the plane so flatly that their cut cannot be told, are *veils*: they may shadow
//! what they touch, and prove nothing. Cost: one look at each point and facet of a body that reaches the plane, some 20 ns
//! for each border edge.

use glam::DVec3;
use umbriel_geometry::{
    Aabb, Facets, LightSource, Point, Sign,
    decisions::{Level, count},
    predicates::{Target, side_value},
};

use super::{
    projection::{Image, ImageBounds, Place, Projection, margin_over},
    segments::{Chain, CornerKey, Segment, Veil},
    silhouette::{BorderEdge, Silhouette},
    standing::Standing,
};
use crate::fine::flat::FLAT;

/// A cut that is uncertain by more cells than this makes its facet a veil.
const MOST_SLIP: f64 = 0.25;

/// The face is not one for this method: something passes too near to the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GiveUp;

/// Where a point lies, as bits that can be joined over a facet.
pub(super) mod place {
    /// Clearly on the light's side of the plane.
    pub(crate) const ABOVE: u8 = 1;
    /// Clearly on the other side.
    pub(crate) const BELOW: u8 = 2;
    /// Exactly in the plane.
    pub(crate) const ON: u8 = 4;
    /// Nearer to the plane than the bounds, on the light's side.
    pub(crate) const JUST_ABOVE: u8 = 8;
    /// Nearer to the plane than the bounds, on the other side.
    pub(crate) const JUST_BELOW: u8 = 16;
    /// As high as the light or nearly so; comes with `ABOVE`.
    pub(crate) const HIGH: u8 = 32;

    pub(crate) const NEAR: u8 = JUST_ABOVE | JUST_BELOW;
    pub(crate) const CLEAR: u8 = ABOVE | BELOW;
}

/// The face that borders are looked for on.
pub(crate) struct Plane<'a> {
    pub(crate) corners: &'a [Point<'a>; FLAT],
    pub(crate) light: &'a LightSource,
    pub(crate) facing: Sign,
    pub(crate) projection: Projection,
    pub(crate) is_triangle: bool,
}

/// A corner of a facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) point: u32,
    pub(super) image: Image,
    pub(super) state: u8,
}

/// An end of what is left of an edge; uncertain along the edge by `slip` cells.
#[derive(Clone, Copy, Debug)]
struct End {
    place: Place,
    slip: f64,
}

/// A body that may shadow the face, as the light sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Occluder<'a> {
    pub(crate) facets: &'a Facets,
    pub(crate) bounds: &'a Aabb,
    pub(crate) turns: &'a [Sign],
    /// Of all its facets, or of some.
    pub(crate) silhouette: &'a Silhouette,
    /// Those; `None` for all.
    pub(crate) some: Option<&'a [u32]>,
}

/// One body before a face.
pub(crate) struct BodyChain<'a> {
    pub(super) plane: &'a Plane<'a>,
    pub(super) facets: &'a Facets,
    pub(super) turns: &'a [Sign],
    pub(super) bounds: ImageBounds,
    /// Points no farther than this from the plane (as h) are looked at exactly.
    near: f64,
    /// Not all points are above the plane and well below the light.
    is_cut: bool,
    /// Where the points lie, if that is known beforehand.
    pub(super) states: Vec<u8>,
    /// Solids that are one outline each.
    standing: Standing,
}

impl Chain {
    /// Adds one body.
    pub(crate) fn add(&mut self, plane: &Plane, occluder: &Occluder) -> Result<(), GiveUp> {
        let Occluder { facets, bounds, turns, silhouette, some } = *occluder;
        let slack = match facets.triangles() {
            Some(_) => DVec3::ZERO,
            None => (0..facets.positions().len() as u32).fold(DVec3::ZERO, |s, k| s.max(facets.point(k).slack)),
        };
        let (reach, image_bounds, near) = plane.reach(bounds, slack)?;
        if reach == Reach::Nothing {
            return Ok(());
        }
        let is_cut = reach == Reach::Cut;
        let (states, standing) = (Vec::new(), Standing::default());
        let mut body = BodyChain { plane, facets, turns, bounds: image_bounds, near, is_cut, states, standing };
        if is_cut && some.is_none() {
            body.states = (0..facets.positions().len() as u32).map(|point| body.find_state(point)).collect();
            count(Level::Double, body.states.iter().filter(|state| **state & place::CLEAR != 0).count() as u64);
            body.standing = Standing::of(&body);
        }
        self.bodies += 1;
        match some {
            _ if !is_cut => silhouette.edge_on.iter().try_for_each(|&facet| body.add_facet(facet, self))?,
            Some(some) => body.add_cuts(some.iter().copied(), self)?,
            None => body.add_cuts(body.standing.others(facets.len()), self)?,
        }
        for border in &silhouette.borders {
            body.add_border(border, self);
        }
        Ok(())
    }
}

/// What of a body's box can block the face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    Nothing,
    /// All of it is above the plane and well below the light.
    Above,
    Cut,
}

impl Plane<'_> {
    /// Whether a mesh with this box may have part in the shadows on the face.
    pub(crate) fn is_reached_by(&self, bounds: &Aabb) -> Result<bool, GiveUp> {
        self.reach(bounds, DVec3::ZERO).map(|(reach, ..)| reach != Reach::Nothing)
    }

    /// What of a body with this box can block the face, the bounds of its images, and how near to the plane points are looked at exactly.
    fn reach(&self, bounds: &Aabb, slack: DVec3) -> Result<(Reach, ImageBounds, f64), GiveUp> {
        let image_bounds = self.projection.bounds(bounds, slack);
        if 16.0 * image_bounds.w > self.projection.cutoff() {
            return Err(GiveUp);
        }
        let near = 4.0 * image_bounds.h;
        let images = bounds.corners().map(|corner| self.projection.image(corner));
        let lowest = images.iter().fold(f64::INFINITY, |low, image| low.min(image.h));
        let highest = images.iter().fold(f64::NEG_INFINITY, |high, image| high.max(image.h));
        let is_seen = images.iter().all(|image| image.w > 2.0 * self.projection.cutoff());
        let reach = if highest < -near || (is_seen && self.misses(&images, &image_bounds)) {
            Reach::Nothing
        } else if lowest > near && is_seen {
            Reach::Above
        } else {
            Reach::Cut
        };
        Ok((reach, image_bounds, near))
    }

    /// Whether the hull of points before the light is cast beside the face.
    fn misses(&self, images: &[Image], image_bounds: &ImageBounds) -> bool {
        let cells = self.projection.cells();
        let places = || images.iter().map(|image| self.projection.place(image, image_bounds));
        places().all(|p| p.x + p.margin < -1.0)
            || places().all(|p| p.y + p.margin < -1.0)
            || places().all(|p| p.x - p.margin > cells + 1.0)
            || places().all(|p| p.y - p.margin > cells + 1.0)
    }
}

impl BodyChain<'_> {
    /// Where a point lies.
    fn state(&self, point: u32) -> u8 {
        match self.states.get(point as usize) {
            _ if !self.is_cut => place::ABOVE,
            Some(&state) => state,
            None => self.find_state(point),
        }
    }

    fn find_state(&self, point: u32) -> u8 {
        let position = self.facets.positions()[point as usize];
        let h = self.plane.projection.image(position).h;
        if h < -self.near {
            return place::BELOW;
        }
        if h > self.near {
            let w = self.plane.projection.image(position).w;
            return if w < self.plane.projection.cutoff() { place::ABOVE | place::HIGH } else { place::ABOVE };
        }
        match self.exact_side(point, position) {
            Sign::Zero => place::ON,
            Sign::Positive => place::JUST_ABOVE,
            Sign::Negative => place::JUST_BELOW,
        }
    }

    fn exact_side(&self, point: u32, position: DVec3) -> Sign {
        let point = self.facets.point(point);
        let height = self.plane.projection.height(position);
        let is_exact = point.slack == DVec3::ZERO && self.plane.corners[0].slack == DVec3::ZERO;
        if let Some(sign) = height.sign().filter(|_| is_exact) {
            count(Level::Double, 1);
            return sign;
        }
        let [a, b, d] = [0, 1, FLAT - 1].map(|corner| &self.plane.corners[corner]);
        Sign::of(side_value(a, b, d, Target::Point(&point)).value).times(self.plane.facing)
    }

    pub(super) fn image(&self, point: u32) -> Image {
        self.plane.projection.image(self.facets.positions()[point as usize])
    }

    fn corner(&self, point: u32) -> Corner {
        Corner { point, image: self.image(point), state: self.state(point) }
    }

    /// How often a facet's border runs counter-clockwise round its image when its corners are taken in order.
    fn turn(&self, facet: u32) -> i32 {
        self.turns[facet as usize].times(self.plane.facing) as i32 - Sign::Zero as i32
    }

    /// Looks at those facets that are not simply above the plane.
    fn add_cuts(&self, facets: impl Iterator<Item = u32>, chain: &mut Chain) -> Result<(), GiveUp> {
        for facet in facets {
            let corners = self.facets.facet(facet as usize).corners();
            let joined = corners.iter().fold(0, |joined, &corner| joined | self.state(corner));
            // Where states are not known beforehand.
            if self.states.is_empty() && joined & place::CLEAR != 0 {
                count(Level::Double, corners.len() as u64);
            }
            let is_plain = joined == place::ABOVE && self.turns[facet as usize] != Sign::Zero;
            let is_harmless = joined & (place::ABOVE | place::JUST_ABOVE) == 0;
            if !is_plain && !is_harmless {
                self.add_facet(facet, chain)?;
            }
        }
        Ok(())
    }

    fn add_facet(&self, facet: u32, chain: &mut Chain) -> Result<(), GiveUp> {
        let corners = self.facets.facet(facet as usize).corners();
        let all = [0, 1, 2, corners.len() - 1].map(|k| self.corner(corners[k]));
        let corners = &all[..corners.len()];
        let joined = corners.iter().fold(0, |joined, corner| joined | corner.state);
        let beyond = self.beyond(corners);
        if joined & place::HIGH != 0 && beyond.is_none() && !self.high_part_is_beside(corners) {
            return Err(GiveUp);
        }
        let turn = self.turn(facet);
        if turn == 0 || joined & place::ABOVE == 0 {
            return match beyond {
                Some(_) => Ok(()),
                None if joined & place::ABOVE == 0 => self.add_veil(corners, chain),
                None => {
                    self.add_clipped_veil(corners, chain);
                    Ok(())
                }
            };
        }
        let Some(cuts) = self.cut(corners) else {
            self.subtract(corners, turn, chain);
            return if beyond.is_some() { Ok(()) } else { self.add_veil(corners, chain) };
        };
        for [from, to] in cuts.into_iter().flatten() {
            match beyond {
                None => self.push(&from, &to, turn, chain),
                Some(0) => self.push_beside(&from, &to, turn, chain),
                // Beyond the other sides it changes no winding on the face.
                Some(_) => {}
            }
        }
        Ok(())
    }

    /// The segments along which a facet is cut by the plane and below the light; `None` where they are too uncertain.
    fn cut(&self, corners: &[Corner]) -> Option<[Option<[Place; 2]>; 2]> {
        let count = corners.len();
        let at = |k: usize| &corners[k % count];
        if corners.iter().all(|corner| corner.state & !place::ABOVE & !place::ON == 0) {
            // What stands on the plane is cut along an edge of its own, or in a corner: there it touches the face and blocks nothing.
            let is_on = |k: usize| at(k).state == place::ON;
            let last = (0..count).find(|&k| !is_on(k) && is_on(k + 1));
            let foot = last.map(|last| [last + 1, if is_on(last + 2) { last + 2 } else { last + 1 }]);
            return Some([foot.map(|ends| ends.map(|k| self.place_of(at(k)))), None]);
        }
        // A parallelogram with one corner clear of the plane and another just beside it is hardly clear of it at all.
        let low = corners.iter().filter(|corner| corner.state & place::ABOVE == 0).count();
        let is_flat = count == 4 && low == 3 && corners.iter().any(|corner| corner.state & place::NEAR != 0);
        let edges_are_sure = (0..count).all(|k| self.edge(at(k), at(k + 1)).is_none_or(|ends| is_sure(&ends)));
        if is_flat || !edges_are_sure {
            return None;
        }
        let mut cuts = [None, None];
        for (cut, bit) in cuts.iter_mut().zip([place::ABOVE, place::HIGH]) {
            // The plane keeps what is above it, the light what is not high.
            let kept = |k: usize| (at(k).state & bit != 0) == (bit == place::ABOVE);
            let Some(last) = (0..count).find(|&k| kept(k) && !kept(k + 1)) else { continue };
            let first = (last + 1..=last + count).find(|&k| kept(k))?;
            let leaving = self.leave(at(last), at(last + 1), at(last + 2), bit);
            let entering = self.leave(at(first), at(first + count - 1), at(first + count - 2), bit);
            if leaving.slip > MOST_SLIP || entering.slip > MOST_SLIP {
                return None;
            }
            *cut = Some([leaving.widened(), entering.widened()]);
        }
        Some(cuts)
    }

    /// Where a facet's border leaves the part that is kept between `kept` and `next`; `beyond` comes after `next`.
    fn leave(&self, kept: &Corner, next: &Corner, beyond: &Corner, bit: u8) -> End {
        let mut end = self.end(next, kept);
        if bit == place::ABOVE && next.state & place::NEAR != 0 && beyond.state & place::BELOW != 0 {
            end.slip = end.slip.max(self.end(next, beyond).slip);
        }
        end
    }

    /// What is left of an edge; `None` if nothing is.
    fn edge(&self, a: &Corner, b: &Corner) -> Option<[End; 2]> {
        let is_above = (a.state | b.state) & place::ABOVE != 0;
        let is_high = a.state & b.state & place::HIGH != 0;
        (is_above && !is_high).then(|| [self.end(a, b), self.end(b, a)])
    }

    /// The end of an edge at `corner`, whose other corner is `other`.
    fn end(&self, corner: &Corner, other: &Corner) -> End {
        let (own, far) = (&corner.image, &other.image);
        if corner.state & place::HIGH != 0 {
            let t = (far.w - self.plane.projection.cutoff()) / (far.w - own.w);
            return End { place: self.place(&far.toward(own, t)), slip: 0.0 };
        }
        let error = self.bounds.h;
        if corner.state & place::BELOW != 0 {
            // t = h/(h − h'), each known to `error`.
            let drop = far.h - own.h;
            self.slid(far, own, far.h / drop, 4.0 * error / (drop - 2.0 * error))
        } else if corner.state & place::NEAR != 0 {
            let height = far.h.abs() - error;
            self.slid(own, far, 0.0, (own.h.abs() + error) / height * (1.0 + 4.0 * f64::EPSILON))
        } else {
            End { place: self.place_of(corner), slip: 0.0 }
        }
    }

    /// The point at `t` between two images, where `t` may be off by `slip`. Places move one way along the edge.
    fn slid(&self, from: &Image, to: &Image, t: f64, slip: f64) -> End {
        let place = self.place(&from.toward(to, t));
        let slip = [t - slip, t + slip].map(|t| {
            let other = self.place(&from.toward(to, t.clamp(0.0, 1.0)));
            (other.x - place.x).abs().max((other.y - place.y).abs()) + other.margin
        });
        End { place, slip: slip[0].max(slip[1]) }
    }

    fn place(&self, image: &Image) -> Place {
        self.plane.projection.place(image, &self.bounds)
    }

    /// The place of a corner; with its number if it is clear of the plane: what ends in the plane only touches the face there.
    fn place_of(&self, corner: &Corner) -> Place {
        let number = (corner.state == place::ABOVE).then(|| self.facets.first_at(corner.point));
        Place { corner: number, ..self.place(&corner.image) }
    }

    fn add_border(&self, border: &BorderEdge, chain: &mut Chain) {
        let [a, b] = border.ends.map(|point| self.corner(point));
        let net = if self.plane.facing == Sign::Negative { -border.net } else { border.net };
        if self.standing.has(a.point) {
            // A facet on either side of the outline, of the one solid.
            self.push(&self.place_of(&a), &self.place_of(&b), net / 2, chain);
        } else if a.state == place::ABOVE && b.state == place::ABOVE {
            self.push(&self.place_of(&a), &self.place_of(&b), net, chain);
        } else if let Some(ends) = self.edge(&a, &b).filter(is_sure) {
            self.push(&ends[0].widened(), &ends[1].widened(), net, chain);
        }
    }

    /// Takes a facet out of the count: its border is subtracted. Edges that are too uncertain are left out with all facets
    /// that use them, so their uses cancel.
    fn subtract(&self, corners: &[Corner], turn: i32, chain: &mut Chain) {
        for (k, corner) in corners.iter().enumerate() {
            let next = &corners[(k + 1) % corners.len()];
            if let Some(ends) = self.edge(corner, next).filter(is_sure) {
                self.push(&ends[0].widened(), &ends[1].widened(), -turn, chain);
            }
        }
    }

    /// A facet's whole image as a veil.
    fn add_veil(&self, corners: &[Corner], chain: &mut Chain) -> Result<(), GiveUp> {
        if corners.iter().any(|corner| corner.state & place::HIGH != 0) {
            return Err(GiveUp);
        }
        self.push_veil(corners.iter().map(|corner| self.place(&corner.image)), chain);
        Ok(())
    }

    /// The part of a facet that may block as a veil.
    fn add_clipped_veil(&self, corners: &[Corner], chain: &mut Chain) {
        let count = corners.len();
        let mut places = Vec::new();
        for (k, corner) in corners.iter().enumerate() {
            let (before, after) = (&corners[(k + count - 1) % count], &corners[(k + 1) % count]);
            if corner.state & (place::HIGH | place::BELOW) == 0 {
                places.push(self.place(&corner.image));
                continue;
            }
            for other in [before, after] {
                if self.edge(corner, other).is_some() {
                    let end = self.end(corner, other);
                    let is_known = end.slip <= MOST_SLIP;
                    places.push(if is_known { end.widened() } else { self.place(&corner.image) });
                }
            }
        }
        self.push_veil(places.into_iter(), chain);
    }

    /// Adds a segment with `net` facets more on its left, unless it is above, below or to the right of the face.
    fn push(&self, from: &Place, to: &Place, net: i32, chain: &mut Chain) {
        self.push_segment(from, to, (net, false), chain);
    }

    /// Adds a segment on the face's side u = 0 with its facets beyond.
    fn push_beside(&self, from: &Place, to: &Place, net: i32, chain: &mut Chain) {
        self.push_segment(from, to, (net, true), chain);
    }

    fn push_segment(&self, from: &Place, to: &Place, (net, is_beside): (i32, bool), chain: &mut Chain) {
        let cells = self.plane.projection.cells();
        // The rounding of a crossing with a row's middle, and of the way to f32.
        let far = from.x.abs().max(from.y.abs()).max(to.x.abs()).max(to.y.abs()).max(cells);
        let margin = margin_over(from, to, cells) + far * (16.0 * f64::EPSILON);
        let margin = (margin as f32).next_up();
        let reach = f64::from(margin) + 1.0;
        let is_outside = from.y.max(to.y) < -reach
            || from.y.min(to.y) > cells + reach
            || from.x.min(to.x) > cells + reach
            || (self.plane.is_triangle && (from.x + from.y).min(to.x + to.y) > cells + 2.0 * reach);
        if !is_outside {
            let (from, to) = if net > 0 { (from, to) } else { (to, from) };
            let key = |number: u32| CornerKey::new(&self.facets.point(number), chain.bodies, number);
            let ends = [from.corner.map(key), to.corner.map(key)];
            let (from, to, net) = ([from.x, from.y], [to.x, to.y], net.abs());
            chain.push(Segment { from, to, margin, net, is_beside }, ends);
        }
    }

    fn push_veil(&self, places: impl Iterator<Item = Place>, chain: &mut Chain) {
        let mut margin = 0.0_f64;
        let mut far = self.plane.projection.cells();
        let corners: Vec<[f64; 2]> = places
            .map(|place| {
                margin = margin.max(place.margin);
                far = far.max(place.x.abs()).max(place.y.abs());
                [place.x, place.y]
            })
            .collect();
        let margin = ((margin + far * (16.0 * f64::EPSILON)) as f32).next_up();
        if !corners.is_empty() {
            chain.veils.push(Veil { corners, margin });
        }
    }
}

impl End {
    /// With the slip in the margin.
    fn widened(&self) -> Place {
        Place { margin: self.place.margin + self.slip, ..self.place }
    }
}

fn is_sure(ends: &[End; 2]) -> bool {
    ends.iter().all(|end| end.slip <= MOST_SLIP)
}
