//! Portals: convex polygons, checked against the two cells that they join.
//!
//! Corners of slanted portals are rounded, and so are those of the cells that they should lie on. So a corner stands for a box round it
//! ([`super::rounded`]); it is refused where no point of the box, and none of the boxes round the corners of the face, is in place. Where
//! neither the portal nor its cells state a slack, it is nothing for a portal that lies exactly in place, else an ulp of the greatest
//! coordinate, as far as a turn about the origin may move a corner.

use glam::DVec3;
use umbriel_geometry::{Approx, Brep, Decide, Dyadic, Point, Ring, Sign, accept_point, decisions::decide, predicates};

use super::{
    CellDefect, Region, SceneCell, face_plane,
    rounded::{apart, boxed, ulp},
};

/// An opening between two cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Portal {
    /// Unique within the scene.
    pub name: String,
    /// The two cells, by their indices.
    pub cells: [usize; 2],
    /// The corners of a strictly convex polygon, in order, world coordinates in metres. In a graph the first of the cells is
    /// in front of it, where they run counter-clockwise.
    pub corners: Vec<DVec3>,
    /// How far each coordinate of a corner may be from what is meant, by rounding, metres. In a graph it is that of its cells at least, and what
    /// is seen through the portal is taken wider by it; 0 only where it lies exactly in both boundaries.
    pub slack: f64,
}

impl Portal {
    /// As many corners as a portal may have.
    pub const MOST_CORNERS: usize = 256;

    /// The strictly convex outline of points that lie in a plane, world coordinates in metres; its corners are some of them. Fewer than three
    /// where they lie on a line. Exact; O(n log n).
    pub fn outline_of(points: &[DVec3]) -> Vec<DVec3> {
        let Some(&first) = points.first() else { return Vec::new() };
        let farthest = |far: &dyn Fn(&DVec3) -> f64| {
            points.iter().copied().max_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(first)
        };
        let second = farthest(&|point| point.distance_squared(first));
        let third = farthest(&|point| (second - first).cross(*point - first).length_squared());
        let axis = (second - first).cross(third - first).abs().max_position();
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut sorted = points.to_vec();
        sorted.sort_by(|a, b| a[j].total_cmp(&b[j]).then(a[k].total_cmp(&b[k])));
        sorted.dedup_by(|a, b| a[j] == b[j] && a[k] == b[k]);
        // Andrew's chains: along the lower side, and back along the upper one.
        let chain = |points: &mut dyn Iterator<Item = DVec3>| {
            let mut chain: Vec<DVec3> = Vec::new();
            for point in points {
                while let [.., before, last] = chain[..]
                    && turn(before, last, point, axis) != Sign::Positive
                {
                    chain.pop();
                }
                chain.push(point);
            }
            chain.pop();
            chain
        };
        let mut outline = chain(&mut sorted.iter().copied());
        outline.extend(chain(&mut sorted.iter().rev().copied()));
        outline
    }

    /// The portal with its first cell in front.
    pub(super) fn checked(mut self, cells: &[SceneCell]) -> Result<Self, CellDefect> {
        let [first, second] = self.cells;
        if first == second || first >= cells.len() || second >= cells.len() {
            return Err(CellDefect::Ends);
        }
        if !(3..=Self::MOST_CORNERS).contains(&self.corners.len()) {
            return Err(CellDefect::Corners(self.corners.len()));
        }
        for (corner, position) in self.corners.iter_mut().enumerate() {
            *position = accept_point(position.to_array()).map_err(|(axis, defect)| CellDefect::Coordinate {
                corner,
                axis,
                defect,
            })?;
        }
        let bodies = self.cells.map(|cell| match &cells[cell].region {
            Region::Convex(body) => Some(body),
            Region::Outdoors => None,
        });
        self.slack = self.cells.iter().fold(self.slack, |slack, &cell| slack.max(cells[cell].slack));
        if self.check_place(bodies).is_err() {
            let vertices = bodies.into_iter().flatten().flat_map(Brep::vertices).copied();
            self.slack = self.slack.max(ulp(vertices.chain(self.corners.iter().copied())));
            self.check_place(bodies)?;
        }
        let front = bodies.map(|body| Some(self.has_in_front(body?)));
        let first_is_in_front = match front {
            [Some(first), Some(second)] if first == second => return Err(CellDefect::SameSide),
            [Some(first), _] => first,
            [None, second] => !second.unwrap_or_default(),
        };
        if !first_is_in_front {
            self.corners.reverse();
        }
        Ok(self)
    }

    /// A strictly convex polygon in the boundaries of its cells, as far as its slack tells.
    fn check_place(&self, bodies: [Option<&Brep>; 2]) -> Result<(), CellDefect> {
        self.check_polygon()?;
        bodies.into_iter().enumerate().try_for_each(|(end, body)| match body {
            Some(body) => self.check_boundary(body, end),
            None => Ok(()),
        })
    }

    /// Planar within the corners' boxes, and every corner strictly left of every edge that it does not belong to.
    fn check_polygon(&self) -> Result<(), CellDefect> {
        let corners = &self.corners;
        let [a, b, c] = [0, 1, 2].map(|k| boxed(corners[k], self.slack));
        for (corner, &position) in corners.iter().enumerate().skip(3) {
            if apart(&a, &b, &c, &boxed(position, self.slack)).is_some() {
                return Err(CellDefect::NotPlanar { corner });
            }
        }
        let axis = widest_axis(corners);
        let n = corners.len();
        let turn = turn(corners[0], corners[1], corners[2], axis);
        for first in 0..n {
            let second = (first + 1) % n;
            for corner in (0..n).filter(|&corner| corner != first && corner != second) {
                let other = self::turn(corners[first], corners[second], corners[corner], axis);
                if turn == Sign::Zero || other != turn {
                    return Err(CellDefect::NotConvex { corner });
                }
            }
        }
        Ok(())
    }

