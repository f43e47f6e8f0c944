//! Areas of cells of a placed patch, with bounds.
//!
//! Gauss-Legendre quadrature along both parameters. With n points, h the edge and c the Taylor coefficient of order 2n of the
//! density along one parameter, somewhere in the cell, the mean misses h^(2n)·c/180 for two points, /2800 for three, /698544 for five
//! (Davis & Rabinowitz, "Methods of Numerical Integration", §2.7); c is bounded by interval Taylor series. Where the series says nothing, as where
//! a flat ellipsoid turns round its rim, the range of the density over the cell does. A cell whose bound is too wide is halved where most is
//! missed (`halved`), or quartered where borders cut it.

use std::f64::consts::FRAC_PI_2;

use super::{
    chart::{Chart, Kind, Occupied, quarter_direction},
    cut::share,
    halved::{self, Measured, Part},
    jet::Jet,
    outline::Outline,
};
use crate::{
    approx::{Approx, sorted},
    placement::Placement,
    stretch::{between, cofactors, common_stretch, stretches},
};

/// Relative width at which a bound of an area is good enough.
const GOOD: f64 = 1e-8;

/// The same on a trimmed patch, whose border is known far less well.
const GOOD_IF_TRIMMED: f64 = 1e-6;

/// The same where areas are only roughly asked for: less than most looks at borders gain, and finer ones would take the time from these.
const GOOD_IF_ROUGH: f64 = 1.0 / 4096.0;

/// How many times too wide a bound by two points may be for three to be tried before five.
const NEARLY: f64 = 256.0;

/// Relative width above which the mere range of the density may say more than quadrature.
const ROUGH: f64 = 0.125;

/// How often a cell is quartered at most.
const QUARTERINGS: u32 = 6;

/// The same where areas are only roughly asked for.
const QUARTERINGS_IF_ROUGH: u32 = 3;

/// Cells are not quartered to below 2 to the minus this.
const FINEST: i32 = 9;

/// How often a patch is where next to nothing is asked of its area.
const QUARTERINGS_OF_PATCH: u32 = 1;

/// How often a cell at the border of a trimmed patch is.
const BORDER_QUARTERINGS: u32 = 2;

/// What the area of a cell that borders cut costs, in evaluations of the density; and such an evaluation, in those of other bodies.
const AT_CORNERS: u64 = 4;
const OF_GRAPH: u64 = 2;

/// How far off such a cell's area may be, of the greatest that it can have.
const GOOD_AT_BORDER: f64 = 1.0 / 16.0;

/// A Gauss-Legendre rule on −1..1.
struct Rule {
    /// Nodes and weights, both to nearest; the weights are two together.
    nodes: &'static [(f64, f64)],
    /// With n nodes, edge h and the Taylor coefficient c of order 2n somewhere in the cell, h^(2n)·c over this is missed.
    remainder: f64,
}

/// The nodes are ±1/√3.
const TWO_POINTS: Rule =
    Rule { nodes: &[(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)], remainder: 180.0 };

/// The outer nodes are ±√(3/5).
const THREE_POINTS: Rule = Rule {
    nodes: &[(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)],
    remainder: 2800.0,
};

/// The outer nodes are ±√(5 ± 2√(10/7))/3 with the weights (322 ∓ 13√70)/900, that of the inner one is 128/225.
const FIVE_POINTS: Rule = Rule {
    nodes: &[
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ],
    remainder: 698_544.0,
};

/// The density of area over the parameters of one placed patch.
#[derive(Clone, Debug)]
pub struct PatchArea<'a> {
    chart: &'a Chart,
    /// Takes the local normal times the area to the world's: the cofactors of M, by rows.
    cofactors: [[Approx; 3]; 3],
    /// How much the placement stretches all areas, if it stretches them alike.
    stretch: Option<Approx>,
    /// Relative width at which a bound is good enough.
    good: f64,
    /// How often a cell is quartered at most.
    quarterings: u32,
}

impl<'a> PatchArea<'a> {
    /// Prepares a patch.
    pub fn new(chart: &'a Chart, placement: &Placement) -> Self {
        let cofactors = cofactors(placement);
        let good = if chart.is_trimmed() { GOOD_IF_TRIMMED } else { GOOD };
        Self { chart, cofactors, stretch: common_stretch(&cofactors), good, quarterings: QUARTERINGS }
    }

