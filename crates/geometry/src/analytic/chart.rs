//! Patches of a body's surface: a parameter square each, exact points, and hulls of its cells.
//!
//! A cell [u, u + e] × [v, v + e] is held by the hull of eight points: on a sphere, the cone of its four corner directions
//! between two parallel planes; on a surface of revolution, two meridian planes and a quadrilateral round the outline.
//! Hulls shrink with the cell, their thickness with its square.

use glam::DVec3;

use super::{
    Analytic, PlacedAnalytic,
    forms::LocalPoint,
    graph::{Graph, HomogeneousPoint},
    layout::{Surface, symmetric_form},
    outline::Outline,
};
use crate::{
    approx::Approx,
    decide::Decide,
    decisions::decide_by_pairs,
    dyadic::Dyadic,
    pair::Pair,
    placement::Placement,
    point::{ExactPoint, Point},
    predicates::symmetric_sum,
    ring::{Sign, dot},
    surd::Surd,
};

/// Covers the roundings of a point's or hull's construction: two dozen operations on numbers of the body's size.
pub(crate) const PADDING: f64 = 32.0 * f64::EPSILON;

/// Points of a hull.
pub const HULL: usize = 8;

/// A patch of a body's surface with parameters u, v in 0..=1, local coordinates. u × v points outward.
#[derive(Clone, Debug)]
pub struct Chart {
    /// The surface that the patch is part of.
    pub surface: Surface,
    pub(crate) kind: Kind,
}

/// How a patch is drawn.
#[derive(Clone, Debug)]
pub(crate) enum Kind {
    /// center + radii·d/|d| with the direction d = origin + u·along\[0\] + v·along\[1\].
    Radial { center: f64, radii: [f64; 3], origin: [f64; 3], along: [[f64; 3]; 2] },
    /// A quarter turn of an outline about the y axis.
    Turned { quarter: usize, outline: Outline },
    /// A part of a general quadric, or of a side of its box.
    Graph(Box<Graph>),
}

/// Eight points whose convex hull holds a cell, local coordinates; each may be off by `slack` along each axis.
#[derive(Clone, Copy, Debug)]
pub struct CellHull {
    /// The points.
    pub points: [DVec3; HULL],
    /// How far off they may be, along each axis.
    pub slack: DVec3,
}

/// How much of a cell of a patch's parameter square is surface; of two conditions the greater answer holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Occupied {
    /// All of it.
    Whole,
    /// Not known, or only a part.
    Partly,
    /// Nothing.
    Nowhere,
}

/// The axes in the plane y = 0 around which the quarters lie, counter-clockwise seen from +y: (x, z) of each.
const QUARTERS: [[f64; 2]; 4] = [[1.0, 0.0], [0.0, -1.0], [-1.0, 0.0], [0.0, 1.0]];

/// The middle of a quarter and the way u runs: (x, z) of each.
pub(crate) fn quarter_axes(quarter: usize) -> [[f64; 2]; 2] {
    [QUARTERS[quarter], QUARTERS[(quarter + 1) % 4]]
}

/// The direction of a quarter at u, not of unit length: (x, z).
pub(crate) fn quarter_direction<T>(quarter: usize, u: T, number: impl Fn(f64) -> T) -> [T; 2]
where
    T: Clone + std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Mul<Output = T>,
{
    let [axis, next] = quarter_axes(quarter);
    let across = u.clone() + u - number(1.0);
    [0, 1].map(|k| number(axis[k]) + across.clone() * number(next[k]))
}

