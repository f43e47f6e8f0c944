//! All faces as the light sees them, dealt out to a coarse grid of tiles over the window.
//!
//! Each chunk of faces is projected and sorted into tiles by itself (a counting sort), so chunks run in parallel and
//! the lists of a tile, read chunk by chunk, are in the order of the scene. Cost: about two looks at every face.

use std::{collections::BTreeMap, ops::Range};

use rayon::prelude::*;
use umbriel_geometry::{Facet, Facets};

use super::{
    clip::clip,
    view::{Image, View},
};

/// Faces a chunk has, about.
const CHUNK: usize = 1 << 16;

/// A box of images, quanta.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rect {
    pub(super) min: [i32; 2],
    pub(super) max: [i32; 2],
}

impl Rect {
    pub(super) fn of(images: &[Image]) -> Self {
        let mut rect = Self { min: [i32::MAX; 2], max: [i32::MIN; 2] };
        for image in images {
            rect.min = [rect.min[0].min(image.x), rect.min[1].min(image.y)];
            rect.max = [rect.max[0].max(image.x), rect.max[1].max(image.y)];
        }
        rect
    }
}

/// How far from the middle of an area, in halves of it, the corners of a small face are at most.
pub(super) const NEAR: f64 = 12.0;

/// More than any window.
const EVERYWHERE: Rect = Rect { min: [-(1 << 30); 2], max: [1 << 30; 2] };

/// The least and the greatest depth.
fn depths(images: &[Image]) -> [f32; 2] {
    let depths = images.iter().map(|image| image.depth);
    depths.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], depth| [low.min(depth), high.max(depth)])
}

/// A regular grid over the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) low: [f64; 2],
    /// Edges of a tile, quanta.
    pub(super) step: [f64; 2],
    pub(super) count: [u32; 2],
    /// How far beyond its own area a tile looks.
    pub(super) margin: f64,
}

impl Grid {
    /// About `tiles` tiles over the window of `view`, nearly square.
    pub(super) fn new(view: &View, tiles: f64) -> Self {
        let size = view.half.map(|half| 2.0 * half);
        let edge = (size[0] * size[1] / tiles.max(1.0)).sqrt();
        let count = size.map(|size| (size / edge).ceil().clamp(1.0, 512.0) as u32);
        let step = [0, 1].map(|k| size[k] / f64::from(count[k]));
        Self { low: view.half.map(|half| -half), step, count, margin: margin(step, view) }
    }

    /// How many tiles.
    pub(super) fn len(&self) -> usize {
        self.count[0] as usize * self.count[1] as usize
    }

    /// The tiles along each axis that look at a box; empty beyond the window.
    pub(super) fn range(&self, rect: &Rect) -> [Range<u32>; 2] {
        [0, 1].map(|k| {
            let at = |x: i32, outward: f64| (f64::from(x) + outward - self.low[k]) / self.step[k];
            let first = at(rect.min[k], -self.margin).floor().clamp(0.0, f64::from(self.count[k]));
            let end = (at(rect.max[k], self.margin).floor() + 1.0).clamp(0.0, f64::from(self.count[k]));
            first as u32..end as u32
        })
    }

    /// The area of a tile.
    pub(super) fn area(&self, tile: usize) -> Area {
        let place = [tile as u32 % self.count[0], tile as u32 / self.count[0]];
        let low = [0, 1].map(|k| self.low[k] + f64::from(place[k]) * self.step[k]);
        Area { center: [0, 1].map(|k| low[k] + 0.5 * self.step[k]), half: self.step.map(|step| 0.5 * step) }
    }
}

/// How far a part of the window looks beyond its border: images may be off, and samples near the border may be looked at
/// from both sides.
pub(super) fn margin(step: [f64; 2], view: &View) -> f64 {
    (step[0].max(step[1]) / 512.0).max(8.0 * view.error + 2.0)
}

