//! Skins, morph targets, and bodies of colliders.

use glam::DVec3;
use umbriel_geometry::{Analytic, Cuboid, Rectangle};
use umbriel_scene::Sides;

use super::*;
use crate::options::Colliders;

/// The document of [`triangle`] with a skin of two joints on node 0: the joints stand at (0, 5, 0) and (0, 7, 0), their
/// inverse bind matrices move by −(0, 2, 0) and −(0, 4, 0).
fn skinned(change: impl FnOnce(&mut Value, &mut Data)) -> (Value, Data) {
    changed(|document, data| {
        let moved = |y: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, y, 0.0, 1.0];
        let bytes: Vec<u8> = [moved(-2.0), moved(-4.0)].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        let inverse = data.add(&bytes, 5126, "MAT4", 2, false);
        let joints = data.add(&[0; 12], 5121, "VEC4", 3, false);
        let weights = data.floats(&[[1.0, 0.0, 0.0, 0.0]; 3]);
        let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
        (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(joints), json!(weights));
        document["nodes"] = json!([
            { "name": "skin", "mesh": 0, "skin": 0, "translation": [100, 0, 0] },
            { "translation": [0, 5, 0], "children": [2] },
            { "translation": [0, 2, 0] },
        ]);
        document["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": inverse }]);
        change(document, data);
    })
}

#[test]
fn skins_are_taken_at_their_bind_pose() {
    let skin = model(skinned(|_, _| ()));
    assert_eq!(skin.objects[0].map.translation, DVec3::new(0.0, 3.0, 0.0), "the node's own matrix does not count");
    assert_eq!(found(skin), [(FindingKind::Deformation, "skin".to_owned(), 1)]);
    let bent = model(skinned(|document, _| document["nodes"][2]["rotation"] = json!([1, 0, 0, 1])));
    assert_eq!(bent.objects[0].map.translation, DVec3::new(0.0, 3.0, 0.0), "nor do the other joints");
    let plain = model(skinned(|document, _| document["skins"][0] = json!({ "joints": [2] })));
    assert_eq!(plain.objects[0].map.translation, DVec3::new(0.0, 7.0, 0.0));
    let outside = model(skinned(|document, _| document["scenes"] = json!([{ "nodes": [0] }])));
    assert_eq!(outside.objects[0].map.translation, DVec3::new(0.0, 3.0, 0.0), "its joints need not be in the scene");
    let told = (FindingKind::BrokenRule, "skin 0: joints that are not in the scene".to_owned(), 2);
    assert!(found(outside).contains(&told));
}

#[test]
fn broken_skins_are_refused() {
    let message = |skin: Value| refused(skinned(|document, _| document["skins"][0] = skin));
    assert!(message(json!({ "joints": [] })).contains("no joints"));
    assert!(message(json!({ "joints": [1, 9] })).contains("joint node 9"));
    assert!(
        message(json!({ "joints": [1, 2, 1], "inverseBindMatrices": 1 })).contains("2 inverse bind matrices for 3")
    );
    assert!(message(json!({ "joints": [1], "inverseBindMatrices": 0 })).contains("MAT4"));
    assert!(message(json!({ "joints": [1], "inverseBindMatrices": 7 })).contains("accessor 7"));
    assert!(refused(skinned(|document, _| document["nodes"][0]["skin"] = json!(1))).contains("skin 1"));
}

#[test]
fn inverse_bind_matrices_that_place_nothing_are_told() {
    let with = |joint: usize, entry: usize, value: f32| {
        skinned(|_, data| {
            let start = data.bytes.len() - 12 - 12 * 4 - 2 * 64 + 64 * joint + 4 * entry;
            data.bytes[start..start + 4].copy_from_slice(&value.to_le_bytes());
        })
    };
    let told = |joint: usize, entry: usize, value: f32| found(model(with(joint, entry, value)));
    let kept = (FindingKind::Deformation, "skin".to_owned(), 1);
    assert_eq!(told(1, 13, -4.0), std::slice::from_ref(&kept));
    for (entry, value, rule) in
        [(0, f32::NAN, "that are not finite"), (3, 0.5, "with a last row that is not quite 0 0 0 1")]
    {
        let subject = format!("accessor 1: inverse bind matrices {rule}");
        assert_eq!(told(1, entry, value), [kept.clone(), (FindingKind::BrokenRule, subject, 1)]);
    }
    assert!(refused(with(0, 0, f32::NAN)).contains("inverse bind matrix 0 is not finite"));
}

