//! Faults of elements that nothing uses, and rules broken without harm.

use super::*;

/// The document of [`triangle`] with something more that no node uses.
fn unused(change: impl FnOnce(&mut Value, &mut Data)) -> Result<Model, LoadProblem> {
    parse(changed(change))
}

#[test]
fn faults_of_unused_elements_are_refused() {
    let refused = |change: fn(&mut Value, &mut Data)| unused(change).expect_err("refused").to_string();
    let accessor = |mut accessor: Value, key: &str, value: Value| {
        accessor[key] = value;
        unused(|_, data| data.accessors.push(accessor)).expect_err("refused").to_string()
    };
    let plain = json!({ "bufferView": 0, "componentType": 5126, "type": "SCALAR", "count": 9 });
    for (key, value, fault) in [
        ("count", json!(10), "accessor 1, buffer view 0: 10 elements of 4 bytes do not fit"),
        ("count", json!(usize::MAX), "do not fit"),
        ("byteOffset", json!(usize::MAX), "do not fit"),
        ("bufferView", json!(7), "accessor 1, buffer view 7: there is none"),
        ("componentType", json!(5124), "5124"),
        ("type", json!("VEC5"), "VEC5"),
        (
            "sparse",
            json!({ "count": 10, "indices": { "bufferView": 0, "componentType": 5123 },
            "values": { "bufferView": 0 } }),
            "10 of its 9 elements",
        ),
        (
            "sparse",
            json!({ "count": 9, "indices": { "bufferView": 0, "componentType": 5123, "byteOffset": 20 },
            "values": { "bufferView": 0 } }),
            "accessor 1, sparse, buffer view 0",
        ),
    ] {
        let message = accessor(plain.clone(), key, value);
        assert!(message.contains(fault), "{message}");
    }
    let view = |value: Value| unused(|_, data| data.views.push(value)).expect_err("refused").to_string();
    assert!(view(json!({ "buffer": 0, "byteLength": 37 })).contains("buffer view 1: its 37 bytes"));
    assert!(view(json!({ "buffer": 0, "byteOffset": usize::MAX, "byteLength": 1 })).contains("leave buffer 0"));
    assert!(view(json!({ "buffer": 3, "byteLength": 1 })).contains("buffer 3"));
    let primitive = |primitive: Value| {
        let mesh = json!({ "primitives": [primitive] });
        let push = |document: &mut Value, _: &mut Data| document["meshes"].as_array_mut().expect("meshes").push(mesh);
        unused(push).expect_err("refused").to_string()
    };
    assert!(primitive(json!({ "attributes": { "NORMAL": 5 } })).contains("mesh 1, primitive 0, accessor 5"));
    assert!(primitive(json!({ "attributes": { "POSITION": 0 }, "indices": 5 })).contains("accessor 5"));
    assert!(primitive(json!({ "attributes": { "POSITION": 0 }, "material": 5 })).contains("material 5"));
    assert!(primitive(json!({ "attributes": { "POSITION": 0 }, "mode": 9 })).contains("mode"));
    assert!(refused(|document, _| document["skins"] = json!([{ "joints": [4] }])).contains("skin 0, node 4"));
    assert!(
        refused(|document, _| {
            document["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1] }]);
        })
        .contains("scene 1, node 1")
    );
    assert!(
        refused(|document, _| {
            document["nodes"] = json!([{ "mesh": 0 }, { "mesh": 4 }]);
            document["scenes"] = json!([{ "nodes": [0] }]);
        })
        .contains("node 1: it names mesh 4")
    );
    assert!(refused(|document, _| document["textures"] = json!([{ "source": 2 }])).contains("texture 0, image 2"));
}

#[test]
fn rules_broken_without_harm_are_told() {
    let told = |change: fn(&mut Value, &mut Data)| {
        let model = unused(change).unwrap_or_else(|problem| panic!("{problem}"));
        assert_eq!(mesh(&model.objects[0]).triangles(), [[0, 1, 2]]);
        let found: Vec<_> = found(model).into_iter().map(|(kind, subject, _)| (kind, subject)).collect();
        assert!(found.iter().all(|(kind, _)| *kind == FindingKind::BrokenRule), "{found:?}");
        found.into_iter().map(|(_, subject)| subject).collect::<Vec<_>>()
    };
    let shifted = told(|_, data| {
        data.bytes.insert(0, 0);
        data.views[0]["byteOffset"] = json!(1);
    });
    assert_eq!(shifted, ["accessor 0: its components are not aligned"]);
    let strided = told(|_, data| {
        data.bytes = data.bytes.chunks(12).flat_map(|corner| [corner, &[0]].concat()).collect();
        data.views[0]["byteStride"] = json!(13);
        data.views[0]["byteLength"] = json!(39);
    });
    let rules = ["accessor 0: its components are not aligned", "buffer view 0: its stride is not one of 4, 8, ... 252"];
    assert_eq!(strided, rules);
    let counts = told(|document, data| {
        let normals = data.floats(&[[0.0_f32, 0.0, 1.0]; 2]);
        document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    });
    assert_eq!(counts, ["mesh 0, primitive 0: its attributes differ in their number of vertices"]);
    let empty = told(|document, data| {
        document["meshes"].as_array_mut().expect("meshes").push(json!({ "primitives": [] }));
        data.accessors.push(json!({ "componentType": 5126, "type": "MAT3", "count": 0, "normalized": true }));
    });
    let rules = [
        "accessor 1: it has no elements",
        "accessor 1: its components cannot be normalised",
        "mesh 1: it has no primitives",
    ];
    assert_eq!(empty, rules);
}

#[test]
fn whole_numbers_may_be_written_as_floats() {
    let (mut document, data) = changed(|document, _| document["scenes"] = json!([{ "nodes": [0.0] }]));
    document["scene"] = json!(0.0);
    assert_eq!(model((document.clone(), data)).objects.len(), 1);
    for scene in [json!(0.5), json!(-1.0), json!(1e300)] {
        document["scene"] = scene;
        assert!(parse((document.clone(), Data::default())).is_err());
    }
}

#[test]
fn an_unknown_alpha_mode_is_told() {
    let model = model(changed(|document, _| {
        document["materials"] = json!([{ "alphaMode": "GLASS" }]);
        document["meshes"][0]["primitives"][0]["material"] = json!(0);
    }));
    let found = found(model);
    assert!(matches!(&found[..], [(FindingKind::BrokenRule, told, 1)] if told.contains("alphaMode")), "{found:?}");
}

#[test]
fn a_node_scaled_to_a_point_is_told() {
    let nodes = json!([{ "mesh": 0 }, { "name": "hidden", "mesh": 0, "scale": [0, 0, 0] }]);
    let model = model(triangle(&nodes));
    assert_eq!(names(&model), ["node0"]);
    assert_eq!(found(model), [(FindingKind::NotTriangles, "hidden".to_owned(), 1)]);
    let instances = self::model(instanced(|data| json!({ "SCALE": data.floats(&[[1.0; 3], [0.0; 3], [2.0; 3]]) })));
    assert_eq!(names(&instances), ["leaf#0", "leaf#2"]);
    assert_eq!(found(instances), [(FindingKind::NotTriangles, "leaf".to_owned(), 1)]);
}

#[test]
fn a_primitive_without_positions_is_told() {
    let model = model(changed(|document, _| {
        let primitives = document["meshes"][0]["primitives"].as_array_mut().expect("primitives");
        primitives.push(json!({ "attributes": {} }));
    }));
    assert_eq!(found(model), [(FindingKind::NotTriangles, "node0".to_owned(), 1)]);
}
