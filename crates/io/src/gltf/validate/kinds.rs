//! Values of a kind that no member of glTF has: null, a list in a list, a list where an object is due. Derived readers take the first for a member that is
//! absent, and the others for the members of an object in order; so the text is walked once more, without keeping it. On the way empty lists are told, and
//! values of members that nothing reads where they are of another kind than theirs.
//!
//! What `extras` and extensions that are not known hold may be anything; whether an extension is among those that the document says it uses is looked at on the way. Depth is
//! limited by the reader of JSON.

use std::{collections::BTreeMap, fmt};

use serde::{
    Deserializer,
    de::{self, DeserializeSeed, IgnoredAny, MapAccess, SeqAccess, Visitor},
};

use crate::{
    error::excerpt,
    gltf::{READ, WITHOUT_EFFECT, json::ExtensionNames},
};

/// Members that are objects and never lists.
const OBJECTS: [&str; 26] = [
    "asset",
    "attributes",
    "baseColorTexture",
    "box",
    "capsule",
    "collider",
    "cylinder",
    "emissiveTexture",
    "extensions",
    "geometry",
    "indices",
    "joint",
    "metallicRoughnessTexture",
    "normalTexture",
    "occlusionTexture",
    "orthographic",
    "pbrMetallicRoughness",
    "perspective",
    "plane",
    "sampler",
    "sparse",
    "sphere",
    "spot",
    "target",
    "trigger",
    "values",
];

/// Members that are left out rather than empty. Those whose elements something needs are looked at where they are read.
const NEVER_EMPTY: [&str; 18] = [
    "accessors",
    "animations",
    "buffers",
    "bufferViews",
    "cameras",
    "children",
    "extensionsRequired",
    "extensionsUsed",
    "images",
    "materials",
    "meshes",
    "nodes",
    "samplers",
    "scenes",
    "skins",
    "targets",
    "textures",
    "weights",
];

/// How the names of extensions of materials begin.
const OF_MATERIALS: &str = "KHR_materials_";

/// Whether it is looked at what an extension holds: it is read, or its members are known.
fn is_looked_into(extension: &str) -> bool {
    READ.contains(&extension) || extension.starts_with(OF_MATERIALS) && WITHOUT_EFFECT.contains(&extension)
}

/// What is wrong, by the member's name, and how often; `used` are the extensions that the document uses. Nothing for a text that is no JSON.
pub(in crate::gltf) fn check(text: &[u8], used: &ExtensionNames) -> BTreeMap<String, usize> {
    let mut told = BTreeMap::new();
    let member =
        Member { name: "the document", kind: Kind::Any, is_in_list: false, is_open: false, used, told: &mut told };
    // A text that is no JSON was refused before.
    if let Err(fault) = member.deserialize(&mut serde_json::Deserializer::from_slice(text)) {
        told.insert(format!("JSON: what follows is not looked at: {fault}"), 1);
    }
    told
}

/// What the values of a member are, where nothing else reads them.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Not looked at here.
    Any,
    Text,
    Flag,
    Number,
    /// A number, 0 or more.
    Magnitude,
    /// A number between 0 and 1.
    Share,
    /// A list of three shares.
    Color,
    /// A whole number, 0 or more.
    Index,
}

impl Kind {
    /// That of a member, by the name of what it is a member of, and its own.
    fn of(parent: &str, name: &str) -> Self {
        match (parent, name) {
            (_, "name") | ("asset", "generator" | "copyright") => Self::Text,
            ("materials", "doubleSided") => Self::Flag,
            ("materials", "emissiveFactor") => Self::Color,
            ("pbrMetallicRoughness", "metallicFactor" | "roughnessFactor") | ("occlusionTexture", "strength") => {
                Self::Share
            }
            ("normalTexture", "scale") => Self::Number,
            (_, "texCoord") => Self::Index,
            _ => parent.strip_prefix(OF_MATERIALS).map_or(Self::Any, |extension| Self::of_material(extension, name)),
        }
    }

    /// That of a member of a material's extension.
    fn of_material(extension: &str, name: &str) -> Self {
        match (extension, name) {
            ("clearcoat", "clearcoatFactor" | "clearcoatRoughnessFactor")
            | ("transmission", "transmissionFactor")
            | ("diffuse_transmission", "diffuseTransmissionFactor")
            | ("sheen", "sheenRoughnessFactor")
            | ("specular", "specularFactor")
            | ("iridescence", "iridescenceFactor")
            | ("anisotropy", "anisotropyStrength") => Self::Share,
            ("sheen", "sheenColorFactor")
            | ("volume", "attenuationColor")
            | ("diffuse_transmission", "diffuseTransmissionColorFactor") => Self::Color,
            ("ior", "ior")
            | ("dispersion", "dispersion")
            | ("emissive_strength", "emissiveStrength")
            | ("volume", "thicknessFactor" | "attenuationDistance") => Self::Magnitude,
            ("anisotropy", "anisotropyRotation") => Self::Number,
            _ => Self::Any,
        }
    }

