//! Members that nothing reads: values of other kinds than theirs, lists that are empty, and text that is not UTF-8.

use super::*;
use crate::gltf::json::ExtensionNames;

/// What is told of a text, as `name: fault`.
fn told(text: &Value) -> Vec<String> {
    validate::kinds::check(text.to_string().as_bytes(), &ExtensionNames::default()).into_keys().collect()
}

#[test]
fn values_are_of_the_kinds_of_their_members() {
    let material = |material: Value| told(&json!({ "materials": [material] }));
    let rough = |key: &str, value: Value| material(json!({ "pbrMetallicRoughness": { key: value } }));
    let texture = |texture: &str, key: &str, value: Value| material(json!({ texture: { "index": 0, key: value } }));
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
        (texture("normalTexture", "scale", json!("x")), "scale: not a number"),
        (texture("normalTexture", "scale", json!([1])), "scale: not a number"),
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
    let found = validate::kinds::check(empty.to_string().as_bytes(), &ExtensionNames::default());
    let list = |name: &str, count: usize| (format!("{name}: an empty list"), count);
    assert!(found.into_iter().eq([list("children", 2), list("extensionsUsed", 1), list("targets", 1)]));
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
