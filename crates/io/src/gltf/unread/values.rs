//! Values that attributes may have (glTF 2.0, 3.7.2.1): directions have length 1, the handedness of a tangent is 1 or −1, and colours
//! and weights lie between 0 and 1. Rotations of animations and instances are of length 1, too.

use std::collections::BTreeSet;

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Rule {
    Normal,
    Tangent,
    Color,
    Weights,
    Rotation,
    /// Every third value alone, between two tangents.
    CubicRotation,
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
            Self::Rotation | Self::CubicRotation => kind == "VEC4" && (is_float || normalized),
        }
    }

    /// Whether it speaks of the element of that number.
    fn is_for_element(self, number: usize) -> bool {
        self != Self::CubicRotation || number % 3 == 1
    }

    /// What its elements are.
    fn name(self) -> &'static str {
        match self {
            Self::Normal => "normals",
            Self::Tangent => "tangents",
            Self::Color => "colours",
            Self::Weights => "weights",
            Self::Rotation | Self::CubicRotation => "rotations",
        }
    }

    /// What one of them is called.
    fn place(self) -> &'static str {
        if matches!(self, Self::Rotation | Self::CubicRotation) { "rotation" } else { "vertex" }
    }
}

/// Accessors of the rotations of animations and of instances.
fn rotations(document: &Document) -> impl Iterator<Item = (usize, Rule)> {
    let instances = document.nodes.iter().filter_map(|node| node.extensions().instancing.as_ref());
    let of_instances = instances.filter_map(|instances| Some((*instances.attributes.get("ROTATION")?, Rule::Rotation)));
    let of_animations = document.animations.iter().flat_map(|animation| {
        let turning = animation.channels.iter().filter(|channel| channel.target.path.as_deref() == Some("rotation"));
        turning.map(|channel| {
            let sampler = &animation.samplers[channel.sampler];
            let is_cubic = sampler.interpolation.as_deref() == Some("CUBICSPLINE");
            (sampler.output, if is_cubic { Rule::CubicRotation } else { Rule::Rotation })
        })
    });
    of_animations.chain(of_instances)
}

/// Looks at the attributes of all primitives and at rotations, each accessor once for each rule. What is not finite is told elsewhere.
pub(super) fn check(document: &Document, accessors: &Accessors, left: &mut u64, findings: &mut Findings) {
    let primitives = document.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let plain = primitives.filter(|primitive| primitive.extensions.draco.is_none());
    let named = plain.flat_map(|primitive: &Primitive| primitive.attributes.iter());
    let of_attributes = named.filter_map(|(name, &accessor)| Some((accessor, Rule::of(name)?)));
    let rules: BTreeSet<_> = of_attributes.chain(rotations(document)).collect();
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
            if rule.is_for_element(vertex) && values.iter().all(|value| value.is_finite()) {
                lengths.add_if(has_wrong_length(rule, values, component), vertex);
                others.add_if(has_wrong_value(rule, values), vertex);
            }
        });
        let (what, place) = (rule.name(), rule.place());
        lengths.tell(&format!("accessor {index}: {what} that are not of length 1"), place, findings);
        let range = if rule == Rule::Tangent { "whose w is neither 1 nor -1" } else { "that are not between 0 and 1" };
        others.tell(&format!("accessor {index}: {what} {range}"), place, findings);
    }
}

/// Whether a direction is not of length 1, as closely as its components can say it: whichever way each is rounded, the vector is off by
/// √3 steps at most (of four components 2), and so is its length.
fn has_wrong_length(rule: Rule, values: &[f64], component: Component) -> bool {
    let values = match rule {
        Rule::Normal | Rule::Tangent => &values[..3],
        Rule::Rotation | Rule::CubicRotation => values,
        Rule::Color | Rule::Weights => return false,
    };
    let length = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    let slack = LENGTH_OFF + (values.len() as f64).sqrt() * component.step();
    (length - 1.0).abs() > slack
}

fn has_wrong_value(rule: Rule, values: &[f64]) -> bool {
    match rule {
        Rule::Normal | Rule::Rotation | Rule::CubicRotation => false,
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

    fn tell(&self, subject: &str, place: &str, findings: &mut Findings) {
        for number in &self.first {
            findings.add_at(FindingKind::BrokenRule, subject, format_args!("{place} {number}"));
        }
        findings.add(FindingKind::BrokenRule, subject, self.count - self.first.len());
    }
}
