//! `umbriel bake --suns`: hours of sun, by object and by cell.

use serde_json::Value;

use crate::workspace::Workspace;

/// A floor of 64 m² and, two metres above its middle, a plate of 2 m².
const PLATE: &str = r#"
[[object]]
name = "floor"
rectangle = { size = [8.0, 8.0] }

[[object]]
name = "plate"
rectangle = { size = [2.0, 1.0] }
translation = [0.0, 2.0, 0.0]
"#;

/// From above, and from the east at 45 degrees; and twice night.
const DAY: &str = "time,azimuth,elevation\n05:30,80,-3\n06:00,83,0\n06:30,90,90\n07:30,90,45\n";

fn workspace(table: &str) -> Workspace {
    Workspace::with(&[("plate.toml", PLATE), ("day.csv", table)])
}

fn json(workspace: &Workspace, arguments: &str) -> Value {
    let arguments = format!("bake plate.toml --suns day.csv --json - {arguments}");
    serde_json::from_str(&workspace.run(&arguments).succeeds().stdout()).expect("JSON")
}

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} in {value}"))
}

#[test]
fn json_tells_hours_with_bounds() {
    let bake = json(&workspace(DAY), "--boundary-depth 7");
    assert!(bake["lights"].as_array().is_some_and(Vec::is_empty));
    for (path, expected) in [
        ("/suns/count", 4.0),
        ("/suns/below_horizon", 2.0),
        ("/suns/hours", 1.0), // two suns, each for the step of half an hour
        ("/suns/objects/0/area", 64.0),
        ("/suns/rows/3/line", 5.0),
        ("/suns/rows/3/hours", 0.5),
        ("/suns/rows/0/lit_area/upper", 0.0),
    ] {
        assert_eq!(number(&bake, path), expected, "{path}");
    }
    assert_eq!(
        (&bake["suns"]["objects"][1]["name"], &bake["suns"]["rows"][2]["time"]),
        (&"plate".into(), &"06:30".into())
    );
    // The plate keeps its own 2 m² off the floor, under either sun, and is lit all the time.
    for (path, truth) in [
        ("/suns/objects/0/lit_hours", 62.0 / 64.0),
        ("/suns/objects/0/lit_area_hours", 62.0),
        ("/suns/objects/1/lit_area_hours", 2.0),
        ("/suns/rows/3/lit_area", 64.0),
    ] {
        let bound = |name: &str| number(&bake, &format!("{path}/{name}"));
        let (lower, upper, estimate) = (bound("lower"), bound("upper"), bound("estimate"));
        assert!(lower <= truth && truth <= upper && upper - lower < 0.03 * truth, "{path}: {lower} to {upper}");
        assert!((lower..=upper).contains(&estimate), "{path}");
    }
    let finding = serde_json::json!({ "kind": "suns_below_horizon", "object": "", "count": 2 });
    assert!(bake["findings"].as_array().is_some_and(|findings| findings.contains(&finding)), "{}", bake["findings"]);
    assert!(number(&bake, "/time/first_sun") > 0.0 && number(&bake, "/time/further_sun") > 0.0);
}

#[test]
fn rows_last_as_long_as_they_say() {
    let hours = |table: &str, arguments: &str| {
        let bake = json(&workspace(table), &format!("--boundary-depth 0 {arguments}"));
        number(&bake, "/suns/hours")
    };
    assert_eq!(hours("azimuth,elevation\n10,20\n20,30\n", ""), 2.0);
    assert_eq!(hours("azimuth,elevation\n10,20\n20,30\n", "--hours-each 0.25"), 0.5);
    assert_eq!(hours("azimuth,elevation,hours\n10,20,0.5\n20,30,3\n20,-1,7\n", ""), 3.5);
    assert_eq!(hours("azimuth,elevation\n10,-20\n", ""), 0.0);
}

