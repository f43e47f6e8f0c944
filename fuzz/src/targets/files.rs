//! Files: whatever the bytes, they are read or refused; what is read is sound.

use std::{collections::HashSet, path::Path};

use umbriel_io::{LoadOptions, load_bytes, npy, read_suns, surface_findings, write::read_points};
use umbriel_scene::{FindingKind, Member, Object, Scene};

pub(super) fn obj(bytes: &[u8]) {
    scene("scene.obj", bytes);
}

pub(super) fn stl(bytes: &[u8]) {
    scene("scene.stl", bytes);
}

pub(super) fn ply(bytes: &[u8]) {
    scene("scene.ply", bytes);
}

pub(super) fn gltf(bytes: &[u8]) {
    scene("scene.gltf", bytes);
}

pub(super) fn scene_file(bytes: &[u8]) {
    scene("scene.toml", bytes);
}

pub(super) fn npy(bytes: &[u8]) {
    match npy::read_npy_points(bytes) {
        Ok(points) => assert!(points.len() * 12 <= bytes.len(), "more points than bytes"),
        Err(error) => is_short(&error.to_string()),
    }
}

pub(super) fn points(bytes: &[u8]) {
    match read_points(bytes) {
        Ok(table) => assert_eq!(table.points.len(), table.lines.len()),
        Err(error) => is_short(&error.to_string()),
    }
}

pub(super) fn suns(bytes: &[u8]) {
    match read_suns(bytes, None) {
        Ok(rows) => assert!(rows.iter().all(|row| row.line > 1)),
        Err(error) => is_short(&error.to_string()),
    }
}

/// Reads the bytes as a file of that name, in a folder that is not there.
pub(super) fn scene(name: &str, bytes: &[u8]) {
    let options = LoadOptions { lightmap_set: Some(1), ..LoadOptions::default() };
    match load_bytes(&Path::new("no such folder").join(name), bytes, &options) {
        Ok(loaded) => is_sound(&loaded.scene),
        Err(error) => is_short(&error.to_string()),
    }
}

/// Messages are for people: a hostile file does not fill the screen.
fn is_short(message: &str) {
    assert!(!message.is_empty() && message.len() < 2000, "a message of {} bytes", message.len());
}

fn is_sound(scene: &Scene) {
    let mut names = HashSet::new();
    assert!(scene.objects.iter().all(|object| names.insert(object.name.as_str())), "names that are not unique");
    let is_empty = scene.objects.iter().all(|object| object.face_count() == 0);
    let is_told = scene.findings.iter().any(|finding| finding.kind == FindingKind::EmptyScene);
    assert_eq!(is_empty, is_told, "an empty scene is told");
    let found = surface_findings(scene);
    let has_surface = |object: &&Object| {
        object.face_count() > 0
            && !found.iter().any(|finding| finding.kind == FindingKind::NoSurface && finding.subject == object.name)
    };
    for object in scene.objects.iter().filter(has_surface) {
        let bounds = object.bounds();
        assert!(bounds.min.is_finite() && bounds.max.is_finite(), "{}: {bounds:?}", object.name);
    }
    for finding in scene.findings.iter().chain(&found) {
        assert!(finding.count > 0 && finding.places.len() <= finding.count, "{finding:?}");
    }
    let members = scene.families.families.iter().flat_map(|family| &family.members).chain(&scene.families.roots);
    let mut is_placed = vec![false; scene.objects.len()];
    for member in members {
        if let Member::Object(object) = *member {
            assert!(!std::mem::replace(&mut is_placed[object], true), "an object in two families");
        }
    }
    assert!(is_placed.into_iter().all(|is_placed| is_placed), "an object in no family");
}
