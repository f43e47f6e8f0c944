//! Coloured triangle meshes as binary glTF 2.0 (Khronos, "glTF 2.0 Specification", section 4.4, GLB).
//!
//! ```text
//! | magic, version, length | JSON length, "JSON", text, spaces | BIN length, "BIN\0", bytes, zeros |
//! ```
//!
//! Each mesh is a node of its own. glTF stores positions as 32-bit floats; they are taken relative to the middle of
//! their mesh, which goes into the node's translation, so that a model far from the origin keeps its shape.

use std::io::{self, Write};

use serde_json::{Value, json};

/// A triangle mesh with a colour at every vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColoredMesh {
    /// The node's name.
    pub name: String,
    /// World coordinates, metres.
    pub positions: Vec<[f64; 3]>,
    /// One a position: red, green, blue in linear light, and opacity.
    pub colors: Vec<[u8; 4]>,
    /// Three indices of positions each, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Writes meshes as one GLB file; those without triangles are left out.
///
/// # Errors
/// What the system says; `InvalidInput` for a mesh whose colours or indices do not fit its positions, or for more than
/// the 4 GiB that the format can hold.
pub fn write_glb(meshes: &[ColoredMesh], out: &mut impl Write) -> io::Result<()> {
    let mut document = Document::default();
    for mesh in meshes.iter().filter(|mesh| !mesh.triangles.is_empty()) {
        check(mesh)?;
        document.add(mesh);
    }
    let mut text = serde_json::to_vec(&document.json())?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let bytes = document.bytes;
    let binary_chunk = if bytes.is_empty() { 0 } else { 8 + bytes.len() };
    let total = u32::try_from(12 + 8 + text.len() + binary_chunk).map_err(|_| invalid("the meshes exceed 4 GiB"))?;
    out.write_all(b"glTF")?;
    out.write_all(&2u32.to_le_bytes())?;
    out.write_all(&total.to_le_bytes())?;
    write_chunk(out, b"JSON", &text)?;
    if !bytes.is_empty() {
        write_chunk(out, b"BIN\0", &bytes)?;
    }
    Ok(())
}

fn invalid(message: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, message.into())
}

fn write_chunk(out: &mut impl Write, kind: &[u8; 4], content: &[u8]) -> io::Result<()> {
    // The sum of all chunks was checked against u32 before.
    out.write_all(&(content.len() as u32).to_le_bytes())?;
    out.write_all(kind)?;
    out.write_all(content)
}

fn check(mesh: &ColoredMesh) -> io::Result<()> {
    let vertices = mesh.positions.len();
    if mesh.colors.len() != vertices {
        return Err(invalid(format!("{}: {} colours for {vertices} vertices", mesh.name, mesh.colors.len())));
    }
    match mesh.triangles.iter().flatten().find(|&&index| index as usize >= vertices) {
        Some(index) => Err(invalid(format!("{}: vertex {index} of {vertices}", mesh.name))),
        None => Ok(()),
    }
}

/// The parts of a glTF document as they grow.
#[derive(Default)]
struct Document {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
}

impl Document {
    fn add(&mut self, mesh: &ColoredMesh) {
        let center = center(&mesh.positions);
        let local = |position: &[f64; 3]| -> [f32; 3] { std::array::from_fn(|i| (position[i] - center[i]) as f32) };
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(local).collect();
        let (min, max) = extent(&positions);
        let view = self.view(positions.as_flattened().iter().flat_map(|value| value.to_le_bytes()), ARRAY_BUFFER);
        let position = self.accessor(json!({
            "bufferView": view, "componentType": FLOAT, "count": positions.len(), "type": "VEC3",
            "min": min, "max": max,
        }));
        let view = self.view(mesh.colors.as_flattened().iter().copied(), ARRAY_BUFFER);
        let color = self.accessor(json!({
            "bufferView": view, "componentType": UNSIGNED_BYTE, "normalized": true, "count": mesh.colors.len(),
            "type": "VEC4",
        }));
        let indices = mesh.triangles.as_flattened().iter().flat_map(|index| index.to_le_bytes());
        let view = self.view(indices, ELEMENT_ARRAY_BUFFER);
        let indices = self.accessor(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": 3 * mesh.triangles.len(), "type": "SCALAR",
        }));
        let attributes = json!({ "POSITION": position, "COLOR_0": color });
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": 0 });
        self.nodes.push(json!({ "name": mesh.name, "mesh": self.meshes.len(), "translation": center }));
        self.meshes.push(json!({ "name": mesh.name, "primitives": [primitive] }));
    }

    /// Appends bytes to the buffer; all our elements are four bytes long, so every view starts aligned.
    fn view(&mut self, bytes: impl Iterator<Item = u8>, target: u32) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - start;
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": target }));
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// The JSON chunk. glTF allows no empty arrays.
    fn json(&self) -> Value {
        let asset = json!({ "version": "2.0", "generator": concat!("umbriel ", env!("CARGO_PKG_VERSION")) });
        if self.nodes.is_empty() {
            return json!({ "asset": asset });
        }
        json!({
            "asset": asset,
            "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": [{
                "name": "vertex colours",
                "doubleSided": true,
                "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
            }],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.bytes.len() }],
        })
    }
}

