//! Bad input: one clear message, the right exit code, no panic, nothing written.

use crate::workspace::{DARK, NOON, Workspace};

/// The command on a scene of that content must end with `code` and say `words`, and leave only the scene behind.
fn refused(name: &str, content: &str, code: i32, words: &[&str]) {
    let workspace = Workspace::with(&[(name, content)]);
    let run = workspace.run(&format!("bake {name} --sun 180,45 --json out.json -o out.csv -o out.glb"));
    run.fails(code, words);
    assert_eq!(workspace.files(), [name]);
}

#[test]
fn missing_files() {
    let workspace = Workspace::with(&[]);
    for command in ["info", "bake", "query --points p.csv", "render -o out.png"] {
        let (name, rest) = command.split_once(' ').unwrap_or((command, ""));
        let missing = if name == "query" { "p.csv" } else { "gone.obj" };
        workspace.run(&format!("{name} gone.obj {rest}")).fails(2, &[missing, "cannot be read"]);
    }
    refused("scene.toml", "[[object]]\nname = \"house\"\nmesh = \"gone.obj\"\n", 2, &["gone.obj", "cannot be read"]);
    assert_eq!(workspace.files(), [""; 0]);
}

#[test]
fn content_that_is_refused() {
    refused("a.obj", "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", 1, &["a.obj", "line 3"]);
    refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", 1, &["a.obj", "line 4"]);
    refused("a.toml", "[[object]]\nname = \"o\"\nsphere = { radius = 1.0 }\ncolour = 3\n", 1, &["a.toml", "colour"]);
    refused("a.toml", "[[object]]\nname = \"o\"\nmesh = \"../b.obj\"\n", 1, &["a.toml", "../b.obj", "--allow-outside"]);
    refused("a.toml", "[[object]]\nname = \"o\"\nsphere = { radius = inf }\n", 1, &["a.toml", "o"]);
    let cycle = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "children": [1] }, { "children": [0] }] }"#;
    refused("a.gltf", cycle, 1, &["a.gltf", "node"]);
    refused("a.gltf", "{", 1, &["a.gltf"]);
    refused("a.glb", "glTF", 1, &["a.glb"]);
}

/// Files without a surface are valid: cameras alone, clouds of points, nothing yet.
#[test]
fn a_scene_without_surface_is_told() {
    let files = [
        ("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"),
        ("a.gltf", r#"{ "asset": { "version": "2.0" } }"#),
        ("a.stl", "solid a\nendsolid a\n"),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n",
        ),
    ];
    let workspace = Workspace::with(&[&files[..], &[("p.csv", "x,y,z\n0,1,0\n")]].concat());
    for (name, _) in files {
        for command in [
            "info SCENE",
            "doctor SCENE",
            "bake SCENE --sun 180,45 --samples 100 --json out.json -o out.csv -o out.glb -o out.vtu",
            "bake SCENE --sun 180,45 --cell 0.1 --json out.json",
            "query SCENE --sun 180,45 --points p.csv",
            "render SCENE --sun 180,45 -o out.png",
        ] {
            workspace.run(&command.replace("SCENE", name)).succeeds();
        }
        assert!(workspace.run(&format!("info {name}")).stdout().contains("no triangle and no body"));
    }
}

#[test]
fn a_scene_without_light_says_how_to_give_one() {
    let workspace = Workspace::with(&[("dark.toml", DARK), ("p.csv", "x,y,z\n0,1,0\n")]);
    for command in ["bake dark.toml -o out.csv", "render dark.toml -o out.png", "query dark.toml --points p.csv"] {
        workspace.run(command).fails(1, &["dark.toml", "no light", "--sun", "--point"]);
    }
    assert_eq!(workspace.files(), ["dark.toml", "p.csv"]);
    workspace.run("info dark.toml").succeeds();
}

