//! Does a closed convex planar polygon meet a closed box? By separating axes.
//!
//! Two convex polytopes are disjoint exactly when one of these directions separates them strictly: a normal of the box,
//! the normal of the polygon, a cross product of an edge of each (Gottschalk, Lin & Manocha, "OBBTree", SIGGRAPH 1996;
//! Akenine-Möller, "Fast 3D Triangle-Box Overlap Testing", Journal of Graphics Tools 6(1), 2001, for the box). The
//! list stays complete for polygons without area, since the box has an extent on every axis.
//!
//! Every direction is tried over numbers that know their error first and over exact dyadics where that leaves a doubt.
//! Lengths are doubled, so that the middle of the box needs no halving. Degree 3 in coordinates. O(corners), 13 axes for
//! a triangle at most; directions that are a box normal in disguise are left out.

use std::cmp::Ordering;

use crate::{
    aabb::Aabb,
    approx::Approx,
    decide::Decide,
    decisions::decide,
    dyadic::Dyadic,
    point::Point,
    ring::{Ring, Sign},
};

/// Numbers with magnitudes.
trait Scalar: Decide {
    fn magnitude(self) -> Self;
}

impl Scalar for Approx {
    fn magnitude(self) -> Self {
        Self { value: self.value.abs(), error: self.error }
    }
}

impl Scalar for Dyadic {
    fn magnitude(self) -> Self {
        if self.sign() == Sign::Negative { -self } else { self }
    }
}

/// Whether the closed polygon with these corners meets the closed box: exact.
pub(super) fn meets<const N: usize>(corners: &[Point; N], cell: &Aabb) -> bool {
    if (0..3).any(|axis| is_beyond(corners, cell, axis)) {
        return false;
    }
    if corners.iter().any(|corner| is_exact(corner) && cell.contains(corner.position)) {
        return true;
    }
    let coordinates = corners.map(|corner| corner.coordinates());
    let separated = decide(Seen::new(&coordinates, cell).is_separated(corners), || {
        // The corners of facets have weight 1.
        let coordinates = corners.map(|corner| corner.to_exact::<Dyadic>().xyz);
        Seen::new(&coordinates, cell).is_separated(corners).unwrap_or(false)
    });
    !separated
}

/// Whether the polygon lies strictly beyond one of the two sides of the box on this axis.
fn is_beyond(corners: &[Point], cell: &Aabb, axis: usize) -> bool {
    corners.iter().all(|corner| compare(corner, axis, cell.max[axis]).is_gt())
        || corners.iter().all(|corner| compare(corner, axis, cell.min[axis]).is_lt())
}

/// Where a point's coordinate lies, seen from `value`: exact.
fn compare(point: &Point, axis: usize, value: f64) -> Ordering {
    let (position, slack) = (point.position[axis], point.slack[axis]);
    // A slack of zero is an exact coordinate; otherwise the coordinate is strictly within two slacks.
    let near = if slack == 0.0 { 0.0 } else { slack * 2.0 };
    let distance = position - value;
    if slack == 0.0 || distance.abs() > near {
        return if distance > 0.0 {
            Ordering::Greater
        } else if distance < 0.0 {
            Ordering::Less
        } else {
            Ordering::Equal
        };
    }
    let order = || {
        let exact = point.to_exact::<Dyadic>();
        match (exact.xyz[axis].clone() - Dyadic::new(value) * exact.w).sign() {
            Sign::Negative => Ordering::Less,
            Sign::Zero => Ordering::Equal,
            Sign::Positive => Ordering::Greater,
        }
    };
    decide(None, order)
}

fn is_exact(point: &Point) -> bool {
    point.exact.is_none()
}

/// A polygon seen from the middle of a box, all lengths doubled.
struct Seen<T, const N: usize> {
    corners: [[T; 3]; N],
    /// Half the box, doubled: its edges.
    reach: [T; 3],
}

impl<T: Scalar, const N: usize> Seen<T, N> {
    fn new(corners: &[[T; 3]; N], cell: &Aabb) -> Self {
        let (min, max) = (cell.min.to_array().map(T::number), cell.max.to_array().map(T::number));
        let seen = |corner: &[T; 3]| {
            std::array::from_fn(|axis| {
                (corner[axis].clone() - min[axis].clone()) + (corner[axis].clone() - max[axis].clone())
            })
        };
        Self {
            corners: std::array::from_fn(|index| seen(&corners[index])),
            reach: std::array::from_fn(|axis| max[axis].clone() - min[axis].clone()),
        }
    }

