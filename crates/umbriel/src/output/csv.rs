//! A bake as a table: its sums, one row an object and light; or its cells, one row a cell and light.

use std::io::{self, Write};

use clap::ValueEnum;
use umbriel_geometry::Approx;
use umbriel_io::write::{Table, write_rows};
use umbriel_scene::Scene;
use umbriel_shadow::{Cell, HourBounds, HourCell, Report, Verdict};

use crate::output::{
    hours::{self, Day},
    surface::Surface,
};

/// What a row of a baked .csv stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Rows {
    /// An object under a light, with its sums
    Objects,
    /// A stored cell under a light
    Cells,
}

/// The columns of the table of cells.
const CELL_COLUMNS: [&str; 13] =
    ["light", "object", "face", "level", "u", "v", "x", "y", "z", "area", "lit_lower", "lit_upper", "verdict"];

/// Writes the table.
///
/// # Errors
/// What the system says.
pub(crate) fn write(scene: &Scene, report: &Report, rows: Rows, out: &mut impl Write) -> io::Result<()> {
    match rows {
        Rows::Objects => table(scene, report).write(out),
        Rows::Cells => write_cells(scene, report, out),
    }
}

/// The sums; areas in square metres.
fn table(scene: &Scene, report: &Report) -> Table {
    let sampled = report.lights.iter().flat_map(|light| &light.objects).any(|object| object.samples.is_some());
    let mut header = vec!["light", "object", "area", "lit_lower", "lit_upper", "lit_estimate", "undecided"];
    if sampled {
        header.extend(["samples", "lit_samples"]);
    }
    let rows = report.lights.iter().flat_map(|light| {
        light.objects.iter().map(move |object| {
            let names = [&scene.lights[light.light].name, &scene.objects[object.object].name];
            let lit = &object.lit;
            let areas = [object.area, lit.lower, lit.upper, lit.estimate, object.undecided()];
            let mut row: Vec<String> = names.into_iter().cloned().collect();
            row.extend(areas.map(|area| area.to_string()));
            if sampled {
                let count = object.samples.unwrap_or_default();
                row.extend([count.samples.to_string(), count.lit.to_string()]);
            }
            row
        })
    });
    Table { header: header.into_iter().map(str::to_owned).collect(), rows: rows.collect() }
}

fn write_cells(scene: &Scene, report: &Report, out: &mut impl Write) -> io::Result<()> {
    let rows = report.lights.iter().flat_map(|light| {
        let light_name = &scene.lights[light.light].name;
        light.objects.iter().flat_map(move |report| {
            let object = &scene.objects[report.object];
            let surface = Surface::of(object);
            report.cells.iter().map(move |cell| row([light_name, &object.name], &surface, cell))
        })
    });
    write_rows(&CELL_COLUMNS, rows, out)
}

fn row(names: [&str; 2], surface: &Surface, cell: &Cell) -> [String; CELL_COLUMNS.len()] {
    let [light, object] = names.map(str::to_owned);
    let [face, level] = [cell.face, u32::from(cell.level)].map(|number| number.to_string());
    let middle = surface.middle(cell);
    let [u, v] = middle.map(|parameter| parameter.to_string());
    let [x, y, z] = surface.point(cell.face, middle).unwrap_or_default().to_array().map(|metres| metres.to_string());
    let area = surface.area(cell);
    let [lower, upper] = lit_bounds(cell.verdict, area).map(|metres| metres.to_string());
    let verdict = match cell.verdict {
        Verdict::Lit => "lit",
        Verdict::Shadowed => "shadowed",
        Verdict::Undecided => "undecided",
    };
    [light, object, face, level, u, v, x, y, z, area.value.to_string(), lower, upper, verdict.to_owned()]
}

/// The columns of the table of cells of a day of suns.
const HOUR_COLUMNS: [&str; 11] =
    ["object", "face", "level", "u", "v", "x", "y", "z", "area", "hours_lower", "hours_upper"];

/// Writes the table of a day of suns.
///
/// # Errors
/// What the system says.
pub(crate) fn write_hours(day: &Day, rows: Rows, out: &mut impl Write) -> io::Result<()> {
    match rows {
        Rows::Objects => hours_table(day).write(out),
        Rows::Cells => {
            let rows = day.report.objects.iter().flat_map(|report| {
                let object = &day.scene.objects[report.object];
                let surface = Surface::of(object);
                report.cells.iter().map(move |cell| hours_row(&object.name, &surface, &cell))
            });
            write_rows(&HOUR_COLUMNS, rows, out)
        }
    }
}

fn hours_table(day: &Day) -> Table {
    let mut header = vec!["object", "area", "hours_lower", "hours_upper", "hours_estimate"];
    header.extend(["area_hours_lower", "area_hours_upper", "area_hours_estimate"]);
    let sampled = day.report.objects.iter().any(|object| object.samples.is_some());
    if sampled {
        header.extend(["samples", "sampled_hours"]);
    }
    let rows = day.report.objects.iter().map(|object| {
        let three = |hours: &HourBounds| [hours.lower, hours.upper, hours.estimate];
        let numbers = [object.area].into_iter().chain(three(&object.lit_hours)).chain(three(&object.lit_area_hours));
        let mut row = vec![day.name(object).to_owned()];
        row.extend(numbers.map(|number| number.to_string()));
        if sampled {
            let samples = object.samples.unwrap_or_default();
            row.extend([samples.samples.to_string(), samples.mean.to_string()]);
        }
        row
    });
    Table { header: header.into_iter().map(str::to_owned).collect(), rows: rows.collect() }
}

fn hours_row(object: &str, surface: &Surface, cell: &HourCell) -> [String; HOUR_COLUMNS.len()] {
    let place = hours::place(cell);
    let middle = surface.middle(&place);
    let [u, v] = middle.map(|parameter| parameter.to_string());
    let [x, y, z] = surface.point(cell.face, middle).unwrap_or_default().to_array().map(|metres| metres.to_string());
    let [lower, upper] = hours::bounds(cell).map(|hours| hours.to_string());
    let [face, level] = [cell.face, u32::from(cell.level)].map(|number| number.to_string());
    [object.to_owned(), face, level, u, v, x, y, z, surface.area(&place).value.to_string(), lower, upper]
}

/// Between which areas the lit part of a cell lies.
pub(crate) fn lit_bounds(verdict: Verdict, area: Approx) -> [f64; 2] {
    match verdict {
        Verdict::Lit => [area.lower().max(0.0), area.upper()],
        Verdict::Shadowed => [0.0, 0.0],
        Verdict::Undecided => [0.0, area.upper()],
    }
}
