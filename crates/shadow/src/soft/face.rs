//! Faces that soft light falls on: their cells and areas.

use umbriel_geometry::{
    Approx, Facet, Facets, PlacedAnalytic, Point,
    analytic::{Chart, Occupied, PatchArea},
};
use umbriel_octree::{Face, Quadrant};

use super::{cell::Cell, horizon::CurvedSide};
use crate::{
    bodies::Body,
    fine::flat::{FLAT, flat_probe},
    levels::FaceSize,
    query::Queries,
    receivers::flat_corners,
};

/// A face and how it is divided.
pub(super) enum FaceShape<'a> {
    /// A triangle or a parallelogram.
    Flat {
        facets: &'a Facets,
        outline: Face,
        /// The corner from which parameters are counted, and the corners from there on.
        first: u8,
        corners: [Point<'a>; FLAT],
        area: Approx,
    },
    /// A patch of a curved body.
    Patch { side: CurvedSide<'a>, area: PatchArea<'a> },
}

impl<'a> FaceShape<'a> {
    pub(super) fn new(queries: &'a Queries<'a>, object: usize, face: usize) -> Self {
        match queries.bodies.get(object) {
            Body::Flat(facets) => {
                let is_triangle = matches!(facets.facet(face), Facet::Triangle(_));
                let outline = if is_triangle { Face::Triangle } else { Face::Square };
                let first = facets.base(face).corner;
                let corners = flat_corners(facets, face, first);
                Self::Flat { facets, outline, first, corners, area: facets.area(face) }
            }
            Body::Analytic(body) => {
                let chart = &body.charts()[face];
                let is_one_sided = queries.bodies.is_one_sided(object, face);
                let area = PatchArea::new(chart, body.placement());
                Self::Patch { side: CurvedSide { body, chart, is_one_sided }, area }
            }
        }
    }

    /// Whether it has no area.
    pub(super) fn is_empty(&self) -> bool {
        matches!(self, Self::Flat { area, .. } if area.upper() == 0.0)
    }

    pub(super) fn size(&self) -> FaceSize {
        match self {
            Self::Flat { outline: Face::Triangle, corners: [a, b, _, d], .. } => FaceSize::of_flat(&[*a, *b, *d], true),
            Self::Flat { corners, .. } => FaceSize::of_flat(corners, false),
            Self::Patch { side, .. } => FaceSize::of_patch(side.chart, side.body.placement()),
        }
    }

    /// The corner of the face from which the parameters of cells are counted.
    pub(super) fn first_corner(&self) -> u8 {
        match self {
            Self::Flat { first, .. } => *first,
            Self::Patch { .. } => 0,
        }
    }

    pub(super) fn children(&self, place: Quadrant) -> Vec<Quadrant> {
        match self {
            Self::Flat { outline, .. } => outline.children(place).collect(),
            Self::Patch { .. } => place.children().collect(),
        }
    }

    /// How much of a cell is surface.
    pub(super) fn occupied(&self, place: Quadrant) -> Occupied {
        match self {
            Self::Flat { .. } => Occupied::Whole,
            Self::Patch { side, .. } => side.chart.occupied(place.low_corner(), place.edge()),
        }
    }

    /// Where a cell lies.
    pub(super) fn cell(&self, place: Quadrant) -> Cell {
        match self {
            Self::Flat { outline, corners, .. } => {
                let at = outline.corners(place).map(|[u, v]| flat_probe(corners, u, v).bounds.position);
                Cell::flat(at.collect())
            }
            Self::Patch { side, .. } => patch_cell(side.body, side.chart, place),
        }
    }

    /// The area of a cell, square metres.
    pub(super) fn area(&self, place: Quadrant) -> Approx {
        match self {
            Self::Flat { outline, area, .. } => {
                let share = outline.share(place);
                Approx { value: area.value * share, error: area.error * share }
            }
            Self::Patch { area, .. } => area.of_cell(place.low_corner(), place.edge()),
        }
    }
}

fn patch_cell(body: &PlacedAnalytic, chart: &Chart, place: Quadrant) -> Cell {
    let ([u, v], edge) = (place.low_corner(), place.edge());
    let hull = chart.hull([u, v], edge).placed(body.placement());
    let slack = hull.iter().map(|point| point.slack.max_element()).fold(0.0, f64::max);
    let mut cell = Cell { slack, ..Cell::flat(hull.map(|point| point.position).to_vec()) };
    let [u, v] = [u + 0.5 * edge, v + 0.5 * edge];
    if chart.occupied([u, v], 0.0) == Occupied::Whole {
        let middle = chart.bounded_point(body.placement(), u, v);
        cell.middle = middle.position;
        cell.slack = slack.max(middle.slack.max_element());
    }
    cell
}
