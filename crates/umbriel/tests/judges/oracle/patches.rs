//! Points of curved faces: what (u, v) of a face means, exactly.
//!
//! A face is a patch of a piece. Cube patches: the direction d on the cube −1..1 (of a capsule's half spheres, on its upper
//! or lower half) goes to middle + radii·d/|d|. Turned patches: a quarter turn of an outline (radius, y) about the axis, around
//! +x, −z, −x, +z; the direction there is (axis of the quarter) + (2u − 1)·(axis of the next), v runs along the outline.
//! Either way a point is (p + q·√n)/w with n and w from the direction's squared length.

use super::{
    blocking::Place,
    number::{Binary, Vector, dot, times, vector},
    sheets,
    solids::Solid,
};

/// Coordinates of an outline's point: radius = factor·√square, and the level y.
struct OnOutline {
    factor: Binary,
    square: Binary,
    y: Binary,
}

impl Solid {
    /// How many faces there are.
    pub(crate) fn face_count(&self) -> usize {
        match self {
            Self::Ellipsoid(_) => 6,
            Self::Cylinder(..) | Self::Hyperboloid(..) => 12,
            Self::Frustum(_, high, _) => {
                if *high > 0.0 {
                    12
                } else {
                    8
                }
            }
            Self::Capsule(..) => 14,
            Self::Paraboloid(..) => 8,
            Self::Disk(_) => 4,
            Self::Quadric(..) => 12,
        }
    }

    /// The piece that a face is a patch of, and the local point (u, v); `None` where that is no point of the surface.
    pub(crate) fn point(&self, face: usize, [u, v]: [f64; 2]) -> Option<(usize, Place)> {
        let half = |height: f64| &exact(0.5) * &exact(height);
        let zero = Binary::zero;
        Some(match *self {
            Self::Ellipsoid(radii) => (0, radial(cube(face, u, v), radii, &zero())),
            Self::Capsule(radius, height) => match face {
                0..5 => (0, radial(half_cube(face, u, v, false), [radius; 3], &-&half(height))),
                5..9 => (1, turned(face - 5, u, &line([radius, -0.5], [radius, 0.5], height, v))),
                _ => (2, radial(half_cube(face - 9, u, v, true), [radius; 3], &half(height))),
            },
            Self::Disk(radius) => (0, turned(face, u, &line([radius, 0.0], [0.0, 0.0], 1.0, v))),
            Self::Quadric(ref matrix, ref within) => return sheets::point(matrix, within, face, [u, v]),
            _ => (face / 4, turned(face % 4, u, &self.outline(face / 4, v))),
        })
    }

    /// The point v of a piece's outline, for bodies of bottom, side and top.
    fn outline(&self, piece: usize, v: f64) -> OnOutline {
        let (low, high, height) = match *self {
            Self::Cylinder(radius, height) => (radius, radius, height),
            Self::Frustum(low, high, height) => (low, high, height),
            Self::Hyperboloid(_, end, height) => (end, end, height),
            Self::Paraboloid(radius, height) => (radius, 0.0, height),
            _ => unreachable!("no outline of three pieces"),
        };
        match (piece, self) {
            (0, _) => line([0.0, -0.5], [low, -0.5], height, v),
            (2, _) => line([high, 0.5], [0.0, 0.5], height, v),
            (_, Self::Hyperboloid(waist, end, _)) => {
                // Along the axis at even pace.
                let s = &(&exact(2.0) * &exact(v)) - &exact(1.0);
                let square = |value: f64| &exact(value) * &exact(value);
                let growth = &square(*end) - &square(*waist);
                let squared = &square(*waist) + &(&growth * &(&s * &s));
                OnOutline { factor: exact(1.0), square: squared, y: &(&exact(0.5) * &exact(height)) * &s }
            }
            (_, Self::Paraboloid(radius, _)) => {
                // The radius shrinks at even pace.
                let inward = &exact(1.0) - &exact(v);
                let share = &exact(0.5) - &(&inward * &inward);
                OnOutline { factor: &exact(*radius) * &inward, square: exact(1.0), y: &exact(height) * &share }
            }
            _ => line([low, -0.5], [high, 0.5], height, v),
        }
    }
}

fn exact(value: f64) -> Binary {
    Binary::new(value)
}

/// Between two corners (radius, share of the height), at even pace.
fn line(from: [f64; 2], to: [f64; 2], height: f64, v: f64) -> OnOutline {
    let at = |k: usize| &exact(from[k]) + &(&exact(v) * &(&exact(to[k]) - &exact(from[k])));
    OnOutline { factor: at(0), square: exact(1.0), y: &exact(height) * &at(1) }
}

fn turned(quarter: usize, u: f64, outline: &OnOutline) -> Place {
    let axes = [[1.0, 0.0], [0.0, -1.0], [-1.0, 0.0], [0.0, 1.0]];
    let across = &(&exact(2.0) * &exact(u)) - &exact(1.0);
    let [x, z] = [0, 1].map(|k| &exact(axes[quarter][k]) + &(&across * &exact(axes[(quarter + 1) % 4][k])));
    let weight = &(&x * &x) + &(&z * &z);
    Place {
        rational: [Binary::zero(), &outline.y * &weight, Binary::zero()],
        irrational: [&x * &outline.factor, Binary::zero(), &z * &outline.factor],
        radicand: &outline.square * &weight,
        weight,
    }
}

fn radial(direction: Vector, radii: [f64; 3], middle: &Binary) -> Place {
    let weight = dot(&direction, &direction);
    let irrational = std::array::from_fn(|k| &exact(radii[k]) * &direction[k]);
    let rational = times(&weight, &[Binary::zero(), middle.clone(), Binary::zero()]);
    Place { rational, irrational, radicand: weight.clone(), weight }
}

/// The faces −x, +x, −y, +y, −z, +z: parameters along the next two axes; for − they change places, so that u × v points
/// outward.
pub(crate) fn cube(face: usize, u: f64, v: f64) -> Vector {
    let (axis, positive) = (face / 2, face % 2 == 1);
    let (first, second) = if positive { (u, v) } else { (v, u) };
    let centred = |t: f64| &(&exact(2.0) * &exact(t)) - &exact(1.0);
    let mut direction = vector([if positive { 1.0 } else { -1.0 }; 3]);
    direction[(axis + 1) % 3] = centred(first);
    direction[(axis + 2) % 3] = centred(second);
    direction
}

/// The sides −x, +x, −z, +z with the upper or the lower half of their heights, then the pole.
fn half_cube(face: usize, u: f64, v: f64, is_upper: bool) -> Vector {
    let Some(&of_cube) = [0, 1, 4, 5].get(face) else {
        return cube(if is_upper { 3 } else { 2 }, u, v);
    };
    let mut direction = cube(of_cube, u, v);
    let raised = if is_upper { exact(1.0) } else { exact(-1.0) };
    direction[1] = &exact(0.5) * &(&direction[1] + &raised);
    direction
}
