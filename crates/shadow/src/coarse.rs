//! The coarse step: which objects may shadow which, by their boxes and families (Xie et al. 2001, "Coarse step").
//!
//! Of objects that are one body in one place ([`first_alike`]) the first stands for all: what one blocks, all of them block, and none of them blocks more of
//! another than that one blocks of itself, since faces that coincide are in contact. So equal objects cost their boxes, not the square of their number. Lists of
//! occluders that would take too much memory are not kept, but found anew for each face; where there are so many pairs the step ends before it has seen them all,
//! and goes on ([`Influences::see_all`]) unless the scene is one in which pairs are not gone through ([`throng`](crate::throng)).
//!
//! Objects that cannot matter to what is asked are left out before: one test of their boxes, in columns ([`Objects::boxes`](umbriel_scene::Objects::boxes)), and nothing
//! that is made here has a place for them.

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

/// Where so small a part of a scene is left, families are not looked at: those of all the others would be gone through as well.
const FEW: usize = 8;

/// The objects of a scene as the coarse step looks at them, in places that follow each other; made once for all lights.
pub(crate) struct Coarse {
    present: Present,
    /// Over places, without those of what has no influence and of what is like one before it.
    tree: ObjectTree,
    /// Whether each place is of an object that may shadow something and is like none before it.
    is_occluder: Vec<bool>,
    alike: Alike,
    /// How many faces the object at each place has, at most.
    faces: Vec<u32>,
}

/// The objects that are not left out.
struct Present {
    /// Ascending.
    objects: Vec<u32>,
    /// How many objects the scene has.
    of: usize,
}

/// Which objects are one body in one place.
struct Alike {
    /// For each place the first that is the same.
    firsts: Vec<u32>,
    /// How many places each first one stands for; 0 for all others.
    counts: Vec<u32>,
}

/// Which objects may shadow which receivers under one light.
pub(crate) struct Influences<'a> {
    coarse: &'a Coarse,
    light: LightSource,
    /// For each place of a first object how many asked receivers it stands for.
    asked: Vec<u32>,
    /// Objects by the place of what they may shadow. `None` where there are too many pairs to keep.
    kept: Option<umbriel_bvh::Influences>,
    counts: PairCounts,
    /// Pairs of a face and a face of an object that may shadow it, equal objects once.
    face_pairs: u64,
    /// Whether all pairs were seen.
    is_whole: bool,
}

impl Coarse {
    /// What no light reaches is left out unless it is asked for, and so is what may shadow none of the receivers under `lights`, if these are known.
    pub(crate) fn new(bodies: &Bodies, receivers: &[usize], lights: Option<&[LightSource]>) -> Self {
        let Scene { objects, families, .. } = bodies.scene;
        let present = Present::of(bodies, receivers, lights.filter(|_| receivers.len() < objects.len()));
        let has_part = |&object: &u32| !is_nothing(bodies, object as usize);
        let mut is_occluder: Vec<bool> = present.objects.iter().map(has_part).collect();
        let alike = Alike::of(&present.bodies(objects), &is_occluder);
        let mut faces = vec![0; is_occluder.len()];
        for (place, &object) in present.objects.iter().enumerate().filter(|(place, _)| is_occluder[*place]) {
            faces[place] = most_faces(&objects[object as usize]) as u32;
        }
        is_occluder.iter_mut().zip(0u32..).for_each(|(is, place)| *is &= alike.firsts[place as usize] == place);
        let bounds =
            |place: u32| is_occluder[place as usize].then(|| bodies.bounds(present.objects[place as usize] as usize));
        let place_of = |object: usize| match objects.get(object) {
            Some(_) => present.place_of(object).filter(|&place| is_occluder[place]).map(|place| place as u32),
            // No place either.
            None => Some(u32::MAX),
        };
        let families = present.families_pay().then_some(families);
        let tree = object_tree(present.objects.len(), bounds, families, place_of);
        Self { present, tree, is_occluder, alike, faces }
    }

