//! Horizons: what of an area light is on the lit side of the points of a cell.
//!
//! For a flat face that is one side of a plane. On a curved body the tangent plane turns from point to point; how high a light stands over it is the
//! surface's polar form, affine in the point and in the light. So a light point that is above the planes at all corners of a cell's hull is above all of
//! the cell's, and one that is below them all is below. Of a ball of light the share above a plane is a closed form of elevation and radius.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};
use umbriel_geometry::{
    Approx, Facets, LightSource, PlacedAnalytic, Point, Sign,
    analytic::{Chart, LocalPoint, Surface},
    predicates::{self, Target},
};
use umbriel_scene::{Extent, Light};

use super::{
    caps::{cap_area, common_area},
    cell::Cell,
    normal::{Normal, exact},
    occluders::LightHull,
    polygon::{Pieces, Polygon},
    window::{Shape, Window},
};

/// The side of a receiver that can be lit.
#[derive(Clone, Copy, Debug)]
pub(super) enum LitSide<'a> {
    /// All of the light is behind it.
    Away,
    /// Of a flat face.
    Plane(FacePlane<'a>),
    /// Both sides of a flat face, and light on both.
    Both,
    /// It changes from cell to cell.
    Patch(CurvedSide<'a>),
}

/// The plane of a flat face.
#[derive(Clone, Copy, Debug)]
pub(super) struct FacePlane<'a> {
    corner: Point<'a>,
    /// To the side that is lit.
    pub(super) normal: Normal,
    /// The sign of points on that side in exact predicates.
    pub(super) front: Sign,
}

/// A patch of a curved body.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurvedSide<'a> {
    pub(super) body: &'a PlacedAnalytic,
    pub(super) chart: &'a Chart,
    pub(super) is_one_sided: bool,
}

/// What of an area light is above the horizon of a cell's points.
#[derive(Clone, Debug)]
pub(super) enum Above {
    /// All of it, of all points; a convex body is not in its own way.
    All,
    /// None of it, of any point.
    Nothing,
    /// Parts of the light's image.
    Between {
        /// Above the horizon of all points.
        least: Pieces,
        /// Above the horizon of some point.
        most: Pieces,
    },
    /// A share of the light, the least and the greatest.
    Share([f64; 2]),
}

impl Above {
    fn of_share([least, most]: [f64; 2]) -> Self {
        match (least, most) {
            (1.0, _) => Self::All,
            (_, 0.0) => Self::Nothing,
            _ => Self::Share([least, most]),
        }
    }
}

impl<'a> LitSide<'a> {
    /// Of a flat face.
    pub(super) fn of_flat(facets: &'a Facets, face: usize, is_one_sided: bool, light: &LightHull) -> Self {
        let corner = facets.point(facets.facet(face).corners()[0]);
        let plane = FacePlane { corner, normal: Normal::of_face(facets, face), front: front(facets) };
        let [all_before, all_behind] = sides_of_light(facets, face, light);
        match (is_one_sided, all_before, all_behind) {
            (true, _, true) => Self::Away,
            (true, ..) | (false, true, _) => Self::Plane(plane),
            (false, _, true) => Self::Plane(plane.flipped()),
            (false, ..) => Self::Both,
        }
    }

    /// What of the light is above the horizon of the cell's points; `window` is the view of the light from the cell's middle.
    pub(super) fn above(&self, cell: &Cell, light: &Light, window: &Window) -> Above {
        match self {
            Self::Away => Above::Nothing,
            Self::Both => Above::All,
            Self::Plane(plane) => plane.above(cell, light, window),
            Self::Patch(side) => side.above(cell, light, window),
        }
    }
}

/// The sign of points before a face in exact predicates.
fn front(facets: &Facets) -> Sign {
    if facets.is_mirrored() { Sign::Negative } else { Sign::Positive }
}

