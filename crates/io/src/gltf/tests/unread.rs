//! What nothing reads: elements of other attributes, joints, references of extensions and of what is not shown.

use super::*;

/// What is told of the document of [`triangle`] with a change.
fn told(change: impl FnOnce(&mut Value, &mut Data)) -> Vec<String> {
    told_of(model(changed(change)))
}

fn told_of(model: Model) -> Vec<String> {
    let rules = found(model).into_iter().filter(|(kind, ..)| *kind == FindingKind::BrokenRule);
    rules.map(|(_, subject, count)| format!("{count} {subject}")).collect()
}

fn attribute(name: &str, change: impl FnOnce(&mut Data) -> usize) -> Vec<String> {
    told(|document, data| document["meshes"][0]["primitives"][0]["attributes"][name] = json!(change(data)))
}

#[test]
fn elements_that_nothing_reads_are_finite() {
    let normals =
        |wrong: f32| attribute("NORMAL", |data| data.floats(&[[0.0, 0.0, 1.0], [0.0, wrong, 0.8], [wrong; 3]]));
    assert!(attribute("NORMAL", |data| data.floats(&[[0.0, 0.6, 0.8]; 3])).is_empty());
    for wrong in [f32::NAN, f32::INFINITY] {
        assert_eq!(normals(wrong), ["4 unused: accessor 1: components that are not finite"]);
    }
    // Elements that are too many to look at are left alone.
    let motion = told(|document, data| {
        let times = data.floats(&[[f32::NAN]]);
        document["animations"] = json!([{ "samplers": [{ "input": times, "output": times }], "channels": [] }]);
        data.accessors.push(json!({ "componentType": 5126, "type": "SCALAR", "count": usize::MAX }));
    });
    assert!(motion.contains(&"1 unused: accessor 1: components that are not finite".to_owned()), "{motion:?}");
}

#[test]
fn sparse_places_that_nothing_reads_ascend() {
    let normals = |places: [u16; 2]| {
        attribute("NORMAL", |data| {
            let normals = data.floats(&[[0.0, 0.0, 1.0]; 3]);
            let places: Vec<u8> = places.iter().flat_map(|place| place.to_le_bytes()).collect();
            let places = data.add(&places, 5123, "SCALAR", 2, false);
            let values = data.floats(&[[0.0, 1.0, 0.0]; 2]);
            data.accessors[normals]["sparse"] = json!({
                "count": 2, "indices": { "bufferView": data.accessors[places]["bufferView"], "componentType": 5123 },
                "values": { "bufferView": data.accessors[values]["bufferView"] },
            });
            normals
        })
    };
    assert!(normals([0, 2]).is_empty());
    for places in [[2, 0], [1, 1], [0, 3]] {
        assert!(matches!(&normals(places)[..], [told] if told.contains("accessor 1, sparse: index")), "{places:?}");
    }
}

#[test]
fn compressed_views_that_nothing_reads_are_decoded() {
    let unread = |change: fn(&mut Value)| {
        told(|document, data| {
            // Three elements of four zeros.
            let mut stream = vec![0xa0, 0, 0, 0, 0];
            stream.extend([0; 32]);
            let extension = json!({ "buffer": 0, "byteOffset": data.bytes.len(), "byteLength": stream.len(),
                "byteStride": 4, "count": 3, "mode": "ATTRIBUTES" });
            data.bytes.extend(stream);
            data.views.push(json!({ "buffer": 0, "byteLength": 12, "byteStride": 4,
                "extensions": { "EXT_meshopt_compression": extension } }));
            let view = data.views.len() - 1;
            change(&mut data.views[view]["extensions"]["EXT_meshopt_compression"]);
            data.accessors.push(json!({ "bufferView": view, "componentType": 5121, "type": "VEC3", "count": 3 }));
            document["meshes"][0]["primitives"][0]["attributes"]["_WIND"] = json!(1);
        })
    };
    let told = |rest: &str| format!("1 unused: buffer view 1, EXT_meshopt_compression: {rest}");
    assert_eq!(unread(|_| ()), Vec::<String>::new());
    assert_eq!(unread(|view| view["byteLength"] = json!(20)), [told("its stream ends too early")]);
    assert_eq!(
        unread(|view| view["count"] = json!(2)),
        [told("2 elements of 4 bytes are not the 12 bytes of its view")]
    );
}

