//! MASK and BLEND materials.

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use umbriel_geometry::{
    LightSource, Point,
    blocking::Probe,
    cut_out::{MOST_PLACE, Opacity},
};

use super::*;
use crate::options::Blend;

/// Two by two texels: opaque at the upper left and the lower right, half as much at the upper right.
fn checkers() -> Vec<u8> {
    let mut bytes = Vec::new();
    let pixels = [0, 0, 0, 255, 0, 0, 0, 128, 0, 0, 0, 0, 0, 0, 0, 255];
    PngEncoder::new(&mut bytes).write_image(&pixels, 2, 2, ExtendedColorType::Rgba8).expect("a picture");
    bytes
}

/// A square in the plane y = 0 over (0..1, 0..1), texture coordinates its x and z, with a material of that texture.
fn sheet(change: impl FnOnce(&mut Value, &mut Data)) -> (Value, Data) {
    changed(|document, data| {
        let corners = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        let positions = data.floats(&corners);
        let places = data.floats(&corners.map(|[x, _, z]| [x, z]));
        let indices = data.add(&[0, 1, 2, 0, 2, 3], 5121, "SCALAR", 6, false);
        let picture = checkers();
        data.views.push(json!({ "buffer": 0, "byteOffset": data.bytes.len(), "byteLength": picture.len() }));
        data.bytes.extend(picture);
        document["images"] = json!([{ "bufferView": data.views.len() - 1, "mimeType": "image/png" }]);
        document["samplers"] = json!([{ "magFilter": 9728 }]);
        document["textures"] = json!([{ "source": 0, "sampler": 0 }]);
        document["materials"] = json!([{
            "name": "leaf", "alphaMode": "MASK", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
        }]);
        let attributes = json!({ "POSITION": positions, "TEXCOORD_0": places });
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": 0 });
        document["meshes"][0]["primitives"] = json!([primitive]);
        change(document, data);
    })
}

/// Whether the sheet is opaque at four points, one a texel, row by row.
fn pattern(model: &Model) -> [bool; 4] {
    let mesh = mesh(&model.objects[0]);
    let overhead = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    [[0.25, 0.3], [0.75, 0.3], [0.25, 0.8], [0.75, 0.8]].map(|[x, z]| {
        // The first triangle is below the diagonal.
        let triangle = usize::from(x > z);
        match mesh.opacity(triangle) {
            Opacity::Opaque => return true,
            Opacity::Clear => return false,
            Opacity::Mixed => {}
        }
        let corners = mesh.triangles()[triangle].map(|corner| Point::exact(mesh.positions()[corner as usize]));
        let below = Probe::<umbriel_geometry::Dyadic>::at(glam::DVec3::new(x, -1.0, z));
        mesh.cut_out(triangle).is_none_or(|holes| holes.is_opaque_at(corners.each_ref(), &below, &overhead))
    })
}

fn material(change: impl FnOnce(&mut Value)) -> Model {
    model(sheet(|document, _| change(&mut document["materials"][0])))
}

#[test]
fn textures_cut_out() {
    let sheet = material(|_| ());
    assert_eq!(pattern(&sheet), [true, true, false, true], "128 of 255 is more than a half");
    assert_eq!(found(sheet), []);
}

#[test]
fn factor_cutoff_and_vertex_colour_count() {
    let base = |member: &str, value: Value| {
        pattern(&material(|material| material["pbrMetallicRoughness"][member] = value.clone()))
    };
    assert_eq!(base("baseColorFactor", json!([1, 1, 1, 0.75])), [true, false, false, true]);
    assert_eq!(base("baseColorFactor", json!([1, 1, 1, 0.25])), [false; 4]);
    let cutoff = |value: f64| pattern(&material(|material| material["alphaCutoff"] = json!(value)));
    assert_eq!(cutoff(0.75), [true, false, false, true]);
    assert_eq!(cutoff(0.0), [true; 4]);
    assert_eq!(cutoff(1.0), [true, false, false, true], "alpha at the cutoff is opaque");
    assert_eq!(cutoff(1.5), [false; 4]);
    let coloured = model(sheet(|document, data| {
        let colors = data.add(&[0, 0, 0, 102].repeat(4), 5121, "VEC4", 4, true);
        document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        document["materials"][0]["alphaCutoff"] = json!(0.3);
    }));
    assert_eq!(pattern(&coloured), [true, false, false, true], "102 of 255 of a half is a fifth");
    assert_eq!(found(coloured), []);
}

