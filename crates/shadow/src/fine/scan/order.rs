//! Faces in the order of the light's image: large ones first, then along a Morton curve.
//!
//! Neighbours in the order are neighbours in the image and of similar size, so that runs of them make good boxes (packed
//! trees: Kamel and Faloutsos 1993; the curve: Morton 1966). Chunks of faces sort themselves by the leading bits of their keys in
//! parallel; what has the same leading bits is then collected from the chunks, in their order, and sorted by the next
//! sixteen bits that differ. Stable: equal keys stay in the order of the scene. Cost: three looks at every face.

use std::{collections::BTreeMap, ops::Range};

use rayon::prelude::*;
use umbriel_geometry::Sign;

use super::{
    faces::{Face, Faces, Piece, Rect, Sight, Source, corners, sight},
    images::Images,
    repeats::repeats,
    tree::{WIDTH, digits, key},
    view::{Image, View},
};

/// Faces of a chunk at least and at most: between, so many that there are [`CHUNKS`].
const CHUNK: [usize; 2] = [1 << 12, 1 << 16];

/// Chunks, where that makes them neither too small nor too large: enough for many threads, whatever their number.
const CHUNKS: usize = 64;

/// Bits of a key: three of size, one of the side turned to the light, forty of place.
const KEY_BITS: u32 = 44;

/// Leading bits by which chunks sort.
const CELL_BITS: u32 = 12;

/// Faces that are sorted together, about.
const BUCKET: usize = 1 << 13;

/// Faces of a group at most.
const GROUP: usize = 128;

/// Faces that [`Classes`] are made by, about.
const LOOKS: usize = 1 << 12;

/// A face and its place in the order.
#[derive(Clone, Copy, Debug)]
struct Item {
    key: u64,
    piece: Piece,
}

impl Item {
    const NONE: Self = Self { key: 0, piece: Piece::NONE };
}

/// Faces of consecutive sources, sorted by cells.
struct Chunk {
    items: Vec<Item>,
    /// Where each cell begins, and the end of the last.
    starts: Vec<u32>,
    clipped: Vec<(Face, Vec<Image>)>,
}

/// Faces in order, in groups.
#[derive(Clone, Debug, Default)]
pub(super) struct Order {
    /// Groups are filled up with [`Piece::NONE`] to whole packs.
    pub(super) pieces: Vec<Piece>,
    /// Where each group ends: faces that lie together in a rectangle of the image.
    pub(super) ends: Vec<usize>,
    /// The places of pieces that are too many for a group and have the same key.
    pub(super) piles: Vec<Range<usize>>,
}

impl Order {
    /// The places of a group's pieces.
    pub(super) fn group(&self, group: usize) -> Range<usize> {
        if group == 0 { 0..self.ends[0] } else { self.ends[group - 1]..self.ends[group] }
    }

    /// Adds faces sorted by the bits of their keys from `shift` on: in groups that differ in leading bits.
    fn add(&mut self, items: &[Item], shift: u32) {
        let [Some(first), Some(last)] = [items.first(), items.last()] else { return };
        let differing = (first.key ^ last.key) >> shift;
        if items.len() > GROUP && differing != 0 {
            let bit = shift + differing.ilog2();
            let (low, high) = items.split_at(items.partition_point(|item| item.key >> bit & 1 == 0));
            self.add(low, shift);
            return self.add(high, shift);
        }
        let first = self.pieces.len();
        for items in items.chunks(GROUP) {
            self.pieces.extend(items.iter().map(|item| item.piece));
            self.pieces.resize(self.pieces.len().next_multiple_of(WIDTH), Piece::NONE);
            self.ends.push(self.pieces.len());
        }
        if items.len() > GROUP {
            self.piles.push(first..self.pieces.len());
        }
    }

    fn append(&mut self, other: &Self) {
        let first = self.pieces.len();
        self.pieces.extend_from_slice(&other.pieces);
        self.ends.extend(other.ends.iter().map(|end| first + end));
        self.piles.extend(other.piles.iter().map(|pile| first + pile.start..first + pile.end));
    }
}

