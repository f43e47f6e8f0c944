//! One tree for all instances of a mesh: over its triangles in local coordinates, asked through each instance's placement.
//!
//! What a frame of the light measures of a point (two places and a depth) is affine in the point, before a division, and so it is in the point's local
//! coordinates: on a box of the tree it is least and greatest at corners that the signs of its slopes name. A box is passed over when one of the sides of
//! what is asked for has all of it beyond; what is left is for the caller to look at, triangle by triangle as placed.
//!
//! Guarantee: no triangle is passed over whose placed corners have a box in the frame ([`LightFrame::bounds`]) that meets the one asked for (NUMERICS.md §3,
//! "Boxes of instances"). Cost: some 10 ns a node, where a tree of the instance's own in light space takes 2; that tree takes a millisecond and a hundred bytes a triangle.

use std::ops::ControlFlow;

use glam::DVec3;
use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Mesh, Placement, cut_out::Opacity};

use super::light_frame::LightFrame;

/// Whether a triangle of a mesh may block and blocks more than those before it; repeats may have other holes.
pub(crate) fn may_block(mesh: &Mesh, triangle: usize) -> bool {
    mesh.opacity(triangle) != Opacity::Clear && (mesh.has_holes() || !mesh.is_repeat(triangle))
}

/// A tree over those triangles of a mesh; items are triangles.
pub(crate) fn tree_of(mesh: &Mesh) -> BoxTree {
    let of_triangle = |(triangle, corners): (usize, &[u32; 3])| {
        let corners = corners.iter().map(|&corner| mesh.positions()[corner as usize]);
        if may_block(mesh, triangle) { Aabb::of(corners) } else { Aabb::EMPTY }
    };
    BoxTree::build(&mesh.triangles().iter().enumerate().map(of_triangle).collect::<Vec<_>>())
}

/// An affine function of local coordinates.
#[derive(Clone, Copy, Debug)]
struct Affine {
    slope: DVec3,
    offset: f64,
}

impl Affine {
    /// The least value on a box, rounded.
    #[inline]
    fn least(&self, bounds: &Aabb) -> f64 {
        let least = (self.slope * bounds.min).min(self.slope * bounds.max);
        least.x + least.y + least.z + self.offset
    }

    /// The greatest value on a box, rounded.
    #[inline]
    fn greatest(&self, bounds: &Aabb) -> f64 {
        let greatest = (self.slope * bounds.min).max(self.slope * bounds.max);
        greatest.x + greatest.y + greatest.z + self.offset
    }

    /// This and `factor` times another.
    fn with(&self, factor: f64, other: &Self) -> Self {
        Self { slope: self.slope + factor * other.slope, offset: self.offset + factor * other.offset }
    }
}

/// A frame of the light in the local coordinates of an instance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalFrame {
    /// The two places across and the depth; of a frustum before the division by the depth.
    across: [Affine; 2],
    depth: Affine,
    is_frustum: bool,
    /// How far off all of these, those of the placed corners and their own sums may be together.
    slack: f64,
}

impl LocalFrame {
    /// Of a mesh with this local box.
    pub(crate) fn new(frame: &LightFrame, placement: &Placement, local: &Aabb) -> Self {
        let map = placement.map();
        let world: [Affine; 3] =
            std::array::from_fn(|axis| Affine { slope: map.matrix3.row(axis), offset: map.translation[axis] });
        let reach = local.min.abs().max(local.max.abs());
        let sizes = world.map(|place| (place.slope.abs() * reach).element_sum() + place.offset.abs());
        let lamp = match frame {
            LightFrame::Sun { .. } => DVec3::ZERO,
            LightFrame::Frustum { light, .. } => light.abs(),
        };
        // NUMERICS.md §3, "Boxes of instances".
        let slack = 32.0 * f64::EPSILON * (sizes.iter().sum::<f64>() + lamp.element_sum());
        let at = |axis: usize| world[axis % 3];
        match *frame {
            LightFrame::Sun { axis, sign, slope } => Self {
                across: [1, 2].map(|k| at(axis + k).with(-slope[k - 1].value, &at(axis))),
                depth: Affine { slope: -sign * at(axis).slope, offset: -sign * at(axis).offset },
                is_frustum: false,
                slack,
            },
            LightFrame::Frustum { light, axis, sign } => {
                let from_light = |k: usize| {
                    let place = at(axis + k);
                    Affine { offset: place.offset - light[(axis + k) % 3], ..place }
                };
                let depth = from_light(0);
                Self {
                    across: [from_light(1), from_light(2)],
                    depth: Affine { slope: sign * depth.slope, offset: sign * depth.offset },
                    is_frustum: true,
                    slack,
                }
            }
        }
    }

