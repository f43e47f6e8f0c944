//! Faults of elements that nothing uses, and rules broken without harm.

use super::*;
use crate::ledger::Ledger;

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
fn kinds_of_elements_that_gltf_does_not_have_are_told() {
    let unknown = json!({ "componentType": 1, "type": "VEC5", "count": 1, "sparse": { "count": 1,
        "indices": { "bufferView": 9, "componentType": 5123 }, "values": { "bufferView": 0 } } });
    let message = unused(|_, data| data.accessors.push(unknown)).expect_err("refused").to_string();
    assert!(message.contains("accessor 1, buffer view 9"), "{message}");
    for (told, fault) in [
        (
            told(|_, data| data.accessors.push(json!({ "componentType": 5124, "type": "VEC3", "count": 1 }))),
            "accessor 1: its component type 5124 is none of glTF's",
        ),
        (
            told(|_, data| data.accessors.push(json!({ "componentType": 5126, "type": "VEC5", "count": 1 }))),
            "accessor 1: its type VEC5 is none of glTF's",
        ),
    ] {
        assert_eq!(told, fault);
    }
}

#[test]
fn vertices_without_a_place_or_out_of_line_are_told() {
    for (told, fault) in [
        (
            told(|document, data| {
                let colors = data.add(&[0; 16], 5121, "VEC4", 3, true);
                data.accessors[colors]["byteOffset"] = json!(2);
                document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
            }),
            "accessor 1: its vertices do not begin at multiples of four",
        ),
        (
            told(|document, data| {
                let normals = data.floats(&[[0.0, 0.0, 1.0]; 3]);
                let other = json!({ "primitives": [{ "attributes": { "NORMAL": normals } }] });
                document["meshes"].as_array_mut().expect("meshes").push(other);
            }),
            "mesh 1, primitive 0: it has no POSITION",
        ),
    ] {
        assert!(told.contains(fault), "{told}");
    }
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
        let still = json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "targets": [{}] }, { "attributes": {}, "targets": [{}] }] });
        document["meshes"].as_array_mut().expect("meshes").push(still);
        data.accessors.push(json!({ "componentType": 5126, "type": "MAT3", "count": 0, "normalized": true }));
    });
    let rules = [
        "accessor 1: it has no elements",
        "accessor 1: its components cannot be normalised",
        "mesh 1: it has no primitives",
        "mesh 2, primitive 0: a morph target of it has no attributes",
        "mesh 2, primitive 1: a morph target of it has no attributes",
        "mesh 2, primitive 1: it has no attributes",
    ];
    assert_eq!(empty, rules);
}

#[test]
fn halves_of_characters_are_told_and_replaced() {
    let text = br#"{"asset": {"version": "2.0"}, "nodes": [{"name": "\ud83c\udfe0"}, {"name": "a\ud83c"}]}"#;
    let (document, _) = super::super::parse(text).expect("a document");
    assert_eq!(document.nodes[1].name.as_deref(), Some("a\u{fffd}"));
    let model = read(text, &folder(), &reading()).expect("a model");
    let told: Vec<_> = found(model).into_iter().filter(|(_, subject, _)| subject.starts_with("JSON")).collect();
    assert!(matches!(&told[..], [(FindingKind::BrokenRule, _, 1)]), "{told:?}");
}

#[test]
fn whole_numbers_may_be_written_as_floats() {
    let (mut document, data) = changed(|document, _| document["scenes"] = json!([{ "nodes": [0.0] }]));
    document["scene"] = json!(0.0);
    assert_eq!(model((document.clone(), data)).objects.len(), 1);
    let digits = "0".repeat(70_000);
    let long = format!("{{ \"asset\": {{ \"version\": \"2.0\" }}, \"scene\": 0.{digits} }}");
    assert!(super::super::parse(long.as_bytes()).is_ok_and(|(document, _)| document.scene == Some(0)));
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
fn a_flattened_node_is_a_flat_mesh() {
    let nodes = json!([
        { "name": "up", "translation": [0.1, 0, 0], "children": [1, 2] },
        { "name": "flat", "mesh": 0, "scale": [3, 0, 1] },
        { "name": "line", "mesh": 0, "scale": [0, 0, 1] }
    ]);
    let model = model(triangle(&nodes));
    assert_eq!(names(&model), ["flat"]);
    let scene = model.into_scene(glam::DAffine3::IDENTITY, umbriel_scene::Sides::Auto, &Ledger::default());
    let scene = scene.expect("a scene");
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!("a mesh") };
    let corners: Vec<_> = mesh.positions().iter().map(|&corner| scene.objects[0].placement.round(corner)).collect();
    let corner = glam::DVec3::new;
    assert_eq!(corners, [corner(3.1, 0.0, 0.0), corner(0.1, 0.0, 0.0), corner(0.1, 0.0, 1.0)]);
    assert_eq!(scene.findings[0].kind, FindingKind::NotTriangles);
    assert_eq!(scene.findings[0].subject, "line");
}

