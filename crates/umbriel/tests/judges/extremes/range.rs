//! The accepted range: its ends are accepted and answered; one step beyond, NaN and infinity are refused by their place.

use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::{
    Analytic, AnalyticDefect, Convex, HullDefect, LightDefect, LightSource, MAX_MAGNITUDE, MIN_MAGNITUDE, Mesh,
    MeshDefect, NumberDefect, Placement, PlacementDefect,
};
use umbriel_scene::{Object, ObjectDefect, Shape, Sides};
use umbriel_shadow::{Place, Precision, Queries, QueryDefect};

use super::{judge, judge_answers, lamp, sun};
use crate::oracle::fixtures::{analytic, at, cuboid, mesh, object, rectangle, scene, sphere};

/// Numbers that are refused, and why.
fn refused() -> [(f64, NumberDefect); 6] {
    [
        (f64::NAN, NumberDefect::NotFinite),
        (f64::INFINITY, NumberDefect::NotFinite),
        (f64::NEG_INFINITY, NumberDefect::NotFinite),
        (MAX_MAGNITUDE.next_up(), NumberDefect::TooLarge),
        (-MIN_MAGNITUDE.next_down(), NumberDefect::TooSmall),
        (5e-324, NumberDefect::TooSmall),
    ]
}

#[test]
fn what_is_refused_is_named() {
    for (number, defect) in refused() {
        let mut positions = vec![[0.0; 3]; 5];
        positions[3][2] = number;
        let found = Mesh::new(positions, vec![[0, 1, 2]]).err();
        assert_eq!(found, Some(MeshDefect::Coordinate { vertex: 3, axis: 2, defect }), "{number}");
        assert_eq!(LightSource::point([0.0, number, 0.0]).err(), Some(LightDefect::Coordinate(1, defect)));
        assert_eq!(LightSource::sun([1.0, 1.0, number]).err(), Some(LightDefect::Coordinate(2, defect)));
        let map = |column: usize, row: usize| {
            let mut entries = DAffine3::IDENTITY.to_cols_array();
            entries[3 * column + row] = number;
            Placement::new(DAffine3::from_cols_array(&entries))
        };
        for (column, row) in [(0, 1), (2, 2), (3, 0)] {
            assert_eq!(map(column, row).err(), Some(PlacementDefect::Entry { column, row, defect }), "{number}");
        }
        let whole = |shape| Object::new("o".into(), shape, Placement::IDENTITY, Sides::Auto).err();
        assert_eq!(
            whole(sphere(number)),
            Some(ObjectDefect::Analytic(AnalyticDefect::Size { name: "radius" })),
            "{number}"
        );
        assert_eq!(whole(cuboid(1.0, number, 1.0)), Some(ObjectDefect::Size { number: 1 }), "{number}");
        assert_eq!(whole(rectangle(number, 1.0)), Some(ObjectDefect::Size { number: 0 }), "{number}");
        let quadric = |row: usize, column: usize| {
            let mut matrix = [[0.0; 4]; 4];
            (matrix[0][0], matrix[row][column]) = (1.0, number);
            Shape::from(Analytic::Quadric { matrix, within: [[-1.0; 3], [1.0; 3]] })
        };
        let entry = AnalyticDefect::Entry { row: 2, column: 3 };
        assert_eq!(whole(quadric(2, 3)), Some(ObjectDefect::Analytic(entry)), "{number}");
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, number]];
        let hull = Convex::new(points).err();
        assert!(matches!(hull, Some(HullDefect::Coordinate { point: 3, axis: 2, .. })), "{number}: {hull:?}");
    }
    assert_eq!(LightSource::sun([0.0, -0.0, 0.0]).err(), Some(LightDefect::NoDirection));
}

#[test]
fn what_a_placement_moves_out_of_the_range_is_named() {
    let far = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, MAX_MAGNITUDE, 0.0]];
    let placement = Placement::new(DAffine3::from_scale(DVec3::splat(1.0 + f64::EPSILON))).expect("regular");
    let found = Object::new("o".into(), mesh(&far, &[[0, 1, 2]]), placement, Sides::Auto).err();
    let expected = ObjectDefect::Placed { vertex: 2, axis: 1, defect: NumberDefect::TooLarge };
    assert_eq!(found, Some(expected));
    // Rounded to a number that is not zero, yet below the range.
    let near = [[0.0; 3], [1.0, 0.0, 0.0], [MIN_MAGNITUDE, 1.0, 0.0]];
    let placement = Placement::new(DAffine3::from_scale(DVec3::splat(0.5))).expect("regular");
    let found = Object::new("o".into(), mesh(&near, &[[0, 1, 2]]), placement, Sides::Auto).err();
    let expected = ObjectDefect::Placed { vertex: 2, axis: 0, defect: NumberDefect::TooSmall };
    assert_eq!(found, Some(expected));
}