/// Those of some faces of each source that the view sees, in order; and the view of all faces.
pub(super) fn sorted<'a>(
    sources: &'a [Source<'a>],
    ranges: &[Vec<Range<usize>>],
    images: Images,
    view: &View,
) -> (Faces<'a>, Order) {
    let classes = Classes::of(sources, ranges, &images, view);
    let chunks: Vec<Chunk> =
        chunks(ranges).into_par_iter().map(|pieces| Chunk::new(&pieces, sources, (&images, view), classes)).collect();
    let buckets = buckets_of(&chunks);
    let buckets: Vec<Order> = buckets
        .into_par_iter()
        .map_init(Default::default, |storage, cells| sort_bucket(&chunks, cells, storage))
        .collect();
    let mut order = Order::default();
    order.pieces.reserve_exact(buckets.iter().map(|bucket| bucket.pieces.len()).sum());
    buckets.iter().for_each(|bucket| order.append(bucket));
    let clipped: BTreeMap<_, _> = chunks.into_iter().flat_map(|chunk| chunk.clipped).collect();
    let repeats = repeats(sources, &order);
    (Faces { sources, images, clipped, repeats }, order)
}

/// Runs of faces of sources: small ones together, large ones in several.
fn chunks(ranges: &[Vec<Range<usize>>]) -> Vec<Vec<(u32, Range<usize>)>> {
    let total: usize = ranges.iter().flatten().map(|range| range.len()).sum();
    let most = (total / CHUNKS).clamp(CHUNK[0], CHUNK[1]);
    let mut chunks = vec![Vec::new()];
    let mut used = 0;
    for (source, ranges) in ranges.iter().enumerate() {
        for range in ranges {
            let mut first = range.start;
            while first < range.end {
                if used == most {
                    chunks.push(Vec::new());
                    used = 0;
                }
                let end = range.end.min(first + most - used);
                chunks.last_mut().expect("never empty").push((source as u32, first..end));
                used += end - first;
                first = end;
            }
        }
    }
    chunks
}

impl Chunk {
    fn new(
        pieces: &[(u32, Range<usize>)],
        sources: &[Source],
        (images, view): (&Images, &View),
        classes: Classes,
    ) -> Self {
        let mut items = Vec::with_capacity(pieces.iter().map(|(_, faces)| faces.len()).sum());
        let mut clipped = Vec::new();
        for (index, faces) in pieces {
            let source = &sources[*index as usize];
            let (facets, images) = (source.facets, images.of(*index));
            for number in faces.clone().filter(|&number| !source.is_entered(number)) {
                let face = Face { source: *index, number: number as u32 };
                let (corners, count) = corners(facets, images, number);
                let (rect, pieces, is_away) = match sight(facets, number, &corners[..count], view) {
                    Sight::Nothing => continue,
                    Sight::Whole => {
                        let rect = Rect::of(&corners[..count]);
                        if !view.concerns(&rect) || source.is_spare(number, &corners, view) {
                            continue;
                        }
                        (rect, count - 2, classes.by_side && view.turn(&corners) == Some(Sign::Negative))
                    }
                    Sight::Clipped(polygon) => {
                        let seen = (Rect::of(&polygon), polygon.len() - 2, false);
                        clipped.push((face, polygon));
                        seen
                    }
                    Sight::Unbounded => {
                        clipped.push((face, Vec::new()));
                        (Rect::EVERYWHERE, 1, false)
                    }
                };
                let key = key(&rect, is_away, classes.offset);
                items.extend((0..pieces).map(|piece| Item { key, piece: Piece::new(face, piece as u32) }));
            }
        }
        let (items, starts) = by_cell(&items);
        Self { items, starts, clipped }
    }
}

/// A counting sort by the leading bits.
fn by_cell(items: &[Item]) -> (Vec<Item>, Vec<u32>) {
    let cell = |item: &Item| (item.key >> (KEY_BITS - CELL_BITS)) as usize;
    let mut starts = vec![0; (1 << CELL_BITS) + 1];
    items.iter().for_each(|item| starts[cell(item) + 1] += 1);
    for cell in 0..1 << CELL_BITS {
        starts[cell + 1] += starts[cell];
    }
    let mut next = starts.clone();
    let mut sorted = vec![Item::NONE; items.len()];
    for item in items {
        let place = &mut next[cell(item)];
        sorted[*place as usize] = *item;
        *place += 1;
    }
    (sorted, starts)
}

/// Ranges of cells that are sorted together.
fn buckets_of(chunks: &[Chunk]) -> Vec<Range<usize>> {
    let mut buckets = Vec::new();
    let (mut first, mut len) = (0, 0);
    for cell in 0..1 << CELL_BITS {
        len += chunks.iter().map(|chunk| (chunk.starts[cell + 1] - chunk.starts[cell]) as usize).sum::<usize>();
        if len >= BUCKET {
            buckets.push(first..cell + 1);
            (first, len) = (cell + 1, 0);
        }
    }
    buckets.push(first..1 << CELL_BITS);
    buckets
}