    /// The same with areas that are integrated until they are known to 2^-12, or to 64 parts of a cell: large cells take a fraction of the time.
    #[must_use]
    pub fn rough(self) -> Self {
        Self { good: GOOD_IF_ROUGH, quarterings: QUARTERINGS_IF_ROUGH, ..self }
    }

    /// The area of the cell [u, u + edge] × [v, v + edge], square metres, world. All three are multiples of 2^-29, so that sums of them are exact.
    ///
    /// Cost: below a microsecond by formula; some microseconds where it is integrated, a hundred times that for a large cell
    /// over which a flat body turns, a thousand times where borders cut it.
    pub fn of_cell(&self, at: [f64; 2], edge: f64) -> Approx {
        self.of_cell_counted(at, edge).0
    }

    /// The same, and about what it cost, in evaluations of the density of some tenths of a microsecond: nothing where a formula tells the area.
    pub fn of_cell_counted(&self, at: [f64; 2], edge: f64) -> (Approx, u64) {
        if let Some(area) = self.by_formula(at, edge) {
            return (area, 0);
        }
        let mut points = 0;
        // Not to below the finest edge: where series still say nothing there, they never will.
        let quarterings = (FINEST + libm::ilogb(edge)).clamp(1, self.quarterings as i32) as u32;
        let (area, cost) = match self.chart.kind {
            Kind::Graph(_) => (self.quartered(at, edge, [quarterings, BORDER_QUARTERINGS], &mut points), OF_GRAPH),
            // Halved into as many parts as that would make.
            _ => {
                let (whole, most) = (Part::square(at, edge), 1 << (2 * quarterings));
                (halved::sum(whole, most, self.good, |part| self.measured(part, &mut points)), 1)
            }
        };
        (area, cost * points)
    }

    /// The area of a cell that borders cut, if it is known as well as those of its parts with the edge `finest` would be together. Cost: some
    /// microseconds.
    pub fn of_cut_cell(&self, at: [f64; 2], edge: f64, finest: f64) -> Option<Approx> {
        let area = self.cut(at, edge);
        // A border runs through edge/finest of the parts.
        (area.error <= self.at_most(edge) * GOOD_AT_BORDER * (finest / edge)).then_some(area)
    }

    /// The area of the whole patch, between nothing and twice its value at worst where it is not known by formula: for the cost of some small cells.
    pub fn of_whole_roughly(&self) -> Approx {
        let rough = || self.quartered([0.0; 2], 1.0, [QUARTERINGS_OF_PATCH; 2], &mut 0);
        self.by_formula([0.0; 2], 1.0).or_else(|| self.by_stretches()).unwrap_or_else(rough)
    }

    /// Spheres, and surfaces turned from lines, parabolas and hyperbolas, under similarities.
    fn by_formula(&self, [u, v]: [f64; 2], edge: f64) -> Option<Approx> {
        let stretch = self.stretch?;
        let local = match &self.chart.kind {
            Kind::Radial { radii: [radius, b, c], origin, along, .. } if radius == b && radius == c => {
                let radius = Approx::exact(*radius);
                radius * radius * solid_angle(origin, along, [u, v], edge)
            }
            Kind::Turned { outline, .. } => {
                let angle = |u: f64| rounded(libm::atan(2.0 * u - 1.0), 4.0);
                (angle(u + edge) - angle(u)) * outline.turned_area(v, v + edge)
            }
            _ => return None,
        };
        Some(local * stretch)
    }

    /// A patch of which the map is the image of one whose area is known: that, times something between the map's least and greatest stretch.
    fn by_stretches(&self) -> Option<Approx> {
        let (own, [least, most]) = match &self.chart.kind {
            Kind::Radial { radii, origin, along, .. } => {
                let of_sphere = self.cofactors.map(|row| std::array::from_fn(|k| row[k] * across(radii, k)));
                (solid_angle(origin, along, [0.0; 2], 1.0), stretches(&of_sphere))
            }
            Kind::Turned { outline, .. } => {
                (rounded(FRAC_PI_2, 2.0) * outline.turned_area(0.0, 1.0), stretches(&self.cofactors))
            }
            Kind::Graph(_) => return None,
        };
        Some(between((own.lower() * least).next_down().max(0.0), (own.upper() * most).next_up()))
    }

