//! What is drawn of a face: borders wait in a list, and are drawn and forgotten as soon as there are more of them than cells.
//!
//! Few borders wait until all are there; then each tile is needed for a moment only. Many are drawn in parts: the tiles that they meet are kept, with the
//! crossings in their cells for the estimate, and the list begins again. Both add up whole numbers, segment by segment, so the marks are the same; but rims are joined, and cells that the marks
//! leave open looked at again ([`open_cells`](super::open_cells)), only where all borders are there: how they fall into parts depends on the order of bodies. Memory: some
//! 115 bytes a waiting border, looked at after each body, and of what is drawn 34 KiB a tile and 16 bytes a cell that a border touches (64 in tiles where a byte
//! does not hold the changes in each cell); so besides the borders of one body it goes with the cells of the face, however many borders there are.

use rayon::prelude::*;

use super::{
    Raster,
    bins::Bins,
    estimate::Crossings,
    lowest::Met,
    open_cells::{Found, Touches, look},
    segments::{Chain, Segment, Veil},
    span::{Walk, floor},
    tally::{Outcome, TileGrid, TileMasks},
    tile::{TILE, Tile, TilePlace},
};
use crate::fine::tally::{Tally, Units};

/// On a face of few cells so many borders wait all the same: drawing a part costs a look at each tile.
const LEAST_WAITING: usize = 1 << 12;

/// Cells for which one border waits. It takes about as much memory as 16 cells of tiles that are drawn on, and what waits is still there while the first
/// tiles are drawn: it should be the smaller part of the two.
const CELLS_A_SEGMENT: usize = 32;

/// Once tiles are drawn on, waiting spares no tile: this part of the borders waits then.
const WAITING_BESIDE_TILES: usize = 4;

/// The borders on a face, drawn or waiting.
pub(super) struct Drawing<'a> {
    raster: &'a Raster<'a>,
    /// Cells along the edge of a tile.
    size: i64,
    /// So many borders wait.
    most: usize,
    /// What waits.
    pub(super) chain: Chain,
    /// What is drawn, by rows of tiles; no rows if nothing is.
    kept: Vec<Row>,
}

/// A row of tiles, where anything is drawn.
type Row = Vec<Option<Box<Kept>>>;

/// A tile with what is drawn on it.
struct Kept {
    tile: Box<Tile>,
    crossings: Crossings,
}

impl<'a> Drawing<'a> {
    /// Nothing yet.
    pub(super) fn new(raster: &'a Raster<'a>) -> Self {
        let cells = raster.cells() as usize;
        Self::with_most(raster, LEAST_WAITING.max(cells * cells / CELLS_A_SEGMENT))
    }

    fn with_most(raster: &'a Raster<'a>, most: usize) -> Self {
        Self { raster, size: raster.cells().min(TILE as i64), most, chain: Chain::default(), kept: Vec::new() }
    }

    /// Draws what waits if it is much.
    pub(super) fn relieve(&mut self) {
        let most = if self.kept.is_empty() { self.most } else { self.most.div_ceil(WAITING_BESIDE_TILES) };
        if self.chain.segments.len().max(self.chain.veils.len()) < most {
            return;
        }
        let tiles = self.tiles();
        self.kept.resize_with(tiles, || (0..tiles).map(|_| None).collect());
        let [segments, veils] = self.bins();
        let (raster, chain, size) = (self.raster, &self.chain, self.size);
        self.kept.par_iter_mut().enumerate().for_each(|(number, kept)| {
            Band { raster, chain, number, size, in_parts: true }.draw([segments.of(number), veils.of(number)], kept);
        });
        // The room of the first list is more than those that follow need.
        self.chain = Chain::default();
    }

    /// The sums over the face.
    pub(super) fn finish(mut self) -> Tally<Units> {
        let tiles = self.tiles();
        let mut kept = std::mem::take(&mut self.kept);
        let in_parts = !kept.is_empty();
        kept.resize_with(tiles, Row::new);
        if !in_parts {
            self.chain.join_rims();
        }
        let [segments, veils] = self.bins();
        let (raster, chain, size) = (self.raster, &self.chain, self.size);
        let settle = |(number, kept): (usize, Row)| {
            Band { raster, chain, number, size, in_parts }.settle([segments.of(number), veils.of(number)], kept)
        };
        let rows: Vec<Vec<Outcome>> = kept.into_par_iter().enumerate().map(settle).collect();
        TileGrid::new(raster, size, rows.into_iter().flatten().collect()).finish()
    }