fn sort_bucket(chunks: &[Chunk], cells: Range<usize>, [items, other]: &mut [Vec<Item>; 2]) -> Order {
    items.clear();
    for chunk in chunks {
        items.extend_from_slice(&chunk.items[chunk.starts[cells.start] as usize..chunk.starts[cells.end] as usize]);
    }
    let first = items.first().map_or(0, |item| item.key);
    let differing = items.iter().fold(0, |bits, item| bits | item.key ^ first);
    let shift = (64 - differing.leading_zeros()).saturating_sub(16);
    other.resize(items.len(), Item::NONE);
    sort_by_byte(items, other, shift);
    sort_by_byte(other, items, shift + 8);
    let mut order = Order::default();
    order.add(items, shift);
    order
}

/// One pass of a radix sort.
fn sort_by_byte(from: &[Item], to: &mut [Item], shift: u32) {
    let digit = |item: &Item| (item.key >> shift & 0xff) as usize;
    let mut next = [0; 256];
    from.iter().for_each(|item| next[digit(item)] += 1);
    let mut start = 0;
    for place in &mut next {
        start += std::mem::replace(place, start);
    }
    for item in from {
        let place = &mut next[digit(item)];
        to[*place] = *item;
        *place += 1;
    }
}

/// What of a face's size and turn puts it far from its neighbours in the image.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Classes {
    /// Classes of size have four binary digits each, counted from this many before the first.
    offset: u32,
    /// Whether faces that are turned away come after the others of their size: on dense meshes the two lie on different sheets, one behind the other.
    by_side: bool,
}

impl Classes {
    /// By a look at some thousand faces. As many as possible share their class with as many others, as a mesh of triangles that are about as
    /// large as each other should not be parted in two; and sides count where a face mostly turns as the next one does.
    fn of(sources: &[Source], ranges: &[Vec<Range<usize>>], images: &Images, view: &View) -> Self {
        let total: usize = ranges.iter().flatten().map(|range| range.len()).sum();
        let step = (total / LOOKS).max(1);
        let mut counts = [0_u64; 32];
        let (mut pairs, mut alike) = (0, 0);
        for (index, ranges) in (0..).zip(ranges) {
            let (facets, images) = (sources[index as usize].facets, images.of(index));
            for range in ranges {
                for number in range.clone().step_by(step) {
                    let (own, count) = corners(facets, images, number);
                    if own[..count].iter().all(Image::is_valid) {
                        counts[digits(&Rect::of(&own[..count])) as usize] += 1;
                    }
                    if range.contains(&(number + 1)) {
                        let (next, _) = corners(facets, images, number + 1);
                        pairs += 1;
                        alike += u32::from(view.turn(&own) == view.turn(&next));
                    }
                }
            }
        }
        let concentration = |offset: u32| {
            let mut classes = [0_u64; 9];
            (0..).zip(&counts).for_each(|(digits, count)| classes[((digits + offset) / 4) as usize] += count);
            classes.iter().map(|count| count * count).sum::<u64>()
        };
        let offset = (0..4).max_by_key(|&offset| concentration(offset)).unwrap_or(0);
        Self { offset, by_side: 4 * alike > 3 * pairs }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bucket_is_sorted_and_stable() {
        let item = |key: u64, number: u32| Item { key, piece: Piece::new(Face { source: 0, number }, 0) };
        let items: Vec<Item> = (0..5000).map(|k| item(u64::from(k * 7919 % 1013) << 9, k)).collect();
        let (items, starts) = by_cell(&items);
        let chunk = Chunk { items, starts, clipped: Vec::new() };
        let order = sort_bucket(&[chunk], 0..1 << CELL_BITS, &mut Default::default());
        let pieces = order.pieces.iter().filter(|&&piece| piece != Piece::NONE);
        let faces: Vec<Face> = pieces.map(|piece| piece.face()).collect();
        let keys = |face: &Face| (face.number * 7919 % 1013, face.number);
        assert!(faces.len() == 5000 && faces.windows(2).all(|pair| keys(&pair[0]) < keys(&pair[1])));
        let groups = (0..order.ends.len()).map(|group| order.group(group));
        assert!(groups.clone().all(|group| group.len() <= GROUP && group.len() % WIDTH == 0));
        assert_eq!(groups.map(|group| group.len()).sum::<usize>(), order.pieces.len());
    }
}
