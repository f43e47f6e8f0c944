//! The quadratic and linear forms of a placed body, evaluated at pulled-back points.
//!
//! A world point x with weight w is pulled back to (adj(M)·(x − w·t), w·det M): homogeneous local coordinates, exact in
//! the ring of the inputs, without division. A form there has the sign of the local one. All forms are in units of the
//! body's own size (a power of two), so that values near the body are near one.

use std::ops::{Add, Mul, Neg, Sub};

use glam::DVec3;

use super::layout::Surface;
use crate::{
    approx::Approx,
    decide::Decide,
    dyadic::Dyadic,
    light::LightSource,
    number::MIN_MAGNITUDE,
    point::Point,
    ring::{Ring, Sign},
};

/// Homogeneous local coordinates: x, y, z in units of the body's size, and a weight.
pub type LocalPoint<T> = [T; 4];

/// A symmetric form by its squares and its mixed terms; most bodies have few of these.
#[derive(Clone, Debug)]
pub struct QuadricForm<T> {
    /// Factors of x², y², z², w².
    squares: [T; 4],
    /// (i, j, half the factor of x_i·x_j), i < j.
    mixed: Vec<(usize, usize, T)>,
}

impl<T: Clone + Add<Output = T> + Mul<Output = T>> QuadricForm<T> {
    /// The form with these factors of squares and half factors of mixed terms.
    pub(crate) fn new(squares: [T; 4], mixed: Vec<(usize, usize, T)>) -> Self {
        Self { squares, mixed }
    }

    /// q(x, y): q(x, x) is negative inside, zero on the surface, positive outside.
    pub fn value(&self, x: &LocalPoint<T>, y: &LocalPoint<T>) -> T {
        let square = |k: usize| self.squares[k].clone() * (x[k].clone() * y[k].clone());
        let squares = square(0) + square(1) + square(2) + square(3);
        self.mixed.iter().fold(squares, |sum, (i, j, factor)| {
            sum + factor.clone() * (x[*i].clone() * y[*j].clone() + x[*j].clone() * y[*i].clone())
        })
    }

    /// All factors.
    pub(crate) fn factors(&self) -> impl Iterator<Item = &T> {
        self.squares.iter().chain(self.mixed.iter().map(|(_, _, factor)| factor))
    }

    /// The same form over other numbers.
    pub(crate) fn map<U>(&self, convert: impl Fn(&T) -> U) -> QuadricForm<U> {
        QuadricForm {
            squares: std::array::from_fn(|k| convert(&self.squares[k])),
            mixed: self.mixed.iter().map(|(i, j, factor)| (*i, *j, convert(factor))).collect(),
        }
    }

    /// Row k of the form's matrix: half the derivative along x_k is this row times x.
    pub(crate) fn row(&self, k: usize) -> [T; 4]
    where
        T: Default,
    {
        let entry = |l: usize| {
            let mixed = self.mixed.iter().find(|(i, j, _)| (*i, *j) == (k.min(l), k.max(l)));
            mixed.map_or_else(T::default, |(_, _, factor)| factor.clone())
        };
        std::array::from_fn(|l| if k == l { self.squares[k].clone() } else { entry(l) })
    }

    /// Half the gradient at x with respect to local coordinates.
    pub(crate) fn half_gradient(&self, x: &LocalPoint<T>) -> [T; 3] {
        let [along_x, along_y, along_z, _] = self.polar(x);
        [along_x, along_y, along_z]
    }

    /// The linear form y ↦ q(x, y) ([`linear_value`]): where many points y come to one x, cheaper than [`QuadricForm::value`].
    pub fn polar(&self, x: &LocalPoint<T>) -> [T; 4] {
        let square = |k: usize| self.squares[k].clone() * x[k].clone();
        let mut row = [square(0), square(1), square(2), square(3)];
        for (i, j, factor) in &self.mixed {
            row[*i] = row[*i].clone() + factor.clone() * x[*j].clone();
            row[*j] = row[*j].clone() + factor.clone() * x[*i].clone();
        }
        row
    }
}