/// Fractions of 255 that f64 has only nearly, as decimals or as quotients.
#[test]
fn alpha_at_the_cutoff_is_opaque_wherever_it_comes_from() {
    for (alpha, cutoff) in [(51u8, 0.2), (102, 0.4), (153, 0.6), (204, 0.8)] {
        let sheet = |texel: u8, colour: u8, factor: f64, cutoff: f64| {
            let mut bytes = Vec::new();
            let pixels = [texel, texel - 1, texel, texel].map(|alpha| [0, 0, 0, alpha]);
            let encoder = PngEncoder::new(&mut bytes);
            encoder.write_image(pixels.as_flattened(), 2, 2, ExtendedColorType::Rgba8).expect("a picture");
            let picture = base64::engine::general_purpose::STANDARD.encode(bytes);
            pattern(&model(sheet(|document, data| {
                let colors = data.add(&[0, 0, 0, colour].repeat(4), 5121, "VEC4", 4, true);
                document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
                document["images"] = json!([{ "uri": format!("data:image/png;base64,{picture}") }]);
                document["materials"][0]["alphaCutoff"] = json!(cutoff);
                document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, factor]);
            })))
        };
        let all_but_one = [true, false, true, true];
        assert_eq!(sheet(alpha, 255, 1.0, cutoff), all_but_one, "a texel of {alpha}");
        assert_eq!(sheet(alpha, 255, 0.5, cutoff / 2.0), all_but_one, "half a texel of {alpha}");
        assert_eq!(sheet(255, alpha, 1.0, cutoff), all_but_one, "a colour of {alpha}");
        assert_eq!(sheet(255, 255, cutoff, cutoff), all_but_one, "a factor of {alpha} / 255");
    }
}

