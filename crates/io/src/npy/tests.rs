use proptest::prelude::*;

use super::*;

/// Files as NumPy 2.4 wrote them; spaces of the headers are put in by `file`.
const BIG_BY_COLUMNS: &[u8] =
    b"?\xf8\x00\x00\x00\x00\x00\x00?\xb9\x99\x99\x99\x99\x99\x9a\xc0\x00\x00\x00\x00\x00\x00\x00\
    ?\xd0\x00\x00\x00\x00\x00\x00B\x1b\xf0\x8e\xb0\x00\x00\x00@\x1c\x00\x00\x00\x00\x00\x00";
const SINGLE: &[u8] = b"\x00\x00\xc0?\x00\x00\x00\xc0v\x84\xdfP\xcd\xcc\xcc=\x00\x00\x80>\x00\x00\xe0@";

/// A file of this version, its header padded to a multiple of 64 bytes.
fn file(version: u8, header: &str, numbers: &[u8]) -> Vec<u8> {
    let wide = if version == 1 { 2 } else { 4 };
    let length = (8 + wide + header.len() + 1).next_multiple_of(64) - 8 - wide;
    let mut bytes = [b"\x93NUMPY".as_slice(), &[version, 0], &(length as u32).to_le_bytes()[..wide]].concat();
    bytes.extend(format!("{header:width$}\n", width = length - 1).bytes());
    bytes.extend(numbers);
    bytes
}

fn read(version: u8, header: &str, numbers: &[u8]) -> Result<NpyPoints, NpyError> {
    read_npy_points(file(version, header, numbers).as_slice())
}

#[test]
fn rows_of_single_numbers() {
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
    let expected = NpyPoints::PositionsSingle(vec![[1.5, -2.0, 3e10], [0.1, 0.25, 7.0]]);
    for version in [1, 2, 3] {
        assert_eq!(read(version, header, SINGLE).expect("points"), expected);
    }
    let (header, six) = ("{\"shape\":(1L,6),'fortran_order':False,'descr':'<f4'}", [1.5, -2.0, 3e10, 0.1, 0.25, 7.0]);
    assert_eq!(read(1, header, SINGLE).expect("points"), NpyPoints::NormalsSingle(vec![six]));
}

#[test]
fn columns_of_double_numbers_the_other_way_round() {
    let header = "{'descr': '>f8', 'fortran_order': True, 'shape': (2, 3), }";
    let expected = NpyPoints::PositionsDouble(vec![[1.5, -2.0, 3e10], [0.1, 0.25, 7.0]]);
    assert_eq!(read(2, header, BIG_BY_COLUMNS).expect("points"), expected);
    let empty = read(1, "{'descr': '<f8', 'fortran_order': False, 'shape': (0, 6), }", &[]).expect("no points");
    assert!(empty.is_empty() && empty == NpyPoints::NormalsDouble(Vec::new()));
}

#[test]
fn what_is_no_table_of_points_is_refused() {
    let of = |descr: &str, shape: &str| format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    for (header, words) in [
        (of("<f4", "(2, 4)"), "shape is [2, 4]"),
        (of("<f4", "(6,)"), "shape is [6]"),
        (of("<f4", "()"), "shape is []"),
        (of("<f4", "(1, 2, 3)"), "shape is [1, 2, 3]"),
        (of("<f4", "(3, 3)"), "36 bytes of numbers, the file has 24"),
        (of("<f4", "(1, 3)"), "12 bytes of numbers, the file has 24"),
        (of("<f4", "(18446744073709551615, 3)"), "the file has 24"),
        (of("<f8", "(18446744073709551615, 18446744073709551615)"), "shape is [18446744073709551615, "),
        (of("<f4", &format!("({})", "0,".repeat(65))), "more than 64 axes"),
        (of(&"f".repeat(100), "(2, 3)"), &format!("type \"{}...\"", "f".repeat(60))),
        (of("<f4", "(18446744073709551616, 3)"), "expected a number"),
        (of("<f4", "(-2, 3)"), "expected a number"),
        (of("<i4", "(2, 3)"), "type \"<i4\""),
        (of("|O", "(2, 3)"), "type \"|O\""),
        (of("é8", "(2, 3)"), "type \"é8\""),
        (of("", "(2, 3)"), "type \"\""),
        ("{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': (2,)}".into(), "expected a string"),
        ("{'descr': '<f4', 'shape': (2, 3)}".into(), "not all there"),
        ("{'descr': '<f4', 'descr': '<f4', 'fortran_order': False, 'shape': (2, 3)}".into(), "twice"),
        ("{'descr': '<f4', 'fortran_order': 0, 'shape': (2, 3)}".into(), "True or False"),
        ("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3)} + {}".into(), "something follows"),
        ("{'colour': 1}".into(), "\"colour\" is not known"),
        ("{'descr".into(), "does not end"),
        ("".into(), "expected \"{\""),
    ] {
        let message = read(1, &header, SINGLE).expect_err("a defect").to_string();
        assert!(message.contains(words), "{header}: {message} should contain {words}");
    }
}

#[test]
fn what_is_no_npy_file_is_refused() {
    let whole = file(1, "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", SINGLE);
    for length in 0..whole.len() {
        assert!(read_npy_points(&whole[..length]).is_err(), "the first {length} bytes");
    }
    assert!(matches!(read_npy_points(&b"PK\x03\x04"[..]), Err(NpyError::NotNpy)));
    assert!(matches!(read_npy_points(&b"\x93NUMPY\x04\x00"[..]), Err(NpyError::Version(4, 0))));
    // A header that says to be longer than the file.
    assert!(matches!(read_npy_points(&b"\x93NUMPY\x02\x00\xff\xff\xff\xff{}"[..]), Err(NpyError::Truncated)));
}

#[test]
fn bytes_are_written_as_numpy_writes_them() {
    let mut bytes = Vec::new();
    write_npy_bytes(2, &[1, 0, 0, 1, 1, 1], &mut bytes).expect("written");
    assert_eq!(bytes, file(1, "{'descr': '|u1', 'fortran_order': False, 'shape': (3, 2), }", &[1, 0, 0, 1, 1, 1]));
    assert_eq!(bytes.len(), 128 + 6);
    assert!(write_npy_bytes(4, &[0; 6], &mut Vec::new()).is_err(), "no whole rows");
    write_npy_bytes(0, &[], &mut Vec::new()).expect("no columns");
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200), cut in 0usize..130, by in any::<u8>()) {
        let _ = read_npy_points([b"\x93NUMPY\x01\x00\x40\x00".as_slice(), &bytes].concat().as_slice());
        let mut file = file(1, "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", SINGLE);
        file[cut] = by;
        let _ = read_npy_points(file.as_slice());
    }
}
