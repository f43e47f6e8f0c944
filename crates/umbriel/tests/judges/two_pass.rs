//! Lit areas from shadow polygons, which know nothing of cells, lie inside the pipeline's bounds on every fixture of polygons.

use crate::stored;
use umbriel::{
    geometry::LightSource,
    io::{LoadOptions, load},
    scene::{Light, Scene},
    shadow::{Detail, Request, Silent, bake},
    visibility::two_pass::ShadowPolygons,
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

#[test]
fn shadow_polygons_agree_with_the_bounds() {
    let (mut compared, mut partly) = (0, 0);
    for path in stored::scenes() {
        let scene = lit(load(&path, &LoadOptions::default()).expect("a fixture").scene);
        let lights: Vec<LightSource> = scene.lights.iter().map(|light| light.source).collect();
        let Ok(shadows) = lights.iter().map(|light| ShadowPolygons::cast(&scene, light)).collect::<Result<Vec<_>, _>>()
        else {
            continue;
        };
        let request = Request::everything(&scene, Detail::Depth { interior: 6, boundary: 6 });
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
    assert!(compared > 100 && partly > 50, "{compared} objects were compared, {partly} of them partly lit");
}
