use proptest::prelude::*;
use serde_json::json;

use super::*;

/// What the reference makes of a stream.
struct Vector {
    name: &'static str,
    view: MeshoptView,
    stream: Vec<u8>,
    decoded: Vec<u8>,
}

fn vectors() -> Vec<Vector> {
    let lines = include_str!("vectors.txt").lines().filter(|line| !line.starts_with('#'));
    lines.map(vector).collect()
}

fn vector(line: &'static str) -> Vector {
    let words: Vec<&str> = line.split(' ').collect();
    let number = |word: &str| word.parse::<usize>().expect("a number");
    let bytes = |word: &str| -> Vec<u8> {
        let byte = |i: usize| u8::from_str_radix(&word[2 * i..2 * i + 2], 16).expect("two digits");
        (0..word.len() / 2).map(byte).collect()
    };
    let view = json!({
        "buffer": 0, "byteLength": words[5].len() / 2, "mode": words[1], "filter": words[2],
        "count": number(words[3]), "byteStride": number(words[4]),
    });
    let view = serde_json::from_value(view).expect("a view");
    Vector { name: words[0], view, stream: bytes(words[5]), decoded: bytes(words[6]) }
}

#[test]
fn streams_of_the_reference_are_read() {
    for Vector { name, view, stream, decoded } in vectors() {
        let ours = decode(&stream, &view).unwrap_or_else(|message| panic!("{name}: {message}"));
        match (view.filter, view.byte_stride) {
            (MeshoptFilter::None | MeshoptFilter::Exponential, _) => assert_eq!(ours, decoded, "{name}"),
            // Within one unit, which is what the specification grants.
            (_, 4) => assert!(near(&ours, &decoded, |b| i32::from(b[0]), 1), "{name}: {ours:?} {decoded:?}"),
            _ => assert!(near(&ours, &decoded, |b| i32::from(u16::from_le_bytes([b[0], b[1]])), 2), "{name}"),
        }
    }
}

/// Whether components of `size` bytes differ by one at most, around the border of signs too.
fn near(a: &[u8], b: &[u8], value: fn(&[u8]) -> i32, size: usize) -> bool {
    let turns = 1 << (8 * size);
    let close = |(a, b): (&[u8], &[u8])| [0, 1, turns - 1].contains(&(value(a) - value(b)).rem_euclid(turns));
    a.len() == b.len() && a.chunks_exact(size).zip(b.chunks_exact(size)).all(close)
}

/// The sixteen four-bit codes that the specification works out by hand.
#[test]
fn the_example_of_the_specification() {
    let bytes = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
    let steps = [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0_i8];
    // One block of 16 elements of 4 bytes: the first byte has a group of four bits, the others none.
    let mut stream = vec![0xa0, 2];
    stream.extend(bytes);
    stream.extend([0; 3 + 32]);
    let view = json!({ "buffer": 0, "byteLength": 0, "byteStride": 4, "count": 16, "mode": "ATTRIBUTES" });
    let elements = decode(&stream, &serde_json::from_value(view).expect("a view")).expect("decodes");
    let sums = steps.iter().scan(0_u8, |sum, &step| {
        *sum = sum.wrapping_add_signed(step);
        Some([*sum, 0, 0, 0])
    });
    assert_eq!(elements, sums.flatten().collect::<Vec<u8>>());
}

#[test]
fn streams_of_another_length_are_refused() {
    for Vector { name, view, stream, .. } in vectors() {
        for length in 0..stream.len() {
            assert!(decode(&stream[..length], &view).is_err(), "{name}: {length} of {} bytes", stream.len());
        }
        let longer = [&stream[..1], &[0], &stream[1..]].concat();
        assert!(decode(&longer, &view).is_err(), "{name}: a byte more");
    }
}

#[test]
fn views_that_break_the_rules_are_refused() {
    let refused = |change: &[(&str, serde_json::Value)]| {
        let mut view = json!({ "buffer": 0, "byteLength": 0, "byteStride": 4, "count": 6, "mode": "ATTRIBUTES" });
        change.iter().for_each(|(key, value)| view[*key] = value.clone());
        let view: MeshoptView = serde_json::from_value(view).expect("a view");
        check(&view).expect_err("refused")
    };
    for stride in [0, 3, 260, usize::MAX] {
        assert!(refused(&[("byteStride", json!(stride))]).contains("stride"));
    }
    assert!(refused(&[("byteStride", json!(12)), ("filter", json!("OCTAHEDRAL"))]).contains("stride"));
    assert!(refused(&[("byteStride", json!(4)), ("filter", json!("QUATERNION"))]).contains("stride"));
    assert!(refused(&[("byteStride", json!(8)), ("mode", json!("INDICES"))]).contains("stride"));
    assert!(refused(&[("count", json!(7)), ("mode", json!("TRIANGLES"))]).contains("whole number"));
    assert!(refused(&[("mode", json!("TRIANGLES")), ("filter", json!("COLOR"))]).contains("no filter"));
}

#[test]
fn what_was_not_given_yet_cannot_be_asked_for() {
    let stream = |codes: &[u8]| [&[0xe1], codes, &[0; 16]].concat();
    assert!(indices::triangles(&stream(&[0x00]), 3).expect_err("no edge").contains("not given yet"));
    assert!(indices::triangles(&stream(&[0xfe, 0x90]), 3).expect_err("no vertex").contains("not given yet"));
    assert_eq!(indices::triangles(&stream(&[0xf0, 0x10]), 6), Ok(vec![0, 1, 2, 2, 1, 3].into_iter().collect()));
    let table = [&[0xe1, 0xf0][..], &[0xf0], &[0; 15]].concat();
    assert!(indices::triangles(&table, 3).expect_err("a table").contains("table"));
}

/// A stream cannot claim more than it could hold: nothing of that size is ever allocated.
#[test]
fn large_claims_end_at_once() {
    let most = usize::MAX / 768 * 3;
    assert!(indices::triangles(&[0xe1; 100], most).is_err());
    assert!(indices::sequence(&[0xd1; 100], most).is_err());
    assert!(attributes::decode(&[0xa0; 100], most, 256).is_err());
    assert!(attributes::decode(&[0xa1; 1000], most, 4).is_err());
}

proptest! {
    /// Streams with some bytes changed are decoded to the length that was asked for, or refused.
    #[test]
    fn changed_streams_are_survived(
        which in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..5),
    ) {
        let vectors = vectors();
        let Vector { view, stream, decoded, .. } = which.get(&vectors);
        let (mut stream, length) = (stream.clone(), stream.len());
        changes.iter().for_each(|(at, value)| stream[at.index(length)] = *value);
        if let Ok(elements) = decode(&stream, view) {
            prop_assert_eq!(elements.len(), decoded.len());
        }
    }
}
