use std::path::PathBuf;

use umbriel_geometry::Analytic;
use umbriel_scene::{Extent, FindingKind, Member, Shape};

use super::*;
use crate::{load, options::LoadedScene};

/// A folder with a scene file and some mesh files.
struct Files(tempfile::TempDir);

impl Files {
    fn new(scene: &str) -> Self {
        let files = Self(tempfile::tempdir().expect("a folder"));
        files.with("scene.toml", scene)
    }

    fn with(self, name: &str, content: &str) -> Self {
        std::fs::write(self.0.path().join(name), content).expect("a file");
        self
    }

    fn path(&self) -> PathBuf {
        self.0.path().join("scene.toml")
    }

    fn load(&self) -> Result<LoadedScene, LoadError> {
        load(&self.path(), &LoadOptions::default())
    }
}

fn loaded(scene: &str) -> LoadedScene {
    Files::new(scene).load().unwrap_or_else(|error| panic!("{error}"))
}

fn refused(scene: &str) -> LoadError {
    Files::new(scene).load().expect_err("refused")
}

const FLOOR: &str = "[[object]]\nname = \"floor\"\nrectangle = { size = [40, 40.0] }\n";
/// One of each body that is given by numbers alone.
const BODIES: &str = "[[object]]\nellipsoid = { radii = [1, 2, 3] }\n[[object]]\ncylinder = { radius = 1, height = 2 }\n\
    [[object]]\ncone = { radius = 1, height = 2 }\n\
    [[object]]\nfrustum = { bottom_radius = 1, top_radius = 2, height = 3 }\n\
    [[object]]\ncapsule = { radius = 1, height = 2 }\n[[object]]\nparaboloid = { radius = 1, height = 2 }\n\
    [[object]]\nhyperboloid = { waist_radius = 1, end_radius = 2, height = 3 }\n[[object]]\ndisk = { radius = 1 }\n\
    [[object]]\nconvex = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]] }\n\
    [[object]]\nquadric = { matrix = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16], \
    within = [[-1, -2, -3], [1, 2, 3]] }\n";
const TWO_PARTS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\no Roof\nf 1 2 3\no Wall\nf 3 2 1\n";

#[test]
fn a_quadric_outside_its_box_is_told() {
    // 2x² + y² − z² + z + 11 is positive all over the box.
    let scene = loaded(
        "[[object]]\nname = \"q\"\nquadric = { matrix = [2,0,0,0, 0,1,0,0, 0,0,-1,1, 0,0,0,11], within = [[-2,-2,-2],[0,2,2]] }\n",
    )
    .scene;
    let found = crate::surface_findings(&scene);
    assert_eq!(found.iter().map(|f| (f.kind, &*f.subject)).collect::<Vec<_>>(), [(FindingKind::NoSurface, "q")]);
}

#[test]
fn a_quadric_without_an_inside_is_told() {
    // y² twice over, (x + y)², a line, a point; and a slab, a pair of planes, two planes that cross, the whole box.
    let flat = ["0,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,0", "1,1,0,0, 1,1,0,0, 0,0,0,0, 0,0,0,0"];
    let thin = ["1,0,0,0, 0,0,0,0, 0,0,1,0, 0,0,0,0", "1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,0"];
    let slabs = ["0,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,-1e-30", "0,0,0,0, 0,1,0,-0.5, 0,0,0,0, 0,-0.5,0,0"];
    let others = ["0,1,0,0, 1,0,0,0, 0,0,0,0, 0,0,0,0", "0,0,0,0, 0,-1,0,0, 0,0,0,0, 0,0,0,0"];
    let quadric =
        |matrix: &str| format!("[[object]]\nquadric = {{ matrix = [{matrix}], within = [[-2,-2,-2],[1,2,2]] }}\n");
    let found = |matrices: [&str; 2]| -> Vec<FindingKind> {
        let scene = loaded(&matrices.map(quadric).concat()).scene;
        crate::surface_findings(&scene).iter().map(|found| found.kind).collect()
    };
    assert_eq!([flat, thin].map(found), [(); 2].map(|()| vec![FindingKind::NoInside; 2]));
    assert_eq!([slabs, others].map(found), [(); 2].map(|()| Vec::new()));
}

#[test]
fn every_body_is_read() {
    let shapes: Vec<Shape> = loaded(BODIES).scene.objects.into_iter().map(|object| object.shape.clone()).collect();
    let analytic = |number: usize| match &shapes[number] {
        Shape::Analytic(body) => **body,
        _ => panic!("object {number} is no analytic body"),
    };
    assert_eq!(analytic(0), Analytic::Ellipsoid { radii: [1.0, 2.0, 3.0] });
    assert_eq!(analytic(1), Analytic::Cylinder { radius: 1.0, height: 2.0 });
    assert_eq!(analytic(2), Analytic::Cone { radius: 1.0, height: 2.0 });
    assert_eq!(analytic(3), Analytic::Frustum { bottom_radius: 1.0, top_radius: 2.0, height: 3.0 });
    assert_eq!(analytic(4), Analytic::Capsule { radius: 1.0, height: 2.0 });
    assert_eq!(analytic(5), Analytic::Paraboloid { radius: 1.0, height: 2.0 });
    assert_eq!(analytic(6), Analytic::Hyperboloid { waist_radius: 1.0, end_radius: 2.0, height: 3.0 });
    assert_eq!(analytic(7), Analytic::Disk { radius: 1.0 });
    assert!(matches!(&shapes[8], Shape::Convex(hull) if hull.points().len() == 4));
    let rows = [[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 12.0], [13.0, 14.0, 15.0, 16.0]];
    assert_eq!(analytic(9), Analytic::Quadric { matrix: rows, within: [[-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]] });
}

