//! Lit areas from shadow polygons, which know nothing of cells, lie inside the pipeline's bounds on every fixture of polygons; and what is looked up in them, from
//! wherever it is seen, is what exact queries say.

use std::path::Path;

use glam::DVec3;

use crate::stored;
use umbriel::{
    geometry::LightSource,
    io::{LoadOptions, load},
    scene::{Light, Scene, Shape},
    shadow::{Detail, Place, Queries, Request, Silent, bake, reached_receivers},
    visibility::{
        RayCaster, View,
        two_pass::{FaceShadow, ShadowPolygons, TwoPassDefect},
    },
};

/// The lights of the scene, a slanted sun, and a lamp a little above its middle.
fn lit(mut scene: Scene) -> Scene {
    let bounds = scene.objects.iter().map(|object| object.bounds());
    let bounds = bounds.reduce(|all, own| all.union(own)).expect("objects");
    let above = bounds.center() + bounds.size() * glam::DVec3::new(0.11, 0.83, -0.07);
    scene.lights.push(Light::new("slant", LightSource::sun([0.45, -1.0, 0.3]).expect("a sun")));
    scene.lights.push(Light::new("above", LightSource::point(above.to_array()).expect("a lamp")));
    scene
}

/// The fixtures that have no shadow polygons: curved bodies, and triangles that a texture cuts out.
const REFUSED: [&str; 8] =
    ["ball-over-floor", "bodies", "eclipse-annular", "eclipse-total", "house", "lattice", "placed", "scattered"];

/// A scene by its file, the lights that are cast, and the receivers that are compared: in a scene with cells one lamp, and what it reaches.
fn case(path: &Path) -> (Scene, Vec<usize>, Vec<usize>) {
    let scene = load(path, &LoadOptions::default()).expect("a fixture").scene;
    if scene.cells.is_empty() {
        let scene = lit(scene);
        let (lights, receivers) = ((0..scene.lights.len()).collect(), (0..scene.objects.len()).collect());
        return (scene, lights, receivers);
    }
    let reached = reached_receivers(&scene, &[0]);
    let objects = reached.iter().map(|&object| scene.objects[object].clone()).collect();
    let part = Scene { objects, lights: scene.lights[..1].to_vec(), ..Scene::default() };
    (part, vec![0], (0..reached.len()).collect())
}

/// The shadow polygons of a fixture, or its name among those that are refused for a reason.
fn shadows_of(path: &Path, scene: &Scene, lights: &[usize], refused: &mut Vec<String>) -> Option<Vec<ShadowPolygons>> {
    let cast = lights.iter().map(|&light| ShadowPolygons::cast(scene, &scene.lights[light].source));
    match cast.collect::<Result<Vec<_>, _>>() {
        Ok(shadows) => Some(shadows),
        Err(TwoPassDefect::Curved { object } | TwoPassDefect::Holes { object }) => {
            let shape = &scene.objects[object].shape;
            let is_flat =
                !matches!(shape, Shape::Analytic(_)) && !matches!(shape, Shape::Mesh(mesh) if mesh.has_holes());
            assert!(!is_flat, "{}: an object of flat faces is refused", path.display());
            refused.push(path.file_stem().expect("a name").to_string_lossy().into_owned());
            None
        }
        Err(other) => panic!("{}: {other}", path.display()),
    }
}

/// Points that were looked up.
#[derive(Default)]
struct LookedUp {
    asked: usize,
    lit: usize,
    beside_borders: usize,
}

impl LookedUp {
    /// Looks up what two eyes see. The polygons were cast before there was an eye, and serve both.
    fn look(&mut self, name: &str, scene: &Scene, lights: &[usize], shadows: &[ShadowPolygons]) {
        let (queries, caster) = (Queries::new(scene), RayCaster::new(scene));
        for (turn, elevation) in [(30.0, 35.0), (-130.0, 60.0)] {
            let view = View::around(scene, turn, elevation, 24, 18);
            let rays = (0..24 * 18).map(|k| view.ray(f64::from(k % 24) + 0.5, f64::from(k / 24) + 0.5));
            for (ray, hit) in rays.filter_map(|ray| Some((ray, caster.nearest(&ray)?))) {
                let point = ray.origin + hit.distance * ray.direction;
                for (&light, shadows) in lights.iter().zip(shadows) {
                    let face = shadows.of(hit.object, hit.face).expect("a face that is seen has area");
                    let Some(answer) = settled(face, point) else {
                        self.beside_borders += 1;
                        continue;
                    };
                    let place = Place::Surface { object: hit.object, face: hit.face, u: hit.u, v: hit.v };
                    let Ok(exact) = queries.lit(&place, &scene.lights[light].source) else { continue };
                    let (object, light) = (&scene.objects[hit.object].name, &scene.lights[light].name);
                    assert_eq!(answer, exact.lit, "{name}, {object} face {} at {point} under {light}", hit.face);
                    self.asked += 1;
                    self.lit += usize::from(answer);
                }
            }
        }
    }
}

/// Whether a point is lit; nothing where it is so near to a border that its rounding may put it on either side.
fn settled(face: &FaceShadow, point: DVec3) -> Option<bool> {
    let [u, v] = face.coordinates(point);
    let answer = face.is_lit([u, v]);
    let near = 1e-9 * (1.0 + point.abs().max_element());
    let around = [[near, 0.0], [-near, 0.0], [0.0, near], [0.0, -near]];
    around.iter().all(|by| face.is_lit([u + by[0], v + by[1]]) == answer).then_some(answer)
}

#[test]
fn shadow_polygons_agree_with_the_bounds() {
    let (mut compared, mut partly) = (0, 0);
    let (mut refused, mut looked_up) = (Vec::new(), LookedUp::default());
    for path in stored::scenes() {
        let (scene, lights, receivers) = case(&path);
        let Some(shadows) = shadows_of(&path, &scene, &lights, &mut refused) else { continue };
        looked_up.look(&path.display().to_string(), &scene, &lights, &shadows);
        let detail = Detail::Depth { interior: 6, boundary: 6 };
        let request = Request { lights, receivers, ..Request::everything(&scene, detail) };
        let report = bake(&scene, &request, &Silent).expect("nobody cancels");
        for (light, shadows) in report.lights.iter().zip(&shadows) {
            for object in &light.objects {
                let (area, error) = shadows.lit_area(object.object);
                let named = || {
                    let (object, light) = (&scene.objects[object.object].name, &scene.lights[light.light].name);
                    format!("{}, {object} under {light}", path.display())
                };
                // Sums of floats over the faces.
                let slack = error + object.area_error + 1e-9 * object.area;
                let is_inside = object.lit.lower - slack <= area && area <= object.lit.upper + slack;
                assert!(is_inside, "{}: {area} ± {slack} is not in {:?}", named(), object.lit);
                assert!(error <= 1e-3 * object.area, "{}: the error {error} of {} says nothing", named(), object.area);
                compared += 1;
                partly += usize::from(area > 0.01 * object.area && area < 0.99 * object.area);
            }
        }
    }
    assert_eq!(refused, REFUSED);
    let LookedUp { asked, lit, beside_borders } = looked_up;
    assert!(asked > 2_500 && lit > 500 && lit < asked - 500, "{asked} points, {lit} of them lit");
    assert!(beside_borders * 20 < asked, "{beside_borders} of {asked} points are beside borders");
    assert!(compared > 100 && partly > 50, "{compared} objects were compared, {partly} of them partly lit");
}
