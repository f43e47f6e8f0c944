//! The fine step on one patch of a placed sphere.
//!
//! A cell of a patch is bounded by the cone of its four corner directions, cut by the plane through the sphere's
//! tangent at the middle and a parallel one through the deepest corner: eight points whose hull holds the cell. Signs
//! over the hull are signs over the cell ("curved cells use outward depth bounds"). Whether the surface faces the light
//! is the sign of its polar form, affine in the point; a sphere shadows itself exactly where it faces away.

use umbriel_geometry::{Approx, Dyadic, ExactPoint, Point, Ring, Sign, Sphere, Surd, blocking::Probe};

use glam::DVec3;
use umbriel_octree::Quadrant;

use super::{
    Blocker, Candidates, Occluders, Receiver,
    classify::Hull,
    field::Weights,
    flat::Levels,
    lattice::Lattice,
    pattern,
    solid_angle::PatchArea,
    tally::{Measure, Tally},
};
use crate::{
    bodies::Round,
    report::{Cell, Verdict},
};

/// Points of a hull.
const HULL: usize = 8;

/// Covers the roundings of a hull's construction: a dozen operations on numbers of the sphere's size.
const HULL_PADDING: f64 = 32.0 * f64::EPSILON;

/// One patch and all that may shadow it.
pub(crate) struct Patch<'a> {
    pub(crate) face: u32,
    pub(crate) object: u32,
    pub(crate) round: &'a Round,
    pub(crate) is_one_sided: bool,
    pub(crate) area: &'a PatchArea,
    pub(crate) occluders: &'a Occluders<'a>,
    /// Objects that may shadow this one.
    pub(crate) objects: &'a [u32],
    pub(crate) levels: Levels,
    pub(crate) lattice: Option<Lattice>,
    /// The exact answer for a point (u, v) of the patch.
    pub(crate) is_lit_exactly: &'a (dyn Fn(f64, f64) -> bool + Sync),
    pub(crate) is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// A cell's hull: in the world with slack, and in local coordinates.
struct CellHull {
    points: [Point<'static>; HULL],
    local: [[Approx; 3]; HULL],
}

impl Patch<'_> {
    /// Classifies the whole patch.
    pub(crate) fn run(&self) -> Tally<Approx> {
        let mut tally = Tally::new();
        let hull = self.hull(Quadrant::ROOT);
        let mut candidates = self.occluders.candidates(self.objects, &hull.points);
        candidates.spheres.retain(|&object| object != self.object);
        self.divide(Quadrant::ROOT, &candidates, &mut tally);
        tally
    }

    fn divide(&self, place: Quadrant, candidates: &Candidates, tally: &mut Tally<Approx>) {
        if (self.is_cancelled)() {
            return;
        }
        tally.examined += 1;
        let hull = self.hull(place);
        let (verdict, left) = match self.facing(&hull) {
            Some(false) => (Verdict::Shadowed, Candidates::default()),
            facing => {
                let (verdict, left) = self.classify(&hull, candidates);
                let open = facing.is_none() && verdict == Verdict::Lit;
                (if open { Verdict::Undecided } else { verdict }, left)
            }
        };
        if verdict != Verdict::Undecided || place.level() == self.levels.finest {
            self.count(place, verdict, tally);
        } else {
            for part in place.children() {
                self.divide(part, &left, tally);
            }
        }
    }

    /// Whether the light is strictly on the lit side of all of the cell, or nowhere; `None` where neither is proved.
    fn facing(&self, hull: &CellHull) -> Option<bool> {
        let form = &self.round.form;
        let light = self.occluders.light;
        let weight = Approx::exact(light.w());
        let local_light = form.pull_back(&light.xyz().to_array().map(Approx::exact), &weight);
        let local = |k: usize| form.lift(&hull.local[k]);
        let one = Approx::exact(1.0);
        let polar = (0..HULL).map(|k| form.value((&local(k), &one), (&local_light, &weight)));
        let signs: Vec<Option<Sign>> = polar.map(|value| value.sign()).collect();
        let all = |wanted: Sign| signs.iter().all(|&sign| sign == Some(wanted));
        // Seen from inside, a two-sided sphere turns its inner side to the light.
        let lit_from_inside = || !self.is_one_sided && !light.is_sun() && !self.light_is_outside();
        if all(Sign::Positive) {
            Some(true)
        } else if all(Sign::Negative) {
            Some(lit_from_inside())
        } else {
            None
        }
    }

