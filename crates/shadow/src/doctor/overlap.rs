//! Coplanar overlaps: faces of one plane that lie on each other, in one object or in two.
//!
//! Sorting by plane numbers ([`PlaneKey`]) leaves the faces that share a plane with another one; only these are placed
//! again, an eighth of them at a time where they are many, so that their corners need not all be kept. Inside a plane a tree over boxes proposes pairs, and an exact test decides ([`Plate::meeting`]).
//! Of objects that repeat another one the faces of the first stand for all, and of faces that an object repeats the first one does.
//! A face that is covered by several others counts what they cover one by one, its own area at most. In a plane where very many boxes meet, each face is
//! compared with some of the others only, and this is told ([`DefectKind::CrowdedPlane`]): all pairs would be the square of the input.

use std::{
    collections::{BTreeMap, HashMap},
    ops::ControlFlow,
};

use rayon::prelude::*;
use umbriel_bvh::BoxTree;
use umbriel_geometry::canonical_loop;
use umbriel_scene::Scene;

use crate::progress::{Cancelled, Progress};

use super::{
    defect::{Defect, DefectKind, Place},
    planes::PlaneKey,
    plate::{Meeting, Plate},
};

/// So many faces may be near others of their plane, and so many more for each of its faces, a pair from both sides: a microsecond each.
const FREE_PAIRS: usize = 1 << 18;
const PAIRS_EACH: usize = 32;

/// Faces are placed and kept until there are so many, or an eighth of all, then compared plane by plane.
const PLACED: usize = 1 << 16;

/// How many faces, and what of them, square metres: one an object and kind.
type Sums = BTreeMap<(DefectKind, u32), (usize, f64)>;

/// What covers a face, square metres; `None` while nothing does.
#[derive(Clone, Copy, Debug, Default)]
struct Covered {
    alike: Option<f64>,
    back_to_back: Option<f64>,
    /// The face's own area, where it was not compared with all that is near it.
    not_compared: Option<f64>,
}

/// The overlaps of all objects, from the numbers of their faces' planes; `firsts` says which objects repeat which, of these only the first has planes.
pub(super) fn find(
    scene: &Scene,
    planes: &[Vec<PlaneKey>],
    firsts: &[usize],
    progress: &dyn Progress,
) -> Result<Vec<Defect>, Cancelled> {
    let mut copies = vec![0u32; firsts.len()];
    firsts.iter().for_each(|&first| copies[first] += 1);
    let mut named: Vec<(PlaneKey, u32, u32)> = Vec::with_capacity(planes.iter().map(Vec::len).sum());
    for (object, keys) in planes.iter().enumerate() {
        let faces = keys.iter().enumerate().filter(|(_, key)| **key != PlaneKey::None);
        named.extend(faces.map(|(face, &key)| (key, object as u32, face as u32)));
    }
    if named.iter().any(|&(key, ..)| key == PlaneKey::Any) {
        // A face that may lie in any plane is tested against all faces.
        named.iter_mut().for_each(|(key, ..)| *key = PlaneKey::Any);
    }
    named.par_sort_unstable();
    let may_meet = |group: &&[(PlaneKey, u32, u32)]| group.len() > 1 || copies[group[0].1 as usize] > 1;
    let groups: Vec<&[(PlaneKey, u32, u32)]> = named.chunk_by(|a, b| a.0 == b.0).filter(may_meet).collect();
    let most = PLACED.max(groups.iter().map(|group| group.len()).sum::<usize>() / 8);
    let (mut placed, mut sums) = (0, Sums::new());
    let is_of_one_batch = |group: &&[_], _: &&[_]| {
        placed = if placed < most { placed + group.len() } else { group.len() };
        placed < most
    };
    for groups in groups.chunk_by(is_of_one_batch) {
        let plates = Plates::of(scene, groups, &copies, progress)?;
        let covered = groups
            .par_iter()
            .map(|group| if progress.is_cancelled() { Err(Cancelled) } else { Ok(covered(&plates.of_group(group))) });
        covered
            .collect::<Result<Vec<_>, Cancelled>>()?
            .into_iter()
            .flatten()
            .for_each(|covered| add(&mut sums, covered));
    }
    let mut defects = Vec::new();
    for (object, &first) in firsts.iter().enumerate() {
        for kind in [DefectKind::CoplanarOverlap, DefectKind::Contact, DefectKind::CrowdedPlane] {
            let sum = sums.get(&(kind, first as u32));
            defects.extend(sum.map(|&(count, area)| Defect::new(kind, Place::Object(object), count, area)));
        }
    }
    Ok(defects)
}

/// The faces that share a plane with another one, in the order of objects and faces.
struct Plates(Vec<((u32, u32), Plate)>);

impl Plates {
    fn of(
        scene: &Scene,
        groups: &[&[(PlaneKey, u32, u32)]],
        copies: &[u32],
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let mut faces: Vec<(u32, u32)> =
            groups.iter().flat_map(|group| group.iter().map(|&(_, object, face)| (object, face))).collect();
        faces.par_sort_unstable();
        let objects: Vec<&[(u32, u32)]> = faces.chunk_by(|a, b| a.0 == b.0).collect();
        let plates = objects.par_iter().map(|faces| {
            if progress.is_cancelled() {
                return Err(Cancelled);
            }
            let (object, copies) = (&scene.objects[faces[0].0 as usize], copies[faces[0].0 as usize]);
            let facets = object.facets().unwrap_or_default();
            let mut plates: Vec<((u32, u32), Plate)> = Vec::new();
            let mut known: HashMap<(Vec<u32>, bool), usize> = HashMap::new();
            for &(number, face) in *faces {
                let is_one_sided = object.is_one_sided(|| facets.is_closed(face as usize));
                // The same of faces that repeat each other, not of those turned round.
                let corners = (canonical_loop(facets.welded(face as usize).corners().to_vec()), is_one_sided);
                if let Some(&first) = known.get(&corners) {
                    plates[first].1.repeats += 1;
                } else if let Some(plate) = Plate::new((number, copies), &facets, face as usize, is_one_sided) {
                    known.insert(corners, plates.len());
                    plates.push(((number, face), plate));
                }
            }
            Ok(plates)
        });
        let plates = plates.collect::<Result<Vec<_>, Cancelled>>()?;
        Ok(Self(plates.into_iter().flatten().collect()))
    }

