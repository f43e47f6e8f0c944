//! From a mesh to maps, within the memory that is allowed.

use std::sync::Arc;

use glam::DVec3;
use umbriel_geometry::{LightSource, Mesh};

use super::{
    Layout, Leaf, Numbering, Projection, ProjectionDefect, ProjectionOptions, ProjectionReport, Section, Viewpoint,
    budget::Budget,
    footprint::Footprint,
    frame::{Frame, Kind},
    map::{MAX_FINENESS, Map, Plan},
    outline::Outline,
    pack::{Pack, WIDTH},
    renew::Origins,
    tasks,
    tree::{Grower, LEAF, Part, Root, SectionKey, Tree, by_sections, unit_cell},
};
use crate::morton::Octant;

/// Leaves that one task makes ready.
const CHUNK: usize = 1 << 10;

impl Projection {
    /// Builds octree and maps for the rays of a viewpoint.
    ///
    /// # Errors
    /// [`ProjectionDefect`].
    pub fn build(mesh: Arc<Mesh>, viewpoint: Viewpoint, options: &ProjectionOptions) -> Result<Self, ProjectionDefect> {
        if options.max_level > Octant::MAX_LEVEL {
            return Err(ProjectionDefect::TooDeep(options.max_level));
        }
        let mut scaffold = Scaffold::new(&mesh, &viewpoint, options)?;
        let (tree, leaves, packs) = scaffold.divided();
        let tree_bytes = tree_bytes(&tree, &leaves, &packs);
        let (faces, is_coarser) = scaffold.projected(&tree, tree_bytes);
        let is_coarsened = is_coarser || scaffold.options.max_level < options.max_level;
        let mut projection = scaffold.finished(Arc::clone(&mesh), viewpoint, tree, leaves, packs, faces);
        (projection.options, projection.report.is_coarsened) = (*options, is_coarsened);
        Ok(projection)
    }
}

/// Everything that is known before the tree.
pub(super) struct Scaffold<'a> {
    mesh: &'a Mesh,
    light: LightSource,
    pub(super) frame: Frame,
    pub(super) root: Root,
    /// Local.
    corners: Vec<DVec3>,
    /// Bound on their error.
    pub(super) error: f64,
    options: ProjectionOptions,
    /// For the tree that is grown.
    tree_budget: Budget,
}

impl<'a> Scaffold<'a> {
    pub(super) fn new(
        mesh: &'a Mesh,
        viewpoint: &Viewpoint,
        options: &ProjectionOptions,
    ) -> Result<Self, ProjectionDefect> {
        if mesh.triangles().len() >= LEAF as usize {
            return Err(ProjectionDefect::TooMany);
        }
        let light = viewpoint.light().ok_or(ProjectionDefect::NoView)?;
        let frame = Frame::new(viewpoint, mesh)?;
        let corners: Vec<DVec3> = mesh.positions().iter().map(|&x| frame.local(x)).collect();
        let error = mesh.positions().iter().map(|&x| frame.error_at(x)).fold(0.0, f64::max);
        let eye = (frame.kind != Kind::Parallel).then_some(DVec3::ZERO);
        let root = Root::around(&corners, error, eye);
        Ok(Self { mesh, light, frame, root, corners, error, options: *options, tree_budget: Budget::unlimited() })
    }

    /// With everything that was built.
    pub(super) fn finished(
        self,
        mesh: Arc<Mesh>,
        viewpoint: Viewpoint,
        tree: Tree,
        leaves: Vec<Leaf>,
        packs: Vec<Pack>,
        faces: [Vec<Section>; 6],
    ) -> Projection {
        let report = report(&tree, tree_bytes(&tree, &leaves, &packs), &faces);
        let Self { light, frame, root, error, options, .. } = self;
        let owners = (0..).zip(&leaves).flat_map(|(leaf, Leaf { packs, .. })| (0..*packs).map(move |_| leaf)).collect();
        Projection { mesh, viewpoint, light, options, frame, error, root, tree, leaves, packs, owners, faces, report }
    }

    /// Corners in the cube's coordinates.
    pub(super) fn unit_corners(&self) -> Vec<DVec3> {
        self.corners.iter().map(|&p| (p - self.root.min) / self.root.edge).collect()
    }

