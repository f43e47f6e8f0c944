//! Meshes: all primitives of a glTF mesh as one triangle mesh, made once and shared.

use std::{collections::HashMap, rc::Rc, sync::Arc};

use umbriel_geometry::{Mesh, accept_point};

use super::{
    accessor::{Accessors, Component, within},
    json::{Document, Primitive, element, existing},
};
use crate::{
    error::LoadProblem,
    lightmap::{LightmapLayout, NOWHERE},
};

/// A mesh, and what of it was taken otherwise than the file says.
#[derive(Clone, Debug)]
pub(super) struct LoadedMesh {
    pub(super) mesh: Arc<Mesh>,
    /// Triangles with a MASK material.
    pub(super) masked: usize,
    /// Triangles with a BLEND material.
    pub(super) blended: usize,
    /// Primitives of points or lines.
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

/// The meshes of a document, read when first asked for.
#[derive(Debug)]
pub(super) struct Meshes<'a> {
    document: &'a Document,
    accessors: &'a Accessors<'a>,
    quantized: bool,
    /// Which texture coordinates lay out light maps.
    lightmap_set: Option<u32>,
    loaded: HashMap<usize, LoadedMesh>,
    /// Exporters like to share one vertex buffer among many primitives: it is decoded once.
    positions: HashMap<usize, Rc<Vec<[f64; 3]>>>,
}

impl<'a> Meshes<'a> {
    pub(super) fn new(document: &'a Document, accessors: &'a Accessors<'a>, lightmap_set: Option<u32>) -> Self {
        let quantized = document.extensions_used.iter().any(|name| name == "KHR_mesh_quantization");
        Self { document, accessors, quantized, lightmap_set, loaded: HashMap::new(), positions: HashMap::new() }
    }

    /// The mesh of that index; the same one every time.
    pub(super) fn get(&mut self, index: usize) -> Result<&LoadedMesh, LoadProblem> {
        if !self.loaded.contains_key(&index) {
            let mesh = self.read(index)?;
            self.loaded.insert(index, mesh);
        }
        Ok(&self.loaded[&index])
    }

    fn read(&mut self, index: usize) -> Result<LoadedMesh, LoadProblem> {
        let place = format!("mesh {index}");
        let declared = existing(&self.document.meshes, index, "mesh")?;
        let mut parts = Parts::default();
        let (mut masked, mut blended, mut not_triangles) = (0, 0, 0);
        for (number, primitive) in declared.primitives.iter().enumerate() {
            let place = format!("{place}, primitive {number}");
            let refused = |message: String| LoadProblem::element(&place, message);
            let mode = primitive.mode.unwrap_or(4);
            if mode < 4 {
                not_triangles += 1;
                continue;
            }
            let before = parts.triangles.len();
            self.append(primitive, mode, &place, &mut parts)?;
            let added = parts.triangles.len() - before;
            match self.alpha_mode(primitive).map_err(refused)? {
                "MASK" => masked += added,
                "BLEND" => blended += added,
                _ => {}
            }
        }
        let lightmap = LightmapLayout::of(parts.lightmap).map(Arc::new);
        let mesh =
            Mesh::new(parts.positions, parts.triangles).map_err(|defect| LoadProblem::element(&place, defect))?;
        let morphs = declared.primitives.iter().any(|primitive| !primitive.targets.is_empty());
        Ok(LoadedMesh { mesh: Arc::new(mesh), masked, blended, not_triangles, morphs, lightmap })
    }

    /// Adds the triangles of a primitive and the vertices that they use.
    fn append(&mut self, primitive: &Primitive, mode: u32, place: &str, parts: &mut Parts) -> Result<(), LoadProblem> {
        let refused = |message: String| LoadProblem::element(place, message);
        let Some(&accessor) = primitive.attributes.get("POSITION") else {
            return Err(refused("it has no POSITION attribute".to_owned()));
        };
        let vertices = self.positions(accessor).map_err(|problem| within(problem, place))?;
        let count = u32::try_from(vertices.len()).map_err(|_| refused("it has more than 2^32 vertices".to_owned()))?;
        let corners = match primitive.indices {
            Some(indices) => self.accessors.indices(indices).map_err(|problem| within(problem, place))?,
            None => {
                self.accessors.count(vertices.len())?;
                (0..count).collect()
            }
        };
        if let Some((at, index)) = corners.iter().enumerate().find(|&(_, &index)| index >= count) {
            return Err(refused(format!("index {at} is {index}, but there are {count} vertices")));
        }
        let mut used = corners.clone();
        used.sort_unstable();
        used.dedup();
        let base = parts.positions.len();
        if base + used.len() >= u32::MAX as usize {
            return Err(refused("its mesh has more than 2^32 - 2 vertices".to_owned()));
        }
        parts.positions.extend(used.iter().map(|&vertex| vertices[vertex as usize]));
        let place_of = |vertex: u32| (base + used.partition_point(|&other| other < vertex)) as u32;
        let faces = triangles_of(mode, &corners).map_err(refused)?;
        if self.lightmap_set.is_some() {
            let layout = self.texture_coordinates(primitive, vertices.len(), place)?;
            let corners =
                |face: &[u32; 3]| layout.as_ref().map_or(NOWHERE, |uv| face.map(|corner| uv[corner as usize]));
            parts.lightmap.extend(faces.iter().map(corners));
        }
        parts.triangles.extend(faces.into_iter().map(|face| face.map(place_of)));
        Ok(())
    }

