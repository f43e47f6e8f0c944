//! What 10,000 objects that cannot influence the asked receiver add to the time after loading: jobs beside them and without them, in turns.
//! What is added is the same for all jobs, so what part that is goes by the job: the least of these are the least that can be asked, those of balls at depth 8, the depth
//! that is taken where nothing is said, are like real scenes. The idle objects are in families, as those of most files are.
//! `cargo bench -p umbriel-shadow --bench idle`.

use std::{hint::black_box, time::Instant};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Placement, Rectangle};
use umbriel_scene::{Family, FamilyTree, Light, Member, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, Request, Silent, bake};

/// Runs of which the quickest counts.
const RUNS: usize = 300;
/// Objects of a family.
const FAMILY: usize = 100;
/// Objects that are far from the light's way to the receiver.
const IDLE: u32 = 10_000;

fn main() {
    for (name, bodies) in [("100 boxes", boxes as fn() -> Vec<Object>), ("100 balls", balls)] {
        let [alone, beside] = [0, IDLE].map(|idle| over_floor(bodies(), idle));
        for depth in [4, 8, 10] {
            let [mut alone_ms, mut beside_ms] = [f64::INFINITY; 2];
            for _ in 0..RUNS {
                alone_ms = alone_ms.min(milliseconds(&alone, depth));
                beside_ms = beside_ms.min(milliseconds(&beside, depth));
            }
            show(&format!("floor under {name}, depth {depth}"), alone_ms, beside_ms);
        }
    }
}

fn placed(name: String, shape: Shape, at: DVec3) -> Object {
    let placement = Placement::new(DAffine3::from_translation(at)).expect("a translation is regular");
    Object::new(name, shape, placement, Sides::Auto).expect("an object")
}

/// Places over a floor of 40 m.
fn place(number: u32) -> DVec3 {
    DVec3::new(3.0 * f64::from(number % 10) - 15.0, 1.5, 3.0 * f64::from(number / 10 % 10) - 15.0)
}

fn boxes() -> Vec<Object> {
    (0..100).map(|k| placed(format!("near {k}"), Shape::Cuboid(Cuboid { size: [1.0; 3] }), place(k))).collect()
}

fn balls() -> Vec<Object> {
    let ball = Shape::from(Analytic::Sphere { radius: 0.5 });
    (0..100).map(|k| placed(format!("near {k}"), ball.clone(), place(k))).collect()
}

/// These over a floor, and boxes far below and beside it, none at the place of another.
fn over_floor(bodies: Vec<Object>, idle: u32) -> Scene {
    let floor = placed("floor".into(), Shape::Rectangle(Rectangle { size: [40.0; 2] }), DVec3::ZERO);
    let below = |k: u32| place(k) + DVec3::new(0.0, -100.0 - f64::from(k / 100), 5000.0);
    let idle = (0..idle).map(|k| placed(format!("far {k}"), Shape::Cuboid(Cuboid { size: [1.0; 3] }), below(k)));
    let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
    let objects: Vec<Object> = std::iter::once(floor).chain(bodies).chain(idle).collect();
    let members: Vec<Member> = (0..objects.len()).map(Member::Object).collect();
    let families = members.chunks(FAMILY).map(|members| Family { name: String::new(), members: members.to_vec() });
    let families: Vec<Family> = families.collect();
    let roots = (0..families.len()).map(Member::Family).collect();
    let lights = vec![Light::new("sun", sun)];
    Scene { objects: objects.into(), families: FamilyTree { families, roots }, lights, ..Scene::default() }
}

/// How long the floor takes.
fn milliseconds(scene: &Scene, depth: u8) -> f64 {
    let detail = Detail::Depth { interior: depth.min(4), boundary: depth };
    let request = Request { receivers: vec![0], ..Request::everything(scene, detail) };
    let begun = Instant::now();
    black_box(bake(scene, &request, &Silent)).expect("nobody cancels");
    1e3 * begun.elapsed().as_secs_f64()
}

#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn show(name: &str, alone: f64, beside: f64) {
    let added = beside - alone;
    println!(
        "{name:<32} {alone:>8.3} ms alone, {beside:>8.3} beside {IDLE} idle objects: {added:.3} ms, {:.1} % more",
        100.0 * added / alone
    );
}
