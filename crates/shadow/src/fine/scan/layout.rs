//! Where the samples of an object are, and which bit holds which answer. Does not depend on the light.

use rayon::prelude::*;
use umbriel_geometry::{Facet, Facets};

use super::lit_bits::LitBits;
use crate::{
    fine::lattice::{Lattice, Spacing},
    levels::FaceSize,
    receivers::{edges_of_triangle, flat_corners},
    report::SampleAnswers,
    sums::AreaSums,
};

/// Faces that one thread takes at a time.
const FACES: usize = 1 << 12;

/// A face's lattice and the corner from which it is counted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceLattice {
    pub(crate) lattice: Lattice,
    pub(crate) corner: u8,
}

impl FaceLattice {
    /// Bytes that the answers of a row take.
    #[inline(always)]
    pub(super) fn row_bytes(&self) -> u64 {
        u64::from(self.lattice.counts()[1].div_ceil(8))
    }
}

/// The bytes that hold a row of so many bits, and how many each holds.
fn bytes_of(bits: u32) -> impl Iterator<Item = (u64, u32)> {
    (0..bits.div_ceil(8)).map(move |byte| (u64::from(byte), (bits - 8 * byte).min(8)))
}

/// The samples of one object's flat faces.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    faces: Vec<FaceLattice>,
    /// The first byte of each face's answers, and the end of the last. A row has whole bytes.
    first: Vec<u64>,
    /// How many samples there are.
    pub(crate) samples: u64,
    /// The faces' areas.
    pub(crate) areas: AreaSums,
}

impl Layout {
    /// Of faces with area; others have no samples.
    pub(crate) fn new(facets: &Facets, spacing: Spacing) -> Self {
        let lattice = |face: usize| {
            let (corner, edges, is_triangle) = match facets.facet(face) {
                Facet::Triangle(corners) => {
                    let (corner, edges) = edges_of_triangle(corners.map(|corner| facets.positions()[corner as usize]));
                    (corner, edges, true)
                }
                Facet::Parallelogram(_) => (0, FaceSize::of_flat(&flat_corners(facets, face, 0), false).edges, false),
            };
            let has_area = facets.area(face).upper() > 0.0;
            let lattice = if has_area { Lattice::new(edges, spacing, is_triangle) } else { Lattice::EMPTY };
            FaceLattice { lattice, corner }
        };
        let faces: Vec<FaceLattice> = (0..facets.len()).into_par_iter().with_min_len(FACES).map(lattice).collect();
        let samples = faces.par_iter().with_min_len(FACES).map(|face| face.lattice.len()).sum();
        let areas = (0..facets.len().div_ceil(FACES)).into_par_iter().map(|part| {
            let mut areas = AreaSums::default();
            for face in part * FACES..facets.len().min((part + 1) * FACES) {
                let area = facets.area(face);
                areas.add_undecided(area);
            }
            areas
        });
        let areas = areas.reduce(AreaSums::default, |mut sum, part| {
            sum.append(part);
            sum
        });
        let mut first = Vec::with_capacity(faces.len() + 1);
        let mut byte = 0;
        for face in &faces {
            first.push(byte);
            byte += u64::from(face.lattice.counts()[0]) * face.row_bytes();
        }
        first.push(byte);
        Self { faces, first, samples, areas }
    }

    /// The answers alone, without the bits that no sample uses.
    pub(crate) fn answers(&self, lit: &LitBits) -> SampleAnswers {
        let mut answers = SampleAnswers::default();
        for (face, &first) in self.faces.iter().zip(&self.first) {
            for row in 0..face.lattice.counts()[0] {
                let start = first + u64::from(row) * face.row_bytes();
                for (byte, len) in bytes_of(face.lattice.row_len(row)) {
                    answers.push(u64::from(lit.byte(start + byte)), len);
                }
            }
        }
        answers
    }

    /// How many bytes answers take.
    pub(crate) fn bytes(&self) -> u64 {
        self.first.last().copied().unwrap_or_default()
    }

    pub(crate) fn face(&self, face: usize) -> &FaceLattice {
        &self.faces[face]
    }

    pub(crate) fn first_byte(&self, face: usize) -> u64 {
        self.first[face]
    }
}