    /// The objects that are not left out, ascending.
    pub(crate) fn present(&self) -> &[u32] {
        &self.present.objects
    }

    /// The first object that is the same as this one, which is asked for, and whether it stands for itself only.
    pub(crate) fn first_of(&self, receiver: usize) -> (usize, bool) {
        let first = self.first_place(receiver);
        (self.present.objects[first] as usize, self.alike.counts[first] == 1)
    }

    fn first_place(&self, receiver: usize) -> usize {
        let place = self.present.place_of(receiver).expect("receivers are present");
        self.alike.firsts[place] as usize
    }

    /// Which objects may shadow each asked receiver. Ends where there are many pairs for so many objects.
    pub(crate) fn step(&self, receivers: &[usize], light: &LightSource) -> Influences<'_> {
        self.step_with(receivers, light, FIRST_PAIRS + PAIRS_AN_OBJECT * self.present.of)
    }

    /// As [`Coarse::step`]; it ends with more pairs than that.
    fn step_with(&self, receivers: &[usize], light: &LightSource, most: usize) -> Influences<'_> {
        let asked = self.asked(receivers);
        let (counts, face_pairs, is_whole) = Default::default();
        let mut influences =
            Influences { coarse: self, light: *light, asked, kept: None, counts, face_pairs, is_whole };
        influences.see(most, ControlFlow::Break(()));
        influences
    }

    /// For each place of a first object how many asked receivers it stands for.
    fn asked(&self, receivers: &[usize]) -> Vec<u32> {
        let (mut is_asked, mut asked) = (vec![false; self.faces.len()], vec![0; self.faces.len()]);
        for place in receivers.iter().filter_map(|&receiver| self.present.place_of(receiver)) {
            let is_new = !std::mem::replace(&mut is_asked[place], true);
            asked[self.alike.firsts[place] as usize] += u32::from(is_new);
        }
        asked
    }

    /// Objects of which others stand for none and that may shadow anything, ascending.
    pub(crate) fn occluders(&self) -> impl Iterator<Item = usize> + '_ {
        let places = self.present.objects.iter().zip(&self.is_occluder);
        places.filter(|(_, is_occluder)| **is_occluder).map(|(&object, _)| object as usize)
    }
}

impl Present {
    /// Without what is nothing, or dark, or, if the lights are known, in no shaft from all of the receivers together to a light; receivers are present in any case. The
    /// test of a shaft is monotone in both boxes, so nothing that may shadow one of the receivers goes. Cost: one test of a box an object and light.
    fn of(bodies: &Bodies, receivers: &[usize], lights: Option<&[LightSource]>) -> Self {
        let of = bodies.scene.objects.len();
        let mut objects =
            lights.map_or_else(|| (0..of as u32).collect(), |lights| in_shafts(bodies, receivers, lights));
        objects.retain(|&object| !is_nothing(bodies, object as usize));
        objects.extend(receivers.iter().map(|&receiver| receiver as u32));
        // Two runs, most often.
        objects.sort();
        objects.dedup();
        Self { objects, of }
    }

    /// Whether so many are present that it may pay to walk through the families of all.
    fn families_pay(&self) -> bool {
        self.objects.len() > self.of / FEW
    }

    /// Where an object is, if it is present.
    fn place_of(&self, object: usize) -> Option<usize> {
        if self.objects.len() == self.of {
            return Some(object).filter(|&object| object < self.of);
        }
        self.objects.binary_search(&(object as u32)).ok()
    }

    fn bodies<'o>(&self, objects: &'o [Object]) -> Vec<&'o Object> {
        self.objects.iter().map(|&object| &objects[object as usize]).collect()
    }
}

