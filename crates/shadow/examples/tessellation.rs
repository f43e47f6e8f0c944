//! What not tessellating buys: a ball as a sphere, and as inscribed meshes of a hundred to a million triangles.
//!
//! A ball of radius 1 hangs over a floor under a sun (elevation 40°) and a lamp. Four shares of its surface or shadow have
//! closed forms: the sun's shadow is an ellipse of πr²/sin α, the lamp's the conic section of its tangent cone; of the ball
//! itself 2πr² and 2πr²(1 − r/d) are lit. Every body is baked at the same depth, the floor and the ball as receivers apart;
//! times are the best of interleaved runs in one process, making the mesh left out.
//!
//! The meshes are octahedra whose faces are divided into f² triangles each and blown up to the sphere: N = 8f², all corners
//! on the sphere, convex. As the mesh is convex, every ray of its shadow crosses it twice, so half the sum of its
//! triangles' projected areas is the mesh's own shadow: the column "missing" is what that lacks of the sphere's.
//!
//! `cargo run --release -p umbriel-shadow --example tessellation [F ...]`: other divisions f; 0 stands for the sphere.

#![expect(clippy::print_stdout, reason = "an example shows its results")]

use std::{collections::HashMap, error::Error, f64::consts::PI, sync::Arc, time::Instant};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, LitArea, Request, Silent, bake};

const CENTER: DVec3 = DVec3::new(0.0, 1.5, 0.0);
const LAMP: DVec3 = DVec3::new(-0.8, 6.0, 0.5);
const FLOOR_EDGE: f64 = 8.0;
const DEPTH: u8 = 10;
const RUNS: usize = 5;
const FLOOR: usize = 0;
const BALL: usize = 1;
/// Divisions that give about 10², 10³, … 10⁶ triangles; 0 is the sphere.
const DIVISIONS: [i32; 6] = [0, 4, 11, 35, 112, 354];

/// The way the sun's light travels: 40° above the horizon, along no axis of the mesh.
fn sun() -> DVec3 {
    let (elevation, azimuth) = (40f64.to_radians(), 25f64.to_radians());
    DVec3::new(azimuth.cos() * elevation.cos(), -elevation.sin(), azimuth.sin() * elevation.cos())
}

/// The areas that the four bakes ask for, of the sphere: [floor, ball] by [sun, lamp]. On the floor the shadow, on the
/// ball the lit part.
fn closed_forms() -> [[f64; 2]; 2] {
    // The cone about the axis from the lamp, half angle a, axis at b from the vertical; q = cos²b − sin²a.
    let axis = CENTER - LAMP;
    let (sin_a, cos_b) = (axis.length_recip(), -axis.y / axis.length());
    let q = (cos_b - sin_a) * (cos_b + sin_a);
    let conic = PI * (LAMP.y * sin_a).powi(2) * (1.0 - sin_a * sin_a).sqrt() / (q * q.sqrt());
    [[PI / -sun().y, conic], [2.0 * PI, 2.0 * PI * (1.0 - sin_a)]]
}

/// An octahedron with faces divided into f² triangles each, its corners moved outward to the unit sphere.
fn inscribed(f: i32) -> Result<Mesh, Box<dyn Error>> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut numbers = HashMap::new();
    for octant in 0..8 {
        let sign = |axis: i32| 1 - 2 * (octant >> axis & 1);
        let outward = sign(0) * sign(1) * sign(2) > 0;
        let mut corner = |i: i32, j: i32| {
            let key = [sign(0) * i, sign(1) * j, sign(2) * (f - i - j)];
            *numbers.entry(key).or_insert_with(|| {
                positions.push(DVec3::from_array(key.map(f64::from)).normalize().to_array());
                positions.len() as u32 - 1
            })
        };
        let mut add = |[a, b, c]: [u32; 3]| triangles.push(if outward { [a, b, c] } else { [a, c, b] });
        for (i, j) in (0..f).flat_map(|i| (0..f - i).map(move |j| (i, j))) {
            add([corner(i, j), corner(i + 1, j), corner(i, j + 1)]);
            if i + j + 1 < f {
                add([corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]);
            }
        }
    }
    Ok(Mesh::new(positions, triangles)?)
}

