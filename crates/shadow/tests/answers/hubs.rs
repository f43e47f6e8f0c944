//! Triangles round one corner: their boxes all meet, but hardly one lies over another. They are no crowd, and a shadow of a closed form is found.

use std::{f64::consts::TAU, sync::Arc};

use umbriel_geometry::{LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, Request, Silent, bake};

const SIDES: u32 = 800;
/// Where the rim of the cone lies, its radius and the height of its tip, metres.
const RIM: f64 = 1.0;
const RADIUS: f64 = 5.0;
const TIP: f64 = 6.0;

/// A corner of the rim.
fn rim(k: u32) -> [f64; 2] {
    let angle = TAU * f64::from(k % SIDES) / f64::from(SIDES);
    [RADIUS * libm::cos(angle), RADIUS * libm::sin(angle)]
}

/// A closed cone: its sides and its bottom meet in a corner each.
fn cone() -> Mesh {
    let [tip, middle] = [SIDES, SIDES + 1];
    let corners = (0..SIDES).map(rim).map(|[x, z]| [x, RIM, z]);
    let positions = corners.chain([[0.0, TIP, 0.0], [0.0, RIM, 0.0]]).collect();
    let sides = (0..SIDES).map(|k| [k, tip, (k + 1) % SIDES]);
    let bottom = (0..SIDES).map(|k| [k, (k + 1) % SIDES, middle]);
    Mesh::new(positions, sides.chain(bottom).collect()).expect("a cone")
}

/// The area of the hull of the rim and of another point: to the rim's own are added the triangles over the edges that the point sees.
fn area_of_hull(point: [f64; 2]) -> f64 {
    let doubled = |[a, b]: [[f64; 2]; 2], c: [f64; 2]| {
        let along = |to: [f64; 2]| [to[0] - a[0], to[1] - a[1]];
        let ([x, y], [z, w]) = (along(b), along(c));
        x * w - y * z
    };
    let edges = || (0..SIDES).map(|k| [rim(k), rim(k + 1)]);
    let own: f64 = edges().map(|edge| doubled(edge, [0.0, 0.0])).sum();
    let seen: f64 = edges().map(|edge| (-doubled(edge, point)).max(0.0)).sum();
    0.5 * (own + seen)
}

#[test]
fn a_cone_of_many_sides_over_a_floor_is_no_crowd() {
    let object = |name: &str, shape| Object::new(name.into(), shape, Placement::IDENTITY, Sides::Auto);
    let floor = Shape::Rectangle(Rectangle { size: [40.0; 2] });
    let objects = [object("floor", floor), object("cone", Shape::Mesh(Arc::new(cone())))];
    let sun = LightSource::sun([1.5, -1.0, 0.5]).expect("a sun");
    let objects = objects.map(|object| object.expect("an object")).into();
    let scene = Scene { objects, lights: vec![Light::new("sun", sun)], ..Scene::default() };
    let detail = Detail::Depth { interior: 3, boundary: 8 };
    let report = bake(&scene, &Request::everything(&scene, detail), &Silent).expect("nobody cancels");
    assert_eq!(report.work.objects_crowded, 0);
    // The tip's shadow as seen from the shadow of the rim's middle.
    let along = TIP - RIM;
    let truth = 1600.0 - area_of_hull([1.5 * along, 0.5 * along]);
    let lit = report.lights[0].objects[0].lit;
    assert!(lit.lower <= truth && truth <= lit.upper && lit.upper - lit.lower < 5.0, "{lit:?}, {truth} by a formula");
    let undecided = report.lights[0].objects[1].undecided();
    assert!(undecided < 0.01, "{undecided} m² of the cone");
}