#[test]
fn bodies_stand_where_the_file_says() {
    let scene = loaded(
        "[[object]]\nname = \"floor\"\nrectangle = { size = [40.0, 20.0] }\ntranslation = [1, 2, 3]\nsides = \"one\"\n\
         [[object]]\nbox = { size = [1, 2, 3] }\nscale = [1, 2, -1]\nrotation = [0, 3, 0, 3]\n\
         [[object]]\nname = \"ball\"\nsphere = { radius = 0.5 }\nscale = 2\n\
         [[object]]\nname = \"floor\"\nbox = { size = [1, 1, 1] }\n\
         matrix = [0, 0, -1, 0,  0, 1, 0, 0,  1, 0, 0, 0,  7, 8, 9, 1]\n",
    )
    .scene;
    let names: Vec<_> = scene.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["floor", "object2", "ball", "floor_2"]);
    assert!(matches!(scene.objects[0].shape, Shape::Rectangle(rectangle) if rectangle.size == [40.0, 20.0]));
    assert_eq!(scene.objects[0].placement.map().translation, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!((scene.objects[0].sides, scene.objects[1].sides), (Sides::One, Sides::Auto));
    // A quarter turn about y takes +x to −z and +z to +x; the scale comes first.
    let turned = scene.objects[1].placement.map();
    assert_eq!(turned.transform_point3(DVec3::ONE), DVec3::new(-1.0, 2.0, -1.0));
    assert!(scene.objects[1].placement.is_mirrored());
    assert_eq!(scene.objects[2].placement.map().transform_point3(DVec3::X), DVec3::new(2.0, 0.0, 0.0));
    assert_eq!(scene.objects[3].placement.map().transform_point3(DVec3::X), DVec3::new(7.0, 8.0, 8.0));
    assert_eq!(scene.families.roots.len(), 4);
}

#[test]
fn lights_of_all_kinds() {
    let scene = loaded(&format!(
        "{FLOOR}[[light]]\nname = \"sun\"\nsun = {{ direction = [0.3, -1.0, 0.2] }}\n\
         [[light]]\nsun = {{ azimuth = 90, elevation = 0, angular_diameter = 0.5 }}\n\
         [[light]]\nname = \"bulb\"\npoint = {{ position = [1, 2, 3], radius = 0.1 }}\n\
         [[light]]\nname = \"panel\"\nrectangle = {{ center = [0, 3, 0], u = [1, 0, 0], v = [0, 0, 1] }}\n\
         [[light]]\nname = \"lamp\"\npoint = {{ position = [4, 5, 6] }}\n"
    ))
    .scene;
    let towards: Vec<_> = scene.lights.iter().map(|light| light.source.xyz().to_array()).collect();
    let expected = [[-0.3, 1.0, -0.2], [1.0, 0.0, 0.0], [1.0, 2.0, 3.0], [0.0, 3.0, 0.0], [4.0, 5.0, 6.0]];
    assert_eq!(towards, expected);
    let found: Vec<_> = scene.findings.iter().map(|finding| (finding.kind, finding.subject.as_str())).collect();
    let area = FindingKind::AreaLightAsPoint;
    assert_eq!(found, [(area, "bulb"), (area, "light2"), (area, "panel")]);
    let extents: Vec<_> = scene.lights.iter().map(|light| light.extent).collect();
    let panel = Extent::Rectangle { u: DVec3::X, v: DVec3::Z };
    let disk = Extent::Disk { angular_diameter: 0.5 };
    assert_eq!(extents, [Extent::Point, disk, Extent::Sphere { radius: 0.1 }, panel, Extent::Point]);
}

