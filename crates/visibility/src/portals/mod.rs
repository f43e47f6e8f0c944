//! What an eye or a light reaches through cells and portals.
//!
//! From the cell that holds the eye, its objects are collected that the frustum may meet; through each portal that is seen in it, the
//! frustum narrows to what is seen through the portal, and the neighbour is entered ([`reach_of_eye`], [`reach_of_light`]). A light is an eye that looks
//! everywhere; a sun looks in from the outdoors.
//!
//! - Source: a note on indoor scene management (cells and portals); Luebke and Georges, "Portals and mirrors", I3D 1995, use boxes of
//!   portals in the picture where frusta here are exact.
//! - Guarantee: conservative. A ray from the eye passes portals from one cell to the next, always to the side of the portal where
//!   the eye is not, and lies in the cone of each; so what it meets first belongs to a cell that is entered with a frustum that holds
//!   the ray. Portals with rounded corners are taken wider for it (`opening`). This takes the scene's word that nothing is seen across boundaries but through portals. Sides of portals and corners of
//!   cones are decided by exact signs; objects go by their boxes, doubt collects.
//! - A portal is passed once in a chain. Chains of convex cells cannot meet a cell twice, a ray comes back into a house from the outdoors.
//!   Where the eye lies in a portal's plane, the neighbour is entered with the frustum as it is.
//! - Cost: portals and objects of the cells that are entered, for each chain; nothing else is looked at. More than [`MOST_VISITS`] visits
//!   are not made: everything counts as reached then.

mod frustum;
mod opening;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use umbriel_geometry::LightSource;
use umbriel_scene::{CellGraph, Object, Projection, Scene};

use crate::view::View;
use frustum::EyeSide;
pub use frustum::Frustum;
use opening::Opening;

/// How often cells are entered before everything counts as reached.
pub const MOST_VISITS: usize = 1 << 16;

/// How a search began, and whether it is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Start {
    /// In the cells that hold the eye.
    Cells,
    /// The scene has no cells: all objects that the frustum meets.
    NoCells,
    /// The eye is in no cell, inside a wall or outdoors where there is no outdoors: all objects that the frustum meets.
    OutsideCells,
    /// A parallel view has no eye that is in a cell: all objects that the frustum meets.
    Parallel,
    /// More than [`MOST_VISITS`] visits: all objects that the first frustum meets.
    TooManyVisits,
}

/// An object that is reached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reached {
    /// Index into the scene's objects.
    pub object: usize,
    /// The frusta that may meet it, by their indices in [`Reach::frusta`]; several if it is reached through several chains.
    pub frusta: Vec<usize>,
}

/// What is reached from an eye or a light.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// The objects, ascending, each once.
    pub objects: Vec<Reached>,
    /// The frustum of each visit, the first ones those of the eye.
    pub frusta: Vec<Frustum>,
    /// The cells that were entered, ascending.
    pub cells: Vec<usize>,
    /// How often portals were passed.
    pub passages: usize,
    /// How it began.
    pub start: Start,
}

impl Reach {
    /// The objects, ascending.
    pub fn indices(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.objects.iter().map(|reached| reached.object)
    }
}

/// What a light may reach of a scene.
pub fn reach_of_light(scene: &Scene, light: &LightSource) -> Reach {
    let start =
        if light.is_sun() { scene.cells.outdoors().into_iter().collect() } else { scene.cells.cells_at(light.xyz()) };
    reach(scene, Frustum::everything(*light), *light, &start, Start::Cells)
}

/// What may be seen in a view; `None` where its eye or direction is not accepted.
pub fn reach_of_eye(scene: &Scene, view: &View) -> Option<Reach> {
    let frustum = Frustum::of_view(view)?;
    if matches!(view.camera.projection, Projection::Perspective { .. }) {
        let eye = LightSource::point(view.camera.eye.to_array()).ok()?;
        return Some(reach(scene, frustum, eye, &scene.cells.cells_at(eye.xyz()), Start::Cells));
    }
    Some(all_in(scene, frustum, Start::Parallel))
}

/// All objects that a frustum may meet, whatever the cells: plain frustum culling. O(objects).
pub fn frustum_culling(scene: &Scene, view: &View) -> Option<Vec<usize>> {
    Some(all_in(scene, Frustum::of_view(view)?, Start::NoCells).indices().collect())
}

