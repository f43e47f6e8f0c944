//! Looks at some of many: for faces under more facets than can be listed.
//!
//! Guarantee: which facets are looked at goes by them and by the face alone, whatever the order of objects, of facets and of axes. Memory: of an object over such a
//! face those of the trees of every second, fourth, eighth facet and so on that are asked for, as much again as its own tree at most; of an instance for each group of receivers.

use std::{
    cell::{OnceCell, RefCell},
    ops::ControlFlow,
    sync::OnceLock,
};

use glam::DVec3;
use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Facets, Point, blocking::Probe};

use super::{Among, LightFrame, Occluders, Thinned, Trees, fill_numbered, over};
use crate::{
    bodies::Body,
    exact::{Own, face_blocks, flat_face_is_lit},
    fine::{
        clearance::Clearance,
        field::Weights,
        flat::FLAT,
        polygon_blocker::{FacetId, PolygonBlocker},
        receiver::Receiver,
    },
    receivers::flat_corners,
    tickets::{self, halvings},
};

/// Some of the facets over a face.
pub(crate) struct Picked<'a> {
    /// The face as floats see it: what is measured against it asks no exact sign.
    face: Receiver<'a, FLAT>,
    /// In each frame that sees the face those that are over it there.
    over: Vec<(&'a LightFrame, Vec<Pick>)>,
}

/// A facet picked for a face.
struct Pick {
    id: FacetId,
    /// Its box in the frame.
    bounds: Aabb,
    /// What floats tell of it over the face, once it is asked for; `None` if it blocks no point of that.
    measured: OnceCell<Option<Box<PolygonBlocker<FLAT>>>>,
    /// Whether it hides points of which floats did not tell: cells share corners.
    settled: RefCell<Vec<(Weights<FLAT>, bool)>>,
}

impl Picked<'_> {
    /// How many there are, each for every frame that sees it.
    pub(crate) fn len(&self) -> usize {
        self.over.iter().map(|(_, picks)| picks.len()).sum()
    }
}

impl Pick {
    fn new(id: FacetId, bounds: Aabb) -> Self {
        Self { id, bounds, measured: OnceCell::new(), settled: RefCell::default() }
    }
}

/// A point of a face whose weights are exact.
pub(crate) struct Spot<'a> {
    pub(crate) probe: Probe<'a>,
    pub(crate) weights: Weights<FLAT>,
}

/// Facets that are looked at in the time in which one is measured.
const LOOKS: usize = 32;

/// What the items of a tree stand for.
enum Items<'a> {
    /// Facets of an object.
    Of(u32, &'a [u32]),
    /// Facets of all objects.
    All(&'a [FacetId]),
}

impl Items<'_> {
    fn facet(&self, item: u32) -> FacetId {
        match self {
            Self::Of(object, facets) => FacetId { object: *object, facet: facets[item as usize] },
            Self::All(facets) => facets[item as usize],
        }
    }
}

