//! Cells and portals on the command line.

use serde_json::Value;

use crate::workspace::Workspace;

/// Two closed rooms side by side with a door between them, a third one without, and a lamp in the first. Walls are as thick as they look.
fn rooms() -> Workspace {
    let mut text = String::from(
        "[[light]]\nname = \"lamp\"\npoint = { position = [1.0, 2.0, 2.0] }\n\
         [camera]\neye = [1.0, 1.5, 2.0]\ntarget = [8.0, 1.0, 2.0]\n\
         [[portal]]\nname = \"door\"\ncells = [\"a\", \"b\"]\ncorners = [[4, 0, 1.5], [4, 0, 2.5], [4, 2, 2.5], [4, 2, 1.5]]\n",
    );
    let mut object = |name: &str, size: [f64; 3], center: [f64; 3]| {
        text += &format!("[[object]]\nname = \"{name}\"\nbox = {{ size = {size:?} }}\ntranslation = {center:?}\n");
    };
    for (number, room) in ["a", "b", "c"].into_iter().enumerate() {
        let x = 4.0 * number as f64 + 2.0;
        object(&format!("floor {room}"), [4.0, 0.25, 4.0], [x, 0.0, 2.0]);
        object(&format!("ceiling {room}"), [4.0, 0.25, 4.0], [x, 3.0, 2.0]);
        object(&format!("south {room}"), [4.0, 3.0, 0.25], [x, 1.5, 0.0]);
        object(&format!("north {room}"), [4.0, 3.0, 0.25], [x, 1.5, 4.0]);
        object(&format!("table {room}"), [1.0, 0.75, 1.0], [x, 0.5, 2.0]);
    }
    for (name, x) in [("west", 0.0), ("middle", 8.0), ("east", 12.0)] {
        object(name, [0.25, 3.0, 4.0], [x, 1.5, 2.0]);
    }
    object("beside the door", [0.25, 3.0, 1.5], [4.0, 1.5, 0.75]);
    object("behind the door", [0.25, 3.0, 1.5], [4.0, 1.5, 3.25]);
    object("lintel", [0.25, 1.0, 1.0], [4.0, 2.5, 2.0]);
    for (number, room) in ["a", "b", "c"].into_iter().enumerate() {
        let x = 4.0 * number as f64;
        text += &format!("[[cell]]\nname = \"{room}\"\nbox = [[{x:?}, 0, 0], [{:?}, 3, 4]]\n", x + 4.0);
    }
    Workspace::with(&[("rooms.toml", &text)])
}

fn names(bake: &Value) -> Vec<&str> {
    let objects = bake["lights"][0]["objects"].as_array().expect("objects");
    objects.iter().filter_map(|object| object["name"].as_str()).collect()
}

#[test]
fn info_prints_the_graph() {
    let text = rooms().run("info rooms.toml").succeeds().stdout();
    for words in ["cells       3, 1 portals", "a: ", "to b by door", "to a by door", "to nowhere"] {
        assert!(text.contains(words), "\"{words}\" is missing in: {text}");
    }
}

#[test]
fn a_bake_leaves_out_what_no_light_reaches() {
    let workspace = rooms();
    let run = workspace.run("bake rooms.toml --json - --boundary-depth 4").succeeds();
    assert!(run.stderr().contains("no light reaches"), "{}", run.stderr());
    let bake: Value = serde_json::from_str(&run.stdout()).expect("JSON");
    let lit = names(&bake);
    assert!(lit.contains(&"table a") && lit.contains(&"table b") && !lit.contains(&"table c"), "{lit:?}");
    let portals = &bake["work"]["portals"];
    assert_eq!((portals["cells"].as_u64(), portals["lights_outside"].as_u64()), (Some(2), Some(0)));
    assert_eq!(portals["objects"].as_u64(), Some(lit.len() as u64));
    assert!(portals["objects_left_out"].as_u64() >= Some(4), "{portals}");
    // Who asks for it gets it: dark.
    let run = workspace.run("bake rooms.toml --json - --boundary-depth 4 --receiver table* --quiet").succeeds();
    let bake: Value = serde_json::from_str(&run.stdout()).expect("JSON");
    assert_eq!(names(&bake), ["table a", "table b", "table c"]);
    assert_eq!(bake["lights"][0]["objects"][2]["lit_area"]["upper"].as_f64(), Some(0.0));
    assert_eq!(bake["work"]["portals"]["receivers_left_out"].as_u64(), Some(1));
}

#[test]
fn a_camera_chooses_receivers() {
    let workspace = rooms();
    let seen = |from: &str| -> Vec<String> {
        let arguments = format!("bake rooms.toml --json - --boundary-depth 2 --quiet --visible-from {from}");
        let bake: Value = serde_json::from_str(&workspace.run(&arguments).succeeds().stdout()).expect("JSON");
        names(&bake).into_iter().map(str::to_owned).collect()
    };
    let through_the_door = seen("scene");
    assert!(through_the_door.iter().any(|name| name == "table b"), "{through_the_door:?}");
    let away = seen("3,1.5,2,0,1.5,2,50");
    assert!(away.iter().any(|name| name == "west") && away.iter().all(|name| name != "table b"), "{away:?}");
    let arguments = "bake rooms.toml --visible-from 9,1,2,11,1,2 --receiver table?a";
    workspace.run(arguments).fails(1, &["no light reaches"]);
}

#[test]
fn a_picture_is_drawn_from_what_the_eye_reaches() {
    let workspace = rooms();
    let plain = String::from_utf8(workspace.read("rooms.toml")).expect("text");
    let (open, _) = plain.split_once("[[cell]]").expect("cells");
    let (lights, rest) = open.split_once("[[portal]]").expect("a portal");
    let (_, objects) = rest.split_once("[[object]]").expect("objects");
    let open = format!("{lights}[[object]]{objects}");
    let bare = Workspace::with(&[("rooms.toml", &open)]);
    for method in ["", " --method scanline"] {
        let arguments = format!("render rooms.toml -o a.png --size 60x40 --boundary-depth 3{method}");
        let run = workspace.run(&arguments).succeeds();
        assert!(run.stderr().contains("objects are drawn; it sees 2 cells through 1 passages"), "{}", run.stderr());
        bare.run(&arguments).succeeds();
        assert_eq!(workspace.read("a.png"), bare.read("a.png"), "the picture is that of the whole scene");
    }
}
