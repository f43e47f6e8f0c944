//! Segments and cells on the borders of every decision: the fast ways and the oracle agree on each of them.
//!
//! `umbriel::adversarial` makes the questions. Segments are answered by `Queries`, alone, in lists and now and then by octrees and projections, and by the
//! triangle tree where all surfaces are meshes, ray by ray and in packets; cells by both methods; samples by the tiles. `UMBRIEL_CASES` sets how many, `UMBRIEL_FIRST` the first.

use std::sync::Arc;

use crate::oracle::{Oracle, case_numbers, dice::Dice, fixtures::lit_by};
use crate::proving::{Case, point_of};
use glam::DVec3;
use umbriel::adversarial::{
    Aim, CornerTrial, Edit, Family, FamilyTrial, Random, SegmentTrial, family, history, outline_through_corner, segment,
};
use umbriel_bvh::{Segment, TriangleBvh};
use umbriel_geometry::{LightSource, Mesh, Placement};
use umbriel_scene::{Light, Object, Scene, Shape};
use umbriel_shadow::{
    Cell, CellMethod, Change, Detail, Expected, FacePoint, Place, Points, Queries, Request, Sampling, SearchCosts,
    Session, Silent, Verdict, bake, for_each_sample,
};
use umbriel_visibility::Acceleration;

/// Shows the first complaints, if there are any.
fn none_wrong(wrong: &[String], count: u64) {
    let shown = wrong.iter().take(3).cloned().collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{} of {count} are wrong:\n{shown}", wrong.len());
}

/// What the oracle says about a place.
fn truth(oracle: &Oracle, place: &Place, light: &LightSource) -> bool {
    match *place {
        Place::Surface { object, face, u, v } => oracle.lit(object, face, [u, v], light),
        Place::Free { position } | Place::Oriented { position, .. } => oracle.lit_in_space(position, light),
    }
}

/// What the triangle trees say about a place in space, one ray and packets of equal ones, if all objects are meshes that stand where they are.
fn by_trees(trial: &SegmentTrial) -> Vec<(&'static str, bool)> {
    let Place::Free { position } = trial.place else { return Vec::new() };
    let meshes = trial.scene.objects.iter().map(|object| match &object.shape {
        Shape::Mesh(mesh) => Some(Arc::clone(mesh)),
        _ => None,
    });
    let Some(meshes) = meshes.collect::<Option<Vec<_>>>() else { return Vec::new() };
    let trees: Vec<TriangleBvh> = meshes.into_iter().map(TriangleBvh::build).collect();
    let (origin, light) = (DVec3::from_array(position), trial.light);
    let is_lit = |is_hit: &dyn Fn(&TriangleBvh) -> bool| !trees.iter().any(is_hit);
    let packet = [origin; 9];
    vec![
        ("the tree", is_lit(&|tree| tree.any_hit(&Segment::new(origin, light)))),
        ("a packet", is_lit(&|tree| tree.towards(light).any_hits(&packet).contains(&true))),
        ("a stream", is_lit(&|tree| tree.towards(light).any_hits_unordered(&packet).contains(&true))),
    ]
}

/// The place as one of many points, some of them the same.
fn among_many(queries: &Queries, place: &Place, light: &LightSource) -> Vec<bool> {
    const TIMES: usize = 3;
    let lit = match *place {
        Place::Surface { object, face, u, v } => {
            queries.lit_many(Points::OnFaces(&[FacePoint::new(object, face, u, v); TIMES]), light, &Silent)
        }
        Place::Free { position } => queries.lit_many(Points::FreeDouble(&[position; TIMES]), light, &Silent),
        Place::Oriented { .. } => return Vec::new(),
    };
    lit.expect("accepted points")
}

/// How many trials are answered by octrees and projections, too: one of so many.
const LOOKED_UP: u64 = 16;

