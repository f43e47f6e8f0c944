//! Ray casting: a ray for each pixel, through a tree of boxes or an octree (Appel, "Some techniques for shading machine renderings
//! of solids", AFIPS 1968).
//!
//! The tree answers with the faces whose boxes the ray comes near, nearest boxes first; these are asked one by one, and what lies
//! behind the nearest face so far is passed over. Boxes hold the exact faces, and are entered no later than in truth, so no
//! face is missed. Cost: O(log faces) a pixel in practice, whatever the size of the scene; building O(faces · log faces).

use umbriel_bvh::BoxTree;
use umbriel_geometry::Aabb;
use umbriel_octree::{Cube, Limits, LinearOctree, Ray as OctreeRay};

use super::{HiddenSurface, NOTHING, Shot, Statistics, Window};

/// How rays find faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RayTree {
    /// By a binary tree of boxes.
    #[default]
    Boxes,
    /// By a linear octree.
    Octree,
}

/// Ray casting through a tree over the faces of one shot.
#[derive(Debug)]
pub struct RayCasting {
    tree: Tree,
}

#[derive(Debug)]
enum Tree {
    Boxes(BoxTree),
    Octree(Box<LinearOctree>),
}

impl RayCasting {
    /// Builds the tree over the faces that may be seen. Scenes that no octree holds (their coordinates beyond its lattice) get a tree of
    /// boxes.
    pub fn new(shot: &Shot, tree: RayTree) -> Self {
        let boxes: Vec<_> = (0..shot.footprints.len() as u32).map(|face| shot.bounds(face)).collect();
        let whole = boxes.iter().fold(Aabb::EMPTY, |whole, bounds| whole.union(*bounds));
        let octree = || octree_over(&whole, &boxes);
        let octree = (tree == RayTree::Octree).then(octree).flatten();
        let tree = octree.map_or_else(|| Tree::Boxes(BoxTree::build(&boxes)), |octree| Tree::Octree(Box::new(octree)));
        Self { tree }
    }
}

/// An octree with about as many leaves as faces.
fn octree_over(whole: &Aabb, boxes: &[Aabb]) -> Option<LinearOctree> {
    let max_level = (boxes.len().max(1).ilog2() / 2 + 2).min(12) as u8;
    let cube = Cube::on_grid(whole, max_level)?;
    LinearOctree::build(cube, boxes, Limits { max_level, leaf_items: 8 }).ok()
}

impl HiddenSurface for RayCasting {
    fn name(&self) -> &'static str {
        match self.tree {
            Tree::Boxes(_) => "raycast",
            Tree::Octree(_) => "raycast-octree",
        }
    }

    fn window(&self) -> [u32; 2] {
        [u32::MAX, 8]
    }

    fn draw(&self, shot: &Shot, window: &Window, _faces: &[u32], pixels: &mut [u32]) -> Statistics {
        let mut work = Statistics::default();
        for (index, held) in pixels.iter_mut().enumerate() {
            let (column, row) = (index as u32 % window.width(), index as u32 / window.width());
            let pixel = [window.left + column, window.top + row];
            match &self.tree {
                Tree::Boxes(tree) => through_boxes(tree, shot, pixel, held, &mut work),
                Tree::Octree(octree) => through_octree(octree, shot, pixel, held, &mut work),
            }
        }
        work
    }
}

fn through_boxes(tree: &BoxTree, shot: &Shot, pixel: [u32; 2], held: &mut u32, work: &mut Statistics) {
    let ray = shot.ray(pixel);
    tree.for_each_near(&ray, f64::INFINITY, |face, _, reach| {
        let before = *held;
        shot.contest(face, pixel, held, work);
        if *held == before || *held == NOTHING { reach } else { reach.min(shot.reach(*held, pixel)) }
    });
}

fn through_octree(octree: &LinearOctree, shot: &Shot, pixel: [u32; 2], held: &mut u32, work: &mut Statistics) {
    let ray = shot.ray(pixel);
    let Ok(along) = OctreeRay::new(ray.origin, ray.direction) else {
        // A direction with a component that is next to nothing, which octrees refuse: all faces are asked.
        return (0..shot.footprints.len() as u32).for_each(|face| shot.contest(face, pixel, held, work));
    };
    let mut reach = f64::INFINITY;
    for (crossing, leaf) in octree.cast(&along) {
        if crossing.enter > reach {
            break;
        }
        for &face in leaf.items {
            let before = *held;
            shot.contest(face, pixel, held, work);
            if *held != before {
                reach = shot.reach(*held, pixel);
            }
        }
    }
}
