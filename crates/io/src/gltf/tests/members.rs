//! Members that nothing reads: values of other kinds than theirs, lists that are empty, names that stand twice, extensions out of place, and text that is not UTF-8.

use super::*;
use crate::gltf::json::ExtensionNames;

/// What is told of a text: `name: fault`, and how often.
pub(super) fn told_of(text: &[u8]) -> Vec<(String, usize)> {
    let found = validate::kinds::check(text, &ExtensionNames::default()).into_list();
    found.into_iter().map(|finding| (finding.subject, finding.count)).collect()
}

/// What is told of a text, as `name: fault`.
fn told(text: &Value) -> Vec<String> {
    told_of(text.to_string().as_bytes()).into_iter().map(|(subject, _)| subject).collect()
}

#[test]
fn values_are_of_the_kinds_of_their_members() {
    let material = |material: Value| told(&json!({ "materials": [material] }));
    let rough = |key: &str, value: Value| material(json!({ "pbrMetallicRoughness": { key: value } }));
    let texture = |texture: &str, key: &str, value: Value| material(json!({ texture: { "index": 0, key: value } }));
    let moved = |key: &str, value: Value| {
        let used: ExtensionNames = serde_json::from_value(json!(["KHR_texture_transform"])).expect("names");
        let transform = json!({ "KHR_texture_transform": { key: value } });
        let text = json!({ "materials": [{ "normalTexture": { "index": 0, "extensions": transform } }] }).to_string();
        let found = validate::kinds::check(text.as_bytes(), &used).into_list();
        found.into_iter().map(|finding| finding.subject).collect::<Vec<_>>()
    };
    for sound in [
        told(
            &json!({ "asset": { "generator": "x", "copyright": "" }, "nodes": [{ "name": "a", "scale": [1, 1, 2] }] }),
        ),
        material(json!({ "doubleSided": true, "emissiveFactor": [0, 0.5, 1.0], "name": "m" })),
        rough("metallicFactor", json!(1)),
        rough("roughnessFactor", json!(0.25)),
        texture("normalTexture", "scale", json!(-2.5)),
        texture("occlusionTexture", "strength", json!(0)),
        texture("emissiveTexture", "texCoord", json!(1.0)),
        moved("offset", json!([-0.5, 3])),
        moved("rotation", json!(-7)),
        told(&json!({ "nodes": [{ "extras": { "name": 5, "children": [] } }] })),
    ] {
        assert_eq!(sound, Vec::<String>::new());
    }
    for (found, fault) in [
        (told(&json!({ "asset": { "generator": 5 } })), "generator: not a text"),
        (told(&json!({ "asset": { "copyright": [1] } })), "copyright: not a text"),
        (told(&json!({ "scenes": [{ "name": {} }] })), "name: not a text"),
        (told(&json!({ "accessors": [{ "name": true }] })), "name: not a text"),
        (material(json!({ "doubleSided": 1 })), "doubleSided: neither true nor false"),
        (material(json!({ "emissiveFactor": "red" })), "emissiveFactor: not three numbers"),
        (material(json!({ "emissiveFactor": [1] })), "emissiveFactor: not three numbers"),
        (material(json!({ "emissiveFactor": [0, 2, 0] })), "emissiveFactor: not a number between 0 and 1"),
        (rough("metallicFactor", json!("x")), "metallicFactor: not a number between 0 and 1"),
        (rough("roughnessFactor", json!(-1)), "roughnessFactor: not a number between 0 and 1"),
        (moved("offset", json!([1])), "offset: not two numbers"),
        (moved("scale", json!(2)), "scale: not two numbers"),
        (moved("scale", json!(["1", 2])), "scale: not a number"),
        (moved("rotation", json!([0])), "rotation: not a number"),
        (texture("normalTexture", "scale", json!("x")), "scale: not a number"),
        (texture("normalTexture", "scale", json!([1])), "scale: not a number"),
        (texture("clearcoatNormalTexture", "scale", json!("x")), "scale: not a number"),
        (texture("occlusionTexture", "strength", json!(2)), "strength: not a number between 0 and 1"),
        (texture("normalTexture", "texCoord", json!(-1)), "texCoord: not a whole number"),
        (texture("normalTexture", "texCoord", json!(0.5)), "texCoord: not a whole number"),
    ] {
        assert!(matches!(&found[..], [told] if told.starts_with(fault)), "{found:?} should tell {fault:?}");
    }
}

