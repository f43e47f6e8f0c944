//! Umbra, penumbra and lit surface under area lights, with bounds.
//!
//! As [`crate::bake`] for points: faces are divided into cells ([`umbriel_octree::Face`]) until each is lit, umbra, or a penumbra whose visible
//! fraction is known well enough, or the detail ends. Every cell has an interval that holds the visible fraction of all of its points
//! ([`super::cell`]), so areas and means have bounds. Cost: proportional to the area of penumbrae in cells.

use std::{
    sync::atomic::{AtomicU64, Ordering},
    time::Instant,
};

use rayon::prelude::*;
use umbriel_geometry::analytic::Occupied;
use umbriel_octree::Quadrant;
use umbriel_scene::{Extent, Scene};

use super::{
    cell::{CellBounds, Receiver},
    face::FaceShape,
    limits,
    occluders::InShaft,
    sums::SoftSums,
};
use crate::{
    bodies::Body,
    levels,
    progress::{Cancelled, Progress},
    query::Queries,
    report::{LitArea, place_in_face},
    request::Detail,
};

/// Levels at which the parts of a cell are given to all threads.
const SHARED_LEVELS: u8 = 5;

/// What to compute about soft shadows.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftRequest {
    /// How fine.
    pub detail: Detail,
    /// Penumbra cells whose interval is no wider are not divided; 0 divides all. Where a share limits the detail, no more than the share; where a time or
    /// memory does, no more than 2^-depth.
    pub tolerance: f64,
    /// Which lights of the scene; those with an extent.
    pub lights: Vec<usize>,
    /// Which objects as receivers; all objects are occluders.
    pub receivers: Vec<usize>,
    /// Whether the report keeps the cells.
    pub keep_cells: bool,
}

impl SoftRequest {
    /// All lights with an extent, all receivers, sums only; the tolerance is 1/64.
    pub fn everything(scene: &Scene, detail: Detail) -> Self {
        let lights = scene.lights.iter().enumerate().filter(|(_, light)| light.extent != Extent::Point);
        Self {
            detail,
            tolerance: 1.0 / 64.0,
            lights: lights.map(|(number, _)| number).collect(),
            receivers: (0..scene.objects.len()).collect(),
            keep_cells: false,
        }
    }
}

/// An area with bounds, square metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AreaBounds {
    /// Not less, rounded down.
    pub lower: f64,
    /// Not more, rounded up.
    pub upper: f64,
}

/// A cell and what its points see of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftCell {
    /// Face of the object.
    pub face: u32,
    /// The corner of the face from which the parameters are counted.
    pub corner: u8,
    /// How often the face's parameter square was halved.
    pub level: u8,
    /// Along u.
    pub i: u32,
    /// Along v.
    pub j: u32,
    /// No point of the cell sees less of the light: 1 for a lit cell.
    pub lower: f64,
    /// No point of the cell sees more of the light: 0 for umbra.
    pub upper: f64,
    /// What its middle sees.
    pub estimate: f64,
}

impl SoftCell {
    /// The point (s, t) of the cell, both in 0..=1, in the parameters (u, v) of its face.
    pub fn point(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        let edge = 1.0 / f64::from(1u32 << self.level);
        place_in_face(self.corner, [(f64::from(self.i) + s) * edge, (f64::from(self.j) + t) * edge])
    }
}

/// One object under one area light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SoftObject {
    /// Index into the scene's objects.
    pub object: usize,
    /// Surface area, square metres.
    pub area: f64,
    /// All of the light is seen.
    pub lit: AreaBounds,
    /// Some of it is seen.
    pub penumbra: AreaBounds,
    /// None of it is seen.
    pub umbra: AreaBounds,
    /// The visible fraction summed over the surface, square metres; over the area it is the mean.
    pub visible: LitArea,
    /// The cells if they were asked for, in the order of faces and Morton codes.
    pub cells: Vec<SoftCell>,
}

/// All asked objects under one light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SoftLight {
    /// Index into the scene's lights.
    pub light: usize,
    /// One report a receiver, in the order of the request.
    pub objects: Vec<SoftObject>,
    /// Cells examined.
    pub cells: u64,
}

/// Computes soft shadows. Deterministic: the same bits for any number of threads.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
///
/// # Panics
/// If the request names a light or an object that the scene does not have.
pub fn soft_bake(scene: &Scene, request: &SoftRequest, progress: &dyn Progress) -> Result<Vec<SoftLight>, Cancelled> {
    let begun = Instant::now();
    let queries = Queries::new(scene);
    let lights = request.lights.iter().enumerate().map(|(lights_done, &light)| {
        let (detail, tolerance) = (request.detail, request.tolerance);
        let bake = Bake { queries: &queries, request, light, detail, tolerance, room: None, progress };
        match limits::of(request, begun, lights_done) {
            None => bake.run(),
            Some(limit) => limits::refine(bake, &limit),
        }
    });
    lights.collect()
}

