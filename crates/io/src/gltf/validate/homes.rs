//! Where extensions may stand: what each of those that are known extends. Elsewhere they mean nothing.

/// How the document is called among what has extensions.
pub(super) const DOCUMENT: &str = "the document";

/// What an extension may belong to, by the name of the member that holds it or the list that it is in.
enum Homes {
    Any,
    /// Those that end in `Texture`.
    References,
    Of(&'static [&'static str]),
}

impl Homes {
    fn of(extension: &str) -> Self {
        match extension {
            "KHR_texture_transform" => Self::References,
            "KHR_lights_punctual" | "KHR_physics_rigid_bodies" => Self::Of(&[DOCUMENT, "nodes"]),
            "EXT_mesh_gpu_instancing" | "EXT_instance_features" | "KHR_node_visibility" => Self::Of(&["nodes"]),
            "EXT_meshopt_compression" | "KHR_meshopt_compression" => Self::Of(&["buffers", "bufferViews"]),
            "KHR_draco_mesh_compression" | "EXT_mesh_features" => Self::Of(&["primitives"]),
            "KHR_materials_variants" | "EXT_structural_metadata" => Self::Of(&[DOCUMENT, "primitives"]),
            "KHR_implicit_shapes" => Self::Of(&[DOCUMENT]),
            "KHR_animation_pointer" => Self::Of(&["target"]),
            "KHR_texture_basisu" | "EXT_texture_avif" | "EXT_texture_webp" | "MSFT_texture_dds" => {
                Self::Of(&["textures"])
            }
            // It only widens what attributes may be made of.
            "KHR_mesh_quantization" => Self::Of(&[]),
            _ if extension.starts_with("KHR_materials_") => Self::Of(&["materials"]),
            _ => Self::Any,
        }
    }
}

/// Whether an extension may belong to something of a member of that name.
pub(super) fn may_stand_in(extension: &str, member: &str) -> bool {
    match Homes::of(extension) {
        Homes::Any => true,
        Homes::References => member.ends_with("Texture"),
        Homes::Of(members) => members.contains(&member),
    }
}