impl Alike {
    /// What has no part is like nothing.
    fn of(bodies: &[&Object], has_part: &[bool]) -> Self {
        let (mut firsts, mut counts): (Vec<u32>, _) = ((0..bodies.len() as u32).collect(), vec![1; bodies.len()]);
        let places: Vec<usize> = (0..bodies.len()).filter(|&place| has_part[place]).collect();
        let alike = first_alike(places.iter().map(|&place| bodies[place]));
        for (&place, first) in places.iter().zip(alike).filter(|(place, first)| **place != places[*first]) {
            firsts[place] = places[first] as u32;
            counts[place] = 0;
            counts[places[first]] += 1;
        }
        Self { firsts, counts }
    }
}

impl Influences<'_> {
    /// The objects that may shadow an asked receiver, ascending, of equal ones one: `receiver` itself where it is among them, unless it is flat.
    pub(crate) fn occluders_of(&self, receiver: u32) -> Cow<'_, [u32]> {
        let Coarse { present, tree, .. } = self.coarse;
        let place = self.coarse.first_place(receiver as usize) as u32;
        let object_at = |place: u32| present.objects[place as usize];
        let found = match &self.kept {
            Some(kept) => Cow::Borrowed(kept.occluders_of(place)),
            None => Cow::Owned(occluders_of(tree, &self.light, place).into_iter().map(object_at).collect()),
        };
        let first = object_at(place);
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
        let mut is_over = vec![false; self.coarse.present.of];
        for receiver in receivers {
            let occluders = self.occluders_of(receiver as u32);
            occluders.iter().for_each(|&occluder| is_over[occluder as usize] = true);
        }
        (0u32..).zip(is_over).filter(|(_, is_over)| *is_over).map(|(object, _)| object).collect()
    }

    /// Whether an asked receiver may have more occluders than that, equal ones counted once.
    pub(crate) fn has_longer_list_than(&self, most: usize) -> bool {
        let places = 0..self.asked.len() as u32;
        self.kept.as_ref().is_none_or(|kept| places.into_iter().any(|place| kept.occluders_of(place).len() > most))
    }

    /// The first object that is the same as this one.
    pub(crate) fn first_of(&self, receiver: usize) -> usize {
        self.coarse.first_of(receiver).0
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
        KEPT_PAIRS + PAIRS_AN_OBJECT * self.coarse.present.of
    }

    /// Keeps the pairs if they are no more than that; with more it goes on or breaks.
    fn see(&mut self, most: usize, beyond: ControlFlow<()>) {
        let (mut pairs, objects) = (Some(Vec::new()), &self.coarse.present.objects);
        self.count(|receivers, occluders| match &mut pairs {
            Some(kept) if kept.len() + receivers.len() * occluders.len() <= most => {
                let occluders = || occluders.iter().map(|&occluder| objects[occluder as usize]);
                kept.extend(receivers.iter().flat_map(|&receiver| occluders().map(move |object| (receiver, object))));
                ControlFlow::Continue(())
            }
            _ => {
                pairs = None;
                beyond
            }
        });
        let places = self.coarse.tree.objects();
        self.kept = pairs.map(|pairs| umbriel_bvh::Influences::of_pairs(pairs, places, self.counts));
    }

    /// Counts the pairs of first objects, and gives the places of some receivers and of what may shadow each of them to `take` until that breaks; those that broke it are counted, too.
    fn count(&mut self, mut take: impl FnMut(&[u32], &[u32]) -> ControlFlow<()>) {
        let (Coarse { tree, alike, faces, .. }, asked) = (self.coarse, &self.asked);
        let (mut registered, mut face_pairs, mut is_whole) = (0, 0u64, true);
        let sum = |of: &[u32], places: &[u32]| places.iter().map(|&place| u64::from(of[place as usize])).sum::<u64>();
        let register = |receivers: &[u32], occluders: &[u32]| {
            // Of a class that is its own occluder, each but itself.
            let own = u64::from(receivers == occluders);
            registered += sum(asked, receivers) * (sum(&alike.counts, occluders) - own);
            face_pairs = face_pairs.saturating_add(sum(faces, receivers).saturating_mul(sum(faces, occluders)));
            let taken = take(receivers, occluders);
            is_whole &= taken.is_continue();
            taken
        };
        let counts = for_each_influence(tree, &self.light, |place| asked[place as usize] > 0, register);
        (self.counts, self.face_pairs, self.is_whole) = (PairCounts { registered, ..counts }, face_pairs, is_whole);
    }
}