/// Whether all of the light is certainly before a face, and whether all of it is behind: by the filter of exact predicates, with the roundings of placed
/// corners and of the light's own points in its bound.
fn sides_of_light(facets: &Facets, face: usize, light: &LightHull) -> [bool; 2] {
    let numbers = facets.facet(face).corners();
    let [a, b, c] = [0, 1, numbers.len() - 1].map(|k| facets.point(numbers[k]));
    let of_point = |&position: &DVec3| {
        // A point of a hull is a sum of three numbers.
        let slack = DVec3::splat(4.0 * f64::EPSILON * position.abs().max_element());
        predicates::side_filter(&a, &b, &c, Target::Point(&Point::within(position, slack))).sign()
    };
    let of_direction = |&direction: &DVec3| {
        let sun = LightSource::sun((-direction).to_array()).ok()?;
        let Approx { value, error } = predicates::side_filter(&a, &b, &c, Target::Light(&sun));
        // So many roundings may have turned the direction: they count by the terms of the normal.
        let [u, v] = [b, c].map(|corner| (corner.position - a.position).abs());
        let terms = u.y * v.z + u.z * v.y + u.z * v.x + u.x * v.z + u.x * v.y + u.y * v.x;
        let turned = 16.0 * f64::EPSILON * terms * direction.abs().max_element();
        Approx { value, error: error + turned }.sign()
    };
    let sides: Vec<Option<Sign>> = match light {
        LightHull::Points(points) => points.iter().map(of_point).collect(),
        LightHull::Directions(directions) => directions.iter().map(of_direction).collect(),
    };
    let front = front(facets);
    [front, front.flipped()].map(|side| sides.iter().all(|&of| of == Some(side)))
}

/// On which side of a face's plane, in exact predicates, all of the light lies; `None` if it may be on both.
pub(super) fn side_of_light(facets: &Facets, face: usize, light: &LightHull) -> Option<Sign> {
    match sides_of_light(facets, face, light) {
        [true, _] => Some(front(facets)),
        [_, true] => Some(front(facets).flipped()),
        _ => None,
    }
}

impl FacePlane<'_> {
    fn flipped(self) -> Self {
        Self { normal: self.normal.flipped(), front: self.front.flipped(), ..self }
    }

    /// What of the light is above the plane.
    fn above(&self, cell: &Cell, light: &Light, window: &Window) -> Above {
        let centre = light.source.xyz();
        if let Extent::Sphere { radius } = light.extent {
            return self.above_ball(cell, centre, radius);
        }
        let over = match light.extent {
            Extent::Rectangle { u, v } => {
                [self.height(centre), self.normal.along(exact(u)), self.normal.along(exact(v))]
            }
            _ => over_axes(&self.normal, window, DVec3::ZERO),
        };
        if least_over(&window.shape, &over) > 0.0 {
            return Above::All;
        }
        if least_over(&window.shape, &over.map(|value| -value)) > 0.0 {
            return Above::Nothing;
        }
        let (mut least, mut most) = (window.whole(), window.whole());
        least.keep(|p| height_at(&over, p).lower());
        most.keep(|p| height_at(&over, p).upper());
        if most.pieces.is_empty() { Above::Nothing } else { Above::Between { least, most } }
    }

    fn above_ball(&self, cell: &Cell, centre: DVec3, radius: f64) -> Above {
        let (height, length) = (self.height(centre), self.normal.length());
        let reach = length * Approx::exact(radius);
        if (height - reach).lower() > 0.0 {
            return Above::All;
        }
        if (height + reach).upper() <= 0.0 {
            return Above::Nothing;
        }
        Above::of_share(share_of_ball(&[height], [length.lower(), length.upper()], cell, centre, radius))
    }

    /// How high a point is over the plane, times the length of the normal.
    fn height(&self, point: DVec3) -> Approx {
        self.normal.along(Point::exact(point).minus(&self.corner))
    }
}

