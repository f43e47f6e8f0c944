//! Rays looked up in projections against a loop over all triangles, the BVH and an ordinary traversal: no ray may differ.

use std::sync::Arc;

use glam::DVec3;
use umbriel_bvh::{Hit, Segment, TriangleBvh, TriangleRay};
use umbriel_geometry::{Dyadic, ExactPoint, LightSource, Mesh, blocking::exact_polygon_blocks};
use umbriel_octree::{Layout, Numbering, Projection, ProjectionOptions, Viewpoint};

/// A fixed sequence of numbers.
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// From a coarse grid, so that corners coincide and lie on planes between cells, or not.
    fn number(&mut self) -> f64 {
        if self.below(3) < 2 { (self.below(17) as f64 - 8.0) * 0.25 } else { self.unit() * 4.0 - 2.0 }
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    fn mesh(&mut self) -> Arc<Mesh> {
        let count = 3 + self.below(60);
        let positions: Vec<[f64; 3]> = (0..count).map(|_| self.point().to_array()).collect();
        let triangles = (0..1 + self.below(120)).map(|_| std::array::from_fn(|_| self.below(count) as u32)).collect();
        Arc::new(Mesh::new(positions, triangles).expect("numbers in range"))
    }

    fn viewpoint(&mut self, mesh: &Mesh) -> Viewpoint {
        let point = match self.below(3) {
            0 => mesh.positions()[self.below(mesh.positions().len())],
            1 => self.point() * 3.0,
            _ => self.point(),
        };
        match self.below(3) {
            0 => Viewpoint::Point(point),
            1 => Viewpoint::Picture { eye: point, forward: -point, right: self.point(), up: self.point() },
            _ => Viewpoint::Parallel(point),
        }
    }

    fn options(&mut self) -> ProjectionOptions {
        ProjectionOptions {
            max_level: self.below(7) as u8,
            leaf_items: 1 + self.below(8),
            numbering: [Numbering::FrontToBack, Numbering::Sections][self.below(2)],
            layout: [Layout::OneMap, Layout::OneMap, Layout::MapPerSection][self.below(3)],
            rays: [1, 1 << 12, 1 << 20][self.below(3)],
            memory: [1 << 14, 1 << 30][self.below(2)],
        }
    }

    /// Where rays are in trouble: corners, edges, faces, cell corners, and anywhere.
    fn target(&mut self, mesh: &Mesh) -> DVec3 {
        let triangle = mesh.triangles()[self.below(mesh.triangles().len())];
        let [a, b, c] = triangle.map(|corner| mesh.positions()[corner as usize]);
        match self.below(6) {
            0 => a,
            1 => (a + b) * 0.5,
            2 => a + (b - a) * self.unit() + (c - a) * self.unit(),
            3 => a + (a - b) * self.number(),
            _ => self.point(),
        }
    }
}

/// The nearest hit by looking at every triangle.
fn nearest(mesh: &Mesh, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Hit> {
    let ray = TriangleRay::new(origin, direction)?;
    let corners = |triangle: &[u32; 3]| triangle.map(|corner| mesh.positions()[corner as usize]);
    let hits = (0u32..).zip(mesh.triangles()).filter_map(|(name, triangle)| ray.hit(corners(triangle), name));
    hits.filter(|hit| hit.t <= t_max).min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)))
}

/// Whether a segment is blocked, in exact arithmetic alone, by looking at every triangle.
fn is_blocked(mesh: &Mesh, x: DVec3, light: &LightSource) -> bool {
    let [x, light] = [ExactPoint::<Dyadic>::from_position(x), ExactPoint::from_light(light)];
    mesh.triangles().iter().any(|triangle| {
        let corners = triangle.map(|corner| ExactPoint::from_position(mesh.positions()[corner as usize]));
        exact_polygon_blocks(&corners, &x, &light)
    })
}

fn light_of(viewpoint: &Viewpoint) -> LightSource {
    match *viewpoint {
        Viewpoint::Point(eye) | Viewpoint::Picture { eye, .. } => LightSource::point(eye.to_array()),
        Viewpoint::Parallel(direction) => LightSource::sun(direction.to_array()),
    }
    .expect("numbers in range")
}

/// Builds what can be built; viewpoints drawn without a direction, or with all axes in a plane, cannot.
fn projection(dice: &mut Dice) -> Option<(Arc<Mesh>, Viewpoint, Projection)> {
    let mesh = dice.mesh();
    let viewpoint = dice.viewpoint(&mesh);
    let options = dice.options();
    Some((Arc::clone(&mesh), viewpoint, Projection::build(mesh, viewpoint, &options).ok()?))
}

#[test]
fn every_segment_is_decided_as_by_exact_arithmetic() {
    let mut dice = Dice(7);
    let (mut blocked, mut asked) = (0, 0);
    for case in 0..120 {
        let Some((mesh, viewpoint, projection)) = projection(&mut dice) else { continue };
        let light = light_of(&viewpoint);
        let bvh = TriangleBvh::build(Arc::clone(&mesh));
        let (mut segments, mut descents) = (projection.segments(), projection.segments_by_descent());
        for _ in 0..24 {
            let x = dice.target(&mesh);
            let truth = is_blocked(&mesh, x, &light);
            assert_eq!(projection.any_hit(x), truth, "case {case}: {viewpoint:?} to {x}");
            assert_eq!(segments.any_hit(x), truth, "case {case}, neighbours: {viewpoint:?} to {x}");
            assert_eq!(descents.any_hit(x), truth, "case {case}, descent: {viewpoint:?} to {x}");
            assert_eq!(bvh.any_hit(&Segment::new(x, light)), truth, "case {case}, BVH: {viewpoint:?} to {x}");
            (blocked, asked) = (blocked + usize::from(truth), asked + 1);
        }
    }
    assert!(asked > 2_000 && blocked * 10 > asked && blocked * 10 < 9 * asked, "{blocked} of {asked}");
}

#[test]
fn every_ray_hits_what_a_loop_over_all_triangles_hits() {
    let mut dice = Dice(11);
    let (mut hits, mut asked) = (0, 0);
    for case in 0..150 {
        let Some((mesh, viewpoint, projection)) = projection(&mut dice) else { continue };
        let bvh = TriangleBvh::build(Arc::clone(&mesh));
        for _ in 0..32 {
            let target = dice.target(&mesh);
            let (origin, direction) = match viewpoint {
                Viewpoint::Point(eye) | Viewpoint::Picture { eye, .. } => (eye, target - eye),
                Viewpoint::Parallel(direction) => (target - direction * dice.number(), direction),
            };
            let t_max = if dice.below(2) == 0 { f64::INFINITY } else { 1.0 };
            let truth = nearest(&mesh, origin, direction, t_max);
            let what = format!("case {case}: {viewpoint:?}, {origin} along {direction} to {t_max}");
            assert_eq!(projection.nearest_hit(origin, direction, t_max), Ok(truth), "{what}");
            assert_eq!(projection.nearest_hit_by_descent(origin, direction, t_max), Ok(truth), "descent, {what}");
            assert_eq!(bvh.nearest_hit(origin, direction, t_max), truth, "BVH, {what}");
            (hits, asked) = (hits + usize::from(truth.is_some()), asked + 1);
        }
    }
    assert!(asked > 3_000 && hits * 10 > asked, "{hits} of {asked}");
}
