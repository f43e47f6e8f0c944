use super::*;

fn parse(bytes: &[u8]) -> Result<Model, LoadProblem> {
    read(bytes, "part", &Reading { up_is_stated: true, ..Reading::default() })
}

fn mesh(model: &Model) -> &Mesh {
    match &model.objects[0].shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("not a mesh: {other:?}"),
    }
}

/// A header around these lines.
fn header(format: &str, lines: &str) -> String {
    format!("ply\nformat {format} 1.0\ncomment by hand\n{lines}end_header\n")
}

const SQUARE: &str = "element vertex 4\nproperty float x\nproperty double y\nproperty float z\nproperty uchar red\n\
                      element face 1\nproperty uchar flags\nproperty list uchar int vertex_indices\n";

fn text(lines: &str, data: &str) -> Vec<u8> {
    (header("ascii", lines) + data).into_bytes()
}

/// The square in binary.
fn binary(is_big_endian: bool) -> Vec<u8> {
    let name = if is_big_endian { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = header(name, SQUARE).into_bytes();
    let mut put = |number: &[u8]| {
        let ordered: Vec<u8> = if is_big_endian { number.iter().rev().copied().collect() } else { number.to_vec() };
        bytes.extend(ordered);
    };
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 0.1], [0.0, 1.0]] {
        put(&(x as f32).to_le_bytes());
        put(&f64::to_le_bytes(y));
        put(&f32::to_le_bytes(-2.5));
        put(&[255]);
    }
    put(&[9]);
    put(&[4]);
    [0i32, 1, 2, 3].iter().for_each(|corner| put(&corner.to_le_bytes()));
    bytes
}

#[test]
fn all_encodings_agree() {
    let data = "0 0 -2.5 255\n1 0 -2.5 255\n1 0.1 -2.5 255\n0 1 -2.5 255\n9 4 0 1 2 3\n";
    for bytes in [text(SQUARE, data), binary(false), binary(true)] {
        let model = parse(&bytes).expect("loads");
        assert_eq!(mesh(&model).positions()[2].to_array(), [1.0, 0.1, -2.5]);
        assert_eq!(mesh(&model).triangles().len(), 2);
        assert_eq!(model.objects[0].name, "part");
        assert!(model.findings.into_list().is_empty());
    }
    let old = String::from_utf8(text(SQUARE, data)).expect("text").replace('\n', "\r");
    assert_eq!(mesh(&parse(old.as_bytes()).expect("loads")).triangles().len(), 2);
}

#[test]
fn data_behind_lines_that_end_in_cr_may_begin_with_lf() {
    let with = |end: &str| {
        let whole = binary(false);
        let length = Header::read(&whole).expect("a header").length;
        let lines = String::from_utf8_lossy(&whole[..length]).replace('\n', end);
        let mut bytes = [lines.as_bytes(), &whole[length..]].concat();
        bytes[lines.len()] = b'\n';
        bytes
    };
    for end in ["\r", "\r\n", "\n"] {
        let model = parse(&with(end)).unwrap_or_else(|problem| panic!("{end:?}: {problem}"));
        assert_eq!(mesh(&model).positions()[0].x, f64::from(f32::from_le_bytes([b'\n', 0, 0, 0])), "{end:?}");
        assert!(model.findings.into_list().iter().all(|finding| finding.kind != FindingKind::BrokenRule), "{end:?}");
    }
}

#[test]
fn every_type_is_decoded() {
    let lines = "element a 1\nproperty char i\nproperty uchar j\nproperty short k\nproperty ushort l\n\
                 property int m\nproperty uint n\nproperty float o\nproperty double p\n";
    let data = [&[0x80u8, 0x80][..], &[0x01, 0x80], &[0x01, 0x80], &[1, 0, 0, 0x80], &[1, 0, 0, 0x80]].concat();
    let data = [data, 0.5f32.to_le_bytes().to_vec(), (-0.1f64).to_le_bytes().to_vec()].concat();
    let bytes = [header("binary_little_endian", lines).into_bytes(), data].concat();
    let header = Header::read(&bytes).expect("a header");
    let mut found = Vec::new();
    let mut source = Source::new(&header, &bytes[header.length..], "");
    let rows = source.rows(&header.elements[0], &[0], |_, row| {
        found = (0..8).map(|at| row.number(at)).collect();
        Ok(())
    });
    assert!(rows.is_ok() && !source.has_more());
    assert_eq!(found, [-128.0, 128.0, -32767.0, 32769.0, -2147483647.0, 2147483649.0, 0.5, -0.1]);
}