/// The same four areas of a convex mesh.
fn own_areas(mesh: &Mesh) -> [[f64; 2]; 2] {
    let by_sun = |p: DVec3| p - sun() * (p.y / sun().y);
    let by_lamp = |p: DVec3| LAMP + (p - LAMP) * (LAMP.y / (LAMP.y - p.y));
    let mut areas = [[0.0; 2]; 2];
    for corners in mesh.triangles() {
        let triangle = corners.map(|index| mesh.positions()[index as usize] + CENTER);
        let doubled = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        let normal = doubled(triangle);
        areas[FLOOR][0] += doubled(triangle.map(by_sun)).length() / 4.0;
        areas[FLOOR][1] += doubled(triangle.map(by_lamp)).length() / 4.0;
        for (light, to_light) in [-sun(), LAMP - triangle[0]].into_iter().enumerate() {
            areas[BALL][light] += if normal.dot(to_light) > 0.0 { normal.length() / 2.0 } else { 0.0 };
        }
    }
    areas
}

/// A ball to be baked, and what came of it.
struct Body {
    title: String,
    own: [[f64; 2]; 2],
    scene: Scene,
    found: [[LitArea; 2]; 2],
    seconds: [[f64; 2]; 2],
}

impl Body {
    fn new(f: i32) -> Result<Self, Box<dyn Error>> {
        let (title, own, ball) = if f == 0 {
            ("sphere".into(), closed_forms(), Shape::from(Analytic::Sphere { radius: 1.0 }))
        } else {
            let mesh = inscribed(f)?;
            (mesh.triangles().len().to_string(), own_areas(&mesh), Shape::Mesh(Arc::new(mesh)))
        };
        let floor = Shape::Rectangle(Rectangle { size: [FLOOR_EDGE; 2] });
        let above = Placement::new(DAffine3::from_translation(CENTER))?;
        let scene = Scene {
            objects: [
                Object::new("floor".into(), floor, Placement::IDENTITY, Sides::Auto)?,
                Object::new("ball".into(), ball, above, Sides::Auto)?,
            ]
            .into(),
            lights: vec![
                Light::new("sun", LightSource::sun(sun().to_array())?),
                Light::new("lamp", LightSource::point(LAMP.to_array())?),
            ],
            ..Scene::default()
        };
        Ok(Self { title, own, scene, found: Default::default(), seconds: [[f64::INFINITY; 2]; 2] })
    }

    /// Bakes each receiver under each light once, and keeps the best time.
    fn run(&mut self) -> Result<(), Box<dyn Error>> {
        let detail = Detail::Depth { interior: DEPTH, boundary: DEPTH };
        for (receiver, light) in [(FLOOR, 0), (FLOOR, 1), (BALL, 0), (BALL, 1)] {
            let everything = Request::everything(&self.scene, detail);
            let request = Request { lights: vec![light], receivers: vec![receiver], ..everything };
            let start = Instant::now();
            let report = bake(&self.scene, &request, &Silent)?;
            let seconds = start.elapsed().as_secs_f64();
            self.seconds[receiver][light] = self.seconds[receiver][light].min(seconds);
            self.found[receiver][light] = report.lights[0].objects[0].lit;
        }
        Ok(())
    }

    /// One line: the bounds on shadow (floor) or lit area (ball), and whether the sphere's area lies between them.
    fn line(&self, receiver: usize, light: usize) -> String {
        let LitArea { lower, upper, .. } = self.found[receiver][light];
        let whole = FLOOR_EDGE * FLOOR_EDGE;
        let [lower, upper] = if receiver == FLOOR { [whole - upper, whole - lower] } else { [lower, upper] };
        let (sphere, own) = (closed_forms()[receiver][light], self.own[receiver][light]);
        // Closed forms and sums have some roundings themselves.
        let holds = |area: f64| if (lower - 1e-9..=upper + 1e-9).contains(&area) { "yes" } else { "no" };
        format!(
            "{:>8} {:>9.4} {lower:>9.5} {upper:>9.5} {:>9} {:>10} {:>11.5}",
            self.title,
            self.seconds[receiver][light],
            holds(own),
            holds(sphere),
            100.0 * (1.0 - own / sphere)
        )
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let asked = std::env::args().skip(1).map(|f| f.parse::<u16>().map(i32::from)).collect::<Result<Vec<_>, _>>()?;
    let divisions = if asked.is_empty() { &DIVISIONS[..] } else { &asked };
    let mut bodies = divisions.iter().map(|&f| Body::new(f)).collect::<Result<Vec<_>, _>>()?;
    for _ in 0..RUNS {
        bodies.iter_mut().try_for_each(Body::run)?;
    }
    for (receiver, title) in [(FLOOR, "the floor's shadow"), (BALL, "the ball's lit part")] {
        for (light, name) in ["sun", "lamp"].into_iter().enumerate() {
            println!("{title}, {name}: {:.5} m² for the sphere; depth {DEPTH}", closed_forms()[receiver][light]);
            println!("    body   seconds  at least   at most  own area  sphere's   missing %");
            bodies.iter().for_each(|body| println!("{}", body.line(receiver, light)));
            println!();
        }
    }
    Ok(())
}
