//! Facets that cannot shadow the face though they touch its plane, or come as high as the light: they are beside it.
//!
//! Neighbours of a face meet it along a side, often exactly. What may block of them lies beyond that side, up to points of
//! contact, which block nothing; this is decided by exact signs, so that no cell along the side is left undecided.

use umbriel_geometry::{
    Point, Sign,
    predicates::{Target, side_value},
};

use super::{
    chain::{BodyChain, Corner, place},
    projection::Image,
};
use crate::fine::flat::FLAT;

impl BodyChain<'_> {
    /// The side of the face (0: u = 0) beyond which the part of a facet that may block lies, points in contact with the
    /// face up to the side itself: so it blocks nothing of the face. Exact.
    pub(super) fn beyond(&self, corners: &[Corner]) -> Option<usize> {
        let [a, b, c, d] = [0, 1, 2, FLAT - 1].map(|k| &self.plane.corners[k]);
        let third = if self.plane.is_triangle { [[b, d]; 2] } else { [[b, c], [c, d]] };
        // Counter-clockwise round the face.
        let sides = [[d, a], [a, b], third[0], third[1]];
        sides.into_iter().enumerate().position(|(side, ends)| {
            let is_beyond = |corner: &Corner| self.is_beyond(corner, self.insides(&corner.image)[side], ends);
            let is_uncut = || corners.iter().all(|corner| corner.state & place::BELOW == 0);
            corners.iter().all(is_beyond) && (is_uncut() || self.cuts_along(corners, ends))
        })
    }

    /// How far an image is on the inner sides of the face's sides, up to [`BodyChain::side_error`]: u = 0, v = 0, and the others; a triangle's third is there twice.
    #[inline]
    fn insides(&self, &Image { u, v, w, .. }: &Image) -> [f64; 4] {
        if self.plane.is_triangle { [u, v, w - u - v, w - u - v] } else { [u, v, w - u, w - v] }
    }

    #[inline]
    fn side_error(&self) -> f64 {
        2.0 * (self.bounds.u + self.bounds.v + self.bounds.w)
    }

    /// Whether an image is surely on no line along a side of the face.
    pub(super) fn is_off_sides(&self, image: &Image) -> bool {
        self.insides(image).iter().all(|inside| inside.abs() > self.side_error())
    }

    /// Whether a corner, if it is not below the plane, is beyond a side of the face; `inside` is how far it is on the
    /// inner side.
    fn is_beyond(&self, corner: &Corner, inside: f64, [from, to]: [&Point; 2]) -> bool {
        let error = self.side_error();
        if inside < -error || corner.state & place::BELOW != 0 {
            return true;
        }
        if inside > error {
            return false;
        }
        let point = self.facets.point(corner.point);
        let side = Sign::of(side_value(from, to, &point, Target::Light(self.plane.light)).value);
        match side.times(self.plane.facing) {
            Sign::Positive => false,
            Sign::Zero => corner.state == place::ON,
            Sign::Negative => true,
        }
    }

    /// Whether a facet has a plane, and that meets the face's along a side of the face.
    fn cuts_along(&self, corners: &[Corner], ends: [&Point; 2]) -> bool {
        let [a, b, d] = [0, 1, corners.len() - 1].map(|k| self.facets.point(corners[k].point));
        let has_in_plane = |point: &Point| side_value(&a, &b, &d, Target::Point(point)).value == 0.0;
        // A facet without area has everything in its plane.
        ends.iter().all(|end| has_in_plane(end)) && !self.plane.corners.iter().all(has_in_plane)
    }

    /// Whether the part of a facet that is cut off below the light cannot be cast onto the face: one of the face's borders
    /// has it on the outer side.
    pub(super) fn high_part_is_beside(&self, corners: &[Corner]) -> bool {
        let bounds = &self.bounds;
        let cutoff = self.plane.projection.cutoff();
        // The part that is as high as the light or below it.
        let part = clip(corners.iter().map(|corner| corner.image).collect(), |image| cutoff * 1.5 - image.w);
        let part = clip(part, |image| image.w + 4.0 * bounds.w);
        let insides: Vec<[f64; 4]> = part.iter().map(|image| self.insides(image)).collect();
        (0..4).any(|side| insides.iter().all(|inside| inside[side] < -self.side_error()))
    }
}

/// The part of a polygon where `inside` is not negative (Sutherland & Hodgman 1974).
fn clip(polygon: Vec<Image>, inside: impl Fn(&Image) -> f64) -> Vec<Image> {
    let mut kept = Vec::new();
    for (k, image) in polygon.iter().enumerate() {
        let next = &polygon[(k + 1) % polygon.len()];
        let (here, there) = (inside(image), inside(next));
        if here >= 0.0 {
            kept.push(*image);
        }
        if (here >= 0.0) != (there >= 0.0) {
            kept.push(image.toward(next, here / (here - there)));
        }
    }
    kept
}