impl QuadricForm<Dyadic> {
    /// The other factor of a form that is the product of two linear ones, times a positive number; `None` if the given one is none of them. With
    /// Q = (ℓ·mᵀ + m·ℓᵀ)/2 and ℓₖ not zero, ℓₖ²·m is 2·ℓₖ·Qₖ − Qₖₖ·ℓ.
    pub(crate) fn cofactor(&self, plane: &[Dyadic; 4]) -> Option<[Dyadic; 4]> {
        let k = plane.iter().position(|factor| factor.sign() != Sign::Zero)?;
        let (pivot, row) = (&plane[k], self.row(k));
        let cofactor: [Dyadic; 4] = std::array::from_fn(|j| {
            let twice = row[j].clone() + row[j].clone();
            twice * pivot.clone() - row[k].clone() * plane[j].clone()
        });
        let is_product = (0..4).all(|i| {
            let row = self.row(i);
            (i..4).all(|j| {
                let twice = row[j].clone() + row[j].clone();
                let product = plane[i].clone() * cofactor[j].clone() + cofactor[i].clone() * plane[j].clone();
                (twice * pivot.clone() * pivot.clone() - product).sign() == Sign::Zero
            })
        });
        is_product.then_some(cofactor)
    }

    /// Whether q(x, x) is negative at no x, by elimination without division: with a pivot p > 0, p·q is the square of a linear form and a form of
    /// the coordinates that are left; where the pivot is zero, nothing may stand beside it.
    pub(crate) fn is_nowhere_negative(&self) -> bool {
        let mut rows: [[Dyadic; 4]; 4] = std::array::from_fn(|k| self.row(k));
        (0..4).all(|k| {
            let pivots = rows[k].clone();
            if pivots[k].sign() != Sign::Positive {
                return pivots[k..].iter().all(|entry| entry.sign() == Sign::Zero);
            }
            for i in k + 1..4 {
                for j in k + 1..4 {
                    rows[i][j] = rows[i][j].clone() * pivots[k].clone() - pivots[i].clone() * pivots[j].clone();
                }
            }
            true
        })
    }
}

/// A linear form, by its coefficients, at a point.
pub fn linear_value<T>(row: &[T; 4], x: &LocalPoint<T>) -> T
where
    T: Clone + Add<Output = T> + Mul<Output = T>,
{
    let term = |k: usize| row[k].clone() * x[k].clone();
    term(0) + term(1) + term(2) + term(3)
}

/// Whether a linear form is known to have one sign, and not to be zero, over all of the hull of some points.
pub fn is_nowhere_zero(row: &[Approx; 4], corners: &[LocalPoint<Approx>]) -> bool {
    let mut signs = corners.iter().map(|x| linear_value(row, x).sign());
    let first = signs.next().flatten();
    matches!(first, Some(Sign::Positive | Sign::Negative)) && signs.all(|sign| sign == first)
}

/// All forms of a placed body over the numbers `T`.
#[derive(Clone, Debug)]
pub struct Forms<T> {
    /// adj(M) by rows, times the sign of det M.
    pub(crate) adjugate: [[T; 3]; 3],
    pub(crate) translation: [T; 3],
    /// |det M| times the unit of length.
    pub(crate) weight: T,
    /// Negative inside.
    pub(crate) quadrics: Vec<QuadricForm<T>>,
    /// Positive inside.
    pub(crate) planes: Vec<[T; 4]>,
}