/// How high the light's image is over the plane through the eye with this normal. The axes of a round light are rounded, that to its middle by
/// another `moved`, by coordinate.
pub(super) fn over_axes(normal: &Normal, window: &Window, moved: DVec3) -> HeightOverPlane {
    // A dozen roundings of a vector's length make an axis.
    let rounding = |axis: DVec3| DVec3::splat(16.0 * f64::EPSILON * axis.abs().max_element());
    let bounded = |axis: DVec3, error: DVec3| -> [Approx; 3] {
        std::array::from_fn(|k| Approx { value: axis[k], error: error[k] })
    };
    let [u, v, w] = [window.axes.x_axis, window.axes.y_axis, window.axes.z_axis];
    [(w, moved), (u, DVec3::ZERO), (v, DVec3::ZERO)]
        .map(|(axis, moved)| normal.along(bounded(axis, rounding(axis) + moved)))
}

/// The height of a point of the image; its bounds are affine, but for their own rounding.
pub(super) fn height_at([at, along_u, along_v]: &HeightOverPlane, p: DVec2) -> Approx {
    // In the image no coordinate is above one.
    let error = at.error + along_u.error + along_v.error;
    Approx { value: at.value + along_u.value * p.x + along_v.value * p.y, error }
}

/// The least and the greatest share of a ball above the horizon of a cell's points. `heights` are those of its middle over the tangent planes at the cell's
/// corners, times the lengths of these planes' normals; of the latter the least and the greatest over the cell are given.
///
/// The sine of the middle's elevation is its height over its distance. The share grows with the elevation, and with the ball's angular radius it tends
/// to a half: so it is least and greatest at ends of both intervals.
fn share_of_ball(heights: &[Approx], normals: [f64; 2], cell: &Cell, centre: DVec3, radius: f64) -> [f64; 2] {
    let rounding = 64.0 * f64::EPSILON;
    let distance = (centre - cell.middle).length();
    // Corners and middle are rounded in world coordinates.
    let reach = cell.reach() + rounding * cell.middle.abs().max_element();
    let (near, far) = ((distance - reach) * (1.0 - rounding), (distance + reach) * (1.0 + rounding));
    if near <= radius || normals[0] <= 0.0 {
        return [0.0, 1.0];
    }
    let least = heights.iter().map(|height| height.lower()).fold(f64::INFINITY, f64::min);
    let most = heights.iter().map(|height| height.upper()).fold(f64::NEG_INFINITY, f64::max);
    let (small, large) = (normals[0] * near * (1.0 - rounding), normals[1] * far * (1.0 + rounding));
    let sines = [least / if least < 0.0 { small } else { large }, most / if most < 0.0 { large } else { small }];
    let [low, high] = sines.map(|sine| libm::asin(sine.clamp(-1.0, 1.0)));
    let radii = [libm::asin(radius / far), libm::asin(radius / near)];
    let share = |elevation: f64, cap: f64| common_area(FRAC_PI_2, cap, FRAC_PI_2 - elevation) / cap_area(cap);
    let shares = |elevation: f64| radii.map(|cap| share(elevation, cap));
    let (low, high) = (low - rounding, high + rounding);
    let is_whole = low > radii[1] + rounding;
    let is_down = high < -radii[1] - rounding;
    let least = shares(low).into_iter().fold(1.0, f64::min) - rounding;
    let most = shares(high).into_iter().fold(0.0, f64::max) + rounding;
    [if is_whole { 1.0 } else { least.max(0.0) }, if is_down { 0.0 } else { most.min(1.0) }]
}

/// How high a point of the light's image (a, b) is over a plane: the first number, and what a and b add.
pub(super) type HeightOverPlane = [Approx; 3];

