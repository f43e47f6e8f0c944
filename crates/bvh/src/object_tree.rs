//! The tree of bounding boxes over objects and families, in the manner of Xie, Yu, Hao and Sun (2001).
//!
//! The caller says which objects lie together; a family's box is the smallest around its members. A family with more
//! than [`WIDEST`] members, or a scene without families, is split further by the surface-area heuristic ([`BoxTree`]),
//! so that thousands of objects are no special case. A family of one is its member. Families may be nested to any
//! depth: nothing here recurses.

use glam::DVec3;
use umbriel_geometry::Aabb;

use crate::box_tree::{BoxTree, Shape};

/// Most children of a node. Siblings are tested in pairs, so the work in a node grows with the square of this.
const WIDEST: usize = 8;

/// A member of a family.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Member {
    /// An object, by its index.
    Object(u32),
    /// Another family, by its index in [`Families::members`].
    Family(u32),
}

/// Which objects lie together: a forest of families. The default has none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Families {
    /// The members of every family.
    pub members: Vec<Vec<Member>>,
    /// What stands at the top. Objects that are in no family need not be named.
    pub roots: Vec<Member>,
}

/// Why families are no forest over the objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FamilyDefect {
    /// A member that is not there.
    #[error("{0:?} is a member, but there is none")]
    Unknown(Member),
    /// A member of two families, or twice of one.
    #[error("{0:?} is a member more than once")]
    Repeated(Member),
    /// A family that no root leads to: it is named nowhere, or is part of a cycle.
    #[error("family {0} is not below any root")]
    Unreachable(u32),
    /// More objects or families than a tree can name.
    #[error("more than 2^30 objects or families")]
    TooMany,
}

/// A node of an [`ObjectTree`]: an object, a family, or a part of a family that was too wide.
///
/// It means something in the tree it came from, and in no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u32);

/// What stands below a node.
#[derive(Clone, Copy, Debug)]
enum Content {
    /// One object.
    Object(u32),
    /// Nodes: a range of `ObjectTree::children`.
    Nodes { first: u32, end: u32 },
}

/// A node: its box and what it holds.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    content: Content,
}

/// A tree of boxes over objects and families.
#[derive(Clone, Debug)]
pub struct ObjectTree {
    /// Children before parents.
    nodes: Vec<Node>,
    children: Vec<NodeId>,
    root: Option<NodeId>,
    objects: usize,
}

/// A tree's objects by the nodes that they lie below.
#[derive(Debug)]
pub(crate) struct Below {
    nodes: Vec<OfNode>,
    /// Those below one node follow each other.
    objects: Vec<u32>,
}

/// The objects below one node.
#[derive(Clone, Copy, Debug)]
struct OfNode {
    /// The place of the first.
    first: u32,
    count: u32,
    /// What their boxes have in common.
    common: Aabb,
}

impl Below {
    /// What the boxes of all objects below a node have in common.
    pub(crate) fn common(&self, node: NodeId) -> &Aabb {
        &self.nodes[ObjectTree::index(node)].common
    }

    /// The objects below a node.
    pub(crate) fn objects(&self, node: NodeId) -> &[u32] {
        let OfNode { first, count, .. } = self.nodes[ObjectTree::index(node)];
        &self.objects[first as usize..][..count as usize]
    }
}

impl OfNode {
    const NONE: Self = Self { first: 0, count: 0, common: Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY } };

    fn joined(self, other: &Self) -> Self {
        let common = Aabb { min: self.common.min.max(other.common.min), max: self.common.max.min(other.common.max) };
        Self { first: 0, count: self.count + other.count, common }
    }
}

impl ObjectTree {
    /// Builds the tree over the boxes of all objects. Objects with empty boxes are left out.
    ///
    /// O(n log n) in objects and families.
    ///
    /// # Errors
    /// [`FamilyDefect`] when the families are no forest over the objects.
    pub fn build(boxes: &[Aabb], families: &Families) -> Result<Self, FamilyDefect> {
        Self::build_of(boxes.len(), |object| Some(boxes[object as usize]), families)
    }

