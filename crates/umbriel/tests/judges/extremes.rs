//! Sizes, places, shapes and lights that break programs with epsilons: every answer is that of the oracle.
//!
//! Each scene is asked in all ways: cells are baked by both methods and points of proved ones judged; points of its surfaces are queried one by one,
//! directly, by a BVH and looked up in octrees; points in space, of faces and with normals together; samples are taken in tiles. What has a closed form is held against it as well. `UMBRIEL_CASES` sets how many points of
//! each scene are judged.

mod lights;
mod places;
mod range;
mod shapes;
mod strange;

use crate::oracle::{
    Oracle, cases,
    dice::Dice,
    fixtures::{has_triangles, lit_by},
};
use crate::proving::Case;
use glam::DVec3;
use umbriel_geometry::{LightSource, accept_point};
use umbriel_scene::{Object, Scene};
use umbriel_shadow::{
    CellMethod, Detail, Expected, FacePoint, Place, Points, Queries, Report, Request, Sampling, Search, SearchCosts,
    Silent, bake, for_each_sample,
};
use umbriel_visibility::Acceleration;

/// How many of each kind were judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Judged {
    /// Proved cells.
    cells: usize,
    /// Lit points of those asked.
    lit: usize,
    /// Samples of flat faces that were taken in tiles.
    samples: usize,
}

fn sun(direction: [f64; 3]) -> LightSource {
    LightSource::sun(direction).expect("a sun")
}

fn lamp(position: [f64; 3]) -> LightSource {
    LightSource::point(position).expect("a lamp")
}

/// Bakes samples alone, their answers kept.
fn sampled(scene: &Scene, light: LightSource, count: u64) -> (Scene, Request, Report) {
    let scene = lit_by(scene.clone(), light);
    let sampling = Some(Sampling::Count(count));
    let request = Request { sampling, keep_cells: true, ..Request::everything(&scene, Detail::Faces) };
    let report = bake(&scene, &request, &Silent).expect("nobody cancels");
    (scene, request, report)
}

/// Puts everything that is said about a scene under a light to the oracle.
fn judge(name: &str, scene: &Scene, light: LightSource) -> Judged {
    let (judged, by_borders) = judge_answers(name, scene, light);
    assert!(
        judged.cells.min(by_borders) > 0,
        "{name} under {light:?}: {judged:?}, {by_borders} cells by borders are proved"
    );
    judged
}

/// As [`judge`], where perhaps no cell can be proved; with how many were by borders.
fn judge_answers(name: &str, scene: &Scene, light: LightSource) -> (Judged, usize) {
    let oracle = Oracle::new(scene);
    let [cells, by_borders] = judge_cells(name, scene, light, &oracle);
    let lit = judge_points(name, scene, light, &oracle);
    judge_points_in_space(name, scene, light, &oracle);
    judge_points_of_faces(name, scene, light, &oracle);
    let samples = judge_samples(name, scene, light, &oracle);
    (Judged { cells, lit, samples }, by_borders)
}

/// How many cells each method proved.
fn judge_cells(name: &str, scene: &Scene, light: LightSource, oracle: &Oracle) -> [usize; 2] {
    [CellMethod::Quadtree, CellMethod::Borders].map(|method| {
        let case = Case::by(method, name, scene, light, 3);
        let (proved, mut dice) = (case.proved(), Dice::new(name, 0));
        let judged = proved.len().min(cases(30) as usize);
        for k in 0..judged {
            // Spread over all cells, the first and the last among them.
            let cell = proved[k * (proved.len() - 1) / judged.max(2).saturating_sub(1)];
            assert_eq!(case.judge(oracle, cell, 3, &mut dice), None, "{method:?}");
        }
        proved.len()
    })
}

fn judge_points(name: &str, scene: &Scene, light: LightSource, oracle: &Oracle) -> usize {
    const WAYS: [(Acceleration, Search); 3] = [
        (Acceleration::Bvh, Search::Bvh),
        (Acceleration::Octree, Search::Octree),
        (Acceleration::Projection, Search::Projection),
    ];
    let prepared = WAYS.map(|(way, search)| {
        let mut queries = Queries::new(scene);
        let choice = queries.prepare(&light, Expected::Places(cases(80)), way, &SearchCosts::MEASURED);
        assert_eq!(choice.chosen, search, "{name} under {light:?}");
        queries
    });
    let (queries, mut dice) = (Queries::new(scene), Dice::new(name, 1));
    let mut lit = 0;
    for _ in 0..cases(80) {
        let object = dice.index(scene.objects.len());
        let face = dice.index(scene.objects[object].face_count());
        let [u, v] = dice.parameters(has_triangles(&scene.objects[object].shape));
        if !oracle.has_point(object, face, [u, v]) {
            continue;
        }
        let place = Place::Surface { object, face, u, v };
        let expected = oracle.lit(object, face, [u, v], &light);
        let answer = queries.lit(&place, &light).expect("a point of the surface");
        assert_eq!(answer.lit, expected, "{name}: {place:?} under {light:?}");
        for ((way, _), queries) in WAYS.iter().zip(&prepared) {
            let looked_up = queries.lit(&place, &light).expect("a point of the surface");
            assert_eq!(looked_up.lit, expected, "{name}, {way:?}: {place:?} under {light:?}");
        }
        lit += usize::from(answer.lit);
    }
    lit
}

