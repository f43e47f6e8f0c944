//! A bake as one VTK grid: every cell a polygon with what is known of it under every light.
//!
//! Lights divide surfaces differently; the polygons are the coarsest parts on which each light has one verdict.

use std::collections::HashMap;

use umbriel_geometry::Approx;
use umbriel_io::write::{GridArray, GridValues, PolygonGrid};
use umbriel_scene::{Object, Scene};
use umbriel_shadow::{Cell, Report, Verdict};

use crate::output::{
    csv::lit_bounds,
    hours::{self, Day},
    overlay::overlay,
    surface::Surface,
};

/// The number of a verdict; 3 where a light has no stored cell.
fn number(verdict: Option<Verdict>) -> i8 {
    match verdict {
        Some(Verdict::Shadowed) => 0,
        Some(Verdict::Lit) => 1,
        Some(Verdict::Undecided) => 2,
        None => 3,
    }
}

/// The grid of all stored cells. O(cells × lights × levels).
pub(crate) fn grid(scene: &Scene, report: &Report) -> PolygonGrid {
    let mut sheet = Sheet { lights: vec![LightColumns::default(); report.lights.len()], ..Sheet::default() };
    let receivers = report.lights.first().map_or(0, |light| light.objects.len());
    for receiver in 0..receivers {
        let reports = report.lights.iter().map(|light| &light.objects[receiver]);
        let lists: Vec<&[Cell]> = reports.map(|object| object.cells.as_slice()).collect();
        let index = report.lights[0].objects[receiver].object;
        sheet.add_object(index as u32, &scene.objects[index], &lists);
    }
    sheet.into_grid(scene, report)
}

/// The grid of a day of suns: every cell with its hours. O(cells).
pub(crate) fn hours_grid(day: &Day) -> PolygonGrid {
    let mut sheet = Sheet::default();
    let (mut lower, mut upper) = (Vec::new(), Vec::new());
    for report in &day.report.objects {
        let surface = Surface::of(&day.scene.objects[report.object]);
        let mut corners = SharedCorners::default();
        for cell in report.cells.iter() {
            for part in surface.parts(&hours::place(&cell)) {
                sheet.add_polygon(report.object as u32, &surface, &part, &mut corners);
                let [least, most] = hours::bounds(&cell);
                lower.push(least);
                upper.push(most);
            }
        }
    }
    let mut grid = sheet.grid;
    grid.cell_data = vec![
        GridArray::new("hours_lower", GridValues::F64(lower)),
        GridArray::new("hours_upper", GridValues::F64(upper)),
    ];
    grid.cell_data.extend(sheet.columns.into_arrays());
    let objects = day.scene.objects.iter().map(|object| object.name.as_str());
    grid.field_data = vec![GridArray::new("object_names", lines(objects))];
    grid
}

/// The grid as it grows, column by column.
#[derive(Default)]
struct Sheet {
    grid: PolygonGrid,
    columns: PlaceColumns,
    lights: Vec<LightColumns>,
}

/// Where every polygon lies.
#[derive(Default)]
struct PlaceColumns {
    object: Vec<u32>,
    face: Vec<u32>,
    level: Vec<i8>,
    area: Vec<f64>,
}

impl PlaceColumns {
    fn into_arrays(self) -> [GridArray; 4] {
        [
            GridArray::new("area", GridValues::F64(self.area)),
            GridArray::new("object", GridValues::U32(self.object)),
            GridArray::new("face", GridValues::U32(self.face)),
            GridArray::new("level", GridValues::I8(self.level)),
        ]
    }
}

/// What one light says of every polygon.
#[derive(Clone, Default)]
struct LightColumns {
    verdict: Vec<i8>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl LightColumns {
    fn add(&mut self, verdict: Option<Verdict>, area: Approx) {
        // Where nothing is stored, nothing is known.
        let [lower, upper] = lit_bounds(verdict.unwrap_or(Verdict::Undecided), area);
        self.verdict.push(number(verdict));
        self.lower.push(lower);
        self.upper.push(upper);
    }
}

impl Sheet {
    fn add_object(&mut self, index: u32, object: &Object, lists: &[&[Cell]]) {
        let surface = Surface::of(object);
        let mut corners = SharedCorners::default();
        overlay(lists, |cell, verdicts| {
            for part in surface.parts(cell) {
                let area = self.add_polygon(index, &surface, &part, &mut corners);
                self.lights.iter_mut().zip(verdicts).for_each(|(light, &verdict)| light.add(verdict, area));
            }
        });
    }

    /// Adds a part of an object; its area.
    fn add_polygon(&mut self, index: u32, surface: &Surface, part: &Cell, corners: &mut SharedCorners) -> Approx {
        corners.add_polygon(surface, part, &mut self.grid);
        let area = surface.area(part);
        self.columns.object.push(index);
        self.columns.face.push(part.face);
        self.columns.level.push(part.level as i8);
        self.columns.area.push(area.value);
        area
    }

    fn into_grid(self, scene: &Scene, report: &Report) -> PolygonGrid {
        let mut grid = self.grid;
        let lights = report.lights.iter().map(|light| scene.lights[light.light].name.as_str());
        // What readers show first stands first.
        for (columns, name) in self.lights.into_iter().zip(lights.clone()) {
            let mut add = |kind: &str, values| grid.cell_data.push(GridArray::new(format!("{kind} {name}"), values));
            add("verdict", GridValues::I8(columns.verdict));
            add("lit_lower", GridValues::F64(columns.lower));
            add("lit_upper", GridValues::F64(columns.upper));
        }
        grid.cell_data.extend(self.columns.into_arrays());
        let objects = scene.objects.iter().map(|object| object.name.as_str());
        grid.field_data = vec![
            GridArray::new("object_names", lines(objects)),
            GridArray::new("light_names", lines(lights)),
            GridArray::new("verdict_names", lines(["shadowed", "lit", "undecided", "not stored"].into_iter())),
        ];
        grid
    }
}

/// Text in UTF-8, one line a name.
fn lines<'a>(names: impl Iterator<Item = &'a str>) -> GridValues {
    GridValues::U8(names.map(|name| name.replace('\n', " ")).collect::<Vec<_>>().join("\n").into_bytes())
}

/// The points of one face, each stored once.
#[derive(Default)]
struct SharedCorners {
    face: u32,
    places: HashMap<[u64; 2], u32>,
}

impl SharedCorners {
    fn add_polygon(&mut self, surface: &Surface, part: &Cell, grid: &mut PolygonGrid) {
        if self.face != part.face {
            self.face = part.face;
            self.places.clear();
        }
        for corner in surface.polygon(part) {
            let place = *self.places.entry(corner.map(f64::to_bits)).or_insert_with(|| {
                grid.points.push(surface.point(part.face, corner).unwrap_or_default().to_array());
                grid.points.len() as u32 - 1
            });
            grid.corners.push(place);
        }
        grid.ends.push(grid.corners.len() as u32);
    }
}
