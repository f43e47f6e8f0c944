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
//! Balls before round lights are bounded by their caps' closed form, other curved bodies by the shaft and by their convexity. Cost: a shaft, and for
//! penumbra clipping with the faces in it.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use umbriel_geometry::{Dyadic, Facets, LightSource, Sign, blocking::Probe, predicates::side};
use umbriel_scene::{Extent, Light};

use super::{
    caps::{Cap, angle, cap_area, common_area},
    fraction::{Ball, corners, normal_of},
    occluders::{HullShaft, InShaft, LightHull, in_shaft},
    polygon::{Pieces, Polygon},
    window::{Shape, Window},
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
    const UMBRA: Self = Self { lower: 0.0, upper: 0.0, estimate: 0.0 };
    pub(super) const UNKNOWN: Self = Self { lower: 0.0, upper: 1.0, estimate: 0.5 };
}

/// A flat face that receives light.
pub(crate) struct Receiver<'a> {
    queries: &'a Queries<'a>,
    light: &'a Light,
    hull: LightHull,
    object: u32,
    face: u32,
    /// The side from which it can be lit: its normal, and the sign of points before it in exact predicates. `None` if the face has two
    /// sides, and light on both.
    front: Option<(DVec3, Sign)>,
    /// Whether all of the light is behind the side that can be lit.
    is_turned_away: bool,
}

/// A cell's views of the light: from its middle, and from its corners.
struct Views {
    centre: Window,
    all: Vec<Window>,
    /// What the size of coordinates times this is: the rounding of an image, before it is divided by γ.
    rounding: f64,
    /// A round light's rim in the image over all of the cell, and by what factor shares of it differ.
    rim: Rim,
}

struct Rim {
    /// Share of the light, as measured from the middle, within its smallest and its greatest image.
    inner: f64,
    outer: f64,
    /// Ratio of the greatest to the least density.
    density: f64,
    /// How far the image reaches beyond the unit disk.
    growth: f64,
}

/// What faces do in the image.
#[derive(Default)]
struct Cover {
    faces: Vec<Polygon>,
    /// What is within reach of a border edge: hidden or not, it may change.
    borders: Vec<Polygon>,
    /// What is within reach of any edge of an image: not hidden now, it may be elsewhere.
    fringes: Vec<Polygon>,
    /// Whether a face reaches where the views bound nothing: it may hide anything.
    has_unbounded: bool,
}

/// Roundings of a projected corner: the difference to the eye, the matrix's nine products, the quotient, and as many for a corner made by cuts.
const IMAGE_ROUNDING: f64 = 64.0 * f64::EPSILON;

impl<'a> Receiver<'a> {
    /// The face, and what may shadow it.
    pub(crate) fn new(queries: &'a Queries<'a>, light: &'a Light, object: usize, face: usize) -> (Self, InShaft) {
        let hull = LightHull::of(light);
        let mut receiver =
            Self { queries, light, hull, object: object as u32, face: face as u32, front: None, is_turned_away: false };
        let Body::Flat(facets) = queries.bodies.get(object) else { return (receiver, InShaft::default()) };
        (receiver.front, receiver.is_turned_away) = receiver.front_of(facets);
        if receiver.is_turned_away {
            return (receiver, InShaft::default());
        }
        let whole: Vec<DVec3> = corners(facets, face).collect();
        let mut found = in_shaft(queries, &receiver.shaft(&whole));
        found.faces.retain(|&(object, face)| !receiver.cannot_hide(facets, object, face));
        (receiver, found)
    }

    /// The side that can be lit, and whether all of the light is behind it.
    fn front_of(&self, facets: &Facets) -> (Option<(DVec3, Sign)>, bool) {
        let sign = if facets.is_mirrored() { Sign::Negative } else { Sign::Positive };
        let normal = normal_of(facets, self.face as usize);
        let whole: Vec<DVec3> = corners(facets, self.face as usize).collect();
        let (values, size): (Vec<f64>, f64) = match &self.hull {
            LightHull::Points(points) => {
                let size = points.iter().chain(&whole).map(|point| point.abs().max_element()).fold(0.0, f64::max);
                (points.iter().map(|&point| normal.dot(point - whole[0])).collect(), size)
            }
            LightHull::Directions(directions) => {
                (directions.iter().map(|&direction| normal.dot(direction)).collect(), 1.0)
            }
        };
        // The normal's two roundings a coordinate, the difference's and the product's.
        let slack = 16.0 * f64::EPSILON * normal.abs().element_sum() * size;
        let (all_before, all_behind) =
            (values.iter().all(|&value| value > slack), values.iter().all(|&value| value < -slack));
        if self.queries.bodies.is_one_sided(self.object as usize, self.face as usize) {
            (Some((normal, sign)), all_behind)
        } else if all_behind {
            (Some((-normal, sign.flipped())), false)
        } else {
            (all_before.then_some((normal, sign)), false)
        }
    }

