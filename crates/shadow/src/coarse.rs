//! The coarse step: which objects may shadow which, by their boxes and families (Xie et al. 2001, "Coarse step").
//!
//! Of objects that are one body in one place ([`first_alike`]) the first stands for all: what one blocks, all of them block, and none of them blocks more of
//! another than that one blocks of itself, since faces that coincide are in contact. So equal objects cost their boxes, not the square of their number. Lists of
//! occluders that would take too much memory are not kept, but found anew for each face; where there are so many pairs the step ends before it has seen them all,
//! and goes on ([`Influences::see_all`]) unless the scene is one in which pairs are not gone through ([`throng`](crate::throng)).

use std::{borrow::Cow, ops::ControlFlow};

use umbriel_bvh::{Families, Member, ObjectTree, PairCounts, Shaft, for_each_influence, occluders_of};
use umbriel_geometry::{Aabb, LightSource};
use umbriel_scene::{FamilyTree, Object, Scene, Shape, first_alike};

use crate::bodies::Bodies;

/// Pairs that are kept in any scene: 12 bytes each while they are sorted, 4 later.
const KEPT_PAIRS: usize = 1 << 24;

/// Pairs that are kept for each object besides: they take about as much as an object does.
const PAIRS_AN_OBJECT: usize = 64;

/// Pairs that are seen in any scene before it is asked whether all are to be, and [`PAIRS_AN_OBJECT`] besides: a tenth of a second.
const FIRST_PAIRS: usize = 1 << 18;

/// The objects of a scene as the coarse step looks at them; made once for all lights.
pub(crate) struct Coarse {
    tree: ObjectTree,
    alike: Alike,
    /// Which objects the tree does not have.
    is_left_out: Vec<bool>,
    /// How many faces each object has, at most.
    faces: Vec<u32>,
}

/// Which objects are one body in one place.
pub(crate) struct Alike {
    /// For each object the first that is the same.
    firsts: Vec<u32>,
    /// How many objects each first one stands for; 0 for all others.
    counts: Vec<u32>,
}

/// Which objects may shadow which receivers under one light.
pub(crate) struct Influences<'a> {
    coarse: &'a Coarse,
    light: LightSource,
    /// For each first object how many asked receivers it stands for.
    asked: Vec<u32>,
    /// `None` where there are too many pairs to keep.
    kept: Option<umbriel_bvh::Influences>,
    counts: PairCounts,
    /// Pairs of a face and a face of an object that may shadow it, equal objects once.
    face_pairs: u64,
    /// Whether all pairs were seen.
    is_whole: bool,
}

impl Coarse {
    /// What no light reaches is left out, and so is what may shadow none of the receivers under `lights`, if these are known.
    pub(crate) fn new(bodies: &Bodies, receivers: &[usize], lights: Option<&[LightSource]>) -> Self {
        let Scene { objects, families, .. } = bodies.scene;
        let boxes = &bodies.boxes[..];
        let is_nothing = |(object, bounds): (usize, &Aabb)| bodies.is_dark(object) || bounds.is_empty();
        let mut is_left_out: Vec<bool> = boxes.iter().enumerate().map(is_nothing).collect();
        if let Some(lights) = lights.filter(|_| receivers.len() < boxes.len()) {
            leave_out_idle(&mut is_left_out, boxes, receivers, lights);
        }
        let face_count =
            |(object, is_left_out): (&Object, &bool)| if *is_left_out { 0 } else { most_faces(object) as u32 };
        let faces = objects.iter().zip(&is_left_out).map(face_count).collect();
        let alike = Alike::of(objects, &is_left_out);
        is_left_out.iter_mut().zip(&alike.counts).for_each(|(is_left_out, count)| *is_left_out |= *count == 0);
        Self { tree: object_tree(boxes, |object| is_left_out[object as usize], families), alike, is_left_out, faces }
    }

    /// Which objects are one.
    pub(crate) fn alike(&self) -> &Alike {
        &self.alike
    }

