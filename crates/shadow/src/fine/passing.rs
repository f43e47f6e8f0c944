//! Whether a way to the light probably runs through a piece of a body, by the values of the piece's forms at the way's ends.
//!
//! Where the proofs of a single point end in doubt: bodies that are not convex around a light on their surface, surfaces without thickness. A point of the way is (1 − t)·x + t·L, homogeneous;
//! the planes leave an interval of t, and the quadric is least over it at an end or between them. Guarantee: none, it is for estimates.

/// How far a form may be above zero by rounding, as a share of its terms.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Of q(x, x), q(x, L), q(L, L), each plane's values at x and L, and those of the plane that a flat piece lies in.
pub(super) fn passes(
    [at_point, mixed, at_light]: [f64; 3],
    planes: impl Iterator<Item = [f64; 2]>,
    flat: Option<[f64; 2]>,
) -> bool {
    let crossing = |[point, light]: [f64; 2]| point / (point - light);
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for plane in planes {
        match plane {
            [point, light] if point.min(light) < 0.0 && point.max(light) <= 0.0 => return false,
            [point, _] if point < 0.0 => low = low.max(crossing(plane)),
            [_, light] if light < 0.0 => high = high.min(crossing(plane)),
            _ => {}
        }
    }
    let is_met = |t: f64| {
        let terms = [(1.0 - t) * (1.0 - t) * at_point, 2.0 * t * (1.0 - t) * mixed, t * t * at_light];
        let is_between = 0.0 < t && t < 1.0 && low <= t && t <= high;
        is_between && terms.iter().sum::<f64>() <= ROUNDING * terms.iter().map(|term| term.abs()).sum::<f64>()
    };
    match flat {
        Some(plane) => is_met(crossing(plane)),
        None => [low, high, (at_point - mixed) / (at_point - 2.0 * mixed + at_light)].into_iter().any(is_met),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the ball of radius 1 about the origin, cut at y ≥ `cut`, or of all that is outside of it; homogeneous points and lights.
    fn is_met(sign: f64, cut: f64, point: [f64; 4], light: [f64; 4]) -> bool {
        let form = |a: [f64; 4], b: [f64; 4]| sign * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2] - a[3] * b[3]);
        let plane = |a: [f64; 4]| a[1] - cut * a[3];
        let quadric = [form(point, point), form(point, light), form(light, light)];
        passes(quadric, [[plane(point), plane(light)]].into_iter(), None)
    }

    #[test]
    fn ways_past_and_through_a_ball() {
        let (below, aside, sun) = ([0.0, -3.0, 0.0, 1.0], [1.5, -3.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]);
        let top = [0.0, 1.0, 0.0, 1.0];
        assert!(is_met(1.0, -9.0, below, sun) && !is_met(1.0, -9.0, aside, sun));
        assert!(is_met(1.0, -9.0, below, top), "through the ball to a lamp on it");
        assert!(!is_met(1.0, -9.0, [0.0, 3.0, 0.0, 1.0], top), "from above");
        assert!(!is_met(1.0, 2.0, below, sun), "all of it is cut away");
        assert!(is_met(-1.0, -2.0, below, top), "through what is outside of it, above the cut");
        assert!(!is_met(-1.0, 0.9, [0.0, 0.0, 0.0, 1.0], top), "from its middle to its border");
    }

    #[test]
    fn ways_through_what_has_no_thickness() {
        // y² ≤ 0, from below and beside to a sun above.
        let way = |box_plane: [f64; 2]| passes([9.0, 0.0 - 3.0, 1.0], [box_plane].into_iter(), None);
        assert!(way([1.0, 0.0]) && !way([-1.0, 0.0]));
        // A disk, hit and missed.
        assert!(passes([-0.5, 0.0, 0.0], std::iter::empty(), Some([-3.0, 1.0])));
        assert!(!passes([0.5, 0.0, 0.0], std::iter::empty(), Some([-3.0, 1.0])));
        assert!(!passes([-0.5, 0.0, 0.0], std::iter::empty(), Some([3.0, 1.0])), "behind it");
    }
}
