//! Rays by maps: from a ray to its cell, through the cell's packs leaf by leaf, to the triangles in them.
//!
//! *When to stop.* With growing numbers: when the hit, or the segment's end, lies in the leaf that was just looked at. All
//! leaves that come later are entered behind it; a triangle that is hit nearer, or equally near, would have been listed in this leaf or
//! an earlier one. With the source's numbers and with a map a section: when the hit is nearer than what comes next. Rays that are
//! known too roughly for that (the error of their place exceeds a quarter of the leaves' slack) go through the whole run.

use glam::DVec3;
use umbriel_bvh::{Hit, TriangleRay};
use umbriel_geometry::{
    Dyadic, Point,
    blocking::{Probe as PointProbe, polygon_blocks},
    decisions::{Level, count},
    simd::{Kernel, Simd, dispatch},
};

use super::{
    Layout, Leaf, Numbering, Projection, Viewpoint,
    frame::{Kind, Sight},
    pack::{MAX_SPREAD, Pack, Probe, WIDTH},
};

/// The ray does not come from the viewpoint that the projection was built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the ray is none of the viewpoint")]
pub struct NotOfView;

/// What a ray looks for in the leaves that it comes to.
pub(super) trait Look {
    /// Looks at the triangles of a pack; true when nothing more is to be found.
    fn look<S: Simd>(&mut self, simd: S, pack: &Pack) -> bool;

    /// Whether a triangle of the pack certainly ends the search.
    fn settles<S: Simd>(&mut self, _simd: S, _pack: &Pack) -> bool {
        false
    }

    /// The depth behind which nothing matters.
    fn depth(&self) -> Option<f64>;
}

/// Does a triangle lie between a point and the viewpoint?
pub(super) struct Blocked<D> {
    pub(super) probe: Probe,
    pub(super) depth: f64,
    /// Decides about a triangle in doubt.
    pub(super) decide: D,
    /// The last one that it said no to: leaves share triangles.
    pub(super) open: Option<u32>,
    pub(super) is_blocked: bool,
}

impl<D: FnMut(u32) -> bool> Look for Blocked<D> {
    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S, pack: &Pack) -> bool {
        let verdicts = pack.test_segment(simd, &self.probe);
        self.is_blocked = verdicts.hits != 0;
        let mut doubts = verdicts.doubts;
        while doubts != 0 && !self.is_blocked {
            let triangle = pack.triangles[doubts.trailing_zeros() as usize % WIDTH];
            doubts &= doubts - 1;
            if self.open != Some(triangle) {
                self.is_blocked = (self.decide)(triangle);
                self.open = Some(triangle);
            }
        }
        self.is_blocked
    }

    #[inline(always)]
    fn settles<S: Simd>(&mut self, simd: S, pack: &Pack) -> bool {
        self.is_blocked = pack.test_segment(simd, &self.probe).hits != 0;
        self.is_blocked
    }

    #[inline(always)]
    fn depth(&self) -> Option<f64> {
        Some(self.depth)
    }
}

/// The nearest hit of a ray.
pub(super) struct Nearest<'a> {
    projection: &'a Projection,
    /// Origin and direction.
    line: [DVec3; 2],
    /// Made ready for triangles when the first one is near.
    ray: Option<TriangleRay>,
    pub(super) probe: Probe,
    /// Depth at t = 0, and what t = 1 adds.
    base: f64,
    scale: f64,
    t_max: f64,
    pub(super) best: Option<Hit>,
}

impl Nearest<'_> {
    #[inline(always)]
    fn measure(&mut self, triangle: u32) {
        // Leaves share triangles, and so do lanes of a pack.
        if self.best.is_some_and(|known| known.triangle == triangle) {
            return;
        }
        let corners = self.projection.corners(triangle);
        if self.ray.is_none() {
            self.ray = TriangleRay::new(self.line[0], self.line[1]);
        }
        let Some(hit) = self.ray.as_ref().and_then(|ray| ray.hit(corners, triangle)) else { return };
        let is_first = self.best.is_none_or(|known| known.triangle > triangle);
        if hit.t < self.t_max || hit.t == self.t_max && is_first {
            self.t_max = hit.t;
            self.best = Some(hit);
            self.probe.nearness[0] = self.farthest();
        }
    }

    /// The least nearness of interest.
    fn farthest(&self) -> f32 {
        let slack = self.projection.root.slack;
        self.projection.frame.kind.nearness(self.base + self.t_max * self.scale, slack)[0]
    }
}

