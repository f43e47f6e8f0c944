//! Rays against analytic bodies in their own coordinates: slabs for boxes, quadratics for curved ones.
//!
//! Distances count in lengths of the ray's direction, so they are the same before and after a ray is pulled into local
//! coordinates. Double precision, rounded: for pictures, not for proofs.

use glam::DVec3;
use umbriel_bvh::Ray;
use umbriel_geometry::{Cuboid, PlacedAnalytic, Rectangle, analytic::SurfaceHit};

/// The nearest point of a body on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LocalHit {
    pub(crate) distance: f64,
    pub(crate) face: usize,
    pub(crate) u: f64,
    pub(crate) v: f64,
    /// Outward, or by the winding; local coordinates, not of unit length.
    pub(crate) normal: DVec3,
}

/// The rectangle in the plane y = 0.
pub(crate) fn rectangle(rectangle: &Rectangle, ray: &Ray) -> Option<LocalHit> {
    let distance = -ray.origin.y / ray.direction.y;
    let point = at(ray, distance);
    let (u, v) = (point.x / rectangle.size[0] + 0.5, 0.5 - point.z / rectangle.size[1]);
    let inside = distance > 0.0 && distance.is_finite() && within_unit(u) && within_unit(v);
    inside.then_some(LocalHit { distance, face: 0, u, v, normal: DVec3::Y })
}

/// The box: where the ray enters it, or leaves it when it starts inside.
pub(crate) fn cuboid(cuboid: &Cuboid, ray: &Ray) -> Option<LocalHit> {
    let half = 0.5 * DVec3::from_array(cuboid.size);
    let (mut enter, mut leave) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        if direction == 0.0 {
            if origin.abs() > half[axis] {
                return None;
            }
            continue;
        }
        // The faces of an axis are 2·axis at its lower end and 2·axis + 1 at its upper end.
        let entered = if direction > 0.0 { 2 * axis } else { 2 * axis + 1 };
        let reach = direction.signum() * half[axis];
        let (near, far) = ((-reach - origin) / direction, (reach - origin) / direction);
        enter = if near > enter.0 { (near, entered) } else { enter };
        leave = if far < leave.0 { (far, entered ^ 1) } else { leave };
    }
    if enter.0 > leave.0 {
        return None;
    }
    let (distance, face) = if enter.0 > 0.0 { enter } else { leave };
    (distance > 0.0 && distance.is_finite()).then(|| cuboid_hit(cuboid, face, distance, at(ray, distance)))
}

fn cuboid_hit(cuboid: &Cuboid, face: usize, distance: f64, point: DVec3) -> LocalHit {
    let corners = cuboid.corners();
    let [first, second, _, last] = Cuboid::FACES[face].map(|corner| corners[corner as usize]);
    let along = |edge: DVec3| ((point - first).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
    let mut normal = DVec3::ZERO;
    normal[face / 2] = if face % 2 == 1 { 1.0 } else { -1.0 };
    LocalHit { distance, face, u: along(second - first), v: along(last - first), normal }
}

/// A body given by formulas: the nearest part of its surface.
pub(crate) fn analytic(body: &PlacedAnalytic, ray: &Ray) -> Option<LocalHit> {
    let SurfaceHit { distance, face, u, v, normal } = body.nearest_local_hit(ray.origin, ray.direction)?;
    Some(LocalHit { distance, face, u, v, normal })
}

fn at(ray: &Ray, distance: f64) -> DVec3 {
    ray.origin + distance * ray.direction
}

fn within_unit(value: f64) -> bool {
    (0.0..=1.0).contains(&value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbriel_geometry::{Analytic, Placement};

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray::new(DVec3::from_array(origin), DVec3::from_array(direction))
    }

    #[test]
    fn a_sphere_is_hit_from_outside_and_from_inside() {
        let body = PlacedAnalytic::new(Analytic::Sphere { radius: 2.0 }, Placement::IDENTITY).expect("a sphere");
        let outside = analytic(&body, &ray([10.0, 0.0, 0.0], [-2.0, 0.0, 0.0])).expect("a hit");
        assert_eq!((outside.distance, outside.face, outside.u, outside.v), (4.0, 1, 0.5, 0.5));
        assert_eq!(analytic(&body, &ray([0.0; 3], [0.0, -1.0, 0.0])).expect("a hit").face, 2);
        assert_eq!(analytic(&body, &ray([10.0, 2.1, 0.0], [-1.0, 0.0, 0.0])), None);
        assert_eq!(analytic(&body, &ray([10.0, 0.0, 0.0], [1.0, 0.0, 0.0])), None);
    }

    #[test]
    fn every_side_of_a_box_has_its_own_square() {
        let body = Cuboid { size: [2.0, 4.0, 6.0] };
        let corners = body.corners();
        for (face, loop_) in Cuboid::FACES.iter().enumerate() {
            let [first, second, _, last] = loop_.map(|corner| corners[corner as usize]);
            let place = first + 0.25 * (second - first) + 0.75 * (last - first);
            let outward = (second - first).cross(last - first).normalize();
            let hit = cuboid(&body, &Ray::new(place + outward, -outward)).expect("a hit");
            assert_eq!((hit.face, hit.u, hit.v, hit.distance), (face, 0.25, 0.75, 1.0));
            assert_eq!(hit.normal, outward);
            let hit = cuboid(&body, &Ray::new(place - 0.5 * outward, outward)).expect("seen from inside");
            assert_eq!((hit.face, hit.distance), (face, 0.5));
        }
        assert_eq!(cuboid(&body, &ray([5.0, 0.0, 0.0], [0.0, 1.0, 0.0])), None);
        assert_eq!(cuboid(&body, &ray([5.0, 0.0, 0.0], [1.0, 0.0, 0.0])), None);
    }

    #[test]
    fn a_rectangle_has_its_corner_at_minus_x_plus_z() {
        let body = Rectangle { size: [4.0, 2.0] };
        let hit = rectangle(&body, &ray([-1.0, 3.0, 0.5], [0.0, -1.0, 0.0])).expect("a hit");
        assert_eq!((hit.u, hit.v, hit.distance), (0.25, 0.25, 3.0));
        assert_eq!(rectangle(&body, &ray([2.1, 3.0, 0.5], [0.0, -1.0, 0.0])), None);
        assert_eq!(rectangle(&body, &ray([0.0, 0.0, 0.0], [1.0, 0.0, 0.0])), None);
    }
}
