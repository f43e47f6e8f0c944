//! Frusta through portals, without constructed points.
//!
//! Seen from the eye, a point is an *image*: the vector p − e, or for a light without a place (a sun, a parallel view) the place
//! where the line along its direction meets a plane of coordinates, as a homogeneous point of that plane. Lines through the eye are images up
//! to a positive factor, planes through it are linear forms n on images, and a frustum is a cone n₁·x ≥ 0, ..., nₖ·x ≥ 0 whose forms
//! stand in cyclic order round it. The form of an edge from a to b is the cross product of their images. So the corner rays of a cone are
//! nᵢ × nᵢ₊₁, and on which side of a further plane m one lies is the sign of a determinant of three forms, of degree six in coordinates.
//!
//! What two portals show through each other is the intersection of their cones, and its forms are some of theirs: nothing is ever
//! rounded, however long the chain. Signs go through a filter first; images are scaled by powers of two before, so that degree six
//! neither overflows nor loses the filter's bound. Where a plane only touches a cone, the cone stays as it is: larger, never smaller.

use glam::DVec3;
use umbriel_geometry::{Aabb, Approx, Decide, Dyadic, LightSource, Sign, decisions::decide, predicates};
use umbriel_scene::Projection;

use crate::view::{View, corners};

/// What an edge of a frustum goes through.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Corner {
    /// A point of the world.
    World(DVec3),
    /// A direction from the eye.
    Along(DVec3),
}

/// A plane through the eye and an edge; the inside of its frustum is where its form is not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SidePlane {
    from: Corner,
    to: Corner,
    normal: [Approx; 3],
}

/// What can be seen from an eye through a chain of portals: a cone with any number of side planes, or all that there is.
#[derive(Clone, Debug, PartialEq)]
pub struct Frustum {
    eye: LightSource,
    /// In cyclic order; none for the whole space.
    planes: Vec<SidePlane>,
}

/// How the eye lies to a portal's plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EyeSide {
    /// Strictly where the corners run counter-clockwise.
    Front,
    /// Strictly on the other side.
    Behind,
    /// In the plane, or on different sides of the planes of a polygon that is planar up to rounding only.
    Within,
}

impl Frustum {
    /// All that there is.
    pub(super) fn everything(eye: LightSource) -> Self {
        Self { eye, planes: Vec::new() }
    }

    /// The rays of a picture; `None` if the eye or its direction is not accepted.
    ///
    /// The rays of pixels are rounded. A direction is three products, two sums and a division by its length, so each component is off by less
    /// than 16 u of the vector; the cone is wider by 2^-40, more than 2^8 times that. So are the origins of parallel rays.
    pub fn of_view(view: &View) -> Option<Self> {
        const WIDER: f64 = f64::EPSILON * 4096.0;
        let (camera, basis) = (&view.camera, view.basis());
        let aspect = f64::from(view.width) / f64::from(view.height);
        let signs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let (eye, corners) = match camera.projection {
            Projection::Perspective { vertical_degrees } => {
                let half = (0.5 * vertical_degrees).to_radians().tan();
                let wider = |extent: f64| extent + WIDER * (1.0 + half * (1.0 + aspect));
                let (right, up) = (wider(half * aspect) * basis.right, wider(half) * basis.up);
                let eye = LightSource::point(camera.eye.to_array()).ok()?;
                (eye, signs.map(|(s, t)| Corner::Along(basis.forward + s * right + t * up)))
            }
            Projection::Orthographic { height } => {
                let reach = camera.eye.abs().max_element() + height * (1.0 + aspect);
                let wider = |extent: f64| extent + WIDER * reach;
                let (right, up) = (wider(0.5 * height * aspect) * basis.right, wider(0.5 * height) * basis.up);
                let eye = LightSource::sun(basis.forward.to_array()).ok()?;
                (eye, signs.map(|(s, t)| Corner::World(camera.eye + s * right + t * up)))
            }
            _ => return None,
        };
        let planes = cone(&eye, &corners)?;
        Some(Self { eye, planes })
    }

    /// What is seen of it through a portal in whose plane the eye does not lie; `None` if that is nothing.
    pub(super) fn through(&self, portal: &[DVec3]) -> Option<Self> {
        let corners: Vec<Corner> = portal.iter().map(|&corner| Corner::World(corner)).collect();
        let Some(planes) = cone(&self.eye, &corners) else { return Some(self.clone()) };
        let mut narrowed = Self { eye: self.eye, planes };
        self.planes.iter().all(|plane| narrowed.cut(plane)).then_some(narrowed)
    }

    /// Keeps what is on the inner side of a plane; false if all of it is strictly outside.
    fn cut(&mut self, plane: &SidePlane) -> bool {
        let count = self.planes.len();
        // Corner i lies between planes i and i + 1.
        let signs: Vec<Sign> =
            (0..count).map(|i| self.sign_of_corner(plane, &self.planes[i], &self.planes[(i + 1) % count])).collect();
        if !signs.contains(&Sign::Positive) {
            return signs.contains(&Sign::Zero);
        }
        if !signs.contains(&Sign::Negative) {
            return true;
        }
        let is_after_corner = |i: usize| signs[(i + count - 1) % count] == Sign::Positive;
        // Plane i runs from corner i − 1 to corner i. As the cone is convex, those with a corner inside follow each other.
        let start = (0..count).find(|&i| signs[i] == Sign::Positive && !is_after_corner(i)).unwrap_or(0);
        let run = (start..start + count).map(|i| i % count);
        let kept: Vec<usize> = run.take_while(|&i| i == start || is_after_corner(i)).collect();
        let mut planes: Vec<SidePlane> = kept.into_iter().map(|i| self.planes[i]).collect();
        planes.push(*plane);
        self.planes = planes;
        true
    }

