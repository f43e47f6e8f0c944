//! Line drawings: the edges of bodies with hidden parts left out or dashed, decided in object space (Roberts, "Machine perception of
//! three-dimensional solids", MIT Lincoln Laboratory, 1963).
//!
//! **What hides.** Behind a convex face, seen from the eye, lies a convex volume: planes through the eye and the face's edges, and the face's own
//! plane. These planes are the face's *volume matrix*. A point of an edge is hidden by the face if all planes have it inside. Each plane's
//! value is affine along the edge, so each cuts the edge once, and the face hides one interval of it. Roberts takes the planes of whole
//! convex bodies; here every face is a convex piece, so concave meshes need no decomposition and bodies may run through each other.
//!
//! **What is drawn.** Borders, outlines (one face turned to the eye, one away), creases, and the segments along which faces of different
//! objects cross. Shadows are hatched: strokes on the faces that are seen, where a face hides them from a light. The light is an eye, too.
//!
//! **What is exact.** On which side of each plane the ends of an edge lie: signs of input corners, so an edge is not hidden by the faces that
//! it borders, nor by what it touches. Where an edge is cut is rounded, and so are the ends of crossings and hatches, which are drawn
//! and decide nothing but themselves. Curved bodies hide nothing and are not drawn; [`Drawing::curved`] counts them.
//!
//! Cost: O(edges · faces near the way to the eye), the latter by a tree of boxes; hatches as edges, once more for each light.

mod crossings;
mod edges;
mod hatching;
mod hidden;
mod projection;

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{Facets, LightSource};
use umbriel_scene::Scene;

use crate::{View, hidden_surface::ShotDefect};
use hidden::Hiders;
use projection::Projector;

/// What a stroke stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ink {
    /// A part of an edge that is seen.
    Visible,
    /// A part that something hides.
    Hidden,
    /// A line of shadow on a face that is seen.
    Shadow,
}

/// A straight stroke in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// What it stands for.
    pub ink: Ink,
    /// Ends, pixels from the upper left corner.
    pub ends: [[f64; 2]; 2],
}

/// What is drawn.
#[derive(Clone, Debug)]
pub struct LineOptions {
    /// Edges where faces bend by more than this are drawn, degrees; outlines and borders always are. 0 draws every bend.
    pub crease_degrees: f64,
    /// Whether hidden parts are kept, as strokes of their own.
    pub keeps_hidden: bool,
    /// Lights whose shadows are hatched.
    pub lights: Vec<LightSource>,
    /// Between the lines of a hatch, pixels.
    pub hatch_spacing: f64,
}

impl Default for LineOptions {
    fn default() -> Self {
        Self { crease_degrees: 20.0, keeps_hidden: false, lights: Vec::new(), hatch_spacing: 6.0 }
    }
}

/// A line drawing.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// The picture's size, pixels.
    pub size: [u32; 2],
    /// Sorted by what they stand for, then by objects and edges.
    pub strokes: Vec<Stroke>,
    /// Curved bodies, which are left out.
    pub curved: usize,
}

/// A segment in space that may be drawn, and what it lies on.
pub(crate) struct Line<'a> {
    ends: [umbriel_geometry::Point<'a>; 2],
    /// Faces that it is known to lie on: object and face. They do not hide it.
    on: [Option<(u32, u32)>; 2],
}

/// Draws a scene.
///
/// # Errors
/// [`ShotDefect`] for a picture without pixels, or a camera that is not accepted.
pub fn draw_lines(scene: &Scene, view: &View, options: &LineOptions) -> Result<Drawing, ShotDefect> {
    let projector = Projector::new(view)?;
    let bodies: Vec<Option<Facets>> = scene.objects.par_iter().map(|object| object.facets()).collect();
    let flat: Vec<(u32, &Facets)> =
        bodies.iter().enumerate().filter_map(|(object, facets)| Some((object as u32, facets.as_ref()?))).collect();
    let hiders = Hiders::new(&flat, projector.eye());
    let limit = options.crease_degrees.to_radians().cos();
    let mut lines: Vec<Line> =
        flat.iter().flat_map(|(_, facets)| edges::edges(facets, projector.eye(), limit)).collect();
    lines.extend(crossings::crossings(&hiders));
    let drawn: Vec<Vec<Stroke>> = lines.par_iter().map(|line| strokes(line, &hiders, &projector, options)).collect();
    let mut strokes = drawn.concat();
    for (number, light) in options.lights.iter().enumerate() {
        let hatch = hatching::Hatch { spacing: options.hatch_spacing, rises: number % 2 == 0 };
        strokes.extend(hatching::draw(&hiders, &projector, light, &hatch));
    }
    strokes.retain(Stroke::is_seen);
    strokes.sort_by_key(|stroke| stroke.ink);
    Ok(Drawing { size: [view.width, view.height], strokes, curved: bodies.len() - flat.len() })
}

/// Shorter strokes are what rounding leaves of the ends of others, pixels; nobody sees them.
const LEAST_STROKE: f64 = 0.01;

impl Stroke {
    fn is_seen(&self) -> bool {
        let [[a, b], [c, d]] = self.ends;
        (c - a).hypot(d - b) >= LEAST_STROKE
    }
}

/// The seen and the hidden parts of a line.
fn strokes(line: &Line, hiders: &Hiders, projector: &Projector, options: &LineOptions) -> Vec<Stroke> {
    let ends = line.ends.each_ref().map(|end| end.position);
    let Some(range) = projector.visible_range(ends) else { return Vec::new() };
    let hidden = hiders.hidden(line);
    let stroke = |ink: Ink| {
        move |[from, to]: [f64; 2]| {
            let at = |s: f64| projector.place(ends[0].lerp(ends[1], s));
            Stroke { ink, ends: [at(from), at(to)] }
        }
    };
    let mut strokes: Vec<Stroke> = gaps(&hidden, range).into_iter().map(stroke(Ink::Visible)).collect();
    if options.keeps_hidden {
        let parts = hidden.iter().map(|&[from, to]| [from.max(range[0]), to.min(range[1])]);
        strokes.extend(parts.filter(|[from, to]| from < to).map(stroke(Ink::Hidden)));
    }
    strokes
}

/// What sorted, disjoint intervals leave of a range.
fn gaps(intervals: &[[f64; 2]], [first, last]: [f64; 2]) -> Vec<[f64; 2]> {
    let mut from = first;
    let mut gaps = Vec::new();
    for &[start, end] in intervals {
        gaps.push([from, start.min(last)]);
        from = from.max(end);
    }
    gaps.push([from, last]);
    gaps.retain(|[from, to]| from < to);
    gaps
}

/// A unit normal of a facet on the side where its corners run counter-clockwise; zero without area.
fn normal(facets: &Facets, face: usize) -> DVec3 {
    let numbers = facets.facet(face).corners();
    let [a, b, d] = [0, 1, numbers.len() - 1].map(|k| facets.positions()[numbers[k] as usize]);
    (b - a).cross(d - a).normalize_or_zero()
}

#[cfg(test)]
mod tests;
