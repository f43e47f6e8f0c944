//! The picture: every pixel's surface in the light of the scene's lamps, with the computed shadows.
//!
//! Lambert's cosine law for the lights, a sky that is brighter above for everything else, neutral colours. Whether a
//! point is lit comes from the cells of the bake; where these do not say, from an exact query. Or it is looked up in shadow polygons,
//! which were cast once for all pictures of the scene.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::LightSource;
use umbriel_io::write::Picture;
use umbriel_scene::Scene;
use umbriel_shadow::{
    Cancelled, Expected, LightReport, Place, Progress, Queries, Report, SearchChoice, SearchCosts, Verdict,
};
use umbriel_visibility::{Acceleration, Ray, RayCaster, SurfaceHit, View, two_pass::ShadowPolygons};

use crate::output::{cells::CellMap, lamplight::Lamplight};

/// Rays a pixel along each of its edges, unless asked for otherwise.
pub(crate) const SUBPIXELS: u32 = 2;

/// Light of the lamps together, and of the sky at its zenith and below the horizon: linear, a white surface that faces
/// the light squarely has about 1.
const LAMPS: DVec3 = DVec3::new(1.22, 1.12, 0.94);
const ZENITH: DVec3 = DVec3::new(0.19, 0.23, 0.32);
const NADIR: DVec3 = DVec3::new(0.11, 0.10, 0.095);

/// The background, from the upper edge of the picture to the lower one.
const BACKGROUND: [DVec3; 2] = [DVec3::new(0.44, 0.52, 0.64), DVec3::new(0.80, 0.82, 0.84)];

/// Surface colours by turns; neutral, just apart enough to tell neighbours.
const SURFACES: [DVec3; 4] = [
    DVec3::new(0.60, 0.59, 0.55),
    DVec3::new(0.60, 0.56, 0.51),
    DVec3::new(0.52, 0.55, 0.59),
    DVec3::new(0.57, 0.52, 0.48),
];

/// What becomes of pixels in undecided cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Undecided {
    /// They are decided by exact queries.
    Decide,
    /// They are shown in this colour (sRGB).
    Show([u8; 3]),
}

/// All that a picture is made from.
pub(crate) struct Studio<'a> {
    caster: &'a RayCaster,
    lamplight: &'a Lamplight<'a>,
    queries: Queries<'a>,
    lamps: Vec<Lamp>,
    undecided: Undecided,
}

struct Lamp {
    source: LightSource,
    shadows: Shadows,
}

/// What is known of a lamp's shadows.
enum Shadows {
    /// For each object the cells that it was baked into.
    Cells(Vec<CellMap>),
    /// Of the scene that lights are asked about.
    Polygons(ShadowPolygons),
}

/// What is known about a point in the light of a lamp.
enum Exposure {
    Known(bool),
    Undecided,
}

