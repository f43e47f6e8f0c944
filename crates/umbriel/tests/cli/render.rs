//! `umbriel render`: a picture of the right size with a shadow in it.

use crate::workspace::{NOON, Workspace};

const CAMERA: &str =
    "\n[camera]\neye = [0.0, 10.0, 0.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, -1.0]\nheight = 8.0\n";

#[test]
fn a_picture_is_written() {
    let workspace = Workspace::noon();
    workspace.run("render noon.toml -o a.png --size 48x32 --boundary-depth 5").succeeds();
    workspace.run("render noon.toml -o b.png --size 48x32 --boundary-depth 5 --threads 1").succeeds();
    workspace.run("render noon.toml -o c.png --size 48x32 --boundary-depth 5 --undecided").succeeds();
    let (picture, again, undecided) = (workspace.read("a.png"), workspace.read("b.png"), workspace.read("c.png"));
    assert_eq!(&picture[1..4], b"PNG");
    assert_eq!(picture[16..24], [0, 0, 0, 48, 0, 0, 0, 32]);
    assert_eq!(picture, again, "threads do not change a picture");
    assert_ne!(picture, undecided, "undecided cells have a colour of their own");
}

#[test]
fn the_acceleration_changes_no_pixel_and_is_told() {
    let cubes = "\n[[object]]\nname = \"rock\"\nconvex = { points = [[0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0], [0.0, 1.0, 1.0], [1.0, 2.0, 1.0]] }\n";
    let workspace = Workspace::with(&[("rock.toml", &format!("{NOON}{cubes}"))]);
    for (way, told) in [("bvh", "rays by BVH"), ("octree", "rays by octree"), ("projection", "rays by projection")] {
        let arguments = format!("render rock.toml -o {way}.png --size 48x32 --boundary-depth 4 --acceleration {way}");
        let run = workspace.run(&arguments).succeeds();
        assert!(run.stderr().contains(told), "{}", run.stderr());
        assert_eq!(workspace.read("bvh.png"), workspace.read(&format!("{way}.png")));
    }
}

#[test]
fn exact_queries_make_the_picture_independent_of_the_detail() {
    let workspace = Workspace::noon();
    for depth in [2, 7] {
        let arguments = format!("render noon.toml -o {depth}.png --size 48x32 --boundary-depth {depth}");
        workspace.run(&arguments).succeeds();
    }
    assert_eq!(workspace.read("2.png"), workspace.read("7.png"));
}

#[test]
fn the_camera_of_the_scene_is_used() {
    let scene = format!("{NOON}{CAMERA}");
    let workspace = Workspace::with(&[("own.toml", &scene), ("noon.toml", NOON)]);
    for name in ["own", "noon"] {
        workspace.run(&format!("render {name}.toml -o {name}.png --size 24x24 --boundary-depth 3")).succeeds();
    }
    assert_ne!(workspace.read("own.png"), workspace.read("noon.png"));
}

#[test]
fn all_methods_of_hidden_surfaces_draw_the_same_picture() {
    let workspace = Workspace::noon();
    let drawn = "render noon.toml --size 48x32 --aa 3 --boundary-depth 4 --camera -3,4,9,0,0,0,50";
    for method in ["depth", "scanline", "warnock", "raycast", "octree", "sort"] {
        let run = workspace.run(&format!("{drawn} --method {method} -o {method}.png")).succeeds();
        assert!(run.stdout().contains("144 x 96 samples"), "{}", run.stdout());
        assert_eq!(workspace.read("depth.png"), workspace.read(&format!("{method}.png")), "{method}");
    }
    let all = workspace.run(&format!("{drawn} --method all -o all.png")).succeeds();
    assert_eq!(all.stdout().lines().filter(|line| line.ends_with(" 0")).count(), 6, "{}", all.stdout());
    assert_eq!(workspace.read("all.png")[16..24], [0, 0, 0, 144, 0, 0, 0, 64], "three columns, two rows");
}

#[test]
fn edges_are_drawn_as_svg() {
    let workspace = Workspace::noon();
    workspace.run("render noon.toml --lines -o seen.svg --size 90x60").succeeds();
    workspace.run("render noon.toml --lines --dashed -o dashed.svg --size 90x60").succeeds();
    let text = |name: &str| String::from_utf8(workspace.read(name)).expect("text");
    let (seen, dashed) = (text("seen.svg"), text("dashed.svg"));
    assert!(seen.contains("id=\"visible\"") && !seen.contains("id=\"hidden\""), "{seen}");
    assert!(dashed.starts_with("<svg ") && dashed.contains("viewBox=\"0 0 90 60\""), "{dashed}");
    workspace.run("render noon.toml --method lines --dashed -o same.svg --size 90x60").succeeds();
    assert_eq!(text("same.svg"), dashed);
    workspace.run("render noon.toml --dashed -o seen.png").fails(2, &["--lines"]);
    workspace.run("render noon.toml --lines -o seen.png").fails(2, &[".svg"]);
}
