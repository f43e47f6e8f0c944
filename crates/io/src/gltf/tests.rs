use std::path::Path;

use base64::Engine;
use serde_json::{Value, json};
use umbriel_scene::{Camera, Member, Projection, Shape};

use super::*;
use crate::{model::ModelObject, options::Outside};

mod bodies;
mod compressed;
mod lenient;
mod limits;
mod masks;
mod members;
mod motions;
mod pictures;
mod rooms;
mod rules;
mod unread;
mod views;

/// Bytes of a buffer, with the views and accessors that describe them.
#[derive(Clone, Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Data {
    fn add(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize, normalized: bool) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend(bytes);
        let view = self.views.len() - 1;
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind, "normalized": normalized
        }));
        self.accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        let accessor = self.add(&bytes, 5126, ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N], values.len(), false);
        let along = |axis: usize| values.iter().map(move |value| value[axis]);
        let min: Vec<f32> = (0..N).map(|axis| along(axis).fold(f32::INFINITY, f32::min)).collect();
        let max: Vec<f32> = (0..N).map(|axis| along(axis).fold(f32::NEG_INFINITY, f32::max)).collect();
        if min.iter().chain(&max).all(|bound| bound.is_finite()) {
            self.accessors[accessor]["min"] = json!(min);
            self.accessors[accessor]["max"] = json!(max);
        }
        accessor
    }
}

/// A document whose mesh 0 is a triangle (1 0 0), (0 1 0), (0 0 1), with the given nodes.
fn triangle(nodes: &Value) -> (Value, Data) {
    let mut data = Data::default();
    let positions = data.floats(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let primitive = json!({ "attributes": { "POSITION": positions } });
    let document = json!({ "asset": { "version": "2.0" }, "nodes": nodes, "meshes": [{ "primitives": [primitive] }] });
    (document, data)
}

fn folder() -> Folder {
    Folder::of_scene(Path::new("nowhere/scene.gltf"), Outside::Refused)
}

fn parse(input: (Value, Data)) -> Result<Model, LoadProblem> {
    parse_with(input, &reading())
}

/// As text with a data URI.
fn parse_with((mut document, data): (Value, Data), reading: &Reading) -> Result<Model, LoadProblem> {
    let encoded = base64::engine::general_purpose::STANDARD.encode(&data.bytes);
    let uri = format!("data:application/octet-stream;base64,{encoded}");
    let fill = |document: &mut Value, key: &str, value: Value| {
        if document.get(key).is_none() {
            document[key] = value;
        }
    };
    fill(&mut document, "buffers", json!([{ "uri": uri, "byteLength": data.bytes.len() }]));
    fill(&mut document, "bufferViews", data.views.into());
    fill(&mut document, "accessors", data.accessors.into());
    let used: Vec<_> = READ.iter().filter(|&&name| name != "KHR_mesh_quantization").collect();
    fill(&mut document, "extensionsUsed", json!(used));
    read(document.to_string().as_bytes(), &folder(), reading)
}

fn reading() -> Reading {
    Reading { lightmap_set: Some(1), ..Reading::default() }
}

fn model(input: (Value, Data)) -> Model {
    parse(input).unwrap_or_else(|problem| panic!("{problem}"))
}

fn refused(input: (Value, Data)) -> String {
    parse(input).expect_err("refused").to_string()
}

/// The document of [`triangle`] with one change.
fn changed(change: impl FnOnce(&mut Value, &mut Data)) -> (Value, Data) {
    let (mut document, mut data) = triangle(&json!([{ "mesh": 0 }]));
    change(&mut document, &mut data);
    (document, data)
}

fn mesh(object: &ModelObject) -> &umbriel_geometry::Mesh {
    match &object.shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("not a mesh: {other:?}"),
    }
}

fn names(model: &Model) -> Vec<&str> {
    model.objects.iter().map(|object| object.name.as_str()).collect()
}

fn found(model: Model) -> Vec<(FindingKind, String, usize)> {
    model.findings.into_list().into_iter().map(|found| (found.kind, found.subject, found.count)).collect()
}

fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let length = 12 + 8 + text.len() + 8 + binary.len();
    for word in [2, length as u32, text.len() as u32] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}