    /// The texture coordinates that lay out light maps, one pair a vertex, if the primitive has them.
    fn texture_coordinates(
        &self,
        primitive: &Primitive,
        vertices: usize,
        place: &str,
    ) -> Result<Option<Vec<[f64; 2]>>, LoadProblem> {
        let Some(set) = self.lightmap_set else { return Ok(None) };
        let name = format!("TEXCOORD_{set}");
        let Some(&accessor) = primitive.attributes.get(&name) else { return Ok(None) };
        let refused = |message: String| LoadProblem::element(format!("{place}, {name}"), message);
        let pairs = self.accessors.vectors::<2>(accessor).map_err(|problem| within(problem, place))?;
        if pairs.len() != vertices {
            return Err(refused(format!("{} pairs for {vertices} vertices", pairs.len())));
        }
        match pairs.iter().position(|pair| !pair.iter().all(|coordinate| coordinate.is_finite())) {
            Some(vertex) => Err(refused(format!("vertex {vertex} has a coordinate that is not finite"))),
            None => Ok(Some(pairs)),
        }
    }

    /// The positions of an accessor, each one accepted, used or not.
    fn positions(&mut self, index: usize) -> Result<Rc<Vec<[f64; 3]>>, LoadProblem> {
        if let Some(positions) = self.positions.get(&index) {
            return Ok(Rc::clone(positions));
        }
        let place = format!("accessor {index}");
        let (_, component) = self.accessors.declared(index)?;
        if component != Component::F32 && !self.quantized {
            let message = "positions must be 32-bit floats, unless the file uses KHR_mesh_quantization";
            return Err(LoadProblem::element(place, message));
        }
        let positions = self.accessors.vectors::<3>(index)?;
        for (vertex, &position) in positions.iter().enumerate() {
            accept_point(position).map_err(|(axis, defect)| {
                LoadProblem::element(&place, format!("position {vertex}: coordinate {axis} {defect}"))
            })?;
        }
        let positions = Rc::new(positions);
        self.positions.insert(index, Rc::clone(&positions));
        Ok(positions)
    }

    fn alpha_mode(&self, primitive: &Primitive) -> Result<&'a str, String> {
        let Some(material) = primitive.material else { return Ok("OPAQUE") };
        let mode = element(&self.document.materials, material, "material")?.alpha_mode.as_deref().unwrap_or("OPAQUE");
        match mode {
            "OPAQUE" | "MASK" | "BLEND" => Ok(mode),
            _ => Err(format!("material {material}: its alphaMode \"{mode}\" is none of OPAQUE, MASK, BLEND")),
        }
    }
}

/// The triangles of a list (4), a strip (5) or a fan (6), wound as glTF says.
fn triangles_of(mode: u32, corners: &[u32]) -> Result<Vec<[u32; 3]>, String> {
    match mode {
        4 if !corners.len().is_multiple_of(3) => {
            Err(format!("its {} corners are no whole number of triangles", corners.len()))
        }
        4 => Ok(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()),
        5 => {
            let turned = |(i, c): (usize, &[u32])| if i % 2 == 0 { [c[0], c[1], c[2]] } else { [c[0], c[2], c[1]] };
            Ok(corners.windows(3).enumerate().map(turned).collect())
        }
        6 => {
            let hub = corners.first().copied().unwrap_or_default();
            Ok(corners.get(1..).unwrap_or_default().windows(2).map(|c| [c[0], c[1], hub]).collect())
        }
        _ => Err(format!("its mode {mode} is none of glTF's (0 to 6)")),
    }
}

#[cfg(test)]
mod tests {
    use super::triangles_of;

    #[test]
    fn strips_and_fans_keep_their_orientation() {
        assert_eq!(triangles_of(4, &[0, 1, 2, 2, 1, 3]), Ok(vec![[0, 1, 2], [2, 1, 3]]));
        assert_eq!(triangles_of(5, &[0, 1, 2, 3, 4]), Ok(vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]]));
        assert_eq!(triangles_of(6, &[7, 1, 2, 3]), Ok(vec![[1, 2, 7], [2, 3, 7]]));
        assert_eq!(triangles_of(5, &[0, 1]), Ok(Vec::new()));
        assert_eq!(triangles_of(6, &[]), Ok(Vec::new()));
        assert!(triangles_of(4, &[0, 1]).is_err() && triangles_of(7, &[0, 1, 2]).is_err());
    }
}
