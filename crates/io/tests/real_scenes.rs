//! Real scenes from public collections, where they are at hand: everything loads, nothing is lost.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use umbriel_io::{LoadError, LoadOptions, LoadProblem, LoadedScene, UpAxis, load, surface_findings};
use umbriel_scene::{FindingKind, Member, Projection, Scene, Shape};

/// The path of a scene, unless the collection is not there.
#[expect(clippy::print_stderr, reason = "a test that is skipped says so")]
fn data(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(name);
    let there = path.exists();
    if !there {
        eprintln!("skipped: the collection with {name} is not here");
    }
    there.then_some(path)
}

fn read(name: &str) -> Option<LoadedScene> {
    Some(load(&data(name)?, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}")))
}

fn triangles(scene: &Scene) -> usize {
    scene.objects.iter().map(|object| object.face_count()).sum()
}

fn count(scene: &Scene, kind: FindingKind) -> usize {
    scene.findings.iter().filter(|finding| finding.kind == kind).map(|finding| finding.count).sum()
}

/// The triangles of an OBJ, counted from its faces alone.
fn written_triangles(name: &str) -> usize {
    let text = std::fs::read_to_string(data(name).expect("checked before")).expect("readable");
    text.lines().filter(|line| line.starts_with("f ")).map(|line| line.split_whitespace().count() - 3).sum()
}

#[test]
fn obj_scenes_keep_their_triangles_and_objects() {
    for (name, objects) in [
        ("cornell/cornell_box.obj", 8),
        ("spot/spot.obj", 1),
        ("bunny/stanford-bunny.obj", 1),
        ("delft-city/delft.obj", 570),
        ("delft-3dfier/testarea.obj", 570),
    ] {
        let Some(loaded) = read(name) else { return };
        assert_eq!(triangles(&loaded.scene), written_triangles(name), "{name}");
        assert_eq!(loaded.scene.objects.len(), objects, "{name}: {:?}", loaded.scene.findings);
        assert!(loaded.scene.lights.is_empty() && loaded.scene.camera.is_none());
        assert_eq!(count(&loaded.scene, FindingKind::MissingMaterials), 0, "{name}");
        let z_up = usize::from(name.starts_with("delft-3dfier"));
        assert_eq!(count(&loaded.scene, FindingKind::LooksZUp), z_up, "{name}");
    }
}

#[test]
fn groups_over_several_objects_are_families() {
    let Some(loaded) = read("delft-city/delft.obj") else { return };
    let families = &loaded.scene.families;
    assert!(families.families.iter().any(|family| family.name == "Building" && family.members.len() > 100));
    let members: usize = families.families.iter().map(|family| family.members.len()).sum();
    assert_eq!(members, 570);
}

#[test]
fn up_z_turns_the_city_without_rounding() {
    let Some(path) = data("delft-3dfier/testarea.obj") else { return };
    let plain = load(&path, &LoadOptions::default()).expect("loads");
    let options = LoadOptions { up: Some(UpAxis::Z), ..LoadOptions::default() };
    let turned = load(&path, &options).expect("loads");
    assert_eq!(count(&turned.scene, FindingKind::LooksZUp), 0, "the user has said it");
    for (a, b) in plain.scene.objects.iter().zip(&turned.scene.objects) {
        let (a, b) = (a.bounds(), b.bounds());
        assert_eq!((b.min.x, b.min.y, b.max.z), (a.min.x, a.min.z, 0.0 - a.min.y));
    }
}

#[test]
fn a_closed_cow_and_an_open_bunny() {
    let Some(spot) = read("spot/spot.obj") else { return };
    assert_eq!(surface_findings(&spot.scene), []);
    let Some(bunny) = read("bunny/stanford-bunny.obj") else { return };
    let found = surface_findings(&bunny.scene);
    assert!(found.iter().any(|finding| finding.kind == FindingKind::OpenEdges && finding.count > 0), "{found:?}");
}

#[test]
fn gltf_scenes_keep_their_triangles_and_objects() {
    for (name, objects, expected) in [
        ("flighthelmet/FlightHelmet.gltf", 6, None),
        ("cannon/cannon_01.gltf", 10, None),
        ("fern/fern_02.gltf", 4, None),
        ("house-mask/house.glb", 2, Some(10497)),
        ("shadow-tester/Shadow_Tester.glb", 1, Some(2222)),
        ("three-lights/lights.gltf", 1, Some(5172 / 3)),
    ] {
        let Some(loaded) = read(name) else { return };
        assert_eq!(loaded.scene.objects.len(), objects, "{name}");
        assert_eq!(triangles(&loaded.scene), expected.unwrap_or_else(|| declared_triangles(name)), "{name}");
    }
}

/// The triangles of a glTF text whose meshes are used once each, counted from its index accessors.
fn declared_triangles(name: &str) -> usize {
    let text = std::fs::read(data(name).expect("checked before")).expect("readable");
    let document: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
    let primitives = document["meshes"].as_array().expect("meshes").iter().flat_map(|mesh| {
        mesh["primitives"].as_array().expect("primitives").iter().map(|primitive| primitive["indices"].as_u64())
    });
    primitives
        .map(|indices| {
            let accessor = &document["accessors"][indices.expect("indexed") as usize];
            accessor["count"].as_u64().expect("a count") as usize / 3
        })
        .sum()
}

#[test]
fn instances_share_one_geometry() {
    let Some(LoadedScene { scene, .. }) = read("teapots-instanced/teapots_galore.gltf") else { return };
    assert_eq!(scene.objects.len(), 1899 + 1);
    let teapots: Vec<_> = scene.objects.iter().filter(|object| object.name.starts_with("teapot")).collect();
    assert_eq!(teapots.len(), 1899);
    let mesh_of = |shape: &Shape| match shape {
        Shape::Mesh(mesh) => Arc::clone(mesh),
        other => panic!("not a mesh: {other:?}"),
    };
    let first = mesh_of(&teapots[0].shape);
    assert_eq!(first.triangles().len(), 12096 / 3);
    assert!(teapots.iter().all(|teapot| Arc::ptr_eq(&first, &mesh_of(&teapot.shape))));
    assert_eq!((teapots[0].name.as_str(), teapots[958].name.as_str()), ("teapot#0", "teapot0#0"));
    let camera = scene.camera.expect("a camera");
    assert!(
        matches!(camera.projection, Projection::Perspective { vertical_degrees } if (vertical_degrees - 46.83).abs() < 0.01)
    );
    assert_eq!(camera.eye, glam::DVec3::new(0.0, 20.000001907348633, 0.0));
    let families = &scene.families;
    assert_eq!(families.roots, [Member::Family(0)]);
    let counts = families.families.iter().filter(|family| family.name.starts_with("teapot")).map(|f| f.members.len());
    assert_eq!(counts.collect::<Vec<_>>(), [3, 958, 941]);
}

#[test]
fn lights_and_alpha_modes_are_told() {
    let Some(LoadedScene { scene, .. }) = read("three-lights/lights.gltf") else { return };
    let lights: Vec<_> = scene.lights.iter().map(|light| (light.name.as_str(), light.source.is_sun())).collect();
    assert_eq!(lights, [("point_light", false), ("directional_light", true)]);
    assert_eq!(scene.lights[0].source.xyz(), glam::DVec3::new(0.0, 22.0, 0.0));
    assert_eq!(scene.lights[1].source.xyz(), glam::DVec3::Z, "it travels along -z");
    let Some(house) = read("house-mask/house.glb") else { return };
    assert_eq!(count(&house.scene, FindingKind::MaskAsOpaque), 4462);
    let Some(fern) = read("fern/fern_02.gltf") else { return };
    assert_eq!(count(&fern.scene, FindingKind::MaskAsOpaque), triangles(&fern.scene));
}

#[test]
fn compressed_scenes_say_what_they_need() {
    for (name, expected) in [
        ("apartment-meshopt/dream-apartment.glb", "EXT_meshopt_compression"),
        ("bridge-garden-meshopt/bridge-garden.glb", "EXT_meshopt_compression"),
        ("ingenuity-meshopt/Ingenuity.glb", "EXT_meshopt_compression"),
        ("helicopter-draco/helicopter.gltf", "KHR_draco_mesh_compression"),
    ] {
        let Some(path) = data(name) else { return };
        let refused: LoadError = load(&path, &LoadOptions::default()).expect_err("compressed");
        assert!(matches!(&refused.problem, LoadProblem::Extension { name, .. } if name == expected), "{refused}");
        assert!(!refused.is_unreadable() && refused.to_string().contains(expected), "{refused}");
    }
}
