//! Finding what may block a receiver: every occluder's faces in a tree over their light-space boxes.
//!
//! A tree is built when a receiver first asks for its object. A face is handed out when its rectangle in light space
//! overlaps the receiver's and its least depth is not beyond the receiver's greatest; nothing that could block is left
//! out, since boxes are rounded outward.

mod facet_tree;
pub(crate) mod few;
mod object_index;
mod promise;
pub(crate) mod swarm;
pub(crate) mod throng;

use std::{collections::BTreeMap, ops::ControlFlow, sync::OnceLock, time::Instant};

use umbriel_geometry::{Aabb, Facets, LightSource, PlacedAnalytic, Point, Sign, analytic::Glance};

use super::{
    analytic_blocker::AnalyticBlocker,
    borders::DirectedEdge,
    classify::Blockers,
    clearance::Clearance,
    light_frame::LightFrame,
    light_values::LightValues,
    polygon_blocker::{FacetId, PolygonBlocker},
    raster::{Chain, GiveUp, Occluder, Plane, silhouette::Silhouette},
    receiver::Receiver,
};
use crate::{
    bodies::{Bodies, Body},
    by_object::ByObject,
};
use object_index::{ObjectIndex, Thinned, Trees};
use throng::Throng;

/// Shares of a body's facets are counted in parts of this size: whole numbers have the same sum in any order.
const SHARES: f64 = 1024.0;

/// Looks at facets between two at the clock.
const LOOKS: usize = 1 << 10;

/// What may block a receiver, by name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Candidates {
    /// Facets, each once; of [`Occluders::candidates`] sorted.
    pub(crate) facets: Vec<FacetId>,
    /// Objects that are analytic bodies.
    pub(crate) bodies: Vec<u32>,
}

impl Candidates {
    /// The objects that these are, or are of, ascending.
    pub(crate) fn objects(&self) -> Vec<u32> {
        let mut objects: Vec<u32> = self.facets.iter().map(|id| id.object).chain(self.bodies.iter().copied()).collect();
        objects.sort_unstable();
        objects.dedup();
        objects
    }

    /// The facets of each object; both ascend.
    pub(crate) fn facets_by_object(&self) -> BTreeMap<u32, Vec<u32>> {
        let of_one = |facets: &[FacetId]| (facets[0].object, facets.iter().map(|id| id.facet).collect());
        self.facets.chunk_by(|a, b| a.object == b.object).map(of_one).collect()
    }
}

/// What is looked through for what may block.
#[derive(Clone, Copy)]
pub(crate) enum Among<'a> {
    /// These objects, one after the other.
    Objects(&'a [u32]),
    /// All of the scene, by trees over all facets.
    Throng(&'a Throng),
}

/// All occluders of one light.
pub(crate) struct Occluders<'a> {
    pub(crate) bodies: &'a Bodies<'a>,
    pub(crate) light: &'a LightSource,
    frames: Vec<LightFrame>,
    /// Further frames of a sun that comes equally along several axes: what one of them shows to be out of the way is, so
    /// that no axis is the first.
    ties: Vec<LightFrame>,
    /// Two words an object until something of it is asked for.
    seen: ByObject<Box<Seen>>,
    /// The light-space box of each object's box in each frame that sees it; the ties last. Apart from the rest: of most objects nothing else is asked.
    views: ByObject<Box<[Option<Aabb>]>>,
    /// Those of all groups, where all but instances are kept.
    of_all: Option<&'a Self>,
    /// From when on nothing is built any more.
    deadline: OnceLock<Instant>,
}

/// One object as the light sees it.
#[derive(Default)]
struct Seen {
    turns: OnceLock<Vec<Sign>>,
    /// For analytic bodies the light as they see it.
    light: OnceLock<LightValues>,
    silhouette: OnceLock<Silhouette>,
    index: OnceLock<ObjectIndex>,
    /// Of its facets ([`tickets`](crate::tickets)).
    tickets: OnceLock<Vec<u64>>,
    /// Of every second facet, of every fourth and so on.
    thinned: OnceLock<Vec<Thinned>>,
}

impl<'a> Occluders<'a> {
    /// Nothing is built yet.
    pub(crate) fn new(bodies: &'a Bodies<'a>, light: &'a LightSource) -> Self {
        Self {
            bodies,
            light,
            frames: LightFrame::all(light),
            ties: LightFrame::ties(light),
            seen: ByObject::new(bodies.scene.objects.len()),
            views: ByObject::new(bodies.scene.objects.len()),
            of_all: None,
            deadline: OnceLock::new(),
        }
    }