/// A triangle with two morph targets: one moves all corners by (1, 2, 3), the other the first by (0, 0, 10).
fn morphed(change: impl FnOnce(&mut Value)) -> (Value, Data) {
    changed(|document, data| {
        let all = data.floats(&[[1.0, 2.0, 3.0]; 3]);
        let first = data.floats(&[[0.0, 0.0, 10.0], [0.0; 3], [0.0; 3]]);
        document["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": all }, { "POSITION": first }]);
        change(document);
    })
}

#[test]
fn morph_targets_count_by_their_default_weights() {
    let corner = |input| mesh(&model(input).objects[0]).positions()[0].to_array();
    assert_eq!(corner(morphed(|_| ())), [1.0, 0.0, 0.0]);
    assert_eq!(corner(morphed(|document| document["meshes"][0]["weights"] = json!([1, 0.5]))), [2.0, 2.0, 8.0]);
    let own = |document: &mut Value| {
        document["meshes"][0]["weights"] = json!([1, 0.5]);
        document["nodes"] = json!([{ "mesh": 0, "weights": [0, 1] }, { "mesh": 0 }, { "mesh": 0, "weights": [0, 1] }]);
    };
    let model = model(morphed(own));
    let corners: Vec<_> = model.objects.iter().map(|object| mesh(object).positions()[0].to_array()).collect();
    assert_eq!(corners, [[1.0, 0.0, 10.0], [2.0, 2.0, 8.0], [1.0, 0.0, 10.0]]);
    assert!(std::ptr::eq(mesh(&model.objects[0]), mesh(&model.objects[2])), "equal weights share one mesh");
    let kinds: Vec<_> = found(model).into_iter().map(|(kind, _, count)| (kind, count)).collect();
    assert_eq!(kinds, [(FindingKind::Deformation, 1); 3]);
    let short = self::model(morphed(|document| document["meshes"][0]["weights"] = json!([1])));
    assert_eq!(mesh(&short.objects[0]).positions()[0].to_array(), [2.0, 2.0, 3.0]);
    assert!(found(short).iter().any(|(kind, ..)| *kind == FindingKind::BrokenRule));
    let other = refused(morphed(|document| {
        document["accessors"] = Value::Null;
        document.as_object_mut().expect("an object").remove("accessors");
        document["meshes"][0]["weights"] = json!([1, 1]);
        document["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(9);
    }));
    assert!(other.contains("primitive 0, morph target 0, accessor 9"), "{other}");
}

/// A node without a mesh whose collider has that shape, in one of the two spellings.
fn collider(shape: &Value, is_old: bool) -> (Value, Data) {
    changed(|document, _| {
        let (list, collider) = match is_old {
            true => ("KHR_collision_shapes", json!({ "shape": 0 })),
            false => ("KHR_implicit_shapes", json!({ "geometry": { "shape": 0 } })),
        };
        let node = json!({ "name": "body", "translation": [0, 9, 0],
            "extensions": { "KHR_physics_rigid_bodies": { "collider": collider } } });
        document["nodes"] = json!([{ "mesh": 0 }, node]);
        document["extensions"] = json!({ list: { "shapes": [shape] } });
        document["extensionsUsed"] = json!([list, "KHR_physics_rigid_bodies"]);
    })
}

#[test]
fn colliders_without_a_mesh_are_bodies() {
    let turned = |kind: &str, bottom: f64, top: f64| json!({ "type": kind, kind: { "height": 3, "radiusBottom": bottom, "radiusTop": top } });
    for (shape, expected) in [
        (json!({ "type": "sphere", "sphere": { "radius": 2 } }), Analytic::Sphere { radius: 2.0 }),
        (json!({ "type": "sphere" }), Analytic::Sphere { radius: 0.5 }),
        (json!({ "type": "cylinder" }), Analytic::Cylinder { radius: 0.25, height: 0.5 }),
        (turned("cylinder", 2.0, 2.0), Analytic::Cylinder { radius: 2.0, height: 3.0 }),
        (turned("cylinder", 2.0, 0.0), Analytic::Cone { radius: 2.0, height: 3.0 }),
        (turned("cylinder", 2.0, 1.0), Analytic::Frustum { bottom_radius: 2.0, top_radius: 1.0, height: 3.0 }),
        (turned("capsule", 2.0, 2.0), Analytic::Capsule { radius: 2.0, height: 3.0 }),
        (
            json!({ "type": "capsule", "capsule": { "radius": 1, "height": 4 } }),
            Analytic::Capsule { radius: 1.0, height: 4.0 },
        ),
    ] {
        for is_old in [false, true] {
            let model = model(collider(&shape, is_old));
            assert_eq!(names(&model), ["node0", "body"]);
            assert!(model.objects[1].shape.analytic() == Some(&expected), "{shape}");
            assert_eq!(model.objects[1].map, glam::DAffine3::from_translation(DVec3::new(0.0, 9.0, 0.0)));
            assert!(found(model).is_empty());
        }
    }
    let standing = model(collider(&turned("cylinder", 0.0, 2.0), false));
    assert_eq!(standing.objects[1].map.transform_point3(DVec3::new(0.0, 1.5, 0.0)), DVec3::new(0.0, 7.5, 0.0));
    let cuboid = model(collider(&json!({ "type": "box", "box": { "size": [1, 2, 3] } }), false));
    assert!(matches!(cuboid.objects[1].shape, Shape::Cuboid(Cuboid { size: [1.0, 2.0, 3.0] })));
    let plane = json!({ "type": "plane", "plane": { "sizeX": 4, "sizeZ": 5, "doubleSided": true } });
    let plane = model(collider(&plane, false));
    assert!(matches!(plane.objects[1].shape, Shape::Rectangle(Rectangle { size: [4.0, 5.0] })));
    assert_eq!(plane.objects[1].sides, Some(Sides::Two));
}

#[test]
fn shapes_that_are_no_bodies_are_told() {
    let tapered = json!({ "type": "capsule", "capsule": { "height": 3, "radiusBottom": 1, "radiusTop": 2 } });
    for shape in [tapered, json!({ "type": "plane" }), json!({ "type": "trimesh", "trimesh": { "mesh": 0 } })] {
        let model = model(collider(&shape, true));
        assert_eq!(names(&model), ["node0"]);
        assert_eq!(found(model), [(FindingKind::UnreadShape, "body".to_owned(), 1)]);
    }
    let (mut document, data) = collider(&json!({ "type": "sphere" }), false);
    document["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"]["collider"]["geometry"]["shape"] = json!(3);
    assert!(refused((document, data)).contains("node 1 (\"body\"): it names shape 3"));
}

#[test]
fn shapes_without_a_size_are_told() {
    for shape in [
        json!({ "type": "box", "box": { "size": [1, 0, 1] } }),
        json!({ "type": "sphere", "sphere": { "radius": 0 } }),
        json!({ "type": "sphere", "sphere": { "radius": 1e-300 } }),
        json!({ "type": "cylinder", "cylinder": { "height": 0 } }),
        json!({ "type": "cylinder", "cylinder": { "radiusTop": 0, "radiusBottom": 0 } }),
        json!({ "type": "cylinder", "cylinder": { "height": 0, "radiusTop": 1, "radiusBottom": 2 } }),
        json!({ "type": "capsule", "capsule": { "radius": 0 } }),
        json!({ "type": "plane", "plane": { "sizeX": 0, "sizeZ": 1 } }),
    ] {
        let model = model(collider(&shape, false));
        assert_eq!(names(&model), ["node0"], "{shape}");
        assert_eq!(found(model), [(FindingKind::NotTriangles, "body".to_owned(), 1)], "{shape}");
    }
    for shape in [
        json!({ "type": "sphere", "sphere": { "radius": -1 } }),
        json!({ "type": "box", "box": { "size": [-1, 0, 1] } }),
        json!({ "type": "cylinder", "cylinder": { "height": -1 } }),
    ] {
        let model = model(collider(&shape, false));
        let ledger = crate::ledger::Ledger::default();
        assert!(model.into_scene(glam::DAffine3::IDENTITY, Sides::Auto, &ledger).is_err(), "{shape}");
    }
}

#[test]
fn colliders_stand_for_meshes_where_that_is_wanted() {
    let with_mesh = || {
        let (mut document, data) = collider(&json!({ "type": "sphere", "sphere": { "radius": 2 } }), false);
        document["nodes"][1]["mesh"] = json!(0);
        (document, data)
    };
    let body = |reading: &Reading| {
        let model = parse_with(with_mesh(), reading).expect("a model");
        assert_eq!(names(&model), ["node0", "body"]);
        model.objects[1].shape.analytic() == Some(&Analytic::Sphere { radius: 2.0 })
    };
    assert!(!body(&Reading::default()), "the mesh");
    assert!(body(&Reading { colliders: Colliders::InPlace, ..Reading::default() }));
}
