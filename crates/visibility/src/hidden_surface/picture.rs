//! The picture of faces, and what is known about the surface in a pixel.

use glam::DVec3;
use umbriel_geometry::{Facets, PlacedAnalytic};

use super::{
    NOTHING,
    shot::{Body, Shot},
    window::Window,
};
use crate::ray_casting::{SurfaceHit, into_triangle};

/// The face in a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// Index into the scene's objects.
    pub object: usize,
    /// The facet; 0 for a curved body, whose patch [`FacePicture::hit`] tells.
    pub face: usize,
}

/// Which face each pixel of some rows shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FacePicture {
    window: Window,
    pixels: Vec<u32>,
}

impl FacePicture {
    /// Puts windows together.
    pub(super) fn join(whole: Window, parts: impl Iterator<Item = (Window, Vec<u32>)>) -> Self {
        let mut pixels = vec![NOTHING; whole.area()];
        for (window, part) in parts {
            let width = window.width() as usize;
            for (row, line) in (window.top..window.bottom).zip(part.chunks(width.max(1))) {
                let start = whole.index([window.left, row]);
                pixels[start..start + width].copy_from_slice(line);
            }
        }
        Self { window: whole, pixels }
    }

    /// The pixels that it holds.
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// The face in a pixel, by the picture's columns and rows.
    ///
    /// # Panics
    /// If the pixel is not one of the picture's.
    pub fn seen(&self, shot: &Shot, pixel: [u32; 2]) -> Option<Seen> {
        let footprint = shot.footprints.get(self.pixels[self.window.index(pixel)] as usize)?;
        Some(Seen { object: footprint.object as usize, face: footprint.face as usize })
    }

    /// The point of the surface in a pixel, with its depth: rounded from what is decided exactly, and the same bits for all methods.
    ///
    /// # Panics
    /// If the pixel is not one of the picture's.
    pub fn hit(&self, shot: &Shot, pixel: [u32; 2]) -> Option<SurfaceHit> {
        let Seen { object, face } = self.seen(shot, pixel)?;
        let ray = shot.ray(pixel);
        match &shot.bodies[object] {
            Body::Flat(facets) => Some(facet_hit(facets, object, face, ray.origin, ray.direction)),
            Body::Curved(body) => curved_hit(shot, body, object, &ray),
            Body::Unknown => None,
        }
    }

    /// At how many pixels the pictures differ.
    ///
    /// # Panics
    /// If they are not of the same size.
    pub fn differences(&self, other: &Self) -> usize {
        assert_eq!(self.window, other.window, "pictures of the same pixels");
        self.pixels.iter().zip(&other.pixels).filter(|(a, b)| a != b).count()
    }

    /// How many pixels show a face.
    pub fn covered(&self) -> usize {
        self.pixels.iter().filter(|&&face| face != NOTHING).count()
    }
}

fn facet_hit(facets: &Facets, object: usize, face: usize, origin: DVec3, direction: DVec3) -> SurfaceHit {
    let numbers = facets.facet(face).corners();
    let [a, b, d] = [0, 1, numbers.len() - 1].map(|k| facets.positions()[numbers[k] as usize]);
    let (u, v) = (b - a, d - a);
    let normal = u.cross(v);
    let from_corner = origin - a;
    // Cramer's rule for a + u·s + v·t = o + d·distance.
    let divisor = normal.dot(direction);
    let distance = -normal.dot(from_corner) / divisor;
    let turned = from_corner.cross(direction);
    let (s, t) = (-v.dot(turned) / divisor, u.dot(turned) / divisor);
    let (s, t) = if numbers.len() == 3 { into_triangle(s, t) } else { (s.clamp(0.0, 1.0), t.clamp(0.0, 1.0)) };
    let front = if facets.is_mirrored() { -normal } else { normal };
    SurfaceHit { object, face, u: s, v: t, distance, normal: front.normalize_or_zero() }
}

fn curved_hit(shot: &Shot, body: &PlacedAnalytic, object: usize, ray: &umbriel_bvh::Ray) -> Option<SurfaceHit> {
    let crossing = shot.crossing(body, ray)?;
    let distance = crossing.distance.rounded(|number| number.value);
    let point = ray.origin + distance * ray.direction;
    let to_local = body.placement().map().inverse();
    let local = to_local.transform_point3(point);
    let (face, [u, v]) = body.locate(crossing.surface, local)?;
    let normal = to_local.matrix3.transpose() * body.outward_at(crossing.surface, local);
    Some(SurfaceHit { object, face, u, v, distance, normal: normal.normalize_or_zero() })
}
