//! A binary tree along Morton's curve, for trees that are not used for long.
//!
//! Lauterbach, Garland, Sengupta, Luebke and Manocha, "Fast BVH construction on GPUs", Eurographics 2009: triangles are
//! sorted by the codes of their boxes' middles, and a part is cut where the highest bit changes in which its codes
//! differ. Up to [`PAIR`] triangles in a row make two packs, cut where their boxes are smallest. The codes alone tell the
//! tree's shape, so every pack has its place before any is filled, and threads fill them side by side. O(n); the depth
//! is that of `binary.rs`.

use std::num::NonZeroU32;

use glam::{DVec3, Vec3A};
use umbriel_geometry::Aabb;

use super::{
    super::{
        bounds::Bounds,
        layout::{Pack, WIDTH},
        morton::{code, scatter, sort},
    },
    binary::{BinaryNode, MAX_DEPTH, halvings},
    corners::{Corners, Triangle, fill_up},
    tasks::{CHUNK, for_each, join},
};

/// Bits of a code on an axis.
const BITS: u32 = 10;

/// The codes are sorted in parts, by their high bits: about so many in a part, and at most so many bits.
const PART: usize = 1 << 12;
const PART_BITS: u32 = 9;

/// Not more triangles become two packs.
const PAIR: usize = 2 * WIDTH;

/// Below so many triangles a part is not worth a thread.
const SERIAL: usize = 4096;

/// A code, and which triangle has it.
type Coded = (u32, u32);

/// The binary tree over the triangles, of which there must be some, and its leaves: the packs. A leaf's `first` is its
/// pack. `bounds` are those of the triangles, in the frame.
pub(super) fn build(corners: &Corners, count: usize, bounds: &Aabb) -> (Vec<BinaryNode>, Vec<Pack>) {
    let codes = sorted_codes(corners, count, bounds);
    let mut outline = Outline { nodes: Vec::with_capacity(count / 2), packs: 0 };
    outline.add(&codes, 1);
    let Outline { mut nodes, packs } = outline;
    let mut packs = vec![Pack::ZERO; packs as usize];
    Subtree { nodes: &mut nodes, index: 0, packs: &mut packs, codes: &codes }.fill(corners);
    (nodes, packs)
}

/// The triangles along the curve. What has the same code keeps its order.
fn sorted_codes(corners: &Corners, count: usize, bounds: &Aabb) -> Vec<Coded> {
    let coder = Coder::new(bounds);
    let part_bits = (count / PART).checked_ilog2().map_or(0, |bits| bits + 1).min(PART_BITS);
    let (low_bits, parts) = (3 * BITS - part_bits, 1 << part_bits);
    let part = |code: u32| (code >> low_bits) as usize;
    // Each chunk is sorted by parts; then each part is gathered from all chunks, and sorted.
    let mut chunked = vec![(0, 0); count];
    let firsts = (0u32..).step_by(CHUNK);
    let mut chunks: Vec<_> =
        chunked.chunks_mut(CHUNK).zip(firsts).map(|(codes, first)| (codes, first, vec![0; parts])).collect();
    for_each(&mut chunks, &|(codes, first, ends)| {
        let triangles = *first..*first + codes.len() as u32;
        let coded: Vec<Coded> = triangles.map(|triangle| (coder.code(corners, triangle), triangle)).collect();
        scatter(&coded, codes, ends, part);
    });
    let chunks: Vec<(&[Coded], Vec<u32>)> = chunks.into_iter().map(|(codes, _, ends)| (&*codes, ends)).collect();
    let in_part = |part: usize, (_, ends): &(&[Coded], Vec<u32>)| {
        let first = part.checked_sub(1).map_or(0, |before| ends[before]);
        first as usize..ends[part] as usize
    };
    let mut codes = vec![(0, 0); count];
    let mut rest = &mut codes[..];
    let mut tasks = Vec::with_capacity(parts);
    for part in 0..parts {
        let size = chunks.iter().map(|chunk| in_part(part, chunk).len()).sum();
        let (own, others) = rest.split_at_mut(size);
        tasks.push((part, own));
        rest = others;
    }
    for_each(&mut tasks, &|(part, codes)| {
        let mut end = 0;
        for chunk in &chunks {
            let range = in_part(*part, chunk);
            codes[end..end + range.len()].copy_from_slice(&chunk.0[range.clone()]);
            end += range.len();
        }
        sort(codes, &mut vec![(0, 0); end], low_bits);
    });
    drop(tasks);
    codes
}

/// Gives triangles codes.
struct Coder {
    /// Twice the least corner.
    low: Vec3A,
    /// Of twice a box's middle, to cells.
    factor: Vec3A,
}

impl Coder {
    fn new(bounds: &Aabb) -> Self {
        let cells = f64::from(1u32 << BITS);
        let factor =
            (DVec3::splat(cells / 2.0) / bounds.size()).map(|factor| if factor.is_finite() { factor } else { 0.0 });
        Self { low: (bounds.min * 2.0).as_vec3a(), factor: factor.as_vec3a() }
    }

    #[inline(always)]
    fn code(&self, corners: &Corners, triangle: u32) -> u32 {
        let [min, max] = corners.of(triangle).extremes();
        let cell = (min + max - self.low) * self.factor;
        code([cell.x as u32, cell.y as u32, cell.z as u32], BITS)
    }
}

