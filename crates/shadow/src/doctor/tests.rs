//! Scenes with known defects: counts and areas in closed form.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use umbriel_geometry::{Analytic, Cuboid, LightSource, Mesh, Placement, Rectangle, Sign};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};

use crate::{
    progress::Silent,
    test_bodies::{BOX, box_corners},
};

use super::*;

fn mesh(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Shape {
    Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")))
}

fn unit_box() -> Shape {
    mesh(box_corners([0.0; 3], 1.0), BOX.to_vec())
}

fn placed(name: &str, shape: Shape, map: DAffine3) -> Object {
    Object::new(name.to_owned(), shape, Placement::new(map).expect("regular"), Sides::Auto).expect("an object")
}

fn object(name: &str, shape: Shape) -> Object {
    placed(name, shape, DAffine3::IDENTITY)
}

fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

/// Kind, place's number, count and area of all findings, at a depth at which no face is too small.
fn found(objects: Vec<Object>, lights: &[LightSource]) -> Vec<(DefectKind, usize, usize, f64)> {
    let light = |(number, &source): (usize, &LightSource)| Light::new(number.to_string(), source);
    let scene =
        Scene { objects: objects.into(), lights: lights.iter().enumerate().map(light).collect(), ..Scene::default() };
    let chosen: Vec<usize> = (0..lights.len()).collect();
    let diagnosis = examine(&scene, &chosen, Detail::default(), &Silent).expect("not cancelled");
    let row = |defect: &Defect| {
        let (Place::Object(place) | Place::Light(place)) = defect.place;
        (defect.kind, place, defect.count, defect.area)
    };
    diagnosis.defects.iter().map(row).collect()
}

#[test]
fn a_sound_scene_has_no_findings() {
    let objects = vec![
        object("floor", Shape::Rectangle(Rectangle { size: [8.0, 8.0] })),
        placed("box", unit_box(), at(0.0, 0.5, 0.0)),
        placed("ball", Shape::from(Analytic::Sphere { radius: 1.0 }), at(3.0, 3.0, 3.0)),
    ];
    let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
    assert_eq!(found(objects, &[sun]), []);
}

#[test]
fn an_open_box_and_one_with_a_turned_face() {
    let open = mesh(box_corners([0.0; 3], 1.0), BOX[1..].to_vec());
    let mut turned = BOX.to_vec();
    turned[0].swap(0, 1);
    let turned = mesh(box_corners([0.0; 3], 1.0), turned);
    let objects = vec![object("open", open), placed("turned", turned, at(5.0, 0.0, 0.0))];
    let expected = [
        (DefectKind::OpenEdges, 0, 3, 5.5),
        (DefectKind::OpenEdges, 1, 3, 6.0),
        (DefectKind::InconsistentOrientation, 1, 3, 6.0),
    ];
    assert_eq!(found(objects, &[]), expected);
}

#[test]
fn two_boxes_on_one_edge_are_not_manifold_there() {
    let mut corners = box_corners([0.0; 3], 1.0);
    corners.extend(box_corners([1.0, 1.0, 0.0], 1.0));
    let mut triangles = BOX.to_vec();
    triangles.extend(BOX.map(|corners| corners.map(|corner| corner + 8)));
    // The edge has a side of two triangles on each of four squares, one triangle of each at the edge.
    assert_eq!(found(vec![object("both", mesh(corners, triangles))], &[]), [(DefectKind::NonManifoldEdges, 0, 1, 2.0)]);
}

#[test]
fn an_inverted_box_is_a_cavity_however_it_is_placed() {
    let inverted = || mesh(box_corners([0.0; 3], 1.0), BOX.map(|[a, b, c]| [a, c, b]).to_vec());
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let objects = vec![
        object("inverted", inverted()),
        placed("mirrored", inverted(), at(-3.0, 0.0, 0.0) * mirror),
        placed("far", unit_box(), at(9.0, 0.0, 0.0) * mirror),
    ];
    let expected = [(DefectKind::InsideOut, 0, 1, 6.0), (DefectKind::InsideOut, 1, 1, 6.0)];
    assert_eq!(found(objects, &[]), expected);
}

#[test]
fn doubled_and_flat_triangles() {
    let positions = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], [1.0, 0.0, 0.0], [9.0, 9.0, 9.0]];
    let triangles = vec![[0, 2, 1], [1, 0, 2], [0, 3, 1], [0, 2, 1]];
    let expected = [
        // The edge from 0 to 1 is cut by the flat triangle: 0-3, 3-1 once each.
        (DefectKind::DuplicateFaces, 0, 2, 4.0),
        (DefectKind::ZeroAreaFaces, 0, 1, 0.0),
        (DefectKind::UnreferencedVertices, 0, 1, 0.0),
    ];
    let found = found(vec![object("sheet", mesh(positions, triangles))], &[]);
    assert_eq!(found.iter().filter(|row| row.0 >= DefectKind::DuplicateFaces).copied().collect::<Vec<_>>(), expected);
    let empty = super::tests::found(vec![object("empty", mesh(vec![[0.0; 3]], Vec::new()))], &[]);
    assert_eq!(empty, [(DefectKind::NoSurface, 0, 1, 0.0), (DefectKind::UnreferencedVertices, 0, 1, 0.0)]);
}

