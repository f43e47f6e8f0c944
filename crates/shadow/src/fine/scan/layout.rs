//! Where the samples of an object are, and which bits hold which answers. Does not depend on the light.

use std::sync::atomic::AtomicU8;

use rayon::prelude::*;
use umbriel_geometry::{
    Base, Facet, Facets, Measures,
    simd::{Kernel, Simd, dispatch},
};

use super::lit_bits::{LitBits, count};
use crate::{
    fine::lattice::{Lattice, Spacing},
    report::SampleAnswers,
    sums::{AreaSums, ExactSum},
};

/// Faces that one thread takes at a time, and whose answers are counted from a common byte.
const FACES: usize = 1 << 12;

/// A face's lattice, the corner from which it is counted, and where its answers are.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceLattice {
    pub(super) lattice: Lattice,
    pub(super) corner: u8,
    /// The byte that holds the first answers. Rows have whole bytes.
    pub(super) first_byte: u64,
}

impl FaceLattice {
    /// Bytes that the answers of a row take.
    #[inline(always)]
    pub(super) fn row_bytes(&self) -> u64 {
        u64::from(self.lattice.counts()[1].div_ceil(8))
    }
}

/// As [`FaceLattice`], in 16 bytes: corner and kind are the lowest three bits of the place, counted within a part.
#[derive(Clone, Copy, Debug, Default)]
struct Packed {
    counts: [u32; 2],
    place: u64,
}

/// The samples of one object's flat faces.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    faces: Vec<Packed>,
    /// The first byte of each part of [`FACES`] faces, and the end of the last.
    parts: Vec<u64>,
    /// How many samples there are.
    pub(crate) samples: u64,
    /// The faces' areas.
    pub(crate) areas: AreaSums,
    /// Each face's own, in squares as wide as samples are apart: about as many as it has samples, unless it is small.
    squares: Vec<f32>,
    /// The area of such a square, m².
    square: f64,
}

/// What of an object's samples is lit.
#[derive(Clone, Debug, Default)]
pub(crate) struct LitSamples {
    /// How many.
    pub(crate) count: u64,
    /// The area that they stand for, m²: each sample of a face for as much of it as any other. To single precision, the same whatever the order of faces.
    pub(crate) area: f64,
}

impl Layout {
    /// Of faces with area; others have no samples.
    pub(crate) fn new(facets: &Facets, spacing: Spacing) -> Self {
        let (mut faces, mut squares) = (vec![Packed::default(); facets.len()], vec![0.0; facets.len()]);
        let parts = faces.par_chunks_mut(FACES).zip(squares.par_chunks_mut(FACES)).enumerate().map(
            |(number, (faces, squares))| dispatch(Part { facets, spacing, first: number * FACES, faces, squares }),
        );
        let totals: Vec<Totals> = parts.collect();
        let (parts, samples, areas, square) = (vec![0], 0, AreaSums::default(), spacing.square());
        let mut layout = Self { faces, parts, samples, areas, squares, square };
        let mut end = 0;
        for totals in totals {
            end += totals.bytes;
            layout.parts.push(end);
            layout.samples += totals.samples;
            layout.areas.append(totals.areas);
        }
        layout
    }

    /// The answers alone, without the bits that no sample uses.
    pub(crate) fn answers(&self, lit: &LitBits) -> SampleAnswers {
        let mut answers = SampleAnswers::default();
        for face in 0..self.faces.len() {
            let face = self.face(face);
            for row in 0..face.lattice.counts()[0] {
                let start = face.first_byte + u64::from(row) * face.row_bytes();
                for (byte, len) in bytes_of(face.lattice.row_len(row)) {
                    answers.push(u64::from(lit.byte(start + byte)), len);
                }
            }
        }
        answers
    }

