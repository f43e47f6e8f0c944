//! What must be answered about a position with a normal: the agreement of all surface points in its slack box.
//!
//! The box is taken a little too small where a surface has to be found, and twice too large where surface points have
//! to agree, so that the exact reading of "half an ulp" at zeros and at powers of two does not matter. Agreement is
//! proved on convex regions: a clipped face, or for a sphere the whole box. Where the proof fails, either answer passes.

use umbriel_geometry::LightSource;

use super::{
    Oracle,
    blocking::{Lamp, Place},
    body::{Bent, Body, Flat, Round},
    number::{Binary, Vector, dot, minus, plus, times, vector},
};

/// What a right answer looks like; `None` where either is right, or where the oracle cannot tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Expected {
    /// Whether the place is lit.
    pub(crate) lit: Option<bool>,
    /// Whether there is no surface in the box.
    pub(crate) in_space: Option<bool>,
}

/// What one body says about a box.
enum Finding {
    Absent,
    /// It meets the box, but its lit side looks elsewhere.
    Turned,
    /// It meets the box, and these of its points count: all lit, none lit, or not known.
    Counts(Option<bool>),
    Unknown,
}

/// A closed box about a position.
struct Slack {
    low: Vector,
    high: Vector,
}

impl Slack {
    /// Half an ulp of a type with `digits` binary digits and the least exponent `least`, times 2^`wider`.
    fn new(position: [f64; 3], (digits, least): (i64, i64), wider: i64) -> Self {
        let half = position.map(|coordinate| {
            let exponent = (coordinate.abs().to_bits() >> 52) as i64 - 1023;
            let exact_power = coordinate != 0.0 && coordinate.to_bits() & ((1 << 52) - 1) == 0;
            // Below a power of two the floats are twice as dense.
            let narrower = if exact_power && wider == 0 { 1 } else { 0 };
            Binary::power_of_two((exponent - digits).max(least - 1) + wider - narrower)
        });
        let center = vector(position);
        Self { low: minus(&center, &half), high: plus(&center, &half) }
    }

    fn corners(&self) -> Vec<Place> {
        let end = |i: usize, axis: usize| if i >> axis & 1 == 1 { &self.high[axis] } else { &self.low[axis] };
        (0..8).map(|i| Place::new(std::array::from_fn(|axis| end(i, axis).clone()))).collect()
    }

    /// The corners of what the box leaves of a convex polygon; no division, the weights grow instead.
    fn clip(&self, corners: &[Vector]) -> Vec<Place> {
        let mut polygon: Vec<(Vector, Binary)> =
            corners.iter().map(|corner| (corner.clone(), Binary::new(1.0))).collect();
        for axis in 0..3 {
            polygon = clipped(&polygon, |(p, w)| &p[axis] - &(w * &self.low[axis]));
            polygon = clipped(&polygon, |(p, w)| &(w * &self.high[axis]) - &p[axis]);
        }
        polygon.into_iter().map(|(position, weight)| Place::weighted(position, weight)).collect()
    }
}

type Weighted = (Vector, Binary);

fn clipped(polygon: &[Weighted], height: impl Fn(&Weighted) -> Binary) -> Vec<Weighted> {
    let mut kept = Vec::new();
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        let (of_p, of_q) = (height(p), height(q));
        if of_p.sign() >= 0 {
            kept.push(p.clone());
        }
        if of_p.sign() * of_q.sign() < 0 {
            // Both factors have the sign of the end above; made positive, they keep the weight positive.
            let (a, b) = if of_p.sign() > 0 { (-&of_q, of_p) } else { (of_q, -&of_p) };
            let position = plus(&times(&a, &p.0), &times(&b, &q.0));
            kept.push((position, &(&a * &p.1) + &(&b * &q.1)));
        }
    }
    kept
}

impl Oracle {
    /// What must be answered at a position that came as `f64` (`single` = false) or as `f32`.
    pub(crate) fn expected(&self, position: [f64; 3], normal: [f64; 3], single: bool, light: &LightSource) -> Expected {
        let kind = if single { (24, -149) } else { (53, -1074) };
        let (narrow, wide) = (Slack::new(position, kind, 0), Slack::new(position, kind, 1));
        let (lamp, normal) = (Lamp::new(light), vector(normal));
        let found = |slack: &Slack| -> Vec<Finding> {
            let of_body = |(number, body): (usize, &Body)| match body {
                Body::Flats(flats) => flats.iter().map(|flat| self.flat_in(flat, slack, &normal, &lamp)).collect(),
                Body::Round(round) => vec![self.round_in(number, round, slack, &normal, &lamp)],
                Body::Bent(bent) => vec![self.bent_in(number, bent, slack, &normal, &lamp)],
            };
            self.bodies.iter().enumerate().flat_map(of_body).collect()
        };
        let (narrow, wide) = (found(&narrow), found(&wide));
        if wide.iter().any(|finding| matches!(finding, Finding::Unknown)) {
            return Expected { lit: None, in_space: None };
        }
        if wide.iter().all(|finding| matches!(finding, Finding::Absent)) {
            return Expected { lit: Some(self.lit_in_space(position, light)), in_space: Some(true) };
        }
        let is_found = narrow.iter().any(|finding| matches!(finding, Finding::Turned | Finding::Counts(_)));
        let counts = narrow.iter().any(|finding| matches!(finding, Finding::Counts(_)));
        let answers: Vec<Option<bool>> = wide
            .iter()
            .filter_map(|finding| if let Finding::Counts(answer) = finding { Some(*answer) } else { None })
            .collect();
        let agreed = |lit: bool| answers.iter().all(|&answer| answer == Some(lit));
        let lit = (counts && (agreed(true) || agreed(false))).then(|| agreed(true));
        Expected { lit, in_space: is_found.then_some(false) }
    }