/// Whether the place is lit, or what is wrong about an answer.
fn judge_segment(trial: &SegmentTrial, is_looked_up: bool) -> Result<bool, String> {
    let SegmentTrial { scene, place, light } = trial;
    let expected = truth(&Oracle::new(scene), place, light);
    let mut queries = Queries::new(scene);
    let answer = queries.lit(place, light).map_err(|defect| format!("{defect}: {trial:?}"))?;
    let mut answers = vec![("a query", answer.lit)];
    answers.extend(by_trees(trial));
    answers.extend(among_many(&queries, place, light).into_iter().map(|lit| ("a list of points", lit)));
    if is_looked_up {
        for way in [Acceleration::Octree, Acceleration::Projection] {
            queries.prepare(light, Expected::Places(1), way, &SearchCosts::MEASURED);
            let answer = queries.lit(place, light).map_err(|defect| format!("{defect}: {trial:?}"))?;
            answers.push((if way == Acceleration::Octree { "an octree" } else { "a projection" }, answer.lit));
        }
    }
    match answers.iter().find(|(_, lit)| *lit != expected) {
        Some((who, lit)) => Err(format!("by definition {expected}, {who} says {lit}: {trial:?}")),
        None => Ok(expected),
    }
}

#[test]
fn segments_that_graze_agree_with_the_definition() {
    let numbers = case_numbers(40_000);
    let count = numbers.end - numbers.start;
    for (kind, aim) in Aim::ALL.into_iter().enumerate() {
        let (mut lit, mut wrong) = (0, Vec::new());
        let own = numbers.clone().filter(|number| number % Aim::ALL.len() as u64 == kind as u64);
        for number in own {
            let is_looked_up = (number / Aim::ALL.len() as u64).is_multiple_of(LOOKED_UP);
            match judge_segment(&segment(aim, &mut Random::new(number)), is_looked_up) {
                Ok(open) => lit += u64::from(open),
                Err(complaint) => wrong.push(format!("case {number}, {aim:?}: {complaint}")),
            }
        }
        none_wrong(&wrong, count);
        // A judge that hears one answer only proves little.
        let share = lit as f64 / (count as f64 / Aim::ALL.len() as f64);
        assert!(count < 1000 || (0.1..0.9).contains(&share), "{aim:?}: {share} lit");
    }
}

/// Whether the cell, closed, holds the point (u, v) of its face, counted from the face's first corner.
fn holds(cell: &Cell, [u, v]: [f64; 2]) -> bool {
    let [low, high] = [cell.point([0.0; 2]), cell.point([1.0; 2])];
    cell.corner == 0 && low[0] <= u && u <= high[0] && low[1] <= v && v <= high[1]
}

/// Judges the proved cells round the corner: how many, or what is wrong.
fn judge_corner(trial: &CornerTrial, method: CellMethod, dice: &mut Dice) -> Result<u64, String> {
    let scene = lit_by(trial.scene.clone(), trial.light);
    let detail = Detail::Depth { interior: trial.level, boundary: trial.level };
    let request = Request { receivers: vec![0], keep_cells: true, method, ..Request::everything(&scene, detail) };
    let report = bake(&scene, &request, &Silent).expect("nobody cancels");
    let title = format!("{method:?}");
    let case = Case { title, scene, light: trial.light, report };
    let oracle = Oracle::new(&trial.scene);
    let at_corner = oracle.lit(0, 0, trial.corner, &trial.light);
    let round = case.proved().into_iter().filter(|(_, cell)| holds(cell, trial.corner));
    let mut judged = 0;
    for (object, cell) in round {
        judged += 1;
        if at_corner != (cell.verdict == Verdict::Lit) {
            return Err(format!("{cell:?} at its corner {:?}, lit {at_corner}: {trial:?}", trial.corner));
        }
        if let Some(complaint) = case.judge(&oracle, (object, cell), 3, dice) {
            return Err(format!("{complaint}: {trial:?}"));
        }
    }
    Ok(judged)
}

#[test]
fn cells_round_a_corner_on_an_outline_are_true() {
    let (numbers, mut wrong, mut judged) = (case_numbers(10_000), Vec::new(), 0);
    let wanted = numbers.end - numbers.start;
    // Seeds of their own for every first number; a trial gives two judged cells or so.
    let mut number = numbers.start << 8;
    while judged < wanted {
        let mut dice = Dice::new("corners", number);
        let trial = outline_through_corner(&mut Random::new(number));
        let method = [CellMethod::Quadtree, CellMethod::Borders][(number % 2) as usize];
        match judge_corner(&trial, method, &mut dice) {
            Ok(cells) => judged += cells,
            Err(complaint) => wrong.push(format!("case {number}: {complaint}")),
        }
        number += 1;
        assert!(number - (numbers.start << 8) < 20 * wanted + 1000, "only {judged} cells of {number} trials");
    }
    none_wrong(&wrong, judged);
}

