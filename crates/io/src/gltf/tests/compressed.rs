//! Draco primitives and meshopt views inside documents. The streams are from the encoders of the two references.

use super::*;

/// A tetrahedron with edges of 4 along the axes and texture coordinates (x, y) / 4, as Draco 1.5 writes it: sequentially
/// (the order is kept) and by its corner table. Attribute 0 are texture coordinates, 1 positions, on a grid of 11 bits.
const TETRAHEDRA: [&str; 2] = [
    "445241434f0202010000000404010002010001030102030200030102030902010000090300010002000000000000000000\
     00803f00000000000000000000803f00000000000000000001010003030120012003002084888101000000000400000000\
     000000000000000000000000e0ff440b",
    "445241434f02020101000000040401030000012f010110ff02664002000000ff0000010309020100000100090300010200\
     00000000000000000000000000803f00000000000000000000803f00000000010101000303011001300300508224910400\
     0000000400000000000000000000000000000000e0ff440b",
];

fn bytes(hex: &str) -> Vec<u8> {
    let digits: Vec<u8> = hex.bytes().filter(|digit| !digit.is_ascii_whitespace()).collect();
    let byte = |pair: &[u8]| u8::from_str_radix(str::from_utf8(pair).expect("text"), 16).expect("two digits");
    digits.chunks_exact(2).map(byte).collect()
}

