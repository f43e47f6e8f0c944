//! The outlines of boxes seen from a light, and the two points between which penumbrae are interpolated.
//!
//! Duan, "A fast soft shadows algorithm for dynamic scene in MMOG" (Computer Knowledge and Technology 2009(15)), steps 1 to 4: each box's corners go to light space;
//! of its corners those on a face turned to the light stay, but for one on three such faces, which is inside; a corner inside of another box's outline (and,
//! a condition of ours, behind that box) shapes no shadow, and a box without corners is dropped. Of each outline that is left, the middles of its two
//! corners nearest to the light's plane and of its two farthest are taken; over the outlines of a blocker, the nearest is *max*, where penumbrae are
//! widest, the farthest *min*. Ours: one pair a blocker instead of one a scene; the receiver's own depth; outlines on the plane of slopes, so
//! that they are where the depth map has them; and boxes that are replaced by their children where their depths leave the width open by more than is tolerated. A
//! few dozen operations a box and frame.

use glam::{DAffine3, DVec2, DVec3};
use umbriel_geometry::Cuboid;
use umbriel_scene::{Object, Shape};

use super::depth_map::LightSpace;

/// How often an object's cube is halved at most.
const DEEPEST: u32 = 5;

/// A box that stands in space as it likes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    /// World coordinates, in the order of [`Cuboid::corners`].
    pub corners: [DVec3; 8],
}

impl OrientedBox {
    /// The box of an object in its own coordinates, placed; `None` for a shape without corners.
    pub fn of(object: &Object) -> Option<Self> {
        let map = object.placement.map();
        let around = |points: &mut dyn Iterator<Item = DVec3>| {
            let (low, high) =
                points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
            (low.x <= high.x).then(|| Self::between(low, high, map))
        };
        match &object.shape {
            Shape::Mesh(mesh) => around(&mut mesh.positions().iter().copied()),
            Shape::Convex(body) => around(&mut body.points().iter().copied()),
            Shape::Cuboid(cuboid) => around(&mut cuboid.corners().into_iter()),
            Shape::Rectangle(rectangle) => around(&mut rectangle.corners().into_iter()),
            Shape::Analytic(body) => {
                let half = DVec3::from_array(body.half_extent());
                Some(Self::between(-half, half, map))
            }
            _ => None,
        }
    }

    /// The box between two local corners, placed.
    pub fn between(low: DVec3, high: DVec3, map: &DAffine3) -> Self {
        let size = (high - low).to_array();
        let middle = 0.5 * (low + high);
        Self { corners: Cuboid { size }.corners().map(|corner| map.transform_point3(corner + middle)) }
    }

    /// The boxes round the triangles of a mesh object in the 2^depth parts along each axis: its hierarchy of cubes at that depth, each cut to what it
    /// holds. The object's own box for other shapes.
    pub fn parts_of(object: &Object, depth: u32) -> Vec<Self> {
        let Shape::Mesh(mesh) = &object.shape else { return Self::of(object).into_iter().collect() };
        let all = mesh
            .positions()
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        let edge = (all.1 - all.0).max_element() / f64::from(1u32 << depth.min(10));
        let mut cubes = std::collections::BTreeMap::new();
        for triangle in mesh.triangles() {
            let corners = triangle.map(|corner| mesh.positions()[corner as usize]);
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let key = if edge > 0.0 { ((middle - all.0) / edge).to_array().map(|place| place as u32) } else { [0; 3] };
            let bounds = cubes.entry(key).or_insert((DVec3::INFINITY, DVec3::NEG_INFINITY));
            *bounds = corners.iter().fold(*bounds, |(low, high), &corner| (low.min(corner), high.max(corner)));
        }
        cubes.into_values().map(|(low, high)| Self::between(low, high, object.placement.map())).collect()
    }
}

/// A box's outline as the light sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Slopes and depth of its corners, in order round it, without those that were dropped.
    pub corners: Vec<DVec3>,
    /// All of its corners' slopes, counter-clockwise.
    hull: Vec<DVec2>,
    /// Depths of the box.
    depths: [f64; 2],
}

/// The outlines of boxes: steps 1 and 2. A box that reaches the light's plane has none.
pub fn outlines(space: &LightSpace, boxes: &[OrientedBox]) -> Vec<Outline> {
    let whole: Vec<Outline> = boxes.iter().filter_map(|oriented| outline(space, oriented)).collect();
    let shapes = |number: usize, corner: &DVec3| {
        !whole.iter().enumerate().any(|(other, outline)| other != number && outline.hides(*corner))
    };
    let visible = whole.iter().enumerate().map(|(number, outline)| {
        let corners = outline.corners.iter().copied().filter(|corner| shapes(number, corner)).collect();
        Outline { corners, ..outline.clone() }
    });
    visible.filter(|outline| !outline.corners.is_empty()).collect()
}

/// Step 1: which corners lie on one or two faces turned to the light.
fn outline(space: &LightSpace, oriented: &OrientedBox) -> Option<Outline> {
    let seen = oriented.corners.map(|corner| space.to_light(corner));
    if seen.iter().any(|corner| corner.z <= 0.0) {
        return None;
    }
    let middle = seen.iter().sum::<DVec3>() / 8.0;
    let mut counts = [0; 8];
    for face in Cuboid::FACES {
        let [a, b, _, d] = face.map(|corner| seen[corner as usize]);
        let normal = (b - a).cross(d - a);
        let outward = if normal.dot(a - middle) < 0.0 { -normal } else { normal };
        // The light is the origin.
        if outward.dot(a) < 0.0 {
            face.iter().for_each(|&corner| counts[corner as usize] += 1);
        }
    }
    let on_outline = (0..8).filter(|&corner| counts[corner] == 1 || counts[corner] == 2);
    let mut corners: Vec<DVec3> = on_outline.map(|k| (seen[k].truncate() / seen[k].z).extend(seen[k].z)).collect();
    let centre = corners.iter().map(|corner| corner.truncate()).sum::<DVec2>() / corners.len().max(1) as f64;
    let turn = |corner: &DVec3| {
        let way = corner.truncate() - centre;
        libm::atan2(way.y, way.x)
    };
    corners.sort_by(|a, b| turn(a).total_cmp(&turn(b)));
    let hull = corners.iter().map(|corner| corner.truncate()).collect();
    let depth = |pick: fn(f64, f64) -> f64, start| seen.iter().map(|corner| corner.z).fold(start, pick);
    Some(Outline { corners, hull, depths: [depth(f64::min, f64::INFINITY), depth(f64::max, 0.0)] })
}

