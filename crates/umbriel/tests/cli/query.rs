//! `umbriel query`: the rows come back with a column a light.

use std::fs;

use crate::workspace::{NOON, Workspace};

fn workspace(points: &str) -> Workspace {
    Workspace::with(&[("noon.toml", NOON), ("p.csv", points)])
}

#[test]
fn points_in_space() {
    let points = "x,y,z\n0, 1.0,0\n3,1,0\n0,5e0,0\n";
    let run = workspace(points).run("query noon.toml --points p.csv").succeeds();
    assert_eq!(run.stdout(), "x,y,z,noon\n0,1.0,0,0\n3,1,0,1\n0,5e0,0,1\n");
}

#[test]
fn points_with_normals() {
    let points = "x,y,z,nx,ny,nz\n3,0,0,0,1,0\n0,0,0,0,1,0\n3,0.5,0,0,1,0\n";
    let run = workspace(points).run("query noon.toml --points p.csv").succeeds();
    assert_eq!(run.stdout(), "x,y,z,nx,ny,nz,noon\n3,0,0,0,1,0,1\n0,0,0,0,1,0,0\n3,0.5,0,0,1,0,1\n");
    assert!(run.stderr().contains("1 points with a normal lie on no surface"), "{}", run.stderr());
}

#[test]
fn points_of_faces_and_several_lights() {
    let points = "object,face,u,v\nfloor,0,0.5,0.5\nfloor,0,0,1\nball,3,0.5,0.5\nball,2,0.5,0.5\n";
    let workspace = workspace(points);
    workspace.run("query noon.toml --points p.csv --point 0,0.5,0 -o out.csv").succeeds();
    let expected =
        "object,face,u,v,noon,point\nfloor,0,0.5,0.5,0,1\nfloor,0,0,1,1,1\nball,3,0.5,0.5,1,0\nball,2,0.5,0.5,0,1\n";
    assert_eq!(workspace.text("out.csv"), expected);
}

#[test]
fn the_acceleration_changes_no_answer_and_is_told() {
    for points in ["x,y,z\n0,1,0\n3,1,0\n0,5,0\n", "object,face,u,v\nfloor,0,0.5,0.5\nfloor,0,0,1\nball,3,0.5,0.5\n"] {
        let workspace = workspace(points);
        let plain = workspace.run("query noon.toml --points p.csv").succeeds();
        assert!(plain.stderr().contains("points under noon"), "{}", plain.stderr());
        for (way, told) in [("bvh", "by BVH"), ("octree", "by octree"), ("projection", "by projection")] {
            let run = workspace.run(&format!("query noon.toml --points p.csv --acceleration {way}")).succeeds();
            assert_eq!(run.stdout(), plain.stdout());
            assert!(run.stderr().contains(&format!("points under noon {told}: 3 points")), "{}", run.stderr());
            let quiet =
                workspace.run(&format!("query noon.toml --points p.csv --quiet --acceleration {way}")).succeeds();
            assert_eq!((quiet.stdout(), quiet.stderr()), (plain.stdout(), String::new()));
        }
    }
}

/// Both ends of the accepted range in one scene, as text: a floor of 2^200 m, and a box of 2^-199 m, whose corners lie 2^-200 m beside its middle, two
/// of its heights above that of the floor.
#[test]
fn both_ends_of_the_range_as_text() {
    let (most, least) = ("1.6069380442589903e60", "6.223015277861142e-61");
    let (twice, fourfold) = ("1.2446030555722283e-60", "2.4892061111444567e-60");
    let scene = format!(
        "[[object]]\nname = \"floor\"\nrectangle = {{ size = [{most}, {most}] }}\n
[[object]]\nname = \"speck\"\nbox = {{ size = [{twice}, {twice}, {twice}] }}\ntranslation = [0.0, {fourfold}, 0.0]\n
[[light]]\nname = \"noon\"\nsun = {{ direction = [0.0, -{most}, 0.0] }}\n"
    );
    // Points, whether noon reaches them, and whether a lamp as high as it goes does.
    let rows = [
        ("0,0,0".to_owned(), "0,0"),
        (format!("{twice},0,0"), "1,1"),
        (format!("0,{least},0"), "0,0"),
        (format!("0,{fourfold},0"), "0,0"),
        (format!("0,{most},0"), "1,1"),
        (format!("{most},-{least},{least}"), "1,1"),
        (format!("{least},-{least},0"), "0,0"),
    ];
    let text = |header: &str, rows: &[(String, &str)], told: bool| {
        let row = |(point, lit): &(String, &str)| if told { format!("{point},{lit}\n") } else { format!("{point}\n") };
        format!("{header}\n{}", rows.iter().map(row).collect::<String>())
    };
    let answers = |header: &str, rows: &[(String, &str)]| {
        let points = text(header, rows, false);
        let workspace = Workspace::with(&[("ends.toml", scene.as_str()), ("p.csv", points.as_str())]);
        let lamp = format!("query ends.toml --points p.csv --point 0,{most},0");
        assert_eq!(workspace.run(&lamp).succeeds().stdout(), text(&format!("{header},noon,point"), rows, true));
    };
    answers("x,y,z", &rows);
    let on_floor: Vec<_> = rows[..2].iter().map(|(point, lit)| (format!("{point},0,{least},0"), *lit)).collect();
    answers("x,y,z,nx,ny,nz", &on_floor);
    let of_faces = [("floor,0,0.5,0.5", "0,0"), ("floor,0,0.5,0.25", "1,1"), ("floor,0,0.5,1", "1,1")];
    answers("object,face,u,v", &of_faces.map(|(point, lit)| (point.to_owned(), lit)));
    let beyond = "x,y,z\n0,0,0\n0,1.6069380442589906e60,0\n";
    let workspace = Workspace::with(&[("ends.toml", scene.as_str()), ("p.csv", beyond)]);
    workspace.run("query ends.toml --points p.csv").fails(1, &["line 3", "2^200"]);
}