fn compressed(stream: &[u8], change: impl FnOnce(&mut Value)) -> (Value, Data) {
    changed(|document, data| {
        let view = data.views.len();
        data.views.push(json!({ "buffer": 0, "byteOffset": data.bytes.len(), "byteLength": stream.len() }));
        data.bytes.extend(stream);
        data.accessors = vec![
            json!({ "componentType": 5126, "type": "VEC3", "count": 4 }),
            json!({ "componentType": 5126, "type": "VEC2", "count": 4 }),
            json!({ "componentType": 5123, "type": "SCALAR", "count": 12 }),
        ];
        document["meshes"][0]["primitives"][0] = json!({
            "attributes": { "POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 1 }, "indices": 2,
            "extensions": { "KHR_draco_mesh_compression": {
                "bufferView": view, "attributes": { "TEXCOORD_1": 0, "POSITION": 1 }
            } },
        });
        document["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
        document["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
        change(document);
    })
}

#[test]
fn draco_primitives_are_decoded() {
    for hex in TETRAHEDRA {
        let model = model(compressed(&bytes(hex), |_| ()));
        let mesh = mesh(&model.objects[0]);
        let mut corners: Vec<_> = mesh.positions().iter().map(|p| p.to_array().map(|x| x as i32)).collect();
        assert!(mesh.positions().iter().zip(&corners).all(|(p, c)| p.to_array() == c.map(f64::from)), "whole numbers");
        corners.sort_unstable();
        assert_eq!(corners, [[0, 0, 0], [0, 0, 4], [0, 4, 0], [4, 0, 0]]);
        // All four faces turn outward: six times the volume is the sum of their determinants.
        let volume = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|corner| mesh.positions()[corner as usize]);
            a.dot(b.cross(c))
        };
        assert_eq!(mesh.triangles().iter().map(volume).sum::<f64>(), 64.0);
        let layout = model.objects[0].lightmap.as_ref().expect("a layout");
        for (face, pairs) in mesh.triangles().iter().zip(&layout.triangles) {
            let expected = face.map(|corner| mesh.positions()[corner as usize]).map(|p| [p.x / 4.0, p.y / 4.0]);
            assert_eq!(*pairs, expected);
        }
        assert!(found(model).is_empty());
    }
}

#[test]
fn faults_of_draco_primitives_are_told_with_their_place() {
    let stream = bytes(TETRAHEDRA[1]);
    for length in 0..stream.len() - 1 {
        assert!(parse(compressed(&stream[..length], |_| ())).is_err(), "cut off after {length} bytes");
    }
    let place = "node 0, mesh 0, primitive 0, KHR_draco_mesh_compression";
    let message = refused(compressed(&stream[..40], |_| ()));
    assert!(message.starts_with(&format!("{place}: its stream is not read")), "{message}");
    let numbers = |draco: Value| {
        refused(compressed(&stream, |document| {
            document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = draco;
        }))
    };
    let missing = numbers(json!({ "bufferView": 1, "attributes": { "POSITION": 7 } }));
    assert_eq!(missing, format!("{place}: it has no attribute 7"));
    let other = numbers(json!({ "bufferView": 1, "attributes": { "POSITION": 0 } }));
    assert_eq!(other, format!("{place}: its attribute 0 has 2 components, needed are 3"));
    assert!(numbers(json!({ "bufferView": 9, "attributes": {} })).contains("buffer view 9"));
    let counts = compressed(&stream, |document| {
        document["accessors"] = json!([
            { "componentType": 5126, "type": "VEC3", "count": 5 },
            { "componentType": 5126, "type": "VEC2", "count": 4 },
            { "componentType": 5123, "type": "SCALAR", "count": 9 },
        ]);
    });
    let kinds: Vec<_> = found(model(counts)).into_iter().map(|(kind, ..)| kind).collect();
    assert_eq!(kinds, [FindingKind::BrokenRule; 3], "positions, indices, and the accessors among themselves");
}

#[test]
fn types_and_modes_of_draco_primitives_are_told() {
    let stream = bytes(TETRAHEDRA[0]);
    let told = |change: fn(&mut Value)| {
        let model = model(compressed(&stream, change));
        assert_eq!(mesh(&model.objects[0]).triangles().len(), 4);
        found(model).into_iter().map(|(_, subject, _)| subject).collect::<Vec<_>>()
    };
    let strip = |count: u32| {
        json!([{ "componentType": 5126, "type": "VEC3", "count": 4 }, { "componentType": 5126, "type": "VEC2", "count": 4 },
            { "componentType": 5123, "type": "SCALAR", "count": count }])
    };
    let accessors = [strip(6), strip(12)];
    let [six, twelve] = &accessors;
    let of = |mode: u32, accessors: &Value| {
        let model = model(compressed(&stream, |document| {
            document["meshes"][0]["primitives"][0]["mode"] = json!(mode);
            document["accessors"] = accessors.clone();
        }));
        found(model).into_iter().map(|(_, subject, _)| subject).collect::<Vec<_>>()
    };
    assert!(of(5, six).is_empty() && of(4, twelve).is_empty(), "{:?}", of(5, six));
    let place = "mesh 0, primitive 0, KHR_draco_mesh_compression";
    assert_eq!(of(4, six), [format!("{place}: indices are more or fewer than their accessor's")]);
    assert_eq!(of(6, twelve), [format!("{place}: its mode is neither of triangles nor of strips")]);
    let shorts = told(|document| {
        document["accessors"] = json!([
            { "componentType": 5122, "type": "VEC3", "count": 4 },
            { "componentType": 5126, "type": "VEC2", "count": 4 },
            { "componentType": 5123, "type": "SCALAR", "count": 12 },
        ]);
    });
    assert_eq!(shorts, [format!("{place}: POSITION has another type of components than its accessor")]);
}

proptest::proptest! {
    /// A stream with some bytes changed is read or refused; nothing panics.
    #[test]
    fn changed_draco_streams_are_survived(changes in proptest::collection::vec((0usize..200, 0u8..=255), 1..6)) {
        for hex in TETRAHEDRA {
            let mut stream = bytes(hex);
            let length = stream.len();
            changes.iter().for_each(|(at, value)| stream[at % length] = *value);
            let _ = parse(compressed(&stream, |_| ()));
        }
    }
}

/// The three corners of [`triangle`], each the difference from the one before, byte by byte, in streams of both versions:
/// one group of 16, of which three count.
fn meshopt(extension: &str, change: impl FnOnce(&mut Value)) -> (Value, Data) {
    changed(|document, data| {
        let elements = data.bytes.clone();
        let mut stream = vec![0xa0];
        for byte in 0..12 {
            stream.push(3);
            let value = |row: usize| row.checked_sub(1).map_or(0, |row| elements[12 * row.min(2) + byte]);
            stream.extend((1..=16).map(|row| {
                let step = value(row).wrapping_sub(value(row - 1)) as i8;
                ((step << 1) ^ (step >> 7)) as u8
            }));
        }
        stream.extend([0; 32]);
        let offset = data.bytes.len();
        let length = stream.len();
        data.bytes.extend(stream);
        data.views[0] = json!({ "buffer": 0, "byteOffset": 40, "byteLength": 36, "byteStride": 12, "extensions": { extension: {
            "buffer": 0, "byteOffset": offset, "byteLength": length, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES",
        } } });
        document["extensionsRequired"] = json!([extension]);
        change(&mut data.views[0]["extensions"][extension]);
    })
}

#[test]
fn compressed_views_stand_for_their_elements() {
    for extension in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let model = model(meshopt(extension, |_| ()));
        let positions: Vec<_> = mesh(&model.objects[0]).positions().iter().map(|p| p.to_array()).collect();
        assert_eq!(positions, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert!(found(model).is_empty(), "what lies at the view itself does not count");
    }
}

#[test]
fn strides_of_compressed_views_that_differ_are_told() {
    let with = |stride: Option<u32>| {
        let (document, mut data) = meshopt("EXT_meshopt_compression", |_| ());
        match stride {
            Some(stride) => data.views[0]["byteStride"] = json!(stride),
            None => drop(data.views[0].as_object_mut().expect("a view").remove("byteStride")),
        }
        data.accessors[0]["count"] = json!(if stride == Some(16) { 2 } else { 3 });
        let model = model((document, data));
        let second = model.objects.first().map(|object| mesh(object).positions()[1]);
        (second, found(model).into_iter().map(|(_, subject, _)| subject).collect::<Vec<_>>())
    };
    for stride in [Some(12), None] {
        assert_eq!(with(stride), (Some(glam::DVec3::Y), Vec::new()));
    }
    let (_, told) = with(Some(16));
    assert!(told.contains(&"buffer view 0: its stride is not that of its compressed content".to_owned()), "{told:?}");
}

#[test]
fn buffers_that_stand_for_compressed_content_need_no_bytes() {
    let (mut document, mut data) = meshopt("EXT_meshopt_compression", |_| ());
    let uri = base64::engine::general_purpose::STANDARD.encode(&data.bytes);
    let own = json!({ "uri": format!("data:application/octet-stream;base64,{uri}"), "byteLength": data.bytes.len() });
    document["buffers"] = json!([own, { "byteLength": 36 }]);
    data.views[0]["buffer"] = json!(1);
    data.views[0]["byteOffset"] = json!(0);
    assert!(found(model((document.clone(), data.clone()))).is_empty());
    data.views.push(json!({ "buffer": 1, "byteLength": 36 }));
    let found = found(model((document, data)));
    assert!(matches!(&found[..], [(_, told, 1)] if told.contains("buffer 1: it has no uri")), "{found:?}");
}

#[test]
fn faults_of_compressed_views_are_told_with_their_place() {
    let message = |key: &str, value: Value| refused(meshopt("EXT_meshopt_compression", |view| view[key] = value));
    let place = "node 0, mesh 0, primitive 0, accessor 0, buffer view 0, EXT_meshopt_compression: ";
    for (key, value, fault) in [
        ("count", json!(4), "4 elements of 12 bytes are not the 36 bytes of its view"),
        ("count", json!(usize::MAX), "are not the 36 bytes"),
        ("byteOffset", json!(usize::MAX), "leave buffer 0"),
        ("byteLength", json!(100_000), "leave buffer 0"),
        ("byteLength", json!(100), "its stream ends too early"),
        ("byteOffset", json!(0), "which is not the header"),
        ("filter", json!("QUATERNION"), "stride of 12"),
    ] {
        let message = message(key, value);
        assert!(message.starts_with(place) && message.contains(fault), "{message}");
    }
    assert!(message("buffer", json!(9)).contains("buffer 9"));
    assert!(message("mode", json!("OTHER")).contains("OTHER"));
}