/// A part of the window, quanta.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub(super) center: [f64; 2],
    pub(super) half: [f64; 2],
}

/// One object's part in the soup.
pub(super) struct Source<'a> {
    pub(super) object: u32,
    pub(super) facets: &'a Facets,
    /// Whether a face has samples that may be lit; `None` if the object is no receiver.
    pub(super) receives: Option<&'a (dyn Fn(usize) -> bool + Sync)>,
}

/// A triangle that may block, as the light sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Occluder {
    pub(super) object: u32,
    pub(super) face: u32,
    pub(super) corners: [Image; 3],
}

/// A face with samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Receiver {
    /// Index into the sources.
    pub(super) source: u32,
    pub(super) face: u32,
    /// Its first, second and last corner; without images where the face is not seen as a whole.
    pub(super) corners: [Image; 3],
    pub(super) is_triangle: bool,
    /// The box of its images.
    pub(super) rect: Rect,
    /// Its least and greatest depth.
    pub(super) depths: [f32; 2],
}

impl Receiver {
    /// Whether its corners all have images near the area, so that samples can be found from them.
    pub(super) fn is_small(&self, area: &Area, is_sun: bool) -> bool {
        let reach = NEAR * area.half[0].max(area.half[1]);
        let is_near = |k: usize| {
            f64::from(self.rect.max[k]) - area.center[k] <= reach
                && area.center[k] - f64::from(self.rect.min[k]) <= reach
        };
        self.corners.iter().all(Image::is_valid) && (is_sun || self.is_triangle) && is_near(0) && is_near(1)
    }

    /// The part of its box of images that lies in the area widened by `wide`, relative to the area's middle.
    pub(super) fn overlap(&self, area: &Area, wide: f64) -> ([f32; 2], [f32; 2]) {
        let reach = area.half.map(|half| half + wide);
        let low = [0, 1].map(|k| (f64::from(self.rect.min[k]) - area.center[k] - wide).max(-reach[k]) as f32);
        let high = [0, 1].map(|k| (f64::from(self.rect.max[k]) - area.center[k] + wide).min(reach[k]) as f32);
        (low, high)
    }
}

/// What a view sees of a face.
enum Sight {
    Nothing,
    Whole,
    /// A convex part that holds all of the window.
    Clipped(Vec<Image>),
    /// Nothing bounds its image.
    Unbounded,
}

/// Faces of consecutive sources, dealt out to tiles.
struct Chunk {
    pieces: Vec<Piece>,
    occluders: Lists,
    receivers: Lists,
    /// The faces that are not seen as a whole, by their numbers in the chunk.
    clipped: BTreeMap<u32, Vec<Image>>,
    unbounded: Vec<(u32, u32)>,
}

/// Faces of one source.
struct Piece {
    source: usize,
    faces: Range<usize>,
    /// The number of its first face in the chunk.
    first: u32,
}

/// Numbers of faces in the order of tiles.
struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// A counting sort of faces 0..count by the tiles that `range` gives.
    fn sort(count: u32, grid: &Grid, range: impl Fn(u32) -> Option<[Range<u32>; 2]>) -> Self {
        let for_each_tile = |item: u32, visit: &mut dyn FnMut(usize)| {
            let Some([columns, rows]) = range(item) else { return };
            for row in rows {
                columns.clone().for_each(|column| visit((row * grid.count[0] + column) as usize));
            }
        };
        let mut starts = vec![0; grid.len() + 1];
        (0..count).for_each(|item| for_each_tile(item, &mut |tile| starts[tile + 1] += 1));
        for tile in 0..grid.len() {
            starts[tile + 1] += starts[tile];
        }
        let mut items = vec![0; starts[grid.len()] as usize];
        let mut next = starts.clone();
        for item in 0..count {
            for_each_tile(item, &mut |tile| {
                items[next[tile] as usize] = item;
                next[tile] += 1;
            });
        }
        Self { starts, items }
    }

    fn tile(&self, tile: usize) -> &[u32] {
        &self.items[self.starts[tile] as usize..self.starts[tile + 1] as usize]
    }
}

