//! What stands inside of binary glTF: the container itself, compressed views and primitives, pictures. The bytes are put into a small
//! document that uses them, since decoders have no other door.

use serde_json::{Value, json};

use super::files::scene;

pub(super) fn glb(bytes: &[u8]) {
    scene("scene.glb", bytes);
}

/// Three bytes say how the view is compressed, its stride and its count.
pub(super) fn meshopt(bytes: &[u8]) {
    let Some((&[kind, stride, count], stream)) = bytes.split_first_chunk() else { return };
    let (kind, stride, count) = (usize::from(kind), usize::from(stride), usize::from(count) + 1);
    let mode = ["ATTRIBUTES", "TRIANGLES", "INDICES"][kind % 3];
    let filter = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"][kind / 3 % 5];
    let stride = if kind % 3 == 0 { 4 * (1 + stride % 16) } else { 2 * (1 + stride % 2) };
    let view = json!({ "buffer": 0, "byteLength": stream.len(), "byteStride": stride, "count": count, "mode": mode,
                       "filter": filter });
    let component = match (kind % 3, stride) {
        (0, 4) => 5120,
        (0, 8) => 5122,
        (0, _) => 5126,
        (_, 2) => 5123,
        _ => 5125,
    };
    let elements = |kind: &str| json!({ "bufferView": 0, "componentType": component, "type": kind, "count": count });
    let accessors = match kind % 3 {
        0 => json!([elements("VEC3")]),
        _ => json!([zeros("VEC3", 256), elements("SCALAR")]),
    };
    let mut primitive = json!({ "attributes": { "POSITION": 0 } });
    if kind % 3 != 0 {
        primitive["indices"] = json!(1);
    }
    let mut document = around(primitive, stream.len());
    document["extensionsUsed"] = json!(["KHR_mesh_quantization", "EXT_meshopt_compression"]);
    document["accessors"] = accessors;
    let length = count * stride;
    let own_stride = if kind % 3 == 0 { json!(stride) } else { Value::Null };
    document["bufferViews"] = json!([{ "buffer": 1, "byteLength": length, "byteStride": own_stride,
                                       "extensions": { "EXT_meshopt_compression": view } }]);
    let buffers = document["buffers"].as_array_mut().expect("buffers");
    buffers.push(json!({ "byteLength": length, "extensions": { "EXT_meshopt_compression": { "fallback": true } } }));
    scene("scene.glb", &packed(&document, stream));
}

/// The first byte is the number of the attribute that holds positions.
pub(super) fn draco(bytes: &[u8]) {
    let Some((&number, stream)) = bytes.split_first() else { return };
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 1, "extensions": { "KHR_draco_mesh_compression":
        { "bufferView": 0, "attributes": { "POSITION": number % 4 } } } });
    let mut document = around(primitive, stream.len());
    document["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    document["accessors"] = json!([zeros("VEC3", 4), zeros("SCALAR", 12)]);
    document["accessors"][1]["componentType"] = json!(5123);
    document["bufferViews"] = json!([{ "buffer": 0, "byteLength": stream.len() }]);
    scene("scene.glb", &packed(&document, stream));
}

/// A texture that cuts holes.
pub(super) fn picture(bytes: &[u8]) {
    let primitive = json!({ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 });
    let mut document = around(primitive, bytes.len());
    document["accessors"] = json!([zeros("VEC3", 3), zeros("VEC2", 3)]);
    document["bufferViews"] = json!([{ "buffer": 0, "byteLength": bytes.len() }]);
    document["images"] = json!([{ "bufferView": 0, "mimeType": "image/png" }]);
    document["textures"] = json!([{ "source": 0 }]);
    let texture = json!({ "baseColorTexture": { "index": 0 } });
    document["materials"] = json!([{ "alphaMode": "MASK", "pbrMetallicRoughness": texture }]);
    scene("scene.glb", &packed(&document, bytes));
}

fn zeros(kind: &str, count: usize) -> Value {
    json!({ "componentType": 5126, "type": kind, "count": count })
}

/// A document that shows one primitive, with a binary chunk.
fn around(primitive: Value, length: usize) -> Value {
    json!({ "asset": { "version": "2.0" }, "nodes": [{ "mesh": 0 }], "meshes": [{ "primitives": [primitive] }],
            "buffers": [{ "byteLength": length }] })
}

fn packed(document: &Value, binary: &[u8]) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], content: &[u8], padding: u8| {
        let length = content.len().next_multiple_of(4);
        let mut chunk = (length as u32).to_le_bytes().to_vec();
        chunk.extend(kind);
        chunk.extend(content);
        chunk.resize(8 + length, padding);
        chunk
    };
    let chunks = [chunk(b"JSON", document.to_string().as_bytes(), b' '), chunk(b"BIN\0", binary, 0)].concat();
    [b"glTF".as_slice(), &2u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}
