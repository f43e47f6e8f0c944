//! What the analytic bodies are, by their definitions: the pieces of their surfaces as forms with exact coefficients.
//!
//! All are centred at the local origin with axis +y. A side of revolution is x² + z² = ρ(y)², multiplied by what makes
//! its coefficients whole; a quadric is q ≤ 0 within a box, and closed by the parts of the box's faces with q ≤ 0.

use umbriel_geometry::Analytic;

use super::{
    curved::{Linear, Piece, Quadratic},
    number::Binary,
};

/// An analytic body; lengths as in a scene file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Solid {
    /// Half axes.
    Ellipsoid([f64; 3]),
    /// Radius, height.
    Cylinder(f64, f64),
    /// Radius at the bottom, radius at the top (zero for a cone), height.
    Frustum(f64, f64, f64),
    /// Radius, height between the centres of the half spheres.
    Capsule(f64, f64),
    /// Radius of the base, height.
    Paraboloid(f64, f64),
    /// Radius of the waist, radius of the ends, height.
    Hyperboloid(f64, f64, f64),
    /// Radius.
    Disk(f64),
    /// The matrix by rows, and the two corners of the box.
    Quadric([[f64; 4]; 4], [[f64; 3]; 2]),
}

impl Solid {
    /// The body of a scene.
    pub(crate) fn new(body: &Analytic) -> Self {
        match *body {
            Analytic::Sphere { radius } => Self::Ellipsoid([radius; 3]),
            Analytic::Ellipsoid { radii } => Self::Ellipsoid(radii),
            Analytic::Cylinder { radius, height } => Self::Cylinder(radius, height),
            Analytic::Cone { radius, height } => Self::Frustum(radius, 0.0, height),
            Analytic::Frustum { bottom_radius, top_radius, height } => Self::Frustum(bottom_radius, top_radius, height),
            Analytic::Capsule { radius, height } => Self::Capsule(radius, height),
            Analytic::Paraboloid { radius, height } => Self::Paraboloid(radius, height),
            Analytic::Hyperboloid { waist_radius, end_radius, height } => {
                Self::Hyperboloid(waist_radius, end_radius, height)
            }
            Analytic::Disk { radius } => Self::Disk(radius),
            Analytic::Quadric { matrix, within } => Self::Quadric(matrix, within),
        }
    }

    /// Whether the surface encloses something, so that it has an outside.
    pub(crate) fn is_closed(&self) -> bool {
        !matches!(self, Self::Disk(_))
    }

    /// Whether the body is convex whatever its numbers are.
    pub(crate) fn is_convex(&self) -> bool {
        !matches!(self, Self::Hyperboloid(..) | Self::Quadric(..))
    }

