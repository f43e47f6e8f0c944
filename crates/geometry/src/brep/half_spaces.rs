//! Convex bodies as intersections of half-spaces, by cutting a box with one plane after the other.
//!
//! The box is so large that all corners of all bounded bodies lie strictly inside it: by Cramer's rule a corner's
//! coordinate is a quotient of two determinants, at most 6·2^600 over at least 2^-756 for accepted numbers. A body that
//! reaches the box has no bounds. Every corner is the exact meeting point of three planes, given or of the box, so its
//! digits do not grow with the number of cuts, and every sign is exact.
//!
//! A body keeps f64 vertices. What is cut exactly is therefore rounded once, at the end, and the result is the hull of
//! the rounded corners: a body whose own signs are exact again, which a face of rounded corners alone would not be. So
//! corners are within half an ulp of the true ones in each coordinate, a face of more than three corners may come out as
//! several that bend by as much, and features below the rounding vanish.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{Brep, Cuboid, HullDefect};
use crate::{
    dyadic::Dyadic,
    number::{AXES, NumberDefect, accept, accept_point},
    point::ExactPoint,
    ring::{Ring, Sign, determinant, dot},
};

/// All points x with normal·x ≤ offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Points out of the body; any length but zero.
    pub normal: [f64; 3],
    /// The plane's distance from the origin, metres, times the length of the normal.
    pub offset: f64,
}

/// Why half-spaces have no body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HalfSpaceDefect {
    /// A number outside the accepted range.
    #[error("half-space {half_space}: number {index} {defect}")]
    Number {
        /// Which half-space.
        half_space: usize,
        /// 0, 1, 2 for the normal, 3 for the offset.
        index: usize,
        /// What is wrong with it.
        defect: NumberDefect,
    },
    /// A normal of length zero.
    #[error("half-space {half_space}: the normal has length zero")]
    NoDirection {
        /// Which half-space.
        half_space: usize,
    },
    /// The half-spaces up to this one share no point, or only points of a plane.
    #[error("half-space {half_space} leaves no interior to those before it")]
    Empty {
        /// Which half-space.
        half_space: usize,
    },
    /// The half-spaces share points as far out as one likes.
    #[error("unbounded towards {toward}")]
    Unbounded {
        /// An axis with its sign.
        toward: &'static str,
    },
    /// A corner outside the accepted range.
    #[error("the corner of half-spaces {}, {} and {}: coordinate {} {defect}", .half_spaces[0], .half_spaces[1], .half_spaces[2], AXES[*.axis])]
    Corner {
        /// Three half-spaces that meet there.
        half_spaces: [usize; 3],
        /// 0, 1 or 2.
        axis: usize,
        /// What is wrong with it.
        defect: NumberDefect,
    },
    /// The corners have no hull with interior once they are rounded.
    #[error("the body is too thin for its coordinates: {0}")]
    Thin(HullDefect),
}

impl Brep {
    /// The body that half-spaces have in common. Whether there is one, and whether it is bounded, is decided exactly;
    /// its corners are then correctly rounded, and the body is their [`Brep::hull`].
    ///
    /// A half-space that cuts nothing off changes nothing. Exact arithmetic throughout: O(half-spaces · corners)
    /// decisions of some microseconds.
    ///
    /// # Errors
    /// [`HalfSpaceDefect`].
    pub fn of_half_spaces(half_spaces: &[HalfSpace]) -> Result<Self, HalfSpaceDefect> {
        let mut cell = Cell::large_box();
        for (half_space, given) in half_spaces.iter().enumerate() {
            let plane = accepted_plane(half_space, given)?;
            if !cell.cut(plane) {
                return Err(HalfSpaceDefect::Empty { half_space });
            }
        }
        if let Some(&(plane, _)) = cell.faces.iter().find(|(plane, _)| *plane < BOX_SIDES.len()) {
            return Err(HalfSpaceDefect::Unbounded { toward: BOX_SIDES[plane] });
        }
        Self::hull(cell.rounded_corners()?).map_err(HalfSpaceDefect::Thin)
    }
}

/// The planes of the large box come before those given, in the order of [`Cuboid::FACES`].
const BOX_SIDES: [&str; 6] = ["-x", "+x", "-y", "+y", "-z", "+z"];

/// Normal and offset.
type Plane = ([Dyadic; 3], Dyadic);

fn accepted_plane(half_space: usize, given: &HalfSpace) -> Result<Plane, HalfSpaceDefect> {
    let place = |(index, defect)| HalfSpaceDefect::Number { half_space, index, defect };
    let normal = accept_point(given.normal).map_err(place)?;
    let offset = accept(given.offset).map_err(|defect| place((3, defect)))?;
    if normal == DVec3::ZERO {
        return Err(HalfSpaceDefect::NoDirection { half_space });
    }
    Ok((normal.to_array().map(Dyadic::new), Dyadic::new(offset)))
}

