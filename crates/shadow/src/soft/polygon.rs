//! Convex polygons in the plane of a light, and what is left of them when others are taken away.
//!
//! Cutting along a line is Sutherland and Hodgman's step ("Reentrant polygon clipping", CACM 17(1), 1974); taking a convex polygon
//! away leaves one convex piece an edge at most. The pieces never overlap, so areas add up. Rounded: a corner made by a cut is
//! off by few units of the last place, and so is the place of the line for each corner, which moves an area by no more than
//! that times the line's length: `ERROR_PER_CUT` of a window of edge 2, as NUMERICS.md says. Cost: O(corners) a cut.

use glam::DVec2;

/// What one cut may change about an area within the square −1..1 (NUMERICS.md, "Soft shadows").
pub(crate) const ERROR_PER_CUT: f64 = 128.0 * f64::EPSILON;

/// A convex polygon, counter-clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Polygon(pub(crate) Vec<DVec2>);

impl Polygon {
    /// The square −1..1.
    pub(crate) fn square() -> Self {
        Self::rectangle(DVec2::NEG_ONE, DVec2::ONE)
    }

    /// The rectangle between two corners.
    pub(crate) fn rectangle(low: DVec2, high: DVec2) -> Self {
        Self(vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)])
    }

    /// The area; negative for corners that run clockwise.
    pub(crate) fn area(&self) -> f64 {
        0.5 * self.edges().map(|[a, b]| a.perp_dot(b)).sum::<f64>()
    }

    /// The rectangle round a segment that holds all points within `reach` of it.
    pub(crate) fn round_segment([a, b]: [DVec2; 2], reach: f64) -> Self {
        let along = (b - a).normalize_or(DVec2::X) * reach;
        let across = along.perp();
        Self(vec![a - along - across, b + along - across, b + along + across, a - along + across])
    }

    /// How near the polygon, which is convex and counter-clockwise, comes to the origin.
    pub(crate) fn distance_to_origin(&self) -> f64 {
        let to_edge = |[a, b]: [DVec2; 2]| {
            let along = b - a;
            let share =
                if along == DVec2::ZERO { 0.0 } else { (-a.dot(along) / along.length_squared()).clamp(0.0, 1.0) };
            (a + along * share).length()
        };
        let is_inside = self.edges().all(|[a, b]| (b - a).perp_dot(-a) >= 0.0);
        if is_inside { 0.0 } else { self.edges().map(to_edge).fold(f64::INFINITY, f64::min) }
    }

    /// Whether nothing is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.len() < 3
    }

    /// The edges in order.
    pub(crate) fn edges(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let next = self.0.iter().cycle().skip(1);
        self.0.iter().zip(next).map(|(&a, &b)| [a, b])
    }

    /// The part where `value` is not negative; it must be affine.
    pub(crate) fn cut(&self, value: impl Fn(DVec2) -> f64) -> Self {
        let mut kept = Vec::with_capacity(self.0.len() + 1);
        for [a, b] in self.edges() {
            let (at_a, at_b) = (value(a), value(b));
            if at_a >= 0.0 {
                kept.push(a);
            }
            if (at_a > 0.0 && at_b < 0.0) || (at_a < 0.0 && at_b > 0.0) {
                kept.push(a + (b - a) * (at_a / (at_a - at_b)));
            }
        }
        Self(kept)
    }

    /// Whether the polygons' boxes have no inner point in common.
    fn is_apart(&self, other: &Self) -> bool {
        let ([low, high], [other_low, other_high]) = (self.bounds(), other.bounds());
        low.x >= other_high.x || other_low.x >= high.x || low.y >= other_high.y || other_low.y >= high.y
    }

    fn bounds(&self) -> [DVec2; 2] {
        self.0
            .iter()
            .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], &point| [low.min(point), high.max(point)])
    }
}

/// What is left of an area: convex pieces that do not overlap.
#[derive(Clone, Debug)]
pub(crate) struct Pieces {
    pub(crate) pieces: Vec<Polygon>,
    /// How many cuts were made; each may be off by [`ERROR_PER_CUT`].
    pub(crate) cuts: u64,
}

