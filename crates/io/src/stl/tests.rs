use super::*;

const FACET: &str = "facet normal 0 0 1\nouter loop\nvertex 0 0 0.1\nvertex 1 0 0\nvertex 0 1 9\nendloop\nendfacet\n";

fn parse(bytes: &[u8]) -> Result<Model, LoadProblem> {
    read(bytes, "part", &Reading { up_is_stated: true, ..Reading::default() })
}

fn mesh(model: &Model, object: usize) -> &Mesh {
    match &model.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("not a mesh: {other:?}"),
    }
}

fn binary(header: &str, count: u32, triangles: &[[f32; 9]]) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend(count.to_le_bytes());
    for corners in triangles {
        bytes.extend([0.0_f32; 3].iter().chain(corners).flat_map(|number| number.to_le_bytes()));
        bytes.extend([7, 9]);
    }
    bytes
}

const CORNERS: [f32; 9] = [0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 1.0, 9.0];

#[test]
fn text_is_read_as_f64() {
    let text = format!("solid a thing\n{FACET}{FACET}endsolid a thing\nSOLID\r\n{}ENDSOLID", FACET.to_uppercase());
    let model = parse(text.as_bytes()).expect("loads");
    let names: Vec<&str> = model.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["a thing", "part"]);
    assert_eq!(mesh(&model, 0).triangles(), [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh(&model, 0).positions()[0].to_array(), [0.0, 0.0, 0.1]);
    assert_eq!(model.families.roots.len(), 2);
    assert!(model.findings.into_list().is_empty());
}

#[test]
fn binary_files_may_begin_like_text() {
    for header in ["solid thing", "exported", " solid"] {
        let model = parse(&binary(header, 2, &[CORNERS; 2])).expect("loads");
        assert_eq!(mesh(&model, 0).triangles().len(), 2);
        assert_eq!(mesh(&model, 0).positions()[2].to_array(), [0.0, 1.0, 9.0]);
        assert_eq!(mesh(&model, 0).positions()[0].z, f64::from(0.1f32));
        assert!(model.findings.into_list().is_empty(), "{header}");
    }
}

#[test]
fn what_changes_no_surface_is_told() {
    let text = format!("solid\n{}endsolid\n", FACET.replace("normal 0", "normal -nan(ind)"));
    let found = parse(text.as_bytes()).expect("loads").findings.into_list();
    assert_eq!((found[0].kind, found[0].places[0].as_str()), (FindingKind::BrokenRule, "line 2"));
    for short in ["normal", "normal 0 0", "normal x"] {
        let found = parse(text.replace("normal -nan(ind) 0 1", short).as_bytes()).expect("loads").findings.into_list();
        assert_eq!((found[0].kind, found[0].places[0].as_str()), (FindingKind::BrokenRule, "line 2"));
    }
    let mut bytes = binary("", 1, &[CORNERS]);
    bytes.push(0);
    let found = parse(&bytes).expect("loads").findings.into_list();
    assert_eq!((found[0].kind, found[0].places[0].as_str()), (FindingKind::BrokenRule, "byte 134"));
}

#[test]
fn normals_that_are_no_numbers_are_told() {
    let mut bytes = binary("", 2, &[CORNERS; 2]);
    bytes[HEADER + TRIANGLE..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let found = parse(&bytes).expect("loads").findings.into_list();
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].kind, found[0].places[0].as_str()), (FindingKind::BrokenRule, "triangle 1"));
}

#[test]
fn text_may_stand_on_one_line() {
    let line = |text: &str| text.replace('\n', " ");
    let text =
        format!("solid Solid facet\n{FACET}endsolid Solid facet\nsolid\n{FACET}endsolid\nsolid b\n{FACET}endsolid b");
    for text in [line(&text), text] {
        let model = parse(text.as_bytes()).expect("loads");
        let names: Vec<&str> = model.objects.iter().map(|object| object.name.as_str()).collect();
        assert_eq!(names, ["Solid facet", "part", "b"], "{text}");
        assert!(model.findings.into_list().is_empty());
    }
    let message =
        parse(line(&format!("solid a\n{FACET}endsolid a\n{FACET}")).as_bytes()).expect_err("refused").to_string();
    assert!(message.contains("\"facet\" where \"solid\""), "{message}");
    // Squares of this count take minutes.
    let many = line(&format!("solid a\n{FACET}endsolid a\n")).repeat(100_000);
    assert_eq!(parse(many.as_bytes()).expect("loads").objects.len(), 100_000);
}

#[test]
fn text_may_end_in_zero_bytes() {
    let text = format!("solid a\n{FACET}endsolid a");
    for (end, zero) in [("\0", Some(0)), ("\n\0\0\n", Some(1)), ("\u{1a}", None), ("\u{1a}\0\0", Some(1))] {
        for begin in ["", "\u{feff}"] {
            let model = parse(format!("{begin}{text}{end}").as_bytes()).expect("loads");
            assert_eq!(model.objects.len(), 1);
            let places: Vec<_> = model.findings.into_list().into_iter().flat_map(|finding| finding.places).collect();
            let expected = zero.map(|zero| format!("byte {}", begin.len() + text.len() + zero));
            assert_eq!(places, Vec::from_iter(expected), "{end:?}");
        }
    }
}