    /// What is lit.
    pub(crate) fn lit(&self, lit: &mut LitBits) -> LitSamples {
        let parts = lit.parts(&self.parts).into_par_iter().zip(self.faces.par_chunks(FACES));
        let parts = parts.zip(self.squares.par_chunks(FACES));
        let parts = parts.map(|((bytes, faces), squares)| dispatch(LitPart { faces, squares, bytes }));
        let (mut count, mut squares) = (0, ExactSum::default());
        for (count_of_part, squares_of_part) in parts.collect::<Vec<_>>() {
            count += count_of_part;
            squares.append(squares_of_part);
        }
        LitSamples { count, area: squares.nearest() * self.square }
    }

    /// How many bytes answers take.
    pub(super) fn bytes(&self) -> u64 {
        self.parts.last().copied().unwrap_or_default()
    }

    /// Of one face.
    #[inline(always)]
    pub(super) fn face(&self, face: usize) -> FaceLattice {
        self.faces[face].counted_from(self.parts[face / FACES])
    }
}

impl Packed {
    /// In a part whose first byte is this.
    #[inline(always)]
    fn counted_from(self, first: u64) -> FaceLattice {
        let Self { counts, place } = self;
        FaceLattice {
            lattice: Lattice::of_counts(counts, place & 4 != 0),
            corner: (place & 3) as u8,
            first_byte: first + (place >> 3),
        }
    }
}

/// The bytes that hold a row of so many bits, and how many each holds.
fn bytes_of(bits: u32) -> impl Iterator<Item = (u64, u32)> {
    (0..bits.div_ceil(8)).map(move |byte| (u64::from(byte), (bits - 8 * byte).min(8)))
}

/// Some faces to be laid out.
struct Part<'a> {
    facets: &'a Facets,
    spacing: Spacing,
    first: usize,
    faces: &'a mut [Packed],
    squares: &'a mut [f32],
}

/// What a part takes.
struct Totals {
    bytes: u64,
    samples: u64,
    areas: AreaSums,
}

impl Kernel for Part<'_> {
    type Output = Totals;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Totals {
        let Self { facets, spacing, first, faces, squares } = self;
        let mut totals = Totals { bytes: 0, samples: 0, areas: AreaSums::default() };
        let (mut measures, a_square) = (Measures::default(), 1.0 / spacing.square());
        for (block, faces) in faces.chunks_mut(Measures::MOST).enumerate() {
            let start = first + block * Measures::MOST;
            measures.measure(facets, start..start + faces.len());
            totals.areas.add_wholes(measures.areas(), measures.errors());
            for (squares, area) in squares[block * Measures::MOST..].iter_mut().zip(measures.areas()) {
                *squares = (area * a_square) as f32;
            }
            for (lane, packed) in faces.iter_mut().enumerate() {
                if measures.area(lane).upper() <= 0.0 {
                    continue;
                }
                let Base { corner, sides } = measures.base(lane);
                let is_triangle = matches!(facets.facet(start + lane), Facet::Triangle(_));
                let lattice = Lattice::new(sides, spacing, is_triangle);
                let counts = lattice.counts();
                *packed = Packed { counts, place: totals.bytes << 3 | u64::from(is_triangle) << 2 | u64::from(corner) };
                totals.bytes += u64::from(counts[0]) * u64::from(counts[1].div_ceil(8));
                totals.samples += lattice.len();
            }
        }
        totals
    }
}

/// The answers of some faces, to be counted.
struct LitPart<'a> {
    faces: &'a [Packed],
    squares: &'a [f32],
    bytes: &'a mut [AtomicU8],
}

impl Kernel for LitPart<'_> {
    /// How many are lit, and the squares that they stand for.
    type Output = (u64, ExactSum);

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> (u64, ExactSum) {
        let Self { faces, squares, bytes } = self;
        let (mut all, mut sum) = (0, ExactSum::default());
        for (packed, &squares) in faces.iter().zip(squares) {
            let face = packed.counted_from(0);
            let bytes_of_face = u64::from(face.lattice.counts()[0]) * face.row_bytes();
            let count = count(&mut bytes[face.first_byte as usize..][..bytes_of_face as usize]);
            if count > 0 {
                all += count;
                sum.add(f64::from(squares) * (count as f64 / face.lattice.len() as f64));
            }
        }
        (all, sum)
    }
}