/// One light.
pub(super) struct Bake<'a> {
    pub(super) queries: &'a Queries<'a>,
    pub(super) request: &'a SoftRequest,
    pub(super) light: usize,
    pub(super) detail: Detail,
    /// Of penumbra cells: narrower intervals are not divided.
    pub(super) tolerance: f64,
    /// How many more cells may be examined, if there is a limit.
    pub(super) room: Option<AtomicU64>,
    pub(super) progress: &'a dyn Progress,
}

impl Bake<'_> {
    pub(super) fn run(&self) -> Result<SoftLight, Cancelled> {
        let mut report = SoftLight { light: self.light, ..SoftLight::default() };
        for (number, &object) in self.request.receivers.iter().enumerate() {
            let faces = match self.queries.bodies.get(object) {
                Body::Flat(facets) => facets.len(),
                Body::Analytic(body) => body.charts().len(),
            };
            let sums: Vec<SoftSums> = (0..faces).into_par_iter().map(|face| self.face(object, face)).collect();
            let sums = sums.into_iter().fold(SoftSums::default(), SoftSums::joined);
            if self.is_over() {
                return Err(Cancelled);
            }
            self.progress.advance("soft shadows", number as u64 + 1, self.request.receivers.len() as u64);
            report.cells += sums.examined;
            report.objects.push(sums.report(object));
        }
        Ok(report)
    }

    /// Whether to give up.
    fn is_over(&self) -> bool {
        self.progress.is_cancelled() || self.room.as_ref().is_some_and(|room| room.load(Ordering::Relaxed) == 0)
    }

    /// Counts a cell.
    fn count(&self) {
        if let Some(room) = &self.room {
            // Nothing else is told by it, so any order of the threads will do; at zero it stays.
            let _ = room.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1));
        }
    }

    fn face(&self, object: usize, face: usize) -> SoftSums {
        let shape = FaceShape::new(self.queries, object, face);
        if shape.is_empty() {
            return SoftSums::default();
        }
        let light = &self.queries.bodies.scene.lights[self.light];
        let number = [object, face];
        let (receiver, candidates) = match &shape {
            FaceShape::Flat { facets, .. } => Receiver::flat(self.queries, light, number, facets),
            FaceShape::Patch { side, .. } => {
                Receiver::patch(self.queries, light, number, *side, &shape.cell(Quadrant::ROOT))
            }
        };
        let finest = levels::of_face(self.detail, false, &self.queries.bodies.bounds(object), &shape.size()).finest;
        let cells = FaceCells { bake: self, receiver, shape, number, finest };
        cells.divide(Quadrant::ROOT, None, &candidates)
    }
}

/// A face that is divided.
struct FaceCells<'a> {
    bake: &'a Bake<'a>,
    receiver: Receiver<'a>,
    shape: FaceShape<'a>,
    /// Object and face.
    number: [usize; 2],
    finest: u8,
}

impl FaceCells<'_> {
    /// Cells that are `known` are only divided where they are partly surface, for their areas.
    fn divide(&self, place: Quadrant, known: Option<CellBounds>, candidates: &InShaft) -> SoftSums {
        let occupied = self.shape.occupied(place);
        if occupied == Occupied::Nowhere {
            return SoftSums::default();
        }
        let (bounds, kept) = match known {
            Some(bounds) => (bounds, InShaft::default()),
            None => self.receiver.bounds(&self.shape.cell(place), candidates),
        };
        let is_decided = known.is_some() || self.is_decided(bounds);
        let is_leaf = is_decided && occupied == Occupied::Whole;
        self.bake.count();
        if is_leaf || place.level() >= self.finest || self.bake.is_over() {
            return self.leaf(place, bounds);
        }
        let known = is_decided.then_some(bounds);
        let parts = self.shape.children(place);
        let sums: Vec<SoftSums> = if place.level() < SHARED_LEVELS {
            parts.into_par_iter().map(|part| self.divide(part, known, &kept)).collect()
        } else {
            parts.into_iter().map(|part| self.divide(part, known, &kept)).collect()
        };
        sums.into_iter().fold(SoftSums::one_examined(), SoftSums::joined)
    }

    fn is_decided(&self, bounds: CellBounds) -> bool {
        let width = bounds.upper - bounds.lower;
        let is_penumbra = bounds.lower > 0.0 && bounds.upper < 1.0;
        width == 0.0 || (is_penumbra && width <= self.bake.tolerance)
    }

    fn leaf(&self, place: Quadrant, bounds: CellBounds) -> SoftSums {
        let mut sums = SoftSums::one_examined();
        sums.add(self.shape.area(place), bounds);
        if self.bake.request.keep_cells {
            let ([i, j], level) = (place.coordinates(), place.level());
            let CellBounds { lower, upper, estimate } = bounds;
            let (face, corner) = (self.number[1] as u32, self.shape.first_corner());
            sums.cells.push(SoftCell { face, corner, level, i, j, lower, upper, estimate });
        }
        sums
    }
}
