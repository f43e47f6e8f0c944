//! Points of a general quadric cut by a box: six sheets and the six sides of the box.
//!
//! A sheet belongs to a direction ±axis: the points where the gradient's largest coordinate is that one (of equal ones the
//! first axis counts). The parameters place a point in the box across the axis, for −axis with the two exchanged; along
//! the axis q = a·t² + 2b·t + c, and the gradient there is ±√(b² − ac) at its two roots, so t = (−b ± √(b² − ac))/a.

use super::{
    blocking::Place,
    number::{Binary, Surd, Vector, vector},
};

/// A quadric by its symmetric matrix (times two), and its box.
struct Quadric<'a> {
    form: [[Binary; 4]; 4],
    within: &'a [[f64; 3]; 2],
}

/// The piece and the point (u, v) of a face; `None` where that is no point of the surface.
pub(crate) fn point(
    matrix: &[[f64; 4]; 4],
    within: &[[f64; 3]; 2],
    face: usize,
    parameters: [f64; 2],
) -> Option<(usize, Place)> {
    let entry = |i: usize, j: usize| &Binary::new(matrix[i][j]) + &Binary::new(matrix[j][i]);
    let form = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
    let quadric = Quadric { form, within };
    if face < 6 {
        quadric.on_sheet(face / 2, face % 2 == 1, parameters).map(|x| (0, x))
    } else {
        let side = face - 6;
        quadric.on_side(side / 2, side % 2 == 1, parameters).map(|x| (1 + side, x))
    }
}

impl Quadric<'_> {
    /// The point of the box over (u, v), at the height zero along the axis.
    fn across(&self, axis: usize, positive: bool, [u, v]: [f64; 2]) -> Vector {
        let mut x = vector([0.0; 3]);
        let [first, second] = if positive { [u, v] } else { [v, u] };
        for (k, t) in [((axis + 1) % 3, first), ((axis + 2) % 3, second)] {
            let [low, high] = [0, 1].map(|end| Binary::new(self.within[end][k]));
            x[k] = &low + &(&Binary::new(t) * &(&high - &low));
        }
        x
    }

    fn on_side(&self, axis: usize, positive: bool, parameters: [f64; 2]) -> Option<Place> {
        let mut x = self.across(axis, positive, parameters);
        x[axis] = Binary::new(self.within[usize::from(positive)][axis]);
        let with_one = |k: usize| if k < 3 { x[k].clone() } else { Binary::new(1.0) };
        let terms = (0..16).map(|n| &(&self.form[n / 4][n % 4] * &with_one(n / 4)) * &with_one(n % 4));
        let value = terms.fold(Binary::zero(), |sum, term| &sum + &term);
        (value.sign() <= 0).then(|| Place::new(x))
    }

    fn on_sheet(&self, axis: usize, positive: bool, parameters: [f64; 2]) -> Option<Place> {
        let mut x = self.across(axis, positive, parameters);
        let at = |k: usize| if k < 3 { x[k].clone() } else { Binary::new(1.0) };
        let row = |i: usize| (0..4).fold(Binary::zero(), |sum, j| &sum + &(&self.form[i][j] * &at(j)));
        let (a, b) = (self.form[axis][axis].clone(), row(axis));
        let c = (0..4).fold(Binary::zero(), |sum, i| &sum + &(&row(i) * &at(i)));
        let radicand = &(&b * &b) - &(&a * &c);
        let wanted = if positive { 1 } else { -1 };
        let signed = |value: &Binary, sign: i8| if sign < 0 { -value } else { value.clone() };
        // The height is (p + q·√radicand)/weight.
        let (p, q, weight) = if a.sign() == 0 {
            (signed(&-&c, wanted), Binary::zero(), signed(&(&b + &b), wanted))
        } else {
            (signed(&-&b, a.sign()), Binary::new(f64::from(wanted * a.sign())), signed(&a, a.sign()))
        };
        if radicand.sign() <= 0 || weight.sign() <= 0 {
            return None;
        }
        x[axis] = Binary::zero();
        let mut place = Place::weighted(x.each_ref().map(|coordinate| coordinate * &weight), weight);
        (place.rational[axis], place.irrational[axis], place.radicand) = (p, q, radicand);
        (self.is_within(axis, &place) && self.is_steepest(axis, wanted, &place)).then_some(place)
    }

    fn is_within(&self, axis: usize, x: &Place) -> bool {
        let mut unit = [0.0; 3];
        unit[axis] = 1.0;
        let side = |end: usize| {
            let mut corner = [0.0; 3];
            corner[axis] = self.within[end][axis];
            x.side(&vector(unit), &vector(corner))
        };
        side(0) >= 0 && side(1) <= 0
    }

    /// Whether the gradient along ±axis is at least as large as any other, and larger than that along an earlier axis.
    fn is_steepest(&self, axis: usize, wanted: i8, x: &Place) -> bool {
        let gradient = |i: usize| {
            let part = |values: &Vector| (0..3).fold(Binary::zero(), |sum, j| &sum + &(&self.form[i][j] * &values[j]));
            let rational = &part(&x.rational) + &(&self.form[i][3] * &x.weight);
            Surd { rational, irrational: part(&x.irrational) }
        };
        let own = if wanted < 0 { -&gradient(axis) } else { gradient(axis) };
        [(axis + 1) % 3, (axis + 2) % 3].into_iter().all(|other| {
            let beside = gradient(other);
            let least = if other < axis { 1 } else { 0 };
            own.plus(&beside).sign(&x.radicand) >= least && own.plus(&-&beside).sign(&x.radicand) >= least
        })
    }
}
