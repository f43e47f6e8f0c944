//! Samples without cells: flat receivers all at once ([`scan`](crate::fine::scan)), or in [`parts`](crate::parts) where meshes have instances.
//!
//! Curved bodies, and receivers that they may shadow where there are few flat faces besides, are left to [`Receivers`](crate::receivers::Receivers): cells are decided as
//! wholes. Elsewhere a curved body is in the way as its box is, and what is behind the box and lit else is asked.
//! Samples prove nothing about the surface between them: the lit area is bounded by nothing and by all.

use std::{borrow::Cow, sync::Arc};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{Aabb, Facets, LightSource, MAX_MAGNITUDE, MIN_MAGNITUDE, Mesh, Placement, Sign};

use crate::{
    bake::Stage,
    bodies::{Bodies, Body},
    coarse::Influences,
    exact::flat_face_is_lit,
    fine::scan::{IsLit, Layout, LitBits, LitSamples, RUNS, Sampled, sample},
    parts::{Lot, Part, PartOfAll, parts},
    progress::{Cancelled, Progress},
    report::{LitArea, ObjectReport, SampleCount},
    solids::{Solids, Uses},
};

/// Flat faces of a receiver and of what may shadow it from which on samples by themselves are sooner done than cells, if curved bodies are among the latter.
const MANY_FACES: usize = if cfg!(test) { 8 } else { 1 << 10 };

/// The samples of all flat receivers under one light.
pub(crate) struct Samples<'a> {
    stage: &'a Stage<'a>,
    light: &'a LightSource,
    influences: &'a Influences<'a>,
    /// Per receiver of the request: whether it is taken.
    taken: Vec<bool>,
}

/// An object of a lot.
struct Prepared<'b> {
    object: usize,
    /// Of a curved body those of its box.
    facets: Cow<'b, Facets>,
    solids: Arc<Solids>,
    /// Of a receiver: its place in the request, and its samples.
    receives: Option<(usize, Arc<Layout>)>,
}

impl<'a> Samples<'a> {
    /// Chooses among the receivers that are `asked`, by their places in the request; nothing is decided yet.
    pub(crate) fn new(
        stage: &'a Stage<'a>,
        light: &'a LightSource,
        influences: &'a Influences<'a>,
        asked: impl Fn(usize) -> bool,
    ) -> Self {
        let bodies = &stage.bodies;
        let is_flat = |object: usize| !bodies.is_analytic(object);
        let all_are_flat = (0..bodies.scene.objects.len()).all(is_flat);
        let suits = |object: usize| {
            let occluders = influences.occluders_of(object as u32);
            let (flat, curved): (Vec<u32>, Vec<u32>) = occluders.iter().partition(|&&other| is_flat(other as usize));
            let has_box = |&other: &u32| is_accepted(&bodies.bounds(other as usize));
            let of_others: usize = flat.iter().map(|&other| bodies.face_count(other as usize)).sum();
            let has_many = bodies.face_count(object) + of_others >= MANY_FACES;
            curved.is_empty() || has_many && curved.iter().all(has_box)
        };
        let taken = stage.request.receivers.iter().enumerate();
        let taken =
            taken.map(|(receiver, &object)| asked(receiver) && is_flat(object) && (all_are_flat || suits(object)));
        Self { stage, light, influences, taken: taken.collect() }
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
        let taken = (0..request.receivers.len()).filter(|&receiver| self.taken[receiver]).collect();
        let parts = parts(bodies, &request.receivers, (self.light, self.influences), taken);
        let all: u64 = parts.iter().flat_map(|part| &part.lots).map(|lot| lot.faces).sum();
        let mut before = 0;
        for part in &parts {
            let mut known: Vec<LitBits> = Vec::new();
            for (number, lot) in part.lots.iter().enumerate() {
                let is_last = number + 1 == part.lots.len();
                let progress = PartOfAll { progress, before, own: lot.faces, all };
                if bodies.has_instances() {
                    self.run_lot(&Bodies::of_group(bodies), (part, lot, is_last), &mut known, reports, &progress)?;
                } else {
                    self.run_lot(bodies, (part, lot, is_last), &mut known, reports, &progress)?;
                }
                before += lot.faces;
            }
        }
        let counts = (0..request.receivers.len()).filter(|&receiver| self.taken[receiver]);
        Ok(counts.filter_map(|receiver| reports[receiver].samples).map(|samples| samples.samples).sum())
    }

    /// The receivers of a part before one lot of what may shadow them; `known` are the answers before those before, and then all of them. The last lot
    /// tells the answers.
    fn run_lot(
        &self,
        bodies: &Bodies,
        (part, lot, is_last): (&Part, &Lot, bool),
        known: &mut Vec<LitBits>,
        reports: &mut [ObjectReport],
        progress: &dyn Progress,
    ) -> Result<(), Cancelled> {
        let prepared = self.prepared(bodies, part, lot);
        let lit_faces: Vec<_> = prepared
            .iter()
            .map(|one| {
                move |face: usize, turn: Option<Sign>| flat_face_is_lit(bodies, (one.object, face), self.light, turn)
            })
            .collect();
        let objects: Vec<Sampled> =
            prepared.iter().zip(&lit_faces).map(|(one, is_lit)| sampled(bodies, one, is_lit)).collect();
        let lit = sample(bodies, self.light, &objects, progress)?;
        let lit = lit.into_iter().zip(&prepared).filter_map(|(lit, one)| one.receives.as_ref().map(|_| lit));
        if known.is_empty() {
            known.extend(lit);
        } else {
            known.iter_mut().zip(lit).for_each(|(known, lit)| known.intersect(&lit));
        }
        if !is_last {
            return Ok(());
        }
        let receivers = prepared.iter().filter_map(|one| Some((one.object, one.receives.as_ref()?)));
        for ((object, (receiver, layout)), lit) in receivers.zip(known) {
            reports[*receiver] = report(object, layout, &layout.lit(lit));
            reports[*receiver].answers = self.stage.request.keep_cells.then(|| layout.answers(lit));
        }
        Ok(())
    }

