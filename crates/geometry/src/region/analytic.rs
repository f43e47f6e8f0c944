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
    polytope::{Frame, Number, Problem, reaches_zero},
};
use crate::{
    aabb::Aabb,
    analytic::{Forms, Part, PlacedAnalytic, Surface, Trim},
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
        let stated = problem(self.forms(), part, cell);
        let exact = || problem(self.exact_forms(), part, cell);
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

/// The quadratic form of a part on the polytope that its planes cut out of a box.
fn problem<T: Number>(forms: &Forms<T>, part: &Part, cell: &Aabb) -> Problem<T> {
    let frame = frame(forms, cell);
    let mut form = std::array::from_fn(|_| std::array::from_fn(|_| T::exact(0.0)));
    let (mut cuts, mut flat) = (Vec::new(), None);
    match part.surface {
        Surface::Quadric(index) => form = frame.quadratic(&forms.quadrics()[index]),
        Surface::Plane(index) => flat = Some(frame.linear(&forms.planes()[index])),
    }
    for trim in &part.trims {
        match *trim {
            Trim::Inside(index) => form = frame.quadratic(&forms.quadrics()[index]),
            Trim::Above(index) => cuts.push(frame.linear(&forms.planes()[index])),
            Trim::Below(index) => cuts.push(frame.linear(&forms.planes()[index]).map(T::neg)),
        }
    }
    Problem::new(form, cuts, flat)
}

/// A box in local coordinates. Bodies are finite, so a box that reaches to infinity meets what the greatest finite one
/// meets.
fn frame<T: Number>(forms: &Forms<T>, cell: &Aabb) -> Frame<T> {
    let finite = |corner: DVec3| corner.clamp(DVec3::splat(f64::MIN), DVec3::splat(f64::MAX)).to_array().map(T::exact);
    let (min, max) = (finite(cell.min), finite(cell.max));
    let column = |axis: usize, size: T| {
        let [x, y, z] = forms.adjugate.each_ref().map(|row| row[axis].clone() * size.clone());
        [x, y, z, T::exact(0.0)]
    };
    let edges = std::array::from_fn(|axis| column(axis, max[axis].clone() - min[axis].clone()));
    Frame { corner: forms.pull_back(&min, &T::exact(1.0)), edges }
}

#[cfg(test)]
mod tests;
