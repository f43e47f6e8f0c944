//! `cargo xtask calibrate`: the coefficients of the cost model by which rays choose their way, and what the choice costs.
//!
//! Times of the three ways on meshes of several sizes, with few rays and with many, are fitted by least squares of relative
//! errors over coefficients that are not negative (coordinate descent, which converges for a convex problem).

use std::sync::Arc;

use anyhow::Result;
use umbriel_bvh::TriangleBvh;
use umbriel_octree::{Projection, ProjectionOptions};
use umbriel_visibility::RayCost;

use super::{
    measure::{Method, Questions, Rays, by_bvh, by_projection, quickest},
    models::{Model, model, names},
};
use crate::bench::clock::timed;

/// Seconds of a way for so many rays through so many triangles, building included for octrees.
struct Sample {
    name: String,
    rays: f64,
    triangles: usize,
    /// BVH, octree, maps.
    seconds: [f64; 3],
}

/// Rays along a side of the pictures.
const SIDES: [u64; 4] = [64, 256, 512, 1024];

/// As the library has it: an octree is taken where it should need less than this share of the BVH's time.
const CLEARLY: f64 = 0.8;

/// Rounds of the descent: far more than three unknowns need.
const ROUNDS: usize = 20_000;

pub(crate) fn run() -> Result<()> {
    let mut samples = Vec::new();
    for name in names() {
        let Some(model) = model(name)? else { continue };
        let bvh = TriangleBvh::build(Arc::clone(&model.mesh));
        for side in SIDES {
            samples.push(sample(&model, &bvh, side)?);
        }
    }
    let costs = [0, 1, 2].map(|way| fit(&samples, way));
    for (name, cost) in ["bvh", "octree", "projection"].iter().zip(&costs) {
        let RayCost { base, doubling, triangle } = cost;
        println!("{name}: RayCost {{ base: {base:.1}, doubling: {doubling:.1}, triangle: {triangle:.1} }},");
    }
    let mut worst = 1.0f64;
    for sample in &samples {
        let [bvh, octree, maps] = costs.map(|cost| cost.nanoseconds(sample.rays as u64, sample.triangles));
        let chosen = if octree.min(maps) > CLEARLY * bvh { 0 } else { 1 + usize::from(maps <= octree) };
        let best = sample.seconds.into_iter().fold(f64::INFINITY, f64::min);
        let ratio = sample.seconds[chosen] / best;
        worst = worst.max(ratio);
        let told = sample.seconds.map(|seconds| format!("{:.1}", seconds * 1e3)).join(", ");
        println!(
            "{}: ms {told}; takes {}, {ratio:.2} times the best",
            sample.name,
            ["the BVH", "the octree", "the maps"][chosen]
        );
    }
    println!("at worst {worst:.2} times the best");
    Ok(())
}

/// Eye rays of a picture.
fn sample(model: &Model, bvh: &TriangleBvh, side: u64) -> Result<Sample> {
    let questions = Questions::new(model, bvh, Rays::Eye, side);
    let triangles = model.mesh.triangles().len();
    let by = |method: Method, rays: u64| -> Result<f64> {
        let deeper = if method == Method::Octree { 2 } else { 0 };
        let max_level = ProjectionOptions::level_for(triangles) + deeper;
        let options = ProjectionOptions { max_level, rays, ..ProjectionOptions::default() };
        let viewpoint = Rays::Eye.viewpoint(model);
        let (built, build) = timed(|| Projection::build(Arc::clone(&model.mesh), viewpoint, &options));
        let built = built?;
        Ok(build.cpu + quickest(|| by_projection(&built, method, &questions)).0)
    };
    let seconds = [
        quickest(|| by_bvh(bvh, model, Rays::Eye, &questions)).0,
        by(Method::Octree, 0)?,
        by(Method::Maps, questions.len() as u64)?,
    ];
    let name = format!("{} {side}²", model.name);
    Ok(Sample { name, rays: questions.len() as f64, triangles, seconds })
}

/// The coefficients of one way.
fn fit(samples: &[Sample], way: usize) -> RayCost {
    // Each row over its own time: relative errors count.
    let rows: Vec<[f64; 3]> = samples
        .iter()
        .map(|sample| {
            let nanoseconds = sample.seconds[way] * 1e9;
            let triangles = sample.triangles as f64;
            [sample.rays, sample.rays * triangles.log2(), triangles].map(|term| term / nanoseconds)
        })
        .collect();
    let mut x = [0.0; 3];
    for _ in 0..ROUNDS {
        for j in 0..3 {
            let rest = |row: &[f64; 3]| 1.0 - (0..3).filter(|&k| k != j).map(|k| row[k] * x[k]).sum::<f64>();
            let along = rows.iter().map(|row| row[j] * rest(row)).sum::<f64>();
            let square = rows.iter().map(|row| row[j] * row[j]).sum::<f64>();
            x[j] = (along / square).max(0.0);
        }
    }
    RayCost { base: x[0], doubling: x[1], triangle: x[2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_that_is_one_is_found() {
        let truth = RayCost { base: 100.0, doubling: 20.0, triangle: 3000.0 };
        let sample = |(rays, triangles): (u64, usize)| Sample {
            name: String::new(),
            rays: rays as f64,
            triangles,
            seconds: [truth.nanoseconds(rays, triangles) / 1e9; 3],
        };
        let cases =
            [1 << 12, 1 << 16, 1 << 20].into_iter().flat_map(|rays| [(rays, 100), (rays, 5_000), (rays, 300_000)]);
        let samples: Vec<Sample> = cases.map(sample).collect();
        let found = fit(&samples, 1);
        assert!((found.base - 100.0).abs() < 5.0 && (found.triangle - 3000.0).abs() < 30.0, "{found:?}");
        assert!((found.doubling - 20.0).abs() < 1.0, "{found:?}");
    }
}