    fn of_group(&self, group: &[(PlaneKey, u32, u32)]) -> Vec<&Plate> {
        let place =
            |&(_, object, face): &(PlaneKey, u32, u32)| self.0.binary_search_by_key(&(object, face), |plate| plate.0);
        group.iter().filter_map(|face| place(face).ok()).map(|place| &self.0[place].1).collect()
    }
}

/// What is covered of the faces of one plane, with their objects and how often these have them.
fn covered(plates: &[&Plate]) -> Vec<((u32, u32), Covered)> {
    // Other copies of its object cover a face as it is.
    let by_copies = |plate: &&Plate| Covered { alike: (plate.copies > 1).then_some(plate.area), ..Covered::default() };
    let mut covered: Vec<Covered> = plates.iter().map(by_copies).collect();
    let (all, is_crowded) = meetings(plates);
    for (face, meetings) in all.into_iter().enumerate() {
        covered[face].not_compared = meetings.is_cut_short.then_some(plates[face].area);
        for (other, meeting) in meetings.found {
            let is_contact = meeting.is_back_to_back && (plates[face].is_one_sided || plates[other].is_one_sided);
            let concerned = [(face, other), (other, face)];
            for &(face, other) in &concerned[..if is_crowded { 1 } else { 2 }] {
                let Covered { alike, back_to_back, .. } = &mut covered[face];
                let sum = if is_contact { back_to_back } else { alike };
                let area = meeting.area * f64::from(coverers(plates[face], plates[other]));
                *sum = Some((sum.unwrap_or(0.0) + area).min(plates[face].area));
            }
        }
    }
    plates.iter().zip(covered).map(|(plate, covered)| ((plate.object, plate.repeats), covered)).collect()
}

/// The other faces of a plane that one shares an area with, in order.
#[derive(Default)]
struct Meetings {
    found: Vec<(usize, Meeting)>,
    is_cut_short: bool,
}

/// For each face of a plane what it meets: of the later ones, so that every pair is compared once; in a crowded plane, which is told, of all that it is compared with.
fn meetings(plates: &[&Plate]) -> (Vec<Meetings>, bool) {
    let boxes: Vec<_> = plates.iter().map(|plate| plate.bounds).collect();
    let tree = BoxTree::build(&boxes);
    // Those near a face, itself included, until there are more than so many: what is left of the limit then.
    let near = |i: usize, most: usize, visit: &mut dyn FnMut(usize)| {
        let mut left = most;
        let visit_next = |j| {
            if left == 0 {
                return ControlFlow::Break(());
            }
            left -= 1;
            visit(j as usize);
            ControlFlow::Continue(())
        };
        let ended = tree.for_each_where(|bounds| bounds.meets(&boxes[i]), visit_next);
        ended.is_continue().then_some(left)
    };
    let allowed = FREE_PAIRS + PAIRS_EACH * plates.len();
    let is_crowded = (0..plates.len()).try_fold(allowed, |left, i| near(i, left, &mut |_| {})).is_none();
    let most = if is_crowded { allowed / plates.len() } else { plates.len() };
    let of_face = |i: usize| {
        let mut others = Vec::new();
        let is_cut_short =
            near(i, most, &mut |j| others.extend((if is_crowded { j != i } else { j > i }).then_some(j))).is_none();
        others.sort_unstable();
        Meetings { found: others.into_iter().filter_map(|j| meeting(plates, i, j)).collect(), is_cut_short }
    };
    ((0..plates.len()).into_par_iter().map(of_face).collect(), is_crowded)
}

fn meeting(plates: &[&Plate], i: usize, j: usize) -> Option<(usize, Meeting)> {
    let (a, b) = (plates[i], plates[j]);
    // The same test from both sides.
    let meeting = plates[i.min(j)].meeting(plates[i.max(j)]).filter(|_| coverers(a, b) > 0)?;
    Some((j, meeting))
}

/// How many faces that are as `other` is count as covering a face that it meets: repeated triangles of one object are a kind of their own.
fn coverers(face: &Plate, other: &Plate) -> u32 {
    let is_repeated = face.object == other.object && face.has_corners_of(other);
    (other.copies - u32::from(is_repeated)) * other.repeats
}

/// Adds what covers a face of an object, each time that it has it.
fn add(sums: &mut Sums, ((object, repeats), covered): ((u32, u32), Covered)) {
    let Covered { alike, back_to_back, not_compared } = covered;
    let kinds = [
        (DefectKind::CoplanarOverlap, alike),
        (DefectKind::Contact, back_to_back),
        (DefectKind::CrowdedPlane, not_compared),
    ];
    for (kind, area) in kinds {
        let Some(area) = area else { continue };
        let sum = sums.entry((kind, object)).or_default();
        *sum = (sum.0 + repeats as usize, sum.1 + area * f64::from(repeats));
    }
}
