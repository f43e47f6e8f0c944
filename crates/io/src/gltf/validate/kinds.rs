//! Values of a kind that no member of glTF has: null, a list in a list, a list where an object is due. Derived readers take the first for a member that is
//! absent, and the others for the members of an object in order; so the text is walked once more, without keeping it.
//!
//! What `extras` and the extensions hold may be anything; whether an extension is among those that the document says it uses is looked at on the way. Depth is
//! limited by the reader of JSON.

use std::{collections::BTreeMap, fmt};

use serde::{
    Deserializer,
    de::{DeserializeSeed, IgnoredAny, MapAccess, SeqAccess, Visitor},
};

use crate::{error::excerpt, gltf::json::ExtensionNames};

/// Members that are objects and never lists.
const OBJECTS: [&str; 16] = [
    "asset",
    "attributes",
    "baseColorTexture",
    "emissiveTexture",
    "extensions",
    "indices",
    "metallicRoughnessTexture",
    "normalTexture",
    "occlusionTexture",
    "orthographic",
    "pbrMetallicRoughness",
    "perspective",
    "sampler",
    "sparse",
    "target",
    "values",
];

/// What is wrong, by the member's name, and how often; `used` are the extensions that the document uses. Nothing for a text that is no JSON.
pub(in crate::gltf) fn check(text: &[u8], used: &ExtensionNames) -> BTreeMap<String, usize> {
    let mut told = BTreeMap::new();
    let member = Member { name: "the document", is_in_list: false, is_open: false, used, told: &mut told };
    // A text that is no JSON was refused before.
    let _ = member.deserialize(&mut serde_json::Deserializer::from_slice(text));
    told
}

/// The value of a member, or an element of a list that is one.
struct Member<'a> {
    name: &'a str,
    is_in_list: bool,
    /// An extension: what it holds is not looked at.
    is_open: bool,
    used: &'a ExtensionNames,
    told: &'a mut BTreeMap<String, usize>,
}

impl Member<'_> {
    fn tell(&mut self, fault: &str) {
        *self.told.entry(format!("{}: {fault}", excerpt(self.name))).or_default() += 1;
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
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<(), A::Error> {
        if self.is_in_list || self.is_open || OBJECTS.contains(&self.name) {
            self.tell("a list where none is due");
            while list.next_element::<IgnoredAny>()?.is_some() {}
            return Ok(());
        }
        let Self { name, used, told, .. } = self;
        while list
            .next_element_seed(Member { name, is_in_list: true, is_open: false, used, told: &mut *told })?
            .is_some()
        {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Self { name: own, is_open, used, told, .. } = self;
        while let Some(name) = map.next_key::<String>()? {
            if is_open || name == "extras" {
                map.next_value::<IgnoredAny>()?;
            } else {
                let is_open = own == "extensions";
                if is_open && !used.contains(&name) {
                    told.insert(format!("{}: it is not among the extensionsUsed", excerpt(&name)), 1);
                }
                map.next_value_seed(Member { name: &name, is_in_list: false, is_open, used, told: &mut *told })?;
            }
        }
        Ok(())
    }
}