impl CurvedSide<'_> {
    /// What of the light is above the tangent planes at a cell's points.
    fn above(&self, cell: &Cell, light: &Light, window: &Window) -> Above {
        if !self.is_one_sided && !self.body.body().is_closed() {
            return Above::All;
        }
        let corners: Vec<LocalPoint<Approx>> =
            cell.corners.iter().map(|&corner| self.local(corner, cell.slack)).collect();
        if let Extent::Sphere { radius } = light.extent {
            return self.above_ball(&corners, cell, light.source.xyz(), radius);
        }
        let [u, v, w] = match light.extent {
            Extent::Rectangle { u, v } => [self.direction(u), self.direction(v), self.local(light.source.xyz(), 0.0)],
            _ => [window.axes.x_axis, window.axes.y_axis, window.axes.z_axis].map(|axis| self.direction(axis)),
        };
        let over = |x: &LocalPoint<Approx>| [&w, &u, &v].map(|l| self.height(x, l));
        let planes: Vec<HeightOverPlane> = corners.iter().map(over).collect();
        if planes.iter().all(|plane| least_over(&window.shape, plane) > 0.0) {
            return Above::All;
        }
        if !self.is_one_sided {
            // The inner side of a closed surface: only what is inside reaches it.
            return Above::Share([0.0, 1.0]);
        }
        if planes.iter().all(|plane| least_over(&window.shape, &plane.map(|value| -value)) > 0.0) {
            return Above::Nothing;
        }
        let (mut least, mut most, mut below) = (window.whole(), window.whole(), Polygon::square());
        for plane in &planes {
            least.keep(|p| height_at(plane, p).lower());
            below = below.cut(|p| -height_at(plane, p).upper());
        }
        if below.is_empty() {
            return Above::Between { least, most };
        }
        most.subtract(&below);
        if most.pieces.is_empty() { Above::Nothing } else { Above::Between { least, most } }
    }

    fn above_ball(&self, corners: &[LocalPoint<Approx>], cell: &Cell, centre: DVec3, radius: f64) -> Above {
        let at = self.local(centre, 0.0);
        let heights: Vec<Approx> = corners.iter().map(|x| self.height(x, &at)).collect();
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| self.direction(axis));
        let normal = |x: &LocalPoint<Approx>| axes.map(|axis| self.height(x, &axis));
        let middle = normal(&self.local(cell.middle, cell.slack));
        let normals: Vec<[Approx; 3]> = corners.iter().map(normal).collect();
        let upper = |v: [Approx; 3]| DVec3::from_array(v.map(|x| x.value.abs() + x.error)).length();
        let lower = |v: [Approx; 3]| DVec3::from_array(v.map(|x| (x.value.abs() - x.error).max(0.0))).length();
        let turned = |n: &[Approx; 3]| upper(std::array::from_fn(|k| n[k] - middle[k]));
        // The normal is affine in the point.
        let most = normals.iter().map(|&n| upper(n)).fold(0.0, f64::max);
        let least = lower(middle) - normals.iter().map(turned).fold(0.0, f64::max);
        match Above::of_share(share_of_ball(&heights, [least, most], cell, centre, radius)) {
            Above::All => Above::All,
            above if self.is_one_sided => above,
            _ => Above::Share([0.0, 1.0]),
        }
    }

    /// The height of a homogeneous point l over the tangent plane at x, times some length of that plane's normal: affine in both.
    fn height(&self, x: &LocalPoint<Approx>, l: &LocalPoint<Approx>) -> Approx {
        match self.chart.surface {
            Surface::Quadric(quadric) => self.body.forms().quadric(quadric, x, l),
            // Planes are positive inside.
            Surface::Plane(plane) => -self.body.forms().plane(plane, l),
        }
    }

    /// Local coordinates of a direction.
    fn direction(&self, direction: DVec3) -> LocalPoint<Approx> {
        self.body.forms().pull_back_direction(&direction.to_array().map(Approx::exact))
    }

    /// Local coordinates of a point that may be off by `slack` along every axis.
    fn local(&self, position: DVec3, slack: f64) -> LocalPoint<Approx> {
        self.body.forms().pull_back_point(&Point::within(position, DVec3::splat(slack)))
    }
}

