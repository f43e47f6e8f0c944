//! Where a sheet lies over a cell: between two parallel planes, and within the cell where some all but affine functions are not negative.

use super::{Graph, Slope};
use crate::{
    analytic::{
        chart::PADDING,
        cut::Condition,
        forms::{LocalPoint, linear_value},
    },
    approx::Approx,
};

/// A slab over a cell: heights within `reach` of a plane through `middle` at the cell's middle.
pub(super) struct Heights {
    pub(super) middle: f64,
    /// For a whole step of the parameters.
    pub(super) slope: [f64; 2],
    pub(super) reach: f64,
}

impl Graph {
    /// Where the surface can lie over a cell, given the range of the root there and whether there is one everywhere.
    pub(super) fn heights(&self, at: [f64; 2], edge: f64, (range, is_there): (Approx, bool)) -> Heights {
        let crude = self.level_heights(range);
        let sharp = if is_there { self.tangent(at, edge) } else { self.tilted(at, edge, &crude) };
        sharp.filter(|sharp| sharp.reach < crude.reach).unwrap_or(crude)
    }

    /// The same without a slope.
    pub(super) fn level_heights(&self, range: Approx) -> Heights {
        let [low, high] = self.within.map(|corner| corner[self.axis]);
        let (low, high) = (range.lower().max(low), range.upper().min(high));
        Heights { middle: 0.5 * (low + high), slope: [0.0; 2], reach: 0.5 * (high - low).max(0.0) }
    }

    /// The mean value theorem between the cell's middle and any point of the surface in the crude box.
    fn tilted(&self, at: [f64; 2], edge: f64, crude: &Heights) -> Option<Heights> {
        let middle = self.point(at[0] + 0.5 * edge, at[1] + 0.5 * edge);
        let height = middle[self.axis];
        let (centre, exists) = self.range([at[0] + 0.5 * edge, at[1] + 0.5 * edge], 0.0);
        let is_there =
            exists && (centre.value - height).abs() <= centre.error && (height - crude.middle).abs() <= crude.reach;
        let cell = self.cell_box(at, edge, Approx { value: crude.middle, error: crude.reach });
        let steep = linear_value(&self.form.row(self.axis), &cell);
        let slope = self.across.map(|axis| -linear_value(&self.form.row(axis), &cell).divided_by(steep));
        let extent = self.across.map(|axis| self.extent(axis));
        let spread = (0..2).map(|k| slope[k].error * 0.5 * edge * extent[k]).sum::<f64>();
        let reach = spread + centre.error + self.size() * PADDING;
        let slope = [0, 1].map(|k| slope[k].value * extent[k]);
        (is_there && reach.is_finite()).then_some(Heights { middle: height, slope, reach })
    }

    /// How far the surface is from its tangent plane over a cell; `None` unless there is a root everywhere. With q(y, e) the half derivative along the axis,
    /// a point p of the plane and the surface's point p + δ·e beside it fulfil δ·(q(p, e) + q(p + δ·e, e)) = −q(p, p), and the second of these
    /// derivatives is ±√D.
    fn tangent(&self, at: [f64; 2], edge: f64) -> Option<Heights> {
        let middle = at.map(|low| low + 0.5 * edge);
        let (centre, sign) = (self.range(middle, 0.0).0, Approx::exact(self.sign()));
        let steep = (self.steep(at, edge) * sign).lower();
        let m = self.cell_box(middle, 0.0, Approx::exact(centre.value));
        let [own, beside @ ..] =
            [self.axis, self.across[0], self.across[1]].map(|axis| linear_value(&self.form.row(axis), &m));
        let extent = self.across.map(|axis| self.extent(axis));
        let slope = [0, 1].map(|k| -beside[k].value / own.value * extent[k]);
        let [a, b] = self.halves(edge, slope);
        let terms = [(&m, &m), (&m, &a), (&m, &a), (&m, &b), (&m, &b), (&a, &a), (&a, &b), (&a, &b), (&b, &b)];
        let off = terms.iter().map(|(x, y)| greatest(self.form.value(x, y))).sum::<f64>();
        let along = [&a, &b].map(|half| greatest(linear_value(&self.form.row(self.axis), half)));
        let least = (own * sign).lower() - along[0] - along[1] + steep;
        let roundings = self.size() * PADDING + (slope[0].abs() + slope[1].abs()) * edge * PADDING;
        let reach = off / least * (1.0 + PADDING) + roundings;
        (steep > 0.0 && least > 0.0 && reach.is_finite()).then_some(Heights { middle: centre.value, slope, reach })
    }

