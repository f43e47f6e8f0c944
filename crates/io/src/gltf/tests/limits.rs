//! Small files that would take gigabytes or hours if what they repeat was done again each time.

use super::*;
use crate::options::Blend;

#[test]
fn long_names_are_cut_where_they_are_repeated() {
    let long = "ä".repeat(1_000_000);
    let (mut document, data) = instanced(|data| {
        data.accessors.push(json!({ "componentType": 5126, "type": "VEC3", "count": 256 }));
        json!({ "TRANSLATION": data.accessors.len() - 1 })
    });
    document["nodes"][0]["name"] = json!(long);
    let light = json!({ "KHR_lights_punctual": { "light": 0 } });
    let nodes = document["nodes"].as_array_mut().expect("nodes");
    nodes.extend([json!({ "extensions": light.clone() }), json!({ "name": long, "extensions": light })]);
    nodes.push(json!({ "name": format!("cell:{long}"), "mesh": 0 }));
    document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "name": long, "type": "spot" }] } });
    let model = model((document, data));
    assert_eq!(model.objects.len(), 257);
    let kept = crate::names::brief_name(&long);
    assert_eq!(model.objects[255].name, format!("{kept}#255"));
    assert_eq!(model.families.families[0].name, kept);
    assert!(model.lights.iter().all(|light| light.name == kept));
    assert!(found(model).iter().all(|(_, subject, _)| subject.len() < 1000));
    let refused = refused(triangle(&json!([{ "name": long, "mesh": 7 }])));
    assert!(refused.contains("mesh 7") && refused.len() < 1000);
}

#[test]
fn the_turn_of_a_light_is_that_of_its_parent_and_its_own() {
    let light = json!({ "KHR_lights_punctual": { "light": 0 } });
    let count = 100_000;
    let mut nodes = vec![json!({ "scale": [0, 0, 0], "rotation": [-1, 0, 0, 1], "children": [1] })];
    nodes.extend((1..count).map(|node| json!({ "extensions": light, "children": [node + 1] })));
    nodes.push(json!({ "extensions": light, "rotation": [1, 0, 0, 1], "scale": [2, 2, 2] }));
    let (mut document, data) = triangle(&nodes.into());
    document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "directional" }] } });
    let model = model((document, data));
    assert_eq!(model.lights.len(), count);
    let (last, others) = model.lights.split_last().expect("lights");
    assert!(others.iter().all(|light| light.source.xyz() == glam::DVec3::Y));
    assert_eq!(last.source.xyz(), glam::DVec3::Z);
}

#[test]
fn a_skin_is_looked_at_once() {
    let (nodes, joints) = (2000, 20_000);
    let model = model(changed(|document, data| {
        let matrix: [f32; 16] = std::array::from_fn(|entry| if entry % 5 == 0 { 1.0 } else { 0.0 });
        let bytes: Vec<u8> = matrix.iter().flat_map(|entry| entry.to_le_bytes()).collect();
        let matrices = data.add(&bytes.repeat(joints), 5126, "MAT4", joints, false);
        document["skins"] = json!([{ "joints": vec![0; joints], "inverseBindMatrices": matrices }]);
        document["nodes"] = json!(vec![json!({ "mesh": 0, "skin": 0 }); nodes]);
    }));
    assert_eq!(model.objects.len(), nodes);
}

/// An accessor without bytes of its own.
fn zeros(data: &mut Data, kind: &str, count: usize) -> usize {
    data.accessors.push(json!({ "componentType": 5126, "type": kind, "count": count }));
    data.accessors.len() - 1
}

#[test]
fn holes_cost_the_vertices_that_triangles_use() {
    for (mode, blend) in [("MASK", Blend::Block), ("BLEND", Blend::Ignore)] {
        let document = changed(|document, data| {
            let positions = zeros(data, "VEC3", 4_000_000);
            let indices = data.add(&[0, 1, 2], 5121, "SCALAR", 3, false);
            let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": 0 });
            document["materials"] = json!([{ "alphaMode": mode }]);
            document["meshes"][0]["primitives"] = json!(vec![primitive; 1000]);
        });
        let model = parse_with(document, &Reading { blend, ..reading() }).unwrap_or_else(|problem| panic!("{problem}"));
        assert_eq!(mesh(&model.objects[0]).positions().len(), 3000);
    }
}