    /// Whether a face is the receiver itself or lies on the closed back side of its plane: exact.
    fn cannot_hide(&self, facets: &Facets, object: u32, face: u32) -> bool {
        if (object, face) == (self.object, self.face) {
            return true;
        }
        let (Some((_, front)), Body::Flat(other)) = (self.front, self.queries.bodies.get(object as usize)) else {
            return false;
        };
        let own = facets.facet(self.face as usize).corners();
        let [a, b, c] = [own[0], own[1], own[own.len() - 1]].map(|corner| facets.point(corner));
        other.facet(face as usize).corners().iter().all(|&corner| side(&a, &b, &c, &other.point(corner)) != front)
    }

    fn shaft(&self, cell: &[DVec3]) -> HullShaft {
        let mut shaft = HullShaft::between(cell, &self.hull);
        if let Some((normal, _)) = self.front {
            shaft.keep_before(cell[0], normal);
        }
        if let (Extent::Rectangle { u, v }, Some(side)) = (self.light.extent, self.light_plane_side(cell)) {
            shaft.keep_before(self.light.source.xyz(), u.cross(v) * side);
        }
        shaft
    }

    /// On which side of a rectangle light's plane the cell lies: 1 or −1 times its normal. `None` if that plane may meet the cell.
    fn light_plane_side(&self, cell: &[DVec3]) -> Option<f64> {
        let Extent::Rectangle { u, v } = self.light.extent else { return Some(1.0) };
        let (normal, centre) = (u.cross(v), self.light.source.xyz());
        let signs = cell.iter().map(|&corner| {
            // Four roundings of the normal, one of the difference, three of the sum of products.
            let slack = 16.0 * f64::EPSILON * normal.abs().element_sum() * corner.abs().max(centre.abs()).max_element();
            let value = normal.dot(corner - centre);
            if value.abs() > slack { value.signum() } else { 0.0 }
        });
        let sum: f64 = signs.sum();
        (sum.abs() == cell.len() as f64).then(|| sum.signum())
    }

    /// Bounds over a convex cell of the face, by what may shadow it; and what may shadow its parts.
    pub(crate) fn bounds(&self, cell: &[DVec3], candidates: &InShaft) -> (CellBounds, InShaft) {
        if self.is_turned_away {
            return (CellBounds::UMBRA, InShaft::default());
        }
        // From a point in the light's own plane nothing is bounded; smaller cells are off it.
        let views = self.light_plane_side(cell).and_then(|_| Views::new(cell, self.light));
        let Some(views) = views else { return (CellBounds::UNKNOWN, candidates.clone()) };
        let shaft = self.shaft(cell);
        let mut kept = InShaft::default();
        let cover = self.cover(&views, &shaft, candidates, &mut kept);
        let mut base = views.centre.whole();
        if let Some((normal, _)) = self.front {
            let above = views.centre.half_plane(normal);
            let is_cut = Polygon::square().0.iter().any(|&corner| above(corner) < 0.0);
            if is_cut && matches!(self.light.extent, Extent::Sphere { .. }) {
                // The horizon of a ball's image moves with the point; no bound is made for that.
                return (CellBounds::UNKNOWN, candidates.clone());
            }
            if is_cut {
                base.keep(above);
            }
        }
        if base.pieces.is_empty() {
            return (CellBounds::UMBRA, InShaft::default());
        }
        let mut bounds = bounds_of(&views, &base, &cover);
        for &body in &candidates.bodies {
            let bodies = &self.queries.bodies;
            if !shaft.may_meet(&bodies.boxes[body as usize]) {
                continue;
            }
            kept.bodies.push(body);
            let (least, most) = self.hidden_by(body, cell, &views);
            bounds.lower = (bounds.lower - most).max(0.0);
            bounds.upper = bounds.upper.min(1.0 - least).max(0.0);
            bounds.estimate -= 0.5 * (least + most);
        }
        bounds.estimate = bounds.estimate.clamp(bounds.lower, bounds.upper);
        (bounds, kept)
    }

