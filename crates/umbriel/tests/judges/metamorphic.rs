//! Changes that must not change an answer, made to random scenes: no oracle is asked, only the program itself, twice.
//!
//! All that is reported keeps every bit when objects, triangles, the corners within a triangle, threads, the SIMD level, axes or
//! powers of two change, or an object comes where it can do nothing: cells by both methods, areas with their bounds, estimates and samples. Where the cells themselves are others
//! (triangles cut at points that are floats), the same points have the same answers, what is proved of the one holds of the other, and the bounds
//! overlap.
//! `UMBRIEL_CASES` sets the number of scenes, `UMBRIEL_FIRST` the first.

use std::{cell::Cell, ops::Range, sync::Arc};

use crate::chance::{any_light, any_scene};
use crate::oracle::{
    case_numbers,
    dice::Dice,
    fixtures::{analytic, cuboid, has_triangles, lit_by, mesh, scene, sphere, with_sides},
};
use crate::proving::point_of;
use crate::shuffle::{Shuffled, with_triangles};
use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::{Analytic, LightSource, Mesh, Placement, simd::Level};
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::{
    CellMethod, Detail, LitArea, ObjectReport, Place, Points, Queries, Request, Sampling, Silent, Verdict, bake,
};

/// Compares random scenes with what becomes of them.
fn judge(numbers: Range<u64>, title: &str, compare: impl Fn(&Scene, LightSource, &mut Dice)) {
    for number in numbers {
        let mut dice = Dice::new(title, number);
        let whole = any_scene(&mut dice);
        let light = any_light(&whole, &mut dice);
        // The number is in the way of a panic's message otherwise.
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| compare(&whole, light, &mut dice)));
        assert!(outcome.is_ok(), "{title}, scene {number}");
    }
}

fn bakes(
    whole: &Scene,
    light: LightSource,
    detail: Detail,
    method: CellMethod,
    sampling: Option<Sampling>,
) -> Vec<ObjectReport> {
    let whole = lit_by(whole.clone(), light);
    let request = Request { sampling, keep_cells: true, method, ..Request::everything(&whole, detail) };
    bake(&whole, &request, &Silent).expect("nobody cancels").lights.remove(0).objects
}

/// Everything that is reported of cells by both methods and of samples, those of cells included: every bit of it.
fn everything(whole: &Scene, light: LightSource) -> [Vec<ObjectReport>; 3] {
    // Cells finer than those that are kept are counted by rules of their own.
    let [kept, summed] = [3, 1].map(|interior| Detail::Depth { interior, boundary: 3 });
    let ways = [(summed, CellMethod::Quadtree), (kept, CellMethod::Borders), (Detail::Faces, CellMethod::Auto)];
    ways.map(|(detail, method)| bakes(whole, light, detail, method, Some(Sampling::Count(400))))
}

/// Compares what is reported of a scene with what is reported of another form of it, which `back` turns back.
fn same_reports(
    whole: &Scene,
    other: &Scene,
    [light, there]: [LightSource; 2],
    back: impl Fn(Vec<ObjectReport>) -> Vec<ObjectReport>,
) {
    for (before, after) in everything(whole, light).into_iter().zip(everything(other, there)) {
        for (a, b) in before.iter().zip(&back(after)) {
            // Answers that `back` cannot put in order are left out.
            let a = &ObjectReport { answers: a.answers.clone().filter(|_| b.answers.is_some()), ..a.clone() };
            let differs = a.cells.iter().zip(&b.cells).find(|(a, b)| a != b);
            let outline = |r: &ObjectReport| format!("{:?} {:?} {:?} {:?}", r.area, r.area_error, r.lit, r.samples);
            assert!(a == b, "object {}: {} or {}; {differs:?}", a.object, outline(a), outline(b));
        }
    }
}

