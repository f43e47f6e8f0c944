//! Convex solids as one occluder each.
//!
//! A sample is in the shadow of a convex solid if and only if its image is in the image of the solid, a convex polygon, and
//! it is behind the planes of all faces by which rays to the light leave: the shadow is a convex polyhedron itself (a shadow
//! volume, Crow 1977). So a box is some six lines and three planes instead of six triangles, and nothing has to be sorted but
//! solids. Where a solid has many faces and a depth alone does not tell that samples are behind, its faces are put into packs
//! of their own. NUMERICS.md, "Volumes". Cost: a look at each vertex and face.

use std::{ops::Range, sync::OnceLock};

use rayon::prelude::*;
use umbriel_geometry::{
    Facets, LightSource, Sign,
    simd::{Kernel, Simd, dispatch},
};

use super::{
    faces::{Face, Faces, Piece, Rect, Source, corners, depths},
    hull::hull,
    images::Images,
    pack::Pack,
    repeats::repeated_volumes,
    tree::{Tree, WIDTH, key},
    view::{Image, View},
};
use crate::solids::Solid;

/// Planes of a volume at most.
const MOST_PLANES: usize = 24;

/// Solids whose lines and planes are kept together.
const SOLIDS: usize = 16;

/// Eight of a kind, one a lane.
pub(super) trait Packed {
    /// Lanes that nothing is in.
    const EMPTY: Self;

    /// Takes one over from others.
    fn copy(&mut self, to: usize, other: &Self, from: usize);
}

/// Directed edges of outlines, the solid to the left.
#[derive(Clone, Debug)]
pub(super) struct Edges {
    pub(super) from: [[i32; WIDTH]; 2],
    pub(super) along: [[i32; WIDTH]; 2],
}

impl Packed for Edges {
    const EMPTY: Self = Self { from: [[0; WIDTH]; 2], along: [[0; WIDTH]; 2] };

    #[inline(always)]
    fn copy(&mut self, to: usize, other: &Self, from: usize) {
        for k in 0..2 {
            self.from[k][to] = other.from[k][from];
            self.along[k][to] = other.along[k][from];
        }
    }
}

/// Planes of faces: distances behind them are normal·point − offset. World metres.
#[derive(Clone, Debug)]
pub(super) struct Planes {
    /// To where the shadow is; over the product of the largest coordinates of two edges, so 2 at most.
    pub(super) normal: [[f64; WIDTH]; 3],
    pub(super) offset: [f64; WIDTH],
}

impl Packed for Planes {
    const EMPTY: Self = Self { normal: [[0.0; WIDTH]; 3], offset: [0.0; WIDTH] };

    #[inline(always)]
    fn copy(&mut self, to: usize, other: &Self, from: usize) {
        for k in 0..3 {
            self.normal[k][to] = other.normal[k][from];
        }
        self.offset[to] = other.offset[from];
    }
}

/// Where some things are, eight a pack.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lanes {
    pub(super) first: usize,
    pub(super) count: usize,
}

impl Lanes {
    /// The packs, each with a bit for each lane that is used.
    #[inline(always)]
    pub(super) fn of<T>(self, packs: &[T]) -> impl Iterator<Item = (&T, u32)> {
        let lanes = move |number: usize| (1 << (self.count - number * WIDTH).min(WIDTH)) - 1;
        let packs = &packs[self.first..self.first + self.count.div_ceil(WIDTH)];
        packs.iter().enumerate().map(move |(number, pack)| (pack, lanes(number)))
    }

    /// Takes these lanes of a pack over; what is here already ends `kept`.
    #[inline(always)]
    pub(super) fn take<P: Packed>(&mut self, kept: &mut Vec<P>, pack: &P, mut lanes: u32) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            if self.count.is_multiple_of(WIDTH) {
                kept.push(P::EMPTY);
            }
            let last = kept.len() - 1;
            kept[last].copy(self.count % WIDTH, pack, lane);
            self.count += 1;
        }
    }
}

/// Lines and planes of some volumes.
#[derive(Default)]
pub(super) struct Sides {
    pub(super) edges: Vec<Edges>,
    pub(super) planes: Vec<Planes>,
    /// A bit a face: whether rays to the light leave by it.
    left: Vec<u64>,
}

/// A convex solid all of which the view sees.
pub(super) struct Volume {
    pub(super) source: u32,
    pub(super) faces: Range<usize>,
    /// How faces turn by which rays to the light leave.
    pub(super) outward: Sign,
    /// Its number among the solids of all sources.
    pub(super) solid: i32,
    pub(super) rect: Rect,
    pub(super) nearest: f32,
    /// What is in its image and deeper than this is behind it.
    pub(super) cover: f32,
    /// Which of the [`Sides`] are its own.
    pub(super) part: usize,
    pub(super) edges: Lanes,
    /// `None` if there are too many.
    pub(super) planes: Option<Lanes>,
    /// The place of its first face's bit.
    first_bit: usize,
    pieces: OnceLock<Pieces>,
}

