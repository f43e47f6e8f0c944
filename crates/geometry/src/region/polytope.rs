//! Does a quadratic form take a value ≤ 0 on a cube cut by planes? Exact.
//!
//! P is the set of all points of the unit cube on the positive sides of some planes, or of one plane (a *flat*) alone: a
//! compact convex polytope. The form takes a value ≤ 0 on P exactly when its least value on P is one, and that is taken at
//! one of finitely many points. For each set of at most three of the planes that bound P, the point to try is where the
//! form is stationary on the set's intersection; it counts if it is the only one, lies in P, and the form is ≤ 0 there.
//!
//! This is enough. Of the faces of P on which the least value is taken, let F be one of least dimension, taken at x. Then x
//! is in the relative interior of F, so x is stationary on the affine hull of F. Were x + d stationary there too, d ≠ 0, so
//! would be all points of the line through both, and the form would be constant on it; but the line leaves F through a face
//! of smaller dimension, where the value would be taken again. So x is the only stationary point. The hull of F is the
//! intersection of at most three of the planes with independent normals, and that set is tried. Hence sets whose linear
//! system is singular can be skipped.
//!
//! A system has three rows, linear forms that vanish at the point: the planes of the set, and the derivatives of the form
//! along directions that span their intersection. Cramer's rule solves it in homogeneous coordinates without division, so
//! one code serves numbers that know their error, which decide nearly all sets, and exact numbers for the rest. Before all
//! that, Bernstein coefficients and the ranges of the planes over the cube tell the clear cases.
//!
//! Degree 11 in the entries of the form and the planes. A cube without cuts has 27 sets, each further plane that may cut
//! it adds about 20.

use std::ops::Neg;

use crate::{
    analytic::{LocalPoint, QuadricForm},
    approx::{Approx, UNIT_ROUNDOFF},
    decide::Decide,
    decisions::{Level, count, decide},
    dyadic::Dyadic,
    ring::{Sign, determinant},
};

/// Factors of u₁, u₂, u₃ and a constant.
pub(crate) type Linear<T> = [T; 4];

/// A symmetric form in (u₁, u₂, u₃, 1), by rows.
pub(crate) type Quadratic<T> = [[T; 4]; 4];

/// A box in the local coordinates of a body: all points corner + u₁·edge₁ + u₂·edge₂ + u₃·edge₃, u in the unit cube.
pub(crate) struct Frame<T> {
    /// The point with u = 0.
    pub(crate) corner: LocalPoint<T>,
    /// Directions, of weight 0.
    pub(crate) edges: [LocalPoint<T>; 3],
}

impl<T: Decide> Frame<T> {
    fn columns(&self) -> [&LocalPoint<T>; 4] {
        [&self.edges[0], &self.edges[1], &self.edges[2], &self.corner]
    }

    /// A body's form as a form in u.
    pub(crate) fn quadratic(&self, form: &QuadricForm<T>) -> Quadratic<T> {
        let columns = self.columns();
        let mut matrix: Quadratic<T> = std::array::from_fn(|_| std::array::from_fn(|_| T::number(0.0)));
        for j in 0..4 {
            for i in 0..=j {
                let entry = form.value(columns[i], columns[j]);
                matrix[j][i] = entry.clone();
                matrix[i][j] = entry;
            }
        }
        matrix
    }

    /// A plane's form as a form in u.
    pub(crate) fn linear(&self, plane: &[T; 4]) -> Linear<T> {
        self.columns().map(|column| value_at(plane, column))
    }
}

/// The unit cube, cut by planes.
#[derive(Clone)]
pub(crate) struct Polytope<T> {
    /// The sides of the cube, then the planes that cut it; all are ≥ 0 on the polytope.
    planes: Vec<Linear<T>>,
    /// The plane that the polytope lies in.
    flat: Option<Linear<T>>,
}

impl<T: Decide> Polytope<T> {
    /// Where all `cuts` are ≥ 0 and `flat`, if given, is zero.
    pub(crate) fn new(cuts: impl IntoIterator<Item = Linear<T>>, flat: Option<Linear<T>>) -> Self {
        let side = |axis: usize, factor: f64, constant: f64| {
            let mut side = [0.0, 0.0, 0.0, constant];
            side[axis] = factor;
            side.map(T::number)
        };
        let low = (0..3).map(|axis| side(axis, 1.0, 0.0));
        let high = (0..3).map(|axis| side(axis, -1.0, 1.0));
        Self { planes: low.chain(high).chain(cuts).collect(), flat }
    }
}

