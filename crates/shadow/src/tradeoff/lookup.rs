//! Stored answers, looked up at any point of the surface: by the cell that holds it, or by the nearest sample of its face.

use umbriel_geometry::{Facet, Facets};
use umbriel_octree::encode2;

use crate::{
    Cell, SamplePoint, Verdict,
    bodies::{Bodies, Body},
    fine::lattice::{Lattice, Spacing},
    levels::FaceSize,
    receivers::flat_corners,
    report::LightReport,
};

/// The finest level of a Morton code here.
const FINEST: u8 = 31;

/// The cells of a bake's light, each face's in Morton order.
pub(super) struct CellLookup<'a> {
    /// Per object: where each face's cells begin, and the cells.
    objects: Vec<(Vec<usize>, &'a [Cell])>,
}

impl<'a> CellLookup<'a> {
    pub(super) fn new(objects: usize, report: &'a LightReport) -> Self {
        let mut all = vec![(Vec::new(), &[][..]); objects];
        for object in &report.objects {
            let faces = object.cells.last().map_or(0, |cell| cell.face + 1);
            let starts = (0..=faces).map(|face| object.cells.partition_point(|cell| cell.face < face)).collect();
            all[object.object] = (starts, &object.cells[..]);
        }
        Self { objects: all }
    }

    /// What is known of the point; undecided where there is no cell.
    pub(super) fn verdict(&self, point: &SamplePoint) -> Verdict {
        let (starts, cells) = &self.objects[point.object];
        let range = || Some(*starts.get(point.face)?..*starts.get(point.face + 1)?);
        let Some(cells) = range().map(|range| &cells[range]).filter(|cells| !cells.is_empty()) else {
            return Verdict::Undecided;
        };
        let corner = from_corner(cells[0].corner, [point.u, point.v]);
        let scale = f64::from(1u32 << FINEST);
        let place = corner.map(|share| (share * scale).max(0.0).min(scale - 1.0) as u32);
        let code = |cell: &Cell| encode2([cell.i, cell.j].map(|place| place << (FINEST - cell.level)));
        let after = cells.partition_point(|cell| code(cell) <= encode2(place));
        cells[after.saturating_sub(1)].verdict
    }
}

/// Parameters of a face as those counted from one of its corners.
fn from_corner(corner: u8, [u, v]: [f64; 2]) -> [f64; 2] {
    match corner {
        1 => [v, 1.0 - u - v],
        2 => [1.0 - u - v, u],
        _ => [u, v],
    }
}

/// Where the samples of each face begin among those of its object, and how they lie.
pub(super) struct SampleLookup {
    /// Per object, per face.
    objects: Vec<Vec<FaceSamples>>,
}

struct FaceSamples {
    first: u64,
    corner: u8,
    lattice: Lattice,
    /// Samples before each row; empty for a single row, and for squares.
    before: Vec<u64>,
}

impl FaceSamples {
    fn new(first: u64, corner: u8, lattice: Lattice) -> Self {
        let rows = if lattice.is_triangle() && lattice.counts()[0] > 1 { lattice.counts()[0] } else { 0 };
        let before = (0..rows).scan(0, |sum, row| {
            let before = *sum;
            *sum += u64::from(lattice.row_len(row));
            Some(before)
        });
        Self { first, corner, lattice, before: before.collect() }
    }
}

impl SampleLookup {
    /// Of all objects; `None` for a scene with a body whose patches fill their squares in part only, so that samples are not numbered by place.
    pub(super) fn new(bodies: &Bodies, spacing: Spacing) -> Option<Self> {
        let of_object = |object: usize| {
            let mut next = 0;
            let mut add = |corner: u8, lattice: Lattice, has_area: bool| {
                let first = next;
                next += if has_area { lattice.len() } else { 0 };
                FaceSamples::new(first, corner, lattice)
            };
            match bodies.get(object) {
                Body::Flat(facets) => Some(
                    (0..facets.len())
                        .map(|face| {
                            let (corner, lattice) = flat_lattice(facets, face, spacing);
                            add(corner, lattice, facets.area(face).upper() > 0.0)
                        })
                        .collect(),
                ),
                Body::Analytic(body) => body
                    .charts()
                    .iter()
                    .map(|chart| {
                        let is_whole = chart.occupied([0.0, 0.0], 1.0) == umbriel_geometry::analytic::Occupied::Whole;
                        let edges = FaceSize::of_patch(chart, body.placement()).edges;
                        is_whole.then(|| add(0, Lattice::new(edges, spacing, false), true))
                    })
                    .collect(),
            }
        };
        let objects = (0..bodies.scene.objects.len()).map(of_object).collect::<Option<Vec<_>>>()?;
        Some(Self { objects })
    }

    /// The number, among the samples of its object, of the one nearest to a point along the parameters of its face.
    pub(super) fn nearest(&self, point: &SamplePoint) -> u64 {
        let FaceSamples { first, corner, lattice, before } = &self.objects[point.object][point.face];
        let [rows, columns] = lattice.counts();
        let [u, v] = from_corner(*corner, [point.u, point.v]);
        let index = |share: f64, count: u32| ((share * f64::from(count)) as u32).min(count - 1);
        let mut row = index(u, rows);
        while row > 0 && lattice.row_len(row) == 0 {
            row -= 1;
        }
        let column = index(v, columns).min(lattice.row_len(row).max(1) - 1);
        let before = before.get(row as usize).copied().unwrap_or(u64::from(row) * u64::from(columns));
        first + before + u64::from(column)
    }
}

fn flat_lattice(facets: &Facets, face: usize, spacing: Spacing) -> (u8, Lattice) {
    let is_triangle = matches!(facets.facet(face), Facet::Triangle(_));
    let corner = facets.base(face).corner;
    let size = FaceSize::of_flat(&flat_corners(facets, face, corner), is_triangle);
    (corner, Lattice::new(size.edges, spacing, is_triangle))
}
