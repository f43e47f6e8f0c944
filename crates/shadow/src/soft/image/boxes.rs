//! The outlines of boxes seen from a light, and the two points between which penumbrae are interpolated.
//!
//! Duan, "A fast soft shadows algorithm for dynamic scene in MMOG" (Computer Knowledge and Technology 2009(15)), steps 1 to 4: each box's corners go to light space;
//! of its corners those on a face turned to the light stay, but for one on three such faces, which is inside; a corner inside of another box's outline (and,
//! a condition of ours, behind that box) shapes no shadow, and a box without corners is dropped. Of each outline that is left, the middles of its two
//! corners nearest to the light's plane and of its two farthest are taken; over the outlines of a blocker, the nearest is *max*, where penumbrae are
//! widest, the farthest *min*. Ours: one pair a blocker instead of one a scene; the receiver's own depth; outlines on the map's image, so
//! that they are where the depth map has them; and boxes that are replaced by their parts ([`super::BoxTree`]) where their depths leave the width open by more than
//! is tolerated. A few dozen operations a box and frame.

use glam::{DVec2, DVec3};
use umbriel_geometry::Cuboid;
use umbriel_visibility::depth_map::LightSpace;

/// A box that stands in space as it likes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    /// World coordinates, in the order of [`Cuboid::corners`].
    pub corners: [DVec3; 8],
}

impl OrientedBox {
    /// Whether something of a body, given by points round it, may be behind the box as the light sees it: none of the box's faces that
    /// are turned to the light has the body on its closed front side, up to rounding.
    pub fn may_hide(&self, space: &LightSpace, points: &[DVec3]) -> bool {
        let seen: Vec<DVec3> = points.iter().map(|&point| space.to_light(point)).collect();
        turned_faces(space, &self.corners.map(|corner| space.to_light(corner))).all(|(_, normal, corner)| {
            seen.iter().any(|&point| {
                let size = normal.abs().dot(point.abs() + corner.abs());
                // Some thirty roundings from local coordinates to here.
                normal.dot(point - corner) < -64.0 * f64::EPSILON * size
            })
        })
    }
}

/// The faces of a box (in light space) that are turned to the light: corners, outward normal, a point.
fn turned_faces<'a>(
    space: &'a LightSpace,
    seen: &'a [DVec3; 8],
) -> impl Iterator<Item = ([u32; 4], DVec3, DVec3)> + 'a {
    let middle = seen.iter().sum::<DVec3>() / 8.0;
    Cuboid::FACES.into_iter().filter_map(move |face| {
        let [a, b, _, d] = face.map(|corner| seen[corner as usize]);
        let normal = (b - a).cross(d - a);
        let outward = if normal.dot(a - middle) < 0.0 { -normal } else { normal };
        space.is_turned_to_light(outward, a).then_some((face, outward, a))
    })
}

/// A box's outline as the light sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Places on the image and depths of its corners, in order round it, without those that were dropped.
    pub corners: Vec<DVec3>,
    /// All of its corners on the image, counter-clockwise.
    hull: Vec<DVec2>,
    /// The rectangle round them.
    low: DVec2,
    high: DVec2,
    /// Of the box.
    depths: [f64; 2],
}

