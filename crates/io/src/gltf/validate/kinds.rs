//! Values of a kind that no member of glTF has: null, a list in a list, a list where an object is due. Derived readers take the first for a member that is
//! absent, and the others for the members of an object in order; so the text is walked once more, without keeping it. On the way empty lists are told, and
//! values of members that nothing reads where they are of another kind than theirs.
//!
//! What `extras` and extensions that are not known hold may be anything; whether an extension is among those that the document says it uses, and stands where it may
//! ([`homes`](super::homes)), is looked at on the way. Depth is limited by the reader of JSON.

use std::{collections::HashSet, fmt};

use serde::{
    Deserializer,
    de::{self, DeserializeSeed, IgnoredAny, MapAccess, SeqAccess, Visitor},
};

use umbriel_scene::FindingKind;

use super::homes;
use crate::{
    error::excerpt,
    gltf::{READ, WITHOUT_EFFECT, json::ExtensionNames, keys::write_name},
    model::Findings,
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
const NEVER_EMPTY: [&str; 20] = [
    "accessors",
    "animations",
    "buffers",
    "bufferViews",
    "cameras",
    "children",
    "extensionsRequired",
    "extensionsUsed",
    "images",
    "lights",
    "materials",
    "meshes",
    "nodes",
    "samplers",
    "scenes",
    "shapes",
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

/// What is wrong, with the JSON pointers (RFC 6901) of the first places; `used` are the extensions that the document uses. Nothing for a text that is no JSON.
pub(in crate::gltf) fn check(text: &[u8], used: &ExtensionNames) -> Findings {
    let mut walk = Walk { used, undeclared: HashSet::new(), findings: Findings::default() };
    let name = homes::DOCUMENT;
    let member = Member { name, kind: Kind::Any, is_in_list: false, is_open: false, place: None, walk: &mut walk };
    // A text that is no JSON was refused before.
    if let Err(fault) = member.deserialize(&mut serde_json::Deserializer::from_slice(text)) {
        let subject = format!("JSON: what follows is not looked at: {fault}");
        walk.findings.add(FindingKind::BrokenRule, &subject, 1);
    }
    walk.findings
}

/// What stays the same all the way.
struct Walk<'a> {
    used: &'a ExtensionNames,
    /// Extensions that are used and not said to be, told once each.
    undeclared: HashSet<String>,
    findings: Findings,
}

/// A member or an element of a list, below those around it.
#[derive(Clone, Copy)]
struct Place<'a> {
    above: Option<&'a Place<'a>>,
    step: Step<'a>,
}

#[derive(Clone, Copy)]
enum Step<'a> {
    Name(&'a str),
    Number(usize),
}

/// Its JSON pointer, made for the few that are shown.
impl fmt::Display for Place<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let upward: Vec<&Place> = std::iter::successors(Some(self), |place| place.above).collect();
        upward.into_iter().rev().try_for_each(|place| match place.step {
            Step::Name(name) => write_name(formatter, name),
            Step::Number(number) => write!(formatter, "/{number}"),
        })
    }
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
    /// A number above 0.
    Positive,
    /// An index of refraction: 1 or more, or 0 for none.
    Refraction,
    /// A number between 0 and 1.
    Share,
    /// A list of three shares.
    Color,
    /// A list of three magnitudes.
    Strengths,
    /// A list of two numbers.
    Pair,
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
            (_, "scale") if parent.ends_with("ormalTexture") => Self::Number,
            (_, "texCoord") => Self::Index,
            ("KHR_texture_transform", "offset" | "scale") => Self::Pair,
            ("KHR_texture_transform", "rotation") => Self::Number,
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
            | ("pbrSpecularGlossiness", "glossinessFactor")
            | ("anisotropy", "anisotropyStrength") => Self::Share,
            ("sheen", "sheenColorFactor")
            | ("volume", "attenuationColor")
            | ("pbrSpecularGlossiness", "specularFactor")
            | ("diffuse_transmission", "diffuseTransmissionColorFactor") => Self::Color,
            ("specular", "specularColorFactor") => Self::Strengths,
            ("ior", "ior") | ("iridescence", "iridescenceIor") => Self::Refraction,
            ("volume", "attenuationDistance") => Self::Positive,
            ("dispersion", "dispersion")
            | ("emissive_strength", "emissiveStrength")
            | ("iridescence", "iridescenceThicknessMinimum" | "iridescenceThicknessMaximum")
            | ("volume", "thicknessFactor") => Self::Magnitude,
            ("anisotropy", "anisotropyRotation") => Self::Number,
            _ => Self::Any,
        }
    }

    /// What the elements of a list are, if these are in one.
    fn of_elements(self) -> Option<Self> {
        match self {
            Self::Any => Some(Self::Any),
            Self::Color => Some(Self::Share),
            Self::Strengths => Some(Self::Magnitude),
            Self::Pair => Some(Self::Number),
            _ => None,
        }
    }

    /// How many elements it is a list of; `None` for any number, or no list.
    fn length(self) -> Option<usize> {
        match self {
            Self::Color | Self::Strengths => Some(3),
            Self::Pair => Some(2),
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
            Self::Positive => "not a number above 0",
            Self::Refraction => "neither 0 nor a number from 1 on",
            Self::Share => "not a number between 0 and 1",
            Self::Color => "not three numbers between 0 and 1",
            Self::Strengths => "not three numbers, 0 or more",
            Self::Pair => "not two numbers",
            Self::Index => "not a whole number, 0 or more",
        }
    }
}