    /// As [`ObjectTree::build`], with a box for each of so many objects; those without one are left out as if it were empty.
    ///
    /// # Errors
    /// [`FamilyDefect`] when the families are no forest over the objects.
    pub fn build_of(
        objects: usize,
        bounds: impl Fn(u32) -> Option<Aabb>,
        families: &Families,
    ) -> Result<Self, FamilyDefect> {
        const MOST: usize = 1 << 30;
        if objects > MOST || families.members.len() > MOST {
            return Err(FamilyDefect::TooMany);
        }
        let order = parents_first(objects, families)?;
        let mut tree = Self { nodes: Vec::new(), children: Vec::new(), root: None, objects };
        let leaf = |object| bounds(object).and_then(|bounds| tree.add_object(object, &bounds));
        let leaves: Vec<Option<NodeId>> = (0..objects as u32).map(leaf).collect();
        let mut groups = vec![None; families.members.len()];
        for &family in order.families.iter().rev() {
            let nodes = present(&families.members[family as usize], &leaves, &groups);
            groups[family as usize] = tree.add_group(nodes);
        }
        let mut top = present(&families.roots, &leaves, &groups);
        top.extend(
            leaves.iter().zip(&order.is_member).filter(|(_, is_member)| !**is_member).filter_map(|(leaf, _)| *leaf),
        );
        tree.root = tree.add_group(top);
        Ok(tree)
    }

    /// The box around all objects.
    pub fn bounds(&self) -> Aabb {
        self.root.map_or(Aabb::EMPTY, |root| self.node(root).bounds)
    }

    /// How many objects the tree was built over, those with empty boxes included.
    pub fn objects(&self) -> usize {
        self.objects
    }

    /// How many boxes the tree has: objects, families and what large families were split into.
    pub fn boxes(&self) -> usize {
        self.nodes.len()
    }

    /// The node above all others; `None` where no object has a box.
    pub fn root(&self) -> Option<NodeId> {
        self.root
    }

    /// The nodes directly below `node`, two to eight of them; none for an object.
    ///
    /// # Panics
    /// Like all that takes a node, where the node is of a larger tree.
    pub fn children_of(&self, node: NodeId) -> &[NodeId] {
        match self.node(node).content {
            Content::Object(_) => &[],
            Content::Nodes { first, end } => &self.children[first as usize..end as usize],
        }
    }

    /// The smallest box around all that lies below `node`, world coordinates in metres.
    ///
    /// # Panics
    /// Where the node is of a larger tree.
    pub fn bounds_of(&self, node: NodeId) -> &Aabb {
        &self.node(node).bounds
    }

    /// The object that `node` is; `None` for a family or a part of one.
    ///
    /// # Panics
    /// Where the node is of a larger tree.
    pub fn object_of(&self, node: NodeId) -> Option<u32> {
        match self.node(node).content {
            Content::Object(object) => Some(object),
            Content::Nodes { .. } => None,
        }
    }

    /// All objects at or below `node`, ascending: what the source writes as `[0123456]`. O(k log k) for k objects.
    ///
    /// # Panics
    /// Where the node is of a larger tree.
    pub fn objects_below(&self, node: NodeId) -> Vec<u32> {
        let (mut objects, mut open) = (Vec::new(), vec![node]);
        while let Some(next) = open.pop() {
            objects.extend(self.object_of(next));
            open.extend(self.children_of(next));
        }
        objects.sort_unstable();
        objects
    }

