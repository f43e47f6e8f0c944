//! Hours against closed forms, against single bakes, and in any order.

use super::*;
use crate::{Detail, Sampling, Silent, bake};
use glam::DVec3;
use umbriel_geometry::{Analytic, Placement, Rectangle};
use umbriel_scene::{Light, Object, Shape, Sides};

const HOUR: Duration = Duration::from_secs(3600);

fn object(name: &str, shape: Shape, at: [f64; 3]) -> Object {
    let placement = Placement::new(glam::DAffine3::from_translation(at.into())).expect("regular");
    Object::new(name.into(), shape, placement, Sides::Auto).expect("a body")
}

/// A floor of 8 × 8 m, and a plate of 2 × 1 m two metres above its middle.
fn plate_over_floor() -> Scene {
    let rectangle = |size| Shape::Rectangle(Rectangle { size });
    let objects =
        vec![object("floor", rectangle([8.0, 8.0]), [0.0; 3]), object("plate", rectangle([2.0, 1.0]), [0.0, 2.0, 0.0])];
    Scene { objects: objects.into(), ..Scene::default() }
}

/// Directions whose shadows of the plate end on borders of cells, with their durations.
fn suns() -> Vec<TimedLight> {
    let directions = [[0.0, -1.0, 0.0], [1.0, -1.0, 0.0], [-0.5, -1.0, 0.25], [0.5, -1.0, 0.5], [1.0, -2.0, 1.0]];
    let minutes = [60, 20, 7, 90, 1];
    let sun = |direction| LightSource::sun(direction).expect("a sun");
    let lights = directions.iter().zip(minutes);
    lights.map(|(&to, minutes)| TimedLight { source: sun(to), duration: HOUR / 60 * minutes }).collect()
}

/// Whether a floor point is in the plate's shadow: by how far it is inside, negative outside.
fn depth_in_shadow(light: &TimedLight, x: f64, z: f64) -> f64 {
    let to_light = light.source.xyz();
    let at = DVec3::new(x, 0.0, z) + to_light * (2.0 / to_light.y);
    (1.0 - at.x.abs()).min(0.5 - at.z.abs())
}

fn request(scene: &Scene, interior: u8, boundary: u8) -> Request {
    Request { keep_cells: true, ..Request::everything(scene, Detail::Depth { interior, boundary }) }
}

fn hours_of(scene: &Scene, request: &Request, lights: &[TimedLight]) -> HoursReport {
    bake_hours(scene, request, lights, &Silent).expect("not cancelled")
}

/// The middle of a floor cell in the plane, and its edge. The floor's u runs along x, its v against z.
fn on_floor(cell: &HourCell) -> ([f64; 2], f64) {
    let edge = 8.0 / f64::from(1u32 << cell.level);
    ([-4.0 + (f64::from(cell.i) + 0.5) * edge, 4.0 - (f64::from(cell.j) + 0.5) * edge], edge)
}

#[test]
fn every_cell_has_the_hours_of_the_shadow_rectangles() {
    let (scene, suns) = (plate_over_floor(), suns());
    for interior in [2, 5] {
        let report = hours_of(&scene, &request(&scene, interior, 5), &suns);
        let mut area = 0.0;
        for cell in report.objects[0].cells.iter() {
            let ([x, z], edge) = on_floor(&cell);
            area += edge * edge;
            // Lit all over, in shadow all over, or cut by the shadow's border (touched counts as cut).
            let time = |is: &dyn Fn(f64) -> bool| -> Duration {
                suns.iter().filter(|sun| is(depth_in_shadow(sun, x, z))).map(|sun| sun.duration).sum()
            };
            let half = edge / 2.0;
            let (lit, dark) = (time(&|depth| depth < -half), time(&|depth| depth >= half));
            assert!(cell.lower <= lit && report.duration - dark <= cell.upper, "{cell:?}");
            if interior == 5 {
                // A square outside the shadow by more than its edge in the plane is proved; inside alike.
                let surely_lit = time(&|depth| depth < -3.0 * half);
                let surely_dark = time(&|depth| depth > half);
                assert!(cell.lower >= surely_lit && cell.upper <= report.duration - surely_dark, "{cell:?}");
            }
        }
        assert_eq!(area, 64.0);
    }
}

