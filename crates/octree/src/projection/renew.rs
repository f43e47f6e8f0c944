//! A projection after triangles have moved: only what they touched, or touch now, is made anew.
//!
//! *Tree.* A triangle has moved where a corner of it lies elsewhere. On the way down beside the old tree, a cell that no moved triangle
//! met before or meets now keeps what is below it: the same triangles would be tested against the same cells. All other cells are
//! divided as ever. *Maps.* Packs have new numbers then, and a tile in which no changed leaf is seen, or was, keeps its cells
//! under these; other tiles are filled from the packs of the leaves whose boxes are seen there.
//!
//! *Guarantee.* What comes out is what [`Projection::build`] makes of the new mesh, to the bit. So everything is built anew where
//! the cube or the bounds on errors change (the scene's extent did, or its farthest corner), where memory has made tree or
//! maps coarser, and, face by face, where the number of leaves asks for other tiles; maps of the source's modes too.
//!
//! *Cost.* O(triangles) comparisons and O(leaves + numbers) copies, about a tenth of a build; the rest as building what was touched.

use std::sync::Arc;

use glam::DVec3;
use umbriel_geometry::Mesh;

use super::{
    Layout, Numbering, Projection, ProjectionDefect, Section,
    budget::Budget,
    build::{Scaffold, cell_box},
    footprint::Footprint,
    map::{Changes, Map, Plan},
    tasks,
    tree::{Grower, LEAF, Link, NOTHING, Part, Tree, held, number},
};
use crate::morton::Octant;

/// What [`Projection::renewed`] made anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Renewal {
    /// Whether everything was built anew, as the octree's cube or the bounds on errors had changed.
    pub is_whole: bool,
    /// Triangles that were moved, added or taken away.
    pub moved: usize,
    /// Leaves that were made anew, of those in the [report](Projection::report).
    pub leaves: usize,
    /// Cells of maps in tiles that were filled anew.
    pub cells: usize,
}

/// Packs a task looks at.
const CHUNK: usize = 1 << 12;

/// Where a new leaf comes from: the number that it had; `None` for one made anew.
pub(super) type Origins = [Option<u32>];

impl Projection {
    /// The projection of a mesh that differs from this one's in some triangles: what [`Projection::build`] makes of it with this one's viewpoint
    /// and options, to the bit, but only what the triangles that differ touch, or touched, is made anew. Triangles are the same where
    /// their numbers and their corners' positions are.
    ///
    /// # Errors
    /// [`ProjectionDefect`].
    pub fn renewed(&self, mesh: Arc<Mesh>) -> Result<(Self, Renewal), ProjectionDefect> {
        let moved = differences(&self.mesh, &mesh);
        let count = moved.iter().filter(|&&is_moved| is_moved).count();
        match self.renewed_in_part(&mesh, &moved)? {
            Some((projection, renewal)) => Ok((projection, Renewal { moved: count, ..renewal })),
            None => {
                let projection = Self::build(mesh, self.viewpoint, &self.options)?;
                let (leaves, cells) = (projection.report.leaves, projection.report.cells);
                Ok((projection, Renewal { is_whole: true, moved: count, leaves, cells }))
            }
        }
    }

    /// `None` where everything has to be built anew.
    fn renewed_in_part(&self, mesh: &Arc<Mesh>, moved: &[bool]) -> Result<Option<(Self, Renewal)>, ProjectionDefect> {
        let scaffold = Scaffold::new(mesh, &self.viewpoint, &self.options)?;
        let is_same = scaffold.frame == self.frame && scaffold.root == self.root && scaffold.error == self.error;
        if !is_same || self.report.is_coarsened {
            return Ok(None);
        }
        let former = Former { projection: self, moved };
        let (tree, origins) = former.regrown(&scaffold);
        if !scaffold.is_within_memory(&tree) {
            return Ok(None);
        }
        let (leaves, packs) = scaffold.leaves(&tree, Some((self, &origins)));
        let tree_bytes = super::build::tree_bytes(&tree, &leaves, &packs);
        let mut cells = 0;
        let faces = std::array::from_fn(|face| former.sections(&scaffold, &tree, &origins, face, &mut cells));
        let made = origins.iter().filter(|origin| origin.is_none()).count();
        let renewed = scaffold.finished(Arc::clone(mesh), self.viewpoint, tree, leaves, packs, faces);
        let is_within = tree_bytes + renewed.report.map_bytes <= self.options.memory;
        Ok(is_within.then_some((renewed, Renewal { is_whole: false, moved: 0, leaves: made, cells })))
    }
}