/// The faces of a volume, in packs.
pub(super) struct Pieces {
    pub(super) packs: Vec<Pack>,
    pub(super) tree: Tree,
}

impl Volume {
    /// Its faces in packs, without some by which rays to the light enter; made when first asked for.
    pub(super) fn pieces(&self, faces: &Faces, view: &View) -> &Pieces {
        self.pieces.get_or_init(|| {
            let all = self.faces.clone().map(|number| Face { source: self.source, number: number as u32 });
            let may_be_left = |&face: &Face| view.turn(&faces.corners(face).0).is_none_or(|turn| turn == self.outward);
            let numbers: Vec<Piece> = all.filter(may_be_left).map(|face| Piece::new(face, 0)).collect();
            // On one thread: others may wait for it.
            let packs: Vec<Pack> = numbers.chunks(WIDTH).map(|pieces| Pack::new(faces, pieces)).collect();
            let boxes: Vec<_> = packs.iter().map(Pack::bounds).collect();
            Pieces { tree: Tree::of_boxes(&boxes), packs }
        })
    }
}

/// All volumes of a view.
pub(super) struct Volumes {
    /// In the order of the light's image.
    pub(super) all: Vec<Volume>,
    pub(super) sides: Vec<Sides>,
    pub(super) tree: Tree,
    /// Faces that receive, by volumes: those of one entry are decided together.
    pub(super) groups: Vec<Vec<(u32, Range<usize>)>>,
}

/// Faces of a group at most.
const GROUP: usize = 128;

impl Volumes {
    /// Whether rays to the light leave a volume by one of its faces.
    #[inline(always)]
    pub(super) fn is_left(&self, volume: &Volume, face: usize) -> bool {
        let bit = volume.first_bit + (face - volume.faces.start);
        self.sides[volume.part].left[bit / 64] >> (bit % 64) & 1 == 1
    }

    /// Of the solids of all sources that the view sees as a whole, and for each source the faces of others.
    pub(super) fn new(
        sources: &[Source],
        images: &Images,
        light: &LightSource,
        view: &View,
    ) -> (Self, Vec<Vec<Range<usize>>>) {
        let mut solids = Vec::new();
        let mut others = Vec::with_capacity(sources.len());
        for (number, source) in sources.iter().enumerate() {
            let (mut rest, mut next) = (Vec::new(), 0);
            for (solid, place) in source.solids.iter().zip(source.first_solid..) {
                let images = &images.of(number as u32)[solid.vertices.clone()];
                if solid.is_convex && solid.owns_its_vertices() && images.iter().all(Image::is_valid) {
                    solids.push((number as u32, solid, place as i32));
                    if next < solid.faces.start {
                        rest.push(next..solid.faces.start);
                    }
                    next = solid.faces.end;
                }
            }
            if next < source.facets.len() {
                rest.push(next..source.facets.len());
            }
            others.push(rest);
        }
        let parts = solids.par_chunks(SOLIDS).enumerate().map_init(Default::default, |storage, (part, solids)| {
            let (mut sides, mut made) = (Sides::default(), Vec::with_capacity(solids.len()));
            for &(source, solid, place) in solids {
                let facets = sources[source as usize].facets;
                let sight = Seen { facets, images: images.of(source), light, view, solid };
                made.push(Some(dispatch(Make { sight, source, place, part, sides: &mut sides, storage })));
            }
            (made, sides)
        });
        let (made, sides): (Vec<_>, Vec<Sides>) = parts.unzip();
        let (keys, all) = in_order(made, view);
        let mut boxes: Vec<_> = all.iter().map(|volume| (volume.rect, volume.nearest)).collect();
        for repeat in repeated_volumes(&all, &keys, sources) {
            // What it blocks the first one blocks: nobody need find it.
            boxes[repeat] = (Rect::EMPTY, f32::INFINITY);
        }
        let groups = groups(&all, sources);
        (Self { tree: Tree::of_boxes(&boxes), groups, sides, all }, others)
    }
}

/// The convex solid that samples all have in common, if they have; −2 stands for none. Its faces block none of them.
#[inline(always)]
pub(super) fn common_solid(mut solids: impl Iterator<Item = i32>) -> Option<i32> {
    let first = solids.next().filter(|&solid| solid >= 0)?;
    solids.all(|solid| solid == first).then_some(first)
}

/// Those volumes that a view may need, each with its key, in the order of its image; equal keys in that of the scene.
fn in_order(mut parts: Vec<Vec<Option<Volume>>>, view: &View) -> (Vec<u64>, Vec<Volume>) {
    let mut keys: Vec<(u64, u32, u32)> = Vec::new();
    for (part, made) in (0..).zip(&parts) {
        for (number, volume) in (0..).zip(made.iter().flatten()) {
            if view.concerns(&volume.rect) {
                keys.push((key(&volume.rect, false, 0), part, number));
            }
        }
    }
    // Volumes are large: only their keys are moved about.
    keys.par_sort_unstable();
    let mut take = |part: u32, number: u32| parts[part as usize][number as usize].take().expect("each is taken once");
    keys.into_iter().map(|(key, part, number)| (key, take(part, number))).unzip()
}

