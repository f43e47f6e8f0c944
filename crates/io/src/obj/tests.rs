use umbriel_scene::{FamilyTree, FindingKind};

use super::*;
use crate::{folder::Folder, options::Outside};

fn parse(text: &str) -> Result<Model, LoadProblem> {
    let folder = Folder::of_scene(std::path::Path::new("nowhere/scene.obj"), Outside::Refused);
    read(text.as_bytes(), "scene", &folder, &Reading { lightmap_set: Some(1), ..Reading::default() })
}

fn model(text: &str) -> Model {
    parse(text).unwrap_or_else(|problem| panic!("{problem}"))
}

fn names(model: &Model) -> Vec<&str> {
    model.objects.iter().map(|object| object.name.as_str()).collect()
}

fn mesh(model: &Model, object: usize) -> &Mesh {
    match &model.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("not a mesh: {other:?}"),
    }
}

fn findings(model: Model) -> Vec<(FindingKind, String, usize)> {
    model.findings.into_list().into_iter().map(|found| (found.kind, found.subject, found.count)).collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// The faults, each with its line.
fn fault(text: &str) -> (usize, String) {
    match parse(text) {
        Err(LoadProblem::Text { line, message, .. }) => (line, message),
        other => panic!("{text}: {other:?}"),
    }
}

#[test]
fn loose_ways_of_writing_are_read() {
    let text = "v 0 0 0#corner\nv 1 0 0 # one\nv 0 1 1\no plate #1\nf 1 2 3\n\u{1a}";
    let model = model(text);
    assert_eq!(names(&model), ["plate #1"]);
    assert_eq!(findings(model), []);
}

#[test]
fn corners_that_end_in_slashes_are_read_and_told() {
    for corners in ["1// 2// 3//", "1/ 2/ 3/"] {
        let model = model(&format!("v 0 0 0\nv 1 0 0\nv 0 1 1\nf {corners}\n"));
        assert_eq!(mesh(&model, 0).triangles(), [[0, 1, 2]]);
        let told = "f, l or p: a slash at the end of a corner".to_owned();
        assert_eq!(findings(model), [(FindingKind::BrokenRule, told, 1)]);
    }
}

#[test]
fn what_follows_positions_is_told_where_it_is_none_of_the_formats() {
    let told = |rest: &str| findings(model(&format!("v 0 0 0{rest}\nv 1 0 0\nv 0 1 1\nf 1 2 3\n")));
    for rest in ["", " 1", " 2.5", " 1 0 0", " 1 0 0 0", " 1 1 0 0"] {
        assert_eq!(told(rest), [], "{rest}");
    }
    for (rest, words) in [(" 0", "a weight of 0"), (" 4 5", "not a weight"), (" 1 1 1 1 1", "not a weight")] {
        let found = told(rest);
        assert!(matches!(&found[..], [(FindingKind::BrokenRule, told, 1)] if told.contains(words)), "{found:?}");
    }
}

#[test]
fn white_space_that_only_some_readers_know_is_told() {
    let told = |face: &str| findings(model(&format!("o a\u{a0}b\nv 0 0 0\nv 1 0 0\nv 0 1 1\n{face}\n")));
    for plain in ["f 1 2 3", "f\t1\t2   3 # \u{a0}"] {
        assert_eq!(told(plain), [], "{plain}");
    }
    for odd in ["f 1\u{a0}2 3", "f\u{a0}1 2 3", "\u{a0}f 1 2 3"] {
        let found = told(odd);
        let is_told = matches!(&found[..], [(FindingKind::BrokenRule, told, 1)] if told.starts_with("white space"));
        assert!(is_told, "{odd}: {found:?}");
    }
}

#[test]
fn text_of_no_known_encoding_is_told_by_its_line() {
    let folder = Folder::of_scene(std::path::Path::new("scene.obj"), Outside::Refused);
    let bytes = b"v 0 0 0\nv 1 0 0\nv 0 1 1\no t\xe4st\nf 1 2 3\n";
    let found = read(bytes, "scene", &folder, &Reading::default()).expect("loads").findings.into_list();
    let told: Vec<_> = found.iter().map(|found| (found.kind, found.places.join(", "))).collect();
    assert_eq!(told, [(FindingKind::BrokenRule, "line 4".to_owned())]);
}

#[test]
fn an_object_is_its_o_else_its_g_else_the_file() {
    let text = format!(
        "{SQUARE}f 1 2 3\ng wall\nf 1 2 3\ng roof\nf 1 2 3\ng wall\nusemtl red\nf 1 3 4\n\
         o house\nf 1 2 3\ng door\nusemtl blue\nf 1 2 4\no empty\no house\nf 1 2 3\n"
    );
    let model = model(&text);
    assert_eq!(names(&model), ["scene", "wall", "roof", "house", "house"]);
    assert_eq!(mesh(&model, 1).triangles().len(), 2, "a group that comes up again goes on");
    assert_eq!(mesh(&model, 3).triangles().len(), 2, "neither a group nor a material cuts an object");
    let door =
        |tree: &FamilyTree| tree.families.iter().map(|f| (f.name.clone(), f.members.clone())).collect::<Vec<_>>();
    assert_eq!(door(&model.families), [("door".to_owned(), vec![Member::Object(4)])]);
    assert_eq!(model.families.roots.len(), 5);
}

#[test]
fn groups_over_objects_are_families() {
    let text = format!("{SQUARE}g street\no a\nf 1 2 3\no b\nf 1 2 3\ng\no c\nf 1 2 3\n");
    let families = model(&text).families;
    assert_eq!(families.families.len(), 1);
    assert_eq!(families.families[0].members, [Member::Object(0), Member::Object(1)]);
    assert_eq!(families.roots, [Member::Family(0), Member::Object(2)]);
}

#[test]
fn numbers_are_f64_and_every_index_form_is_read() {
    let text = "v 0.1 85012.343 -0\nv 1e0 0 0 1\nv 0 1 0 0.5 0.5 0.5\nvt 0 0\nvn 0 0 1\n\
                f 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 2/-1/-1 -1/1/1 # remark\nf -3 -2 -1\n";
    let model = model(text);
    assert_eq!(mesh(&model, 0).triangles(), [[0, 1, 2]; 5]);
    assert_eq!(mesh(&model, 0).positions()[0].to_array(), [0.1, 85012.343, 0.0]);
    assert!(mesh(&model, 0).positions()[0].z.is_sign_positive());
}

#[test]
fn line_ends_continuations_and_remarks() {
    let text = "\u{feff}# a path C:\\\r\nv 0 0 0\r\nv 1 0 \\\r\n 0\r\nv 0 1 0\r\n\r\n  f 1 \\\n 2 \\\n 3\r\n";
    assert_eq!(mesh(&model(text), 0).triangles(), [[0, 1, 2]]);
    assert_eq!(fault("v 0 0 0\nv 1 \\\n x 0\n").0, 2, "a continued statement is told by its first line");
    for end in ["f 1 2 3 # C:\\", "f 1 2 \\\n 3 # C:\\", "f 1 2 3#C:\\"] {
        let text = format!("{SQUARE}{end}\nf 1 3 4\n");
        assert_eq!(mesh(&model(&text), 0).triangles(), [[0, 1, 2], [0, 2, 3]], "{end}");
    }
}

#[test]
fn numbers_that_are_none_are_no_remarks() {
    for number in ["1.#INF", "-1.#IND", "1.#QNAN00", "1.#inf"] {
        let (line, message) = fault(&format!("{SQUARE}v 0 0 {number}\n"));
        assert!(line == 5 && message.contains(number) && message.ends_with("is not a number"), "{message}");
    }
    assert_eq!(fault("v 0 0#1\n").1, "3 numbers expected, found 2");
    assert_eq!(mesh(&model("v 0. 0. 0.#index 5\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), 0).positions().len(), 3);
    let normal = findings(model(&format!("{SQUARE}vn 0 0 1.#QNAN\nf 1 2 3\n")));
    assert!(normal.contains(&(FindingKind::BrokenRule, "vn: not three numbers".to_owned(), 1)), "{normal:?}");
}

#[test]
fn indices_may_look_ahead() {
    let text = format!("f 1 2 3\n{SQUARE}");
    assert_eq!(mesh(&model(&text), 0).triangles().len(), 1);
    assert_eq!(fault(&format!("f 1 2 5\n{SQUARE}")), (1, "index 5 is out of range: there are 4 vertices".to_owned()));
}

#[test]
fn concave_and_non_planar_polygons() {
    let arrow = "v 0 0 0\nv 2 -1 0\nv 0 3 0\nv -2 -1 0\nf 1 2 3 4\nf 4 3 2 1\n";
    let loaded = model(arrow);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|corner| mesh(&loaded, 0).positions()[corner as usize]);
        (b - a).cross(c - a).z
    };
    let areas: Vec<_> = mesh(&loaded, 0).triangles().iter().map(area).collect();
    assert!(areas[..2].iter().all(|&area| area > 0.0) && areas[2..].iter().all(|&area| area < 0.0), "{areas:?}");
    assert_eq!(areas[0] + areas[1], 12.0);
    let bent = format!("{SQUARE}v 0 1 1\nf 1 2 3 5\nf 1 2 3 4\n");
    assert_eq!(findings(model(&bent)), [(FindingKind::NonPlanarPolygons, String::new(), 1)]);
}

#[test]
fn what_is_not_read_is_told() {
    let text = format!(
        "mtllib there is.mtl\n{SQUARE}s off\nusemtl x\nf 1 2 3\np 1 2\nl 1 2 3\nl 2 3\nsurf 0 1 0 1 1 2 3 4\nwobble 3\n"
    );
    let expected = [
        (FindingKind::UnknownExtension, "surf".to_owned(), 1),
        (FindingKind::UnknownExtension, "wobble".to_owned(), 1),
        (FindingKind::NotTriangles, String::new(), 3),
        (FindingKind::MissingMaterials, "there is.mtl".to_owned(), 1),
    ];
    let mut found = findings(model(&text));
    // A square in the xy plane is as flat along z as can be.
    found.retain(|finding| finding.0 != FindingKind::LooksZUp);
    assert_eq!(found, expected);
}

#[test]
fn flat_along_z_looks_z_up() {
    let kinds = |text: &str, stated: bool| {
        let folder = Folder::of_scene(std::path::Path::new("scene.obj"), Outside::Refused);
        let model = read(text.as_bytes(), "scene", &folder, &Reading { up_is_stated: stated, ..Reading::default() })
            .expect("loads");
        findings(model).iter().any(|finding| finding.0 == FindingKind::LooksZUp)
    };
    let terrain = "v 0 0 0\nv 100 0 5\nv 0 100 1\nf 1 2 3\n";
    assert!(kinds(terrain, false));
    assert!(!kinds(terrain, true), "the user has said which axis is up");
    assert!(!kinds("v 0 0 0\nv 100 5 0\nv 0 1 100\nf 1 2 3\n", false));
    assert!(!kinds("v 0 0 0\nv 100 0 50\nv 0 100 1\nf 1 2 3\n", false));
}

#[test]
fn faults_name_their_line() {
    for (text, line, part) in [
        ("v 0 0 0\nv 1 nan 0\n", 2, "not a finite number"),
        ("v 0 0 inf\n", 1, "not a finite number"),
        ("v 0 0 1e999\n", 1, "not a finite number"),
        ("v 0 0 1e99\n", 1, "larger than 2^200"),
        ("v 0 0 1.6e60\nv 0 -1e61 0\n", 2, "larger than 2^200"),
        ("v 0 0 6.3e-61\nv 1e-61 0 0\n", 2, "smaller than 2^-200"),
        ("v 0 zero 0\n", 1, "not a number"),
        ("v 0 0\n", 1, "3 numbers"),
    ] {
        let (found, message) = fault(text);
        assert!(found == line && message.contains(part), "{text}: {found}: {message}");
    }
    for (face, part) in [
        ("f 0 1 2", "out of range"),
        ("f -5 1 2", "out of range"),
        ("f 1 2 99", "out of range"),
        ("f 1 2 4294967297", "out of range"),
        ("f 1 2 9999999999999999999", "not an index"),
        ("f 1 2 x", "not an index"),
        ("f 1.5 2 3", "not an index"),
        ("f 1/ /2 3", "not a corner"),
        ("f 1/1/1/1 2 3", "not a corner"),
        ("f 1 2 3//x", "not an index"),
        ("p 99", "index 99 is out of range: there are 4 vertices"),
        ("p 1 0", "out of range"),
        ("l 1 99", "index 99 is out of range: there are 4 vertices"),
        ("l 1 x", "not an index"),
    ] {
        let (line, message) = fault(&format!("{SQUARE}{face}\n"));
        assert!(line == 5 && message.contains(part), "{face}: {line}: {message}");
    }
}

#[test]
fn faults_that_change_no_surface_are_told() {
    let text = format!(
        "{SQUARE}v 0 0 1 1 1 0 nan\nv 1 0 1 1 1 1 1 1\nvn nan nan nan\nvn 0 -1.#IND\nf 1 2\nf 1//1 2 3//2\nf 1 2 3\n"
    );
    let told = model(&text).findings.into_list();
    let told: Vec<_> = told.iter().filter(|found| found.kind == FindingKind::BrokenRule).collect();
    let words: Vec<_> = told.iter().map(|found| (&found.subject[..2], found.count, found.places.join(", "))).collect();
    let lines = |text: &str| text.to_owned();
    let expected = [
        ("f:", 1, lines("line 10")),
        ("f:", 1, lines("line 9")),
        ("v:", 2, lines("line 5, line 6")),
        ("vn", 2, lines("line 7, line 8")),
    ];
    assert_eq!(words, expected);
    assert_eq!(mesh(&model(&text), 0).triangles().len(), 2);
}

#[test]
fn corners_may_name_normals_that_are_not_there() {
    for face in
        ["f 1//1 2//2 3//3", "f 1/1 2/1 3/1", "f 1//-1 2//-1 3//-1", "f 1/0/0 2/0/0 3/0/0", "f 1 2 3\nl 1/1 2/2"]
    {
        for keeps_texture in [false, true] {
            let folder = Folder::of_scene(std::path::Path::new("scene.obj"), Outside::Refused);
            let reading = Reading { lightmap_set: keeps_texture.then_some(0), ..Reading::default() };
            let model = read(format!("{SQUARE}{face}\n").as_bytes(), "scene", &folder, &reading).expect(face);
            assert_eq!(mesh(&model, 0).triangles().len(), 1);
            let found = findings(model);
            let is_told = |found: &(FindingKind, String, usize)| {
                found.0 == FindingKind::BrokenRule && found.1.contains("not there")
            };
            assert!(found.iter().any(is_told), "{face}: {found:?}");
        }
    }
}

#[test]
fn exponents_of_fortran_are_read_and_told() {
    let text = "v 1.5D+00 -2d0 0\nv 1D3 0 0\nv 0 0 1\nf 1 2 3\n";
    let model = model(text);
    assert_eq!(mesh(&model, 0).positions()[..2], [[1.5, -2.0, 0.0], [1000.0, 0.0, 0.0]].map(glam::DVec3::from));
    let told = model.findings.into_list();
    assert!(told.iter().any(|found| found.kind == FindingKind::BrokenRule && found.places == ["line 1", "line 2"]));
    for text in ["v 1d 0 0\n", "v 1d0 d0 0\n", "v 1d999 0 0\n", "v 1d0 0\n"] {
        assert_eq!(fault(text).0, 1, "{text}");
    }
}

#[test]
fn every_material_library_has_to_be_there() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a b.mtl"), "").expect("written");
    std::fs::write(folder.path().join("c.mtl"), "").expect("written");
    let scene = Folder::of_scene(&folder.path().join("scene.obj"), Outside::Refused);
    let found = |line: &str| {
        let text = format!("mtllib{line}\n{SQUARE}f 1 2 3\n");
        let model = read(text.as_bytes(), "scene", &scene, &Reading::default()).expect("loads");
        findings(model).into_iter().filter(|found| found.0 != FindingKind::LooksZUp).map(|found| found.0).collect()
    };
    let missing = vec![FindingKind::MissingMaterials];
    for (line, expected) in [
        (" a b.mtl", Vec::new()),
        (" c.mtl c.mtl", Vec::new()),
        (" c.mtl d.mtl", missing.clone()),
        (" .", missing.clone()),
        ("", vec![FindingKind::BrokenRule]),
    ] {
        let found: Vec<FindingKind> = found(line);
        assert_eq!(found, expected, "{line}");
    }
}

#[test]
fn triangles_of_transparent_materials_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.mtl"), "newmtl glass\nd 0.5\nnewmtl wall\nd 1\nnewmtl unused\nTr 1\n")
        .expect("written");
    let scene = Folder::of_scene(&folder.path().join("scene.obj"), Outside::Refused);
    let text = format!(
        "{SQUARE}f 1 2 3\nusemtl glass\nf 1 2 3 4\nusemtl wall\nf 1 3 4\nusemtl glass\nf 1 2 4\nmtllib a.mtl\n"
    );
    let found = findings(read(text.as_bytes(), "scene", &scene, &Reading::default()).expect("loads"));
    assert!(found.contains(&(FindingKind::BlendAsOpaque, "glass".to_owned(), 3)), "{found:?}");
    assert!(!found.iter().any(|(_, subject, _)| subject == "wall" || subject == "unused"));
}