#[test]
fn queries_refuse_what_scenes_refuse() {
    let floor = scene(vec![object("floor", rectangle(2.0, 2.0), DAffine3::IDENTITY)]);
    let (queries, light) = (Queries::new(&floor), sun([0.0, -1.0, 0.0]));
    for (number, defect) in refused() {
        let position = [0.0, number, 0.0];
        let oriented = |position, normal| Place::Oriented { position, normal, precision: Precision::Double };
        for place in [Place::Free { position }, oriented(position, [0.0, 1.0, 0.0])] {
            assert_eq!(queries.lit(&place, &light), Err(QueryDefect::Coordinate { axis: 1, defect }), "{place:?}");
        }
        if !number.is_finite() {
            let place = oriented([0.0; 3], [0.0, number, 0.0]);
            assert_eq!(queries.lit(&place, &light), Err(QueryDefect::Normal), "{place:?}");
            let place = Place::Surface { object: 0, face: 0, u: number, v: 0.5 };
            assert_eq!(queries.lit(&place, &light), Err(QueryDefect::OutsideFace), "{place:?}");
        }
    }
}

/// Normals as flat, as short and as long as floats may be.
#[test]
fn any_normal_but_zero() {
    let floor = scene(vec![object("floor", rectangle(2.0, 2.0), DAffine3::IDENTITY)]);
    let (queries, noon) = (Queries::new(&floor), sun([0.0, -1.0, 0.0]));
    let lit = |normal| {
        let place = Place::Oriented { position: [0.25, 0.0, 0.25], normal, precision: Precision::Double };
        queries.lit(&place, &noon).expect("a normal").lit
    };
    for [x, y] in [[1.0, 1e-61], [1e300, 5e-324], [-3.0, 5e-324], [0.0, 5e-324], [f64::MAX, f64::MAX]] {
        assert_eq!([lit([x, y, 0.0]), lit([x, -y, 0.0])], [true, false], "{x:e}, {y:e}");
    }
}

/// The same scene with all its zeros written as −0.
#[test]
fn minus_zero_is_zero() {
    let corners = [[0.0, 1.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 2.0]];
    let negated = corners.map(|corner| corner.map(|x| if x == 0.0 { -0.0 } else { x }));
    let of = |corners: &[[f64; 3]], zero: f64| {
        let map = DAffine3 {
            matrix3: DMat3::from_cols(
                DVec3::new(1.0, zero, zero),
                DVec3::new(zero, 1.0, zero),
                DVec3::new(zero, zero, 1.0),
            ),
            translation: DVec3::splat(zero),
        };
        let floor = object("floor", rectangle(8.0, 8.0), map);
        scene(vec![floor, object("roof", mesh(corners, &[[0, 2, 1]]), map), object("ball", sphere(0.5), map)])
    };
    for direction in [[0.0, -1.0, 0.0], [0.0, -1.0, 1.0]] {
        let plain = crate::proving::Case::new("zero", &of(&corners, 0.0), sun(direction), 3);
        let minus = direction.map(|x| if x == 0.0 { -0.0 } else { x });
        let negative = crate::proving::Case::new("zero", &of(&negated, -0.0), sun(minus), 3);
        assert_eq!(plain.report.lights, negative.report.lights);
    }
    let negative = of(&negated, -0.0);
    let lit = |x| Queries::new(&negative).lit(&Place::Free { position: [0.25, x, 0.25] }, &lamp([0.25, 3.0, 0.25]));
    assert_eq!(lit(-0.0), lit(0.0));
}

/// Both ends of the range in one scene: a floor as wide as it goes, and on it bodies as small as it goes.
#[test]
fn both_ends_of_the_range_in_one_scene() {
    let (wide, small) = (MAX_MAGNITUDE, MIN_MAGNITUDE);
    let floor = || object("floor", rectangle(wide, wide), DAffine3::IDENTITY);
    let speck = [[0.0, small, 0.0], [small, small, 0.0], [0.0, small, small]];
    let speck = || object("speck", mesh(&speck, &[[0, 1, 2]]), DAffine3::IDENTITY);
    let sail = [[-wide, 0.0, 0.0], [wide, wide, 0.0], [-wide, wide, 0.0]];
    let sail = object("sail", mesh(&sail, &[[0, 1, 2]]), DAffine3::IDENTITY);
    let objects = vec![floor(), speck(), sail, object("ball", sphere(1.0), at(4.0, 1.0, 4.0))];
    let whole = scene(objects);
    for light in [
        sun([0.0, -1.0, 0.0]),
        sun([wide, -wide, small]),
        sun([small, -1.0, -small]),
        lamp([small, wide, small]),
        lamp([0.0, small * 4.0, 0.0]),
        lamp([-wide, wide, wide]),
    ] {
        judge("both ends", &whole, light);
    }
    // Under the speck and beside it.
    let both = scene(vec![floor(), speck()]);
    let (queries, noon) = (Queries::new(&both), sun([0.0, -1.0, 0.0]));
    let lit = |x: f64| queries.lit(&Place::Free { position: [x, 0.0, 0.0] }, &noon).expect("accepted").lit;
    assert_eq!([0.0, small, small.next_up(), -small].map(lit), [false, false, true, true]);
}

