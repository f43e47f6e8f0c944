//! A bake's sums for people: one block a light, columns aligned.

use std::fmt::Write;

use umbriel_geometry::decisions::Decisions;
use umbriel_scene::Scene;
use umbriel_shadow::{HourBounds, LightReport, ObjectHours, ObjectReport, Report};

use crate::output::hours::Day;

/// The readable table.
pub(crate) fn text(scene: &Scene, report: &Report) -> String {
    let mut text = String::new();
    for (index, light) in report.lights.iter().enumerate() {
        if index > 0 {
            text.push('\n');
        }
        let _ = writeln!(text, "light {}", scene.lights[light.light].name);
        text.push_str(&aligned(&rows(scene, light)));
    }
    text
}

/// What settled the decisions of a command, in a line.
pub(crate) fn decisions_text(decisions: Decisions) -> String {
    let Decisions { single, double, pair, expansion, exact } = decisions;
    let all = decisions.all();
    format!("{all} decisions: {single} in f32, {double} in f64, {pair} in pairs, {} exactly\n", expansion + exact)
}

fn rows(scene: &Scene, light: &LightReport) -> Vec<[String; 5]> {
    let header = ["object", "area m²", "lit %", "between %", "undecided m²"].map(str::to_owned);
    let mut rows = vec![header];
    rows.extend(light.objects.iter().map(|object| row(&scene.objects[object.object].name, object)));
    if light.objects.len() > 1 {
        rows.push(row("total", &total(&light.objects)));
    }
    rows
}

fn row(name: &str, object: &ObjectReport) -> [String; 5] {
    let percent = |area: f64| if object.area > 0.0 { 100.0 * area / object.area } else { 0.0 };
    let lit = &object.lit;
    [
        name.to_owned(),
        number(object.area),
        format!("{:.2}", percent(lit.estimate)),
        // An area that is roughly known is less than its bound, and no more than all of it is lit.
        format!("{:.2} to {:.2}", percent(lit.lower), percent(lit.upper).min(100.0)),
        number(object.undecided()),
    ]
}

fn total(objects: &[ObjectReport]) -> ObjectReport {
    let mut total = ObjectReport::default();
    for object in objects {
        total.area += object.area;
        total.lit.lower += object.lit.lower;
        total.lit.upper += object.lit.upper;
        total.lit.estimate += object.lit.estimate;
    }
    total
}

/// The readable table of a day of suns.
pub(crate) fn day_text(day: &Day) -> String {
    let (shining, night) = (day.report.lights.len(), day.below_horizon());
    let mut text = format!("{shining} suns, {} hours", number(day.hours()));
    if night > 0 {
        let _ = write!(text, "; {night} more at or below the horizon");
    }
    text.push('\n');
    let header = ["object", "area m²", "lit h", "between h", "undecided h"].map(str::to_owned);
    let mut rows = vec![header];
    let row = |name: &str, area: f64, hours: &HourBounds| {
        let between = format!("{} to {}", number(hours.lower), number(hours.upper));
        [name.to_owned(), number(area), number(hours.estimate), between, number(hours.upper - hours.lower)]
    };
    rows.extend(day.report.objects.iter().map(|object| row(day.name(object), object.area, &object.lit_hours)));
    if day.report.objects.len() > 1 {
        let sum = |value: fn(&ObjectHours) -> f64| day.report.objects.iter().map(value).sum::<f64>();
        let area = sum(|object| object.area);
        let mean = |hours: f64| if area > 0.0 { hours / area } else { 0.0 };
        let total = HourBounds {
            lower: mean(sum(|object| object.lit_area_hours.lower)),
            upper: mean(sum(|object| object.lit_area_hours.upper)),
            estimate: mean(sum(|object| object.lit_area_hours.estimate)),
        };
        rows.push(row("total", area, &total));
    }
    text + &aligned(&rows)
}

/// Five significant digits; scenes may be millimetres or kilometres across.
pub(crate) fn number(value: f64) -> String {
    // Sizes below the accepted range are zeros that were rounded outward.
    if value.abs() < umbriel_geometry::MIN_MAGNITUDE {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor();
    if !(-4.0..9.0).contains(&magnitude) {
        return format!("{value:.4e}");
    }
    format!("{value:.*}", (4.0 - magnitude).clamp(0.0, 8.0) as usize)
}

/// Characters of a column that others are padded to at most. Names may be of any length, and padding every row to the longest one
/// would multiply it by their number.
const WIDEST: usize = 80;

/// The first column to the left, all others to the right.
pub(crate) fn aligned<const N: usize>(rows: &[[String; N]]) -> String {
    let length = |text: &str| text.chars().count();
    let widths: [usize; N] =
        std::array::from_fn(|column| rows.iter().map(|row| length(&row[column])).max().unwrap_or(0).min(WIDEST));
    let mut text = String::new();
    for row in rows {
        let _ = write!(text, "  {:<width$}", row[0], width = widths[0]);
        for column in 1..N {
            let _ = write!(text, "  {:>width$}", row[column], width = widths[column]);
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbriel_shadow::LitArea;

    #[test]
    fn a_name_of_any_length_has_its_line() {
        let long = "x".repeat(70_000);
        let rows = [["a".to_owned(), "1".to_owned()], [long.clone(), "2".to_owned()]];
        let text = aligned(&rows);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], format!("  a{}  1", " ".repeat(79)));
        assert_eq!(lines[1], format!("  {long}  2"));
    }

    #[test]
    fn numbers_keep_five_digits() {
        let cases =
            [(0.0, "0"), (1600.0, "1600.0"), (0.012345678, "0.012346"), (123456.7, "123457"), (1e-12, "1.0000e-12")];
        for (value, expected) in cases {
            assert_eq!(number(value), expected);
        }
    }

    #[test]
    fn a_row_tells_share_and_bounds() {
        let lit = LitArea { lower: 1.0, upper: 3.0, estimate: 2.0 };
        let object = ObjectReport { area: 4.0, lit, ..Default::default() };
        assert_eq!(row("a", &object), ["a", "4.0000", "50.00", "25.00 to 75.00", "2.0000"]);
        assert_eq!(row("empty", &ObjectReport::default())[2], "0.00");
    }
}