impl Chart {
    /// The point (u, v), rounded: off by less than 2^-47 of the body's size.
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        match &self.kind {
            Kind::Radial { center, radii, origin, along } => {
                let direction = direction(origin, along, u, v).normalize();
                DVec3::new(0.0, *center, 0.0) + DVec3::from_array(*radii) * direction
            }
            Kind::Turned { quarter, outline } => {
                let [x, z] = quarter_direction(*quarter, u, |value| value);
                let [radius, y] = outline.at(v);
                let scale = radius / (x * x + z * z).sqrt();
                DVec3::new(x * scale, y, z * scale)
            }
            Kind::Graph(graph) => graph.point(u, v),
        }
    }

    /// The exact world point (u, v); `None` where that point of the square is no surface.
    pub fn exact_point(&self, placement: &Placement, u: f64, v: f64) -> Option<ExactPoint<Surd>> {
        self.local_point(u, v, Dyadic::clone).flatten().map(|point| placed(placement, point))
    }

    /// The world point (u, v) in pairs of floats; `None` where that point of the square is no surface, or that is not known.
    pub(crate) fn point_in_pairs(&self, placement: &Placement, u: f64, v: f64) -> Option<ExactPoint<Surd<Pair>>> {
        self.local_point_in_pairs(u, v).map(|point| placed(placement, point))
    }

    /// The same point in local coordinates.
    pub(crate) fn local_point_in_pairs(&self, u: f64, v: f64) -> Option<HomogeneousPoint<Pair>> {
        self.local_point(u, v, |number| Pair::from(number)).flatten()
    }

    /// Whether the point (u, v) of the square is surface. Exact.
    pub fn has_point(&self, u: f64, v: f64) -> bool {
        if !self.is_trimmed() {
            return true;
        }
        let filtered = match self.occupied([u, v], 0.0) {
            Occupied::Whole => Some(true),
            Occupied::Nowhere => Some(false),
            Occupied::Partly => None,
        };
        decide_by_pairs(
            filtered,
            || self.local_point(u, v, |number| Pair::from(number)).map(|point| point.is_some()),
            || self.local_point(u, v, Dyadic::clone).flatten().is_some(),
        )
    }

    /// The local point (u, v) over the numbers that `of` makes; `Some(None)` where that point of the square is no surface, `None` where
    /// that is not known.
    fn local_point<T>(&self, u: f64, v: f64, of: impl Fn(&Dyadic) -> T) -> Option<Option<HomogeneousPoint<T>>>
    where
        T: Decide + Default,
        Surd<T>: Decide,
    {
        let number = T::number;
        let point = match &self.kind {
            Kind::Radial { center, radii, origin, along } => {
                let d: [T; 3] = std::array::from_fn(|k| {
                    number(origin[k]) + number(u) * number(along[0][k]) + number(v) * number(along[1][k])
                });
                let weight = dot(&d, &d);
                let mut local: [Surd<T>; 3] =
                    std::array::from_fn(|k| Surd::root(number(radii[k]) * d[k].clone(), weight.clone()));
                local[1] = local[1].clone() + Surd::plain(number(*center) * weight.clone());
                (local, weight)
            }
            Kind::Turned { quarter, outline } => {
                let [x, z] = quarter_direction(*quarter, number(u), number);
                let weight = x.clone() * x.clone() + z.clone() * z.clone();
                let (factor, radius_squared, y) = outline.exact_at::<T>(v);
                let has_radius = radius_squared.decide()? == Sign::Positive;
                let root = |d: T| match has_radius {
                    true => Surd::root(d * factor.clone(), radius_squared.clone() * weight.clone()),
                    false => Surd::default(),
                };
                ([root(x), Surd::plain(y * weight.clone()), root(z)], weight)
            }
            Kind::Graph(graph) => return graph.local_point(u, v, of),
        };
        Some(Some(point))
    }

    /// The world point (u, v) by floats that bound it.
    pub fn bounded_point(&self, placement: &Placement, u: f64, v: f64) -> Point<'static> {
        let local = self.point(u, v);
        let (slack, vanishes) = (self.extent() * PADDING, self.vanishing(local, [u, v]));
        world(placement, local, DVec3::from_array([0, 1, 2].map(|k| if vanishes[k] { 0.0 } else { slack[k] })))
    }

    /// Which coordinates of the point (u, v), rounded to `local`, are exactly zero. Those that are a product are zero as a
    /// product, by a factor that is no more than −1 + 2u or a parameter, so not by rounding; but tiny parameters may
    /// underflow. Coordinates that are sums may cancel and do not count.
    fn vanishing(&self, local: DVec3, parameters: [f64; 2]) -> [bool; 3] {
        // Sizes are above 2^-201, and so are products of one with such a parameter far above the least float.
        const SAFE: f64 = 1.0 / (1u128 << 100) as f64;
        let is_safe = parameters.iter().all(|&t| t == 0.0 || t >= SAFE);
        let is_product = match &self.kind {
            Kind::Radial { center, .. } => [true, *center == 0.0, true],
            Kind::Turned { .. } => [true, false, true],
            Kind::Graph(_) => [false; 3],
        };
        [0, 1, 2].map(|axis| is_safe && is_product[axis] && local[axis] == 0.0)
    }

    /// Eight points whose hull holds a cell's surface.
    pub fn hull(&self, [u, v]: [f64; 2], edge: f64) -> CellHull {
        let slack = self.extent() * PADDING;
        let points = match &self.kind {
            Kind::Radial { center, radii, origin, along } => {
                let at = |s: f64, t: f64| direction(origin, along, u + s * edge, v + t * edge);
                let corners = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
                let middle = at(0.5, 0.5).normalize();
                // Directions are positive sums of the corners' unit vectors over a length of at most one.
                let deepest = corners.map(|d| middle.dot(d) / d.length()).into_iter().fold(1.0, f64::min);
                let reach = [deepest * (1.0 - PADDING), 1.0 + PADDING];
                std::array::from_fn(|k| {
                    let corner = corners[k % 4] * (reach[k / 4] / middle.dot(corners[k % 4]));
                    DVec3::new(0.0, *center, 0.0) + DVec3::from_array(*radii) * corner
                })
            }
            Kind::Turned { quarter, outline } => {
                let ends = [u, u + edge].map(|u| {
                    let [x, z] = quarter_direction(*quarter, u, |value| value);
                    let length = (x * x + z * z).sqrt();
                    [x / length, z / length]
                });
                // Between the two meridians the circle lies between its chord and the parallel tangent.
                let cosine = ends[0][0] * ends[1][0] + ends[0][1] * ends[1][1];
                let stretch = (2.0 / (1.0 + cosine)).sqrt() * (1.0 + PADDING);
                let outline = outline.hull(v, v + edge, stretch);
                std::array::from_fn(|k| {
                    let ([x, z], [radius, y]) = (ends[k % 2], outline[k / 2]);
                    DVec3::new(x * radius, y, z * radius)
                })
            }
            Kind::Graph(graph) => return graph.hull([u, v], edge),
        };
        CellHull { points, slack }
    }

    /// How much of a cell is surface.
    pub fn occupied(&self, at: [f64; 2], edge: f64) -> Occupied {
        match &self.kind {
            Kind::Graph(graph) => graph.occupied(at, edge),
            _ => Occupied::Whole,
        }
    }

    /// Whether it is a patch of a quadric in a box, the only ones that may hold surface in a part of their square.
    pub fn is_trimmed(&self) -> bool {
        matches!(self.kind, Kind::Graph(_))
    }

    /// Whether the patch is flat.
    pub fn is_flat(&self) -> bool {
        matches!(self.surface, Surface::Plane(_))
    }

    /// Greatest distance of its points from the local origin along each axis, at least.
    fn extent(&self) -> DVec3 {
        match &self.kind {
            Kind::Radial { center, radii, .. } => DVec3::from_array(*radii) + DVec3::Y * center.abs(),
            Kind::Turned { outline, .. } => {
                let (radius, height) = (outline.greatest_radius(), outline.greatest_height());
                DVec3::new(radius, height, radius)
            }
            Kind::Graph(graph) => DVec3::splat(graph.size()),
        }
    }

    /// Three points that span the plane of a flat patch, local coordinates; exact.
    pub fn plane_points(&self) -> Option<[DVec3; 3]> {
        match (&self.surface, &self.kind) {
            (Surface::Plane(_), Kind::Turned { outline, .. }) => {
                let ([_, y], size) = (outline.at(0.0), self.extent().max_element());
                Some([DVec3::new(0.0, y, 0.0), DVec3::new(size, y, 0.0), DVec3::new(0.0, y, size)])
            }
            (_, Kind::Graph(graph)) => graph.plane_points(),
            _ => None,
        }
    }

    /// How far a step of one along u, and one along v, goes at most in the world, metres. Two steps together go no farther
    /// than the root of the sum of their squares.
    pub fn steps(&self, placement: &Placement) -> [f64; 2] {
        let local = match &self.kind {
            // |d| ≥ 1: the way on the sphere is no longer than on the cube.
            Kind::Radial { radii, along, .. } => {
                let radius = radii.iter().fold(0.0, |a: f64, &b| a.max(b));
                along.map(|step| radius * DVec3::from_array(step).length())
            }
            Kind::Turned { outline, .. } => {
                let [radius, y] = outline.step();
                [2.0 * outline.greatest_radius(), radius.hypot(y)]
            }
            Kind::Graph(graph) => graph.steps(),
        };
        let stretch = greatest_stretch(placement);
        local.map(|length| length * stretch)
    }
}

