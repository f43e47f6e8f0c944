//! Do all methods answer alike? Rays through a picture, all round a point and towards lights, among them rays aimed at trouble: corners and
//! edges of triangles, along faces and edges, through cell corners of maps, through the borders of leaves' projections, and where
//! the faces of a cube of maps meet.
//!
//! Every ray goes through the maps, an ordinary traversal of the octree and the BVH; as many as time allows also through a loop over
//! all triangles: exact arithmetic alone for segments, and the measure of hits alone for nearest hits.

use std::sync::Arc;

use anyhow::{Result, ensure};
use glam::DVec3;
use umbriel_bvh::{Hit, TriangleBvh, TriangleRay};
use umbriel_geometry::{Aabb, Dyadic, ExactPoint, LightSource, Mesh, blocking::exact_polygon_blocks};
use umbriel_octree::{Layout, Numbering, Projection, ProjectionOptions, Viewpoint};

use super::models::{Model, Picture};
use crate::bench::clock::timed;

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

    /// −1 to 1 with few bits: a border of cells in every map that is fine enough, and of all faces where it is ±1.
    fn border(&mut self) -> f64 {
        let steps = 1 << self.below(12);
        self.below(2 * steps + 1) as f64 / steps as f64 - 1.0
    }

    /// A place to aim at.
    fn target(&mut self, Judge { model, bounds, aim, projection, .. }: &Judge) -> DVec3 {
        let mesh = &model.mesh;
        let triangle = mesh.triangles()[self.below(mesh.triangles().len())];
        let [a, b, c] = triangle.map(|corner| mesh.positions()[corner as usize]);
        let share = DVec3::new(self.unit(), self.unit(), self.unit());
        match self.below(9) {
            0 => a,
            1 => a + (b - a) * self.unit(),
            2 => (a + b) * 0.5,
            3 => a + (b - a) * self.unit() + (c - a) * self.unit(),
            // Along a face, where the viewpoint is in its plane; else through a line of it.
            4 => a + (a - b) * (4.0 * self.unit()),
            5 => aim.map_corner([self.border(), self.border()], self.below(6), bounds.size().max_element()),
            6 | 7 => {
                let corner = projection.leaf_corner(self.below(projection.report().leaves), self.below(8) as u8);
                let other = projection.leaf_corner(self.below(projection.report().leaves), self.below(8) as u8);
                // On the border between two leaves' corners only by chance; a corner is on it always.
                if self.below(4) == 0 {
                    corner.zip(other).map_or(a, |(x, y)| (x + y) * 0.5)
                } else {
                    corner.unwrap_or(a)
                }
            }
            _ => bounds.min + bounds.size() * share,
        }
    }
}

/// Rays of a viewpoint.
struct Aim {
    name: &'static str,
    viewpoint: Viewpoint,
    /// Whether nearest hits are asked for, not segments.
    is_nearest: bool,
}

impl Aim {
    /// All that a model is judged by. A viewpoint in a corner of the mesh has rays along its faces.
    fn all(model: &Model) -> [Self; 5] {
        let mesh = &model.mesh;
        let corner = mesh.positions()[mesh.triangles()[mesh.triangles().len() / 2][0] as usize];
        let aim = |name, viewpoint, is_nearest| Self { name, viewpoint, is_nearest };
        [
            aim("picture", model.picture.viewpoint(), true),
            aim("around", Viewpoint::Point(corner), true),
            aim("lamp", Viewpoint::Point(model.lamp), false),
            aim("corner", Viewpoint::Point(corner), false),
            aim("sun", Viewpoint::Parallel(model.sun), false),
        ]
    }

    /// Where rays begin that have an origin of their own.
    fn origin(&self) -> DVec3 {
        match self.viewpoint {
            Viewpoint::Point(eye) | Viewpoint::Picture { eye, .. } => eye,
            Viewpoint::Parallel(_) => DVec3::ZERO,
        }
    }

    /// A point seen at a place of a face.
    fn map_corner(&self, [a, b]: [f64; 2], face: usize, size: f64) -> DVec3 {
        match self.viewpoint {
            Viewpoint::Point(eye) => {
                let mut along = DVec3::ZERO;
                along[face / 2] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
                along[(face / 2 + 1) % 3] = a;
                along[(face / 2 + 2) % 3] = b;
                eye + along * size
            }
            Viewpoint::Picture { eye, forward, right, up } => eye + Picture { eye, forward, right, up }.at([a, b]),
            Viewpoint::Parallel(direction) => {
                let (across, beside) = direction.normalize().any_orthonormal_pair();
                (across * a + beside * b) * size
            }
        }
    }