#[test]
fn a_primitive_without_positions_is_told() {
    let model = model(changed(|document, _| {
        let primitives = document["meshes"][0]["primitives"].as_array_mut().expect("primitives");
        primitives.push(json!({ "attributes": {} }));
    }));
    let rule = "mesh 0, primitive 1: it has no attributes";
    let expected = [(FindingKind::NotTriangles, "node0".to_owned(), 1), (FindingKind::BrokenRule, rule.to_owned(), 1)];
    assert_eq!(found(model), expected);
}

/// What is told of the document of [`triangle`] after one change.
pub(super) fn told(change: impl FnOnce(&mut Value, &mut Data)) -> String {
    let found = found(unused(change).unwrap_or_else(|problem| panic!("{problem}")));
    found.into_iter().map(|(_, subject, _)| subject).collect::<Vec<_>>().join("\n")
}

#[test]
fn meshes_that_no_node_shows_are_looked_at() {
    let mesh = |primitive: fn(&mut Data) -> Value| {
        told(move |document, data| {
            let primitive = primitive(data);
            document["meshes"].as_array_mut().expect("meshes").push(json!({ "primitives": [primitive] }));
        })
    };
    let fault = "unused: mesh 1, primitive 0";
    let out = mesh(
        |data| json!({ "attributes": { "POSITION": 0 }, "indices": data.add(&[0, 1, 3, 0], 5121, "SCALAR", 3, false) }),
    );
    assert_eq!(out, format!("{fault}: index 2 is 3, but there are 3 vertices"));
    let points = mesh(|data| json!({ "attributes": { "POSITION": data.floats(&[[f32::NAN; 3]]) }, "mode": 0 }));
    assert!(points.starts_with(&format!("{fault}, accessor 1: position 0: coordinate x is not finite")), "{points}");
    let target = mesh(|data| {
        let target = data.floats(&[[0.0, f32::INFINITY, 0.0]; 3]);
        json!({ "attributes": { "POSITION": 0 }, "targets": [{ "POSITION": target }] })
    });
    assert!(target.contains("accessor 1: position 0: coordinate y is not finite"), "{target}");
    assert_eq!(mesh(|_| json!({ "attributes": { "POSITION": 0 }, "mode": 1 })), "");
}

/// What is told of a document with this value.
pub(super) fn with(key: &'static str, value: Value) -> String {
    told(move |document, _| document[key] = value)
}

