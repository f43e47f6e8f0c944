//! The rectangles of all pieces in a light's views.
//!
//! Triangles of a mesh are seen eight at a time, lane by lane and without branches, so that the compiler makes vectors of them: once fetched, in one view after the
//! other, of which a lamp's leave out what lies beside or behind. Cost: some nanoseconds a piece, and about a nanosecond for each view that sees none of eight neighbours.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{
    gathered::Gathered,
    simd::{Kernel, Simd, dispatch},
};

use crate::{
    light_space::{View, greater, lesser},
    loose::{
        occupancy::Occupancy,
        pieces::{Pieces, Triangles},
    },
};

/// Pieces are seen and listed in so many parts at most, by as many threads: each part has a number for each tile.
const PARTS: usize = 64;

/// A piece and its rectangle in the view: least u, v, greatest u, v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub(super) bounds: [f64; 4],
    pub(super) piece: u32,
    /// It turns the other way round than by its winding, as far as roundings tell; what belongs together.
    pub(super) is_reversed: bool,
}

/// Nothing.
pub(super) const NOWHERE: [f64; 4] = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];

/// A rectangle that holds two.
#[inline(always)]
pub(super) fn union([a, b, c, d]: [f64; 4], [e, f, g, h]: [f64; 4]) -> [f64; 4] {
    [lesser(e, a), lesser(f, b), greater(g, c), greater(h, d)]
}

/// All pieces that each of a light's views sees, in parts; of those that may meet a point if that is known. `error` is that of corners in all views.
pub(super) fn see_all(
    pieces: &Pieces,
    views: &[View],
    error: f64,
    occupancies: Option<&[Occupancy]>,
) -> Vec<Vec<Vec<Placed>>> {
    let runs = pieces.runs();
    let parts = runs.par_chunks(runs.len().div_ceil(PARTS).max(1)).with_max_len(1);
    let parts: Vec<_> = parts.map(|runs| dispatch(See { pieces, views, error, occupancies, runs })).collect();
    let mut of_views: Vec<Vec<Vec<Placed>>> = views.iter().map(|_| Vec::with_capacity(parts.len())).collect();
    for part in parts {
        of_views.iter_mut().zip(part).for_each(|(of_view, seen)| of_view.push(seen));
    }
    of_views
}

struct See<'a> {
    pieces: &'a Pieces<'a>,
    views: &'a [View],
    error: f64,
    occupancies: Option<&'a [Occupancy]>,
    runs: &'a [Range<u32>],
}

impl Kernel for See<'_> {
    type Output = Vec<Vec<Placed>>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Vec<Vec<Placed>> {
        let is_sun = self.views[0].is_sun();
        // A sun sees them all.
        let sees_all = is_sun && self.occupancies.is_none();
        let most = if sees_all { self.runs.iter().map(ExactSizeIterator::len).sum() } else { 0 };
        let mut seen: Vec<Vec<Placed>> = self.views.iter().map(|_| Vec::with_capacity(most)).collect();
        for run in self.runs {
            match self.pieces.triangles(run) {
                Some(triangles) if is_sun => self.see_triangles::<true>(&triangles, &mut seen),
                Some(triangles) => self.see_triangles::<false>(&triangles, &mut seen),
                None => self.pieces.for_each(run.clone(), |piece, corners| self.see_piece(piece, corners, &mut seen)),
            }
        }
        seen
    }
}

impl See<'_> {
    fn see_piece(&self, piece: u32, corners: &[DVec3], seen: &mut [Vec<Placed>]) {
        for (number, (view, seen)) in self.views.iter().zip(seen).enumerate() {
            if let Some(bounds) = view.bounds(corners, self.error) {
                let is_reversed = matches!(*corners, [a, b, c] if view.is_reversed(&[a, b, c]));
                let nearest = view.nearest(corners, self.error);
                if self.occupancies.is_none_or(|of_views| of_views[number].may_meet(bounds, nearest)) {
                    seen.push(Placed { bounds, piece, is_reversed });
                }
            }
        }
    }

    #[inline(always)]
    fn see_triangles<const IS_SUN: bool>(&self, triangles: &Triangles, seen: &mut [Vec<Placed>]) {
        let mut corners = Gathered::<3, 8>::default();
        if triangles.are_all_kept() {
            for (first, triangles_here) in (triangles.first..).step_by(8).zip(triangles.all.chunks(8)) {
                corners.gather(triangles_here, triangles.positions, 0);
                let pieces = [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| first + lane);
                self.see_eight::<IS_SUN>(&pieces[..triangles_here.len()], &corners, seen);
            }
            return;
        }
        let (mut pieces, mut count) = ([0; 8], 0);
        for (piece, triangle) in triangles.kept() {
            (0..3).for_each(|k| corners.set(k, count, triangles.positions[triangle[k] as usize]));
            pieces[count] = piece;
            count += 1;
            if count == pieces.len() {
                self.see_eight::<IS_SUN>(&pieces, &corners, seen);
                count = 0;
            }
        }
        if count > 0 {
            self.see_eight::<IS_SUN>(&pieces[..count], &corners, seen);
        }
    }

    /// Eight triangles or fewer.
    #[inline(always)]
    fn see_eight<const IS_SUN: bool>(&self, pieces: &[u32], corners: &Gathered<3, 8>, seen: &mut [Vec<Placed>]) {
        for (number, (&view, seen)) in self.views.iter().zip(seen).enumerate() {
            let mut is_beyond = [false; 8];
            if !IS_SUN {
                for (lane, is_beyond) in is_beyond.iter_mut().enumerate() {
                    *is_beyond = view.is_beyond(&corners.triangle(lane), self.error);
                }
                if is_beyond == [true; 8] {
                    continue;
                }
            }
            let eight = Eight::of::<IS_SUN>(&view, corners, self.error);
            let is_met = match self.occupancies {
                Some(of_views) => of_views[number].may_meet_eight(&eight.bounds, &eight.nearest),
                None => [true; 8],
            };
            for (lane, &piece) in pieces.iter().enumerate() {
                if is_met[lane] & !is_beyond[lane] {
                    seen.push(eight.placed(lane, piece));
                }
            }
        }
    }
}

