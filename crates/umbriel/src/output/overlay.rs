//! The cells of one object under several lights, laid over each other: the coarsest cells on which every light has one
//! verdict.
//!
//! The cells of one light are disjoint squares of a quadtree, sorted by face and Morton code; so is their overlay. Each
//! face is divided from its whole square downward while some light has finer cells. O(cells × levels).

use std::ops::Range;

use umbriel_octree::encode2;
use umbriel_shadow::{Cell, Verdict};

/// Depth of the grid on which cells are compared.
const DEPTH: u8 = 31;

/// The common parts, each with one verdict a list (`None` where that list has no cell). `visit` sees them by face and
/// Morton code; the verdict of the cell itself means nothing. Cells of a list must not overlap.
pub(crate) fn overlay(lists: &[&[Cell]], mut visit: impl FnMut(&Cell, &[Option<Verdict>])) {
    let sorted: Vec<Vec<Cell>> = lists.iter().map(|cells| sorted(cells)).collect();
    let mut next = vec![0; lists.len()];
    while let Some(first) = (0..lists.len()).filter_map(|k| sorted[k].get(next[k])).min_by_key(|cell| cell.face) {
        let root = Cell { level: 0, i: 0, j: 0, ..*first };
        let ranges: Vec<Range<usize>> = (sorted.iter().zip(&next))
            .map(|(cells, &from)| from..from + cells[from..].partition_point(|cell| cell.face <= root.face))
            .collect();
        ranges.iter().zip(&mut next).for_each(|(range, next)| *next = range.end);
        let face = Face { lists: &sorted };
        face.divide(&root, &ranges, &vec![None; lists.len()], &mut visit);
    }
}

fn sorted(cells: &[Cell]) -> Vec<Cell> {
    let mut cells = cells.to_vec();
    cells.sort_by_key(|cell| (cell.face, code(cell)));
    cells
}

/// Morton code of a cell's first corner on the finest grid.
fn code(cell: &Cell) -> u64 {
    let shift = DEPTH.saturating_sub(cell.level);
    encode2([cell.i << shift, cell.j << shift])
}

struct Face<'a> {
    lists: &'a [Vec<Cell>],
}

