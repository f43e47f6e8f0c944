//! Do the numbers of leaves grow along a ray? What the order of a run gets wrong, counted; and where leaves end, for rays that
//! are to run along their borders.

use glam::DVec3;

use super::{
    Leaf, Projection,
    frame::{Kind, Sight},
    pack::MAX_SPREAD,
};

impl Projection {
    /// How many leaves the ray from the viewpoint to `x` enters later than one that its run lists behind them, on the maps that
    /// hold all leaves: zero along every ray for [`Numbering::FrontToBack`](super::Numbering::FrontToBack). Leaves that the ray
    /// only touches do not count. For looking at numberings; O(packs of the run).
    pub fn disorder(&self, x: DVec3) -> usize {
        let sight = self.frame.sight_to(x, 0.0);
        let is_seen = sight.spread <= MAX_SPREAD && sight.is_within_maps();
        let Some(section) = self.faces[sight.face].first().filter(|_| is_seen) else { return 0 };
        let run = section.map.run_at(sight.place(), sight.spread).unwrap_or_default();
        let mut leaves: Vec<u32> = run.iter().map(|&pack| self.owners[pack as usize]).collect();
        leaves.dedup();
        let mut latest = f64::NEG_INFINITY;
        let entries = leaves.into_iter().filter_map(|leaf| self.entry(&self.leaves[leaf as usize], &sight));
        entries
            .filter(|&enter| {
                let is_late = enter < latest;
                latest = latest.max(enter);
                is_late
            })
            .count()
    }

    /// A corner of a leaf's cell in world coordinates, rounded: where rays meet the borders of projections. Bit k of `corner` is
    /// its side on the octree's axis k. `None` where there is no such leaf.
    pub fn leaf_corner(&self, leaf: usize, corner: u8) -> Option<DVec3> {
        let leaf = self.leaves.get(leaf)?;
        let side = DVec3::from_array(std::array::from_fn(|axis| f64::from(corner >> axis & 1)));
        let unit = DVec3::from_array(leaf.min.map(f64::from)) + side * f64::from(leaf.edge);
        Some(self.frame.world(self.root.min + unit * self.root.edge))
    }

    /// The depth at which a ray enters a leaf, where it stays for longer than the slack.
    fn entry(&self, leaf: &Leaf, sight: &Sight) -> Option<f64> {
        let min = self.root.min + DVec3::from_array(leaf.min.map(f64::from)) * self.root.edge;
        let max = min + f64::from(leaf.edge) * self.root.edge;
        let (start, along) = match self.frame.kind {
            Kind::Parallel => (sight.direction.with_z(0.0), DVec3::Z),
            _ => (DVec3::ZERO, sight.direction),
        };
        let (mut enter, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            if along[axis] == 0.0 {
                let is_inside = (min[axis]..=max[axis]).contains(&start[axis]);
                (enter, exit) = if is_inside { (enter, exit) } else { (0.0, -1.0) };
                continue;
            }
            let ends = [(min[axis] - start[axis]) / along[axis], (max[axis] - start[axis]) / along[axis]];
            (enter, exit) = (enter.max(ends[0].min(ends[1])), exit.min(ends[0].max(ends[1])));
        }
        let is_met = exit - enter.max(0.0) > 4.0 * self.root.slack;
        (is_met && (exit > 0.0 || self.frame.kind == Kind::Parallel)).then_some(enter)
    }
}