#[test]
fn bad_rows_are_named_by_their_lines() {
    for (points, words) in [
        ("a,b\n", ["p.csv", "header"]),
        ("x,y,z\n1,2,3\n1,x,3\n", ["line 3", "y is \"x\""]),
        ("x,y,z\n1,2,3\n\n1,2\n", ["line 4", "2 fields"]),
        ("object,face,u,v\nroof,0,0,0\n", ["line 2", "no object \"roof\""]),
        ("object,face,u,v\nfloor,1,0,0\n", ["line 2", "faces 0 to 0"]),
        ("object,face,u,v\nfloor,0,0,0\nfloor,0,0.5,1.5\n", ["line 3", "outside the face"]),
        ("x,y,z,nx,ny,nz\n1,0,1,0,0,0\n", ["line 2", "normal"]),
    ] {
        let workspace = workspace(points);
        workspace.run("query noon.toml --points p.csv -o out.csv").fails(1, &words);
        assert_eq!(workspace.files(), ["noon.toml", "p.csv"]);
    }
}

/// A `.npy` file of version 1 with this type and shape.
fn npy(descr: &str, shape: &str, numbers: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    let start = [b"\x93NUMPY\x01\x00".as_slice(), &118u16.to_le_bytes()].concat();
    [start.as_slice(), format!("{header:117}\n").as_bytes(), numbers].concat()
}

fn bytes(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

#[test]
fn arrays_of_points() {
    let workspace = workspace("");
    let rows = [3.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 3.0, 0.5, 0.25, 0.0, 2.0, 0.0];
    fs::write(workspace.path("p.npy"), npy("<f4", "(3, 6)", &bytes(&rows))).expect("written");
    let run = workspace.run("query noon.toml --points p.npy --point 0,0.5,0 -o a.npy -o a.csv").succeeds();
    assert!(run.stderr().contains("1 points with a normal lie on no surface"), "{}", run.stderr());
    assert_eq!(workspace.read("a.npy"), npy("|u1", "(3, 2)", &[1, 1, 0, 1, 1, 1]));
    let expected = "x,y,z,nx,ny,nz,noon,point\n3,0,0,0,1,0,1,1\n0,0,0,0,1,0,0,1\n3,0.5,0.25,0,2,0,1,1\n";
    assert_eq!(workspace.text("a.csv"), expected);
}

#[test]
fn answers_to_a_table_as_an_array() {
    let workspace = workspace("x,y,z\n0, 1.0,0\n3,1,0\n");
    workspace.run("query noon.toml --points p.csv -o a.npy").succeeds();
    assert_eq!(workspace.read("a.npy"), npy("|u1", "(2, 1)", &[0, 1]));
}

#[test]
fn bad_arrays_are_named_by_what_is_wrong() {
    let whole = bytes(&[1.0, 2.0, 3.0, 0.0, f32::NAN, 0.0]);
    for (file, words) in [
        (npy("<f4", "(2, 3)", &whole), ["p.npy", "row 1: y is not finite"]),
        (npy("<f4", "(1, 6)", &whole), ["p.npy", "row 0: the normal is"]),
        (npy("<f4", "(3, 3)", &whole), ["p.npy", "36 bytes"]),
        (npy("<i8", "(1, 3)", &whole), ["p.npy", "type \"<i8\""]),
        (b"x,y,z\n".to_vec(), ["p.npy", "no .npy file"]),
    ] {
        let workspace = workspace("");
        fs::write(workspace.path("p.npy"), file).expect("written");
        workspace.run("query noon.toml --points p.npy -o out.npy").fails(1, &words);
        assert!(!workspace.files().contains(&"out.npy".to_owned()), "nothing is written");
    }
}

#[test]
fn area_lights_answer_with_shares() {
    let half = "[[object]]\nname = \"plate\"\nrectangle = { size = [4, 4] }\ntranslation = [2, 2, 0]\n\
                [[light]]\nname = \"panel\"\nrectangle = { center = [0, 4, 0], u = [1, 0, 0], v = [0, 0, 1] }\n\
                [[light]]\nname = \"noon\"\nsun = { direction = [0, -1, 0] }\n";
    let workspace = Workspace::with(&[("half.toml", half), ("p.csv", "x,y,z\n0,0,0\n-3,0,0\n2,0,0\n")]);
    let plain = workspace.run("query half.toml --points p.csv").succeeds();
    assert_eq!(plain.stdout().lines().next(), Some("x,y,z,panel,noon"));
    let run = workspace.run("query half.toml --points p.csv --errors").succeeds();
    let text = run.stdout();
    let mut rows = text.lines();
    assert_eq!(rows.next(), Some("x,y,z,panel,panel_error,noon"));
    let numbers = |row: &str| -> Vec<f64> { row.split(',').map(|field| field.parse().expect("a number")).collect() };
    for (row, expected) in rows.zip([[0.0, 0.0, 0.0, 0.5, 0.0], [-3.0, 0.0, 0.0, 1.0, 1.0], [2.0, 0.0, 0.0, 0.0, 0.0]])
    {
        let found = numbers(row);
        assert_eq!([found[0], found[1], found[2], found[3], found[5]], expected, "{row}");
        assert!((0.0..1e-12).contains(&found[4]) && (expected[3] != 1.0 || found[4] == 0.0), "{row}");
    }
    assert!(!run.stderr().contains("extent"), "{}", run.stderr());
    workspace.run("query half.toml --points p.csv -o out.npy").fails(2, &["panel", "shares"]);
    workspace.run("query half.toml --points p.csv --light noon -o out.npy").succeeds();
}
