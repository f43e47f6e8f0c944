//! The least and greatest components that accessors declare (glTF 2.0, 3.6.2.5). Those of positions and of indices are looked at where these are read.

use std::collections::HashSet;

use umbriel_scene::FindingKind;

use super::Plain;
use crate::{
    gltf::{
        accessor::Accessors,
        json::{Accessor, Document},
    },
    model::Findings,
    triangulate::SIX_DIGITS,
};

/// Looks at all accessors that declare something, of which all elements are plain and at hand.
pub(super) fn check(document: &Document, accessors: &Accessors, left: &mut u64, findings: &mut Findings) {
    let elsewhere = looked_at_elsewhere(document);
    for (index, accessor) in document.accessors.iter().enumerate() {
        let is_vector = matches!(accessor.kind.as_str(), "SCALAR" | "VEC2" | "VEC3" | "VEC4");
        let says_nothing = accessor.min.is_none() && accessor.max.is_none();
        // Without a view the elements may be within a compressed primitive.
        if says_nothing || !is_vector || accessor.buffer_view.is_none() || elsewhere.contains(&index) {
            continue;
        }
        let Some(plain) = Plain::of(document, accessors, index, left) else { continue };
        let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
        let mut is_finite = true;
        plain.stored().for_each(|_, values| {
            for (place, &value) in values.iter().enumerate() {
                (low[place], high[place]) = (low[place].min(value), high[place].max(value));
                is_finite &= value.is_finite();
            }
        });
        // What is not finite is told already.
        if is_finite && accessor.count > 0 && !declares(accessor, &low, &high) {
            let subject = format!("accessor {index}: its min and max are not those of its elements");
            findings.add(FindingKind::BrokenRule, &subject, 1);
        }
    }
}

/// Accessors of positions and of indices.
fn looked_at_elsewhere(document: &Document) -> HashSet<usize> {
    let mut accessors = HashSet::new();
    for primitive in document.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let lists = primitive.targets.iter().chain([&primitive.attributes]);
        accessors.extend(lists.filter_map(|list| list.get("POSITION")));
        accessors.extend(primitive.indices);
    }
    accessors
}

/// Whether an accessor declares these components, or nothing of them: six written digits are as good as all.
fn declares(accessor: &Accessor, low: &[f64], high: &[f64]) -> bool {
    let largest =
        low.iter().chain(high).filter(|value| value.is_finite()).fold(0.0, |most: f64, value| most.max(value.abs()));
    let are_near = |said: &Option<Vec<f64>>, found: &[f64]| {
        let said = said.as_deref().unwrap_or_default();
        said.iter().zip(found).all(|(said, found)| !found.is_finite() || (said - found).abs() <= SIX_DIGITS * largest)
    };
    are_near(&accessor.min, low) && are_near(&accessor.max, high)
}