/// A skin of two joints, and the joints of the first vertex.
fn skinned(joint: u8, change: impl FnOnce(&mut Value)) -> Vec<String> {
    told(|document, data| {
        let joints = data.add(&[0, 1, joint, 0, 0, 1, 0, 0, 0, 0, 0, 0], 5121, "VEC4", 3, false);
        let weights = data.floats(&[[1.0, 0.0, 0.0, 0.0]; 3]);
        document["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
        document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
        document["nodes"] = json!([{ "mesh": 0, "skin": 0 }, { "children": [2] }, {}]);
        document["skins"] = json!([{ "joints": [1, 2] }]);
        change(document);
    })
}

#[test]
fn joints_are_those_of_the_skin() {
    assert!(skinned(1, |_| ()).is_empty());
    let expected = "1 unused: accessor 1: numbers of joints that its skin does not have";
    assert_eq!(skinned(2, |_| ()), [expected]);
    assert_eq!(skinned(255, |_| ()), [expected]);
    let without = |document: &mut Value| {
        document["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0 });
    };
    assert_eq!(skinned(0, without), ["1 node 0: it has a skin, but its mesh has no joints or no weights"]);
    let two = |document: &mut Value| {
        let skins = document["skins"].as_array_mut().expect("skins");
        skins.push(json!({ "joints": [1, 2], "inverseBindMatrices": 0 }));
    };
    let told = skinned(0, two);
    assert!(told.iter().any(|told| told.contains("skin 1: its inverse bind matrices")), "{told:?}");
}

#[test]
fn joints_have_one_weight_for_a_vertex() {
    let moved = |joints: [u8; 4], weights: [f32; 4], second: u8| {
        told(|document, data| {
            let bytes: Vec<u8> = joints.iter().copied().cycle().take(12).collect();
            let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
            attributes["JOINTS_0"] = json!(data.add(&bytes, 5121, "VEC4", 3, false));
            attributes["WEIGHTS_0"] = json!(data.floats(&[weights; 3]));
            attributes["JOINTS_1"] = json!(data.add(&[second; 12], 5121, "VEC4", 3, false));
            attributes["WEIGHTS_1"] = json!(data.floats(&[[0.25, 0.0, 0.0, 0.0]; 3]));
        })
    };
    let weights = [0.5, 0.25, 0.0, 0.0];
    assert_eq!(moved([1, 2, 0, 0], weights, 3), Vec::<String>::new());
    let fault = "3 unused: accessor 1: joints that have two weights for a vertex";
    assert_eq!(moved([1, 1, 0, 0], weights, 3), [fault]);
    assert_eq!(moved([1, 2, 0, 0], weights, 2), [fault]);
}

#[test]
fn weights_add_up() {
    // Of three vertices, in one set and in two.
    let weights = |first: [[f32; 4]; 3], second: [[f32; 4]; 3]| {
        let model = model(changed(|document, data| {
            let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
            attributes["WEIGHTS_0"] = json!(data.floats(&first));
            attributes["WEIGHTS_1"] = json!(data.floats(&second));
            for (name, joints) in [("JOINTS_0", [0, 1, 2, 3]), ("JOINTS_1", [4, 5, 6, 7])] {
                attributes[name] = json!(data.add(&[joints; 3].concat(), 5121, "VEC4", 3, false));
            }
        }));
        let found = model.findings.into_list().into_iter().filter(|finding| finding.subject.contains("weights"));
        found.map(|finding| (finding.subject, finding.count, finding.places)).collect::<Vec<_>>()
    };
    let (whole, half, none) = ([0.5, 0.5, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0], [0.0; 4]);
    assert!(weights([whole; 3], [none; 3]).is_empty());
    assert!(weights([half; 3], [half; 3]).is_empty());
    assert!(weights([[0.333, 0.333, 0.333, 0.0]; 3], [none; 3]).is_empty(), "rounded");
    let subject = "unused: accessor 1: weights that do not add up to 1".to_owned();
    let expected = (subject, 2, vec!["vertex 1".to_owned()]);
    assert_eq!(weights([half; 3], [half, none, whole]), [expected]);
    let bytes = |last: u8| {
        attribute("WEIGHTS_0", |data| {
            data.add(&[85, 85, 85, 0, 255, 0, 0, 0, 127, 126, 1, last], 5121, "VEC4", 3, true)
        })
    };
    assert!(bytes(1).iter().all(|rule| !rule.contains("add up")));
    assert!(bytes(4).contains(&"1 unused: accessor 1: weights that do not add up to 1".to_owned()));
}

#[test]
fn attributes_have_types_of_their_own() {
    let plain = |name: &str, component: u32, kind: &str, normalized: bool| {
        attribute(name, |data| data.add(&[0; 48], component, kind, 3, normalized))
    };
    for (name, component, kind, normalized) in [
        ("NORMAL", 5126, "VEC3", false),
        ("TANGENT", 5126, "VEC4", false),
        ("TEXCOORD_0", 5126, "VEC2", false),
        ("COLOR_0", 5126, "VEC3", false),
        ("COLOR_0", 5123, "VEC4", true),
        ("_ANYTHING", 5126, "MAT4", false),
    ] {
        let told = plain(name, component, if kind == "MAT4" { "SCALAR" } else { kind }, normalized);
        assert!(!told.iter().any(|told| told.contains("is no attribute")), "{name}: {told:?}");
    }
    for (name, component, kind, normalized) in [
        ("NORMAL", 5126, "VEC2", false),
        ("NORMAL", 5125, "VEC3", false),
        ("TANGENT", 5126, "VEC3", false),
        ("TEXCOORD_0", 5123, "VEC2", false),
        ("COLOR_0", 5123, "VEC4", false),
        ("JOINTS_0", 5126, "VEC4", false),
        ("WEIGHTS_0", 5126, "VEC2", false),
        ("ANYTHING", 5126, "VEC3", false),
        ("_ANYTHING", 5125, "SCALAR", false),
        ("", 5126, "SCALAR", false),
    ] {
        let told = plain(name, component, kind, normalized);
        assert!(told.iter().any(|told| told.contains(&format!("{name} is no attribute"))), "{name}: {told:?}");
    }
}

#[test]
fn references_of_extensions_lead_somewhere() {
    let used = [
        "KHR_materials_clearcoat",
        "OTHER_x",
        "EXT_texture_webp",
        "KHR_materials_variants",
        "KHR_physics_rigid_bodies",
    ];
    let told = |change: &dyn Fn(&mut Value)| {
        told(|document, _| {
            document["extensionsUsed"] = json!(used);
            change(document);
        })
    };
    let extension = |key: &str, index: u32| match key {
        "material" => told(&|document| {
            document["materials"] = json!([{ "extensions": { "KHR_materials_clearcoat":
                { "clearcoatFactor": 1, "clearcoatTexture": { "index": index } }, "OTHER_x": { "a": [[[]]] } } }]);
            document["textures"] = json!([{}]);
        }),
        "texture" => told(&|document| {
            document["textures"] = json!([{ "extensions": { "EXT_texture_webp": { "source": index } } }]);
            document["images"] = json!([{ "uri": "data:image/webp,RIFF....WEBP" }]);
        }),
        "variant" => told(&|document| {
            document["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_materials_variants":
                { "mappings": [{ "material": index, "variants": [0] }] } });
            document["materials"] = json!([{}]);
            document["extensions"] = json!({ "KHR_materials_variants": { "variants": [{ "name": "a" }] } });
        }),
        "physics" => told(&|document| {
            let lists = json!({ "physicsMaterials": [{}], "collisionFilters": [{}], "physicsJoints": [{}] });
            document["extensions"] = json!({ "KHR_physics_rigid_bodies": lists });
            document["nodes"][0]["extensions"] = json!({ "KHR_physics_rigid_bodies": {
                "collider": { "physicsMaterial": index, "collisionFilter": index }, "joint": { "joint": index } } });
        }),
        _ => told(&|document| {
            document["nodes"][0]["extensions"] = json!({ "KHR_physics_rigid_bodies": {
                "trigger": { "geometry": { "node": index } }, "joint": { "connectedNode": index } } });
        }),
    };
    for (key, count) in [("material", 1), ("texture", 1), ("variant", 1), ("body", 1), ("physics", 3)] {
        assert!(extension(key, 0).is_empty(), "{key}");
        let told = extension(key, 1);
        assert!(
            told.len() == count && told[0].contains("names") && told[0].contains(" 1, but there are 1"),
            "{told:?}"
        );
    }
}

#[test]
fn variants_map_each_name_once() {
    let found = |mappings: Value| {
        told(|document, _| {
            document["extensionsUsed"] = json!(["KHR_materials_variants"]);
            document["extensions"] = json!({ "KHR_materials_variants": { "variants": [{ "name": "a" }] } });
            document["materials"] = json!([{}]);
            document["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_materials_variants": mappings });
        })
    };
    assert!(found(json!({ "mappings": [{ "material": 0, "variants": [0] }] })).is_empty());
    for mappings in [json!({ "mappings": [] }), json!({})] {
        assert_eq!(found(mappings), ["1 mesh 0, primitive 0: its variants map nothing"]);
    }
    let fault = "1 mesh 0, primitive 0: a mapping has no variants, or one that is mapped twice";
    for mapping in [json!({ "material": 0 }), json!({ "material": 0, "variants": [0, 0] })] {
        assert_eq!(found(json!({ "mappings": [mapping] })), [fault]);
    }
    assert!(found(json!({ "mappings": [[0]] })).contains(&"1 mappings: a list where none is due".to_owned()));
}