/// Points of surfaces as floats say them, and others around.
fn judge_points_in_space(name: &str, scene: &Scene, light: LightSource, oracle: &Oracle) {
    let mut dice = Dice::new(name, 2);
    let bounds = scene.objects.iter().map(Object::bounds).reduce(|a, b| a.union(b)).expect("an object");
    let mut any = |_| {
        let object = dice.index(scene.objects.len());
        let face = dice.index(scene.objects[object].face_count());
        let [u, v] = dice.parameters(has_triangles(&scene.objects[object].shape));
        let is_on_a_face = dice.one_in(2) && oracle.has_point(object, face, [u, v]);
        let share = [0; 3].map(|_| dice.float(0.0, 1.0));
        let around = bounds.min + bounds.size() * DVec3::from_array(share);
        if is_on_a_face { oracle.point(object, face, [u, v]).approximate() } else { around.to_array() }
    };
    let accepted = |point: &[f64; 3]| accept_point(*point).is_ok();
    let points: Vec<[f64; 3]> = (0..cases(60)).map(&mut any).filter(accepted).collect();
    let lit = Queries::new(scene).lit_many(Points::FreeDouble(&points), &light, &Silent).expect("accepted points");
    for (point, lit) in points.iter().zip(lit) {
        assert_eq!(lit, oracle.lit_in_space(*point, &light), "{name}: {point:?} under {light:?}");
    }
}

/// Points of faces by their parameters, and as floats with a normal, all of them together.
fn judge_points_of_faces(name: &str, scene: &Scene, light: LightSource, oracle: &Oracle) {
    let mut dice = Dice::new(name, 3);
    let mut any = |_| {
        let object = dice.index(scene.objects.len());
        let face = dice.index(scene.objects[object].face_count());
        let [u, v] = dice.parameters(has_triangles(&scene.objects[object].shape));
        FacePoint::new(object, face, u, v)
    };
    let numbers = |point: &FacePoint| (point.object as usize, point.face as usize, [point.u, point.v]);
    let there = |point: &FacePoint| {
        let (object, face, place) = numbers(point);
        oracle.has_point(object, face, place)
    };
    let points: Vec<FacePoint> = (0..cases(60)).map(&mut any).filter(there).collect();
    let queries = Queries::new(scene);
    let lit = queries.lit_many(Points::OnFaces(&points), &light, &Silent).expect("points of faces");
    for ((object, face, [u, v]), lit) in points.iter().map(numbers).zip(lit) {
        assert_eq!(
            lit,
            oracle.lit(object, face, [u, v], &light),
            "{name}: {object}, {face}, ({u}, {v}) under {light:?}"
        );
    }
    let row = |point: &FacePoint| {
        let (object, face, [u, v]) = numbers(point);
        let [x, y, z] = oracle.point(object, face, [u, v]).approximate();
        let [nx, ny, nz] = oracle.front(object, face, [u, v]);
        [x, y, z, nx, ny, nz]
    };
    let accepted = |[x, y, z, normal @ ..]: &[f64; 6]| {
        accept_point([*x, *y, *z]).is_ok() && normal.iter().all(|c| c.is_finite()) && *normal != [0.0; 3]
    };
    let rows: Vec<[f64; 6]> = points.iter().take(20).map(row).filter(accepted).collect();
    let lit = queries.lit_many(Points::OrientedDouble(&rows), &light, &Silent).expect("accepted points");
    for (row @ &[x, y, z, nx, ny, nz], lit) in rows.iter().zip(lit) {
        let expected = oracle.expected([x, y, z], [nx, ny, nz], false, &light).lit;
        assert!(expected.is_none_or(|expected| expected == lit), "{name}: {row:?} under {light:?} is told lit {lit}");
    }
}

fn judge_samples(name: &str, scene: &Scene, light: LightSource, oracle: &Oracle) -> usize {
    let (whole, request, report) = sampled(scene, light, cases(200));
    let (mut next, mut judged) = (vec![0_u64; scene.objects.len()], 0);
    for_each_sample(&whole, &request, |sample| {
        let index = next[sample.object];
        next[sample.object] += 1;
        let Some(answers) = &report.lights[0].objects[sample.object].answers else { return };
        // Every face has a sample; of ten thousand triangles some are enough.
        if !index.is_multiple_of(1 + answers.len() / cases(200)) {
            return;
        }
        judged += 1;
        let agrees = oracle.sample_is_lit(&sample, &light) == answers.is_lit(index);
        assert!(agrees, "{name}: {sample:?} under {light:?} is told lit {}", answers.is_lit(index));
    });
    judged
}
