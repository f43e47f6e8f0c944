//! Triangles of bodies that several tests use: corners, and their numbers, outward.

/// The triangles of a box with the corners of [`box_corners`].
pub(crate) const BOX: [[u32; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

/// The corners of a box, x fastest.
pub(crate) fn box_corners(low: [f64; 3], size: f64) -> Vec<[f64; 3]> {
    (0..8).map(|k| [0, 1, 2].map(|axis| low[axis] + size * f64::from(k >> axis & 1))).collect()
}

/// Two pyramids over a star with `count` corners that goes round `turns` times; every other corner is as far from the middle as `dent`
/// says, the others 1.
pub(crate) fn bipyramid(count: u32, turns: u32, dent: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut positions = vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    positions.extend((0..count).map(|k| {
        let angle = std::f64::consts::TAU * f64::from(k * turns) / f64::from(count);
        let radius = if k % 2 == 0 { 1.0 } else { dent };
        [radius * libm::cos(angle), radius * libm::sin(angle), 0.0]
    }));
    let sides = (0..count).map(|k| [2 + k, 2 + (k + 1) % count]);
    (positions, sides.flat_map(|[a, b]| [[a, b, 0], [b, a, 1]]).collect())
}