/// What a view sees of eight triangles, lane by lane.
struct Eight {
    /// Least u, v, greatest u, v.
    bounds: [[f64; 8]; 4],
    nearest: [f64; 8],
    is_reversed: [bool; 8],
}

impl Eight {
    #[inline(always)]
    fn of<const IS_SUN: bool>(view: &View, corners: &Gathered<3, 8>, error: f64) -> Self {
        let mut eight = Self { bounds: [[0.0; 8]; 4], nearest: [0.0; 8], is_reversed: [false; 8] };
        for lane in 0..8 {
            let triangle = corners.triangle(lane);
            let [u0, v0, u1, v1] =
                if IS_SUN { view.sun_bounds(&triangle, error) } else { view.lamp_bounds(&triangle, error) };
            let [u0_to, v0_to, u1_to, v1_to] = &mut eight.bounds;
            (u0_to[lane], v0_to[lane], u1_to[lane], v1_to[lane]) = (u0, v0, u1, v1);
            eight.nearest[lane] = view.nearest(&triangle, error);
            eight.is_reversed[lane] = view.is_reversed(&triangle);
        }
        eight
    }

    #[inline(always)]
    fn placed(&self, lane: usize, piece: u32) -> Placed {
        let [u0, v0, u1, v1] = &self.bounds;
        Placed { bounds: [u0[lane], v0[lane], u1[lane], v1[lane]], piece, is_reversed: self.is_reversed[lane] }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use umbriel_geometry::{
        LightSource, Mesh, Placement,
        simd::{Level, dispatch_at},
    };
    use umbriel_scene::{Object, Scene, Shape, Sides};

    use super::*;
    use crate::query::Queries;

    /// 21 triangles round the origin: small ones that one view sees, then some that several see or that lie about the origin.
    fn scene() -> Scene {
        let at = |turn: f64, size: f64, far: f64| {
            let middle = DVec3::new(libm::cos(turn), libm::sin(2.0 * turn), libm::sin(turn)) * far;
            [DVec3::X, DVec3::Y + DVec3::X * 0.25, DVec3::Z - DVec3::X].map(|off| (middle + off * size).to_array())
        };
        let small = (0..15).map(|k| at(f64::from(k) * 0.7, 0.125, 3.0));
        let large = (0..6).map(|k| at(f64::from(k), 4.0, f64::from(k)));
        let positions: Vec<[f64; 3]> = small.chain(large).flatten().collect();
        let triangles = (0..positions.len() as u32).step_by(3).map(|k| [k, k + 1, k + 2]).collect();
        let shape = Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")));
        let object = Object::new("around".into(), shape, Placement::IDENTITY, Sides::Two).expect("an object");
        Scene { objects: vec![object].into(), ..Scene::default() }
    }

    #[test]
    fn eight_at_a_time_are_seen_as_one_by_one() {
        let scene = scene();
        let queries = Queries::new(&scene);
        let pieces = Pieces::of(&queries.bodies).expect("few pieces");
        for light in [LightSource::point([0.125, 0.0, -0.25]), LightSource::sun([1.0, -3.0, 2.0])] {
            let views = View::all(&light.expect("a light"), &pieces.bounds);
            let error = views[0].error(pieces.slack, views[0].reach(&pieces.bounds));
            let mut one_by_one: Vec<Vec<Placed>> = vec![Vec::new(); views.len()];
            let runs = pieces.runs();
            let see = || See { pieces: &pieces, views: &views, error, occupancies: None, runs: &runs };
            runs.iter().for_each(|run| {
                pieces.for_each(run.clone(), |piece, corners| see().see_piece(piece, corners, &mut one_by_one));
            });
            for level in Level::ALL {
                assert_eq!(dispatch_at(level, see()), one_by_one, "{level:?}");
            }
            let counts: Vec<usize> = one_by_one.iter().map(Vec::len).collect();
            assert!(views.len() == 1 || counts.iter().all(|&count| (1..21).contains(&count)), "{counts:?}");
        }
    }
}