#[test]
fn up_turns_everything_and_north_only_azimuths() {
    let text = format!(
        "up = \"z\"\nnorth = 90\n{FLOOR}translation = [1, 2, 3]\n\
         [[light]]\nsun = {{ direction = [0, 1, -1] }}\n[[light]]\nsun = {{ azimuth = 0, elevation = 0 }}\n\
         [[light]]\npoint = {{ position = [1, 2, 3] }}\n\
         [camera]\neye = [0, -10, 5]\ntarget = [0, 0, 0]\n"
    );
    let LoadedScene { scene, north_degrees, .. } = loaded(&text);
    assert_eq!(scene.objects[0].placement.map().translation, DVec3::new(1.0, 3.0, -2.0));
    // Light towards +y (north) and down goes to −z and down; an azimuth of 0 is now the east.
    assert_eq!(scene.lights[0].source.xyz(), DVec3::new(0.0, 1.0, 1.0));
    assert_eq!(scene.lights[1].source.xyz(), DVec3::X);
    assert_eq!(scene.lights[2].source.xyz(), DVec3::new(1.0, 3.0, -2.0));
    let camera = scene.camera.expect("a camera");
    assert_eq!((camera.eye, camera.up), (DVec3::new(0.0, 5.0, 10.0), DVec3::Y));
    assert_eq!(camera.projection, Projection::Perspective { vertical_degrees: 45.0 });
    assert_eq!(north_degrees, 90.0);

    // What the caller says comes first.
    let files = Files::new(&text);
    let options = LoadOptions { up: Some(UpAxis::Y), north_degrees: Some(0.0), ..LoadOptions::default() };
    let plain = load(&files.path(), &options).expect("loads");
    assert_eq!(plain.scene.objects[0].placement.map().translation, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(plain.scene.lights[1].source.xyz(), DVec3::NEG_Z);
    assert_eq!(plain.sun_from_angles(90.0, 0.0), [-1.0, 0.0, 0.0]);
}

#[test]
fn a_mesh_file_is_an_object_or_a_family() {
    let files = Files::new(
        "sides = \"two\"\n[[object]]\nname = \"house\"\nmesh = \"parts.obj\"\nscale = 2\n\
         [[object]]\nname = \"roof\"\nmesh = \"parts.obj\"\nnode = \"Roof\"\ntranslation = [0, 5, 0]\nsides = \"auto\"\n\
         [[object]]\nname = \"tile\"\nmesh = \"one.obj\"\n",
    )
    .with("parts.obj", TWO_PARTS)
    .with("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\nl 1 2\n");
    let scene = files.load().unwrap_or_else(|error| panic!("{error}")).scene;
    let names: Vec<_> = scene.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["house/Roof", "house/Wall", "roof", "tile"]);
    assert_eq!(scene.families.roots, [Member::Family(0), Member::Object(2), Member::Object(3)]);
    assert_eq!(scene.families.families[0].name, "house");
    assert_eq!(scene.families.families[0].members, [Member::Object(0), Member::Object(1)]);
    assert_eq!((scene.objects[0].sides, scene.objects[2].sides), (Sides::Two, Sides::Auto));
    assert_eq!(scene.objects[2].placement.map().translation, DVec3::new(0.0, 5.0, 0.0));
    let (Shape::Mesh(a), Shape::Mesh(b)) = (&scene.objects[0].shape, &scene.objects[2].shape) else {
        panic!("meshes expected");
    };
    assert!(std::sync::Arc::ptr_eq(a, b), "read once, shared");
    let kinds: Vec<_> = scene.findings.iter().map(|finding| (finding.kind, finding.subject.as_str())).collect();
    assert!(kinds.contains(&(FindingKind::NotTriangles, "tile")), "{kinds:?}");
}

#[test]
fn what_is_found_in_a_mesh_file_is_told_once() {
    let entry = |name: &str, node: &str| format!("[[object]]\nname = \"{name}\"\nmesh = \"a.obj\"\n{node}");
    let found = |scene: &str, mesh: &str| {
        let files = Files::new(scene).with("a.obj", mesh);
        let findings = files.load().unwrap_or_else(|error| panic!("{error}")).scene.findings;
        findings.into_iter().map(|found| (found.kind, found.subject, found.count)).collect::<Vec<_>>()
    };
    let points = |subject: &str| (FindingKind::NotTriangles, subject.to_owned(), 2);
    let wall = entry("wall", "node = \"Wall\"\n");
    let (one, two) = (entry("one", ""), entry("two", ""));
    let mesh = format!("{TWO_PARTS}v 0 0 9\np 1\np 2\n");
    assert_eq!(found(&format!("up = \"y\"\n{wall}{one}{two}"), &mesh), [points("one")]);
    assert_eq!(found(&wall, &mesh), []);
    // Squares of these counts take minutes.
    let bad: String = (0..20_000).map(|number| format!("word{number}\n")).collect();
    let entries = "[[object]]\nmesh = \"a.obj\"\n".repeat(10_000);
    let found = found(&entries, &format!("v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n{bad}"));
    assert_eq!(found.len(), 20_000);
    assert!(found.iter().all(|found| found.1.starts_with("object1/word") && found.2 == 1));
}

