//! Bounds of cells under area lights: against closed forms, and against what points of the cells see.

use std::{f64::consts::PI, sync::Arc, time::Duration};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Extent, Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{AreaBounds, Detail, Place, Queries, Silent, SoftCell, SoftObject, SoftRequest, soft_bake};

use crate::dice::Dice;

fn object(name: &str, shape: Shape, map: DAffine3) -> Object {
    let placement = Placement::new(map).expect("regular");
    Object::new(name.into(), shape, placement, Sides::Auto).expect("a body")
}

fn floor(edge: f64) -> Object {
    object("floor", Shape::Rectangle(Rectangle { size: [edge; 2] }), DAffine3::IDENTITY)
}

fn lamp(center: DVec3, extent: Extent) -> Light {
    Light::with_extent("lamp", LightSource::point(center.to_array()).expect("a point"), extent).expect("a light")
}

fn sun(direction: [f64; 3], angular_diameter: f64) -> Light {
    let source = LightSource::sun(direction).expect("a sun");
    Light::with_extent("sun", source, Extent::Disk { angular_diameter }).expect("a light")
}

/// The first object under the only light.
fn first(scene: &Scene, depth: u8, keep_cells: bool) -> SoftObject {
    let detail = Detail::Depth { interior: depth, boundary: depth };
    let request = SoftRequest { receivers: vec![0], keep_cells, ..SoftRequest::everything(scene, detail) };
    soft_bake(scene, &request, &Silent).expect("done").remove(0).objects.remove(0)
}

fn assert_holds(bounds: AreaBounds, truth: f64, what: &str) {
    assert!(bounds.lower <= truth && truth <= bounds.upper, "{what}: {truth} is not in {bounds:?}");
}

#[test]
fn a_rectangle_under_a_parallel_rectangle() {
    // The plate stands at 3/8 of the light's height: its shadow is 8/5 as large, blurred by 3/5 of the light.
    let plate =
        object("plate", Shape::Rectangle(Rectangle { size: [3.0; 2] }), DAffine3::from_translation(DVec3::Y * 3.0));
    let light = lamp(DVec3::Y * 8.0, Extent::Rectangle { u: DVec3::X, v: DVec3::Z * 0.5 });
    let scene = Scene { objects: [floor(16.0), plate].into(), lights: vec![light], ..Scene::default() };
    let (umbra, reached) = (4.0 * 1.8 * 2.1, 4.0 * 3.0 * 2.7);
    let mut widths = Vec::new();
    for depth in [4, 6, 8] {
        let found = first(&scene, depth, false);
        assert_holds(found.umbra, umbra, "umbra");
        assert_holds(found.penumbra, reached - umbra, "penumbra");
        assert_holds(found.lit, 256.0 - reached, "lit");
        // Every point of the light throws the same shadow.
        let seen = AreaBounds { lower: found.visible.lower, upper: found.visible.upper };
        assert_holds(seen, 256.0 - 9.0 * 2.56, "mean");
        widths.push(seen.upper - seen.lower);
    }
    assert!(widths[1] < 0.4 * widths[0] && widths[2] < 0.4 * widths[1], "bounds shrink: {widths:?}");
    assert!(widths[2] < 0.005 * 256.0, "half a per cent of the floor: {widths:?}");
}