    /// `left` tells how often cells are still quartered, and how often those that a border cuts.
    fn quartered(&self, [u, v]: [f64; 2], edge: f64, left: [u32; 2], points: &mut u64) -> Approx {
        let (area, left_here, good) = match self.chart.occupied([u, v], edge) {
            Occupied::Nowhere => return Approx::exact(0.0),
            Occupied::Whole => {
                let area = self.measured(&Part::square([u, v], edge), points).area;
                let good = area.value.abs() * self.good;
                (if area.error <= good { area } else { self.within_reach(area, edge) }, left[0], good)
            }
            Occupied::Partly => {
                *points += AT_CORNERS;
                (self.cut([u, v], edge), left[1], self.at_most(edge) * GOOD_AT_BORDER)
            }
        };
        if left_here == 0 || area.error <= good {
            return area;
        }
        let half = 0.5 * edge;
        let mut part = |i: f64, j: f64| {
            self.quartered([u + i * half, v + j * half], half, left.map(|times| times.saturating_sub(1)), points)
        };
        let sum = (part(0.0, 0.0) + part(1.0, 0.0)) + (part(0.0, 1.0) + part(1.0, 1.0));
        // The bound of the whole may be the better one where rounding dominates.
        if sum.error < area.error || area.error.is_nan() { sum } else { area }
    }

    /// The area of a cell that borders cut: its share of the square between the least and the greatest density.
    fn cut(&self, at: [f64; 2], edge: f64) -> Approx {
        let Kind::Graph(graph) = &self.chart.kind else { return Approx::UNKNOWN };
        let Some(conditions) = graph.conditions(at, edge) else { return between(0.0, self.at_most(edge)) };
        self.within_reach(share(&conditions) * self.over_range(&Part::square(at, edge)), edge)
    }

    /// An area of a cell between none and the greatest that there can be.
    fn within_reach(&self, area: Approx, edge: f64) -> Approx {
        let most = self.at_most(edge);
        // Where nothing is known of the density it is infinite or NaN.
        let (least, greatest) = (area.lower().max(0.0), area.upper().min(most));
        if least <= greatest { between(least, greatest) } else { between(0.0, most) }
    }

    /// The greatest area that a cell of a trimmed patch can have.
    fn at_most(&self, edge: f64) -> f64 {
        let Kind::Graph(graph) = &self.chart.kind else { return f64::INFINITY };
        let normal = graph.greatest_normal();
        let reach = |row: [Approx; 3]| (0..3).map(|k| row[k].upper().max((-row[k]).upper()) * normal[k]).sum::<f64>();
        let [least, middle, greatest] = sorted(self.cofactors.map(|row| reach(row) * reach(row)));
        (least + middle + greatest).sqrt() * edge * edge * (1.0 + 8.0 * f64::EPSILON)
    }

    /// On small cells fewer points are as good, for a fraction of the work. Where the density bends too sharply for any, its own range bounds the area.
    fn measured(&self, part: &Part, points: &mut u64) -> Measured {
        let miss = |by: &Measured| by.area.error / (by.area.value.abs() * self.good);
        let by_two = self.gauss::<5>(&TWO_POINTS, part, points);
        if miss(&by_two) <= 1.0 {
            return by_two;
        }
        if !by_two.area.error.is_finite() {
            // The series says nothing, and a longer one begins with it.
            return self.by_range(part);
        }
        if miss(&by_two) <= NEARLY {
            let by_three = self.gauss::<7>(&THREE_POINTS, part, points);
            if miss(&by_three) <= 1.0 {
                return by_three;
            }
        }
        let by_five = self.gauss::<11>(&FIVE_POINTS, part, points);
        if by_five.area.error < ROUGH * by_five.area.value.abs() {
            return by_five;
        }
        let range = self.by_range(part);
        let is_better = range.area.error <= by_five.area.error || by_five.area.error.is_nan();
        if is_better { range } else { Measured { area: by_five.area, ..range } }
    }

