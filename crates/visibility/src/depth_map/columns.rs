//! The texels of a row whose middles lie in a triangle: half open, so that triangles that share an edge draw each texel once.

use std::ops::Range;

use glam::DVec2;

/// The columns of `row` that a triangle covers, of a picture `size` texels wide; corners in texels. `None` where the row's middle line misses it.
pub(crate) fn columns(corners: &[DVec2; 3], row: usize, size: usize) -> Option<Range<usize>> {
    let [low, high] = span(corners, row as f64 + 0.5)?;
    let column = |x: f64| (x - 0.5).ceil().clamp(0.0, size as f64) as usize;
    let (from, to) = (column(low), column(high));
    Some(from..to.max(from))
}

/// Between which x the line at y is inside.
fn span(corners: &[DVec2; 3], y: f64) -> Option<[f64; 2]> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        if (a.y <= y) != (b.y <= y) {
            let x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
            low = low.min(x);
            high = high.max(x);
        }
    }
    (low < high).then_some([low, high])
}