    /// Points that light should graze: poles, apexes, points of rims and waists, corners of boxes.
    pub(crate) fn features(&self) -> Vec<[f64; 3]> {
        let circle = |radius: f64, y: f64| [[radius, y, 0.0], [0.0, y, radius], [-radius, y, 0.0], [0.0, y, -radius]];
        let rims = |rims: &[(f64, f64)]| rims.iter().flat_map(|&(radius, y)| circle(radius, y)).collect::<Vec<_>>();
        match *self {
            Self::Ellipsoid([a, b, c]) => {
                let tips = [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]];
                tips.into_iter().flat_map(|tip| [tip, tip.map(|coordinate| -coordinate)]).collect()
            }
            Self::Cylinder(radius, height) => rims(&[(radius, -height / 2.0), (radius, height / 2.0)]),
            Self::Frustum(low, high, height) => rims(&[(low, -height / 2.0), (high, height / 2.0)]),
            Self::Capsule(radius, height) => {
                let (half, pole) = (height / 2.0, height / 2.0 + radius);
                rims(&[(radius, -half), (radius, half), (0.0, pole), (0.0, -pole)])
            }
            Self::Paraboloid(radius, height) => rims(&[(radius, -height / 2.0), (0.0, height / 2.0)]),
            Self::Hyperboloid(waist, end, height) => rims(&[(end, -height / 2.0), (waist, 0.0), (end, height / 2.0)]),
            Self::Disk(radius) => rims(&[(radius, 0.0), (0.0, 0.0)]),
            Self::Quadric(_, within) => {
                let corner = |k: usize| std::array::from_fn(|axis| within[k >> axis & 1][axis]);
                (0..8).map(corner).collect()
            }
        }
    }

    /// The middle and the radius of a ball that holds the body.
    pub(crate) fn ball(&self) -> ([f64; 3], f64) {
        let about_origin = |across: f64, along: f64| ([0.0; 3], 1.01 * across.hypot(along));
        match *self {
            Self::Ellipsoid([a, b, c]) => about_origin(a.max(b).max(c), 0.0),
            Self::Cylinder(radius, height) | Self::Paraboloid(radius, height) => about_origin(radius, height / 2.0),
            Self::Frustum(low, high, height) => about_origin(low.max(high), height / 2.0),
            Self::Capsule(radius, height) => about_origin(radius + height / 2.0, 0.0),
            Self::Hyperboloid(waist, end, height) => about_origin(end.max(waist), height / 2.0),
            Self::Disk(radius) => about_origin(radius, 0.0),
            Self::Quadric(_, [low, high]) => {
                let half: [f64; 3] = std::array::from_fn(|k| (high[k] - low[k]) / 2.0);
                let middle = std::array::from_fn(|k| low[k] + half[k]);
                (middle, 1.01 * half[0].hypot(half[1]).hypot(half[2]))
            }
        }
    }

    /// The pieces of the surface: bottom, side, top as far as they exist; of a capsule lower half sphere, side, upper half
    /// sphere; of a quadric the quadric, then the box's faces −x, +x, −y, +y, −z, +z.
    pub(crate) fn pieces(&self) -> Vec<Piece> {
        match *self {
            Self::Ellipsoid(radii) => vec![Piece::Curved { form: ellipsoid(radii), within: Vec::new() }],
            Self::Cylinder(radius, height) => {
                let form = round(radius, 0.0);
                vec![bottom(radius, height), side(form, height), top(radius, height)]
            }
            Self::Frustum(low, high, height) => {
                let mut pieces = vec![bottom(low, height), side(frustum(low, high, height), height)];
                if high > 0.0 {
                    pieces.push(top(high, height));
                }
                pieces
            }
            Self::Capsule(radius, height) => capsule(radius, height),
            Self::Paraboloid(radius, height) => {
                let above = vec![below_bottom(height).negated()];
                vec![bottom(radius, height), Piece::Curved { form: paraboloid(radius, height), within: above }]
            }
            Self::Hyperboloid(waist, end, height) => {
                vec![bottom(end, height), side(hyperboloid(waist, end, height), height), top(end, height)]
            }
            Self::Disk(radius) => {
                let plane = Linear::new([0.0, 1.0, 0.0, 0.0]);
                vec![Piece::Flat { plane, inside: round(radius, 0.0), within: Vec::new() }]
            }
            Self::Quadric(matrix, within) => quadric(&matrix, &within),
        }
    }
}

fn exact(value: f64) -> Binary {
    Binary::new(value)
}

fn square(value: &Binary) -> Binary {
    value * value
}

/// A form a·x² + b·y² + c·z² + 2m·y·w + d·w².
fn diagonal([a, b, c]: [Binary; 3], m: Binary, d: Binary) -> Quadratic {
    let zero = Binary::zero;
    Quadratic([
        [a, zero(), zero(), zero()],
        [zero(), b, zero(), m.clone()],
        [zero(), zero(), c, zero()],
        [zero(), m, zero(), d],
    ])
}

/// x² + z² + k·y² − r²: a cylinder or, for k = 1, a sphere.
fn round(radius: f64, k: f64) -> Quadratic {
    let one = || exact(1.0);
    diagonal([one(), exact(k), one()], Binary::zero(), -&square(&exact(radius)))
}

/// Σ x²/a², times a²b²c², minus a²b²c².
fn ellipsoid(radii: [f64; 3]) -> Quadratic {
    let squares = radii.map(|radius| square(&exact(radius)));
    let but = |i: usize| &squares[(i + 1) % 3] * &squares[(i + 2) % 3];
    let all = &but(0) * &squares[0];
    diagonal([but(0), but(1), but(2)], Binary::zero(), -&all)
}