impl Outline {
    /// Step 1: which corners lie on one or two faces turned to the light. A box that reaches the plane of a lamp has no outline,
    /// nor has one that is flattened to a line or a point.
    pub fn of(space: &LightSpace, oriented: &OrientedBox) -> Option<Self> {
        let seen = oriented.corners.map(|corner| space.to_light(corner));
        if seen.iter().any(|&corner| !space.is_before(corner)) {
            return None;
        }
        let mut counts = [0; 8];
        for (face, _, _) in turned_faces(space, &seen) {
            face.iter().for_each(|&corner| counts[corner as usize] += 1);
        }
        let on_outline = (0..8).filter(|&corner| counts[corner] == 1 || counts[corner] == 2);
        let mut corners: Vec<DVec3> = on_outline.map(|k| space.image(seen[k]).extend(seen[k].z)).collect();
        if corners.is_empty() {
            return None;
        }
        let centre = corners.iter().map(|corner| corner.truncate()).sum::<DVec2>() / corners.len() as f64;
        let turn = |corner: &DVec3| {
            let way = corner.truncate() - centre;
            libm::atan2(way.y, way.x)
        };
        corners.sort_by(|a, b| turn(a).total_cmp(&turn(b)));
        let hull: Vec<DVec2> = corners.iter().map(|corner| corner.truncate()).collect();
        let low = hull.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = hull.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let depth = |pick: fn(f64, f64) -> f64, start| seen.iter().map(|corner| corner.z).fold(start, pick);
        Some(Self { corners, hull, low, high, depths: [depth(f64::min, f64::INFINITY), depth(f64::max, 0.0)] })
    }

    /// The nearest and the farthest depth of the box, metres.
    pub fn depths(&self) -> [f64; 2] {
        self.depths
    }

    /// Whether a corner is inside and not nearer to the light than the box.
    fn hides(&self, corner: DVec3) -> bool {
        corner.z > self.depths[0] && self.covers(corner.truncate())
    }

    /// Whether a place on the image is inside.
    pub(super) fn covers(&self, place: DVec2) -> bool {
        if place.cmple(self.low).any() || place.cmpge(self.high).any() {
            return false;
        }
        let next = self.hull.iter().cycle().skip(1);
        self.hull.len() > 2 && self.hull.iter().zip(next).all(|(&a, &b)| (b - a).perp_dot(place - a) > 0.0)
    }

    /// Step 3: the middles of its two nearest corners and of its two farthest; `None` without corners.
    fn extremes(&self) -> Option<[DVec3; 2]> {
        let mut sorted = self.corners.clone();
        sorted.sort_by(|a, b| a.z.total_cmp(&b.z));
        let last = sorted.len().checked_sub(1)?;
        Some([0.5 * (sorted[0] + sorted[1.min(last)]), 0.5 * (sorted[last] + sorted[last.saturating_sub(1)])])
    }
}

/// Step 2: the outlines without the corners that others hide; those that lose all of them are dropped. O(outlines²).
pub fn visible_outlines(whole: &[Outline]) -> Vec<Outline> {
    let shapes = |number: usize, corner: &DVec3| {
        !whole.iter().enumerate().any(|(other, outline)| other != number && outline.hides(*corner))
    };
    let visible = whole.iter().enumerate().map(|(number, outline)| {
        let corners = outline.corners.iter().copied().filter(|corner| shapes(number, corner)).collect();
        Outline { corners, ..outline.clone() }
    });
    visible.filter(|outline| !outline.corners.is_empty()).collect()
}

/// Step 2 where each outline is a blocker by itself: as [`visible_outlines`], but an outline is dropped only if a single other one hides all of its corners,
/// and so covers it. Neighbours may hide each other's corners all round and leave a hole if they all go; one that only several hide stays whole.
pub fn covering_outlines(whole: &[Outline]) -> Vec<Outline> {
    let left = whole.iter().enumerate().filter_map(|(number, outline)| {
        let others = || whole.iter().enumerate().filter(|(other, _)| *other != number).map(|(_, outline)| outline);
        let hides = |other: &Outline, corner: &DVec3| other.hides(*corner);
        if others().any(|other| outline.corners.iter().all(|corner| hides(other, corner))) {
            return None;
        }
        let shapes = |corner: &DVec3| !others().any(|other| hides(other, corner));
        let corners: Vec<DVec3> = outline.corners.iter().copied().filter(shapes).collect();
        Some(if corners.is_empty() { outline.clone() } else { Outline { corners, ..outline.clone() } })
    });
    left.collect()
}

