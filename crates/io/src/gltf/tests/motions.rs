//! Animations: what a channel moves, and whether its values are such.

use super::*;

/// What is told of an animation of node 1 (node 0 shows the triangle) with a change; `times` is accessor 1, `values` accessor 2.
fn told(change: impl FnOnce(&mut Value, &mut Data)) -> Vec<String> {
    let model = model(changed(|document, data| {
        data.floats(&[[0.0], [1.0]]);
        data.floats(&[[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]);
        document["nodes"] = json!([{ "mesh": 0 }, {}]);
        document["animations"] = json!([{
            "samplers": [{ "input": 1, "output": 2 }],
            "channels": [{ "sampler": 0, "target": { "node": 1, "path": "translation" } }],
        }]);
        change(document, data);
    }));
    found(model).into_iter().map(|(_, subject, _)| subject).collect()
}

fn path(path: &'static str, values: impl FnOnce(&mut Data) -> usize) -> Vec<String> {
    told(|document, data| {
        document["animations"][0]["channels"][0]["target"]["path"] = json!(path);
        document["animations"][0]["samplers"][0]["output"] = json!(values(data));
    })
}

fn cubic(values: usize) -> Vec<String> {
    told(|document, data| {
        let output = data.floats(&vec![[0.5; 3]; values]);
        document["animations"][0]["samplers"][0] =
            json!({ "input": 1, "output": output, "interpolation": "CUBICSPLINE" });
    })
}

/// Weights of a mesh with two morph targets, or none.
fn weights(values: usize, targets: usize) -> Vec<String> {
    told(|document, data| {
        let output = data.floats(&vec![[0.5]; values]);
        document["meshes"][0]["primitives"][0]["targets"] = json!(vec![json!({ "POSITION": 0 }); targets]);
        document["animations"][0]["samplers"][0]["output"] = json!(output);
        document["animations"][0]["channels"][0]["target"] = json!({ "node": 0, "path": "weights" });
    })
}

#[test]
fn sound_motions_are_not_told() {
    for found in [
        told(|_, _| ()),
        told(|document, _| document["animations"][0]["samplers"][0]["interpolation"] = json!("STEP")),
        path("scale", |_| 2),
        path("pointer", |_| 0),
        path("rotation", |data| data.floats(&[[0.0, 0.0, 0.0, 1.0]; 2])),
        cubic(6),
    ] {
        assert_eq!(found, Vec::<String>::new());
    }
    // Morphing is told of the node.
    assert_eq!(weights(4, 2), ["node0"]);
}

#[test]
fn values_are_those_of_the_path_and_as_many_as_the_times() {
    let fault = "animation 0, channel 0: its output is not of the type of its path, or not as many as its input";
    for found in [
        path("rotation", |_| 2),
        path("scale", |data| data.floats(&[[1.0; 4]; 2])),
        path("translation", |data| data.floats(&[[1.0; 3]; 3])),
        cubic(2),
    ] {
        assert_eq!(found, [fault]);
    }
    assert!(weights(2, 2).contains(&fault.to_owned()));
    assert!(weights(2, 0).contains(&"animation 0, channel 0: its node has no morph targets".to_owned()));
}

#[test]
fn times_are_floats_with_bounds() {
    let times = |change: fn(&mut Data)| told(|_, data| change(data));
    for found in [
        times(|data| data.accessors[1]["min"] = Value::Null),
        times(|data| data.accessors[1]["min"] = json!([-1])),
        told(|document, data| {
            let times = data.add(&[0, 0, 1, 0], 5123, "SCALAR", 2, true);
            document["animations"][0]["samplers"][0]["input"] = json!(times);
        }),
        told(|document, _| document["animations"][0]["samplers"][0]["input"] = json!(2)),
    ] {
        let fault = "animation 0, sampler 0: its input is none of 32-bit floats with min and max, 0 or more";
        assert!(found.contains(&fault.to_owned()), "{found:?}");
    }
}

#[test]
fn times_ascend() {
    let times = |times: [f32; 3]| {
        told(|document, data| {
            let input = data.floats(&times.map(|time| [time]));
            let output = data.floats(&[[1.0; 3]; 3]);
            document["animations"][0]["samplers"][0] = json!({ "input": input, "output": output });
        })
    };
    assert_eq!(times([0.0, 0.5, 2.0]), Vec::<String>::new());
    for falling in [[0.0, 2.0, 1.0], [0.0, 0.0, 1.0]] {
        assert_eq!(times(falling), ["unused: accessor 3: times that do not ascend"]);
    }
}

#[test]
fn times_are_not_negative_and_curves_have_two_ends() {
    let input = |times: &[[f32; 1]], way: &str, values: usize| {
        told(|document, data| {
            let input = data.floats(times);
            data.accessors[input]["min"] = json!([0]);
            let output = data.floats(&vec![[1.0; 3]; values]);
            document["animations"][0]["samplers"][0] =
                json!({ "input": input, "output": output, "interpolation": way });
        })
    };
    assert_eq!(input(&[[0.0]], "LINEAR", 1), Vec::<String>::new());
    assert!(input(&[[-1.0], [1.0]], "LINEAR", 2).contains(&"unused: accessor 3: times below 0".to_owned()));
    let fault = "animation 0, sampler 0: a curve through fewer than two values";
    assert_eq!(input(&[[0.0]], "CUBICSPLINE", 3), [fault]);
}

#[test]
fn values_are_made_of_components_that_paths_may_have() {
    let output = |of: &'static str, component: u32, kind: &'static str, normalized: bool| {
        let size = if component == 5121 { 1 } else { 4 };
        // Both values are (0 0 0 1), or begin so.
        let one: &[u8] = if size == 1 { &[0, 0, 0, 255] } else { &[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63] };
        path(of, |data| data.add(&[one, one].concat(), component, kind, 2, normalized))
    };
    for sound in [output("rotation", 5121, "VEC4", true), output("translation", 5126, "VEC3", false)] {
        assert_eq!(sound, Vec::<String>::new());
    }
    let fault = "animation 0, channel 0: the components of its output are none that its path may have";
    for found in [
        output("translation", 5125, "VEC3", false),
        output("scale", 5121, "VEC3", true),
        output("rotation", 5121, "VEC4", false),
    ] {
        assert!(found.contains(&fault.to_owned()), "{found:?}");
    }
}

#[test]
fn rotations_have_length_one() {
    let turned = |way: &str, values: &[[f32; 4]]| {
        told(|document, data| {
            let output = data.floats(values);
            document["animations"][0]["samplers"][0] = json!({ "input": 1, "output": output, "interpolation": way });
            document["animations"][0]["channels"][0]["target"]["path"] = json!("rotation");
        })
    };
    let (unit, none) = ([0.1826, 0.3651, 0.5477, 0.7303], [0.0; 4]);
    assert_eq!(turned("STEP", &[unit; 2]), Vec::<String>::new());
    assert_eq!(turned("CUBICSPLINE", &[none, unit, none, none, unit, none]), Vec::<String>::new());
    let fault = "accessor 3: rotations that are not of length 1";
    for wrong in [none, [0.0, 0.0, 0.0, 2.0]] {
        assert_eq!(turned("LINEAR", &[unit, wrong]), [fault]);
        assert_eq!(turned("CUBICSPLINE", &[none, unit, none, none, wrong, none]), [fault]);
    }
}

#[test]
fn channels_move_what_they_may() {
    let animation = |change: fn(&mut Value)| told(|document, _| change(&mut document["animations"][0]));
    let twice = animation(|animation| {
        let channel = animation["channels"][0].clone();
        animation["channels"] = json!([channel.clone(), channel]);
    });
    assert_eq!(twice, ["animation 0, channel 1: another one has its target"]);
    assert_eq!(animation(|animation| animation["channels"] = json!([])), ["animation 0: it has no channels"]);
    let matrix = told(|document, _| {
        document["nodes"][1] = json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] });
    });
    assert_eq!(matrix, ["animation 0, channel 0: its node has a matrix"]);
    for target in [json!({ "path": "colour" }), json!({})] {
        let found = told(|document, _| document["animations"][0]["channels"][0]["target"] = target);
        assert_eq!(found, ["animation 0: a path or an interpolation in it is none of glTF's"]);
    }
    let way = animation(|animation| animation["samplers"][0]["interpolation"] = json!("WOBBLE"));
    assert_eq!(way, ["animation 0: a path or an interpolation in it is none of glTF's"]);
}
