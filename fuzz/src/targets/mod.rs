//! What is fuzzed: functions of bytes that panic where something is wrong.

mod codes;
mod containers;
mod files;
mod shadows;

/// What takes the bytes.
pub(crate) type Target = fn(&[u8]);

/// Every target with its name, which is also the folder of its corpus.
pub(crate) const TARGETS: [(&str, Target); 14] = [
    ("obj", files::obj),
    ("stl", files::stl),
    ("ply", files::ply),
    ("gltf", files::gltf),
    ("glb", containers::glb),
    ("meshopt", containers::meshopt),
    ("draco", containers::draco),
    ("picture", containers::picture),
    ("scene_file", files::scene_file),
    ("npy", files::npy),
    ("points", files::points),
    ("suns", files::suns),
    ("shadows", shadows::shadows),
    ("codes", codes::codes),
];
