//! Faces by number, and what a view sees of them.

use std::collections::{BTreeMap, HashSet};

use umbriel_geometry::{Facet, Facets, LightSource, Sign, cut_out::Opacity};

use super::{
    clip::clip,
    images::Images,
    sampler::{IsLit, Sampled},
    view::{Image, View},
};
pub(super) use crate::fine::packed_tree::Rect;
use crate::solids::Solids;

/// One object's part.
pub(super) struct Source<'a> {
    pub(super) object: u32,
    pub(super) facets: &'a Facets,
    /// See [`Sampled::is_box`].
    is_box: bool,
    pub(super) solids: &'a Solids,
    /// What the numbers of its solids are counted from.
    pub(super) first_solid: u32,
    is_lit: Option<&'a IsLit<'a>>,
    light: &'a LightSource,
}

impl<'a> Source<'a> {
    pub(super) fn all(objects: &[Sampled<'a>], light: &'a LightSource) -> Vec<Self> {
        let mut solid_count = 0;
        let source = |&Sampled { object, facets, is_box, solids, receives, .. }: &Sampled<'a>| {
            let first_solid = solid_count;
            solid_count += solids.len() as u32;
            Self { object, facets, is_box, solids, first_solid, is_lit: receives.map(|(_, is_lit)| is_lit), light }
        };
        objects.iter().map(source).collect()
    }

    /// Whether it has samples.
    pub(super) fn receives(&self) -> bool {
        self.is_lit.is_some()
    }

    /// The convex solid that a face belongs to.
    #[inline(always)]
    pub(super) fn convex(&self, face: usize) -> Option<u32> {
        let (number, solid) = self.solids.get(face)?;
        solid.is_convex.then_some(self.first_solid + number)
    }

    /// The same, if the face turns so that rays from it to the light leave the solid: none of its faces is in their way.
    #[inline(always)]
    pub(super) fn convex_behind(&self, face: usize, turn: Option<Sign>) -> Option<u32> {
        let (number, solid) = self.solids.get(face)?;
        let is_left = turn? == if solid.is_inward { Sign::Negative } else { Sign::Positive };
        (is_left && solid.is_convex).then_some(self.first_solid + number)
    }

    /// Which way a face turns as seen from the light. Exact.
    pub(super) fn turn(&self, face: usize) -> Sign {
        self.facets.turn(face, self.light)
    }

    /// Whether rays to the light only enter a box by a face: what they meet in it they leave by another one.
    #[inline(always)]
    pub(super) fn is_entered(&self, face: usize) -> bool {
        self.is_box && self.turn(face) == Sign::Negative
    }

    /// Whether a face has nothing to receive, and blocks nothing that other faces of its solid do not block as well: on their
    /// way to a light outside, rays do not leave the solid by it (NUMERICS.md, "Samples by scan conversion").
    #[inline(always)]
    pub(super) fn is_spare(&self, face: usize, images: &[Image; 4], view: &View) -> bool {
        let Some((_, solid)) = self.solids.get(face) else { return false };
        let Some(turn) = view.turn(images) else { return false };
        let is_left = (turn == Sign::Positive) != solid.is_inward;
        let is_outside = || self.light.is_sun() || !solid.bounds.contains(self.light.xyz());
        !is_left && is_outside() && !self.is_lit.is_some_and(|is_lit| is_lit(face, Some(turn)))
    }
}

/// A face of a source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Face {
    /// Index into the sources.
    pub(super) source: u32,
    pub(super) number: u32,
}

/// A triangle of a face's fan: one of a triangle, two of a parallelogram, up to six of a face that is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Piece {
    source: u32,
    /// The face's number below, that of the piece in the highest three bits.
    number: u32,
}

impl Piece {
    /// None of all pieces.
    pub(super) const NONE: Self = Self { source: u32::MAX, number: u32::MAX };

    const NUMBER_BITS: u32 = 29;

    #[inline(always)]
    pub(super) fn new(face: Face, piece: u32) -> Self {
        Self { source: face.source, number: face.number | piece << Self::NUMBER_BITS }
    }

    #[inline(always)]
    pub(super) fn face(self) -> Face {
        Face { source: self.source, number: self.number & ((1 << Self::NUMBER_BITS) - 1) }
    }

    /// Which triangle of the face's fan it is.
    #[inline(always)]
    pub(super) fn place(self) -> usize {
        (self.number >> Self::NUMBER_BITS) as usize
    }
}