#[test]
fn a_box_on_a_floor_is_in_contact_and_a_sheet_in_a_sheet_overlaps() {
    let rectangle = |size| Shape::Rectangle(Rectangle { size });
    let objects = vec![
        object("floor", rectangle([8.0, 8.0])),
        placed("box", Shape::Cuboid(Cuboid { size: [2.0, 1.0, 1.0] }), at(0.0, 0.5, 0.0)),
        // Half of it beyond the floor's border.
        placed("mat", rectangle([2.0, 1.0]), at(4.0, 0.0, 2.0)),
        // Neighbours in the plane that touch the floor from outside, along an edge and at a corner.
        placed("beside", rectangle([2.0, 2.0]), at(-5.0, 0.0, 0.0)),
        placed("corner", rectangle([2.0, 2.0]), at(-5.0, 0.0, -5.0)),
        placed("above", rectangle([8.0, 8.0]), at(0.0, 1e-50, 0.0)),
    ];
    let expected = [
        (DefectKind::CoplanarOverlap, 0, 1, 1.0),
        (DefectKind::CoplanarOverlap, 2, 1, 1.0),
        (DefectKind::Contact, 0, 1, 2.0),
        (DefectKind::Contact, 1, 1, 2.0),
    ];
    assert_eq!(found(objects, &[]), expected);
}

#[test]
fn turned_boxes_touch_exactly() {
    // Corners that no float hits: the common plane is known all the same.
    let turn = DAffine3::from_quat(DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize());
    let cube = || Shape::Cuboid(Cuboid { size: [2.0; 3] });
    let objects = vec![placed("a", cube(), turn), placed("b", Shape::Cuboid(Cuboid { size: [2.0, 2.0, 1.0] }), turn)];
    let found = found(objects, &[]);
    // Four sides of the flat box lie in sides of the cube, facing alike.
    let kinds: Vec<_> = found.iter().map(|&(kind, object, count, _)| (kind, object, count)).collect();
    assert_eq!(kinds, [(DefectKind::CoplanarOverlap, 0, 4), (DefectKind::CoplanarOverlap, 1, 4)]);
    assert!(found.iter().all(|row| (row.3 - 8.0).abs() < 1e-12), "{found:?}");
}

#[test]
fn a_normal_that_vanishes_modulo_the_prime_hides_nothing() {
    // 2^31·2^30 − 1·1 = 2^61 − 1: the normal of the large triangle is the prime.
    let large = vec![[0.0; 3], [2_147_483_648.0, 1.0, 0.0], [1.0, 1_073_741_824.0, 0.0]];
    let small = vec![[100.0, 100.0, 0.0], [104.0, 100.0, 0.0], [100.0, 104.0, 0.0]];
    let off = small.iter().map(|&[x, y, _]| [x, y, 1e-40]).collect();
    let sheet = |corners| mesh(corners, vec![[0, 1, 2]]);
    let objects = vec![object("large", sheet(large)), object("small", sheet(small)), object("off", sheet(off))];
    let overlaps = found(objects, &[]).into_iter().filter(|row| row.0 == DefectKind::CoplanarOverlap);
    let overlaps: Vec<_> = overlaps.map(|row| (row.1, row.2, row.3)).collect();
    assert_eq!((overlaps[0].0, overlaps[1]), (0, (1, 1, 8.0)));
    assert_eq!(overlaps.len(), 2);
}