/// An older extension has its own colour, whose alpha counts in place of the base colour's.
#[test]
fn specular_glossiness_takes_the_place_of_the_base_colour() {
    let with = |extension: Value| {
        material(|material| {
            material["pbrMetallicRoughness"] = json!({ "baseColorFactor": [1, 1, 1, 0.125] });
            material["extensions"] = json!({ "KHR_materials_pbrSpecularGlossiness": extension.clone() });
        })
    };
    let sheet = with(json!({ "diffuseTexture": { "index": 0 } }));
    assert_eq!(pattern(&sheet), [true, true, false, true]);
    assert_eq!(found(sheet), []);
    let factor = with(json!({ "diffuseTexture": { "index": 0 }, "diffuseFactor": [1, 1, 1, 0.75] }));
    assert_eq!(pattern(&factor), [true, false, false, true]);
    let moved = json!({ "index": 0, "extensions": { "KHR_texture_transform": { "offset": [0.5, 0] } } });
    assert_eq!(pattern(&with(json!({ "diffuseTexture": moved }))), [true, true, true, false]);
    assert_eq!(pattern(&with(json!({}))), [true; 4], "its alpha is one where it says nothing");
    let other = material(|material| {
        material["extensions"] = json!({ "KHR_materials_specular": { "specularColorTexture": { "index": 0 } } });
        material["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 0.25]);
    });
    assert_eq!(pattern(&other), [false; 4], "other extensions leave the base colour as it is");
}

#[test]
fn transforms_and_other_sets_move_the_texture() {
    let transform = |transform: Value| {
        let model = material(|material| {
            let texture = &mut material["pbrMetallicRoughness"]["baseColorTexture"];
            texture["extensions"] = json!({ "KHR_texture_transform": transform.clone() });
        });
        pattern(&model)
    };
    assert_eq!(transform(json!({ "offset": [0.5, 0] })), [true, true, true, false]);
    assert_eq!(transform(json!({ "offset": [0, 1], "scale": [1, -1] })), [false, true, true, true], "upside down");
    // A quarter: u' = v, v' = 1 − u. What is met at (u, v) is the texture's (v, 1 − u).
    let quarter = transform(json!({ "offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2 }));
    assert_eq!(quarter, [false, true, true, true]);
    let other = model(sheet(|document, data| {
        let places = data.floats(&[[0.25, 0.75]; 4]);
        document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(places);
        document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = json!(1);
    }));
    assert_eq!(pattern(&other), [false; 4], "all of it is the lower left texel");
}

#[test]
fn what_is_missing_counts_as_one_and_is_told() {
    let told = |change: &dyn Fn(&mut Value)| {
        let model = model(sheet(|document, _| change(document)));
        assert_eq!(pattern(&model), [true; 4]);
        let findings = model.findings.into_list();
        let missing: Vec<_> = findings.iter().filter(|found| found.kind == FindingKind::MissingTexture).collect();
        assert_eq!((missing.len(), missing[0].subject.as_str(), missing[0].count), (1, "leaf", 2));
        missing[0].places.join(", ")
    };
    assert_eq!(told(&|document| document["materials"][0]["pbrMetallicRoughness"] = json!({})), "it has no texture");
    assert!(told(&|document| document["images"][0] = json!({ "uri": "leaf.png" })).contains("leaf.png"));
    assert!(told(&|document| document["images"][0] = json!({ "uri": "../leaf.png" })).contains("folder"));
    assert!(told(&|document| document["images"][0] = json!({ "uri": "https://a.b/leaf.png" })).contains("only files"));
    assert!(told(&|document| document["images"][0] = json!({ "bufferView": 0 })).contains("neither PNG nor JPEG"));
    assert!(told(&|document| document["images"][0] = json!({})).contains("neither a uri"));
    assert!(told(&|document| document["textures"][0] = json!({})).contains("texture 0"));
    let attributes = |document: &mut Value| {
        document["meshes"][0]["primitives"][0]["attributes"].as_object_mut().map(|all| all.remove("TEXCOORD_0"));
    };
    assert!(told(&attributes).contains("coordinates"));
}

#[test]
fn faults_are_told_or_refused() {
    let message = |change: &dyn Fn(&mut Value, &mut Data)| refused(sheet(|document, data| change(document, data)));
    assert!(message(&|document, _| document["textures"][0]["sampler"] = json!(7)).contains("sampler 7"));
    assert!(message(&|document, _| document["textures"][0]["source"] = json!(7)).contains("image 7"));
    let base = "baseColorTexture";
    assert!(
        message(&|document, _| document["materials"][0]["pbrMetallicRoughness"][base]["index"] = json!(7))
            .contains("texture 7")
    );
    let replace = |values: [[f32; 2]; 4]| {
        move |document: &mut Value, data: &mut Data| {
            let places = data.floats(&values);
            document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(places);
        }
    };
    assert!(message(&replace([[f32::NAN, 0.0]; 4])).contains("not finite"));
    let far = model(sheet(replace([[2.0 * MOST_PLACE as f32, 0.0]; 4])));
    assert_eq!(found(far), [(FindingKind::MaskAsOpaque, "node0".to_owned(), 2)]);
    let odd = model(sheet(|document, _| {
        document["samplers"][0] = json!({ "wrapS": 7 });
        document["materials"][0]["alphaCutoff"] = json!(-1);
    }));
    let kinds: Vec<_> = found(odd).into_iter().map(|(kind, subject, _)| (kind, subject)).collect();
    let rule = |text: &str| (FindingKind::BrokenRule, text.to_owned());
    assert_eq!(
        kinds,
        [rule("material 0: its cutoff is below 0"), rule("sampler 0: its filters or wraps are none of glTF's")]
    );
}

#[test]
fn blending_surfaces_block_or_do_not() {
    let glass = || sheet(|document, _| document["materials"][0]["alphaMode"] = json!("BLEND"));
    let blocking = model(glass());
    assert_eq!(pattern(&blocking), [true; 4]);
    assert_eq!(found(blocking), [(FindingKind::BlendAsOpaque, "node0".to_owned(), 2)]);
    let reading = Reading { blend: Blend::Ignore, ..Reading::default() };
    let ignored = parse_with(glass(), &reading).expect("a model");
    assert_eq!(pattern(&ignored), [false; 4]);
    assert_eq!(found(ignored), [(FindingKind::BlendIgnored, "node0".to_owned(), 2)]);
}

#[test]
fn morph_targets_move_textures_and_add_to_colours() {
    let morphed = |weight: f64, target: fn(&mut Data) -> Value| {
        let sheet = model(sheet(|document, data| {
            let colors = data.floats(&[[1.0, 1.0, 1.0, 1.0]; 4]);
            let target = target(data);
            let primitive = &mut document["meshes"][0]["primitives"][0];
            primitive["attributes"]["COLOR_0"] = json!(colors);
            primitive["targets"] = json!([{ "POSITION": primitive["attributes"]["POSITION"] }, target]);
            document["meshes"][0]["weights"] = json!([0, weight]);
        }));
        pattern(&sheet)
    };
    let unmorphed = [true, true, false, true];
    let moved = |data: &mut Data| json!({ "TEXCOORD_0": data.floats(&[[1.0, 0.0]; 4]) });
    assert_eq!(morphed(0.5, moved), [true, true, true, false], "by one texel");
    assert_eq!(morphed(0.0, moved), unmorphed);
    let faded = |data: &mut Data| json!({ "COLOR_0": data.floats(&[[0.0, 0.0, 0.0, -1.0]; 4]) });
    assert_eq!(morphed(0.25, faded), [true, false, false, true], "128 of 255 of three quarters");
    assert_eq!(morphed(-3.0, faded), unmorphed, "alphas end at one");
    assert_eq!(morphed(3.0, faded), [false; 4], "and at zero");
    let tinted = |data: &mut Data| json!({ "COLOR_0": data.floats(&[[-1.0, 0.0, 0.0]; 4]) });
    assert_eq!(morphed(1.0, tinted), unmorphed, "colours without alpha");
}
