//! Cells and portals that share space: allowed, since what is in two cells belongs to both, but mostly a slip.
//!
//! Two convex cells are apart if all of one lies in the plane of a face of the other, or outside it, or within
//! a rounding of it. Bodies that only a plane through an edge of each keeps apart are told as well; rooms that meet at walls are never among them.
//! Two portals between the same cells that lie in one plane are convex polygons there, and some edge's line keeps them apart or none does.

use std::collections::BTreeMap;

use glam::DVec3;
use umbriel_geometry::{Aabb, Brep, Sign};

use super::{
    CellEntry, CellGraph, Region, SceneCell, face_plane,
    portal::share_area,
    rounded::{apart, boxed, ulp},
};

/// So many pairs of portals are compared at most: a file may hold any number of them side by side.
const LOOKS: usize = 1 << 22;

/// Two entries that share space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Two cells, or two portals.
    pub entries: [CellEntry; 2],
    /// The middle of what the boxes round both have in common, metres: about where it is.
    pub near: DVec3,
}

impl CellGraph {
    /// The pairs of convex cells that overlap, then those of portals between the same cells, in the order of their entries; `most` pairs, and no more are
    /// looked for. Cost: O((c + p) log (c + p)) for c cells that lie side by side along some axis and p portals of which few lie beside each other along the
    /// longest axis, and a look at all faces of cells whose boxes share inside. At most four million pairs of portals are compared.
    pub fn overlaps(&self, most: usize) -> Vec<Overlap> {
        let mut found = Vec::new();
        for (number, cell) in self.cells.iter().enumerate() {
            let Region::Convex(body) = &cell.region else { continue };
            if found.len() >= most {
                return found;
            }
            let mut others = Vec::new();
            self.index.for_each_near(&self.cells, &body.bounds(), |other, other_body| {
                if other > number && found.len() + others.len() < most {
                    let [one, two] = [(cell, body), (&self.cells[other], other_body)];
                    let common = common(&body.bounds(), &other_body.bounds());
                    others.extend(
                        common.filter(|_| !keeps_out(one, two) && !keeps_out(two, one)).map(|common| (other, common)),
                    );
                }
            });
            others.sort_by_key(|&(other, _)| other);
            let overlap = |(other, common): (usize, Aabb)| Overlap {
                entries: [number, other].map(CellEntry::Cell),
                near: common.center(),
            };
            found.extend(others.into_iter().map(overlap));
        }
        self.add_portals(&mut found, most);
        found
    }

    fn add_portals(&self, found: &mut Vec<Overlap>, most: usize) {
        let mut between: BTreeMap<[usize; 2], Vec<(usize, Aabb)>> = BTreeMap::new();
        for (number, portal) in self.portals.iter().enumerate() {
            let [one, two] = portal.cells;
            let bounds = Aabb::of(portal.corners.iter().copied());
            between.entry([one.min(two), one.max(two)]).or_default().push((number, bounds));
        }
        let mut looks = LOOKS;
        let mut pairs: Vec<([usize; 2], DVec3)> = Vec::new();
        for mut portals in between.into_values() {
            let axis = portals.iter().fold(Aabb::EMPTY, |all, (_, own)| all.union(*own)).size().max_position();
            portals.sort_by(|(_, a), (_, b)| a.min[axis].total_cmp(&b.min[axis]));
            for (place, (number, bounds)) in portals.iter().enumerate() {
                let slack = self.portals[*number].slack.max(ulp([bounds.min, bounds.max].into_iter()));
                let wide = bounds.widened(DVec3::splat(slack));
                let beside = portals[place + 1..].iter().take_while(|(_, other)| other.min[axis] <= wide.max[axis]);
                for (other, other_bounds) in beside.take(looks) {
                    looks -= 1;
                    let is_shared = other_bounds.meets(&wide)
                        && found.len() + pairs.len() < most
                        && share_area(&self.portals[*number], &self.portals[*other]);
                    if is_shared {
                        let near = (bounds.min.max(other_bounds.min) + bounds.max.min(other_bounds.max)) * 0.5;
                        pairs.push(([*number.min(other), *number.max(other)], near));
                    }
                }
            }
        }
        pairs.sort_by_key(|&(numbers, _)| numbers);
        let overlap = |(numbers, near): ([usize; 2], DVec3)| Overlap { entries: numbers.map(CellEntry::Portal), near };
        found.extend(pairs.into_iter().map(overlap));
    }
}

/// What two boxes have in common, if that has an inside.
fn common(one: &Aabb, two: &Aabb) -> Option<Aabb> {
    let (min, max) = (one.min.max(two.min), one.max.min(two.max));
    min.cmplt(max).all().then_some(Aabb { min, max })
}

/// Whether the plane of a face has all of another cell outside or in it, or may have by the roundings of both: an ulp at least.
fn keeps_out((cell, body): (&SceneCell, &Brep), (other, other_body): (&SceneCell, &Brep)) -> bool {
    let slack = ulp(body.vertices().iter().chain(other_body.vertices()).copied()).max(cell.slack).max(other.slack);
    let is_kept_out = |face: usize, vertex: DVec3| {
        let [a, b, c] = face_plane(body, face).map(|corner| boxed(corner, slack));
        apart(&a, &b, &c, &boxed(vertex, slack)) != Some(Sign::Negative)
    };
    (0..body.face_count()).any(|face| other_body.vertices().iter().all(|&vertex| is_kept_out(face, vertex)))
}
