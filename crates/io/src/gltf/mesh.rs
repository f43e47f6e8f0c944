//! Meshes: all primitives of a glTF mesh as one triangle mesh, made once for each set of morph weights and shared.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use umbriel_geometry::{
    Mesh,
    cut_out::{CutOut, CutOutPart, Filter, MOST_PLACE, TexturePoint, Wrap},
};
use umbriel_scene::FindingKind;

use super::{
    accessor::Accessors,
    json::{Document, Material, MeshPrimitives, Primitive, element, existing},
    primitive::{Geometry, Primitives},
    textures::{MaskMaterial, Textures},
};
use crate::{
    error::LoadProblem,
    lightmap::{LightmapLayout, NOWHERE},
    load::Reading,
    model::Findings,
    names::brief_name,
    options::Blend,
};

/// A mesh, and what of it was taken otherwise than the file says.
#[derive(Clone, Debug)]
pub(super) struct LoadedMesh {
    pub(super) mesh: Arc<Mesh>,
    /// Triangles with a MASK material that are taken as opaque all the same.
    pub(super) masked: usize,
    /// Triangles with a BLEND material, and what that is told as.
    pub(super) blended: usize,
    pub(super) blend: FindingKind,
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
    cut_outs: Vec<CutOutPart>,
}

/// Which mesh, and the bits of the weights that a node gives its morph targets.
type Key = (usize, Option<Vec<u64>>);

/// The meshes of a document, read when first asked for.
#[derive(Debug)]
pub(super) struct Meshes<'a> {
    document: &'a Document,
    primitives: Primitives<'a>,
    textures: Textures<'a>,
    reading: Reading,
    loaded: HashMap<Key, LoadedMesh>,
}

impl<'a> Meshes<'a> {
    pub(super) fn new(document: &'a Document, accessors: &'a Accessors<'a>, reading: &Reading) -> Self {
        let quantized = document.uses("KHR_mesh_quantization");
        let primitives = Primitives::new(accessors, quantized, reading.lightmap_set);
        let textures = Textures::new(document, accessors);
        Self { document, primitives, textures, reading: *reading, loaded: HashMap::new() }
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

    /// The rules that were found broken, here and in what no node shows.
    pub(super) fn into_findings(mut self) -> Findings {
        let shown: HashSet<usize> = self.loaded.keys().map(|&(mesh, _)| mesh).collect();
        for (index, mesh) in self.document.meshes.iter().enumerate() {
            for (number, primitive) in mesh.primitives.iter().enumerate() {
                let is_shown = shown.contains(&index) && has_triangles(primitive);
                self.primitives.check_rest(primitive, is_shown, &format!("mesh {index}, primitive {number}"));
            }
        }
        self.primitives.findings
    }

    /// As many weights as there are morph targets.
    fn weights(&mut self, index: usize, declared: &MeshPrimitives, own: Option<&[f64]>) -> Vec<f64> {
        let targets = declared.primitives.iter().map(|primitive| primitive.targets.len()).max().unwrap_or(0);
        let of_mesh = declared.weights.as_deref();
        let given = own.or(of_mesh).unwrap_or_default();
        let is_whole = |weights: &[f64]| weights.is_empty() || weights.len() == targets;
        if ![own, of_mesh].into_iter().flatten().all(is_whole)
            || declared.primitives.iter().any(|primitive| primitive.targets.len() != targets)
        {
            let subject = format!("mesh {index}: its primitives and weights differ in their number of morph targets");
            self.primitives.findings.add(FindingKind::BrokenRule, &subject, 1);
        }
        let mut weights: Vec<f64> = given.iter().take(targets).copied().collect();
        weights.resize(targets, 0.0);
        weights
    }

    fn read(&mut self, index: usize, declared: &'a MeshPrimitives, weights: &[f64]) -> Result<LoadedMesh, LoadProblem> {
        let place = format!("mesh {index}");
        let mut parts = Parts::default();
        let (mut masked, mut blended, mut not_triangles) = (0, 0, 0);
        for (number, primitive) in declared.primitives.iter().enumerate() {
            let place = format!("{place}, primitive {number}");
            let refused = |message: String| LoadProblem::element(&place, message);
            // A mesh is read again for every set of weights.
            self.primitives.count()?;
            // Positions may be left out; then there is nothing to see.
            if !has_triangles(primitive) {
                not_triangles += 1;
                continue;
            }
            let material = self.material(primitive).map_err(refused)?;
            let mode = material.and_then(|material| material.alpha_mode.as_deref()).unwrap_or("OPAQUE");
            let mask = match (mode, material) {
                ("MASK", Some(material)) => Some(self.textures.mask(material)?),
                _ => None,
            };
            let geometry = self.primitives.read(primitive, weights, mask.as_ref(), &place)?;
            let faces = geometry.faces.len();
            match mode {
                "OPAQUE" | "MASK" => {}
                "BLEND" => blended += faces,
                // Told where the document is checked.
                _ => {}
            }
            let cut_out = match mask {
                Some(mask) => self.cut_out(primitive.material.unwrap_or_default(), mask, &geometry),
                None if mode == "BLEND" && self.reading.blend == Blend::Ignore => Some(nothing(&geometry)),
                None => None,
            };
            masked += if mode == "MASK" && cut_out.is_none() { faces } else { 0 };
            parts.append(geometry, cut_out, self.reading.lightmap_set.is_some()).map_err(refused)?;
        }
        let morphs = declared.primitives.iter().any(|primitive| !primitive.targets.is_empty());
        let blend = match self.reading.blend {
            Blend::Block => FindingKind::BlendAsOpaque,
            Blend::Ignore => FindingKind::BlendIgnored,
        };
        let (mesh, lightmap) = parts.finish(&place)?;
        Ok(LoadedMesh { mesh, masked, blended, blend, not_triangles, morphs, lightmap })
    }

    fn material(&self, primitive: &Primitive) -> Result<Option<&'a Material>, String> {
        primitive.material.map(|material| element(&self.document.materials, material, "material")).transpose()
    }