impl Outline {
    /// Whether a corner is inside and not nearer to the light than the box.
    fn hides(&self, corner: DVec3) -> bool {
        let next = self.hull.iter().cycle().skip(1);
        let is_inside = self.hull.iter().zip(next).all(|(&a, &b)| (b - a).perp_dot(corner.truncate() - a) > 0.0);
        is_inside && self.hull.len() > 2 && corner.z > self.depths[0]
    }

    /// Step 3: the middles of its two nearest corners and of its two farthest.
    fn extremes(&self) -> [DVec3; 2] {
        let mut sorted = self.corners.clone();
        sorted.sort_by(|a, b| a.z.total_cmp(&b.z));
        let last = sorted.len() - 1;
        [0.5 * (sorted[0] + sorted[1.min(last)]), 0.5 * (sorted[last] + sorted[last.saturating_sub(1)])]
    }
}

/// A blocker: the two points between which penumbrae are interpolated, and how far its outlines reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocker {
    /// Slopes and depth of *max*, the nearest to the light.
    pub nearest: DVec3,
    /// Slopes and depth of *min*, the farthest.
    pub farthest: DVec3,
    low: DVec2,
    high: DVec2,
}

impl Blocker {
    /// Steps 3 and 4 over the outlines of one blocker; `None` without outlines.
    pub fn of(outlines: &[Outline]) -> Option<Self> {
        let extremes = outlines.iter().map(Outline::extremes);
        let pairs: Vec<[DVec3; 2]> = extremes.collect();
        let nearest = pairs.iter().map(|pair| pair[0]).min_by(|a, b| a.z.total_cmp(&b.z))?;
        let farthest = pairs.iter().map(|pair| pair[1]).max_by(|a, b| a.z.total_cmp(&b.z))?;
        let slopes = outlines.iter().flat_map(|outline| &outline.hull);
        let (low, high) =
            slopes.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &s| (low.min(s), high.max(s)));
        Some(Self { nearest, farthest, low, high })
    }

    /// A blocker for each box of a mesh object's hierarchy of cubes, as deep as it takes for the penumbra of each, on a receiver at this depth, to be
    /// known within `tolerance` metres; the object's own box where that does. Ours. At most five levels.
    pub fn refined(space: &LightSpace, object: &Object, receiver: f64, width: f64, tolerance: f64) -> Vec<Self> {
        let mut blockers = Vec::new();
        for depth in 0..=DEEPEST {
            let boxes = if depth == 0 {
                OrientedBox::of(object).into_iter().collect()
            } else {
                OrientedBox::parts_of(object, depth)
            };
            let outlines: Vec<Outline> = boxes.iter().filter_map(|oriented| outline(space, oriented)).collect();
            blockers = outlines.iter().filter_map(|outline| Self::of(std::slice::from_ref(outline))).collect();
            let is_known = |outline: &Outline| {
                let [widest, narrowest] = Self::interval(outline.depths, receiver, width);
                widest - narrowest <= tolerance
            };
            if outlines.iter().all(is_known) {
                break;
            }
        }
        blockers
    }

    /// Between which widths the penumbra of a blocker between two depths lies: it falls with the blocker's depth. Metres.
    pub fn interval(depths: [f64; 2], receiver: f64, width: f64) -> [f64; 2] {
        depths.map(|depth| (width * (receiver - depth) / depth).max(0.0))
    }

    /// Whether a receiver's slope is in the outlines' rectangle, grown by the widest penumbra.
    pub(crate) fn holds(&self, slope: DVec2, receiver: f64, width: f64) -> bool {
        let grown = (width * (1.0 / self.nearest.z - 1.0 / receiver)).max(0.0);
        slope.cmpge(self.low - grown).all() && slope.cmple(self.high + grown).all()
    }

    /// How near a slope is to *min*, 1 at *max* and 0 at *min*.
    fn share_of_nearest(&self, slope: DVec2) -> f64 {
        let (to_nearest, to_farthest) =
            (slope.distance(self.nearest.truncate()), slope.distance(self.farthest.truncate()));
        let both = to_nearest + to_farthest;
        if both > 0.0 { to_farthest / both } else { 1.0 }
    }

    /// The blocker's depth at a slope, interpolated.
    pub(crate) fn depth_at(&self, slope: DVec2) -> f64 {
        let share = self.share_of_nearest(slope);
        share * self.nearest.z + (1.0 - share) * self.farthest.z
    }

    /// The penumbra's width at a slope, interpolated between those of the two points for a receiver at `receiver`, metres.
    pub(crate) fn fixed_width(&self, slope: DVec2, receiver: f64, width: f64) -> f64 {
        let [widest, narrowest] = Self::interval([self.nearest.z, self.farthest.z], receiver, width);
        let share = self.share_of_nearest(slope);
        share * widest + (1.0 - share) * narrowest
    }
}
