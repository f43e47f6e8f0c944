//! Nearest hits of rays that go nearly the same way: neighbours in a picture.
//!
//! Sixteen rays share one walk: a node's boxes are tested against what bounds all of them ([`Shaft::around`]), the nearest for any of them
//! first, and a leaf's box against the sixteen side by side. The triangles of the leaf are each ray's own ([`super::nearest`]), and so are the answers: they depend
//! on no order. Source: Boulos, Wald and Shirley, "Geometric and arithmetic culling methods for entire ray packets", 2006.
//! Cost: where rays meet the same leaves, a sixteenth of the nodes of single rays. Where they go apart what bounds them all is wide, and the walk is
//! given up; then each goes on alone, up to the hit that it has.
//!
//! **Boxes.** All directions are multiplied by one number, so that their largest component is 1, and rounded to f32; a bundle is refused
//! where a ray's own largest component is below 1/4, or an origin farther than 64 from the frame's centre. So a ray leaves the frame before τ = 4·65 < 2^9,
//! and what is said of boxes in [`super::ray`] holds with 2^9·2·2^-40 for components below 2^-40, as these are replaced by 2^-40 whatever their sign.

use glam::{DVec3, Vec3};
use umbriel_geometry::simd::{Float, Kernel, Lanes, Mask, Simd};

use super::{
    TriangleBvh,
    frame::Frame,
    layout::{Node, WIDTH},
    nearest::{Nearest, Visit, Waiting},
    ray::{LEAST_SLOPE, OUTWARD, U},
    shaft::Shaft,
};
use crate::ray::Ray;

/// Rays of a bundle.
pub(super) const BUNDLE: usize = 16;

/// Nodes that a bundle may look at before its rays go on alone: as many as they would look at alone.
const PATIENCE: u32 = 128;

/// What is refused; see the header.
const FARTHEST: f64 = 64.0;
const LEAST_COMPONENT: f64 = 0.25;

/// More than the way to the far end of the frame. Not infinite, because empty boxes are entered at infinity.
const BEYOND: f32 = (1u32 << 10) as f32;

/// What replacing small components moves a ray by, at most; see the header.
const SLACK: f32 = LEAST_SLOPE * (1u32 << 10) as f32;

/// The rays of a bundle in the frame, by axis and lane.
pub(super) struct Lines {
    /// Origins moved up by their error, and down.
    pub(super) raised: [[f32; BUNDLE]; 3],
    pub(super) lowered: [[f32; BUNDLE]; 3],
    pub(super) directions: [[f32; BUNDLE]; 3],
    /// Boxes entered behind this are of no interest. Lanes that are left over are interested in none.
    pub(super) ends: [f32; BUNDLE],
    /// Lengths of the rays' directions become lengths here when multiplied by this.
    unit: f64,
}

impl Lines {
    /// `None` for rays that are refused.
    fn new(bvh: &TriangleBvh, rays: &[(Ray, f64)]) -> Option<Self> {
        let frame = &bvh.parts.frame;
        let sizes = rays.iter().map(|(ray, _)| ray.direction.abs().max_element());
        let (least, most) =
            sizes.fold((f64::INFINITY, 0.0f64), |(least, most), size| (least.min(size), most.max(size)));
        let longest = 1.0 / most;
        // Not so of directions that are none.
        let are_alike = least * longest >= LEAST_COMPONENT;
        if !are_alike {
            return None;
        }
        let zero = [[0.0; BUNDLE]; 3];
        let unit = frame.scale() * most;
        let mut lines = Self { raised: zero, lowered: zero, directions: zero, ends: [-1.0; BUNDLE], unit };
        let mut known = None;
        for (lane, (ray, t_max)) in rays.iter().enumerate() {
            // Eyes are the same for all.
            let (_, [lowered, raised]) = match known.filter(|&(origin, _)| origin == ray.origin) {
                Some(known) => known,
                None => *known.insert((ray.origin, around(frame, ray.origin)?)),
            };
            let direction = (ray.direction * longest).as_vec3();
            for axis in 0..3 {
                lines.raised[axis][lane] = raised[axis];
                lines.lowered[axis][lane] = lowered[axis];
                lines.directions[axis][lane] = direction[axis];
            }
            lines.stop_at(lane, *t_max);
        }
        Some(lines)
    }

    fn stop_at(&mut self, lane: usize, t_max: f64) {
        self.ends[lane] = BEYOND.min((t_max * self.unit) as f32 * OUTWARD);
    }

    /// The farthest end.
    fn end(&self) -> f32 {
        self.ends.iter().fold(-1.0, |end, &other| if other > end { other } else { end })
    }