    /// Tiles along an edge of the face.
    fn tiles(&self) -> usize {
        (self.raster.cells() / self.size) as usize
    }

    /// The segments and the veils by rows of tiles.
    fn bins(&self) -> [Bins; 2] {
        let (cells, size) = (self.raster.cells(), self.size);
        let bands_of = |segment| bands(Walk::of(segment).rows(0, cells), size);
        let veils = self.chain.veils.iter().map(|veil| {
            let ys = || veil.corners.iter().map(|corner| corner[1]);
            let (low, high) = (ys().fold(f64::INFINITY, f64::min), ys().fold(f64::NEG_INFINITY, f64::max));
            bands(Walk::new([0.0, low], [0.0, high], f64::from(veil.margin)).rows(0, cells), size)
        });
        [Bins::new(self.tiles(), self.chain.segments.iter().map(bands_of)), Bins::new(self.tiles(), veils)]
    }
}

/// The bands that rows lie in.
fn bands(rows: std::ops::Range<i64>, size: i64) -> std::ops::Range<usize> {
    if rows.is_empty() { 0..0 } else { (rows.start / size) as usize..((rows.end - 1) / size + 1) as usize }
}

impl Kept {
    fn new(place: TilePlace) -> Self {
        let mut tile = Tile::new();
        tile.move_to(place);
        Self { tile, crossings: Crossings::new() }
    }

    fn draw<'s>(
        &mut self,
        raster: &Raster,
        segments: impl Iterator<Item = &'s Segment>,
        veils: impl Iterator<Item = &'s Veil>,
    ) {
        let Self { tile, crossings } = self;
        let place = tile.place;
        for segment in segments {
            tile.add(segment, |cell, is_left| crossings.add(raster, place, cell, segment, is_left));
        }
        veils.for_each(|veil| tile.add_veil(veil));
    }
}

/// A tile that is needed for a moment only, and which segments touch its cells.
struct Fresh {
    tile: Box<Tile>,
    touches: Touches,
}

impl Fresh {
    /// Draws all that is on a tile; false if that is too much to note what touches what.
    fn draw<'s>(&mut self, place: TilePlace, segments: &[Met], veils: impl Iterator<Item = &'s Veil>) -> bool {
        let Self { tile, touches } = self;
        tile.move_to(place);
        touches.clear();
        for (number, (segment, _)) in (0..).zip(segments) {
            tile.add(segment, |cell, is_left| touches.add(number, cell, is_left));
        }
        veils.for_each(|veil| tile.add_veil(veil));
        !touches.are_too_many()
    }
}

/// A row of tiles.
struct Band<'a> {
    raster: &'a Raster<'a>,
    chain: &'a Chain,
    number: usize,
    size: i64,
    /// Whether anything on the face was drawn before and is forgotten.
    in_parts: bool,
}

/// What meets each tile of a band.
struct InBand<'a> {
    of_band: [&'a [u32]; 2],
    by_tile: [Bins; 2],
}

impl InBand<'_> {
    /// Segments and veils by their numbers.
    fn tile(&self, number: usize) -> [impl ExactSizeIterator<Item = usize> + Clone; 2] {
        [0, 1].map(|kind| self.by_tile[kind].of(number).iter().map(move |&k| self.of_band[kind][k as usize] as usize))
    }
}

