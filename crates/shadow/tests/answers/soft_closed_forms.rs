//! Bounds of cells against three closed forms, a thousand draws of each: a ball under a ball of light, a ball before a sun, and a rectangle
//! under a parallel rectangle light. The truths are restated here and share nothing with the library.

use std::f64::consts::PI;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, LightSource, Placement, Rectangle};
use umbriel_scene::{Extent, Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, Silent, SoftCell, SoftRequest, soft_bake};

/// Scenes and points in each.
const SCENES: usize = 25;
const POINTS: usize = 40;

const DEPTHS: [u8; 3] = [3, 5, 7];

/// Edge of the floor.
const FLOOR: f64 = 8.0;

/// What a truth may be off: its arc cosines lose half of the digits where caps barely touch.
const ROUNDING: f64 = 1e-7;

fn object(shape: Shape, at: DVec3) -> Object {
    let placement = Placement::new(DAffine3::from_translation(at)).expect("regular");
    Object::new("body".into(), shape, placement, Sides::Auto).expect("a body")
}

/// A small generator of chance.
struct Dice(u64);

impl Dice {
    fn next(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn over_floor(&mut self, reach: f64, [low, high]: [f64; 2]) -> DVec3 {
        DVec3::new(self.next(-reach, reach), self.next(low, high), self.next(-reach, reach))
    }
}

/// The area common to two caps of the unit sphere with angular radii a and b whose middles are c apart.
fn common_area(a: f64, b: f64, c: f64) -> f64 {
    let area = |radius: f64| 2.0 * PI * (1.0 - radius.cos());
    if c >= a + b {
        return 0.0;
    }
    if c <= (a - b).abs() {
        return area(a.min(b));
    }
    let angle = |opposite: f64, beside: [f64; 2]| {
        let [p, q] = beside;
        ((opposite.cos() - p.cos() * q.cos()) / (p.sin() * q.sin())).clamp(-1.0, 1.0).acos()
    };
    2.0 * (PI - angle(c, [a, b]) - a.cos() * angle(b, [c, a]) - b.cos() * angle(a, [c, b]))
}

/// The visible share of a cap of light in this direction with this angular radius, behind a ball.
fn beside_ball(point: DVec3, (towards, light): (DVec3, f64), (middle, radius): (DVec3, f64)) -> f64 {
    let to_ball = middle - point;
    let apart = towards.cross(to_ball).length().atan2(towards.dot(to_ball));
    let hidden = common_area(light, (radius / to_ball.length()).asin(), apart);
    1.0 - hidden / (2.0 * PI * (1.0 - light.cos()))
}

/// A floor, a blocker and a light, and what a point of the floor sees.
struct Draw {
    blocker: Object,
    light: Light,
    truth: Box<dyn Fn(DVec3) -> f64>,
}

fn ball_under_ball(dice: &mut Dice) -> Draw {
    let (radius, middle) = (dice.next(0.3, 1.2), dice.over_floor(1.5, [2.0, 3.0]));
    let (light_radius, place) = (dice.next(0.1, 1.0), dice.over_floor(3.0, [6.0, 9.0]));
    let source = LightSource::point(place.to_array()).expect("a point");
    Draw {
        blocker: object(Shape::from(Analytic::Sphere { radius }), middle),
        light: Light::with_extent("lamp", source, Extent::Sphere { radius: light_radius }).expect("a light"),
        truth: Box::new(move |point| {
            let cap = (light_radius / (place - point).length()).asin();
            beside_ball(point, (place - point, cap), (middle, radius))
        }),
    }
}

fn ball_before_sun(dice: &mut Dice) -> Draw {
    let (radius, middle) = (dice.next(0.3, 1.2), dice.over_floor(1.5, [2.0, 3.0]));
    let (towards, degrees) = (DVec3::new(dice.next(-0.6, 0.6), 1.0, dice.next(-0.6, 0.6)), dice.next(0.5, 20.0));
    let source = LightSource::sun((-towards).to_array()).expect("a sun");
    Draw {
        blocker: object(Shape::from(Analytic::Sphere { radius }), middle),
        light: Light::with_extent("sun", source, Extent::Disk { angular_diameter: degrees }).expect("a light"),
        truth: Box::new(move |point| beside_ball(point, (towards, 0.5 * degrees.to_radians()), (middle, radius))),
    }
}

fn rectangle_under_rectangle(dice: &mut Dice) -> Draw {
    let (size, middle) = ([dice.next(0.5, 3.0), dice.next(0.5, 3.0)], dice.over_floor(1.0, [2.0, 4.0]));
    let (half, place) = ([dice.next(0.1, 1.5), dice.next(0.1, 1.5)], dice.over_floor(2.0, [6.0, 9.0]));
    let source = LightSource::point(place.to_array()).expect("a point");
    let extent = Extent::Rectangle { u: DVec3::X * half[0], v: DVec3::Z * half[1] };
    // The share of an edge of the light that the plate's image covers from x.
    let covered = move |axis: usize, x: f64| {
        let edge = [0, 2][axis];
        let image = |end: f64| x + (end - x) * (place.y / middle.y);
        let (low, high) = (middle[edge] - 0.5 * size[axis], middle[edge] + 0.5 * size[axis]);
        let (low, high) = (image(low).max(place[edge] - half[axis]), image(high).min(place[edge] + half[axis]));
        (high - low).max(0.0) / (2.0 * half[axis])
    };
    Draw {
        blocker: object(Shape::Rectangle(Rectangle { size }), middle),
        light: Light::with_extent("panel", source, extent).expect("a light"),
        truth: Box::new(move |point| 1.0 - covered(0, point.x) * covered(1, point.z)),
    }
}

/// The cells of the floor down to a depth.
fn cells(scene: &Scene, depth: u8) -> Vec<SoftCell> {
    let request = SoftRequest {
        keep_cells: true,
        receivers: vec![0],
        ..SoftRequest::everything(scene, Detail::Depth { interior: depth, boundary: depth })
    };
    soft_bake(scene, &request, &Silent).expect("done").remove(0).objects.remove(0).cells
}

fn holding(cells: &[SoftCell], [u, v]: [f64; 2]) -> SoftCell {
    let holds = |cell: &&SoftCell| {
        let ([a, c], [b, d]) = (cell.point([0.0, 0.0]), cell.point([1.0, 1.0]));
        a <= u && u <= b && c <= v && v <= d
    };
    *cells.iter().find(holds).expect("cells tile the floor")
}

/// Points of the floor, most in the penumbra, lie within the bounds of their cells at all depths; the bounds' mean width at each.
fn check(draw: impl Fn(&mut Dice) -> Draw, seed: u64) {
    let mut dice = Dice(seed);
    let (mut widths, mut penumbra) = ([0.0; 3], 0);
    for scene in 0..SCENES {
        let Draw { blocker, light, truth } = draw(&mut dice);
        let floor = object(Shape::Rectangle(Rectangle { size: [FLOOR; 2] }), DVec3::ZERO);
        let corners = floor.facets().expect("flat").positions().to_vec();
        let scene_of = Scene { objects: [floor, blocker].into(), lights: vec![light], ..Scene::default() };
        let levels = DEPTHS.map(|depth| cells(&scene_of, depth));
        for _ in 0..POINTS {
            let mut place = || [dice.next(0.0, 1.0), dice.next(0.0, 1.0)];
            let point = |[u, v]: [f64; 2]| corners[0] + (corners[1] - corners[0]) * u + (corners[3] - corners[0]) * v;
            let mut at = place();
            for _ in 0..30 {
                let seen = truth(point(at));
                if 0.0 < seen && seen < 1.0 {
                    break;
                }
                at = place();
            }
            let seen = truth(point(at));
            penumbra += usize::from(0.0 < seen && seen < 1.0);
            for (level, width) in levels.iter().zip(&mut widths) {
                let cell = holding(level, at);
                assert!(
                    cell.lower - ROUNDING <= seen && seen <= cell.upper + ROUNDING,
                    "{scene}: {seen} at {at:?}: {cell:?}"
                );
                *width += cell.upper - cell.lower;
            }
        }
    }
    assert!(penumbra > SCENES * POINTS / 2, "{penumbra}");
    // Cells of a metre know little more than 0 to 1; from there on bounds shrink as fast as cells.
    assert!(widths[1] < 0.7 * widths[0] && widths[2] < 0.5 * widths[1], "bounds shrink: {widths:?}");
}

#[test]
fn a_thousand_points_below_a_ball_and_a_ball_of_light() {
    check(ball_under_ball, 31);
}

#[test]
fn a_thousand_points_of_a_ball_and_a_sun() {
    check(ball_before_sun, 32);
}

#[test]
fn a_thousand_points_below_a_rectangle_and_a_parallel_rectangle_light() {
    check(rectangle_under_rectangle, 33);
}