impl Occluders<'_> {
    /// How many of these facets and bodies have boxes over the hull of `points`, each for every frame that sees it, so no fewer than
    /// [`Occluders::candidates`] finds; counting ends at `most`.
    pub(crate) fn count(&self, among: Among, points: &[Point], most: usize) -> usize {
        let (mut count, ties) = (0, self.ties_over(points));
        let _ = self.for_each_over(among, points, |id| {
            count += usize::from(self.is_over_in(&ties, id));
            if count < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        count
    }

    /// What measuring a face against these facets comes to, in facets: those that floats do not tell to be clear of it, and one more for each [`LOOKS`] whose boxes
    /// are over it in a frame; counting ends at `most`. Cost: some tens of nanoseconds for each of the latter.
    pub(crate) fn burden(&self, among: Among, face: &Receiver<FLAT>, most: usize) -> usize {
        let (clearance, ties) = (Clearance::of(face), self.ties_over(&face.points));
        let (mut looked, mut left) = (0, 0);
        let _ = self.for_each_over(among, &face.points, |id| {
            looked += 1;
            let is_clear = clearance.as_ref().is_some_and(|face| self.is_clear(id, face));
            left += usize::from(!is_clear && self.is_over_in(&ties, id));
            if left + looked / LOOKS < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        (left + looked / LOOKS).min(most)
    }

    /// The same of a face of an object; nothing where that is turned away.
    pub(crate) fn burden_of_face(
        &self,
        among: Among,
        (object, facets, face): (usize, &Facets, usize),
        most: usize,
    ) -> usize {
        let turn = facets.turn(face, self.light);
        if !flat_face_is_lit(self.bodies, (object, face), self.light, Some(turn)) {
            return 0;
        }
        let corners = flat_corners(facets, face, facets.base(face).corner);
        self.burden(among, &Receiver::of_face(corners, self.light, turn), most)
    }

    /// Those of these facets over a face: halved as often as leaves no more than `limit`, once at least.
    pub(crate) fn pick<'s>(&'s self, among: Among, face: &Receiver<'s, FLAT>, limit: usize) -> Picked<'s> {
        let points = &face.points;
        let objects = match among {
            Among::Objects(objects) => self.seen_over(objects, points),
            Among::Throng(_) => Vec::new(),
        };
        let (among, most) = match among {
            Among::Objects(_) => {
                let most = objects.iter().map(|&object| self.thinned(object).len()).max().unwrap_or(0);
                (Among::Objects(&objects), most)
            }
            Among::Throng(throng) => (among, throng.halvings()),
        };
        let picks = (1..=most).rev().map_while(|times| self.all_over((among, times), points, limit));
        let face = Receiver { points: face.points, light: face.light, facing: None, plane: None };
        Picked { face, over: picks.last().unwrap_or_default() }
    }

    /// Those objects whose boxes are over the hull of `points`.
    fn seen_over(&self, objects: &[u32], points: &[Point]) -> Vec<u32> {
        let over = |object: &u32| {
            let views = self.frames.iter().enumerate();
            let mut views = views.filter_map(|(number, view)| Some((number, view.bounds(points).map(over)?)));
            views.any(|(number, query)| self.view_of_body(*object, number).is_some_and(|body| body.meets(&query)))
        };
        objects.iter().copied().filter(over).collect()
    }

    /// What is over a hull of the facets halved so often; `None` if it is more than `limit`.
    fn all_over(
        &self,
        (among, times): (Among, usize),
        points: &[Point],
        limit: usize,
    ) -> Option<Vec<(&LightFrame, Vec<Pick>)>> {
        let (mut left, ties) = (limit, self.ties_over(points));
        let mut picked = Vec::new();
        for (number, frame) in self.frames.iter().enumerate() {
            let Some(query) = frame.bounds(points).map(over) else { continue };
            let mut found = Vec::new();
            for (tree, items) in self.halved(among, times, number) {
                let enter = |bounds: &Aabb| bounds.meets(&query).then_some((0.0, *bounds));
                tree.for_each_entered(enter, 0.0, |item, (_, bounds), _| {
                    let id = items.facet(item);
                    if self.is_over_in(&ties, id) {
                        found.push(Pick::new(id, bounds));
                    }
                    // Past a negative parameter nothing is entered any more.
                    if found.len() <= left { 0.0 } else { -1.0 }
                });
                if found.len() > left {
                    return None;
                }
            }
            left -= found.len();
            picked.push((frame, found));
        }
        Some(picked)
    }

    /// The trees of these facets halved so often, once at least, in a frame.
    fn halved<'s>(&'s self, among: Among<'s>, times: usize, frame: usize) -> Vec<(&'s BoxTree, Items<'s>)> {
        let of_object = |&object: &u32| {
            let (tree, items) = &self.halved_of(object, times)?[frame];
            Some((tree, Items::Of(object, items)))
        };
        match among {
            Among::Objects(objects) => objects.iter().filter_map(of_object).collect(),
            Among::Throng(throng) => {
                let (tree, items) = throng.halved(times, frame);
                vec![(tree, Items::All(items))]
            }
        }
    }

    /// Whether one of the facets picked for a face covers a cell of it, given by the cell's corners. Exact, but for those whose rectangle does not hold that of the cell: they
    /// are passed over.
    pub(crate) fn is_covered(&self, (picked, own): (&Picked, FacetId), corners: &[Spot]) -> bool {
        // What lies behind a convex facet is convex.
        let covers = |pick: &Pick| self.is_solid(pick.id) && self.hides_all(&picked.face, pick, corners);
        self.that_may_cover(picked, &bounds_of(corners)).any(|pick| pick.id != own && covers(pick))
    }

    /// Those of the same facets that hide the middle of a cell, with their tickets.
    pub(crate) fn hiding(
        &self,
        (picked, own): (&Picked, FacetId),
        (corners, middle): (&[Spot], &Spot),
    ) -> Vec<(u64, FacetId)> {
        let may_cover = self.that_may_cover(picked, &bounds_of(corners)).filter(|pick| pick.id != own);
        let hiding = may_cover.filter(|pick| self.hides_all(&picked.face, pick, std::slice::from_ref(middle)));
        hiding.map(|Pick { id, .. }| (self.tickets(id.object)[id.facet as usize], *id)).collect()
    }

    /// Whether a facet hides all of some points. Exact; what floats leave open is settled only where they tell of no other point that
    /// it is not hidden.
    fn hides_all(&self, face: &Receiver<FLAT>, pick: &Pick, points: &[Spot]) -> bool {
        // Most are beside a point, which takes a few nanoseconds to tell: so few are measured.
        let is_new = pick.measured.get().is_none();
        if is_new && points.iter().any(|point| self.is_beside(pick.id, &point.probe.bounds)) {
            return false;
        }
        let measured = pick.measured.get_or_init(|| self.measured(pick.id, face).map(Box::new));
        let Some(polygon) = measured else { return false };
        points.iter().all(|point| polygon.blocks_at(&point.weights) != Some(false))
            && points.iter().all(|point| {
                let told = polygon.blocks_at(&point.weights);
                told.unwrap_or_else(|| self.hides_exactly(pick, point))
            })
    }

    /// Whether a facet hides a point of which floats do not tell; asked once.
    fn hides_exactly(&self, pick: &Pick, point: &Spot) -> bool {
        let known =
            pick.settled.borrow().iter().find(|(weights, _)| *weights == point.weights).map(|&(_, hides)| hides);
        known.unwrap_or_else(|| {
            let (object, facet) = (pick.id.object as usize, pick.id.facet as usize);
            let hides = face_blocks(self.bodies, (object, facet), &point.probe, Own::Nothing, self.light);
            pick.settled.borrow_mut().push((point.weights, hides));
            hides
        })
    }

    /// A facet measured against a face; `None` if it blocks no point of it.
    fn measured(&self, id: FacetId, face: &Receiver<FLAT>) -> Option<PolygonBlocker<FLAT>> {
        let Body::Flat(facets) = self.bodies.get(id.object as usize) else { return None };
        let numbers = facets.from_base(id.facet as usize).corners();
        let mut corners = [(facets.point(numbers[0]), 0); 4];
        fill_numbered(&mut corners, facets, &numbers);
        PolygonBlocker::new(id, &corners[..numbers.len()], self.turn(id), face, None)
    }

    /// Those picked whose rectangle holds that of a hull, in every frame that sees this.
    fn that_may_cover<'s>(&'s self, picked: &'s Picked, points: &[Point]) -> impl Iterator<Item = &'s Pick> + 's {
        let mut seen = picked.over.iter().filter_map(|(frame, found)| Some((*frame, frame.bounds(points)?, found)));
        let first = seen.next();
        let others = seen.map(|(frame, hull, _)| (frame, hull)).chain(self.ties_over(points));
        let others: Vec<(&LightFrame, Aabb)> = others.collect();
        let holds_in_others = move |pick: &&Pick| {
            others.iter().all(|(frame, hull)| self.view_of(pick.id, frame).is_some_and(|bounds| holds(&bounds, hull)))
        };
        let in_first =
            first.into_iter().flat_map(|(_, hull, found)| found.iter().filter(move |pick| holds(&pick.bounds, &hull)));
        in_first.filter(holds_in_others)
    }

    /// Whether a facet surely does not hide a point, by floats (NUMERICS.md, "Crowds"): tells most of them in a few nanoseconds.
    fn is_beside(&self, id: FacetId, point: &Point) -> bool {
        let Body::Flat(facets) = self.bodies.get(id.object as usize) else { return false };
        let (is_sun, x) = (self.light.is_sun(), point.position);
        let way = if is_sun { self.light.xyz() } else { self.light.xyz() - x };
        let corners = facets.facet(id.facet as usize).corners();
        let seen = |corner: &u32| facets.positions()[*corner as usize] - x;
        let sum = |v: DVec3| v.abs().element_sum();
        let doubt = 2.0 * sum(point.slack) + 2.0 * sum(point.rest);
        let mut from = corners.last().map_or(DVec3::ZERO, seen);
        let (mut is_left, mut is_right) = (false, false);
        for to in corners.iter().map(seen) {
            let turn = from.cross(to).dot(way);
            let reach = sum(from) + sum(to) + if is_sun { 0.0 } else { sum(way) };
            let product = reach * if is_sun { sum(way) } else { reach };
            let slack = (64.0 * f64::EPSILON * (sum(x) + reach) + doubt) * product;
            (is_left, is_right) = (is_left || turn > slack, is_right || turn < -slack);
            from = to;
        }
        is_left && is_right
    }

    fn is_solid(&self, id: FacetId) -> bool {
        matches!(self.bodies.get(id.object as usize), Body::Flat(facets) if facets.holes(id.facet as usize).is_none())
    }

    /// Places for trees of every second facet of an object, of every fourth and so on, down to the last ones that hold something.
    fn thinned(&self, object: u32) -> &[Thinned] {
        self.seen(object).thinned.get_or_init(|| {
            let most = self.tickets(object).iter().map(|&ticket| halvings(ticket)).max().unwrap_or(0);
            (0..most).map(|_| OnceLock::new()).collect()
        })
    }

    /// The trees of an object's facets halved so often, once at least: where many are over every face the larger ones are never asked for. `None` if nothing is left, or if the clock came
    /// first.
    fn halved_of(&self, object: u32, times: usize) -> Option<&Trees> {
        let trees = || {
            let Body::Flat(facets) = self.bodies.get(object as usize) else { return None };
            let tickets = self.tickets(object);
            self.trees_of(facets, |facet| usize::from(halvings(tickets[facet])) >= times)
        };
        self.thinned(object).get(times - 1)?.get_or_init(trees).as_ref()
    }

    /// The tickets of an object's facets; none of an analytic body.
    pub(crate) fn tickets(&self, object: u32) -> &[u64] {
        self.seen(object).tickets.get_or_init(|| match self.bodies.get(object as usize) {
            Body::Flat(facets) => tickets::tickets(&self.bodies.scene.objects[object as usize], facets),
            Body::Analytic(_) => Vec::new(),
        })
    }
}

/// Where some points surely are.
pub(crate) fn bounds_of(spots: &[Spot]) -> Vec<Point<'static>> {
    spots.iter().map(|spot| spot.probe.bounds).collect()
}