    /// Which rays may meet a node's box, a bit each.
    #[inline(always)]
    fn met<S: Simd>(&self, simd: S, node: &Node, lane: usize, reciprocals: &[<S as Lanes<16>>::Float; 3]) -> u32 {
        let (mut enter, mut leave) = (simd.splat16(0.0), simd.load(&self.ends));
        for (axis, &reciprocal) in reciprocals.iter().enumerate() {
            let low = simd.splat16(node.planes[axis][lane]) - simd.load(&self.raised[axis]);
            let high = simd.splat16(node.planes[axis + 3][lane]) - simd.load(&self.lowered[axis]);
            let (one, other) = (low * reciprocal, high * reciprocal);
            enter = enter.max(one.min(other));
            leave = leave.min(one.max(other));
        }
        enter.le(leave * simd.splat16(OUTWARD)).bits()
    }
}

/// An origin in the frame, moved down and up by its error; `None` where it is refused.
fn around(frame: &Frame, origin: DVec3) -> Option<[Vec3; 2]> {
    let exact = frame.localise(origin);
    let reach = exact.abs().max_element();
    let rounded = exact.as_vec3();
    let off = (exact - rounded.as_dvec3()).abs().max_element() + frame.error(reach);
    let widening = Vec3::splat(off as f32 * (1.0 + 4.0 * U) + SLACK + 4.0 * U * reach as f32);
    (reach <= FARTHEST).then_some([rounded - widening, rounded + widening])
}

/// Finds the nearest hits of at most [`BUNDLE`] rays.
pub(super) struct Bundle<'a, 'r, const COUNTED: bool> {
    bvh: &'a TriangleBvh,
    rays: &'r [(Ray, f64)],
    lines: Lines,
    shaft: Shaft,
    /// Made when a ray meets its first leaf. Not here itself, because it is large and would be moved.
    searches: &'r mut [Option<Nearest<'a, COUNTED>>; BUNDLE],
    /// Nodes that were looked at.
    pub(super) nodes: u32,
}

impl<'a, 'r, const COUNTED: bool> Bundle<'a, 'r, COUNTED> {
    /// `None` for rays that are refused. There are no searches yet.
    pub(super) fn new(
        bvh: &'a TriangleBvh,
        rays: &'r [(Ray, f64)],
        searches: &'r mut [Option<Nearest<'a, COUNTED>>; BUNDLE],
    ) -> Option<Self> {
        let lines = Lines::new(bvh, rays)?;
        let shaft = Shaft::around(&lines, rays.len(), lines.end());
        Some(Self { bvh, rays, lines, shaft, searches, nodes: 0 })
    }

    /// The nearest child that some ray may meet; the others wait. Links are lanes of nodes, because packs have no boxes.
    #[inline(always)]
    fn open<S: Simd>(&mut self, simd: S, index: u32, waiting: &mut Waiting) -> Option<Visit> {
        self.nodes += 1;
        let (enter, met) = self.shaft.box_spans(simd, &self.bvh.parts.nodes[index as usize]);
        waiting.nearest_of(met.bits(), enter.to_array(), |lane| index * WIDTH as u32 + lane as u32)
    }

    /// Measures the triangles of a leaf with these rays, a bit each.
    #[inline(always)]
    fn measure<S: Simd>(&mut self, simd: S, pack: u32, mut concerned: u32) {
        let mut is_shorter = false;
        while concerned != 0 {
            let lane = concerned.trailing_zeros() as usize % BUNDLE;
            concerned &= concerned - 1;
            if self.searches[lane].is_none() {
                let (ray, t_max) = &self.rays[lane];
                self.searches[lane] = self.bvh.search(ray.origin, ray.direction, *t_max);
            }
            let Some(search) = &mut self.searches[lane] else { continue };
            let t_max = search.t_max;
            search.measure(simd, pack);
            if search.t_max < t_max {
                is_shorter = true;
                self.lines.stop_at(lane, search.t_max);
            }
        }
        if is_shorter {
            self.shaft.end = self.lines.end();
        }
    }
}

impl<const COUNTED: bool> Kernel for &mut Bundle<'_, '_, COUNTED> {
    /// Whether the walk came to its end.
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let mut reciprocals = [simd.splat16(1.0); 3];
        for (reciprocal, direction) in reciprocals.iter_mut().zip(&self.lines.directions) {
            let (direction, least) = (simd.load(direction), simd.splat16(LEAST_SLOPE));
            *reciprocal = *reciprocal / least.select(direction.abs().lt(least), direction);
        }
        let mut waiting = Waiting::new();
        let mut next = self.open(simd, 0, &mut waiting);
        while let Some(Visit { enter, link }) = next {
            if enter > self.shaft.end {
                next = waiting.pop();
                continue;
            }
            let bvh = self.bvh;
            let (node, lane) = (&bvh.parts.nodes[link as usize / WIDTH], link as usize % WIDTH);
            if node.leaves >> lane & 1 != 0 {
                let concerned = self.lines.met(simd, node, lane, &reciprocals);
                self.measure(simd, node.children[lane], concerned);
                next = waiting.pop();
            } else {
                if self.nodes == PATIENCE {
                    return false;
                }
                next = self.open(simd, node.children[lane], &mut waiting).or_else(|| waiting.pop());
            }
        }
        true
    }
}
