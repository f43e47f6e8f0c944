//! Warnock: windows quartered until one face decides them (Warnock, "A hidden surface algorithm for computer generated halftone
//! pictures", University of Utah, 1969).
//!
//! To a window a face is disjoint, surrounding, or neither (contained or intersecting). A window is decided when it holds nothing, one
//! face alone, or a surrounding face that is nearer than all others; else it is quartered, with the faces that are left. A
//! surrounding face that is not nearest still removes all that it hides. A single pixel is decided by the judge.
//!
//! Guarantee: relations and nearness have bounds, so a window is decided only where it is clear. Cost: O(length of all visible borders in
//! pixels) windows, each with the faces over it.

use super::{HiddenSurface, Shot, Statistics, Window, footprint::Cover};

/// Area subdivision.
#[derive(Clone, Copy, Debug)]
pub struct Warnock {
    /// Edge of the windows that one thread begins with, pixels; at least 1.
    pub root: u32,
}

impl Default for Warnock {
    fn default() -> Self {
        Self { root: 256 }
    }
}

impl HiddenSurface for Warnock {
    fn name(&self) -> &'static str {
        "warnock"
    }

    fn window(&self) -> [u32; 2] {
        [self.root; 2]
    }

    fn draw(&self, shot: &Shot, window: &Window, faces: &[u32], pixels: &mut [u32]) -> Statistics {
        let mut area = Area { shot, root: window, pixels, work: Statistics::default() };
        area.decide(window, faces);
        area.work
    }
}

/// The window that all others are parts of.
struct Area<'a> {
    shot: &'a Shot,
    root: &'a Window,
    pixels: &'a mut [u32],
    work: Statistics,
}

/// A face that is not disjoint from a window.
struct Candidate {
    face: u32,
    surrounds: bool,
    /// Bounds on its nearness in the window.
    nearness: [f64; 2],
}

impl Area<'_> {
    fn decide(&mut self, window: &Window, faces: &[u32]) {
        let mut candidates = self.candidates(window, faces);
        let nearest = candidates.iter().filter(|candidate| candidate.surrounds);
        let wall = nearest.map(|candidate| candidate.nearness[0]).fold(f64::NEG_INFINITY, f64::max);
        let before = candidates.len();
        // What surrounds with its least nearness at the wall is kept: it is the wall.
        candidates.retain(|candidate| candidate.nearness[1] >= wall);
        self.work.skipped += (before - candidates.len()) as u64;
        match &candidates[..] {
            [] => {}
            [only] if only.surrounds => self.fill(window, only.face),
            [only] => self.draw(window, only.face),
            _ if window.area() == 1 => {
                let pixel = [window.left, window.top];
                let held = &mut self.pixels[self.root.index(pixel)];
                candidates.iter().for_each(|candidate| self.shot.contest(candidate.face, pixel, held, &mut self.work));
            }
            _ => {
                self.work.divided += 1;
                let rest: Vec<u32> = candidates.iter().map(|candidate| candidate.face).collect();
                window.quarters().for_each(|quarter| self.decide(&quarter, &rest));
            }
        }
    }

    fn candidates(&mut self, window: &Window, faces: &[u32]) -> Vec<Candidate> {
        self.work.tests += faces.len() as u64;
        let candidate = |&face: &u32| {
            let footprint = &self.shot.footprints[face as usize];
            let relation = footprint.relation(&self.shot.frame, window);
            (relation != Cover::None).then(|| Candidate {
                face,
                surrounds: relation == Cover::All,
                nearness: footprint.nearness(&self.shot.frame, window),
            })
        };
        faces.iter().filter_map(candidate).collect()
    }

    /// A window that one face surrounds.
    fn fill(&mut self, window: &Window, face: u32) {
        for row in window.top..window.bottom {
            let start = self.root.index([window.left, row]);
            self.pixels[start..start + window.width() as usize].fill(face);
        }
        self.work.written += window.area() as u64;
    }

    /// A window that holds one face and nothing else.
    fn draw(&mut self, window: &Window, face: u32) {
        for row in window.top..window.bottom {
            let span = self.shot.footprints[face as usize].span(&self.shot.frame, row, window.left..window.right);
            let start = self.root.index([window.left, row]);
            let place = |column: u32| start + (column - window.left) as usize;
            if !span.inner.is_empty() {
                self.pixels[place(span.inner.start)..place(span.inner.end)].fill(face);
                self.work.written += span.inner.len() as u64;
            }
            for column in (span.outer.start..span.inner.start).chain(span.inner.end..span.outer.end) {
                let held = &mut self.pixels[place(column)];
                self.shot.contest(face, [column, row], held, &mut self.work);
            }
        }
    }
}
