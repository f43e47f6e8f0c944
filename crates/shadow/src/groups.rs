//! Receivers in groups, so that what is placed for one group can be forgotten before the next.
//!
//! Instances share a mesh and a tree, but their placed vertices, on which decisions are made, are their own. Placing is cheap beside deciding; so a group
//! places the instances that it needs and forgets them. Receivers that lie side by side as the light sees them have mostly the same occluders, so groups
//! follow a Morton curve there. What is no instance is placed for all of the bake and makes the first group: a ground that all bodies shadow needs the most room
//! to work, and has it for itself. Answers do not depend on groups.

use glam::DVec3;
use umbriel_geometry::{Aabb, LightSource};
use umbriel_octree::encode3;

use crate::{bodies::Bodies, receivers::Receivers};

/// A group is complete with so many faces: a common mesh or some small ones, which keep some threads busy, and so little that what is placed, looked through and forgotten takes
/// no more than one of them does. Groups four times as large took a megabyte more and no less time, groups 32 times as large three times the memory. Tests have more groups than
/// one.
const FACES: usize = if cfg!(test) { 1 << 6 } else { 1 << 12 };

/// Steps along each axis of the curve.
const STEPS: f64 = ((1u32 << 21) - 1) as f64;

/// Places in the request's list of receivers, in groups.
pub(crate) fn groups(receivers: &Receivers, asked: Vec<usize>) -> Vec<Vec<usize>> {
    let (bodies, objects) = (receivers.bodies, &receivers.request.receivers);
    let (instances, others): (Vec<usize>, _) = asked.into_iter().partition(|&place| bodies.is_instance(objects[place]));
    let others = Some(others).filter(|others| !others.is_empty());
    others.into_iter().chain(groups_of(bodies, objects, receivers.light, (instances, FACES))).collect()
}

/// Places in a list of receivers, in groups that are complete with `most` faces.
pub(crate) fn groups_of(
    bodies: &Bodies,
    receivers: &[usize],
    light: &LightSource,
    (asked, most): (Vec<usize>, usize),
) -> Vec<Vec<usize>> {
    let object = |receiver: usize| receivers[receiver];
    let place = |receiver: &usize| as_seen(light, bodies.bounds(object(*receiver)).center());
    let all = Aabb::of(asked.iter().map(place).filter(|place| place.is_finite()));
    let code = |receiver: &usize| {
        let step = (place(receiver) - all.min) / all.size().max_element() * STEPS;
        // What is no number, as of an empty box, comes first.
        encode3(step.to_array().map(|step| step as u32))
    };
    let mut ordered = asked;
    ordered.sort_by_cached_key(code);
    let (mut groups, mut faces) = (Vec::new(), most);
    for receiver in ordered {
        if faces >= most {
            groups.push(Vec::new());
            faces = 0;
        }
        faces += bodies.face_count(object(receiver));
        if let Some(group) = groups.last_mut() {
            group.push(receiver);
        }
    }
    groups
}