    /// For each node, by [`Self::index`], whether `is_wanted` names an object at or below it.
    pub(crate) fn mark(&self, is_wanted: impl Fn(u32) -> bool) -> Vec<bool> {
        let mut marks = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let mark = match node.content {
                Content::Object(object) => is_wanted(object),
                Content::Nodes { first, end } => {
                    self.children[first as usize..end as usize].iter().any(|&child| marks[Self::index(child)])
                }
            };
            marks.push(mark);
        }
        marks
    }

    /// The objects that lie below each node.
    pub(crate) fn below(&self) -> Below {
        let mut below = Below { nodes: Vec::with_capacity(self.nodes.len()), objects: Vec::new() };
        for node in &self.nodes {
            let of_node = match node.content {
                Content::Object(_) => OfNode { count: 1, common: node.bounds, first: 0 },
                Content::Nodes { first, end } => self.children[first as usize..end as usize]
                    .iter()
                    .fold(OfNode::NONE, |sum, &child| sum.joined(&below.nodes[Self::index(child)])),
            };
            below.nodes.push(of_node);
        }
        // Parents come after their children, so this way round the place of each is known before those of its children.
        below.objects.resize(self.root.map_or(0, |root| below.nodes[Self::index(root)].count as usize), 0);
        for (index, node) in self.nodes.iter().enumerate().rev() {
            let mut first = below.nodes[index].first;
            match node.content {
                Content::Object(object) => below.objects[first as usize] = object,
                Content::Nodes { first: from, end } => {
                    for &child in &self.children[from as usize..end as usize] {
                        let child = &mut below.nodes[Self::index(child)];
                        child.first = first;
                        first += child.count;
                    }
                }
            }
        }
        below
    }

    /// The objects that have boxes, with these.
    pub(crate) fn boxed_objects(&self) -> impl Iterator<Item = (u32, &Aabb)> {
        self.nodes.iter().filter_map(|node| match node.content {
            Content::Object(object) => Some((object, &node.bounds)),
            Content::Nodes { .. } => None,
        })
    }

    /// The node of an object, if that has a box.
    pub(crate) fn node_of(&self, object: u32) -> Option<NodeId> {
        // Nodes of objects come first, ascending.
        let is_before = |node: &Node| matches!(node.content, Content::Object(other) if other < object);
        let node = NodeId(self.nodes.partition_point(is_before) as u32);
        self.nodes.get(Self::index(node)).and_then(|_| self.object_of(node)).filter(|&found| found == object)?;
        Some(node)
    }

    /// The place of a node in lists with an entry for each.
    pub(crate) fn index(node: NodeId) -> usize {
        node.0 as usize
    }

    fn node(&self, node: NodeId) -> &Node {
        &self.nodes[Self::index(node)]
    }

    fn add(&mut self, bounds: Aabb, content: Content) -> NodeId {
        self.nodes.push(Node { bounds, content });
        NodeId((self.nodes.len() - 1) as u32)
    }

    fn add_object(&mut self, object: u32, bounds: &Aabb) -> Option<NodeId> {
        (!bounds.is_empty()).then(|| self.add(*bounds, Content::Object(object)))
    }

    /// A node over `nodes`; the node itself when there is only one.
    fn add_group(&mut self, nodes: Vec<NodeId>) -> Option<NodeId> {
        match nodes.len() {
            0 => None,
            1 => Some(nodes[0]),
            2..=WIDEST => Some(self.add_node(nodes)),
            _ => self.add_split(&nodes),
        }
    }

    fn add_node(&mut self, nodes: impl IntoIterator<Item = NodeId>) -> NodeId {
        let first = self.children.len();
        self.children.extend(nodes);
        let end = self.children.len();
        let bounds = self.children[first..].iter().fold(Aabb::EMPTY, |sum, &child| sum.union(*self.bounds_of(child)));
        self.add(bounds, Content::Nodes { first: first as u32, end: end as u32 })
    }

    /// A family that is too wide: split in the shape of a [`BoxTree`] over its members.
    fn add_split(&mut self, nodes: &[NodeId]) -> Option<NodeId> {
        let boxes: Vec<Aabb> = nodes.iter().map(|&node| *self.bounds_of(node)).collect();
        let split = BoxTree::build(&boxes);
        let mut made = vec![NodeId(0); split.shape().len()];
        for (index, shape) in split.shape().enumerate().rev() {
            made[index] = match shape {
                Shape::Leaf(&[only]) => nodes[only as usize],
                Shape::Leaf(items) => self.add_node(items.iter().map(|&item| nodes[item as usize])),
                Shape::Inner(pair) => self.add_node(pair.map(|child| made[child])),
            };
        }
        made.first().copied()
    }
}

/// The nodes of those members that have one.
fn present(members: &[Member], leaves: &[Option<NodeId>], groups: &[Option<NodeId>]) -> Vec<NodeId> {
    let node = |member: &Member| match *member {
        Member::Object(object) => leaves[object as usize],
        Member::Family(family) => groups[family as usize],
    };
    members.iter().filter_map(node).collect()
}

/// What a walk over the families from the roots finds.
struct Order {
    /// All families, parents before children.
    families: Vec<u32>,
    /// Which objects are in a family.
    is_member: Vec<bool>,
}

/// Walks the forest and checks that it is one.
fn parents_first(objects: usize, families: &Families) -> Result<Order, FamilyDefect> {
    let mut object_seen = vec![false; objects];
    let mut family_seen = vec![false; families.members.len()];
    let mut order = Vec::new();
    let mut open: Vec<&[Member]> = vec![&families.roots];
    while let Some(members) = open.pop() {
        for &member in members {
            let seen = match member {
                Member::Object(object) => object_seen.get_mut(object as usize),
                Member::Family(family) => family_seen.get_mut(family as usize),
            };
            if std::mem::replace(seen.ok_or(FamilyDefect::Unknown(member))?, true) {
                return Err(FamilyDefect::Repeated(member));
            }
            if let Member::Family(family) = member {
                order.push(family);
                open.push(&families.members[family as usize]);
            }
        }
    }
    if let Some(family) = family_seen.iter().position(|seen| !seen) {
        return Err(FamilyDefect::Unreachable(family as u32));
    }
    Ok(Order { families: order, is_member: object_seen })
}

#[cfg(test)]
mod tests;
