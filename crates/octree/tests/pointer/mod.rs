//! The rival: a plain octree of boxes with pointers, recursive, over the same cells.

use glam::DVec3;
use umbriel_geometry::{Aabb, Region, Relation};
use umbriel_octree::{Cube, Octant};

/// A node of a pointer octree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Node {
    Leaf(Relation),
    Inner(Box<[Node; 8]>),
}

impl Node {
    pub(crate) fn build(region: &dyn Region, cell: Aabb, parts: &[u32], depth: u8) -> Self {
        let met: Vec<u32> = parts.iter().copied().filter(|&part| region.meets(part, &cell)).collect();
        if met.is_empty() {
            return Self::Leaf(if region.encloses(cell.max) { Relation::Inside } else { Relation::Outside });
        }
        if depth == 0 {
            return Self::Leaf(Relation::Boundary);
        }
        Self::Inner(Box::new(std::array::from_fn(|child| Self::build(region, part_of(&cell, child), &met, depth - 1))))
    }

    /// The tree of a region over a cube whose planes are floats.
    pub(crate) fn of(region: &dyn Region, cube: &Cube, depth: u8) -> Self {
        Self::build(region, cube.bounds_of(Octant::ROOT), &Vec::from_iter(0..region.parts()), depth)
    }

    /// What the leaf that holds a point of the cube says.
    pub(crate) fn at(&self, cell: Aabb, point: DVec3) -> Relation {
        match self {
            Self::Leaf(relation) => *relation,
            Self::Inner(children) => {
                let middle = middle(&cell);
                let child = (0..3).filter(|&axis| point[axis] >= middle[axis]).fold(0, |bits, axis| bits | 1 << axis);
                children[child].at(part_of(&cell, child), point)
            }
        }
    }

    /// Visits all leaves in Morton order.
    pub(crate) fn leaves(&self, cell: Octant, visit: &mut impl FnMut(Octant, Relation)) {
        match self {
            Self::Leaf(relation) => visit(cell, *relation),
            Self::Inner(children) => {
                cell.children().zip(children.iter()).for_each(|(cell, node)| node.leaves(cell, visit))
            }
        }
    }

    pub(crate) fn list(&self) -> Vec<(Octant, Relation)> {
        let mut list = Vec::new();
        self.leaves(Octant::ROOT, &mut |cell, relation| list.push((cell, relation)));
        list
    }

    /// Both trees joined by a rule, siblings that agree put together.
    pub(crate) fn combined(&self, other: &Self, rule: fn(Relation, Relation) -> Relation) -> Self {
        if let (Self::Leaf(a), Self::Leaf(b)) = (self, other) {
            return Self::Leaf(rule(*a, *b));
        }
        let children: [Self; 8] = std::array::from_fn(|index| self.child(index).combined(other.child(index), rule));
        let first = children[0].clone();
        let agree = matches!(first, Self::Leaf(Relation::Inside | Relation::Outside));
        if agree && children.iter().all(|node| *node == first) { first } else { Self::Inner(Box::new(children)) }
    }

    /// A child, or the leaf itself.
    fn child(&self, index: usize) -> &Self {
        match self {
            Self::Leaf(_) => self,
            Self::Inner(children) => &children[index],
        }
    }

    /// The tree cut at a depth.
    pub(crate) fn cut(&self, depth: u8) -> Self {
        match self {
            Self::Inner(_) if depth == 0 => Self::Leaf(Relation::Boundary),
            Self::Inner(children) => Self::Inner(Box::new(std::array::from_fn(|index| children[index].cut(depth - 1)))),
            leaf => leaf.clone(),
        }
    }

    /// Counts the leaves along a ray in plain floats, near ones first: recursion by slabs.
    #[allow(dead_code, reason = "only the benchmark asks")]
    pub(crate) fn cast(&self, cell: Aabb, origin: DVec3, inverse: DVec3) -> usize {
        let (low, high) = ((cell.min - origin) * inverse, (cell.max - origin) * inverse);
        if low.min(high).max_element().max(0.0) > low.max(high).min_element() {
            return 0;
        }
        match self {
            Self::Leaf(_) => 1,
            Self::Inner(children) => {
                let turned = (0..3).filter(|&axis| inverse[axis] < 0.0).fold(0, |bits, axis| bits | 1 << axis);
                let near_first = (0..8).map(|order: usize| order ^ turned);
                near_first.map(|child| children[child].cast(part_of(&cell, child), origin, inverse)).sum()
            }
        }
    }
}

fn middle(cell: &Aabb) -> DVec3 {
    (cell.min + cell.max) * 0.5
}

fn part_of(cell: &Aabb, child: usize) -> Aabb {
    let middle = middle(cell);
    let mut part = *cell;
    for axis in 0..3 {
        if child >> axis & 1 == 1 {
            part.min[axis] = middle[axis];
        } else {
            part.max[axis] = middle[axis];
        }
    }
    part
}
