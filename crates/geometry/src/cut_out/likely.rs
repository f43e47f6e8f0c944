//! What a cut-out most likely is at a point, in plain floats: for estimates, which prove nothing.
//!
//! As [`FaceCutOut::is_opaque_on`] without its bounds, which take ten times as long. Sums of three do not depend on the corner that is counted first. Cost: some 20 ns.

use glam::DVec3;

use super::{AlphaMap, CutOut, FaceCutOut, Filter, greatest, least};
use crate::predicates::symmetric_sum;

impl FaceCutOut<'_> {
    /// Whether the point that a way meets is opaque, as far as floats tell: by the way's weights at the corners, all of one sign.
    pub fn probably_opaque_on(&self, way: [f64; 3]) -> bool {
        let way = DVec3::from_array(way);
        let weight = symmetric_sum(way);
        let mean = |values: [f64; 3]| {
            let about = symmetric_sum(way * DVec3::from_array(values)) / weight;
            about.clamp(least(values), greatest(values))
        };
        let cut_out = self.cut_out;
        let texture = match &cut_out.map {
            None => f64::from(AlphaMap::ONE),
            Some(map) => {
                cut_out.likely_alpha(map, [0, 1].map(|axis| mean(self.corners.map(|corner| corner.place[axis]))))
            }
        };
        let alpha = cut_out.factor * mean(self.corners.map(|corner| corner.alpha)) * texture;
        // Edge-on nothing is a number, and what is met counts as opaque.
        let is_clear = alpha < cut_out.cutoff * f64::from(AlphaMap::ONE);
        !is_clear
    }
}

impl CutOut {
    /// The map's alpha at a place, 0 to [`AlphaMap::ONE`].
    fn likely_alpha(&self, map: &AlphaMap, place: [f64; 2]) -> f64 {
        let size = map.size();
        let shift = if self.filter == Filter::Linear { 0.5 } else { 0.0 };
        let texels = [0, 1].map(|axis| place[axis] * f64::from(size[axis]) - shift);
        let first = texels.map(floor);
        if self.filter == Filter::Nearest {
            return self.texel(map, first);
        }
        let [x, y] = [0, 1].map(|axis| texels[axis] - first[axis] as f64);
        let [above, below] = self.square(map, first).map(|[left, right]| left * (1.0 - x) + right * x);
        above * (1.0 - y) + below * y
    }
}

/// Without a call. Places are below 2^48 in size.
fn floor(x: f64) -> i64 {
    let whole = x as i64;
    whole - i64::from(x < whole as f64)
}
