//! The images of all corners.

use rayon::prelude::*;
use umbriel_geometry::simd::{Kernel, Simd, dispatch};

use super::{
    faces::Source,
    view::{Image, View},
};

/// Points that a thread projects at a time.
const CHUNK: usize = 1 << 13;

/// The images of the points of all sources.
pub(super) struct Images {
    all: Vec<Image>,
    /// Where those of each source begin, and the end of the last.
    first: Vec<usize>,
}

impl Images {
    /// Projects the points. Cost: a few nanoseconds each.
    pub(super) fn new(sources: &[Source], view: &View) -> Self {
        let mut first = vec![0];
        for source in sources {
            first.push(first[first.len() - 1] + source.facets.positions().len());
        }
        let mut all = vec![Image::default(); first[sources.len()]];
        let mut parts = Vec::new();
        let mut rest = all.as_mut_slice();
        for source in sources {
            let (own, others) = rest.split_at_mut(source.facets.positions().len());
            rest = others;
            parts.extend(own.chunks_mut(CHUNK).enumerate().map(|(k, images)| Part {
                source,
                first: k * CHUNK,
                images,
            }));
        }
        parts.into_par_iter().with_min_len(16).for_each(|part| dispatch(Project { part, view }));
        Self { all, first }
    }

    /// Those of one source.
    #[inline(always)]
    pub(super) fn of(&self, source: u32) -> &[Image] {
        &self.all[self.first[source as usize]..self.first[source as usize + 1]]
    }
}

/// Images of consecutive points of a source.
struct Part<'a> {
    source: &'a Source<'a>,
    first: usize,
    images: &'a mut [Image],
}

struct Project<'a> {
    part: Part<'a>,
    view: &'a View,
}

impl Kernel for Project<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Part { source, first, images } = self.part;
        let is_exact = source.facets.point(0).exact.is_none();
        let positions = &source.facets.positions()[first..];
        for (k, (image, &position)) in images.iter_mut().zip(positions).enumerate() {
            let slack = if is_exact { 0.0 } else { source.facets.point((first + k) as u32).slack.max_element() };
            *image = self.view.image(position, slack);
        }
    }
}