#[test]
fn the_mean_holds_the_truth() {
    let (scene, suns) = (plate_over_floor(), suns());
    let report = hours_of(&scene, &request(&scene, 8, 8), &suns);
    let total = hours(report.duration);
    // The plate's shadow keeps its 2 m²; all suns reach one side of the plate.
    let truth = total * (1.0 - 2.0 / 64.0);
    let floor = report.objects[0].lit_hours;
    assert!(floor.lower <= truth && truth <= floor.upper && floor.upper - floor.lower < 0.02 * total, "{floor:?}");
    assert!((floor.lower..=floor.upper).contains(&floor.estimate));
    let plate = report.objects[1].lit_hours;
    assert!(plate.lower <= total && plate.upper == total && total - plate.lower < 1e-12, "{plate:?}");
    let lit = report.objects[0].lit_area_hours;
    assert!(lit.lower <= truth * 64.0 && truth * 64.0 <= lit.upper);
}

#[test]
fn the_sum_is_that_of_single_bakes() {
    let mut scene = plate_over_floor();
    scene.objects.push(object("ball", Shape::from(Analytic::Sphere { radius: 1.0 }), [2.0, 1.5, 1.0]));
    let (suns, request) = (suns(), Request { sampling: Some(Sampling::Count(500)), ..request(&scene, 4, 5) });
    let report = hours_of(&scene, &request, &suns);
    scene.lights = suns.iter().map(|sun| Light::new(String::new(), sun.source)).collect();
    let single = bake(&scene, &Request { lights: (0..suns.len()).collect(), ..request }, &Silent).expect("done");
    // Fallbacks are counted in the whole process, other tests included.
    let counted = |work| Work { exact_fallbacks: 0, ..work };
    assert_eq!(counted(report.work), counted(single.work));
    for (place, object) in report.objects.iter().enumerate() {
        let sum = |value: fn(&ObjectReport) -> f64| {
            let mut sum = ExactSum::default();
            let reports = single.lights.iter().map(|light| &light.objects[place]);
            reports.zip(&suns).for_each(|(report, sun)| sum.add_product(value(report), sun.duration.as_secs()));
            sum.nearest() / 3600.0
        };
        let (lower, upper) = (sum(|report| report.lit.lower), sum(|report| report.lit.upper));
        let bounds = object.lit_area_hours;
        let ulps = |value: f64| value * (8.0 * f64::EPSILON);
        assert!(bounds.lower <= lower && lower - bounds.lower <= ulps(lower), "{} is not {lower}", bounds.lower);
        assert!(bounds.upper >= upper && bounds.upper - upper <= ulps(upper), "{} is not {upper}", bounds.upper);
        let lit = sum(|report| report.samples.expect("samples").lit as f64);
        let samples = object.samples.expect("samples");
        assert!((samples.mean * samples.samples as f64 - lit).abs() <= ulps(lit), "{samples:?}");
    }
    for (summary, light) in report.lights.iter().zip(&single.lights) {
        let lower: f64 = light.objects.iter().map(|object| object.lit.lower).sum();
        assert!((summary.lit.lower - lower).abs() < 1e-12 * lower);
    }
}

#[test]
fn the_order_of_the_lights_changes_nothing() {
    let mut scene = plate_over_floor();
    let cone = Shape::from(Analytic::Cone { radius: 1.0, height: 2.0 });
    scene.objects.push(object("cone", cone, [-2.0, 1.0, 1.0]));
    let request = request(&scene, 3, 5);
    let forth = suns();
    let mut back = suns();
    back.reverse();
    let [forth, back] = [forth, back].map(|suns| hours_of(&scene, &request, &suns));
    for (one, other) in forth.objects.iter().zip(&back.objects) {
        assert_eq!((one.lit_hours, one.lit_area_hours), (other.lit_hours, other.lit_area_hours));
        assert!(one.cells.iter().eq(other.cells.iter()));
    }
    assert!(forth.objects.iter().map(|object| object.cells.len()).sum::<usize>() > 50);
}

#[test]
fn no_light_means_no_hours() {
    let scene = plate_over_floor();
    let report = hours_of(&scene, &request(&scene, 3, 3), &[]);
    assert_eq!((report.lights.len(), report.duration), (0, Duration::ZERO));
    let floor = &report.objects[0];
    assert_eq!((floor.area, floor.lit_hours), (64.0, HourBounds::default()));
    assert_eq!((floor.cells.len(), floor.cells.iter().map(|cell| cell.upper).max()), (1, Some(Duration::ZERO)));
}

#[test]
fn durations_are_limited() {
    let long = TimedLight { duration: Duration::from_secs(1 << 34), ..suns()[0] };
    let scene = plate_over_floor();
    let bake = |lights: &[TimedLight]| bake_hours(&scene, &request(&scene, 0, 0), lights, &Silent).map(|_| ());
    assert_eq!(bake(&[long]), Ok(()));
    assert_eq!(bake(&[long, long]), Err(HoursError::TooLong));
    assert_eq!(bake(&[TimedLight { duration: Duration::MAX, ..long }]), Err(HoursError::TooLong));
}
