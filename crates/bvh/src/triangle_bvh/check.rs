//! Whether a tree is one over its mesh: boxes hold what is below them, every triangle is there once, no way is too long.

use super::{
    TriangleBvh,
    bounds::Bounds,
    build::MAX_DEPTH,
    layout::{Node, WIDTH},
};
use crate::box_tree::TreeDefect;

pub(super) fn check(bvh: &TriangleBvh) -> Result<(), TreeDefect> {
    let parts = &bvh.parts;
    let mut walk = Walk {
        bvh,
        nodes: vec![false; parts.nodes.len()],
        packs: vec![false; parts.packs.len()],
        triangles: vec![false; bvh.len()],
    };
    walk.node(0, 1)?;
    let unreached = |reached: &[bool]| reached.iter().position(|&reached| !reached);
    if let Some(node) = unreached(&walk.nodes).or(unreached(&walk.packs)) {
        return Err(TreeDefect::Node { node });
    }
    unreached(&walk.triangles).map_or(Ok(()), |item| Err(TreeDefect::Item { item }))
}

struct Walk<'a> {
    bvh: &'a TriangleBvh,
    nodes: Vec<bool>,
    packs: Vec<bool>,
    triangles: Vec<bool>,
}

impl Walk<'_> {
    /// Checks the node and all below it; returns the box around them.
    fn node(&mut self, index: usize, depth: usize) -> Result<Bounds, TreeDefect> {
        if depth > MAX_DEPTH {
            return Err(TreeDefect::Depth { node: index });
        }
        let node = match self.nodes.get_mut(index) {
            Some(reached) if !*reached => {
                *reached = true;
                &self.bvh.parts.nodes[index]
            }
            _ => return Err(TreeDefect::Node { node: index }),
        };
        let mut all = Bounds::EMPTY;
        for lane in (0..WIDTH).filter(|&lane| node.planes[0][lane] <= node.planes[3][lane]) {
            let child = node.children[lane] as usize;
            let content = if node.leaves >> lane & 1 == 1 { self.pack(child)? } else { self.node(child, depth + 1)? };
            let claimed = lane_bounds(node, lane);
            if !claimed.holds(&content) {
                return Err(TreeDefect::Bounds { node: index });
            }
            all = all.union(&claimed);
        }
        Ok(all)
    }

    fn pack(&mut self, index: usize) -> Result<Bounds, TreeDefect> {
        match self.packs.get_mut(index) {
            Some(reached) if !*reached => *reached = true,
            _ => return Err(TreeDefect::Node { node: index }),
        }
        let pack = &self.bvh.parts.packs[index];
        let mut all = Bounds::EMPTY;
        for (lane, &triangle) in pack.triangles.iter().enumerate() {
            let item = triangle as usize;
            let is_repeated = lane > 0 && triangle == pack.triangles[0];
            let corners = (item < self.triangles.len()).then(|| self.bvh.corners(triangle));
            let corners = corners.filter(|_| is_repeated || !self.triangles[item]).ok_or(TreeDefect::Item { item })?;
            self.triangles[item] = true;
            for (corner, position) in corners.into_iter().enumerate() {
                let stored = [0, 1, 2].map(|axis| f64::from(pack.corners[corner][axis][lane]));
                let off = (self.bvh.parts.frame.localise(position) - glam::DVec3::from_array(stored)).abs();
                if off.max_element() > f64::from(self.bvh.parts.corner_error) {
                    return Err(TreeDefect::Item { item });
                }
            }
            all = all.union(&self.bvh.parts.frame.bounds_of(corners));
        }
        Ok(all)
    }
}

/// The box of a child.
fn lane_bounds(node: &Node, lane: usize) -> Bounds {
    Bounds::new([0, 1, 2].map(|axis| node.planes[axis][lane]), [3, 4, 5].map(|row| node.planes[row][lane]))
}
