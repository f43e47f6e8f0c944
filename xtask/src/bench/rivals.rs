//! Trees of boxes in Rust, asked one ray at a time: what a program does that takes a crate and shoots rays.
//!
//! The workspace's own tree of triangles is always among them; the feature `rivals` adds the crates `obvhs`, `bvh` and
//! `parry3d` in the configurations that their documentation shows.

use std::sync::Arc;

use anyhow::Result;
use glam::DVec3;
use umbriel_bvh::TriangleBvh;
use umbriel_geometry::{LightSource, Mesh};
use umbriel_scene::Scene;
use umbriel_shadow::Request;

use super::{
    clock::{Seconds, timed},
    rays::{Soup, Start},
};

#[cfg(feature = "rivals")]
mod crates;

/// A ray to a light: the points `origin + t direction` for 0 < t < `t_max`.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "rivals"), expect(dead_code, reason = "the workspace's own tree takes the light instead"))]
pub(super) struct Ray {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    pub(super) t_max: f64,
}

/// A built tree.
pub(super) trait Tree {
    /// How many of the rays to a light nothing is in the way of.
    fn count_free(&self, light: &LightSource, rays: &mut dyn Iterator<Item = Ray>) -> u64;
}

/// A name, and how to build.
pub(super) struct Rival {
    pub(super) name: &'static str,
    pub(super) build: fn(&Soup) -> Result<Box<dyn Tree>>,
}

/// The tree of this workspace.
pub(super) const OWN_TREE: Rival = Rival { name: "umbriel-bvh", build: |soup| Ok(Box::new(own_tree(soup)?)) };

/// All that this program knows.
pub(super) fn all() -> Vec<Rival> {
    #[cfg(feature = "rivals")]
    return [vec![OWN_TREE], crates::all()].into_iter().flatten().collect();
    #[cfg(not(feature = "rivals"))]
    vec![OWN_TREE]
}

fn own_tree(soup: &Soup) -> Result<TriangleBvh> {
    let positions = soup.positions.iter().map(|position| position.map(f64::from)).collect();
    Ok(TriangleBvh::build(Arc::new(Mesh::new(positions, soup.triangles.clone())?)))
}

impl Tree for TriangleBvh {
    fn count_free(&self, light: &LightSource, rays: &mut dyn Iterator<Item = Ray>) -> u64 {
        let mut segments = self.towards(*light);
        rays.filter(|ray| !segments.any_hit(ray.origin)).count() as u64
    }
}

/// Where all rays of a request start.
pub(super) struct Starts {
    starts: Vec<Start>,
    offset: f32,
}

impl Starts {
    pub(super) fn of(soup: &Soup, scene: &Scene, request: &Request) -> Self {
        let mut starts = Vec::new();
        soup.for_each_start(scene, request, |_, start| starts.push(start));
        Self { starts, offset: soup.offset }
    }

    /// Builds the tree, then asks one ray after the other; answers the time, and how many samples are lit.
    pub(super) fn run(&self, rival: &Rival, soup: &Soup, light: &LightSource) -> Result<(Seconds, u64)> {
        let (lit, seconds) = timed(|| {
            let tree = (rival.build)(soup)?;
            let mut rays = self.starts.iter().filter_map(|start| start.ray(light, self.offset));
            anyhow::Ok(tree.count_free(light, &mut rays))
        });
        Ok((seconds, lit?))
    }
}
