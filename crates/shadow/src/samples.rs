//! Samples without cells: flat receivers all at once ([`scan`](crate::fine::scan)).
//!
//! Receivers that a curved body or one with holes may shadow, and these themselves, are left to [`Receivers`](crate::receivers::Receivers).
//! Samples prove nothing about the surface between them: the lit area is bounded by nothing and by all.

use rayon::prelude::*;
use umbriel_geometry::{Facets, LightSource, Sign};

use crate::{
    bake::Stage,
    bodies::Body,
    coarse::Influences,
    exact::flat_face_is_lit,
    fine::scan::{IsLit, Layout, Sampled, sample},
    progress::{Cancelled, Progress},
    report::{LitArea, ObjectReport, SampleCount},
    solids::{Solids, Uses},
};

/// The samples of all flat receivers under one light.
pub(crate) struct Samples<'a> {
    stage: &'a Stage<'a>,
    light: &'a LightSource,
    /// Per receiver of the request: whether it is taken.
    taken: Vec<bool>,
    /// Per object: whether it may block a sample of a receiver that is taken.
    blocks: Vec<bool>,
}

impl<'a> Samples<'a> {
    /// Chooses among the receivers that are `asked`, by their places in the request; nothing is decided yet.
    pub(crate) fn new(
        stage: &'a Stage<'a>,
        light: &'a LightSource,
        influences: &Influences,
        asked: impl Fn(usize) -> bool,
    ) -> Self {
        let bodies = &stage.bodies;
        let is_flat = |object: usize| matches!(bodies.get(object), Body::Flat(facets) if !facets.has_holes());
        let mut blocks = vec![false; bodies.boxes.len()];
        let taken = stage.request.receivers.iter().enumerate().map(|(receiver, &object)| {
            if !asked(receiver) {
                return false;
            }
            let occluders = influences.occluders_of(object as u32);
            let is_taken = is_flat(object) && occluders.iter().all(|&occluder| is_flat(occluder as usize));
            if is_taken {
                occluders.iter().for_each(|&occluder| blocks[occluder as usize] = true);
            }
            is_taken
        });
        let taken = taken.collect();
        Self { stage, light, taken, blocks }
    }

    /// Whether receiver number `receiver` of the request is taken.
    pub(crate) fn takes(&self, receiver: usize) -> bool {
        self.taken[receiver]
    }

    /// Decides all samples and writes the reports of the receivers that are taken; answers how many samples that were.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` says so.
    pub(crate) fn run(&self, reports: &mut [ObjectReport], progress: &dyn Progress) -> Result<u64, Cancelled> {
        let Stage { bodies, request, .. } = self.stage;
        let mut place = vec![None; bodies.boxes.len()];
        let asked = request.receivers.iter().enumerate().filter(|&(receiver, _)| self.taken[receiver]);
        asked.for_each(|(receiver, &object)| place[object] = Some(receiver));
        let lit_faces: Vec<_> = (0..bodies.boxes.len())
            .map(|object| {
                move |face: usize, turn: Option<Sign>| flat_face_is_lit(bodies, (object, face), self.light, turn)
            })
            .collect();
        let objects: Vec<Sampled> = (0..bodies.boxes.len())
            .into_par_iter()
            .filter(|&object| self.blocks[object] || place[object].is_some())
            .map_init(Uses::default, |uses, object| {
                let Body::Flat(facets) = bodies.get(object) else { return None };
                let receives = place[object].map(|_| (self.layout(object, facets), &lit_faces[object] as &IsLit));
                // Each object is one job, and lights go one after another: no job waits for what its own thread is making.
                let solids = self.stage.solids[object].get_or_init(|| Box::new(Solids::of(facets, uses)));
                Some(Sampled { object: object as u32, facets, solids, receives, bounds: bodies.boxes[object] })
            })
            .flatten_iter()
            .collect();
        let lit = sample(bodies, self.light, &objects, progress)?;
        let mut all = 0;
        for (object, lit) in objects.iter().zip(lit) {
            let (Some((layout, _)), Some(receiver)) = (object.receives, place[object.object as usize]) else {
                continue;
            };
            let samples = SampleCount { samples: layout.samples, lit: lit.count() };
            reports[receiver] = report(object.object as usize, layout, samples);
            reports[receiver].answers = request.keep_cells.then(|| layout.answers(&lit));
            all += samples.samples;
        }
        Ok(all)
    }

    fn layout(&self, object: usize, facets: &Facets) -> &'a Layout {
        let spacing = self.stage.spacing.expect("samples were asked for");
        self.stage.layouts[object].get_or_init(|| Box::new(Layout::new(facets, spacing)))
    }
}

fn report(object: usize, layout: &Layout, samples: SampleCount) -> ObjectReport {
    let upper = layout.areas.whole();
    let share = samples.lit as f64 / samples.samples.max(1) as f64;
    let (area, area_error) = layout.areas.area();
    let estimate = if samples.lit == samples.samples { area } else { area * share };
    ObjectReport {
        object,
        area,
        area_error,
        lit: LitArea { lower: 0.0, upper, estimate: estimate.clamp(0.0, upper) },
        cells: Vec::new(),
        samples: Some(samples),
        answers: None,
    }
}