/// By triangle, whether it is not the same in both meshes.
fn differences(old: &Mesh, new: &Mesh) -> Vec<bool> {
    let corners = |mesh: &Mesh, triangle: usize| {
        mesh.triangles().get(triangle).map(|corners| corners.map(|corner| mesh.positions()[corner as usize]))
    };
    let count = old.triangles().len().max(new.triangles().len());
    (0..count).map(|triangle| corners(old, triangle) != corners(new, triangle)).collect()
}

/// What was there before.
struct Former<'a> {
    projection: &'a Projection,
    moved: &'a [bool],
}

/// A cell on the way down beside the old tree.
struct Beside {
    cell: Octant,
    /// All triangles that meet it now.
    items: Vec<u32>,
    /// The moved ones that met it before.
    before: Vec<u32>,
    /// What the cell was.
    link: Link,
}

impl Former<'_> {
    /// The new tree, and where its leaves come from.
    fn regrown(&self, scaffold: &Scaffold) -> (Tree, Vec<Option<u32>>) {
        let old = self.projection;
        let (root, mesh) = (&old.root, &old.mesh);
        let unit = scaffold.unit_corners();
        let former: Vec<DVec3> = if self.moved.contains(&true) { old.unit_corners() } else { Vec::new() };
        let now = scaffold.grower(&unit);
        let then = Grower { root, corners: &former, triangles: mesh.triangles(), ..now };
        let (all, was) = (now.triangles.len() as u32, mesh.triangles().len() as u32);
        let before = (0..was).filter(|&item| self.moved[item as usize]).collect();
        let top = Beside { cell: Octant::ROOT, items: (0..all).collect(), before, link: old.tree.root };
        let mut growth =
            Growth { now, then, old: &old.tree, moved: self.moved, tree: Tree::default(), origins: Vec::new() };
        growth.tree.root = growth.regrow(top);
        (growth.tree, growth.origins)
    }

    /// The maps of a face, and in `cells` how many of their cells are new.
    fn sections(
        &self,
        scaffold: &Scaffold,
        tree: &Tree,
        origins: &Origins,
        face: usize,
        cells: &mut usize,
    ) -> Vec<Section> {
        let options = &self.projection.options;
        // What was within its memory before is about as large now, and looked at again in the end.
        let budget = Budget::unlimited();
        let plan = scaffold.plan(&budget);
        let is_plain = options.layout == Layout::OneMap && options.numbering == Numbering::FrontToBack;
        let renewed = self.projection.faces[face].first().filter(|_| is_plain).and_then(|section| {
            let (map, made) =
                self.map(&section.map, scaffold, [tree, &self.projection.tree], origins, (face, &plan))?;
            *cells += made;
            Some(vec![Section { near: section.near, map }])
        });
        renewed.unwrap_or_else(|| {
            let sections = scaffold.sections(tree, face, &plan);
            *cells += sections.iter().map(|section| section.map.len()[0]).sum::<usize>();
            sections
        })
    }

    /// A map with the new leaves, and how many cells were filled; `None` where it needs other tiles. `trees`: new, old.
    fn map(
        &self,
        map: &Map,
        scaffold: &Scaffold,
        [tree, former]: [&Tree; 2],
        origins: &Origins,
        (face, plan): (usize, &Plan),
    ) -> Option<(Map, usize)> {
        let old = self.projection;
        let (parts, were) = (tree.parts(), former.parts());
        let mut numbers = vec![NOTHING; were.len()];
        let mut next = 0;
        for of_leaf in parts.chunk_by(|a, b| a.leaf == b.leaf) {
            let count = of_leaf.len() as u32;
            if let Some(origin) = origins[of_leaf[0].leaf as usize] {
                let first = old.leaves[origin as usize].first_pack;
                (0..count).for_each(|place| numbers[(first + place) as usize] = next + place);
            }
            next += count;
        }
        let seen = |packs: Vec<u32>, footprint: &(dyn Fn(u32) -> Option<Footprint> + Sync)| {
            tasks::joined(tasks::map(packs.chunks(CHUNK).collect(), |packs| {
                packs.iter().filter_map(|&pack| Some((pack, footprint(pack)?))).collect::<Vec<_>>()
            }))
        };
        let gone = (0..).zip(&numbers).filter(|(_, number)| **number == NOTHING).map(|(pack, _)| pack).collect();
        let made = (0..).zip(&parts).filter(|(_, part)| origins[part.leaf as usize].is_none()).map(|(pack, _)| pack);
        let gone = seen(gone, &|pack| old.former_footprint(face, &were[pack as usize]));
        let made = seen(made.collect(), &|pack| scaffold.seen(tree, face, &parts[pack as usize]));
        let changes = Changes { numbers: &numbers, gone: &gone, made: &made };
        let touched = map.touched(&changes, plan)?;
        let near = seen((0..parts.len() as u32).collect(), &|pack| {
            let part = &parts[pack as usize];
            let (min, max) = cell_box(&old.root, tree.cells[part.leaf as usize]);
            let cell = Footprint::new(scaffold.frame.kind, face, min, max)?;
            map.meets_any(&cell, &touched).then(|| scaffold.seen(tree, face, part)).flatten()
        });
        Some(map.renewed(&changes, &near, &touched, plan))
    }
}