#[test]
fn shares_times_and_memory_are_details() {
    let plate =
        object("plate", Shape::Rectangle(Rectangle { size: [3.0; 2] }), DAffine3::from_translation(DVec3::Y * 3.0));
    let light = lamp(DVec3::Y * 8.0, Extent::Rectangle { u: DVec3::X, v: DVec3::Z * 0.5 });
    let scene = Scene { objects: [floor(16.0), plate].into(), lights: vec![light.clone(), light], ..Scene::default() };
    let truth = 256.0 - 9.0 * 2.56;
    let open = |detail| {
        let request = SoftRequest { keep_cells: true, ..SoftRequest::everything(&scene, detail) };
        let report = soft_bake(&scene, &request, &Silent).expect("done");
        assert_eq!(report.len(), 2);
        for light in &report {
            let seen = light.objects[0].visible;
            assert!(seen.lower <= truth && truth <= seen.upper, "{detail:?}: {seen:?}");
        }
        let cells = report[0].objects.iter().map(|object| object.cells.len()).sum::<usize>();
        (report[0].objects.iter().map(|object| object.visible.upper - object.visible.lower).sum::<f64>(), cells)
    };
    for share in [0.1, 0.02] {
        assert!(open(Detail::MaxUndecided { share }).0 <= share * (256.0 + 9.0));
    }
    let bytes = [1, 10_000, 100_000].map(|bytes| (bytes, open(Detail::Memory { bytes })));
    let bytes_first = bytes[0].1.1;
    for (bytes, (_, cells)) in bytes {
        // The first look is taken whatever it costs.
        assert!(cells == bytes_first || cells * size_of::<SoftCell>() <= bytes as usize, "{bytes}: {cells}");
    }
    assert!(bytes[2].1.0 < bytes[1].1.0 && bytes[1].1.0 < bytes[0].1.0, "{bytes:?}");
    let times = [0, 5, 1000].map(|millis| open(Detail::Time { limit: Duration::from_millis(millis) }).0);
    assert!(times[0] >= times[1] && times[1] >= times[2], "more time is never worse: {times:?}");
    assert!(times[2] < times[0], "{times:?}");
}

#[test]
fn a_ball_under_a_ball_of_light() {
    let (light_radius, light_height, radius, height) = (0.5, 10.0, 1.0, 3.0);
    let ball = object("ball", Shape::from(Analytic::Sphere { radius }), DAffine3::from_translation(DVec3::Y * height));
    let light = lamp(DVec3::Y * light_height, Extent::Sphere { radius: light_radius });
    let scene = Scene { objects: [floor(8.0), ball].into(), lights: vec![light], ..Scene::default() };
    let between = light_height - height;
    let tangent = |sine: f64| sine / (1.0f64 - sine * sine).sqrt();
    let umbra =
        (light_height + between * light_radius / (radius - light_radius)) * tangent((radius - light_radius) / between);
    let reached =
        (light_height - between * light_radius / (radius + light_radius)) * tangent((radius + light_radius) / between);
    let mut widths = Vec::new();
    for depth in [4, 6, 8] {
        let found = first(&scene, depth, false);
        assert_holds(found.umbra, PI * umbra * umbra, "umbra");
        assert_holds(found.penumbra, PI * (reached * reached - umbra * umbra), "penumbra");
        assert_holds(found.lit, 64.0 - PI * reached * reached, "lit");
        widths.push(found.visible.upper - found.visible.lower);
    }
    assert!(widths[1] < 0.5 * widths[0] && widths[2] < 0.5 * widths[1], "bounds shrink: {widths:?}");
}

impl Dice {
    /// Triangles in no order.
    fn soup(&mut self) -> Shape {
        let positions = (0..12).map(|_| self.vector(-0.8, 0.8).to_array()).collect();
        let triangles = (0..4).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")))
    }