fn sampled(whole: &Scene, light: LightSource) -> Vec<ObjectReport> {
    // A third of the largest body's reach: some dozens of samples each, at any scale.
    let reach = whole.objects.iter().map(|object| object.bounds().size().max_element()).fold(0.0, f64::max);
    let spacing = (reach > 0.0).then(|| Sampling::Spacing(reach / 24.0));
    bakes(whole, light, Detail::Faces, CellMethod::Auto, spacing)
}

fn cells(whole: &Scene, light: LightSource) -> Vec<ObjectReport> {
    bakes(whole, light, Detail::Depth { interior: 3, boundary: 3 }, CellMethod::Auto, None)
}

/// How many samples of each object there are and are lit, and each answer where it is kept.
fn answers(reports: &[ObjectReport]) -> Vec<String> {
    reports.iter().map(|report| format!("{:?} {:?}", report.samples, report.answers)).collect()
}

/// Points of surfaces, short fractions in both parameters, asked one by one.
fn queried(whole: &Scene, light: LightSource, places: &[Place]) -> Vec<bool> {
    let queries = Queries::new(whole);
    places.iter().map(|place| queries.lit(place, &light).is_ok_and(|answer| answer.lit)).collect()
}

fn any_places(whole: &Scene, dice: &mut Dice) -> Vec<Place> {
    let any = |_| {
        let object = dice.index(whole.objects.len());
        let face = dice.index(whole.objects[object].face_count());
        let [u, v] = dice.parameters(has_triangles(&whole.objects[object].shape));
        Place::Surface { object, face, u, v }
    };
    (0..60).map(any).collect()
}

fn is_mesh(object: &Object) -> bool {
    matches!(object.shape, Shape::Mesh(_))
}

#[test]
fn objects_in_another_order() {
    judge(case_numbers(6), "order of objects", |whole, light, dice| {
        let shuffled = Shuffled::objects(whole, dice);
        same_reports(whole, &shuffled.scene, [light; 2], |reports| shuffled.back(&reports));
        same_places(whole, &shuffled, light, dice);
    });
}

#[test]
fn triangles_in_another_order() {
    judge(case_numbers(20), "order of triangles", |whole, light, dice| {
        let shuffled = Shuffled::triangles(whole, dice);
        same_reports(whole, &shuffled.scene, [light; 2], |reports| {
            let mut first = shuffled.back(&reports);
            // Samples of faces come in these' order.
            first.iter_mut().filter(|report| is_mesh(&whole.objects[report.object])).for_each(|r| r.answers = None);
            first
        });
        same_places(whole, &shuffled, light, dice);
    });
}

fn same_places(whole: &Scene, shuffled: &Shuffled, light: LightSource, dice: &mut Dice) {
    let places = any_places(whole, dice);
    let moved: Vec<Place> = places.iter().map(|place| shuffled.place(place)).collect();
    assert_eq!(queried(whole, light, &places), queried(&shuffled.scene, light, &moved));
}

#[test]
fn faces_that_start_at_another_corner() {
    // Some as they are, some begun with their second corner, some with their third.
    let first = |face: usize| (face + 1) % 3;
    judge(case_numbers(20), "first corners", |whole, light, dice| {
        let mut turned = whole.clone();
        for object in &mut turned.objects {
            let Shape::Mesh(mesh) = &object.shape else { continue };
            let begun = |(face, corners): (usize, &[u32; 3])| [0, 1, 2].map(|k| corners[(first(face) + k) % 3]);
            *object = with_triangles(object, mesh, mesh.triangles().iter().enumerate().map(begun).collect());
        }
        same_reports(whole, &turned, [light; 2], |mut reports| {
            for report in reports.iter_mut().filter(|report| is_mesh(&whole.objects[report.object])) {
                let turn =
                    |cell: &mut umbriel_shadow::Cell| cell.corner = (cell.corner + first(cell.face as usize) as u8) % 3;
                report.cells.iter_mut().for_each(turn);
            }
            reports
        });
        let places = any_places(whole, dice);
        let turned_place = |place: &Place| match *place {
            Place::Surface { object, face, u, v } if is_mesh(&whole.objects[object]) => {
                // Weights of the corners; 1 − u − v is exact.
                let weights = [1.0 - u - v, u, v];
                let [u, v] = [1, 2].map(|k| weights[(first(face) + k) % 3]);
                Place::Surface { object, face, u, v }
            }
            other => other,
        };
        let moved: Vec<Place> = places.iter().map(turned_place).collect();
        assert_eq!(queried(whole, light, &places), queried(&turned, light, &moved));
    });
}