#[test]
fn parts_are_found_by_their_names() {
    // Squares of these counts take minutes.
    const COUNT: usize = 40_000;
    let mesh: String = (0..COUNT).map(|number| format!("g group{}\no part{number}\nf 1 2 3\n", number / 2)).collect();
    let scene: String = (0..COUNT)
        .map(|number| {
            let node = if number % 2 == 0 { format!("part{number}") } else { format!("group{}", number / 2) };
            format!("[[object]]\nmesh = \"a.obj\"\nnode = \"{node}\"\n")
        })
        .collect();
    let files = Files::new(&scene).with("a.obj", &format!("v 0 0 0\nv 1 0 0\nv 0 1 1\n{mesh}"));
    let scene = files.load().unwrap_or_else(|error| panic!("{error}")).scene;
    assert_eq!((scene.objects.len(), scene.families.families.len()), (COUNT + COUNT / 2, COUNT / 2));
    assert_eq!(scene.objects[1].name, "object2/part0");
}

#[test]
fn a_mesh_of_many_cells_is_read_once() {
    // A part that is not there ends the reading; without it, the files would be read for minutes.
    let mesh: String = (0..100_000).map(|number| format!("v {number} 0 0\n")).collect();
    let cells: String = (0..20_000).map(|_| "[[cell]]\nmesh = \"a.obj\"\nnode = \"room\"\n").collect();
    let files = Files::new(&format!("{cells}[[cell]]\nmesh = \"a.obj\"\nnode = \"none\"\n"));
    let error = files.with("a.obj", &format!("o room\n{mesh}f 1 2 3\n")).load().expect_err("refused").to_string();
    assert!(error.contains("line 60001") && error.contains("cell20001"), "{error}");
    let broken = Files::new("[[cell]]\nmesh = \"a.obj\"\n").with("a.obj", "v 0 0 x\n").load().expect_err("refused");
    assert!(broken.to_string().contains("a.obj: line 1"), "{broken}");
}

#[test]
fn a_light_that_is_moved_out_of_range_is_refused() {
    let lit = r#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_lights_punctual"],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"}]}},
        "nodes":[{"mesh":0},{"name":"lamp","translation":[1e60,0,0],"extensions":{"KHR_lights_punctual":{"light":0}}}],
        "scenes":[{"nodes":[0,1]}],"scene":0,"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,
        "uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAIA/"}]}"#;
    let load = |x: &str| {
        let scene = format!("[[object]]\nmesh = \"lit.gltf\"\ntranslation = [{x}, 0, 0]\n");
        Files::new(&scene).with("lit.gltf", lit).load()
    };
    assert_eq!(load("1").unwrap_or_else(|error| panic!("{error}")).scene.lights[0].name, "object1/lamp");
    let message = load("1e60").expect_err("refused").to_string();
    assert!(message.contains("\"lamp\" lies too far away"), "{message}");
}