#[test]
fn empty_lists_are_told() {
    let empty = json!({ "extensionsUsed": [], "nodes": [{ "children": [] }, { "children": [], "mesh": 0 }],
        "meshes": [{ "primitives": [{ "targets": [] }] }], "unknown": [] });
    let list = |name: &str, count: usize| (format!("{name}: an empty list"), count);
    let expected = [list("children", 2), list("extensionsUsed", 1), list("targets", 1)];
    assert_eq!(told_of(empty.to_string().as_bytes()), expected);
    let found = validate::kinds::check(empty.to_string().as_bytes(), &ExtensionNames::default()).into_list();
    assert_eq!(found[0].places, ["/nodes/0/children", "/nodes/1/children"]);
    assert_eq!(found[2].places, ["/meshes/0/primitives/0/targets"]);
}

#[test]
fn text_that_is_not_utf_8_is_refused() {
    let (document, _) = triangle(&json!([{}]));
    let text = document.to_string().replacen('{', "{\n \"extras\": \"?\",", 1);
    let read_with = |byte: u8| {
        let bytes: Vec<u8> = text.bytes().map(|found| if found == b'?' { byte } else { found }).collect();
        super::super::parse(&bytes).map(|_| ()).map_err(|problem| problem.to_string())
    };
    assert_eq!(read_with(b'!'), Ok(()));
    assert_eq!(read_with(0xff), Err("line 2, column 13: its JSON is not UTF-8".to_owned()));
}

#[test]
fn members_of_extensions_are_of_their_kinds() {
    let with = |name: &str, extension: Value| {
        parse(changed(|document, _| {
            document["extensionsUsed"] = json!([name]);
            document["extensions"] = json!({ name: extension });
        }))
    };
    let spot = |cone: Value| json!({ "lights": [{ "type": "spot", "spot": cone }] });
    let lights = |extension: Value| with("KHR_lights_punctual", extension);
    assert!(found(lights(spot(json!({ "innerConeAngle": 0.1 }))).expect("loads")).is_empty());
    assert!(lights(spot(json!({ "innerConeAngle": "x" }))).is_err());
    let turned = lights(spot(json!({ "innerConeAngle": 1.0, "outerConeAngle": 0.5 }))).expect("loads");
    assert!(found(turned)[0].1.starts_with("light 0: it has no spot, or the angles"));
    for (cone, is_sound) in [([0.0, 1.570_796_4], true), ([0.5, 0.5], false), ([0.0, 1.58], false), ([0.0, 0.0], false)]
    {
        let told = found(lights(spot(json!({ "innerConeAngle": cone[0], "outerConeAngle": cone[1] }))).expect("loads"));
        assert_eq!(told.is_empty(), is_sound, "{cone:?}: {told:?}");
    }
    assert!(with("KHR_materials_variants", json!({ "variants": [{ "name": 5 }] })).is_err());
    // Of a list the reader takes the elements for the members in their order.
    let list = with("KHR_implicit_shapes", json!({ "shapes": [{ "type": "sphere", "sphere": [2.0] }] }));
    let told = found(list.expect("loads"));
    assert!(told.iter().any(|(_, subject, _)| subject == "sphere: a list where none is due"), "{told:?}");
}

/// The places of names that stand twice, and how many there are.
fn twice(text: &str) -> (Vec<String>, usize) {
    let found = keys::check(text.as_bytes()).into_list();
    assert!(found.len() < 2, "one finding for all: {found:?}");
    found.into_iter().next().map_or((Vec::new(), 0), |finding| (finding.places, finding.count))
}