impl Band<'_> {
    /// Draws what waits, and keeps the tiles.
    fn draw(&self, of_band: [&[u32]; 2], kept: &mut Row) {
        let in_band = self.by_tile(of_band);
        for (number, kept) in kept.iter_mut().enumerate() {
            let place = self.place(number);
            let [segments, veils] = in_band.tile(number);
            if segments.len() + veils.len() == 0 || self.is_off(&place) || !(self.raster.spend)(1) {
                continue;
            }
            let kept = kept.get_or_insert_with(|| Box::new(Kept::new(place)));
            kept.draw(self.raster, segments.map(|k| &self.chain.segments[k]), veils.map(|k| &self.chain.veils[k]));
        }
    }

    /// Draws what waits, and settles all tiles.
    fn settle(&self, of_band: [&[u32]; 2], mut kept: Row) -> Vec<Outcome> {
        let in_band = self.by_tile(of_band);
        let mut fresh = Fresh { tile: Tile::new(), touches: Touches::default() };
        let mut carry = [0; TILE];
        (0..(self.raster.cells() / self.size) as usize)
            .map(|number| {
                let place = self.place(number);
                if self.is_off(&place) || !(self.raster.spend)(1) {
                    return Outcome::Off;
                }
                let [segments, veils] = in_band.tile(number);
                let kept = kept.get_mut(number).and_then(Option::take);
                if segments.len() + veils.len() == 0 && kept.is_none() {
                    return Outcome::clear(carry[0]);
                }
                let veils = veils.map(|k| &self.chain.veils[k]);
                if kept.is_none() {
                    let met = segments.clone().map(|k| (&self.chain.segments[k], &self.chain.ends[k]));
                    let met: Vec<Met> = met.collect();
                    if fresh.draw(place, &met, veils.clone()) {
                        let Fresh { tile, touches } = &mut fresh;
                        return self.settle_tile(tile, &mut carry, |open_cells| {
                            look(self.raster, tile, open_cells, (&met, touches), !self.in_parts)
                        });
                    }
                }
                let mut kept = kept.unwrap_or_else(|| Box::new(Kept::new(place)));
                kept.draw(self.raster, segments.map(|k| &self.chain.segments[k]), veils);
                let Kept { tile, crossings } = kept.as_ref();
                self.settle_tile(tile, &mut carry, |(open, before)| {
                    Found::points(crossings.lit_points(tile, open, before))
                })
            })
            .collect()
    }

    /// `look` answers what is found out about the open cells, given the windings at the left.
    fn settle_tile(
        &self,
        tile: &Tile,
        carry: &mut [i32; TILE],
        look: impl FnOnce((&[u64; TILE], &[i32; TILE])) -> Found,
    ) -> Outcome {
        let before = *carry;
        let proofs = tile.settle(carry);
        let mut masks = TileMasks::new(self.raster, tile.place, &proofs);
        if let Some(outcome) = masks.whole() {
            return outcome;
        }
        let found = look((&masks.open, &before));
        masks.add_shadowed(&found.shadowed);
        masks.whole().unwrap_or_else(|| Outcome::Mixed(Box::new(masks.tally(self.raster, &found.lit_points))))
    }

    fn place(&self, number: usize) -> TilePlace {
        TilePlace { column: number as i64 * self.size, row: self.number as i64 * self.size, size: self.size }
    }

    /// Whether no cell of the tile is on the face.
    fn is_off(&self, place: &TilePlace) -> bool {
        self.raster.is_triangle() && place.column + place.row >= self.raster.cells()
    }

    fn by_tile<'b>(&self, of_band: [&'b [u32]; 2]) -> InBand<'b> {
        let tiles = (self.raster.cells() / self.size) as usize;
        let [segments, veils] = of_band;
        let segments = Bins::new(tiles, segments.iter().map(|&k| self.tiles_of_segment(k)));
        let veils = Bins::new(tiles, veils.iter().map(|&k| self.tiles_of_veil(&self.chain.veils[k as usize])));
        InBand { of_band, by_tile: [segments, veils] }
    }

    fn tiles_of_segment(&self, segment: u32) -> std::ops::Range<usize> {
        let first = self.number as i64 * self.size;
        let [low, high] = Walk::of(&self.chain.segments[segment as usize]).reach_over(first, first + self.size);
        // A crossing counts from the next middle of a cell on, which may be in the next tile.
        self.tiles_in(low, high + 1.0)
    }

    fn tiles_of_veil(&self, veil: &Veil) -> std::ops::Range<usize> {
        let margin = f64::from(veil.margin);
        let xs = || veil.corners.iter().map(|corner| corner[0]);
        self.tiles_in(xs().fold(f64::INFINITY, f64::min) - margin, xs().fold(f64::NEG_INFINITY, f64::max) + margin)
    }

    /// The tiles that a range of x meets; what is left of the face counts for the first one.
    fn tiles_in(&self, low: f64, high: f64) -> std::ops::Range<usize> {
        let (last, size) = (self.raster.cells() - 1, self.size);
        let first = floor(low).max(0) / size;
        let end = floor(high).clamp(0, last) / size + 1;
        first as usize..end.max(first) as usize
    }
}