/// Samples of a scene against the oracle; how many, or what is wrong.
fn judge_samples(scene: &Scene, light: LightSource, count: u64) -> Result<u64, String> {
    let scene = lit_by(scene.clone(), light);
    let sampling = Some(Sampling::Count(count));
    let request = Request { sampling, keep_cells: true, ..Request::everything(&scene, Detail::Faces) };
    let report = bake(&scene, &request, &Silent).expect("nobody cancels");
    let oracle = Oracle::new(&scene);
    let (mut next, mut wrong, mut judged) = (vec![0; scene.objects.len()], None, 0);
    for_each_sample(&scene, &request, |sample| {
        let index = next[sample.object];
        next[sample.object] += 1;
        let Some(answers) = &report.lights[0].objects[sample.object].answers else { return };
        judged += 1;
        let agrees = oracle.sample_is_lit(&sample, &light) == answers.is_lit(index);
        if !agrees && wrong.is_none() {
            wrong = Some(format!("{sample:?} lit {}: {scene:?}", answers.is_lit(index)));
        }
    });
    wrong.map_or(Ok(judged), Err)
}

#[test]
fn samples_on_an_outline_agree_with_the_definition() {
    let (mut judged, mut wrong) = (0, Vec::new());
    let numbers = case_numbers(300);
    for number in numbers.clone() {
        let trial = outline_through_corner(&mut Random::new(number));
        match judge_samples(&trial.scene, trial.light, 64) {
            Ok(samples) => judged += samples,
            Err(complaint) => wrong.push(format!("case {number}: {complaint}")),
        }
    }
    none_wrong(&wrong, numbers.end - numbers.start);
    assert!(judged > 30 * (numbers.end - numbers.start), "only {judged} samples");
}

/// Proved cells, samples and single points of a whole scene; what is wrong, if anything.
fn judge_family(trial: &FamilyTrial, dice: &mut Dice) -> Result<u64, String> {
    let FamilyTrial { scene, light } = trial;
    let oracle = Oracle::new(scene);
    let method = dice.pick(&[CellMethod::Quadtree, CellMethod::Borders]);
    let case = Case::by(method, "family", scene, *light, 4);
    let proved = case.proved();
    for _ in 0..proved.len().min(24) {
        let cell = dice.pick(&proved);
        if let Some(complaint) = case.judge(&oracle, cell, 3, dice) {
            return Err(format!("{method:?}: {complaint}: {trial:?}"));
        }
    }
    let queries = Queries::new(scene);
    let everywhere: Vec<_> = case.cells().collect();
    for _ in 0..everywhere.len().min(8) {
        let (object, cell) = dice.pick(&everywhere);
        let (face, [u, v]) = (cell.face as usize, point_of(&cell, case.is_mesh(object), dice));
        if !oracle.has_point(object, face, [u, v]) {
            continue;
        }
        let expected = oracle.lit(object, face, [u, v], light);
        let answer = queries.lit(&Place::Surface { object, face, u, v }, light);
        if !answer.as_ref().is_ok_and(|answer| answer.lit == expected) {
            return Err(format!("object {object}, face {face}, ({u}, {v}) is {answer:?}: {trial:?}"));
        }
    }
    judge_samples(scene, *light, 48)
}

#[test]
fn scenes_of_all_families_agree_with_the_definition() {
    let (mut judged, mut wrong) = (0, Vec::new());
    let numbers = case_numbers(60);
    for number in numbers.clone() {
        let kind = Family::ALL[(number % Family::ALL.len() as u64) as usize];
        let trial = family(kind, &mut Random::new(number));
        match judge_family(&trial, &mut Dice::new("families", number)) {
            Ok(samples) => judged += samples,
            Err(complaint) => wrong.push(format!("case {number}, {kind:?}: {complaint}")),
        }
    }
    none_wrong(&wrong, numbers.end - numbers.start);
    assert!(judged > 8 * (numbers.end - numbers.start), "only {judged} samples");
}

/// The same objects, made anew from their numbers and in the order of their names.
fn made_anew(scene: &Scene) -> Scene {
    let anew = |object: &Object| {
        let shape = match &object.shape {
            Shape::Mesh(mesh) => {
                let positions = mesh.positions().iter().map(DVec3::to_array).collect();
                Shape::Mesh(Arc::new(Mesh::new(positions, mesh.triangles().to_vec()).expect("the same mesh")))
            }
            other => other.clone(),
        };
        let placement = Placement::new(*object.placement.map()).expect("the same matrix");
        Object::new(object.name.clone(), shape, placement, object.sides).expect("the same object")
    };
    let mut objects: Vec<Object> = scene.objects.iter().map(anew).collect();
    objects.sort_by(|a, b| a.name.cmp(&b.name));
    Scene { objects: objects.into(), ..Scene::default() }
}

