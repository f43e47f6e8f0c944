//! Buffers, and what their views say that they are for.

use super::{rules::told, *};

#[test]
fn buffers_that_nothing_reads_are_looked_up() {
    let with = |buffer: Value| {
        told(move |document, data| {
            let uri = base64::engine::general_purpose::STANDARD.encode(&data.bytes);
            let uri = format!("Data:Application/Octet-Stream;BASE64,{uri}");
            document["buffers"] = json!([{ "uri": uri, "byteLength": data.bytes.len() }, buffer]);
        })
    };
    assert_eq!(with(json!({ "uri": "data:application/octet-stream;base64,AAAA", "byteLength": 3 })), "");
    assert_eq!(with(json!({ "uri": "data:application/octet-stream;base64,AAAA", "byteLength": 2 })), "");
    let fallback = json!({ "EXT_meshopt_compression": { "fallback": true } });
    assert_eq!(with(json!({ "byteLength": 9, "extensions": fallback })), "");
    for (buffer, fault) in [
        (json!({ "byteLength": 4 }), "unused: buffer 1: it has no uri"),
        (
            json!({ "uri": "data:application/octet-stream;base64,AAAA", "byteLength": 4 }),
            "it should have 4 bytes, but 3 are there",
        ),
        (json!({ "uri": "data:application/octet-stream;base64,A!AA", "byteLength": 3 }), "not base64"),
        (json!({ "uri": "../other.bin", "byteLength": 3 }), "leads out of the folder"),
        (json!({ "uri": "http://a/b", "byteLength": 3 }), "is not a file"),
        (json!({ "uri": "missing.bin", "byteLength": 3 }), "cannot be read"),
    ] {
        let told = with(buffer);
        assert!(told.contains(fault), "{told}");
    }
}

#[test]
fn folders_are_no_buffers() {
    let folder = Folder::of_scene(Path::new("scene.gltf"), Outside::Refused);
    let document = json!({ "asset": { "version": "2.0" }, "buffers": [{ "uri": ".", "byteLength": 1 }] });
    let told = found(read(document.to_string().as_bytes(), &folder, &reading()).expect("loads"));
    assert!(matches!(&told[..], [(_, subject, 1)] if subject.ends_with("buffer 0: \".\" is not a file")), "{told:?}");
}

#[test]
fn data_uris_of_buffers_have_their_type_and_no_white_space() {
    let with = |kind: &str, from: &str, to: &str| {
        told(|document, data| {
            let encoded = base64::engine::general_purpose::STANDARD.encode(&data.bytes).replace(from, to);
            let uri = format!("data:{kind};base64,{encoded}");
            document["buffers"] = json!([{ "uri": uri, "byteLength": data.bytes.len() }]);
        })
    };
    for kind in ["application/octet-stream", "application/gltf-buffer"] {
        assert_eq!(with(kind, "", ""), "");
        assert_eq!(with(kind, "AAAA", "AA\n AA"), "buffer 0: its data URI has white space");
    }
    for kind in ["", "image/png"] {
        assert_eq!(with(kind, "", ""), "buffer 0: its data URI's type is none of buffers'");
    }
}

