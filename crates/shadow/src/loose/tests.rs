//! The filter against the exact predicate, and at every level of instructions.

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{
    Analytic, Cuboid, LightSource, Mesh, Placement, Point,
    blocking::{Probe, polygon_blocks},
    simd::{Level, dispatch_at},
};
use umbriel_scene::{Object, Scene, Shape, Sides};

use super::{grid::Grid, sorted::Buckets, *};
use crate::progress::Silent;

/// A ball of triangles over a floor of two, in numbers that no grid has.
fn scene() -> Scene {
    let (rings, sectors) = (12u32, 24u32);
    let mut positions: Vec<[f64; 3]> = Vec::new();
    for ring in 0..=rings {
        for sector in 0..sectors {
            let (a, b) = (f64::from(ring) / f64::from(rings) * 3.1, f64::from(sector) / f64::from(sectors) * 6.25);
            positions.push([libm::sin(a) * libm::cos(b), 1.3 + libm::cos(a), libm::sin(a) * libm::sin(b)]);
        }
    }
    let at = |ring: u32, sector: u32| ring * sectors + sector % sectors;
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for (ring, sector) in (0..rings).flat_map(|ring| (0..sectors).map(move |sector| (ring, sector))) {
        let [a, b, c, d] = [at(ring, sector), at(ring, sector + 1), at(ring + 1, sector + 1), at(ring + 1, sector)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let floor = positions.len() as u32;
    positions.extend([[-4.1, 0.0, -4.2], [4.3, 0.0, -4.1], [4.2, 0.01, 4.4], [-4.0, -0.02, 4.1]]);
    triangles.extend([[floor, floor + 1, floor + 2], [floor, floor + 2, floor + 3]]);
    let mesh = Mesh::new(positions, triangles).expect("a mesh");
    let object = Object::new("scene".into(), Shape::Mesh(mesh.into()), Placement::IDENTITY, Sides::Auto);
    Scene { objects: [object.expect("an object")].into(), ..Scene::default() }
}

fn lights() -> Vec<LightSource> {
    let sun = |x, y, z| LightSource::sun([x, y, z]).expect("a sun");
    let lamp = |x, y, z| LightSource::point([x, y, z]).expect("a lamp");
    vec![sun(0.3, -1.0, 0.2), sun(1.0, -0.01, 0.3), lamp(2.0, 4.0, 1.0), lamp(0.1, 1.2, 0.2), lamp(3.0, 0.5, -11.0)]
}

/// Points in rows, so that some lie together: on the floor, in the ball, in the air.
fn points() -> Vec<[f32; 3]> {
    let along = |k: u32, n: u32| f64::from(k) / f64::from(n) * 7.8 - 3.9;
    let rows = (0..40).flat_map(|row| (0..64).map(move |column| (row, column)));
    let place = |(row, column): (u32, u32)| {
        let height = [0.001, 0.7, 1.9, 3.0][(row % 4) as usize];
        [along(column, 64), height, along(row, 40)].map(|x| x as f32)
    };
    rows.map(place).collect()
}

#[test]
fn all_levels_say_the_same_and_what_is_certain_is_true() {
    let (scene, points) = (scene(), points());
    let queries = Queries::new(&scene);
    let pieces = Pieces::of(&queries.bodies).expect("few pieces");
    let size = Points::FreeSingle(&points).size();
    for light in lights() {
        let grids = Grids::of(&pieces, View::all(&light, &pieces.bounds), points.len(), None).expect("few cells");
        let run = |level| {
            let mut lit = vec![false; points.len()];
            let rows: &[[f32; 3]] = &points;
            let buckets = &mut Buckets::default();
            let filter = Filter { grids: &grids, rows, own: &[], slack: 0.0, size, lit: &mut lit, buckets };
            let doubtful = dispatch_at(level, filter);
            (lit, doubtful.iter().map(|doubt| doubt.index).collect::<Vec<_>>())
        };
        let (lit, doubtful) = run(Level::Scalar);
        for level in Level::ALL {
            assert_eq!(run(level), (lit.clone(), doubtful.clone()), "{level:?} under {light:?}");
        }
        assert!(doubtful.len() < points.len() / 100, "{} doubtful under {light:?}", doubtful.len());
        for (index, point) in points.iter().enumerate().filter(|(index, _)| !doubtful.contains(&(*index as u32))) {
            let probe: Probe = Probe::at(DVec3::from_array(point.map(f64::from)));
            let mut hint = 0;
            let is_blocked = (0..pieces.len()).any(|piece| match pieces.get(piece, &mut hint).0 {
                pieces::Piece::Triangle { corners, .. } => polygon_blocks(&corners.map(Point::exact), &probe, &light),
                pieces::Piece::CutOut(_) | pieces::Piece::Box(_) => false,
            });
            assert_eq!(lit[index], !is_blocked, "{point:?} under {light:?}");
        }
    }
}

#[test]
fn points_that_are_roughly_known_are_left_to_single_queries() {
    let scene = scene();
    let queries = Queries::new(&scene);
    let light = LightSource::point([0.5, 3.0, 0.25]).expect("a lamp");
    let far: Vec<[f32; 6]> = vec![[1e7, 0.0, 0.0, 0.0, 1.0, 0.0], [0.5, 3.0, 0.25, 0.0, 1.0, 0.0]];
    let lit = queries.lit_many(Points::OrientedSingle(&far), &light, &Silent).expect("points");
    let alone = |index| queries.lit(&Points::OrientedSingle(&far).place(index), &light).expect("a point").lit;
    assert_eq!(lit, [alone(0), alone(1)]);
}

/// More points than one part takes, neighbours together.
fn many_points() -> Vec<[f32; 3]> {
    let shifted = |copy: u8| points().into_iter().map(move |[x, y, z]| [x + 0.013 * f32::from(copy), y, z]);
    let points: Vec<[f32; 3]> = (0..5).flat_map(shifted).collect();
    assert!(points.len() > CHUNK);
    points
}

#[test]
fn the_order_of_points_does_not_matter() {
    let scene = scene();
    let queries = Queries::new(&scene);
    let straight = many_points();
    let count = straight.len();
    // The step is a prime that does not divide the count, so each place is met once.
    let place = |index: usize| index * 7919 % count;
    let strewn: Vec<[f32; 3]> = (0..count).map(|index| straight[place(index)]).collect();
    for light in lights() {
        let ask = |points: &[[f32; 3]]| queries.lit_many(Points::FreeSingle(points), &light, &Silent).expect("points");
        let (in_order, anyhow) = (ask(&straight), ask(&strewn));
        assert!((0..count).all(|index| anyhow[index] == in_order[place(index)]), "under {light:?}");
    }
}

#[test]
fn one_point_far_away_does_not_make_others_doubtful() {
    let scene = scene();
    let queries = Queries::new(&scene);
    let pieces = Pieces::of(&queries.bodies).expect("few pieces");
    let mut points = many_points();
    points[17] = [1e15, 0.0, 0.0];
    let light = lights()[0];
    let grids = Grids::of(&pieces, View::all(&light, &pieces.bounds), points.len(), None).expect("few cells");
    let mut lit = vec![false; points.len()];
    let part = Points::FreeSingle(&points);
    let at = LitScene { queries: &queries, pieces: &pieces, light: &light };
    let doubtful = queries.filter(at, &grids, part, part.size(), &mut lit, &mut Room::default()).expect("accepted");
    assert!(doubtful.len() < CHUNK, "{} of {}", doubtful.len(), points.len());
    let answers = queries.lit_many(Points::FreeSingle(&points), &light, &Silent).expect("points");
    let is_certain = |index: usize| doubtful.iter().all(|doubt| doubt.index as usize != index);
    assert!((0..points.len()).step_by(97).filter(|&index| is_certain(index)).all(|index| lit[index] == answers[index]));
}

/// The ball and floor again beside a box, a cylinder, and needles of a millimetre's width whose planes f32 cannot tell.
fn mixed_scene() -> Scene {
    let object = |name: &str, shape, translation: [f64; 3]| {
        let placement = Placement::new(DAffine3::from_rotation_translation(
            DQuat::from_xyzw(0.1, 0.2, 0.3, 0.9).normalize(),
            DVec3::from_array(translation),
        ))
        .expect("a placement");
        Object::new(name.into(), shape, placement, Sides::Two).expect("an object")
    };
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..24u32 {
        let (x, z) = (f64::from(k % 5) * 0.9 - 1.7, f64::from(k / 5) * 0.8 - 1.9);
        positions.extend([[x, 0.4, z], [x + 1.1, 2.3, z + 0.7], [x + 1.1, 2.3 + 1e-3, z + 0.7]]);
        triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    let needles = Mesh::new(positions, triangles).expect("a mesh");
    let mut scene = scene();
    scene.objects.extend([
        object("box", Shape::Cuboid(Cuboid { size: [0.8, 1.1, 0.5] }), [-2.0, 0.7, 1.5]),
        object("cylinder", Shape::from(Analytic::Cylinder { radius: 0.4, height: 1.2 }), [2.1, 0.9, -1.2]),
        object("needles", Shape::Mesh(needles.into()), [0.0, 0.1, 0.0]),
    ]);
    scene
}

/// Points of all faces, some of them on edges and at corners.
fn points_of_faces(scene: &Scene) -> Vec<FacePoint> {
    let mut points = Vec::new();
    for (object, body) in scene.objects.iter().enumerate() {
        for face in 0..body.face_count() {
            let share = |k: usize| ((face * 37 + k * 101) % 128) as f64 / 127.0;
            let (u, v) = (share(1), share(2));
            let is_triangle = matches!(body.shape, Shape::Mesh(_));
            let inside = if is_triangle && u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let places = [inside, (0.0, v), (0.0, 0.0), (0.3, 0.2), (1.0 / 3.0, 1.0 / 3.0)];
            points.extend(places.map(|(u, v)| FacePoint::new(object, face, u, v)));
        }
    }
    let queries = Queries::new(scene);
    points.retain(|&point| queries.surface_defect(point).is_none());
    points
}

#[test]
fn points_of_faces_are_answered_as_single_ones() {
    let scene = mixed_scene();
    let queries = Queries::new(&scene);
    let points = points_of_faces(&scene);
    assert!(points.len() > 2500, "{}", points.len());
    for light in lights() {
        let many = queries.lit_many(Points::OnFaces(&points), &light, &Silent).expect("points of faces");
        let mut lit = 0;
        for (point, many) in points.iter().zip(many) {
            assert_eq!(many, queries.lit(&point.place(), &light).expect("a point").lit, "{point:?} under {light:?}");
            lit += usize::from(many);
        }
        assert!(lit > 50 && lit < points.len() - 50, "{lit} of {} under {light:?}", points.len());
    }
}

#[test]
fn few_points_are_answered_as_single_ones_by_fewer_pieces() {
    let scene = mixed_scene();
    let queries = Queries::new(&scene);
    let pieces = Pieces::of(&queries.bodies).expect("few pieces");
    let of_faces: Vec<FacePoint> = points_of_faces(&scene).into_iter().step_by(61).collect();
    let in_space: Vec<[f32; 3]> = points().into_iter().step_by(67).collect();
    for light in lights() {
        for points in [Points::OnFaces(&of_faces), Points::FreeSingle(&in_space)] {
            let at = LitScene { queries: &queries, pieces: &pieces, light: &light };
            let few = match points {
                Points::OnFaces(points) => {
                    assert!(at.are_few(points));
                    let mut lit = vec![false; points.len()];
                    at.grids_before(&at.gathered(points, &mut lit, &Silent).expect("points of faces"))
                }
                _ => queries.grids(&pieces, points, &light),
            };
            let all = Grids::of(&pieces, View::all(&light, &pieces.bounds), points.len(), None);
            let count = |grids: Option<Grids>| grids.expect("few cells").grids.iter().map(Grid::listed).sum::<usize>();
            let (some, all) = (count(few), count(all));
            assert!(some < all * 9 / 10, "{some} of {all} are listed under {light:?}");
            let many = queries.lit_many(points, &light, &Silent).expect("points");
            for (index, many) in many.into_iter().enumerate() {
                let place = points.place(index);
                assert_eq!(many, queries.lit(&place, &light).expect("a point").lit, "{place:?} under {light:?}");
            }
        }
    }
}

#[test]
fn many_points_of_which_few_are_turned_to_the_light_are_answered_as_single_ones() {
    let mut scene = mixed_scene();
    let one_sided = |object: &Object| {
        let mut object = object.clone();
        object.sides = Sides::One;
        object
    };
    scene.objects = scene.objects.iter().map(one_sided).collect();
    let queries = Queries::new(&scene);
    let pieces = Pieces::of(&queries.bodies).expect("few pieces");
    let points = points_of_faces(&scene);
    for light in lights() {
        let lit = |point: &FacePoint| queries.lit(&point.place(), &light).expect("a point").lit;
        // Pictures of the dark sides, in which some faces catch the light.
        let mut places = 0;
        let is_wanted = |point: &&FacePoint| {
            places += 1;
            places % 23 == 0 || !lit(point)
        };
        let dark: Vec<FacePoint> = points.iter().filter(is_wanted).copied().collect();
        let picture: Vec<FacePoint> = (0..4).flat_map(|_| &dark).copied().collect();
        let at = LitScene { queries: &queries, pieces: &pieces, light: &light };
        assert!(at.are_few(&picture) && picture.len() > 8 * pieces.len() as usize, "under {light:?}");
        let many = queries.lit_many(Points::OnFaces(&picture), &light, &Silent).expect("points of faces");
        assert!(picture.iter().zip(&many).all(|(point, &many)| many == lit(point)), "under {light:?}");
        assert!(many.contains(&true), "under {light:?}");
        // The first that is refused, wherever it stands.
        for index in [picture.len() / 3, picture.len() - 1] {
            let mut refused = picture.clone();
            refused[index..].iter_mut().for_each(|point| point.u = -0.5);
            let answer = queries.lit_many(Points::OnFaces(&refused), &light, &Silent);
            assert_eq!(answer, Err(PointsError::Refused { index, defect: QueryDefect::OutsideFace }));
        }
    }
}

#[test]
fn few_points_of_many_pieces_make_jobs_of_their_own() {
    let one = scene();
    let at = |k: u32| DAffine3::from_translation(DVec3::new(f64::from(k % 8) * 2.25, 0.0, f64::from(k / 8) * 2.5));
    let copy = |k: u32| {
        let placement = Placement::new(at(k)).expect("a placement");
        Object::new(format!("{k}"), one.objects[0].shape.clone(), placement, Sides::Two).expect("an object")
    };
    let scene = Scene { objects: (0..40).map(copy).collect(), ..Scene::default() };
    let queries = Queries::new(&scene);
    let pieces = Pieces::of(&queries.bodies).expect("few pieces");
    let points: Vec<FacePoint> =
        points_of_faces(&scene).into_iter().enumerate().filter(|(k, _)| k % 4 == 1).map(|(_, point)| point).collect();
    for light in [lights()[0], lights()[2]] {
        let at = LitScene { queries: &queries, pieces: &pieces, light: &light };
        let parts = at.gathered(&points, &mut vec![false; points.len()], &Silent).expect("points of faces");
        assert!(at.are_few(&points) && parts.len() > 8, "{} parts under {light:?}", parts.len());
        let many = queries.lit_many(Points::OnFaces(&points), &light, &Silent).expect("points of faces");
        for (point, many) in points.iter().zip(many).step_by(7) {
            assert_eq!(many, queries.lit(&point.place(), &light).expect("a point").lit, "{point:?} under {light:?}");
        }
    }
}

/// The ball and floor where surveys have their buildings, thousands of kilometres from the origin; turned as well, no corner is a float.
fn surveyed(scene: &Scene, is_turned: bool) -> Scene {
    let offset = DVec3::new(684_000.5, 12.25, -5_335_000.25);
    let turn = if is_turned { DQuat::from_rotation_y(0.3) } else { DQuat::IDENTITY };
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { unreachable!("the ball is a mesh") };
    let moved = mesh.positions().iter().map(|&position| (position + offset).to_array()).collect();
    let (positions, placement) = if is_turned {
        let placed = DAffine3::from_rotation_translation(turn, offset);
        (mesh.positions().iter().map(|position| position.to_array()).collect(), Placement::new(placed))
    } else {
        (moved, Ok(Placement::IDENTITY))
    };
    let mesh = Mesh::new(positions, mesh.triangles().to_vec()).expect("a mesh");
    let placement = placement.expect("a placement");
    let object = Object::new("survey".into(), Shape::Mesh(mesh.into()), placement, Sides::Auto).expect("an object");
    Scene { objects: [object].into(), ..Scene::default() }
}

#[test]
fn few_points_of_faces_are_in_doubt_far_from_the_origin() {
    let near = scene();
    let faces = 0..near.objects[0].face_count();
    let points: Vec<FacePoint> =
        faces.flat_map(|face| [(0.3, 0.2), (0.2, 0.5)].map(|(u, v)| FacePoint::new(0, face, u, v))).collect();
    for scene in [&near, &surveyed(&near, false), &surveyed(&near, true)] {
        let queries = Queries::new(scene);
        let pieces = Pieces::of(&queries.bodies).expect("few pieces");
        let corner = scene.objects[0].bounds().max;
        let lamp = LightSource::point((corner + DVec3::ONE).to_array()).expect("a lamp");
        for light in [lights()[0], lights()[1], lamp] {
            let grids = Grids::of(&pieces, View::all(&light, &pieces.bounds), points.len(), None).expect("few cells");
            let mut lit = vec![false; points.len()];
            let part = Points::OnFaces(&points);
            let at = LitScene { queries: &queries, pieces: &pieces, light: &light };
            let doubtful =
                queries.filter(at, &grids, part, part.size(), &mut lit, &mut Room::default()).expect("accepted");
            assert!(doubtful.len() < points.len() / 50, "{} of {} under {light:?}", doubtful.len(), points.len());
        }
    }
}

#[test]
fn the_first_point_beside_its_face_is_refused() {
    let scene = mixed_scene();
    let queries = Queries::new(&scene);
    let light = lights()[0];
    let good = FacePoint { object: 0, face: 3, u: 0.25, v: 0.5 };
    let refused = [
        (FacePoint { v: 0.75 + f64::EPSILON, ..good }, QueryDefect::OutsideFace),
        (FacePoint { u: -0.1, ..good }, QueryDefect::OutsideFace),
        (FacePoint { v: f64::NAN, ..good }, QueryDefect::OutsideFace),
        (FacePoint { face: 1 << 20, ..good }, QueryDefect::NoFace),
        (FacePoint { object: 9, ..good }, QueryDefect::NoObject),
    ];
    // Of every kind of body; twice the greatest number is zero once more.
    let too_many = |object: usize| [scene.objects[object].face_count(), 1 << 31, usize::MAX].map(|face| (object, face));
    let no_faces = (0..scene.objects.len()).flat_map(too_many);
    let no_faces = no_faces.map(|(object, face)| (FacePoint::new(object, face, 0.25, 0.5), QueryDefect::NoFace));
    for (bad, defect) in refused.into_iter().chain(no_faces) {
        let points = [good, FacePoint { v: 0.75, ..good }, bad, bad];
        let answer = queries.lit_many(Points::OnFaces(&points), &light, &Silent);
        assert_eq!(answer, Err(PointsError::Refused { index: 2, defect }), "{bad:?}");
    }
}

/// Asks `lit_many` and single queries for the same points in space; how many are lit.
fn lit_of_points(scene: &Scene, points: &[[f64; 3]], light: &LightSource) -> usize {
    let queries = Queries::new(scene);
    let many = queries.lit_many(Points::FreeDouble(points), light, &Silent).expect("points");
    for (&position, &many) in points.iter().zip(&many) {
        let alone = queries.lit(&Place::Free { position }, light).expect("a point").lit;
        assert_eq!(many, alone, "{position:?} under {light:?}");
    }
    many.into_iter().filter(|&lit| lit).count()
}

#[test]
fn walls_that_are_seen_edge_on_and_curved_bodies_among_them() {
    let at = |name: &str, shape, x: f64, z: f64| {
        let placement = Placement::new(DAffine3::from_translation(DVec3::new(x, 0.5, z))).expect("a placement");
        Object::new(name.into(), shape, placement, Sides::Two).expect("an object")
    };
    // Boxes of different heights with cylinders numbered between them: eight pieces are seldom of one kind.
    let objects = (0..30).map(|k| {
        let (x, z) = (f64::from(k % 6) * 1.5, f64::from(k / 6) * 1.5);
        match k % 3 {
            0 => at("cylinder", Shape::from(Analytic::Cylinder { radius: 0.4, height: 0.75 }), x, z),
            _ => at("box", Shape::Cuboid(Cuboid { size: [1.0, 0.25 * f64::from(k % 5 + 1), 1.0] }), x, z),
        }
    });
    let scene = Scene { objects: objects.collect(), ..Scene::default() };
    // On the borders of shadows, beside them, within and above bodies.
    let along = |k: u32| f64::from(k) * 0.25 - 1.0;
    let points: Vec<[f64; 3]> =
        (0..40 * 32 * 3).map(|k| [along(k % 40), [-1.0, 0.5, 2.0][(k / 1280) as usize], along(k / 40 % 32)]).collect();
    let sun = |x, y, z| LightSource::sun([x, y, z]).expect("a sun");
    let lamp = LightSource::point([3.5, 4.0, 3.0]).expect("a lamp");
    for light in [sun(0.0, 1.0, 0.0), sun(1.0, 0.0, 0.0), sun(0.0, 1.0, 1.0), lamp] {
        let lit = lit_of_points(&scene, &points, &light);
        assert!(lit > points.len() / 8 && lit < points.len() * 7 / 8, "{lit} of {} under {light:?}", points.len());
    }
}

#[test]
fn a_crowd_in_one_tile() {
    // A floor a thousand times as wide as the leaves over its middle, in no order.
    let part = |k: u32, step: u32| f64::from(k * step % 4099) / 4099.0;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..4000u32 {
        let [x, y, z] = [part(k, 1657), part(k, 2221), part(k, 3023)];
        positions.extend([[x, y, z], [x + 0.02, y, z + 0.01], [x, y + 0.01, z + 0.02]]);
        triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    positions.extend([[-500.0, -1.0, -500.0], [500.0, -1.0, -500.0], [500.0, -1.0, 500.0], [-500.0, -1.0, 500.0]]);
    triangles.extend([[12000, 12001, 12002], [12000, 12002, 12003]]);
    let mesh = Mesh::new(positions, triangles).expect("a mesh");
    let object = Object::new("crowd".into(), Shape::Mesh(mesh.into()), Placement::IDENTITY, Sides::Auto);
    let scene = Scene { objects: [object.expect("an object")].into(), ..Scene::default() };
    let points: Vec<[f64; 3]> = (0..900).map(|k| [part(k, 811), part(k, 1277) - 0.5, part(k, 2609)]).collect();
    for light in lights() {
        let lit = lit_of_points(&scene, &points, &light);
        assert!(lit > 9 && lit < points.len() - 9, "{lit} of {} under {light:?}", points.len());
    }
}

#[test]
fn what_is_refused_is_found_wherever_it_stands() {
    let scene = scene();
    let queries = Queries::new(&scene);
    let rows = [[1.0f32, -7.5, 0.0, 0.0, -0.0, 1e-45]; 40];
    assert_eq!(Points::OrientedSingle(&rows).checked_size(&queries), Ok(7.5));
    for index in [0, 15, 16, 31, 32, 39] {
        let with = |columns: &[usize], number: f32| {
            let mut rows = rows;
            columns.iter().for_each(|&column| rows[index][column] = number);
            rows
        };
        for column in 0..6 {
            for number in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let rows = with(&[column], number);
                assert_eq!(Points::OrientedSingle(&rows).checked_size(&queries), Err(index), "{number} at {column}");
                let free = rows.map(|[x, y, z, ..]| [x, y, z]);
                assert_eq!(Points::FreeSingle(&free).checked_size(&queries).is_err(), column < 3);
            }
        }
        let flat = with(&[3, 4, 5], -0.0);
        assert_eq!(Points::OrientedSingle(&flat).checked_size(&queries), Err(index));
        let far = with(&[2], -1e38);
        assert_eq!(Points::OrientedSingle(&far).checked_size(&queries), Ok(f64::from(1e38f32)));
    }
}
