//! Charts as SVG, written by hand: bars for the ratios, lines for the series. Both axes of the lines are logarithmic.

use std::fmt::Write;

use super::{options::short, scaling::Series, table::Row};
use crate::svg::{Axis, stroke, text};

/// The picture of a run: all ratios, then a panel a series.
pub(super) fn draw(rows: &[Row], series: &[Series]) -> String {
    let mut body = String::new();
    let mut height = 20.0;
    if !rows.is_empty() {
        height += bars(&mut body, rows, height);
    }
    for (number, series) in series.iter().enumerate() {
        let (column, row) = (number % 2, number / 2);
        lines(&mut body, series, [20.0 + 400.0 * column as f64, height + PANEL[1] * row as f64]);
    }
    height += PANEL[1] * series.len().div_ceil(2) as f64;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 840 {height:.0}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{body}</svg>\n"
    )
}

const OWN: &str = "#c8502d";
const PEER: &str = "#3c6e9f";
/// Width and height of a panel of lines with its margins.
const PANEL: [f64; 2] = [400.0, 300.0];

/// A bar a row: how many times as long Embree takes, on a logarithmic scale round 1. Answers the height.
fn bars(body: &mut String, rows: &[Row], top: f64) -> f64 {
    let measured: Vec<(&Row, f64)> = rows.iter().filter_map(|row| Some((row, row.ratio()?))).collect();
    let reach = measured.iter().map(|(_, ratio)| ratio.log10().abs()).fold(0.1, f64::max);
    let [zero, scale] = [540.0, 220.0 / reach];
    text(body, [20.0, top + 4.0], "start", "Times as fast as Embree's best configuration");
    for (number, (row, ratio)) in measured.iter().enumerate() {
        let y = top + 16.0 + 18.0 * number as f64;
        let length = ratio.log10() * scale;
        let threads = if row.threads == 1 { String::new() } else { format!(", {} threads", row.threads) };
        let name = format!("{}, {} {}, {}{threads}", row.scene, short(row.samples), row.task, row.light);
        text(body, [270.0, y + 11.0], "end", &name);
        let colour = if *ratio >= 1.0 { OWN } else { PEER };
        let (x, width) = (zero + length.min(0.0), length.abs().max(1.0));
        let _ =
            writeln!(body, "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"14\" fill=\"{colour}\"/>");
        let anchor = if length < 0.0 { "end" } else { "start" };
        text(body, [zero + length + 5.0 * length.signum(), y + 11.0], anchor, &format!("{ratio:.2}"));
    }
    let bottom = top + 16.0 + 18.0 * measured.len() as f64;
    stroke(body, &[[zero, top + 12.0], [zero, bottom]], "black");
    bottom + 24.0 - top
}

/// Seconds over the number of a series, of both sides.
fn lines(body: &mut String, series: &Series, [left, top]: [f64; 2]) {
    let own = points(series, |row| Some(measure(row, row.own.seconds)));
    let peer = points(series, |row| row.embree.as_ref().map(|peer| measure(row, peer.total)));
    let all: Vec<[f64; 2]> = own.iter().chain(&peer).copied().collect();
    let (Some(x), Some(y)) = (Axis::over(&all, 0), Axis::over(&all, 1)) else { return };
    let place = |[a, b]: [f64; 2]| [left + 50.0 + x.part(a) * 310.0, top + 250.0 - y.part(b) * 220.0];
    text(body, [left + 205.0, top + 12.0], "middle", &format!("seconds over {}", series.over));
    stroke(body, &[[left + 50.0, top + 30.0], [left + 50.0, top + 250.0], [left + 360.0, top + 250.0]], "black");
    for (number, _) in &series.points {
        let [at, _] = place([*number as f64, y.min]);
        text(body, [at, top + 266.0], "middle", &short(*number));
    }
    for value in y.ticks() {
        let [_, at] = place([x.min, value]);
        text(body, [left + 45.0, at + 4.0], "end", &format!("{value}"));
        stroke(body, &[[left + 50.0, at], [left + 360.0, at]], "#dddddd");
    }
    for (points, colour, name) in [(own, OWN, "umbriel"), (peer, PEER, "Embree")] {
        let placed: Vec<[f64; 2]> = points.into_iter().map(place).collect();
        stroke(body, &placed, colour);
        for [cx, cy] in &placed {
            let _ = writeln!(body, "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"3\" fill=\"{colour}\"/>");
        }
        if let Some([at, height]) = placed.last() {
            text(body, [at - 6.0, height - 8.0], "end", name);
        }
    }
}

fn points(series: &Series, seconds: impl Fn(&Row) -> Option<f64>) -> Vec<[f64; 2]> {
    let point = |(number, row): &(u64, Row)| Some([*number as f64, seconds(row)?]);
    series.points.iter().filter_map(point).collect()
}

/// Processor time on one thread, the clock's on several.
fn measure(row: &Row, seconds: super::clock::Seconds) -> f64 {
    if row.threads == 1 { seconds.cpu } else { seconds.wall }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_their_points() {
        let axis = Axis::over(&[[1.0, 0.3], [4.0, 20.0], [16.0, 3.0]], 1).expect("there are points");
        assert_eq!((axis.part(0.3), axis.part(20.0)), (0.0, 1.0));
        let ticks: Vec<f64> = axis.ticks().collect();
        assert_eq!(ticks, [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        assert!(Axis::over(&[], 0).is_none());
    }

    #[test]
    fn an_empty_picture_is_a_picture() {
        assert!(draw(&[], &[]).ends_with("</svg>\n"));
    }
}