    /// From now on what is found after this moment is of no use: what takes long is given up there.
    pub(crate) fn stop_at(&self, deadline: Instant) {
        self.deadline.get_or_init(|| deadline);
    }

    fn is_over(&self) -> bool {
        self.deadline.get().is_some_and(|deadline| Instant::now() >= *deadline)
    }

    /// For a group of receivers, to be forgotten with `bodies` ([`Bodies::of_group`]).
    pub(crate) fn of_group(bodies: &'a Bodies<'a>, all: &'a Self) -> Self {
        Self { of_all: Some(all), deadline: all.deadline.clone(), ..Self::new(bodies, all.light) }
    }

    /// Where what is known of an object is kept.
    fn keeper(&self, object: u32) -> &Self {
        self.of_all.filter(|_| !self.bodies.is_instance(object as usize)).unwrap_or(self)
    }

    fn seen(&self, object: u32) -> &Seen {
        self.keeper(object).seen.get_or_init(object as usize, Box::default)
    }

    /// Which way each facet of an object turns, seen from the light; for an analytic body, on which side of it the light
    /// lies.
    pub(crate) fn turns(&self, object: u32) -> &[Sign] {
        self.seen(object).turns.get_or_init(|| match self.bodies.get(object as usize) {
            // By one thread: one that waited for others here could take up work that waits for this very list.
            Body::Flat(facets) => facets.turns(self.light),
            Body::Analytic(body) => vec![body.light_side(self.light)],
        })
    }

    /// The border edges of an object with flat faces.
    pub(crate) fn silhouette(&self, object: u32, facets: &Facets) -> &Silhouette {
        self.seen(object)
            .silhouette
            .get_or_init(|| Silhouette::new(self.bodies.edges(object as usize, facets), self.turns(object)))
    }

    /// Adds the borders of a body with flat faces and no holes, or of `some` of its facets. An instance that the group has not placed is placed for this alone: a large
    /// face has all of them before it.
    pub(crate) fn add_borders(
        &self,
        (object, some): (u32, Option<&[u32]>),
        plane: &Plane,
        chain: &mut Chain,
    ) -> Result<(), GiveUp> {
        let (number, bounds) = (object as usize, &self.bodies.bounds(object as usize));
        if self.bodies.is_kept(number) {
            let Body::Flat(facets) = self.bodies.get(number) else { return Ok(()) };
            let turns = self.turns(object);
            let silhouette = match some {
                Some(some) => &Silhouette::of_some(facets, turns, some),
                None => self.silhouette(object, facets),
            };
            return chain.add(plane, &Occluder { facets, bounds, turns, silhouette, some });
        }
        if !plane.is_reached_by(bounds)? {
            return Ok(());
        }
        let Some(facets) = self.bodies.scene.objects[number].facets() else { return Ok(()) };
        let turns = facets.turns(self.light);
        let silhouette = match some {
            Some(some) => Silhouette::of_some(&facets, &turns, some),
            None => Silhouette::new(&self.bodies.edges_of(number, &facets), &turns),
        };
        chain.add(plane, &Occluder { facets: &facets, bounds, turns: &turns, silhouette: &silhouette, some })
    }

    /// Which way a facet turns, seen from the light.
    pub(crate) fn turn(&self, id: FacetId) -> Sign {
        self.turns(id.object)[id.facet as usize]
    }

    /// On which side of an analytic body the light lies: positive outside. Exact.
    pub(crate) fn side_of_light(&self, object: u32) -> Sign {
        self.turns(object)[0]
    }

    /// The light as a body sees it.
    pub(crate) fn light_at(&self, object: u32, body: &PlacedAnalytic) -> &LightValues {
        let side = self.side_of_light(object);
        self.seen(object).light.get_or_init(|| LightValues::new(body, self.light, side))
    }

    /// About how many facets of `objects` [`Occluders::candidates`] would find, from boxes alone; the same whatever the
    /// order of the axes and of the objects.
    pub(crate) fn expected_facets(&self, objects: &[u32], points: &[Point]) -> f64 {
        let views = self.frames.iter().chain(&self.ties).enumerate();
        let expected = views.map(|(number, frame)| {
            let face = frame.bounds(points);
            face.map_or(0, |face| objects.iter().map(|&object| self.expected_of(object, number, &face)).sum())
        });
        // Each frame of a lamp shows other facets, each of a sun all of them.
        let whole = if self.light.is_sun() { expected.max().unwrap_or(0) } else { expected.sum::<u64>() };
        whole as f64 / SHARES
    }