    /// A closed body of triangles.
    fn tetrahedron(&mut self) -> Shape {
        let positions = (0..4).map(|_| self.vector(-0.9, 0.9).to_array()).collect();
        Shape::Mesh(Arc::new(Mesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).expect("a mesh")))
    }

    /// A body that lies between two polyhedra.
    fn curved(&mut self, kind: usize) -> Analytic {
        let (radius, height) = (self.next(0.3, 0.9), self.next(0.3, 1.0));
        match kind % 7 {
            0 => Analytic::Cylinder { radius, height },
            1 => Analytic::Cone { radius, height },
            2 => Analytic::Capsule { radius: 0.5 * radius, height },
            3 => Analytic::Ellipsoid { radii: [radius, 0.5 * height, 1.5 * radius] },
            4 => Analytic::Paraboloid { radius, height },
            5 => Analytic::Frustum { bottom_radius: radius, top_radius: 0.3, height },
            _ => Analytic::Hyperboloid { waist_radius: 0.5 * radius, end_radius: radius, height },
        }
    }

    fn occluder(&mut self, kind: usize) -> Object {
        let shape = match kind % 6 {
            0 => Shape::Cuboid(Cuboid { size: self.vector(0.3, 1.8).to_array() }),
            1 => self.soup(),
            2 => Shape::Rectangle(Rectangle { size: [self.next(0.3, 2.0), self.next(0.3, 2.0)] }),
            3 => self.tetrahedron(),
            4 => Shape::from(Analytic::Sphere { radius: self.next(0.2, 0.9) }),
            _ => Shape::from(self.curved(kind / 6)),
        };
        // Some reach through the floor.
        let map =
            DAffine3::from_rotation_translation(self.turn(), self.vector(-1.0, 1.0) + DVec3::Y * self.next(0.2, 3.0));
        object("thing", shape, map)
    }
}

/// A body whose surface receives light, two metres large at most, about the origin.
fn receiver(kind: usize, dice: &mut Dice) -> Object {
    let hyperbolic = [[1.0, 0.0, 0.0, 0.0], [0.0, -0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, -0.3]];
    let shape = match kind {
        0 => Analytic::Sphere { radius: 0.9 },
        1 => Analytic::Cylinder { radius: 0.6, height: 1.4 },
        2 => Analytic::Hyperboloid { waist_radius: 0.3, end_radius: 0.8, height: 1.6 },
        3 => Analytic::Disk { radius: 1.0 },
        4 => Analytic::Cone { radius: 0.7, height: 1.5 },
        _ => Analytic::Quadric { matrix: hyperbolic, within: [[-1.0; 3], [1.0; 3]] },
    };
    object("receiver", Shape::from(shape), DAffine3::from_quat(dice.turn()))
}

/// What draws found.
#[derive(Default)]
struct Drawn {
    draws: usize,
    penumbrae: [usize; 3],
    lit: usize,
    umbra: usize,
}

/// A lamp or a sun above.
fn random_light(kind: usize, dice: &mut Dice) -> Light {
    let centre = dice.vector(-1.0, 1.0) * DVec3::new(2.0, 1.0, 2.0) + DVec3::Y * 6.0;
    match kind {
        0 => lamp(centre, Extent::Sphere { radius: dice.next(0.05, 0.8) }),
        1 => lamp(centre, Extent::Rectangle { u: dice.vector(-0.6, 0.6), v: dice.vector(-0.6, 0.6) }),
        _ => sun([dice.next(-1.0, 1.0), -1.0, dice.next(-1.0, 1.0)], dice.next(0.5, 15.0)),
    }
}

/// Points of random cells of the first object, corners and borders among them, are within the cells' bounds.
fn draw(objects: Vec<Object>, round: usize, [depth, cells_drawn]: [u8; 2], dice: &mut Dice, drawn: &mut Drawn) {
    let light = random_light(round % 3, dice);
    let scene = Scene { objects: objects.into(), lights: vec![light.clone()], ..Scene::default() };
    let cells = first(&scene, depth, true).cells;
    let queries = Queries::new(&scene);
    let snapped = |t: f64| if (0.15..=0.85).contains(&t) { t } else { t.round() };
    for _ in 0..cells_drawn {
        let cell = cells[(dice.next(0.0, 1.0) * cells.len() as f64) as usize];
        drawn.lit += usize::from(cell.lower == 1.0);
        drawn.umbra += usize::from(cell.upper == 0.0);
        for _ in 0..3 {
            let [u, v] = cell.point([snapped(dice.next(0.0, 1.0)), snapped(dice.next(0.0, 1.0))]);
            let place = Place::Surface { object: 0, face: cell.face as usize, u, v };
            // Some of a cell of a trimmed patch may be no surface.
            let Ok(seen) = queries.visible_fraction(&place, &light) else { continue };
            let (low, high) = (cell.lower - seen.max_error, cell.upper + seen.max_error);
            assert!(low <= seen.value && seen.value <= high, "{round}, {depth}: {seen:?} at ({u}, {v}) of {cell:?}");
            drawn.draws += 1;
            drawn.penumbrae[round % 3] += usize::from(seen.value > 0.01 && seen.value < 0.99);
        }
    }
}

