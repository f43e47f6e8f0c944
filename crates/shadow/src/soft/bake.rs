//! Umbra, penumbra and lit surface under area lights, with bounds.
//!
//! As [`crate::bake`] for points: faces are divided into cells ([`umbriel_octree::Face`]) until each is lit, umbra, or a penumbra whose visible
//! fraction is known well enough, or the detail ends. Every cell has an interval that holds the visible fraction of all of its points
//! ([`super::cell`]), so areas and means have bounds. Curved receivers are not divided: of their surface nothing is said, and all of it counts as
//! undecided. Cost: proportional to the area of penumbrae in cells.

use rayon::prelude::*;
use umbriel_geometry::{Approx, Facet, Facets, Point};
use umbriel_octree::{Face, Quadrant};
use umbriel_scene::{Extent, Scene};

use super::{
    cell::{CellBounds, Receiver},
    occluders::InShaft,
};
use crate::{
    bodies::Body,
    fine::flat::flat_probe,
    levels::{self, FaceSize},
    progress::{Cancelled, Progress},
    query::Queries,
    receivers::{first_corner, flat_corners},
    report::{LitArea, place_in_face},
    request::Detail,
    sums::ExactSum,
};

/// Levels at which the parts of a cell are given to all threads.
const SHARED_LEVELS: u8 = 5;

/// What to compute about soft shadows.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftRequest {
    /// How fine.
    pub detail: Detail,
    /// Penumbra cells whose interval is no wider are not divided; 0 divides all.
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
    let queries = Queries::new(scene);
    let lights = request.lights.iter().map(|&light| {
        let bake = |detail| Bake { queries: &queries, request, light, detail, progress }.run();
        let Detail::MaxUndecided { share } = request.detail else { return bake(request.detail) };
        let mut boundary = 0;
        loop {
            boundary += 1;
            let report = bake(Detail::Depth { interior: boundary, boundary })?;
            let area: f64 = report.objects.iter().map(|object| object.area).sum();
            let open: f64 = report.objects.iter().map(|object| object.visible.upper - object.visible.lower).sum();
            if open <= share * area || boundary == levels::MAX_DEPTH {
                return Ok(report);
            }
        }
    });
    lights.collect()
}

/// One light.
struct Bake<'a> {
    queries: &'a Queries<'a>,
    request: &'a SoftRequest,
    light: usize,
    detail: Detail,
    progress: &'a dyn Progress,
}

/// A face that is divided.
struct FaceCells<'a> {
    bake: &'a Bake<'a>,
    receiver: Receiver<'a>,
    facets: &'a Facets,
    shape: Face,
    number: u32,
    first: u8,
    area: Approx,
    finest: u8,
}

impl Bake<'_> {
    fn run(&self) -> Result<SoftLight, Cancelled> {
        let mut report = SoftLight { light: self.light, ..SoftLight::default() };
        for (number, &object) in self.request.receivers.iter().enumerate() {
            let sums = match self.queries.bodies.get(object) {
                Body::Analytic(body) => {
                    let steps = body.charts().iter().map(|chart| chart.steps(body.placement()));
                    let area: f64 = steps.map(|[u, v]| u * v).sum();
                    let mut sums = SoftSums::default();
                    sums.add(Approx { value: area, error: area }, CellBounds::UNKNOWN);
                    sums
                }
                Body::Flat(facets) => {
                    let faces = (0..facets.len()).into_par_iter().map(|face| self.face(object, facets, face));
                    let faces: Vec<SoftSums> = faces.collect();
                    faces.into_iter().fold(SoftSums::default(), SoftSums::joined)
                }
            };
            if self.progress.is_cancelled() {
                return Err(Cancelled);
            }
            self.progress.advance("soft shadows", number as u64 + 1, self.request.receivers.len() as u64);
            report.cells += sums.examined;
            report.objects.push(sums.report(object));
        }
        Ok(report)
    }

    fn face(&self, object: usize, facets: &Facets, face: usize) -> SoftSums {
        let area = facets.area(face);
        if area.upper() == 0.0 {
            return SoftSums::default();
        }
        let light = &self.queries.bodies.scene.lights[self.light];
        let (receiver, candidates) = Receiver::new(self.queries, light, object, face);
        let is_triangle = matches!(facets.facet(face), Facet::Triangle(_));
        let first = first_corner(facets, face);
        let points: [Point; 4] = flat_corners(facets, face, first);
        let corners = if is_triangle { vec![points[0], points[1], points[3]] } else { points.to_vec() };
        let size = FaceSize::of_flat(&corners, is_triangle);
        let finest = levels::of_face(self.detail, false, &self.queries.bodies.boxes[object], &size).finest;
        let shape = if is_triangle { Face::Triangle } else { Face::Square };
        let cells = FaceCells { bake: self, receiver, facets, shape, number: face as u32, first, area, finest };
        cells.divide(Quadrant::ROOT, &candidates)
    }
}

