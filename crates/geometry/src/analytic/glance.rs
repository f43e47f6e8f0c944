//! Whether a body is likely to be in the way from a point to a light: in floats, for estimates and for choosing what to prove.
//!
//! A point on the way from x to the light L is y = x + s·L with s > 0, in homogeneous coordinates. Planes leave an interval of s, and
//! q(y, y) = q(x, x) + 2·s·q(x, L) + s²·q(L, L) is least over it at one of its ends or, with q(L, L) > 0, between them. Guarantee: none but that
//! the axes of the world may change places without changing an answer. Cost: some ten nanoseconds. Rays for pictures (`ray`) do not serve: they look for the place
//! of a hit, reach a little beyond every part, so that no seam opens, and know nothing of contact.

use glam::DVec3;

use super::{
    PlacedAnalytic,
    forms::{LocalPoint, QuadricForm, linear_value},
    layout::Piece,
};
use crate::{approx::sorted, light::LightSource};

/// What is within this of a plane lies in it, as a share of the terms of its form: a point in contact with a body is not in its own way.
const CONTACT: f64 = 64.0 * f64::EPSILON;

/// A placed body and a light strictly outside of it.
#[derive(Clone, Debug)]
pub struct Glance {
    adjugate: [[f64; 3]; 3],
    translation: DVec3,
    weight: f64,
    pieces: Vec<PieceGlance>,
}

/// One of the sets whose union is the body.
#[derive(Clone, Debug)]
struct PieceGlance {
    quadric: QuadricForm<f64>,
    /// The linear form q(·, L).
    polar: [f64; 4],
    /// q(L, L).
    at_light: f64,
    planes: Vec<PlaneGlance>,
    flat: Option<PlaneGlance>,
}

/// A plane's form, and its value at the light.
#[derive(Clone, Debug)]
struct PlaneGlance {
    form: [f64; 4],
    at_light: f64,
}

impl PlacedAnalytic {
    /// The body as ways to this light see it, which must be strictly outside.
    pub fn glance(&self, light: &LightSource) -> Glance {
        let forms = self.float_forms();
        let light = self.forms().pull_back_light(light).map(|coordinate| coordinate.value);
        Glance {
            adjugate: forms.adjugate,
            translation: forms.translation.into(),
            weight: forms.weight,
            pieces: self.pieces().iter().map(|piece| self.piece_glance(piece, &light)).collect(),
        }
    }

    fn piece_glance(&self, piece: &Piece, light: &LocalPoint<f64>) -> PieceGlance {
        let forms = self.float_forms();
        let plane = |&index: &usize| {
            let form = forms.planes()[index];
            PlaneGlance { form, at_light: linear_value(&form, light) }
        };
        let quadric = forms.quadrics()[piece.quadric].clone();
        PieceGlance {
            polar: quadric.polar(light),
            at_light: quadric.value(light, light),
            quadric,
            planes: piece.planes.iter().map(plane).collect(),
            flat: piece.flat.as_ref().map(plane),
        }
    }
}

impl Glance {
    /// Whether the body is likely to be in the way from a point.
    pub fn blocks(&self, position: DVec3) -> bool {
        let way = position - self.translation;
        let row = |row: &[f64; 3]| {
            let [least, middle, greatest] = sorted([row[0] * way.x, row[1] * way.y, row[2] * way.z]);
            (least + greatest) + middle
        };
        let [x, y, z] = &self.adjugate;
        let local = [row(x), row(y), row(z), self.weight];
        self.pieces.iter().any(|piece| piece.blocks(&local))
    }
}

impl PieceGlance {
    fn blocks(&self, x: &LocalPoint<f64>) -> bool {
        let Some([start, end]) = self.between_planes(x) else { return false };
        let (constant, half_slope) = (self.quadric.value(x, x), linear_value(&self.polar, x));
        let at = |s: f64| constant + s * (2.0 * half_slope + s * self.at_light);
        if self.flat.is_some() {
            return at(start) <= 0.0;
        }
        let lowest = -half_slope / self.at_light;
        let is_lowest_between = self.at_light > 0.0 && start < lowest && lowest < end;
        let is_met_at_start = if start > 0.0 { at(start) <= 0.0 } else { constant < 0.0 };
        is_met_at_start
            || end < f64::INFINITY && at(end) <= 0.0
            || is_lowest_between && constant * self.at_light <= half_slope * half_slope
    }