    /// The images of the faces in the shaft and the bands along their borders, object by object.
    fn cover(&self, views: &Views, shaft: &HullShaft, candidates: &InShaft, kept: &mut InShaft) -> Cover {
        let mut cover = Cover::default();
        for faces in candidates.faces.chunk_by(|a, b| a.0 == b.0) {
            let Body::Flat(facets) = self.queries.bodies.get(faces[0].0 as usize) else { continue };
            let mut outline = Outline::default();
            for &(object, face) in faces {
                let mut polygon: Vec<DVec3> = corners(facets, face as usize).collect();
                shaft.cut(&mut polygon);
                if polygon.len() < 3 {
                    continue;
                }
                kept.faces.push((object, face));
                outline.add(facets, face as usize, &polygon, views);
            }
            outline.finish(facets, shaft, views, &mut cover);
        }
        cover
    }

    /// The least and the greatest share of the light that a curved body hides from points of the cell.
    fn hidden_by(&self, body: u32, cell: &[DVec3], views: &Views) -> (f64, f64) {
        if let (Some(ball), Shape::Disk { cap, .. }) = (self.queries.ball(body), views.centre.shape) {
            return hidden_by_ball(&ball, cap, self.light, cell, views.centre.eye);
        }
        let Body::Analytic(placed) = self.queries.bodies.get(body as usize) else { return (0.0, 1.0) };
        let sources: Vec<LightSource> = match &self.hull {
            LightHull::Points(points) => {
                points.iter().filter_map(|point| LightSource::point(point.to_array()).ok()).collect()
            }
            LightHull::Directions(directions) => {
                directions.iter().filter_map(|&direction| LightSource::sun((-direction).to_array()).ok()).collect()
            }
        };
        let hides_all = placed.body().is_convex()
            && cell.iter().all(|&corner| {
                let probe = Probe::<Dyadic>::at(corner);
                sources.iter().all(|source| placed.blocks(&probe, None, source))
            });
        if hides_all { (1.0, 1.0) } else { (0.0, 1.0) }
    }
}

/// The bounds that faces leave.
fn bounds_of(views: &Views, base: &Pieces, cover: &Cover) -> CellBounds {
    let mut seen = base.clone();
    let mut is_touched = false;
    cover.faces.iter().for_each(|face| is_touched |= seen.subtract(face));
    let (estimate, error) = views.centre.share_of(&seen);
    let (of_base, base_error) = views.centre.share_of(base);
    let mut off_borders = base.clone();
    let mut has_bands = false;
    cover.borders.iter().for_each(|band| has_bands |= off_borders.subtract(band));
    if !has_bands && estimate <= error && of_base > 4.0 * (error + base_error) {
        // No border moves over the light, and the middle sees none of it.
        return CellBounds::UMBRA;
    }
    let (outside, _) = views.centre.share_of(&off_borders);
    cover.faces.iter().for_each(|face| _ = off_borders.subtract(face));
    let (not_hidden, open_error) = views.centre.share_of(&off_borders);
    cover.fringes.iter().for_each(|fringe| is_touched |= off_borders.subtract(fringe));
    let (open, fringe_error) = views.centre.share_of(&off_borders);
    let rounding = if base.cuts == 0 && !is_touched && !has_bands {
        0.0
    } else {
        error + 2.0 * (base_error + open_error + fringe_error)
    };
    let (lower, upper) =
        if rounding == 0.0 { (1.0, 1.0) } else { (open - rounding, not_hidden + (of_base - outside) + rounding) };
    let lower = if cover.has_unbounded { 0.0 } else { lower.clamp(0.0, 1.0) };
    views.rim.widened(CellBounds { lower, upper: upper.clamp(0.0, 1.0), estimate })
}

/// What the faces of one object do: their images, and which of their edges are borders.
#[derive(Default)]
struct Outline {
    faces: Vec<Polygon>,
    /// By ranks of the ends: how often it is used one way more than the other, the ends' points, and whether it is a border in any case.
    edges: BTreeMap<(u32, u32), (i32, [u32; 2], bool)>,
    reach: f64,
    has_unbounded: bool,
}

