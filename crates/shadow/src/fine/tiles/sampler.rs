//! The samples of flat receivers under one light.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{Aabb, Facets, LightSource};

use super::{
    layout::{FaceLattice, Layout},
    leaf::Leaf,
    region::Tile,
    soup::{Grid, Occluder, Receiver, Soup, Source},
    view::View,
};
use crate::{
    bodies::Bodies,
    exact::{Own, face_blocks},
    fine::flat::flat_probe,
    progress::{Cancelled, Progress},
    receivers::flat_corners,
};

/// Faces for each tile of the coarse grid, about.
const FACES_PER_TILE: f64 = 512.0;

/// Samples for each tile of the coarse grid at most, about.
const SAMPLES_PER_TILE: f64 = 131_072.0;

/// The answers of one object, a bit each.
pub(crate) struct LitBits(Vec<AtomicU64>);

impl LitBits {
    pub(crate) fn new(bits: u64) -> Self {
        Self((0..bits.div_ceil(64)).map(|_| AtomicU64::new(0)).collect())
    }

    /// `count` bits from bit `first` on, 64 at most.
    pub(super) fn bits(&self, first: u64, count: u32) -> u64 {
        let (word, shift) = ((first / 64) as usize, (first % 64) as u32);
        let at = |word: usize| self.0[word].load(Ordering::Relaxed);
        let low = at(word) >> shift;
        let bits = if shift + count > 64 { low | at(word + 1) << (64 - shift) } else { low };
        bits & (u64::MAX >> (64 - count))
    }

    /// How many are set.
    pub(crate) fn count(&self) -> u64 {
        self.0.iter().map(|word| u64::from(word.load(Ordering::Relaxed).count_ones())).sum()
    }

    /// Sets the bits of `bits` from bit `first` on.
    #[inline(always)]
    fn set(&self, first: u64, bits: u64) {
        if bits == 0 {
            return;
        }
        let (word, shift) = ((first / 64) as usize, first % 64);
        self.0[word].fetch_or(bits << shift, Ordering::Relaxed);
        if shift != 0 && bits >> (64 - shift) != 0 {
            self.0[word + 1].fetch_or(bits >> (64 - shift), Ordering::Relaxed);
        }
    }

    /// Sets `count` bits.
    fn fill(&self, first: u64, count: u64) {
        let (mut bit, end) = (first, first + count);
        while bit < end {
            let run = (64 - bit % 64).min(end - bit);
            self.set(bit, u64::MAX >> (64 - run));
            bit += run;
        }
    }
}

/// An asked receiver with its samples.
pub(crate) struct Sampled<'a> {
    pub(crate) object: u32,
    pub(crate) facets: &'a Facets,
    /// `None` for an object that only blocks.
    pub(crate) layout: Option<&'a Layout>,
    pub(crate) is_lit_side: Option<&'a (dyn Fn(usize) -> bool + Sync)>,
    pub(crate) bounds: Aabb,
}

/// One view of a light and everything in it.
pub(super) struct Sampler<'a> {
    pub(super) view: View,
    bodies: &'a Bodies<'a>,
    light: &'a LightSource,
    objects: &'a [Sampled<'a>],
    lit: &'a [LitBits],
    /// Faces whose shadow nothing bounds: asked about every sample.
    pub(super) unbounded: Vec<(u32, u32)>,
}

/// Decides all samples; one set of answers an object, in their order. Exact.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
pub(crate) fn sample(
    bodies: &Bodies,
    light: &LightSource,
    objects: &[Sampled],
    progress: &dyn Progress,
) -> Result<Vec<LitBits>, Cancelled> {
    let lit: Vec<LitBits> = objects.iter().map(|object| LitBits::new(object.layout.map_or(0, Layout::bits))).collect();
    let bounds = objects.iter().fold(Aabb::EMPTY, |bounds, object| bounds.union(object.bounds));
    if bounds.is_empty() {
        return Ok(lit);
    }
    let slack = objects.iter().map(|object| object.facets.slack()).fold(0.0, f64::max);
    let sources: Vec<Source> = objects
        .iter()
        .map(|&Sampled { object, facets, is_lit_side, .. }| Source { object, facets, receives: is_lit_side })
        .collect();
    let faces: usize = objects.iter().map(|object| object.facets.len()).sum();
    let samples: u64 = objects.iter().map(|object| object.layout.map_or(0, |layout| layout.samples)).sum();
    let tiles = (faces as f64 / FACES_PER_TILE).max(samples as f64 / SAMPLES_PER_TILE);
    for view in View::all(light, &bounds, slack) {
        let soup = Soup::new(&sources, &view, Grid::new(&view, tiles));
        let sampler = Sampler { view, bodies, light, objects, lit: &lit, unbounded: soup.unbounded.clone() };
        let (done, total) = (AtomicU64::new(0), soup.grid.len() as u64);
        (0..soup.grid.len()).into_par_iter().for_each_init(Leaf::default, |leaf, tile| {
            if !progress.is_cancelled() {
                sampler.run_tile(&soup, tile, leaf);
                progress.advance("samples", done.fetch_add(1, Ordering::Relaxed) + 1, total);
            }
        });
        if progress.is_cancelled() {
            return Err(Cancelled);
        }
    }
    Ok(lit)
}