    /// How many facets of an object are expected over a face in a frame, times [`SHARES`].
    fn expected_of(&self, object: u32, frame: usize, face: &Aabb) -> u64 {
        if self.bodies.is_analytic(object as usize) {
            return 0;
        }
        let Some(body) = self.view_of_body(object, frame) else { return 0 };
        let area = |bounds: &Aabb| bounds.size().x * bounds.size().y;
        // Depths are left out: what is nearer than all of the face shadows it, too.
        let (min, max) = (body.min.max(face.min), body.max.min(face.max));
        let common = Aabb { min: min.with_z(0.0), max: max.with_z(0.0) };
        let whole = area(body);
        let share = if whole > 0.0 { area(&common) / whole } else { 1.0 };
        if common.is_empty() {
            0
        } else {
            (share * SHARES).round() as u64 * self.bodies.distinct_faces(object as usize) as u64
        }
    }

    /// The box of an object's box in a frame; the ties last.
    fn view_of_body(&self, object: u32, frame: usize) -> Option<&Aabb> {
        let keeper = self.keeper(object);
        let views = keeper.views.get_or_init(object as usize, || {
            let corners = box_corners(&keeper.bodies.bounds(object as usize));
            keeper.frames.iter().chain(&keeper.ties).map(|frame| frame.bounds(&corners)).collect()
        });
        views[frame].as_ref()
    }

    /// What of these may block some point of the hull of `points`.
    pub(crate) fn candidates(&self, among: Among, points: &[Point]) -> Candidates {
        let mut found = Candidates::default();
        let _ = self.for_each_over(among, points, |id| {
            if self.bodies.is_analytic(id.object as usize) {
                found.bodies.push(id.object);
            } else {
                found.facets.push(id);
            }
            ControlFlow::Continue(())
        });
        found.facets.sort_unstable();
        found.facets.dedup();
        found.bodies.sort_unstable();
        found.bodies.dedup();
        let ties = self.ties_over(points);
        found.facets.retain(|&id| self.is_over_in(&ties, id));
        found.bodies.retain(|&object| self.is_over_in(&ties, FacetId { object, facet: 0 }));
        found
    }

    /// Visits the facets and bodies whose boxes are over the hull of `points`, for every frame that sees them, until `visit` breaks.
    fn for_each_over(
        &self,
        among: Among,
        points: &[Point],
        mut visit: impl FnMut(FacetId) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.frames.iter().enumerate().try_for_each(|(frame, view)| match view.bounds(points).map(over) {
            Some(query) => self.for_each_among(among, frame, &query, &mut visit),
            None => ControlFlow::Continue(()),
        })
    }

    /// Visits the facets whose boxes in a frame meet `query` (of an analytic body the first), until `visit` breaks.
    fn for_each_among(
        &self,
        among: Among,
        frame: usize,
        query: &Aabb,
        mut visit: impl FnMut(FacetId) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        match among {
            Among::Objects(objects) => {
                let may_meet = |object: u32| self.view_of_body(object, frame).is_some_and(|body| body.meets(query));
                objects.iter().copied().filter(|&object| may_meet(object)).try_for_each(|object| {
                    self.for_each_meeting(object, frame, query, |facet| visit(FacetId { object, facet }))
                })
            }
            Among::Throng(throng) => throng.for_each_meeting(frame, query, visit),
        }
    }

    /// Visits the facets of an object whose boxes in a frame meet `query` (an analytic body is one), until `visit` breaks. The same for an instance as for
    /// a mesh that is alone.
    fn for_each_meeting(
        &self,
        object: u32,
        frame: usize,
        query: &Aabb,
        mut visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        match self.index(object) {
            ObjectIndex::Own(trees) => trees[frame].for_each_meeting(query, visit),
            ObjectIndex::Instance(mesh, tree, frames) => {
                let local = &frames[frame];
                local.for_each_near(tree, query, |facet| {
                    let corners = mesh.triangles()[facet as usize].map(|corner| mesh.positions()[corner as usize]);
                    let placed = || self.view_of(FacetId { object, facet }, &self.frames[frame]);
                    let meets = local.meets(corners, query);
                    let meets = meets.unwrap_or_else(|| placed().is_some_and(|bounds| bounds.meets(query)));
                    if meets { visit(facet) } else { ControlFlow::Continue(()) }
                })
            }
            ObjectIndex::Unbuilt => ControlFlow::Continue(()),
        }
    }

    /// What a facet must meet in the further frames of a light to be over the hull of `points`.
    fn ties_over(&self, points: &[Point]) -> Vec<(&LightFrame, Aabb)> {
        self.ties.iter().filter_map(|frame| Some((frame, over(frame.bounds(points)?)))).collect()
    }

