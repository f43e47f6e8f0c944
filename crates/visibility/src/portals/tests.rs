use glam::{DAffine3, DVec3};
use proptest::prelude::*;
use umbriel_geometry::{Aabb, Brep, Cuboid, Placement, decisions::Decisions};
use umbriel_scene::{Camera, Portal, Region, SceneCell, Shape, Sides};

use super::*;

fn room(name: &str, min: DVec3, max: DVec3) -> SceneCell {
    let ends = [min, max];
    let corner = |i: usize| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2 & 1].z);
    SceneCell { name: name.into(), region: Region::Convex(Brep::hull((0..8).map(corner)).expect("a box")), slack: 0.0 }
}

/// A row of cubes of 4 m along x with a door of 1 m in each wall between two, all in line; a small box in the middle of each room.
fn enfilade(rooms: usize) -> Scene {
    let at = |number: usize| 4.0 * number as f64;
    let cells = (0..rooms)
        .map(|number| room(&format!("{number}"), DVec3::X * at(number), DVec3::new(at(number + 1), 4.0, 4.0)))
        .collect();
    let door = |number: usize| Portal {
        name: format!("door {number}"),
        cells: [number - 1, number],
        corners: [[0.0, 1.5], [0.0, 2.5], [2.0, 2.5], [2.0, 1.5]].map(|[y, z]| DVec3::new(at(number), y, z)).to_vec(),
        slack: 0.0,
    };
    let object = |number: usize, z: f64| {
        let place = Placement::new(DAffine3::from_translation(DVec3::new(at(number) + 2.0, 1.0, z))).expect("regular");
        Object::new(format!("box {number}"), Shape::Cuboid(Cuboid { size: [0.5; 3] }), place, Sides::Auto)
            .expect("a box")
    };
    // One in line with the doors, one in a corner, in each room.
    let objects: Vec<Object> = (0..rooms).flat_map(|number| [object(number, 2.0), object(number, 0.5)]).collect();
    let cells = CellGraph::new(cells, (1..rooms).map(door).collect(), &objects).expect("rooms");
    Scene { objects: objects.into(), cells, ..Scene::default() }
}

fn lamp(x: f64, y: f64, z: f64) -> LightSource {
    LightSource::point([x, y, z]).expect("a lamp")
}

#[test]
fn doors_in_line_show_what_is_in_line() {
    let scene = enfilade(6);
    let reach = reach_of_light(&scene, &lamp(1.0, 1.0, 2.0));
    assert_eq!((reach.cells.len(), reach.passages, reach.start), (6, 5, Start::Cells));
    // From the second room on the corners are hidden: in room k the cone is 1 m · (4k + 1)/3 wide at most.
    let seen: Vec<usize> = reach.indices().collect();
    assert!([0, 1, 2, 4, 6, 8, 10].iter().all(|object| seen.contains(object)), "{seen:?}");
    assert!(!seen.contains(&3), "{seen:?}");
    // From beside the door nothing of the third room is seen.
    let reach = reach_of_light(&scene, &lamp(3.5, 1.0, 0.25));
    assert_eq!(reach.cells, [0, 1]);
}

#[test]
fn doors_whose_edges_are_in_one_plane_with_the_eye_are_told_exactly() {
    // The plane z = 1.5 through the lamp holds a side of every door, and y = 2.5 another one.
    let before = Decisions::of_thread();
    let reach = reach_of_light(&enfilade(6), &lamp(1.0, 2.5, 1.5));
    let decisions = Decisions::of_thread() - before;
    assert!(decisions.exact > 0, "{decisions:?}");
    assert_eq!((reach.cells.len(), reach.passages), (6, 5));
}

#[test]
fn an_eye_in_the_plane_of_a_door_looks_both_ways() {
    let scene = enfilade(3);
    let reach = reach_of_light(&scene, &lamp(4.0, 1.0, 2.0));
    assert_eq!(reach.cells, [0, 1, 2]);
    assert_eq!(reach.objects.first().expect("an object").object, 0);
    // Under the lintel's line, beside the door, the plane itself is all that is seen of the other side.
    assert!(reach_of_light(&scene, &lamp(4.0, 3.5, 0.5)).cells.starts_with(&[0, 1]));
}