#[test]
fn a_grid_overlaps_nothing_but_its_copy() {
    const EDGE: u32 = 20;
    let vertex = |k: u32| [f64::from(k % (EDGE + 1)) * 0.1, 0.7, f64::from(k / (EDGE + 1)) * 0.1];
    let positions: Vec<[f64; 3]> = (0..(EDGE + 1) * (EDGE + 1)).map(vertex).collect();
    let square = |k: u32| {
        let corner = k / EDGE * (EDGE + 1) + k % EDGE;
        [[corner, corner + EDGE + 1, corner + 1], [corner + 1, corner + EDGE + 1, corner + EDGE + 2]]
    };
    let triangles: Vec<[u32; 3]> = (0..EDGE * EDGE).flat_map(square).collect();
    let grid = || mesh(positions.clone(), triangles.clone());
    let overlaps = |objects| {
        let found = found(objects, &[]);
        found
            .into_iter()
            .filter(|row| row.0 == DefectKind::CoplanarOverlap)
            .map(|row| (row.2, row.3))
            .collect::<Vec<_>>()
    };
    assert_eq!(overlaps(vec![object("grid", grid())]), []);
    let twice = overlaps(vec![object("grid", grid()), object("copy", grid())]);
    assert_eq!(twice.len(), 2);
    assert!(twice.iter().all(|&(count, area)| count == 800 && (area - 4.0).abs() < 1e-12), "{twice:?}");
}

#[test]
fn of_copies_the_same_is_found_as_of_bodies_whose_triangles_are_listed_otherwise() {
    // A box, one of its sides twice, once more turned round; a sliver that lies in another side, and a half box on top.
    let mut triangles = BOX.to_vec();
    triangles.extend([[0, 2, 1], [1, 2, 0], [0, 1, 1]]);
    let turned = |turns: usize| {
        let mut triangles = triangles.clone();
        triangles.iter_mut().for_each(|corners| corners.rotate_left(turns));
        mesh(box_corners([0.0; 3], 1.0), triangles)
    };
    let half = || Shape::Cuboid(Cuboid { size: [1.0, 1.0, 0.5] });
    let sheet = || mesh(vec![[0.0, 0.0, 0.2], [0.0, 0.0, 0.8], [0.0, 1.0, 0.5]], vec![[0, 1, 2]]);
    let bodies = |turns: [usize; 3]| {
        let mut objects: Vec<Object> = turns.map(|turns| object("box", turned(turns))).into();
        objects.insert(1, object("sheet", sheet()));
        objects.push(placed("half", half(), at(0.5, 1.5, 0.25)));
        objects
    };
    let lights =
        [LightSource::sun([1.0, -2.0, 0.0]).expect("a sun"), LightSource::sun([0.0, -1.0, 0.0]).expect("a sun")];
    let rows = |objects: Vec<Object>| {
        let round = |area: f64| (area * 1e9).round() as i64;
        found(objects, &lights)
            .into_iter()
            .map(|(kind, place, count, area)| (kind, place, count, round(area)))
            .collect::<Vec<_>>()
    };
    let copies = rows(bodies([0; 3]));
    assert_eq!(copies, rows(bodies([0, 1, 2])));
    assert!(copies.iter().any(|row| row.0 == DefectKind::CoplanarOverlap && row.1 == 0 && row.2 == 14), "{copies:?}");
    // Of copies with other sides it may be otherwise: the light comes from behind.
    let from_behind = LightSource::sun([-1.0, 0.0, 0.0]).expect("a sun");
    let one = |sides| Object::new("sheet".to_owned(), sheet(), Placement::IDENTITY, sides).expect("an object");
    let sheets = |both: [Sides; 2]| both.map(one).to_vec();
    let is_dark = |both| found(sheets(both), &[from_behind]).iter().any(|row| row.0 == DefectKind::NothingTurned);
    assert!(is_dark([Sides::One; 2]) && !is_dark([Sides::One, Sides::Two]));
}