/// The value of a member, or an element of a list that is one.
struct Member<'a, 'w> {
    name: &'a str,
    kind: Kind,
    is_in_list: bool,
    /// An extension: what it holds is looked at where something reads it.
    is_open: bool,
    /// The document itself has none.
    place: Option<&'a Place<'a>>,
    walk: &'a mut Walk<'w>,
}

impl<'w> Member<'_, 'w> {
    fn tell(&mut self, fault: &str) {
        let place: &dyn fmt::Display = if let Some(place) = self.place { place } else { &"" };
        self.walk.findings.add_at(FindingKind::BrokenRule, &format!("{}: {fault}", excerpt(self.name)), place);
    }

    /// An element of the list that this member is.
    fn element<'b>(&'b mut self, kind: Kind, place: &'b Place<'b>) -> Member<'b, 'w> {
        Member { name: self.name, kind, is_in_list: true, is_open: false, place: Some(place), walk: &mut *self.walk }
    }

    /// Tells a value that is none of those that the member may have.
    fn expect<E>(mut self, is_fitting: bool) -> Result<(), E> {
        if !is_fitting && self.kind != Kind::Any {
            self.tell(self.kind.fault());
        }
        Ok(())
    }

    /// Tells an extension of what this member, `extensions`, belongs to, if the document does not say that it uses it or it has nothing to say there.
    fn extension(&mut self, name: &str) {
        let findings = &mut self.walk.findings;
        if !self.walk.used.contains(name) && self.walk.undeclared.insert(name.to_owned()) {
            let subject = format!("{}: it is not among the extensionsUsed", excerpt(name));
            findings.add(FindingKind::BrokenRule, &subject, 1);
        }
        let around = std::iter::successors(self.place.and_then(|place| place.above), |place| place.above);
        let owner = around.filter_map(|place| if let Step::Name(name) = place.step { Some(name) } else { None }).next();
        if !homes::may_stand_in(name, owner.unwrap_or(homes::DOCUMENT)) {
            let place = Place { above: self.place, step: Step::Name(name) };
            let subject = format!("{}: it means nothing where it stands", excerpt(name));
            findings.add_at(FindingKind::BrokenRule, &subject, place);
        }
    }
}

impl<'de> DeserializeSeed<'de> for Member<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Member<'_, '_> {
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
            Kind::Positive => number > 0.0,
            Kind::Refraction => number == 0.0 || number >= 1.0,
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
        let above = self.place;
        while list.next_element_seed(self.element(kind, &Place { above, step: Step::Number(count) }))?.is_some() {
            count += 1;
        }
        if self.kind.length().is_some_and(|length| length != count) {
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
        let (own, above) = (self.name, self.place);
        while let Some(name) = map.next_key::<String>()? {
            if self.is_open && !is_looked_into(own) || name == "extras" {
                map.next_value::<IgnoredAny>()?;
                continue;
            }
            let is_open = own == "extensions";
            if is_open {
                self.extension(&name);
            }
            let kind = if is_open { Kind::Any } else { Kind::of(own, &name) };
            let place = Some(&Place { above, step: Step::Name(&name) });
            map.next_value_seed(Member {
                name: &name,
                kind,
                is_in_list: false,
                is_open,
                place,
                walk: &mut *self.walk,
            })?;
        }
        Ok(())
    }
}