    /// Which objects may shadow each asked receiver. Ends where there are many pairs for so many objects.
    pub(crate) fn step(&self, receivers: &[usize], light: &LightSource) -> Influences<'_> {
        self.step_with(receivers, light, FIRST_PAIRS + PAIRS_AN_OBJECT * self.alike.firsts.len())
    }

    /// As [`Coarse::step`]; it ends with more pairs than that.
    fn step_with(&self, receivers: &[usize], light: &LightSource, most: usize) -> Influences<'_> {
        let asked = self.alike.asked(receivers);
        let (counts, face_pairs, is_whole) = Default::default();
        let mut influences =
            Influences { coarse: self, light: *light, asked, kept: None, counts, face_pairs, is_whole };
        influences.see(most, ControlFlow::Break(()));
        influences
    }

    /// Objects of which others stand for none and that may shadow anything, ascending.
    pub(crate) fn occluders(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.is_left_out.len()).filter(|&object| !self.is_left_out[object])
    }
}

impl Alike {
    /// An object that is left out is like none.
    fn of(objects: &[Object], is_left_out: &[bool]) -> Self {
        let mut firsts: Vec<u32> = (0..objects.len() as u32).collect();
        let present: Vec<usize> = (0..objects.len()).filter(|&object| !is_left_out[object]).collect();
        let alike = first_alike(present.iter().map(|&object| &objects[object]));
        present.iter().zip(alike).for_each(|(&object, first)| firsts[object] = present[first] as u32);
        let mut counts = vec![0; firsts.len()];
        firsts.iter().for_each(|&first| counts[first as usize] += 1);
        Self { firsts, counts }
    }

    /// The first object that is the same as this one.
    pub(crate) fn first_of(&self, object: usize) -> usize {
        self.firsts[object] as usize
    }

    /// Whether a first object stands for itself only.
    pub(crate) fn is_alone(&self, first: usize) -> bool {
        self.counts[first] == 1
    }

    /// For each first object how many asked receivers it stands for.
    fn asked(&self, receivers: &[usize]) -> Vec<u32> {
        let mut is_asked = vec![false; self.firsts.len()];
        receivers.iter().for_each(|&receiver| is_asked[receiver] = true);
        let mut asked = vec![0; self.firsts.len()];
        let firsts = self.firsts.iter().zip(is_asked).filter(|(_, is_asked)| *is_asked);
        firsts.for_each(|(&first, _)| asked[first as usize] += 1);
        asked
    }
}

