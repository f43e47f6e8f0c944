//! Occluders side by side: eight triangles a pack.

use rayon::prelude::*;
use umbriel_geometry::{
    cut_out::Opacity,
    simd::{F8, Float, I8, Int, M8, Mask, Simd},
};

use super::{
    faces::{Face, Faces, Piece, Rect},
    tree::{Node, Tree, WIDTH},
    view::Image,
};

/// Nodes that a thread makes at a time, at least.
const NODES: usize = 64;

/// Unit roundoff of f32.
pub(super) const ROUNDOFF: f32 = f32::EPSILON / 2.0;

/// Eight triangles, counter-clockwise as far as their images tell.
#[derive(Clone, Debug)]
pub(super) struct Pack {
    x: [[i32; WIDTH]; 3],
    y: [[i32; WIDTH]; 3],
    depth: [[f32; WIDTH]; 3],
    source: [i32; WIDTH],
    number: [i32; WIDTH],
    /// The convex solid that the face belongs to; −1 for none.
    solid: [i32; WIDTH],
    /// The lanes whose second and third corner have changed places.
    turned: u8,
    /// The lanes whose triangles have holes: they block nothing for certain.
    holed: u8,
}

impl Pack {
    /// Triangles beyond every window.
    pub(super) const EMPTY: Self = Self {
        x: [[i32::MAX; WIDTH]; 3],
        y: [[i32::MAX; WIDTH]; 3],
        depth: [[f32::INFINITY; WIDTH]; 3],
        source: [-1; WIDTH],
        number: [-1; WIDTH],
        solid: [-1; WIDTH],
        turned: 0,
        holed: 0,
    };

    /// Of eight pieces of faces at most, without those that are clear all over.
    pub(super) fn new(faces: &Faces, pieces: &[Piece]) -> Self {
        let mut pack = Self::EMPTY;
        for (lane, &piece) in pieces.iter().enumerate() {
            if let Some(corners) = faces.triangle(piece) {
                let face = piece.face();
                match faces.opacity(face) {
                    Opacity::Opaque => {}
                    Opacity::Mixed => pack.holed |= 1 << lane,
                    Opacity::Clear => continue,
                }
                pack.set(lane, face, &corners);
                let convex = faces.sources[face.source as usize].convex(face.number as usize);
                pack.solid[lane] = convex.map_or(-1, |solid| solid as i32);
            }
        }
        pack
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, face: Face, [a, b, c]: &[Image; 3]) {
        let away = |image: &Image| [i64::from(image.x) - i64::from(a.x), i64::from(image.y) - i64::from(a.y)];
        let ([bx, by], [cx, cy]) = (away(b), away(c));
        let is_turned = bx * cy < by * cx;
        let corners = if is_turned { [a, c, b] } else { [a, b, c] };
        self.turned |= u8::from(is_turned) << lane;
        for (k, corner) in corners.into_iter().enumerate() {
            (self.x[k][lane], self.y[k][lane], self.depth[k][lane]) = (corner.x, corner.y, corner.depth);
        }
        (self.source[lane], self.number[lane]) = (face.source as i32, face.number as i32);
    }

    /// Takes a triangle over from another pack.
    #[inline(always)]
    pub(super) fn copy(&mut self, to: usize, other: &Self, from: usize) {
        for k in 0..3 {
            self.x[k][to] = other.x[k][from];
            self.y[k][to] = other.y[k][from];
            self.depth[k][to] = other.depth[k][from];
        }
        (self.source[to], self.number[to]) = (other.source[from], other.number[from]);
        self.holed = self.holed & !(1 << to) | (other.holed >> from & 1) << to;
    }

    /// The corners of the triangle in a lane, as the face has them.
    #[inline(always)]
    pub(super) fn corners(&self, lane: usize) -> [Image; 3] {
        let corner = |k: usize| Image { x: self.x[k][lane], y: self.y[k][lane], depth: self.depth[k][lane] };
        let [a, b, c] = [corner(0), corner(1), corner(2)];
        if self.turned >> lane & 1 == 1 { [a, c, b] } else { [a, b, c] }
    }

    /// The face in a lane.
    pub(super) fn face(&self, lane: usize) -> Face {
        Face { source: self.source[lane] as u32, number: self.number[lane] as u32 }
    }

