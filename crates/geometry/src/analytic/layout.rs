//! What each body is made of: its forms, the parts of its surface, and the solid pieces whose union it is.

use super::{Analytic, forms::QuadricForm};
use crate::{
    dyadic::Dyadic,
    number::power_of_two_below,
    ring::{Ring, Sign},
};

/// Where a part of a surface lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// On a quadric; outward is where its form is positive.
    Quadric(usize),
    /// On a plane; outward is where its form is negative.
    Plane(usize),
}

/// What cuts a part of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trim {
    /// Where a quadric's form is ≤ 0.
    Inside(usize),
    /// Where a plane's form is ≥ 0.
    Above(usize),
    /// Where a plane's form is ≤ 0.
    Below(usize),
}

/// A closed part of the surface.
#[derive(Clone, Debug)]
pub struct Part {
    /// The surface it is cut from.
    pub surface: Surface,
    /// What it is cut by: all must hold.
    pub trims: Vec<Trim>,
}

/// One of the closed sets whose union is the body: all points where a quadric's form is ≤ 0 and some planes' are ≥ 0.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The quadric.
    pub quadric: usize,
    /// The planes.
    pub planes: Vec<usize>,
    /// For a disk, the plane that it lies in.
    pub flat: Option<usize>,
    /// Whether it is convex.
    pub is_convex: bool,
}

/// Forms in units of `unit`, parts and pieces.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// The body's size, a power of two, metres.
    pub(crate) unit: f64,
    pub(crate) quadrics: Vec<QuadricForm<Dyadic>>,
    pub(crate) planes: Vec<[Dyadic; 4]>,
    pub(crate) parts: Vec<Part>,
    pub(crate) pieces: Vec<Piece>,
}

const BOTTOM: usize = 0;
const TOP: usize = 1;

impl Layout {
    pub(crate) fn of(body: &Analytic) -> Self {
        let extent = body.half_extent().into_iter().fold(0.0, f64::max);
        let unit = power_of_two_below(extent);
        // Exact: a power of two, far from the ends of the range.
        let s = |size: f64| Dyadic::new(size / unit);
        let mut layout = match *body {
            Analytic::Sphere { radius } => Self::sphere(&s(radius)),
            Analytic::Ellipsoid { radii } => Self::ellipsoid(radii.map(s)),
            Analytic::Cylinder { radius, height } => Self::cylinder(&s(radius), &s(height)),
            Analytic::Cone { radius, height } => Self::frustum(s(radius), Dyadic::zero(), s(height), false),
            Analytic::Frustum { bottom_radius, top_radius, height } => {
                Self::frustum(s(bottom_radius), s(top_radius), s(height), true)
            }
            Analytic::Capsule { radius, height } => Self::capsule(s(radius), s(height)),
            Analytic::Paraboloid { radius, height } => Self::paraboloid(s(radius), s(height)),
            Analytic::Hyperboloid { waist_radius, end_radius, height } => {
                Self::hyperboloid(s(waist_radius), s(end_radius), s(height), body.is_convex())
            }
            Analytic::Disk { radius } => Self::disk(s(radius)),
            Analytic::Quadric { matrix, within } => Self::quadric(&matrix, within.map(|corner| corner.map(s)), unit),
        };
        layout.unit = unit;
        layout
    }

    fn new(quadrics: Vec<QuadricForm<Dyadic>>, planes: Vec<[Dyadic; 4]>) -> Self {
        Self { unit: 1.0, quadrics, planes, parts: Vec::new(), pieces: Vec::new() }
    }

    fn with_part(mut self, surface: Surface, trims: &[Trim]) -> Self {
        self.parts.push(Part { surface, trims: trims.to_vec() });
        self
    }

    fn with_piece(mut self, quadric: usize, planes: &[usize], is_convex: bool) -> Self {
        self.pieces.push(Piece { quadric, planes: planes.to_vec(), flat: None, is_convex });
        self
    }

    /// x² + y² + z² ≤ radius²·w².
    fn sphere(radius: &Dyadic) -> Self {
        let one = || Dyadic::new(1.0);
        let form = QuadricForm::new([one(), one(), one(), -squared(radius)], Vec::new());
        Self::new(vec![form], Vec::new()).with_part(Surface::Quadric(0), &[]).with_piece(0, &[], true)
    }