impl Polytope<Approx> {
    /// Whether no point is left, for sure.
    pub(crate) fn is_clearly_empty(&self) -> bool {
        let is_below = |plane: &Linear<Approx>| greatest(plane).sign() == Some(Sign::Negative);
        let is_missed = |flat: &Linear<Approx>| is_below(flat) || is_below(&flat.map(Neg::neg));
        self.planes[6..].iter().any(is_below) || self.flat.iter().any(is_missed)
    }

    /// The planes that may cut: the sides of the cube and those that are not surely ≥ 0 on it.
    fn live(&self) -> PlaneSet {
        let may_cut =
            |plane: &Linear<Approx>| greatest(&plane.map(Neg::neg)).sign().is_none_or(|s| s == Sign::Positive);
        let cuts = (6..self.planes.len()).filter(|&index| may_cut(&self.planes[index]));
        cuts.fold(0b111_111, |set, index| set | 1 << index)
    }
}

/// A form on a polytope.
#[derive(Clone)]
pub(crate) struct Problem<T> {
    pub(crate) form: Quadratic<T>,
    pub(crate) polytope: Polytope<T>,
}

/// Numbers of planes, as bits.
type PlaneSet = u32;

impl<T: Decide> Problem<T> {
    /// The form with the other sign on the same polytope.
    pub(crate) fn negated(self) -> Self {
        Self { form: self.form.map(|row| row.map(T::neg)), ..self }
    }

    /// Whether the point that belongs to the planes in `set` lies in the polytope and the form is ≤ 0 there; only the planes
    /// in `live` can cut.
    fn holds_at(&self, set: PlaneSet, live: PlaneSet) -> Option<bool> {
        let rows = self.rows(set)?;
        let spatial = rows.each_ref().map(|row| std::array::from_fn(|k| row[k].clone()));
        let weight = determinant(&spatial);
        let turned = match weight.decide()? {
            Sign::Zero => return Some(false),
            sign => move |number: T| if sign == Sign::Negative { -number } else { number },
        };
        let coordinate = |axis: usize| {
            let mut replaced = spatial.clone();
            (0..3).for_each(|row| replaced[row][axis] = -rows[row][3].clone());
            determinant(&replaced)
        };
        let point = [coordinate(0), coordinate(1), coordinate(2), weight].map(turned);
        let planes = &self.polytope.planes;
        let others = (0..planes.len()).filter(|index| (live & !set) >> index & 1 == 1);
        let heights = others.map(|index| value_at(&planes[index], &point));
        let depth = std::iter::once_with(|| -value_at(&self.form.each_ref().map(|row| value_at(row, &point)), &point));
        all_non_negative(heights.chain(depth))
    }

    /// Three linear forms that vanish where the form is stationary on the common points of the planes in `set`.
    fn rows(&self, set: PlaneSet) -> Option<[Linear<T>; 3]> {
        let Polytope { planes, flat } = &self.polytope;
        let in_set = (0..planes.len()).filter(|index| set >> index & 1 == 1).map(|index| &planes[index]);
        let planes: Vec<&Linear<T>> = flat.iter().chain(in_set).collect();
        let along = |direction: &[T; 3]| {
            let term = |i: usize, j: usize| direction[i].clone() * self.form[i][j].clone();
            std::array::from_fn(|j| term(0, j) + term(1, j) + term(2, j))
        };
        Some(match planes.as_slice() {
            [] => std::array::from_fn(|axis| self.form[axis].clone()),
            &[plane] => {
                let [s, t] = tangents(plane)?;
                [plane.clone(), along(&s), along(&t)]
            }
            &[a, b] => [a.clone(), b.clone(), along(&cross(a, b))],
            &[a, b, c, ..] => [a.clone(), b.clone(), c.clone()],
        })
    }
}

