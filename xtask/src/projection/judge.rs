//! Do all methods answer alike? Rays through a picture and towards lights, among them rays aimed at trouble: corners and edges
//! of triangles, along faces and edges, through cell corners of maps and where the faces of a cube of maps meet.

use std::sync::Arc;

use anyhow::{Result, ensure};
use glam::DVec3;
use umbriel_bvh::TriangleBvh;
use umbriel_geometry::Mesh;
use umbriel_octree::{Layout, Numbering, Projection, ProjectionOptions};

use super::{
    measure::Rays,
    models::{Model, model},
};

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

    /// A place to aim at from `origin`.
    fn target(&mut self, mesh: &Mesh, origin: DVec3) -> DVec3 {
        let triangle = mesh.triangles()[self.below(mesh.triangles().len())];
        let [a, b, c] = triangle.map(|corner| mesh.positions()[corner as usize]);
        let (bounds, share) = (mesh.bounds(), DVec3::new(self.unit(), self.unit(), self.unit()));
        match self.below(7) {
            0 => a,
            1 => a + (b - a) * self.unit(),
            2 => (a + b) * 0.5,
            3 => a + (b - a) * self.unit() + (c - a) * self.unit(),
            // Along a face: in its plane, if the origin is; else through a line of it.
            4 => a + (a - b) * (4.0 * self.unit()),
            // Through cells' corners of every map round the origin: coordinates from it with few bits.
            5 => {
                let few = |share: f64| (share * 64.0).round() / 32.0 - 1.0;
                origin + bounds.size().max_element() * DVec3::new(few(share.x), few(share.y), few(share.z))
            }
            _ => bounds.min + bounds.size() * share,
        }
    }
}

/// How projections are built for the judge.
const VARIANTS: [(Numbering, Layout, u8); 3] = [
    (Numbering::FrontToBack, Layout::OneMap, 8),
    (Numbering::Sections, Layout::OneMap, 6),
    (Numbering::FrontToBack, Layout::MapPerSection, 5),
];

/// Fails at the first ray on which the methods differ.
pub(super) fn run(names: impl Iterator<Item = &'static str>, rays: u64) -> Result<()> {
    for name in names {
        let Some(model) = model(name)? else { continue };
        let bvh = TriangleBvh::build(Arc::clone(&model.mesh));
        for kind in Rays::ALL {
            for (numbering, layout, max_level) in VARIANTS {
                let options = ProjectionOptions { numbering, layout, max_level, ..ProjectionOptions::default() };
                let projection = Projection::build(Arc::clone(&model.mesh), kind.viewpoint(&model), &options)?;
                // The slow variants are asked less.
                let count = if (numbering, layout) == (VARIANTS[0].0, VARIANTS[0].1) { rays } else { rays / 16 };
                let hits = compare(&model, &bvh, &projection, kind, count)?;
                println!("{name:<9} {kind:?} {numbering:?} {layout:?}: {count} rays, {hits} hits, no difference");
            }
        }
    }
    Ok(())
}

fn compare(model: &Model, bvh: &TriangleBvh, projection: &Projection, kind: Rays, count: u64) -> Result<u64> {
    let mut dice = Dice(count);
    let (mut segments, mut descents) = (projection.segments(), projection.segments_by_descent());
    let mut hits = 0;
    for _ in 0..count {
        let is_hit = match kind {
            Rays::Eye => {
                let eye = model.picture.eye;
                let direction = dice.target(&model.mesh, eye) - eye;
                let truth = bvh.nearest_hit(eye, direction, f64::INFINITY);
                let found = projection.nearest_hit(eye, direction, f64::INFINITY)?;
                let ordinary = projection.nearest_hit_by_descent(eye, direction, f64::INFINITY)?;
                ensure!(found == truth, "{}: along {direction}: {found:?} is not {truth:?}", model.name);
                ensure!(ordinary == truth, "{}: along {direction}: {ordinary:?}, {truth:?}", model.name);
                truth.is_some()
            }
            Rays::Lamp | Rays::Sun => {
                let light = if kind == Rays::Lamp { model.lamp_source()? } else { model.sun_source()? };
                let x = dice.target(&model.mesh, model.lamp);
                let truth = bvh.towards(light).any_hit(x);
                ensure!(segments.any_hit(x) == truth, "{}: {kind:?} from {x}: not {truth}", model.name);
                let ordinary = descents.any_hit(x);
                ensure!(ordinary == truth, "{}: {kind:?} from {x}, descent: not {truth}", model.name);
                truth
            }
        };
        hits += u64::from(is_hit);
    }
    Ok(hits)
}
