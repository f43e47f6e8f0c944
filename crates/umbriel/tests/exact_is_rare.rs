//! Exact arithmetic is the rare path: on ordinary scenes floats, or pairs of them, settle all but a few decisions.
//!
//! One test alone, for decisions are counted over the whole process.

use std::{
    hint::black_box,
    path::{Path, PathBuf},
};

use glam::DVec3;
use umbriel_geometry::{Facets, LightSource, accept_point, decisions::Decisions};
use umbriel_io::{LoadOptions, load};
use umbriel_scene::{Light, Object, Scene};
use umbriel_shadow::{Detail, Place, Points, Queries, Request, Sampling, Silent, bake, for_each_sample};

/// The scenes of the repository and, where they are at hand, of public collections.
#[expect(clippy::print_stderr, reason = "what is skipped is said")]
fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let fixtures = root.join("fixtures").read_dir().expect("fixtures").map(|entry| entry.expect("an entry").path());
    let is_scene = |path: &PathBuf| {
        path.extension().is_some_and(|extension| ["toml", "obj", "gltf", "glb"].iter().any(|known| extension == *known))
    };
    let mut scenes: Vec<PathBuf> = fixtures.filter(is_scene).collect();
    scenes.push(root.join("fixtures/office/office.toml"));
    assert!(scenes.len() >= 16, "the fixtures are there");
    for name in ["delft-city/delft.obj", "spot/spot.obj", "bunny/stanford-bunny.obj", "cornell/cornell_box.obj"] {
        let path = root.join("../shared/data").join(name);
        if path.exists() {
            scenes.push(path);
        } else {
            eprintln!("skipped: the collection with {name} is not here");
        }
    }
    scenes
}

fn read(path: &Path) -> Scene {
    let mut scene = load(path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}")).scene;
    let sun = LightSource::sun([0.24, -0.7, 0.66]).expect("a sun");
    scene.lights.push(Light::new("one more sun", sun));
    scene
}

/// Samples asked for.
const SAMPLES: u64 = 20_000;

/// What some work decides.
fn decisions_of(work: impl FnOnce()) -> Decisions {
    let before = Decisions::of_process();
    work();
    Decisions::of_process() - before
}

/// Points of all surfaces, and as many in the box round them all.
fn places(scene: &Scene) -> (Vec<Place>, Vec<[f64; 3]>) {
    let request = Request { sampling: Some(Sampling::Count(SAMPLES / 4)), ..Request::everything(scene, Detail::Faces) };
    let (mut places, mut loose) = (Vec::new(), Vec::new());
    let bounds = scene.objects.iter().map(Object::bounds).reduce(|a, b| a.union(b)).expect("an object");
    for_each_sample(scene, &request, |sample| {
        places.push(Place::Surface { object: sample.object, face: sample.face, u: sample.u, v: sample.v });
        let share = [sample.u, sample.v, places.len() as f64 / SAMPLES as f64 * 4.0];
        loose.push((bounds.min + bounds.size() * DVec3::from_array(share)).to_array());
    });
    loose.retain(|point| accept_point(*point).is_ok());
    (places, loose)
}

/// Points of surfaces as files have them: rounded, with a normal. Not on edges, where the neighbour is as near as the face, and off the lattice of
/// samples, through which borders of shadows pass in round scenes.
fn oriented(scene: &Scene, places: &[Place]) -> Vec<[f64; 6]> {
    let facets: Vec<_> = scene.objects.iter().map(Object::facets).collect();
    let row = |place: &Place| {
        let &Place::Surface { object, face, u, v } = place else { return None };
        let [u, v] = [0.96 * u + 0.013, 0.94 * v + 0.017];
        let [position, normal] = match &facets[object] {
            Some(facets) => on_face(facets, face, [u, v])?,
            None => on_patch(&scene.objects[object], face, [u, v])?,
        };
        let [[x, y, z], [nx, ny, nz]] = [position, normal].map(|vector| vector.to_array());
        accept_point([x, y, z]).is_ok().then_some([x, y, z, nx, ny, nz])
    };
    places.iter().filter_map(row).collect()
}

/// A point of a flat face and its normal.
fn on_face(facets: &Facets, face: usize, [u, v]: [f64; 2]) -> Option<[DVec3; 2]> {
    let facet = facets.facet(face);
    let corners = facet.corners();
    let [a, b, c] = [0, 1, corners.len() - 1].map(|k| facets.positions()[corners[k] as usize]);
    Some([a + (b - a) * u + (c - a) * v, (b - a).cross(c - a).try_normalize()?])
}

/// A point of a patch and its outer normal.
fn on_patch(object: &Object, face: usize, [u, v]: [f64; 2]) -> Option<[DVec3; 2]> {
    let body = object.analytic().expect("what has no facets is analytic");
    let chart = &body.charts()[face];
    let point = chart.has_point(u, v).then(|| chart.bounded_point(body.placement(), u, v))?;
    let outward = body.outward_in(chart.surface, &point).map(|coordinate| coordinate.value);
    Some([point.position, DVec3::from_array(outward).try_normalize()?])
}

/// Fewer than one of 10,000.
fn is_rare(number: u64, all: u64) -> bool {
    number * 10_000 < all.max(10_000)
}

#[test]
fn exact_arithmetic_settles_fewer_than_one_decision_of_ten_thousand() {
    let mut wrong = Vec::new();
    for path in scenes() {
        let scene = read(&path);
        let cells = Request::everything(&scene, Detail::Depth { interior: 5, boundary: 5 });
        let samples =
            Request { sampling: Some(Sampling::Count(SAMPLES)), ..Request::everything(&scene, Detail::Faces) };
        let [cells, samples] = [cells, samples]
            .map(|request| decisions_of(|| drop(bake(&scene, &request, &Silent).expect("not cancelled"))));
        let (places, loose) = places(&scene);
        let queries = Queries::new(&scene);
        let lights = || scene.lights.iter().map(|light| &light.source);
        let points = decisions_of(|| {
            for light in lights() {
                places.iter().for_each(|place| _ = black_box(queries.lit(place, light).expect("a point of a face")));
                black_box(queries.lit_many(Points::FreeDouble(&loose), light, &Silent).expect("points"));
            }
        });
        let rows = oriented(&scene, &places);
        let oriented = decisions_of(|| {
            for light in lights() {
                black_box(queries.lit_many(Points::OrientedDouble(&rows), light, &Silent).expect("points"));
            }
        });
        assert!(points.all() > 0, "{}: {points:?}", path.display());
        let exact = |of: Decisions| of.expansion + of.exact;
        if ![cells, samples, points, oriented].into_iter().all(|of| is_rare(exact(of), of.all())) {
            wrong.push(format!(
                "{}: cells {cells:?}, samples {samples:?}, points {points:?}, with normals {oriented:?}",
                path.display()
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