impl Look for Nearest<'_> {
    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S, pack: &Pack) -> bool {
        let mut candidates = pack.test_ray(simd, &self.probe);
        while candidates != 0 {
            let triangle = pack.triangles[candidates.trailing_zeros() as usize % WIDTH];
            candidates &= candidates - 1;
            self.measure(triangle);
        }
        false
    }

    #[inline(always)]
    fn depth(&self) -> Option<f64> {
        self.best.map(|hit| self.base + hit.t * self.scale)
    }
}

/// How the leaves of a ray are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    Maps,
    Descent,
}

/// A ray on its way through its leaves.
pub(super) struct Walk<'a, L> {
    pub(super) projection: &'a Projection,
    pub(super) sight: &'a Sight,
    pub(super) way: Way,
    pub(super) look: &'a mut L,
    /// The packs of the ray where they are known already.
    pub(super) run: Option<&'a [u32]>,
    /// The pack to look at first; then the last one that was looked at.
    pub(super) pack: Option<u32>,
    /// The depth of the hit, or of the segment's end, when it was last asked for, and where in the cube that is.
    pub(super) end: Option<(f64, DVec3)>,
}

impl<L: Look> Kernel for Walk<'_, L> {
    /// The pack that ended the search, if one did.
    type Output = Option<u32>;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Option<u32> {
        if let Some(first) = self.pack.take()
            && self.look.settles(simd, &self.projection.packs[first as usize])
        {
            return Some(first);
        }
        match (self.run, self.way) {
            (Some(run), _) => {
                self.through(simd, run);
            }
            (None, Way::Maps) if self.projection.has_maps(self.sight) => self.by_maps(simd),
            _ => self.by_descent(simd),
        }
        self.pack
    }
}

impl<L: Look> Walk<'_, L> {
    #[inline(always)]
    fn by_maps<S: Simd>(&mut self, simd: S) {
        if !self.sight.is_within_maps() {
            return;
        }
        let (place, spread) = (self.sight.place(), self.sight.spread);
        for section in &self.projection.faces[self.sight.face] {
            if self.is_behind(section.near) {
                return;
            }
            if let Some(run) = section.map.run_at(place, spread) {
                if self.through(simd, run) {
                    return;
                }
            } else {
                // Each run stops for itself: what ends one may be beside the others.
                for run in section.map.runs_near(place, spread) {
                    if self.through(simd, run) {
                        return;
                    }
                }
            }
        }
    }

    /// Looks at the packs of a run; true when all is found.
    #[inline(always)]
    fn through<S: Simd>(&mut self, simd: S, run: &[u32]) -> bool {
        let Projection { owners, packs, .. } = self.projection;
        let mut leaf = None;
        for &pack in run {
            let next = owners[pack as usize];
            if leaf != Some(next) && self.ends_before(next, leaf.replace(next)) {
                return false;
            }
            if self.look.look(simd, &packs[pack as usize]) {
                self.pack = Some(pack);
                return true;
            }
        }
        false
    }

    /// Whether what matters ends before a leaf of a run: where numbers grow along rays in the one that was left.
    #[inline(always)]
    fn ends_before(&mut self, next: u32, left: Option<u32>) -> bool {
        let Projection { options, leaves, .. } = self.projection;
        match (options.layout, options.numbering) {
            (Layout::OneMap, Numbering::FrontToBack) => left.is_some_and(|left| self.ends_in(&leaves[left as usize])),
            (Layout::OneMap, _) => self.is_behind(self.near(&leaves[next as usize])),
            (Layout::MapPerSection, _) => false,
        }
    }

    /// Looks at the packs of a leaf; true when all is found.
    #[inline(always)]
    pub(super) fn look_at<S: Simd>(&mut self, simd: S, leaf: &Leaf) -> bool {
        for pack in leaf.first_pack..leaf.first_pack + leaf.packs {
            if self.look.look(simd, &self.projection.packs[pack as usize]) {
                self.pack = Some(pack);
                return true;
            }
        }
        false
    }

    /// Whether a depth lies certainly behind all that matters.
    #[inline(always)]
    pub(super) fn is_behind(&self, depth: f64) -> bool {
        let slack = self.projection.root.slack + self.sight.depth_error;
        self.look.depth().is_some_and(|known| depth > known + 2.0 * slack)
    }

    /// The least depth of a leaf on the ray's face.
    fn near(&self, leaf: &Leaf) -> f64 {
        let root = &self.projection.root;
        let axis = self.sight.face / 2;
        let plane = |unit: f32| root.min[axis] + f64::from(unit) * root.edge;
        if self.sight.face.is_multiple_of(2) { plane(leaf.min[axis]) } else { -plane(leaf.min[axis] + leaf.edge) }
    }

    /// Whether the hit, or the end, lies in the leaf.
    #[inline(always)]
    fn ends_in(&mut self, leaf: &Leaf) -> bool {
        let Some(depth) = self.look.depth() else { return false };
        let place = match self.end {
            Some((known, place)) if known == depth => place,
            _ => self.end_at(depth),
        };
        let away = place - DVec3::from_array(leaf.min.map(f64::from));
        away.min_element() >= 0.0 && away.max_element() <= f64::from(leaf.edge)
    }

    /// Where in the cube a depth is; nowhere when the ray is known too roughly.
    #[inline(always)]
    fn end_at(&mut self, depth: f64) -> DVec3 {
        let Projection { root, frame, .. } = self.projection;
        let error = self.sight.spread * if frame.kind == Kind::Parallel { 1.0 } else { depth };
        let place = if error > 0.25 * root.slack {
            DVec3::NAN
        } else {
            (self.sight.at(depth, frame.kind) - root.min) / root.edge
        };
        self.end = Some((depth, place));
        place
    }
}