#[test]
fn no_point_of_a_cell_leaves_its_bounds() {
    let (mut dice, mut drawn) = (Dice(5), Drawn::default());
    for round in 0..60 {
        let count = 1 + round / 3 % 3;
        let mut objects = vec![floor(6.0)];
        objects.extend((0..count).map(|k| dice.occluder(round / 3 + k)));
        draw(objects, round, [2 + (round / 3 % 4) as u8, 60], &mut dice, &mut drawn);
    }
    assert!(drawn.draws > 10_000 && drawn.penumbrae.iter().all(|&count| count > 150), "{:?}", drawn.penumbrae);
    assert!(drawn.lit > 50 && drawn.umbra > 50, "{} {}", drawn.lit, drawn.umbra);
}

#[test]
fn no_point_of_a_curved_cell_leaves_its_bounds() {
    let (mut dice, mut drawn) = (Dice(6), Drawn::default());
    for round in 0..36 {
        let kind = round / 3 % 6;
        let mut objects = vec![receiver(kind, &mut dice)];
        // Above it, and sometimes in it.
        objects.extend((0..1 + round % 2).map(|k| dice.occluder(round / 2 + k)));
        // The light must be sampled before bodies that may be in their own way.
        let is_convex = kind != 2 && kind != 5;
        let depth = 2 + (round % 2) as u8;
        draw(objects, round, [depth, if is_convex { 20 } else { 2 }], &mut dice, &mut drawn);
    }
    assert!(drawn.draws > 1_000 && drawn.penumbrae.iter().all(|&count| count > 50), "{:?}", drawn.penumbrae);
    assert!(drawn.lit > 30 && drawn.umbra > 30, "{} {}", drawn.lit, drawn.umbra);
}

#[test]
fn a_ball_under_round_lights() {
    // Lit is the cap from which all of the light is up, umbra the one from which none is: the belt between lies between the cones that touch ball and
    // light. A sun's middle has the half angle ρ about it; of a lamp of radius R at the distance d all is up where r + R or less of d is.
    let (radius, diameter, lamp_radius, distance) = (2.0, 10.0f64, 1.0, 12.0);
    let ball = || object("ball", Shape::from(Analytic::Sphere { radius }), DAffine3::IDENTITY);
    let area = 4.0 * PI * radius * radius;
    let sine = (0.5 * diameter).to_radians().sin();
    let above = lamp(DVec3::Y * distance, Extent::Sphere { radius: lamp_radius });
    let cases = [
        (sun([0.3, -1.0, 0.2], diameter), [-sine, sine]),
        (above, [(radius - lamp_radius) / distance, (radius + lamp_radius) / distance]),
    ];
    for (light, [umbra_ends, lit_begins]) in cases {
        let scene = Scene { objects: [ball()].into(), lights: vec![light], ..Scene::default() };
        let mut widths = Vec::new();
        for depth in [3, 5, 7] {
            let found = first(&scene, depth, false);
            assert!((found.area - area).abs() < 1e-6 * area);
            assert_holds(found.lit, 0.5 * area * (1.0 - lit_begins), "lit");
            assert_holds(found.umbra, 0.5 * area * (1.0 + umbra_ends), "umbra");
            assert_holds(found.penumbra, 0.5 * area * (lit_begins - umbra_ends), "penumbra");
            if umbra_ends < 0.0 {
                // Of a sun the mean over the ball is a half, by symmetry.
                assert_holds(AreaBounds { lower: found.visible.lower, upper: found.visible.upper }, 0.5 * area, "mean");
                assert!((found.visible.estimate - 0.5 * area).abs() < 0.02 * area);
            }
            widths.push(found.lit.upper - found.lit.lower);
        }
        assert!(widths[1] < 0.5 * widths[0] && widths[2] < 0.5 * widths[1], "bounds shrink: {widths:?}");
    }
}