#[cfg(test)]
mod tests {
    use umbriel_octree::Face;

    use super::*;
    use crate::fine::flat::{FaceShape, Levels};

    /// Counter-clockwise borders of triangles with corners on a grid finer than the cells, and here and there one as a veil.
    fn triangles(count: usize, cells: f64) -> impl Iterator<Item = Result<[Segment; 3], Veil>> {
        let mut seed = 12_345_u32;
        let mut part = move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 16) / 65_536.0
        };
        (0..count).map(move |number| {
            let at = [0, 1].map(|_| (1.4 * part() - 0.2) * cells);
            let mut corners = [0; 3].map(|_| at.map(|x| x + 0.3 * cells * (part() - 0.5)));
            let [a, b, c] = corners;
            if (b[0] - a[0]) * (c[1] - a[1]) < (b[1] - a[1]) * (c[0] - a[0]) {
                corners.swap(1, 2);
            }
            if number % 40 == 7 {
                return Err(Veil { corners: corners.to_vec(), margin: 1e-6 });
            }
            let side = |k: usize| Segment {
                from: corners[k],
                to: corners[(k + 1) % 3],
                margin: 1e-6,
                net: 1,
                is_beside: false,
            };
            Ok([0, 1, 2].map(side))
        })
    }

    #[test]
    fn what_is_drawn_in_parts_is_the_same() {
        for (domain, finest, count) in
            [(Face::Square, 3, 12), (Face::Triangle, 3, 12), (Face::Square, 8, 120), (Face::Triangle, 8, 120)]
        {
            let raster = Raster {
                shape: FaceShape { face: 0, domain, corner: 0 },
                levels: Levels { finest, interior: finest, keep_cells: true, pixel: None },
                lattice: None,
                is_lit_exactly: &|_, _| true,
                spend: &|_| true,
            };
            let drawn = |most: usize, as_part: bool| {
                let mut drawing = Drawing::with_most(&raster, most);
                let mut parts = 0;
                for triangle in triangles(count, raster.cells() as f64) {
                    match triangle {
                        Ok(sides) => {
                            sides.into_iter().for_each(|side| drawing.chain.push(side, [None; 2]));
                        }
                        Err(veil) => drawing.chain.veils.push(veil),
                    }
                    drawing.relieve();
                    parts += usize::from(drawing.chain.segments.len() == 0);
                }
                if as_part && drawing.kept.is_empty() {
                    drawing.kept.push(Row::new());
                }
                let tally = drawing.finish();
                ((tally.lit, tally.shadowed, tally.undecided, tally.likely), tally.cells, tally.points, parts)
            };
            let (sums, cells, points, parts) = drawn(usize::MAX, true);
            assert!(parts == 0 && sums.0 > 0 && (finest < 8 || sums.1 > 0) && sums.2 > 0 && sums.3 > 0, "{sums:?}");
            for most in [1, 20] {
                let in_parts = drawn(most, false);
                assert!(in_parts.3 > 0);
                assert!((in_parts.0, in_parts.1, in_parts.2) == (sums, cells.clone(), points), "{domain:?} {finest}");
            }
            // All at once, open cells are looked at again.
            let looked_at = drawn(usize::MAX, false).0;
            assert_eq!((looked_at.0, looked_at.1 + looked_at.2), (sums.0, sums.1 + sums.2));
            assert!(looked_at.2 < sums.2 || finest < 8, "{looked_at:?} {sums:?}");
        }
    }
}