/// Cells by both methods, samples, and many points at once.
fn everything_and_points(whole: &Scene, light: LightSource, places: &[[f64; 6]]) -> String {
    let points = Queries::new(whole).lit_many(Points::OrientedDouble(places), &light, &Silent);
    format!("{:?} {points:?}", everything(whole, light))
}

fn any_rows(dice: &mut Dice) -> Vec<[f64; 6]> {
    let mut row = |_| {
        let [x, y, z] = dice.grid_point(8, 0.5);
        let [nx, ny, nz] = dice.pick(&[[0.0, 1.0, 0.0], [0.25, -0.5, 1.0], [-1.0, 0.0, 0.0]]);
        [x, y, z, nx, ny, nz]
    };
    (0..200).map(&mut row).collect()
}

#[test]
fn any_simd_level() {
    judge(case_numbers(6), "levels", |whole, light, dice| {
        let rows = any_rows(dice);
        let at = |level: Level| {
            level.limit();
            everything_and_points(whole, light, &rows)
        };
        let [scalar, middle, widest] = Level::ALL.map(at);
        assert!(scalar == middle && middle == widest, "{scalar}\n{middle}\n{widest}");
    });
}

#[test]
fn one_thread_or_many() {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let (one, many) = (pool(1), pool(7));
    judge(case_numbers(6), "threads", |whole, light, dice| {
        let rows = any_rows(dice);
        let [alone, together] = [&one, &many].map(|pool| pool.install(|| everything_and_points(whole, light, &rows)));
        assert!(alone == together, "{alone}\n{together}");
    });
}

fn mapped(whole: &Scene, matrix: DMat3) -> Scene {
    let map = DAffine3::from_mat3(matrix);
    let moved =
        |object: &Object| with_sides(&object.name, object.shape.clone(), map * *object.placement.map(), object.sides);
    scene(whole.objects.iter().map(moved).collect())
}

fn mapped_light(light: &LightSource, matrix: DMat3) -> LightSource {
    let xyz = (matrix * light.xyz()).to_array();
    let mapped = if light.is_sun() { LightSource::sun(xyz.map(|c| -c)) } else { LightSource::point(xyz) };
    mapped.expect("a light")
}

#[test]
fn axes_exchanged_and_mirrored() {
    let maps = [
        DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
        DMat3::from_cols(DVec3::Z, DVec3::Y, DVec3::X),
        DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
        DMat3::from_diagonal(DVec3::new(-1.0, -1.0, -1.0)),
    ];
    judge(case_numbers(40), "axes", |whole, light, dice| {
        let matrix = dice.pick(&maps);
        let (moved, there) = (mapped(whole, matrix), mapped_light(&light, matrix));
        same_reports(whole, &moved, [light, there], |reports| reports);
        let places = any_places(whole, dice);
        assert_eq!(queried(whole, light, &places), queried(&moved, there, &places));
    });
}