    /// How the vertices of a primitive are cut out; `None` if they are taken as opaque.
    fn cut_out(&mut self, number: usize, mask: MaskMaterial, geometry: &Geometry) -> Option<VertexCutOut> {
        let name = self.document.materials[number].name.as_deref().filter(|name| !name.is_empty());
        let subject = name.map_or_else(|| format!("material{number}"), brief_name);
        let faces = geometry.faces.len();
        if let Some(reason) = &mask.missing {
            self.primitives.findings.add_with(FindingKind::MissingTexture, &subject, faces, reason);
        } else if mask.cut_out.map.is_some() && geometry.mask.places.is_none() {
            let reason = "the primitive has no such texture coordinates";
            self.primitives.findings.add_with(FindingKind::MissingTexture, &subject, faces, reason);
        }
        let map = mask.cut_out.map.clone().filter(|_| geometry.mask.places.is_some());
        let place = |vertex: usize| match (&geometry.mask.places, mask.reference) {
            (Some(places), Some(reference)) => reference.moved(places[vertex]),
            _ => [0.0; 2],
        };
        let alpha = |vertex: usize| geometry.mask.alphas.as_ref().map_or(1.0, |alphas| alphas[vertex]);
        let vertices = (0..geometry.vertices.len())
            .map(|vertex| TexturePoint { place: place(vertex), alpha: alpha(vertex) })
            .collect();
        let cut_out = VertexCutOut { cut_out: CutOut { map, ..mask.cut_out }, vertices };
        let is_near = |vertex: &TexturePoint| vertex.place.iter().all(|coordinate| coordinate.abs() <= MOST_PLACE);
        cut_out.vertices.iter().all(is_near).then_some(cut_out)
    }
}

/// How a primitive is cut out, vertex by vertex.
struct VertexCutOut {
    cut_out: CutOut,
    vertices: Vec<TexturePoint>,
}

/// Whether a primitive has triangles: neither points nor lines, and with positions.
fn has_triangles(primitive: &Primitive) -> bool {
    primitive.mode.is_none_or(|mode| mode >= 4) && primitive.attributes.contains_key("POSITION")
}

/// A cut-out that leaves nothing.
fn nothing(geometry: &Geometry) -> VertexCutOut {
    let cut_out = CutOut { map: None, filter: Filter::Nearest, wrap: [Wrap::Repeat; 2], factor: 0.0, cutoff: 1.0 };
    VertexCutOut { cut_out, vertices: vec![TexturePoint { place: [0.0; 2], alpha: 1.0 }; geometry.vertices.len()] }
}

impl Parts {
    /// Adds the triangles of a primitive and their vertices.
    fn append(
        &mut self,
        geometry: Geometry,
        cut_out: Option<VertexCutOut>,
        wants_lightmap: bool,
    ) -> Result<(), String> {
        let base = self.positions.len();
        if base + geometry.vertices.len() >= u32::MAX as usize {
            return Err("its mesh has more than 2^32 - 2 vertices".to_owned());
        }
        let (base, first) = (base as u32, self.triangles.len() as u32);
        self.positions.extend(geometry.vertices);
        if wants_lightmap {
            let texture = geometry.texture.as_ref();
            let corners = |face: &[u32; 3]| texture.map_or(NOWHERE, |uv| face.map(|corner| uv[corner as usize]));
            self.lightmap.extend(geometry.faces.iter().map(corners));
        }
        self.triangles.extend(geometry.faces.iter().map(|face| face.map(|corner| base + corner)));
        if let Some(VertexCutOut { cut_out, vertices }) = cut_out {
            let faces = first..self.triangles.len() as u32;
            self.cut_outs.push(CutOutPart { faces, cut_out, first_vertex: base, vertices });
        }
        Ok(())
    }

    fn finish(self, place: &str) -> Result<(Arc<Mesh>, Option<Arc<LightmapLayout>>), LoadProblem> {
        let refused = |defect: &dyn std::fmt::Display| LoadProblem::element(place, defect);
        let lightmap = LightmapLayout::of(self.lightmap).map(Arc::new);
        let mesh = Mesh::new(self.positions, self.triangles).map_err(|defect| refused(&defect))?;
        let mesh = mesh.with_cut_outs(self.cut_outs).map_err(|defect| refused(&defect))?;
        Ok((Arc::new(mesh), lightmap))
    }
}