/// Everything that one view sees.
pub(super) struct Soup<'a> {
    sources: &'a [Source<'a>],
    images: Vec<Vec<Image>>,
    chunks: Vec<Chunk>,
    pub(super) grid: Grid,
    /// Faces (object, face) whose shadow nothing bounds.
    pub(super) unbounded: Vec<(u32, u32)>,
}

impl<'a> Soup<'a> {
    /// Projects and sorts the faces of all sources.
    pub(super) fn new(sources: &'a [Source<'a>], view: &View, grid: Grid) -> Self {
        let images: Vec<Vec<Image>> = sources.par_iter().map(|source| images(source.facets, view)).collect();
        let chunks: Vec<Chunk> =
            pieces(sources).into_par_iter().map(|pieces| Chunk::new(pieces, sources, &images, view, &grid)).collect();
        let unbounded = chunks.iter().flat_map(|chunk| chunk.unbounded.iter().copied()).collect();
        Self { sources, images, chunks, grid, unbounded }
    }

    /// Calls `visit` with the triangles that may block a sample of the tile, in the order of the scene.
    pub(super) fn for_each_occluder(&self, tile: usize, mut visit: impl FnMut(Occluder)) {
        for chunk in &self.chunks {
            for &item in chunk.occluders.tile(tile) {
                let (source, face) = chunk.face(item);
                let object = self.sources[source].object;
                let mut fan = |images: &[Image]| {
                    for k in 1..images.len() - 1 {
                        let corners = [images[0], images[k], images[k + 1]];
                        visit(Occluder { object, face: face as u32, corners });
                    }
                };
                if let Some(images) = chunk.clipped(item) {
                    fan(images);
                    continue;
                }
                let (corners, count) = self.corners(source, face);
                fan(&corners[..count]);
            }
        }
    }

    /// Calls `visit` with the faces that may have samples in the tile, in the order of the scene.
    pub(super) fn for_each_receiver(&self, tile: usize, mut visit: impl FnMut(Receiver)) {
        for chunk in &self.chunks {
            for &item in chunk.receivers.tile(tile) {
                let (source, face) = chunk.face(item);
                let (corners, count) = self.corners(source, face);
                let (rect, depths) = match chunk.clipped(item) {
                    // Nothing bounds it.
                    Some(images) if images.is_empty() => (EVERYWHERE, [f32::NEG_INFINITY, f32::INFINITY]),
                    Some(images) => (Rect::of(images), depths(images)),
                    None => (Rect::of(&corners[..count]), depths(&corners[..count])),
                };
                let (source, face, is_triangle) = (source as u32, face as u32, count == 3);
                let corners = [corners[0], corners[1], corners[3]];
                visit(Receiver { source, face, corners, is_triangle, rect, depths });
            }
        }
    }

    #[inline]
    fn corners(&self, source: usize, face: usize) -> ([Image; 4], usize) {
        corners_of(self.sources[source].facets, &self.images[source], face)
    }
}

#[inline]
fn corners_of(facets: &Facets, images: &[Image], face: usize) -> ([Image; 4], usize) {
    let at = |number: u32| images[number as usize];
    match facets.facet(face) {
        Facet::Triangle([a, b, c]) => ([at(a), at(b), at(c), at(c)], 3),
        Facet::Parallelogram(numbers) => (numbers.map(at), 4),
    }
}

fn images(facets: &Facets, view: &View) -> Vec<Image> {
    let image = |point: usize| {
        let point = facets.point(point as u32);
        view.image(point.position, point.slack.max_element())
    };
    (0..facets.positions().len()).into_par_iter().with_min_len(1 << 12).map(image).collect()
}