/// What may stand between all of the receivers together and a light, ascending.
fn in_shafts(bodies: &Bodies, receivers: &[usize], lights: &[LightSource]) -> Vec<u32> {
    let bounds = receivers.iter().map(|&receiver| bodies.bounds(receiver)).filter(|bounds| !bounds.is_empty());
    let around = bounds.fold(Aabb::EMPTY, Aabb::union);
    let boxes = bodies.scene.objects.boxes();
    // A bit an object.
    let mut met = vec![0u64; boxes.len().div_ceil(64)];
    for light in lights {
        let shaft = Shaft::new(&around, light);
        shaft.for_each_met(boxes, |object| {
            let (word, bit) = (&mut met[object / 64], 1 << (object % 64));
            if *word & bit == 0 && shaft.may_meet(&bodies.bounds(object)) {
                *word |= bit;
            }
        });
    }
    let met = met.into_iter().zip((0u32..).step_by(64)).filter(|(word, _)| *word != 0);
    met.flat_map(|(word, first)| (0..64).filter(move |bit| word >> bit & 1 == 1).map(move |bit| first + bit)).collect()
}

/// How many faces an object has, at most: without building the hull of a convex body.
pub(crate) fn most_faces(object: &Object) -> usize {
    match &object.shape {
        // Of triangles.
        Shape::Convex(body) => (2 * body.points().len()).saturating_sub(4),
        _ => object.face_count(),
    }
}

/// Whether an object has no part in anything: it is empty, or no light reaches it.
fn is_nothing(bodies: &Bodies, object: usize) -> bool {
    bodies.is_dark(object) || bodies.bounds(object).is_empty()
}

/// The tree of bounding cubes over all objects of a scene, by its families.
pub(crate) fn tree_of_all(scene: &Scene) -> ObjectTree {
    let bounds = |object: u32| Some(scene.objects[object as usize].bounds());
    object_tree(scene.objects.len(), bounds, Some(&scene.families), |object| Some(object as u32))
}

/// The tree of bounding cubes over places, by families of objects, each of which has a place or is left out. Without families, or where they do not form a tree over
/// the objects, these are grouped by where they stand.
fn object_tree(
    places: usize,
    bounds: impl Fn(u32) -> Option<Aabb>,
    families: Option<&FamilyTree>,
    place_of: impl Fn(usize) -> Option<u32>,
) -> ObjectTree {
    let build = |families: &Families| ObjectTree::build_of(places, &bounds, families);
    build(&families.map_or_else(Families::default, |families| families_of(families, place_of)))
        .unwrap_or_else(|_| build(&Families::default()).expect("fewer than 2^30 objects without families"))
}

/// The families as the tree takes them, without what has no place in it.
fn families_of(tree: &FamilyTree, place_of: impl Fn(usize) -> Option<u32>) -> Families {
    let member = |member: &umbriel_scene::Member| match *member {
        umbriel_scene::Member::Object(object) => place_of(object).map(Member::Object),
        umbriel_scene::Member::Family(family) => Some(Member::Family(family as u32)),
    };
    Families {
        members: tree.families.iter().map(|family| family.members.iter().filter_map(member).collect()).collect(),
        roots: tree.roots.iter().filter_map(member).collect(),
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
                let [a, b] = [occluder, receiver].map(|object| bodies.bounds(object));
                (occluder == receiver || may_shadow(&a, &b, &light)) && !cannot_shadow(&a, &b, &light)
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