/// The middle of the bounding box.
fn center(positions: &[[f64; 3]]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let along = || positions.iter().map(|position| position[axis]);
        0.5 * along().fold(f64::INFINITY, f64::min) + 0.5 * along().fold(f64::NEG_INFINITY, f64::max)
    })
}

fn extent(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    positions.iter().fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(min, max), position| {
        (std::array::from_fn(|i| min[i].min(position[i])), std::array::from_fn(|i| max[i].max(position[i])))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(name: &str, offset: f64) -> ColoredMesh {
        ColoredMesh {
            name: name.to_owned(),
            positions: vec![[offset, 0.0, 0.0], [offset + 0.25, 0.0, 0.0], [offset, 0.5, 0.0]],
            colors: vec![[255, 128, 0, 255]; 3],
            triangles: vec![[0, 1, 2]],
        }
    }

    #[test]
    fn the_file_is_valid_and_keeps_its_shape_far_from_the_origin() {
        let mut bytes = Vec::new();
        write_glb(&[triangle("near", 0.0), ColoredMesh::default(), triangle("far", 1e7)], &mut bytes).expect("written");
        // The reader validates the document: index ranges, required fields, alignment.
        let glb = gltf::Gltf::from_slice(&bytes).expect("valid glTF");
        let blob = glb.blob.clone().expect("a binary chunk");
        assert_eq!(
            glb.nodes().map(|node| node.name().expect("a name").to_owned()).collect::<Vec<_>>(),
            ["near", "far"]
        );
        for (node, offset) in glb.nodes().zip([0.0, 1e7]) {
            let (translation, ..) = node.transform().decomposed();
            assert_eq!(f64::from(translation[0]), offset as f32 as f64 + if offset == 0.0 { 0.125 } else { 0.0 });
            let primitive = node.mesh().expect("a mesh").primitives().next().expect("a primitive");
            let reader = primitive.reader(|_| Some(&blob));
            let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
            assert_eq!(positions, [[-0.125, -0.25, 0.0], [0.125, -0.25, 0.0], [-0.125, 0.25, 0.0]]);
            assert_eq!(primitive.bounding_box().min, [-0.125, -0.25, 0.0]);
            assert_eq!(reader.read_indices().expect("indices").into_u32().collect::<Vec<_>>(), [0, 1, 2]);
            let colors: Vec<[u8; 4]> = reader.read_colors(0).expect("colours").into_rgba_u8().collect();
            assert_eq!(colors, [[255, 128, 0, 255]; 3]);
        }
        assert_eq!(bytes.len(), u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize);
        assert_eq!(bytes.len() % 4, 0);
    }

    #[test]
    fn nothing_to_show_is_still_a_file() {
        let mut bytes = Vec::new();
        write_glb(&[], &mut bytes).expect("written");
        assert_eq!(gltf::Gltf::from_slice(&bytes).expect("valid glTF").nodes().len(), 0);
    }

    #[test]
    fn meshes_that_do_not_fit_are_refused() {
        let mut short = triangle("short", 0.0);
        short.colors.pop();
        let mut wild = triangle("wild", 0.0);
        wild.triangles[0][1] = 3;
        for (mesh, expected) in [(short, "short: 2 colours"), (wild, "wild: vertex 3 of 3")] {
            let error = write_glb(&[mesh], &mut Vec::new()).expect_err("a defect");
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