    fn flat_in(&self, flat: &Flat, slack: &Slack, normal: &Vector, light: &Lamp) -> Finding {
        let region = slack.clip(&flat.corners);
        let towards_light = light.side(&flat.normal, &flat.corners[0]);
        let lit_side = if flat.one_sided { 1 } else { towards_light };
        if region.is_empty() {
            Finding::Absent
        } else if !flat.one_sided && towards_light == 0 {
            Finding::Unknown
        } else if dot(&flat.normal, normal).sign() * lit_side <= 0 {
            Finding::Turned
        } else if towards_light * lit_side <= 0 {
            Finding::Counts(Some(false))
        } else {
            Finding::Counts(self.agreement(&region, None, light))
        }
    }

    fn round_in(&self, number: usize, round: &Round, slack: &Slack, normal: &Vector, light: &Lamp) -> Finding {
        let region = slack.corners();
        let common = |sign: &dyn Fn(&Place) -> i8| {
            let first = sign(&region[0]);
            region.iter().all(|x| sign(x) == first).then_some(first)
        };
        match common(&|x| round.surface.side(x)) {
            Some(-1) => return Finding::Absent,
            Some(_) if round.surface.is_apart_from(&region) => return Finding::Absent,
            Some(_) => return Finding::Unknown,
            None => {}
        }
        let outward = common(&|x| round.surface.outward(x, normal));
        let facing = common(&|x| round.surface.light_side(x, light));
        match (outward, facing) {
            (Some(1), Some(1)) => Finding::Counts(self.agreement(&region, Some(number), light)),
            (Some(1), Some(-1)) if round.one_sided => Finding::Counts(Some(false)),
            (Some(-1), Some(_)) if round.one_sided => Finding::Turned,
            _ => Finding::Unknown,
        }
    }

    fn bent_in(&self, number: usize, bent: &Bent, slack: &Slack, normal: &Vector, light: &Lamp) -> Finding {
        let (region, surface) = (slack.corners(), &bent.surface);
        let near = surface.near(&region);
        let piece = match near[..] {
            [] => return Finding::Absent,
            [piece] if bent.solid.is_convex() && surface.surely_meets(piece, &region) => piece,
            _ => return Finding::Unknown,
        };
        let common = |sign: &dyn Fn(&Place) -> i8| {
            let first = sign(&region[0]);
            region.iter().all(|x| sign(x) == first).then_some(first)
        };
        let outward = common(&|x| surface.outward(piece, x, normal));
        let facing = common(&|x| surface.light_side(piece, x, light));
        match (outward, facing) {
            (Some(1), Some(1)) => Finding::Counts(self.agreement(&region, Some(number), light)),
            (Some(1), Some(-1)) if surface.one_sided => Finding::Counts(Some(false)),
            (Some(-1), Some(_)) if surface.one_sided => Finding::Turned,
            _ => Finding::Unknown,
        }
    }

    /// Whether all points of a convex region are lit, or none; `own` is a convex curved body that the region lies on,
    /// facing the light.
    fn agreement(&self, region: &[Place], own: Option<usize>, light: &Lamp) -> Option<bool> {
        let others = || self.bodies.iter().enumerate().filter(|&(number, _)| Some(number) != own);
        let one_blocks = self.triangles.iter().any(|triangle| region.iter().all(|x| triangle.blocks(x, light)))
            || others().any(|(_, body)| match body {
                Body::Flats(_) => false,
                Body::Round(round) => round.surface.surely_blocks(region, light),
                Body::Bent(bent) => bent.surely_blocks(region, light),
            });
        let none_blocks = || {
            self.triangles.iter().all(|triangle| triangle.surely_misses(region, light))
                && others().all(|(_, body)| match body {
                    Body::Flats(_) => true,
                    Body::Round(round) => round.surface.surely_misses(region, light),
                    Body::Bent(bent) => bent.hull.surely_misses(region, light),
                })
        };
        if one_blocks { Some(false) } else { none_blocks().then_some(true) }
    }
}
