//! What extensions that shade refer to: but for an older base colour nothing of it is read, yet an index out of range is a fault of the file. Whatever they hold, the rest is good.

use std::{fmt, marker::PhantomData};

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeOwned, IgnoredAny, MapAccess, Visitor},
};
use serde_json::value::RawValue;

use super::{BaseColor, TextureIndex, TextureReference};

/// What is looked for in extensions.
pub(in crate::gltf) trait Referring: DeserializeOwned {
    /// How the names of those extensions begin.
    const BEGINNINGS: &'static [&'static str];

    /// Told the whole name.
    fn of_name(self, _name: &str) -> Self {
        self
    }
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
                match serde_json::from_str::<R>(map.next_value::<Box<RawValue>>()?.get()) {
                    Ok(extension) => references.found.push(extension.of_name(&name)),
                    Err(_) => references.malformed.push(name),
                }
            } else {
                map.next_value::<IgnoredAny>()?;
            }
        }
        Ok(references)
    }
}

/// A material's extension.
#[derive(Debug, Default)]
pub(in crate::gltf) struct MaterialExtension {
    /// Its members whose names end in "Texture". A member whose name ends in "Strength" is a number.
    pub(in crate::gltf) textures: Vec<TextureIndex>,
    /// Its members `diffuseTexture` and `diffuseFactor`.
    diffuse: BaseColor,
    /// It is KHR_materials_pbrSpecularGlossiness.
    is_specular_glossiness: bool,
}

impl MaterialExtension {
    /// What takes the place of the material's base colour, if the extension is one of those.
    pub(super) fn base_color(&self) -> Option<&BaseColor> {
        self.is_specular_glossiness.then_some(&self.diffuse)
    }
}

impl Referring for MaterialExtension {
    const BEGINNINGS: &'static [&'static str] = &["KHR_materials_"];

    fn of_name(self, name: &str) -> Self {
        Self { is_specular_glossiness: name == "KHR_materials_pbrSpecularGlossiness", ..self }
    }
}

impl<'de> Deserialize<'de> for MaterialExtension {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(OfMaterial)
    }
}

struct OfMaterial;

impl<'de> Visitor<'de> for OfMaterial {
    type Value = MaterialExtension;

    fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
        text.write_str("an extension of a material, which is an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut found = MaterialExtension::default();
        while let Some(name) = map.next_key::<String>()? {
            if name == "diffuseTexture" {
                let texture: TextureReference = map.next_value()?;
                found.textures.push(TextureIndex::of(&texture));
                found.diffuse.base_color_texture = Some(texture);
            } else if name == "diffuseFactor" {
                found.diffuse.base_color_factor = Some(map.next_value()?);
            } else if name.ends_with("Texture") {
                found.textures.push(map.next_value()?);
            } else if name.ends_with("Strength") {
                map.next_value::<f64>()?;
            } else {
                map.next_value::<IgnoredAny>()?;
            }
        }
        Ok(found)
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
