//! With half of the faces the answers are those of single queries, which look at all: on solids of cubes, as they are and with their corners moved.

use std::{cell::Cell, sync::Arc};

use glam::{DAffine3, DVec3};
use proptest::{prelude::*, test_runner::TestRunner};
use umbriel_geometry::{Convex, LightSource, Mesh, Placement};
use umbriel_scene::{Object, Scene, Shape, Sides};

use crate::{
    FacePoint, Points, Queries, Silent,
    loose::{pieces::Pieces, turned::Turned},
};

/// Cubes along a side.
const SIDE: usize = 3;

/// The corners of a cube's six sides, counter-clockwise seen from outside.
const SIDES: [([i32; 3], [[usize; 3]; 4]); 6] = [
    ([1, 0, 0], [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]]),
    ([-1, 0, 0], [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]]),
    ([0, 1, 0], [[0, 1, 0], [0, 1, 1], [1, 1, 1], [1, 1, 0]]),
    ([0, -1, 0], [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]),
    ([0, 0, 1], [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]),
    ([0, 0, -1], [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]]),
];

/// What bounds the cubes whose bits are set, each corner moved.
fn solid(cubes: u32, offset: [f64; 3], moved: &[f64], is_turned: bool) -> Option<Mesh> {
    let is_there = |at: [i32; 3]| {
        at.iter().all(|x| (0..SIDE as i32).contains(x))
            && cubes >> (at[0] as usize + SIDE * (at[1] as usize + SIDE * at[2] as usize)) & 1 == 1
    };
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for at in (0..SIDE.pow(3)).map(|k| [k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE]) {
        if !is_there(at.map(|x| x as i32)) {
            continue;
        }
        for (normal, corners) in SIDES {
            if is_there([0, 1, 2].map(|k| at[k] as i32 + normal[k])) {
                continue;
            }
            let first = positions.len() as u32;
            positions.extend(corners.map(|corner| {
                [0, 1, 2].map(|k| {
                    let place = [0, 1, 2].map(|k| at[k] + corner[k]);
                    let number = k + 3 * (place[0] + 4 * (place[1] + 4 * place[2]));
                    place[k] as f64 + offset[k] + moved.get(number % moved.len().max(1)).copied().unwrap_or_default()
                })
            }));
            triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    if is_turned {
        triangles.iter_mut().for_each(|triangle: &mut [u32; 3]| triangle.swap(1, 2));
    }
    (!triangles.is_empty()).then(|| Mesh::new(positions, triangles).expect("a mesh"))
}

#[derive(Clone, Debug)]
struct Body {
    cubes: u32,
    offset: [i32; 3],
    moved: Vec<f64>,
    is_turned: bool,
    is_mirrored: bool,
    sides: Sides,
}

fn body() -> impl Strategy<Value = Body> {
    // A walk makes what hangs together; anything, what meets itself.
    let walk = prop::collection::vec((0..3usize, any::<bool>()), 1..9).prop_map(|steps| {
        let (mut at, mut cubes) = ([1; 3], 1 << 13);
        for (axis, is_up) in steps {
            at[axis] = if is_up { (at[axis] + 1).min(SIDE - 1) } else { at[axis].max(1) - 1 };
            cubes |= 1 << (at[0] + SIDE * (at[1] + SIDE * at[2]));
        }
        cubes
    });
    let cubes = prop_oneof![3 => walk, 1 => any::<u32>()];
    let moved = prop_oneof![Just(Vec::new()), prop::collection::vec(-0.3..0.3, 192)];
    let sides = prop_oneof![4 => Just(Sides::Auto), 1 => Just(Sides::One), 1 => Just(Sides::Two)];
    let offset = prop::array::uniform3(-6..7);
    (cubes, offset, moved, prop::bool::weighted(0.2), prop::bool::weighted(0.2), sides).prop_map(
        |(cubes, offset, moved, is_turned, is_mirrored, sides)| Body {
            cubes,
            offset,
            moved,
            is_turned,
            is_mirrored,
            sides,
        },
    )
}

fn light() -> impl Strategy<Value = LightSource> {
    let even = || prop::array::uniform3(-4..8).prop_map(|x| x.map(f64::from));
    let uneven = || prop::array::uniform3(-4.0..8.0);
    let sun =
        prop_oneof![prop::array::uniform3(-1..2).prop_map(|x| x.map(f64::from)), prop::array::uniform3(-1.0..1.0)];
    prop_oneof![
        sun.prop_filter_map("a direction", |direction| LightSource::sun(direction).ok()),
        prop_oneof![even(), uneven()].prop_map(|place| LightSource::point(place).expect("a lamp")),
    ]
}

fn scene(bodies: &[Body]) -> Scene {
    let object = |(number, body): (usize, &Body)| {
        let mesh = solid(body.cubes, body.offset.map(f64::from), &body.moved, body.is_turned)?;
        let scale = DVec3::new(if body.is_mirrored { -1.0 } else { 1.0 }, 1.0, 1.0);
        let placement = Placement::new(DAffine3::from_scale(scale)).expect("a placement");
        Object::new(number.to_string(), Shape::Mesh(mesh.into()), placement, body.sides).ok()
    };
    Scene { objects: bodies.iter().enumerate().filter_map(object).collect::<Vec<_>>().into(), ..Scene::default() }
}

/// So many on each face: corners and places on edges first, then others all over it.
fn on_faces(scene: &Scene, count: usize) -> Vec<FacePoint> {
    let places = [[0.0, 0.0], [0.25, 0.5], [0.5, 0.5], [1.0, 0.0], [0.25, 0.25], [0.0, 1.0], [0.5, 0.0], [0.125, 0.75]];
    let place = |k: usize| match places.get(k) {
        Some(&place) => place,
        None => {
            let [u, v] = [0.754_877_666, 0.569_840_29].map(|step| (k as f64 * step).fract());
            if u + v < 1.0 { [u, v] } else { [1.0 - u, 1.0 - v] }
        }
    };
    let objects = scene.objects.iter().enumerate();
    let faces = objects.flat_map(|(object, body)| (0..body.face_count()).map(move |face| (object, face)));
    let points = faces.flat_map(|(object, face)| {
        (0..count).map(move |k| {
            let [u, v] = place((k + 3 * face) % count.max(places.len()));
            FacePoint::new(object, face, u, v)
        })
    });
    points.collect()
}

#[test]
fn with_half_of_the_faces_points_have_the_answers_of_all() {
    let (entered, left) = (Cell::new(0), Cell::new(0));
    let strategy = (
        prop::collection::vec(body(), 1..4),
        light(),
        prop_oneof![6 => 1..9usize, 1 => 20..60usize],
        prop::collection::vec(prop::array::uniform3(-4.0..8.0), 200),
    );
    let config = ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() };
    TestRunner::new(config)
        .run(&strategy, |(bodies, light, count, free)| {
            let scene = scene(&bodies);
            let (plain, mut queries) = (Queries::new(&scene), Queries::new(&scene));
            queries.find_solids();
            let points = on_faces(&scene, count);
            let lit = queries.lit_many(Points::OnFaces(&points), &light, &Silent).expect("points");
            for (point, lit) in points.iter().zip(lit) {
                prop_assert_eq!(lit, plain.lit(&point.place(), &light).expect("a point").lit, "{:?}", point);
            }
            let lit = queries.lit_many(Points::FreeDouble(&free), &light, &Silent).expect("points");
            for (index, lit) in lit.into_iter().enumerate() {
                let place = Points::FreeDouble(&free).place(index);
                prop_assert_eq!(lit, plain.lit(&place, &light).expect("a point").lit, "{:?}", place);
            }
            let mut pieces = Pieces::of(&queries.bodies).expect("few pieces");
            pieces.leave_out(&queries, &light, true);
            let turned = |object: usize| pieces.turned(object);
            let of = |is_entered| {
                (0..scene.objects.len())
                    .filter_map(turned)
                    .filter(|turned: &&Turned| turned.is_entered == is_entered)
                    .count()
            };
            entered.set(entered.get() + of(true));
            left.set(left.get() + of(false));
            Ok(())
        })
        .expect("the same answers");
    let (entered, left) = (entered.get(), left.get());
    assert!(entered > 50 && left > 50, "{entered} entered, {left} left");
}

#[test]
fn instances_and_hulls_are_solids_each_for_itself() {
    let mesh = Arc::new(solid(0b1_0111, [0.0; 3], &[0.25, -0.125, 0.0], false).expect("a solid"));
    let at = |x: f64| Placement::new(DAffine3::from_translation(DVec3::new(x, 0.5, 0.0))).expect("a placement");
    let object =
        |name: &str, shape: Shape, x: f64| Object::new(name.into(), shape, at(x), Sides::Auto).expect("an object");
    let hull = Convex::new((0..8).map(|k| [0, 1, 2].map(|axis| f64::from(k >> axis & 1))).collect()).expect("a hull");
    let instance = || Shape::Mesh(Arc::clone(&mesh));
    let objects = vec![
        object("one", instance(), 0.0),
        object("two", instance(), 7.0),
        object("hull", Shape::Convex(hull.into()), -7.0),
        object("touching", instance(), 9.5),
    ];
    let scene = Scene { objects: objects.into(), ..Scene::default() };
    let mut queries = Queries::new(&scene);
    queries.find_solids();
    let points = on_faces(&scene, 30);
    for light in [LightSource::sun([3.0, -1.0, 0.25]), LightSource::point([8.0, 2.0, 1.5])] {
        let light = light.expect("a light");
        let mut pieces = Pieces::of(&queries.bodies).expect("few pieces");
        pieces.leave_out(&queries, &light, true);
        let entered: Vec<Option<bool>> =
            (0..4).map(|object| pieces.turned(object).map(|turned| turned.is_entered)).collect();
        assert_eq!([entered[0], entered[2]], [Some(true); 2]);
        assert_ne!(entered[1], Some(true), "another box meets its own");
        let lit = queries.lit_many(Points::OnFaces(&points), &light, &Silent).expect("points");
        for (point, lit) in points.iter().zip(lit) {
            assert_eq!(lit, queries.lit(&point.place(), &light).expect("a point").lit, "{point:?} under {light:?}");
        }
    }
}
