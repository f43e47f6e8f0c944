//! Queries answer what the definition says: `Queries::lit` against the oracle.
//!
//! Random points of small scenes under random and adversarial lights: segments through corners, along edges, within
//! faces, tangent to spheres, and the same moved by an ulp or two. `UMBRIEL_CASES` sets the number of points,
//! `UMBRIEL_FIRST` the first.

use std::ops::Range;

use crate::{
    oracle::{Oracle, case_numbers, dice::Dice, fixtures},
    stored,
};
use umbriel_geometry::LightSource;
use umbriel_scene::{Object, Scene, Shape};
use umbriel_shadow::{Answer, Place, Precision, Queries};

/// A fixture with everything that is asked about it.
struct Court<'a> {
    name: &'a str,
    scene: &'a Scene,
    oracle: Oracle,
    queries: Queries<'a>,
    features: Vec<[f64; 3]>,
}

impl<'a> Court<'a> {
    fn new(name: &'a str, scene: &'a Scene) -> Self {
        let (oracle, features) = (Oracle::new(scene), fixtures::features(scene));
        Self { name, scene, oracle, queries: Queries::new(scene), features }
    }

    /// A point of a face: object, face, (u, v).
    fn surface_point(&self, dice: &mut Dice) -> (usize, usize, [f64; 2]) {
        loop {
            let object = dice.index(self.scene.objects.len());
            let is_mesh = fixtures::has_triangles(&self.scene.objects[object].shape);
            let (face, parameters) = (dice.index(self.scene.objects[object].face_count()), dice.parameters(is_mesh));
            if self.oracle.has_point(object, face, parameters) {
                return (object, face, parameters);
            }
        }
    }

    fn answer(&self, place: &Place, light: &LightSource) -> Result<Answer, String> {
        self.queries.lit(place, light).map_err(|defect| format!("{}: {place:?} refused: {defect}", self.name))
    }

    fn disagreement(&self, place: &Place, light: &LightSource, expected: &str, answer: Answer) -> String {
        let objects: Vec<String> = match place {
            Place::Surface { object, .. } => vec![format!("{:?}", self.scene.objects[*object])],
            _ => self.scene.objects.iter().map(|object| object.name.clone()).collect(),
        };
        let name = self.name;
        format!("fixture {name}: {place:?} under {light:?}: {answer:?}, by definition {expected}; {objects:?}")
    }

    fn judge_surface(&self, dice: &mut Dice) -> Result<(), String> {
        let (object, face, [u, v]) = self.surface_point(dice);
        let x = self.oracle.point(object, face, [u, v]).approximate();
        let light = fixtures::tricky_light(dice, x, &self.features);
        let place = Place::Surface { object, face, u, v };
        let expected = Answer { lit: self.oracle.lit(object, face, [u, v], &light), in_space: false };
        let answer = self.answer(&place, &light)?;
        if answer == expected {
            Ok(())
        } else {
            Err(self.disagreement(&place, &light, &format!("{expected:?}"), answer))
        }
    }

    fn judge_space(&self, dice: &mut Dice) -> Result<(), String> {
        let position = match dice.below(3) {
            0 => dice.grid_point(16, 0.25),
            1 => dice.pick(&self.features),
            _ => std::array::from_fn(|_| dice.float(-4.0, 4.0)),
        };
        let light = fixtures::tricky_light(dice, position, &self.features);
        let place = Place::Free { position };
        let expected = self.oracle.lit_in_space(position, &light);
        let answer = self.answer(&place, &light)?;
        if answer.lit == expected {
            Ok(())
        } else {
            Err(self.disagreement(&place, &light, &format!("lit: {expected}"), answer))
        }
    }