/// A bound on how much a placement stretches any vector: by Gershgorin's circles on MᵀM, which is sharp for similarities.
/// The world's axes may change places without changing it.
fn greatest_stretch(placement: &Placement) -> f64 {
    let columns = [0, 1, 2].map(|k| placement.map().matrix3.col(k));
    let circle = |k: usize| columns.iter().map(|column| symmetric_sum(columns[k] * column).abs()).sum::<f64>();
    circle(0).max(circle(1)).max(circle(2)).sqrt()
}

/// A local point in the world, by floats, when its local coordinates may be off by `slack`. A coordinate to which nothing adds but the
/// translation has no slack.
pub(crate) fn world(placement: &Placement, local: DVec3, slack: DVec3) -> Point<'static> {
    let map = placement.map();
    let sizes = map.matrix3.abs();
    Point::beside(map.translation, map.matrix3 * local, sizes * local.abs() * PADDING + sizes * slack)
}

impl CellHull {
    /// The points in the world.
    pub fn placed(&self, placement: &Placement) -> [Point<'static>; HULL] {
        self.points.map(|local| world(placement, local, self.slack))
    }

    /// The points in the local coordinates of a body's forms: there neither its place nor how it is turned and sheared adds to the slack.
    pub fn local(&self, body: &PlacedAnalytic) -> [LocalPoint<Approx>; HULL] {
        let unit = Approx::exact(body.unit());
        self.points.map(|point| {
            let [x, y, z] = [0, 1, 2].map(|k| Approx { value: point[k], error: self.slack[k] });
            [x, y, z, unit]
        })
    }
}

