//! Where a sheet lies over a cell: between two parallel planes, and within the cell where some all but affine functions are not negative.

use super::{Graph, slopes::Slope};
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

impl Heights {
    /// All of them over a cell with this edge.
    pub(super) fn over(&self, edge: f64) -> Approx {
        let tilt = 0.5 * edge * (self.slope[0].abs() + self.slope[1].abs()) * (1.0 + 4.0 * f64::EPSILON);
        Approx { value: self.middle, error: (self.reach + tilt).next_up() }
    }
}

/// The root over a cell.
pub(super) struct Root {
    /// Where there is one.
    pub(super) heights: Approx,
    /// b² − a·c.
    pub(super) discriminant: Approx,
    /// Whether it is known that there is none with the gradient of this sheet.
    pub(super) is_nowhere: bool,
}

impl Root {
    /// Whether it is known that there is one all over the cell.
    pub(super) fn is_everywhere(&self) -> bool {
        self.discriminant.lower() > 0.0
    }
}

impl Graph {
    /// Where the surface can lie over a cell with this root.
    pub(super) fn heights(&self, at: [f64; 2], edge: f64, root: &Root) -> Heights {
        let crude = self.level_heights(root.heights);
        let tangent = || self.tangent(at, edge, root.discriminant);
        let sharp = if root.is_everywhere() { tangent() } else { self.tilted(at, edge, &crude) };
        sharp.filter(|sharp| sharp.reach < crude.reach).unwrap_or(crude)
    }

    /// The same without a slope.
    pub(super) fn level_heights(&self, range: Approx) -> Heights {
        let [low, high] = self.within.map(|corner| corner[self.axis]);
        let (low, high) = (range.lower().max(low), range.upper().min(high));
        let reach = 0.5 * (high - low).max(0.0) + self.size() * PADDING;
        Heights { middle: 0.5 * (low + high), slope: [0.0; 2], reach }
    }

    /// The mean value theorem between the cell's middle and any point of the surface in the crude box.
    fn tilted(&self, at: [f64; 2], edge: f64, crude: &Heights) -> Option<Heights> {
        let middle = self.point(at[0] + 0.5 * edge, at[1] + 0.5 * edge);
        let height = middle[self.axis];
        let root = self.root([at[0] + 0.5 * edge, at[1] + 0.5 * edge], 0.0);
        let centre = root.heights;
        // Both the rounded height and the true one are as near to the value.
        let off = 2.0 * centre.error;
        let is_near = (centre.value - height).abs() <= centre.error;
        let is_there = root.is_everywhere() && is_near && (height - crude.middle).abs() + off <= crude.reach;
        let cell = self.cell_box(at, edge, Approx { value: crude.middle, error: crude.reach });
        let steep = linear_value(&self.form.row(self.axis), &cell);
        let slope = self.across.map(|axis| -linear_value(&self.form.row(axis), &cell).divided_by(steep));
        let extent = self.across.map(|axis| self.extent(axis));
        let spread = (0..2).map(|k| slope[k].error * 0.5 * edge * extent[k]).sum::<f64>();
        let reach = spread + off + self.size() * PADDING;
        let slope = [0, 1].map(|k| slope[k].value * extent[k]);
        (is_there && reach.is_finite()).then_some(Heights { middle: height, slope, reach })
    }

