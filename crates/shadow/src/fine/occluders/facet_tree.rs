//! The facets of one object as a frame of the light sees them, in a packed tree.
//!
//! Boxes in light space are counted in whole numbers across the light and in single precision along it. Both ways of rounding are monotone, so boxes that
//! meet still do: nothing that may block is left out, and what is handed out beside that lies no farther than 2^-27 of the extent of the object's box away, 2^-22 along the light.
//! A tree of doubles took five times as long to build, three times the memory, and as long to look through. Cost: a look at each facet and a sort;
//! 28 bytes a facet.

use std::ops::ControlFlow;

use glam::DVec3;
use umbriel_geometry::{
    Aabb,
    simd::{Kernel, Simd, dispatch},
};

use crate::fine::packed_tree::{Path, Rect, Tree, key};

/// A tree over facets.
pub(super) struct FacetTree {
    grid: Grid,
    tree: Tree,
    /// The facets in order.
    items: Vec<u32>,
}

/// A facet on its way into a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    facet: u32,
    rect: Rect,
    nearest: f32,
}

impl FacetTree {
    /// Of facets as a grid has them, as long as `goes_on`.
    pub(super) fn build_while(grid: Grid, entries: Vec<Entry>, goes_on: &dyn Fn() -> bool) -> Option<Self> {
        let mut order = Vec::with_capacity(entries.len());
        for (place, entry) in (0u32..).zip(&entries) {
            if place.is_multiple_of(LOOKS) && !goes_on() {
                return None;
            }
            order.push((key(&entry.rect, false, 0), place));
        }
        sort_while(&mut order, goes_on)?;
        let (mut boxes, mut items) = (Vec::with_capacity(order.len()), Vec::with_capacity(order.len()));
        for (number, &(_, place)) in (0u32..).zip(&order) {
            if number.is_multiple_of(LOOKS) && !goes_on() {
                return None;
            }
            let Entry { facet, rect, nearest } = entries[place as usize];
            boxes.push((rect, nearest));
            items.push(facet);
        }
        // Many trees are built side by side: what is not needed any more goes before more comes.
        drop((entries, order));
        Some(Self { tree: Tree::of_boxes(&boxes), items, grid })
    }

    /// Visits the facets whose boxes meet `query`, and maybe some all but as near, until `visit` breaks. `query` has no least depth.
    pub(super) fn for_each_meeting(&self, query: &Aabb, visit: impl FnMut(u32) -> ControlFlow<()>) -> ControlFlow<()> {
        let (rect, farthest) = (self.grid.rect(query), self.grid.depth(query.max.z));
        dispatch(Look { facets: self, rect, farthest, visit })
    }
}

/// Boxes that are looked at, and numbers that are sorted, without asking for the time; a millisecond.
const LOOKS: u32 = 1 << 15;

/// Sorts numbers that are all different, as long as `goes_on`.
fn sort_while(items: &mut [(u64, u32)], goes_on: &dyn Fn() -> bool) -> Option<()> {
    if !goes_on() {
        return None;
    }
    if items.len() <= LOOKS as usize {
        items.sort_unstable();
        return Some(());
    }
    let middle = items.len() / 2;
    items.select_nth_unstable(middle);
    let (low, high) = items.split_at_mut(middle);
    sort_while(low, goes_on)?;
    sort_while(high, goes_on)
}

/// A look for what is over a box.
struct Look<'a, V> {
    facets: &'a FacetTree,
    rect: Rect,
    farthest: f32,
    visit: V,
}

impl<V: FnMut(u32) -> ControlFlow<()>> Kernel for Look<'_, V> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> ControlFlow<()> {
        let Self { facets: FacetTree { tree, items, .. }, rect, farthest, mut visit } = self;
        let mut path = Path::default();
        tree.begin(simd, &rect, farthest, &mut path);
        while let Some(place) = tree.walk(simd, &rect, farthest, &mut path) {
            visit(items[place])?;
        }
        ControlFlow::Continue(())
    }
}

/// Where whole numbers lie across the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    center: DVec3,
    /// Steps a metre along each axis, or whatever the frame counts in; powers of two.
    steps: DVec3,
}