impl<T> Forms<T>
where
    T: Clone + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + Neg<Output = T>,
{
    /// The local coordinates of a homogeneous world point; the world's axes may change places without changing a bit.
    pub fn pull_back(&self, xyz: &[T; 3], w: &T) -> LocalPoint<T>
    where
        T: Decide,
    {
        let way = std::array::from_fn(|i| xyz[i].clone() - w.clone() * self.translation[i].clone());
        let [x, y, z] = self.turn_back(&way);
        [x, y, z, self.weight.clone() * w.clone()]
    }

    /// [`Forms::pull_back`] of a position: what it and the translation have in common is taken away first, so that nothing is lost far
    /// from the origin.
    pub fn pull_back_position(&self, position: DVec3) -> LocalPoint<T>
    where
        T: Decide,
    {
        let way = std::array::from_fn(|i| T::number(position[i]) - self.translation[i].clone());
        let [x, y, z] = self.turn_back(&way);
        [x, y, z, self.weight.clone()]
    }

    /// [`Forms::pull_back`] of a direction.
    pub fn pull_back_direction(&self, direction: &[T; 3]) -> LocalPoint<T>
    where
        T: Decide,
    {
        let [x, y, z] = self.turn_back(direction);
        [x, y, z, T::number(0.0)]
    }

    fn turn_back(&self, way: &[T; 3]) -> [T; 3]
    where
        T: Decide,
    {
        // Written out: arrays made by closures are not inlined, and take half the time of a curved body.
        let row = |[a, b, c]: &[T; 3]| {
            let [x, y, z] = way;
            T::sum_of_three([a.clone() * x.clone(), b.clone() * y.clone(), c.clone() * z.clone()])
        };
        let [x, y, z] = &self.adjugate;
        [row(x), row(y), row(z)]
    }

    /// The quadrics, negative inside.
    pub fn quadrics(&self) -> &[QuadricForm<T>] {
        &self.quadrics
    }

    /// The planes' coefficients, positive inside.
    pub fn planes(&self) -> &[[T; 4]] {
        &self.planes
    }

    /// The value of plane `index` at a point.
    pub fn plane(&self, index: usize, x: &LocalPoint<T>) -> T {
        linear_value(&self.planes[index], x)
    }

    /// The value of quadric `index` at a pair of points.
    pub fn quadric(&self, index: usize, x: &LocalPoint<T>, y: &LocalPoint<T>) -> T {
        self.quadrics[index].value(x, y)
    }

    /// The value of a surface's form at a point: zero on the surface, whatever cuts it.
    pub fn surface(&self, surface: Surface, x: &LocalPoint<T>) -> T {
        match surface {
            Surface::Quadric(index) => self.quadric(index, x, x),
            Surface::Plane(index) => self.plane(index, x),
        }
    }

    /// The same forms over other numbers.
    pub(crate) fn map<U>(&self, convert: impl Fn(&T) -> U) -> Forms<U>
    where
        U: Clone,
    {
        Forms {
            adjugate: std::array::from_fn(|i| std::array::from_fn(|j| convert(&self.adjugate[i][j]))),
            translation: std::array::from_fn(|k| convert(&self.translation[k])),
            weight: convert(&self.weight),
            quadrics: self.quadrics.iter().map(|form| form.map(&convert)).collect(),
            planes: self.planes.iter().map(|h| std::array::from_fn(|k| convert(&h[k]))).collect(),
        }
    }
}

/// Entries that are this small beside the greatest one make terms below the normal range of floats.
const TINY: f64 = MIN_MAGNITUDE * MIN_MAGNITUDE * MIN_MAGNITUDE;

impl Forms<Approx> {
    /// Whether terms of a quadric fall below the normal range of floats, where arithmetic takes many times as long: bodies of extreme proportions.
    pub fn underflow(&self) -> bool {
        let size = |entry: &Approx| entry.value.abs() + entry.error;
        let underflows = |form: &QuadricForm<Approx>| {
            let sizes = || form.squares.iter().chain(form.mixed.iter().map(|(_, _, entry)| entry)).map(size);
            let greatest = sizes().fold(0.0, f64::max);
            sizes().any(|size| size > 0.0 && size < TINY * greatest)
        };
        self.quadrics.iter().any(underflows)
    }

    /// [`Forms::pull_back`] of a point with its bounds; what its position leaves out counts.
    pub fn pull_back_point(&self, x: &Point) -> LocalPoint<Approx> {
        let translation = self.translation.map(|coordinate| coordinate.value);
        let [x, y, z] = self.turn_back(&x.minus(&Point::exact(translation.into())));
        [x, y, z, self.weight]
    }

    /// [`Forms::pull_back`] of a light.
    pub fn pull_back_light(&self, light: &LightSource) -> LocalPoint<Approx> {
        if light.is_sun() {
            self.pull_back_direction(&light.xyz().to_array().map(Approx::exact))
        } else {
            self.pull_back_position(light.xyz())
        }
    }
}

impl Forms<Dyadic> {
    /// The same forms over a larger ring.
    pub fn lifted<R: Ring>(&self) -> Forms<R> {
        self.map(|number| R::from(number.clone()))
    }
}
