//! `cargo xtask offsets`: what distance from the origin does to answers, as the table of the README.
//!
//! A block of a town, a hundred metres wide, is moved away from the origin; its moved coordinates, rounded to f64, are the
//! scene. Every sample of its surface is answered by the samples of a bake, and by a ray through a tree of triangles in the way
//! of most programs: 32-bit world coordinates, the ray's start moved off the surface along the normal by a fixed length. The
//! truth is the exact answer for the point of the moved scene, asked point by point; every thousandth is found again by the
//! definition in whole numbers, which has nothing in common with the library ([`by_definition`](super::by_definition)).

use std::sync::Arc;

use anyhow::{Result, anyhow, bail, ensure};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbriel_geometry::{Facets, LightSource, Mesh, Placement};
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::{Place, Queries, SamplePoint, Silent, bake, for_each_sample};

use super::{
    by_definition::Triangles,
    duel::request,
    rays::Soup,
    rivals::{Ray, Rival, Tree, all},
    scenes::{bodies, sun_at},
};
use crate::{
    fixtures::{
        SplitMix64,
        meshes::{TriangleMesh, icosphere},
    },
    workspace::{cargo, succeed},
};

/// How far the scene is moved along x and z, metres.
const OFFSETS: [f64; 4] = [0.0, 1e3, 1e5, 1e7];

/// How far rays start off the surface, metres.
const EPSILONS: [f32; 2] = [1e-3, 1e-4];

/// The trees that are asked.
const RIVALS: [&str; 2] = ["obvhs medium", "parry3d"];

/// Samples asked for.
const SAMPLES: u64 = 1_000_000;

/// One sample of so many is asked of all triangles by the definition.
const CHECKED: usize = 1000;

/// Prints the table; with the crates that it needs.
pub(crate) fn run() -> Result<()> {
    if !cfg!(feature = "rivals") {
        let again = ["run", "--quiet", "--package", "xtask", "--features", "rivals", "--", "offsets"];
        return succeed(&mut cargo(&again));
    }
    let rivals: Vec<Rival> = all().into_iter().filter(|rival| RIVALS.contains(&rival.name)).collect();
    ensure!(rivals.len() == RIVALS.len(), "the crates are there");
    let columns = rivals.iter().flat_map(|rival| EPSILONS.map(|epsilon| format!(" {}, {epsilon} m |", rival.name)));
    println!("| offset | umbriel |{}", columns.collect::<String>());
    println!("|---|---|{}", "---|".repeat(rivals.len() * EPSILONS.len()));
    for offset in OFFSETS {
        println!("{}", row(offset, SAMPLES, &rivals)?);
    }
    Ok(())
}

/// One row: the share of all samples that each way misclassifies.
fn row(offset: f64, samples: u64, rivals: &[Rival]) -> Result<String> {
    let scene = town_block(offset)?;
    let block = Block::new(&scene, samples)?;
    let truth = block.truth()?;
    let mut line = format!("| {} | {} |", distance(offset), share(&truth, &block.own()?));
    let soup = Soup::of(&scene)?;
    for rival in rivals {
        let tree = (rival.build)(&soup)?;
        for epsilon in EPSILONS {
            line += &format!(" {} |", share(&truth, &block.by_rays(&*tree, epsilon)));
        }
    }
    Ok(line)
}

/// Houses on five times five lots, a ball of triangles over the middle one, level ground; the sun 35 degrees high.
fn town_block(offset: f64) -> Result<Scene> {
    let mut random = SplitMix64::new(7);
    let mut houses = TriangleMesh::default();
    for lot in 0..25u32 {
        let corner = DVec3::new(f64::from(lot % 5) * 20.0 + 2.0, 0.0, f64::from(lot / 5) * 20.0 + 2.0);
        let size = DVec3::new(random.between(8.0, 15.0), random.between(4.0, 18.0), random.between(8.0, 15.0));
        if lot != 12 {
            houses.append(&bodies::cuboid(corner, corner + size));
        }
    }
    let ball = icosphere(3).map(|point| DVec3::new(50.0, 8.0, 50.0) + point * 6.0);
    let ground = bodies::ground([0.0; 2], [100.0; 2], 0.0);
    let parts = [("ground", ground), ("houses", houses), ("ball", ball)];
    let objects = parts.into_iter().map(|(name, mesh)| {
        let moved = mesh.map(|point| point + DVec3::new(offset, 0.0, offset));
        let positions = moved.positions.iter().map(|position| position.to_array()).collect();
        let shape = Shape::Mesh(Arc::new(Mesh::new(positions, moved.triangles)?));
        Ok(Object::new(name.into(), shape, Placement::IDENTITY, Sides::One)?)
    });
    Ok(Scene { objects: objects.collect::<Result<_>>()?, lights: vec![sun_at(215.0, 35.0)?], ..Scene::default() })
}

/// A scene under its one sun, with its samples in the order of the bake.
struct Block<'a> {
    scene: &'a Scene,
    light: LightSource,
    facets: Vec<Facets>,
    samples: Vec<SamplePoint>,
    asked: u64,
}