/// The least height over all of the light's image, rounded down.
pub(super) fn least_over(shape: &Shape, [at, along_u, along_v]: &HeightOverPlane) -> f64 {
    let slopes = DVec2::new(along_u.value, along_v.value);
    let spread = match shape {
        Shape::Square => slopes.abs().element_sum(),
        Shape::Disk { .. } => slopes.length(),
    };
    let error = at.error + along_u.error + along_v.error;
    at.value - (spread + error) * (1.0 + 8.0 * f64::EPSILON)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use umbriel_geometry::{Dyadic, ExactPoint, Mesh, Placement, Ring, predicates::exact_side};

    struct Chance(u64);

    impl Chance {
        /// From −1 to 1.
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        fn vector(&mut self) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next())
        }
    }

    /// On which side of the plane (a, b, c) the light's point at (s, t) is: exact.
    fn side_of_light_point(corners: &[DVec3; 3], [centre, u, v]: [DVec3; 3], s: f64, t: f64) -> Sign {
        let number = |x: f64| Dyadic::new(x);
        let xyz = std::array::from_fn(|k| number(centre[k]) + number(u[k]) * number(s) + number(v[k]) * number(t));
        let [a, b, c] = corners.map(ExactPoint::from_position);
        exact_side::<Dyadic>(&a, &b, &c, &ExactPoint { xyz, w: number(1.0) }).sign()
    }

    /// Whether a piece holds a point, at least so far inside (or less than so far outside).
    fn holds(pieces: &Pieces, point: DVec2, inside: f64) -> bool {
        let is_inside =
            |piece: &Polygon| piece.edges().all(|[a, b]| (b - a).perp_dot(point - a) >= inside * (b - a).length());
        pieces.pieces.iter().any(is_inside)
    }

    /// What is said to be above a needle's plane is above, by exact signs, however the needle's normal was rounded.
    #[test]
    fn what_is_above_a_needle_is_above_it() {
        let (mut chance, mut told) = (Chance(1), [0; 2]);
        for case in 0..600 {
            let thin = 10f64.powi(-(case % 14));
            let offset = chance.vector() * [0.0, 1.0, 1e4][case as usize % 3];
            let (a, b) = (offset + chance.vector(), offset + chance.vector());
            let c = a + (b - a) * (0.5 + 0.4 * chance.next()) + chance.vector() * thin;
            let light = [offset + chance.vector() * 2.0, chance.vector() * 0.5, chance.vector() * 0.5];
            let extent = Extent::Rectangle { u: light[1], v: light[2] };
            let source = LightSource::point(light[0].to_array()).expect("a point");
            let light_source = Light::with_extent("light", source, extent).expect("a light");
            let mesh = Mesh::new([a, b, c].map(|p| p.to_array()).to_vec(), vec![[0, 1, 2]]).expect("a triangle");
            let facets = Facets::of_mesh(Arc::new(mesh), &Placement::IDENTITY);
            let hull = LightHull::of(&light_source);
            let cell = Cell::flat(vec![a, b, c]);
            let Some(window) = Window::new(cell.middle, &light_source) else { continue };
            let side = LitSide::of_flat(&facets, 0, true, &hull);
            let above = side.above(&cell, &light_source, &window);
            let grid = (0..81).map(|k| DVec2::new(f64::from(k % 9), f64::from(k / 9)) * 0.25 - 1.0);
            // Cuts are rounded by far less.
            let margin = 0.5f64.powi(36);
            for p in grid {
                let is_above = side_of_light_point(&[a, b, c], light, p.x, p.y) == Sign::Positive;
                let (surely, never) = match &above {
                    Above::All => (true, false),
                    Above::Nothing => (false, true),
                    Above::Between { least, most } => (holds(least, p, margin), !holds(most, p, -margin)),
                    Above::Share(_) => (false, false),
                };
                assert!(!surely || is_above, "case {case}: {p} is not above {a} {b} {c}: {light:?}");
                assert!(!never || !is_above, "case {case}: {p} is above {a} {b} {c}: {light:?}");
                told[0] += usize::from(surely);
                told[1] += usize::from(never);
            }
        }
        assert!(told.iter().all(|&count| count > 10_000), "{told:?}");
    }
}
