//! The parts of a glTF 2.0 document that say where surfaces, lights and eyes are. Everything else is skipped.

mod buffers;
mod cameras;
mod extensions;
mod members;
mod motion;
mod node;
mod shading;

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeOwned, IgnoredAny},
};
use serde_json::value::RawValue;

use crate::error::LoadProblem;
pub(super) use buffers::{Buffer, BufferView, MeshoptFilter, MeshoptMode, MeshoptView};
pub(super) use cameras::{Eye, Orthographic, Perspective};
pub(super) use extensions::ExtensionNames;
pub(super) use members::Members;
pub(super) use motion::{Animation, AnimationChannel, AnimationSampler};
pub(super) use node::{Collider, Instancing, Node};
use shading::{MaterialExtension, References, TextureImage, VariantMappings, Variants};

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", expecting = "a glTF document, which is an object")]
pub(super) struct Document {
    pub(super) asset: Asset,
    #[serde(default)]
    pub(super) extensions_used: ExtensionNames,
    #[serde(default)]
    pub(super) extensions_required: Vec<String>,
    pub(super) scene: Option<usize>,
    #[serde(default)]
    pub(super) scenes: Vec<SceneNodes>,
    #[serde(default)]
    pub(super) nodes: Vec<Node>,
    #[serde(default)]
    pub(super) meshes: Vec<MeshPrimitives>,
    #[serde(default)]
    pub(super) skins: Vec<Skin>,
    #[serde(default)]
    pub(super) animations: Vec<Animation>,
    #[serde(default)]
    pub(super) materials: Vec<Material>,
    #[serde(default)]
    pub(super) textures: Vec<Texture>,
    #[serde(default)]
    pub(super) samplers: Vec<Sampler>,
    #[serde(default)]
    pub(super) images: Vec<Image>,
    #[serde(default)]
    pub(super) cameras: Vec<Eye>,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub(super) buffers: Vec<Buffer>,
    #[serde(default)]
    pub(super) extensions: RootExtensions,
}

impl Document {
    /// Whether it says that it uses an extension.
    pub(super) fn uses(&self, extension: &str) -> bool {
        self.extensions_used.contains(extension)
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Asset {
    pub(super) version: String,
    pub(super) min_version: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(super) lights: Option<PunctualLights>,
    #[serde(rename = "KHR_implicit_shapes")]
    pub(super) implicit_shapes: Option<Shapes>,
    #[serde(rename = "KHR_collision_shapes")]
    pub(super) collision_shapes: Option<Shapes>,
    #[serde(rename = "KHR_materials_variants")]
    pub(super) variants: Option<Variants>,
    #[serde(rename = "KHR_physics_rigid_bodies", default)]
    pub(super) physics: Physics,
}

/// What rigid bodies refer to, as far as it is counted.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Physics {
    #[serde(default)]
    pub(super) physics_materials: Vec<IgnoredAny>,
    #[serde(default)]
    pub(super) collision_filters: Vec<IgnoredAny>,
    #[serde(default)]
    pub(super) physics_joints: Vec<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Shapes {
    #[serde(default)]
    pub(super) shapes: Vec<ImplicitShape>,
}

/// A body, in the member that its type names.
#[derive(Debug, Deserialize)]
pub(super) struct ImplicitShape {
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sphere: Option<SphereShape>,
    #[serde(rename = "box")]
    pub(super) cuboid: Option<BoxShape>,
    pub(super) cylinder: Option<TurnedShape>,
    pub(super) capsule: Option<TurnedShape>,
    pub(super) plane: Option<PlaneShape>,
}

impl ImplicitShape {
    /// Whether it has no member of its type, all of whose numbers have defaults, but one of another.
    pub(super) fn is_of_another_type(&self) -> bool {
        let members = [
            ("sphere", self.sphere.is_some()),
            ("box", self.cuboid.is_some()),
            ("cylinder", self.cylinder.is_some()),
            ("capsule", self.capsule.is_some()),
            ("plane", self.plane.is_some()),
        ];
        let has = |is_own: bool| members.iter().any(|&(name, is_there)| is_there && (name == self.kind) == is_own);
        !has(true) && has(false)
    }
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default)]
pub(super) struct SphereShape {
    pub(super) radius: f64,
}

impl Default for SphereShape {
    fn default() -> Self {
        Self { radius: 0.5 }
    }
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default)]
pub(super) struct BoxShape {
    pub(super) size: [f64; 3],
}

impl Default for BoxShape {
    fn default() -> Self {
        Self { size: [1.0; 3] }
    }
}

/// A cylinder or capsule; early drafts have one `radius` for both ends.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct TurnedShape {
    pub(super) height: f64,
    pub(super) radius: f64,
    pub(super) radius_top: Option<f64>,
    pub(super) radius_bottom: Option<f64>,
}

impl Default for TurnedShape {
    fn default() -> Self {
        Self { height: 0.5, radius: 0.25, radius_top: None, radius_bottom: None }
    }
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct PlaneShape {
    pub(super) size_x: Option<f64>,
    pub(super) size_z: Option<f64>,
    pub(super) double_sided: bool,
}

#[derive(Debug, Deserialize)]
pub(super) struct PunctualLights {
    pub(super) lights: Vec<PunctualLight>,
}

#[derive(Debug, Deserialize)]
pub(super) struct PunctualLight {
    pub(super) name: Option<String>,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) color: Option<Vec<f64>>,
    pub(super) intensity: Option<f64>,
    pub(super) range: Option<f64>,
    pub(super) spot: Option<SpotCone>,
}

