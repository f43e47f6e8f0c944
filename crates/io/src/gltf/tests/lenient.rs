//! Files that say what they show, if not quite as they should: they are read, and what is odd is told.

use super::*;

/// What is told of a model that is made all the same.
fn told(model: Model) -> Vec<String> {
    found(model).into_iter().map(|(_, subject, _)| subject).collect()
}

#[test]
fn what_rounding_left_of_zero_is_zero() {
    for (node, map) in [
        (json!({ "translation": [1e-310, 0, 7] }), glam::DAffine3::from_translation(glam::DVec3::new(0.0, 0.0, 7.0))),
        (json!({ "rotation": [2.8e-45, 0, 1.4e-45, 1] }), glam::DAffine3::IDENTITY),
    ] {
        let mut node = node;
        node["mesh"] = json!(0);
        let model = model(triangle(&json!([node])));
        let entries = model.objects[0].map.to_cols_array();
        assert!(entries.iter().zip(map.to_cols_array()).all(|(entry, other)| (entry - other).abs() < 1e-40));
        assert!(entries.iter().all(|&entry| umbriel_geometry::accept(entry).is_ok()), "{entries:?}");
        assert_eq!(told(model), ["node 0: numbers of its matrix below 2^-200 are taken as 0"]);
    }
    // Each is large enough, their product is not; the child has nothing of its own.
    let scale = json!([1e-40, 1, 1]);
    let nodes =
        json!([{ "scale": scale, "children": [1] }, { "scale": scale, "children": [2], "mesh": 0 }, { "mesh": 0 }]);
    let flat = model(triangle(&nodes));
    assert_eq!(flat.objects[1].map.matrix3.x_axis, glam::DVec3::ZERO);
    assert_eq!(told(flat), ["node 1: numbers of its matrix below 2^-200 are taken as 0"]);
    let instances =
        model(instanced(|data| json!({ "ROTATION": data.floats(&[[1e-40, 0.0, 1e-40, 1.0], [0.0, 0.0, 0.0, 1.0]]) })));
    assert_eq!(instances.objects[0].map.matrix3.x_axis.z, 0.0);
    let place = "node 0 (\"leaf\"), EXT_mesh_gpu_instancing";
    assert_eq!(told(instances), [format!("{place}: numbers of its matrix below 2^-200 are taken as 0")]);
}

#[test]
fn tiny_steps_of_targets_are_no_steps() {
    let model = model(changed(|document, data| {
        let steps = data.floats(&[[0.0, 1e-40, 0.0]; 3]);
        let primitive = json!({ "attributes": { "POSITION": 0 }, "targets": [{ "POSITION": steps }] });
        document["meshes"][0] = json!({ "primitives": [primitive], "weights": [1e-40] });
    }));
    assert_eq!(mesh(&model.objects[0]).positions()[0], glam::DVec3::X);
    let expected =
        (FindingKind::BrokenRule, "mesh 0, primitive 0: morphed coordinates below 2^-200 are taken as 0".to_owned(), 2);
    assert!(found(model).contains(&expected));
}

#[test]
fn base64_is_read_as_browsers_read_it() {
    let with = |uri: &str| {
        told(model(changed(|document, data| {
            let encoded = base64::engine::general_purpose::STANDARD.encode(&data.bytes);
            let own = json!({ "uri": format!("data:application/octet-stream;base64,{encoded}"), "byteLength": data.bytes.len() });
            document["buffers"] = json!([own, { "uri": uri, "byteLength": 2 }]);
        })))
    };
    assert!(with("data:application/octet-stream;base64,AAA=").is_empty());
    assert_eq!(
        with("data:application/octet-stream;base64,AAB="),
        ["buffer 1: its base64 ends with bits that mean nothing"]
    );
    // What is no base64 shows that it is taken as such.
    let spaced = "data:application/octet-stream; base64,";
    assert_eq!(with(&format!("{spaced}AAA=")), ["buffer 1: its data URI has white space"]);
    assert!(with(&format!("{spaced}?")).iter().any(|told| told.contains("not base64")));
}

#[test]
fn a_stride_of_zero_is_none() {
    let model = model(changed(|_, data| data.views[0]["byteStride"] = json!(0)));
    assert_eq!(mesh(&model.objects[0]).positions()[1], glam::DVec3::Y);
    assert_eq!(told(model), ["buffer view 0: its stride is not one of 4, 8, ... 252"]);
}

#[test]
fn extensions_that_are_required_have_to_be_known() {
    let with = |key: &str, name: &str| parse(changed(|document, _| document[key] = json!([name])));
    for name in ["KHR_materials_nonsense", "KHR_texture_nonsense", "KHR_xmp_nonsense", "EXT_mesh_features_2"] {
        let refused = with("extensionsRequired", name).expect_err("refused").to_string();
        assert!(refused.contains(name), "{refused}");
        let told = told(with("extensionsUsed", name).expect("a model"));
        assert_eq!(told.len(), usize::from(name.starts_with("EXT_")), "{name}");
    }
    for name in ["KHR_materials_unlit", "KHR_texture_basisu", "EXT_texture_webp", "MSFT_texture_dds", "KHR_xmp_json_ld"]
    {
        assert!(with("extensionsRequired", name).is_ok(), "{name}");
    }
}

#[test]
fn instances_may_have_attributes_of_others_alone() {
    let model = model(instanced(|data| json!({ "_ID": data.floats(&[[1.0], [2.0]]) })));
    assert_eq!(names(&model), ["leaf#0", "leaf#1"]);
    assert_eq!(model.objects[0].map, model.objects[1].map);
    assert!(told(model).is_empty());
}