#[test]
fn curved_occluders_are_bounded_more_sharply_in_smaller_cells() {
    let bodies = [
        Analytic::Cylinder { radius: 0.5, height: 1.5 },
        Analytic::Cone { radius: 0.8, height: 1.0 },
        Analytic::Capsule { radius: 0.4, height: 0.8 },
        Analytic::Sphere { radius: 0.7 },
        Analytic::Disk { radius: 0.8 },
        Analytic::Hyperboloid { waist_radius: 0.3, end_radius: 0.7, height: 1.4 },
    ];
    let lamp = lamp(DVec3::new(0.5, 6.0, 0.0), Extent::Rectangle { u: DVec3::X * 0.6, v: DVec3::Z * 0.4 });
    for (number, body) in bodies.into_iter().enumerate() {
        let thing = object("thing", Shape::from(body), DAffine3::from_translation(DVec3::Y * 1.5));
        let light = if number % 2 == 0 { lamp.clone() } else { sun([0.3, -1.0, 0.2], 12.0) };
        let scene = Scene { objects: [floor(6.0), thing].into(), lights: vec![light], ..Scene::default() };
        let found = [3, 5, 7].map(|depth| first(&scene, depth, false).visible);
        let width = |k: usize| found[k].upper - found[k].lower;
        assert!(width(1) < 0.6 * width(0) && width(2) < 0.6 * width(1), "{body:?}: {found:?}");
        assert!(found[2].lower >= found[1].lower && found[2].upper <= found[1].upper, "{body:?}: {found:?}");
    }
}

#[test]
fn lit_and_umbra_cells_are_proofs_against_rays() {
    // Decided cells against exact rays to single points of the light, corners first.
    let mut dice = Dice(77);
    let mut checked = 0;
    for round in 0..40 {
        let objects = vec![floor(6.0), dice.occluder(round), dice.occluder(round / 2)];
        let (u, v) = (dice.vector(-0.6, 0.6), dice.vector(-0.6, 0.6));
        let centre = dice.vector(-1.0, 1.0) + DVec3::Y * 6.0;
        let scene = Scene {
            objects: objects.into(),
            lights: vec![lamp(centre, Extent::Rectangle { u, v })],
            ..Scene::default()
        };
        let queries = Queries::new(&scene);
        let cells = first(&scene, 5, true).cells;
        for cell in cells.iter().filter(|cell| cell.lower == 1.0 || cell.upper == 0.0).step_by(5) {
            for (s, t) in [(0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (dice.next(0.0, 1.0), dice.next(0.0, 1.0))] {
                let [a, b] = [dice.next(-1.0, 1.0), dice.next(-1.0, 1.0)]
                    .map(|x: f64| if x.abs() > 0.7 { x.signum() } else { x });
                let source = LightSource::point((centre + u * (a * 0.999_999) + v * (b * 0.999_999)).to_array())
                    .expect("a point");
                let [x, y] = cell.point([s, t]);
                let lit =
                    queries.lit(&Place::Surface { object: 0, face: 0, u: x, v: y }, &source).expect("a place").lit;
                assert_eq!(lit, cell.lower == 1.0, "{round} ({x}, {y}) {cell:?}");
                checked += 1;
            }
        }
    }
    assert!(checked > 5_000, "{checked}");
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let mut dice = Dice(3);
    let objects = vec![floor(6.0), dice.occluder(0), dice.occluder(3)];
    let light = lamp(DVec3::Y * 6.0, Extent::Rectangle { u: DVec3::X, v: DVec3::Z * 0.5 });
    let scene = Scene { objects: objects.into(), lights: vec![light], ..Scene::default() };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| first(&scene, 6, true))
    };
    assert_eq!(with(1), with(3));
}