/// Whether the form is positive on the whole cube, for sure: all its Bernstein coefficients of degree 2 in each variable
/// are, and its values are means of them.
///
/// A coefficient sums at most ten terms, which are entries times 0, ½, 1 or 2: nine roundings, each at most u times the sum
/// of all magnitudes, and halves that underflow. The entries' own errors enter with the same factors.
fn is_clearly_positive(form: &Quadratic<Approx>) -> bool {
    let total = |part: fn(&Approx) -> f64| form.iter().flatten().map(part).sum::<f64>();
    let slack = total(|entry| entry.error) + total(|entry| entry.value.abs()) * BERNSTEIN_SLACK + f64::MIN_POSITIVE;
    let slack = slack * (1.0 + 32.0 * UNIT_ROUNDOFF);
    let a = form.map(|row| row.map(|entry| entry.value));
    (0..27).all(|number| {
        // Of u the coefficients are 0, ½, 1; of u² they are 0, 0, 1.
        let index = [number % 3, number / 3 % 3, number / 9].map(f64::from);
        let linear = |k: usize| index[k] * a[k][3];
        let square = |k: usize| if index[k] == 2.0 { a[k][k] } else { 0.0 };
        let mixed = |j: usize, k: usize| 0.5 * index[j] * index[k] * a[j][k];
        let linear = linear(0) + linear(1) + linear(2);
        let squares = square(0) + square(1) + square(2);
        a[3][3] + linear + squares + (mixed(0, 1) + mixed(0, 2) + mixed(1, 2)) > slack
    })
}

/// Nine roundings (at most ten with that of the sum of magnitudes), doubled for their products.
const BERNSTEIN_SLACK: f64 = 20.0 * UNIT_ROUNDOFF;

/// Whether the form takes a value ≤ 0 on the polytope. Exact; `exact` states the same problem in exact numbers, and is
/// asked only where `approx` leaves a doubt.
pub(crate) fn reaches_zero(approx: &Problem<Approx>, exact: impl FnOnce() -> Problem<Dyadic>) -> bool {
    if approx.polytope.is_clearly_empty() || is_clearly_positive(&approx.form) {
        count(Level::Double, 1);
        return false;
    }
    let live = approx.polytope.live();
    let mut doubtful = Vec::new();
    decide(reaches_zero_filter(approx, live, &mut doubtful), || {
        let exact = exact();
        doubtful.into_iter().any(|set| exact.holds_at(set, live) == Some(true))
    })
}

/// [`reaches_zero`] by trying all sets, where floats can tell; else the sets that are left, in `doubtful`.
fn reaches_zero_filter(approx: &Problem<Approx>, live: PlaneSet, doubtful: &mut Vec<PlaneSet>) -> Option<bool> {
    let free = if approx.polytope.flat.is_some() { 2 } else { 3 };
    for size in (0..=free).rev() {
        for set in sets(approx.polytope.planes.len(), live, size) {
            match approx.holds_at(set, live) {
                Some(true) => return Some(true),
                Some(false) => {}
                None => doubtful.push(set),
            }
        }
    }
    doubtful.is_empty().then_some(false)
}

/// All sets of `size` planes out of those in `live`, without opposite sides of the cube.
fn sets(planes: usize, live: PlaneSet, size: u32) -> impl Iterator<Item = PlaneSet> {
    (0..1 << planes)
        .filter(move |&set: &PlaneSet| set & !live == 0 && set.count_ones() == size && set & (set >> 3) & 0b111 == 0)
}

/// Whether all numbers are ≥ 0; unknown only if none is known to be negative.
fn all_non_negative<T: Decide>(numbers: impl Iterator<Item = T>) -> Option<bool> {
    let mut is_known = true;
    for number in numbers {
        match number.decide() {
            Some(Sign::Negative) => return Some(false),
            Some(_) => {}
            None => is_known = false,
        }
    }
    is_known.then_some(true)
}

fn value_at<T: Decide>(form: &[T; 4], x: &[T; 4]) -> T {
    let term = |k: usize| form[k].clone() * x[k].clone();
    term(0) + term(1) + term(2) + term(3)
}

/// The greatest value over the unit cube. A factor that may have either sign counts with its error whichever is chosen.
fn greatest(form: &Linear<Approx>) -> Approx {
    form[..3].iter().fold(form[3], |sum, factor| sum + Approx { value: factor.value.max(0.0), error: factor.error })
}

/// Two directions that span the plane; none if its normal is zero, which makes the system singular.
fn tangents<T: Decide>(plane: &Linear<T>) -> Option<[[T; 3]; 2]> {
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        if plane[axis].decide()? != Sign::Zero {
            let direction = |other: usize| {
                let mut direction = [0.0; 3].map(T::number);
                direction[axis] = plane[other].clone();
                direction[other] = -plane[axis].clone();
                direction
            };
            return Some([direction(next), direction(last)]);
        }
    }
    Some([[0.0; 3]; 2].map(|direction| direction.map(T::number)))
}

fn cross<T: Decide>(a: &Linear<T>, b: &Linear<T>) -> [T; 3] {
    let minor = |i: usize, j: usize| a[i].clone() * b[j].clone() - a[j].clone() * b[i].clone();
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

#[cfg(test)]
mod tests;
