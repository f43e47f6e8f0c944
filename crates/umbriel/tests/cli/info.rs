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

/// The same pyramid in the formats that know nothing but triangles.
fn pyramid(format: &str) -> String {
    let corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let row = |[x, y, z]: [i32; 3]| format!("{x} {y} {z}\n");
    match format {
        "ply" => {
            let corners: String = corners.map(row).concat();
            let faces: String = faces.map(|face| format!("3 {}", row(face))).concat();
            format!(
                "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                 element face 4\nproperty list uchar int vertex_index\nend_header\n{corners}{faces}"
            )
        }
        _ => {
            let corner = |corner: i32| format!("vertex {}", row(corners[corner as usize]));
            let facet = |face: [i32; 3]| {
                format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", face.map(corner).concat())
            };
            format!("solid\n{}endsolid\n", faces.map(facet).concat())
        }
    }
}

#[test]
fn formats_of_triangles_alone() {
    let scene = |format: &str| format!("[[object]]\nname = \"tent\"\nmesh = \"pyramid.{format}\"\n");
    for format in ["stl", "ply"] {
        let (file, content) = (format!("pyramid.{format}"), pyramid(format));
        let workspace = Workspace::with(&[(&*file, &*content), ("scene.toml", &scene(format))]);
        for (name, object) in [(&*file, "pyramid"), ("scene.toml", "tent")] {
            let text = workspace.run(&format!("info {name}")).succeeds().stdout();
            assert!(text.contains(&format!("{object}: 4 triangles, closed")), "{text}");
            assert!(text.contains("findings    none"), "{text}");
        }
    }
}

#[test]
fn findings_have_places_in_text_and_json() {
    let turned = TETRAHEDRON.replace("f 1 2 4", "f 2 1 4").replace("f 3 1 4", "f 3 1 4\nvn nan 0 1\nf 1 1 2");
    let workspace = Workspace::with(&[("turned.obj", &turned)]);
    let text = workspace.run("info turned.obj").succeeds().stdout();
    for words in ["wound differently (pyramid at face 1)", "without area (pyramid at face 4)", "at line 10)"] {
        assert!(text.contains(words), "\"{words}\" is missing in: {text}");
    }
    let json = workspace.run("bake turned.obj --sun 200,45 --json - --quiet").succeeds().stdout();
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let findings = json["findings"].as_array().expect("a list");
    let winding = findings.iter().find(|found| found["kind"] == "inconsistent_winding").expect("the finding");
    assert_eq!((&winding["count"], &winding["places"][0]), (&2.into(), &"face 1".into()));
}