impl Projection {
    /// The first triangle that the ray `origin + t direction` hits for 0 < t ≤ `t_max`, the lower one of equals: what
    /// [`TriangleBvh::nearest_hit`](umbriel_bvh::TriangleBvh::nearest_hit) finds. Rounded: for pictures, not for proofs.
    ///
    /// # Errors
    /// [`NotOfView`] when the origin is not the viewpoint, or the direction not that of parallel rays.
    pub fn nearest_hit(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Result<Option<Hit>, NotOfView> {
        self.nearest(origin, direction, t_max, Way::Maps)
    }

    /// [`Projection::nearest_hit`] by an ordinary traversal of the same octree, without maps.
    ///
    /// # Errors
    /// [`NotOfView`] as there.
    pub fn nearest_hit_by_descent(
        &self,
        origin: DVec3,
        direction: DVec3,
        t_max: f64,
    ) -> Result<Option<Hit>, NotOfView> {
        self.nearest(origin, direction, t_max, Way::Descent)
    }

    /// Whether any triangle blocks the open segment from `x` to the viewpoint (without end, for parallel rays): exactly what
    /// [`polygon_blocks`] says of all of them. Contact at its ends does not block. For many points, [`Projection::segments`] is
    /// faster.
    pub fn any_hit(&self, x: DVec3) -> bool {
        self.segments().any_hit(x)
    }

    /// Segments from many points to the viewpoint.
    pub fn segments(&self) -> ProjectedSegments<'_> {
        ProjectedSegments { projection: self, way: Way::Maps, last: None }
    }

