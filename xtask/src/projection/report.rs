//! Figures as lines, as a table for the documentation, and what they say about the source's claims.

use std::fmt::Write;

use super::measure::{Figure, Method, Rays, Row};

/// The share of ordinary traversal's time that the source reports on average, and that is required.
const CLAIMED_SHARE: f64 = 0.476;

const MEBIBYTE: f64 = 1_048_576.0;

pub(super) fn heading() -> String {
    format!(
        "{:<9} {:>9} {:<5} {:>5}  {:>24}  {:>24}  {:>15}  {:>7} {:>6}",
        "model",
        "triangles",
        "rays",
        "side",
        "maps ns (depth, MiB)",
        "octree ns (depth, MiB)",
        "BVH ns (MiB)",
        "/octree",
        "/BVH"
    )
}

pub(super) fn line(row: &Row) -> String {
    let rays = row.count as f64;
    let told = |method: Method| {
        let Some(Figure { seconds, depth, bytes, .. }) = row.figure(method) else { return String::new() };
        let nanoseconds = seconds * 1e9 / rays;
        match depth {
            Some(depth) => format!("{nanoseconds:.0} ({depth:>2}, {:>6.1})", *bytes as f64 / MEBIBYTE),
            None => format!("{nanoseconds:.0} ({:>6.1})", *bytes as f64 / MEBIBYTE),
        }
    };
    let ratio = |other: Method| row.ratio(Method::Maps, other).unwrap_or(f64::NAN);
    format!(
        "{:<9} {:>9} {:<5} {:>5}  {:>24}  {:>24}  {:>15}  {:>7.3} {:>6.3}",
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

/// A table in Markdown: nanoseconds a ray, best depth, mebibytes, seconds of building.
pub(super) fn markdown(rows: &[Row]) -> String {
    let mut text = "| model | triangles | rays | picture | maps | octree | BVH | maps/octree | maps/BVH |\n".to_owned();
    text += "|---|---|---|---|---|---|---|---|---|\n";
    for row in rows {
        let told = |method: Method| {
            let Some(Figure { seconds, depth, bytes, build, .. }) = row.figure(method) else { return String::new() };
            let depth = depth.map_or(String::new(), |depth| format!("level {depth}, "));
            let nanoseconds = seconds * 1e9 / row.count as f64;
            format!("{nanoseconds:.0} ({depth}{:.1} MiB, {:.2} s)", *bytes as f64 / MEBIBYTE, build)
        };
        let ratio = |other: Method| row.ratio(Method::Maps, other).unwrap_or(f64::NAN);
        let kind = format!("{:?}", row.rays).to_lowercase();
        let _ = writeln!(
            text,
            "| {} | {} | {kind} | {}² | {} | {} | {} | {:.3} | {:.3} |",
            row.model,
            row.triangles,
            row.side,
            told(Method::Maps),
            told(Method::Octree),
            told(Method::Bvh),
            ratio(Method::Octree),
            ratio(Method::Bvh),
        );
    }
    text
}
