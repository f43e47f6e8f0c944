//! Caps of the unit sphere: how much of one another one covers.
//!
//! A round light, and a ball in front of it, are caps of directions as seen from a point. Two caps of radii p and q whose
//! centres are θ apart have in common two sectors less the kite between the centres and the crossings of their rims, which is
//! twice the spherical triangle with the sides p, q and θ. Its angles come from the half-angle formulas and its area from
//! L'Huilier's theorem (Todhunter, "Spherical Trigonometry", 1886, §§45 and 102): no step takes the difference of two
//! nearly equal numbers but the last one, so small caps, like the Sun's, keep their digits. Cost: some fifteen elementary functions.

use std::f64::consts::PI;

use glam::DVec3;
use libm::{asin, atan, atan2, sin, sqrt, tan};

/// A cap of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cap {
    /// Towards its middle; any length but zero.
    pub(crate) towards: DVec3,
    /// Radians, above 0 and at most π/2.
    pub(crate) radius: f64,
}

impl Cap {
    /// The directions from which a ball fills the sky; `None` from inside it and from its surface.
    pub(crate) fn of_ball(towards: DVec3, radius: f64) -> Option<Self> {
        let distance = towards.length();
        (distance > radius).then(|| Self { towards, radius: asin(radius / distance) })
    }

    /// The angle between the middles.
    pub(crate) fn distance(&self, other: &Self) -> f64 {
        angle(self.towards, other.towards)
    }

    /// Steradians.
    pub(crate) fn solid_angle(&self) -> f64 {
        cap_area(self.radius)
    }

    /// The share of this cap that the other one covers.
    pub(crate) fn share_covered_by(&self, other: &Self) -> f64 {
        (common_area(self.radius, other.radius, self.distance(other)) / self.solid_angle()).clamp(0.0, 1.0)
    }
}

/// The angle between two vectors, 0 to π, with its digits when it is small.
pub(crate) fn angle(a: DVec3, b: DVec3) -> f64 {
    // Scaled to one length each, so that no product leaves the range of floats.
    let (a, b) = (a.normalize(), b.normalize());
    atan2(a.cross(b).length(), a.dot(b))
}

/// The area of a cap on the unit sphere: 2π(1 − cos r), without the difference.
pub(crate) fn cap_area(radius: f64) -> f64 {
    let half = sin(0.5 * radius);
    4.0 * PI * half * half
}

/// The area that two caps of these radii have in common, their middles `distance` apart; radians and steradians.
pub(crate) fn common_area(first: f64, second: f64, distance: f64) -> f64 {
    if distance >= first + second {
        return 0.0;
    }
    if distance <= (first - second).abs() {
        return cap_area(first.min(second));
    }
    if first + second + distance >= 2.0 * PI {
        // Together they fill the sphere: what they have in common is what neither leaves out.
        return cap_area(first) + cap_area(second) - 4.0 * PI;
    }
    let half = 0.5 * (first + second + distance);
    let rest = [half - first, half - second, half - distance].map(|side| side.max(0.0));
    let sines = rest.map(sin);
    // Half the angles at the two middles: tan²(A/2) = sin(s − b) sin(s − c) / (sin s sin(s − a)).
    let whole = sin(half);
    let at_first = atan2(sqrt(sines[0] * sines[2]), sqrt(whole * sines[1]));
    let at_second = atan2(sqrt(sines[1] * sines[2]), sqrt(whole * sines[0]));
    let tangents = tan(0.5 * half) * tan(0.5 * rest[0]) * tan(0.5 * rest[1]) * tan(0.5 * rest[2]);
    let triangle = 4.0 * atan(sqrt(tangents.max(0.0)));
    // A sector of the full angle 2A is the share 2A/2π of its cap.
    let sectors = (2.0 * at_first * cap_area(first) + 2.0 * at_second * cap_area(second)) / PI;
    (sectors - 2.0 * triangle).clamp(0.0, cap_area(first.min(second)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The common area by rings about the middle of the first cap: each is covered over an angle with a closed form.
    fn by_rings(first: f64, second: f64, distance: f64) -> f64 {
        const RINGS: usize = 200_000;
        let step = first / RINGS as f64;
        let ring = |k: usize| {
            let r = (k as f64 + 0.5) * step;
            let cosine = (second.cos() - r.cos() * distance.cos()) / (r.sin() * distance.sin());
            2.0 * cosine.clamp(-1.0, 1.0).acos() * r.sin() * step
        };
        (0..RINGS).map(ring).sum()
    }

    #[test]
    fn the_common_area_is_what_rings_sum_to() {
        for (first, second, distance) in [
            (0.3, 0.2, 0.25),
            (0.3, 0.5, 0.45),
            (0.1, 1.5, 1.45),
            (0.004, 0.0045, 0.006),
            (1.2, 0.9, 0.5),
            (0.7, 0.7, 0.01),
        ] {
            let (exact, summed) = (common_area(first, second, distance), by_rings(first, second, distance));
            assert!((exact - summed).abs() < 1e-7 * summed, "{first} {second} {distance}: {exact} {summed}");
            let swapped = common_area(second, first, distance);
            assert!((exact - swapped).abs() <= 1e-14 * cap_area(first.max(second)), "{exact} {swapped}");
        }
    }

    #[test]
    fn small_caps_are_disks_in_a_plane() {
        // Two disks of radius r, their middles r apart, have (2π/3 − √3/2) r² in common.
        for radius in [1e-3, 1e-5, 1e-7] {
            let common = common_area(radius, radius, radius) / (radius * radius);
            assert!((common - (2.0 * PI / 3.0 - 0.75f64.sqrt())).abs() < 2.0 * radius * radius + 1e-13, "{radius}");
        }
    }

    #[test]
    fn the_ends_meet() {
        assert_eq!(common_area(0.2, 0.3, 0.5), 0.0);
        assert_eq!(common_area(0.2, 0.3, 0.1 - 1e-12), cap_area(0.2));
        assert!(common_area(0.2, 0.3, 0.5 - 1e-9) < 1e-12);
        assert!((common_area(0.2, 0.3, 0.1 + 1e-9) - cap_area(0.2)).abs() < 1e-12);
        // A half sky: what lies above the horizon of a cap on it is half of it.
        assert!((common_area(0.2, 0.5 * PI, 0.5 * PI) - 0.5 * cap_area(0.2)).abs() < 1e-15);
    }
}
