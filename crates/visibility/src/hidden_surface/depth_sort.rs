//! Depth sort: faces painted from back to front, split where no order exists (Newell, Newell and Sancha, "A solution to the hidden
//! surface problem", ACM annual conference 1972).
//!
//! The farthest face of a list may be painted first if it hides none of the others: for each one that is not wholly nearer, their
//! pixels are apart, or it lies behind the other's plane, or the other lies before its plane. If it fails against a face, that
//! one is tried instead, once; then the face is split along the other's plane. Faces that neither the order nor a plane parts (cycles
//! without crossings) quarter the window, down to pixels, which the judge decides.
//!
//! **What is exact.** Sides of planes are signs of input corners (`Shot::place`). A part is its face with the sides that it was split to,
//! so splitting makes no new corners, and no rounded one decides: it covers the pixels of its face where the difference of two faces'
//! nearness, affine in the pixel, has the right sign. A part is judged as its whole face. Pixels on borders of faces and parts, where
//! floats leave a doubt, are compared with what is there, now and when something is painted over them: there faces may be at
//! the same depth although one is before the other's plane. Faces of one plane are painted in falling order of their numbers.
//!
//! Cost: O(k²) pairs for k faces over a window, so windows are small. Curved bodies are compared pixel by pixel at the end.

use super::{
    HiddenSurface, NOTHING, Shot, Statistics, Window,
    footprint::{Affine, Cover},
    judge::Place,
};

/// Painting in order of depth.
#[derive(Clone, Copy, Debug)]
pub struct DepthSort {
    /// Edge of a window, pixels; at least 1.
    pub window: u32,
}

impl Default for DepthSort {
    fn default() -> Self {
        Self { window: 16 }
    }
}

impl HiddenSurface for DepthSort {
    fn name(&self) -> &'static str {
        "sort"
    }

    fn window(&self) -> [u32; 2] {
        [self.window; 2]
    }

    fn draw(&self, shot: &Shot, window: &Window, faces: &[u32], pixels: &mut [u32]) -> Statistics {
        let is_curved = |face: &u32| shot.footprints[*face as usize].plane.is_none();
        let (curved, flat): (Vec<u32>, Vec<u32>) = faces.iter().partition(|face| is_curved(face));
        let is_border = vec![false; pixels.len()];
        let mut canvas = Canvas { shot, root: window, pixels, is_border, work: Statistics::default() };
        canvas.paint_all(window, &flat);
        for &face in &curved {
            let part = shot.footprints[face as usize].window.meet(window);
            for row in part.top..part.bottom {
                (part.left..part.right).for_each(|column| canvas.contest(face, [column, row]));
            }
        }
        canvas.work
    }
}

/// A face, or a part of it, that waits to be painted.
#[derive(Clone, Debug)]
struct Part {
    face: u32,
    /// Faces along whose planes it was split, and whether it lies before them, on the eye's side.
    cuts: Vec<(u32, bool)>,
    /// Bounds on nearness in the window.
    nearness: [f64; 2],
    was_preferred: bool,
}

/// What becomes of the farthest part.
enum Step {
    Paint,
    Prefer(usize),
    Split { part: usize, along: u32 },
    Quarter,
}

/// The window that is painted.
struct Canvas<'a> {
    shot: &'a Shot,
    root: &'a Window,
    pixels: &'a mut [u32],
    /// Where the face in the pixel may be at its border.
    is_border: Vec<bool>,
    work: Statistics,
}