fn groups(volumes: &[Volume], sources: &[Source]) -> Vec<Vec<(u32, Range<usize>)>> {
    let (mut groups, mut used) = (vec![Vec::new()], 0);
    for (number, volume) in volumes.iter().enumerate() {
        if !sources[volume.source as usize].receives() {
            continue;
        }
        let mut first = volume.faces.start;
        while first < volume.faces.end {
            if used == GROUP || used + volume.faces.len().min(GROUP) > GROUP {
                groups.push(Vec::new());
                used = 0;
            }
            let end = volume.faces.end.min(first + GROUP - used);
            groups.last_mut().expect("never empty").push((number as u32, first..end));
            used += end - first;
            first = end;
        }
    }
    groups
}

/// A solid as a view sees it.
struct Seen<'a> {
    facets: &'a Facets,
    images: &'a [Image],
    light: &'a LightSource,
    view: &'a View,
    solid: &'a Solid,
}

/// A volume to be made.
struct Make<'a> {
    sight: Seen<'a>,
    source: u32,
    place: i32,
    part: usize,
    sides: &'a mut Sides,
    storage: &'a mut [Vec<[i32; 2]>; 2],
}

impl Kernel for Make<'_> {
    type Output = Volume;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Volume {
        let Self { sight, source, place, part, sides, storage: [kept, outline] } = self;
        let solid = sight.solid;
        let images = &sight.images[solid.vertices.clone()];
        hull(images, kept, outline);
        let mut volume = Volume {
            source,
            faces: solid.faces.clone(),
            outward: if solid.is_inward { Sign::Negative } else { Sign::Positive },
            solid: place,
            rect: Rect::of(images),
            nearest: depths(images)[0],
            cover: f32::NEG_INFINITY,
            part,
            edges: add_edges(outline, &mut sides.edges),
            planes: None,
            first_bit: 64 * sides.left.len(),
            pieces: OnceLock::new(),
        };
        sight.add_faces(&mut volume, sides);
        volume
    }
}

impl Seen<'_> {
    /// What the faces by which rays to the light leave say of depths.
    #[inline(always)]
    fn add_faces(&self, volume: &mut Volume, Sides { planes, left, .. }: &mut Sides) {
        left.resize(left.len() + volume.faces.len().div_ceil(64), 0);
        let mut lanes = Lanes { first: planes.len(), count: 0 };
        for (face, bit) in volume.faces.clone().zip(volume.first_bit..) {
            let (corners, count) = corners(self.facets, self.images, face);
            let turn = self.view.turn(&corners).unwrap_or_else(|| self.facets.turn(face, self.light));
            if turn != volume.outward {
                continue;
            }
            left[bit / 64] |= 1 << (bit % 64);
            volume.cover = volume.cover.max(depths(&corners[..count])[1]);
            if lanes.count < MOST_PLANES {
                self.add_plane(planes, lanes.count % WIDTH, face);
            }
            lanes.count += 1;
        }
        if lanes.count <= MOST_PLANES {
            volume.planes = Some(lanes);
        } else {
            planes.truncate(lanes.first);
        }
    }

    #[inline(always)]
    fn add_plane(&self, planes: &mut Vec<Planes>, lane: usize, face: usize) {
        if lane == 0 {
            planes.push(Planes::EMPTY);
        }
        let Some(last) = planes.last_mut() else { return };
        let numbers = self.facets.facet(face).corners();
        let [a, b, c] = [0, 1, 2].map(|k| self.facets.positions()[numbers[k] as usize]);
        let (ab, ac) = if self.solid.is_inward { (b - a, c - a) } else { (c - a, b - a) };
        let normal = ab.cross(ac) / (ab.abs().max_element() * ac.abs().max_element());
        last.offset[lane] = normal.dot(a);
        for (k, coordinate) in normal.to_array().into_iter().enumerate() {
            last.normal[k][lane] = coordinate;
        }
    }
}

/// Adds the edges of a polygon, counter-clockwise.
fn add_edges(outline: &[[i32; 2]], edges: &mut Vec<Edges>) -> Lanes {
    let first = edges.len();
    for (number, &from) in outline.iter().enumerate() {
        if number.is_multiple_of(WIDTH) {
            edges.push(Edges::EMPTY);
        }
        let to = outline[(number + 1) % outline.len()];
        let (pack, lane) = (&mut edges[first + number / WIDTH], number % WIDTH);
        for k in 0..2 {
            pack.from[k][lane] = from[k];
            pack.along[k][lane] = to[k] - from[k];
        }
    }
    Lanes { first, count: outline.len() }
}