    /// [`Projection::segments`] by an ordinary traversal of the same octree, without maps.
    pub fn segments_by_descent(&self) -> ProjectedSegments<'_> {
        ProjectedSegments { projection: self, way: Way::Descent, last: None }
    }

    /// The exact decision.
    #[cold]
    fn blocks(&self, triangle: u32, x: DVec3) -> bool {
        let corners = self.corners(triangle).map(Point::exact);
        polygon_blocks::<Dyadic>(&corners, &PointProbe::at(x), &self.light)
    }

    #[inline]
    pub(super) fn corners(&self, triangle: u32) -> [DVec3; 3] {
        // Without `map`, whose closure becomes a call in kernels.
        let ([a, b, c], positions) = (self.mesh.triangles()[triangle as usize], self.mesh.positions());
        [positions[a as usize], positions[b as usize], positions[c as usize]]
    }

    /// Whether the rays of a face have maps.
    #[inline(always)]
    fn has_maps(&self, sight: &Sight) -> bool {
        self.frame.kind.faces().contains(&sight.face)
    }

    /// The packs that a ray comes to, where one cell of one map has them all.
    #[inline(always)]
    fn run_of(&self, sight: &Sight) -> Option<&[u32]> {
        match &self.faces[sight.face][..] {
            [only] if sight.is_within_maps() => only.map.run_at(sight.place(), sight.spread),
            _ => None,
        }
    }

    fn nearest(&self, origin: DVec3, direction: DVec3, t_max: f64, way: Way) -> Result<Option<Hit>, NotOfView> {
        let kind = self.frame.kind;
        let is_own = match self.viewpoint {
            Viewpoint::Point(eye) | Viewpoint::Picture { eye, .. } => eye == origin,
            Viewpoint::Parallel(along) => along == direction,
        };
        if !is_own {
            return Err(NotOfView);
        }
        let (sight, base, scale) = if kind == Kind::Parallel {
            let sight = self.frame.sight_to(origin, 0.0);
            let begin = sight.depth - sight.depth_error - self.root.slack;
            (Sight { begin, ..sight }, sight.depth, self.frame.turn(direction).z)
        } else {
            let sight = self.frame.sight_along(direction);
            (Sight { depth_error: 0.0, ..sight }, 0.0, sight.depth)
        };
        // First of all, as most rays of many pictures meet nothing.
        let run = if way == Way::Maps { self.run_of(&sight) } else { None };
        if run.is_some_and(<[u32]>::is_empty) {
            return Ok(None);
        }
        let nearest = if kind == Kind::Parallel { kind.nearness(base, sight.depth_error)[1] } else { f32::INFINITY };
        let probe = Probe::new(sight.direction, [f32::NEG_INFINITY, nearest]);
        let mut look =
            Nearest { projection: self, line: [origin, direction], ray: None, probe, base, scale, t_max, best: None };
        if sight.spread.is_nan() || sight.spread > MAX_SPREAD {
            (0..self.mesh.triangles().len() as u32).for_each(|triangle| look.measure(triangle));
            return Ok(look.best);
        }
        if t_max < f64::INFINITY {
            look.probe.nearness[0] = look.farthest();
        }
        dispatch(Walk { projection: self, sight: &sight, way, look: &mut look, run, pack: None, end: None });
        Ok(look.best)
    }
}

/// Segments from many points to the viewpoint. What blocked the last one is tried first for the next (the shadow cache of
/// Haines and Greenberg, "The light buffer", 1986), so neighbours should follow each other; answers do not depend on it.
#[derive(Clone, Debug)]
pub struct ProjectedSegments<'a> {
    projection: &'a Projection,
    way: Way,
    /// The pack that blocked the last segment.
    last: Option<u32>,
}

impl ProjectedSegments<'_> {
    /// As [`Projection::any_hit`].
    #[inline]
    pub fn any_hit(&mut self, x: DVec3) -> bool {
        let projection = self.projection;
        self.any_hit_where(x, 0.0, |triangle| projection.blocks(triangle, x))
    }

    /// As [`ProjectedSegments::any_hit`] for a point that is not a float: it is within `slack` of `x` on every axis, and
    /// `decide` tells whether a triangle blocks its segment. It is asked about triangles in doubt only, until it says yes, in
    /// no particular order; those that the point lies on are always in doubt.
    pub fn any_hit_where(&mut self, x: DVec3, slack: f64, mut decide: impl FnMut(u32) -> bool) -> bool {
        let projection = self.projection;
        let sight = projection.frame.sight_to(x, slack);
        if sight.spread.is_nan() || sight.spread > MAX_SPREAD {
            return (0..projection.mesh.triangles().len() as u32).any(decide);
        }
        let probe = Probe::new(sight.direction, projection.frame.kind.nearness(sight.depth, sight.depth_error));
        let mut is_settled = true;
        let mut decide = |triangle| {
            is_settled = false;
            decide(triangle)
        };
        let mut look = Blocked { probe, depth: sight.depth, decide: &mut decide, open: None, is_blocked: false };
        let walk =
            Walk { projection, sight: &sight, way: self.way, look: &mut look, run: None, pack: self.last, end: None };
        self.last = dispatch(walk).or(self.last);
        let is_blocked = look.is_blocked;
        count(Level::Single, u64::from(is_settled));
        is_blocked
    }
}