#[test]
fn a_material_library_is_looked_for_once() {
    let mut parser = Parser::new(false);
    for line in 1..=3 {
        parser.statement("mtllib a b.mtl", line).expect("a statement");
    }
    assert_eq!(parser.libraries.into_iter().collect::<Vec<_>>(), [("a b.mtl".to_owned(), 3)]);
    let found = findings(model(&format!("{SQUARE}f 1 2 3\nmtllib a\nmtllib a b\nmtllib a\n")));
    let missing: Vec<_> = found.iter().filter(|found| found.0 == FindingKind::MissingMaterials).collect();
    assert_eq!(missing.iter().map(|found| (found.1.as_str(), found.2)).collect::<Vec<_>>(), [("a", 2), ("a b", 1)]);
}

#[test]
fn long_names_are_cut() {
    let long = "ä".repeat(100_000);
    let faces = "f 1 2 3\n";
    let model = model(&format!("{SQUARE}g {long}\n{faces}g {long}b\n{faces}o {long}\n{faces}o {long}\n{faces}"));
    let [one, other] = [crate::names::brief_name(&long), crate::names::brief_name(&format!("{long}b"))];
    assert_eq!(names(&model), [&*one, &*other, &*one, &*one]);
    assert_eq!(model.families.families[0].name.chars().count(), 200);
    let far = LoadProblem::element(long, "").in_file(std::path::Path::new("a.obj")).to_string();
    assert!(far.chars().count() < 500, "{far}");
}