impl Projection {
    /// Corners in the cube's coordinates.
    fn unit_corners(&self) -> Vec<DVec3> {
        let unit = |&x: &DVec3| (self.frame.local(x) - self.root.min) / self.root.edge;
        self.mesh.positions().iter().map(unit).collect()
    }

    /// What a face sees of a pack, if anything.
    fn former_footprint(&self, face: usize, part: &Part) -> Option<Footprint> {
        let triangle = |item: u32| self.corners(item).map(|corner| self.frame.local(corner));
        let cell = self.tree.cells[part.leaf as usize];
        super::build::seen(&self.root, self.frame.kind, face, cell, self.tree.items_of(part), &triangle)
    }
}

/// A tree that is grown beside an old one.
struct Growth<'a> {
    now: Grower<'a>,
    /// The same with the old corners.
    then: Grower<'a>,
    old: &'a Tree,
    moved: &'a [bool],
    tree: Tree,
    origins: Vec<Option<u32>>,
}

impl Growth<'_> {
    /// Puts what a cell becomes at the end of the tree.
    fn regrow(&mut self, Beside { cell, items, before, link }: Beside) -> Link {
        let is_node = link != NOTHING && link & LEAF == 0;
        if !is_node {
            return self.grow(cell, items);
        }
        let (mut met, mut met_before) = (Vec::new(), Vec::new());
        if !self.now.split(cell, &items, &mut met) {
            return self.grow(cell, items);
        }
        self.then.children_met(cell, &before, &mut met_before);
        let node = self.tree.nodes.len();
        self.tree.nodes.push([NOTHING; 8]);
        for child in self.now.front_to_back(cell) {
            let link = self.old.nodes[link as usize][number(child)];
            let before = held(child, &before, &met_before);
            let items = held(child, &items, &met);
            let is_untouched = before.is_empty() && !items.iter().any(|&item| self.moved[item as usize]);
            self.tree.nodes[node][number(child)] = if is_untouched {
                self.keep(child, link)
            } else {
                self.regrow(Beside { cell: child, items, before, link })
            };
        }
        node as Link
    }

    /// A part that is divided from scratch.
    fn grow(&mut self, cell: Octant, items: Vec<u32>) -> Link {
        if items.is_empty() {
            return NOTHING;
        }
        let part = self.now.subtree(cell, items);
        self.origins.resize(self.origins.len() + part.cells.len(), None);
        self.tree.append(part)
    }

    /// A part that stays as it was.
    fn keep(&mut self, cell: Octant, link: Link) -> Link {
        if link == NOTHING {
            return NOTHING;
        }
        if link & LEAF != 0 {
            let leaf = link & !LEAF;
            self.origins.push(Some(leaf));
            return self.tree.push_leaf(cell, self.old.items(leaf as usize));
        }
        let node = self.tree.nodes.len();
        self.tree.nodes.push([NOTHING; 8]);
        for child in self.now.front_to_back(cell) {
            self.tree.nodes[node][number(child)] = self.keep(child, self.old.nodes[link as usize][number(child)]);
        }
        node as Link
    }
}