#[test]
fn an_eye_in_no_cell_sees_what_its_frustum_meets() {
    let scene = enfilade(3);
    let camera = |eye: DVec3, target: DVec3| {
        let projection = Projection::Perspective { vertical_degrees: 30.0 };
        View { camera: Camera { eye, target, up: DVec3::Y, projection }, width: 100, height: 100 }
    };
    let outside = camera(DVec3::new(2.0, 1.0, -10.0), DVec3::new(2.0, 1.0, 0.0));
    let reach = reach_of_eye(&scene, &outside).expect("an eye");
    assert_eq!(reach.start, Start::OutsideCells);
    assert_eq!(reach.indices().collect::<Vec<_>>(), frustum_culling(&scene, &outside).expect("an eye"));
    assert!(reach.objects.len() < scene.objects.len());
    let inside = camera(DVec3::new(1.0, 1.0, 2.0), DVec3::new(2.0, 1.0, 2.0));
    let reach = reach_of_eye(&scene, &inside).expect("an eye");
    assert_eq!((reach.start, reach.cells.len()), (Start::Cells, 3));
    let back = reach_of_eye(&scene, &camera(DVec3::new(1.0, 1.0, 2.0), DVec3::new(0.0, 1.0, 2.0))).expect("an eye");
    assert_eq!(back.cells, [0], "the door is behind the eye");
    let parallel =
        View { camera: Camera { projection: Projection::Orthographic { height: 3.0 }, ..inside.camera }, ..inside };
    assert_eq!(reach_of_eye(&scene, &parallel).expect("a view").start, Start::Parallel);
}

#[test]
fn two_chains_collect_an_object_once() {
    // Two doors side by side between two rooms; the box stands behind both.
    let mut scene = enfilade(2);
    let portal = |name: &str, z: f64| Portal {
        name: name.into(),
        cells: [0, 1],
        corners: [[0.0, z], [0.0, z + 0.5], [2.0, z + 0.5], [2.0, z]].map(|[y, z]| DVec3::new(4.0, y, z)).to_vec(),
        slack: 0.0,
    };
    let portals = vec![portal("left", 1.5), portal("right", 2.0)];
    scene.cells = CellGraph::new(scene.cells.cells().to_vec(), portals, &scene.objects).expect("rooms");
    let reach = reach_of_light(&scene, &lamp(1.0, 1.0, 2.0));
    let behind: Vec<&Reached> = reach.objects.iter().filter(|reached| reached.object == 2).collect();
    assert_eq!(behind.len(), 1);
    assert_eq!(behind[0].frusta.len(), 2);
    assert!(behind[0].frusta.iter().all(|&frustum| reach.frusta[frustum].sides() == 4));
}

