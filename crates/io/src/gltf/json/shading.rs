//! What extensions that only shade refer to: nothing of it is read, but an index out of range is a fault of the file.

use std::{fmt, marker::PhantomData};

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeOwned, IgnoredAny, MapAccess, Visitor},
};

use super::TextureIndex;

/// What is looked for in extensions.
pub(in crate::gltf) trait Referring: DeserializeOwned {
    /// How the names of those extensions begin.
    const BEGINNINGS: &'static [&'static str];
}

/// The extensions of an element that refer to something; others may be anything.
#[derive(Debug)]
pub(in crate::gltf) struct References<R>(Vec<R>);

impl<R> Default for References<R> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<R> References<R> {
    pub(in crate::gltf) fn iter(&self) -> impl Iterator<Item = &R> {
        self.0.iter()
    }
}

impl<'de, R: Referring> Deserialize<'de> for References<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(OfExtensions(PhantomData))
    }
}

struct OfExtensions<R>(PhantomData<R>);

impl<'de, R: Referring> Visitor<'de> for OfExtensions<R> {
    type Value = References<R>;

    fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
        text.write_str("an object of extensions")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut found = Vec::new();
        while let Some(name) = map.next_key::<String>()? {
            if R::BEGINNINGS.iter().any(|beginning| name.starts_with(beginning)) {
                found.push(map.next_value()?);
            } else {
                map.next_value::<IgnoredAny>()?;
            }
        }
        Ok(References(found))
    }
}

/// The textures of a material's extension: its members whose names end in "Texture".
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
    pub(in crate::gltf) variants: Vec<IgnoredAny>,
}