    /// By the density's own range.
    fn by_range(&self, part: &Part) -> Measured {
        Measured { area: self.over_range(part), missed: [0, 1].map(|axis| self.spread_along(axis, part)) }
    }

    /// Between the least and the greatest density on a part.
    fn over_range(&self, part: &Part) -> Approx {
        let [u, v] = [0, 1].map(|axis| Jet::<1>::constant(part.range(axis)));
        let density = match &self.chart.kind {
            // Only squares are asked for of a graph.
            Kind::Graph(graph) => self.stretched(&graph.normal_over(part.at, part.edges[0]).map(Jet::<1>::constant)),
            _ => self.density(u, v),
        };
        density.0[0] * Approx::exact(part.edges[0] * part.edges[1])
    }

    /// How far the density ranges along a parameter through a part's middle.
    fn spread_along(&self, axis: usize, part: &Part) -> f64 {
        let mut middle = [0, 1].map(|axis| Jet::<1>::constant(Approx::exact(part.range(axis).value)));
        middle[axis] = Jet::constant(part.range(axis));
        self.density(middle[0], middle[1]).0[0].error
    }

    /// A rule along both parameters; K is one more than twice its number of nodes.
    fn gauss<const K: usize>(&self, rule: &Rule, part: &Part, points: &mut u64) -> Measured {
        // A series of K terms is multiplied in K²/2 steps.
        *points += (rule.nodes.len() * rule.nodes.len() + K * K / 2) as u64;
        let at_node = |axis: usize, node: f64| {
            let offset = Approx { value: node, error: node.abs() * f64::EPSILON };
            let range = part.range(axis);
            Jet::<1>::constant(Approx::exact(range.value) + offset * Approx::exact(range.error))
        };
        let weight = |weight: f64| Approx { value: weight, error: weight * f64::EPSILON };
        let [u, v] = [0, 1].map(|axis| part.range(axis));
        let along_u = self.density(Jet::<K>::variable(u), Jet::constant(v));
        let along_v = self.density(Jet::<K>::constant(u), Jet::variable(v));
        let missed = |along: Jet<K>, edge: f64| along.0[K - 1] * Approx::exact(edge.powi(K as i32 - 1));
        let missed = [missed(along_u, part.edges[0]), missed(along_v, part.edges[1])];
        let remainder = (missed[0] + missed[1]).divided_by(Approx::exact(rule.remainder));
        let missed = missed.map(|missed| missed.value.abs() + missed.error);
        if !remainder.error.is_finite() {
            return Measured { area: Approx::UNKNOWN, missed };
        }
        let mut sum = Approx::exact(0.0);
        for (node_u, weight_u) in rule.nodes {
            for (node_v, weight_v) in rule.nodes {
                let density = self.density(at_node(0, *node_u), at_node(1, *node_v));
                sum = sum + density.0[0] * weight(*weight_u) * weight(*weight_v);
            }
        }
        let mean = sum * Approx::exact(0.25) + remainder;
        Measured { area: mean * Approx::exact(part.edges[0] * part.edges[1]), missed }
    }

    /// Square metres for each unit of the parameters.
    fn density<const K: usize>(&self, u: Jet<K>, v: Jet<K>) -> Jet<K> {
        match &self.chart.kind {
            Kind::Radial { radii, origin, along, .. } => self.radial(radii, origin, along, [u, v]),
            Kind::Turned { quarter, outline } => self.turned(*quarter, outline, [u, v]),
            Kind::Graph(graph) => self.stretched(&graph.normal(u, v)),
        }
    }

    /// With the direction d, the solid angle has the density d·(d_u × d_v)/|d|³; radii R stretch area by |cof(R)·d|/|d|.
    fn radial<const K: usize>(
        &self,
        radii: &[f64; 3],
        origin: &[f64; 3],
        along: &[[f64; 3]; 2],
        [u, v]: [Jet<K>; 2],
    ) -> Jet<K> {
        let number = |value: f64| Jet::<K>::constant(Approx::exact(value));
        let toward = |k: usize| number(origin[k]) + u * number(along[0][k]) + v * number(along[1][k]);
        let d = [toward(0), toward(1), toward(2)];
        let solid = glam::DMat3::from_cols((*origin).into(), along[0].into(), along[1].into()).determinant();
        let across = |k: usize| d[k].scaled(across(radii, k));
        let normal = [across(0), across(1), across(2)];
        let squared = length_squared(&d);
        self.stretched(&normal).scaled(Approx::exact(solid)).divided_by(squared.squared())
    }