    /// Whether none of these frames shows a facet (a body as a whole) to be out of the way.
    fn is_over_in(&self, ties: &[(&LightFrame, Aabb)], id: FacetId) -> bool {
        ties.iter().all(|(frame, query)| self.view_of(id, frame).is_some_and(|bounds| bounds.meets(query)))
    }

    /// The box of a facet (of a body as a whole) in a frame.
    fn view_of(&self, id: FacetId, frame: &LightFrame) -> Option<Aabb> {
        match self.bodies.get(id.object as usize) {
            Body::Flat(facets) => {
                let (points, count) = corners_of(facets, id.facet as usize);
                frame.bounds(&points[..count])
            }
            Body::Analytic(_) => frame.bounds(&box_corners(&self.bodies.bounds(id.object as usize))),
        }
    }

    /// An analytic body measured against a receiver; `None` for objects that are none.
    pub(crate) fn body<const N: usize>(&self, object: u32, receiver: &Receiver<N>) -> Option<AnalyticBlocker<'_, N>> {
        match self.bodies.get(object as usize) {
            Body::Analytic(body) => Some(AnalyticBlocker::new(object, body, self.light_at(object, body), receiver)),
            Body::Flat(_) => None,
        }
    }

    /// What floats say of ways to the light past an analytic body, if the light is outside of it.
    pub(crate) fn glance(&self, object: u32) -> Option<&Glance> {
        match self.bodies.get(object as usize) {
            Body::Analytic(body) => self.light_at(object, body).glance(),
            Body::Flat(_) => None,
        }
    }

    /// Whether floats say that an analytic body is in a point's way.
    pub(crate) fn probably_blocks(&self, object: u32, point: &Receiver<1>) -> bool {
        match self.glance(object) {
            Some(glance) => glance.blocks(point.points[0].position),
            None => self.body(object, point).is_some_and(AnalyticBlocker::probably_blocks_point),
        }
    }

    /// Leaves out the facets of which floats tell that they block no point of a face: most of what is over its box.
    pub(crate) fn leave_out_clear(&self, facets: &mut Vec<FacetId>, face: &Clearance) {
        facets.retain(|&id| !self.is_clear(id, face));
    }

    /// Whether floats tell of a facet that it blocks no point of a face.
    fn is_clear(&self, id: FacetId, face: &Clearance) -> bool {
        let Body::Flat(facets) = self.bodies.get(id.object as usize) else { return false };
        let corners = facets.facet(id.facet as usize).corners();
        face.tells_of(corners.iter().map(|&corner| facets.point(corner))) == Some(true)
    }

    /// What of these may block a receiver, measured component by component of each object until that of one is enough.
    pub(crate) fn blockers_until<const N: usize>(
        &self,
        candidates: &Candidates,
        (receiver, clearance): (&Receiver<N>, Option<&Clearance>),
        is_enough: impl Fn(&Blockers<N>) -> bool,
    ) -> Blockers<'_, N> {
        let component = |id: FacetId| self.bodies.component(id.object as usize, id.facet as usize);
        let mut facets: Vec<((u32, u32), FacetId)> =
            candidates.facets.iter().map(|&id| ((id.object, component(id)), id)).collect();
        facets.sort_by_key(|&(part, _)| part);
        let of = |part: &[((u32, u32), FacetId)], bodies: &[u32]| {
            self.blockers_of(part.iter().map(|&(_, id)| id), bodies, (receiver, clearance))
        };
        let mut all = Blockers::none();
        let mut parts = facets.chunk_by(|(a, _), (b, _)| a == b).peekable();
        while let Some(part) = parts.next() {
            let some = of(part, &[]);
            // What the last one does is asked of all together.
            let others = parts.peek().is_some() || !candidates.bodies.is_empty();
            if others && is_enough(&some) {
                return some;
            }
            all.append(some);
            if self.is_over() {
                break;
            }
        }
        all.append(of(&[], &candidates.bodies));
        all
    }

    /// Facets and bodies measured against a receiver; those that cannot block it after all are left out.
    pub(crate) fn blockers<const N: usize>(
        &self,
        facets: &[FacetId],
        bodies: &[u32],
        receiver: &Receiver<N>,
    ) -> Blockers<'_, N> {
        self.blockers_of(facets.iter().copied(), bodies, (receiver, Clearance::of(receiver).as_ref()))
    }

    fn blockers_of<const N: usize>(
        &self,
        facets: impl Iterator<Item = FacetId>,
        bodies: &[u32],
        (receiver, clearance): (&Receiver<N>, Option<&Clearance>),
    ) -> Blockers<'_, N> {
        let mut polygons = Vec::new();
        let (mut edges, mut holes) = (Vec::new(), Vec::new());
        for (number, id) in facets.enumerate() {
            if number % LOOKS == LOOKS - 1 && self.is_over() {
                break;
            }
            let Body::Flat(facets) = self.bodies.get(id.object as usize) else { continue };
            let corners = facets.facet(id.facet as usize).corners();
            let is_clear = clearance.and_then(|face| face.tells_of(corners.iter().map(|&corner| facets.point(corner))));
            if is_clear == Some(true) {
                continue;
            }
            let numbers = facets.from_base(id.facet as usize).corners();
            let (mut corners, count) = ([(facets.point(numbers[0]), 0); 4], numbers.len());
            fill_numbered(&mut corners, facets, &numbers);
            let turn = self.turn(id);
            let Some(mut blocker) = PolygonBlocker::new(id, &corners[..count], turn, receiver, is_clear) else {
                continue;
            };
            if let Some(cut_out) = facets.holes(id.facet as usize) {
                blocker.holes = Some(holes.len() as u32);
                holes.push(cut_out.counted_from(facets.base(id.facet as usize).corner));
            } else if !blocker.edge_on {
                let polygon = polygons.len() as u32;
                for side in 0..count {
                    let ends = [side, (side + 1) % count].map(|corner| corners[corner].1);
                    edges.push(DirectedEdge::new(id.object, ends, turn == Sign::Negative, polygon, side as u8));
                }
            }
            polygons.push(blocker);
        }
        let bodies = bodies.iter().filter_map(|&object| self.body(object, receiver));
        Blockers::new(polygons, bodies.collect(), holes, edges)
    }
}

