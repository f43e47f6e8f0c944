//! What attributes are made of (glTF 2.0, 3.7.2.1 and 3.7.2.2; KHR_mesh_quantization): types that are none of theirs are told.

use super::Check;
use crate::gltf::{
    accessor::Component::{self, F32, I8, I16, U8, U16},
    json::{Accessor, Members, Primitive},
};

/// Types of components, and whether they are normalised.
type Components = &'static [(Component, bool)];

const FLOATS: Components = &[(F32, false)];
const FLOATS_OR_SHARES: Components = &[(F32, false), (U8, true), (U16, true)];
const DIRECTIONS: Components = &[(F32, false), (I8, true), (I16, true)];
const NUMBERS: Components = &[(U8, false), (U16, false)];
/// The type of components that are whole numbers of 32 bits, which only indices are.
const UNSIGNED_INT: u32 = 5125;
/// Texture coordinates of quantised meshes.
const ANY_SMALL: Components = &[
    (F32, false),
    (U8, true),
    (U16, true),
    (U8, false),
    (U16, false),
    (I8, true),
    (I16, true),
    (I8, false),
    (I16, false),
];

impl Check<'_> {
    /// Attributes of a primitive and of its targets.
    pub(super) fn formats(&mut self, primitive: &Primitive, place: &str) {
        self.formats_of(&primitive.attributes, false, place);
        self.sets_of(&primitive.attributes, place);
        for (number, target) in primitive.targets.iter().enumerate() {
            self.formats_of(target, true, &format!("{place}, morph target {number}"));
        }
    }

    fn formats_of(&mut self, attributes: &Members<usize>, is_target: bool, place: &str) {
        let is_quantized = self.document.uses("KHR_mesh_quantization");
        for (name, &index) in attributes.iter() {
            let accessor = &self.document.accessors[index];
            let is_of_extension = name.split_once(':').is_some_and(|(extension, _)| self.document.uses(extension));
            if !is_of_extension && !is_format(name, accessor, is_target, is_quantized) {
                let name = crate::error::excerpt(name);
                self.tell(place, &format!("{name} is no attribute of glTF, or its type is none of that attribute's"));
            }
        }
    }

    /// Sets of attributes are counted from 0 on, and joints and weights come in pairs.
    fn sets_of(&mut self, attributes: &Members<usize>, place: &str) {
        let count = |of: &str| attributes.keys().filter(|name| set_of(name, of).is_some()).count();
        let is_without_gaps = |of: &str| {
            let count = count(of);
            attributes.keys().filter_map(|name| set_of(name, of)).all(|set| set < count)
        };
        if !["TEXCOORD", "COLOR", "JOINTS", "WEIGHTS"].into_iter().all(is_without_gaps) {
            self.tell(place, "sets of its attributes are not counted from 0 on");
        }
        if count("JOINTS") != count("WEIGHTS") {
            self.tell(place, "its joints and weights are not pairs");
        }
    }
}

/// The number of an attribute of some set, such as 1 for `TEXCOORD_1`.
fn set_of(name: &str, of: &str) -> Option<usize> {
    let number = name.strip_prefix(of)?.strip_prefix('_')?;
    number.parse().ok().filter(|set: &usize| set.to_string() == number)
}

/// Whether an attribute may be made of these elements. Positions are looked at where they are read.
fn is_format(name: &str, accessor: &Accessor, is_target: bool, is_quantized: bool) -> bool {
    let directions = if is_quantized { DIRECTIONS } else { FLOATS };
    let places = if is_quantized { ANY_SMALL } else { FLOATS_OR_SHARES };
    let base = name.split('_').next().unwrap_or_default();
    let is_named = match base {
        "TEXCOORD" | "COLOR" | "JOINTS" | "WEIGHTS" => set_of(name, base).is_some(),
        // The attributes of others begin with an underscore.
        "" => !name.is_empty() && accessor.component_type != UNSIGNED_INT,
        _ => name == base,
    };
    if !is_named {
        return false;
    }
    // Differences of colours may be signed; how targets may be quantised is left open.
    let (kinds, components): (&[&str], _) = match base {
        "" | "POSITION" => return true,
        "NORMAL" => (&["VEC3"], directions),
        "TANGENT" if is_target => (&["VEC3"], directions),
        "TANGENT" => (&["VEC4"], directions),
        "TEXCOORD" if is_target => (&["VEC2"], ANY_SMALL),
        "TEXCOORD" => (&["VEC2"], places),
        "COLOR" if is_target => (&["VEC3", "VEC4"], ANY_SMALL),
        "COLOR" => (&["VEC3", "VEC4"], FLOATS_OR_SHARES),
        "JOINTS" => (&["VEC4"], NUMBERS),
        "WEIGHTS" => (&["VEC4"], FLOATS_OR_SHARES),
        _ => return false,
    };
    let component = Component::of(accessor.component_type).map(|component| (component, accessor.normalized));
    kinds.contains(&&*accessor.kind) && component.is_ok_and(|component| components.contains(&component))
}
