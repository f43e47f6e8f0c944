//! Scenes drawn by chance, and what is proved of their cells against exact answers.

use umbriel_scene::Scene;
use umbriel_shadow::{Place, Queries, Report, Verdict};

/// Numbers between 0 and 1: the top bits of a linear congruential generator, with Knuth's constants.
#[allow(dead_code, reason = "not all tests draw scenes by chance")]
pub(crate) fn dice() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1u32 << 24)
    }
}

/// Exact answers at some points of every n-th stored cell, which must be what is proved of it; how many cells have each verdict.
pub(crate) fn judged(scene: &Scene, report: &Report, step: usize) -> [usize; 3] {
    let (queries, light) = (Queries::new(scene), &scene.lights[0].source);
    let mut counts = [0; 3];
    for receiver in &report.lights[0].objects {
        for cell in receiver.cells.iter().step_by(step) {
            let is_lit = |place: [f64; 2]| {
                let [u, v] = cell.point(place);
                let place = Place::Surface { object: receiver.object, face: cell.face as usize, u, v };
                queries.lit(&place, light).expect("a place on a face").lit
            };
            let mut inside = [[0.125, 0.125], [0.125, 0.75], [0.75, 0.125], [0.375, 0.375]].into_iter();
            let is_right = match cell.verdict {
                Verdict::Lit => inside.all(is_lit),
                Verdict::Shadowed => !inside.any(is_lit),
                Verdict::Undecided => true,
            };
            assert!(is_right, "object {}: {cell:?}", receiver.object);
            counts[cell.verdict as usize] += 1;
        }
    }
    counts
}