impl<'a> Studio<'a> {
    /// With the cells of a bake. The lights of `lamplight` are those of the report.
    pub(crate) fn new(
        scene: &Scene,
        (lamplight, caster): (&'a Lamplight<'a>, &'a RayCaster),
        report: &Report,
        undecided: Undecided,
    ) -> Self {
        let lamps = report.lights.iter().map(|light| {
            let mut cells: Vec<CellMap> = Vec::new();
            cells.resize_with(scene.objects.len(), CellMap::default);
            for object in &light.objects {
                cells[object.object] = CellMap::new(&object.cells);
            }
            Lamp { source: scene.lights[light.light].source, shadows: Shadows::Cells(cells) }
        });
        Self { caster, lamplight, queries: Queries::new(lamplight.scene()), lamps: lamps.collect(), undecided }
    }

    /// With shadow polygons, cast for the lights of `lamplight`.
    pub(crate) fn with_polygons(
        (lamplight, caster): (&'a Lamplight<'a>, &'a RayCaster),
        lamps: Vec<(LightSource, ShadowPolygons)>,
    ) -> Self {
        let lamps = lamps.into_iter().map(|(source, cast)| Lamp { source, shadows: Shadows::Polygons(cast) }).collect();
        Self { caster, lamplight, queries: Queries::new(lamplight.scene()), lamps, undecided: Undecided::Decide }
    }

    /// Makes ready for the points that no cell decides, of so many that are seen of each object; answers what was chosen for each
    /// light, and why.
    pub(crate) fn prepare(&mut self, report: &Report, points: &[u64], asked: Acceleration) -> Vec<SearchChoice> {
        let costs = SearchCosts::MEASURED;
        let lights = self.lamps.iter().zip(&report.lights);
        let prepare = |(lamp, light): (&Lamp, &LightReport)| {
            let expected = Expected::Places(open_points(light, points));
            self.queries.prepare(&lamp.source, expected, asked, &costs)
        };
        lights.map(prepare).collect()
    }

    /// Some rows of the picture.
    pub(crate) fn rows(
        &self,
        view: &View,
        subpixels: u32,
        rows: Range<u32>,
        progress: &dyn Progress,
    ) -> Result<Vec<[u8; 3]>, Cancelled> {
        take_rows((self.caster, view), subpixels, rows, progress, &|hit, ray| self.surface(hit, ray))
    }

    /// The light that comes from a point of a surface, linear.
    pub(crate) fn surface(&self, hit: &SurfaceHit, ray: &Ray) -> DVec3 {
        let point = ray.origin + hit.distance * ray.direction;
        let seen_from_front = hit.normal.dot(ray.direction) < 0.0;
        let facing = if seen_from_front { hit.normal } else { -hit.normal };
        let mut light = NADIR.lerp(ZENITH, 0.5 + 0.5 * facing.y);
        let albedo = SURFACES[hit.object % SURFACES.len()];
        for (number, lamp) in self.lamps.iter().enumerate() {
            // The lit side is seen only by an eye on the same side of the surface.
            let cosine = facing.dot(towards(&lamp.source, point));
            if cosine <= 0.0 {
                continue;
            }
            match (self.exposure((number, lamp), hit, point), self.undecided) {
                (Exposure::Undecided, Undecided::Show(color)) => return from_srgb(color) * (0.4 + 0.6 * cosine),
                (Exposure::Undecided, Undecided::Decide) | (Exposure::Known(false), _) => {}
                (Exposure::Known(true), _) => light += cosine * LAMPS / self.lamps.len() as f64,
            }
        }
        albedo * light
    }

    fn exposure(&self, (number, lamp): (usize, &Lamp), hit: &SurfaceHit, point: DVec3) -> Exposure {
        let Some(object) = self.lamplight.place(number, hit.object) else { return Exposure::Known(false) };
        let cells = match &lamp.shadows {
            Shadows::Cells(cells) => cells,
            Shadows::Polygons(cast) => {
                let face = cast.of(object, hit.face);
                return Exposure::Known(face.is_some_and(|face| face.is_lit(face.coordinates(point))));
            }
        };
        match cells[hit.object].at(hit.face as u32, hit.u, hit.v) {
            Some(Verdict::Lit) => Exposure::Known(true),
            Some(Verdict::Shadowed) => Exposure::Known(false),
            Some(Verdict::Undecided) if self.undecided != Undecided::Decide => Exposure::Undecided,
            Some(Verdict::Undecided) | None => Exposure::Known(self.exact(lamp, object, hit)),
        }
    }

    fn exact(&self, lamp: &Lamp, object: usize, hit: &SurfaceHit) -> bool {
        let place = Place::Surface { object, face: hit.face, u: hit.u, v: hit.v };
        // A place that is refused lies, by rounding, just outside its face; it stays dark.
        self.queries.lit(&place, &lamp.source).is_ok_and(|answer| answer.lit)
    }
}

/// How many of an object's points no cell decides, all in all: those on its undecided share, or all where it was not baked.
pub(crate) fn open_points(light: &LightReport, points: &[u64]) -> u64 {
    let mut open = points.to_vec();
    for object in &light.objects {
        let share = (object.undecided() / object.area).clamp(0.0, 1.0);
        if share.is_finite() && !object.cells.is_empty() {
            open[object.object] = (open[object.object] as f64 * share) as u64;
        }
    }
    open.iter().sum()
}

/// A picture of surfaces in the colours that `surface` gives them, linear light; rows in parallel.
pub(crate) fn take(
    caster: &RayCaster,
    view: &View,
    subpixels: u32,
    progress: &dyn Progress,
    surface: &(dyn Fn(&SurfaceHit, &Ray) -> DVec3 + Sync),
) -> Result<Picture, Cancelled> {
    let pixels = take_rows((caster, view), subpixels, 0..view.height, progress, surface)?;
    Ok(Picture { width: view.width, height: view.height, pixels })
}

/// Some rows of such a picture. Bands of them are cast square by square: sixteen rays that follow each other go nearly the same way.
fn take_rows(
    (caster, view): (&RayCaster, &View),
    subpixels: u32,
    rows: Range<u32>,
    progress: &dyn Progress,
    surface: &(dyn Fn(&SurfaceHit, &Ray) -> DVec3 + Sync),
) -> Result<Vec<[u8; 3]>, Cancelled> {
    let done = std::sync::atomic::AtomicU64::new(u64::from(rows.start));
    let (eye, side) = (view.rays(), (RayCaster::SQUARE / subpixels).max(1));
    let band = |top: u32| {
        if progress.is_cancelled() {
            return Err(Cancelled);
        }
        let height = side.min(rows.end - top);
        let square = |left: u32| {
            let columns = left..view.width.min(left + side);
            (0..height).flat_map(move |y| columns.clone().map(move |x| [x, y]))
        };
        let pixels: Vec<[u32; 2]> = (0..view.width).step_by(side as usize).flat_map(square).collect();
        let places: Vec<[f64; 2]> = pixels.iter().flat_map(|&[x, y]| places_of([x, top + y], subpixels)).collect();
        let rays: Vec<Ray> = places.iter().map(|&[x, y]| eye.through(x, y)).collect();
        let hits = caster.nearest_of(&rays);
        let color = |n: usize| match &hits[n] {
            Some(hit) => surface(hit, &rays[n]),
            None => background(places[n][1] / f64::from(view.height)),
        };
        let count = (subpixels * subpixels) as usize;
        let mut band = vec![[0; 3]; pixels.len()];
        for (n, [x, y]) in pixels.into_iter().enumerate() {
            let mean = (n * count..(n + 1) * count).map(color).sum::<DVec3>() / count as f64;
            band[(y * view.width + x) as usize] = to_srgb(mean);
        }
        let rows = done.fetch_add(u64::from(height), std::sync::atomic::Ordering::Relaxed) + u64::from(height);
        progress.advance("picture", rows, u64::from(view.height));
        Ok(band)
    };
    let bands = rows.clone().into_par_iter().step_by(side as usize);
    Ok(bands.map(band).collect::<Result<Vec<_>, Cancelled>>()?.concat())
}

/// Where a pixel is looked at, column by column; in pixels.
fn places_of([x, y]: [u32; 2], subpixels: u32) -> impl Iterator<Item = [f64; 2]> {
    let at = move |pixel: u32, part: u32| f64::from(pixel) + (f64::from(part) + 0.5) / f64::from(subpixels);
    (0..subpixels).flat_map(move |i| (0..subpixels).map(move |j| [at(x, i), at(y, j)]))
}

/// The background at a share of the picture's height, from above; linear light.
pub(crate) fn background(share: f64) -> DVec3 {
    BACKGROUND[0].lerp(BACKGROUND[1], share)
}

/// The unit vector from a point towards a light.
fn towards(source: &LightSource, point: DVec3) -> DVec3 {
    let vector = if source.is_sun() { source.xyz() } else { source.xyz() - point };
    vector.normalize_or_zero()
}

/// The transfer curve of sRGB (IEC 61966-2-1).
pub(crate) fn to_srgb(linear: DVec3) -> [u8; 3] {
    linear.to_array().map(|value| {
        let value = value.clamp(0.0, 1.0);
        let curved = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
        (255.0 * curved).round() as u8
    })
}

pub(crate) fn from_srgb(color: [u8; 3]) -> DVec3 {
    DVec3::from_array(color.map(|byte| {
        let value = f64::from(byte) / 255.0;
        if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_survive_the_curve() {
        for byte in 0..=255 {
            assert_eq!(to_srgb(from_srgb([byte, 255 - byte, 7])), [byte, 255 - byte, 7]);
        }
        assert_eq!(to_srgb(DVec3::new(-1.0, 2.0, 0.0)), [0, 255, 0]);
    }
}