#[test]
fn the_ends_of_the_range_are_read() {
    let text = format!("solid\n{}endsolid\n", FACET.replace("0 1 9", "-1.6e60 6.3e-61 0"));
    let model = parse(text.as_bytes()).expect("loads");
    assert!(mesh(&model, 0).positions().iter().any(|position| position.to_array() == [-1.6e60, 6.3e-61, 0.0]));
}

#[test]
fn long_names_are_cut() {
    let long = "ä".repeat(100_000);
    let model = parse(format!("solid {long}\n{FACET}endsolid {long}\n").as_bytes()).expect("loads");
    assert_eq!(model.objects[0].name.chars().count(), 200);
}

#[test]
fn exponents_of_fortran_are_read_and_told() {
    let text = format!("solid\n{}endsolid\n", FACET.replace("vertex 1 0 0", "vertex 1.0D+00 0d0 0"));
    let model = parse(text.as_bytes()).expect("loads");
    assert!(mesh(&model, 0).positions().iter().any(|position| position.to_array() == [1.0, 0.0, 0.0]));
    let found = model.findings.into_list();
    assert_eq!((found[0].kind, found[0].count), (FindingKind::BrokenRule, 2));
}

#[test]
fn ends_are_written_in_many_ways() {
    for (end, told) in [("endsolid", 0), ("end solid a", 1), ("ENDSOLID a b", 0), ("EndSolidA b", 1), ("", 1)] {
        let model = parse(format!("\u{feff}solid a\n{FACET}{end}\n").as_bytes()).expect("loads");
        assert_eq!((model.objects.len(), model.findings.into_list().len()), (1, told), "{end}");
    }
    let in_words = FACET.replace("endloop", "end loop").replace("endfacet", "end FACET");
    let model =
        parse(format!("solid a\n{in_words}{in_words}endsolida\nsolid b\n{FACET}endsolid").as_bytes()).expect("loads");
    let found = model.findings.into_list();
    assert_eq!(model.objects.len(), 2);
    assert_eq!(found.iter().map(|finding| finding.count).sum::<usize>(), 5, "{found:?}");
}

#[test]
fn faults_name_their_place() {
    let mut not_finite = CORNERS;
    not_finite[4] = f32::INFINITY;
    let cut = format!("solid a\n{FACET}");
    for (bytes, words) in [
        (binary("", u32::MAX, &[CORNERS]), "tells of 214748364834 bytes, the file has 134"),
        (binary("solid", 2, &[CORNERS]), "tells of 184 bytes, the file has 134"),
        (binary("", 1, &[not_finite]), "solid \"part\", triangle 0: coordinate y of corner 1 is not finite"),
        (format!("# made by\n{cut}endsolid").into_bytes(), "neither text that begins with \"solid\", nor as long as"),
        (cut.replace("1 0 0", "1 0").into_bytes(), "line 5: 3 numbers expected, found 2"),
        (b"so".to_vec(), "84 bytes at the least"),
        (b"solid a\n".to_vec(), "line 2: the file ends where \"facet\" or \"endsolid\" is expected"),
        (format!("{cut}end").into_bytes(), "line 9: the file ends where \"solid\" is expected"),
        (format!("{cut}endsolid\nfacet").into_bytes(), "line 10: \"facet\" where \"solid\" is expected"),
        (cut.replace("1 9", "1 nan").into_bytes(), "line 6: \"nan\" is not a finite number"),
        (cut.replace("1 9", "1 1e61").into_bytes(), "triangle 0: coordinate z of corner 2 is larger than 2^200"),
        (cut.replace("1 9", "-1e-61 9").into_bytes(), "triangle 0: coordinate y of corner 2 is smaller than 2^-200"),
        (cut.replace("endloop", "vertex 0 0 0").into_bytes(), "line 7: \"vertex\" where \"endloop\" is expected"),
        (cut.replace("vertex 1 0 0\n", "").into_bytes(), "line 6: \"endloop\" where \"vertex\" is expected"),
    ] {
        let message = parse(&bytes).expect_err(words).to_string();
        assert!(message.contains(words), "{message}\n{words}");
    }
}

proptest::proptest! {
    /// Any bytes are read or refused; nothing panics.
    #[test]
    fn any_bytes_are_survived(text in "(facet|normal|outer|loop|vertex|endloop|endfacet|endsolid|solid|0|1|\n| ){0,80}",
                              bytes in proptest::collection::vec(0u8.., 0..200)) {
        let _ = parse(format!("solid {text}").as_bytes());
        let _ = parse(&bytes);
    }
}

#[test]
fn words_of_content_in_names_are_names() {
    let texts = [
        format!("solid facet normal test\n{FACET}endsolid facet normal test\n"),
        format!("solid s {FACET} endsolid solid b {FACET} endsolid b").replace('\n', " "),
    ];
    for (text, solids) in texts.iter().zip([1, 2]) {
        let model = parse(text.as_bytes()).expect("a good file");
        assert_eq!(model.objects.len(), solids, "{text}");
    }
}