#[test]
fn broken_rules_of_accessors_and_extensions_are_told() {
    let accessor = |key: &'static str, value: Value| told(move |_, data| data.accessors[0][key] = value);
    for (found, fault) in [
        (accessor("min", json!([0, 0, 0.5])), "accessor 0: its min and max are not those of its positions"),
        (accessor("max", json!([1])), "accessor 0: its min or max is not one number for each"),
        (accessor("max", Value::Null), "accessor 0: it has no min and max"),
        (with("extensionsRequired", json!(["KHR_mesh_quantization"])), "extensionsRequired: not all of them"),
        (
            told(|document, _| {
                document["extensionsUsed"] = json!([]);
                document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [] } });
            }),
            "KHR_lights_punctual: it is not among the extensionsUsed",
        ),
        (accessor("min", json!([0, 0])), "accessor 0: its min or max is not one number for each"),
        (
            told(|_, data| {
                data.accessors.push(json!({ "componentType": 5126, "type": "VEC3", "count": 1, "byteOffset": 0 }))
            }),
            "accessor 1: it has a byteOffset and no bufferView",
        ),
        (
            with("extensionsUsed", json!(["KHR_mesh_quantization"])),
            "KHR_mesh_quantization: it is used and not required",
        ),
        (told(|_, data| data.views[0]["target"] = json!(34963)), "accessor 0: its buffer view is not for vertices"),
        (told(|_, data| data.views[0]["target"] = json!(1)), "buffer view 0: its target is none"),
        (
            told(|_, data| {
                let one = data.floats(&[[0.0; 3]]);
                data.views[one]["byteStride"] = json!(16);
            }),
            "buffer view 1: its stride is more than its bytes",
        ),
        (
            told(|document, data| {
                let colors = data.add(&[0; 12], 5121, "VEC3", 3, true);
                document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
            }),
            "accessor 1: its vertices do not begin at multiples of four",
        ),
        (
            told(|document, data| {
                let (many, last) = (data.floats(&[[1.0; 3]; 256]), data.add(&[0, 1, 255, 0], 5121, "SCALAR", 3, false));
                document["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": many }, "indices": last });
            }),
            "accessor 2: the greatest index of its type",
        ),
        (
            told(|document, data| {
                let two = data.floats(&[[0.0; 3], [1.0; 3]]);
                let strip = json!({ "attributes": { "POSITION": two }, "mode": 5 });
                document["meshes"][0]["primitives"].as_array_mut().expect("primitives").push(strip);
            }),
            "mesh 0, primitive 1: corners are left over",
        ),
    ] {
        assert!(found.contains(fault), "{found:?} should tell {fault:?}");
    }
}

#[test]
fn broken_rules_of_looks_lights_and_cameras_are_told() {
    for (found, fault) in [
        (with("materials", json!([{ "alphaMode": "GLASS" }])), "material 0: its alphaMode"),
        (
            with("extensions", json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "range": -1 }] } })),
            "light 0: its colour, intensity or range",
        ),
        (with("images", json!([{}])), "image 0: it has not just one of uri and bufferView"),
        (with("images", json!([{ "bufferView": 0 }])), "image 0: it is in a buffer view and has no mimeType"),
        (
            with("images", json!([{ "bufferView": 0, "mimeType": "image/png" }])),
            "image 0: its mimeType is image/png, its bytes are no picture",
        ),
        (
            with("images", json!([{ "uri": "data:,", "mimeType": "image/gif" }])),
            "image 0: its mimeType is none of glTF's",
        ),
        (with("materials", json!([{ "alphaCutoff": 0.3 }])), "material 0: it has a cutoff and no alphaMode"),
        (
            with(
                "extensions",
                json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "color": [9, 0, 0] }] } }),
            ),
            "light 0: its colour, intensity or range",
        ),
        (
            with("extensions", json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot" }] } })),
            "light 0: it has no spot",
        ),
        (with("extensions", json!({ "KHR_materials_variants": { "variants": [{}] } })), "variant 0: it has no name"),
        (
            with("extensions", json!({ "KHR_lights_punctual": { "lights": [{ "type": "area" }] } })),
            "light 0: its type is none of directional, point, spot",
        ),
        (with("cameras", json!([{}])), "camera 0: it is not either"),
        (
            with("cameras", json!([{ "type": "perspective", "perspective": { "yfov": -1, "znear": 1 } }])),
            "camera 0: its yfov is not between",
        ),
    ] {
        assert!(found.contains(fault), "{found:?} should tell {fault:?}");
    }
}

#[test]
fn broken_rules_of_bodies_are_told() {
    let shape = |shape: Value| with("extensions", json!({ "KHR_implicit_shapes": { "shapes": [shape] } }));
    for (found, fault) in [
        (shape(json!({ "type": "sphere", "sphere": { "radius": -1 } })), "shape 0: a size of it is negative"),
        (shape(json!({ "type": "cylinder", "cylinder": { "radiusTop": -1 } })), "shape 0: a size of it is negative"),
        (shape(json!({ "type": "box", "sphere": { "radius": 1 } })), "shape 0: it has no numbers of its type"),
    ] {
        assert!(found.contains(fault), "{found:?} should tell {fault:?}");
    }
    for sound in
        [json!({ "type": "box" }), json!({ "type": "box", "box": {}, "sphere": {} }), json!({ "type": "convex" })]
    {
        assert!(!shape(sound.clone()).contains("shape 0"), "{sound}");
    }
}