    fn light(&self) -> Result<LightSource> {
        Ok(match self.viewpoint {
            Viewpoint::Parallel(direction) => LightSource::sun(direction.to_array())?,
            _ => LightSource::point(self.origin().to_array())?,
        })
    }
}

/// How projections are built for the judge.
const VARIANTS: [(Numbering, Layout, u8); 3] = [
    (Numbering::FrontToBack, Layout::OneMap, 8),
    (Numbering::Sections, Layout::OneMap, 6),
    (Numbering::FrontToBack, Layout::MapPerSection, 5),
];

/// Models with more triangles are judged as the pipeline builds them only.
const LARGE: usize = 1 << 20;

/// Triangles that the loops over all of them look at, for each model and kind of rays.
const LOOPED: usize = 1 << 26;

/// What was compared.
#[derive(Clone, Copy, Debug, Default)]
struct Compared {
    rays: u64,
    hits: u64,
    /// Rays that a loop over all triangles answered too.
    looped: u64,
    /// Segments whose leaves were looked up by the source's numbers, and those whose leaves these put in a wrong order.
    numbered: [u64; 2],
}

impl std::ops::AddAssign for Compared {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.hits += other.hits;
        self.looped += other.looped;
        self.numbered = [0, 1].map(|which| self.numbered[which] + other.numbered[which]);
    }
}

/// Fails at the first ray on which the methods differ.
pub(super) fn run(models: impl Iterator<Item = Result<Option<Model>>>, rays: u64) -> Result<()> {
    let (mut count, mut all, mut seconds) = (0, Compared::default(), 0.0);
    for model in models {
        let Some(model) = model? else { continue };
        let (compared, time) = timed(|| judged(&model, rays));
        let compared = compared?;
        println!(
            "{}: {} triangles, {} rays, {} hits, {} of them by a loop too, {:.1} s, no difference",
            model.name,
            model.mesh.triangles().len(),
            compared.rays,
            compared.hits,
            compared.looped,
            time.cpu
        );
        all += compared;
        (count, seconds) = (count + 1, seconds + time.cpu);
    }
    ensure!(count > 0, "no model");
    println!(
        "{count} models, {} rays, {} hits, {} by a loop too, {seconds:.0} s of processor time: no difference; the source's numbers put the \
         leaves of {} of {} segments in a wrong order",
        all.rays, all.hits, all.looped, all.numbered[1], all.numbered[0]
    );
    Ok(())
}

fn judged(model: &Model, rays: u64) -> Result<Compared> {
    let bvh = TriangleBvh::build(Arc::clone(&model.mesh));
    let (triangles, bounds) = (model.mesh.triangles().len(), model.mesh.bounds());
    let mut all = Compared::default();
    for aim in Aim::all(model) {
        for (variant, (numbering, layout, max_level)) in VARIANTS.into_iter().enumerate() {
            // The slow variants are asked less.
            let (count, looped) = if variant == 0 { (rays, LOOPED / triangles) } else { (rays / 64, 0) };
            if count == 0 || variant > 0 && triangles > LARGE {
                continue;
            }
            let max_level = if variant == 0 { ProjectionOptions::level_for(triangles) } else { max_level };
            let options = ProjectionOptions { numbering, layout, max_level, ..ProjectionOptions::default() };
            let projection = Projection::build(Arc::clone(&model.mesh), aim.viewpoint, &options)?;
            let judge = Judge { model, bounds: &bounds, bvh: &bvh, projection: &projection, numbering, aim: &aim };
            let looped = (looped as u64 + 1) * u64::from(variant == 0);
            all += if aim.is_nearest { judge.nearest(count, looped)? } else { judge.segments(count, looped)? };
        }
    }
    Ok(all)
}

struct Judge<'a> {
    model: &'a Model,
    bounds: &'a Aabb,
    bvh: &'a TriangleBvh,
    projection: &'a Projection,
    numbering: Numbering,
    aim: &'a Aim,
}