impl Grid {
    /// So fine that a box takes 2^28 to 2^29 steps.
    pub(super) fn over(whole: Aabb) -> Self {
        let finite = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(-f64::MAX, f64::MAX) };
        // Finite: what is nothing stays nothing. The size of what lies at infinity as a whole is no number.
        let exponent = |extent: f64| (28 - libm::ilogb(finite(extent).max(f64::MIN_POSITIVE))).min(1000);
        let steps = |extent: f64| libm::scalbn(1.0, exponent(extent));
        let center = DVec3::from_array(whole.center().to_array().map(finite));
        Self { center, steps: DVec3::from_array(whole.size().to_array().map(steps)) }
    }

    /// A facet with its box, which had better lie in what the grid is over.
    pub(super) fn entry(&self, facet: u32, bounds: &Aabb) -> Entry {
        Entry { facet, rect: self.rect(bounds), nearest: self.depth(bounds.min.z) }
    }

    fn rect(&self, bounds: &Aabb) -> Rect {
        Rect { min: self.place(bounds.min), max: self.place(bounds.max) }
    }

    /// Each operation is monotone, the cast toward zero too.
    fn place(&self, corner: DVec3) -> [i32; 2] {
        const MOST: f64 = (1 << 30) as f64;
        [0, 1].map(|k| ((corner[k] - self.center[k]) * self.steps[k]).clamp(-MOST, MOST) as i32)
    }

    fn depth(&self, depth: f64) -> f32 {
        ((depth - self.center.z) * self.steps.z) as f32
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn tree_of(facets: &[(u32, Aabb)], goes_on: bool) -> Option<FacetTree> {
        let grid = Grid::over(facets.iter().fold(Aabb::EMPTY, |whole, (_, bounds)| whole.union(*bounds)));
        let entries = facets.iter().map(|(facet, bounds)| grid.entry(*facet, bounds)).collect();
        FacetTree::build_while(grid, entries, &|| goes_on)
    }

    fn number() -> impl Strategy<Value = f64> {
        let magnitude = prop_oneof![Just(0.0), Just(1.0), Just(1e-300), Just(4e61), Just(f64::INFINITY), 0.0..2.0];
        (magnitude, any::<bool>(), 0..4_u32).prop_map(|(magnitude, is_below, ulps)| {
            let number = if is_below { -magnitude } else { magnitude };
            (0..ulps).fold(number, |number, _| number.next_up())
        })
    }

    fn bounds() -> impl Strategy<Value = Aabb> {
        [[number(), number()], [number(), number()], [number(), number()]].prop_map(|ends| Aabb {
            min: DVec3::from_array(ends.map(|[a, b]| a.min(b))),
            max: DVec3::from_array(ends.map(|[a, b]| a.max(b))),
        })
    }

    proptest! {
        #[test]
        fn what_meets_is_visited_once(boxes in prop::collection::vec(bounds(), 0..90), query in bounds()) {
            let facets: Vec<(u32, Aabb)> = (100..).zip(boxes).collect();
            let query = Aabb { min: query.min.with_z(f64::NEG_INFINITY), ..query };
            let tree = tree_of(&facets, true).expect("it goes on");
            let mut visited = Vec::new();
            let _ = tree.for_each_meeting(&query, |facet| {
                visited.push(facet);
                ControlFlow::Continue(())
            });
            visited.sort_unstable();
            prop_assert!(visited.windows(2).all(|pair| pair[0] < pair[1]));
            for (facet, bounds) in &facets {
                prop_assert!(!bounds.meets(&query) || visited.contains(facet), "{facet} with {bounds:?}");
            }
        }
    }

    #[test]
    fn what_lies_at_infinity_is_found() {
        let at = |x: f64| Aabb { min: DVec3::splat(x), max: DVec3::splat(x) };
        for x in [f64::INFINITY, f64::NEG_INFINITY] {
            let tree = tree_of(&[(7, at(x)), (8, at(x))], true).expect("it goes on");
            let mut found = Vec::new();
            let query = Aabb { min: DVec3::NEG_INFINITY, max: at(x).max };
            let _ = tree.for_each_meeting(&query, |facet| {
                found.push(facet);
                ControlFlow::Continue(())
            });
            assert_eq!(found, [7, 8], "at {x}");
        }
    }

    #[test]
    fn what_is_clearly_apart_is_passed_over() {
        let at = |k: u32| f64::from(k) * 2.0;
        let square = |k: u32| Aabb {
            min: DVec3::new(at(k % 30), at(k / 30), 1.0),
            max: DVec3::new(at(k % 30) + 1.0, at(k / 30) + 1.0, 2.0),
        };
        let facets: Vec<(u32, Aabb)> = (0..900).map(|k| (k, square(k))).collect();
        let tree = tree_of(&facets, true).expect("it goes on");
        let found = |query: Aabb| {
            let mut found = Vec::new();
            let _ = tree.for_each_meeting(&query, |facet| {
                found.push(facet);
                ControlFlow::Continue(())
            });
            found
        };
        let deep = |z: f64| Aabb { min: DVec3::new(20.5, 40.5, f64::NEG_INFINITY), max: DVec3::new(21.5, 41.5, z) };
        assert_eq!((found(deep(1.0)), found(deep(0.999))), (vec![20 * 30 + 10], vec![]));
        let first = tree.for_each_meeting(&deep(5.0), |_| ControlFlow::Break(()));
        assert!(first.is_break());
        assert!(tree_of(&facets, false).is_none(), "the clock comes first");
    }
}