    /// Whether a direction other than the box normals separates the two; `None` where the numbers cannot tell.
    fn is_separated(&self, points: &[Point; N]) -> Option<bool> {
        let by_normal = if is_upright(points) { Some(false) } else { self.separates(&self.normal()) };
        if by_normal == Some(true) {
            return by_normal;
        }
        let mut is_certain = by_normal.is_some();
        for (index, from) in points.iter().enumerate() {
            let next = (index + 1) % N;
            for axis in 0..3 {
                let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
                if shares(from, &points[next], j) || shares(from, &points[next], k) {
                    continue; // the cross product is a box normal, or zero
                }
                match self.separates_across(axis, [index, next]) {
                    Some(true) => return Some(true),
                    Some(false) => {}
                    None => is_certain = false,
                }
            }
        }
        is_certain.then_some(false)
    }

    /// The polygon's normal, of any length.
    fn normal(&self) -> [T; 3] {
        let [a, b, c] = [&self.corners[0], &self.corners[1], &self.corners[N - 1]];
        let minus = |p: &[T; 3], q: &[T; 3]| -> [T; 3] { std::array::from_fn(|i| p[i].clone() - q[i].clone()) };
        let (u, v) = (minus(b, a), minus(c, a));
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            u[j].clone() * v[k].clone() - u[k].clone() * v[j].clone()
        })
    }

    /// Whether the plane's normal separates: all corners are at one height along it.
    fn separates(&self, normal: &[T; 3]) -> Option<bool> {
        let [x, y, z] = normal;
        let corner = &self.corners[0];
        let height = x.clone() * corner[0].clone() + y.clone() * corner[1].clone() + z.clone() * corner[2].clone();
        let reach = x.clone().magnitude() * self.reach[0].clone()
            + y.clone().magnitude() * self.reach[1].clone()
            + z.clone().magnitude() * self.reach[2].clone();
        is_positive(&(height.magnitude() - reach))
    }

    /// Whether the cross product of a box axis and the edge between two corners separates.
    fn separates_across(&self, axis: usize, [from, to]: [usize; 2]) -> Option<bool> {
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let (from, to) = (&self.corners[from], &self.corners[to]);
        let along_j = from[k].clone() - to[k].clone();
        let along_k = to[j].clone() - from[j].clone();
        let reach =
            along_j.clone().magnitude() * self.reach[j].clone() + along_k.clone().magnitude() * self.reach[k].clone();
        let heights: [T; N] = std::array::from_fn(|index| {
            along_j.clone() * self.corners[index][j].clone() + along_k.clone() * self.corners[index][k].clone()
        });
        let above = all(heights.iter().map(|height| is_positive(&(height.clone() - reach.clone()))));
        if above == Some(true) {
            return above;
        }
        match all(heights.iter().map(|height| is_positive(&(-height.clone() - reach.clone())))) {
            Some(false) if above.is_some() => Some(false),
            Some(true) => Some(true),
            _ => None,
        }
    }
}

/// Whether the polygon lies in a plane across an axis, by coordinates that are the same float: its normal is a box normal.
fn is_upright(points: &[Point]) -> bool {
    (0..3).any(|axis| points.iter().all(|point| shares(point, &points[0], axis)))
}

/// Whether two points have the same coordinate, as far as floats alone can tell.
fn shares(a: &Point, b: &Point, axis: usize) -> bool {
    a.position[axis] == b.position[axis] && a.slack[axis] == 0.0 && b.slack[axis] == 0.0
}

fn is_positive<T: Scalar>(value: &T) -> Option<bool> {
    value.decide().map(|sign| sign == Sign::Positive)
}

/// Whether all of the answers are yes; one no outweighs any doubt.
fn all(answers: impl Iterator<Item = Option<bool>>) -> Option<bool> {
    let mut sum = Some(true);
    for answer in answers {
        match answer {
            Some(false) => return Some(false),
            Some(true) => {}
            None => sum = None,
        }
    }
    sum
}