impl Outline {
    /// Adds a face with the part of it in the shaft.
    fn add(&mut self, facets: &Facets, face: usize, part: &[DVec3], views: &Views) {
        let images: Option<Vec<(DVec2, f64)>> = part.iter().map(|&corner| views.project(corner)).collect();
        let Some(images) = images else {
            self.has_unbounded = true;
            return;
        };
        self.reach = images.iter().map(|&(_, shift)| shift).fold(self.reach, f64::max);
        let mut image = Polygon(images.into_iter().map(|(point, _)| point).collect());
        let area = image.area();
        let (numbers, ranks) = (facets.facet(face).corners(), facets.ranked(face).corners());
        for k in 0..numbers.len() {
            let next = (k + 1) % numbers.len();
            let forward = ranks[k] < ranks[next];
            let (key, ends) = if forward {
                ((ranks[k], ranks[next]), [numbers[k], numbers[next]])
            } else {
                ((ranks[next], ranks[k]), [numbers[next], numbers[k]])
            };
            let edge = self.edges.entry(key).or_insert((0, ends, false));
            // Seen edge-on, a face has no turn: its edges are borders.
            edge.2 |= area == 0.0;
            edge.0 += if forward == (area > 0.0) { 1 } else { -1 };
        }
        if area < 0.0 {
            image.0.reverse();
        }
        if area != 0.0 {
            self.faces.push(image);
        }
    }

    /// Adds all to the cover.
    fn finish(self, facets: &Facets, shaft: &HullShaft, views: &Views, cover: &mut Cover) {
        cover.has_unbounded |= self.has_unbounded;
        let reach = self.reach + views.rim.growth;
        cover
            .fringes
            .extend(self.faces.iter().flat_map(Polygon::edges).map(|edge| Polygon::round_segment(edge, reach)));
        for (net, ends, is_border) in self.edges.into_values() {
            if net == 0 && !is_border {
                continue;
            }
            let Some(segment) = shaft.cut_segment(ends.map(|end| facets.positions()[end as usize])) else { continue };
            match (views.project(segment[0]), views.project(segment[1])) {
                (Some((a, at_a)), Some((b, at_b))) => {
                    cover
                        .borders
                        .push(Polygon::round_segment([a, b], self.reach.max(at_a).max(at_b) + views.rim.growth));
                }
                _ => cover.has_unbounded = true,
            }
        }
        cover.faces.extend(self.faces);
    }
}

impl Views {
    fn new(cell: &[DVec3], light: &Light) -> Option<Self> {
        let middle = cell.iter().sum::<DVec3>() / cell.len() as f64;
        let centre = Window::new(middle, light)?;
        let mut all = Vec::with_capacity(cell.len() + 1);
        let mut rim = Rim::NONE;
        if let (Extent::Sphere { radius }, Shape::Disk { tangent, cap }) = (light.extent, centre.shape) {
            // A plane through the ball's middle serves the whole cell.
            let (to_light, distance) = (cap.towards, cap.towards.length());
            let mut nearest = distance;
            for &eye in cell.iter().chain([&middle]) {
                let mut axes = centre.axes * distance;
                axes.z_axis = light.source.xyz() - eye;
                let depth = axes.z_axis.dot(to_light) / distance;
                nearest = nearest.min(depth);
                all.push(Window::with_axes(eye, axes, 1.0 - radius / depth, centre.shape).filter(|_| depth > radius)?);
            }
            rim = Rim::of_ball(cell, middle, light.source.xyz(), radius, tangent, nearest)?;
        } else {
            for &eye in cell.iter().chain([&middle]) {
                all.push(Window::new(eye, light)?);
            }
        }
        let stretch = all.iter().map(Window::stretch).fold(0.0, f64::max);
        Some(Self { centre, all, rounding: IMAGE_ROUNDING * stretch, rim })
    }

    /// The image of a point from the middle, and how far off it may be from elsewhere in the cell. `None` where that has no bound: the point is
    /// not before all of the cell, or not before the light.
    fn project(&self, point: DVec3) -> Option<(DVec2, f64)> {
        let size = point.abs().max_element() + self.centre.eye.abs().max_element();
        let image = |window: &Window| {
            let seen = window.homogeneous(point);
            let slack = self.rounding * size;
            let is_between = seen.z > 2.0 * slack && seen.z <= window.end + slack;
            is_between.then(|| {
                let image = seen.truncate() / seen.z;
                (image, slack * (2.0 + image.abs().max_element()) / (seen.z - slack))
            })
        };
        let (own, mut shift) = image(self.all.last()?)?;
        for window in &self.all {
            let (other, slack) = image(window)?;
            shift = shift.max((other - own).length() + 2.0 * slack);
        }
        Some((own, shift))
    }
}

impl Rim {
    const NONE: Self = Self { inner: 1.0, outer: 1.0, density: 1.0, growth: 0.0 };