    /// What the elements of a list are, if these are in one.
    fn of_elements(self) -> Option<Self> {
        match self {
            Self::Any => Some(Self::Any),
            Self::Color => Some(Self::Share),
            _ => None,
        }
    }

    fn fault(self) -> &'static str {
        match self {
            Self::Any => "of no kind that it may have",
            Self::Text => "not a text",
            Self::Flag => "neither true nor false",
            Self::Number => "not a number",
            Self::Magnitude => "not a number, 0 or more",
            Self::Share => "not a number between 0 and 1",
            Self::Color => "not three numbers between 0 and 1",
            Self::Index => "not a whole number, 0 or more",
        }
    }
}

/// The value of a member, or an element of a list that is one.
struct Member<'a> {
    name: &'a str,
    kind: Kind,
    is_in_list: bool,
    /// An extension: what it holds is looked at where something reads it.
    is_open: bool,
    used: &'a ExtensionNames,
    told: &'a mut BTreeMap<String, usize>,
}

impl Member<'_> {
    fn tell(&mut self, fault: &str) {
        *self.told.entry(format!("{}: {fault}", excerpt(self.name))).or_default() += 1;
    }

    /// An element of the list that this member is.
    fn element(&mut self, kind: Kind) -> Member<'_> {
        Member { name: self.name, kind, is_in_list: true, is_open: false, used: self.used, told: &mut *self.told }
    }

    /// Tells a value that is none of those that the member may have.
    fn expect<E>(mut self, is_fitting: bool) -> Result<(), E> {
        if !is_fitting && self.kind != Kind::Any {
            self.tell(self.kind.fault());
        }
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for Member<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Member<'_> {
    type Value = ();

    fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
        text.write_str("JSON")
    }

    fn visit_unit<E>(mut self) -> Result<(), E> {
        self.tell("null");
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        let is_fitting = self.kind == Kind::Flag;
        self.expect(is_fitting)
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<(), E> {
        self.visit_f64(number as f64)
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<(), E> {
        self.visit_f64(number as f64)
    }

    fn visit_f64<E>(self, number: f64) -> Result<(), E> {
        let is_fitting = match self.kind {
            Kind::Number => true,
            Kind::Magnitude => number >= 0.0,
            Kind::Share => (0.0..=1.0).contains(&number),
            Kind::Index => number >= 0.0 && number.fract() == 0.0,
            _ => false,
        };
        self.expect(is_fitting)
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        let is_fitting = self.kind == Kind::Text;
        self.expect(is_fitting)
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<(), A::Error> {
        let kind = self.kind.of_elements();
        let is_object = OBJECTS.contains(&self.name) || self.name.ends_with("Texture");
        let is_due = !self.is_in_list && !self.is_open && !is_object;
        let Some(kind) = kind.filter(|_| is_due) else {
            self.tell(if is_due { self.kind.fault() } else { "a list where none is due" });
            while list.next_element::<IgnoredAny>()?.is_some() {}
            return Ok(());
        };
        let mut count = 0;
        while list.next_element_seed(self.element(kind))?.is_some() {
            count += 1;
        }
        if self.kind == Kind::Color && count != 3 {
            self.tell(self.kind.fault());
        } else if count == 0 && NEVER_EMPTY.contains(&self.name) {
            self.tell("an empty list");
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> Result<(), A::Error> {
        if self.kind != Kind::Any {
            self.tell(self.kind.fault());
        }
        let Self { name: own, is_open, used, told, .. } = self;
        while let Some(name) = map.next_key::<String>()? {
            if is_open && !is_looked_into(own) || name == "extras" {
                map.next_value::<IgnoredAny>()?;
            } else {
                let is_open = own == "extensions";
                if is_open && !used.contains(&name) {
                    told.insert(format!("{}: it is not among the extensionsUsed", excerpt(&name)), 1);
                }
                let kind = if is_open { Kind::Any } else { Kind::of(own, &name) };
                map.next_value_seed(Member { name: &name, kind, is_in_list: false, is_open, used, told: &mut *told })?;
            }
        }
        Ok(())
    }
}