/// Vertices of which the only triangle uses three.
fn loose_vertices(count: usize) -> String {
    let header = format!(
        "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    );
    header + "0 0 0\n1 0 1\n0 1 0\n" + &"0 0 0\n".repeat(count - 3) + "3 0 1 2\n"
}

#[test]
fn what_is_multiplied_has_limits() {
    // Without them, each of these would take half a minute or more.
    let boxes = "{ center = [9, 9, 9], half = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] },".repeat(40_000);
    let cells: String = (0..3000).map(|n| format!("[[cell]]\nname = \"c{n}\"\nmesh = \"a.obj\"\n")).collect();
    let grid = format!("o room\nv 0 0 0\nv 1 0 0\nv 0 1 1\n{}", "f 1 2 3\n".repeat(4096));
    for (scene, file, mesh, words) in [
        ("[[object]]\nmesh = \"a.ply\"\n".repeat(2000), "a.ply", loose_vertices(100_000), "200000000 placed vertices"),
        (
            format!("[[object]]\nmesh = \"a.ply\"\nboxes = [{boxes}]\n"),
            "a.ply",
            loose_vertices(100_000),
            "4000000000 pairs of a vertex and a box",
        ),
        (format!("{FLOOR}{cells}"), "a.obj", grid, "12288000 placed triangles"),
    ] {
        let message = Files::new(&scene).with(file, &mesh).load().expect_err(words).to_string();
        assert!(message.contains(words) && message.contains("at most"), "{message}");
    }
}

#[test]
fn long_names_are_cut() {
    let long = "ä".repeat(100_000);
    let mesh = format!("v 0 0 0\nv 1 0 0\nv 0 1 1\no {long}\nf 1 2 3\no b\nf 1 2 3\n");
    let entry = |node: &str| format!("[[object]]\nname = \"{long}\"\nmesh = \"a.obj\"\n{node}");
    let scene = format!("{}{}", entry(&format!("node = \"{long}\"\n")), entry(""));
    let scene = Files::new(&scene).with("a.obj", &mesh).load().unwrap_or_else(|error| panic!("{error}")).scene;
    let lengths: Vec<usize> = scene.objects.iter().map(|object| object.name.chars().count()).collect();
    assert_eq!(lengths, [200, 401, 202]);
    let rooms = ROOMS.replace("west", &long);
    assert_eq!(loaded(&rooms).scene.cells.cells()[0].name.chars().count(), 200);
    for wrong in [entry("node = \"x\"\n"), entry(&format!("node = \"x{long}\"\n")), entry(&format!("{long} = 1\n"))] {
        let message = Files::new(&wrong).with("a.obj", &mesh).load().expect_err("refused").to_string();
        assert!(message.chars().count() < 1000, "{}", message.len());
    }
}

#[test]
fn places_are_found_on_long_lines() {
    let text = "ä = 'x'\n".to_owned() + &"öx".repeat(10_000) + "\n\nab";
    let places = Places::new(&text);
    let expected = |at: usize| {
        let line = text[..at].matches('\n').count() + 1;
        (line, text[..at].chars().rev().take_while(|&character| character != '\n').count() + 1)
    };
    for at in text.char_indices().map(|(at, _)| at).chain([text.len()]).step_by(7) {
        assert_eq!(places.line_and_column(at..at), expected(at), "{at}");
    }
    assert_eq!(Places::new("").line_and_column(0..0), (1, 1));
    // Squares of this count take minutes.
    let cells = format!("cell = [{}{{}}]", "{box = [[0, 0, 0], [1, 1, 1]]}, ".repeat(100_000));
    assert!(refused(&cells).to_string().contains(&format!("column {}", cells.len() - 2)));
}

#[test]
fn detail_is_one_setting() {
    let with = |detail: &str| loaded(&format!("{FLOOR}[detail]\n{detail}\n")).detail;
    assert_eq!(with("boundary_depth = 8"), Some(DetailSetting::Depth { interior: None, boundary: 8 }));
    let both = DetailSetting::Depth { interior: Some(4), boundary: 9 };
    assert_eq!(with("boundary_depth = 9\ninterior_depth = 4"), Some(both));
    assert_eq!(with("cell = 1"), Some(DetailSetting::Cell { edge: 1.0 }));
    assert_eq!(with("max_undecided = 0.01"), Some(DetailSetting::MaxUndecided { share: 0.01 }));
    assert_eq!(with("time = 0.5"), Some(DetailSetting::Time { limit: std::time::Duration::from_millis(500) }));
    assert_eq!(with("memory = 64_000_000"), Some(DetailSetting::Memory { bytes: 64_000_000 }));
    assert_eq!(with("pixel_rows = 480"), Some(DetailSetting::Pixel { rows: 480 }));
    assert_eq!(loaded(FLOOR).detail, None);
    for wrong in
        ["time = 0", "time = nan", "memory = -1", "memory = 0", "pixel_rows = 0", "cell = 1\ninterior_depth = 2"]
    {
        refused(&format!("{FLOOR}[detail]\n{wrong}\n"));
    }
    for wrong in ["", "cell = 0", "cell = 1\nmax_undecided = 0.1", "boundary_depth = 22", "max_undecided = 2"] {
        assert!(refused(&format!("{FLOOR}[detail]\n{wrong}\n")).to_string().contains("line 4"), "{wrong}");
    }
    refused(&format!("{FLOOR}[detail]\nboundary_depth = 3\ninterior_depth = 4\n"));
}

#[test]
fn objects_and_lights_have_details_of_their_own() {
    let files = Files::new(
        "[[object]]\nname = \"house\"\nmesh = \"parts.obj\"\ndetail = { cell = 0.5 }\n\
         [[object]]\nname = \"ball\"\nsphere = { radius = 1 }\n\
         [[object]]\nname = \"box\"\nbox = { size = [1, 1, 1] }\ndetail = { boundary_depth = 10, interior_depth = 2 }\n\
         [[light]]\nname = \"noon\"\nsun = { direction = [0, -1, 0] }\n\
         [[light]]\nname = \"lamp\"\npoint = { position = [0, 5, 0] }\ndetail = { boundary_depth = 3 }\n",
    )
    .with("parts.obj", TWO_PARTS);
    let own = files.load().unwrap_or_else(|error| panic!("{error}")).own;
    let cell = DetailSetting::Cell { edge: 0.5 };
    let depth = |interior, boundary| DetailSetting::Depth { interior, boundary };
    assert_eq!(own.objects.into_iter().collect::<Vec<_>>(), [(0, cell), (1, cell), (3, depth(Some(2), 10))]);
    assert_eq!(own.lights.into_iter().collect::<Vec<_>>(), [(1, depth(None, 3))]);
    for wrong in ["{ time = 1.0 }", "{ max_undecided = 0.1 }", "{ pixel_rows = 9 }", "{}"] {
        let text = refused(&format!("{FLOOR}detail = {wrong}\n")).to_string();
        assert!(text.contains("detail: ") && text.contains("line 1"), "{text}");
    }
}

#[test]
fn faults_are_told_in_words_of_the_format() {
    for (number, words) in [
        ("\"1\"", "invalid type: string \"1\", expected a number"),
        ("99999999999999999999", "integer `99999999999999999999`, expected a number"),
    ] {
        let message = refused(&format!("[[object]]\nsphere = {{ radius = {number} }}\n")).to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn faults_name_their_place() {
    for (text, parts) in [
        ("colour = 3\n", &["line 1", "column 1", "unknown field `colour`"][..]),
        ("[[object]]\nname = \"a\"\nboxs = 3\n", &["line 3", "unknown field `boxs`"]),
        ("[[object]]\nbox = { size = [1, 1, 1], edge = 2 }\n", &["line 2", "column 27", "unknown field `edge`"]),
        ("[[object]]\nbox = { size = [1, 1] }\n", &["line 2", "length 2"]),
        ("[[object]]\nbox = { size = [1, 1, 1, 1] }\n", &["line 2", "length 4"]),
        ("[[object]]\nsphere = { radius = 1 }\ntranslation = [1, 2, 3, 4]\n", &["line 3", "length 4"]),
        ("[[object]]\nsphere = { radius = 1 }\nscale = [1, 2, 3, 4]\n", &["line 3", "scale must be"]),
        ("[[object]]\nconvex = { points = [[0, 0, 0, 0]] }\n", &["line 2", "length 4"]),
        ("[[cell]]\nbox = [[0, 0, 0], [1, 1, 1], [2, 2, 2]]\n", &["line 2", "length 3"]),
        ("[[cell]]\nbox = [[0, 0, 0], [1, 1, 1, 1]]\n", &["line 2", "length 4"]),
        ("[[portal]]\ncells = [\"a\", \"b\", \"c\"]\ncorners = []\n", &["line 2", "length 3"]),
        ("[camera]\neye = [1, 2, 3, 4]\ntarget = [0, 0, 0]\n", &["line 2", "length 4"]),
        ("[[object]]\nscale = \"x\"\n", &["line 2", "scale must be"]),
        ("[[object]]\nname = \"a\n", &["line 2"]),
        ("up = \"x\"\n", &["line 1", "unknown variant"]),
        ("up = { z = {} }\n", &["line 1", "column 6", "expected a word in quotes"]),
        ("sides = { one = 3 }\n", &["line 1", "expected a word in quotes"]),
        ("[[object]]\nsphere = [1]\n", &["line 2", "column 10", "expected a table"]),
        ("[[object]]\nbox = [[1, 1, 1]]\n", &["line 2", "expected a table"]),
        ("[[object]]\nsphere = { radius = 1 }\ndetail = [3]\n", &["line 3", "expected a table"]),
        ("[[light]]\nsun = [[0, -1, 0]]\n", &["line 2", "expected a table"]),
        ("object = [[\"a\"]]\n", &["line 1", "expected a table"]),
        ("camera = [[1, 2, 3], [0, 0, 0]]\n", &["line 1", "expected a table"]),
        ("[[object]]\nname = \"a\"\n", &["line 1", "object \"a\"", "exactly one body"]),
        ("[[object]]\nbox = { size = [1, 1, 1] }\nsphere = { radius = 1 }\n", &["object1", "exactly one body"]),
        ("[[object]]\ncone = { radius = 1, height = -2 }\n", &["object1", "not a positive number"]),
        ("[[object]]\ncone = { radius = 1 }\n", &["line 2", "height"]),
        ("[[object]]\nquadric = { matrix = [], within = [] }\n", &["line 2", "length 0"]),
        ("[[object]]\nconvex = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0]] }\n", &["object1", "convex"]),
        (
            "[[object]]\nhyperboloid = { waist_radius = 2, end_radius = 1, height = 1 }\n",
            &["object1", "end radius is smaller"],
        ),
        ("[[cell]]\nname = \"a\"\n", &["line 1", "cell \"a\"", "exactly one of points, box"]),
        ("[[portal]]\nname = \"a\"\n", &["line 1", "missing field"]),
        ("[[object]]\nname = \"a\"\nbox = { size = [1, 0, 1] }\n", &["object \"a\"", "size"]),
        ("[[object]]\nname = \"a\"\nsphere = { radius = -1 }\n", &["object \"a\"", "radius"]),
        ("[[object]]\nname = \"a\"\nsphere = { radius = nan }\n", &["object \"a\"", "radius"]),
        ("[[object]]\nname = \"a\"\nsphere = { radius = 1 }\nscale = 0\n", &["object \"a\"", "singular"]),
        ("[[object]]\nname = \"a\"\nsphere = { radius = 1 }\ntranslation = [inf, 0, 0]\n", &["object \"a\"", "finite"]),
        ("[[object]]\nsphere = { radius = 1 }\nrotation = [0, 0, 0, 0]\n", &["object1", "rotation"]),
        ("[[object]]\nsphere = { radius = 1 }\nnode = \"x\"\n", &["object1", "node"]),
        (
            "[[object]]\nsphere = { radius = 1 }\nscale = 1\nmatrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n",
            &["object1", "either matrix"],
        ),
        (
            "[[object]]\nsphere = { radius = 1 }\nmatrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,2]\n",
            &["object1", "last row"],
        ),
        ("north = nan\n", &["north"]),
    ] {
        let error = refused(text);
        let message = error.to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{text}: {message}");
        assert!(message.contains("scene.toml") && !error.is_unreadable(), "{message}");
    }
}

#[test]
fn faults_of_lights_and_cameras() {
    for (text, part) in [
        ("[[light]]\nname = \"l\"\n", "exactly one of"),
        ("[[light]]\nname = \"l\"\nsun = { }\n", "either direction"),
        ("[[light]]\nname = \"l\"\nsun = { azimuth = 1 }\n", "either direction"),
        ("[[light]]\nname = \"l\"\nsun = { direction = [0, 1, 0], elevation = 1 }\n", "either direction"),
        ("[[light]]\nname = \"l\"\nsun = { direction = [0, 0, 0] }\n", "length zero"),
        ("[[light]]\nname = \"l\"\nsun = { azimuth = nan, elevation = 1 }\n", "azimuth"),
        ("[[light]]\nname = \"l\"\nsun = { azimuth = 1, elevation = 91 }\n", "elevation"),
        ("[[light]]\nname = \"l\"\nsun = { direction = [0, 1, 0], angular_diameter = -1 }\n", "angular_diameter"),
        ("[[light]]\nname = \"l\"\npoint = { position = [0, inf, 0] }\n", "not finite"),
        ("[[light]]\nname = \"l\"\npoint = { position = [0, 0, 0], radius = -1 }\n", "radius"),
        ("[[light]]\nname = \"l\"\nrectangle = { center = [0, 0, 0], u = [1, 0, 0], v = [2, 0, 0] }\n", "half edges"),
        ("[camera]\neye = [0, 0, 0]\ntarget = [0, 0, 0]\n", "two points"),
        ("[camera]\neye = [0, 0, 0]\ntarget = [0, 1, 0]\n", "parallel"),
        ("[camera]\neye = [0, 0, 0]\ntarget = [1, 0, 0]\nvertical_degrees = 180\n", "field of view"),
        ("[camera]\neye = [0, 0, 0]\ntarget = [1, 0, 0]\nheight = 0\n", "height"),
        ("[camera]\neye = [0, 0, 0]\ntarget = [1, 0, 0]\nheight = 1\nvertical_degrees = 10\n", "not both"),
        ("[camera]\neye = [0, 0, 0]\n", "target"),
    ] {
        let message = refused(&format!("{FLOOR}{text}")).to_string();
        assert!(message.contains(part) && message.contains("line 4"), "{text}: {message}");
    }
}

#[test]
fn mesh_files_stay_in_the_folder_and_name_their_own_faults() {
    let object = |mesh: &str| format!("[[object]]\nname = \"a\"\nmesh = \"{mesh}\"\n");
    let outside = refused(&object("../other/house.obj"));
    assert!(matches!(&outside.problem, LoadProblem::Outside { .. }) && !outside.is_unreadable());
    assert!(outside.to_string().contains("object \"a\""), "{outside}");
    let missing = refused(&object("house.obj"));
    assert!(missing.is_unreadable() && missing.to_string().contains("house.obj"), "{missing}");
    let kind = Files::new(&object("house.fbx")).with("house.fbx", "?").load().expect_err("refused");
    assert!(!kind.is_unreadable() && kind.to_string().contains("no mesh file"), "{kind}");
    let broken = Files::new(&object("house.obj")).with("house.obj", "v 0 0 x\n").load().expect_err("refused");
    assert!(broken.to_string().contains("house.obj: line 1"), "{broken}");
    let empty = Files::new(&object("house.obj")).with("house.obj", "v 0 0 0\n").load().expect_err("refused");
    assert!(empty.to_string().contains("no triangle"), "{empty}");
    let node = format!("{}node = \"Cellar\"\n", object("house.obj"));
    let node = Files::new(&node).with("house.obj", TWO_PARTS).load().expect_err("refused");
    assert!(node.to_string().contains("\"Cellar\"") && node.to_string().contains("\"Roof\""), "{node}");
}

#[test]
fn unreadable_files_are_told_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["missing.toml", "missing.obj", "missing.glb"] {
        let error = load(&folder.path().join(name), &LoadOptions::default()).expect_err("missing");
        assert!(error.is_unreadable() && error.to_string().contains(name), "{error}");
    }
    std::fs::write(folder.path().join("scene.max"), "?").expect("a file");
    assert!(load(&folder.path().join("scene.max"), &LoadOptions::default()).expect_err("unknown").is_unreadable());
    let directory = folder.path().join("folder.obj");
    std::fs::create_dir(&directory).expect("a folder");
    assert!(load(&directory, &LoadOptions::default()).expect_err("a folder").is_unreadable());
    std::fs::write(folder.path().join("latin.toml"), b"# caf\xe9\n").expect("a file");
    let latin = load(&folder.path().join("latin.toml"), &LoadOptions::default()).expect_err("not UTF-8");
    assert!(!latin.is_unreadable() && latin.to_string().contains("line 1"), "{latin}");
}

/// Two rooms and the outdoors, each kind of cell, and a door.
const ROOMS: &str = "[[object]]\nname = \"table\"\nbox = { size = [1, 1, 1] }\ntranslation = [1, 1, 1]\n\
    [[cell]]\nname = \"west\"\nbox = [[0, 0, 0], [4, 3, 4]]\n\
    [[cell]]\nname = \"east\"\nplanes = [[1, 0, 0, 8], [-1, 0, 0, -4], [0, 1, 0, 3], [0, -1, 0, 0], [0, 0, 1, 4], [0, 0, -1, 0]]\n\
    [[cell]]\nname = \"north\"\npoints = [[0, 0, -4], [4, 0, -4], [0, 0, 0], [4, 0, 0], [0, 3, -4], [4, 3, -4], [0, 3, 0], [4, 3, 0]]\n\
    [[cell]]\nname = \"outside\"\noutdoors = true\n\
    [[portal]]\nname = \"door\"\ncells = [\"west\", \"east\"]\ncorners = [[4, 0, 1], [4, 0, 2], [4, 2, 2], [4, 2, 1]]\n";

#[test]
fn cells_and_portals() {
    let cells = loaded(ROOMS).scene.cells;
    assert_eq!((cells.cells().len(), cells.portals().len(), cells.outdoors()), (4, 1, Some(3)));
    assert_eq!((cells.objects_in(0), cells.objects_in(1)), (&[0][..], &[][..]));
    // With z up, all of it is turned, exactly.
    let turned = loaded(&format!("up = \"z\"\n{ROOMS}")).scene;
    assert_eq!(turned.cells.objects_in(0), [0]);
    assert_eq!(turned.cells.cells_at(DVec3::new(1.0, 1.0, -1.0)), [0]);
    // A mesh that is a cell, alone and as a part of a file.
    let tetrahedron = "o room\nv 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    for cell in ["mesh = \"a.obj\"", "mesh = \"a.obj\"\nnode = \"room\""] {
        let files = Files::new(&format!("{FLOOR}[[cell]]\nname = \"tent\"\n{cell}\n")).with("a.obj", tetrahedron);
        let scene = files.load().unwrap_or_else(|error| panic!("{error}")).scene;
        assert_eq!((scene.objects.len(), scene.cells.objects_in(0)), (1, &[0][..]));
    }
}

#[test]
fn corners_may_say_how_they_are_rounded() {
    let rounded = |x: f64, said: &str| {
        let moved = ROOMS.replace("corners = [[4, 0, 1]", &format!("{said}corners = [[{x}, 0, 1]"));
        Files::new(&moved).load().map(|loaded| loaded.scene.cells.portals()[0].slack)
    };
    assert_eq!(rounded(4.0, "").expect("in place"), 0.0);
    assert!(rounded(4.000_001, "").is_err());
    assert_eq!(rounded(4.000_001, "rounding = 2e-6\n").expect("as near as it says"), 2e-6);
    assert!(rounded(4.1, "rounding = 2e-6\n").is_err());
}

#[test]
fn faults_of_cells_and_portals() {
    for (change, parts) in [
        (
            ("box = [[0, 0, 0], [4, 3, 4]]", "rounding = -1\nbox = [[0, 0, 0], [4, 3, 4]]"),
            &["line 5", "cell \"west\"", "rounding"][..],
        ),
        (("outdoors = true", "outdoors = false"), &["line 14", "cell \"outside\"", "exactly one of"]),
        (("name = \"east\"", "name = \"west\""), &["line 8", "another cell"]),
        (("[1, 0, 0, 8], ", ""), &["line 8", "cell \"east\"", "unbounded towards +x"]),
        (("[4, 3, 0]]", "[4, nan, 0]]"), &["line 11", "cell \"north\"", "not finite"]),
        (("[0, 1, 0, 3]", "[0, inf, 0, 3]"), &["line 8", "cell \"east\"", "not finite"]),
        (("box = [[0, 0, 0], [4, 3, 4]]", "box = [[0, 0, 0], [4, 0, 4]]"), &["line 5", "cell \"west\""]),
        (("[\"west\", \"east\"]", "[\"west\", \"attic\"]"), &["line 17", "portal \"door\"", "no cell \"attic\""]),
        (("[\"west\", \"east\"]", "[\"west\", \"outside\"]"), &[]),
        (("[\"west\", \"east\"]", "[\"north\", \"outside\"]"), &["line 17", "corner 0", "boundary"]),
        (("[[4, 0, 1], ", "[[4, 1e300, 1], "), &["line 17", "corner 0", "coordinate y", "larger than"]),
    ] {
        let text = ROOMS.replacen(change.0, change.1, 1);
        assert_ne!(text, ROOMS);
        match Files::new(&text).load() {
            Ok(_) => assert!(parts.is_empty(), "{change:?}"),
            Err(error) => {
                let message = error.to_string();
                assert!(!parts.is_empty() && parts.iter().all(|part| message.contains(part)), "{change:?}: {message}");
            }
        }
    }
    let many = "[1, 0, 0, 1], ".repeat(crate::rooms::MOST_PLANES + 1);
    let many = format!("{FLOOR}[[cell]]\nname = \"a\"\nplanes = [{many}]\n");
    assert!(refused(&many).to_string().contains("at most"), "counts are limited");
}