/// A point that is the same along a ray of the light.
fn as_seen(light: &LightSource, point: DVec3) -> DVec3 {
    let xyz = light.xyz();
    if light.is_sun() {
        point - xyz * (point.dot(xyz) / xyz.length_squared())
    } else {
        (point - xyz).normalize_or_zero()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, DQuat, DVec3};
    use umbriel_geometry::{LightSource, Mesh, Placement, Rectangle};
    use umbriel_scene::{Light, Object, Scene, Shape, Sides};

    use crate::{CellMethod, Detail, LightReport, Request, SampleCount, Sampling, Silent, bake};

    /// A bowl of 64 triangles, open above, in which vertices of one position are given twice.
    fn bowl() -> Mesh {
        let point = |k: u32| {
            let (ring, side) = (f64::from(k / 9), f64::from(k % 9 % 8));
            let way =
                [[1.0, 0.0], [0.7, 0.7], [0.0, 1.0], [-0.7, 0.7], [-1.0, 0.0], [-0.7, -0.7], [0.0, -1.0], [0.7, -0.7]];
            let [x, z] = way[side as usize].map(|part| part * (0.2 + 0.3 * ring));
            [x, 0.25 * ring * ring / 4.0, z]
        };
        let square = |k: u32| {
            let [a, b] = [k / 8 * 9 + k % 8, k / 8 * 9 + k % 8 + 1];
            [[a, a + 9, b], [b, a + 9, b + 9]]
        };
        Mesh::new((0..45).map(point).collect(), (0..32).flat_map(square).collect()).expect("a mesh")
    }

    /// Bowls over a floor, turned and of many sizes, one mesh for all or one for each.
    fn bowls(is_shared: bool) -> Scene {
        let mesh = Arc::new(bowl());
        let one = |k: u32| {
            let part = |step: f64| (f64::from(k) * step).fract();
            let turn = DQuat::from_xyzw(part(0.618), part(0.414), part(0.732), 0.5).normalize();
            let at = DVec3::new(8.0 * part(0.7549) - 4.0, 1.5 + 2.0 * part(0.3028), 8.0 * part(0.5698) - 4.0);
            let size = DVec3::new(0.5 + part(0.192), 0.5 + part(0.28), if k.is_multiple_of(5) { -1.0 } else { 1.0 });
            let placement = Placement::new(DAffine3::from_scale_rotation_translation(size, turn, at)).expect("regular");
            let mesh = if is_shared { Arc::clone(&mesh) } else { Arc::new(bowl()) };
            Object::new(format!("bowl {k}"), Shape::Mesh(mesh), placement, Sides::Auto).expect("an object")
        };
        let floor = Shape::Rectangle(Rectangle { size: [16.0; 2] });
        let floor = Object::new("floor".into(), floor, Placement::IDENTITY, Sides::Auto).expect("a floor");
        let lights = [
            LightSource::sun([0.3, -1.0, 0.2]),
            LightSource::point([0.5, 2.5, -0.5]),
            LightSource::sun([1.0, -1.0, 0.0]),
        ];
        Scene {
            objects: std::iter::once(floor).chain((0..24).map(one)).collect(),
            lights: lights.map(|light| Light::new("light", light.expect("a light"))).into(),
            ..Scene::default()
        }
    }

    fn answers(is_shared: bool, request: Request) -> Vec<LightReport> {
        bake(&bowls(is_shared), &request, &Silent).expect("nobody cancels").lights
    }

    #[test]
    fn instances_answer_as_meshes_of_their_own() {
        let scene = bowls(true);
        for method in [CellMethod::Quadtree, CellMethod::Borders, CellMethod::Auto] {
            for sampling in [None, Some(Sampling::Count(3000))] {
                let detail = Detail::Depth { interior: 2, boundary: 6 };
                let request = Request { keep_cells: true, sampling, method, ..Request::everything(&scene, detail) };
                let [shared, own] = [true, false].map(|is_shared| answers(is_shared, request.clone()));
                assert!(shared == own, "{method:?}");
                let shadowed = |light: &LightReport| light.objects[0].lit.upper < light.objects[0].area;
                assert!(shared.iter().all(shadowed), "bowls shadow the floor");
            }
        }
    }

    #[test]
    fn samples_of_instances_are_those_of_meshes_of_their_own() {
        let scene = bowls(true);
        for count in [300, 30_000] {
            let sampling = Some(Sampling::Count(count));
            let request = Request { keep_cells: true, sampling, ..Request::everything(&scene, Detail::Faces) };
            let [shared, own] = [true, false].map(|is_shared| answers(is_shared, request.clone()));
            assert!(shared == own, "{count} samples");
            let shadowed = |samples: SampleCount| samples.lit < samples.samples;
            assert!(
                shared.iter().all(|light| light.objects[0].samples.is_some_and(shadowed)),
                "bowls shadow the floor"
            );
        }
    }
}