    /// With the outline (A, B)(v) and the angle θ, the area is θ'·A·|cof(M)·(B'·cos θ, −A', B'·sin θ)|, and θ' = 2/(1 + t²) for the
    /// direction (1, t), t = 2u − 1.
    fn turned<const K: usize>(&self, quarter: usize, outline: &Outline, [u, v]: [Jet<K>; 2]) -> Jet<K> {
        let number = |value: f64| Jet::<K>::constant(Approx::exact(value));
        let direction = quarter_direction(quarter, u, number);
        let squared = direction[0] * direction[0] + direction[1] * direction[1];
        let length = squared.square_root();
        let [cosine, sine] = direction.map(|coordinate| coordinate.divided_by(length));
        let (factor, [along_radius, along_y]) = outline.slope(v);
        let normal = [along_y * cosine, number(0.0) - along_radius, along_y * sine];
        (self.stretched(&normal) * factor).scaled(Approx::exact(2.0)).divided_by(squared)
    }

    /// |cof(M)·n|; where the map stretches all areas alike, that times |n|, which is sharper over a range.
    fn stretched<const K: usize>(&self, normal: &[Jet<K>; 3]) -> Jet<K> {
        if let Some(stretch) = self.stretch {
            return length_squared(normal).square_root().scaled(stretch);
        }
        let along = |[a, b, c]: [Approx; 3]| normal[0].scaled(a) + normal[1].scaled(b) + normal[2].scaled(c);
        let [x, y, z] = self.cofactors;
        length_squared(&[along(x), along(y), along(z)]).square_root()
    }
}

/// The world's axes may change places: so may the terms of each sum.
fn length_squared<const K: usize>(vector: &[Jet<K>; 3]) -> Jet<K> {
    let [x, y, z] = [vector[0].squared(), vector[1].squared(), vector[2].squared()];
    let mut sum = Jet::default();
    for (k, coefficient) in sum.0.iter_mut().enumerate() {
        *coefficient = Approx::sum_of_three([x.0[k], y.0[k], z.0[k]]);
    }
    sum
}

/// A number with some units roundoff of its size, which is at most one.
fn rounded(value: f64, roundings: f64) -> Approx {
    Approx { value, error: roundings * 0.5 * f64::EPSILON }
}

/// The solid angle of the directions over a cell: on the plane at distance one, the rectangle between two corners sees
/// F(a₁, b₁) − F(a₀, b₁) − F(a₁, b₀) + F(a₀, b₀) with F(a, b) = atan(a·b/√(1 + a² + b²)).
fn solid_angle(origin: &[f64; 3], along: &[[f64; 3]; 2], at: [f64; 2], edge: f64) -> Approx {
    // Each parameter runs along one axis.
    let coordinate = |k: usize, t: f64| {
        let axis = (0..3).find(|&axis| along[k][axis] != 0.0).unwrap_or(0);
        origin[axis] + along[k][axis] * t
    };
    let corner = |s: f64, t: f64| {
        let (a, b) = (coordinate(0, at[0] + s * edge), coordinate(1, at[1] + t * edge));
        // At most π/6, eight roundings.
        rounded(libm::atan(a * b / (1.0 + a * a + b * b).sqrt()), 8.0)
    };
    let sum = corner(1.0, 1.0) - corner(0.0, 1.0) - corner(1.0, 0.0) + corner(0.0, 0.0);
    Approx { value: sum.value.abs(), error: sum.error }
}

/// By how much radii stretch areas across an axis.
fn across(radii: &[f64; 3], axis: usize) -> Approx {
    Approx::exact(radii[(axis + 1) % 3]) * Approx::exact(radii[(axis + 2) % 3])
}

#[cfg(test)]
mod tests {
    use std::{f64::consts::TAU, ops::Add};