#[test]
fn attributes_that_primitives_share_are_decoded_once() {
    let primitives = 40;
    let document = changed(|document, data| {
        let count = 200_000;
        let attributes = json!({ "POSITION": zeros(data, "VEC3", count), "TEXCOORD_0": zeros(data, "VEC2", count),
            "TEXCOORD_1": zeros(data, "VEC2", count), "COLOR_0": zeros(data, "VEC4", count) });
        let target = json!({ "POSITION": zeros(data, "VEC3", count) });
        let indices = data.add(&[0, 1, 2], 5121, "SCALAR", 3, false);
        document["materials"] = json!([{ "alphaMode": "MASK" }]);
        document["meshes"][0]["weights"] = json!([0.5]);
        let primitive = json!({ "attributes": attributes, "targets": [target], "indices": indices, "material": 0 });
        document["meshes"][0]["primitives"] = json!(vec![primitive; primitives]);
    });
    assert_eq!(mesh(&model(document).objects[0]).triangles().len(), primitives);
}

#[test]
fn primitives_without_triangles_count_too() {
    let refused = refused(changed(|document, _| {
        document["meshes"][0] = json!({ "primitives": vec![json!({ "attributes": {} }); 2000] });
        document["nodes"] = (0..2000).map(|weight| json!({ "mesh": 0, "weights": [weight] })).collect();
    }));
    assert!(refused.contains("decoded elements"), "{refused}");
}

#[test]
fn nodes_and_skins_look_at_a_mesh_once() {
    let count = 40_000;
    let model = model(changed(|document, data| {
        let joints = data.add(&[0; 12], 5121, "VEC4", 3, false);
        let weights = data.floats(&[[1.0, 0.0, 0.0, 0.0]; 3]);
        let attributes = json!({ "JOINTS_0": joints, "WEIGHTS_0": weights });
        let primitives = document["meshes"][0]["primitives"].as_array_mut().expect("primitives");
        primitives.extend(vec![json!({ "attributes": attributes }); count]);
        document["skins"] = json!(vec![json!({ "joints": [0] }); count]);
        document["nodes"] = (0..count).map(|skin| json!({ "mesh": 0, "skin": skin })).collect();
    }));
    assert_eq!(model.objects.len(), count);
}

#[test]
fn names_of_extensions_are_looked_up() {
    let count = 100_000;
    let found = found(model(changed(|document, _| {
        document["extensionsUsed"] = json!(vec!["a"; count]);
        document["extensionsRequired"] = json!(vec!["KHR_mesh_quantization"; count]);
        let primitive = document["meshes"][0]["primitives"][0].clone();
        document["meshes"][0]["primitives"] = json!(vec![primitive; 20_000]);
    })));
    let rule = |text: &str| (FindingKind::BrokenRule, text.to_owned(), 1);
    let expected = [
        (FindingKind::UnknownExtension, "a".to_owned(), 1),
        rule("extensionsRequired: a name is there twice"),
        rule("extensionsRequired: not all of them are among the extensionsUsed"),
        rule("extensionsUsed: a name is there twice"),
    ];
    assert_eq!(found, expected);
}

#[test]
fn buffers_of_one_file_share_one_reading() {
    let directory = tempfile::tempdir().expect("a folder");
    let folder = Folder::of_scene(&directory.path().join("scene.gltf"), Outside::Refused);
    std::fs::write(directory.path().join("data.bin"), vec![0; 1000]).expect("a file");
    let uris = ["data.bin", "./data.bin", "././data.bin", "data%2Ebin"];
    let buffer = |number: usize| json!({ "uri": uris[number % 4], "byteLength": 100 + number });
    let declared: Vec<json::Buffer> =
        (0..300).map(|number| serde_json::from_value(buffer(number)).expect("a buffer")).collect();
    let buffers = Buffers::new(&declared, None, &folder);
    let all: Vec<&[u8]> = (0..300).map(|buffer| buffers.bytes(buffer).expect("bytes")).collect();
    assert!(
        all.iter().enumerate().all(|(number, bytes)| bytes.len() == 100 + number && bytes.as_ptr() == all[0].as_ptr())
    );
}

#[test]
fn long_names_of_members_are_cut() {
    let member = "n".repeat(100_000);
    let text = json!({ "asset": {}, member: vec![Value::Null; 20_000] }).to_string();
    assert_eq!(members::told_of(text.as_bytes()), [(format!("{}...: null", "n".repeat(60)), 20_000)]);
}
