//! Inscribed meshes converge to the sphere, and the sphere's own bounds hold the closed form at any detail.
//!
//! *The rate.* A chord of a circle of radius r with half angle φ has the sagitta r(1 − cos φ) ≈ r·φ²/2. N triangles on a
//! sphere have edges of about r/√N, so φ² and with it all that the mesh lacks fall as 1/N. Made precise, for a convex
//! mesh with all corners on the sphere:
//!
//! * *at most*: with h the least distance of a face's plane from the centre, the mesh holds the ball of radius h, so its
//!   shadow holds that of the smaller ball; under a sun it lacks at most the share 1 − (h/r)²;
//! * *at least*: under a sun, seen along the light, the shadow is a polygon of m corners inside a circle, and the regular
//!   one is the largest: it lacks at least 1 − sin(2π/m)/(2π/m), where m is the number of silhouette edges.
//!
//! Both are of the order 1/N (m is of the order √N), and both are computed from the mesh at hand. The order that the
//! proved bounds leave possible must exclude 1/2 (an error as large as an edge) and 3/2.
//!
//! *The mesh's own truth.* A ray of the shadow's inside enters and leaves a convex body once, so half the sum of its
//! triangles' projected areas is its shadow.
//!
//! The meshes are divided by meridians and parallels: convex by construction, with flat quadrilaterals cut in two.
//! *Rounding.* As in `closed_forms.rs`: 10^-12 of the area; a sum over 10^4 triangles stays within it.

use std::{collections::HashMap, f64::consts::PI};

use crate::oracle::fixtures::{at, lit_by, mesh as mesh_of, object, rectangle, scene, sphere};
use glam::DVec3;
use umbriel_geometry::LightSource;
use umbriel_scene::{Scene, Shape};
use umbriel_shadow::{Detail, LitArea, Request, Silent, bake};

const CENTER: DVec3 = DVec3::new(0.0, 1.5, 0.0);
const FLOOR_EDGE: f64 = 8.0;
const SUN_WAY: DVec3 = DVec3::new(0.75, -0.875, 0.375);
const LAMP: DVec3 = DVec3::new(-0.75, 6.0, 0.5);

#[derive(Clone, Copy, Debug)]
enum Lamp {
    Sun,
    Point,
}

impl Lamp {
    const ALL: [Self; 2] = [Self::Sun, Self::Point];

    fn source(self) -> LightSource {
        let source = match self {
            Self::Sun => LightSource::sun(SUN_WAY.to_array()),
            Self::Point => LightSource::point(LAMP.to_array()),
        };
        source.expect("a light")
    }

    /// From a point towards the light.
    fn from(self, p: DVec3) -> DVec3 {
        match self {
            Self::Sun => -SUN_WAY,
            Self::Point => LAMP - p,
        }
    }

    /// The shadow of a point on the floor y = 0.
    fn project(self, p: DVec3) -> DVec3 {
        let to_light = self.from(p);
        p - to_light * (p.y / to_light.y)
    }

    /// The shadow on the floor of a ball of this radius: an ellipse, by the sine a of the tangent cone's half angle (0 for
    /// a sun) and the cosine b of its axis with the vertical.
    fn ball_shadow(self, radius: f64) -> f64 {
        let axis = self.from(CENTER);
        let (length, b) = (axis.length(), axis.y / axis.length());
        match self {
            Self::Sun => PI * radius * radius / b,
            Self::Point => {
                let a = radius / length;
                PI * (LAMP.y * a).powi(2) * (1.0 - a * a).sqrt() / ((b - a) * (b + a)).powf(1.5)
            }
        }
    }

    /// How much of a ball of radius 1 is lit.
    fn ball_lit(self) -> f64 {
        match self {
            Self::Sun => 2.0 * PI,
            Self::Point => 2.0 * PI * (1.0 - self.from(CENTER).length_recip()),
        }
    }
}