/// Integers in the order of floats.
fn ordered(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    bits ^ (((bits >> 31) as u32) >> 1) as i32
}

impl<'a> Sampler<'a> {
    fn run_tile(&self, soup: &Soup, tile: usize, leaf: &mut Leaf) {
        let (mut occluders, mut receivers) = (Vec::new(), Vec::new());
        soup.for_each_receiver(tile, |receiver| receivers.push(receiver));
        if !receivers.is_empty() {
            soup.for_each_occluder(tile, |occluder| occluders.push(occluder));
        }
        // Front to back; lists of parts keep the order.
        occluders.sort_by_cached_key(|occluder: &Occluder| {
            let [a, b, c] = occluder.corners.map(|image| image.depth);
            ordered(a.min(b).min(c))
        });
        Tile { sampler: self, occluders, receivers, leaf }.run(soup.grid.area(tile));
    }

    pub(super) fn lattice(&self, receiver: &Receiver) -> &FaceLattice {
        self.layout(receiver).face(receiver.face as usize)
    }

    pub(super) fn first_bit(&self, receiver: &Receiver) -> u64 {
        self.layout(receiver).first_bit(receiver.face as usize)
    }

    fn layout(&self, receiver: &Receiver) -> &Layout {
        self.objects[receiver.source as usize].layout.expect("receivers have a layout")
    }

    /// The corner from which the lattice is counted, the next one and the last one.
    pub(super) fn corners(&self, receiver: &Receiver) -> [DVec3; 3] {
        let facets = self.objects[receiver.source as usize].facets;
        let corners = flat_corners(facets, receiver.face as usize, self.lattice(receiver).corner);
        [corners[0], corners[1], corners[3]].map(|corner| corner.position)
    }

    pub(super) fn is_own(&self, receiver: &Receiver, occluder: &Occluder) -> bool {
        occluder.face == receiver.face && occluder.object == self.objects[receiver.source as usize].object
    }

    /// How much deeper than `depth` something must be to be deeper for certain.
    #[inline(always)]
    pub(super) fn depth_slack(&self, depth: f32) -> f32 {
        2.0 * self.view.depth_error + 32.0 * f32::EPSILON * depth.abs()
    }

    /// Whether one of these occluders, or one whose shadow nothing bounds, blocks a sample. Exact.
    pub(super) fn settle<'o>(
        &self,
        receiver: &Receiver,
        [row, column]: [u32; 2],
        occluders: impl Iterator<Item = &'o Occluder>,
    ) -> bool {
        let Sampled { object, facets, .. } = &self.objects[receiver.source as usize];
        let lattice = self.lattice(receiver);
        let (u, v) = (lattice.lattice.coordinate(0, row), lattice.lattice.coordinate(1, column));
        let corners = flat_corners(facets, receiver.face as usize, lattice.corner);
        let probe = flat_probe(&corners, u, v);
        let own = Own::Face { object: *object as usize, face: receiver.face as usize };
        let faces = occluders.map(|occluder| (occluder.object, occluder.face)).chain(self.unbounded.iter().copied());
        faces
            .into_iter()
            .any(|(object, face)| face_blocks(self.bodies, (object as usize, face as usize), &probe, own, self.light))
    }

    #[inline(always)]
    pub(super) fn set_lit(&self, receiver: &Receiver, first: u64, bits: u64) {
        self.lit[receiver.source as usize].set(first, bits);
    }

    pub(super) fn fill_lit(&self, receiver: &Receiver, first: u64, count: u64) {
        self.lit[receiver.source as usize].fill(first, count);
    }
}