impl Influences<'_> {
    /// The objects that may shadow an asked receiver, ascending, of equal ones one: `receiver` itself where it is among them, unless it is flat.
    pub(crate) fn occluders_of(&self, receiver: u32) -> Cow<'_, [u32]> {
        let first = self.coarse.alike.firsts[receiver as usize];
        let found = match &self.kept {
            Some(kept) => Cow::Borrowed(kept.occluders_of(first)),
            None => Cow::Owned(occluders_of(&self.coarse.tree, &self.light, first)),
        };
        let own = if first == receiver { None } else { found.binary_search(&first).ok() };
        let Some(own) = own else { return found };
        let mut found = found.into_owned();
        found[own] = receiver;
        found.sort_unstable();
        found.into()
    }

    /// The objects that may shadow one of some asked receivers, ascending; where not all pairs were seen, others too.
    pub(crate) fn occluders_of_all(&self, receivers: impl Iterator<Item = usize>) -> Vec<u32> {
        if !self.is_whole {
            return self.coarse.occluders().map(|object| object as u32).collect();
        }
        let mut is_over = vec![false; self.coarse.faces.len()];
        for receiver in receivers {
            let occluders = self.occluders_of(receiver as u32);
            occluders.iter().for_each(|&occluder| is_over[occluder as usize] = true);
        }
        (0u32..).zip(is_over).filter(|(_, is_over)| *is_over).map(|(object, _)| object).collect()
    }

    /// What was done to find them; pairs of objects, however many are one.
    pub(crate) fn counts(&self) -> PairCounts {
        self.counts
    }

    /// Whether all pairs were seen: there are not too many to keep, or they were counted.
    pub(crate) fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Pairs of a face and a face of an object that may shadow it, equal objects once; of those that were seen.
    pub(crate) fn face_pairs(&self) -> u64 {
        self.face_pairs
    }

    /// Sees as many pairs as may be kept.
    pub(crate) fn see_more(&mut self) {
        if !self.is_whole {
            self.see(self.most_kept(), ControlFlow::Break(()));
        }
    }

    /// Sees all pairs, and keeps them unless they take too much memory.
    pub(crate) fn see_all(&mut self) {
        if !self.is_whole {
            self.see(self.most_kept(), ControlFlow::Continue(()));
        }
    }

    fn most_kept(&self) -> usize {
        KEPT_PAIRS + PAIRS_AN_OBJECT * self.coarse.faces.len()
    }

    /// Keeps the pairs if they are no more than that; with more it goes on or breaks.
    fn see(&mut self, most: usize, beyond: ControlFlow<()>) {
        let mut pairs = Some(Vec::new());
        self.count(|receiver, occluder| match &mut pairs {
            Some(kept) if kept.len() < most => {
                kept.push((receiver, occluder));
                ControlFlow::Continue(())
            }
            _ => {
                pairs = None;
                beyond
            }
        });
        let objects = self.coarse.tree.objects();
        self.kept = pairs.map(|pairs| umbriel_bvh::Influences::of_pairs(pairs, objects, self.counts));
    }

    /// Counts the pairs of first objects, and gives each to `take` until that breaks.
    fn count(&mut self, mut take: impl FnMut(u32, u32) -> ControlFlow<()>) {
        let (Coarse { tree, alike, faces, .. }, asked) = (self.coarse, &self.asked);
        let (mut registered, mut face_pairs, mut is_whole) = (0, 0u64, true);
        let register = |receiver: u32, occluder: u32| {
            // Of a class that is its own occluder, each but itself.
            let others = alike.counts[occluder as usize] - u32::from(occluder == receiver);
            registered += u64::from(asked[receiver as usize]) * u64::from(others);
            let [of_receiver, of_occluder] = [receiver, occluder].map(|object| u64::from(faces[object as usize]));
            face_pairs = face_pairs.saturating_add(of_receiver * of_occluder);
            let taken = take(receiver, occluder);
            is_whole &= taken.is_continue();
            taken
        };
        let counts = for_each_influence(tree, &self.light, |object| asked[object as usize] > 0, register);
        (self.counts, self.face_pairs, self.is_whole) = (PairCounts { registered, ..counts }, face_pairs, is_whole);
    }
}

/// How many faces an object has, at most: without building the hull of a convex body.
pub(crate) fn most_faces(object: &Object) -> usize {
    match &object.shape {
        // Of triangles.
        Shape::Convex(body) => (2 * body.points().len()).saturating_sub(4),
        _ => object.face_count(),
    }
}

/// The tree of bounding cubes over a scene's families. A scene whose families do not form a tree over its objects is grouped by place instead.
pub(crate) fn object_tree(boxes: &[Aabb], is_left_out: impl Fn(u32) -> bool, families: &FamilyTree) -> ObjectTree {
    let build = |families: &Families| ObjectTree::build_without(boxes, &is_left_out, families);
    build(&families_of(families))
        .unwrap_or_else(|_| build(&Families::default()).expect("fewer than 2^30 objects without families"))
}

/// Leaves out what lies in no shaft from all of the receivers together to a light. The test of a shaft is monotone in both boxes, so nothing that may shadow
/// one of the receivers goes. Cost: one test an object and light.
fn leave_out_idle(is_left_out: &mut [bool], boxes: &[Aabb], receivers: &[usize], lights: &[LightSource]) {
    let present: Vec<usize> = receivers.iter().copied().filter(|&receiver| !is_left_out[receiver]).collect();
    let all = present.iter().fold(Aabb::EMPTY, |all, &receiver| all.union(boxes[receiver]));
    let shafts: Vec<Shaft> = lights.iter().map(|light| Shaft::new(&all, light)).collect();
    for (is_left_out, bounds) in is_left_out.iter_mut().zip(boxes) {
        *is_left_out |= !shafts.iter().any(|shaft| shaft.may_meet(bounds));
    }
    present.iter().for_each(|&receiver| is_left_out[receiver] = false);
}