#[test]
fn names_that_stand_twice_are_told() {
    for (text, places) in [
        (r#"{ "a": 1, "b": { "a": [{ "a": 2 }, { "b": "a", "c": "," }] }, "A": null, "": "" }"#, &[][..]),
        (r#"["a", "a", { "a": "a" }, { "a" : true }, [], {}]"#, &[]),
        // Half of a character, and the letters that write it.
        (r#"{ "\ud800": 1, "\\ud800": 2 }"#, &[]),
        (r#"{"asset":{"generator":"x","version":"2.0","generator":"y"}}"#, &["/asset/generator"]),
        (
            r#"{ "materials": [{}, { "doubleSided": true,"doubleSided"
            : false }] }"#,
            &["/materials/1/doubleSided"],
        ),
        (
            r#"{ "extras": { "\u0061": [1, { "x": [[], [{ "k/~": 0, "k/~": 0 }]] }], "a": 0 } }"#,
            &["/extras/a/1/x/1/0/k~1~0", "/extras/a"],
        ),
        (r#"{ "x": 1, "x": { "y": 1 }, "x": 2, "\"": 3, "\\": 4 }"#, &["/x", "/x"]),
    ] {
        assert_eq!(twice(text), (places.iter().map(|&place| place.to_owned()).collect(), places.len()), "{text}");
    }
    let many = format!("[{}]", vec![r#"{"a":0,"a":0}"#; 1000].join(","));
    assert_eq!(twice(&many).1, 1000);
    assert_eq!(twice(&many).0, ["/0/a", "/1/a", "/2/a", "/3/a", "/4/a"]);
    let deep = format!("{}{}", r#"{"extras":[1,"#.repeat(100_000), r#"{"a":0,"a":0}"#) + &"]}".repeat(100_000);
    assert!(twice(&deep).0[0].starts_with("/extras/1/extras/1/"));
}

#[test]
fn names_that_stand_twice_are_told_of_files() {
    let told = |asset: &str| {
        let text = format!(r#"{{ "asset": {{ "version": "2.0", {asset} }} }}"#);
        found(read(text.as_bytes(), &folder(), &reading()).expect("loads"))
    };
    assert_eq!(told(r#""generator": "x""#), []);
    let twice = told(r#""generator": "x", "generator": "y""#);
    assert!(matches!(&twice[..], [(_, subject, 1)] if subject.starts_with("JSON: a name")), "{twice:?}");
}

/// What is told of a text in which an extension, which it uses, stands where `@` is: the places.
fn out_of_place(extension: &str, text: &str) -> Vec<String> {
    let used: ExtensionNames = serde_json::from_value(json!([extension])).expect("names");
    let text = text.replace('@', &format!(r#""extensions": {{ "{extension}": {{}} }}"#));
    let found = validate::kinds::check(text.as_bytes(), &used).into_list();
    assert!(found.iter().all(|found| found.subject == format!("{extension}: it means nothing where it stands")));
    found.into_iter().flat_map(|found| found.places).collect()
}

#[test]
fn extensions_that_mean_nothing_where_they_stand_are_told() {
    let (light, moved) = ("KHR_lights_punctual", "KHR_texture_transform");
    for (extension, text) in [
        (light, r#"{ @, "nodes": [{ @ }, { @ }] }"#),
        (
            moved,
            r#"{ "materials": [{ "normalTexture": { @ }, "pbrMetallicRoughness": { "baseColorTexture": { @ } } }] }"#,
        ),
        ("KHR_materials_unlit", r#"{ "materials": [{ @ }] }"#),
        ("KHR_animation_pointer", r#"{ "animations": [{ "channels": [{ "target": { @ } }] }] }"#),
        ("EXT_meshopt_compression", r#"{ "buffers": [{ @ }], "bufferViews": [{ @ }] }"#),
        ("KHR_materials_variants", r#"{ @, "meshes": [{ "primitives": [{ @ }] }] }"#),
        ("VENDOR_thing", r#"{ "scenes": [{ @ }], "asset": { @ } }"#),
        (light, r#"{ "accessors": [{ "extras": { @ } }] }"#),
    ] {
        assert_eq!(out_of_place(extension, text), Vec::<String>::new(), "{extension}");
    }
    for (extension, text, place) in [
        (light, r#"{ "accessors": [{}, { @ }] }"#, "/accessors/1/extensions"),
        (light, r#"{ "scenes": [{ @ }] }"#, "/scenes/0/extensions"),
        (light, r#"{ "meshes": [{ "primitives": [{ @ }] }] }"#, "/meshes/0/primitives/0/extensions"),
        (moved, r#"{ "textures": [{ @ }] }"#, "/textures/0/extensions"),
        ("KHR_materials_unlit", "{ @ }", "/extensions"),
        ("KHR_mesh_quantization", r#"{ "meshes": [{ @ }] }"#, "/meshes/0/extensions"),
        ("EXT_texture_webp", r#"{ "images": [{ @ }] }"#, "/images/0/extensions"),
    ] {
        assert_eq!(out_of_place(extension, text), [format!("{place}/{extension}")], "{extension}");
    }
}