#[test]
fn powers_of_two() {
    judge(case_numbers(10), "powers of two", |whole, light, dice| {
        let exponent = dice.pick(&[-120, -60, 60, 120, 180]);
        let matrix = DMat3::from_diagonal(DVec3::splat(2f64.powi(exponent)));
        let (scaled, there) = (mapped(whole, matrix), mapped_light(&light, matrix));
        let area = 4f64.powi(-exponent);
        same_reports(whole, &scaled, [light, there], |mut reports| {
            for report in &mut reports {
                let LitArea { lower, upper, estimate } = &mut report.lit;
                let sums = [&mut report.area, &mut report.area_error, lower, upper, estimate];
                sums.into_iter().for_each(|sum| *sum *= area);
            }
            reports
        });
        let places = any_places(whole, dice);
        assert_eq!(queried(whole, light, &places), queried(&scaled, there, &places));
    });
}

/// The scene with its meshes where their placements put them, on a grid that is fine enough to leave them their shapes; `None` where there are
/// none.
fn placed_on_grid(whole: &Scene) -> Option<Scene> {
    let on_grid = |coordinate: f64| (coordinate * 1_048_576.0).round() / 1_048_576.0;
    let mut placed = whole.clone();
    for object in placed.objects.iter_mut().filter(|object| is_mesh(object)) {
        let Shape::Mesh(mesh) = &object.shape else { continue };
        let place = |&local: &DVec3| object.placement.map().transform_point3(local).to_array().map(on_grid);
        let positions = mesh.positions().iter().map(place).collect();
        let shape = Shape::Mesh(Arc::new(Mesh::new(positions, mesh.triangles().to_vec()).expect("the same corners")));
        // What is cut keeps its sides: parts of a closed mesh are closed only together.
        *object = Object::new(object.name.clone(), shape, Placement::IDENTITY, Sides::Two).expect("a mesh");
    }
    placed.objects.iter().any(is_mesh).then_some(placed)
}

/// Every triangle of meshes on a grid cut in four at the middles of its sides, which are on a grid twice as fine.
fn cut_in_four(whole: &Scene) -> Scene {
    let mut changed = whole.clone();
    for object in &mut changed.objects {
        let Shape::Mesh(mesh) = &object.shape else { continue };
        let mut positions = Vec::new();
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|index| mesh.positions()[index as usize]);
            let first = positions.len() as u32;
            let middle = |p: DVec3, q: DVec3| (p + q) * 0.5;
            positions.extend([a, b, c, middle(a, b), middle(b, c), middle(c, a)].map(|p| p.to_array()));
            triangles.extend([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]].map(|part| part.map(|k| first + k)));
        }
        let shape = Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("short fractions")));
        *object = Object::new(object.name.clone(), shape, object.placement, object.sides).expect("the same surface");
    }
    changed
}

/// The same point of the scene that is cut; the parameters are short fractions.
fn in_part(whole: &Scene, place: &Place) -> Place {
    match *place {
        Place::Surface { object, face, u, v } if is_mesh(&whole.objects[object]) => {
            let (part, u, v) = match (u + v <= 0.5, u >= 0.5, v >= 0.5) {
                (true, _, _) => (0, 2.0 * u, 2.0 * v),
                (_, true, _) => (1, 2.0 * u - 1.0, 2.0 * v),
                (_, _, true) => (2, 2.0 * u, 2.0 * v - 1.0),
                // From the middle of ab: u' towards the middle of bc, v' towards that of ca.
                _ => (3, 2.0 * (u + v) - 1.0, 1.0 - 2.0 * u),
            };
            Place::Surface { object, face: 4 * face + part, u, v }
        }
        other => other,
    }
}