/// A blocker: the two points between which penumbrae are interpolated, and how far its outlines reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocker {
    /// Place on the image and depth of *max*, the nearest to the light.
    pub nearest: DVec3,
    /// Place on the image and depth of *min*, the farthest.
    pub farthest: DVec3,
    /// The nearest depth of its boxes.
    front: f64,
    low: DVec2,
    high: DVec2,
}

impl Blocker {
    /// Steps 3 and 4 over the outlines of one blocker; `None` without corners.
    pub fn of(outlines: &[Outline]) -> Option<Self> {
        let pairs: Vec<[DVec3; 2]> = outlines.iter().filter_map(Outline::extremes).collect();
        let nearest = pairs.iter().map(|pair| pair[0]).min_by(|a, b| a.z.total_cmp(&b.z))?;
        let farthest = pairs.iter().map(|pair| pair[1]).max_by(|a, b| a.z.total_cmp(&b.z))?;
        let front = outlines.iter().map(|outline| outline.depths[0]).fold(f64::INFINITY, f64::min);
        let low = outlines.iter().map(|outline| outline.low).fold(DVec2::INFINITY, DVec2::min);
        let high = outlines.iter().map(|outline| outline.high).fold(DVec2::NEG_INFINITY, DVec2::max);
        Some(Self { nearest, farthest, front, low, high })
    }

    /// Between which widths the penumbra of a blocker between two depths lies: it falls with the blocker's depth. Metres.
    pub fn interval(space: &LightSpace, depths: [f64; 2], receiver: f64, width: f64) -> [f64; 2] {
        depths.map(|depth| space.penumbra(width, depth, receiver))
    }

    /// Whether a receiver is behind the nearest of the boxes.
    pub(super) fn is_before(&self, receiver: f64) -> bool {
        self.front < receiver
    }

    /// The outlines' rectangle on the image, grown by the widest penumbra on receivers at this depth.
    pub(super) fn rectangle(&self, space: &LightSpace, receiver: f64, width: f64) -> [DVec2; 2] {
        let grown = space.width_on_image(width, self.front, receiver);
        [self.low - grown, self.high + grown]
    }

    /// Whether a receiver's place is in that rectangle.
    pub(super) fn holds(&self, space: &LightSpace, place: DVec2, receiver: f64, width: f64) -> bool {
        let [low, high] = self.rectangle(space, receiver, width);
        place.cmpge(low).all() && place.cmple(high).all()
    }

    /// How much of a square window round a place, of this width on the image, lies in the outlines' rectangle.
    pub(super) fn share_of_window(&self, place: DVec2, width: f64) -> f64 {
        let part = self.high.min(place + 0.5 * width) - self.low.max(place - 0.5 * width);
        let share = part.max(DVec2::ZERO) / width;
        if width > 0.0 { share.x * share.y } else { 0.0 }
    }

    /// How near a place is to *min*, 1 at *max* and 0 at *min*.
    fn share_of_nearest(&self, place: DVec2) -> f64 {
        let (to_nearest, to_farthest) =
            (place.distance(self.nearest.truncate()), place.distance(self.farthest.truncate()));
        let both = to_nearest + to_farthest;
        if both > 0.0 { to_farthest / both } else { 1.0 }
    }

    /// The blocker's depth at a place, interpolated.
    pub(super) fn depth_at(&self, place: DVec2) -> f64 {
        let share = self.share_of_nearest(place);
        share * self.nearest.z + (1.0 - share) * self.farthest.z
    }

    /// The penumbra's width at a place, interpolated between those of the two points for a receiver at `receiver`, metres.
    pub(super) fn fixed_width(&self, space: &LightSpace, place: DVec2, receiver: f64, width: f64) -> f64 {
        let [widest, narrowest] = Self::interval(space, [self.nearest.z, self.farthest.z], receiver, width);
        let share = self.share_of_nearest(place);
        share * widest + (1.0 - share) * narrowest
    }
}
