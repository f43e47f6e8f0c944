//! What extensions that only shade refer to: nothing of it is read, but an index out of range is a fault of the file. Whatever they hold, the rest is good.

use std::{fmt, marker::PhantomData};

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeOwned, IgnoredAny, MapAccess, Visitor},
};
use serde_json::value::RawValue;

use super::TextureIndex;

/// What is looked for in extensions.
pub(in crate::gltf) trait Referring: DeserializeOwned {
    /// How the names of those extensions begin.
    const BEGINNINGS: &'static [&'static str];
}

/// The extensions of an element that refer to something; others may be anything.
#[derive(Debug)]
pub(in crate::gltf) struct References<R> {
    found: Vec<R>,
    /// The names of those that do not say what they should.
    pub(in crate::gltf) malformed: Vec<String>,
}

impl<R> Default for References<R> {
    fn default() -> Self {
        Self { found: Vec::new(), malformed: Vec::new() }
    }
}

impl<R> References<R> {
    pub(in crate::gltf) fn iter(&self) -> impl Iterator<Item = &R> {
        self.found.iter()
    }
}

impl<'de, R: Referring> Deserialize<'de> for References<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OfExtensions(PhantomData))
    }
}

struct OfExtensions<R>(PhantomData<R>);

impl<'de, R: Referring> Visitor<'de> for OfExtensions<R> {
    type Value = References<R>;

    fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
        text.write_str("an object of extensions")
    }

    /// Null, which is told elsewhere.
    fn visit_unit<E>(self) -> Result<Self::Value, E> {
        Ok(References::default())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut references = References::default();
        while let Some(name) = map.next_key::<String>()? {
            if R::BEGINNINGS.iter().any(|beginning| name.starts_with(beginning)) {
                match serde_json::from_str(map.next_value::<Box<RawValue>>()?.get()) {
                    Ok(extension) => references.found.push(extension),
                    Err(_) => references.malformed.push(name),
                }
            } else {
                map.next_value::<IgnoredAny>()?;
            }
        }
        Ok(references)
    }
}

/// The textures of a material's extension: its members whose names end in "Texture". A member whose name ends in "Strength" is a number.
#[derive(Debug)]
pub(in crate::gltf) struct MaterialTextures(pub(in crate::gltf) Vec<TextureIndex>);

impl Referring for MaterialTextures {
    const BEGINNINGS: &'static [&'static str] = &["KHR_materials_"];
}

impl<'de> Deserialize<'de> for MaterialTextures {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(OfMaterial)
    }
}

struct OfMaterial;

impl<'de> Visitor<'de> for OfMaterial {
    type Value = MaterialTextures;

    fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
        text.write_str("an extension of a material, which is an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut textures = Vec::new();
        while let Some(name) = map.next_key::<String>()? {
            if name.ends_with("Texture") {
                textures.push(map.next_value()?);
            } else if name.ends_with("Strength") {
                map.next_value::<f64>()?;
            } else {
                map.next_value::<IgnoredAny>()?;
            }
        }
        Ok(MaterialTextures(textures))
    }
}

/// Another picture of a texture, in a format of its own.
#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct TextureImage {
    pub(in crate::gltf) source: Option<usize>,
}

impl Referring for TextureImage {
    const BEGINNINGS: &'static [&'static str] = &["KHR_texture_", "EXT_texture_", "MSFT_texture_"];
}

/// Materials that take the place of a primitive's own.
#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct VariantMappings {
    #[serde(default)]
    pub(in crate::gltf) mappings: Vec<VariantMapping>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct VariantMapping {
    pub(in crate::gltf) material: usize,
    #[serde(default)]
    pub(in crate::gltf) variants: Vec<usize>,
}

/// The names under which such materials are.
#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Variants {
    #[serde(default)]
    pub(in crate::gltf) variants: Vec<Variant>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Variant {
    pub(in crate::gltf) name: Option<String>,
}