    /// Whether the box of a placed triangle in a sun's frame meets `query`; `None` where the slack leaves it open, and for frusta. It spares placing the
    /// corners and bounding them.
    #[inline]
    pub(crate) fn meets(&self, corners: [DVec3; 3], query: &Aabb) -> Option<bool> {
        if self.is_frustum {
            return None;
        }
        let mut is_sure = true;
        // How far each side has all of it beyond; the slack decides which way rounding may have it.
        let mut sides = |place: &Affine, low: f64, high: f64| {
            let at = corners.map(|corner| place.slope.dot(corner) + place.offset);
            let (least, greatest) = (at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]));
            is_sure &= least + self.slack <= high && greatest - self.slack >= low;
            least - self.slack > high || greatest + self.slack < low
        };
        let is_beyond = sides(&self.across[0], query.min.x, query.max.x)
            || sides(&self.across[1], query.min.y, query.max.y)
            || sides(&self.depth, f64::NEG_INFINITY, query.max.z);
        if is_beyond { Some(false) } else { is_sure.then_some(true) }
    }

    /// Visits the triangles of the tree whose boxes in the frame may meet `query`, until `visit` breaks.
    pub(crate) fn for_each_near(
        &self,
        tree: &BoxTree,
        query: &Aabb,
        visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let beyond = |sides: [f64; 2], number: usize| {
            // Beyond the upper side: place − upper·depth > 0; beyond the lower one: lower·depth − place > 0.
            let place = &self.across[number];
            let lower = Affine { slope: -place.slope, offset: -place.offset };
            [place.with(-sides[1], &self.depth), lower.with(sides[0], &self.depth)]
        };
        let slack = self.slack;
        if self.is_frustum {
            let sides = [beyond([query.min.x, query.max.x], 0), beyond([query.min.y, query.max.y], 1)];
            let window = [beyond([-1.0, 1.0], 0), beyond([-1.0, 1.0], 1)];
            tree.for_each_where(
                |bounds| {
                    let nearest = self.depth.least(bounds);
                    // What reaches behind the light may be anywhere in the window.
                    let sides = if nearest > slack { &sides } else { &window };
                    nearest - slack <= query.max.z
                        && self.depth.greatest(bounds) >= -slack
                        && !sides.as_flattened().iter().any(|side| side.least(bounds) > slack)
                },
                visit,
            )
        } else {
            tree.for_each_where(
                |bounds| {
                    self.depth.least(bounds) - slack <= query.max.z
                        && (0..2).all(|k| {
                            self.across[k].least(bounds) - slack <= query.max[k]
                                && self.across[k].greatest(bounds) + slack >= query.min[k]
                        })
                },
                visit,
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, DQuat};
    use umbriel_geometry::{Facets, LightSource, Point};

    use super::*;

    /// Triangles strewn by powers of an irrational number.
    fn strewn(count: u32) -> Mesh {
        let at = |k: u32| {
            [0.754_877_666, 0.569_840_291, 0.438_579_021].map(|step: f64| (step * f64::from(k)).fract() * 4.0 - 2.0)
        };
        let near = |k: u32, by: f64| at(k).map(|x| x + by * (f64::from(k) * 0.618).fract());
        let positions =
            (0..count).flat_map(|k| [at(k), near(k, 0.25), near(3 * k + 1, 0.125).map(|x| 0.1 * x + at(k)[0])]);
        Mesh::new(positions.collect(), (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect()).expect("a mesh")
    }

    /// Every triangle whose box meets what is asked for is visited, and not all the others are.
    #[test]
    fn nothing_that_meets_is_passed_over() {
        let mesh = Arc::new(strewn(500));
        let tree = tree_of(&mesh);
        let turned = DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize();
        let maps = [
            DAffine3::from_scale_rotation_translation(DVec3::new(1.0, -2.0, 0.5), turned, DVec3::new(3.0, 1.0, -2.0)),
            DAffine3::from_translation(DVec3::new(1e7, 0.125, -3e5)),
            DAffine3::from_scale(DVec3::splat(1e-6)),
        ];
        let (mut met, mut visited) = (0, 0);
        for placement in maps.map(|map| Placement::new(map).expect("regular")) {
            let facets = Facets::of_mesh(Arc::clone(&mesh), &placement);
            let inside = placement.round(DVec3::new(0.3, -0.2, 0.4)).to_array();
            let lights =
                [LightSource::sun([0.3, -1.0, 0.2]), LightSource::point(inside), LightSource::point([9.0, 7.0, 1.0])];
            for light in lights.map(|light| light.expect("a light")) {
                for frame in LightFrame::all(&light) {
                    let local = LocalFrame::new(&frame, &placement, &mesh.bounds());
                    let corners =
                        |facet: usize| -> [Point; 3] { mesh.triangles()[facet].map(|corner| facets.point(corner)) };
                    for asked in (0..500).step_by(50) {
                        let Some(mut query) = frame.bounds(&corners(asked)) else { continue };
                        query.min.z = f64::NEG_INFINITY;
                        let mut near = vec![false; 500];
                        let _ = local.for_each_near(&tree, &query, |triangle| {
                            near[triangle as usize] = true;
                            ControlFlow::Continue(())
                        });
                        for (facet, &is_near) in near.iter().enumerate() {
                            let meets = frame.bounds(&corners(facet)).is_some_and(|bounds| bounds.meets(&query));
                            assert!(is_near || !meets, "triangle {facet} under {light:?}");
                            let told =
                                local.meets(mesh.triangles()[facet].map(|k| mesh.positions()[k as usize]), &query);
                            assert!(told.is_none_or(|told| told == meets), "triangle {facet} under {light:?}");
                            met += usize::from(meets);
                            visited += usize::from(is_near);
                        }
                    }
                }
            }
        }
        assert!(met > 1000 && visited < 3 * met, "{visited} visited for {met}");
    }
}
