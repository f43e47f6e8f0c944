//! Placed analytic bodies as a region.
//!
//! A part of the surface is the zero set of a quadratic form cut by planes, or a piece of a plane where such a form is ≤ 0.
//! Pulled back to the body's coordinates, a box cut by planes is a convex polytope P. A form is continuous and P connected,
//! so the zero set meets P exactly when the form takes a value ≤ 0 on P and a value ≥ 0. The piece of a plane meets the
//! box exactly when the form takes a value ≤ 0 on what the plane cuts out of P. Both are questions about the least value of
//! a quadratic form on a polytope: see [`polytope`](super::polytope), which answers them exactly, whatever the placement.
//!
//! So touching counts as meeting, down to the last bit. A disk encloses nothing. Of a quadric the whole zero set in its
//! box is surface, sheets inside of the solid included (−x² ≤ 0 holds everywhere, and x = 0 is surface).
//!
//! About 1 µs for a box that is clearly off a part; tens of microseconds where its corners do not tell; up to some hundred
//! where the box touches to within rounding and exact numbers decide.

use glam::DVec3;

use super::{
    Region,
    polytope::{Frame, Polytope, Problem, Quadratic, reaches_zero},
};
use crate::{
    aabb::Aabb,
    analytic::{Forms, Part, PlacedAnalytic, Surface, Trim},
    decide::Decide,
    dyadic::Dyadic,
    point::Point,
    ring::Sign,
};

impl Region for PlacedAnalytic {
    fn bounds(&self) -> Aabb {
        Self::bounds(self)
    }

    fn parts(&self) -> u32 {
        // A quadric has most: its surface and the six sides of its box.
        Self::parts(self).len() as u32
    }

    fn meets(&self, part: u32, cell: &Aabb) -> bool {
        if cell.is_empty() {
            return false;
        }
        let part = &Self::parts(self)[part as usize];
        let frame = frame(self.forms(), cell);
        let polytope = polytope(self.forms(), part, &frame);
        if polytope.is_clearly_empty() {
            return false;
        }
        let stated = Problem { form: form(self.forms(), part, &frame), polytope };
        let exact = || exact_problem(self.exact_forms(), part, cell);
        reaches_zero(&stated, exact)
            && match part.surface {
                Surface::Quadric(_) => reaches_zero(&stated.negated(), || exact().negated()),
                Surface::Plane(_) => true,
            }
    }

    fn encloses(&self, point: DVec3) -> bool {
        point.is_finite() && self.side(&Point::exact(point), false) == Sign::Negative
    }
}

fn exact_problem(forms: &Forms<Dyadic>, part: &Part, cell: &Aabb) -> Problem<Dyadic> {
    let frame = frame(forms, cell);
    Problem { form: form(forms, part, &frame), polytope: polytope(forms, part, &frame) }
}

/// What the planes of a part cut out of a box.
fn polytope<T: Decide>(forms: &Forms<T>, part: &Part, frame: &Frame<T>) -> Polytope<T> {
    let plane = |index: usize| frame.linear(&forms.planes()[index]);
    let cuts = part.trims.iter().filter_map(|trim| match *trim {
        Trim::Inside(_) => None,
        Trim::Above(index) => Some(plane(index)),
        Trim::Below(index) => Some(plane(index).map(T::neg)),
    });
    let flat = match part.surface {
        Surface::Quadric(_) => None,
        Surface::Plane(index) => Some(plane(index)),
    };
    Polytope::new(cuts, flat)
}

/// The one quadratic form that makes or trims a part; zero if there is none, so that nothing is cut off.
fn form<T: Decide>(forms: &Forms<T>, part: &Part, frame: &Frame<T>) -> Quadratic<T> {
    let trimming = || {
        part.trims.iter().find_map(|trim| match *trim {
            Trim::Inside(index) => Some(index),
            Trim::Above(_) | Trim::Below(_) => None,
        })
    };
    let quadric = match part.surface {
        Surface::Quadric(index) => Some(index),
        Surface::Plane(_) => trimming(),
    };
    let zero = || std::array::from_fn(|_| std::array::from_fn(|_| T::number(0.0)));
    quadric.map_or_else(zero, |index| frame.quadratic(&forms.quadrics()[index]))
}

/// A box in local coordinates. Bodies are finite, so a box that reaches to infinity meets what the greatest finite one
/// meets.
fn frame<T: Decide>(forms: &Forms<T>, cell: &Aabb) -> Frame<T> {
    let finite = |corner: DVec3| corner.clamp(DVec3::splat(f64::MIN), DVec3::splat(f64::MAX));
    let (min, max) = (finite(cell.min), finite(cell.max));
    let column = |axis: usize, size: T| {
        let [x, y, z] = forms.adjugate.each_ref().map(|row| row[axis].clone() * size.clone());
        [x, y, z, T::number(0.0)]
    };
    let edges = std::array::from_fn(|axis| column(axis, T::number(max[axis]) - T::number(min[axis])));
    Frame { corner: forms.pull_back_position(min), edges }
}

#[cfg(test)]
mod tests;