/// The meeting point of three planes whose normals span space, by Cramer's rule.
fn meeting_point(planes: [&Plane; 3]) -> ExactPoint {
    let normals = planes.map(|plane| plane.0.clone());
    let w = determinant(&normals);
    let xyz = std::array::from_fn(|axis| {
        let mut rows = normals.clone();
        for (row, plane) in rows.iter_mut().zip(planes) {
            row[axis] = plane.1.clone();
        }
        determinant(&rows)
    });
    if w.sign() == Sign::Negative { ExactPoint { xyz: xyz.map(|x: Dyadic| -x), w: -w } } else { ExactPoint { xyz, w } }
}

/// The part of the large box inside the half-spaces so far.
struct Cell {
    planes: Vec<Plane>,
    /// The corners, with three planes that meet there; not all are still in use.
    corners: Vec<(ExactPoint, [usize; 3])>,
    /// Each face's plane and loop, counter-clockwise from outside.
    faces: Vec<(usize, Vec<u32>)>,
}

impl Cell {
    fn large_box() -> Self {
        let far = Dyadic::new(2.0_f64.powi(700));
        let far = far.clone() * far;
        let planes = (0..BOX_SIDES.len()).map(|side| {
            let normal = std::array::from_fn(|axis| match (axis == side / 2, side % 2) {
                (false, _) => Dyadic::zero(),
                (true, 0) => Dyadic::new(-1.0),
                (true, _) => Dyadic::new(1.0),
            });
            (normal, far.clone())
        });
        let mut cell = Self { planes: planes.collect(), corners: Vec::new(), faces: Vec::new() };
        for corner in 0..8 {
            cell.add_corner([0, 1, 2].map(|axis| 2 * axis + (corner >> axis & 1)));
        }
        cell.faces = Cuboid::FACES.iter().map(|face| face.to_vec()).enumerate().collect();
        cell
    }

    fn add_corner(&mut self, planes: [usize; 3]) -> u32 {
        self.corners.push((meeting_point(planes.map(|plane| &self.planes[plane])), planes));
        self.corners.len() as u32 - 1
    }

    /// Keeps what lies behind a plane. False where that has no interior; the cell is then of no more use.
    fn cut(&mut self, plane: Plane) -> bool {
        let side_of = self.sides(&plane);
        let is_on_side =
            |side| self.faces.iter().any(|(_, corners)| corners.iter().any(|corner| side_of[corner] == side));
        if !is_on_side(Sign::Negative) {
            return false;
        }
        // Kept even if it cuts nothing off, so that planes are numbered as given.
        self.planes.push(plane);
        if is_on_side(Sign::Positive) {
            self.cut_faces(side_of);
        }
        true
    }

    /// The side of the plane on which each corner in use lies; positive is to be cut off.
    fn sides(&self, (normal, offset): &Plane) -> BTreeMap<u32, Sign> {
        let mut sides = BTreeMap::new();
        for &corner in self.faces.iter().flat_map(|(_, corners)| corners) {
            sides.entry(corner).or_insert_with(|| {
                let point = &self.corners[corner as usize].0;
                (dot(normal, &point.xyz) - offset.clone() * point.w.clone()).sign()
            });
        }
        sides
    }

    /// Cuts every face by the last plane, on whose two sides there are corners, and closes the cut with a new face.
    fn cut_faces(&mut self, mut side_of: BTreeMap<u32, Sign>) {
        let faces = std::mem::take(&mut self.faces);
        let plane_left_of: BTreeMap<(u32, u32), usize> =
            faces.iter().flat_map(|(plane, corners)| edges(corners).map(|edge| (edge, *plane))).collect();
        let mut crossings = BTreeMap::new();
        // The new face runs against the edges of the others: from the end of each such edge to its start.
        let mut cap = BTreeMap::new();
        for (plane, corners) in faces {
            let mut kept = Vec::new();
            for (from, to) in edges(&corners) {
                if side_of[&from] != Sign::Positive {
                    kept.push(from);
                }
                if side_of[&from].times(side_of[&to]) == Sign::Negative {
                    let crossing = *crossings
                        .entry((from.min(to), from.max(to)))
                        .or_insert_with(|| self.add_corner([plane, plane_left_of[&(to, from)], self.planes.len() - 1]));
                    side_of.insert(crossing, Sign::Zero);
                    kept.push(crossing);
                }
            }
            if kept.len() >= 3 {
                let is_on_cut = |edge: &(u32, u32)| side_of[&edge.0] == Sign::Zero && side_of[&edge.1] == Sign::Zero;
                cap.extend(edges(&kept).filter(is_on_cut).map(|(from, to)| (to, from)));
                self.faces.push((plane, kept));
            }
        }
        self.faces.push((self.planes.len() - 1, cycle(&cap)));
    }