#[test]
fn strips_and_elements_of_any_order() {
    let lines = "element tristrips 1\nproperty list int int vertex_indices\nelement edge 1\nproperty int a\n\
                 element colour 3\nelement vertex 5\nproperty float z\nproperty float y\nproperty float x\n";
    let data = "10 0 1 2 3 -1 2 3 4 4 1\n7\n0 0 0\n0 0 1\n0 1 0\n0 1 1\n0 2 5\n";
    let model = parse(&text(lines, data)).expect("loads");
    assert_eq!(mesh(&model).triangles(), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    assert_eq!(mesh(&model).positions()[4].to_array(), [5.0, 2.0, 0.0]);
    let found: Vec<_> = model.findings.into_list().into_iter().map(|found| (found.kind, found.subject)).collect();
    assert_eq!(
        found,
        [
            (FindingKind::UnknownExtension, "colour".to_owned()),
            (FindingKind::NotTriangles, String::new()),
            (FindingKind::BrokenRule, "element colour: rows without properties".to_owned())
        ]
    );
}

#[test]
fn short_strips_are_told_and_ends_have_no_sign() {
    let lines = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                 element tristrips 1\nproperty list uchar uint vertex_indices\n";
    let data = "0 0 0\n0 0 1\n0 1 0\n0 1 1\n10 0 1 4294967295 4294967295 0 1 2 4294967295 3 4294967295\n";
    let model = parse(&text(lines, data)).expect("loads");
    assert_eq!(mesh(&model).triangles(), [[0, 1, 2]]);
    let found = model.findings.into_list();
    assert_eq!((found[0].subject.as_str(), found[0].count), ("strips of fewer than three corners", 2));
}

#[test]
fn rows_without_properties_are_not_counted() {
    let lines = format!("{SQUARE}element edge {}\n", u64::MAX);
    let data = "0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n0 3 0 1 2\n";
    let found: Vec<_> = parse(&text(&lines, data)).expect("loads").findings.into_list();
    let found: Vec<_> = found.iter().map(|found| (found.kind, found.subject.as_str(), found.count)).collect();
    assert_eq!(found, [(FindingKind::BrokenRule, "element edge: rows without properties", 1)]);
}

#[test]
fn elements_without_rows_need_no_properties() {
    for lines in ["element vertex 0\nelement face 0\n", "element face 0\nproperty int vertex_indices\n"] {
        let model = parse(&text(lines, "")).expect("loads");
        assert!(model.objects.is_empty() && model.findings.into_list().is_empty(), "{lines}");
    }
}

#[test]
fn headers_of_many_names_take_linear_time() {
    // The longest header there may be; squares of these counts take seconds to minutes.
    let elements: String = (0..60_000).map(|number| format!("element {number} 0\n")).collect();
    let elements = parse(&text(&elements, "")).expect("loads");
    assert_eq!(elements.findings.into_list().len(), 60_000);
    let properties: String = (0..45_000).map(|number| format!("property int {number}\n")).collect();
    let properties = parse(&text(&format!("element a 0\n{properties}"), "")).expect("loads");
    assert_eq!(properties.findings.into_list().len(), 1);
}

#[test]
fn what_changes_no_surface_is_told() {
    let lines = SQUARE.replace("face 1", "face 3");
    let model =
        parse(&text(&lines, "0 0 0 1\n1 0 0 1\n1 1 1 1\n0 1 0 1\n0 2 0 1\n0 4 0 1 2 3\n0 0\n8")).expect("loads");
    let found = model.findings.into_list().into_iter().map(|found| (found.kind, found.places));
    let faces = vec!["face 0".to_owned(), "face 2".to_owned()];
    assert_eq!(
        found.collect::<Vec<_>>(),
        [
            (FindingKind::BrokenRule, vec![]),
            (FindingKind::BrokenRule, faces),
            (FindingKind::NonPlanarPolygons, vec!["face 1".to_owned()])
        ]
    );
}

#[test]
fn numbers_are_written_in_many_ways() {
    let lines = SQUARE.replace("int vertex_ind", "float vertex_ind").replace("float x", "uchar x");
    let vertices = "0 0 0 -nan(ind)\n1 1.0 0 1\n1 1 0 1\n0 0 1 1\n";
    let model = parse(&text(&lines, &format!("{vertices}300 3 0 1.0 2\n"))).expect("loads");
    assert_eq!(mesh(&model).triangles(), [[0, 1, 2]]);
    let found: Vec<_> = model.findings.into_list().into_iter().map(|found| (found.kind, found.subject)).collect();
    assert_eq!(
        found,
        [
            (FindingKind::BrokenRule, "element face: indices of a type of floats".to_owned()),
            (FindingKind::BrokenRule, "element face: numbers that are none of their type".to_owned()),
            (FindingKind::BrokenRule, "element vertex: numbers that are none of their type".to_owned())
        ]
    );
}

#[test]
fn types_and_lists_that_the_format_does_not_have_are_told() {
    let lines = SQUARE.replace("property uchar red", "property float nx");
    let second = format!("{lines}property list uchar int vertex_index\n");
    let vertices = "0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n";
    let face = "0 3 0 1 2";
    for (lines, vertices, face, rule) in [
        (lines.replace("uchar int", "uchar double"), vertices, face, "element face: indices of a type of floats"),
        (second, vertices, "0 3 0 1 2 0", "element face: two lists of vertices"),
        (lines.clone(), "0 0 0 1\n1e39 0 0 1\n1 1 0 1\n0 1 0 1\n", face, "element vertex: numbers that are none of"),
        (lines.clone(), vertices, "0 3.0 0 1 2", "element face: numbers that are none of their type"),
        (lines.clone(), vertices, "0 3 0 1e0 2", "element face: numbers that are none of their type"),
        (lines.clone(), "0 0 0 1\n1 0 0 nan\n1 1 0 1\n0 1 0 1\n", face, "element vertex: normals that are no numbers"),
    ] {
        let model = parse(&text(&lines, &format!("{vertices}{face}\n"))).expect("loads");
        assert_eq!(mesh(&model).triangles(), [[0, 1, 2]], "{rule}");
        let found = model.findings.into_list();
        let told: Vec<_> = found.iter().map(|found| (found.kind, found.count)).collect();
        assert_eq!(told, [(FindingKind::BrokenRule, 1)], "{rule}");
        assert!(found[0].subject.starts_with(rule), "{found:?}");
    }
}

#[test]
fn rows_that_are_no_lines_are_told() {
    // Two rows on a line, a row on two lines, and a line that lacks a number, which the next one gives.
    for (data, uneven) in [
        ("0 0 0 1\n\n 1 0 0 1 \r\n1 1 0 1\n0 1 0 1\n0 3 0 1 2", 0),
        ("0 0 0 1 1 0 0 1\n1 1 0 1\n0 1 0 1\n0 3 0 1 2\n", 1),
        ("0 0 0 1\n1 0 0\n1\n1 1 0 1\n0 1 0 1\n0 3 0 1 2\n", 1),
        ("0 0 0 1\n1 0 0\n1 1 0 1\n0 1 0 1 7\n0 3 0 1 2\n", 2),
    ] {
        let found = parse(&text(SQUARE, data)).expect("loads").findings.into_list();
        let told = found.iter().map(|found| (found.kind, found.subject.as_str(), found.count)).collect::<Vec<_>>();
        let expected = [(FindingKind::UnevenRows, "element vertex", uneven)];
        assert_eq!(told, expected[..usize::from(uneven > 0)], "{data}");
    }
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_text() {
    let vertices = "0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n";
    let mut bytes = b"\xef\xbb\xbf".to_vec();
    bytes.extend(text(SQUARE, &format!("{vertices}0 3 0 1 2\n")));
    assert_eq!(mesh(&parse(&bytes).expect("loads")).triangles(), [[0, 1, 2]]);
}

#[test]
fn faults_name_their_place() {
    let vertices = "0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n";
    let huge = |format: &str| header(format, &SQUARE.replace("vertex 4", "vertex 4000000000")).into_bytes();
    let mut cut = binary(true);
    cut.truncate(cut.len() - 1);
    for (bytes, words) in [
        (b"plyformat".to_vec(), "line 1: the first line"),
        (b"ply\nformat ascii 1.0\n".to_vec(), "line 3: the file has no line \"end_header\""),
        (["ply\n", &"comment\n".repeat(1 << 17), "end_header\n"].concat().into_bytes(), "the header is too long"),
        (b"ply\nend_header\n".to_vec(), "line 2: there is no line \"format\""),
        (b"ply\nformat ascii 2.0\n".to_vec(), "line 2: version 2.0"),
        (b"ply\nformat utf 1.0\n".to_vec(), "line 2: \"format utf 1.0\" is no line"),
        (text("property float x\n", ""), "line 4: a property before"),
        (text("element vertex -4\n", ""), "line 4: \"-4\" is not a count"),
        (text("element vertex 1\nproperty half x\n", ""), "line 5: \"half\" is no type"),
        (text("element vertex 1\nproperty list float int x\n", ""), "line 5: the length of a list"),
        (text("element vertex 1\nelement vertex 1\n", ""), "line 5: element vertex is there twice"),
        (text("element vertex 1\nproperty float x\n", "1"), "element vertex: it has no property y"),
        (text("element face 1\nproperty int vertex_indices\n", "1"), "element face: it has no property list"),
        (text(SQUARE, &format!("{vertices}0 3 0 0.5 1")), "line 17: face 0: \"0.5\" is not a whole number"),
        (
            text(&SQUARE.replace("float x", "uchar x"), &vertices.replace("1 1 0", "300 1 0")),
            "line 15: vertex 2: \"300\" is not a whole number of",
        ),
        (
            text(&SQUARE.replace("int vertex_ind", "float vertex_ind"), &format!("{vertices}0 3 0 0.5 1")),
            "face 0: 0.5 is",
        ),
        (huge("ascii"), "element vertex: the header tells of 4000000000 rows"),
        (huge("binary_big_endian"), "element vertex: the header tells of 4000000000 rows"),
        (cut, "face 0: the file ends here"),
        (text(SQUARE, &format!("{vertices}0 9 0 1 2 3")), "line 17: face 0: the file ends here"),
        (text(SQUARE, &format!("{vertices}0 -4 0 1 2 3")), "line 17: face 0: \"-4\" is not a whole number"),
        (text(SQUARE, &format!("{vertices}0 3 0 1 x")), "line 17: face 0: \"x\" is not a whole number"),
        (text(SQUARE, &format!("{vertices}0 3 0 1 4")), "face 0: it names vertex 4, but there are 4"),
        (text(SQUARE, &format!("{vertices}0 3 0 1 -1")), "face 0: it names vertex -1"),
        (
            text(SQUARE, &format!("{}0 3 0 1 2", vertices.replace("1 1 0", "1 nan 0"))),
            "vertex 2: coordinate y is not finite",
        ),
        (
            text(SQUARE, &format!("{}0 3 0 1 2", vertices.replace("1 1 0", "1.6e60 -1e61 0"))),
            "vertex 2: coordinate y is larger than 2^200",
        ),
        (
            text(SQUARE, &format!("{}0 3 0 1 2", vertices.replace("1 1 0", "6.3e-61 1 1e-61"))),
            "vertex 2: coordinate z is smaller than 2^-200",
        ),
    ] {
        let message = parse(&bytes).expect_err(words).to_string();
        assert!(message.contains(words), "{message}\n{words}");
    }
}

proptest::proptest! {
    /// Any bytes behind a header are read or refused; nothing panics.
    #[test]
    fn any_data_is_survived(is_big_endian: bool, data in proptest::collection::vec(0u8.., 0..200), at in 0usize..300) {
        let mut bytes = binary(is_big_endian);
        let at = at.min(bytes.len());
        bytes.splice(at.., data);
        let _ = parse(&bytes);
    }
}