    /// The convex solid of the face in a lane; −1 for none.
    pub(super) fn solid(&self, lane: usize) -> i32 {
        self.solid[lane]
    }

    /// The lanes with faces of a solid.
    #[inline(always)]
    pub(super) fn of_solid<S: Simd>(&self, simd: S, solid: i32) -> u32 {
        simd.load_int(&self.solid).eq(simd.splat_int8(solid)).bits()
    }

    /// The box of all images, and the least depth.
    pub(super) fn bounds(&self) -> (Rect, f32) {
        let mut rect = Rect::EMPTY;
        let mut nearest = f32::INFINITY;
        for lane in (0..WIDTH).filter(|&lane| self.source[lane] != -1) {
            for k in 0..3 {
                let [x, y] = [self.x[k][lane], self.y[k][lane]];
                rect = rect.union(&Rect { min: [x, y], max: [x, y] });
                nearest = nearest.min(self.depth[k][lane]);
            }
        }
        (rect, nearest)
    }

    /// The triangles in vectors.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S) -> Triangles<S> {
        Triangles {
            x: [simd.load_int(&self.x[0]), simd.load_int(&self.x[1]), simd.load_int(&self.x[2])],
            y: [simd.load_int(&self.y[0]), simd.load_int(&self.y[1]), simd.load_int(&self.y[2])],
            depth: [simd.load(&self.depth[0]), simd.load(&self.depth[1]), simd.load(&self.depth[2])],
            holed: simd.mask8(u32::from(self.holed)),
        }
    }
}

/// A tree over packs in order.
pub(super) fn tree_of(packs: &[Pack]) -> Tree {
    let lowest = packs.par_chunks(WIDTH).with_min_len(NODES).map(|packs| Node::of(packs.iter().map(Pack::bounds)));
    Tree::above(lowest.collect())
}

/// Eight triangles in vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangles<S: Simd> {
    pub(super) x: [I8<S>; 3],
    pub(super) y: [I8<S>; 3],
    pub(super) depth: [F8<S>; 3],
    /// Those with holes.
    pub(super) holed: M8<S>,
}

/// The corners of eight triangles counted from a point of the image.
pub(super) struct Corners<S: Simd> {
    pub(super) x: [F8<S>; 3],
    pub(super) y: [F8<S>; 3],
    /// The largest coordinate of each triangle.
    pub(super) reach: F8<S>,
}

impl<S: Simd> Triangles<S> {
    /// The corners, counted from `center`.
    #[inline(always)]
    pub(super) fn corners_from(&self, simd: S, center: [i32; 2]) -> Corners<S> {
        let center = [simd.splat_int8(center[0]), simd.splat_int8(center[1])];
        let (mut x, mut y, mut reach) = ([simd.splat8(0.0); 3], [simd.splat8(0.0); 3], simd.splat8(0.0));
        for k in 0..3 {
            x[k] = (self.x[k] - center[0]).to_float();
            y[k] = (self.y[k] - center[1]).to_float();
            reach = reach.max(x[k].abs()).max(y[k].abs());
        }
        Corners { x, y, reach }
    }

    /// The least and the greatest coordinates.
    #[inline(always)]
    pub(super) fn boxes(&self) -> [[I8<S>; 2]; 2] {
        [[least(self.x), least(self.y)], [most(self.x), most(self.y)]]
    }

    /// The boxes of all of them.
    #[inline(always)]
    pub(super) fn node(&self) -> Node {
        Node::of_lanes::<S>(self.boxes(), self.nearest())
    }

    /// The least depth.
    #[inline(always)]
    pub(super) fn nearest(&self) -> F8<S> {
        self.depth[0].min(self.depth[1]).min(self.depth[2])
    }

    /// The greatest depth.
    #[inline(always)]
    pub(super) fn farthest(&self) -> F8<S> {
        self.depth[0].max(self.depth[1]).max(self.depth[2])
    }
}

#[inline(always)]
fn least<V: Int<WIDTH>>(values: [V; 3]) -> V {
    values[0].min(values[1]).min(values[2])
}

#[inline(always)]
fn most<V: Int<WIDTH>>(values: [V; 3]) -> V {
    values[0].max(values[1]).max(values[2])
}