/// h²(x² + z²) − (ρ·h)², where 2·ρ·h = (low + high)·h + 2·(high − low)·y; four times that.
fn frustum(low: f64, high: f64, height: f64) -> Quadratic {
    let (low, high, height) = (exact(low), exact(high), exact(height));
    let constant = &(&low + &high) * &height;
    let slope = &(&high - &low) * &exact(2.0);
    let level = &square(&height) * &exact(4.0);
    diagonal([level.clone(), -&square(&slope), level], -&(&constant * &slope), -&square(&constant))
}

/// h(x² + z²) − r²(h/2 − y), doubled.
fn paraboloid(radius: f64, height: f64) -> Quadratic {
    let (squared, height) = (square(&exact(radius)), exact(height));
    let level = &height * &exact(2.0);
    diagonal([level.clone(), Binary::zero(), level], squared.clone(), -&(&squared * &height))
}

/// h²(x² + z²) − h²·waist² − 4(end² − waist²)·y².
fn hyperboloid(waist: f64, end: f64, height: f64) -> Quadratic {
    let (waist, end, height) = (square(&exact(waist)), square(&exact(end)), square(&exact(height)));
    let slope = &(&waist - &end) * &exact(4.0);
    diagonal([height.clone(), slope, height.clone()], Binary::zero(), -&(&height * &waist))
}

/// −y − h/2: not negative at the bottom and below.
fn below_bottom(height: f64) -> Linear {
    Linear([Binary::zero(), exact(-1.0), Binary::zero(), &exact(-0.5) * &exact(height)])
}

/// y − h/2: not negative at the top and above.
fn above_top(height: f64) -> Linear {
    Linear([Binary::zero(), exact(1.0), Binary::zero(), &exact(-0.5) * &exact(height)])
}

/// The disk at −h/2, outward down.
fn bottom(radius: f64, height: f64) -> Piece {
    Piece::Flat { plane: below_bottom(height), inside: round(radius, 0.0), within: Vec::new() }
}

/// The disk at +h/2, outward up.
fn top(radius: f64, height: f64) -> Piece {
    Piece::Flat { plane: above_top(height), inside: round(radius, 0.0), within: Vec::new() }
}

/// The part of a quadric with |y| ≤ h/2.
fn side(form: Quadratic, height: f64) -> Piece {
    Piece::Curved { form, within: vec![below_bottom(height).negated(), above_top(height).negated()] }
}

fn capsule(radius: f64, height: f64) -> Vec<Piece> {
    // A sphere about (0, ±h/2, 0): x² + y² + z² ∓ h·y + h²/4 − r².
    let half = &exact(0.5) * &exact(height);
    let sphere = |middle: Binary| {
        let one = || exact(1.0);
        let constant = &square(&half) - &square(&exact(radius));
        diagonal([one(), one(), one()], -&middle, constant)
    };
    vec![
        Piece::Curved { form: sphere(-&half), within: vec![below_bottom(height)] },
        side(round(radius, 0.0), height),
        Piece::Curved { form: sphere(half.clone()), within: vec![above_top(height)] },
    ]
}

fn quadric(matrix: &[[f64; 4]; 4], within: &[[f64; 3]; 2]) -> Vec<Piece> {
    let entry = |i: usize, j: usize| &exact(matrix[i][j]) + &exact(matrix[j][i]);
    let form = Quadratic(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))));
    // Growing towards the outside of the box.
    let face = |axis: usize, upper: bool| {
        let mut coefficients = [0.0; 4];
        coefficients[axis] = if upper { 1.0 } else { -1.0 };
        coefficients[3] = if upper { -within[1][axis] } else { within[0][axis] };
        Linear::new(coefficients)
    };
    let all: Vec<Linear> = (0..6).map(|number| face(number / 2, number % 2 == 1)).collect();
    let inner = |besides: Option<usize>| {
        let kept = all.iter().enumerate().filter(|&(number, _)| besides != Some(number / 2));
        kept.map(|(_, plane)| plane.negated()).collect::<Vec<_>>()
    };
    let mut pieces = vec![Piece::Curved { form: form.clone(), within: inner(None) }];
    for (number, plane) in all.iter().enumerate() {
        pieces.push(Piece::Flat { plane: plane.clone(), inside: form.clone(), within: inner(Some(number / 2)) });
    }
    pieces
}
