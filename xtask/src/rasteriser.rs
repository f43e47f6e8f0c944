//! The depth buffer beside a rasteriser from the registry, on the same triangles: `cargo xtask pictures --rival`, with the feature `rasterisers`.
//!
//! The rival is `euc`: f32, a depth buffer, one thread. On two threads each draws one half of the picture. It gets the triangles in the eye's coordinates, as a program
//! would keep them; ours begins with the scene's placed faces, and both begin with nothing drawn. Pixels count as differing where the two show different faces.

use anyhow::Result;
use umbriel_scene::Scene;
use umbriel_visibility::View;

#[cfg(not(feature = "rasterisers"))]
pub(crate) fn compare(_: &Scene, _: &View) -> Result<()> {
    anyhow::bail!(
        "built without the feature `rasterisers`: cargo run -p xtask --features rasterisers -- pictures --rival"
    )
}

#[cfg(feature = "rasterisers")]
pub(crate) use with_euc::compare;

#[cfg(feature = "rasterisers")]
mod with_euc {
    use std::time::{Duration, Instant};

    use anyhow::{Context, ensure};
    use euc::{
        DepthStrategy, Interpolate, Pipeline,
        buffer::Buffer2d,
        rasterizer::{BackfaceCullingDisabled, Triangles},
    };
    use glam::DVec3;
    use umbriel_scene::Projection;
    use umbriel_visibility::hidden_surface::{DepthBuffer, Shot, draw};

    use super::*;

    /// Runs of each; the quickest counts.
    const RUNS: usize = 5;

    /// What a pixel shows where there is no face.
    const NOTHING: u32 = u32::MAX;

    /// Rows from..from + rows of a picture.
    struct Part {
        /// Turns a height in the picture, −1 to 1, into one of the part: factor and offset.
        up: [f32; 2],
        size: [usize; 2],
    }

    /// A corner in the eye's coordinates over the picture's half edges, and its face.
    type Corner = ([f32; 3], u32);

    /// The number of a face, which does not change over it.
    #[derive(Clone, Copy)]
    struct Face(u32);

    impl Interpolate for Face {
        fn lerp2(a: Self, _: Self, _: f32, _: f32) -> Self {
            a
        }

        fn lerp3(a: Self, _: Self, _: Self, _: f32, _: f32, _: f32) -> Self {
            a
        }
    }

    impl Pipeline for Part {
        type Vertex = Corner;
        type VsOut = Face;
        type Pixel = u32;

        fn vert(&self, &([x, y, z], face): &Corner) -> ([f32; 4], Face) {
            // The third is divided by the fourth: −1/z, less where it is nearer.
            ([x, self.up[0] * y + self.up[1] * z, -1.0, z], Face(face))
        }

        fn frag(&self, face: &Face) -> u32 {
            face.0
        }

        fn get_depth_strategy(&self) -> DepthStrategy {
            DepthStrategy::IfLessWrite
        }
    }

    impl Part {
        fn draw(&self, corners: &[Corner]) -> Vec<u32> {
            let mut faces = Buffer2d::new(self.size, NOTHING);
            let mut depths = Buffer2d::new(self.size, f32::INFINITY);
            Pipeline::draw::<Triangles<Buffer2d<f32>, BackfaceCullingDisabled>, _>(
                self,
                corners,
                &mut faces,
                Some(&mut depths),
            );
            faces.as_ref().to_vec()
        }
    }

    /// The picture as `parts` bands one above the other, each by a thread of its own.
    fn rival(corners: &[Corner], [width, height]: [usize; 2], parts: usize) -> Vec<u32> {
        let bands = (0..parts).map(|band| {
            let factor = parts as f32;
            Part { up: [factor, 2.0 * band as f32 - (factor - 1.0)], size: [width, height / parts] }
        });
        let bands: Vec<Part> = bands.collect();
        std::thread::scope(|scope| {
            let drawn: Vec<_> = bands.iter().map(|band| scope.spawn(|| band.draw(corners))).collect();
            drawn.into_iter().flat_map(|band| band.join().unwrap_or_default()).collect()
        })
    }

    /// All triangles as the eye of a perspective sees them; faces by their number over all objects.
    fn corners(scene: &Scene, view: &View) -> Result<Vec<Corner>> {
        let camera = &view.camera;
        let Projection::Perspective { vertical_degrees } = camera.projection else {
            anyhow::bail!("the rival draws perspectives");
        };
        let forward = (camera.target - camera.eye).normalize();
        let right = forward.cross(camera.up).normalize();
        let up = right.cross(forward);
        let half = (0.5 * vertical_degrees).to_radians().tan();
        let aspect = f64::from(view.width) / f64::from(view.height);
        let seen = |point: DVec3| {
            let from_eye = point - camera.eye;
            [from_eye.dot(right) / (half * aspect), from_eye.dot(up) / half, from_eye.dot(forward)]
                .map(|value| value as f32)
        };
        let mut corners = Vec::new();
        let mut number = 0;
        for object in &scene.objects {
            let facets = object.facets().context("a body with flat faces")?;
            for facet in facets.iter() {
                let numbers = facet.corners();
                for k in 1..numbers.len() - 1 {
                    for corner in [0, k, k + 1] {
                        corners.push((seen(facets.positions()[numbers[corner] as usize]), number));
                    }
                }
                number += 1;
            }
        }
        ensure!(corners.iter().all(|(point, _)| point[2] > 0.0), "the rival does not clip: all must be before the eye");
        Ok(corners)
    }

    fn quickest<T>(mut work: impl FnMut() -> T) -> (Duration, T) {
        let mut timed = || {
            let start = Instant::now();
            let done = work();
            (start.elapsed(), done)
        };
        let mut best = timed();
        for _ in 1..RUNS {
            let run = timed();
            if run.0 < best.0 {
                best = run;
            }
        }
        best
    }

    /// Prints a line for one thread and one for two.
    pub(crate) fn compare(scene: &Scene, view: &View) -> Result<()> {
        let list = corners(scene, view)?;
        let size = [view.width as usize, view.height as usize];
        let starts: Vec<u32> = scene
            .objects
            .iter()
            .scan(0, |sum, object| {
                let start = *sum;
                *sum += object.face_count() as u32;
                Some(start)
            })
            .collect();
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
            let (prepared, shot) = pool.install(|| quickest(|| Shot::new(scene, view)));
            let shot = shot?;
            let (drawn, (ours, _)) = pool.install(|| quickest(|| draw(&DepthBuffer::default(), &shot)));
            let (theirs, faces) = quickest(|| rival(&list, size, threads));
            let at = |index: usize| {
                let seen = ours.seen(&shot, [(index % size[0]) as u32, (index / size[0]) as u32]);
                seen.map_or(NOTHING, |seen| starts[seen.object] + seen.face as u32)
            };
            let differing = (0..faces.len()).filter(|&index| at(index) != faces[index]).count();
            let seconds = [prepared, drawn, theirs].map(|time| time.as_secs_f64());
            println!(
                "  {threads} threads, {} triangles: prepare {:.4} s, draw {:.4} s, euc {:.4} s: {:.2} and with preparing {:.2} of its time; {differing} of {} pixels show another face",
                list.len() / 3,
                seconds[0],
                seconds[1],
                seconds[2],
                seconds[1] / seconds[2],
                (seconds[0] + seconds[1]) / seconds[2],
                faces.len()
            );
        }
        Ok(())
    }
}
