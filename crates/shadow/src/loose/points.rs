//! Points as they are given, and what is asked of all of them at once: whether each is accepted, and how large they are.
//!
//! Cost: half a nanosecond a point in 32 bits, where none is refused; some more in 64.

use std::ops::Range;

use umbriel_geometry::{
    accept,
    simd::{Kernel, Simd, dispatch},
};

use crate::{
    loose::on_faces::FacePoint,
    query::{Place, Precision, Queries},
};

/// Points by coordinates, world, metres; or by faces. A normal may have any length but zero.
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
    /// Points of faces.
    OnFaces(&'a [FacePoint]),
}

impl Points<'_> {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::FreeSingle(rows) => rows.len(),
            Self::FreeDouble(rows) => rows.len(),
            Self::OrientedSingle(rows) => rows.len(),
            Self::OrientedDouble(rows) => rows.len(),
            Self::OnFaces(points) => points.len(),
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
            Self::OnFaces(points) => points[index].place(),
        }
    }

    /// Whether each stands for itself alone, not for others near it whose surface is looked for.
    pub(super) fn are_themselves(&self) -> bool {
        !matches!(self, Self::OrientedSingle(_) | Self::OrientedDouble(_))
    }

    pub(super) fn part(&self, from: usize, to: usize) -> Self {
        match self {
            Self::FreeSingle(rows) => Self::FreeSingle(&rows[from..to]),
            Self::FreeDouble(rows) => Self::FreeDouble(&rows[from..to]),
            Self::OrientedSingle(rows) => Self::OrientedSingle(&rows[from..to]),
            Self::OrientedDouble(rows) => Self::OrientedDouble(&rows[from..to]),
            Self::OnFaces(points) => Self::OnFaces(&points[from..to]),
        }
    }

    /// The first point that a single query would refuse is an error.
    pub(super) fn check(&self, queries: &Queries) -> Result<(), usize> {
        // Every 32-bit float that is finite is accepted.
        let single = |row: &[f32]| row.iter().all(|x| x.is_finite());
        let double = |row: &[f64]| row.iter().all(|&x| accept(x).is_ok());
        let refused = match self {
            Self::FreeSingle(rows) => rows.iter().position(|row| !single(row)),
            Self::FreeDouble(rows) => rows.iter().position(|row| !double(row)),
            Self::OrientedSingle(rows) => {
                rows.iter().position(|row| !single(row) || row[3..].iter().all(|&x| x == 0.0))
            }
            Self::OrientedDouble(rows) => rows.iter().position(|row| {
                let is_normal = row[3..].iter().all(|x| x.is_finite()) && row[3..].iter().any(|&x| x != 0.0);
                !double(&row[..3]) || !is_normal
            }),
            Self::OnFaces(points) => points.iter().position(|&point| queries.surface_defect(point).is_some()),
        };
        refused.map_or(Ok(()), Err)
    }

    /// What a coordinate of a slack box differs from the point's by at most, for points no greater than `size`.
    pub(super) fn slack(&self, size: f64) -> f64 {
        match self {
            Self::FreeSingle(_) | Self::FreeDouble(_) | Self::OnFaces(_) => 0.0,
            Self::OrientedSingle(_) => size * 2f64.powi(-24) + 2f64.powi(-150),
            Self::OrientedDouble(_) => size * f64::EPSILON * 0.5,
        }
    }

    /// The greatest magnitude of a coordinate that is given; of points that are refused any number.
    pub(super) fn size(&self) -> f64 {
        match self {
            Self::FreeSingle(rows) => look(rows).size,
            Self::FreeDouble(rows) => greatest(rows),
            Self::OrientedSingle(rows) => look(rows).size,
            Self::OrientedDouble(rows) => greatest(rows),
            Self::OnFaces(_) => 0.0,
        }
    }

    /// [`Self::size`] after [`Self::check`], in one look where that is enough. Points of faces are not checked.
    pub(super) fn checked_size(&self, queries: &Queries) -> Result<f64, usize> {
        let looked = match self {
            Self::FreeSingle(rows) => look(rows),
            Self::OrientedSingle(rows) => look(rows),
            Self::OnFaces(_) => Looked { size: 0.0, is_accepted: true },
            Self::FreeDouble(_) | Self::OrientedDouble(_) => Looked { size: 0.0, is_accepted: false },
        };
        if looked.is_accepted { Ok(looked.size) } else { self.check(queries).map(|()| self.size()) }
    }
}

/// The greatest magnitude of rows' first three numbers.
fn greatest<const N: usize>(rows: &[[f64; N]]) -> f64 {
    // Axis by axis, so that no comparison waits for the last one.
    let mut most = [0.0f64; 3];
    for row in rows {
        for (most, x) in most.iter_mut().zip(row) {
            *most = if x.abs() > *most { x.abs() } else { *most };
        }
    }
    most[0].max(most[1]).max(most[2])
}

/// What one look at rows tells.
struct Looked {
    /// The greatest magnitude of their first three numbers.
    size: f64,
    /// All numbers are finite, and no normal, the last three of six, is zero.
    is_accepted: bool,
}

fn look<const N: usize>(rows: &[[f32; N]]) -> Looked {
    dispatch(Look(rows))
}

/// Rows of three or six.
struct Look<'a, const N: usize>(&'a [[f32; N]]);

/// Rows that are looked at together: so many that their numbers fill whole vectors.
const TOGETHER: usize = 16;

/// Magnitudes are ordered as these bits are, infinity and NaN above all others.
#[inline(always)]
fn bits(x: f32) -> i32 {
    x.to_bits() as i32 & i32::MAX
}

impl<const N: usize> Kernel for Look<'_, N> {
    type Output = Looked;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Looked {
        let mut most = [[0; N]; TOGETHER];
        let mut is_zero = false;
        let (whole, rest) = self.0.as_chunks::<TOGETHER>();
        for rows in whole.iter().map(<[_; TOGETHER]>::as_slice).chain([rest]) {
            for (most, &x) in most.as_flattened_mut().iter_mut().zip(rows.as_flattened()) {
                *most = if bits(x) > *most { bits(x) } else { *most };
            }
            if N == 6 {
                for row in rows {
                    is_zero |= bits(row[3]) | bits(row[4]) | bits(row[5]) == 0;
                }
            }
        }
        let greatest =
            |columns: Range<usize>| most.iter().flat_map(|row| &row[columns.clone()]).fold(0, |a, &b| a.max(b));
        let infinity = bits(f32::INFINITY);
        let size = f32::from_bits(greatest(0..3).min(infinity) as u32);
        Looked { size: f64::from(size), is_accepted: greatest(0..N) < infinity && !is_zero }
    }
}
