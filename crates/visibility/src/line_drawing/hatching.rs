//! Shadows as hatches: parallel lines on every face that is seen, kept where the face lies in the shadow of a light.
//!
//! A line of a hatch lies in its face. A face that is turned away from the light is in its own shadow all over; on others the parts that
//! other faces hide from the light are. Ends are rounded.

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{Facets, LightSource, Point, Sign};

use super::{Ink, Line, Stroke, gaps, hidden::Hiders, normal, projection::Projector};

/// More lines on one face than this are not drawn: it passes through the eye's plane, or is far larger than the picture.
const MOST_LINES: f64 = 4096.0;

/// The lines of a hatch.
pub(super) struct Hatch {
    /// Between them, pixels.
    pub(super) spacing: f64,
    /// Whether they go up to the right: lights take turns.
    pub(super) rises: bool,
}

/// The hatches of all faces for one light.
pub(super) fn draw(hiders: &Hiders, projector: &Projector, light: &LightSource, hatch: &Hatch) -> Vec<Stroke> {
    let of = |item: usize| {
        let (body, face) = hiders.face(item as u32);
        let (object, facets) = hiders.bodies[body];
        let seen = facets.turn(face as usize, projector.eye());
        if seen == Sign::Zero {
            return Vec::new();
        }
        // The side that is seen is lit if the light is on the same side.
        let is_turned_away = facets.turn(face as usize, light) != seen;
        let lines = lines_on(facets, face as usize, projector, hatch);
        let strokes = lines.into_iter().flat_map(|ends| {
            let line = Line { ends: ends.map(Point::exact), on: [Some((object, face)), None] };
            shadowed(hiders, projector, &line, light, is_turned_away)
        });
        strokes.collect::<Vec<Stroke>>()
    };
    (0..hiders.boxes.len()).into_par_iter().flat_map_iter(of).collect()
}

/// The strokes of one line.
fn shadowed(
    hiders: &Hiders,
    projector: &Projector,
    line: &Line,
    light: &LightSource,
    is_turned_away: bool,
) -> Vec<Stroke> {
    let ends = line.ends.each_ref().map(|end| end.position);
    let Some(range) = projector.visible_range(ends) else { return Vec::new() };
    let dark = if is_turned_away { vec![[0.0, 1.0]] } else { hiders.hidden_from(line, light) };
    if dark.is_empty() {
        return Vec::new();
    }
    let seen = gaps(&hiders.hidden(line), range);
    let common = dark.iter().flat_map(|d| seen.iter().map(move |s| [d[0].max(s[0]), d[1].min(s[1])]));
    let place = |s: f64| projector.place(ends[0].lerp(ends[1], s));
    common
        .filter(|[from, to]| from < to)
        .map(|[from, to]| Stroke { ink: Ink::Shadow, ends: [place(from), place(to)] })
        .collect()
}

/// Parallel lines on a face, as far apart as asked for at its middle. All faces of one plane have lines of one family.
fn lines_on(facets: &Facets, face: usize, projector: &Projector, hatch: &Hatch) -> Vec<[DVec3; 2]> {
    let numbers = facets.facet(face).corners();
    let corners: Vec<DVec3> = numbers.iter().map(|&number| facets.positions()[number as usize]).collect();
    let normal = normal(facets, face);
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    // Lines where a plane across the slant cuts the face.
    let across = normal.cross(projector.slant(hatch.rises)).normalize_or_zero();
    let step = projector.pixel_at(middle) * hatch.spacing;
    let places: Vec<f64> = corners.iter().map(|corner| corner.dot(across) / step).collect();
    let (low, high) =
        places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &place| (low.min(place), high.max(place)));
    if !(high - low).is_finite() || high - low > MOST_LINES {
        return Vec::new();
    }
    let count = (high.floor() - low.ceil()).max(-1.0) as i64 + 1;
    (0..count).filter_map(|k| chord(&corners, &places, low.ceil() + k as f64)).collect()
}

/// Where a convex polygon has a value that is given at its corners.
fn chord(corners: &[DVec3], values: &[f64], value: f64) -> Option<[DVec3; 2]> {
    let crossing = |k: usize| {
        let next = (k + 1) % corners.len();
        let (from, to) = (values[k] - value, values[next] - value);
        ((from < 0.0) != (to < 0.0)).then(|| corners[k].lerp(corners[next], from / (from - to)))
    };
    let points: Vec<DVec3> = (0..corners.len()).filter_map(crossing).collect();
    points.try_into().ok()
}