    /// What divides the cube, from corners in its coordinates.
    pub(super) fn grower<'b>(&'b self, unit: &'b [DVec3]) -> Grower<'b> {
        Grower {
            root: &self.root,
            corners: unit,
            triangles: self.mesh.triangles(),
            max_level: self.options.max_level,
            leaf_items: self.options.leaf_items,
            budget: &self.tree_budget,
        }
    }

    /// Whether a tree takes no more than half of what is allowed: maps take about as much again at most.
    pub(super) fn is_within_memory(&self, tree: &Tree) -> bool {
        let packs: usize = (0..tree.cells.len()).map(|leaf| tree.items(leaf).len().div_ceil(WIDTH)).sum();
        packs * size_of::<Pack>() + size_of_val(&*tree.nodes) <= self.options.memory / 2
    }

    /// How maps are made at their finest.
    pub(super) fn plan<'b>(&self, budget: &'b Budget) -> Plan<'b> {
        Plan {
            rays: self.options.rays as f64 / self.frame.kind.faces().len() as f64,
            max_fineness: MAX_FINENESS,
            max_side: 1 << 16,
            budget,
        }
    }

    /// The tree with its leaves made ready: the deepest whose bytes are allowed, up to the level asked for.
    fn divided(&mut self) -> (Tree, Vec<Leaf>, Vec<Pack>) {
        let unit = self.unit_corners();
        loop {
            self.tree_budget = Budget::new(self.options.memory / 2);
            let tree = self.grower(&unit).grow();
            // A tree of one cell is the least there is.
            if self.is_within_memory(&tree) || self.options.max_level == 0 {
                let (leaves, packs) = self.leaves(&tree, None);
                return (tree, leaves, packs);
            }
            // What a tree that was broken off looks like depends on the order of threads.
            let depth = if self.tree_budget.is_over() { self.options.max_level } else { tree.depth() };
            self.options.max_level = depth.saturating_sub(1).min(self.options.max_level - 1);
        }
    }

    /// The leaves made ready; those that come from a former projection as they are there.
    pub(super) fn leaves(&self, tree: &Tree, former: Option<(&Projection, &Origins)>) -> (Vec<Leaf>, Vec<Pack>) {
        let starts: Vec<usize> = (0..tree.cells.len()).step_by(CHUNK).collect();
        let parts = tasks::map(starts, |start| {
            let range = start..(start + CHUNK).min(tree.cells.len());
            let count = range.clone().map(|leaf| tree.items(leaf).len().div_ceil(WIDTH)).sum();
            let mut packs = Vec::with_capacity(count);
            for leaf in range {
                match former.and_then(|(old, origins)| Some((old, origins[leaf]?))) {
                    Some((old, origin)) => packs.extend_from_slice(old.leaves[origin as usize].packs_of(&old.packs)),
                    None => packs.extend(tree.items(leaf).chunks(WIDTH).map(|items| self.pack(items))),
                }
            }
            packs
        });
        let (mut leaves, mut first_pack) = (Vec::with_capacity(tree.cells.len()), 0);
        for (leaf, &cell) in tree.cells.iter().enumerate() {
            let (min, edge) = unit_cell(cell);
            let packs = tree.items(leaf).len().div_ceil(WIDTH) as u32;
            leaves.push(Leaf { min, edge, first_pack, packs });
            first_pack += packs;
        }
        (leaves, tasks::joined(parts))
    }

    fn pack(&self, items: &[u32]) -> Pack {
        Pack::new(items.iter().map(|&item| (item, self.triangle(item))), self.error, self.frame.kind)
    }

    /// The maps of all faces, the finest that the memory left allows, and whether that made them coarser.
    fn projected(&self, tree: &Tree, tree_bytes: usize) -> ([Vec<Section>; 6], bool) {
        let Plan { mut max_fineness, mut max_side, .. } = self.plan(&Budget::unlimited());
        let mut is_coarser = false;
        loop {
            let budget = Budget::new(self.options.memory.saturating_sub(tree_bytes));
            let plan = Plan { max_fineness, max_side, ..self.plan(&budget) };
            let faces: [Vec<Section>; 6] = std::array::from_fn(|face| self.sections(tree, face, &plan));
            let maps = faces.iter().flatten();
            let bytes: usize = maps.clone().map(|section| section.map.bytes()).sum();
            let side = maps.map(|section| section.map.side()).max().unwrap_or(1);
            let is_least = max_fineness == 0 && side == 1;
            if !budget.is_over() && bytes + tree_bytes <= self.options.memory || is_least {
                let is_coarser = is_coarser || faces.iter().flatten().any(|section| section.map.is_coarser());
                return (faces, is_coarser);
            }
            is_coarser = true;
            match max_fineness {
                0 => max_side = side / 2,
                _ => max_fineness -= 1,
            }
        }
    }

    pub(super) fn sections(&self, tree: &Tree, face: usize, plan: &Plan) -> Vec<Section> {
        if !self.frame.kind.faces().contains(&face) {
            return Vec::new();
        }
        let parts: Vec<(u32, Part)> = (0..).zip(tree.parts()).collect();
        let seen = tasks::map(parts.chunks(CHUNK).collect(), |parts| {
            let seen = |(number, part): &(u32, Part)| Some((*number, self.seen(tree, face, part)?));
            parts.iter().filter_map(seen).collect::<Vec<_>>()
        });
        let mut packs = tasks::joined(seen);
        if self.options.layout == Layout::MapPerSection || self.options.numbering == Numbering::Sections {
            packs.sort_by(|a, b| by_sections(&key(a, tree, &parts), &key(b, tree, &parts)));
        }
        match self.options.layout {
            Layout::OneMap => vec![Section { near: f64::NEG_INFINITY, map: Map::new(&packs, plan) }],
            Layout::MapPerSection => {
                let sections = packs.chunk_by(|(_, a), (_, b)| a.depth[0] == b.depth[0]);
                sections.map(|packs| Section { near: packs[0].1.depth[0], map: Map::new(packs, plan) }).collect()
            }
        }
    }

    /// What a face sees of a pack, if anything.
    pub(super) fn seen(&self, tree: &Tree, face: usize, part: &Part) -> Option<Footprint> {
        let cell = tree.cells[part.leaf as usize];
        seen(&self.root, self.frame.kind, face, cell, tree.items_of(part), &|item| self.triangle(item))
    }

    /// Local corners.
    fn triangle(&self, item: u32) -> [DVec3; 3] {
        let [a, b, c] = self.mesh.triangles()[item as usize];
        [self.corners[a as usize], self.corners[b as usize], self.corners[c as usize]]
    }
}

