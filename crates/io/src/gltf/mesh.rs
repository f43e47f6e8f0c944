//! Meshes: all primitives of a glTF mesh as one triangle mesh, made once for each set of morph weights and shared.

use std::{collections::HashMap, sync::Arc};

use umbriel_geometry::Mesh;
use umbriel_scene::FindingKind;

use super::{
    accessor::Accessors,
    json::{Document, MeshPrimitives, Primitive, element, existing},
    primitive::{Geometry, Primitives},
};
use crate::{
    error::LoadProblem,
    lightmap::{LightmapLayout, NOWHERE},
    model::Findings,
};

/// A mesh, and what of it was taken otherwise than the file says.
#[derive(Clone, Debug)]
pub(super) struct LoadedMesh {
    pub(super) mesh: Arc<Mesh>,
    /// Triangles with a MASK material.
    pub(super) masked: usize,
    /// Triangles with a BLEND material.
    pub(super) blended: usize,
    /// Primitives of points or lines, or without positions.
    pub(super) not_triangles: usize,
    /// Whether it has morph targets.
    pub(super) morphs: bool,
    /// Where its triangles lie on a light map, if that is wanted.
    pub(super) lightmap: Option<Arc<LightmapLayout>>,
}

/// The triangles of a mesh as its primitives come.
#[derive(Default)]
struct Parts {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    /// As many as triangles, or none where light maps are not wanted.
    lightmap: Vec<[[f64; 2]; 3]>,
}

/// Which mesh, and the bits of the weights that a node gives its morph targets.
type Key = (usize, Option<Vec<u64>>);

/// The meshes of a document, read when first asked for.
#[derive(Debug)]
pub(super) struct Meshes<'a> {
    document: &'a Document,
    primitives: Primitives<'a>,
    wants_lightmaps: bool,
    loaded: HashMap<Key, LoadedMesh>,
}

impl<'a> Meshes<'a> {
    pub(super) fn new(document: &'a Document, accessors: &'a Accessors<'a>, lightmap_set: Option<u32>) -> Self {
        let quantized = document.extensions_used.iter().any(|name| name == "KHR_mesh_quantization");
        let primitives = Primitives::new(accessors, quantized, lightmap_set);
        Self { document, primitives, wants_lightmaps: lightmap_set.is_some(), loaded: HashMap::new() }
    }

    /// The mesh of that index, morphed by the weights of a node, else by its own; the same one every time.
    pub(super) fn get(&mut self, index: usize, weights: Option<&[f64]>) -> Result<&LoadedMesh, LoadProblem> {
        let bits = |weights: &[f64]| weights.iter().map(|weight| weight.to_bits()).collect();
        let key: Key = (index, weights.map(bits));
        if !self.loaded.contains_key(&key) {
            let declared = existing(&self.document.meshes, index, "mesh")?;
            let weights = self.weights(index, declared, weights);
            let mesh = self.read(index, declared, &weights)?;
            self.loaded.insert(key.clone(), mesh);
        }
        Ok(&self.loaded[&key])
    }

    /// The rules that were found broken.
    pub(super) fn into_findings(self) -> Findings {
        self.primitives.findings
    }

    /// As many weights as there are morph targets.
    fn weights(&mut self, index: usize, declared: &MeshPrimitives, own: Option<&[f64]>) -> Vec<f64> {
        let targets = declared.primitives.iter().map(|primitive| primitive.targets.len()).max().unwrap_or(0);
        let given = own.or(declared.weights.as_deref()).unwrap_or_default();
        let is_whole = |length: usize| length == 0 || length == targets;
        if !is_whole(given.len()) || declared.primitives.iter().any(|primitive| primitive.targets.len() != targets) {
            let subject = format!("mesh {index}: its primitives and weights differ in their number of morph targets");
            self.primitives.findings.add(FindingKind::BrokenRule, &subject, 1);
        }
        let mut weights: Vec<f64> = given.iter().take(targets).copied().collect();
        weights.resize(targets, 0.0);
        weights
    }

    fn read(&mut self, index: usize, declared: &MeshPrimitives, weights: &[f64]) -> Result<LoadedMesh, LoadProblem> {
        let place = format!("mesh {index}");
        let mut parts = Parts::default();
        let (mut masked, mut blended, mut not_triangles) = (0, 0, 0);
        for (number, primitive) in declared.primitives.iter().enumerate() {
            let place = format!("{place}, primitive {number}");
            let refused = |message: String| LoadProblem::element(&place, message);
            // Positions may be left out; then there is nothing to see.
            if primitive.mode.is_some_and(|mode| mode < 4) || !primitive.attributes.contains_key("POSITION") {
                not_triangles += 1;
                continue;
            }
            let geometry = self.primitives.read(primitive, weights, &place)?;
            match self.alpha_mode(primitive).map_err(refused)? {
                "OPAQUE" => {}
                "MASK" => masked += geometry.faces.len(),
                "BLEND" => blended += geometry.faces.len(),
                _ => {
                    let subject = format!("{place}: the alphaMode of its material is none of glTF's, taken as OPAQUE");
                    self.primitives.findings.add(FindingKind::BrokenRule, &subject, 1);
                }
            }
            parts.append(&geometry, self.wants_lightmaps).map_err(refused)?;
        }
        let lightmap = LightmapLayout::of(parts.lightmap).map(Arc::new);
        let mesh =
            Mesh::new(parts.positions, parts.triangles).map_err(|defect| LoadProblem::element(&place, defect))?;
        let morphs = declared.primitives.iter().any(|primitive| !primitive.targets.is_empty());
        Ok(LoadedMesh { mesh: Arc::new(mesh), masked, blended, not_triangles, morphs, lightmap })
    }

    fn alpha_mode(&self, primitive: &Primitive) -> Result<&'a str, String> {
        let Some(material) = primitive.material else { return Ok("OPAQUE") };
        Ok(element(&self.document.materials, material, "material")?.alpha_mode.as_deref().unwrap_or("OPAQUE"))
    }
}

impl Parts {
    /// Adds the triangles of a primitive and the vertices that they use.
    fn append(&mut self, geometry: &Geometry, wants_lightmap: bool) -> Result<(), String> {
        let mut used = geometry.faces.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let base = self.positions.len();
        if base + used.len() >= u32::MAX as usize {
            return Err("its mesh has more than 2^32 - 2 vertices".to_owned());
        }
        self.positions.extend(used.iter().map(|&vertex| geometry.vertices[vertex as usize]));
        if wants_lightmap {
            let texture = geometry.texture.as_ref();
            let corners = |face: &[u32; 3]| texture.map_or(NOWHERE, |uv| face.map(|corner| uv[corner as usize]));
            self.lightmap.extend(geometry.faces.iter().map(corners));
        }
        let place_of = |vertex: u32| (base + used.partition_point(|&other| other < vertex)) as u32;
        self.triangles.extend(geometry.faces.iter().map(|face| face.map(place_of)));
        Ok(())
    }
}