#[test]
fn triangles_cut_at_exact_points() {
    let (mut compared, mut proofs) = (0, 0);
    for number in case_numbers(60) {
        let mut dice = Dice::new("cut", number);
        let Some(whole) = placed_on_grid(&any_scene(&mut dice)) else { continue };
        let (light, cut) = (any_light(&whole, &mut dice), cut_in_four(&whole));
        compared += 1;
        let places = any_places(&whole, &mut dice);
        let moved: Vec<Place> = places.iter().map(|place| in_part(&whole, place)).collect();
        assert_eq!(queried(&whole, light, &places), queried(&cut, light, &moved), "scene {number}");
        let (before, after) = (sampled(&whole, light), sampled(&cut, light));
        for ((object, a), b) in whole.objects.iter().zip(&before).zip(&after) {
            // The lattices of meshes are others now.
            assert!(is_mesh(object) || (a.samples, &a.answers) == (b.samples, &b.answers), "scene {number}");
        }
        let (before, after) = (cells(&whole, light), cells(&cut, light));
        for (a, b) in before.iter().zip(&after) {
            assert!(a.lit.lower <= b.lit.upper && b.lit.lower <= a.lit.upper, "scene {number}: {a:?} {b:?}");
        }
        // What is proved of the one holds of the other.
        let queries = Queries::new(&cut);
        let proved = before.iter().flat_map(|report| report.cells.iter().map(move |cell| (report.object, cell)));
        for (object, cell) in proved.filter(|(_, cell)| cell.verdict != Verdict::Undecided) {
            let [u, v] = point_of(cell, has_triangles(&whole.objects[object].shape), &mut dice);
            let place = in_part(&whole, &Place::Surface { object, face: cell.face as usize, u, v });
            if let Ok(answer) = queries.lit(&place, &light) {
                proofs += 1;
                assert_eq!(answer.lit, cell.verdict == Verdict::Lit, "scene {number}: {object}, {cell:?} at {u}, {v}");
            }
        }
    }
    assert!(
        2 * compared > case_numbers(60).count() && proofs > 100 * compared,
        "{compared} scenes cut, {proofs} proofs"
    );
}

#[test]
fn an_object_that_cannot_matter() {
    let compared = Cell::new(0);
    judge(case_numbers(24), "bystander", |whole, light, dice| {
        // Farther from the light than everything, on the way that the light travels.
        let bounds = whole.objects.iter().map(Object::bounds).reduce(|a, b| a.union(b)).expect("an object");
        let reach = bounds.size().max_element().max(f64::MIN_POSITIVE);
        let way = if light.is_sun() { -light.xyz() } else { bounds.center() - light.xyz() };
        let Some(way) = way.try_normalize() else { return };
        let far = bounds.center() + way * (reach * 64.0);
        // Smaller than what it is taken from, which sets the spacing of samples.
        let size = whole.objects.iter().map(|object| object.bounds().size().max_element()).fold(0.0, f64::max) * 0.25;
        let tile = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let own = &whole.objects[dice.index(whole.objects.len())];
        let own_size = own.bounds().size().max_element().max(f64::MIN_POSITIVE);
        let unit = |shape: Shape| (shape, DMat3::from_diagonal(DVec3::splat(size)));
        let (shape, matrix) = match dice.below(5) {
            0 => unit(mesh(&tile, &[[0, 1, 2]])),
            1 => unit(cuboid(0.5, 1.0, 0.25)),
            2 => unit(sphere(0.5)),
            3 => unit(analytic(Analytic::Cone { radius: 0.25, height: 0.5 })),
            // One more of an object that is there.
            _ => (own.shape.clone(), own.placement.map().matrix3 * (size / own_size)),
        };
        let mut larger = whole.clone();
        let map = DAffine3 { matrix3: matrix, translation: far };
        let Ok(placement) = Placement::new(map) else { return };
        let Ok(bystander) = Object::new("bystander".to_owned(), shape, placement, Sides::Auto) else { return };
        larger.objects.push(bystander);
        let without = |mut reports: Vec<ObjectReport>| {
            reports.pop();
            reports
        };
        assert_eq!(cells(whole, light), without(cells(&larger, light)));
        assert_eq!(answers(&sampled(whole, light)), answers(&without(sampled(&larger, light))));
        let places = any_places(whole, dice);
        assert_eq!(queried(whole, light, &places), queried(&larger, light, &places));
        compared.set(compared.get() + 1);
    });
    assert!(compared.get() > case_numbers(24).count() / 2, "only {} bystanders", compared.get());
}