#[test]
fn members_of_materials_extensions_are_of_their_kinds() {
    let found = |name: &str, member: &str, value: Value| {
        told(|document, _| {
            document["extensionsUsed"] = json!([name]);
            document["textures"] = json!([{}]);
            document["materials"] = json!([{ "extensions": { name: { member: value } } }]);
        })
    };
    for (name, member, sound, wrong) in [
        ("KHR_materials_clearcoat", "clearcoatFactor", json!(1), json!("x")),
        ("KHR_materials_clearcoat", "clearcoatFactor", json!(0), json!(-1)),
        ("KHR_materials_clearcoat", "clearcoatFactor", json!(0.5), Value::Null),
        ("KHR_materials_clearcoat", "clearcoatTexture", json!({ "index": 0 }), json!([0])),
        ("KHR_materials_transmission", "transmissionFactor", json!(1), json!(2)),
        ("KHR_materials_volume", "attenuationColor", json!([1, 0, 1]), json!([1, 1])),
        ("KHR_materials_emissive_strength", "emissiveStrength", json!(9), json!(-1)),
        ("KHR_materials_ior", "ior", json!(1.5), json!("x")),
        ("KHR_materials_ior", "ior", json!(0), json!(0.5)),
        ("KHR_materials_iridescence", "iridescenceThicknessMaximum", json!(400), json!("x")),
        ("KHR_materials_volume", "attenuationDistance", json!(0.1), json!(0)),
        ("KHR_materials_specular", "specularColorFactor", json!([0, 1, 3]), json!([-1, 0, 0])),
        ("KHR_materials_specular", "specularColorFactor", json!([0, 1, 3]), json!([1])),
        ("KHR_materials_pbrSpecularGlossiness", "glossinessFactor", json!(1), json!(5)),
    ] {
        assert!(found(name, member, sound).is_empty(), "{member}");
        let found = found(name, member, wrong);
        assert!(matches!(&found[..], [told] if told.starts_with(&format!("1 {member}: "))), "{found:?}");
    }
}

