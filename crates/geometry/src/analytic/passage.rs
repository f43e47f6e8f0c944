//! Whether a surface passes a small box, and how it lies there: what filters can say of all points of a box at once.
//!
//! Guarantee: by the mean value theorem a form changes, from the middle of a box to its boundary, by at most the sum of its half edges times
//! the derivatives' magnitudes over the box, and along the diagonal nearest to the gradient by at least the same sum where no
//! derivative changes its sign (NUMERICS.md, section 4). A value in the middle below the one and above the other settles it. Cost: a microsecond.

use glam::DVec3;

use super::{
    PlacedAnalytic,
    layout::{Part, Surface},
    placed::{facing_value, outward_value, trims_hold},
};
use crate::{
    approx::Approx,
    light::LightSource,
    point::{ExactPoint, Point},
    ring::Sign,
};

impl PlacedAnalytic {
    /// Whether floats tell that a surface, trims left aside, is nowhere in a box: the point and its slack.
    pub fn certainly_misses(&self, surface: Surface, whole: &Point) -> bool {
        let x = self.forms().pull_back_point(whole);
        self.forms().surface(surface, &x).sign().is_some_and(|sign| sign != Sign::Zero)
    }

    /// Whether a part of the surface meets a box, a float position and its slack, as far as pairs of floats tell. If so it
    /// meets the half diagonals along [`PlacedAnalytic::diagonal`].
    pub fn passes(&self, part: &Part, whole: &Point) -> Option<bool> {
        let forms = self.forms_in_pairs();
        let middle = ExactPoint::from_position(whole.position);
        let middle = forms.pull_back(&middle.xyz, &middle.w);
        let gradient = self.outward_in(part.surface, whole);
        // Of a quadric that is half its derivative, of a plane minus it.
        let factor = if let Surface::Quadric(_) = part.surface { 2.0 } else { 1.0 };
        let value = forms.surface(part.surface, &middle).rational().to_approx();
        let change = |k: usize| {
            let slope = Approx { value: gradient[k].value.abs(), ..gradient[k] };
            slope * Approx::exact(factor * whole.slack[k])
        };
        let reach = change(0) + change(1) + change(2);
        let value = Approx { value: value.value.abs(), ..value };
        if value.lower() > reach.upper() {
            return Some(false);
        }
        let holds = trims_hold(self.forms(), part, &self.forms().pull_back_point(whole)) == Some(true);
        (holds && value.upper() <= reach.lower()).then_some(true)
    }

    /// The half diagonal of a box along which a surface's form grows most.
    pub fn diagonal(&self, surface: Surface, whole: &Point) -> DVec3 {
        let gradient = self.outward_in(surface, whole);
        DVec3::from_array(std::array::from_fn(|k| whole.slack[k].copysign(gradient[k].value)))
    }

    /// [`PlacedAnalytic::outward`] for all points of a box.
    pub fn outward_in(&self, surface: Surface, whole: &Point) -> [Approx; 3] {
        outward_value(self.forms(), surface, &self.forms().pull_back_point(whole))
    }

    /// [`PlacedAnalytic::facing`] for all points of a box, if floats tell.
    pub fn facing_in(&self, surface: Surface, whole: &Point, light: &LightSource) -> Option<Sign> {
        let forms = self.forms();
        facing_value(forms, surface, &forms.pull_back_point(whole), &forms.pull_back_light(light)).sign()
    }
}