/// Whether a box is over a hull and hides all of its rectangle, as far as boxes tell.
fn holds(bounds: &Aabb, hull: &Aabb) -> bool {
    let across = |k: usize| bounds.min[k] <= hull.min[k] && bounds.max[k] >= hull.max[k];
    across(0) && across(1) && bounds.min.z <= hull.max.z
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, DQuat};
    use umbriel_geometry::{LightSource, Mesh, Placement, Rectangle, decisions::Decisions};
    use umbriel_scene::{Object, Scene, Shape, Sides};

    use super::*;
    use crate::bodies::Bodies;

    /// Triangles round the origin, corners at places of an irrational grid.
    fn strewn(count: u32) -> Scene {
        let step = [0.754_877_666, 0.569_840_291, 0.438_579_021];
        let at = |k: u32| step.map(|step: f64| (step * f64::from(k)).fract() * 4.0 - 2.0);
        let mesh =
            Mesh::new((0..3 * count).map(at).collect(), (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect());
        let shape = Shape::Mesh(Arc::new(mesh.expect("a mesh")));
        let object = Object::new("strewn".to_owned(), shape, Placement::IDENTITY, Sides::Two).expect("an object");
        Scene { objects: [object].into(), ..Scene::default() }
    }

    /// Rectangles about one point, each turned in its own way.
    fn crossing(count: u32) -> Scene {
        let object = |k: u32| {
            let [x, y, z, w] = [1, 2, 3, 5].map(|n| (0.618_033_989 * f64::from(n * (k + 1))).fract() - 0.5);
            let map = DAffine3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize());
            let placement = Placement::new(map).expect("regular");
            Object::new(k.to_string(), Shape::Rectangle(Rectangle { size: [1.0; 2] }), placement, Sides::Two)
        };
        Scene { objects: (0..count).map(|k| object(k).expect("an object")).collect(), ..Scene::default() }
    }

    /// Corners of cells, the common point of all rectangles among them.
    #[test]
    fn what_is_told_of_cells_is_exact() {
        let scene = crossing(12);
        let bodies = Bodies::new(&scene);
        let light = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
        let occluders = Occluders::new(&bodies, &light);
        let before = Decisions::of_thread();
        let (mut hidden, mut asked) = (0, 0);
        for (own, other) in (0..144).map(|pair| (pair / 12, pair % 12)).filter(|(own, other)| own != other) {
            let Body::Flat(facets) = bodies.get(own) else { panic!("a rectangle is flat") };
            let points = [0, 1, 2, 3].map(|k| facets.point(facets.facet(0).corners()[k]));
            let face = Receiver { points, light: &light, facing: None, plane: None };
            let pick = Pick::new(FacetId { object: other as u32, facet: 0 }, Aabb::EMPTY);
            for [u, v] in (0..25).map(|k| [k / 5, k % 5].map(|n| 0.25 * f64::from(n))) {
                let probe = Probe::on_face([points[0], points[1], points[3]], u, v);
                let hides = face_blocks(&bodies, (other, 0), &probe, Own::Nothing, &light);
                let spot = Spot { probe, weights: [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v] };
                assert_eq!(occluders.hides_all(&face, &pick, &[spot]), hides, "{other} over {own} at {u}, {v}");
                (hidden, asked) = (hidden + usize::from(hides), asked + 1);
            }
        }
        assert!(10 * hidden > asked && 2 * hidden < asked, "{hidden} hidden of {asked}");
        assert!((Decisions::of_thread() - before).exact > 0, "the common point");
    }

    /// Points behind inner points, edges and corners of triangles, an ulp or so to each side.
    #[test]
    fn what_hides_a_point_is_never_beside_it() {
        let scene = strewn(200);
        let bodies = Bodies::new(&scene);
        let Body::Flat(facets) = bodies.get(0) else { panic!("a mesh is flat") };
        let (mut hidden, mut beside, mut asked) = (0, 0, 0);
        for light in [LightSource::sun([0.3, -1.0, 0.2]), LightSource::point([0.5, 40.0, 0.25])] {
            let light = light.expect("a light");
            let occluders = Occluders::new(&bodies, &light);
            for facet in 0..200 {
                let [a, b, c] = [0, 1, 2].map(|k| facets.positions()[3 * facet + k]);
                for place in [0.25 * (a + b) + 0.5 * c, 0.5 * (a + b), 0.75 * a + 0.25 * c, b] {
                    let way = if light.is_sun() { light.xyz() } else { light.xyz() - place };
                    let behind = place - 1.25 * way;
                    for k in 0..27 {
                        let nudged = DVec3::from_array([1, 3, 9].map(|n| f64::from(k / n % 3 - 1)));
                        let x: Probe = Probe::at(behind + nudged * f64::EPSILON);
                        let id = FacetId { object: 0, facet: facet as u32 };
                        let hides = face_blocks(&bodies, (0, facet), &x, Own::Nothing, &light);
                        let is_beside = occluders.is_beside(id, &x.bounds);
                        assert!(!(hides && is_beside), "triangle {facet} at {place} under {light:?}");
                        let far = Point::exact(behind + 0.1 * (behind - place).cross(DVec3::X));
                        (hidden, asked) = (hidden + usize::from(hides), asked + 1);
                        beside += usize::from(occluders.is_beside(id, &far));
                    }
                }
            }
        }
        assert!(4 * hidden > asked && 4 * beside > asked, "{hidden} hidden, {beside} beside, of {asked}");
    }
}