/// What a box in light space must meet to be over this one.
fn over(bounds: Aabb) -> Aabb {
    Aabb { min: bounds.min.with_z(f64::NEG_INFINITY), ..bounds }
}

/// The corners of a facet, and how many there are.
fn corners_of(facets: &Facets, facet: usize) -> ([Point<'_>; 4], usize) {
    let numbers = facets.facet(facet).corners();
    let mut points = [facets.point(numbers[0]); 4];
    for (point, &corner) in points.iter_mut().zip(numbers.iter()) {
        *point = facets.point(corner);
    }
    (points, numbers.len())
}

/// Fills in the corners of a facet, each with the number of its place. Counted from its base, it makes no difference which corner it
/// begins with. In place, as a copy for each pair of a face and a facet would show.
#[inline(always)]
fn fill_numbered<'f>(corners: &mut [(Point<'f>, u32); 4], facets: &'f Facets, numbers: &[u32]) {
    for (corner, &number) in corners.iter_mut().zip(numbers) {
        *corner = (facets.point(number), facets.first_at(number));
    }
}

fn box_corners(bounds: &Aabb) -> [Point<'static>; 8] {
    bounds.corners().map(Point::exact)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use umbriel_geometry::{Mesh, Placement, Rectangle};
    use umbriel_scene::{Object, Scene, Shape, Sides};

    use super::*;

    /// A floor, and one metre above its middle a square of 200 triangles.
    fn sheet_over_floor() -> Scene {
        let positions = (0..121).map(|k| [f64::from(k % 11) * 0.1 - 0.5, 1.0, f64::from(k / 11) * 0.1 - 0.5]).collect();
        let squares = (0..100).map(|k| k / 10 * 11 + k % 10);
        let triangles = squares.flat_map(|k| [[k, k + 11, k + 1], [k + 1, k + 11, k + 12]]).collect();
        let sheet = Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a sheet")));
        let floor = Shape::Rectangle(Rectangle { size: [8.0; 2] });
        let object = |shape| Object::new("object".into(), shape, Placement::IDENTITY, Sides::Two).expect("an object");
        Scene { objects: [object(floor), object(sheet)].into(), ..Scene::default() }
    }

    #[test]
    fn what_is_nearer_than_all_of_a_face_is_expected_over_it() {
        let scene = sheet_over_floor();
        let bodies = Bodies::new(&scene);
        let floor = box_corners(&bodies.bounds(0));
        let expected = |direction: [f64; 3]| {
            let sun = LightSource::sun(direction).expect("a sun");
            Occluders::new(&bodies, &sun).expected_facets(&[1], &floor)
        };
        // From above, from aside with all of the shadow on the floor, half beside it, wholly beside.
        let shares = [[0.0, -1.0, 0.0], [2.0, -1.0, 0.0], [4.0, -1.0, 0.0], [6.0, -1.0, 0.0]].map(expected);
        for (share, known) in shares.into_iter().zip([200.0, 200.0, 100.0, 0.0]) {
            assert_eq!(share.round(), known, "{shares:?}");
        }
    }
}