#[test]
fn each_of_repeated_faces_covers_and_is_covered() {
    let corners = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    // Three times, and once turned round.
    let triangles = vec![[0, 1, 2], [1, 2, 0], [0, 1, 2], [2, 1, 0]];
    let floor = || object("floor", Shape::Rectangle(Rectangle { size: [8.0, 8.0] }));
    let overlaps = |objects| -> Vec<_> {
        found(objects, &[])
            .into_iter()
            .filter(|row| row.0 == DefectKind::CoplanarOverlap)
            .map(|row| (row.1, row.2, row.3))
            .collect()
    };
    let sheet = || object("sheet", mesh(corners.clone(), triangles.clone()));
    assert_eq!(overlaps(vec![sheet()]), []);
    assert_eq!(overlaps(vec![floor(), sheet()]), [(0, 1, 2.0), (1, 4, 2.0)]);
    assert_eq!(overlaps(vec![floor(), sheet(), sheet()]), [(0, 1, 4.0), (1, 4, 2.0), (2, 4, 2.0)]);
}

#[test]
fn lamps_in_bodies_on_faces_and_suns_that_light_nothing() {
    let point = |x, y, z| LightSource::point([x, y, z]).expect("a lamp");
    let sun = |x, y, z| LightSource::sun([x, y, z]).expect("a sun");
    let cube = || vec![object("cube", Shape::Cuboid(Cuboid { size: [2.0; 3] }))];
    let row = |kind, count, area| vec![(kind, 0, count, area)];
    let inside = found(cube(), &[point(0.5, 0.25, 0.125)]);
    assert_eq!(inside, [(DefectKind::LampInsideBody, 0, 1, 24.0), (DefectKind::NothingTurned, 0, 1, 24.0)]);
    assert_eq!(found(cube(), &[point(0.5, 2.5, 0.125)]), [], "outside");
    let edge_on = (DefectKind::EdgeOnFaces, 0, 1, 4.0);
    let on_top = found(cube(), &[point(0.5, 1.0, 0.125)]);
    assert_eq!(on_top[..2], [(DefectKind::LampOnSurface, 0, 1, 4.0), edge_on]);
    assert_eq!(found(cube(), &[point(0.5, 1.0, 5.0)]), [edge_on], "beside the top, in its plane");
    assert_eq!(found(cube(), &[sun(0.0, -1.0, 0.0)]), row(DefectKind::EdgeOnFaces, 4, 16.0));
    assert_eq!(found(cube(), &[sun(0.5, 1.0, 0.25)]), row(DefectKind::SunBelowHorizon, 1, 24.0));
    let ball = vec![object("ball", Shape::from(Analytic::Sphere { radius: 1.0 }))];
    assert_eq!(found(ball, &[sun(0.0, -1.0, 0.0)]), []);
}

#[test]
fn lamps_an_ulp_beside_a_turned_face_are_on_the_side_where_they_are() {
    let turn = DQuat::from_xyzw(0.3, -0.5, 0.2, 0.8).normalize();
    let map = DAffine3::from_rotation_translation(turn, DVec3::new(0.3, -0.7, 1.9));
    let cube = || placed("cube", unit_box(), map);
    let facets = cube().facets().expect("faces");
    let mut inside = 0;
    for number in 0..1200u32 {
        let face = number as usize % facets.len();
        let corners = facets.facet(face).corners().to_vec();
        let [a, b, c] = [0, 1, 2].map(|k| facets.positions()[corners[k] as usize]);
        // Well within the triangle, so that no other face is near.
        let share = |step: f64| 0.15 + 0.3 * (f64::from(number) * step).fract();
        let mut at = (a + (b - a) * share(0.618_034) + (c - a) * share(0.414_214)).to_array();
        for (axis, x) in at.iter_mut().enumerate() {
            *x = f64::from_bits(x.to_bits() + u64::from(number >> axis & 3)).next_down().next_down();
        }
        let lamp = LightSource::point(at).expect("a lamp");
        let is_behind = match facets.light_side(face, &lamp) {
            Sign::Zero => continue,
            side => side == Sign::Negative,
        };
        let told = found(vec![cube()], &[lamp]).iter().any(|row| row.0 == DefectKind::LampInsideBody);
        assert_eq!(told, is_behind, "lamp {number} at {at:?}");
        inside += u32::from(is_behind);
    }
    assert!((300..900).contains(&inside), "{inside} inside");
}

