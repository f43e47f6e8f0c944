//! Patches of a general quadric cut by a box: sheets over rectangles of two coordinates, and the sides of the box.
//!
//! A sheet takes the part of the surface where the gradient's largest coordinate is one of six: ±x, ±y, ±z. There the third
//! coordinate t is a function of the two others with slopes of at most one, the root of a·t² + 2·b·t + c where a·t + b has the
//! wanted sign. Where the gradient is, and whether the point is in the box, are signs of linear forms. A cell of the
//! rectangle may hold surface all over, nowhere, or in a part, which lies between straight lines.

use std::ops::{Add, Mul};

use glam::DVec3;

use super::{
    chart::{CellHull, HULL, Occupied, PADDING},
    forms::{LocalPoint, QuadricForm, is_nowhere_zero, linear_value},
    jet::Jet,
    polynomial::all_known,
};
use crate::{
    approx::Approx,
    decide::Decide,
    dyadic::Dyadic,
    ring::{Ring, Sign},
    surd::Surd,
};

mod slab;
mod slopes;

use slab::{Heights, Root};
use slopes::{Slope, slopes};

/// Homogeneous local coordinates, metres: (x, y, z)/weight, the weight positive.
pub(crate) type HomogeneousPoint<T> = ([Surd<T>; 3], T);

/// A patch of a quadric cut by a box.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    /// The form, in metres.
    exact: QuadricForm<Dyadic>,
    form: QuadricForm<Approx>,
    /// b² − a·c as a form of the two coordinates across.
    discriminant: QuadricForm<Approx>,
    slopes: [Slope<Approx>; 4],
    /// Where the form is a product of two linear ones, and a slope, or a bound of the box along the axis, is one of them: the other.
    beside_slopes: [Option<[Approx; 4]>; 4],
    beside_bounds: [Option<[Approx; 4]>; 2],
    within: [[f64; 3]; 2],
    /// The axis that t runs along, and the axes of u and v.
    axis: usize,
    across: [usize; 2],
    /// Whether the surface looks along +axis.
    is_positive: bool,
    /// A side of the box, where q ≤ 0, instead of a sheet of the surface.
    pub(crate) is_side: bool,
    /// A side all of which is in the surface, so that the sheets have it.
    is_of_sheets: bool,
}

impl Graph {
    /// How many a quadric has.
    pub(crate) const COUNT: usize = 12;

    /// The six sheets and the six sides.
    pub(crate) fn all(exact: &QuadricForm<Dyadic>, within: &[[f64; 3]; 2]) -> Vec<Self> {
        let form = exact.map(Dyadic::to_approx);
        let beside = |row: &[Dyadic; 4]| Some(exact.cofactor(row)?.map(|factor| factor.to_approx()));
        let patch = |index: usize, is_side: bool| {
            let (axis, is_positive) = (index / 2, index % 2 == 1);
            let across = [(axis + 1) % 3, (axis + 2) % 3];
            let across = if is_positive { across } else { [across[1], across[0]] };
            let discriminant = discriminant(exact, axis).map(Dyadic::to_approx);
            let slopes = slopes(exact, axis, across, is_positive);
            let beside_bounds = within.map(|corner| beside(&above(axis, corner[axis])));
            Self {
                exact: exact.clone(),
                form: form.clone(),
                discriminant,
                // Of the points of a side no gradient is asked.
                beside_slopes: std::array::from_fn(|k| if is_side { None } else { beside(&slopes[k].row) }),
                is_of_sheets: is_side && beside_bounds[usize::from(is_positive)].is_some(),
                beside_bounds,
                slopes: slopes.map(|slope| slope.to_approx()),
                within: *within,
                axis,
                across,
                is_positive,
                is_side,
            }
        };
        (0..6).map(|index| patch(index, false)).chain((0..6).map(|index| patch(index, true))).collect()
    }

    fn sign(&self) -> f64 {
        if self.is_positive { 1.0 } else { -1.0 }
    }

    /// The box's extent along an axis.
    fn extent(&self, axis: usize) -> f64 {
        self.within[1][axis] - self.within[0][axis]
    }

    fn side(&self) -> f64 {
        self.within[usize::from(self.is_positive)][self.axis]
    }

    /// The greatest coordinate in the box.
    pub(crate) fn size(&self) -> f64 {
        self.within.iter().flatten().fold(0.0, |size: f64, coordinate| size.max(coordinate.abs()))
    }

    pub(crate) fn steps(&self) -> [f64; 2] {
        // Slopes are at most one: |(s, t, s + t)|² ≤ 3·(s² + t²).
        let stretch = if self.is_side { 1.0 } else { 3f64.sqrt() };
        self.across.map(|axis| stretch * self.extent(axis))
    }

