//! Shadow volumes: what a light does not see, closed in by polygons.
//!
//! Crow, "Shadow algorithms for computer graphics" (SIGGRAPH 1977); counted beyond the surface as in Carmack's and Bilodeau and Songy's z-fail,
//! with walls that reach to infinity (Everitt and Kilgard, "Practical and robust stenciled shadow volumes", NVIDIA 2002). Triangles turned to the
//! light are caps; where the directed edges of caps do not cancel is the silhouette ([`sheets`]), and from it walls reach away from the light. A
//! point is in shadow if the way on from the eye through it leaves more volumes than it enters; walls and caps are drawn over all points at once
//! ([`screen`]), which is a stencil buffer with a sample wherever a point is: for the points that a camera sees, the classic method.
//!
//! Of closed surfaces only the front faces are caps. O(n log n) for the silhouettes; then every polygon pays for the points in its outline, seen from the
//! eye. In floats: points within rounding of a volume's border may be wrong. A point's own face is a cap that it lies before.

mod run;
mod screen;
mod sheets;

use std::time::Instant;

use glam::DVec3;
use umbriel_geometry::LightSource;

use self::screen::Screen;
use super::{Polygons, Rival, RivalAnswer, RivalPoint, RivalRefusal};

/// Shadow volumes, seen from somewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShadowVolume {
    /// The eye, world coordinates in metres. It must have all points on one side: the points that a camera sees, or outside of the scene. `None` takes
    /// a place outside. Where it stands changes the work, not the answer.
    pub eye: Option<DVec3>,
}

impl Rival for ShadowVolume {
    fn name(&self) -> String {
        "shadow volume".into()
    }

    fn answer(
        &self,
        polygons: &Polygons,
        light: &LightSource,
        points: &[RivalPoint],
    ) -> Result<RivalAnswer, RivalRefusal> {
        let begun = Instant::now();
        let sheets = sheets::of(polygons, light);
        let build_seconds = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let asked: Vec<u32> =
            (0..points.len() as u32).filter(|&point| points[point as usize].is_turned_to(light)).collect();
        let mut lit = vec![false; points.len()];
        let eye = self.eye.unwrap_or_else(|| eye_outside(polygons, light));
        let screen = Screen::new(eye, points, asked);
        let looked_at = screen.count(&sheets, |point, volumes| lit[point as usize] = volumes <= 0);
        let bytes = (sheets.len() * size_of::<sheets::Sheet>()) as u64 + screen.bytes();
        let points_seconds = begun.elapsed().as_secs_f64();
        Ok(RivalAnswer { lit, build_seconds, points_seconds, rays: 0, looked_at, pieces: sheets.len() as u64, bytes })
    }
}

/// A place that sees all of the scene, two thirds of a right angle or so from the light's direction.
fn eye_outside(polygons: &Polygons, light: &LightSource) -> DVec3 {
    let bounds = polygons.bounds();
    let (center, radius) = (bounds.center(), 0.5 * bounds.size().length());
    let to_light = (light.xyz() - light.w() * center).normalize_or(DVec3::Y);
    // Directions with unequal parts, so that they lie in no usual plane.
    let directions = [DVec3::new(0.36, 0.8, 0.48), DVec3::new(-0.64, 0.48, 0.6), DVec3::new(0.6, 0.64, -0.48)];
    let farness = |direction: &DVec3| (direction.dot(to_light) - 0.5).abs();
    let direction = directions.into_iter().min_by(|a, b| farness(a).total_cmp(&farness(b)));
    center + 2.0 * radius * direction.unwrap_or(DVec3::Y)
}
