//! The pieces over a tile as the tile sees them, eight at a time, in the order of their list ([`order`](super::order)).
//!
//! What eight triangles cover is found by the same steps without branches ([`Footprint::of`]), lane by lane, so that the compiler makes vectors of them. The
//! few that are seen edge-on and curved bodies are put into their lanes one by one. Cost: some tens of nanoseconds a triangle.

use glam::DVec3;
use umbriel_geometry::{
    gathered::Gathered,
    simd::{Kernel, Simd, dispatch},
};

use crate::{
    light_space::{CornerError, Footprint, Homogeneous, View},
    loose::{
        group::{Extent, Group},
        pieces::{Piece, Pieces},
    },
};

/// How a tile sees: from −1 to 1 over it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window<'a> {
    pub(super) view: &'a View,
    /// Where u and v are counted from.
    pub(super) corner: [f64; 2],
    /// Half tiles over a unit of u and v.
    pub(super) density: f64,
    /// The tile's middle, half tiles from the corner.
    pub(super) middle: [f64; 2],
    /// Errors of corners in units of half a tile.
    pub(super) error: CornerError,
    /// Cells of the tile over half of it.
    pub(super) cells: f32,
    /// Whether surfaces that are closed are so in it.
    pub(super) with_surfaces: bool,
}

/// The pieces over a tile, eight that follow each other in their list in each group.
#[derive(Debug, Default)]
pub(super) struct Listed {
    pub(super) groups: Vec<Group>,
    pub(super) extents: Vec<Extent>,
    /// The faces that each group's triangles are of, by the first piece of each; integers as vectors have them.
    pub(super) faces: Vec<[i32; 8]>,
}

/// Corners of eight triangles.
type Corners = Gathered<3, 8>;

/// Sees all pieces of a list.
pub(super) fn see_listed(window: Window, pieces: &Pieces, list: &[u32]) -> Listed {
    dispatch(See { window, pieces, list })
}

struct See<'a> {
    window: Window<'a>,
    pieces: &'a Pieces<'a>,
    list: &'a [u32],
}

impl Kernel for See<'_> {
    type Output = Listed;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Listed {
        if self.window.view.is_sun() { self.all::<true>() } else { self.all::<false>() }
    }
}

impl See<'_> {
    #[inline(always)]
    fn all<const IS_SUN: bool>(&self) -> Listed {
        let mut hint = 0;
        let count = self.list.len().div_ceil(8);
        let mut all = Listed {
            groups: Vec::with_capacity(count),
            extents: Vec::with_capacity(count),
            faces: Vec::with_capacity(count),
        };
        let mut corners = Corners::default();
        for list in self.list.chunks(8) {
            let (mut holes, mut curved, mut closed, mut faces) = (0, 0, 0, [0; 8]);
            for (lane, &number) in list.iter().enumerate() {
                let (piece, first) = self.pieces.get(number, &mut hint);
                faces[lane] = first as i32;
                let triangle = match piece {
                    Piece::Triangle { corners, is_closed } => {
                        closed |= u8::from(is_closed & self.window.with_surfaces) << lane;
                        corners
                    }
                    Piece::CutOut(triangle) => {
                        holes |= 1 << lane;
                        triangle
                    }
                    Piece::Box(_) => {
                        curved |= 1 << lane;
                        continue;
                    }
                };
                (0..3).for_each(|k| corners.set(k, lane, triangle[k]));
            }
            let mut seen = self.see_eight::<IS_SUN>(&corners, &faces, [holes, curved, 0xff >> (8 - list.len())]);
            seen.extent.closed = closed;
            (list.len()..8).for_each(|lane| seen.clear(lane));
            all.groups.push(seen.group);
            all.extents.push(seen.extent);
            all.faces.push(faces);
        }
        all
    }

    /// Which of the eight have holes, which are curved, and which are there at all, a bit each.
    #[inline(always)]
    fn see_eight<const IS_SUN: bool>(
        &self,
        corners: &Corners,
        faces: &[i32; 8],
        [holes, curved, valid]: [u8; 3],
    ) -> Lanes {
        let mut seen = Lanes::EMPTY;
        for lane in 0..8 {
            let footprint = Footprint::of::<IS_SUN>(&self.window.triangle(corners, lane), self.window.error);
            seen.set::<IS_SUN>(lane, &footprint);
        }
        let mut single = valid & (curved | !bits(seen.turned));
        while single != 0 {
            let lane = single.trailing_zeros() as usize;
            single &= single - 1;
            let footprint = if curved >> lane & 1 == 0 {
                Footprint::edge_on::<IS_SUN>(&self.window.triangle(corners, lane), self.window.error)
            } else {
                self.curved::<IS_SUN>(faces[lane] as u32)
            };
            seen.set::<IS_SUN>(lane, &footprint);
        }
        seen.extent.vague = holes | !bits(seen.known);
        seen.extent.reversed = bits(seen.reversed);
        seen
    }

    /// A curved body may be anywhere inside its box.
    fn curved<const IS_SUN: bool>(&self, piece: u32) -> Footprint {
        let (Piece::Box(bounds), _) = self.pieces.get(piece, &mut 0) else { unreachable!("told before") };
        let corners = bounds.corners().map(|corner| self.window.see(corner));
        Footprint::somewhere::<IS_SUN>(&corners, self.window.error)
    }
}

impl Window<'_> {
    /// Where in the tile a place along an axis is.
    #[inline(always)]
    pub(super) fn along(&self, place: f64, axis: usize) -> f32 {
        (self.density * (place - self.corner[axis]) - self.middle[axis]) as f32
    }

    #[inline(always)]
    fn see(&self, corner: DVec3) -> Homogeneous {
        let seen = self.view.see(corner);
        Homogeneous {
            x: self.density * (seen.x - self.corner[0] * seen.w) - self.middle[0] * seen.w,
            y: self.density * (seen.y - self.corner[1] * seen.w) - self.middle[1] * seen.w,
            ..seen
        }
    }

    #[inline(always)]
    fn triangle(&self, corners: &Corners, lane: usize) -> [Homogeneous; 3] {
        let [a, b, c] = corners.triangle(lane);
        [self.see(a), self.see(b), self.see(c)]
    }
}

/// Eight pieces, a lane each. Made here and then moved: written straight into the lists, the lanes do not become vectors.
struct Lanes {
    group: Group,
    extent: Extent,
    /// Whose planes are known.
    known: [bool; 8],
    turned: [bool; 8],
    reversed: [bool; 8],
}

impl Lanes {
    const EMPTY: Self = Self {
        group: Group::EMPTY,
        extent: Extent::EMPTY,
        known: [false; 8],
        turned: [false; 8],
        reversed: [false; 8],
    };

    #[inline(always)]
    fn set<const IS_SUN: bool>(&mut self, lane: usize, footprint: &Footprint) {
        // The view's unit, known while compiling: asked of the view here, the lanes do not become vectors.
        self.known[lane] = self.group.set(lane, footprint, if IS_SUN { 1.0 } else { 0.0 });
        self.extent.set(lane, footprint);
        self.turned[lane] = footprint.is_turned;
        self.reversed[lane] = footprint.is_reversed;
    }

    /// Leaves nothing in a lane.
    #[inline(always)]
    fn clear(&mut self, lane: usize) {
        self.group.clear(lane);
        self.extent.clear(lane);
    }
}

#[inline(always)]
fn bits(lanes: [bool; 8]) -> u8 {
    lanes.iter().enumerate().fold(0, |bits, (lane, &is_set)| bits | u8::from(is_set) << lane)
}
