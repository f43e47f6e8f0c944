//! Real scenes from public collections, where they are at hand: everything loads, nothing is lost.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use serde_json::Value;
use umbriel_geometry::cut_out::Opacity;
use umbriel_io::{LoadOptions, LoadedScene, UpAxis, load, surface_findings};
use umbriel_scene::{FindingKind, Member, Object, Projection, Scene, Shape};

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

/// How many triangles of an object have holes, or are nothing but one.
fn holes(object: &Object) -> usize {
    let Shape::Mesh(mesh) = &object.shape else { return 0 };
    (0..mesh.triangles().len()).filter(|&triangle| mesh.opacity(triangle) != Opacity::Opaque).count()
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

/// Every glTF of the collection, and how many objects it has.
const GLTF_SCENES: [(&str, usize); 11] = [
    ("flighthelmet/FlightHelmet.gltf", 6),
    ("cannon/cannon_01.gltf", 10),
    ("fern/fern_02.gltf", 4),
    ("house-mask/house.glb", 2),
    ("shadow-tester/Shadow_Tester.glb", 1),
    ("three-lights/lights.gltf", 1),
    ("teapots-instanced/teapots_galore.gltf", 1900),
    ("apartment-meshopt/dream-apartment.glb", 1),
    ("bridge-garden-meshopt/bridge-garden.glb", 1),
    ("ingenuity-meshopt/Ingenuity.glb", 1),
    ("helicopter-draco/helicopter.gltf", 14),
];

#[test]
fn gltf_scenes_keep_their_triangles_and_objects() {
    for (name, objects) in GLTF_SCENES {
        let Some(loaded) = read(name) else { return };
        assert_eq!(loaded.scene.objects.len(), objects, "{name}");
        assert_eq!(triangles(&loaded.scene) as u64, declared_triangles(&document(name)), "{name}");
        // The red of Ingenuity's gold is 1.00000012 and may be 1 at most.
        let broken = usize::from(name.ends_with("Ingenuity.glb"));
        assert_eq!(count(&loaded.scene, FindingKind::BrokenRule), broken, "{name}: {:?}", loaded.scene.findings);
    }
}

/// The JSON of a `.gltf`, or of a `.glb`, whose first chunk it is.
fn document(name: &str) -> Value {
    let bytes = std::fs::read(data(name).expect("checked before")).expect("readable");
    let json = match bytes.strip_prefix(b"glTF") {
        Some(rest) => &rest[16..16 + u32::from_le_bytes([rest[8], rest[9], rest[10], rest[11]]) as usize],
        None => &bytes,
    };
    serde_json::from_slice(json).expect("JSON")
}

fn element<'a>(document: &'a Value, kind: &str, index: &Value) -> &'a Value {
    &document[kind][index.as_u64().expect("an index") as usize]
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// The triangles of a scene as its accessors count them, instances included.
fn declared_triangles(document: &Value) -> u64 {
    let count = |accessor: &Value| element(document, "accessors", accessor)["count"].as_u64().expect("a count");
    let of_primitive = |primitive: &Value| {
        assert!(primitive["mode"].is_null() || primitive["mode"] == 4, "a list of triangles");
        count(primitive.get("indices").unwrap_or(&primitive["attributes"]["POSITION"])) / 3
    };
    let mut open = list(&element(document, "scenes", &document["scene"])["nodes"]).to_vec();
    let mut sum = 0;
    while let Some(index) = open.pop() {
        let node = element(document, "nodes", &index);
        open.extend_from_slice(list(&node["children"]));
        let Some(mesh) = node.get("mesh") else { continue };
        let primitives = list(&element(document, "meshes", mesh)["primitives"]);
        let attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"].as_object();
        let instances = attributes.and_then(|attributes| attributes.values().next()).map_or(1, count);
        sum += instances * primitives.iter().map(of_primitive).sum::<u64>();
    }
    sum
}

/// What is decompressed lies where the accessors say, to the last bit. (Those of the Draco scene tell the borders of
/// what was compressed, which its quantisation moves a little.)
#[test]
fn compressed_positions_lie_in_their_declared_borders() {
    for (name, exact) in [
        ("apartment-meshopt/dream-apartment.glb", true),
        ("bridge-garden-meshopt/bridge-garden.glb", true),
        ("ingenuity-meshopt/Ingenuity.glb", true),
        ("helicopter-draco/helicopter.gltf", false),
    ] {
        let Some(LoadedScene { scene, .. }) = read(name) else { return };
        let document = document(name);
        let mut declared: Vec<[f64; 6]> = list(&document["meshes"])
            .iter()
            .map(|mesh| {
                let of = |key: &str, axis: usize, pick: fn(f64, f64) -> f64, none: f64| {
                    let of_primitive = |primitive: &Value| {
                        let accessor = element(&document, "accessors", &primitive["attributes"]["POSITION"]);
                        accessor[key][axis].as_f64().expect("a number")
                    };
                    list(&mesh["primitives"]).iter().map(of_primitive).fold(none, pick)
                };
                std::array::from_fn(|i| match i {
                    0..3 => of("min", i, f64::min, f64::INFINITY),
                    _ => of("max", i - 3, f64::max, f64::NEG_INFINITY),
                })
            })
            .collect();
        let mut found: Vec<[f64; 6]> = scene
            .objects
            .iter()
            .filter_map(|object| match &object.shape {
                Shape::Mesh(mesh) => Some(mesh.bounds()),
                _ => None,
            })
            .map(|bounds| [bounds.min.to_array(), bounds.max.to_array()].concat().try_into().expect("six"))
            .collect();
        declared.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        found.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        assert_eq!(found.len(), declared.len(), "{name}: every mesh is used once");
        for (found, declared) in found.iter().zip(&declared) {
            let largest = (0..3).map(|axis| declared[axis + 3] - declared[axis]).fold(0.0, f64::max);
            let slack = if exact { 0.0 } else { largest / 1024.0 };
            // Both are 32-bit floats, one of them written with nine digits.
            let near = |(&a, &b): (&f64, &f64)| f64::from((a as f32 - b as f32).abs()) <= slack;
            assert!(found.iter().zip(declared).all(near), "{name}: {found:?} {declared:?}");
        }
    }
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
    assert_eq!(count(&house.scene, FindingKind::MissingTexture), 0, "its texture is read");
    let with_holes = |scene: &Scene| scene.objects.iter().map(holes).sum::<usize>();
    assert!((1..=4462).contains(&with_holes(&house.scene)), "among the triangles of its MASK material");
    let Some(fern) = read("fern/fern_02.gltf") else { return };
    assert_eq!(count(&fern.scene, FindingKind::MissingTexture), triangles(&fern.scene), "a missing texture is opaque");
    assert_eq!(with_holes(&fern.scene), 0);
}
