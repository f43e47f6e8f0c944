//! Many points at once have the answers of single queries.
//!
//! Every fixture and random scenes, under lights on corners, in planes and far away; points on corners, on faces as f64
//! and as f32 say them, an ulp beside, in space, in clusters and strewn; free and with normals. `UMBRIEL_CASES` sets the
//! number of scenes.

use crate::chance::{any_light, any_scene};
use crate::oracle::{cases, dice::Dice, fixtures};
use umbriel_geometry::{LightSource, NumberDefect};
use umbriel_scene::Scene;
use umbriel_shadow::{Place, Points, PointsError, Queries, QueryDefect, Silent};

/// Points of one batch.
const POINTS: usize = 160;

/// A place that gives trouble: on a corner, on a face, or anywhere.
fn any_position(scene: &Scene, features: &[[f64; 3]], dice: &mut Dice) -> [f64; 3] {
    let position = match dice.below(4) {
        0 => dice.pick(features),
        1 => std::array::from_fn(|_| dice.float(-4.0, 4.0)),
        2 => dice.grid_point(16, 0.25),
        _ => {
            // Between corners of one object: on its faces if it is flat.
            let corners: Vec<[f64; 3]> = fixtures::features(&Scene {
                objects: [scene.objects[dice.index(scene.objects.len())].clone()].into(),
                ..Scene::default()
            });
            let [a, b, c] = [0; 3].map(|_| dice.pick(&corners));
            let (u, v) = (dice.float(0.0, 0.5), dice.float(0.0, 0.5));
            std::array::from_fn(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]))
        }
    };
    match dice.below(6) {
        // The next numbers beside zero are not accepted: some as far off as those beside one.
        0 => position.map(|x| if x == 0.0 { f64::EPSILON } else { x.next_up() }),
        1 => position.map(|x| if x == 0.0 { x } else { x.next_down() }),
        _ => position,
    }
}

/// Rows of position and normal; half of them close together, as the points of one triangle are.
fn any_rows(scene: &Scene, dice: &mut Dice) -> Vec<[f64; 6]> {
    let features = fixtures::features(scene);
    let mut rows = Vec::new();
    while rows.len() < POINTS {
        let [x, y, z] = any_position(scene, &features, dice);
        let [nx, ny, nz] = dice.pick(&[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.3, -0.5, 0.8], [-1.0, 0.0, 0.0]]);
        let (count, spread) = if dice.one_in(4) { (16, dice.pick(&[1e-7, 1e-3, 0.1])) } else { (1, 0.0) };
        for _ in 0..count {
            let [dx, dz] = [0; 2].map(|_| dice.float(-1.0, 1.0) * spread);
            rows.push([x + dx, y, z + dz, nx, ny, nz]);
        }
    }
    rows
}

/// The first point that is answered otherwise alone.
fn difference(queries: &Queries, points: Points, light: &LightSource) -> Option<String> {
    let lit = queries.lit_many(points, light, &Silent).expect("points");
    let in_space = queries.in_space_many(points, &Silent).expect("points");
    (0..points.len()).find_map(|index| {
        let place: Place = points.place(index);
        let alone = queries.lit(&place, light).expect("a point");
        assert_eq!(alone.in_space, in_space[index], "{place:?}");
        (alone.lit != lit[index]).then(|| format!("point {index}, {place:?} under {light:?}: {alone:?} alone"))
    })
}

fn judge(scene: &Scene, light: &LightSource, dice: &mut Dice) -> Option<String> {
    let queries = Queries::new(scene);
    let rows = any_rows(scene, dice);
    let single: Vec<[f32; 6]> = rows.iter().map(|row| row.map(|number| number as f32)).collect();
    let free: Vec<[f64; 3]> = rows.iter().map(|row| [row[0], row[1], row[2]]).collect();
    let free_single: Vec<[f32; 3]> = single.iter().map(|row| [row[0], row[1], row[2]]).collect();
    [
        Points::OrientedDouble(&rows),
        Points::OrientedSingle(&single),
        Points::FreeDouble(&free),
        Points::FreeSingle(&free_single),
    ]
    .into_iter()
    .find_map(|points| difference(&queries, points, light))
}

#[test]
fn fixtures_point_by_point() {
    for (name, scene) in &fixtures::all() {
        let features = fixtures::features(scene);
        for number in 0..cases(200).div_ceil(20) {
            let mut dice = Dice::new(name, number);
            let near = dice.pick(&features);
            let light = fixtures::tricky_light(&mut dice, near, &features);
            let wrong = judge(scene, &light, &mut dice);
            assert!(wrong.is_none(), "{name}: {}", wrong.unwrap_or_default());
        }
    }
}

#[test]
fn random_scenes_point_by_point() {
    for number in 0..cases(200) {
        let mut dice = Dice::new("many points", number);
        let scene = any_scene(&mut dice);
        let light = any_light(&scene, &mut dice);
        let wrong = judge(&scene, &light, &mut dice);
        assert!(wrong.is_none(), "scene {number}: {}", wrong.unwrap_or_default());
    }
}

#[test]
fn what_single_queries_refuse_is_refused() {
    let scene = &fixtures::all()[0].1;
    let sun = LightSource::sun([0.1, -1.0, 0.2]).expect("a sun");
    let queries = Queries::new(scene);
    let refused = |points: Points| queries.lit_many(points, &sun, &Silent).expect_err("refused");
    let bad = |index, axis, defect| {
        let defect = QueryDefect::Coordinate { axis, defect };
        PointsError::Refused { index, defect }
    };
    let points = [[0.0; 3], [1.0, 1e-300, 0.0], [f64::NAN; 3]];
    assert_eq!(refused(Points::FreeDouble(&points)), bad(1, 1, NumberDefect::TooSmall));
    assert_eq!(refused(Points::FreeSingle(&[[f32::INFINITY; 3]])), bad(0, 0, NumberDefect::NotFinite));
    let rows = [[0.0, 0.0, f32::NAN, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]];
    assert_eq!(refused(Points::OrientedSingle(&rows)), bad(0, 2, NumberDefect::NotFinite));
    assert_eq!(
        refused(Points::OrientedSingle(&rows[1..])),
        PointsError::Refused { index: 0, defect: QueryDefect::Normal }
    );
    assert_eq!(queries.lit_many(Points::FreeDouble(&[]), &sun, &Silent), Ok(Vec::new()));
    let empty = Scene::default();
    assert_eq!(Queries::new(&empty).lit_many(Points::FreeDouble(&[[1.0; 3]]), &sun, &Silent), Ok(vec![true]));
}