fn families_of(tree: &FamilyTree) -> Families {
    let member = |member: &umbriel_scene::Member| match *member {
        umbriel_scene::Member::Object(object) => Member::Object(object as u32),
        umbriel_scene::Member::Family(family) => Member::Family(family as u32),
    };
    Families {
        members: tree.families.iter().map(|family| family.members.iter().map(member).collect()).collect(),
        roots: tree.roots.iter().map(member).collect(),
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};
    use umbriel_bvh::{cannot_shadow, may_shadow};
    use umbriel_geometry::{Cuboid, Placement, Rectangle};
    use umbriel_scene::{Scene, Sides};

    use super::*;

    /// Boxes and flat squares, some of them several times, some beside each other.
    fn scene() -> Scene {
        let object = |k: u32| {
            let at = DVec3::new(f64::from(k % 5), f64::from(k * k % 7), f64::from(k % 3));
            let shape = if k.is_multiple_of(4) {
                Shape::Rectangle(Rectangle { size: [3.0; 2] })
            } else {
                Shape::Cuboid(Cuboid { size: [1.0, 2.0, 1.0] })
            };
            let placement = Placement::new(DAffine3::from_translation(at)).expect("regular");
            Object::new(format!("{k}"), shape, placement, Sides::Auto).expect("an object")
        };
        Scene { objects: (0..60).map(|k| object(k * k % 37)).collect(), ..Scene::default() }
    }

    /// Kept or found anew, the lists are those of all pairs of objects but that equal ones stand for each other, and all pairs are counted.
    #[test]
    fn the_first_stands_for_all_that_are_equal() {
        let scene = scene();
        let bodies = Bodies::new(&scene);
        let receivers: Vec<usize> = (0..60).filter(|object| object % 3 != 1).collect();
        let firsts = first_alike(&scene.objects);
        assert!(firsts.iter().enumerate().filter(|&(object, &first)| object != first).count() > 20);
        for light in [LightSource::sun([0.3, -1.0, 0.2]), LightSource::point([2.0, 5.0, 1.0])] {
            let light = light.expect("a light");
            let influences = |occluder: usize, receiver: usize| {
                let [a, b] = [occluder, receiver].map(|object| &bodies.boxes[object]);
                (occluder == receiver || may_shadow(a, b, &light)) && !cannot_shadow(a, b, &light)
            };
            let coarse = Coarse::new(&bodies, &receivers, Some(&[light]));
            let [kept, mut anew] = [usize::MAX, 5].map(|most| coarse.step_with(&receivers, &light, most));
            assert!(kept.kept.is_some() && anew.kept.is_none() && kept.is_whole() && !anew.is_whole());
            assert!(anew.counts().tested < kept.counts().tested / 2, "{:?}", anew.counts());
            anew.see(5, ControlFlow::Continue(()));
            assert!(anew.is_whole() && anew.face_pairs() == kept.face_pairs());
            let mut registered = 0;
            for &receiver in &receivers {
                let all: Vec<usize> = (0..60).filter(|&occluder| influences(occluder, receiver)).collect();
                registered += all.iter().filter(|&&occluder| occluder != receiver).count() as u64;
                let stands = |&object: &usize| {
                    if firsts[object] == firsts[receiver] { object == receiver } else { object == firsts[object] }
                };
                let expected: Vec<u32> = all.into_iter().filter(stands).map(|object| object as u32).collect();
                assert_eq!(*kept.occluders_of(receiver as u32), expected[..], "{receiver} under {light:?}");
                assert_eq!(*anew.occluders_of(receiver as u32), expected[..], "{receiver} under {light:?}");
            }
            assert_eq!((kept.counts().registered, kept.counts()), (registered, anew.counts()));
            assert!(registered > 300, "{registered}");
        }
    }
}
