//! `umbriel query`: the rows come back with a column a light.

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