#[test]
fn samples_alone_need_no_cells() {
    let workspace = workspace(DAY);
    let alone = json(&workspace, "--samples 40000");
    assert_eq!(alone["detail"]["faces"], "whole", "{}", alone["detail"]);
    let hours = |bake: &Value| number(bake, "/suns/objects/0/sampled_hours");
    // The plate hides 2 of 64 m² from each of two suns of half an hour.
    assert!((hours(&alone) - 62.0 / 64.0).abs() < 1e-3, "{alone}");
    let beside = json(&workspace, "--samples 40000 --boundary-depth 4");
    assert_eq!((beside["detail"]["boundary_depth"].as_u64(), hours(&beside)), (Some(4), hours(&alone)));
}

#[test]
fn directions_are_taken_as_they_are() {
    let workspace = workspace("x,y,z\n0,-1,0\n0,1,0\n");
    let run = workspace.run("bake plate.toml --suns day.csv").succeeds();
    assert!(run.stderr().contains("1 suns whose light does not travel downward"), "{}", run.stderr());
    assert!(run.stdout().starts_with("2 suns, 2.0000 hours\n") && run.stdout().contains("total"), "{}", run.stdout());
    // A z-up scene has z-up directions, and +Y as north.
    let tables = ["x,y,z\n0,-1,-1\n", "azimuth,elevation\n0,45\n"];
    let lit = tables.map(|table| {
        let workspace = Workspace::with(&[("plate.toml", &format!("up = \"z\"\n{PLATE}")), ("day.csv", table)]);
        number(&json(&workspace, "--boundary-depth 3"), "/suns/objects/0/lit_hours/estimate")
    });
    assert!((lit[0] - lit[1]).abs() < 0.05 && lit[0] < 1.0, "{lit:?}");
}

#[test]
fn all_files_are_written() {
    let workspace = workspace(DAY);
    let bake = "bake plate.toml --suns day.csv --boundary-depth 5";
    let run = workspace.run(&format!("{bake} --samples 100 -o a.json -o a.csv -o a.vtu -o a.glb")).succeeds();
    assert!(run.stdout().starts_with("2 suns, 1.0000 hours; 2 more at or below the horizon\n"), "{}", run.stdout());
    workspace.run(&format!("{bake} --csv cells --threads 1 -o cells.csv -o b.vtu")).succeeds();
    assert_eq!(workspace.files(), ["a.csv", "a.glb", "a.json", "a.vtu", "b.vtu", "cells.csv", "day.csv", "plate.toml"]);
    assert_eq!(workspace.read("a.vtu"), workspace.read("b.vtu"), "threads do not change the file");
    assert!(["hours_lower", "hours_upper"].iter().all(|name| workspace.text("a.vtu").contains(name)));
    let table = workspace.text("a.csv");
    let header = "object,area,hours_lower,hours_upper,hours_estimate,area_hours_lower,area_hours_upper,\
        area_hours_estimate,samples,sampled_hours\nfloor,64,";
    assert!(table.starts_with(header) && table.lines().count() == 3, "{table}");
    assert!(workspace.run("info a.glb").succeeds().stdout().contains("plate"));
}

/// Half an hour for each sun whose shadow does not hold the cell, by the shadow rectangles.
#[test]
fn cells_have_the_hours_of_the_shadow_rectangles() {
    let workspace = workspace(DAY);
    workspace.run("bake plate.toml --suns day.csv --boundary-depth 5 --csv cells -o cells.csv").succeeds();
    let text = workspace.text("cells.csv");
    let mut rows = text.lines().map(|line| line.split(',').collect::<Vec<&str>>());
    let header = ["object", "face", "level", "u", "v", "x", "y", "z", "area", "hours_lower", "hours_upper"];
    assert_eq!(rows.next().expect("a header"), header);
    let (mut area, mut held, mut tight) = ([0.0; 2], [0.0; 2], 0.0);
    for row in rows.filter(|row| row[0] == "floor") {
        let at = |column: usize| row[column].parse::<f64>().expect("a number");
        let truth: f64 = [0.0, -2.0]
            .map(|shift: f64| if (at(5) - shift).abs() <= 1.0 && at(7).abs() <= 0.5 { 0.0 } else { 0.5 })
            .iter()
            .sum();
        assert!(at(9) <= truth && truth <= at(10), "{row:?}");
        area[0] += at(8);
        held[0] += at(8) * at(9);
        held[1] += at(8) * at(10);
        tight += if at(9) == at(10) { at(8) } else { 0.0 };
    }
    assert_eq!(area[0], 64.0);
    assert!(held[0] <= 62.0 && 62.0 <= held[1] && tight > 58.0, "{held:?}, {tight}");
}

