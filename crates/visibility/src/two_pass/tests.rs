use std::sync::Arc;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, Mesh, Placement, Rectangle, decisions::Decisions};
use umbriel_scene::Sides;

use super::*;

fn object(shape: Shape, at: DVec3) -> Object {
    let placement = Placement::new(DAffine3::from_translation(at)).expect("regular");
    Object::new(String::new(), shape, placement, Sides::Auto).expect("a body")
}

fn floor() -> Object {
    object(Shape::Rectangle(Rectangle { size: [10.0, 10.0] }), DVec3::ZERO)
}

fn cube(size: [f64; 3], at: [f64; 3]) -> Object {
    object(Shape::Cuboid(Cuboid { size }), at.into())
}

fn cast(objects: Vec<Object>, light: &LightSource) -> ShadowPolygons {
    ShadowPolygons::cast(&Scene { objects: objects.into(), ..Scene::default() }, light).expect("polygons")
}

fn near(found: (f64, f64), truth: f64) {
    assert!((found.0 - truth).abs() <= found.1, "{found:?}, should be {truth}");
    assert!(found.1 < 1e-4 * truth.max(1.0), "the bound is wide: {found:?}");
}

#[test]
fn a_box_shadows_a_floor_as_formulas_say() {
    let objects = || vec![floor(), cube([2.0, 1.0, 1.5], [0.0, 2.0, 0.0])];
    let noon = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    near(cast(objects(), &noon).lit_area(0), 100.0 - 3.0);
    // The sides are edge-on: of the box the top alone is lit.
    near(cast(objects(), &noon).lit_area(1), 3.0);
    // From (0, 5, 0) the lower side at 1.5 is the larger shadow: 5/3.5 times each way, the upper one 5/2.5 times.
    let lamp = LightSource::point([0.0, 5.0, 0.0]).expect("a lamp");
    near(cast(objects(), &lamp).lit_area(0), 100.0 - 2.0 * 2.0 * 1.5 * 2.0);
    // A slanted sun: the hull of two rectangles 2 × 1.5 moved by (0.5, 0.25): 3 + 2·0.25 + 1.5·0.5.
    let slant = LightSource::sun([0.5, -1.0, 0.25]).expect("a sun");
    near(cast(objects(), &slant).lit_area(0), 100.0 - (3.0 + 0.5 + 0.75));
}

#[test]
fn shadows_unite_and_end_at_the_border() {
    // Two boxes whose shadows overlap by a half, and one whose shadow leaves the floor.
    let noon = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    let boxes = [[0.0, 1.0, 0.0], [0.5, 3.0, 0.0], [5.0, 1.0, 0.0]].map(|at| cube([1.0; 3], at));
    let shadows = cast(std::iter::once(floor()).chain(boxes).collect(), &noon);
    near(shadows.lit_area(0), 100.0 - 1.5 - 0.5);
    let face = &shadows.faces[0];
    assert_eq!((face.shadow.len(), face.is_turned), (2, true));
    let shadow: f64 = face.shadow.iter().flatten().map(|contour| area_of(contour)).sum();
    near((shadow, face.error), 2.0);
    for (point, is_lit) in
        [([0.25, 0.0, 0.25], false), ([0.9, 0.0, 0.0], false), ([2.0, 0.0, 0.0], true), ([4.75, 0.0, 0.0], false)]
    {
        let at = face.coordinates(DVec3::from_array(point));
        assert_eq!(face.is_lit(at), is_lit, "{point:?}");
        assert!(face.point(at).distance(DVec3::from_array(point)) < 1e-12);
    }
}

#[test]
fn what_goes_through_the_floor_shadows_what_is_above() {
    // The lower half of the box is under the floor and shadows nothing of it but in contact.
    let slant = LightSource::sun([1.0, -1.0, 0.0]).expect("a sun");
    let shadows = cast(vec![floor(), cube([2.0; 3], [0.0; 3])], &slant);
    // The section of 2 × 2, and the shadow of height 1 beside it.
    near(shadows.lit_area(0), 100.0 - 4.0 - 2.0);
    let lamp = LightSource::point([0.0, 0.5, 0.0]).expect("a lamp inside");
    near(cast(vec![floor(), cube([2.0; 3], [0.0; 3])], &lamp).lit_area(0), 4.0);
}

#[test]
fn curved_bodies_are_refused() {
    let ball = object(Shape::from(Analytic::Sphere { radius: 1.0 }), DVec3::Y);
    let scene = Scene { objects: [floor(), ball].into(), ..Scene::default() };
    let sun = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    assert_eq!(ShadowPolygons::cast(&scene, &sun), Err(TwoPassDefect::Curved { object: 1 }));
}

#[test]
fn what_lies_in_the_plane_of_a_face_covers_nothing_of_it() {
    // Numbers of 45 digits, so that sums of some of them are floats: all three corners of the cover are points of the face.
    let short = |x: f64| (x * 2f64.powi(44)).round() / 2f64.powi(44);
    let noon = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    for turn in 0..12 {
        let angle = 0.35 + f64::from(turn) * 0.7;
        let p = DVec3::new(1.1, 2.3, 0.7).map(short);
        let s = DVec3::new(angle.cos(), 0.3, angle.sin()).map(short);
        let t = DVec3::new(-angle.sin(), 0.1, angle.cos()).map(short);
        let floor = triangle([p, p + s * 4.0, p + t * 4.0]);
        let is_projected = |places: i64| {
            let mut corners = [p + s + t, p + s * 2.0 + t, p + s + t * 2.0];
            corners[1].y = f64::from_bits(corners[1].y.to_bits().wrapping_add_signed(places));
            Receiver::new(&floor, 0, &noon).project(&triangle(corners), 0).is_some()
        };
        let before = Decisions::of_thread();
        assert!(!is_projected(0), "{turn}");
        let decisions = Decisions::of_thread() - before;
        assert!(decisions.expansion > 0, "{turn}: {decisions:?}");
        assert_eq!([-1, 1].map(is_projected), [false, true], "{turn}: an ulp below, an ulp above");
    }
}

fn triangle(corners: [DVec3; 3]) -> Facets {
    let mesh = Mesh::new(corners.map(|corner| corner.to_array()).to_vec(), vec![[0, 1, 2]]).expect("a mesh");
    Facets::of_mesh(Arc::new(mesh), &Placement::IDENTITY)
}
