//! The pieces over a tile as the tile sees them, eight at a time, in the order of their list.
//!
//! What eight triangles cover is found by the same steps without branches ([`Footprint::of`]), lane by lane, so that the compiler makes vectors of them. The
//! few that are seen edge-on and curved bodies are put into their lanes one by one. Cost: some tens of nanoseconds a triangle.

use glam::DVec3;
use umbriel_geometry::simd::{Kernel, Simd, dispatch};

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
    /// Half tiles beside the tile where pieces matter.
    pub(super) margin: f64,
}

/// Eight pieces, a lane each.
#[derive(Clone, Debug)]
pub(super) struct Listed {
    pub(super) pieces: [u32; 8],
    pub(super) group: Group,
    pub(super) extent: Extent,
    /// Which are seen the other way round than by their winding in (u, v).
    pub(super) reversed: u8,
    /// Which may meet the window.
    pub(super) met: u8,
}

/// Corners of eight triangles: corner, axis, lane.
type Corners = [[[f64; 8]; 3]; 3];

/// Sees all pieces of a list.
pub(super) fn see_listed(window: Window, pieces: &Pieces, list: &[u32]) -> Vec<Listed> {
    dispatch(See { window, pieces, list })
}

struct See<'a> {
    window: Window<'a>,
    pieces: &'a Pieces<'a>,
    list: &'a [u32],
}

impl Kernel for See<'_> {
    type Output = Vec<Listed>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Vec<Listed> {
        if self.window.view.is_sun() { self.all::<true>() } else { self.all::<false>() }
    }
}

impl See<'_> {
    #[inline(always)]
    fn all<const IS_SUN: bool>(&self) -> Vec<Listed> {
        let mut hint = 0;
        let mut all = vec![Listed::EMPTY; self.list.len().div_ceil(8)];
        let mut corners = [[[0.0; 8]; 3]; 3];
        for (list, listed) in self.list.chunks(8).zip(&mut all) {
            let (mut holes, mut curved) = (0, 0);
            for (lane, &number) in list.iter().enumerate() {
                listed.pieces[lane] = number;
                match self.pieces.get(number, &mut hint) {
                    Piece::Triangle(triangle) => set(&mut corners, lane, &triangle),
                    Piece::CutOut(triangle) => {
                        set(&mut corners, lane, &triangle);
                        holes |= 1 << lane;
                    }
                    Piece::Box(_) => curved |= 1 << lane,
                }
            }
            let valid = 0xff >> (8 - list.len());
            self.see_eight::<IS_SUN>(&corners, [holes, curved, valid], listed);
        }
        all
    }

    /// Which of the eight have holes, which are curved, and which are there at all, a bit each.
    #[inline(always)]
    fn see_eight<const IS_SUN: bool>(&self, corners: &Corners, [holes, curved, valid]: [u8; 3], listed: &mut Listed) {
        // Not the list's own: what is known to lie nowhere else becomes vectors.
        let mut seen = Lanes::EMPTY;
        for lane in 0..8 {
            let footprint = Footprint::of::<IS_SUN>(&self.window.triangle(corners, lane), self.window.error);
            seen.set::<IS_SUN>(lane, &footprint, self.window.margin);
        }
        let mut single = valid & (curved | !bits(seen.turned));
        while single != 0 {
            let lane = single.trailing_zeros() as usize;
            single &= single - 1;
            let footprint = if curved >> lane & 1 == 0 {
                Footprint::edge_on::<IS_SUN>(&self.window.triangle(corners, lane), self.window.error)
            } else {
                self.curved::<IS_SUN>(listed.pieces[lane])
            };
            seen.set::<IS_SUN>(lane, &footprint, self.window.margin);
        }
        (listed.group, listed.extent) = (seen.group, seen.extent);
        listed.extent.vague = holes | !bits(seen.known);
        listed.reversed = bits(seen.reversed);
        listed.met = valid & bits(seen.met);
    }

    /// A curved body may be anywhere inside its box.
    fn curved<const IS_SUN: bool>(&self, piece: u32) -> Footprint {
        let Piece::Box(bounds) = self.pieces.get(piece, &mut 0) else { unreachable!("told before") };
        let corners = bounds.corners().map(|corner| self.window.see(corner));
        Footprint::somewhere::<IS_SUN>(&corners, self.window.error)
    }
}

impl Window<'_> {
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
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = corners;
        [
            self.see(DVec3::new(ax[lane], ay[lane], az[lane])),
            self.see(DVec3::new(bx[lane], by[lane], bz[lane])),
            self.see(DVec3::new(cx[lane], cy[lane], cz[lane])),
        ]
    }
}

#[inline(always)]
fn set(corners: &mut Corners, lane: usize, triangle: &[DVec3; 3]) {
    for (to, corner) in corners.iter_mut().zip(triangle) {
        let [x, y, z] = to;
        (x[lane], y[lane], z[lane]) = (corner.x, corner.y, corner.z);
    }
}

impl Listed {
    const EMPTY: Self = Self { pieces: [0; 8], group: Group::EMPTY, extent: Extent::EMPTY, reversed: 0, met: 0 };
}

/// What is made lane by lane.
struct Lanes {
    group: Group,
    extent: Extent,
    /// Whose planes are known.
    known: [bool; 8],
    turned: [bool; 8],
    reversed: [bool; 8],
    met: [bool; 8],
}

impl Lanes {
    const EMPTY: Self = Self {
        group: Group::EMPTY,
        extent: Extent::EMPTY,
        known: [false; 8],
        turned: [false; 8],
        reversed: [false; 8],
        met: [false; 8],
    };

    #[inline(always)]
    fn set<const IS_SUN: bool>(&mut self, lane: usize, footprint: &Footprint, margin: f64) {
        self.known[lane] = self.group.set(lane, footprint, if IS_SUN { 1.0 } else { 0.0 });
        self.extent.set(lane, footprint);
        self.turned[lane] = footprint.is_turned;
        self.reversed[lane] = footprint.is_reversed;
        self.met[lane] = footprint.may_meet_window(margin);
    }
}

#[inline(always)]
fn bits(lanes: [bool; 8]) -> u8 {
    lanes.iter().enumerate().fold(0, |bits, (lane, &is_set)| bits | u8::from(is_set) << lane)
}