    /// x² + z² ≤ radius²·w² between the ends.
    fn cylinder(radius: &Dyadic, height: &Dyadic) -> Self {
        let one = || Dyadic::new(1.0);
        let form = QuadricForm::new([one(), Dyadic::zero(), one(), -squared(radius)], Vec::new());
        let half = half(height);
        Self::new(vec![form], vec![above(half.clone()), below(half)]).with_ends(true, true)
    }

    /// b²c²·x² + c²a²·y² + a²b²·z² ≤ a²b²c²·w².
    fn ellipsoid([a, b, c]: [Dyadic; 3]) -> Self {
        let [a, b, c] = [a, b, c].map(|radius| squared(&radius));
        let (bc, ca, ab) = (b.clone() * c.clone(), c * a.clone(), a.clone() * b);
        let constant = -(a * bc.clone());
        Self::new(vec![QuadricForm::new([bc, ca, ab, constant], Vec::new())], Vec::new())
            .with_part(Surface::Quadric(0), &[])
            .with_piece(0, &[], true)
    }

    /// height²·(x² + z²) ≤ ((top − bottom)·y + (top + bottom)·height/2·w)² between the ends; the radius is linear in y.
    fn frustum(bottom: Dyadic, top: Dyadic, height: Dyadic, has_top: bool) -> Self {
        let half = half(&height);
        let (slope, middle) = (top.clone() - bottom.clone(), (top + bottom) * half.clone());
        let across = squared(&height);
        let squares = [across.clone(), -squared(&slope), across, -squared(&middle)];
        let form = QuadricForm::new(squares, vec![(1, 3, -(slope * middle))]);
        Self::new(vec![form], vec![above(half.clone()), below(half)]).with_ends(has_top, true)
    }

    /// height·(x² + z²) ≤ radius²·(height/2·w − y)·w.
    fn paraboloid(radius: Dyadic, height: Dyadic) -> Self {
        let radius_squared = squared(&radius);
        let constant = -(radius_squared.clone() * half(&height));
        let squares = [height.clone(), Dyadic::zero(), height.clone(), constant];
        let form = QuadricForm::new(squares, vec![(1, 3, half(&radius_squared))]);
        let bottom = above(half(&height));
        Self::new(vec![form], vec![bottom])
            .with_part(Surface::Quadric(0), &[Trim::Above(BOTTOM)])
            .with_part(Surface::Plane(BOTTOM), &[Trim::Inside(0)])
            .with_piece(0, &[BOTTOM], true)
    }

    /// height²·(x² + z²) ≤ waist²·height²·w² + 4·(end² − waist²)·y².
    fn hyperboloid(waist: Dyadic, end: Dyadic, height: Dyadic, is_convex: bool) -> Self {
        let across = squared(&height);
        let (waist, end) = (squared(&waist), squared(&end));
        let along = -(Dyadic::new(4.0) * (end - waist.clone()));
        let squares = [across.clone(), along, across.clone(), -(waist * across)];
        let half = half(&height);
        Self::new(vec![QuadricForm::new(squares, Vec::new())], vec![above(half.clone()), below(half)])
            .with_ends(true, is_convex)
    }

    /// A side between two ends that are flat (or a point).
    fn with_ends(self, has_top: bool, is_convex: bool) -> Self {
        let body = self
            .with_part(Surface::Quadric(0), &[Trim::Above(BOTTOM), Trim::Above(TOP)])
            .with_part(Surface::Plane(BOTTOM), &[Trim::Inside(0)])
            .with_piece(0, &[BOTTOM, TOP], is_convex);
        if has_top { body.with_part(Surface::Plane(TOP), &[Trim::Inside(0)]) } else { body }
    }

    /// A cylinder and two whole spheres; of each sphere, the half beyond the cylinder's end is surface.
    fn capsule(radius: Dyadic, height: Dyadic) -> Self {
        let (half, one) = (half(&height), || Dyadic::new(1.0));
        let outer = -squared(&radius);
        let side = QuadricForm::new([one(), Dyadic::zero(), one(), outer.clone()], Vec::new());
        let sphere = |center: Dyadic| {
            let constant = squared(&center) + outer.clone();
            QuadricForm::new([one(), one(), one(), constant], vec![(1, 3, -center)])
        };
        let quadrics = vec![side, sphere(-half.clone()), sphere(half.clone())];
        Self::new(quadrics, vec![above(half.clone()), below(half)])
            .with_part(Surface::Quadric(0), &[Trim::Above(BOTTOM), Trim::Above(TOP)])
            .with_part(Surface::Quadric(1), &[Trim::Below(BOTTOM)])
            .with_part(Surface::Quadric(2), &[Trim::Below(TOP)])
            .with_piece(0, &[BOTTOM, TOP], true)
            .with_piece(1, &[], true)
            .with_piece(2, &[], true)
    }

