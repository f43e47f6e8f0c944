//! Where a ray crosses the surface of a placed body first, decided by signs.
//!
//! The ray o + t·d, t > 0, is pulled back and put into the forms of each part of the surface; what is left are polynomials in t of
//! degree two. Their roots are kept as (p + q·√e)/f and compared with each other without being computed, so one code serves the
//! filter ([`crate::Approx`]) and exact numbers. A part in whose surface the ray runs is seen edge-on, as a plane is by a ray
//! within it, and is not crossed. O(parts²) signs, and a body has at most seven parts.

use super::{
    forms::Forms,
    layout::Surface,
    placed::{PlacedAnalytic, Segment},
    polynomial::{Polynomial, Root, all_known},
};
use crate::{decide::Decide, dyadic::Dyadic, ring::Sign};
use glam::DVec3;

/// A point of a body's surface on a ray.
#[derive(Clone, Debug)]
pub struct Crossing<T> {
    /// The surface that is crossed there.
    pub surface: Surface,
    /// How far along the ray, in lengths of its direction.
    pub distance: Root<T>,
}

impl PlacedAnalytic {
    /// The first crossing strictly ahead of `origin`, world coordinates; `Some(None)` where there is none, `None` where signs
    /// are not known. Of parts that are crossed at the same point the first one is named.
    pub fn first_crossing<T: Decide>(
        &self,
        forms: &Forms<T>,
        origin: DVec3,
        direction: DVec3,
    ) -> Option<Option<Crossing<T>>> {
        let ray = Segment {
            start: forms.pull_back_position(origin),
            along: forms.pull_back_direction(&direction.to_array().map(T::number)),
        };
        let mut first: Option<Crossing<T>> = None;
        for part in self.parts() {
            let surface = ray.along_surface(forms, part.surface);
            if surface.vanishes()? {
                continue;
            }
            let trims: Vec<Polynomial<T>> = part.trims.iter().map(|&trim| ray.along_trim(forms, trim)).collect();
            for root in surface.roots()? {
                if !is_ahead_and_in(&root, &trims)? {
                    continue;
                }
                let is_first = match &first {
                    Some(other) => root.sign_of_difference(&other.distance)? == Sign::Negative,
                    None => true,
                };
                if is_first {
                    first = Some(Crossing { surface: part.surface, distance: root });
                }
            }
        }
        Some(first)
    }

    /// [`PlacedAnalytic::first_crossing`] with exact numbers.
    pub fn first_exact_crossing(&self, origin: DVec3, direction: DVec3) -> Option<Crossing<Dyadic>> {
        // Exact signs are always known.
        self.first_crossing(self.exact_forms(), origin, direction).flatten()
    }
}

/// Whether a root lies strictly ahead, where all trims hold.
fn is_ahead_and_in<T: Decide>(root: &Root<T>, trims: &[Polynomial<T>]) -> Option<bool> {
    let ahead = std::iter::once_with(|| Some(root.sign()? == Sign::Positive));
    all_known(ahead.chain(trims.iter().map(|trim| Some(trim.sign_at(root)? != Sign::Negative))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Analytic, Approx, Placement};
    use proptest::prelude::*;

    fn distance(body: &PlacedAnalytic, origin: DVec3, direction: DVec3) -> Option<f64> {
        let exact = body.first_exact_crossing(origin, direction);
        if let Some(known) = body.first_crossing::<Approx>(body.forms(), origin, direction) {
            assert_eq!(known.is_some(), exact.is_some(), "the filter errs");
        }
        exact.map(|crossing| crossing.distance.rounded(|number| number.to_nearest()))
    }

    #[test]
    fn touching_counts_and_running_in_the_surface_does_not() {
        let place = |body| PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
        let ball = place(Analytic::Sphere { radius: 1.0 });
        assert_eq!(distance(&ball, DVec3::new(1.0, 0.0, 5.0), DVec3::NEG_Z), Some(5.0), "a tangent");
        assert_eq!(distance(&ball, DVec3::new(1.0_f64.next_up(), 0.0, 5.0), DVec3::NEG_Z), None);
        assert_eq!(distance(&ball, DVec3::ZERO, DVec3::new(0.0, 2.0, 0.0)), Some(0.5), "from inside");
        let post = place(Analytic::Cylinder { radius: 1.0, height: 2.0 });
        // Along a line of the side: seen is the top's rim.
        assert_eq!(distance(&post, DVec3::new(1.0, 5.0, 0.0), DVec3::NEG_Y), Some(4.0));
    }

    proptest! {
        #[test]
        fn crossings_are_where_floats_say(o in proptest::array::uniform3(-4.0..4.0f64), d in proptest::array::uniform3(-1.0..1.0f64)) {
            let (origin, direction) = (DVec3::from_array(o), DVec3::from_array(d));
            prop_assume!(direction.length() > 0.1);
            for body in [
                Analytic::Ellipsoid { radii: [1.0, 2.0, 0.5] },
                Analytic::Cone { radius: 1.0, height: 2.0 },
                Analytic::Capsule { radius: 0.5, height: 1.0 },
                Analytic::Hyperboloid { waist_radius: 0.5, end_radius: 1.0, height: 2.0 },
            ] {
                let body = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
                let found = distance(&body, origin, direction);
                let rounded = body.nearest_local_hit(origin, direction).map(|hit| hit.distance);
                // A ray that grazes may be hit or missed by rounding; none of these does within the tolerance of the floats.
                if let (Some(found), Some(rounded)) = (found, rounded) {
                    prop_assert!((found - rounded).abs() <= 1e-6 * (1.0 + rounded), "{found} {rounded}");
                } else {
                    prop_assert_eq!(found.is_some(), rounded.is_some());
                }
            }
        }
    }
}