impl Judge<'_> {
    fn nearest(&self, count: u64, looped: u64) -> Result<Compared> {
        let (mut dice, mut compared) =
            (Dice(count), Compared { rays: count, looped: looped.min(count), ..Compared::default() });
        let origin = self.aim.origin();
        for ray in 0..count {
            let direction = dice.target(self) - origin;
            let truth = self.bvh.nearest_hit(origin, direction, f64::INFINITY);
            let what = || format!("{}, {}: along {direction}", self.model.name, self.aim.name);
            let found = self.projection.nearest_hit(origin, direction, f64::INFINITY)?;
            ensure!(found == truth, "{}: maps {found:?}, BVH {truth:?}", what());
            let found = self.projection.nearest_hit_by_descent(origin, direction, f64::INFINITY)?;
            ensure!(found == truth, "{}: octree {found:?}, BVH {truth:?}", what());
            if ray < looped {
                let found = nearest_by_loop(&self.model.mesh, origin, direction);
                ensure!(found == truth, "{}: loop {found:?}, BVH {truth:?}", what());
            }
            compared.hits += u64::from(truth.is_some());
        }
        Ok(compared)
    }

    fn segments(&self, count: u64, looped: u64) -> Result<Compared> {
        let (mut dice, mut compared) =
            (Dice(count), Compared { rays: count, looped: looped.min(count), ..Compared::default() });
        let light = self.aim.light()?;
        let mut towards = self.bvh.towards(light);
        let (mut segments, mut descents) = (self.projection.segments(), self.projection.segments_by_descent());
        for ray in 0..count {
            let x = dice.target(self);
            let truth = towards.any_hit(x);
            let what = || format!("{}, {}: from {x}", self.model.name, self.aim.name);
            ensure!(segments.any_hit(x) == truth, "{}: maps say otherwise than the BVH's {truth}", what());
            ensure!(descents.any_hit(x) == truth, "{}: the octree says otherwise than the BVH's {truth}", what());
            if ray < looped {
                let exact = is_blocked_by_loop(&self.model.mesh, x, &light);
                ensure!(exact == truth, "{}: exactly {exact}, the BVH says {truth}", what());
            }
            compared.hits += u64::from(truth);
            if self.numbering == Numbering::Sections {
                compared.numbered[0] += 1;
                compared.numbered[1] += u64::from(self.projection.disorder(x) > 0);
            }
        }
        Ok(compared)
    }
}

/// The nearest hit by looking at every triangle.
fn nearest_by_loop(mesh: &Mesh, origin: DVec3, direction: DVec3) -> Option<Hit> {
    let ray = TriangleRay::new(origin, direction)?;
    let near = Nearby::new(origin, direction);
    let corners = |triangle: &[u32; 3]| triangle.map(|corner| mesh.positions()[corner as usize]);
    let hits = (0u32..).zip(mesh.triangles()).filter_map(|(name, triangle)| {
        let corners = corners(triangle);
        if near.misses(&corners) { None } else { ray.hit(corners, name) }
    });
    hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)))
}

/// Whether a segment is blocked, in exact arithmetic alone, by looking at every triangle that its line may come near.
fn is_blocked_by_loop(mesh: &Mesh, x: DVec3, light: &LightSource) -> bool {
    let way = light.xyz() - light.w() * x;
    let near = Nearby::new(x, way);
    let [x, light] = [ExactPoint::<Dyadic>::from_position(x), ExactPoint::from_light(light)];
    mesh.triangles().iter().any(|triangle| {
        let corners = triangle.map(|corner| mesh.positions()[corner as usize]);
        !near.misses(&corners) && exact_polygon_blocks(&corners.map(ExactPoint::from_position), &x, &light)
    })
}

/// Leaves out what is far beside a line: on an axis across it, all corners lie on one side by far more than what rounding can be.
struct Nearby {
    origin: DVec3,
    across: [DVec3; 2],
}

impl Nearby {
    fn new(origin: DVec3, direction: DVec3) -> Self {
        let (first, second) = direction.normalize_or(DVec3::X).any_orthonormal_pair();
        Self { origin, across: [first, second] }
    }

    fn misses(&self, corners: &[DVec3; 3]) -> bool {
        let size = corners.iter().fold(self.origin.abs(), |size, corner| size.max(corner.abs())).max_element();
        // Some ten roundings of numbers of this size, a million times over.
        let margin = size * 1e-9;
        self.across.iter().any(|axis| {
            let beside = corners.map(|corner| (corner - self.origin).dot(*axis));
            beside.iter().all(|&distance| distance > margin) || beside.iter().all(|&distance| distance < -margin)
        })
    }
}