impl<'a> Block<'a> {
    fn new(scene: &'a Scene, asked: u64) -> Result<Self> {
        let facets: Option<Vec<Facets>> = scene.objects.iter().map(|object| object.facets()).collect();
        let facets = facets.ok_or_else(|| anyhow!("all bodies are flat"))?;
        let mut samples = Vec::new();
        for_each_sample(scene, &request(scene, &[0], asked), |sample| samples.push(sample));
        Ok(Self { scene, light: scene.lights[0].source, facets, samples, asked })
    }

    /// The exact answers.
    fn truth(&self) -> Result<Vec<bool>> {
        let queries = Queries::new(self.scene);
        let answers = self.samples.par_iter().map(|&SamplePoint { object, face, u, v, .. }| {
            let answer = queries.lit(&Place::Surface { object, face, u, v }, &self.light)?;
            Ok(answer.lit)
        });
        let answers = answers.collect::<Result<Vec<bool>>>()?;
        let (triangles, starts) = self.triangles()?;
        let checked: Vec<usize> = (0..answers.len()).step_by(CHECKED).collect();
        let is_right = |&index: &usize| {
            let SamplePoint { object, face, u, v, .. } = self.samples[index];
            Ok(triangles.is_lit(starts[object] + face, [u, v])? == answers[index])
        };
        let right = checked.par_iter().map(is_right).collect::<Result<Vec<bool>>>()?;
        ensure!(!right.contains(&false), "some answers are not those of the definition");
        Ok(answers)
    }

    /// All triangles as the definition takes them, and where those of each object begin.
    fn triangles(&self) -> Result<(Triangles, Vec<usize>)> {
        let (mut corners, mut starts) = (Vec::new(), Vec::new());
        for object in &self.scene.objects {
            let Shape::Mesh(mesh) = &object.shape else { bail!("all bodies are meshes that stand where they are") };
            starts.push(corners.len());
            let corner = |number: u32| mesh.positions()[number as usize].to_array();
            corners.extend(mesh.triangles().iter().map(|triangle| triangle.map(corner)));
        }
        Ok((Triangles::new(corners.into_iter(), self.light.xyz().to_array())?, starts))
    }

    /// The samples of a bake.
    fn own(&self) -> Result<Vec<bool>> {
        let asked = umbriel_shadow::Request { keep_cells: true, ..request(self.scene, &[0], self.asked) };
        let report = bake(self.scene, &asked, &Silent)?;
        let mut answers = Vec::new();
        for object in &report.lights[0].objects {
            let lit = object.answers.as_ref().ok_or_else(|| anyhow!("answers are kept"))?;
            answers.extend((0..lit.len()).map(|index| lit.is_lit(index)));
        }
        ensure!(answers.len() == self.samples.len(), "an answer a sample");
        Ok(answers)
    }

    /// Single rays in 32-bit world coordinates.
    fn by_rays(&self, tree: &dyn Tree, epsilon: f32) -> Vec<bool> {
        let direction = self.light.xyz().as_vec3().normalize();
        let rays = self.samples.iter().map(|sample| {
            let facets = &self.facets[sample.object];
            let corners = facets.facet(sample.face).corners();
            let [a, b, d] = [0, 1, 2].map(|corner| facets.positions()[corners[corner] as usize].as_vec3());
            let normal = (b - a).cross(d - a).normalize_or_zero();
            let position = a + (b - a) * sample.u as f32 + (d - a) * sample.v as f32;
            (normal, position + normal * epsilon)
        });
        rays.map(|(normal, origin): (Vec3, Vec3)| {
            let ray = Ray { origin: origin.as_dvec3(), direction: direction.as_dvec3(), t_max: f64::INFINITY };
            normal.dot(direction) > 0.0 && tree.count_free(&self.light, &mut std::iter::once(ray)) == 1
        })
        .collect()
    }
}

/// The share of answers that differ from the truth.
fn share(truth: &[bool], answers: &[bool]) -> String {
    let wrong = truth.iter().zip(answers).filter(|(truth, answer)| truth != answer).count();
    match wrong {
        0 => format!("0 of {}", truth.len()),
        _ => format!("{:.4} %", 100.0 * wrong as f64 / truth.len() as f64),
    }
}

fn distance(offset: f64) -> String {
    if offset < 1000.0 { format!("{offset} m") } else { format!("{} km", offset / 1000.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moved_block_keeps_its_answers_exact() {
        for offset in [0.0, 1e7] {
            let scene = town_block(offset).expect("a scene");
            let block = Block::new(&scene, 3000).expect("flat");
            let truth = block.truth().expect("as by the definition");
            assert_eq!(block.own().expect("a bake"), truth, "{offset}");
            let lit = truth.iter().filter(|lit| **lit).count();
            assert!(lit > truth.len() / 10 && lit < truth.len() * 9 / 10, "{lit} of {}", truth.len());
        }
    }

    #[test]
    fn wrong_answers_are_counted() {
        assert_eq!(share(&[true, false], &[true, false]), "0 of 2");
        assert_eq!(share(&[true, false, true, true], &[true, true, true, true]), "25.0000 %");
    }
}