    /// Of a ball of light. From x at the angle τ to the axis through the cell's middle, the image on the plane through the ball's middle reaches
    /// between R / cos(ρ − τ) and R / cos(ρ + τ). The density d/|p − x|³ on that plane differs from the middle's by a factor whose
    /// logarithm changes by 3|Δx| / (d d₀) a metre at most.
    fn of_ball(cell: &[DVec3], middle: DVec3, light: DVec3, radius: f64, tangent: f64, nearest: f64) -> Option<Self> {
        let axis = light - middle;
        let reach = cell.iter().map(|&corner| (corner - middle).length()).fold(0.0, f64::max);
        let tilt = cell.iter().map(|&corner| angle(axis, light - corner)).fold(0.0, f64::max);
        let (near, far) = (axis.length() - reach, axis.length() + reach);
        if near <= radius {
            return None;
        }
        let (narrow, wide) = (libm::asin(radius / far), libm::asin(radius / near));
        if wide + tilt >= std::f64::consts::FRAC_PI_2 {
            return None;
        }
        let unit = tangent * axis.length();
        let (least, most) = (radius / libm::cos((narrow - tilt).max(0.0)), radius / libm::cos(wide + tilt));
        let whole = cap_area(libm::atan(tangent));
        let share = |reach: f64| cap_area(libm::atan(tangent * reach / unit)) / whole;
        let density = libm::exp(6.0 * most * reach / (axis.length() * nearest));
        let rounding = 64.0 * f64::EPSILON;
        Some(Self {
            inner: share(least).min(1.0) - rounding,
            outer: share(most).max(1.0) + rounding,
            density,
            growth: (most / unit - 1.0).max(0.0) + rounding,
        })
    }

    /// Bounds for the light as the middle sees it, made bounds for the light as each point sees it.
    fn widened(&self, bounds: CellBounds) -> CellBounds {
        let CellBounds { lower, upper, estimate } = bounds;
        if (lower, upper) == (0.0, 0.0) || (lower, upper) == (1.0, 1.0) {
            return bounds;
        }
        let lower = ((lower - (1.0 - self.inner)) / (self.density * self.outer)).max(0.0);
        let upper = ((upper + (self.outer - 1.0)) * self.density / self.inner).min(1.0);
        CellBounds { lower, upper, estimate: estimate.clamp(lower, upper) }
    }
}

/// The least and greatest share of a round light that a ball hides from a cell: the overlap of two caps grows with the ball's cap and falls with
/// their distance; radii and distance change by no more than the cell's reach does to each.
fn hidden_by_ball(ball: &Ball, light_cap: Cap, light: &Light, cell: &[DVec3], middle: DVec3) -> (f64, f64) {
    let reach = cell.iter().map(|&corner| (corner - middle).length()).fold(0.0, f64::max) * (1.0 + 8.0 * f64::EPSILON);
    let to_ball = ball.center - middle;
    let at_ball = to_ball.length();
    if at_ball - reach <= ball.radius {
        return (0.0, 1.0);
    }
    let ball_radii = [at_ball + reach, at_ball - reach].map(|distance| libm::asin(ball.radius / distance));
    let (light_radii, light_turn) = match light.extent {
        Extent::Sphere { radius } => {
            let distance = light_cap.towards.length();
            // A ball beyond the light, or in it, hides what nobody has bounded.
            if distance - reach <= radius || at_ball + ball.radius + 2.0 * reach > distance - radius {
                return (0.0, 1.0);
            }
            let radii = [distance + reach, distance - reach].map(|distance| libm::asin(radius / distance));
            (radii, libm::asin(reach / distance))
        }
        _ => ([light_cap.radius; 2], 0.0),
    };
    let turn = libm::asin(reach / at_ball) + light_turn;
    let apart = angle(to_ball, light_cap.towards);
    let rounding = 64.0 * f64::EPSILON;
    let least = common_area(light_radii[0], ball_radii[0], apart + turn) / cap_area(light_radii[1]);
    let most = common_area(light_radii[1], ball_radii[1], (apart - turn).max(0.0)) / cap_area(light_radii[0]);
    // Hidden altogether, or not at all, from everywhere: no share at all of the other.
    if ball_radii[0] >= apart + turn + light_radii[1] + rounding {
        return (1.0, 1.0);
    }
    if light_radii[1] + ball_radii[1] + rounding <= apart - turn {
        return (0.0, 0.0);
    }
    ((least - rounding).clamp(0.0, 1.0), (most + rounding).clamp(0.0, 1.0))
}