#[test]
fn a_lamp_in_a_cavity_lights_its_walls() {
    // A shell: a box from −1 to 2 around a cavity from 0 to 1.
    let mut corners = box_corners([0.0; 3], 1.0);
    corners.extend(box_corners([-1.0; 3], 3.0));
    let mut triangles = BOX.map(|[a, b, c]| [a, c, b]).to_vec();
    triangles.extend(BOX.map(|corners| corners.map(|corner| corner + 8)));
    let shell = || vec![object("shell", mesh(corners.clone(), triangles.clone()))];
    let lamp = |x| [LightSource::point([x, 0.4, 0.3]).expect("a lamp")];
    let cavity = (DefectKind::InsideOut, 0, 1, 6.0);
    assert_eq!(found(shell(), &lamp(0.5)), [cavity]);
    let walled_in = found(shell(), &lamp(-0.5));
    assert_eq!(walled_in[..2], [cavity, (DefectKind::LampInsideBody, 0, 1, 54.0)]);
}

#[test]
fn coordinates_in_single_precision_far_from_the_origin() {
    let far = |x: f64| f64::from((x + 85_000.0) as f32);
    let corners: Vec<[f64; 3]> =
        box_corners([0.3; 3], 1.0).iter().map(|c| [far(c[0]), c[1] as f32 as f64, c[2] as f32 as f64]).collect();
    let scene = Scene { objects: [object("box", mesh(corners, BOX.to_vec()))].into(), ..Scene::default() };
    let diagnosis = examine(&scene, &[], Detail::default(), &Silent).expect("not cancelled");
    assert_eq!(diagnosis.defects.len(), 1, "{diagnosis:?}");
    assert_eq!((diagnosis.defects[0].kind, diagnosis.defects[0].count), (DefectKind::CoarseCoordinates, 12));
    // Between 2^16 and 2^17 the step is 2^-7.
    assert_eq!(diagnosis.defects[0].note, Some(Note::Rounding(0.00390625)));
}

#[test]
fn small_faces_say_which_depth_divides_them() {
    // Half a square of edge 64, and 256 halves of unit squares: 2048 m² and 128 m².
    let floor = vec![[0.0; 3], [0.0, 0.0, 64.0], [64.0, 0.0, 0.0]];
    let mut positions = floor;
    let mut triangles = vec![[0, 1, 2]];
    for k in 0..256_u32 {
        let first = positions.len() as u32;
        let (x, z) = (100.0 + 2.0 * f64::from(k % 16), 2.0 * f64::from(k / 16));
        positions.extend([[x, 0.0, z], [x, 0.0, z + 1.0], [x + 1.0, 0.0, z]]);
        triangles.push([first, first + 1, first + 2]);
    }
    let scene = Scene { objects: [object("mesh", mesh(positions, triangles))].into(), ..Scene::default() };
    let at_depth = |boundary| {
        let detail = Detail::Depth { interior: 0, boundary };
        examine(&scene, &[], detail, &Silent).expect("not cancelled").defects
    };
    // The cube has edge 131 and the small triangles reach √2: 131/2^6 > √2 ≥ 131/2^7.
    let coarse: Vec<_> = at_depth(4).into_iter().filter(|defect| defect.kind == DefectKind::SmallFaces).collect();
    assert_eq!((coarse[0].count, coarse[0].area, coarse[0].note), (256, 128.0, Some(Note::Depth(7))));
    assert!(at_depth(7).iter().all(|defect| defect.kind != DefectKind::SmallFaces));
    assert!(at_depth(6).iter().any(|defect| defect.kind == DefectKind::SmallComponents && defect.count == 256));
}