fn reach(scene: &Scene, frustum: Frustum, eye: LightSource, cells: &[usize], start: Start) -> Reach {
    if scene.cells.is_empty() {
        return all_in(scene, frustum, Start::NoCells);
    }
    if cells.is_empty() {
        return all_in(scene, frustum, Start::OutsideCells);
    }
    let first = frustum.clone();
    match Search::run(&scene.cells, eye, frustum, cells) {
        Some(search) => search.into_reach(start),
        None => all_in(scene, first, Start::TooManyVisits),
    }
}

fn all_in(scene: &Scene, frustum: Frustum, start: Start) -> Reach {
    let bounds = |number: usize, object: &Object| match scene.cells.bounds().get(number) {
        Some(bounds) => *bounds,
        None => object.bounds(),
    };
    let is_met = |(number, object): (usize, &Object)| {
        let bounds = bounds(number, object);
        (!bounds.is_empty() && !frustum.misses(&bounds)).then(|| Reached { object: number, frusta: vec![0] })
    };
    let objects = scene.objects.iter().enumerate().filter_map(is_met).collect();
    Reach { objects, frusta: vec![frustum], cells: Vec::new(), passages: 0, start }
}

/// A cell entered with a frustum (of the same number).
struct Visit {
    cell: usize,
    /// The portal that was passed, and the visit that it was passed from.
    from: Option<(u32, usize)>,
}

struct Search<'a> {
    graph: &'a CellGraph,
    eye: LightSource,
    visits: Vec<Visit>,
    frusta: Vec<Frustum>,
    seen: BTreeMap<u32, Vec<usize>>,
    /// How the eye lies to each portal that was asked about: a cell is entered once a chain, and asks for all of its portals each time.
    openings: Vec<Option<Opening<'a>>>,
}

impl<'a> Search<'a> {
    /// `None` after too many visits.
    fn run(graph: &'a CellGraph, eye: LightSource, frustum: Frustum, cells: &[usize]) -> Option<Self> {
        let visits = cells.iter().map(|&cell| Visit { cell, from: None }).collect();
        let mut search = Self {
            graph,
            eye,
            visits,
            frusta: vec![frustum; cells.len()],
            seen: BTreeMap::new(),
            openings: vec![None; graph.portals().len()],
        };
        let mut next = 0;
        while next < search.visits.len() {
            if search.visits.len() > MOST_VISITS {
                return None;
            }
            search.collect(next);
            search.pass_portals(next);
            next += 1;
        }
        Some(search)
    }

    /// The cell's objects that the frustum may meet.
    fn collect(&mut self, visit: usize) {
        let (graph, frustum) = (self.graph, &self.frusta[visit]);
        for &object in graph.objects_in(self.visits[visit].cell) {
            if !frustum.misses(&graph.bounds()[object as usize]) {
                self.seen.entry(object).or_default().push(visit);
            }
        }
    }

    /// Enters the neighbours.
    fn pass_portals(&mut self, visit: usize) {
        let (graph, cell) = (self.graph, self.visits[visit].cell);
        for &number in graph.portals_of(cell) {
            if self.is_in_chain(visit, number) {
                continue;
            }
            let portal = &graph.portals()[number as usize];
            let own = usize::from(portal.cells[0] != cell);
            let opening = &mut self.openings[number as usize];
            let (side, corners) = opening.get_or_insert_with(|| opening::seen(&self.eye, portal));
            let frustum = match (*side, own) {
                (EyeSide::Front, 0) | (EyeSide::Behind, 1) => self.frusta[visit].through(corners),
                (EyeSide::Within, _) => Some(self.frusta[visit].clone()),
                _ => None,
            };
            if let Some(frustum) = frustum {
                self.visits.push(Visit { cell: portal.cells[1 - own], from: Some((number, visit)) });
                self.frusta.push(frustum);
            }
        }
    }

    /// Whether a portal was passed on the way to a visit.
    fn is_in_chain(&self, visit: usize, portal: u32) -> bool {
        let mut from = self.visits[visit].from;
        while let Some((passed, before)) = from {
            if passed == portal {
                return true;
            }
            from = self.visits[before].from;
        }
        false
    }

    fn into_reach(self, start: Start) -> Reach {
        let cells: BTreeSet<usize> = self.visits.iter().map(|visit| visit.cell).collect();
        let passages = self.visits.iter().filter(|visit| visit.from.is_some()).count();
        let objects = self.seen.into_iter().map(|(object, frusta)| Reached { object: object as usize, frusta });
        Reach { objects: objects.collect(), frusta: self.frusta, cells: cells.into_iter().collect(), passages, start }
    }
}
