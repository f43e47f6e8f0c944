//! Animations (glTF 2.0, 3.11): nothing here moves, so what is wrong with one is told, and only what it names has to be there.

use std::collections::HashSet;

use super::{Check, named};
use crate::{
    error::LoadProblem,
    gltf::{
        accessor::Component,
        json::{Accessor, Animation, AnimationChannel, AnimationSampler, Node},
    },
};

/// The type of components that are 32-bit floats.
const FLOAT: u32 = 5126;

impl Check<'_> {
    pub(super) fn animations(&mut self) -> Result<(), LoadProblem> {
        let document = self.document;
        for (index, animation) in document.animations.iter().enumerate() {
            let place = format!("animation {index}");
            for accessor in animation.samplers.iter().flat_map(|sampler| [sampler.input, sampler.output]) {
                named(&document.accessors, accessor, "accessor", &place)?;
            }
            for channel in &animation.channels {
                named(&animation.samplers, channel.sampler, "sampler", &place)?;
                if let Some(node) = channel.target.node {
                    named(&document.nodes, node, "node", &place)?;
                }
            }
            self.motion(animation, &place);
        }
        Ok(())
    }

    /// What an animation moves, and how.
    fn motion(&mut self, animation: &Animation, place: &str) {
        let is_path = |path: &str| matches!(path, "translation" | "rotation" | "scale" | "weights" | "pointer");
        let is_way = |way: &str| matches!(way, "LINEAR" | "STEP" | "CUBICSPLINE");
        let paths_are_sound =
            animation.channels.iter().all(|channel| channel.target.path.as_deref().is_some_and(is_path));
        let ways_are_sound =
            animation.samplers.iter().all(|sampler| sampler.interpolation.as_deref().is_none_or(is_way));
        if !paths_are_sound || !ways_are_sound {
            self.tell(place, "a path or an interpolation in it is none of glTF's");
        }
        if animation.channels.is_empty() {
            self.tell(place, "it has no channels");
        }
        for (number, sampler) in animation.samplers.iter().enumerate() {
            let times = &self.document.accessors[sampler.input];
            let place = format!("{place}, sampler {number}");
            for view in [sampler.input, sampler.output].map(|accessor| self.document.accessors[accessor].buffer_view) {
                view.into_iter().for_each(|view| self.plain_view(view, &place));
            }
            if !is_clock(times) {
                self.tell(&place, "its input is none of 32-bit floats with min and max, 0 or more");
            }
            if is_cubic(sampler) && times.count < 2 {
                self.tell(&place, "a curve through fewer than two values");
            }
        }
        let mut targets = HashSet::new();
        for (number, channel) in animation.channels.iter().enumerate() {
            let place = format!("{place}, channel {number}");
            self.channel(channel, &animation.samplers[channel.sampler], &place);
            let target = channel.target.node.zip(channel.target.path.as_deref());
            if target.is_some_and(|target| !targets.insert(target)) {
                self.tell(&place, "another one has its target");
            }
        }
    }

    /// What a channel moves, and whether the values are such and as many as the times.
    fn channel(&mut self, channel: &AnimationChannel, sampler: &AnimationSampler, place: &str) {
        let document = self.document;
        let (input, output) = (&document.accessors[sampler.input], &document.accessors[sampler.output]);
        let node = channel.target.node.map(|node| &document.nodes[node]);
        let (kind, each) = match channel.target.path.as_deref() {
            Some("translation" | "scale") => ("VEC3", 1),
            Some("rotation") => ("VEC4", 1),
            Some("weights") => {
                let weights = node.and_then(|node| self.morph_targets(node));
                if node.is_some() && weights.is_none() {
                    self.tell(place, "its node has no morph targets");
                }
                let Some(weights) = weights else { return };
                ("SCALAR", weights)
            }
            _ => return,
        };
        if kind != "SCALAR" && node.is_some_and(|node| node.matrix.is_some()) {
            self.tell(place, "its node has a matrix");
        }
        if !is_format(output, kind != "VEC3") {
            self.tell(place, "the components of its output are none that its path may have");
        }
        let values = if is_cubic(sampler) { 3 } else { 1 };
        if output.kind != kind || Some(output.count) != input.count.checked_mul(values * each) {
            self.tell(place, "its output is not of the type of its path, or not as many as its input");
        }
    }

    /// The number of morph targets of a node's mesh, if it has any.
    fn morph_targets(&self, node: &Node) -> Option<usize> {
        let primitive = self.document.meshes[node.mesh?].primitives.first()?;
        Some(primitive.targets.len()).filter(|&targets| targets > 0)
    }
}

fn is_cubic(sampler: &AnimationSampler) -> bool {
    sampler.interpolation.as_deref() == Some("CUBICSPLINE")
}

/// Whether an accessor may hold what nodes are moved by: floats, or `small_too` (of rotations and weights) normalised numbers of 8 or 16 bits.
fn is_format(output: &Accessor, small_too: bool) -> bool {
    match Component::of(output.component_type) {
        Ok(Component::F32) => true,
        Ok(Component::U32) | Err(_) => false,
        Ok(_) => small_too && output.normalized,
    }
}

/// Whether an accessor may hold times.
fn is_clock(times: &Accessor) -> bool {
    let is_late = |min: &Vec<f64>| min.iter().all(|&first| first >= 0.0);
    times.kind == "SCALAR"
        && times.component_type == FLOAT
        && times.max.is_some()
        && times.min.as_ref().is_some_and(is_late)
}