#[test]
fn the_first_position_beyond_its_extent_is_told() {
    let places = |max: [f32; 3]| {
        let model = model(changed(|_, data| data.accessors[0]["max"] = json!(max)));
        let found = model.findings.into_list().into_iter().filter(|finding| finding.subject.contains("min and max"));
        found.map(|finding| (finding.count, finding.places)).collect::<Vec<_>>()
    };
    assert_eq!(places([1.0, 0.5, 0.5]), [(1, vec!["position 1".to_owned()])]);
    assert_eq!(places([1.0, 2.0, 1.0]), [(1, Vec::new())], "no position is beyond what is too wide");
    assert!(places([1.0; 3]).is_empty());
}

#[test]
fn buffers_without_bytes_and_uneven_instances_are_told() {
    let empty = told(|document, data| {
        let uri = base64::engine::general_purpose::STANDARD.encode(&data.bytes);
        let own =
            json!({ "uri": format!("data:application/octet-stream;base64,{uri}"), "byteLength": data.bytes.len() });
        document["buffers"] = json!([own, { "uri": "data:application/octet-stream,", "byteLength": 0 }]);
    });
    assert_eq!(empty, "buffer 1: it has no bytes");
    let uneven = told(|document, data| {
        let (two, three) = (data.floats(&[[0.0; 3]; 2]), data.floats(&[[1.0; 3]; 3]));
        let attributes = json!({ "TRANSLATION": two, "SCALE": three });
        let instancing = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
        document["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "extensions": instancing }]);
        document["scenes"] = json!([{ "nodes": [0] }]);
    });
    assert_eq!(uneven, "node 1: the attributes of its instances differ in their number");
}

#[test]
fn attributes_of_instances_have_names_of_theirs_and_rotations_length_one() {
    let with = |name: &str, value: [f32; 4]| {
        told(|document, data| {
            let attributes = json!({ "TRANSLATION": data.floats(&[[0.0; 3]]), name: data.floats(&[value]) });
            document["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
        })
    };
    assert_eq!([with("ROTATION", [0.0, 0.6, 0.0, 0.8]), with("_ID", [0.0; 4])], [""; 2]);
    assert_eq!(with("ROTATION", [0.0, 0.0, 0.0, 2.0]), "accessor 2: rotations that are not of length 1");
    for name in ["FOO", "rotation"] {
        assert_eq!(with(name, [0.0; 4]), format!("node 0: {name} is no attribute of instances"));
    }
}

#[test]
fn morph_targets_move_what_is_there_by_as_many_weights() {
    let with = |target: &str, weights: Value| {
        told(|document, data| {
            let steps = data.floats(&[[0.0, 0.0, 0.0]; 3]);
            let primitive = json!({ "attributes": { "POSITION": 0 }, "targets": [{ target: steps }] });
            document["meshes"][0] = json!({ "primitives": [primitive], "weights": weights });
            document["nodes"][0]["weights"] = json!([0]);
        })
    };
    assert_eq!(with("POSITION", json!([1])), "node0");
    let fault = "mesh 0, primitive 0: a morph target moves an attribute that it does not have";
    assert!(with("NORMAL", json!([1])).contains(fault));
    assert!(with("POSITION", json!([0, 0])).contains("mesh 0: its primitives and weights differ in their number"));
}

#[test]
fn extents_of_indices_are_told_where_they_are_not_theirs() {
    let saying = |max: u32| {
        told(|document, data| {
            let indices = data.add(&[0, 1, 2, 0], 5121, "SCALAR", 3, false);
            (data.accessors[indices]["min"], data.accessors[indices]["max"]) = (json!([0]), json!([max]));
            document["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        })
    };
    assert_eq!(saying(2), "");
    assert_eq!(saying(3), "accessor 1: its min and max are not those of its indices");
}

#[test]
fn broken_rules_of_nodes_and_skins_are_told() {
    let of = |key: &'static str, value: Value| told(move |document, _| document[key] = value);
    let node = |value: Value| of("nodes", json!([{ "mesh": 0 }, value]));
    let turned = [0.1826, 0.3651, 0.5477, 0.7303];
    assert_eq!(node(json!({ "rotation": turned })), "");
    assert_eq!(node(json!({ "matrix": [0, 0, 0, 0, 0, 1e30, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] })), "", "flat is no skew");
    for (found, fault) in [
        (node(json!({ "rotation": [0, 0, 0, 2] })), "node 1: its rotation is no unit quaternion"),
        (node(json!({ "matrix": [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] })), "node 1: its matrix skews"),
        (node(json!({ "matrix": [1, 0, 0, 1e-9, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] })), "not quite 0 0 0 1"),
        (
            told(|document, _| {
                document["nodes"] = json!([{ "mesh": 0 }, { "children": [2] }, {}, {}]);
                document["skins"] = json!([{ "joints": [1, 2] }, { "joints": [2, 3] }]);
            }),
            "skin 1: its joints have no common root",
        ),
        (
            told(|document, _| {
                document["nodes"] = json!([{ "mesh": 0 }, { "children": [2, 3] }, {}, {}]);
                document["skins"] = json!([
                    { "joints": [2, 3], "skeleton": 1 }, { "joints": [3], "skeleton": 3 }, { "joints": [2, 3], "skeleton": 3 }
                ]);
            }),
            "skin 2: its joints do not hang on its skeleton",
        ),
        (
            node(json!({ "scale": [1, 1e300, 1] })),
            "node 1: numbers of its matrix, translation or scale are above 2^200",
        ),
        (of("skins", json!([{ "joints": [0, 0] }])), "skin 0: it has no joints, or one of them twice"),
        (node(json!({ "weights": [1.0] })), "node 1: it has weights and no mesh"),
        (
            node(json!({ "extensions": { "EXT_mesh_gpu_instancing": { "attributes": {} } } })),
            "node 1: it has EXT_mesh_gpu_instancing and no mesh",
        ),
    ] {
        assert!(found.contains(fault), "{found:?} should tell {fault:?}");
    }
}

#[test]
fn broken_rules_of_cameras_are_told() {
    let of = |key: &'static str, value: Value| told(move |document, _| document[key] = value);
    let camera = |kind: &str, near: f64, far: f64| {
        let perspective = json!({ "yfov": 1.0, "znear": near, "zfar": far });
        of("cameras", json!([{ "type": kind, "perspective": perspective }]))
    };
    assert_eq!(camera("perspective", 0.1, 1.0), "");
    let wide = |ratio: f64| {
        let perspective = json!({ "yfov": 1.0, "znear": 0.1, "aspectRatio": ratio });
        of("cameras", json!([{ "type": "perspective", "perspective": perspective }]))
    };
    let flat = |width: Value, height: f64| {
        let orthographic = json!({ "xmag": width, "ymag": height, "znear": 0.0, "zfar": 1.0 });
        of("cameras", json!([{ "type": "orthographic", "orthographic": orthographic }]))
    };
    assert_eq!([wide(1.5), flat(json!(2.0), 1.0)], [""; 2]);
    for (found, fault) in [
        (camera("orthographic", 0.1, 1.0), "camera 0: its type is not its projection's, or its planes"),
        (camera("perspective", 0.0, 1.0), "camera 0: its type is not its projection's, or its planes"),
        (wide(0.0), "camera 0: its aspectRatio, xmag or ymag"),
        (flat(json!(0.0), 1.0), "camera 0: its aspectRatio, xmag or ymag"),
        (flat(Value::Null, 1.0), "camera 0: its aspectRatio, xmag or ymag"),
        (flat(json!(1.0), 0.0), "camera 0: its aspectRatio, xmag or ymag"),
        (camera("perspective", 2.0, 1.0), "camera 0: its type is not its projection's, or its planes"),
    ] {
        assert!(found.contains(fault), "{found:?} should tell {fault:?}");
    }
}

#[test]
fn cameras_that_are_not_read_are_looked_at() {
    let perspective = |yfov: f64| json!({ "type": "perspective", "perspective": { "yfov": yfov, "znear": 1 } });
    let of = |camera: Value, roots: Value| {
        told(|document, _| {
            document["cameras"] = json!([perspective(1.0), camera]);
            document["nodes"] = json!([{ "mesh": 0 }, { "camera": 0 }, { "camera": 1 }]);
            document["scenes"] = json!([{ "nodes": roots }]);
        })
    };
    for roots in [json!([0, 1, 2]), json!([0, 1]), json!([0])] {
        assert_eq!(of(perspective(2.0), roots.clone()), "");
        assert!(of(perspective(0.0), roots.clone()).contains("camera 1: its yfov is not between"), "{roots}");
        assert!(of(json!({ "type": "perspective" }), roots).contains("camera 1: it is not either"));
    }
}

#[test]
fn references_of_what_only_shades_are_checked() {
    let material = |material: Value| {
        unused(|document, _| document["materials"] = json!([material])).expect_err("refused").to_string()
    };
    for key in ["normalTexture", "occlusionTexture", "emissiveTexture"] {
        assert!(material(json!({ key: { "index": 3 } })).contains("material 0, texture 3"), "{key}");
    }
    let rough = json!({ "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 3 } } });
    assert!(material(rough).contains("material 0, texture 3"));
    let skeleton = json!([{ "joints": [0], "skeleton": 9 }]);
    let skin = unused(|document, _| document["skins"] = skeleton).expect_err("refused").to_string();
    assert!(skin.contains("skin 0, node 9"), "{skin}");
    let collider = json!({ "KHR_physics_rigid_bodies": { "collider": { "shape": 4 } } });
    let shape = unused(|document, _| document["nodes"][0]["extensions"] = collider).expect_err("refused").to_string();
    assert!(shape.contains("shape 4"), "{shape}");
}

#[test]
fn names_that_are_there_twice_are_refused() {
    let (document, _) = triangle(&json!([{ "mesh": 0 }]));
    let text = document.to_string();
    let twice = |from: &str, to: &str| {
        assert!(text.contains(from), "{text}");
        let text = text.replace(from, to).replace("\"asset\"", "\"scene\":0.0,\"scenes\":[{\"nodes\":[0]}],\"asset\"");
        read(text.as_bytes(), &folder(), &reading()).expect_err("refused").to_string()
    };
    assert!(twice("\"POSITION\":0", "\"POSITION\":0,\"POSITION\":0").contains("duplicate field `POSITION`"));
    assert!(twice("\"nodes\":[{\"mesh\":0}]", "\"nodes\":[],\"nodes\":[]").contains("duplicate field `nodes`"));
}

#[test]
fn extras_may_be_anything() {
    let deep = format!("{}0.0{}", "[".repeat(300), "]".repeat(300));
    let (mut document, data) = triangle(&json!([{ "mesh": 0, "extras": "HERE" }, { "mesh": 0.0 }]));
    let encoded = base64::engine::general_purpose::STANDARD.encode(&data.bytes);
    document["buffers"] =
        json!([{ "uri": format!("data:application/octet-stream;base64,{encoded}"), "byteLength": data.bytes.len() }]);
    document["bufferViews"] = data.views.into();
    document["accessors"] = data.accessors.into();
    let text = document.to_string().replace("\"HERE\"", &deep);
    let model = read(text.as_bytes(), &folder(), &reading()).unwrap_or_else(|problem| panic!("{problem}"));
    assert_eq!(model.objects.len(), 2);
}

#[test]
fn all_unknown_extensions_that_are_required_are_named() {
    let names = json!(["VENDOR_a", "KHR_mesh_quantization", "VENDOR_b"]);
    let refused = unused(|document, _| document["extensionsRequired"] = names).expect_err("refused").to_string();
    assert!(refused.contains("VENDOR_a, VENDOR_b;"), "{refused}");
}

#[test]
fn instances_without_bytes_are_few() {
    let of = |count: usize| {
        let accessor = json!({ "componentType": 5126, "type": "VEC3", "count": count });
        parse(instanced(|data| {
            data.accessors.push(accessor);
            json!({ "TRANSLATION": data.accessors.len() - 1 })
        }))
    };
    assert_eq!(of(256).expect("a model").objects.len(), 256);
    assert!(of(257).expect_err("refused").to_string().contains("257 instances in one place"));
}