fn direction(origin: &[f64; 3], along: &[[f64; 3]; 2], u: f64, v: f64) -> DVec3 {
    DVec3::from_array(*origin) + DVec3::from_array(along[0]) * u + DVec3::from_array(along[1]) * v
}

/// The image of a homogeneous local point.
fn placed<T: Decide>(placement: &Placement, (local, weight): HomogeneousPoint<T>) -> ExactPoint<Surd<T>>
where
    Surd<T>: Decide,
{
    let map = placement.map();
    let weight = Surd::plain(weight);
    let xyz = std::array::from_fn(|axis| {
        let row = map.matrix3.row(axis).to_array().map(Surd::number);
        dot(&row, &local) + Surd::number(map.translation[axis]) * weight.clone()
    });
    ExactPoint { xyz, w: weight }
}

/// The patches of a body in the order of its faces; see [`Analytic`].
pub(crate) fn charts(body: &Analytic) -> Vec<Chart> {
    let quadric = |kind| Chart { surface: Surface::Quadric(0), kind };
    let side = |outline| quarters(Surface::Quadric(0), outline);
    let end = |plane, outline| quarters(Surface::Plane(plane), outline);
    match *body {
        Analytic::Sphere { radius } => cube_faces([radius; 3], 0.0).map(quadric).collect(),
        Analytic::Ellipsoid { radii } => cube_faces(radii, 0.0).map(quadric).collect(),
        Analytic::Cylinder { radius, height } => frustum(radius, radius, height),
        Analytic::Cone { radius, height } => frustum(radius, 0.0, height),
        Analytic::Frustum { bottom_radius, top_radius, height } => frustum(bottom_radius, top_radius, height),
        Analytic::Capsule { radius, height } => {
            let half = 0.5 * height;
            let side = side(Outline::Line { from: [radius, -half], to: [radius, half] });
            half_sphere(radius, -half, 1).into_iter().chain(side).chain(half_sphere(radius, half, 2)).collect()
        }
        Analytic::Paraboloid { radius, height } => {
            let base = end(0, Outline::Line { from: [0.0, -0.5 * height], to: [radius, -0.5 * height] });
            base.into_iter().chain(side(Outline::Parabola { radius, height })).collect()
        }
        Analytic::Hyperboloid { waist_radius, end_radius, height } => {
            let half = 0.5 * height;
            let bottom = end(0, Outline::Line { from: [0.0, -half], to: [end_radius, -half] });
            let top = end(1, Outline::Line { from: [end_radius, half], to: [0.0, half] });
            let side = side(Outline::Hyperbola { waist: waist_radius, end: end_radius, height });
            bottom.into_iter().chain(side).chain(top).collect()
        }
        Analytic::Disk { radius } => end(0, Outline::Line { from: [radius, 0.0], to: [0.0, 0.0] }),
        Analytic::Quadric { matrix, within } => Graph::all(&symmetric_form(&matrix, 1.0), &within)
            .into_iter()
            .enumerate()
            .map(|(face, graph)| {
                let surface = if graph.is_side { Surface::Plane(face - 6) } else { Surface::Quadric(0) };
                Chart { surface, kind: Kind::Graph(Box::new(graph)) }
            })
            .collect(),
    }
}