/// A mesh in the unit sphere: `bands` bands of latitude, twice as many meridians.
struct Inscribed {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Inscribed {
    fn new(bands: u32) -> Self {
        let around = 2 * bands;
        let mut positions = vec![[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
        for (band, k) in (1..bands).flat_map(|band| (0..around).map(move |k| (band, k))) {
            let (s, c) = (PI * f64::from(band) / f64::from(bands)).sin_cos();
            let (x, z) = (2.0 * PI * f64::from(k) / f64::from(around)).sin_cos();
            positions.push([s * x, c, s * z]);
        }
        let ring = |band: u32, k: u32| match band {
            0 => 0,
            band if band == bands => 1,
            band => 2 + (band - 1) * around + k % around,
        };
        let quads = (0..bands).flat_map(|band| (0..around).map(move |k| (band, k)));
        let triangles = quads.flat_map(|(band, k)| {
            let [a, b, c, d] = [ring(band, k), ring(band + 1, k), ring(band + 1, k + 1), ring(band, k + 1)];
            [[a, b, c], [a, c, d]]
        });
        let triangles = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        Self { positions, triangles }
    }

    fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> {
        self.triangles.iter().map(|corners| corners.map(|i| DVec3::from_array(self.positions[i as usize])))
    }

    fn shape(&self) -> Shape {
        mesh_of(&self.positions, &self.triangles)
    }

    /// The area of its shadow on the floor.
    fn shadow(&self, lamp: Lamp) -> f64 {
        self.corners().map(|corners| normal(corners.map(|p| lamp.project(p + CENTER))).length() / 4.0).sum()
    }

    /// Which faces are turned to the light.
    fn turned(&self, lamp: Lamp) -> Vec<bool> {
        self.corners().map(|corners| normal(corners).dot(lamp.from(corners[0] + CENTER)) > 0.0).collect()
    }

    /// The area of the faces that are turned to the light: a convex body shades none of them.
    fn lit(&self, lamp: Lamp) -> f64 {
        let turned = self.corners().zip(self.turned(lamp)).filter(|(_, turned)| *turned);
        turned.map(|(corners, _)| normal(corners).length() / 2.0).sum()
    }

    /// The greatest and the least share of the ball's shadow that its own may lack under a sun.
    fn sun_limits(&self) -> [f64; 2] {
        let distances = self.corners().map(|corners| normal(corners).normalize().dot(corners[0]));
        let inner = distances.fold(1.0, f64::min);
        let angle = 2.0 * PI / f64::from(self.silhouette_edges(Lamp::Sun));
        [1.0 - angle.sin() / angle, 1.0 - inner * inner]
    }

    /// Edges between a face turned to the light and one turned away.
    fn silhouette_edges(&self, lamp: Lamp) -> u32 {
        let mut balance: HashMap<[u32; 2], i32> = HashMap::new();
        for (&[a, b, c], turned) in self.triangles.iter().zip(self.turned(lamp)) {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                *balance.entry([p.min(q), p.max(q)]).or_default() += if turned { 1 } else { -1 };
            }
        }
        balance.values().filter(|&&turns| turns == 0).count() as u32
    }
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

fn ball_over_floor(ball: Shape, lamp: Lamp) -> Scene {
    let floor = object("floor", rectangle(FLOOR_EDGE, FLOOR_EDGE), at(0.0, 0.0, 0.0));
    let ball = object("ball", ball, at(CENTER.x, CENTER.y, CENTER.z));
    lit_by(scene(vec![floor, ball]), lamp.source())
}

/// Bounds on the lit area of an object.
fn lit_bounds(scene: &Scene, receiver: usize, depth: u8) -> [f64; 2] {
    let detail = Detail::Depth { interior: depth.min(4), boundary: depth };
    let request = Request { receivers: vec![receiver], ..Request::everything(scene, detail) };
    let report = bake(scene, &request, &Silent).expect("nobody cancels");
    let LitArea { lower, upper, .. } = report.lights[0].objects[0].lit;
    [lower, upper]
}

/// Bounds on the area of the shadow on the floor.
fn shadow_bounds(scene: &Scene, depth: u8) -> [f64; 2] {
    let [lower, upper] = lit_bounds(scene, 0, depth);
    [FLOOR_EDGE * FLOOR_EDGE - upper, FLOOR_EDGE * FLOOR_EDGE - lower]
}

fn assert_between([lower, upper]: [f64; 2], truth: f64, scale: f64, title: &str) {
    let slack = 1e-12 * scale;
    assert!((lower - slack..=upper + slack).contains(&truth), "{truth} is not in {lower}..{upper}: {title}");
}

#[test]
fn bounds_of_the_sphere_hold_the_closed_form_at_any_detail() {
    for lamp in Lamp::ALL {
        let scene = ball_over_floor(sphere(1.0), lamp);
        for depth in 1..=11 {
            let title = format!("{lamp:?}, depth {depth}");
            assert_between(shadow_bounds(&scene, depth), lamp.ball_shadow(1.0), FLOOR_EDGE * FLOOR_EDGE, &title);
            assert_between(lit_bounds(&scene, 1, depth.min(8)), lamp.ball_lit(), 4.0 * PI, &title);
        }
    }
}

#[test]
fn bounds_of_meshes_hold_their_own_area() {
    for lamp in Lamp::ALL {
        for bands in [5, 16, 50] {
            let mesh = Inscribed::new(bands);
            let scene = ball_over_floor(mesh.shape(), lamp);
            let title = format!("{lamp:?}, {} triangles", mesh.triangles.len());
            assert_between(shadow_bounds(&scene, 10), mesh.shadow(lamp), FLOOR_EDGE * FLOOR_EDGE, &title);
            assert_between(lit_bounds(&scene, 1, 6), mesh.lit(lamp), 4.0 * PI, &title);
        }
    }
}

/// What a mesh's proved bounds say about the share it lacks of the ball's shadow under the sun.
fn missing_share(mesh: &Inscribed, depth: u8) -> [f64; 2] {
    let [lower, upper] = shadow_bounds(&ball_over_floor(mesh.shape(), Lamp::Sun), depth);
    let truth = Lamp::Sun.ball_shadow(1.0);
    [1.0 - upper / truth, 1.0 - lower / truth]
}

#[test]
fn what_meshes_lack_falls_with_their_triangles() {
    // Deep enough to tell each mesh from the ball.
    let meshes = [(5, 8), (16, 10), (50, 14)].map(|(bands, depth)| (Inscribed::new(bands), depth));
    let mut found = Vec::new();
    for (mesh, depth) in &meshes {
        let count = mesh.triangles.len() as f64;
        let [least, most] = mesh.sun_limits();
        let [lower, upper] = missing_share(mesh, *depth);
        assert!(lower > 0.0, "{count} triangles cannot be told from the ball: {lower}..{upper}");
        assert!(lower <= most && least <= upper, "{count} triangles lack {lower}..{upper}, not {least}..{most}");
        found.push((count, [lower, upper]));
    }
    for pair in found.windows(2) {
        let [(few, coarse), (many, fine)] = [pair[0], pair[1]];
        let order = |coarse: f64, fine: f64| (coarse / fine).ln() / (many / few).ln();
        let orders = [order(coarse[0], fine[1]), order(coarse[1], fine[0])];
        // The order of 1/N is 1; a half would be an error as large as an edge, one and a half its cube.
        assert!(orders[0] > 0.5 && orders[1] < 1.5, "{few} to {many} triangles: the order is within {orders:?}");
    }
}

#[test]
fn under_a_lamp_meshes_lie_between_two_balls() {
    for (bands, depth) in [(5, 8), (16, 10), (50, 11)] {
        let mesh = Inscribed::new(bands);
        let [_, most] = mesh.sun_limits();
        let [lower, upper] = shadow_bounds(&ball_over_floor(mesh.shape(), Lamp::Point), depth);
        let [inner, outer] = [(1.0 - most).sqrt(), 1.0].map(|radius| Lamp::Point.ball_shadow(radius));
        assert!(lower < outer && inner < upper, "{bands} bands: {lower}..{upper}, between {inner} and {outer}");
    }
}