#[test]
fn the_sun_looks_in_through_windows_only() {
    let mut scene = enfilade(2);
    let mut cells = scene.cells.cells().to_vec();
    cells.push(SceneCell { name: "outdoors".into(), region: Region::Outdoors, slack: 0.0 });
    let mut portals = scene.cells.portals().to_vec();
    let window = [[1.0, 1.0], [1.5, 1.0], [1.5, 3.0], [1.0, 3.0]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
    portals.push(Portal { name: "window".into(), cells: [0, 2], corners: window, slack: 0.0 });
    scene.cells = CellGraph::new(cells, portals, &scene.objects).expect("rooms");
    let sun = |direction| LightSource::sun(direction).expect("a sun");
    let reach = reach_of_light(&scene, &sun([1.0, -1.0, 1.5]));
    // It falls into the first room, and no ray of it comes through the door.
    assert_eq!(reach.cells, [0, 2]);
    assert_eq!(reach_of_light(&scene, &sun([1.0, -0.5, -1.5])).cells, [2], "it shines at the back");
    // Flat enough along x, it passes the door as well.
    assert_eq!(reach_of_light(&scene, &sun([3.0, -0.5, 2.0])).cells, [0, 1, 2]);
}

/// Rooms, doors and rays are turned and moved exactly enough, and the rooms and doors are rounded to 32 bits: whatever passes the true doors passes the rounded ones.
#[test]
fn rounded_doors_show_all_that_the_true_ones_show() {
    let scene = enfilade(3);
    let mut far_rooms = 0;
    for step in 1..60_u32 {
        let number = |k: u32| f64::from(step.wrapping_mul(2_654_435_761).wrapping_mul(k + 1) >> 8) / f64::from(1 << 24);
        let turn = glam::DQuat::from_euler(glam::EulerRot::YXZ, 6.0 * number(0), 2.0 * number(1), number(2));
        let shift = DVec3::new(1000.0 * number(3), -30.0, 7.0) * f64::from(step % 3);
        let truly = |point: DVec3| turn * point + shift;
        let rounded = |point: &DVec3| truly(*point).as_vec3().as_dvec3();
        let slack = truly(DVec3::splat(12.0)).abs().max_element() * f64::from(f32::EPSILON);
        let turned = |cell: &SceneCell| {
            let Region::Convex(body) = &cell.region else { return cell.clone() };
            let body = Brep::hull(body.vertices().iter().map(rounded)).expect("a box");
            SceneCell { region: Region::Convex(body), slack, ..cell.clone() }
        };
        let cells = scene.cells.cells().iter().map(turned).collect();
        let portal =
            |portal: &Portal| Portal { corners: portal.corners.iter().map(rounded).collect(), ..portal.clone() };
        let portals = scene.cells.portals().iter().map(portal).collect();
        let graph = CellGraph::new(cells, portals, &[]).unwrap_or_else(|defect| panic!("step {step}: {defect:?}"));
        let scene = Scene { cells: graph, ..Scene::default() };
        // Through the edges of the two doors, from near and far, and from flat angles.
        for (k, y, z, to) in [
            (4, 0.0, 1.5, [0.5, 2.5]),
            (5, 2.0, 2.5, [0.0, 1.5]),
            (6, 0.0, 2.5, [0.25, 2.5]),
            (7, 1.0, 1.5, [1.5, 1.5]),
        ] {
            let on_door = DVec3::new(4.0, y, z);
            let out = 4.0 * 10.0_f64.powi(-((step % 8) as i32)) * number(k);
            let beside = DVec3::new(4.0 - out, 1.0 + number(k + 1), 2.0 + 1.9 * (number(k + 2) - 0.5));
            let in_line = on_door - (DVec3::new(8.0, to[0], to[1]) - on_door) * (0.25 * out);
            let is_inside = in_line.y > 0.0 && (0.0..4.0).contains(&in_line.z);
            let local = if step % 2 == 0 && is_inside { in_line } else { beside };
            let direction = on_door - local;
            let eye = truly(local);
            let reach = reach_of_light(&scene, &LightSource::point(eye.to_array()).expect("a lamp"));
            assert_eq!(reach.start, Start::Cells);
            // Where the ray leaves the second room: through its door, or at its walls, before which it meets something.
            let at_far_wall = on_door + direction * (4.0 / direction.x);
            let passes = local == in_line;
            let beyond = if passes { at_far_wall + 0.5 * direction / direction.x } else { on_door + 1e-3 * direction };
            let cell = if passes { 2 } else { 1 };
            far_rooms += u32::from(passes);
            let at = Aabb { min: truly(beyond), max: truly(beyond) };
            assert!(reach.cells.contains(&cell), "step {step}, door point {k}: room {cell} is not entered");
            assert!(
                reach.frusta.iter().skip(1).any(|frustum| !frustum.misses(&at)),
                "step {step}, door point {k}: a frustum is too narrow"
            );
        }
    }
    assert!(far_rooms > 10, "{far_rooms} rays pass both doors");
}

proptest! {
    /// A ray that passes two random portals in turn is inside what is seen through both.
    #[test]
    fn rays_through_two_portals_are_in_the_cone_of_both(
        eye in proptest::array::uniform3(-1.0..1.0f64),
        a in proptest::array::uniform8(-1.0..1.0f64),
        b in proptest::array::uniform8(-2.0..2.0f64),
        s in 0.0..1.0f64, t in 0.0..1.0f64, is_sun in any::<bool>(),
    ) {
        // Two convex polygons in the planes x = 2 and x = 4.
        let polygon = |x: f64, p: [f64; 8]| {
            Portal::outline_of(&[0, 1, 2, 3].map(|k| DVec3::new(x, p[2 * k], p[2 * k + 1])))
        };
        let (first, second) = (polygon(2.0, a), polygon(4.0, b));
        let eye = if is_sun { LightSource::sun([1.0, eye[1], eye[2]]) } else { LightSource::point(eye) }.expect("an eye");
        let inside = |polygon: &[DVec3]| {
            let along = polygon[0].lerp(polygon[1], s);
            along.lerp(polygon[2], t)
        };
        let through = inside(&first);
        let direction = if eye.is_sun() { -eye.xyz() } else { through - eye.xyz() };
        let target = through + direction * ((4.0 - through.x) / direction.x);
        // Strictly inside the second polygon?
        let turns: Vec<f64> = (0..second.len()).map(|k| {
            let (p, q) = (second[k], second[(k + 1) % second.len()]);
            (q - p).cross(target - p).x
        }).collect();
        let is_inside = turns.iter().all(|&turn| turn > 1e-9) || turns.iter().all(|&turn| turn < -1e-9);
        let seen = Frustum::everything(eye).through(&first).and_then(|frustum| frustum.through(&second));
        if is_inside {
            let seen = seen.expect("the ray passes both");
            let beyond = target + direction * 3.0;
            let point = Aabb { min: beyond, max: beyond };
            prop_assert!(!seen.misses(&point));
        } else if turns.iter().any(|&turn| turn > 1e-9) && turns.iter().any(|&turn| turn < -1e-9) && let Some(seen) = seen {
            // A point off the second polygon is outside its cone, as planes go.
            let beyond = target + direction * 3.0;
            let point = Aabb { min: beyond, max: beyond };
            prop_assert!(seen.misses(&point));
        }
    }
}
