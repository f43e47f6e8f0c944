//! How far apart samples are.

use std::ops::Range;

use rayon::prelude::*;
use umbriel_geometry::{
    Facets, Measures,
    simd::{Kernel, Simd, dispatch},
};

use crate::{
    bodies::{Bodies, Body},
    fine::lattice::Spacing,
    request::{Request, Sampling},
    sums::ExactSum,
};

/// Faces that one thread takes at a time.
const FACES: usize = 1 << 12;

/// How far apart samples are, if the request asks for any.
///
/// The lattice of a face is a parallelogram's, so a slanted face has more points than its area says. Where faces are so slanted that
/// there would be far more than were asked for, points are farther apart: never more than 17 for each that was asked for and each face.
pub(crate) fn spacing(bodies: &Bodies, request: &Request) -> Option<Spacing> {
    request.sampling.map(|sampling| match sampling {
        Sampling::Spacing(spacing) => Spacing::AtMost(spacing),
        Sampling::Count(count) => {
            let lattices = Lattices::of(bodies, request);
            let points = 8.0 * (count as f64 + lattices.faces);
            let even = (lattices.area.nearest() / count.max(1) as f64).sqrt();
            Spacing::About(
                even.max((lattices.products.nearest() / points).sqrt()).max(lattices.lengths.nearest() / points),
            )
        }
    })
}

/// What bounds the number of points of all lattices together; the same bits whatever the order of faces.
#[derive(Default)]
pub(crate) struct Lattices {
    /// Of the faces, m²; of a patch of a curved body, what its lattice covers.
    area: ExactSum,
    /// Products of the two edges that lattices lie along, m².
    products: ExactSum,
    /// Sums of these edges, metres.
    lengths: ExactSum,
    faces: f64,
}

impl Lattices {
    /// Of all receivers. One look at every face.
    pub(crate) fn of(bodies: &Bodies, request: &Request) -> Self {
        let objects = request.receivers.par_iter();
        objects
            .fold(Self::default, |lattices, &object| bodies.look_at(object, |body| lattices.with_body(body)))
            .reduce(Self::default, Self::joined)
    }

    fn with_body(self, body: &Body) -> Self {
        match body {
            Body::Flat(facets) => self.with_facets(facets),
            Body::Analytic(body) => {
                let charts = body.charts().iter().map(|chart| chart.steps(body.placement()));
                charts.fold(self, |mut lattices, [a, b]| {
                    lattices.add(&[a * b], &[a], &[b]);
                    lattices
                })
            }
        }
    }

    fn with_facets(self, facets: &Facets) -> Self {
        let part = |lattices: Self, first: usize| {
            dispatch(Measured { lattices, facets, faces: first..facets.len().min(first + FACES) })
        };
        if facets.len() <= FACES {
            return part(self, 0);
        }
        let parts = (0..facets.len().div_ceil(FACES)).into_par_iter().map(|part| part * FACES);
        self.joined(parts.fold(Self::default, part).reduce(Self::default, Self::joined))
    }

    fn joined(mut self, other: Self) -> Self {
        self.area.append(other.area);
        self.products.append(other.products);
        self.lengths.append(other.lengths);
        self.faces += other.faces;
        self
    }

    /// Adds the areas and the edges of some faces, at most [`Measures::MOST`].
    #[inline(always)]
    fn add(&mut self, areas: &[f64], a: &[f64], b: &[f64]) {
        let (mut products, mut lengths) = ([0.0; Measures::MOST], [0.0; Measures::MOST]);
        for (k, (a, b)) in a.iter().zip(b).enumerate() {
            (products[k], lengths[k]) = (a * b, a + b);
        }
        self.area.add_all(areas);
        self.products.add_all(&products[..a.len()]);
        self.lengths.add_all(&lengths[..a.len()]);
        self.faces += a.len() as f64;
    }

    /// No lattices with points so far apart have more points: a/s + 1 and b/s + 1 are the most along the edges of a face.
    pub(crate) fn most_points(&self, spacing: f64) -> f64 {
        if self.lengths.nearest() == 0.0 {
            return self.faces;
        }
        self.products.nearest() / spacing / spacing + self.lengths.nearest() / spacing + self.faces
    }
}

/// Lattices, and some faces that join them.
struct Measured<'a> {
    lattices: Lattices,
    facets: &'a Facets,
    faces: Range<usize>,
}

impl Kernel for Measured<'_> {
    type Output = Lattices;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Lattices {
        let Self { mut lattices, facets, faces } = self;
        let mut measures = Measures::default();
        for first in faces.clone().step_by(Measures::MOST) {
            measures.measure(facets, first..faces.end.min(first + Measures::MOST));
            lattices.add(measures.areas(), measures.sides(0), measures.sides(1));
        }
        lattices
    }
}