fn quarters(surface: Surface, outline: Outline) -> Vec<Chart> {
    (0..4).map(|quarter| Chart { surface, kind: Kind::Turned { quarter, outline } }).collect()
}

fn frustum(bottom: f64, top: f64, height: f64) -> Vec<Chart> {
    let half = 0.5 * height;
    let line = |from, to| Outline::Line { from, to };
    let mut charts = quarters(Surface::Plane(0), line([0.0, -half], [bottom, -half]));
    charts.extend(quarters(Surface::Quadric(0), line([bottom, -half], [top, half])));
    if top > 0.0 {
        charts.extend(quarters(Surface::Plane(1), line([top, half], [0.0, half])));
    }
    charts
}

/// The faces −x, +x, −y, +y, −z, +z of the cube, projected from the centre. For +axis the parameters run along the next
/// two axes (cyclic); for −axis these change places, so that u × v points outward.
fn cube_faces(radii: [f64; 3], center: f64) -> impl Iterator<Item = Kind> {
    (0..6).map(move |face| {
        let (axis, positive) = (face / 2, face % 2 == 1);
        let mut origin = [-1.0; 3];
        origin[axis] = if positive { 1.0 } else { -1.0 };
        let mut along = [[0.0; 3]; 2];
        along[usize::from(!positive)][(axis + 1) % 3] = 2.0;
        along[usize::from(positive)][(axis + 2) % 3] = 2.0;
        Kind::Radial { center, radii, origin, along }
    })
}

/// The sides −x, +x, −z, +z of a half sphere and its pole; the upper half for quadric 2, the lower for 1.
fn half_sphere(radius: f64, center: f64, quadric: usize) -> Vec<Chart> {
    let is_upper = quadric == 2;
    let faces: Vec<Kind> = cube_faces([radius; 3], center).collect();
    let pole = if is_upper { 3 } else { 2 };
    let halved = [0, 1, 4, 5].into_iter().map(|face| halve(faces[face].clone(), is_upper));
    let kinds = halved.chain(std::iter::once(faces[pole].clone()));
    kinds.map(|kind| Chart { surface: Surface::Quadric(quadric), kind }).collect()
}

/// The half of a cube's side face with y ≥ 0, or y ≤ 0.
fn halve(kind: Kind, upper: bool) -> Kind {
    let Kind::Radial { center, radii, mut origin, mut along } = kind else { return kind };
    origin[1] = if upper { 0.0 } else { -1.0 };
    for step in &mut along {
        step[1] *= 0.5;
    }
    Kind::Radial { center, radii, origin, along }
}
