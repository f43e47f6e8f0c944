//! Scenes in (glTF, OBJ, scene files), tables, meshes and pictures out