    /// Whether all corners lie in one face of a cell, and no vertices of the cell lie on different sides of them: where rounding splits a
    /// wall into slivers, a sliver alone tells little.
    fn check_boundary(&self, body: &Brep, end: usize) -> Result<(), CellDefect> {
        let sides = |face: usize, corner: DVec3| {
            let [a, b, c] = face_plane(body, face).map(|corner| boxed(corner, self.slack));
            apart(&a, &b, &c, &boxed(corner, self.slack))
        };
        let outside = |&corner: &DVec3| (0..body.face_count()).any(|face| sides(face, corner) == Some(Sign::Positive));
        if let Some(corner) = self.corners.iter().position(outside) {
            return Err(CellDefect::NotInBoundary { corner, end });
        }
        let off = |face: usize| self.corners.iter().position(|&corner| sides(face, corner).is_some());
        let farthest = (0..body.face_count()).map(off).min_by_key(|off| off.map_or(0, |corner| usize::MAX - corner));
        match farthest.flatten() {
            Some(corner) => Err(CellDefect::NotInBoundary { corner, end }),
            None if self.divides(body) => Err(CellDefect::NotInBoundary { corner: 0, end }),
            None => Ok(()),
        }
    }

    /// Whether a cell surely reaches to both sides of the polygon's plane.
    fn divides(&self, body: &Brep) -> bool {
        let third = self.corners.len() * 2 / 3;
        let [a, b, c] = [0, self.corners.len() / 3, third].map(|k| boxed(self.corners[k], self.slack));
        let on = |side: Sign| {
            body.vertices().iter().any(|&vertex| apart(&a, &b, &c, &boxed(vertex, self.slack)) == Some(side))
        };
        on(Sign::Positive) && on(Sign::Negative)
    }

    /// Whether a cell whose boundary the polygon lies in is in front of it: by the vertex farthest from its plane.
    fn has_in_front(&self, body: &Brep) -> bool {
        let [a, b, c] = [0, 1, 2].map(|k| Point::exact(self.corners[k]));
        let height = |&vertex: &DVec3| {
            predicates::side_value(&a, &b, &c, predicates::Target::Point(&Point::exact(vertex))).value
        };
        let heights = body.vertices().iter().map(height);
        heights.max_by(|a, b| a.abs().total_cmp(&b.abs())).is_some_and(|height| height > 0.0)
    }
}

/// Whether two portals lie in one plane, as far as rounding lets tell, and share some of their area there: no line of an edge has one of them wholly on its outer
/// side. Exact in the plane of two coordinates.
pub(super) fn share_area(one: &Portal, two: &Portal) -> bool {
    let slack = ulp(one.corners.iter().chain(&two.corners).copied()).max(one.slack).max(two.slack);
    let [a, b, c] = [0, 1, 2].map(|k| boxed(one.corners[k], slack));
    if two.corners.iter().any(|&corner| apart(&a, &b, &c, &boxed(corner, slack)).is_some()) {
        return false;
    }
    let axis = widest_axis(&one.corners);
    let is_kept_out = |inner: &Portal, other: &Portal| {
        let corners = &inner.corners;
        let winding = turn(corners[0], corners[1], corners[2], axis);
        (0..corners.len()).any(|k| {
            let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
            other.corners.iter().all(|&corner| turn(from, to, corner, axis) != winding)
        })
    };
    !is_kept_out(one, two) && !is_kept_out(two, one)
}

/// The axis along which the polygon's area is largest, by Newell's sums; any will do where none is clearly largest.
fn widest_axis(corners: &[DVec3]) -> usize {
    let normal: DVec3 =
        (1..corners.len() - 1).map(|k| (corners[k] - corners[0]).cross(corners[k + 1] - corners[0])).sum();
    normal.abs().max_position()
}

/// The sign of the turn a, b, c, seen along an axis. Exact.
fn turn(a: DVec3, b: DVec3, c: DVec3, axis: usize) -> Sign {
    fn doubled<T: Decide>(a: DVec3, b: DVec3, c: DVec3, axis: usize) -> T {
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let from_a = |p: DVec3, i: usize| T::number(p[i]) - T::number(a[i]);
        from_a(b, j) * from_a(c, k) - from_a(b, k) * from_a(c, j)
    }
    let filtered: Approx = doubled(a, b, c, axis);
    decide(filtered.sign(), || doubled::<Dyadic>(a, b, c, axis).sign())
}

#[cfg(test)]
mod tests {
    use umbriel_geometry::decisions::Decisions;

    use super::*;

    #[test]
    fn corners_in_line_are_told_exactly() {
        let [a, b, c] = [0.1, 0.2, 0.4].map(|t| DVec3::new(t, 1.0, 3.0 * t));
        let before = Decisions::of_thread();
        assert_eq!(turn(a, b, DVec3::new(0.4, 1.0, 0.7), 1), Sign::Positive);
        assert_eq!((Decisions::of_thread() - before).exact, 0);
        let sign = turn(a, b, c, 1);
        assert_eq!((Decisions::of_thread() - before).exact, 1);
        let numbers = |p: DVec3| [p.x, p.z].map(Dyadic::new);
        let [[ax, az], [bx, bz], [cx, cz]] = [a, b, c].map(numbers);
        let across = (bz - az.clone()) * (cx - ax.clone()) - (bx - ax) * (cz - az);
        assert_eq!(sign, across.sign());
    }
}
