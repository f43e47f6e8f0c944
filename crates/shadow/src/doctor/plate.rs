//! Faces that carry their exact corners with them, and the exact answer to whether two of one plane overlap.
//!
//! A plane is looked at from a point off it, its *eye*: for a, b, x in the plane the side of the eye on (a, b, x) is
//! the turn from a over b to x, so the one exact predicate for planes in space serves in every plane, and nothing is
//! projected. Two convex polygons share an area unless an edge of one of them has the whole other one on its outer
//! side (the separating axes of the plane), edge included: neighbours that touch share none.
//!
//! Cost: a handful of predicates that fail fast for two faces that do not overlap. The shared area is a rounded number
//! (Sutherland and Hodgman, "Reentrant polygon clipping", Communications of the ACM 17(1), 1974), for output only.

use glam::DVec3;
use umbriel_geometry::{Aabb, Exact, ExactPoint, Facets, Point, Sign, predicates::side};

/// A point off the plane of a face; `None` when the face has no area, exactly.
///
/// Four points that lie in no common plane: a face with area has a side towards one of them, one without has none.
pub(super) fn eye_of(facets: &Facets, facet: usize) -> Option<DVec3> {
    let corners = facets.facet(facet).corners();
    let [a, b, c] = [corners[0], corners[1], corners[corners.len() - 1]].map(|corner| facets.point(corner));
    let (u, v) = (b.position - a.position, c.position - a.position);
    let normal = u.cross(v).abs();
    let largest = a.position.abs().max_element();
    let reach = if largest > 0.0 { largest } else { 1.0 };
    let mut axes = [0, 1, 2];
    // The axis that the normal runs along sees the face best.
    axes.sort_by(|&i, &j| normal[j].total_cmp(&normal[i]));
    let steps = axes.map(|axis| DVec3::AXES[axis] * reach).into_iter().chain([DVec3::ZERO]);
    steps.map(|step| a.position + step).find(|&eye| side(&a, &b, &c, &Point::exact(eye)) != Sign::Zero)
}

/// A corner that owns its exact point.
#[derive(Clone, Debug)]
struct Corner {
    position: DVec3,
    /// What the position leaves out, and the point itself, where it is no float. Boxed: nearly all are floats.
    inexact: Option<Box<(DVec3, ExactPoint)>>,
}

impl Corner {
    fn new(point: &Point) -> Self {
        let inexact = point.exact.map(|exact| Box::new((point.rest, exact.point().clone())));
        Self { position: point.position, inexact }
    }

    fn point(&self) -> Point<'_> {
        let position = self.position;
        match self.inexact.as_deref() {
            Some((rest, exact)) => Point::with_rest(position, *rest, Exact::Point(exact)),
            None => Point::exact(position),
        }
    }
}

/// A flat face of some object.
#[derive(Clone, Debug)]
pub(super) struct Plate {
    pub(super) object: u32,
    /// How many objects have this face: the object and those that repeat it.
    pub(super) copies: u32,
    /// How often each of them has it.
    pub(super) repeats: u32,
    pub(super) is_one_sided: bool,
    is_mirrored: bool,
    /// Rounded, square metres.
    pub(super) area: f64,
    pub(super) bounds: Aabb,
    eye: DVec3,
    corners: Vec<Corner>,
}

/// How two faces of one plane lie on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meeting {
    /// What they share, square metres, rounded.
    pub(super) area: f64,
    /// Whether their fronts point in opposite directions.
    pub(super) is_back_to_back: bool,
}

impl Plate {
    /// A facet with its corners; `None` for one without area.
    pub(super) fn new((object, copies): (u32, u32), facets: &Facets, facet: usize, is_one_sided: bool) -> Option<Self> {
        let corners = facets.facet(facet).corners();
        let corners = corners.iter().map(|&corner| Corner::new(&facets.point(corner)));
        Some(Self {
            object,
            copies,
            repeats: 1,
            is_one_sided,
            is_mirrored: facets.is_mirrored(),
            area: facets.area(facet).value,
            bounds: facets.facet_bounds(facet),
            eye: eye_of(facets, facet)?,
            corners: corners.collect(),
        })
    }

    /// How this face and another lie on each other; `None` when they lie in two planes, or share no area.
    pub(super) fn meeting(&self, other: &Self) -> Option<Meeting> {
        if !may_share_area(&self.bounds, &other.bounds) {
            return None;
        }
        let eye = Point::exact(self.eye);
        let (own, their) = (self.turn(&eye), other.turn(&eye));
        // Neighbours fail the first test at once, by corners they share; the plane is the dearer question.
        let is_apart = self.has_outside(own, other, &eye) || other.has_outside(their, self, &eye);
        if is_apart || !self.is_coplanar(other) {
            return None;
        }
        let is_turned_over = own != their;
        let is_back_to_back = is_turned_over != (self.is_mirrored != other.is_mirrored);
        Some(Meeting { area: self.shared_area(other), is_back_to_back })
    }