/// Bodies with sizes at the ends of the range, one or two of them at a time.
fn bodies_at_the_ends() -> Vec<(String, Shape)> {
    // Corners lie at half a height, and at a height and a half.
    const ENDS: [f64; 3] = [2.0 * MIN_MAGNITUDE, 1.0, 0.5 * MAX_MAGNITUDE];
    let mut bodies = Vec::new();
    let mut add = |name: String, body: Analytic| bodies.push((name, analytic(body)));
    for (k, a) in ENDS.into_iter().enumerate() {
        add(format!("sphere {a:e}"), Analytic::Sphere { radius: a });
        add(format!("disk {a:e}"), Analytic::Disk { radius: a });
        for b in ENDS {
            add(format!("ellipsoid {a:e} {b:e}"), Analytic::Ellipsoid { radii: [a, b, ENDS[(k + 1) % 3]] });
            add(format!("cylinder {a:e} {b:e}"), Analytic::Cylinder { radius: a, height: b });
            add(format!("cone {a:e} {b:e}"), Analytic::Cone { radius: a, height: b });
            let frustum = Analytic::Frustum { bottom_radius: a, top_radius: ENDS[(k + 2) % 3], height: b };
            add(format!("frustum {a:e} {b:e}"), frustum);
            add(format!("capsule {a:e} {b:e}"), Analytic::Capsule { radius: a, height: b });
            add(format!("paraboloid {a:e} {b:e}"), Analytic::Paraboloid { radius: a, height: b });
            let waist_radius = a;
            let end_radius = 2.0 * waist_radius;
            add(format!("hyperboloid {a:e} {b:e}"), Analytic::Hyperboloid { waist_radius, end_radius, height: b });
        }
    }
    for [a, b, c] in [[0, 1, 2], [0, 0, 2], [2, 2, 0]].map(|ends| ends.map(|end: usize| ENDS[end])) {
        bodies.push((format!("box {a:e} {b:e}"), cuboid(a, b, c)));
    }
    bodies
}

#[test]
fn sizes_at_both_ends_of_the_range() {
    let lights = [sun([0.25, -1.0, 0.5]), lamp([0.5, 3.0, 0.25]), lamp([3.0, 0.0, 0.0])];
    let mut proved = [0; 2];
    for ((name, body), light) in bodies_at_the_ends().into_iter().zip(lights.into_iter().cycle()) {
        let floor = object("floor", rectangle(4.0, 4.0), at(0.25, -0.75, 0.0));
        let whole = scene(vec![object("body", body, DAffine3::IDENTITY), floor]);
        let (judged, by_borders) = judge_answers(&name, &whole, light);
        proved = [proved[0] + judged.cells, proved[1] + by_borders];
    }
    assert!(proved.iter().all(|&cells| cells > 1000), "{proved:?} cells are proved");
}

/// What is farther from a place than floats can tell is told exactly.
#[test]
fn differences_below_all_floats() {
    let speck = |power: i32| {
        let map = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(2f64.powi(power))), translation: DVec3::ONE };
        object("speck", cuboid(2.0 * MIN_MAGNITUDE, 2.0 * MIN_MAGNITUDE, 2.0 * MIN_MAGNITUDE), map)
    };
    let nested = scene(vec![speck(-199), speck(-198)]);
    for light in [lamp([5.0, 6.0, 7.0]), sun([-0.25, -1.0, -0.5])] {
        judge_answers("nested specks", &nested, light);
        let inner = Queries::new(&nested).lit(&Place::Surface { object: 0, face: 3, u: 0.5, v: 0.5 }, &light);
        assert!(!inner.expect("a point of a face").lit, "{light:?}");
    }
    // A ball that is sheared until its matrix has no inverse in floats.
    let [small, large] = [MIN_MAGNITUDE, 0.25 * MAX_MAGNITUDE];
    let shear =
        DMat3::from_cols(DVec3::new(small, 0.0, 0.0), DVec3::new(large, small, 0.0), DVec3::new(large, large, small));
    let floor = object("floor", rectangle(4.0, 4.0), at(0.0, -0.75, 0.0));
    let map = DAffine3 { matrix3: shear, translation: DVec3::Z };
    let sheared = scene(vec![object("needle", sphere(1.0), map), floor]);
    for light in [lamp([0.5, 3.0, 0.25]), sun([0.25, -1.0, 0.5])] {
        judge_answers("a sheared ball", &sheared, light);
    }
}