#[test]
fn matrices_multiply_from_the_root_in_f64() {
    let nodes = json!([
        { "name": "root", "children": [1], "translation": [0.1, 0, 0], "scale": [2, -3, 0.5] },
        { "name": "arm", "children": [2], "rotation": [0, 0, 1, 1] },
        { "mesh": 0, "matrix": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  10, 0, 0, 1] },
    ]);
    let model = model(triangle(&nodes));
    assert_eq!(names(&model), ["node2"]);
    // (10, 0, 0), turned by 90° about z, scaled, moved; 0.1 is the f64 one.
    let map = model.objects[0].map;
    assert_eq!(map.translation, glam::DVec3::new(0.1, -30.0, 0.0));
    assert_eq!(map.transform_point3(glam::DVec3::X), glam::DVec3::new(0.1, -33.0, 0.0));
    let families: Vec<_> = model.families.families.iter().map(|f| (f.name.as_str(), f.members.clone())).collect();
    assert_eq!(families, [("root", vec![Member::Family(1)]), ("arm", vec![Member::Object(0)])]);
    assert_eq!(model.families.roots, [Member::Family(0)]);
}

#[test]
fn nodes_share_their_mesh() {
    let model =
        model(triangle(&json!([{ "name": "a", "mesh": 0 }, { "name": "b", "mesh": 0, "scale": [-1, 1, 1] }, {}])));
    assert_eq!(names(&model), ["a", "b"]);
    assert!(std::ptr::eq(mesh(&model.objects[0]), mesh(&model.objects[1])));
    assert_eq!(model.families.roots, [Member::Object(0), Member::Object(1)]);
}

#[test]
fn the_scene_is_the_default_one_else_the_first_else_everything() {
    let nodes = json!([{ "name": "a", "mesh": 0 }, { "name": "b", "mesh": 0 }]);
    let with = |scenes: Value, scene: Value| {
        let (mut document, data) = triangle(&nodes);
        document["scenes"] = scenes;
        if !scene.is_null() {
            document["scene"] = scene;
        }
        parse((document, data))
    };
    let scenes = json!([{ "nodes": [1] }, { "nodes": [0] }]);
    assert_eq!(names(&with(scenes.clone(), json!(1)).expect("loads")), ["a"]);
    assert_eq!(names(&with(scenes.clone(), Value::Null).expect("loads")), ["b"]);
    assert_eq!(names(&with(json!([]), Value::Null).expect("loads")), ["a", "b"]);
    assert!(with(scenes, json!(2)).is_err() && with(json!([]), json!(0)).is_err());
    assert!(with(json!([{ "nodes": [7] }]), Value::Null).is_err());
    assert!(with(json!([{ "nodes": [0, 0] }]), Value::Null).is_err());
}

