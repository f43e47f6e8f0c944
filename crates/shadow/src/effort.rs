//! How much is done for a light: counted, not timed, so that it is the same everywhere.
//!
//! The unit is a facet held against a cell, about a tenth of a microsecond; all else that takes long again and again counts for as many as it takes longer. Before a
//! step of a look is taken, the look is told what it costs ([`Spend`]), and whether to take it; of some steps the cost is only known after them, and ends the next one. What a look finds
//! for which there was not enough is dropped.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use umbriel_scene::Scene;

use crate::coarse::most_faces;

/// Told what a step costs before it is taken; `false` if it is not to be.
pub(crate) type Spend<'a> = &'a (dyn Fn(u64) -> bool + Sync);

/// What holding a curved body against a cell costs, in facets.
pub(crate) const BODY: u64 = 24;

/// How many times that where numbers fall below the normal range of floats, in which processors take some hundred cycles for each.
pub(crate) const UNDERFLOWING: u64 = 16;

/// How many times what holding a body against a cell costs all points of a cell cost, where floats are asked whether it blocks them.
pub(crate) const BODIES_AT_POINTS: u64 = 2;

/// What holding a facet with holes against a cell costs, in facets without.
pub(crate) const CUT_OUT: u64 = 6;

/// What finding and measuring a facet over a face costs.
pub(crate) const MEASURED: u64 = 2;

/// Parts into which a cell is divided.
pub(crate) const PARTS: u64 = 4;

/// The typical effort: what the lights of a scene share, and what each of up to [`LIGHTS`] has beside that for each face. Where faces are many each is small.
const OF_SCENE: u64 = 3 << 24;
const OF_FACE: u64 = 1 << 10;
const OF_FURTHER_FACE: u64 = 1 << 8;
const FIRST_FACES: u64 = 1 << 15;

/// More lights share what so many have.
const LIGHTS: u64 = 16;

/// Threads tell each other what they spent when it is so much.
const TOLD: u64 = 1 << 12;

/// What a bake may take for each of so many lights where nobody said how fine the cells should be ([`Request::effort`](crate::Request::effort)): some seconds of a
/// thread for all of them together, and a tenth of a millisecond more for each face and light, a quarter of that for each beyond some ten thousand faces; more than sixteen lights
/// share what sixteen have. Ordinary scenes come nowhere near it at the typical depths; hundreds of bodies that all but coincide do, dozens of general quadrics, or of lights on dozens of curved bodies, and hundreds of lights on any.
pub fn typical_effort(scene: &Scene, lights: usize) -> u64 {
    let faces: u64 = scene.objects.iter().map(|object| most_faces(object) as u64).sum();
    let (lights, first) = (lights.max(1) as u64, faces.min(FIRST_FACES));
    let of_faces = OF_FACE * first + OF_FURTHER_FACE * (faces - first);
    (OF_SCENE + lights.min(LIGHTS) * of_faces) / lights
}

/// What all looks together may spend.
#[derive(Debug)]
pub(crate) struct Purse {
    pub(crate) most: u64,
    spent: AtomicU64,
}

impl Purse {
    pub(crate) fn new(most: u64) -> Self {
        Self { most, spent: AtomicU64::new(0) }
    }

    /// What is left of it without what another one has spent.
    pub(crate) fn without(&self, other: &Self) -> Self {
        Self::new(self.most - other.spent.load(Ordering::Relaxed).min(self.most))
    }

    /// What one look, or several in a row, spend of it.
    pub(crate) fn share(&self) -> Share<'_> {
        Share { purse: self, own: AtomicU64::new(0) }
    }

    /// Whether all that was spent was there.
    pub(crate) fn is_enough(&self) -> bool {
        self.spent.load(Ordering::Relaxed) <= self.most
    }
}

/// A part of what is spent of a [`Purse`], told to the others now and then and when it is dropped.
#[derive(Debug)]
pub(crate) struct Share<'a> {
    purse: &'a Purse,
    own: AtomicU64,
}

impl Share<'_> {
    /// `false` as soon as more is known to be spent than there is.
    pub(crate) fn spend(&self, work: u64) -> bool {
        let before = self.own.fetch_add(work, Ordering::Relaxed);
        let told = (before + work) / TOLD - before / TOLD;
        if told > 0 {
            self.purse.spent.fetch_add(told * TOLD, Ordering::Relaxed);
        }
        self.purse.is_enough()
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        self.purse.spent.fetch_add(*self.own.get_mut() % TOLD, Ordering::Relaxed);
    }
}

