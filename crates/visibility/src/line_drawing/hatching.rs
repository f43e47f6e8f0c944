//! Shadows as hatches: lines that are parallel and equally spaced in the picture, kept on every face where it lies in the shadow of a light.
//!
//! A line of the picture and the eye are a plane, and where it cuts a face is a segment: the picture's coordinate across the lines is n/d with n and d affine on the face, and
//! a line is n − c·d = 0. So one family of lines runs over all faces, near and far. A face that is turned away from the light is in its own shadow all over; on others the parts that
//! other faces hide from the light are. Ends are rounded.

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{Facets, LightSource, Point, Sign};

use super::{Ink, Line, Stroke, gaps, hidden::Hiders, projection::Projector};

/// The lines of a hatch.
pub(super) struct Hatch {
    /// Between them, pixels.
    pub(super) spacing: f64,
    /// Across them: a unit vector of the picture, right and up.
    pub(super) across: [f64; 2],
}

impl Hatch {
    /// The hatch of a light by its number: lines up to the right, then down, then steep and flat, and ever half-way between: Van der Corput's sequence.
    pub(super) fn of_light(number: usize, spacing: f64) -> Self {
        let share = (number as u32).reverse_bits() as f64 / (1u64 << 32) as f64;
        let (sine, cosine) = (std::f64::consts::PI * (0.75 + share)).sin_cos();
        Self { spacing, across: [cosine, sine] }
    }
}

/// The hatches of all faces of some bodies (ascending) for one light.
pub(super) fn draw(
    (hiders, hatched): (&Hiders, &[usize]),
    projector: &Projector,
    light: &LightSource,
    hatch: &Hatch,
) -> Vec<Stroke> {
    let of = |item: usize| {
        let (body, face) = hiders.face(item as u32);
        let (object, facets) = hiders.bodies[body];
        let seen = facets.turn(face as usize, projector.eye());
        if seen == Sign::Zero || hatched.binary_search(&body).is_err() {
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

/// The lines of a hatch on a face, as far as they may be in the picture.
fn lines_on(facets: &Facets, face: usize, projector: &Projector, hatch: &Hatch) -> Vec<[DVec3; 2]> {
    let numbers = facets.facet(face).corners();
    let corners: Vec<DVec3> = numbers.iter().map(|&number| facets.positions()[number as usize]).collect();
    let values: Vec<[f64; 2]> = corners.iter().map(|&corner| projector.across(corner, hatch.across)).collect();
    let reach = projector.reach_across(hatch.across);
    let places = values.iter().map(|[n, d]| n / d);
    let (low, high) = if values.iter().all(|&[_, depth]| depth > 0.0) {
        places.fold((reach, -reach), |(low, high), place| (low.min(place), high.max(place)))
    } else {
        // It reaches behind the eye, where its image has no end.
        (-reach, reach)
    };
    let (first, last) = ((low.max(-reach) / hatch.spacing).ceil(), (high.min(reach) / hatch.spacing).floor());
    let count = (last - first).max(-1.0) as i64 + 1;
    let line = |k: i64| {
        let place = (first + k as f64) * hatch.spacing;
        let offsets: Vec<f64> = values.iter().map(|[n, d]| n - place * d).collect();
        chord(&corners, &offsets)
    };
    (0..count).filter_map(line).collect()
}

/// Where a value that is given at the corners of a convex polygon is zero.
fn chord(corners: &[DVec3], values: &[f64]) -> Option<[DVec3; 2]> {
    let crossing = |k: usize| {
        let next = (k + 1) % corners.len();
        let (from, to) = (values[k], values[next]);
        ((from < 0.0) != (to < 0.0)).then(|| corners[k].lerp(corners[next], from / (from - to)))
    };
    let points: Vec<DVec3> = (0..corners.len()).filter_map(crossing).collect();
    points.try_into().ok()
}