/// The shape of the tree.
struct Outline {
    nodes: Vec<BinaryNode>,
    packs: u32,
}

impl Outline {
    /// Appends the subtree over triangles in a row on the curve.
    fn add(&mut self, codes: &[Coded], depth: usize) {
        let (index, count) = (self.nodes.len(), codes.len());
        self.push(count);
        if count <= WIDTH {
            self.packs += 1;
            return;
        }
        let right = if count <= PAIR {
            // How many each pack gets is found when they are filled.
            self.push(0);
            self.packs += 1;
            self.push(0);
            self.packs += 1;
            index + 2
        } else {
            let middle = if depth + halvings(count) >= MAX_DEPTH { count / 2 } else { cut(codes) };
            let (left, right) = codes.split_at(middle);
            self.add(left, depth + 1);
            let second = self.nodes.len();
            self.add(right, depth + 1);
            second
        };
        self.nodes[index].right = NonZeroU32::new(right as u32);
    }

    fn push(&mut self, count: usize) {
        self.nodes.push(BinaryNode::leaf(Bounds::EMPTY, self.packs, count as u32));
    }
}

/// Where the highest bit changes in which the codes differ; the middle where none does.
fn cut(codes: &[Coded]) -> usize {
    let differing = codes[0].0 ^ codes[codes.len() - 1].0;
    if differing == 0 {
        return codes.len() / 2;
    }
    let bit = 1 << differing.ilog2();
    codes.partition_point(|(code, _)| code & bit == 0)
}

/// A subtree to be filled: its nodes, the first of them at `index` in the tree, its packs and triangles.
struct Subtree<'a> {
    nodes: &'a mut [BinaryNode],
    index: usize,
    packs: &'a mut [Pack],
    codes: &'a [Coded],
}

impl Subtree<'_> {
    /// Fills packs and boxes; returns the box around all.
    fn fill(self, corners: &Corners) -> Bounds {
        let Self { nodes, index, packs, codes } = self;
        let Some((root, below)) = nodes.split_first_mut() else { return Bounds::EMPTY };
        let bounds = match root.right {
            None => fill_pack(corners, codes, &mut packs[0]),
            Some(_) if codes.len() <= PAIR => fill_pair(corners, codes, below, packs),
            Some(right) => {
                let middle = right.get() as usize - index - 1;
                let (left, right) = below.split_at_mut(middle);
                let (left_packs, right_packs) = packs.split_at_mut((right[0].first - root.first) as usize);
                let (left_codes, right_codes) = codes.split_at(left[0].count as usize);
                let left = Subtree { nodes: left, index: index + 1, packs: left_packs, codes: left_codes };
                let right = Subtree { nodes: right, index: index + 1 + middle, packs: right_packs, codes: right_codes };
                let (left, right) = if codes.len() > SERIAL {
                    join(|| left.fill(corners), || right.fill(corners))
                } else {
                    (left.fill(corners), right.fill(corners))
                };
                left.union(&right)
            }
        };
        nodes[0].bounds = bounds;
        BinaryNode::choose(nodes, 0, index);
        bounds
    }
}

fn fill_pack(corners: &Corners, codes: &[Coded], pack: &mut Pack) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for (lane, &(_, index)) in codes.iter().enumerate() {
        let triangle = corners.of(index);
        bounds = bounds.union(&triangle.bounds());
        triangle.put(index, lane, pack);
    }
    fill_up(codes.len(), pack);
    bounds
}

/// Two packs, cut where the sum of their boxes' areas is least.
fn fill_pair(corners: &Corners, codes: &[Coded], leaves: &mut [BinaryNode], packs: &mut [Pack]) -> Bounds {
    let ([first_leaf, second_leaf], [first_pack, second_pack]) = (leaves, packs) else { return Bounds::EMPTY };
    let count = codes.len();
    let mut triangles = [Triangle([Vec3A::ZERO; 3]); PAIR];
    let mut boxes = [Bounds::EMPTY; PAIR];
    for (&(_, index), (triangle, bounds)) in codes.iter().zip(triangles.iter_mut().zip(&mut boxes)) {
        *triangle = corners.of(index);
        *bounds = triangle.bounds();
    }
    // Entry i: the box of all but the first i.
    let mut rest = [Bounds::EMPTY; PAIR + 1];
    for index in (0..count).rev() {
        rest[index] = rest[index + 1].union(&boxes[index]);
    }
    let (mut least, mut middle, mut first, mut bounds) = (f32::INFINITY, WIDTH, Bounds::EMPTY, Bounds::EMPTY);
    for size in 1..=WIDTH {
        first = first.union(&boxes[size - 1]);
        let cost = first.half_area() + rest[size].half_area();
        if size + WIDTH >= count && cost < least {
            (least, middle, bounds) = (cost, size, first);
        }
    }
    for lane in 0..middle {
        triangles[lane].put(codes[lane].1, lane, first_pack);
    }
    for lane in middle..count {
        triangles[lane].put(codes[lane].1, lane - middle, second_pack);
    }
    fill_up(middle, first_pack);
    fill_up(count - middle, second_pack);
    *first_leaf = BinaryNode::leaf(bounds, first_leaf.first, middle as u32);
    *second_leaf = BinaryNode::leaf(rest[middle], second_leaf.first, (count - middle) as u32);
    rest[0]
}