    use glam::{DAffine3, DMat3, DQuat, DVec3};

    use super::*;
    use crate::analytic::{Analytic, PlacedAnalytic};

    /// A rough look must not need the fine one, which takes a thousand times as long.
    #[test]
    fn rough_areas_are_bounded_at_once() {
        let turned = DMat3::from_quat(DQuat::from_rotation_x(0.57));
        let squashed = DMat3::from_diagonal(DVec3::new(1.0, 0.25, 2.0));
        let leaning = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.25), DVec3::new(0.0, 0.0, 1.5));
        let saddle = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.5], [0.0, 0.0, -1.0, 0.0], [0.0, 0.5, 0.0, 0.0]];
        let bodies = [
            Analytic::Sphere { radius: 0.7 },
            Analytic::Ellipsoid { radii: [1.0, 0.5, 0.75] },
            Analytic::Ellipsoid { radii: [1.0, 1.0 / 64.0, 64.0] },
            Analytic::Cylinder { radius: 0.5, height: 2.0 },
            Analytic::Cone { radius: 0.8, height: 1.5 },
            Analytic::Frustum { bottom_radius: 0.4, top_radius: 1.1, height: 0.9 },
            Analytic::Capsule { radius: 0.6, height: 1.7 },
            Analytic::Paraboloid { radius: 1.2, height: 0.8 },
            Analytic::Hyperboloid { waist_radius: 0.3, end_radius: 1.0, height: 2.5 },
            Analytic::Disk { radius: 1.3 },
            Analytic::Quadric { matrix: saddle, within: [[-1.0; 3], [1.0; 3]] },
        ];
        let mut sums = [0; 2];
        for map in [DMat3::IDENTITY, turned, squashed, turned * squashed * turned.transpose(), leaning] {
            let placement = Placement::new(DAffine3::from_mat3(map)).expect("regular");
            for body in bodies {
                let placed = PlacedAnalytic::new(body, placement).expect("a body");
                for chart in placed.charts() {
                    let area = PatchArea::new(chart, &placement);
                    let rough = area.of_whole_roughly();
                    let (fine, points) = area.of_cell_counted([0.0; 2], 1.0);
                    assert!(rough.error <= (1.0 + 1e-9) * rough.value, "{body:?} {map:?} {rough:?}");
                    assert!((rough.value - fine.value).abs() <= rough.error + fine.error, "{body:?} {map:?}");
                    let (less, fewer) = area.rough().of_cell_counted([0.0; 2], 1.0);
                    assert!((less.value - fine.value).abs() <= less.error + fine.error, "{body:?} {map:?}");
                    assert!(less.error >= fine.error && fewer <= points, "{body:?} {map:?} {fewer} of {points}");
                    sums = [sums[0] + points, sums[1] + fewer];
                }
            }
        }
        assert!(4 * sums[1] <= sums[0], "{sums:?}");
    }

    /// What cells to a depth add up to, as a bake divides a patch all of which is decided.
    fn divided(area: &PatchArea, at: [f64; 2], edge: f64, finest: f64) -> Approx {
        let known = match area.chart.occupied(at, edge) {
            Occupied::Nowhere => Some(Approx::exact(0.0)),
            Occupied::Partly if edge > finest => area.of_cut_cell(at, edge, finest),
            _ => Some(area.of_cell(at, edge)),
        };
        known.unwrap_or_else(|| {
            let half = 0.5 * edge;
            let part = |i: f64, j: f64| divided(area, [at[0] + i * half, at[1] + j * half], half, finest);
            part(0.0, 0.0) + part(1.0, 0.0) + part(0.0, 1.0) + part(1.0, 1.0)
        })
    }

    /// Of products of planes, where gradients are equal or the surface is in the box's sides, whole cells are told, so that areas are exact but for roundings.
    #[test]
    fn planes_have_their_areas() {
        let quadric = |terms: &[(usize, usize, f64)]| {
            let mut matrix = [[0.0; 4]; 4];
            terms.iter().for_each(|&(i, j, factor)| matrix[i][j] = factor);
            Analytic::Quadric { matrix, within: [[-1.0, -0.5, -1.0], [1.0, 0.5, 1.0]] }
        };
        let root = 2f64.sqrt();
        let bodies = [
            // All of the box: x² ≤ 1.
            (quadric(&[(0, 0, 1.0), (3, 3, -1.0)]), 2.0 * (2.0 + 2.0 + 4.0), 1e-9),
            // The half x ≤ y: the cut, both ends of y, one of x, and half of those of z.
            (quadric(&[(0, 3, 1.0), (1, 3, -1.0)]), 2.0 * root + 1.0 + 3.0 + 2.0 + 2.0, 1e-9),
            // Two wedges, x² ≤ y², and the ends of y and z; along their edge no cell is told.
            (quadric(&[(0, 0, 1.0), (1, 1, -1.0)]), 2.0 * 2.0 * root + 2.0 * 2.0 + 2.0 * 0.5, 0.5),
        ];
        for (body, area, allowed) in bodies {
            let placed = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
            let parts = placed.charts().iter().map(|chart| PatchArea::new(chart, &Placement::IDENTITY));
            let sum =
                parts.map(|part| divided(&part, [0.0; 2], 1.0, 0.5f64.powi(4))).fold(Approx::exact(0.0), Approx::add);
            assert!(
                (sum.value - area).abs() <= sum.error + 1e-12 && sum.error < allowed,
                "{body:?}: {sum:?}, not {area}"
            );
        }
    }

    /// Quadrics whose areas are known, cut into sheets and sides by rims and by equal gradients.
    #[test]
    fn cut_cells_hold_the_areas_of_quadrics() {
        let (ball, tube) = ([1.0, 1.0, 1.0, -0.49], [1.0, 0.0, 1.0, -0.25]);
        let quadric = |diagonal: [f64; 4]| {
            let matrix = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { diagonal[i] } else { 0.0 }));
            Analytic::Quadric { matrix, within: [[-1.0, -0.75, -1.0], [1.0, 0.75, 1.0]] }
        };
        let tilted = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7)) * 1.5;
        let whole = [(ball, TAU * 2.0 * 0.49), (tube, TAU * 0.5 * (1.5 + 0.5))];
        for (diagonal, area) in whole {
            for (map, stretch) in [(DMat3::IDENTITY, 1.0), (tilted, 2.25)] {
                let placement = Placement::new(DAffine3::from_mat3(map)).expect("regular");
                let placed = PlacedAnalytic::new(quadric(diagonal), placement).expect("a body");
                let parts = placed.charts().iter().map(|chart| PatchArea::new(chart, &placement));
                let sum = parts
                    .map(|part| divided(&part, [0.0; 2], 1.0, 0.5f64.powi(7)))
                    .fold(Approx::exact(0.0), Approx::add);
                let off = (sum.value - area * stretch).abs();
                assert!(off <= sum.error + 1e-12 && sum.error < 5e-3 * sum.value, "{diagonal:?} {sum:?} off {off}");
            }
        }
    }

    /// There series say nothing.
    #[test]
    fn finer_cells_say_more_along_the_edge_of_a_wedge() {
        let mut matrix = [[0.0; 4]; 4];
        (matrix[0][0], matrix[1][1]) = (-0.5, 0.5);
        let body = Analytic::Quadric { matrix, within: [[-0.5, -1.0, -1.0], [1.0, 0.25, 0.5]] };
        let placed = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
        // Each plane from its end of y to that of x, or x to y, and 1.5 long.
        let truth = 2f64.sqrt() * (0.75 + 1.25) * 1.5;
        let error = |level: i32| {
            let sheets = placed.charts().iter().take(4).map(|chart| PatchArea::new(chart, &Placement::IDENTITY));
            let sum = sheets
                .map(|sheet| divided(&sheet, [0.0; 2], 1.0, 0.5f64.powi(level)))
                .fold(Approx::exact(0.0), Approx::add);
            assert!((sum.value - truth).abs() <= sum.error, "{sum:?}, not {truth}");
            sum.error
        };
        let errors: Vec<f64> = (5..10).map(error).collect();
        assert!(errors.iter().zip(&errors[1..]).all(|(coarse, fine)| fine < coarse), "{errors:?}");
    }
}