    /// The objects of a lot, ascending: receivers are in the way of others, too.
    fn prepared<'b>(&self, bodies: &'b Bodies, part: &Part, lot: &Lot) -> Vec<Prepared<'b>> {
        let mut objects: Vec<(usize, Option<usize>)> =
            lot.occluders.iter().map(|&object| (object as usize, None)).collect();
        objects.extend(part.receivers.iter().map(|&receiver| (self.stage.request.receivers[receiver], Some(receiver))));
        // What receives comes after what only blocks; of both the last is kept.
        objects.sort_unstable();
        objects.reverse();
        objects.dedup_by_key(|(object, _)| *object);
        objects.reverse();
        let prepare = |uses: &mut Uses, (object, receiver): (usize, Option<usize>)| {
            let facets = match bodies.get(object) {
                Body::Flat(facets) => facets,
                Body::Analytic(_) => {
                    let facets = Cow::Owned(sides_of(&bodies.bounds(object))?);
                    return Some(Prepared { object, facets, solids: Arc::default(), receives: None });
                }
            };
            let receives = receiver.map(|receiver| (receiver, self.layout(object, facets)));
            // Each object is one job, and lights go one after another: no job waits for what its own thread is making.
            let mut solids = || Arc::new(Solids::of(facets, uses));
            let solids = if bodies.is_instance(object) {
                solids()
            } else {
                Arc::clone(self.stage.solids.get_or_init(object, solids))
            };
            Some(Prepared { object, facets: Cow::Borrowed(facets), solids, receives })
        };
        let most = objects.len().div_ceil(RUNS);
        objects.into_par_iter().with_max_len(most).map_init(Uses::default, prepare).flatten_iter().collect()
    }

    fn layout(&self, object: usize, facets: &Facets) -> Arc<Layout> {
        let spacing = self.stage.spacing.expect("samples were asked for");
        let layout = || Arc::new(Layout::new(facets, spacing));
        if self.stage.bodies.is_instance(object) {
            layout()
        } else {
            Arc::clone(self.stage.layouts.get_or_init(object, layout))
        }
    }
}

fn sampled<'s>(bodies: &Bodies, one: &'s Prepared<'s>, is_lit: &'s IsLit<'s>) -> Sampled<'s> {
    Sampled {
        object: one.object as u32,
        facets: &one.facets,
        is_box: bodies.is_analytic(one.object),
        solids: &one.solids,
        receives: one.receives.as_ref().map(|(_, layout)| (&**layout, is_lit)),
        bounds: bodies.bounds(one.object),
    }
}

/// Whether a mesh may have the corners of a box.
fn is_accepted(bounds: &Aabb) -> bool {
    bounds.magnitude() <= MAX_MAGNITUDE
}

/// The sides of a box, to the outside, or of one that is hardly larger; `None` for an empty one, and for one that is not accepted.
fn sides_of(bounds: &Aabb) -> Option<Facets> {
    if bounds.is_empty() {
        return None;
    }
    // What is too small for a mesh is rounded outward.
    let outward = |end: DVec3, way: f64| {
        end.map(|x| match x {
            x if x.abs() >= MIN_MAGNITUDE || x == 0.0 => x,
            x if x * way > 0.0 => way * MIN_MAGNITUDE,
            _ => 0.0,
        })
    };
    let accepted = Aabb { min: outward(bounds.min, -1.0), max: outward(bounds.max, 1.0) };
    let corners = accepted.corners().map(|corner| corner.to_array()).to_vec();
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = Mesh::new(corners, triangles).ok()?;
    Some(Facets::of_mesh(mesh, &Placement::IDENTITY))
}

fn report(object: usize, layout: &Layout, lit: &LitSamples) -> ObjectReport {
    let upper = layout.areas.whole();
    let (area, area_error) = layout.areas.area();
    let samples = SampleCount { samples: layout.samples, lit: lit.count };
    let estimate = if samples.lit == samples.samples { area } else { lit.area };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_hold_a_box_and_face_outward() {
        let tiny = f64::MIN_POSITIVE;
        let bounds = Aabb { min: DVec3::new(-1.0, -tiny, tiny), max: DVec3::new(2.0, tiny, 3.0) };
        let sides = sides_of(&bounds).expect("a box");
        assert!(sides.bounds().contains(bounds.min) && sides.bounds().contains(bounds.max) && sides.len() == 12);
        for side in 0..12 {
            let corners = sides.facet(side).corners();
            let [a, b, c] = [0, 1, 2].map(|k| sides.positions()[corners[k] as usize]);
            let normal = (b - a).cross(c - a);
            // All corners of a box lie behind the planes of its sides.
            let is_behind = |corner: &DVec3| normal.dot(*corner - a) <= 0.0;
            assert!(normal.length() > 0.0 && sides.positions().iter().all(is_behind), "side {side}");
        }
        let large = Aabb { max: DVec3::splat(2e61), ..bounds };
        assert!(!is_accepted(&large) && sides_of(&large).is_none());
        assert!(is_accepted(&bounds) && is_accepted(&Aabb::EMPTY) && sides_of(&Aabb::EMPTY).is_none());
    }
}