#[test]
fn utf_16_and_old_line_ends() {
    let text = format!("o h\u{fc}tte\n{SQUARE}f 1 2 3 4\n").replace('\n', "\r");
    let bytes: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let folder = Folder::of_scene(std::path::Path::new("scene.obj"), Outside::Refused);
    let model = read(&bytes, "scene", &folder, &Reading::default()).expect("loads");
    assert_eq!((names(&model)[0], mesh(&model, 0).triangles().len()), ("h\u{fc}tte", 2));
}

#[test]
fn work_is_linear_in_continuations_and_unnamed_groups() {
    // Squares of these counts would take minutes.
    let continued = format!("{SQUARE}f 1 2 3 {}\n", "\\\n".repeat(300_000));
    assert_eq!(mesh(&model(&continued), 0).triangles().len(), 1);
    let mut groups: String = (0..60_000).map(|number| format!("g {number}\nf 1 2 3\n")).collect();
    groups.push_str(&"g\nf 1 2 3\n".repeat(60_000));
    assert_eq!(names(&model(&format!("{SQUARE}{groups}"))).len(), 60_001);
}

proptest::proptest! {
    /// Any text is read or refused; nothing panics.
    #[test]
    fn any_text_is_survived(text in "(v|f|o|g|l|vt|vn|mtllib|\\\\|#)?[ \\-0-9./a-e\\\\\r\n]{0,60}") {
        let _ = parse(&text);
        let _ = parse(&format!("{SQUARE}{text}\n{text}"));
    }
}

#[test]
fn texture_coordinates_lay_out_light_maps() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvt 1 0.75\nvt 0 1\n\
        f 1/1 2/2 3/3 4/4\nf 1 2 3\no bare\nf 1 2 3\n";
    let model = model(text);
    // v counts from above in a layout, from below in the file.
    let [a, b, c, d] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.25], [0.0, 0.0]];
    let mesh = mesh(&model, 0);
    let place = |triangle: [u32; 3]| triangle.map(|corner| [a, b, c, d][corner as usize]);
    let expected = [place(mesh.triangles()[0]), place(mesh.triangles()[1]), NOWHERE];
    assert_eq!(model.objects[0].lightmap.as_ref().expect("a layout").triangles, expected);
    assert!(model.objects[1].lightmap.is_none());
    // A corner without a place leaves its polygon without one.
    for wrong in ["vt", "vt 1 nan", "vt 1 0 0 0", "vt x"] {
        let model = self::model(&text.replace("vt 1 0.75", wrong));
        assert!(model.objects[0].lightmap.is_none());
        let told = model.findings.into_list().into_iter().find(|found| found.kind == FindingKind::BrokenRule);
        assert_eq!(told.expect("a finding").places, ["line 7"], "{wrong}");
    }
}