    /// Three corners of a side.
    pub(crate) fn plane_points(&self) -> Option<[DVec3; 3]> {
        let corner = |u, v| self.beside(u, v, self.side());
        self.is_side.then(|| [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)])
    }

    /// The local point over (u, v) at a height.
    fn beside(&self, u: f64, v: f64, height: f64) -> DVec3 {
        let mut point = DVec3::ZERO;
        for (k, t) in [u, v].into_iter().enumerate() {
            let [low, high] = self.within.map(|corner| corner[self.across[k]]);
            point[self.across[k]] = low * (1.0 - t) + high * t;
        }
        point[self.axis] = height;
        point
    }

    /// The point over (u, v), rounded; where there is none, something near.
    pub(crate) fn point(&self, u: f64, v: f64) -> DVec3 {
        if self.is_side {
            return self.beside(u, v, self.side());
        }
        let x = self.beside(u, v, 0.0);
        let [a, b, c] = self.coefficients(&[x.x, x.y, x.z, 1.0].map(Approx::exact)).map(|number| number.value);
        let root = self.sign() * (b * b - a * c).max(0.0).sqrt();
        let height = if b * root >= 0.0 { -c / (b + root) } else { (root - b) / a };
        let [low, high] = self.within.map(|corner| corner[self.axis]);
        self.beside(u, v, if height.is_finite() { height.clamp(low, high) } else { low })
    }

    /// a, b, c of the form as a·t² + 2·b·t + c over a point with t = 0.
    fn coefficients(&self, base: &LocalPoint<Approx>) -> [Approx; 3] {
        coefficients(&self.form, self.axis, base)
    }

    /// The local point over (u, v) and its weight; `Some(None)` where there is no surface, `None` where that is not known.
    pub(crate) fn local_point<T>(
        &self,
        u: f64,
        v: f64,
        of: impl Fn(&Dyadic) -> T,
    ) -> Option<Option<HomogeneousPoint<T>>>
    where
        T: Decide + Default,
        Surd<T>: Decide,
    {
        let (number, form) = (T::number, self.exact.map(of));
        let mut base = [0.0, 0.0, 0.0, 1.0].map(number);
        for (k, t) in [u, v].into_iter().enumerate() {
            let [low, high] = self.within.map(|corner| number(corner[self.across[k]]));
            base[self.across[k]] = low.clone() + number(t) * (high - low);
        }
        if self.is_side {
            base[self.axis] = number(self.side());
            let is_inside = !self.is_of_sheets && form.value(&base, &base).decide()? != Sign::Positive;
            let [x, y, z, _] = base.map(Surd::plain);
            return Some(is_inside.then(|| ([x, y, z], number(1.0))));
        }
        let [a, b, c] = coefficients(&form, self.axis, &base);
        let Some((height, weight)) = self.exact_height(a, b, c)? else { return Some(None) };
        let mut local: [Surd<T>; 3] = std::array::from_fn(|k| Surd::plain(base[k].clone() * weight.clone()));
        local[self.axis] = height;
        Some(self.holds(&form, &local, &weight)?.then_some((local, weight)))
    }

    /// The root where a·t + b has the wanted sign, over its positive weight; `Some(None)` where there is none, `None` where that is not
    /// known.
    fn exact_height<T: Decide>(&self, a: T, b: T, c: T) -> Option<Option<(Surd<T>, T)>> {
        let wanted = if self.is_positive { Sign::Positive } else { Sign::Negative };
        let turned = |value: T, sign: Sign| if sign == Sign::Negative { -value } else { value };
        Some(match a.decide()? {
            Sign::Zero => {
                let weight = turned(b.clone() + b.clone(), wanted);
                (b.decide()? == wanted).then(|| (Surd::plain(turned(-c, wanted)), weight))
            }
            sign => {
                let discriminant = b.clone() * b.clone() - a.clone() * c;
                let is_there = discriminant.decide()? == Sign::Positive;
                let root = |factor: Sign| Surd::root(turned(T::number(1.0), factor), discriminant.clone());
                is_there.then(|| (Surd::plain(turned(-b, sign)) + root(wanted.times(sign)), turned(a, sign)))
            }
        })
    }

    /// Whether a point of the surface belongs to this sheet: in the box, and of the largest gradients along this axis.
    fn holds<T>(&self, form: &QuadricForm<T>, local: &[Surd<T>; 3], weight: &T) -> Option<bool>
    where
        T: Decide,
        Surd<T>: Decide,
    {
        let [low, high] = self.within.map(|corner| Surd::plain(T::number(corner[self.axis]) * weight.clone()));
        let height = || local[self.axis].clone();
        if (height() - low).decide()? == Sign::Negative || (high - height()).decide()? == Sign::Negative {
            return Some(false);
        }
        let [x, y, z] = local.clone();
        let x = [x, y, z, Surd::plain(weight.clone())];
        let form = form.map(|factor| Surd::plain(factor.clone()));
        all_known(slopes(&form, self.axis, self.across, self.is_positive).iter().map(|slope| {
            let sign = linear_value(&slope.row, &x).decide()?;
            Some(sign == Sign::Positive || sign == Sign::Zero && !slope.is_strict)
        }))
    }

    /// Eight points whose hull holds all surface over a cell.
    pub(crate) fn hull(&self, at: [f64; 2], edge: f64) -> CellHull {
        let heights = if self.is_side {
            Heights { middle: self.side(), slope: [0.0; 2], reach: 0.0 }
        } else {
            self.heights(at, edge, &self.root(at, edge))
        };
        CellHull { points: self.corners(at, edge, &heights), slack: DVec3::splat(self.size() * PADDING) }
    }

    /// The corners of a slab over a cell; the lower ones first.
    fn corners(&self, at: [f64; 2], edge: f64, heights: &Heights) -> [DVec3; HULL] {
        std::array::from_fn(|k| {
            let [u, v] = [at[0] + edge * f64::from(k as u8 & 1), at[1] + edge * f64::from(k as u8 >> 1 & 1)];
            let away = [u - at[0] - 0.5 * edge, v - at[1] - 0.5 * edge];
            let middle = heights.middle + heights.slope[0] * away[0] + heights.slope[1] * away[1];
            self.beside(u, v, if k < 4 { middle - heights.reach } else { middle + heights.reach })
        })
    }

    /// The root over a cell.
    fn root(&self, at: [f64; 2], edge: f64) -> Root {
        let [a, b, c] = self.coefficients(&self.cell_box(at, edge, Approx::exact(0.0)));
        let discriminant = self.discriminant_over(at, edge);
        let steep = self.steep(discriminant);
        let heights = match (b.sign(), a.sign()) {
            (Some(sign), _) if sign == Sign::of(self.sign()) => (-c).divided_by(b + steep),
            (_, Some(Sign::Positive | Sign::Negative)) => (steep - b).divided_by(a),
            _ => Approx::UNKNOWN,
        };
        // Where the equation is linear, b is the gradient. A double root has none.
        let is_turned_away = a.sign() == Some(Sign::Zero) && b.sign() == Some(Sign::of(-self.sign()));
        Root { heights, discriminant, is_nowhere: is_turned_away || discriminant.upper() <= 0.0 }
    }

    /// The form's half derivative along the axis on the surface, where b² − a·c is this: ±√D.
    fn steep(&self, discriminant: Approx) -> Approx {
        discriminant.square_root() * Approx::exact(self.sign())
    }

    /// The range of the discriminant over a cell: a quadratic form stays within its values at pairs of corners.
    fn discriminant_over(&self, at: [f64; 2], edge: f64) -> Approx {
        let corner = |[s, t]: [f64; 2]| self.cell_box([at[0] + s * edge, at[1] + t * edge], 0.0, Approx::exact(0.0));
        if edge == 0.0 {
            let x = corner([0.0, 0.0]);
            return self.discriminant.value(&x, &x);
        }
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(corner);
        let (mut range, mut is_known) = ([f64::INFINITY, f64::NEG_INFINITY], true);
        for (k, x) in corners.iter().enumerate() {
            for y in &corners[k..] {
                let value = self.discriminant.value(x, y);
                range = [range[0].min(value.lower()), range[1].max(value.upper())];
                is_known &= value.error.is_finite();
            }
        }
        if !is_known {
            return Approx::UNKNOWN;
        }
        if range[0] == range[1] {
            return Approx::exact(range[0]); // as where it vanishes
        }
        let middle = 0.5 * (range[0] + range[1]);
        Approx { value: middle, error: (range[1] - middle).max(middle - range[0]).next_up() }
    }

    /// All points over a cell with heights in an interval.
    fn cell_box(&self, at: [f64; 2], edge: f64, height: Approx) -> LocalPoint<Approx> {
        let mut cell = [Approx::exact(1.0); 4];
        for k in 0..2 {
            let [low, high] = self.within.map(|corner| Approx::exact(corner[self.across[k]]));
            let t = Approx { value: at[k] + 0.5 * edge, error: 0.5 * edge };
            cell[self.across[k]] = low + (high - low) * t;
        }
        cell[self.axis] = height;
        cell
    }

    /// The local normal, scaled so that its part along the axis is the area of the box across it, as far as the surface goes.
    pub(crate) fn normal<const K: usize>(&self, u: Jet<K>, v: Jet<K>) -> [Jet<K>; 3] {
        let number = |value: Approx| Jet::<K>::constant(value);
        let bound = |corner: usize, axis: usize| Approx::exact(self.within[corner][axis]);
        let rectangle = self.across.map(|axis| bound(1, axis) - bound(0, axis));
        let area = number(rectangle[0] * rectangle[1]);
        let mut normal = [number(Approx::exact(0.0)); 3];
        normal[self.axis] = area;
        if self.is_side {
            return normal;
        }
        let mut x = [
            number(Approx::exact(0.0)),
            number(Approx::exact(0.0)),
            number(Approx::exact(0.0)),
            number(Approx::exact(1.0)),
        ];
        for (k, t) in [u, v].into_iter().enumerate() {
            x[self.across[k]] = number(bound(0, self.across[k])) + t.scaled(rectangle[k]);
        }
        let form = self.form.map(|&factor| number(factor));
        let [a, b, c] = coefficients(&form, self.axis, &x);
        let discriminant = self.discriminant.map(|&factor| number(factor)).value(&x, &x);
        let steep = discriminant.square_root().scaled(Approx::exact(self.sign()));
        // a·t + b = ±√D, so t = (±√D − b)/a; without dividing by a where it may vanish: −c/(b ± √D).
        let is_stable = (b.0[0].value * self.sign()) >= 0.0;
        let zero = number(Approx::exact(0.0));
        x[self.axis] = if is_stable { (zero - c).divided_by(b + steep) } else { (steep - b).divided_by(a) };
        for axis in self.across {
            normal[axis] = (linear_value(&form.row(axis), &x) * area).divided_by(steep);
        }
        normal
    }

    /// The range of [`Graph::normal`] over a cell, as far as there is surface.
    pub(crate) fn normal_over(&self, at: [f64; 2], edge: f64) -> [Approx; 3] {
        let bound = |corner: usize, axis: usize| Approx::exact(self.within[corner][axis]);
        let [width, height] = self.across.map(|axis| bound(1, axis) - bound(0, axis));
        let mut normal = [Approx::exact(0.0); 3];
        normal[self.axis] = width * height;
        if !self.is_side {
            let root = self.root(at, edge);
            let x = self.cell_box(at, edge, self.heights(at, edge, &root).over(edge));
            for axis in self.across {
                let along = linear_value(&self.form.row(axis), &x) * normal[self.axis];
                normal[axis] = along.divided_by(self.steep(root.discriminant));
            }
        }
        normal
    }

    /// What no coordinate of [`Graph::normal`] exceeds, on the surface: the one along the axis is the largest.
    pub(crate) fn greatest_normal(&self) -> [f64; 3] {
        let area = self.extent(self.across[0]) * self.extent(self.across[1]) * (1.0 + 4.0 * f64::EPSILON);
        std::array::from_fn(|axis| if self.is_side && axis != self.axis { 0.0 } else { area })
    }

    /// How much of a cell is surface.
    pub(crate) fn occupied(&self, at: [f64; 2], edge: f64) -> Occupied {
        if self.is_of_sheets {
            return Occupied::Nowhere;
        }
        if self.is_side {
            // Its hull has no thickness: each corner is there twice.
            let points = self.hull(at, edge).points.map(|point| self.bounded(point));
            let values = (0..HULL / 2).flat_map(|k| (k..HULL / 2).map(move |l| (k, l)));
            return occupied_by(values.map(|(k, l)| -self.form.value(&points[k], &points[l])), true);
        }
        let root = self.root(at, edge);
        if root.is_nowhere {
            return Occupied::Nowhere;
        }
        let of_slab = |range: Approx, slab: &Heights| {
            let corners = self.corners(at, edge, slab).map(|point| self.bounded(point));
            self.in_box(range, &corners).max(self.of_sheet(&corners))
        };
        // Most cells are told without the slope of the surface.
        let mut told = of_slab(root.heights, &self.level_heights(root.heights));
        if told == Occupied::Partly {
            let slab = self.heights(at, edge, &root);
            told = of_slab(slab.over(edge), &slab);
        }
        if root.is_everywhere() { told } else { told.max(Occupied::Partly) }
    }

    /// How much of what has heights in a range, between these corners, is in the box. A factor of the form that is not zero tells this of surface between the corners alone, but
    /// where all of it is beyond them [`Graph::of_sheet`] is not `Whole`: at the box's side the gradient has the other sign.
    fn in_box(&self, heights: Approx, corners: &[LocalPoint<Approx>; HULL]) -> Occupied {
        let [low, high] = self.within.map(|corner| corner[self.axis]);
        let lies_in = |bound: usize| self.beside_bounds[bound].is_some_and(|row| is_nowhere_zero(&row, corners));
        if heights.upper() < low || heights.lower() > high {
            Occupied::Nowhere
        } else if (heights.lower() >= low || lies_in(0)) && (heights.upper() <= high || lies_in(1)) {
            Occupied::Whole
        } else {
            Occupied::Partly
        }
    }

    /// How much of what lies between these corners has the gradients of this sheet.
    fn of_sheet(&self, corners: &[LocalPoint<Approx>; HULL]) -> Occupied {
        let mut answer = Occupied::Whole;
        for (Slope { row, is_strict }, beside) in self.slopes.iter().zip(&self.beside_slopes) {
            // Where one factor of the form is not zero the other is: the gradient's coordinates are equal.
            let is_tie = beside.is_some_and(|row| is_nowhere_zero(&row, corners));
            let zero = [Approx::exact(0.0)];
            let held = match is_tie {
                true => occupied_by(zero.into_iter(), !is_strict),
                false => occupied_by(corners.iter().map(|x| linear_value(row, x)), !is_strict),
            };
            match held {
                Occupied::Nowhere => return Occupied::Nowhere,
                Occupied::Partly => answer = Occupied::Partly,
                Occupied::Whole => {}
            }
        }
        answer
    }

    /// A rounded point with its bounds.
    fn bounded(&self, point: DVec3) -> LocalPoint<Approx> {
        let [x, y, z] = point.to_array().map(|value| Approx { value, error: self.size() * PADDING });
        [x, y, z, Approx::exact(1.0)]
    }

    /// u and v of a point of the patch; `None` for points of other sheets.
    pub(crate) fn parameters(&self, point: DVec3) -> Option<[f64; 2]> {
        let parameters = self.across.map(|axis| (point[axis] - self.within[0][axis]) / self.extent(axis));
        let x = [point.x, point.y, point.z, 1.0];
        let form = self.form.map(|factor| factor.value);
        let gradient = |axis: usize| linear_value(&form.row(axis), &x);
        let own = self.sign() * gradient(self.axis);
        // Rounding must leave no point without a sheet.
        let is_largest = self.across.iter().all(|&axis| gradient(axis).abs() <= own * (1.0 + 1e3 * f64::EPSILON));
        (self.is_side || is_largest).then_some(parameters)
    }
}