    /// The side of a plane on which the corner ray between two others lies. Exact.
    fn sign_of_corner(&self, plane: &SidePlane, before: &SidePlane, after: &SidePlane) -> Sign {
        let filtered = dot(&plane.normal, &cross(&before.normal, &after.normal));
        decide(filtered.sign(), || {
            let [plane, before, after] = [plane, before, after].map(|side| side.exact(&self.eye));
            known(&dot(&plane, &cross(&before, &after)))
        })
    }

    /// Whether a box is surely outside: all corners strictly beyond one of the planes. Doubt is a no.
    pub fn misses(&self, bounds: &Aabb) -> bool {
        if self.planes.is_empty() {
            return false;
        }
        let corners: [[Approx; 3]; 8] = corners(bounds).map(|corner| scaled_image(&self.eye, Corner::World(corner)));
        let is_beyond =
            |plane: &SidePlane| corners.iter().all(|corner| dot(&plane.normal, corner).sign() == Some(Sign::Negative));
        self.planes.iter().any(is_beyond)
    }

    /// How many side planes it has; none for all that there is.
    pub fn sides(&self) -> usize {
        self.planes.len()
    }
}

/// How the eye lies to a polygon's plane. Exact.
pub(super) fn side_of_eye(eye: &LightSource, portal: &[DVec3]) -> EyeSide {
    let point = umbriel_geometry::Point::exact;
    let sides = portal[1..]
        .windows(2)
        .map(|edge| predicates::light_side(&point(portal[0]), &point(edge[0]), &point(edge[1]), eye));
    let sides: Vec<Sign> = sides.collect();
    if sides.iter().all(|&side| side == Sign::Positive) {
        EyeSide::Front
    } else if sides.iter().all(|&side| side == Sign::Negative) {
        EyeSide::Behind
    } else {
        EyeSide::Within
    }
}

impl SidePlane {
    fn new(eye: &LightSource, from: Corner, to: Corner) -> Self {
        Self { from, to, normal: cross(&scaled_image(eye, from), &scaled_image(eye, to)) }
    }

    fn exact(&self, eye: &LightSource) -> [Dyadic; 3] {
        cross(&image(eye, self.from), &image(eye, self.to))
    }
}

/// The planes round a strictly convex polygon, turned so that it is inside; `None` if the eye sees it edge-on.
fn cone(eye: &LightSource, corners: &[Corner]) -> Option<Vec<SidePlane>> {
    let count = corners.len();
    let turn = |i: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % count]);
        let filtered = dot(&scaled_image(eye, c), &cross(&scaled_image(eye, a), &scaled_image(eye, b)));
        decide(filtered.sign(), || {
            let [a, b, c] = [a, b, c].map(|corner| image::<Dyadic>(eye, corner));
            known(&dot(&c, &cross(&a, &b)))
        })
    };
    let first = turn(0);
    if first == Sign::Zero || (1..count).any(|i| turn(i) != first) {
        return None;
    }
    let edge = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % count]);
        if first == Sign::Positive { SidePlane::new(eye, a, b) } else { SidePlane::new(eye, b, a) }
    };
    let planes = (0..count).map(edge);
    Some(if first == Sign::Positive { planes.collect() } else { planes.rev().collect() })
}

/// A corner as the eye sees it.
fn image<T: Decide>(eye: &LightSource, corner: Corner) -> [T; 3] {
    let numbers = |v: DVec3| v.to_array().map(T::number);
    let e = eye.xyz();
    match corner {
        Corner::Along(direction) => numbers(direction),
        Corner::World(point) if !eye.is_sun() => std::array::from_fn(|k| T::number(point[k]) - T::number(e[k])),
        Corner::World(point) => {
            let k = e.abs().max_position();
            let (p, d) = (numbers(point), numbers(e));
            let along = |i: usize| p[i].clone() * d[k].clone() - p[k].clone() * d[i].clone();
            [along((k + 1) % 3), along((k + 2) % 3), d[k].clone()]
        }
    }
}

/// An image times a power of two that makes its largest component about one.
fn scaled_image(eye: &LightSource, corner: Corner) -> [Approx; 3] {
    let image: [Approx; 3] = image(eye, corner);
    let greatest = image.iter().fold(0.0_f64, |most, component| most.max(component.value.abs()));
    if greatest == 0.0 || !greatest.is_finite() {
        return image;
    }
    // Coordinates lie within 2^±200, so the factor is a normal number.
    let exponent = (greatest.to_bits() >> 52 & 0x7ff) as i64 - 1023;
    let factor = f64::from_bits(((1023 - exponent).clamp(1, 2045) as u64) << 52);
    image.map(|Approx { value, error }| {
        let scaled = value * factor;
        let error = if error == 0.0 { 0.0 } else { (error * factor).next_up() };
        // What a component far below the others loses to underflow.
        let lost = if scaled / factor == value { 0.0 } else { f64::MIN_POSITIVE };
        Approx { value: scaled, error: error + lost }
    })
}

fn cross<T: Decide>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i].clone() * b[j].clone() - a[j].clone() * b[i].clone()
    })
}

fn dot<T: Decide>(a: &[T; 3], b: &[T; 3]) -> T {
    T::sum_of_three(std::array::from_fn(|k| a[k].clone() * b[k].clone()))
}

/// The sign of an exact number.
fn known(number: &Dyadic) -> Sign {
    number.decide().unwrap_or(Sign::Zero)
}