#[test]
fn primitives_have_the_coordinates_of_their_textures() {
    let found = |material: Value| {
        told(|document, data| {
            let primitive = &mut document["meshes"][0]["primitives"][0];
            primitive["attributes"]["TEXCOORD_0"] = json!(data.floats(&[[0.0; 2]; 3]));
            primitive["material"] = json!(0);
            document["extensionsUsed"] = json!(["KHR_texture_transform", "KHR_materials_clearcoat"]);
            document["textures"] = json!([{}]);
            document["materials"] = json!([material]);
        })
    };
    let at = |set: u32| json!({ "index": 0, "texCoord": set });
    let moved = json!({ "index": 0, "texCoord": 3, "extensions": { "KHR_texture_transform": { "texCoord": 0 } } });
    for sound in [at(0), json!({ "index": 0 }), moved] {
        assert!(found(json!({ "normalTexture": sound })).is_empty(), "{sound}");
    }
    let fault = "1 mesh 0, primitive 0: it has no TEXCOORD_1, which its material takes";
    for material in [
        json!({ "pbrMetallicRoughness": { "baseColorTexture": at(1) } }),
        json!({ "pbrMetallicRoughness": { "baseColorTexture": at(1) }, "alphaMode": "MASK" }),
        json!({ "pbrMetallicRoughness": { "metallicRoughnessTexture": at(1) }, "emissiveTexture": at(1) }),
        json!({ "extensions": { "KHR_materials_clearcoat": { "clearcoatTexture": at(1) } } }),
    ] {
        assert_eq!(found(material), [fault]);
    }
}