/// What looks that run beside each other spend, as if they were taken one after the other as long as there is something left: which of them are does not go
/// by how threads run.
#[derive(Debug)]
pub(crate) struct Ledger {
    left: u64,
    spent: Vec<AtomicU64>,
    /// For this one and those after it there is not enough, as far as is known.
    lacking: AtomicUsize,
}

impl Ledger {
    /// For so many looks.
    pub(crate) fn new(looks: usize, left: u64) -> Self {
        let spent = (0..looks).map(|_| AtomicU64::new(0)).collect();
        Self { left, spent, lacking: AtomicUsize::new(looks) }
    }

    /// What a look is about to spend; `false` as soon as it is known that there is not enough for it.
    pub(crate) fn spend(&self, look: usize, work: u64) -> bool {
        let before = self.spent[look].fetch_add(work, Ordering::Relaxed);
        let is_due = (before + work) / TOLD > before / TOLD;
        if is_due && self.spent[..=look].iter().map(|spent| spent.load(Ordering::Relaxed)).sum::<u64>() > self.left {
            self.lacking.fetch_min(look, Ordering::Relaxed);
        }
        look < self.lacking.load(Ordering::Relaxed)
    }

    /// What each look has spent; `None` from the first for which there was not enough.
    pub(crate) fn spent(self) -> impl Iterator<Item = Option<u64>> {
        let mut left = Some(self.left);
        self.spent.into_iter().map(move |spent| {
            let spent = spent.into_inner();
            left = left.and_then(|left| left.checked_sub(spent));
            left.map(|_| spent)
        })
    }
}

#[cfg(test)]
mod tests {
    use umbriel_geometry::{Analytic, Placement};
    use umbriel_scene::{Object, Shape, Sides};

    use super::*;

    #[test]
    fn lights_share_what_there_is() {
        let ball = Shape::from(Analytic::Sphere { radius: 1.0 });
        let ball = Object::new("ball".to_owned(), ball, Placement::IDENTITY, Sides::Auto).expect("an object");
        let scene = Scene { objects: [ball].into(), ..Scene::default() };
        let of_all = |lights: usize| lights as u64 * typical_effort(&scene, lights);
        assert_eq!(of_all(2) - of_all(1), OF_FACE * most_faces(&scene.objects[0]) as u64);
        assert!(of_all(1) < of_all(16) && of_all(100_000) <= of_all(16));
        assert_eq!(typical_effort(&scene, 0), of_all(1));
    }

    #[test]
    fn looks_are_taken_in_their_order_as_long_as_there_is_enough() {
        let ledger = Ledger::new(4, 10_000);
        assert!(ledger.spend(3, 9_000) && ledger.spend(0, 4_000), "nobody knows yet what those before it spend");
        assert!(!ledger.spend(1, 8_000), "12,000 of 10,000");
        assert!(!ledger.spend(3, 1) && !ledger.spend(2, 1), "those after it will not be taken either");
        assert!(ledger.spend(0, 1));
        assert_eq!(ledger.spent().collect::<Vec<_>>(), [Some(4_001), None, None, None]);
        let little = Ledger::new(2, 100);
        assert!(little.spend(0, 90) && little.spend(1, 20), "so little is not told");
        assert_eq!(little.spent().collect::<Vec<_>>(), [Some(90), None]);
    }

    #[test]
    fn shares_are_added_up() {
        let purse = Purse::new(10_000);
        let (one, two) = (purse.share(), purse.share());
        assert!(one.spend(6_000) && two.spend(4_000), "of these 4,096 are told");
        assert!(one.spend(3_000), "8,192 are");
        assert!(!two.spend(1_000), "12,288 are");
        drop((one, two));
        assert!(!purse.is_enough());
        let purse = Purse::new(10_000);
        let all_spent = (0..2).all(|_| purse.share().spend(5_000));
        assert!(all_spent && purse.is_enough(), "all of it is what there is");
        assert_eq!((Purse::new(12_000).without(&purse).most, Purse::new(9_000).without(&purse).most), (2_000, 0));
    }
}
