//! The coarse step: which objects may shadow which, by their boxes.

use umbriel_bvh::may_shadow;
use umbriel_geometry::LightSource;

use crate::bodies::Bodies;

/// What the coarse step leaves for the fine step.
pub(crate) struct Influences {
    /// For each asked receiver, the objects that may shadow it, itself included; sorted.
    pub(crate) occluders_of: Vec<Vec<u32>>,
    pub(crate) tested: u64,
    pub(crate) registered: u64,
    pub(crate) excluded: u64,
}

/// Tests every pair of an object and an asked receiver.
pub(crate) fn coarse_step(bodies: &Bodies, receivers: &[usize], light: &LightSource) -> Influences {
    let mut influences = Influences { occluders_of: Vec::new(), tested: 0, registered: 0, excluded: 0 };
    for &receiver in receivers {
        let mut occluders = Vec::new();
        for (object, bounds) in bodies.boxes.iter().enumerate() {
            influences.tested += 1;
            if object == receiver || may_shadow(bounds, &bodies.boxes[receiver], light) {
                occluders.push(object as u32);
            }
        }
        influences.registered += occluders.len() as u64;
        influences.occluders_of.push(occluders);
    }
    influences
}