    /// The corners in use, correctly rounded.
    fn rounded_corners(&self) -> Result<Vec<DVec3>, HalfSpaceDefect> {
        let used = self.faces.iter().flat_map(|(_, corners)| corners);
        let rounded = used.map(|&corner| {
            let (point, planes) = &self.corners[corner as usize];
            accept_point(std::array::from_fn(|axis| nearest_quotient(&point.xyz[axis], &point.w))).map_err(
                |(axis, defect)| {
                    let half_spaces = planes.map(|plane| plane - BOX_SIDES.len());
                    HalfSpaceDefect::Corner { half_spaces, axis, defect }
                },
            )
        });
        rounded.collect()
    }
}

/// The edges of a loop.
fn edges(corners: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// The loop that steps from each key to its value.
fn cycle(next: &BTreeMap<u32, u32>) -> Vec<u32> {
    let first = next.keys().next().copied();
    let step = |corner: &u32| next.get(corner).copied().filter(|&corner| Some(corner) != first);
    std::iter::successors(first, step).collect()
}

/// The float nearest to a quotient, ties to even; the divisor is positive.
fn nearest_quotient(dividend: &Dyadic, divisor: &Dyadic) -> f64 {
    // A few ulps off at most; then step by step, by the exact side of the midpoints between neighbours.
    let mut quotient = dividend.to_approx().value / divisor.to_approx().value;
    let beyond_midpoint = |a: f64, b: f64| {
        let midpoint = Dyadic::new(a) + Dyadic::new(b);
        (dividend.clone() + dividend.clone() - midpoint * divisor.clone()).sign()
    };
    let is_odd = |value: f64| value.to_bits() & 1 == 1;
    while quotient.is_finite() {
        let (up, down) = (quotient.next_up(), quotient.next_down());
        let (over, under) = (beyond_midpoint(quotient, up), beyond_midpoint(down, quotient));
        if over == Sign::Positive || (over == Sign::Zero && is_odd(quotient)) {
            quotient = up;
        } else if under == Sign::Negative || (under == Sign::Zero && is_odd(quotient)) {
            quotient = down;
        } else {
            break;
        }
    }
    quotient
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_are_rounded_to_nearest() {
        for (dividend, divisor) in [(1.0, 3.0), (-2.0, 7.0), (0.0, 5.0), (1e150, 1e-150), (6.0, 2.0), (-1.0, 49.0)] {
            // The processor's quotient of two floats is correctly rounded too.
            let rounded = nearest_quotient(&Dyadic::new(dividend), &Dyadic::new(divisor));
            assert_eq!(rounded, dividend / divisor, "{dividend}/{divisor}");
        }
        let tie = Dyadic::new(1.0) + Dyadic::new(f64::EPSILON / 2.0);
        assert_eq!(nearest_quotient(&tie, &Dyadic::new(1.0)), 1.0);
        let tie = Dyadic::new(1.0) + Dyadic::new(1.5 * f64::EPSILON);
        assert_eq!(nearest_quotient(&tie, &Dyadic::new(1.0)), 1.0 + 2.0 * f64::EPSILON);
    }

    /// The prism z in 0..=1 over a triangle of the lines x = 0, y = 0 and slope·x + y = 1.
    fn wedge(slope: f64, last: HalfSpace) -> Result<Brep, HalfSpaceDefect> {
        let space = |normal: [f64; 3], offset: f64| HalfSpace { normal, offset };
        let sides = [space([-1.0, 0.0, 0.0], 0.0), space([0.0, -1.0, 0.0], 0.0), space([slope, 1.0, 0.0], 1.0)];
        Brep::of_half_spaces(&[&sides[..], &[space([0.0, 0.0, -1.0], 0.0), last]].concat())
    }

    #[test]
    fn the_least_slope_bounds_a_body_and_the_least_distance_leaves_an_interior() {
        let lid = |offset: f64| HalfSpace { normal: [0.0, 0.0, 1.0], offset };
        let least = 0.5f64.powi(100);
        assert!(wedge(least, lid(1.0)).is_ok());
        for slope in [0.0, -least] {
            assert_eq!(wedge(slope, lid(1.0)).unwrap_err(), HalfSpaceDefect::Unbounded { toward: "+x" });
        }
        assert!(wedge(1.0, lid(least)).is_ok());
        for offset in [0.0, -least] {
            assert_eq!(wedge(1.0, lid(offset)).unwrap_err(), HalfSpaceDefect::Empty { half_space: 4 });
        }
    }
}