impl Pieces {
    /// All of a polygon.
    pub(crate) fn of(polygon: Polygon) -> Self {
        Self { pieces: vec![polygon], cuts: 0 }
    }

    /// Takes a convex polygon away; whether there was anything to take.
    pub(crate) fn subtract(&mut self, taken: &Polygon) -> bool {
        let mut has_met = false;
        let edges: Vec<[DVec2; 2]> = taken.edges().filter(|[a, b]| a != b).collect();
        let mut left = Vec::with_capacity(self.pieces.len() + edges.len());
        for piece in std::mem::take(&mut self.pieces) {
            if piece.is_apart(taken) {
                left.push(piece);
                continue;
            }
            let first = left.len();
            let mut inside = piece.clone();
            for &[a, b] in &edges {
                let side = |point: DVec2| (b - a).perp_dot(point - a);
                if inside.0.iter().all(|&point| side(point) >= 0.0) {
                    continue;
                }
                let outside = inside.cut(|point| -side(point));
                if !outside.is_empty() && outside.area() > 0.0 {
                    left.push(outside);
                }
                inside = inside.cut(side);
                self.cuts += 1;
                if inside.is_empty() || inside.area() <= 0.0 {
                    // Nothing in common: the piece stays whole.
                    left.truncate(first);
                    left.push(piece);
                    break;
                }
            }
            has_met |= !inside.is_empty() && inside.area() > 0.0;
        }
        self.pieces = left;
        has_met
    }

    /// Keeps what is inside a half plane.
    pub(crate) fn keep(&mut self, value: impl Fn(DVec2) -> f64) {
        self.cuts += self.pieces.len() as u64;
        let kept = self.pieces.iter().map(|piece| piece.cut(&value));
        self.pieces = kept.filter(|piece| !piece.is_empty() && piece.area() > 0.0).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(pieces: &Pieces) -> f64 {
        pieces.pieces.iter().map(Polygon::area).sum()
    }

    #[test]
    fn what_is_taken_is_gone_once() {
        let mut left = Pieces::of(Polygon::square());
        let taken = Polygon::rectangle(DVec2::new(-0.5, -0.5), DVec2::new(0.5, 2.0));
        left.subtract(&taken);
        assert_eq!(total(&left), 2.5);
        left.subtract(&taken);
        assert_eq!(total(&left), 2.5);
        left.subtract(&Polygon::rectangle(DVec2::new(0.0, 0.0), DVec2::new(1.0, 1.0)));
        assert_eq!(total(&left), 2.0);
        left.subtract(&Polygon::rectangle(DVec2::splat(-3.0), DVec2::splat(3.0)));
        assert!(left.pieces.is_empty());
    }

    #[test]
    fn a_polygon_beside_it_changes_nothing() {
        let mut left = Pieces::of(Polygon::square());
        // Its box meets the square, the triangle does not.
        left.subtract(&Polygon(vec![DVec2::new(3.0, 0.9), DVec2::new(3.0, 3.0), DVec2::new(0.9, 3.0)]));
        assert_eq!(left.pieces, [Polygon::square()]);
    }

    #[test]
    fn random_triangles_against_a_grid_of_points() {
        let mut dice = 7u64;
        let mut next = || {
            dice = dice.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (dice >> 11) as f64 / (1u64 << 52) as f64 * 1.5 - 1.5
        };
        for _ in 0..50 {
            let mut left = Pieces::of(Polygon::square());
            let mut taken = Vec::new();
            for _ in 0..6 {
                let mut triangle = Polygon((0..3).map(|_| DVec2::new(next(), next())).collect());
                if triangle.area() < 0.0 {
                    triangle.0.reverse();
                }
                left.subtract(&triangle);
                taken.push(triangle);
            }
            let holds = |polygon: &Polygon, p: DVec2| polygon.edges().all(|[a, b]| (b - a).perp_dot(p - a) >= 0.0);
            for k in 0..1000 {
                let p = DVec2::new((k % 40) as f64, (k / 40) as f64) * 0.049 - 0.97;
                let free = !taken.iter().any(|triangle| holds(triangle, p));
                assert_eq!(left.pieces.iter().any(|piece| holds(piece, p)), free, "{p}");
            }
        }
    }
}