/// What a bake says about each object, cells and samples, in the order of names. Whatever the numbers of objects are.
fn answers_by_name(scene: &Scene, light: LightSource) -> Vec<(String, String)> {
    let scene = lit_by(scene.clone(), light);
    let detail = Detail::Depth { interior: 3, boundary: 3 };
    let request =
        Request { sampling: Some(Sampling::Spacing(0.25)), keep_cells: true, ..Request::everything(&scene, detail) };
    let report = bake(&scene, &request, &Silent).expect("nobody cancels");
    let named = report.lights[0].objects.iter().map(|object| {
        let name = scene.objects[object.object].name.clone();
        let sums = [object.area, object.area_error, object.lit.lower, object.lit.upper, object.lit.estimate];
        (name, format!("{:?} {:?} {:?}", sums.map(f64::to_bits), object.samples, object.cells))
    });
    let mut named: Vec<(String, String)> = named.collect();
    named.sort();
    named
}

#[test]
fn a_state_is_baked_alike_whatever_came_before() {
    for number in case_numbers(6) {
        let mut random = Random::new(number);
        let mut scene = Scene::default();
        let lights = [LightSource::sun([1.0, -2.0, 0.5]), LightSource::point([0.5, 3.0, 0.25])];
        for (step, edit) in history(30, &mut random).iter().enumerate() {
            edit.apply(&mut scene);
            let light = lights[step % 2].expect("a light");
            let (grown, anew) = (answers_by_name(&scene, light), answers_by_name(&made_anew(&scene), light));
            assert_eq!(grown, anew, "history {number}, edit {step}: {edit:?}");
        }
    }
}

/// A session keeps what an edit does not touch; now and then the sun moves as well, and a lamp comes or goes.
#[test]
fn a_session_follows_its_history() {
    let lamp = || Light::new("lamp", LightSource::point([0.5, 3.0, 0.25]).expect("a lamp"));
    for number in case_numbers(6) {
        let mut random = Random::new(number);
        let edits = history(30, &mut random);
        let mut any_sun = || {
            let [x, z] = [(); 2].map(|()| random.below(9) as f64 / 4.0 - 1.0);
            Light::new("sun", LightSource::sun([x, -1.0, z]).expect("a sun"))
        };
        let empty = Scene { lights: vec![any_sun()], ..Scene::default() };
        let detail = Detail::Depth { interior: 3, boundary: 3 };
        let request = Request { keep_cells: true, ..Request::everything(&empty, detail) };
        let mut session = Session::new(empty, request);
        for (step, edit) in edits.into_iter().enumerate() {
            let edited = match edit.clone() {
                Edit::Add(object) => Change::Add(*object),
                Edit::Remove(object) => Change::Remove(object),
                Edit::Move { object, to } => Change::Move { object, placement: to },
            };
            let lit = match step % 8 {
                3 => Some(Change::SetLight(0, any_sun())),
                5 => Some(Change::AddLight(lamp())),
                7 => Some(Change::RemoveLight(1)),
                _ => None,
            };
            for change in std::iter::once(edited).chain(lit) {
                session.change(change).expect("a sound change");
            }
            session.update(&Silent).expect("nobody cancels");
            let scene = session.scene();
            let request = Request { keep_cells: true, ..Request::everything(scene, detail) };
            let fresh = bake(scene, &request, &Silent).expect("nobody cancels");
            assert!(session.lights().eq(&fresh.lights), "history {number}, edit {step}: {edit:?}");
        }
    }
}

#[test]
fn histories_hold_every_kind_of_edit() {
    let edits = history(200, &mut Random::new(1));
    let (mut kinds, mut scene) = ([0; 3], Scene::default());
    for edit in &edits {
        edit.apply(&mut scene);
        kinds[match edit {
            Edit::Add(_) => 0,
            Edit::Remove(_) => 1,
            Edit::Move { .. } => 2,
        }] += 1;
        let mut names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
        let all = names.len();
        names.sort_unstable();
        names.dedup();
        assert!(names.len() == all && (1..=12).contains(&all));
    }
    assert!(kinds.iter().all(|&count| count > 20), "{kinds:?}");
}
