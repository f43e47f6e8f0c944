//! Many points given by coordinates, exactly and fast.
//!
//! The problem: whether a light reaches each of millions of loose points, with the answers of [`Queries::lit`]. The way is that
//! of light space: every shadow ray is a point (u, v) of a plane there. The plane is cut into tiles, tiles into cells of about
//! the size of a triangle; a cell holds the triangles over it, nearest to the light first, eight to a [`group`]. A point looks into
//! its own cell alone and is compared with eight triangles at a time in f32, with a derived margin. The few points
//! that the margin cannot tell, and those whose slack box may meet a surface, are decided exactly.
//!
//! Guarantee: the answers are those of the definition. A point that some triangle certainly hides, all of its slack box at once and
//! without touching it, is in shadow whatever else may be at the point: a surface point in the box is hidden too, and a point in
//! space as well. If no triangle comes near the box or its shadow, the point is in space and lit. All other points are asked
//! one by one.
//!
//! Cost: about 150 ns a triangle and view, 15 to 30 ns a point; a doubtful point less than a microsecond, one in contact
//! with a surface some microseconds. Where u, v of many points cannot be told from each other (scenes that are far from the
//! origin, in f32) every point is doubtful.

mod filter;
mod grid;
mod group;
mod pieces;
mod tile;

#[cfg(test)]
mod tests;

use filter::{Doubtful, Filter, Grids};
use glam::DVec3;
use grid::Grid;
use pieces::Pieces;
use rayon::prelude::*;
use umbriel_geometry::{LightSource, blocking::Probe, predicates::exact_fallbacks, simd::dispatch};

use crate::{
    exact::{Own, face_blocks},
    light_space::View,
    query::{Place, Precision, Queries, QueryDefect},
};

/// Points by coordinates; world, metres. A normal may have any length but zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Points<'a> {
    /// Points in space, coordinates that were 32-bit floats.
    FreeSingle(&'a [[f32; 3]]),
    /// Points in space.
    FreeDouble(&'a [[f64; 3]]),
    /// Position and normal; each point stands for half an ulp of its 32-bit coordinates.
    OrientedSingle(&'a [[f32; 6]]),
    /// Position and normal; each point stands for half an ulp of its 64-bit coordinates.
    OrientedDouble(&'a [[f64; 6]]),
}

/// Points that one job takes.
const CHUNK: usize = 8192;

impl Points<'_> {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::FreeSingle(rows) => rows.len(),
            Self::FreeDouble(rows) => rows.len(),
            Self::OrientedSingle(rows) => rows.len(),
            Self::OrientedDouble(rows) => rows.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One point, as a single query takes it.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn place(&self, index: usize) -> Place {
        let wide = |row: [f32; 6]| row.map(f64::from);
        let oriented = |[x, y, z, nx, ny, nz]: [f64; 6], precision| Place::Oriented {
            position: [x, y, z],
            normal: [nx, ny, nz],
            precision,
        };
        match self {
            Self::FreeSingle(rows) => Place::Free { position: rows[index].map(f64::from) },
            Self::FreeDouble(rows) => Place::Free { position: rows[index] },
            Self::OrientedSingle(rows) => oriented(wide(rows[index]), Precision::Single),
            Self::OrientedDouble(rows) => oriented(rows[index], Precision::Double),
        }
    }

    fn part(&self, from: usize, to: usize) -> Self {
        match self {
            Self::FreeSingle(rows) => Self::FreeSingle(&rows[from..to]),
            Self::FreeDouble(rows) => Self::FreeDouble(&rows[from..to]),
            Self::OrientedSingle(rows) => Self::OrientedSingle(&rows[from..to]),
            Self::OrientedDouble(rows) => Self::OrientedDouble(&rows[from..to]),
        }
    }

    /// The greatest magnitude of a coordinate.
    fn size(&self) -> f64 {
        fn greatest<const N: usize>(rows: &[[f32; N]]) -> f64 {
            let size = rows.iter().fold(0.0f32, |m, row| m.max(row[0].abs()).max(row[1].abs()).max(row[2].abs()));
            f64::from(size)
        }
        fn greatest_double<const N: usize>(rows: &[[f64; N]]) -> f64 {
            rows.iter().fold(0.0f64, |m, row| m.max(row[0].abs()).max(row[1].abs()).max(row[2].abs()))
        }
        match self {
            Self::FreeSingle(rows) => greatest(rows),
            Self::FreeDouble(rows) => greatest_double(rows),
            Self::OrientedSingle(rows) => greatest(rows),
            Self::OrientedDouble(rows) => greatest_double(rows),
        }
    }
}

impl Queries<'_> {
    /// Whether each point is lit by `light`: the answers of [`Queries::lit`], point by point.
    ///
    /// # Errors
    /// The first point that is refused, by its index, and why.
    pub fn lit_many(&self, points: Points, light: &LightSource) -> Result<Vec<bool>, (usize, QueryDefect)> {
        let mut lit = vec![false; points.len()];
        let Some(pieces) = Pieces::of(&self.bodies) else { todo!() };
        let views = View::all(light, &pieces.bounds);
        let grids = Grids { grids: views.into_iter().map(|view| Grid::of(&pieces, view)).collect() };
        let jobs = lit.par_chunks_mut(CHUNK).enumerate();
        jobs.for_each(|(job, lit)| {
            let from = job * CHUNK;
            let part = points.part(from, from + lit.len());
            let doubtful = filter(&grids, part, lit);
            for doubt in doubtful {
                let place = part.place(doubt.index as usize);
                lit[doubt.index as usize] = self.decide(&pieces, &place, &doubt, light);
            }
        });
        Ok(lit)
    }

    fn decide(&self, pieces: &Pieces, place: &Place, doubt: &Doubtful, light: &LightSource) -> bool {
        self.lit(place, light).unwrap().lit
    }
}

fn filter(grids: &Grids, part: Points, lit: &mut [bool]) -> Vec<Doubtful> {
    let size = part.size();
    fn run<const N: usize>(grids: &Grids, rows: &[[f32; N]], slack: f64, size: f64, lit: &mut [bool]) -> Vec<Doubtful> {
        let points = rows.iter().map(|row| DVec3::new(f64::from(row[0]), f64::from(row[1]), f64::from(row[2])));
        dispatch(Filter { grids, points, slack, size, lit })
    }
    fn run_double<const N: usize>(grids: &Grids, rows: &[[f64; N]], slack: f64, size: f64, lit: &mut [bool]) -> Vec<Doubtful> {
        let points = rows.iter().map(|row| DVec3::new(row[0], row[1], row[2]));
        dispatch(Filter { grids, points, slack, size, lit })
    }
    let (single, double) = (size * 2f64.powi(-24) + 2f64.powi(-150), size * f64::EPSILON * 0.5);
    match part {
        Points::FreeSingle(rows) => run(grids, rows, 0.0, size, lit),
        Points::FreeDouble(rows) => run_double(grids, rows, 0.0, size, lit),
        Points::OrientedSingle(rows) => run(grids, rows, single, size, lit),
        Points::OrientedDouble(rows) => run_double(grids, rows, double, size, lit),
    }
}