#[test]
fn tables_are_refused_by_the_line() {
    for (table, words) in [
        ("", vec!["day.csv", "line 1", "azimuth,elevation or x,y,z"]),
        ("azimuth\n1\n", vec!["line 1", "azimuth"]),
        ("azimuth,elevation\n", vec!["day.csv", "no row"]),
        ("azimuth,elevation\n1,2\n1,up\n", vec!["day.csv", "line 3", "elevation is \"up\""]),
        ("azimuth,elevation,hour\n1,2,3\n", vec!["line 1", "\"hour\""]),
        ("x,y,z\n0,0,0\n", vec!["day.csv", "line 2", "length zero"]),
        ("x,y,z\n0,1e-300,0\n", vec!["day.csv", "line 2", "2^-200"]),
        ("azimuth,elevation,time\n1,2,9:00\n1,2,9:00\n", vec!["line 3", "line 2", "hours"]),
        (
            "x,y,z,hours\n1,1,1,1000000\n1,1,1,1000000\n1,1,1,1000000\n1,1,1,1000000\n1,1,1,1000000\n1,1,1,1000000\n",
            vec!["day.csv", "584 years"],
        ),
    ] {
        let workspace = workspace(table);
        workspace.run("bake plate.toml --suns day.csv --boundary-depth 0 -o out.csv").fails(1, &words);
        assert_eq!(workspace.files(), ["day.csv", "plate.toml"]);
    }
}

#[test]
fn wrong_usage() {
    let workspace = workspace(DAY);
    for (arguments, words) in [
        ("--suns gone.csv", vec!["gone.csv", "cannot be read"]),
        ("--suns day.csv --sun 1,2", vec!["--suns", "--sun"]),
        ("--suns day.csv -o a.png", vec![".png", ".glb"]),
        ("--suns day.csv -o day.csv", vec!["day.csv", "is read"]),
        ("--suns day.csv --receiver roof", vec!["--receiver roof"]),
        ("--hours-each 1 --sun 1,2", vec!["--hours-each", "--sun"]),
        ("--hours-each 1", vec!["--suns"]),
    ] {
        workspace.run(&format!("bake plate.toml {arguments}")).fails(2, &words);
    }
    #[cfg(unix)]
    workspace.run("bake plate.toml --suns /dev/zero").fails(2, &["/dev/zero", "not a regular file"]);
}

#[test]
fn a_picture_shows_hours() {
    let camera = "[camera]\neye = [0.0, 20.0, 0.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, -1.0]\nheight = 8.0\n";
    let scene = format!("{PLATE}\n{camera}");
    let workspace =
        Workspace::with(&[("plate.toml", &scene), ("day.csv", DAY), ("night.csv", "x,y,z,hours\n1,1,1,0\n")]);
    for table in ["day", "night"] {
        let render = format!("render plate.toml --suns {table}.csv --boundary-depth 6 --size 32x32 -o {table}.png");
        workspace.run(&render).succeeds();
    }
    let pixel = |file: &str, x: u32, y: u32| {
        image::open(workspace.path(file))
            .expect("a picture")
            .into_rgb8()
            .get_pixel(x, y)
            .0
            .map(u32::from)
            .iter()
            .sum::<u32>()
    };
    // Lit all day; in the plate's shadow from the east, two metres to the west; the plate itself.
    let (open, shadow, plate) = (pixel("day.png", 8, 4), pixel("day.png", 7, 16), pixel("day.png", 16, 16));
    assert!(open > shadow + 50 && plate > shadow + 50, "{open}, {shadow}, {plate}");
    assert!(pixel("night.png", 8, 4) < shadow);
    workspace.run("render plate.toml --suns day.csv --undecided -o a.png").fails(2, &["--undecided", "--suns"]);
}