    /// Whether the oracle could tell, or what is wrong.
    fn judge_oriented(&self, dice: &mut Dice) -> Result<bool, String> {
        let (object, face, parameters) = self.surface_point(dice);
        let single = dice.one_in(2);
        let exact = self.oracle.point(object, face, parameters).approximate();
        let narrowed = exact.map(|coordinate| if single { f64::from(coordinate as f32) } else { coordinate });
        let away = if dice.one_in(8) { dice.grid_point(2, 0.0625) } else { [0.0; 3] };
        let position: [f64; 3] = std::array::from_fn(|i| narrowed[i] + away[i]);
        let normal = match self.oracle.front(object, face, parameters) {
            front if front == [0.0; 3] => [0.0, 1.0, 0.0],
            front if dice.one_in(2) => front,
            front => front.map(|coordinate| -coordinate),
        };
        let light = fixtures::tricky_light(dice, exact, &self.features);
        let precision = if single { Precision::Single } else { Precision::Double };
        let place = Place::Oriented { position, normal, precision };
        let expected = self.oracle.expected(position, normal, single, &light);
        let answer = self.answer(&place, &light)?;
        let agrees = expected.lit.is_none_or(|lit| lit == answer.lit)
            && expected.in_space.is_none_or(|in_space| in_space == answer.in_space);
        if agrees {
            Ok(expected.lit.is_some())
        } else {
            Err(self.disagreement(&place, &light, &format!("{expected:?}"), answer))
        }
    }
}

/// Judges cases spread over all fixtures; tells how many the oracle decided.
fn judge(title: &str, numbers: Range<u64>, case: impl Fn(&Court, &mut Dice) -> Result<bool, String>) -> u64 {
    let fixtures = fixtures::all();
    let share = (numbers.end - numbers.start).div_ceil(fixtures.len() as u64);
    let (mut decided, mut wrong) = (0, Vec::new());
    for (name, scene) in &fixtures {
        let court = Court::new(name, scene);
        for number in numbers.start..numbers.start + share {
            let mut dice = Dice::new(title, number);
            match case(&court, &mut dice) {
                Ok(known) => decided += u64::from(known),
                Err(complaint) => wrong.push(format!("case {number}, {complaint}")),
            }
        }
    }
    let shown = wrong.iter().take(5).cloned().collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{} of {} cases are wrong:\n{shown}", wrong.len(), share * fixtures.len() as u64);
    decided
}

#[test]
fn surface_points_agree_with_the_definition() {
    judge("surface", case_numbers(100_000), |court, dice| court.judge_surface(dice).map(|()| true));
}

#[test]
fn points_in_space_agree_with_the_definition() {
    judge("space", case_numbers(10_000), |court, dice| court.judge_space(dice).map(|()| true));
}

#[test]
fn positions_with_normals_agree_with_their_slack_box() {
    let numbers = case_numbers(5_000);
    let count = numbers.end - numbers.start;
    let decided = judge("oriented", numbers, |court, dice| court.judge_oriented(dice));
    assert!(3 * decided > count, "the oracle decided only {decided} of {count} cases");
}

#[test]
fn both_answers_occur_in_every_fixture() {
    for (name, scene) in &fixtures::all() {
        let court = Court::new(name, scene);
        let mut counts = [0; 2];
        for number in 0..300 {
            let mut dice = Dice::new("surface", number);
            let (object, face, parameters) = court.surface_point(&mut dice);
            let x = court.oracle.point(object, face, parameters).approximate();
            let light = fixtures::tricky_light(&mut dice, x, &court.features);
            counts[usize::from(court.oracle.lit(object, face, parameters, &light))] += 1;
        }
        let rare = if *name == "closed room" { 1 } else { 15 };
        assert!(counts[0] >= rare && counts[1] >= rare, "{name}: {counts:?} of 300 shadowed and lit");
    }
}

#[test]
fn surface_points_of_the_stored_scenes_agree_with_the_definition() {
    let numbers = case_numbers(1_000);
    let mut judged = 0;
    for path in stored::scenes() {
        let scene = umbriel_io::load(&path, &umbriel_io::LoadOptions::default()).expect("a scene").scene;
        // Holes have a judge of their own, and offices have too many faces to look at each.
        let has_holes = |object: &Object| matches!(&object.shape, Shape::Mesh(mesh) if mesh.has_holes());
        if !scene.cells.is_empty() || scene.objects.iter().any(has_holes) {
            continue;
        }
        judged += 1;
        let name = path.file_name().expect("a file").to_string_lossy().into_owned();
        let court = Court::new(&name, &scene);
        let complaint = |number| court.judge_surface(&mut Dice::new("stored", number)).err();
        let wrong: Vec<String> = numbers.clone().filter_map(complaint).collect();
        assert!(wrong.is_empty(), "{} points of {name} are wrong, first {}", wrong.len(), wrong[0]);
    }
    assert!(judged >= 20, "only {judged} fixtures are there");
}