#[test]
fn what_views_are_for_is_told() {
    let view = |change: fn(&mut Value)| {
        move |data: &mut Data| {
            change(data.views.last_mut().expect("a view"));
        }
    };
    let indices = |change: fn(&mut Value)| {
        told(move |document, data| {
            let indices = data.add(&[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0], 5125, "SCALAR", 3, false);
            view(change)(data);
            document["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        })
    };
    let sparse = |change: fn(&mut Value)| {
        told(move |_, data| {
            let indices = data.add(&[0, 0, 0, 0], 5125, "SCALAR", 1, false);
            view(change)(data);
            let sparse = json!({ "count": 1, "indices": { "bufferView": indices, "componentType": 5125 }, "values": { "bufferView": 0 } });
            data.accessors.push(json!({ "componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse }));
        })
    };
    let matrices = |change: fn(&mut Value)| {
        told(move |document, data| {
            let matrices = data.add(&[0; 64], 5126, "MAT4", 1, false);
            view(change)(data);
            document["skins"] = json!([{ "joints": [0], "inverseBindMatrices": matrices }]);
        })
    };
    let stride: fn(&mut Value) = |view| view["byteStride"] = json!(4);
    let wide: fn(&mut Value) = |view| view["byteStride"] = json!(64);
    let target: fn(&mut Value) = |view| view["target"] = json!(34962);
    let plain = "its buffer view has a stride or a target";
    for (found, fault) in [
        (indices(stride), "accessor 1: its buffer view has a stride, and holds indices".to_owned()),
        (indices(target), "accessor 1: its buffer view is not for indices".to_owned()),
        (sparse(stride), format!("accessor 2, sparse: {plain}")),
        (sparse(target), format!("accessor 2, sparse: {plain}")),
        (matrices(wide), format!("skin 0: {plain}")),
        (matrices(target), format!("skin 0: {plain}")),
    ] {
        assert!(found.contains(&fault), "{found:?} should tell {fault:?}");
    }
    assert_eq!([indices(|_| ()), sparse(|_| ()), matrices(|_| ())], [""; 3]);
}

#[test]
fn views_of_motions_and_of_what_morphs_are_told() {
    let view = |data: &mut Data, key: &str, value: u32| data.views.last_mut().expect("a view")[key] = json!(value);
    let moved = |key: &'static str, value: u32| {
        told(move |document, data| {
            let times = data.floats(&[[0.0], [1.0]]);
            let places = data.floats(&[[0.0; 3]; 2]);
            view(data, key, value);
            document["animations"] = json!([{ "samplers": [{ "input": times, "output": places }],
                "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }] }]);
        })
    };
    let morphed = |key: &'static str, value: u32| {
        told(move |document, data| {
            let target = data.floats(&[[0.0; 3]; 3]);
            view(data, key, value);
            document["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
        })
    };
    // Where it begins anyway.
    assert_eq!(moved("byteOffset", 44), "");
    for told in [moved("byteStride", 12), moved("target", 34962)] {
        assert_eq!(
            told,
            "animation 0, sampler 0: its buffer view has a stride or a target, which only those of vertices and indices have"
        );
    }
    assert!(morphed("target", 34963).contains("accessor 1: its buffer view is not for vertices"));
    for kept in [morphed("target", 34962), morphed("byteStride", 12)] {
        assert!(!kept.contains("view"), "{kept}");
    }
}

#[test]
fn views_that_vertices_share_have_a_stride() {
    let shared = |stride: Option<u32>| {
        told(|document, data| {
            data.bytes = data.bytes.chunks(12).flat_map(|corner| [corner, corner].concat()).collect();
            let accessor = data.accessors[0].clone();
            data.accessors.push(accessor);
            data.accessors[1]["byteOffset"] = json!(if stride.is_some() { 12 } else { 36 });
            data.views[0]["byteLength"] = json!(72);
            if let Some(stride) = stride {
                data.views[0]["byteStride"] = json!(stride);
            }
            document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(1);
        })
    };
    assert_eq!(shared(Some(24)), "");
    assert!(shared(None).contains("buffer view 0: several accessors of vertices share it, and it has no stride"));
}

#[test]
fn views_of_indices_hold_no_vertices() {
    let mixed = |is_mixed: bool| {
        told(|document, data| {
            let indices = data.add(&[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0], 5125, "SCALAR", 3, false);
            if is_mixed {
                data.views[0]["byteLength"] = json!(48);
                data.accessors[indices]["bufferView"] = json!(0);
                data.accessors[indices]["byteOffset"] = json!(36);
            }
            document["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        })
    };
    assert_eq!([mixed(false).as_str(), &mixed(true)], ["", "buffer view 0: it holds indices and vertices"]);
    let skinned = told(|document, data| {
        data.bytes.extend([0; 64]);
        data.views[0]["byteLength"] = json!(100);
        data.accessors
            .push(json!({ "bufferView": 0, "byteOffset": 36, "componentType": 5126, "type": "MAT4", "count": 1 }));
        document["skins"] = json!([{ "joints": [0], "inverseBindMatrices": 1 }]);
        document["images"] = json!([{ "bufferView": 0, "mimeType": "image/ktx2" }]);
        document["extensionsUsed"] = json!(["KHR_texture_basisu"]);
    });
    assert!(skinned.contains("buffer view 0: it holds inverse bind matrices and pictures and vertices"), "{skinned}");
}