    /// How far the surface is from its tangent plane over a cell; `None` unless there is a root everywhere. With q(y, e) the half derivative along the axis,
    /// a point p of the plane and the surface's point p + δ·e beside it fulfil δ·(q(p, e) + q(p + δ·e, e)) = −q(p, p), and the second of these
    /// derivatives is ±√D.
    fn tangent(&self, at: [f64; 2], edge: f64, discriminant: Approx) -> Option<Heights> {
        let middle = at.map(|low| low + 0.5 * edge);
        let (centre, sign) = (self.root(middle, 0.0).heights, Approx::exact(self.sign()));
        let steep = discriminant.square_root().lower();
        let m = self.cell_box(middle, 0.0, Approx::exact(centre.value));
        let [own, beside @ ..] =
            [self.axis, self.across[0], self.across[1]].map(|axis| linear_value(&self.form.row(axis), &m));
        let extent = self.across.map(|axis| self.extent(axis));
        let slope = [0, 1].map(|k| -beside[k].value / own.value * extent[k]);
        let [a, b] = self.halves(edge, slope);
        let terms = [(&m, &m), (&m, &a), (&m, &a), (&m, &b), (&m, &b), (&a, &a), (&a, &b), (&a, &b), (&b, &b)];
        let off = terms.iter().map(|(x, y)| greatest(self.form.value(x, y))).sum::<f64>();
        let along = [&a, &b].map(|half| greatest(linear_value(&self.form.row(self.axis), half)));
        let parts = [(own * sign).lower(), -along[0], -along[1], steep];
        let least = parts.iter().sum::<f64>() - PADDING * parts.iter().map(|part| part.abs()).sum::<f64>();
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
    /// there is a root everywhere, or nothing is known of its slopes. Where one that must not be zero is zero everywhere there is no surface
    /// ([`Graph::occupied`]).
    pub(in crate::analytic) fn conditions(&self, at: [f64; 2], edge: f64) -> Option<Vec<Condition>> {
        let middle = at.map(|low| low + 0.5 * edge);
        let conditions = if self.is_side {
            vec![self.condition_of_side(middle, edge)]
        } else {
            self.conditions_of_sheet(middle, edge, &self.tangent(at, edge, self.discriminant_over(at, edge))?)
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
        let along = |row: &[Approx; 4]| halves.each_ref().map(|half| linear_value(row, half));
        let condition = |row: &[Approx; 4]| {
            Condition::new(linear_value(row, &x), along(row), greatest(row[self.axis]) * slab.reach)
        };
        let largest = self.slopes.iter().map(|Slope { row, .. }| condition(row));
        let in_box = [(0, 1.0), (1, -1.0)].map(|(bound, sign)| {
            let above = x[self.axis] - Approx::exact(self.within[bound][self.axis]);
            let [above, along @ ..] =
                [above, halves[0][self.axis], halves[1][self.axis]].map(|value| value * Approx::exact(sign));
            Condition::new(above, along, slab.reach)
        });
        let beside = self.beside_slopes.iter().chain(&self.beside_bounds);
        // What is zero all over the surface holds.
        let is_tie = |beside: &Option<[Approx; 4]>| beside.is_some_and(|row| condition(&row).is_nowhere_zero());
        let all = largest.chain(in_box).zip(beside);
        all.filter(|(_, beside)| !is_tie(beside)).map(|(condition, _)| condition).collect()
    }
}

/// What the size of a number does not exceed.
fn greatest(value: Approx) -> f64 {
    value.upper().max((-value).upper())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::layout::symmetric_form;

    /// By how much a function is off its condition at a point of the cell, as a share of what it may be.
    fn off(value: Approx, condition: &Condition, [s, t]: [f64; 2]) -> f64 {
        let affine = condition.constant + condition.along[0] * s + condition.along[1] * t;
        ((value.value - affine).abs() - value.error) / condition.error
    }

    /// Roots of random quadrics at points of random cells, each with bounds of its own, held against the slab and the conditions of the cell.
    #[test]
    fn slabs_hold_the_surface_and_conditions_their_functions() {
        let mut state = 1u64;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
        };
        let grid = [-1.0, -0.5, 0.0, 0.5, 1.0];
        // Of sheets and of sides: cells, and what was farthest off.
        let (mut cells, mut farthest) = ([0; 2], [0.0f64; 3]);
        for _ in 0..8000 {
            let matrix = std::array::from_fn(|_| std::array::from_fn(|_| number()));
            let within = [[0; 3].map(|_| -1.5 + 0.5 * number()), [0; 3].map(|_| 1.5 + 0.5 * number())];
            let edge = [0.5, 0.125, 1.0 / 32.0][(number().abs() * 3.0) as usize % 3];
            let at = [0; 2].map(|_| (0.5 * (number() + 1.0) / edge).floor() * edge);
            let graph = &Graph::all(&symmetric_form(&matrix, 1.0), &within)[(number().abs() * 12.0) as usize % 12];
            let middle = at.map(|low| low + 0.5 * edge);
            let points = grid.iter().flat_map(|&s| grid.map(|t| [s, t]));
            let place = |[s, t]: [f64; 2]| [middle[0] + 0.5 * edge * s, middle[1] + 0.5 * edge * t];
            let told = format!("{matrix:?} {within:?} {at:?} {edge}");
            if graph.is_side {
                let condition = graph.condition_of_side(middle, edge);
                cells[1] += 1;
                for point in points {
                    let x = graph.cell_box(place(point), 0.0, Approx::exact(graph.side()));
                    farthest[2] = farthest[2].max(off(-graph.form.value(&x, &x), &condition, point));
                    assert!(farthest[2] <= 1.0, "{told}: {}", farthest[2]);
                }
                continue;
            }
            let Some(slab) = graph.tangent(at, edge, graph.discriminant_over(at, edge)) else { continue };
            let conditions = graph.conditions_of_sheet(middle, edge, &slab);
            cells[0] += 1;
            for point in points {
                let height = graph.root(place(point), 0.0).heights;
                let plane = slab.middle + 0.5 * edge * (slab.slope[0] * point[0] + slab.slope[1] * point[1]);
                farthest[0] = farthest[0].max(((height.value - plane).abs() - height.error) / slab.reach);
                let x = graph.cell_box(place(point), 0.0, height);
                for (slope, condition) in graph.slopes.iter().zip(&conditions) {
                    farthest[1] = farthest[1].max(off(linear_value(&slope.row, &x), condition, point));
                }
                assert!(farthest[0].max(farthest[1]) <= 1.0, "{told}: {farthest:?}");
            }
        }
        // The bounds are no wider than they must be: some are attained.
        assert!(
            cells.iter().all(|&cells| cells > 500) && farthest.iter().all(|&off| off > 0.99),
            "{cells:?} {farthest:?}"
        );
    }
}