#[test]
fn slivers_and_totals() {
    let needle = mesh(vec![[0.0; 3], [1000.0, 0.0, 0.0], [500.0, 0.0, -1.0 / 128.0]], vec![[0, 1, 2]]);
    let scene = Scene { objects: [object("needle", needle), object("box", unit_box())].into(), ..Scene::default() };
    let diagnosis = examine(&scene, &[], Detail::default(), &Silent).expect("not cancelled");
    let totals = diagnosis.totals();
    let sliver = totals.iter().find(|total| total.kind == DefectKind::Slivers).expect("a sliver");
    assert_eq!((sliver.count, &*sliver.places), (1, &[Place::Object(0)][..]));
    assert!((sliver.share - 3.90625 / 9.90625).abs() < 1e-9 && (diagnosis.area - 9.90625).abs() < 1e-9);
    assert!(diagnosis.defects.iter().all(|defect| defect.share == 1.0), "each concerns all of its object");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Rectangles on a lattice overlap by products of intervals, whatever their order and wherever the plane is.
    #[test]
    fn lattice_rectangles_overlap_by_intervals(
        rows in proptest::collection::vec((-6i32..6, -6i32..6, 1i32..5, 1i32..5, 0i32..2), 2..14), power in -30i32..30,
    ) {
        let unit = f64::powi(2.0, power);
        // Even sizes, so that halves are whole: [x − w, x + w] × [z − d, z + d].
        let sheet = |&(x, z, w, d, level): &(i32, i32, i32, i32, i32)| {
            let size = [2.0 * f64::from(w) * unit, 2.0 * f64::from(d) * unit];
            let [x, y, z] = [x, level, z].map(|n| f64::from(n) * unit);
            placed("sheet", Shape::Rectangle(Rectangle { size }), at(x, y, z))
        };
        let mut expected = Vec::new();
        for (i, a) in rows.iter().enumerate() {
            let side = |p: i32, r: i32, q: i32, s: i32| ((p + r).min(q + s) - (p - r).max(q - s)).max(0);
            let others = rows.iter().enumerate().filter(|&(j, b)| i != j && a.4 == b.4);
            let shared = others.map(|(_, b)| side(a.0, a.2, b.0, b.2) * side(a.1, a.3, b.1, b.3)).sum::<i32>();
            if shared > 0 {
                expected.push((DefectKind::CoplanarOverlap, i, 1, f64::from(shared.min(4 * a.2 * a.3)) * unit * unit));
            }
        }
        let found = found(rows.iter().map(sheet).collect(), &[]);
        prop_assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            prop_assert_eq!((found.0, found.1, found.2), (expected.0, expected.1, expected.2));
            prop_assert!((found.3 - expected.3).abs() <= 1e-9 * expected.3);
        }
    }
}

#[test]
fn a_floor_under_thousands_of_tiles_is_compared_with_all() {
    let tile = |k: u32| {
        let map = at(f64::from(k % 60) - 29.5, 0.0, f64::from(k / 60) - 24.5);
        placed("tile", Shape::Rectangle(Rectangle { size: [0.5; 2] }), map)
    };
    let floor = object("floor", Shape::Rectangle(Rectangle { size: [64.0; 2] }));
    let tiles: Vec<Object> = (0..3000).map(tile).collect();
    let areas = |objects: Vec<Object>| {
        let found = found(objects, &[]);
        assert!(found.iter().all(|defect| defect.0 == DefectKind::CoplanarOverlap), "{:?}", found[0]);
        // What is clipped out of the floor is rounded.
        found.iter().map(|defect| (defect.3 * 1e9).round() / 1e9).collect::<Vec<f64>>()
    };
    assert_eq!(areas([vec![floor.clone()], tiles.clone()].concat()), [vec![750.0], vec![0.25; 3000]].concat());
    assert_eq!(areas([tiles, vec![floor]].concat()), [vec![0.25; 3000], vec![750.0]].concat());
}

#[test]
fn copies_without_number_do_not_crowd_a_plane() {
    let sheets = (0..2100).map(|_| object("sheet", Shape::Rectangle(Rectangle { size: [2.0, 1.0] }))).collect();
    let overlaps: Vec<_> = (0..2100).map(|sheet| (DefectKind::CoplanarOverlap, sheet, 1, 2.0)).collect();
    assert_eq!(found(sheets, &[]), overlaps);
}

#[test]
fn a_crowded_plane_is_told_and_compared_in_part() {
    let width = |k: u32| 1.0 + f64::from(k) / 4096.0;
    let sheet = |k| object("sheet", Shape::Rectangle(Rectangle { size: [2.0, width(k)] }));
    let found = found((0..2100).map(sheet).collect(), &[]);
    let expected: Vec<f64> = (0..2100).map(|k| 2.0 * width(k)).collect();
    for kind in [DefectKind::CoplanarOverlap, DefectKind::CrowdedPlane] {
        let areas: Vec<f64> = found.iter().filter(|defect| defect.0 == kind).map(|defect| defect.3).collect();
        assert_eq!(areas, expected, "{kind:?}");
    }
}
