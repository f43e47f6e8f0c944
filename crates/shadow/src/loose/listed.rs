//! The pieces over a tile as the tile sees them, eight at a time, in the order of their list.
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
        group::{Extent, Group, whole},
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
    /// Cells of the tile over half of it.
    pub(super) cells: f32,
}

/// Eight pieces, a lane each.
#[derive(Clone, Debug)]
pub(super) struct Listed {
    /// Their faces, by the first piece of each; integers as vectors have them.
    pub(super) faces: [i32; 8],
    pub(super) group: Group,
    pub(super) extent: Extent,
    /// Neighbours by [`key`] belong together.
    pub(super) keys: [u32; 8],
    /// Which may meet the window.
    pub(super) met: u8,
}

/// Corners of eight triangles.
type Corners = Gathered<3, 8>;

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
        let mut corners = Corners::default();
        for (list, listed) in self.list.chunks(8).zip(&mut all) {
            let (mut holes, mut curved) = (0, 0);
            for (lane, &number) in list.iter().enumerate() {
                let (piece, first) = self.pieces.get(number, &mut hint);
                listed.faces[lane] = first as i32;
                let triangle = match piece {
                    Piece::Triangle(triangle) => triangle,
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
            let valid = 0xff >> (8 - list.len());
            self.see_eight::<IS_SUN>(&corners, [holes, curved, valid], listed);
        }
        all
    }

    /// Which of the eight have holes, which are curved, and which are there at all, a bit each.
    #[inline(always)]
    fn see_eight<const IS_SUN: bool>(&self, corners: &Corners, [holes, curved, valid]: [u8; 3], listed: &mut Listed) {
        // Made here and then moved: written straight into the list, the lanes do not become vectors.
        let mut seen = Lanes::EMPTY;
        for lane in 0..8 {
            let footprint = Footprint::of::<IS_SUN>(&self.window.triangle(corners, lane), self.window.error);
            seen.set::<IS_SUN>(lane, &footprint, &self.window);
        }
        let mut single = valid & (curved | !bits(seen.turned));
        while single != 0 {
            let lane = single.trailing_zeros() as usize;
            single &= single - 1;
            let footprint = if curved >> lane & 1 == 0 {
                Footprint::edge_on::<IS_SUN>(&self.window.triangle(corners, lane), self.window.error)
            } else {
                self.curved::<IS_SUN>(listed.faces[lane] as u32)
            };
            seen.set::<IS_SUN>(lane, &footprint, &self.window);
        }
        (listed.group, listed.extent) = (seen.group, seen.extent);
        listed.extent.vague = holes | !bits(seen.known);
        let place_bits = place_bits(self.list.len().div_ceil(8));
        for lane in 0..8 {
            listed.keys[lane] = key(listed.extent.lane(lane), seen.reversed[lane], self.window.cells, place_bits);
        }
        listed.met = valid & bits(seen.met);
    }

    /// A curved body may be anywhere inside its box.
    fn curved<const IS_SUN: bool>(&self, piece: u32) -> Footprint {
        let (Piece::Box(bounds), _) = self.pieces.get(piece, &mut 0) else { unreachable!("told before") };
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
        [self.see(corners.at(0, lane)), self.see(corners.at(1, lane)), self.see(corners.at(2, lane))]
    }
}

impl Listed {
    const EMPTY: Self = Self { faces: [0; 8], group: Group::EMPTY, extent: Extent::EMPTY, keys: [0; 8], met: 0 };
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
    fn set<const IS_SUN: bool>(&mut self, lane: usize, footprint: &Footprint, window: &Window) {
        // The view's unit, known while compiling: asked of the view here, the lanes do not become vectors.
        self.known[lane] = self.group.set(lane, footprint, if IS_SUN { 1.0 } else { 0.0 });
        self.extent.set(lane, footprint);
        self.turned[lane] = footprint.is_turned;
        self.reversed[lane] = footprint.is_reversed;
        self.met[lane] = footprint.may_meet_window(window.margin);
    }
}

#[inline(always)]
fn bits(lanes: [bool; 8]) -> u8 {
    lanes.iter().enumerate().fold(0, |bits, (lane, &is_set)| bits | u8::from(is_set) << lane)
}

/// Places along a side that keys tell apart, as a power of two: about as many in all as there are pieces.
fn place_bits(eights: usize) -> u32 {
    ((8 * eights).max(1).ilog2() / 2).clamp(4, 8)
}

/// How many keys there are for so many eights: three sizes, two facings, and the places.
pub(super) fn keys(eights: usize) -> usize {
    6 << (2 * place_bits(eights))
}

/// Neighbours in this order go into one group: triangles of like size, then of one facing, then along a Morton curve. `cells` lie over half the tile.
#[inline(always)]
fn key([u0, v0, u1, v1]: [f32; 4], is_reversed: bool, cells: f32, place_bits: u32) -> u32 {
    let (u0, v0, u1, v1) = (within(u0), within(v0), within(u1), within(v1));
    let (wide, high) = (u1 - u0, v1 - v0);
    let longer = if wide > high { wide } else { high };
    let extent = longer * cells;
    let class = u32::from(extent >= 2.0) + u32::from(extent >= 6.0);
    let last = ((1u32 << place_bits) - 1) as f32;
    let place = |low: f32, high: f32| whole(((low + high) * 0.25 + 0.5) * last);
    let morton = spread_bits(place(u0, u1)) | spread_bits(place(v0, v1)) << 1;
    (class << 1 | u32::from(is_reversed)) << (2 * place_bits) | morton
}

/// The nearest place of the tile.
#[inline(always)]
fn within(bound: f32) -> f32 {
    let bound = if bound > -1.0 { bound } else { -1.0 };
    if bound < 1.0 { bound } else { 1.0 }
}

/// Eight bits with gaps between them.
#[inline(always)]
fn spread_bits(x: u32) -> u32 {
    let x = (x | x << 4) & 0x0f0f;
    let x = (x | x << 2) & 0x3333;
    (x | x << 1) & 0x5555
}
