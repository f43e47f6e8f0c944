//! Figures as lines, as a chart, and what they say about the source's claims.

use std::fmt::Write;

use super::measure::{Figure, Method, Rays, Row};

/// The share of ordinary traversal's time that the source reports on average, and that is required.
const CLAIMED_SHARE: f64 = 0.476;

pub(super) fn heading() -> String {
    format!(
        "{:<9} {:>9} {:<5} {:>5}  {:>24}  {:>24}  {:>9}  {:>7} {:>6}",
        "model",
        "triangles",
        "rays",
        "side",
        "maps ns (depth, MiB)",
        "octree ns (depth, MiB)",
        "BVH ns",
        "/octree",
        "/BVH"
    )
}

pub(super) fn line(row: &Row) -> String {
    let rays = row.count as f64;
    let told = |method: Method| {
        let Some(Figure { seconds, depth, bytes, .. }) = row.figure(method) else { return String::new() };
        let nanoseconds = seconds * 1e9 / rays;
        match (depth, bytes) {
            (Some(depth), Some(bytes)) => format!("{nanoseconds:.0} ({depth:>2}, {:>6.1})", *bytes as f64 / 1048576.0),
            _ => format!("{nanoseconds:.0}"),
        }
    };
    let ratio = |other: Method| row.ratio(Method::Maps, other).unwrap_or(f64::NAN);
    format!(
        "{:<9} {:>9} {:<5} {:>5}  {:>24}  {:>24}  {:>9}  {:>7.3} {:>6.3}",
        row.model,
        row.triangles,
        format!("{:?}", row.rays).to_lowercase(),
        row.side,
        told(Method::Maps),
        told(Method::Octree),
        told(Method::Bvh),
        ratio(Method::Octree),
        ratio(Method::Bvh),
    )
}

/// What the figures say about each claim.
pub(super) fn claims(rows: &[Row]) -> String {
    let mut text = String::new();
    for rays in Rays::ALL {
        let of_kind = || rows.iter().filter(|row| row.rays == rays);
        let mut sides: Vec<u64> = of_kind().map(|row| row.side).collect();
        sides.sort_unstable();
        sides.dedup();
        let mean = |side: Option<u64>, other: Method| {
            let rows = of_kind().filter(|row| side.is_none_or(|side| row.side == side));
            let ratios: Vec<f64> = rows.filter_map(|row| row.ratio(Method::Maps, other)).collect();
            ratios.iter().sum::<f64>() / ratios.len() as f64
        };
        let depth = |row: &Row, method| row.figure(method).and_then(|figure| figure.depth);
        let deeper = of_kind().filter(|row| depth(row, Method::Maps) > depth(row, Method::Octree)).count();
        let equal = of_kind().filter(|row| depth(row, Method::Maps) == depth(row, Method::Octree)).count();
        let share = mean(None, Method::Octree);
        let verdict = if share <= CLAIMED_SHARE { "confirmed" } else { "refuted" };
        let _ = writeln!(
            text,
            "{rays:?}: {:.1} % of ordinary traversal's time on average (claim: at most {:.1} %, {verdict}); by side {}; \
             best depth deeper in {deeper}, equal in {equal} of {} cases; {:.1} % of the BVH's time",
            100.0 * share,
            100.0 * CLAIMED_SHARE,
            sides
                .iter()
                .map(|&side| format!("{side}: {:.1} %", 100.0 * mean(Some(side), Method::Octree)))
                .collect::<Vec<_>>()
                .join(", "),
            of_kind().count(),
            100.0 * mean(None, Method::Bvh),
        );
    }
    text
}

/// A bar a case: the maps' time over ordinary traversal's, and over the BVH's.
pub(super) fn chart(rows: &[Row]) -> String {
    let (left, scale, height) = (260.0, 300.0, 16.0);
    let mut body = String::new();
    let _ = writeln!(
        body,
        "<text x=\"20\" y=\"20\">Time of rays looked up in maps, over ordinary octree traversal (dark) and over the BVH \
         (light); line: 47.6 %</text>"
    );
    let mut top = 34.0;
    for row in rows {
        let name = format!("{}, {:?}, {}²", row.model, row.rays, row.side);
        let _ = writeln!(body, "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{name}</text>", left - 8.0, top + 12.0);
        for (other, offset, colour) in [(Method::Octree, 0.0, "#c8502d"), (Method::Bvh, 7.0, "#8fb4d4")] {
            if let Some(ratio) = row.ratio(Method::Maps, other) {
                let (y, width) = (top + offset, (ratio * scale).min(540.0));
                let _ = writeln!(
                    body,
                    "<rect x=\"{left}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"6\" fill=\"{colour}\"/>\n\
                     <text x=\"{:.1}\" y=\"{:.1}\" font-size=\"7\">{ratio:.2}</text>",
                    left + width + 3.0,
                    y + 6.0,
                );
            }
        }
        top += height;
    }
    for (share, colour) in [(CLAIMED_SHARE, "#c8502d"), (1.0, "black")] {
        let x = left + share * scale;
        let _ = writeln!(body, "<polyline points=\"{x:.1},28 {x:.1},{top:.1}\" fill=\"none\" stroke=\"{colour}\"/>");
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 840 {:.0}\" font-family=\"sans-serif\" \
         font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{body}</svg>\n",
        top + 16.0
    )
}
