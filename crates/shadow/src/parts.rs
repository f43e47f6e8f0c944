//! Sampled receivers in parts, and what may shadow each part in lots, so that not all instances of meshes are placed at once.
//!
//! A part is a group of receivers that lie side by side as the light sees them ([`groups`](crate::groups)); a sample is lit if it is before every lot. What is in a lot is
//! sorted, answered and forgotten. Parts have at least as many faces as all objects that are no instances, which are kept anyhow; so these cost no more than the
//! instances by themselves. Where many parts share much of what may shadow them, parts are larger. A scene without instances is one part and one lot.
//!
//! Guarantee: the samples' answers are those of one part. Cost: an instance is placed for its own part and for each that it may shadow, two or three times as long
//! as all at once where many stand close together.

use umbriel_geometry::LightSource;

use crate::{bodies::Bodies, coarse::Influences, groups::groups_of, progress::Progress};

/// Faces of a part at least, some tens of megabytes; a lot has twice as many. Tests have more parts than one.
const FACES: usize = if cfg!(test) { 1 << 6 } else { 1 << 17 };

/// All parts and their lots together look at faces at most so many times as one part would: beyond that memory comes after time.
const MOST_LOOKS: u64 = 4;

/// Receivers that are sampled together.
pub(crate) struct Part {
    /// Places in the request.
    pub(crate) receivers: Vec<usize>,
    /// What may shadow them; one lot at least.
    pub(crate) lots: Vec<Lot>,
}

/// What the receivers of a part are held against at a time.
#[derive(Default)]
pub(crate) struct Lot {
    /// Ascending.
    pub(crate) occluders: Vec<u32>,
    /// Of these and of the receivers.
    pub(crate) faces: u64,
}

/// The receivers at these places of the request, in parts.
pub(crate) fn parts(
    bodies: &Bodies,
    receivers: &[usize],
    (light, influences): (&LightSource, &Influences),
    asked: Vec<usize>,
) -> Vec<Part> {
    let make = |group: Vec<usize>, most: usize| part(bodies, receivers, influences, (group, most));
    if !bodies.has_instances() {
        return vec![make(asked, usize::MAX)];
    }
    let whole = make(asked.clone(), usize::MAX);
    let kept = whole.lots[0].occluders.iter().filter(|&&object| !bodies.is_instance(object as usize));
    let mut most = FACES.max(kept.map(|&object| bodies.face_count(object as usize)).sum());
    let looks = |parts: &[Part]| parts.iter().flat_map(|part| &part.lots).map(|lot| lot.faces).sum::<u64>();
    let all = looks(std::slice::from_ref(&whole));
    loop {
        let groups = groups_of(bodies, receivers, light, (asked.clone(), most));
        let parts: Vec<Part> = groups.into_iter().map(|group| make(group, 2 * most)).collect();
        if parts.len() <= 1 || looks(&parts) <= MOST_LOOKS * all {
            return parts;
        }
        most *= 2;
    }
}

/// A group of receivers, and what may shadow them in lots of `most` faces.
fn part(bodies: &Bodies, receivers: &[usize], influences: &Influences, (group, most): (Vec<usize>, usize)) -> Part {
    let own: u64 = group.iter().map(|&receiver| bodies.face_count(receivers[receiver]) as u64).sum();
    let occluders = influences.occluders_of_all(group.iter().map(|&receiver| receivers[receiver]));
    let mut lots = vec![Lot { faces: own, ..Lot::default() }];
    let mut free = most as u64;
    for object in occluders {
        let faces = bodies.face_count(object as usize) as u64;
        if free == 0 {
            lots.push(Lot { faces: own, ..Lot::default() });
            free = most as u64;
        }
        free = free.saturating_sub(faces);
        if let Some(lot) = lots.last_mut() {
            lot.occluders.push(object);
            lot.faces += faces;
        }
    }
    Part { receivers: group, lots }
}

/// Tells how far all parts are.
pub(crate) struct PartOfAll<'a> {
    pub(crate) progress: &'a dyn Progress,
    /// Faces of lots that are done.
    pub(crate) before: u64,
    /// Those of this lot.
    pub(crate) own: u64,
    /// Those of all lots.
    pub(crate) all: u64,
}

impl Progress for PartOfAll<'_> {
    fn advance(&self, phase: &str, done: u64, total: u64) {
        let share = done as f64 / total.max(1) as f64;
        self.progress.advance(phase, self.before + (share * self.own as f64) as u64, self.all);
    }

    fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled()
    }
}
