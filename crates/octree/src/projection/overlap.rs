//! Does a triangle meet a cube, and which of its children? By separating axes (Akenine-Möller, "Fast 3D triangle-box overlap testing", Journal of
//! Graphics Tools 6(1), 2001).
//!
//! In floating point, for cubes that the caller has widened by more than the roundings take: with coordinates of at most
//! 2 in size, a coordinate seen from the cube's middle is off by 2u, from a child's by 4u, and a product with a vector e by 12u·|e|, which moves the
//! triangle by less than 24u.

use glam::DVec3;

/// Which of the eight children of a cube round `middle` a triangle meets; bit k of a child's number is its side on axis k. The triangle meets the cube, and all cubes
/// reach beyond their borders by `slack`.
///
/// Most triangles are small, and told by their boxes: one that lies on one side of each middle plane meets the child where it meets the cube, and one
/// inside the cube that crosses a single middle plane has corners in two children. The others are tested.
pub(super) fn children(triangle: &[DVec3; 3], middle: DVec3, half: f64, slack: f64) -> u8 {
    let [a, b, c] = [triangle[0] - middle, triangle[1] - middle, triangle[2] - middle];
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let sides = [low.cmple(DVec3::splat(slack)).bitmask(), high.cmpge(DVec3::splat(-slack)).bitmask()];
    // By axis: the children on the lower and on the upper side.
    const HALVES: [[u8; 2]; 3] = [[0x55, 0xaa], [0x33, 0xcc], [0x0f, 0xf0]];
    let near = (0..3).fold(0xff, |children, axis| {
        let on = |side: usize| HALVES[axis][side] * (sides[side] >> axis & 1) as u8;
        children & (on(0) | on(1))
    });
    let crossed = (sides[0] & sides[1]).count_ones();
    let is_inside = || low.min_element() >= -(half + slack) && high.max_element() <= half + slack;
    if crossed == 0 || crossed == 1 && is_inside() {
        return near;
    }
    let (half, mut met) = (0.5 * half, 0);
    for child in (0..8u8).filter(|child| near >> child & 1 == 1) {
        let side = |axis: u8| if child >> axis & 1 == 1 { half } else { -half };
        let offset = DVec3::new(side(0), side(1), side(2));
        met |= u8::from(meets(&[a, b, c], offset, half + slack)) << child;
    }
    met
}

/// Whether the closed triangle meets the closed cube round `middle`. Touching counts, up to the roundings of the header.
pub(super) fn meets(triangle: &[DVec3; 3], middle: DVec3, half: f64) -> bool {
    let [a, b, c] = [triangle[0] - middle, triangle[1] - middle, triangle[2] - middle];
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    if low.max_element() > half || high.min_element() < -half {
        return false;
    }
    let edges = [b - a, c - b, a - c];
    let normal = edges[0].cross(edges[1]);
    if normal.dot(a).abs() > half * normal.abs().element_sum() {
        return false;
    }
    // The corner opposite an edge, and one of its own, span the triangle across an axis at a right angle to the edge.
    let pairs = [(edges[0], a, c), (edges[1], b, a), (edges[2], c, b)];
    !pairs.into_iter().any(|(edge, own, other)| is_apart(edge, own, other, half))
}

/// Whether one of the three axes edge × unit vector separates the cube from the triangle.
fn is_apart(edge: DVec3, own: DVec3, other: DVec3, half: f64) -> bool {
    (0..3).any(|axis| {
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let along = |p: DVec3| edge[j] * p[k] - edge[k] * p[j];
        let (first, second) = (along(own), along(other));
        let radius = half * (edge[j].abs() + edge[k].abs());
        first.min(second) > radius || first.max(second) < -radius
    })
}

#[cfg(test)]
mod tests {
    use super::{super::tests::Dice, *};

    #[test]
    fn a_triangle_meets_the_cubes_that_hold_a_point_of_it() {
        // A fixed sequence of triangles and points in them; the cube round a point is met however small it is.
        let mut dice = Dice(1);
        let mut next = || dice.unit();
        let mut apart = 0;
        for _ in 0..20_000 {
            let triangle: [DVec3; 3] = std::array::from_fn(|_| DVec3::new(next(), next(), next()));
            let (u, v) = (next(), next());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let point = triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0]);
            let half = next() * 0.1 + 64.0 * f64::EPSILON;
            let offset = DVec3::new(next(), next(), next()) * 2.0 - 1.0;
            assert!(meets(&triangle, point + offset * (half - 32.0 * f64::EPSILON), half), "{triangle:?} {point}");
            let elsewhere = DVec3::new(next(), next(), next());
            let beside = nearest(&triangle, elsewhere);
            // The nearest point is at most a step nearer, a cube's corner √3 halves from its middle.
            if (beside - elsewhere).length() > 1.75 * half + 1.8 / STEPS {
                apart += 1;
                assert!(!meets(&triangle, elsewhere, half), "{triangle:?}");
            }
        }
        assert!(apart > 5_000);
    }

    #[test]
    fn a_triangle_meets_the_children_that_it_meets() {
        // Against the test of each child by itself, which may differ within the roundings only: none lies so near here.
        let mut dice = Dice(7);
        let mut next = || dice.unit();
        let (middle, half, slack) = (DVec3::splat(0.5), 0.25, 1.0 / (1u64 << 40) as f64);
        let mut counts = [0; 9];
        for turn in 0..40_000 {
            let size = [1.0, 0.3, 0.05][turn % 3];
            let place = DVec3::new(next(), next(), next()) * (1.0 - size);
            let triangle: [DVec3; 3] = std::array::from_fn(|_| place + DVec3::new(next(), next(), next()) * size);
            if !meets(&triangle, middle, half + slack) {
                continue;
            }
            let met = children(&triangle, middle, half, slack);
            for child in 0..8u8 {
                let side = |axis: u8| if child >> axis & 1 == 1 { 0.125 } else { -0.125 };
                let is_met = meets(&triangle, middle + DVec3::new(side(0), side(1), side(2)), 0.125 + slack);
                assert_eq!(met >> child & 1 == 1, is_met, "{triangle:?}, child {child}");
            }
            counts[met.count_ones() as usize] += 1;
        }
        assert!(counts[0] == 0 && counts[1] > 1_000 && counts[2] > 1_000 && counts[4] > 500, "{counts:?}");
    }

    const STEPS: f64 = 40.0;

    /// The nearest of many points of the triangle, a step of its edges apart.
    fn nearest(triangle: &[DVec3; 3], point: DVec3) -> DVec3 {
        let [a, b, c] = *triangle;
        let steps = STEPS as u32;
        let places =
            (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| [f64::from(i) / STEPS, f64::from(j) / STEPS]));
        let points = places.map(|[u, v]| a + (b - a) * u + (c - a) * v);
        points.fold(a, |best, p| if (p - point).length() < (best - point).length() { p } else { best })
    }
}