impl Canvas<'_> {
    fn paint_all(&mut self, window: &Window, faces: &[u32]) {
        if window.area() == 1 {
            return faces.iter().for_each(|&face| self.contest(face, [window.left, window.top]));
        }
        let mut parts: Vec<Part> = faces.iter().filter_map(|&face| self.part(window, face)).collect();
        self.work.tests += faces.len() as u64;
        parts.sort_by(farthest_last);
        self.drop_hidden(window, &mut parts);
        // Each split adds a part; where there are too many, smaller windows have fewer.
        let most = 2 * parts.len() + 8;
        while let Some(last) = parts.last() {
            if parts.len() > most || last.cuts.len() > MOST_CUTS {
                return self.quarter(window, &parts);
            }
            match self.step(window, &parts) {
                Step::Paint => {
                    if let Some(part) = parts.pop() {
                        self.paint(window, &part);
                    }
                }
                Step::Prefer(place) => {
                    let mut part = parts.remove(place);
                    part.was_preferred = true;
                    parts.push(part);
                }
                Step::Split { part, along } => self.split(&mut parts, part, along),
                Step::Quarter => return self.quarter(window, &parts),
            }
        }
    }

    /// A face as a whole, unless it is not in the window.
    fn part(&self, window: &Window, face: u32) -> Option<Part> {
        let (footprint, frame) = (&self.shot.footprints[face as usize], &self.shot.frame);
        (footprint.relation(frame, window) != Cover::None).then(|| Part {
            face,
            cuts: Vec::new(),
            nearness: footprint.nearness(frame, window),
            was_preferred: false,
        })
    }

    /// Leaves out what lies behind a face that covers all of the window.
    fn drop_hidden(&mut self, window: &Window, parts: &mut Vec<Part>) {
        let covers =
            |part: &&Part| self.shot.footprints[part.face as usize].relation(&self.shot.frame, window) == Cover::All;
        let wall = parts.iter().filter(covers).map(|part| part.nearness[0]).fold(f64::NEG_INFINITY, f64::max);
        let before = parts.len();
        parts.retain(|part| part.nearness[1] >= wall);
        self.work.skipped += (before - parts.len()) as u64;
    }

    /// Draws what is left by quarters, over what is painted already.
    fn quarter(&mut self, window: &Window, parts: &[Part]) {
        self.work.divided += 1;
        let mut faces: Vec<u32> = parts.iter().map(|part| part.face).collect();
        // Those that are painted stay in the game: an order that was found with the others need not hold with parts of them.
        let held =
            (window.top..window.bottom).flat_map(|row| (window.left..window.right).map(move |column| [column, row]));
        faces.extend(held.map(|pixel| self.pixels[self.root.index(pixel)]).filter(|&face| face != NOTHING));
        faces.sort_unstable();
        faces.dedup();
        window.quarters().for_each(|quarter| self.paint_all(&quarter, &faces));
    }

    /// What to do next; the farthest part is the last.
    fn step(&mut self, window: &Window, parts: &[Part]) -> Step {
        let Some((farthest, others)) = parts.split_last() else { return Step::Paint };
        for (place, other) in others.iter().enumerate().rev() {
            self.work.depths += 1;
            // Wholly nearer: painted later, whatever lies between.
            if other.nearness[0] > farthest.nearness[1] || self.may_precede(window, farthest, other) {
                continue;
            }
            if !other.was_preferred && self.may_precede(window, other, farthest) {
                return Step::Prefer(place);
            }
            let lies = |a: &Part, b: &Part| self.shot.place(a.face, b.face);
            return match (lies(farthest, other), lies(other, farthest)) {
                (Place::Across, _) => Step::Split { part: parts.len() - 1, along: other.face },
                (_, Place::Across) => Step::Split { part: place, along: farthest.face },
                _ => Step::Quarter,
            };
        }
        Step::Paint
    }

    /// Whether a part may be painted before another one: it hides nothing of it.
    fn may_precede(&self, window: &Window, part: &Part, other: &Part) -> bool {
        let (a, b) = (part.face, other.face);
        if self.are_apart(window, part, other) || is_parted(part, other) {
            return true;
        }
        match self.shot.place(a, b) {
            Place::Behind => true,
            Place::Within => a >= b,
            _ => self.shot.place(b, a) == Place::Before,
        }
    }

    /// Whether no pixel of the window may show both.
    fn are_apart(&self, window: &Window, part: &Part, other: &Part) -> bool {
        let [a, b] = [part.face, other.face].map(|face| &self.shot.footprints[face as usize]);
        let common = a.window.meet(&b.window).meet(window);
        if common.is_empty() {
            return true;
        }
        let frame = &self.shot.frame;
        a.relation(frame, &common) == Cover::None || b.relation(frame, &common) == Cover::None
    }

    fn split(&mut self, parts: &mut Vec<Part>, place: usize, along: u32) {
        self.work.divided += 1;
        let part = parts.remove(place);
        for before in [true, false] {
            let cuts = part.cuts.iter().copied().chain([(along, before)]).collect();
            parts.push(Part { cuts, was_preferred: false, ..part });
        }
        parts.sort_by(farthest_last);
    }

    /// Paints a part over what is there.
    fn paint(&mut self, window: &Window, part: &Part) {
        let footprint = &self.shot.footprints[part.face as usize];
        let frame = &self.shot.frame;
        let cuts: Vec<Affine> = part.cuts.iter().filter_map(|&cut| self.cut_function(part.face, cut)).collect();
        let rows = footprint.window.meet(window);
        for row in rows.top..rows.bottom {
            let span = footprint.span(frame, row, rows.left..rows.right);
            for column in span.outer.clone() {
                let (x, y) = (frame.x(column), frame.y(row));
                let values = || cuts.iter().map(|cut| (cut.at(x, y), cut.error));
                if values().any(|(value, error)| value < -error) {
                    continue;
                }
                let is_clear = span.inner.contains(&column) && values().all(|(value, error)| value > error);
                self.paint_pixel(part.face, [column, row], is_clear);
            }
        }
    }

    /// Positive where the first face, on its plane, lies on the given side of the other's plane: before it is nearer.
    fn cut_function(&self, face: u32, (along, before): (u32, bool)) -> Option<Affine> {
        let nearness = |face: u32| self.shot.footprints[face as usize].plane.as_ref().map(|plane| plane.nearness);
        Some(nearness(face)?.minus(&nearness(along)?, if before { 1.0 } else { -1.0 }))
    }

    fn paint_pixel(&mut self, face: u32, pixel: [u32; 2], is_clear: bool) {
        let index = self.root.index(pixel);
        if !is_clear || self.is_border[index] {
            return self.contest(face, pixel);
        }
        self.pixels[index] = face;
        self.work.written += 1;
    }

    fn contest(&mut self, face: u32, pixel: [u32; 2]) {
        let index = self.root.index(pixel);
        self.shot.contest(face, pixel, &mut self.pixels[index], &mut self.work);
        self.is_border[index] = true;
    }
}

/// More cuts of one face than this are a tangle that smaller windows untie.
const MOST_CUTS: usize = 8;

/// Whether a cut lies between two parts: the first is behind a plane that the other one's is before, or is that plane's.
fn is_parted(part: &Part, other: &Part) -> bool {
    let behind_other = part.cuts.contains(&(other.face, false)) || other.cuts.contains(&(part.face, true));
    let between = part.cuts.iter().any(|&(along, before)| !before && other.cuts.contains(&(along, true)));
    behind_other || between
}

/// The part whose farthest point is farthest comes last; of equals, the one of the higher face.
fn farthest_last(a: &Part, b: &Part) -> std::cmp::Ordering {
    b.nearness[0].total_cmp(&a.nearness[0]).then(a.face.cmp(&b.face)).then(b.cuts.cmp(&a.cuts))
}