#[test]
fn what_is_not_shown_is_looked_at() {
    let hidden = |node: Value| {
        refused(changed(|document, _| {
            document["scenes"] = json!([{ "nodes": [0] }]);
            document["nodes"] = json!([{ "mesh": 0 }, node]);
        }))
    };
    let light = hidden(json!({ "extensions": { "KHR_lights_punctual": { "light": 3 } } }));
    assert!(light.contains("node 1, light 3"), "{light}");
    let instances = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "_ID": 9 } } });
    assert!(hidden(json!({ "extensions": instances })).contains("node 1, accessor 9"));
    for roots in [json!([2]), json!([1, 1])] {
        let scenes = told(|document, _| {
            document["nodes"] = json!([{ "mesh": 0 }, { "children": [2] }, {}]);
            document["scenes"] = json!([{ "nodes": [0] }, { "nodes": roots }]);
        });
        assert!(matches!(&scenes[..], [told] if told.contains("scene 1: its node")), "{scenes:?}");
    }
    let both = told(|document, _| {
        document["scenes"] = json!([{ "nodes": [0] }, { "nodes": [0] }]);
    });
    assert!(both.is_empty(), "two scenes may share a root");
}

#[test]
fn values_of_kinds_that_no_member_has_are_told() {
    let told_at = |change: fn(&mut Value)| told(|document, _| change(document));
    assert_eq!(told_at(|document| document["extras"] = json!({ "asset": [], "a": [[null]] })), Vec::<String>::new());
    assert_eq!(told_at(|document| document["nodes"][0]["name"] = Value::Null), ["1 name: null"]);
    let lists = members::told_of(br#"{ "asset": ["2.0"], "nodes": [[0], [1]], "scenes": [{ "nodes": [0] }] }"#);
    let [asset, nodes] = ["asset", "nodes"].map(|name| format!("{name}: a list where none is due"));
    assert_eq!(lists, [(asset, 1), (nodes, 2)]);
    let unlit = json!([{ "extensions": { "KHR_materials_unlit": [] } }]);
    let expected =
        ["1 KHR_materials_unlit: a list where none is due", "1 material 0: its extension KHR_materials_unlit"];
    let found = told(|document, _| {
        document["extensionsUsed"] = json!(["KHR_materials_unlit"]);
        document["materials"] = unlit;
    });
    assert!(expected.iter().all(|expected| found.iter().any(|found| found.starts_with(expected))), "{found:?}");
    // What it holds may be anything where nothing reads it.
    let open = json!({ "VENDOR_thing": { "a": null, "b": [[1]], "asset": [] } });
    let found = told(|document, _| {
        document["extensionsUsed"] = json!(["VENDOR_thing"]);
        document["extensions"] = open;
    });
    assert_eq!(found, Vec::<String>::new());
    let deep = format!("{}1{}", "{ \"odd\": ".repeat(1000), "}".repeat(1000));
    let told = members::told_of(deep.as_bytes());
    assert!(told.iter().any(|(told, _)| told.starts_with("JSON: what follows is not looked at")), "{told:?}");
}

#[test]
fn extensions_for_shading_may_hold_anything() {
    for extensions in [
        json!({ "KHR_materials_sheen": { "emissiveStrength": "much" } }),
        json!(null),
        json!({ "KHR_materials_sheen": { "sheenColorTexture": { "index": -1 } } }),
        json!({ "KHR_materials_unlit": true }),
    ] {
        let found = told(|document, _| {
            document["extensionsUsed"] = json!(["KHR_materials_sheen", "KHR_materials_unlit"]);
            document["materials"] = json!([{ "extensions": extensions }]);
        });
        assert_eq!(found.len(), 1, "{found:?}");
    }
}

#[test]
fn extensions_that_are_not_said_to_be_used_are_told_once() {
    let at = |change: fn(&mut Value)| told(|document, _| change(document));
    let expected = ["1 VENDOR_thing: it is not among the extensionsUsed"];
    let thing = |_: ()| json!({ "VENDOR_thing": {} });
    assert_eq!(at(|document| document["extensions"] = json!({ "VENDOR_thing": { "a": 1 } })), expected);
    let everywhere = told(|document, _| {
        for place in ["nodes", "meshes"] {
            document[place][0]["extensions"] = thing(());
        }
        document["meshes"][0]["primitives"][0]["extensions"] = thing(());
    });
    assert_eq!(everywhere, expected);
    // What an extension holds is its own, and so are extras.
    let inside = at(|document| {
        document["extensionsUsed"] = json!(["VENDOR_thing"]);
        document["extensions"] = json!({ "VENDOR_thing": { "extensions": { "OTHER_thing": {} } } });
        document["extras"] = json!({ "extensions": { "OTHER_thing": {} } });
    });
    assert!(inside.iter().all(|told| !told.contains("extensionsUsed")), "{inside:?}");
}

#[test]
fn sets_of_attributes_are_counted_and_paired() {
    let of = |names: &[&str]| {
        told(|document, data| {
            for name in names {
                let kind = if name.starts_with("TEX") { "VEC2" } else { "VEC4" };
                let component = if name.starts_with("JOINTS") { 5123 } else { 5126 };
                let accessor = match *name {
                    "WEIGHTS_0" => data.floats(&[[1.0, 0.0, 0.0, 0.0]; 3]),
                    _ => data.add(&[0; 48], component, kind, 3, false),
                };
                document["meshes"][0]["primitives"][0]["attributes"][*name] = json!(accessor);
            }
        })
    };
    let sets = ["TEXCOORD_0", "TEXCOORD_1", "JOINTS_0", "WEIGHTS_0", "JOINTS_1", "WEIGHTS_1", "COLOR_0"];
    assert!(of(&sets).is_empty(), "{:?}", of(&sets));
    for names in [&["TEXCOORD_1"][..], &["COLOR_0", "COLOR_2"]] {
        assert!(
            of(names)[..] == ["1 mesh 0, primitive 0: sets of its attributes are not counted from 0 on"],
            "{names:?}"
        );
    }
    for name in ["JOINTS_0", "WEIGHTS_0"] {
        assert_eq!(of(&[name]), ["1 mesh 0, primitive 0: its joints and weights are not pairs"]);
    }
    for name in ["TEXCOORD_00", "TEXCOORD_+0", "TEXCOORD", "NORMAL_0", "WEIGHTS_x"] {
        assert!(of(&[name]).iter().any(|told| told.contains("is no attribute")), "{name}");
    }
}

#[test]
fn sparse_values_that_nothing_reads_are_finite() {
    let normals = |value: f32| {
        attribute("NORMAL", |data| {
            let normals = data.floats(&[[0.0, 0.0, 1.0]; 3]);
            let places = data.add(&1u32.to_le_bytes(), 5125, "SCALAR", 1, false);
            let values = data.floats(&[[0.0, value, 1.0]]);
            let view = |accessor: usize| data.accessors[accessor]["bufferView"].clone();
            let sparse = json!({ "count": 1, "indices": { "bufferView": view(places), "componentType": 5125 },
                "values": { "bufferView": view(values) } });
            data.accessors.truncate(normals + 1);
            data.accessors[normals]["sparse"] = sparse;
            normals
        })
    };
    assert!(normals(0.5).is_empty(), "{:?}", normals(0.5));
    assert_eq!(normals(f32::NAN), ["1 unused: accessor 1: sparse components that are not finite"]);
}

#[test]
fn directions_have_length_one() {
    let normals =
        |second: [f32; 3]| attribute("NORMAL", |data| data.floats(&[[0.0, 0.0, 1.0], second, [0.6, 0.0, 0.8]]));
    // Exporters that divide by an estimate of the root, and those that write four decimals.
    for second in [[0.0, 0.0, 1.000_3], [0.577_4; 3], [0.0, -0.999_7, 0.0]] {
        assert!(normals(second).is_empty(), "{second:?}");
    }
    for second in [[0.0; 3], [0.0, 0.0, 1.001], [0.5; 3], [3.0, 0.0, 4.0]] {
        assert_eq!(normals(second), ["1 accessor 1: normals that are not of length 1"], "{second:?}");
    }
    let zeros = attribute("NORMAL", |data| {
        data.accessors.push(json!({ "componentType": 5126, "type": "VEC3", "count": 3 }));
        data.accessors.len() - 1
    });
    assert_eq!(zeros, ["3 accessor 1: normals that are not of length 1"]);
    let tangents = |w: f32| {
        attribute("TANGENT", |data| data.floats(&[[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, w], [1.0, 0.0, 0.0, -1.0]]))
    };
    assert!(tangents(-1.0).is_empty());
    for w in [0.0, 0.999, 2.0] {
        assert_eq!(tangents(w), ["1 accessor 1: tangents whose w is neither 1 nor -1"], "{w}");
    }
    // What is not finite is told once.
    assert_eq!(tangents(f32::NAN), ["1 unused: accessor 1: components that are not finite"]);
}

#[test]
fn extents_of_all_elements_are_theirs() {
    let normals = |key: &str, value: Value| {
        attribute("NORMAL", |data| {
            let normals = data.floats(&[[0.0, 0.6, 0.8], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]);
            data.accessors[normals][key] = value;
            normals
        })
    };
    assert!(normals("max", json!([0, 0.600_000_1, 1])).is_empty());
    let fault = "1 accessor 1: its min and max are not those of its elements";
    assert_eq!(normals("max", json!([0, 0.6, 1.1])), [fault]);
    assert_eq!(normals("min", json!([0, 0, 0])), [fault]);
    let colors = |max: u32| {
        attribute("COLOR_0", |data| {
            let colors = data.add(&[0, 9, 255, 0, 7, 7, 7, 7, 0, 0, 0, 0], 5121, "VEC4", 3, true);
            data.accessors[colors]["max"] = json!([7, 9, max, 7]);
            colors
        })
    };
    assert!(colors(255).is_empty(), "as they are stored");
    assert_eq!(colors(1), [fault]);
}

#[test]
fn data_uris_that_nothing_else_reads_are_looked_at() {
    let found = told(|document, data| {
        let encode = |bytes: &[u8]| {
            let encoded = base64::engine::general_purpose::STANDARD.encode(bytes);
            json!({ "uri": format!("data:application/octet-stream;base64,{encoded}"), "byteLength": bytes.len() })
        };
        document["buffers"] = json!([encode(&data.bytes), encode(&f32::NAN.to_le_bytes().repeat(9))]);
        data.views.push(json!({ "buffer": 1, "byteLength": 36 }));
        data.accessors.push(json!({ "bufferView": 1, "componentType": 5126, "type": "VEC3", "count": 3 }));
        document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(1);
    });
    assert_eq!(found, ["9 unused: accessor 1: components that are not finite"]);
}

#[test]
fn an_accessor_of_two_attributes_keeps_the_rules_of_both() {
    let shared = |second: [f32; 4]| {
        told(|document, data| {
            let both = data.floats(&[[1.0, 0.0, 0.0, 1.0], second, [0.0, 1.0, 0.0, 1.0]]);
            let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
            (attributes["COLOR_0"], attributes["TANGENT"]) = (json!(both), json!(both));
            attributes["NORMAL"] = json!(data.floats(&[[0.0, 0.0, 1.0]; 3]));
        })
    };
    assert_eq!(shared([0.0, 0.6, 0.8, 1.0]), Vec::<String>::new());
    assert_eq!(shared([0.5, 0.0, 0.0, 1.0]), ["1 accessor 1: tangents that are not of length 1"]);
    assert_eq!(shared([0.0, 0.0, -1.0, 1.0]), ["1 accessor 1: colours that are not between 0 and 1"]);
}

#[test]
fn quantised_directions_are_as_long_as_their_steps_allow() {
    let normals = |x: i8| {
        told(|document, data| {
            document["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
            document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            let bytes: Vec<u8> = [x, x, x, 0, 0, 0, 127, 0, 127, 0, 0, 0].into_iter().map(|byte| byte as u8).collect();
            let normals = data.add(&bytes, 5120, "VEC3", 3, true);
            let view = data.accessors[normals]["bufferView"].as_u64().expect("a view") as usize;
            data.views[view]["byteStride"] = json!(4);
            document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
        })
    };
    // 127/√3 is 73.3.
    for x in [73, 74, -74] {
        assert!(normals(x).is_empty(), "{x}");
    }
    for x in [71, 76, 0] {
        assert_eq!(normals(x), ["1 accessor 1: normals that are not of length 1"], "{x}");
    }
}

#[test]
fn colours_and_weights_are_shares() {
    let colors = |red: f32| attribute("COLOR_0", |data| data.floats(&[[red, 0.0, 1.0], [0.5; 3], [red, 1.0, 1.0]]));
    assert!(colors(1.0).is_empty());
    for red in [-0.1, 1.1] {
        assert_eq!(colors(red), ["2 accessor 1: colours that are not between 0 and 1"], "{red}");
    }
    let weights = told(|document, data| {
        let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
        attributes["WEIGHTS_0"] = json!(data.floats(&[[2.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.25; 4]]));
        attributes["JOINTS_0"] = json!(data.add(&[[0, 1, 2, 3]; 3].concat(), 5121, "VEC4", 3, false));
    });
    assert_eq!(weights, ["1 accessor 1: weights that are not between 0 and 1"]);
}