impl FaceCells<'_> {
    fn divide(&self, place: Quadrant, candidates: &InShaft) -> SoftSums {
        let points = flat_corners(self.facets, self.number as usize, self.first);
        let corners = self.shape.corners(place).map(|[u, v]| flat_probe(&points, u, v).bounds.position);
        let (bounds, kept) = self.receiver.bounds(&corners.collect::<Vec<_>>(), candidates);
        let width = bounds.upper - bounds.lower;
        let is_decided =
            width == 0.0 || (bounds.lower > 0.0 && bounds.upper < 1.0 && width <= self.bake.request.tolerance);
        if is_decided || place.level() >= self.finest || self.bake.progress.is_cancelled() {
            return self.leaf(place, bounds);
        }
        let parts: Vec<Quadrant> = self.shape.children(place).collect();
        let sums: Vec<SoftSums> = if place.level() < SHARED_LEVELS {
            parts.into_par_iter().map(|part| self.divide(part, &kept)).collect()
        } else {
            parts.into_iter().map(|part| self.divide(part, &kept)).collect()
        };
        let whole = sums.into_iter().fold(SoftSums::default(), SoftSums::joined);
        SoftSums { examined: whole.examined + 1, ..whole }
    }

    fn leaf(&self, place: Quadrant, bounds: CellBounds) -> SoftSums {
        let share = self.shape.share(place);
        let mut sums = SoftSums { examined: 1, ..SoftSums::default() };
        sums.add(Approx { value: self.area.value * share, error: self.area.error * share }, bounds);
        if self.bake.request.keep_cells {
            let [i, j] = place.coordinates();
            let CellBounds { lower, upper, estimate } = bounds;
            let (face, corner, level) = (self.number, self.first, place.level());
            sums.cells.push(SoftCell { face, corner, level, i, j, lower, upper, estimate });
        }
        sums
    }
}

/// Areas of cells.
#[derive(Clone, Debug, Default)]
struct SoftSums {
    area: ExactSum,
    lit: ExactSum,
    not_lit: ExactSum,
    umbra: ExactSum,
    not_umbra: ExactSum,
    penumbra: ExactSum,
    whole: ExactSum,
    lower: ExactSum,
    upper: ExactSum,
    estimate: ExactSum,
    cells: Vec<SoftCell>,
    examined: u64,
}

impl SoftSums {
    fn add(&mut self, area: Approx, bounds: CellBounds) {
        let (least, most) = (area.lower().max(0.0), area.upper());
        self.area.add(area.value);
        self.whole.add(most);
        if bounds.lower >= 1.0 {
            self.lit.add(least);
        }
        if bounds.upper < 1.0 {
            self.not_lit.add(least);
        }
        if bounds.upper <= 0.0 {
            self.umbra.add(least);
        }
        if bounds.lower > 0.0 {
            self.not_umbra.add(least);
        }
        if bounds.lower > 0.0 && bounds.upper < 1.0 {
            self.penumbra.add(least);
        }
        self.lower.add((least * bounds.lower).next_down().max(0.0));
        self.upper.add((most * bounds.upper).next_up());
        self.estimate.add(area.value * bounds.estimate);
    }

    fn joined(mut self, mut other: Self) -> Self {
        self.area.append(other.area);
        self.whole.append(other.whole);
        self.lit.append(other.lit);
        self.not_lit.append(other.not_lit);
        self.umbra.append(other.umbra);
        self.not_umbra.append(other.not_umbra);
        self.penumbra.append(other.penumbra);
        self.lower.append(other.lower);
        self.upper.append(other.upper);
        self.estimate.append(other.estimate);
        self.cells.append(&mut other.cells);
        self.examined += other.examined;
        self
    }

    fn report(self, object: usize) -> SoftObject {
        let whole = self.whole.rounded_up();
        let at_most = |others: f64| (whole - others).next_up().max(0.0);
        let [lit, not_lit, umbra, not_umbra, penumbra] =
            [&self.lit, &self.not_lit, &self.umbra, &self.not_umbra, &self.penumbra].map(ExactSum::rounded_down);
        let (lower, upper) = (self.lower.rounded_down(), self.upper.rounded_up());
        SoftObject {
            object,
            area: self.area.nearest(),
            lit: AreaBounds { lower: lit, upper: at_most(not_lit) },
            penumbra: AreaBounds { lower: penumbra, upper: at_most((lit + umbra).next_down().max(0.0)) },
            umbra: AreaBounds { lower: umbra, upper: at_most(not_umbra) },
            visible: LitArea { lower, upper, estimate: self.estimate.nearest().clamp(lower, upper) },
            cells: self.cells,
        }
    }
}