/// The work in chunks: small sources together, large ones in several.
fn pieces(sources: &[Source]) -> Vec<Vec<Piece>> {
    let mut chunks = vec![Vec::new()];
    let mut used = 0;
    for (source, Source { facets, .. }) in sources.iter().enumerate() {
        let mut first = 0;
        while first < facets.len() {
            if used == CHUNK {
                chunks.push(Vec::new());
                used = 0;
            }
            let end = facets.len().min(first + CHUNK - used);
            let piece = Piece { source, faces: first..end, first: used as u32 };
            chunks.last_mut().expect("never empty").push(piece);
            used += end - first;
            first = end;
        }
    }
    chunks
}

impl Chunk {
    fn new(pieces: Vec<Piece>, sources: &[Source], images: &[Vec<Image>], view: &View, grid: &Grid) -> Self {
        let count = pieces.last().map_or(0, |piece| piece.first + piece.faces.len() as u32);
        let mut chunk = Self {
            pieces,
            occluders: Lists { starts: Vec::new(), items: Vec::new() },
            receivers: Lists { starts: Vec::new(), items: Vec::new() },
            clipped: BTreeMap::new(),
            unbounded: Vec::new(),
        };
        let mut ranges = Vec::with_capacity(count as usize);
        let mut receives = vec![false; count as usize];
        let everywhere = [0..grid.count[0], 0..grid.count[1]];
        for item in 0..count {
            let (source, face) = chunk.face(item);
            let Source { object, facets, receives: asked } = &sources[source];
            let (corners, corner_count) = corners_of(facets, &images[source], face);
            let range = match sight(facets, face, &corners[..corner_count], view) {
                Sight::Nothing => None,
                Sight::Whole => Some(grid.range(&Rect::of(&corners[..corner_count]))),
                Sight::Clipped(polygon) => {
                    let range = grid.range(&Rect::of(&polygon));
                    chunk.clipped.insert(item, polygon);
                    Some(range)
                }
                Sight::Unbounded => {
                    chunk.unbounded.push((*object, face as u32));
                    chunk.clipped.insert(item, Vec::new());
                    Some(everywhere.clone())
                }
            };
            let range = range.filter(|range| !range.iter().any(Range::is_empty));
            receives[item as usize] = range.is_some() && asked.is_some_and(|asked| asked(face));
            ranges.push(range);
        }
        let is_bounded = |item: u32| chunk.clipped(item).is_none_or(|polygon| !polygon.is_empty());
        let occluders = Lists::sort(count, grid, |item| ranges[item as usize].clone().filter(|_| is_bounded(item)));
        let receivers =
            Lists::sort(count, grid, |item| ranges[item as usize].clone().filter(|_| receives[item as usize]));
        Self { occluders, receivers, ..chunk }
    }

    /// What is left of a face that is not seen as a whole.
    #[inline]
    fn clipped(&self, item: u32) -> Option<&Vec<Image>> {
        if self.clipped.is_empty() { None } else { self.clipped.get(&item) }
    }

    /// The source and the face of number `item`.
    fn face(&self, item: u32) -> (usize, usize) {
        let piece =
            if self.pieces.len() == 1 { 0 } else { self.pieces.partition_point(|piece| piece.first <= item) - 1 };
        let piece = &self.pieces[piece];
        (piece.source, piece.faces.start + (item - piece.first) as usize)
    }
}

fn sight(facets: &Facets, face: usize, images: &[Image], view: &View) -> Sight {
    if images.iter().all(Image::is_valid) {
        return Sight::Whole;
    }
    if images.iter().fold(-1, |beyond, image| beyond & if image.is_valid() { 0 } else { image.x }) != 0 {
        return Sight::Nothing;
    }
    let corners = facets.facet(face).corners();
    let points: Vec<_> = corners.iter().map(|&corner| view.homogeneous(facets.positions()[corner as usize])).collect();
    match clip(points, view) {
        Some(images) if images.is_empty() => Sight::Nothing,
        Some(images) => Sight::Clipped(images),
        None => Sight::Unbounded,
    }
}