    /// Whether both have the same corners (those that no float hits never count as the same).
    pub(super) fn has_corners_of(&self, other: &Self) -> bool {
        let is_there = |corner: &Corner| other.corners.iter().any(|there| there.position == corner.position);
        let is_exact = |plate: &Self| plate.corners.iter().all(|corner| corner.inexact.is_none());
        is_exact(self)
            && is_exact(other)
            && self.corners.len() == other.corners.len()
            && self.corners.iter().all(is_there)
    }

    /// Which way the corners run, seen from a point off the plane.
    fn turn(&self, eye: &Point) -> Sign {
        let [a, b, c] = self.three();
        side(&a, &b, &c, eye)
    }

    fn is_coplanar(&self, other: &Self) -> bool {
        let [a, b, c] = self.three();
        other.corners.iter().all(|corner| side(&a, &b, &c, &corner.point()) == Sign::Zero)
    }

    /// Whether all of the other face lies on the outer side of an edge. This face's corners run by `turn`.
    fn has_outside(&self, turn: Sign, other: &Self, eye: &Point) -> bool {
        let mut edges = (0..self.corners.len()).map(|k| [k, (k + 1) % self.corners.len()]);
        edges.any(|[from, to]| {
            let (from, to) = (self.corners[from].point(), self.corners[to].point());
            let is_outside = |x: &Corner| side(&from, &to, &x.point(), eye).times(turn) != Sign::Positive;
            other.corners.iter().all(is_outside)
        })
    }

    /// Three corners that span the plane.
    fn three(&self) -> [Point<'_>; 3] {
        [0, 1, self.corners.len() - 1].map(|k| self.corners[k].point())
    }

    /// The area of the intersection of two faces of one plane, rounded.
    fn shared_area(&self, other: &Self) -> f64 {
        let origin = self.corners[0].position;
        let [a, b, c] = self.three().map(|corner| corner.position);
        let normal = (b - a).cross(c - a).abs();
        let axis = (0..3).fold(0, |best, axis| if normal[axis] > normal[best] { axis } else { best });
        let flat = |corner: &Corner| {
            let away = corner.position - origin;
            [away[(axis + 1) % 3], away[(axis + 2) % 3]]
        };
        let own: Vec<[f64; 2]> = self.corners.iter().map(flat).collect();
        let mut rest: Vec<[f64; 2]> = other.corners.iter().map(flat).collect();
        let whole = signed_area(&own);
        for k in 0..own.len() {
            rest = clipped(&rest, own[k], own[(k + 1) % own.len()], whole.signum());
        }
        let share = (signed_area(&rest) / whole).abs();
        if share.is_finite() { (share * self.area).min(self.area).min(other.area) } else { 0.0 }
    }
}

/// Whether the boxes overlap along two axes at least: what lies in both may then have an area.
fn may_share_area(a: &Aabb, b: &Aabb) -> bool {
    let (low, high) = (a.min.max(b.min), a.max.min(b.max));
    low.cmple(high).all() && low.cmplt(high).bitmask().count_ones() >= 2
}

/// The part of a polygon on the inner side of a line; `turn` is the direction in which the clipping polygon runs.
fn clipped(polygon: &[[f64; 2]], from: [f64; 2], to: [f64; 2], turn: f64) -> Vec<[f64; 2]> {
    let height = |x: [f64; 2]| turn * ((to[0] - from[0]) * (x[1] - from[1]) - (to[1] - from[1]) * (x[0] - from[0]));
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &x) in polygon.iter().enumerate() {
        let next = polygon[(k + 1) % polygon.len()];
        let (here, there) = (height(x), height(next));
        if here >= 0.0 {
            kept.push(x);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            let t = here / (here - there);
            kept.push([x[0] + t * (next[0] - x[0]), x[1] + t * (next[1] - x[1])]);
        }
    }
    kept
}

fn signed_area(polygon: &[[f64; 2]]) -> f64 {
    let corner = |k: usize| polygon[k % polygon.len()];
    let twice: f64 =
        (0..polygon.len()).map(|k| corner(k)[0] * corner(k + 1)[1] - corner(k)[1] * corner(k + 1)[0]).sum();
    0.5 * twice
}