/// The linear form that is zero in the plane across an axis at a coordinate, and positive above it.
pub(crate) fn above(axis: usize, coordinate: f64) -> [Dyadic; 4] {
    let mut row = [0.0, 0.0, 0.0, -coordinate].map(Dyadic::new);
    row[axis] = Dyadic::new(1.0);
    row
}

/// What values of a condition at all corners of a hull say of it.
fn occupied_by(values: impl Iterator<Item = Approx>, zero_counts: bool) -> Occupied {
    let (mut all, mut none) = (true, true);
    for value in values {
        all &= value.value > value.error || (zero_counts && value.value >= value.error);
        none &= -value.value > value.error || (!zero_counts && -value.value >= value.error);
    }
    match (all, none) {
        (true, _) => Occupied::Whole,
        (_, true) => Occupied::Nowhere,
        _ => Occupied::Partly,
    }
}

/// For rows r of the form's matrix and k the axis: (r_ki·r_kj − r_kk·r_ij)·x_i·x_j over the other axes.
fn discriminant(form: &QuadricForm<Dyadic>, axis: usize) -> QuadricForm<Dyadic> {
    let own = form.row(axis);
    let entry = |i: usize, j: usize| own[i].clone() * own[j].clone() - own[axis].clone() * form.row(i)[j].clone();
    let mixed = (0..4).flat_map(|i| (i + 1..4).map(move |j| (i, j))).map(|(i, j)| (i, j, entry(i, j)));
    // All terms with the axis are zero.
    let mixed = mixed.filter(|(_, _, factor)| factor.sign() != Sign::Zero);
    QuadricForm::new(std::array::from_fn(|k| entry(k, k)), mixed.collect())
}

fn coefficients<T>(form: &QuadricForm<T>, axis: usize, base: &LocalPoint<T>) -> [T; 3]
where
    T: Clone + Default + Add<Output = T> + Mul<Output = T>,
{
    let row = form.row(axis);
    [row[axis].clone(), linear_value(&row, base), form.value(base, base)]
}