    /// Half a cell along each parameter, in a plane with this slope.
    fn halves(&self, edge: f64, slope: [f64; 2]) -> [LocalPoint<Approx>; 2] {
        [0, 1].map(|k| {
            let axis = self.across[k];
            let mut half = [Approx::exact(0.0); 4];
            half[axis] = Approx::exact(self.within[1][axis]) - Approx::exact(self.within[0][axis]);
            half[self.axis] = Approx::exact(slope[k]);
            half.map(|coordinate| coordinate * Approx::exact(0.5 * edge))
        })
    }

    /// The functions that are not negative where a cell is surface, over −1..1 along both parameters; `None` where it is not known that
    /// there is a root everywhere, or nothing is known of its slopes.
    pub(in crate::analytic) fn conditions(&self, at: [f64; 2], edge: f64) -> Option<Vec<Condition>> {
        let middle = at.map(|low| low + 0.5 * edge);
        let conditions = if self.is_side {
            vec![self.condition_of_side(middle, edge)]
        } else {
            self.conditions_of_sheet(middle, edge, &self.tangent(at, edge)?)
        };
        conditions.iter().all(Condition::is_finite).then_some(conditions)
    }

    /// −q at x + s·a + t·b is −q(x, x) − 2·s·q(x, a) − 2·t·q(x, b), and what bends.
    fn condition_of_side(&self, middle: [f64; 2], edge: f64) -> Condition {
        let x = self.cell_box(middle, 0.0, Approx::exact(self.side()));
        let halves = self.halves(edge, [0.0; 2]);
        let [a, b] = &halves;
        let bend = [(a, a), (a, b), (a, b), (b, b)].map(|(k, l)| greatest(self.form.value(k, l)));
        let along = halves.map(|half| self.form.value(&x, &half) * Approx::exact(-2.0));
        Condition::new(-self.form.value(&x, &x), along, bend.iter().sum())
    }

    /// The gradient's largest coordinate is the own one, and the height is in the box.
    fn conditions_of_sheet(&self, middle: [f64; 2], edge: f64, slab: &Heights) -> Vec<Condition> {
        let x = self.cell_box(middle, 0.0, Approx::exact(slab.middle));
        let halves = self.halves(edge, slab.slope);
        let largest = self.slopes.iter().map(|Slope { row, .. }| {
            let along = halves.map(|half| linear_value(row, &half));
            Condition::new(linear_value(row, &x), along, greatest(row[self.axis]) * slab.reach)
        });
        let in_box = [(0, 1.0), (1, -1.0)].map(|(bound, sign)| {
            let above = x[self.axis] - Approx::exact(self.within[bound][self.axis]);
            let [above, along @ ..] =
                [above, halves[0][self.axis], halves[1][self.axis]].map(|value| value * Approx::exact(sign));
            Condition::new(above, along, slab.reach)
        });
        largest.chain(in_box).collect()
    }

    /// The form's half derivative along the axis on the surface over a cell: ±√D.
    pub(super) fn steep(&self, at: [f64; 2], edge: f64) -> Approx {
        self.discriminant_over(at, edge).square_root() * Approx::exact(self.sign())
    }
}

/// What the size of a number does not exceed.
fn greatest(value: Approx) -> f64 {
    value.upper().max((-value).upper())
}
