//! The experiment as a picture: a panel a model and kind of rays, nanoseconds a ray over the number of rays, a line a method. Both
//! axes are logarithmic; all panels have the same ones, so that they can be compared.

use std::fmt::Write;

use super::measure::{Method, Rays, Row};
use crate::svg::{Axis, stroke, text};

/// Width and height of a panel with its margins.
const PANEL: [f64; 2] = [270.0, 170.0];
/// Where lines are drawn in a panel: left, top, width, height.
const AREA: [f64; 4] = [42.0, 22.0, 205.0, 118.0];

const METHODS: [(Method, &str, &str); 3] =
    [(Method::Maps, "#c8502d", "maps"), (Method::Octree, "#3c6e9f", "octree"), (Method::Bvh, "#7a7a7a", "BVH")];

/// The picture of a run.
pub(super) fn draw(rows: &[Row]) -> String {
    let mut models: Vec<&str> = rows.iter().map(|row| row.model.as_str()).collect();
    models.dedup();
    let mut body = String::new();
    let times: Vec<f64> =
        rows.iter().flat_map(|row| METHODS.iter().filter_map(|(method, ..)| nanoseconds(row, *method))).collect();
    let nanos = Axis::around(&times);
    let sides = Axis::around(&rows.iter().map(|row| row.side as f64).collect::<Vec<_>>());
    legend(&mut body);
    for (line, model) in models.iter().enumerate() {
        for (column, rays) in Rays::ALL.into_iter().enumerate() {
            let panel: Vec<&Row> = rows.iter().filter(|row| row.model == *model && row.rays == rays).collect();
            let place = [10.0 + PANEL[0] * column as f64, 30.0 + PANEL[1] * line as f64];
            draw_panel(&mut body, &panel, place, [&sides, &nanos]);
        }
    }
    let [width, height] = [20.0 + PANEL[0] * 3.0, 40.0 + PANEL[1] * models.len() as f64];
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\" \
         font-size=\"10\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{body}</svg>\n"
    )
}

fn legend(body: &mut String) {
    text(
        body,
        [20.0, 18.0],
        "start",
        "Nanoseconds a ray over the side of the picture, each method at its best level (at the points, with MiB):",
    );
    for (number, (_, colour, name)) in METHODS.iter().enumerate() {
        let x = 530.0 + 70.0 * number as f64;
        stroke(body, &[[x, 14.0], [x + 18.0, 14.0]], colour);
        text(body, [x + 22.0, 18.0], "start", name);
    }
}

fn draw_panel(body: &mut String, rows: &[&Row], [x, y]: [f64; 2], [sides, nanos]: [&Axis; 2]) {
    let Some(first) = rows.first() else { return };
    let [left, top, width, height] = AREA;
    let [left, top] = [left + x, top + y];
    let place = |side: f64, time: f64| [left + width * sides.part(side), top + height * (1.0 - nanos.part(time))];
    let title =
        format!("{} ({} triangles), {}", first.model, first.triangles, format!("{:?}", first.rays).to_lowercase());
    text(body, [left, top - 6.0], "start", &title);
    for tick in [20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0].into_iter().filter(|&tick| nanos.holds(tick))
    {
        let [_, at] = place(sides.min, tick);
        stroke(body, &[[left, at], [left + width, at]], "#dddddd");
        text(body, [left - 4.0, at + 3.0], "end", &format!("{tick}"));
    }
    stroke(body, &[[left, top], [left, top + height], [left + width, top + height]], "black");
    for row in rows {
        text(body, [place(row.side as f64, nanos.min)[0], top + height + 12.0], "middle", &format!("{}²", row.side));
    }
    for (method, colour, _) in METHODS {
        let points: Vec<[f64; 2]> =
            rows.iter().filter_map(|row| Some(place(row.side as f64, nanoseconds(row, method)?))).collect();
        stroke(body, &points, colour);
        for ([cx, cy], row) in points.into_iter().zip(rows) {
            let _ = writeln!(body, "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"2.5\" fill=\"{colour}\"/>");
            let _ = writeln!(
                body,
                "<text x=\"{cx:.1}\" y=\"{:.1}\" font-size=\"6\" fill=\"{colour}\">{}</text>",
                // Those of maps are the lowest: below.
                if method == Method::Maps { cy + 9.0 } else { cy - 4.0 },
                label(row, method)
            );
        }
    }
}

/// The best level, and MiB.
fn label(row: &Row, method: Method) -> String {
    let Some(figure) = row.figure(method) else { return String::new() };
    let level = figure.depth.map_or(String::new(), |depth| format!("{depth}: "));
    format!("{level}{:.0}", figure.bytes as f64 / 1_048_576.0)
}

fn nanoseconds(row: &Row, method: Method) -> Option<f64> {
    Some(row.figure(method)?.seconds * 1e9 / row.count.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_their_values() {
        let axis = Axis::around(&[10.0, 1000.0]);
        assert!(axis.holds(10.0) && axis.holds(1000.0) && !axis.holds(2000.0));
        assert!((axis.part(100.0) - 0.5).abs() < 1e-12);
        assert!(draw(&[]).ends_with("</svg>\n"));
    }
}
