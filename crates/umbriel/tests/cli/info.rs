//! `umbriel info`: what a scene holds.

use crate::workspace::Workspace;

const TETRAHEDRON: &str = "o pyramid\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

#[test]
fn bodies_lights_and_extents() {
    let text = Workspace::noon().run("info noon.toml").succeeds().stdout();
    for words in ["objects     2", "analytic  2", "noon: sun", "8.0000 x 3.0000 x 8.0000 m", "findings    none"] {
        assert!(text.contains(words), "\"{words}\" is missing in: {text}");
    }
}

#[test]
fn closed_and_open_surfaces() {
    let open = TETRAHEDRON.replace("f 3 1 4\n", "");
    let workspace = Workspace::with(&[("closed.obj", TETRAHEDRON), ("open.obj", &open)]);
    let closed = workspace.run("info closed.obj").succeeds().stdout();
    assert!(closed.contains("pyramid: 4 triangles, closed") && closed.contains("findings    none"), "{closed}");
    let open = workspace.run("info open.obj").succeeds().stdout();
    assert!(open.contains("pyramid: 3 triangles, open") && open.contains("3 open edges"), "{open}");
}

#[test]
fn instances_share_one_geometry() {
    let scene = "[[object]]\nname = \"a\"\nmesh = \"p.obj\"\n[[object]]\nname = \"b\"\nmesh = \"p.obj\"\ntranslation = [5.0, 0.0, 0.0]\n";
    let workspace = Workspace::with(&[("p.obj", TETRAHEDRON), ("two.toml", scene)]);
    let text = workspace.run("info two.toml").succeeds().stdout();
    assert!(text.contains("triangles   8 placed, 4 in memory"), "{text}");
    assert!(text.contains("2 of 1 geometries"), "{text}");
}

#[test]
fn a_model_that_looks_z_up_is_told() {
    let flat = "v 0 0 0\nv 90 0 0\nv 90 80 2\nv 0 80 2\nf 1 2 3 4\n";
    let workspace = Workspace::with(&[("map.obj", flat)]);
    assert!(workspace.run("info map.obj").succeeds().stdout().contains("--up z"));
    let turned = workspace.run("info map.obj --up z").succeeds().stdout();
    assert!(!turned.contains("--up z") && turned.contains("90.000 x 2.0000 x 80.000"), "{turned}");
}