/// What a face sees of triangles in a cell, if anything; `corners` tells the triangles' local corners.
pub(super) fn seen(
    root: &Root,
    kind: Kind,
    face: usize,
    cell: Octant,
    items: &[u32],
    corners: &dyn Fn(u32) -> [DVec3; 3],
) -> Option<Footprint> {
    let (min, max) = cell_box(root, cell);
    let footprint = Footprint::new(kind, face, min, max)?;
    footprint.reach()?;
    let outline = Outline::new(kind, face, root.slack, items.iter().map(|&item| corners(item)));
    let footprint = footprint.showing(outline);
    footprint.reach().is_some().then_some(footprint)
}

/// A cell with its slack, local coordinates.
pub(super) fn cell_box(root: &Root, cell: Octant) -> (DVec3, DVec3) {
    let (min, edge) = unit_cell(cell);
    let min = root.min + DVec3::from_array(min.map(f64::from)) * root.edge;
    (min - root.slack, min + f64::from(edge) * root.edge + root.slack)
}

fn key((number, footprint): &(u32, Footprint), tree: &Tree, parts: &[(u32, Part)]) -> SectionKey {
    let level = tree.cells[parts[*number as usize].1.leaf as usize].level();
    SectionKey { near: footprint.depth[0], aside: footprint.aside(), level, pack: *number }
}

pub(super) fn tree_bytes(tree: &Tree, leaves: &[Leaf], packs: &[Pack]) -> usize {
    size_of_val(&*tree.nodes)
        + size_of_val(&*tree.cells)
        + size_of_val(&*tree.ends)
        + size_of_val(&*tree.triangles)
        + size_of_val(leaves)
        + packs.len() * (size_of::<Pack>() + size_of::<u32>())
}

fn report(tree: &Tree, tree_bytes: usize, faces: &[Vec<Section>; 6]) -> ProjectionReport {
    let maps = || faces.iter().flatten().map(|section| &section.map);
    let [cells, numbers] = [0, 1].map(|which| maps().map(|map| map.len()[which]).sum());
    ProjectionReport {
        depth: tree.depth(),
        leaves: tree.cells.len(),
        items: tree.triangles.len(),
        maps: maps().count(),
        cells,
        numbers,
        tree_bytes,
        map_bytes: maps().map(Map::bytes).sum(),
        is_coarsened: false,
    }
}