#[test]
fn hidden_nodes_show_nothing_and_nor_do_those_below() {
    let visible = |visible: bool| json!({ "KHR_node_visibility": { "visible": visible } });
    let (mut document, data) = triangle(&json!([
        { "name": "hidden", "mesh": 0, "children": [1], "extensions": visible(false) },
        { "name": "below", "mesh": 0, "camera": 0, "extensions": visible(true) },
        { "name": "shown", "mesh": 0, "extensions": visible(true) },
        { "extensions": { "KHR_node_visibility": { "visible": false }, "KHR_lights_punctual": { "light": 0 } } },
        { "extensions": { "KHR_lights_punctual": { "light": 0 } } }
    ]));
    document["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }]);
    document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    document["extensionsRequired"] = json!(["KHR_node_visibility"]);
    let shown = model((document.clone(), data.clone()));
    assert_eq!((names(&shown), shown.lights.len(), shown.camera.is_some()), (vec!["shown"], 1, true));
    assert!(found(shown).iter().all(|(kind, ..)| *kind != FindingKind::UnknownExtension));
    for fault in [json!({ "mesh": 9 }), json!({ "extensions": { "KHR_lights_punctual": { "light": 9 } } })] {
        let mut broken = document.clone();
        broken["nodes"][0].as_object_mut().expect("a node").remove("mesh");
        broken["nodes"][1].as_object_mut().expect("a node").extend(fault.as_object().expect("members").clone());
        assert!(parse((broken, data.clone())).is_err(), "{fault}");
    }
}

#[test]
fn broken_hierarchies_are_refused() {
    let message = |nodes: Value| refused(triangle(&nodes));
    assert!(message(json!([{ "children": [1] }, { "name": "x", "children": [0] }])).contains("cycle"));
    assert!(message(json!([{ "children": [0] }])).contains("cycle"));
    assert!(message(json!([{ "mesh": 0 }, { "children": [2] }, { "children": [1] }])).contains("cycle"));
    assert!(message(json!([{ "children": [2] }, { "children": [2] }, {}])).contains("child twice"));
    assert!(message(json!([{ "children": [1, 1] }, {}])).contains("child twice"));
    assert!(message(json!([{ "children": [9] }])).contains("child node 9"));
    assert!(message(json!([{ "mesh": 3 }])).contains("mesh 3"));
    assert!(message(json!([{ "mesh": 0, "rotation": [0, 0, 0, 0] }])).contains("rotation"));
    assert!(
        message(json!([{ "mesh": 0, "matrix": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }]))
            .contains("last row")
    );
    assert!(message(json!([{ "mesh": 0, "matrix": [1, 0] }])).contains("line 1"));
    // Depth costs no stack.
    let mut chain: Vec<_> = (1..50_000).map(|child| json!({ "children": [child] })).collect();
    chain.push(json!({ "mesh": 0 }));
    assert_eq!(model(triangle(&chain.into())).objects.len(), 1);
}

#[test]
fn indices_of_every_type_and_every_mode() {
    for (component, bytes) in [
        (5121, vec![0, 1, 2, 3]),
        (5123, [0u16, 1, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect()),
        (5125, [0u32, 1, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<u8>>()),
    ] {
        for (mode, expected) in [(5, vec![[0, 1, 2], [1, 3, 2]]), (6, vec![[1, 2, 0], [2, 3, 0]])] {
            let model = model(changed(|document, data| {
                let corners: Vec<_> = (0..9).map(|i| [i as f32, 0.5, 0.1]).collect();
                let positions = data.floats(&corners);
                let indices = data.add(&bytes, component, "SCALAR", 4, false);
                let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices, "mode": mode });
                document["meshes"][0]["primitives"] = json!([primitive]);
            }));
            let mesh = mesh(&model.objects[0]);
            assert_eq!(mesh.triangles(), expected);
            assert_eq!(mesh.positions().len(), 4, "only the vertices in use");
            assert_eq!(mesh.positions()[3].to_array(), [3.0, 0.5, f64::from(0.1_f32)], "32 bits become 64 exactly");
        }
    }
}

#[test]
fn all_primitives_are_one_mesh() {
    let model = model(changed(|document, data| {
        let other = data.floats(&[[5.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 7.0]]);
        document["materials"] = json!([{ "alphaMode": "MASK" }, { "alphaMode": "BLEND" }]);
        document["meshes"][0]["primitives"] = json!([
            { "attributes": { "POSITION": 0 } },
            { "attributes": { "POSITION": other }, "material": 0, "targets": [{ "POSITION": 0 }] },
            { "attributes": { "POSITION": other }, "material": 1 },
            { "attributes": { "POSITION": 0 }, "mode": 0 },
        ]);
    }));
    assert_eq!(mesh(&model.objects[0]).triangles(), [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    let expected = [
        (FindingKind::BlendAsOpaque, "node0".to_owned(), 1),
        (FindingKind::NotTriangles, "node0".to_owned(), 1),
        (FindingKind::Deformation, "node0".to_owned(), 1),
        (
            FindingKind::BrokenRule,
            "mesh 0: its primitives and weights differ in their number of morph targets".to_owned(),
            1,
        ),
        (FindingKind::MissingTexture, "material0".to_owned(), 1),
    ];
    assert_eq!(found(model), expected);
}

#[test]
fn what_is_no_gltf_is_told_in_words_of_the_format() {
    let read = |text: &[u8]| read(text, &Folder::of_scene(Path::new("scene.gltf"), Outside::Refused), &reading());
    let refused = |text: &str| read(text.as_bytes()).expect_err("refused").to_string();
    for text in ["", "glTX", "\u{feff}glTF"] {
        assert!(refused(text).contains("neither with the { of JSON nor with the glTF"), "{text}");
    }
    let with = |rest: &str| format!("{{\"asset\":{{\"version\":\"2.0\"}},{rest}}}");
    for (rest, words) in [
        (r#""cameras":[7]"#, "expected an object"),
        (r#""meshes":[7]"#, "expected an object"),
        (r#""accessors":[{"componentType":"5126","type":"VEC3","count":1}]"#, "expected a whole number, 0 or more"),
        (r#""materials":[{"alphaCutoff":"half"}]"#, "expected a number"),
    ] {
        let told = refused(&with(rest));
        assert!(told.ends_with(words) && !told.contains("struct"), "{told}");
    }
    let marked = read(format!("\u{feff}{}", with(r#""scenes":[]"#)).as_bytes()).expect("loads");
    let told = (FindingKind::BrokenRule, "file: a byte order mark before its text".to_owned(), 1);
    assert!(found(marked).contains(&told));
}

#[test]
fn bad_meshes_are_refused() {
    let message =
        |primitive: Value| refused(changed(|document, _| document["meshes"][0]["primitives"] = json!([primitive])));
    assert!(message(json!({ "attributes": { "POSITION": 4 } })).contains("accessor 4"));
    assert!(message(json!({ "attributes": { "POSITION": 0 }, "mode": 7 })).contains("mode 7"));
    assert!(message(json!({ "attributes": { "POSITION": 0 }, "indices": 0 })).contains("unsigned"));
    assert!(message(json!({ "attributes": { "POSITION": 0 }, "material": 0 })).contains("material 0"));
    let index = refused(changed(|document, data| {
        let indices = data.add(&[0, 1, 3], 5121, "SCALAR", 3, false);
        document["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    }));
    assert!(index.contains("mesh 0, primitive 0") && index.contains("index 2 is 3"), "{index}");
    let not_finite = refused(changed(|_, data| data.bytes[..4].copy_from_slice(&f32::NAN.to_le_bytes())));
    assert!(not_finite.contains("position 0: coordinate x is not finite"), "{not_finite}");
    let component = refused(changed(|_, data| data.accessors[0]["componentType"] = json!(5122)));
    assert!(component.contains("KHR_mesh_quantization"), "{component}");
    assert!(refused(changed(|_, data| data.accessors[0]["componentType"] = json!(5124))).contains("5124"));
    assert!(refused(changed(|_, data| data.accessors[0]["type"] = json!("VEC4"))).contains("VEC3"));
}

#[test]
fn corners_that_make_no_triangle_are_told() {
    let model = model(changed(|document, data| {
        let indices = data.add(&[0, 1, 2, 0], 5121, "SCALAR", 4, false);
        document["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    }));
    assert_eq!(mesh(&model.objects[0]).triangles(), [[0, 1, 2]]);
    let expected = (FindingKind::BrokenRule, "mesh 0, primitive 0: corners are left over".to_owned(), 1);
    assert_eq!(found(model), [expected]);
}

#[test]
fn sizes_are_checked_before_anything_is_allocated() {
    let huge = usize::MAX;
    for (key, value) in [
        ("count", json!(4)),
        ("count", json!(4_000_000_000_u64)),
        ("count", json!(huge)),
        ("byteOffset", json!(1)),
        ("byteOffset", json!(huge)),
        ("bufferView", json!(3)),
    ] {
        let message = refused(changed(|_, data| data.accessors[0][key] = value.clone()));
        assert!(message.contains("accessor 0, buffer view"), "{key} {value}: {message}");
    }
    for (key, value) in [
        ("byteLength", json!(37)),
        ("byteOffset", json!(huge)),
        ("byteStride", json!(8)),
        ("byteStride", json!(huge)),
        ("buffer", json!(1)),
    ] {
        let message = refused(changed(|_, data| data.views[0][key] = value.clone()));
        assert!(message.contains("buffer"), "{key} {value}: {message}");
    }
    for count in [1_u64 << 23, 4_000_000_000, u64::MAX] {
        let zeros = refused(changed(|_, data| {
            data.accessors[0] = json!({ "componentType": 5126, "type": "VEC3", "count": count })
        }));
        assert!(zeros.contains("decoded elements"), "{zeros}");
    }
    let negative = refused(changed(|_, data| data.accessors[0]["count"] = json!(-1)));
    assert!(negative.contains("line 1"), "{negative}");
}

#[test]
fn sparse_accessors_replace_zeros_or_values() {
    let sparse = |base: bool, places: &[u8]| {
        changed(|_, data| {
            let indices = data.add(places, 5121, "SCALAR", places.len(), false);
            let values = data.floats(&vec![[7.0, 8.0, 9.0]; places.len()]);
            if !base {
                data.accessors[0] = json!({ "componentType": 5126, "type": "VEC3", "count": 3 });
            }
            data.accessors[0]["sparse"] = json!({
                "count": places.len(),
                "indices": { "bufferView": indices, "componentType": 5121 },
                "values": { "bufferView": values },
            });
        })
    };
    let positions = |input| mesh(&model(input).objects[0]).positions().iter().map(|p| p.to_array()).collect::<Vec<_>>();
    assert_eq!(positions(sparse(true, &[1])), [[1.0, 0.0, 0.0], [7.0, 8.0, 9.0], [0.0, 0.0, 1.0]]);
    assert_eq!(positions(sparse(false, &[0, 2])), [[7.0, 8.0, 9.0], [0.0; 3], [7.0, 8.0, 9.0]]);
    for places in [&[3][..], &[1, 1], &[2, 0]] {
        assert!(refused(sparse(true, places)).contains("sparse"), "{places:?}");
    }
}

#[test]
fn quantized_positions_are_read_where_announced() {
    let model = model(changed(|document, data| {
        document["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let positions = data.add(&[127, 0, 0x80, 0, 127, 0, 0, 0, 64], 5120, "VEC3", 3, true);
        document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
    }));
    let positions: Vec<_> = mesh(&model.objects[0]).positions().iter().map(|p| p.to_array()).collect();
    assert_eq!(positions, [[1.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 64.0 / 127.0]]);
}

fn instanced(change: impl FnOnce(&mut Data) -> Value) -> (Value, Data) {
    let (mut document, mut data) = triangle(&json!([{ "name": "leaf", "mesh": 0, "translation": [100, 0, 0] }]));
    let attributes = change(&mut data);
    document["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    (document, data)
}

#[test]
fn instances_of_all_types() {
    let input = instanced(|data| {
        let translations = data.floats(&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        // 90° about y, and nothing.
        let turns: Vec<u8> = [0_i16, 23170, 0, 23170, 0, 0, 0, 32767].iter().flat_map(|c| c.to_le_bytes()).collect();
        let rotations = data.add(&turns, 5122, "VEC4", 2, true);
        let scales = data.floats(&[[1.0, 1.0, 1.0], [-2.0, 1.0, 1.0]]);
        json!({ "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": scales })
    });
    let model = model(input);
    assert_eq!(names(&model), ["leaf#0", "leaf#1"]);
    let moved = |object: usize| model.objects[object].map.transform_point3(glam::DVec3::X).to_array();
    assert_eq!((moved(0), moved(1)), ([101.0, 2.0, 2.0], [102.0, 5.0, 6.0]));
    assert_eq!(model.families.families[0].members, [Member::Object(0), Member::Object(1)]);
    assert!(found(model).is_empty());
    let small = instanced(|data| json!({ "ROTATION": data.add(&[0, 0, 127, 127], 5120, "VEC4", 1, true) }));
    assert_eq!(self::model(small).objects[0].map.transform_vector3(glam::DVec3::X), glam::DVec3::Y);
}

#[test]
fn bad_instances_are_refused() {
    assert!(refused(instanced(|_| json!({}))).contains("none of TRANSLATION"));
    assert!(refused(instanced(|data| json!({ "SCALE": data.floats(&[[1.0; 3]]), "_ID": 77 }))).contains("accessor 77"));
    let differ =
        |data: &mut Data| json!({ "TRANSLATION": data.floats(&[[0.0; 3]; 2]), "SCALE": data.floats(&[[1.0; 3]]) });
    assert!(refused(instanced(differ)).contains("number of instances"));
    let integers = |data: &mut Data| json!({ "TRANSLATION": data.add(&[0; 3], 5120, "VEC3", 1, false) });
    assert!(refused(instanced(integers)).contains("32-bit floats"));
    assert!(refused(instanced(|data| json!({ "ROTATION": data.floats(&[[0.0; 4]]) }))).contains("instance 0"));
}

#[test]
fn lights_shine_along_minus_z() {
    let with = |kind: &str, node: Value| {
        changed(|document, _| {
            let nodes = document["nodes"].as_array_mut().expect("nodes");
            nodes.push(node);
            nodes[1]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
            document["extensions"] =
                json!({ "KHR_lights_punctual": { "lights": [{ "name": "L", "type": kind, "spot": {} }] } });
        })
    };
    let sun = model(with("directional", json!({ "rotation": [-1, 0, 0, 1], "scale": [3, 3, 3] })));
    assert!(sun.lights[0].source.is_sun() && sun.lights[0].name == "L");
    assert_eq!(sun.lights[0].source.xyz(), glam::DVec3::new(0.0, 3.0, 0.0), "straight down, so the sun is above");
    let spot = model(with("spot", json!({ "name": "lamp", "translation": [1, 2, 3] })));
    assert_eq!(spot.lights[0].source.xyz(), glam::DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(found(spot), [(FindingKind::SpotAsPoint, "lamp".to_owned(), 1)]);
    assert!(found(model(with("point", json!({})))).is_empty());
    assert!(refused(with("area", json!({}))).contains("\"area\""));
    let flat = model(with("directional", json!({ "rotation": [-1, 0, 0, 1], "scale": [1, 1, 0] })));
    assert_eq!(flat.lights[0].source.xyz(), glam::DVec3::new(0.0, 1.0, 0.0), "scales do not turn light");
    let nowhere = model(with("directional", json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1] })));
    assert!(nowhere.lights.is_empty());
    assert!(found(nowhere)[0].1.contains("its light is left out"));
    let missing =
        changed(|document, _| document["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 2 } }));
    assert!(refused(missing).contains("light 2"));
}

#[test]
fn the_first_camera_of_the_scene_is_taken() {
    let perspective = |yfov: f64| json!({ "type": "perspective", "perspective": { "yfov": yfov, "znear": 0.1 } });
    let with = |camera: Value| {
        changed(|document, _| {
            document["cameras"] = json!([perspective(9.0), camera]);
            let nodes = document["nodes"].as_array_mut().expect("nodes");
            nodes.extend([json!({ "camera": 1, "translation": [1, 2, 3] }), json!({ "camera": 0 })]);
        })
    };
    let camera = model(with(perspective(std::f64::consts::FRAC_PI_2))).camera;
    let expected = Camera {
        eye: glam::DVec3::new(1.0, 2.0, 3.0),
        target: glam::DVec3::new(1.0, 2.0, 2.0),
        up: glam::DVec3::Y,
        projection: Projection::Perspective { vertical_degrees: 90.0 },
    };
    assert_eq!(camera, Some(expected));
    let camera = model(with(json!({ "orthographic": { "ymag": 2.5 } }))).camera.expect("a camera");
    assert_eq!(camera.projection, Projection::Orthographic { height: 5.0 });
    for (camera, fault) in [(perspective(4.0), "field of view"), (json!({}), "perspective or orthographic")] {
        let mut input = with(camera);
        input.0["nodes"][2] = json!({});
        input.0["cameras"][0] = perspective(1.0);
        let model = model(input);
        assert_eq!(model.camera, None);
        let found = found(model);
        assert!(matches!(&found[..], [(FindingKind::BrokenRule, told, 1)] if told.contains(fault)), "{found:?}");
    }
}

#[test]
fn extensions_are_told_or_refused() {
    let with = |key: &str, name: &str| changed(|document, _| document[key] = json!([name]));
    assert_eq!(
        found(model(with("extensionsUsed", "VENDOR_x"))),
        [(FindingKind::UnknownExtension, "VENDOR_x".to_owned(), 1)]
    );
    assert!(found(model(with("extensionsUsed", "KHR_materials_unlit"))).is_empty());
    assert!(parse(with("extensionsRequired", "KHR_texture_transform")).is_ok());
    assert!(refused(with("extensionsRequired", "VENDOR_x")).contains("VENDOR_x"));
    assert!(refused(changed(|document, _| document["asset"]["version"] = json!("1.0"))).contains("glTF 1.0"));
    assert!(refused(changed(|document, _| document["asset"]["minVersion"] = json!("2.1"))).contains("glTF 2.1"));
}

#[test]
fn binary_files_and_their_faults() {
    let (mut document, data) = triangle(&json!([{ "mesh": 0 }]));
    document["buffers"] = json!([{ "byteLength": data.bytes.len() }]);
    document["bufferViews"] = data.views.into();
    document["accessors"] = data.accessors.into();
    let whole = glb(&document, &data.bytes);
    let model = read(&whole, &folder(), &reading()).unwrap_or_else(|problem| panic!("{problem}"));
    assert_eq!(mesh(&model.objects[0]).triangles(), [[0, 1, 2]]);
    for length in 0..whole.len() {
        assert!(read(&whole[..length], &folder(), &reading()).is_err(), "cut off after {length} bytes");
    }
    // Chunks of other kinds stand behind the JSON and its buffer.
    for at in [12, whole.len() - data.bytes.len() - 8, whole.len()] {
        let mut bytes = whole.clone();
        bytes.splice(at..at, *b"\x04\0\0\0XYZ\0abcd");
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[8..12].copy_from_slice(&length);
        let found = found(read(&bytes, &folder(), &reading()).unwrap_or_else(|problem| panic!("{problem}")));
        assert_eq!(found.is_empty(), at == whole.len(), "{found:?}");
    }
    let with = |at: usize, value: u32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        read(&bytes, &folder(), &reading()).expect_err("refused").to_string()
    };
    assert!(with(4, 1).contains("version is 1"));
    assert!(with(8, u32::MAX).contains("4294967295"));
    assert!(with(12, u32::MAX).contains("chunk"));
    assert!(with(16, 7).contains("no JSON") || with(16, 7).contains("chunks"));
    document["buffers"][0]["byteLength"] = json!(data.bytes.len() + 1);
    assert!(
        read(&glb(&document, &data.bytes), &folder(), &reading()).expect_err("short").to_string().contains("buffer 0")
    );
}

#[test]
fn an_empty_binary_chunk_is_no_fault() {
    let document = json!({ "asset": { "version": "2.0" }, "nodes": [{}] });
    let found = |binary: &[u8]| {
        let model = read(&glb(&document, binary), &folder(), &reading()).unwrap_or_else(|problem| panic!("{problem}"));
        found(model).into_iter().map(|(_, subject, _)| subject).collect::<Vec<_>>()
    };
    assert_eq!(found(&[]), Vec::<String>::new());
    assert_eq!(
        found(&[0; 4]),
        ["unused: binary chunk: no buffer is for it: the first one has a URI, or there is none"]
    );
}

#[test]
fn buffers_come_from_files_in_the_folder() {
    let directory = tempfile::tempdir().expect("a folder");
    let folder = Folder::of_scene(&directory.path().join("scene.gltf"), Outside::Refused);
    let (mut document, data) = triangle(&json!([{ "mesh": 0 }]));
    std::fs::write(directory.path().join("my data.bin"), &data.bytes).expect("a file");
    document["bufferViews"] = data.views.into();
    document["accessors"] = data.accessors.into();
    let mut with = |uri: &str| {
        document["buffers"] = json!([{ "byteLength": data.bytes.len(), "uri": uri }]);
        read(document.to_string().as_bytes(), &folder, &Reading::default())
    };
    assert!(with("my%20data.bin").is_ok() && with("my data.bin").is_ok() && with("./my%20data.bin").is_ok());
    for outside in ["../my%20data.bin", "%2e%2e/my%20data.bin", "%2Fetc/hostname", "/etc/hostname"] {
        assert!(matches!(with(outside), Err(LoadProblem::Outside { .. })), "{outside}");
    }
    assert!(matches!(with("missing.bin"), Err(LoadProblem::Unreadable { .. })));
    let told = with(".\\my%20data.bin").map(found).expect("backslashes are slashes");
    assert!(told.iter().any(|(_, subject, _)| subject.contains("backslashes")), "{told:?}");
    assert!(with("..\\my%20data.bin").is_err());
    for refused in
        ["http://example.invalid/x.bin", "file:///etc/hostname", "data:;base64,?", "data:x", "data:,ab", "%ff"]
    {
        assert!(matches!(with(refused), Err(LoadProblem::Element { .. })), "{refused}");
    }
}

proptest::proptest! {
    /// A file with some bytes changed is read or refused; nothing panics.
    #[test]
    fn changed_bytes_are_survived(changes in proptest::collection::vec((0usize..2000, 0u8..=255), 1..6)) {
        let (mut document, data) = instanced(|data| json!({ "TRANSLATION": data.floats(&[[1.0, 2.0, 3.0]]) }));
        document["buffers"] = json!([{ "byteLength": data.bytes.len() }]);
        document["bufferViews"] = data.views.into();
        document["accessors"] = data.accessors.into();
        let mut bytes = glb(&document, &data.bytes);
        for (at, value) in changes {
            let at = at % bytes.len();
            bytes[at] = value;
        }
        let _ = read(&bytes, &folder(), &reading());
    }
}

#[test]
fn a_small_file_does_not_become_a_large_scene() {
    let zeros = |document: &mut Value, data: &mut Data, count: usize| {
        data.accessors.push(json!({ "componentType": 5126, "count": count, "type": "VEC3" }));
        let accessor = data.accessors.len() - 1;
        document["meshes"][0]["primitives"] = json!(vec![json!({ "attributes": { "POSITION": accessor } }); 100]);
        accessor
    };
    let primitives = refused(changed(|document, data| {
        zeros(document, data, 600_000);
    }));
    assert!(primitives.contains("decoded elements") && primitives.contains("at most"), "{primitives}");
    let instances = refused(changed(|document, data| {
        let accessor = zeros(document, data, 1_000_000);
        document["meshes"][0]["primitives"] = json!([{ "attributes": { "POSITION": 0 } }]);
        let attributes = json!({ "attributes": { "TRANSLATION": accessor } });
        document["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": attributes });
    }));
    assert!(instances.contains("1000000 objects"), "{instances}");
}

#[test]
fn what_a_node_or_primitive_names_is_told_with_its_name() {
    let mesh = refused(changed(|document, _| document["nodes"][0] = json!({ "name": "roof", "mesh": 4 })));
    assert_eq!(mesh, "node 0 (\"roof\"), mesh 4: there is none; the file has 1");
    let accessor = refused(changed(|document, _| {
        document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9);
    }));
    assert_eq!(accessor, "node 0, mesh 0, primitive 0, accessor 9: there is none; the file has 1");
    let both = json!({ "mesh": 0, "scale": [1, 1, 1], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] });
    let both = refused(changed(|document, _| document["nodes"][0] = both));
    assert!(both.contains("both a matrix and translation"), "{both}");
}

#[test]
fn the_second_texture_coordinates_lay_out_light_maps() {
    let with = |pairs: &[[f32; 2]]| {
        changed(|document, data| {
            let pairs = data.floats(pairs);
            document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = pairs.into();
            let bare = document["meshes"][0]["primitives"][0]["attributes"]["POSITION"].clone();
            let bare = json!({ "attributes": { "POSITION": bare, "TEXCOORD_0": 1 } });
            document["meshes"][0]["primitives"].as_array_mut().expect("primitives").push(bare);
        })
    };
    let model = model(with(&[[0.0, 0.5], [1.0, 0.25], [0.75, 1.0]]));
    let layout = model.objects[0].lightmap.as_ref().expect("a layout");
    assert_eq!(layout.triangles, [[[0.0, 0.5], [1.0, 0.25], [0.75, 1.0]], [[0.0; 2]; 3]]);
    assert!(super::tests::model(triangle(&json!([{ "mesh": 0 }]))).objects[0].lightmap.is_none());
    assert!(refused(with(&[[0.0, 0.5]])).contains("TEXCOORD_1: 1 elements for 3 vertices"));
    let wild = refused(with(&[[0.0, 0.5], [f32::NAN, 0.0], [0.0; 2]]));
    assert!(wild.contains("mesh 0, primitive 0, TEXCOORD_1: vertex 1 has a coordinate that is not finite"), "{wild}");
}
