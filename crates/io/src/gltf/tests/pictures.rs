//! Pictures that nothing decodes.

use super::{
    rules::{told, with},
    *,
};
use crate::picture::tests::jpeg;

/// A PNG of one pixel.
const PNG: &str = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";

fn png() -> Vec<u8> {
    base64::engine::general_purpose::STANDARD.decode(PNG).expect("base64")
}

#[test]
fn pictures_are_what_their_types_say() {
    let of = |stated: &str, bytes: &[u8]| {
        told(|document, data| {
            data.add(bytes, 5121, "SCALAR", bytes.len(), false);
            data.accessors.pop();
            document["extensionsUsed"] = json!(["EXT_texture_webp"]);
            document["images"] = json!([{ "bufferView": data.views.len() - 1, "mimeType": stated }]);
        })
    };
    let (png, jpeg) = (png(), jpeg());
    for (stated, bytes) in
        [("image/png", &png), ("image/jpeg", &jpeg), ("image/webp", &b"RIFF....WEBP".to_vec()), ("image/x", &png)]
    {
        assert_eq!(of(stated, bytes), "", "{stated}");
    }
    assert!(of("image/png", &jpeg).contains("image 0: its mimeType is image/png, its bytes are image/jpeg"));
    assert!(of("image/jpeg", &png).contains("image 0: its mimeType is image/jpeg, its bytes are image/png"));
    let within = |kind: &str, content: &str| with("images", json!([{ "uri": format!("data:{kind},{content}") }]));
    let written: String = png.iter().map(|byte| format!("%{byte:02x}")).collect();
    let (packed, written) = (PNG, written.as_str());
    for (kind, content) in
        [("image/png;base64", packed), ("image/png", written), ("application/octet-stream;base64", packed)]
    {
        assert_eq!(within(kind, content), "", "{kind}");
    }
    assert!(
        within("image/jpeg;base64", packed)
            .contains("image 0: its data URI's type is image/jpeg, its bytes are image/png")
    );
    assert!(within("IMAGE/PNG", "hello").contains("data URI's type is image/png, its bytes are no picture"));
    assert!(
        within("image/png", "hello").contains("image 0: its data URI's type is image/png, its bytes are no picture")
    );
}

#[test]
fn pictures_that_nothing_reads_are_there() {
    let found = |uri: &str| with("images", json!([{ "uri": uri }]));
    for elsewhere in ["https://example.invalid/a.png", &format!("data:image/png;base64,{PNG}")] {
        assert_eq!(found(elsewhere), "", "{elsewhere}");
    }
    for missing in ["nowhere.png", "data:image/png;base64,!!!!"] {
        let found = found(missing);
        assert!(found.starts_with("unused: ") && !found.contains('\n'), "{found}");
    }
}

#[test]
fn pictures_that_are_cut_off_are_told() {
    let in_view = |bytes: &[u8], kind: &str| {
        told(|document, data| {
            data.add(bytes, 5121, "SCALAR", bytes.len(), false);
            data.accessors.pop();
            document["images"] = json!([{ "bufferView": data.views.len() - 1, "mimeType": kind }]);
        })
    };
    let in_uri = |bytes: &[u8], kind: &str| {
        let encoded = base64::engine::general_purpose::STANDARD.encode(bytes);
        with("images", json!([{ "uri": format!("data:{kind};base64,{encoded}") }]))
    };
    for (bytes, kind, fault) in [
        (png(), "image/png", "unused: image 0: its PNG is cut off or broken"),
        (jpeg(), "image/jpeg", "unused: image 0: its JPEG is cut off or broken"),
    ] {
        let short = &bytes[..bytes.len() - 1];
        assert_eq!([in_view(short, kind), in_uri(short, kind)], [fault; 2]);
        let longer = [&bytes[..], &[0; 3]].concat();
        assert_eq!([in_view(&bytes, kind), in_uri(&longer, kind)], [""; 2]);
    }
}