impl Rect {
    /// The box of some images.
    #[inline(always)]
    pub(super) fn of(images: &[Image]) -> Self {
        images.iter().fold(Self::EMPTY, |rect, image| Self {
            min: [rect.min[0].min(image.x), rect.min[1].min(image.y)],
            max: [rect.max[0].max(image.x), rect.max[1].max(image.y)],
        })
    }
}

/// The least and the greatest depth.
#[inline(always)]
pub(super) fn depths(images: &[Image]) -> [f32; 2] {
    let depths = images.iter().map(|image| image.depth);
    depths.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], depth| [low.min(depth), high.max(depth)])
}

/// The images of a face's corners, the last repeated for a triangle, and how many there are.
#[inline(always)]
pub(super) fn corners(facets: &Facets, images: &[Image], face: usize) -> ([Image; 4], usize) {
    let at = |number: u32| images[number as usize];
    match facets.facet(face) {
        Facet::Triangle([a, b, c]) => ([at(a), at(b), at(c), at(c)], 3),
        Facet::Parallelogram(numbers) => (numbers.map(at), 4),
    }
}

/// What a view sees of a face.
#[derive(Clone, Debug)]
pub(super) enum Sight {
    Nothing,
    /// All corners have images.
    Whole,
    /// A convex part that holds all of the window.
    Clipped(Vec<Image>),
    /// Nothing bounds its image.
    Unbounded,
}

/// What the view sees of a face whose corners have these images.
#[inline(always)]
pub(super) fn sight(facets: &Facets, face: usize, images: &[Image], view: &View) -> Sight {
    if images.iter().all(Image::is_valid) { Sight::Whole } else { partial_sight(facets, face, images, view) }
}

fn partial_sight(facets: &Facets, face: usize, images: &[Image], view: &View) -> Sight {
    if images.iter().fold(-1, |beyond, image| beyond & if image.is_valid() { 0 } else { image.x }) != 0 {
        return Sight::Nothing;
    }
    let corners = facets.facet(face).corners();
    let points: Vec<_> = corners.iter().map(|&corner| view.homogeneous(facets.positions()[corner as usize])).collect();
    let slack = corners.iter().map(|&corner| facets.point(corner).slack.max_element()).fold(0.0, f64::max);
    match clip(points, slack, view) {
        Some(images) if images.is_empty() => Sight::Nothing,
        Some(images) => Sight::Clipped(images),
        None => Sight::Unbounded,
    }
}

/// All faces under one view.
pub(super) struct Faces<'a> {
    pub(super) sources: &'a [Source<'a>],
    pub(super) images: Images,
    /// What is left of the faces that are not seen as a whole; nothing of those that nothing bounds.
    pub(super) clipped: BTreeMap<Face, Vec<Image>>,
    /// Faces that others of a pile repeat ([`repeats`](super::repeats)).
    pub(super) repeats: HashSet<Face>,
}

impl Faces<'_> {
    /// What is left of a face that is not seen as a whole.
    #[inline(always)]
    pub(super) fn clipped(&self, face: Face) -> Option<&[Image]> {
        if self.clipped.is_empty() { None } else { self.clipped.get(&face).map(Vec::as_slice) }
    }

    /// What of a face blocks that others do not. A body may be anywhere in its box.
    #[inline(always)]
    pub(super) fn opacity(&self, face: Face) -> Opacity {
        if !self.repeats.is_empty() && self.repeats.contains(&face) {
            return Opacity::Clear;
        }
        let source = &self.sources[face.source as usize];
        if source.is_box { Opacity::Mixed } else { source.facets.opacity(face.number as usize) }
    }

    #[inline(always)]
    pub(super) fn corners(&self, face: Face) -> ([Image; 4], usize) {
        corners(self.sources[face.source as usize].facets, self.images.of(face.source), face.number as usize)
    }

    /// The corners of a piece; `None` for none, and for a face whose shadow nothing bounds.
    #[inline(always)]
    pub(super) fn triangle(&self, piece: Piece) -> Option<[Image; 3]> {
        if piece == Piece::NONE {
            return None;
        }
        let (face, place) = (piece.face(), piece.place());
        match self.clipped(face) {
            Some([]) => None,
            Some(images) => Some([images[0], images[place + 1], images[place + 2]]),
            None => {
                let (corners, _) = self.corners(face);
                Some([corners[0], corners[place + 1], corners[place + 2]])
            }
        }
    }
}