    fn disk(radius: Dyadic) -> Self {
        let one = || Dyadic::new(1.0);
        let rim = QuadricForm::new([one(), Dyadic::zero(), one(), -squared(&radius)], Vec::new());
        // The front is +y, so the "inside" of its plane is −y.
        let plane = [Dyadic::zero(), -one(), Dyadic::zero(), Dyadic::zero()];
        let mut body = Self::new(vec![rim], vec![plane]).with_part(Surface::Plane(0), &[Trim::Inside(0)]);
        body.pieces.push(Piece { quadric: 0, planes: Vec::new(), flat: Some(0), is_convex: true });
        body
    }

    fn quadric(matrix: &[[f64; 4]; 4], within: [[Dyadic; 3]; 2], unit: f64) -> Self {
        let planes = (0..6).map(|side| {
            let axis = side / 2;
            let upper = side % 2 == 1;
            let mut plane = [Dyadic::zero(), Dyadic::zero(), Dyadic::zero(), Dyadic::zero()];
            plane[axis] = Dyadic::new(if upper { -1.0 } else { 1.0 });
            let bound = within[usize::from(upper)][axis].clone();
            plane[3] = if upper { bound } else { -bound };
            plane
        });
        let all: Vec<usize> = (0..6).collect();
        let above: Vec<Trim> = all.iter().map(|&plane| Trim::Above(plane)).collect();
        let form = symmetric_form(matrix, unit).normalised();
        let planes: Vec<[Dyadic; 4]> = planes.collect();
        // A side all of which is in the surface is a part of that.
        let sides: Vec<usize> = all.iter().copied().filter(|&side| form.cofactor(&planes[side]).is_none()).collect();
        let body = Self::new(vec![form], planes).with_part(Surface::Quadric(0), &above).with_piece(0, &all, false);
        sides.iter().fold(body, |body, &side| {
            let others = all.iter().filter(|&&plane| plane / 2 != side / 2).map(|&plane| Trim::Above(plane));
            let trims: Vec<Trim> = std::iter::once(Trim::Inside(0)).chain(others).collect();
            body.with_part(Surface::Plane(side), &trims)
        })
    }
}

/// The form of a matrix's symmetric part, doubled, over lengths in a unit.
pub(crate) fn symmetric_form(matrix: &[[f64; 4]; 4], unit: f64) -> QuadricForm<Dyadic> {
    let scale = |k: usize| Dyadic::new(if k < 3 { unit } else { 1.0 });
    let entry = |i: usize, j: usize| (Dyadic::new(matrix[i][j]) + Dyadic::new(matrix[j][i])) * scale(i) * scale(j);
    let pairs = [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)];
    let mixed = pairs.into_iter().map(|(i, j)| (i, j, entry(i, j)));
    let mixed = mixed.filter(|(_, _, factor)| factor.sign() != Sign::Zero);
    QuadricForm::new(std::array::from_fn(|k| entry(k, k)), mixed.collect())
}

impl QuadricForm<Dyadic> {
    /// The form times the power of two that brings its largest factor near one.
    fn normalised(self) -> Self {
        let largest = self.factors().filter_map(Dyadic::magnitude).max().unwrap_or(0);
        let inverse = Dyadic::power_of_two(-largest);
        self.map(|factor| factor.clone() * inverse.clone())
    }
}

fn squared(value: &Dyadic) -> Dyadic {
    value.clone() * value.clone()
}

fn half(value: &Dyadic) -> Dyadic {
    value.clone() * Dyadic::new(0.5)
}

/// y ≥ −half.
fn above(half: Dyadic) -> [Dyadic; 4] {
    [Dyadic::zero(), Dyadic::new(1.0), Dyadic::zero(), half]
}

/// y ≤ half.
fn below(half: Dyadic) -> [Dyadic; 4] {
    [Dyadic::zero(), Dyadic::new(-1.0), Dyadic::zero(), half]
}
