//! Scan line: one row of pixels at a time, decided by whole intervals (Wylie, Romney, Evans and Erdahl, "Half-tone perspective
//! drawings by computer", AFIPS 1967; Watkins, 1970).
//!
//! The faces of a row are kept in a list that faces join and leave with their first and last rows. Each has a run of columns that
//! it covers; the ends of runs cut the row into intervals over which the same faces lie. Over an interval nearness is
//! affine, so a face that is nearer than the others at both ends is nearest all along; where faces cross, the interval is
//! halved. Pixels at the ends of runs that floats cannot tell apart, and the pixels of curved bodies, are decided one by one.
//!
//! Cost: O(rows · active faces + intervals · faces over them); memory a row and the list.

use std::ops::Range;

use super::{HiddenSurface, NOTHING, Shot, Statistics, Window};

/// Scan line with intervals.
#[derive(Clone, Copy, Debug)]
pub struct ScanLine {
    /// Rows that one thread draws in one go; at least 1.
    pub rows: u32,
}

impl Default for ScanLine {
    fn default() -> Self {
        Self { rows: 32 }
    }
}

impl HiddenSurface for ScanLine {
    fn name(&self) -> &'static str {
        "scanline"
    }

    fn window(&self) -> [u32; 2] {
        [u32::MAX, self.rows]
    }

    fn draw(&self, shot: &Shot, window: &Window, faces: &[u32], pixels: &mut [u32]) -> Statistics {
        let mut waiting = faces.to_vec();
        // The last one joins first.
        waiting.sort_by_key(|&face| std::cmp::Reverse((shot.footprints[face as usize].window.top, face)));
        let mut active: Vec<u32> = Vec::new();
        let mut line = Line { shot, columns: window.left..window.right, row: 0, work: Statistics::default() };
        for (row, pixels) in (window.top..window.bottom).zip(pixels.chunks_mut(window.width() as usize)) {
            active.retain(|&face| row < shot.footprints[face as usize].window.bottom);
            while let Some(face) = waiting.pop_if(|face| shot.footprints[*face as usize].window.top <= row) {
                active.push(face);
            }
            line.row = row;
            line.draw(&active, pixels);
        }
        line.work
    }
}

/// A row of pixels.
struct Line<'a> {
    shot: &'a Shot,
    columns: Range<u32>,
    row: u32,
    work: Statistics,
}

/// Where the faces over a row change.
#[derive(Clone, Copy, Debug)]
struct Event {
    column: u32,
    face: u32,
    change: Change,
}

#[derive(Clone, Copy, Debug)]
enum Change {
    Covers,
    NoLonger,
    MayCover,
    MayNoLonger,
}

impl Line<'_> {
    fn draw(&mut self, active: &[u32], pixels: &mut [u32]) {
        let mut events = Vec::with_capacity(2 * active.len());
        active.iter().for_each(|&face| self.add_events(face, &mut events));
        events.sort_unstable_by_key(|event| event.column);
        let (mut covering, mut doubtful) = (Vec::new(), Vec::new());
        for (k, event) in events.iter().enumerate() {
            match event.change {
                Change::Covers => covering.push(event.face),
                Change::NoLonger => remove(&mut covering, event.face),
                Change::MayCover => doubtful.push(event.face),
                Change::MayNoLonger => remove(&mut doubtful, event.face),
            }
            let end = events.get(k + 1).map_or(event.column, |next| next.column);
            let interval = event.column..end;
            if interval.is_empty() {
                continue;
            }
            let start = self.columns.start;
            let part = &mut pixels[(interval.start - start) as usize..(interval.end - start) as usize];
            self.decide(interval.clone(), &covering, part);
            for (column, held) in interval.zip(part) {
                doubtful.iter().for_each(|&face| self.shot.contest(face, [column, self.row], held, &mut self.work));
            }
        }
    }

    fn add_events(&mut self, face: u32, events: &mut Vec<Event>) {
        self.work.tests += 1;
        let span = self.shot.footprints[face as usize].span(&self.shot.frame, self.row, self.columns.clone());
        let mut add = |columns: Range<u32>, [begin, end]: [Change; 2]| {
            if !columns.is_empty() {
                events.push(Event { column: columns.start, face, change: begin });
                events.push(Event { column: columns.end, face, change: end });
            }
        };
        let doubt = [Change::MayCover, Change::MayNoLonger];
        if span.inner.is_empty() {
            return add(span.outer, doubt);
        }
        add(span.outer.start..span.inner.start, doubt);
        add(span.inner.clone(), [Change::Covers, Change::NoLonger]);
        add(span.inner.end..span.outer.end, doubt);
    }

    /// Fills an interval all of whose pixels are covered by the same faces.
    fn decide(&mut self, columns: Range<u32>, faces: &[u32], pixels: &mut [u32]) {
        let Some(&first) = faces.first() else { return };
        let window = Window { left: columns.start, top: self.row, right: columns.end, bottom: self.row + 1 };
        let range = |face: u32| self.shot.footprints[face as usize].nearness(&self.shot.frame, &window);
        let mut best = (first, range(first));
        for &face in &faces[1..] {
            let nearness = range(face);
            if nearness[0] > best.1[0] {
                best = (face, nearness);
            }
        }
        // Those that may be nearer than the best somewhere; only they go on.
        let rivals: Vec<u32> = faces.iter().copied().filter(|&face| range(face)[1] >= best.1[0]).collect();
        self.work.depths += faces.len() as u64 - 1;
        self.work.skipped += (faces.len() - rivals.len()) as u64;
        if rivals.len() == 1 {
            self.work.written += pixels.len() as u64;
            pixels.fill(best.0);
        } else if let [held] = pixels {
            *held = NOTHING;
            rivals.iter().for_each(|&face| self.shot.contest(face, [columns.start, self.row], held, &mut self.work));
        } else {
            self.work.divided += 1;
            let middle = columns.start + columns.len() as u32 / 2;
            let (low, high) = pixels.split_at_mut((middle - columns.start) as usize);
            self.decide(columns.start..middle, &rivals, low);
            self.decide(middle..columns.end, &rivals, high);
        }
    }
}

fn remove(faces: &mut Vec<u32>, face: u32) {
    if let Some(place) = faces.iter().position(|&other| other == face) {
        faces.swap_remove(place);
    }
}
