//! A picture of hours: every surface in a colour for its share of them, from dark blue (never lit) to pale yellow (always).
//!
//! The colours grow lighter all the way, so that they can be told apart in grey, too. Shapes are told by a weak light from
//! the eye.

use glam::DVec3;
use umbriel_io::write::Picture;
use umbriel_scene::Scene;
use umbriel_shadow::{Cancelled, HoursReport, Progress};
use umbriel_visibility::{Ray, RayCaster, SurfaceHit, View};

use crate::output::{
    cells::CellMap,
    hours::{place, share},
    picture::{from_srgb, take},
};

/// Colours (sRGB) of shares at equal steps from nothing to all.
const COLORS: [[u8; 3]; 5] = [[24, 28, 72], [92, 60, 128], [196, 88, 88], [246, 164, 72], [255, 244, 176]];

/// Surfaces of objects that were not baked.
const UNKNOWN: [u8; 3] = [128, 128, 128];

/// How much light does not come from the eye.
const EVEN: f64 = 0.65;

/// Takes the picture.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
pub(crate) fn picture(
    scene: &Scene,
    caster: &RayCaster,
    report: &HoursReport,
    view: &View,
    subpixels: u32,
    progress: &dyn Progress,
) -> Result<Picture, Cancelled> {
    let mut maps: Vec<CellMap<f64>> = Vec::new();
    maps.resize_with(scene.objects.len(), CellMap::default);
    for object in &report.objects {
        maps[object.object] = CellMap::with(object.cells.iter().map(|cell| (place(&cell), share(&cell, report))));
    }
    let surface = |hit: &SurfaceHit, ray: &Ray| {
        let color = maps[hit.object].at(hit.face as u32, hit.u, hit.v).map_or(from_srgb(UNKNOWN), color);
        let cosine = hit.normal.dot(ray.direction).abs() / ray.direction.length();
        color * (EVEN + (1.0 - EVEN) * cosine)
    };
    take(caster, view, subpixels, progress, &surface)
}

/// The colour of a share (0 to 1), linear light.
fn color(share: f64) -> DVec3 {
    let last = COLORS.len() - 1;
    let place = share.clamp(0.0, 1.0) * last as f64;
    let first = (place as usize).min(last - 1);
    from_srgb(COLORS[first]).lerp(from_srgb(COLORS[first + 1]), place - first as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_hours_are_lighter() {
        let light = |share: f64| color(share).dot(DVec3::new(0.2126, 0.7152, 0.0722));
        assert!((0..100).all(|k| light(f64::from(k) / 100.0) < light(f64::from(k + 1) / 100.0)));
        assert_eq!((color(0.0), color(1.0)), (from_srgb(COLORS[0]), from_srgb(COLORS[4])));
    }
}
