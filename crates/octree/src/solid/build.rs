//! Building a solid's octree: the cells that the surface meets, then the sides of the rest.

use umbriel_geometry::{Region, Relation};

use super::SolidOctree;
use crate::{cube::Cube, direction::Direction, linear::BuildDefect, morton::Octant, partition::Partition};

/// A cell to be halved and the parts of the surface that meet it.
type Open = (Octant, Vec<u32>);

pub(super) fn build_in<R: Region + ?Sized>(cube: Cube, region: &R, depth: u8) -> Result<SolidOctree, BuildDefect> {
    if depth > Octant::MAX_LEVEL {
        return Err(BuildDefect::TooDeep(depth));
    }
    if !cube.has_float_planes(depth) {
        return Err(BuildDefect::Lattice(depth));
    }
    let (partition, is_met) = divide(cube, region, depth);
    let relations = sides(&partition, &is_met, region);
    Ok(SolidOctree { partition, relations })
}

/// The leaves, and which of them the surface meets.
fn divide<R: Region + ?Sized>(cube: Cube, region: &R, depth: u8) -> (Partition, Vec<bool>) {
    let meets = |cell: Octant| {
        let bounds = cube.bounds_of(cell);
        move |part: &u32| region.meets(*part, &bounds)
    };
    let (mut cells, mut is_met) = (Vec::new(), Vec::new());
    let mut open: Vec<Open> = vec![(Octant::ROOT, (0..region.parts()).filter(meets(Octant::ROOT)).collect())];
    while let Some((cell, parts)) = open.pop() {
        if parts.is_empty() || cell.level() == depth {
            cells.push(cell);
            is_met.push(!parts.is_empty());
        } else if cell.level() + 1 == depth {
            // Which parts meet a leaf is of no interest, only whether one does.
            for child in cell.children() {
                cells.push(child);
                is_met.push(parts.iter().any(meets(child)));
            }
        } else {
            // The first child ends on top, so leaves come in Morton order.
            open.extend(cell.children().rev().map(|child| {
                let met = parts.iter().copied().filter(meets(child)).collect();
                (child, met)
            }));
        }
    }
    (Partition::of_leaves(cube, cells), is_met)
}

/// What each leaf says: one question for each connected set of leaves off the surface.
fn sides<R: Region + ?Sized>(partition: &Partition, is_met: &[bool], region: &R) -> Vec<Relation> {
    let mut set = connected(partition, is_met);
    let mut relations = vec![Relation::Boundary; is_met.len()];
    for leaf in (0..is_met.len()).filter(|&leaf| !is_met[leaf]) {
        let root = root_of(&mut set, leaf);
        // Roots are the least of their sets, so they are asked first.
        relations[leaf] = if root < leaf {
            relations[root]
        } else if region.encloses(partition.cube().bounds_of(partition.cells()[leaf]).min) {
            Relation::Inside
        } else {
            Relation::Outside
        };
    }
    relations
}

/// Joins the leaves off the surface that share a face: a forest of disjoint sets, roots least.
fn connected(partition: &Partition, is_met: &[bool]) -> Vec<usize> {
    let cells = partition.cells();
    let mut set = Vec::from_iter(0..cells.len());
    for leaf in (0..cells.len()).filter(|&leaf| !is_met[leaf]) {
        // A common face is seen from the finer leaf, whose neighbour lies in the coarser one.
        for beside in Direction::FACES.iter().filter_map(|&direction| cells[leaf].neighbour(direction)) {
            let other = partition.first_leaf(beside);
            if !is_met[other] && cells[other].level() <= cells[leaf].level() {
                let (a, b) = (root_of(&mut set, leaf), root_of(&mut set, other));
                set[a.max(b)] = a.min(b);
            }
        }
    }
    set
}

/// The root of a leaf's set, halving the way to it.
fn root_of(set: &mut [usize], mut leaf: usize) -> usize {
    while set[leaf] != leaf {
        set[leaf] = set[set[leaf]];
        leaf = set[leaf];
    }
    leaf
}
