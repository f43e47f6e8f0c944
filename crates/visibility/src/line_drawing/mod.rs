//! Line drawings: the edges of bodies with hidden parts left out or dashed, decided in object space (Roberts, "Machine perception of
//! three-dimensional solids", MIT Lincoln Laboratory, 1963).
//!
//! **What hides.** Behind a convex face, seen from the eye, lies a convex volume: planes through the eye and the face's edges, and the face's own
//! plane. These planes are the face's *volume matrix*. A point of an edge is hidden by the face if all planes have it inside. Each plane's
//! value is affine along the edge, so each cuts the edge once, and the face hides one interval of it. Roberts takes the planes of whole
//! convex bodies; here every face is a convex piece, so concave meshes need no decomposition and bodies may run through each other.
//!
//! **What is drawn.** Borders, outlines (one face turned to the eye, one away), creases, and the segments along which faces cross.
//! Shadows are hatched: strokes on the faces that are seen, where a face hides them from a light (the light is an eye, too), with the outlines of shadow polygons
//! ([`crate::two_pass`]) round them. Of curved bodies a polyhedron is drawn that is off by a quarter of a pixel (`curved`): its outline, its rims, and what it
//! hides and shadows. General quadrics are left out; [`Drawing::left_out`] counts them. In a scene with cells only what the eye or a light reaches is looked at, and a light hatches
//! only objects that it may reach: those of other rooms would be hatched all over.
//!
//! **What is exact.** On which side of each plane the ends of an edge lie: signs of input corners, so an edge is not hidden by the faces that
//! it borders, nor by what it touches. Where an edge is cut is rounded, and so are the ends of crossings and hatches, which are drawn
//! and decide nothing but themselves.
//!
//! Cost: O(edges · faces near the way to the eye), the latter by a tree of boxes; hatches as edges, once more for each light.

mod borders;
mod crossings;
mod curved;
mod edges;
mod hatching;
mod hidden;
mod projection;

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{Facets, LightSource};
use umbriel_scene::{Object, Scene, first_alike};

use crate::{
    View,
    hidden_surface::ShotDefect,
    portals::{reach_of_eye, reach_of_light},
    two_pass::TwoPassDefect,
};
use curved::Flattened;
use edges::Creases;
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
    /// Where a cast shadow ends on a face that is seen.
    ShadowOutline,
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
    /// General quadrics, which are left out.
    pub left_out: usize,
    /// Why shadows have no outlines, if they should and have not.
    pub no_outlines: Option<TwoPassDefect>,
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
    let (flat, drawn) = flat_scene(scene, view, options, &projector);
    // A hull that has become flat by rounding was refused with the scene.
    let facets: Vec<Facets> = flat.scene.objects.par_iter().filter_map(Object::facets).collect();
    let bodies: Vec<(u32, &Facets)> = (0..).zip(&facets).collect();
    let hiders = Hiders::new(&bodies, projector.eye(), drawn);
    let limit = options.crease_degrees.to_radians().cos();
    let edges = |&body: &usize| {
        let creases = flat.pieces[body].as_deref().map_or(Creases::Bends(limit), Creases::Pieces);
        edges::edges(bodies[body].1, projector.eye(), &creases)
    };
    let mut lines: Vec<Line> = hiders.drawn.iter().flat_map(edges).collect();
    lines.extend(crossings::crossings(&hiders));
    let parts: Vec<Vec<Stroke>> = lines.par_iter().map(|line| strokes(line, &hiders, &projector, options)).collect();
    let mut drawing = Drawing {
        size: [view.width, view.height],
        strokes: parts.concat(),
        left_out: flat.left_out,
        no_outlines: None,
    };
    for (number, light) in options.lights.iter().enumerate() {
        let hatched = flat.reached(scene, light, &hiders.drawn);
        if hatched.is_empty() {
            continue;
        }
        let hatch = hatching::Hatch::of_light(number, options.hatch_spacing);
        drawing.strokes.extend(hatching::draw((&hiders, &hatched), &projector, light, &hatch));
        match borders::draw(&flat.scene, (&hiders, &hatched), &projector, light) {
            Ok(strokes) => drawing.strokes.extend(strokes),
            Err(defect) => drawing.no_outlines = Some(defect),
        }
    }
    drawing.strokes.retain(Stroke::is_seen);
    drawing.strokes.sort_by_key(|stroke| stroke.ink);
    Ok(drawing)
}

/// The objects that a drawing is made from, all with flat faces.
struct FlatScene {
    scene: Scene,
    /// Their indices in the scene, ascending.
    sources: Vec<usize>,
    /// Of curved ones the piece of each face.
    pieces: Vec<Option<Vec<u32>>>,
    left_out: usize,
}

impl FlatScene {
    /// Those of some places whose objects a light may reach; all in a scene without cells.
    fn reached(&self, scene: &Scene, light: &LightSource, places: &[usize]) -> Vec<usize> {
        if scene.cells.is_empty() {
            return places.to_vec();
        }
        let reached: Vec<usize> = reach_of_light(scene, light).indices().collect();
        places.iter().copied().filter(|&place| reached.binary_search(&self.sources[place]).is_ok()).collect()
    }
}

/// What the eye or a light reaches, and the places of what the eye may see. Hidden lines are wanted of everything.
fn flat_scene(scene: &Scene, view: &View, options: &LineOptions, projector: &Projector) -> (FlatScene, Vec<usize>) {
    let all = || (0..scene.objects.len()).collect::<Vec<usize>>();
    let reach = if scene.cells.is_empty() || options.keeps_hidden { None } else { reach_of_eye(scene, view) };
    let is_partial = reach.is_some();
    let seen = reach.map_or_else(all, |reach| reach.indices().collect());
    let mut wanted = seen.clone();
    if is_partial {
        wanted
            .extend(options.lights.iter().flat_map(|light| reach_of_light(scene, light).indices().collect::<Vec<_>>()));
        wanted.sort_unstable();
        wanted.dedup();
    }
    // What is given again is drawn once.
    let firsts = first_alike(&scene.objects);
    wanted.retain(|&object| firsts[object] == object);
    let made = |&source: &usize| Some((source, curved::flattened(&scene.objects[source], projector)?));
    let made: Vec<Option<(usize, Flattened)>> = wanted.par_iter().map(made).collect();
    let left_out = made.iter().filter(|object| object.is_none()).count();
    let mut flat = FlatScene { scene: Scene::default(), sources: Vec::new(), pieces: Vec::new(), left_out };
    let mut drawn = Vec::new();
    for (place, (source, Flattened { object, pieces })) in made.into_iter().flatten().enumerate() {
        flat.scene.objects.push(object);
        flat.sources.push(source);
        flat.pieces.push(pieces);
        if seen.binary_search(&source).is_ok() {
            drawn.push(place);
        }
    }
    (flat, drawn)
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
