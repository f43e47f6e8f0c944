//! The nearest of many points: a k-d tree without pointers (Bentley 1975). The middle of a slice, by the axis of its depth, is its root.
//!
//! O(n log n) to build, about O(log n) a question. Distances are rounded.

use glam::DVec3;

/// Points, each slice's middle between those below and those above it.
#[derive(Clone, Debug, Default)]
pub(super) struct NearestPoint(Vec<DVec3>);

impl NearestPoint {
    pub(super) fn new(mut points: Vec<DVec3>) -> Self {
        arrange(&mut points, 0);
        Self(points)
    }

    /// How far the nearest point is; `None` without points.
    pub(super) fn distance(&self, from: DVec3) -> Option<f64> {
        let mut best = f64::INFINITY;
        search(&self.0, 0, from, &mut best);
        best.is_finite().then(|| best.sqrt())
    }
}

fn arrange(points: &mut [DVec3], axis: usize) {
    if points.len() < 2 {
        return;
    }
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
    let (below, above) = points.split_at_mut(middle);
    arrange(below, (axis + 1) % 3);
    arrange(&mut above[1..], (axis + 1) % 3);
}

fn search(points: &[DVec3], axis: usize, from: DVec3, best: &mut f64) {
    let middle = points.len() / 2;
    let Some(root) = points.get(middle) else { return };
    *best = best.min(root.distance_squared(from));
    let offset = from[axis] - root[axis];
    let (below, above) = (&points[..middle], &points[middle + 1..]);
    let (near, far) = if offset < 0.0 { (below, above) } else { (above, below) };
    search(near, (axis + 1) % 3, from, best);
    if offset * offset < *best {
        search(far, (axis + 1) % 3, from, best);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_found() {
        let number = |seed: u64| (seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64 / 16_777_216.0;
        let point = |k: u64| DVec3::new(number(3 * k + 1), number(3 * k + 2), number(3 * k + 3));
        let points: Vec<DVec3> = (0..500).map(point).collect();
        let tree = NearestPoint::new(points.clone());
        for from in (500..700).map(point) {
            let nearest = points.iter().map(|point| point.distance(from)).fold(f64::INFINITY, f64::min);
            assert_eq!(tree.distance(from), Some(nearest));
        }
        assert_eq!(NearestPoint::default().distance(DVec3::ZERO), None);
    }
}