impl Face<'_> {
    /// Visits what lies in `square`: of every list, the cells of a range, or the verdict of a larger cell.
    fn divide(
        &self,
        square: &Cell,
        ranges: &[Range<usize>],
        known: &[Option<Verdict>],
        visit: &mut impl FnMut(&Cell, &[Option<Verdict>]),
    ) {
        let (mut ranges, mut known) = (ranges.to_vec(), known.to_vec());
        for (k, range) in ranges.iter_mut().enumerate() {
            if let [only] = &self.lists[k][range.clone()]
                && only.level == square.level
            {
                known[k] = Some(only.verdict);
                *range = range.end..range.end;
            }
        }
        if ranges.iter().all(Range::is_empty) {
            if known.iter().any(Option::is_some) {
                visit(square, &known);
            }
            return;
        }
        for (di, dj) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let part = Cell { level: square.level + 1, i: 2 * square.i + di, j: 2 * square.j + dj, ..*square };
            let end = code(&part) + (1 << (2 * (DEPTH - part.level)));
            let mut inside = Vec::with_capacity(ranges.len());
            for (k, range) in ranges.iter_mut().enumerate() {
                let count = self.lists[k][range.clone()].partition_point(|cell| code(cell) < end);
                inside.push(range.start..range.start + count);
                range.start += count;
            }
            self.divide(&part, &inside, &known, visit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Lit, Shadowed, Undecided};

    fn cell(face: u32, level: u8, i: u32, j: u32, verdict: Verdict) -> Cell {
        Cell { face, corner: 2, level, i, j, verdict }
    }

    type Part = (u32, u8, u32, u32, Vec<Option<Verdict>>);

    fn parts(lists: &[&[Cell]]) -> Vec<Part> {
        let mut parts = Vec::new();
        overlay(lists, |cell, verdicts| {
            assert_eq!(cell.corner, 2);
            parts.push((cell.face, cell.level, cell.i, cell.j, verdicts.to_vec()));
        });
        parts
    }

    #[test]
    fn one_light_keeps_its_cells() {
        let cells = [cell(0, 0, 0, 0, Lit), cell(3, 1, 0, 0, Lit), cell(3, 1, 1, 1, Undecided)];
        let expected =
            [(0, 0, 0, 0, vec![Some(Lit)]), (3, 1, 0, 0, vec![Some(Lit)]), (3, 1, 1, 1, vec![Some(Undecided)])];
        assert_eq!(parts(&[&cells]), expected);
    }

    #[test]
    fn the_finer_light_divides() {
        let whole = [cell(0, 0, 0, 0, Lit), cell(1, 0, 0, 0, Shadowed)];
        let quarters = [cell(0, 1, 0, 0, Lit), cell(0, 1, 1, 0, Shadowed), cell(0, 1, 0, 1, Undecided)];
        let expected = [
            (0, 1, 0, 0, vec![Some(Lit), Some(Lit)]),
            (0, 1, 1, 0, vec![Some(Lit), Some(Shadowed)]),
            (0, 1, 0, 1, vec![Some(Lit), Some(Undecided)]),
            // The second light has no cell here.
            (0, 1, 1, 1, vec![Some(Lit), None]),
            (1, 0, 0, 0, vec![Some(Shadowed), None]),
        ];
        assert_eq!(parts(&[&whole, &quarters]), expected);
    }

    /// Against the plain way: every square of the finest grid looks up its verdict in every list.
    #[test]
    fn every_point_keeps_its_verdicts() {
        let mut seed = 7u64;
        let mut chance = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as u32
        };
        for _ in 0..50 {
            let lists: Vec<Vec<Cell>> = (0..3)
                .map(|_| {
                    let (mut open, mut cells) = (vec![cell(0, 0, 0, 0, Lit), cell(2, 0, 0, 0, Lit)], Vec::new());
                    while let Some(square) = open.pop() {
                        match chance() % 4 {
                            0 | 1 if square.level < 4 => open.extend((0..4).map(|k| Cell {
                                level: square.level + 1,
                                i: 2 * square.i + k % 2,
                                j: 2 * square.j + k / 2,
                                ..square
                            })),
                            2 => {}
                            _ => cells
                                .push(Cell { verdict: [Lit, Shadowed, Undecided][chance() as usize % 3], ..square }),
                        }
                    }
                    cells
                })
                .collect();
            let at = |cells: &[Cell], face: u32, i: u32, j: u32| {
                let holds = |cell: &&Cell| {
                    let shift = 4 - cell.level;
                    cell.face == face && (cell.i, cell.j) == (i >> shift, j >> shift)
                };
                let found: Vec<Verdict> = cells.iter().filter(holds).map(|cell| cell.verdict).collect();
                assert!(found.len() < 2, "cells overlap");
                found.first().copied()
            };
            let slices: Vec<&[Cell]> = lists.iter().map(Vec::as_slice).collect();
            let parts = parts(&slices);
            for (face, i, j) in (0..3).flat_map(|face| (0..256).map(move |k| (face, k % 16, k / 16))) {
                let expected: Vec<Option<Verdict>> = lists.iter().map(|cells| at(cells, face, i, j)).collect();
                let holding: Vec<&Part> = (parts.iter())
                    .filter(|part| part.0 == face && (part.2, part.3) == (i >> (4 - part.1), j >> (4 - part.1)))
                    .collect();
                match holding.as_slice() {
                    [] => assert!(expected.iter().all(Option::is_none)),
                    [part] => assert_eq!(part.4, expected),
                    more => panic!("{} parts overlap", more.len()),
                }
            }
        }
    }
}