#[test]
fn wrong_usage() {
    let workspace = Workspace::with(&[("noon.toml", NOON), ("p.csv", "x,y,z\n0,1,0\n")]);
    for (arguments, words) in [
        ("", vec!["Usage"]),
        ("bake", vec!["SCENE"]),
        ("bake noon.toml --sun 1", vec!["--sun", "2 are needed"]),
        ("bake noon.toml --sun 0,91", vec!["--sun", "between -90 and 90"]),
        ("bake noon.toml -o out.csv -o ./out.csv", vec!["out.csv", "twice"]),
        ("bake noon.toml -o out.json --json out.json", vec!["out.json", "twice"]),
        ("bake noon.toml --sun up,1", vec!["--sun", "not a finite number"]),
        ("bake noon.toml --point 1e300,0,0", vec!["--point", "2^200"]),
        ("bake noon.toml --light moon", vec!["--light moon", "noon"]),
        ("bake noon.toml --receiver roof*", vec!["--receiver roof*", "info"]),
        ("bake noon.toml --boundary-depth 2 --interior-depth 3", vec!["interior depth 3", "boundary depth 2"]),
        ("bake noon.toml -o out.txt", vec!["out.txt", ".json or .csv or .vtu or .glb or .png"]),
        ("bake noon.toml -o no/out.csv", vec!["no/out.csv", "folder does not exist"]),
        ("bake noon.toml --json no/out.json", vec!["no/out.json"]),
        ("bake noon.toml --point 0,9,0 -o out.glb", vec![".glb", "--light"]),
        ("query noon.toml --points p.csv -o p.csv", vec!["p.csv", "is read"]),
        ("render noon.toml -o out.jpg", vec!["out.jpg", ".png"]),
        ("render noon.toml", vec!["--output"]),
        ("render noon.toml -o out.png --size 0x3", vec!["--size"]),
    ] {
        workspace.run(arguments).fails(2, &words);
    }
    assert_eq!(workspace.files(), ["noon.toml", "p.csv"]);
}

#[test]
fn help_is_a_success() {
    let workspace = Workspace::with(&[]);
    for arguments in ["--help", "bake --help", "--version"] {
        assert!(workspace.run(arguments).succeeds().stdout().contains("umbriel"));
    }
}

#[cfg(unix)]
#[test]
fn what_a_scene_reads_is_not_written_over() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n";
    let scene = "[[object]]\nname = \"roof\"\nmesh = \"roof.obj\"\n";
    let workspace = Workspace::with(&[("roof.obj", triangle), ("scene.toml", scene)]);
    std::os::unix::fs::symlink("roof.obj", workspace.path("roof.csv")).expect("a link");
    workspace.run("bake scene.toml --sun 9,9 -o roof.csv").fails(2, &["roof.csv", "is read"]);
    assert_eq!(workspace.text("roof.obj"), triangle);
}

#[test]
fn messages_name_the_file_at_fault_as_the_user_knows_it() {
    let scene = "[[object]]\nname = \"roof\"\nmesh = \"parts/roof.obj\"\n";
    let workspace = Workspace::with(&[("scene.toml", scene)]);
    std::fs::create_dir(workspace.path("parts")).expect("a folder");
    workspace.run("info scene.toml").fails(2, &["scene.toml: parts/roof.obj cannot be read"]);
    std::fs::write(workspace.path("parts/roof.obj"), "v 0 0 nan\n").expect("written");
    workspace.run("info scene.toml").fails(1, &["umbriel: parts/roof.obj: line 1"]);
    std::fs::write(workspace.path("parts/roof.obj"), "v 0 0 0\n").expect("written");
    workspace.run("info scene.toml").fails(1, &["scene.toml", "\"roof\"", "parts/roof.obj", "no triangle"]);
    std::fs::write(workspace.path("parts/roof.obj"), format!("v {}\n", "x".repeat(9000))).expect("written");
    let run = workspace.run("info scene.toml");
    assert!(run.stderr().len() < 300, "{}", run.stderr());
    std::fs::write(workspace.path("parts/roof.obj"), "\n\n\0").expect("written");
    workspace.run("info scene.toml").fails(1, &["line 3", "no text"]);
}

#[cfg(unix)]
#[test]
fn what_may_never_end_is_not_read() {
    let workspace = Workspace::noon();
    workspace.run("query noon.toml --points /dev/zero").fails(2, &["/dev/zero", "not a regular file"]);
    std::os::unix::fs::symlink("/dev/zero", workspace.path("a.obj")).expect("a link");
    workspace.run("info a.obj").fails(2, &["a.obj", "not a regular file"]);
}

#[test]
fn a_small_scene_file_does_not_become_a_large_scene() {
    let mesh = format!("v 0 0 0\nv 1 0 0\nv 0 1 1\n{}", "f 1 2 3\n".repeat(20_000));
    let scene = "[[object]]\nmesh = \"roof.obj\"\n".repeat(4_000);
    let workspace = Workspace::with(&[("roof.obj", &mesh), ("many.toml", &scene)]);
    workspace.run("info many.toml").fails(1, &["many.toml", "80000000 placed triangles", "at most"]);
}
