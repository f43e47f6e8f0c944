//! Values that attributes may have (glTF 2.0, 3.7.2.1): directions have length 1, the handedness of a tangent is 1 or −1, and colours
//! and weights lie between 0 and 1.

use std::collections::BTreeMap;

use umbriel_scene::{Finding, FindingKind};

use super::Plain;
use crate::{
    gltf::{
        accessor::{Accessors, Component},
        json::{Document, Primitive},
    },
    model::Findings,
};

/// How far the length of a direction may be off 1 where nothing quantised it: as far as processors' own estimate of 1/√x is off, which
/// fast exporters divide by (1.5 · 2^-12 of it at most). Four written decimals are off by a quarter of that.
const LENGTH_OFF: f64 = 1.5 / 4096.0;

/// What has to hold for the elements of an accessor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    Normal,
    Tangent,
    Color,
    Weights,
}

impl Rule {
    fn of(attribute: &str) -> Option<Self> {
        match attribute {
            "NORMAL" => Some(Self::Normal),
            "TANGENT" => Some(Self::Tangent),
            _ if attribute.starts_with("COLOR_") => Some(Self::Color),
            _ if attribute.starts_with("WEIGHTS_") => Some(Self::Weights),
            _ => None,
        }
    }

    /// The types that it speaks of; others are told elsewhere, and normalised numbers without a sign are shares anyway.
    fn is_for(self, kind: &str, component: Component, normalized: bool) -> bool {
        let is_float = component == Component::F32 && !normalized;
        let is_small = matches!(component, Component::I8 | Component::I16) && normalized;
        match self {
            Self::Normal => kind == "VEC3" && (is_float || is_small),
            Self::Tangent => kind == "VEC4" && (is_float || is_small),
            Self::Color => is_float && matches!(kind, "VEC3" | "VEC4"),
            Self::Weights => is_float && kind == "VEC4",
        }
    }
}

/// Looks at the attributes of all primitives, each accessor once. What is not finite is told elsewhere.
pub(super) fn check(document: &Document, accessors: &Accessors, left: &mut u64, findings: &mut Findings) {
    let primitives = document.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let plain = primitives.filter(|primitive| primitive.extensions.draco.is_none());
    let named = plain.flat_map(|primitive: &Primitive| primitive.attributes.iter());
    let mut rules = BTreeMap::new();
    for (rule, accessor) in named.filter_map(|(name, &accessor)| Some((Rule::of(name)?, accessor))) {
        rules.entry(accessor).or_insert(rule);
    }
    for (index, rule) in rules {
        let accessor = &document.accessors[index];
        let Ok(component) = Component::of(accessor.component_type) else { continue };
        if !rule.is_for(&accessor.kind, component, accessor.normalized) {
            continue;
        }
        let Some(plain) = Plain::of(document, accessors, index, left) else { continue };
        // Alphas that cut something out are brought between 0 and 1, and told so, where they are read.
        let read_alphas = rule == Rule::Color && accessors.is_read(index);
        let (mut lengths, mut others) = (Faults::default(), Faults::default());
        plain.for_each(|vertex, values| {
            let values = if read_alphas { &values[..3] } else { values };
            if values.iter().all(|value| value.is_finite()) {
                lengths.add_if(has_wrong_length(rule, values, component), vertex);
                others.add_if(has_wrong_value(rule, values), vertex);
            }
        });
        let what = match rule {
            Rule::Normal => "normals",
            Rule::Tangent => "tangents",
            Rule::Color => "colours",
            Rule::Weights => "weights",
        };
        lengths.tell(&format!("accessor {index}: {what} that are not of length 1"), findings);
        let range = if rule == Rule::Tangent { "whose w is neither 1 nor -1" } else { "that are not between 0 and 1" };
        others.tell(&format!("accessor {index}: {what} {range}"), findings);
    }
}

/// Whether a direction is not of length 1, as closely as its components can say it: whichever way each is rounded, the vector is off by
/// √3 steps at most, and so is its length.
fn has_wrong_length(rule: Rule, values: &[f64], component: Component) -> bool {
    let length = values[..3].iter().map(|value| value * value).sum::<f64>().sqrt();
    let slack = LENGTH_OFF + 3f64.sqrt() * component.step();
    matches!(rule, Rule::Normal | Rule::Tangent) && (length - 1.0).abs() > slack
}

fn has_wrong_value(rule: Rule, values: &[f64]) -> bool {
    match rule {
        Rule::Normal => false,
        Rule::Tangent => values[3].abs() != 1.0,
        Rule::Color | Rule::Weights => !values.iter().all(|value| (0.0..=1.0).contains(value)),
    }
}

/// Vertices at fault: how many, and the first ones.
#[derive(Default)]
struct Faults {
    count: usize,
    first: Vec<usize>,
}

impl Faults {
    fn add_if(&mut self, is_wrong: bool, vertex: usize) {
        if is_wrong {
            self.count += 1;
            if self.first.len() < Finding::PLACES {
                self.first.push(vertex);
            }
        }
    }

    fn tell(&self, subject: &str, findings: &mut Findings) {
        for vertex in &self.first {
            findings.add_at(FindingKind::BrokenRule, subject, format_args!("vertex {vertex}"));
        }
        findings.add(FindingKind::BrokenRule, subject, self.count - self.first.len());
    }
}
