//! A list in blocks: it grows without moving.
//!
//! A list that moves as it grows leaves half of its room unused and all that it had before behind; and once a long one is freed, allocators keep lists of its length where
//! they cannot give them back. Blocks have the same few lengths for all lists.

use std::{
    iter::Flatten,
    ops::{Index, IndexMut},
    slice,
};

/// A list, in blocks of `SIZE` items, a power of two.
#[derive(Clone, Debug)]
pub(crate) struct Blocks<T, const SIZE: usize> {
    /// All full but the last.
    blocks: Vec<Vec<T>>,
}

impl<T, const SIZE: usize> Default for Blocks<T, SIZE> {
    fn default() -> Self {
        Self { blocks: Vec::new() }
    }
}

impl<T, const SIZE: usize> Blocks<T, SIZE> {
    pub(super) fn len(&self) -> usize {
        self.blocks.last().map_or(0, |last| (self.blocks.len() - 1) * SIZE + last.len())
    }

    /// Adds an item; answers its place.
    pub(super) fn push(&mut self, item: T) -> usize {
        match self.blocks.last_mut() {
            Some(last) if last.len() < SIZE => last.push(item),
            // Most lists are short: the first block takes the room that it needs.
            None => self.blocks.push(vec![item]),
            Some(_) => {
                let mut block = Vec::with_capacity(SIZE);
                block.push(item);
                self.blocks.push(block);
            }
        }
        self.len() - 1
    }

    pub(super) fn iter(&self) -> Flatten<slice::Iter<'_, Vec<T>>> {
        self.blocks.iter().flatten()
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.blocks.iter_mut().flatten()
    }

    /// The items as others.
    pub(super) fn map<U>(&self, f: impl Fn(&T) -> U) -> Blocks<U, SIZE> {
        Blocks { blocks: self.blocks.iter().map(|block| block.iter().map(&f).collect()).collect() }
    }
}

impl<T: Copy, const SIZE: usize> Blocks<T, SIZE> {
    /// Leaves out the items of which `is_kept` is false.
    pub(super) fn retain(&mut self, mut is_kept: impl FnMut(&T) -> bool) {
        let mut kept = 0;
        for place in 0..self.len() {
            let item = self[place];
            if is_kept(&item) {
                self[kept] = item;
                kept += 1;
            }
        }
        self.blocks.truncate(kept.div_ceil(SIZE));
        if let Some(last) = self.blocks.last_mut() {
            last.truncate((kept - 1) % SIZE + 1);
        }
    }
}

impl<T, const SIZE: usize> Index<usize> for Blocks<T, SIZE> {
    type Output = T;

    fn index(&self, place: usize) -> &T {
        &self.blocks[place / SIZE][place % SIZE]
    }
}

impl<T, const SIZE: usize> IndexMut<usize> for Blocks<T, SIZE> {
    fn index_mut(&mut self, place: usize) -> &mut T {
        &mut self.blocks[place / SIZE][place % SIZE]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_in_blocks_is_a_list() {
        for count in [0, 1, 3, 4, 5, 8, 9, 20] {
            let list: Vec<usize> = (0..count).map(|number| number * 7 % 5).collect();
            let mut blocks = Blocks::<usize, 4>::default();
            for (place, &item) in list.iter().enumerate() {
                assert_eq!(blocks.push(item), place);
            }
            let same = |blocks: &Blocks<usize, 4>, list: &[usize]| {
                assert!(blocks.iter().eq(list), "{blocks:?}");
                assert_eq!(blocks.len(), list.len());
                (0..list.len()).for_each(|place| assert_eq!(blocks[place], list[place]));
            };
            same(&blocks, &list);
            for least in 0..6 {
                let (mut blocks, mut list) = (blocks.clone(), list.clone());
                blocks.retain(|&item| item >= least);
                list.retain(|&item| item >= least);
                same(&blocks, &list);
                blocks.push(9);
                list.push(9);
                blocks.iter_mut().chain(&mut list).for_each(|item| *item += 1);
                same(&blocks, &list);
                assert!(blocks.map(|&item| item + 1).iter().eq(&list.iter().map(|item| item + 1).collect::<Vec<_>>()));
            }
        }
    }
}