    /// Whether a point light lies strictly outside the sphere. Exact: one on the surface is not outside.
    fn light_is_outside(&self) -> bool {
        let (form, source) = (&self.round.form, self.occluders.light);
        let weight = Approx::exact(source.w());
        let local = form.pull_back(&source.xyz().to_array().map(Approx::exact), &weight);
        let sign = form.value((&local, &weight), (&local, &weight)).sign().unwrap_or_else(|| {
            let form = self.round.sphere.exact_form::<Dyadic>(&self.round.placement);
            let light = ExactPoint::<Dyadic>::from_light(source);
            let local = form.pull_back(&light.xyz, &light.w);
            form.value((&local, &light.w), (&local, &light.w)).sign()
        });
        sign == Sign::Positive
    }

    fn classify(&self, hull: &CellHull, candidates: &Candidates) -> (Verdict, Candidates) {
        let receiver = Receiver { points: hull.points, light: self.occluders.light, facing: None };
        let blockers = self.occluders.blockers(candidates, &receiver);
        let unit = |k: usize| -> Weights<HULL> { std::array::from_fn(|l| f64::from(u8::from(k == l))) };
        let corners = (0..HULL).map(unit).collect();
        let cell = Hull { corners, center: [1.0 / HULL as f64; HULL], parameters: None };
        let mut entries = Vec::new();
        let verdict = blockers.classify(&cell, &blockers.entries(), &mut entries);
        let mut left = Candidates::default();
        for entry in entries {
            match entry.blocker() {
                Blocker::Polygon(index) => left.facets.push(blockers.polygons[index].id),
                Blocker::Sphere(index) => left.spheres.push(blockers.spheres[index].object),
            }
        }
        (verdict, left)
    }

    fn hull(&self, place: Quadrant) -> CellHull {
        let ([u, v], edge) = (place.low_corner(), place.edge());
        let at = |s: f64, t: f64| Sphere::direction(self.face as usize, u + s * edge, v + t * edge);
        let corners = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        let middle = at(0.5, 0.5).normalize();
        let radius = self.round.sphere.radius;
        let deepest = corners.map(|corner| middle.dot(corner) / corner.length()).into_iter().fold(1.0, f64::min);
        let reach = [radius * deepest * (1.0 - HULL_PADDING), radius * (1.0 + HULL_PADDING)];
        let local: [DVec3; HULL] =
            std::array::from_fn(|k| corners[k % 4] * (reach[k / 4] / middle.dot(corners[k % 4])));
        let map = self.round.placement.map();
        let points = local.map(|point| {
            let position = map.transform_point3(point);
            let size = map.matrix3.abs() * point.abs() + map.translation.abs();
            Point { position, slack: size * HULL_PADDING, exact: None }
        });
        let bounded = |v: f64| Approx { value: v, error: radius * HULL_PADDING };
        CellHull { points, local: local.map(|point| point.to_array().map(bounded)) }
    }

    fn count(&self, place: Quadrant, verdict: Verdict, tally: &mut Tally<Approx>) {
        let area = self.area.of_cell(self.face as usize, place);
        match verdict {
            Verdict::Lit => tally.lit.add(&area),
            Verdict::Shadowed => tally.shadowed.add(&area),
            Verdict::Undecided => {
                tally.undecided.add(&area);
                let ([u, v], edge) = (place.low_corner(), place.edge());
                let points = pattern::points(place);
                let lit = points.filter(|&[s, t]| (self.is_lit_exactly)(u + s * edge, v + t * edge));
                tally.likely.add(&area.part(lit.count() as u64));
                tally.points += 16;
            }
        }
        if self.levels.stored.is_some_and(|stored| place.level() <= stored || verdict == Verdict::Undecided) {
            tally.cells.push(Cell::new(self.face, 0, place, verdict));
        }
        for [u, v] in self.lattice.iter().flat_map(|lattice| lattice.points(place)) {
            let lit = match verdict {
                Verdict::Lit => true,
                Verdict::Shadowed => false,
                Verdict::Undecided => {
                    tally.points += 1;
                    (self.is_lit_exactly)(u, v)
                }
            };
            tally.samples.samples += 1;
            tally.samples.lit += u64::from(lit);
        }
    }
}

/// The exact point (u, v) of a patch, and floats round it.
pub(crate) fn patch_probe(round: &Round, patch: usize, u: f64, v: f64) -> Probe<'_, Surd> {
    let direction = Sphere::direction(patch, u, v);
    let local = direction * (round.sphere.radius / direction.length());
    let map = round.placement.map();
    let size = map.matrix3.abs() * local.abs() + map.translation.abs();
    // 2u − 1 may have cancelled: an error of one rounding of 1 in the direction.
    let slack = size * HULL_PADDING + map.matrix3.abs() * DVec3::splat(round.sphere.radius * HULL_PADDING);
    let bounds = Point { position: map.transform_point3(local), slack, exact: None };
    Probe::new(bounds, move || round.sphere.exact_point(&round.placement, patch, u, v))
}