/// The angles of a spot, which is read as a point.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SpotCone {
    pub(super) inner_cone_angle: Option<f64>,
    pub(super) outer_cone_angle: Option<f64>,
}

#[derive(Debug, Deserialize)]
pub(super) struct SceneNodes {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct MeshPrimitives {
    pub(super) primitives: Vec<Primitive>,
    pub(super) weights: Option<Vec<f64>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: Members<usize>,
    pub(super) indices: Option<usize>,
    pub(super) material: Option<usize>,
    pub(super) mode: Option<u32>,
    #[serde(default)]
    pub(super) targets: Vec<Members<usize>>,
    #[serde(default)]
    pub(super) extensions: PrimitiveExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(super) draco: Option<DracoPrimitive>,
    #[serde(rename = "KHR_materials_variants")]
    pub(super) variants: Option<VariantMappings>,
}

/// The view that holds a primitive, and which of its attributes have which numbers there.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct DracoPrimitive {
    pub(super) buffer_view: usize,
    pub(super) attributes: Members<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material {
    pub(super) name: Option<String>,
    pub(super) alpha_mode: Option<String>,
    pub(super) alpha_cutoff: Option<f64>,
    #[serde(default)]
    pub(super) pbr_metallic_roughness: BaseColor,
    pub(super) normal_texture: Option<TextureIndex>,
    pub(super) occlusion_texture: Option<TextureIndex>,
    pub(super) emissive_texture: Option<TextureIndex>,
    #[serde(default)]
    pub(super) extensions: References<MaterialExtension>,
}

impl Material {
    /// What its alpha comes from: an extension that takes the place of the base colour, as viewers do that know it.
    pub(super) fn base_color(&self) -> &BaseColor {
        self.extensions.iter().find_map(MaterialExtension::base_color).unwrap_or(&self.pbr_metallic_roughness)
    }
}

/// A texture that changes nothing but shading.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureIndex {
    pub(super) index: usize,
    #[serde(default, deserialize_with = "lenient")]
    tex_coord: f64,
    #[serde(default, deserialize_with = "lenient")]
    extensions: TextureReferenceExtensions,
}

impl TextureIndex {
    /// What else changes shading alone.
    fn of(texture: &TextureReference) -> Self {
        Self { index: texture.index, tex_coord: texture.set().into(), extensions: Default::default() }
    }

    /// Which texture coordinates it takes.
    pub(super) fn set(&self) -> u32 {
        self.extensions.transform.as_ref().and_then(|transform| transform.tex_coord).unwrap_or(self.tex_coord as u32)
    }
}

/// What is there, or the default for what it may not be, which is told elsewhere.
fn lenient<'de, T: DeserializeOwned + Default, D: Deserializer<'de>>(value: D) -> Result<T, D::Error> {
    let written = Box::<RawValue>::deserialize(value)?;
    Ok(serde_json::from_str(written.get()).unwrap_or_default())
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BaseColor {
    pub(super) base_color_factor: Option<[f64; 4]>,
    pub(super) base_color_texture: Option<TextureReference>,
    pub(super) metallic_roughness_texture: Option<TextureIndex>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureReference {
    pub(super) index: usize,
    #[serde(default)]
    pub(super) tex_coord: u32,
    #[serde(default)]
    pub(super) extensions: TextureReferenceExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct TextureReferenceExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(super) transform: Option<TextureTransform>,
}

#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct TextureTransform {
    pub(super) offset: [f64; 2],
    pub(super) rotation: f64,
    pub(super) scale: [f64; 2],
    pub(super) tex_coord: Option<u32>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct Texture {
    pub(super) source: Option<usize>,
    pub(super) sampler: Option<usize>,
    #[serde(default)]
    pub(super) extensions: References<TextureImage>,
}

/// Codes of OpenGL.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Sampler {
    pub(super) mag_filter: Option<u32>,
    pub(super) min_filter: Option<u32>,
    pub(super) wrap_s: Option<u32>,
    pub(super) wrap_t: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    pub(super) uri: Option<String>,
    pub(super) buffer_view: Option<usize>,
    pub(super) mime_type: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub(super) inverse_bind_matrices: Option<usize>,
    pub(super) joints: Vec<usize>,
    pub(super) skeleton: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    byte_offset: Option<usize>,
    pub(super) component_type: u32,
    pub(super) count: usize,
    #[serde(rename = "type")]
    pub(super) kind: String,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) sparse: Option<Sparse>,
    pub(super) min: Option<Vec<f64>>,
    pub(super) max: Option<Vec<f64>>,
}

impl Accessor {
    /// Where it begins in its view.
    pub(super) fn byte_offset(&self) -> usize {
        self.byte_offset.unwrap_or(0)
    }

    /// Whether it says where it begins, and not in which view.
    pub(super) fn is_offset_without_view(&self) -> bool {
        self.byte_offset.is_some() && self.buffer_view.is_none()
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct Sparse {
    pub(super) count: usize,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
}

/// An element of the document by its index; a message about it is told of the element.
pub(super) fn existing<'a, T>(list: &'a [T], index: usize, kind: &str) -> Result<&'a T, LoadProblem> {
    let missing =
        || LoadProblem::element(format!("{kind} {index}"), format!("there is none; the file has {}", list.len()));
    list.get(index).ok_or_else(missing)
}

/// An element of the document by its index, or what is wrong with the index.
pub(super) fn element<'a, T>(list: &'a [T], index: usize, kind: &str) -> Result<&'a T, String> {
    list.get(index).ok_or_else(|| format!("it names {kind} {index}, but there are {}", list.len()))
}