    /// Which part of the way lies between the planes; where it crosses the plane of a flat piece, that point twice.
    fn between_planes(&self, x: &LocalPoint<f64>) -> Option<[f64; 2]> {
        let mut part = [0.0, f64::INFINITY];
        for plane in &self.planes {
            let value = plane.at(x);
            let crossing = -value / plane.at_light;
            match plane.at_light {
                at_light if at_light > 0.0 => part[0] = crossing.max(part[0]),
                at_light if at_light < 0.0 => part[1] = crossing.min(part[1]),
                _ if value < 0.0 => return None,
                _ => {}
            }
        }
        let Some(plane) = &self.flat else { return (part[0] < part[1]).then_some(part) };
        let crossing = -plane.at(x) / plane.at_light;
        let is_between = crossing > 0.0 && crossing < f64::INFINITY && part[0] <= crossing && crossing <= part[1];
        is_between.then_some([crossing; 2])
    }
}

impl PlaneGlance {
    /// The form at a point, zero in contact.
    fn at(&self, x: &LocalPoint<f64>) -> f64 {
        let terms: [f64; 4] = std::array::from_fn(|k| self.form[k] * x[k]);
        let [value, size] = [terms, terms.map(f64::abs)].map(|[a, b, c, d]| a + b + c + d);
        if value.abs() <= CONTACT * size { 0.0 } else { value }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DQuat};

    use super::*;
    use crate::{Placement, analytic::Analytic};

    fn placed(body: Analytic) -> PlacedAnalytic {
        let map = DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.5), DVec3::new(1.0, 2.0, 3.0));
        PlacedAnalytic::new(body, Placement::new(map).expect("regular")).expect("a body")
    }

    /// A point is shadowed where a picture's ray from it meets the surface.
    #[test]
    fn glances_agree_with_rays() {
        let cone = [[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, -0.1]];
        let bodies = [
            Analytic::Sphere { radius: 0.7 },
            Analytic::Ellipsoid { radii: [1.0, 0.01, 0.5] },
            Analytic::Cylinder { radius: 0.5, height: 2.0 },
            Analytic::Cone { radius: 0.8, height: 1.5 },
            Analytic::Capsule { radius: 0.6, height: 1.7 },
            Analytic::Hyperboloid { waist_radius: 0.3, end_radius: 1.0, height: 1.5 },
            Analytic::Disk { radius: 1.0 },
            Analytic::Quadric { matrix: cone, within: [[-1.0; 3], [1.0; 3]] },
        ];
        let lights = [LightSource::sun([0.3, -1.0, 0.2]), LightSource::point([3.0, 5.0, 2.0])];
        for (body, light) in bodies.iter().flat_map(|body| lights.iter().map(move |light| (body, light))) {
            let (body, light) = (placed(*body), light.as_ref().expect("a light"));
            let (glance, inverse) = (body.glance(light), body.placement().map().inverse());
            let mut blocked = 0;
            for k in 0..1000 {
                let at = [k % 10, k / 10 % 10, k / 100].map(|step| f64::from(step) * 0.41 - 1.83);
                let point = DVec3::new(1.0, 2.0, 3.0) + DVec3::from_array(at);
                let (way, most) =
                    if light.is_sun() { (light.xyz(), f64::INFINITY) } else { (light.xyz() - point, 1.0) };
                let hit = body.nearest_local_hit(inverse.transform_point3(point), inverse.transform_vector3(way));
                let is_hit = hit.is_some_and(|hit| hit.distance < most);
                assert_eq!(glance.blocks(point), is_hit, "{:?} {light:?} {point}", body.body());
                blocked += u32::from(is_hit);
            }
            assert!(blocked > 20, "{:?} {light:?} {blocked}", body.body());
        }
    }

    #[test]
    fn what_stands_on_a_point_is_no_more_in_its_way_than_it_was() {
        let (up, down) = (DVec3::new(0.2, 1.0, 0.1), DVec3::new(0.2, -1.0, 0.1));
        let turned = DQuat::from_rotation_x(0.5);
        let body = placed(Analytic::Cylinder { radius: 0.5, height: 2.0 });
        let foot = DVec3::new(1.0, 2.0, 3.0) + turned * DVec3::new(0.1, -1.0, 0.2);
        let [above, below] = [up, down].map(|to_light| {
            let light = LightSource::sun((turned * -to_light).to_array()).expect("a sun");
            // `xyz` is the way to the light.
            body.glance(&light).blocks(foot)
        });
        assert!(above && !below);
    }
}
