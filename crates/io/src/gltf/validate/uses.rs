//! What buffers and their views say about what they are used for (glTF 2.0, 3.6.2 and 5.11).

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::{Check, Component, element_size};
use crate::gltf::{
    container::media_type,
    json::{Accessor, BufferView, Primitive},
};

/// What a buffer view says that it is for: vertices or indices.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

impl Check<'_> {
    pub(super) fn buffers(&mut self) {
        let is_for_buffers = |kind: &str| {
            ["application/octet-stream", "application/gltf-buffer"].iter().any(|due| kind.eq_ignore_ascii_case(due))
        };
        for (index, buffer) in self.document.buffers.iter().enumerate() {
            let place = format!("buffer {index}");
            if buffer.byte_length == 0 {
                self.tell(&place, "it has no bytes");
            }
            let Some(uri) = buffer.uri.as_deref() else { continue };
            if media_type(uri).is_some_and(|kind| !is_for_buffers(kind)) {
                self.tell(&place, "its data URI's type is none of buffers'");
            }
            self.data_uri(uri, &place);
        }
    }

    /// White space stands in no URI; in those of data it is passed over.
    pub(super) fn data_uri(&mut self, uri: &str, place: &str) {
        if media_type(uri).is_some() && uri.contains(|character: char| character.is_ascii_whitespace()) {
            self.tell(place, "its data URI has white space");
        }
    }

    /// What the views behind a primitive say that they are for, and where their vertices begin.
    pub(super) fn views_of(&mut self, primitive: &Primitive) {
        if primitive.extensions.draco.is_some() {
            return;
        }
        for &index in attributes_of(primitive) {
            self.purpose(index, VERTICES, "its buffer view is not for vertices");
            if self.is_misaligned(index) {
                self.tell(&format!("accessor {index}"), "its vertices do not begin at multiples of four bytes");
            }
        }
        if let Some(index) = primitive.indices {
            self.purpose(index, INDICES, "its buffer view is not for indices");
            if self.view_of(index).is_some_and(|view| view.byte_stride.is_some()) {
                self.tell(&format!("accessor {index}"), "its buffer view has a stride, and holds indices");
            }
        }
    }

    /// Views of vertices that several accessors share need a stride; and no view holds two of vertices, indices, matrices of skins and pictures.
    pub(super) fn shared_views(&mut self) {
        let document = self.document;
        let primitives = document.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let plain = primitives.filter(|primitive| primitive.extensions.draco.is_none());
        let view_of = |accessor: usize| document.accessors.get(accessor)?.buffer_view;
        let (mut first, mut shared) = (HashMap::new(), BTreeSet::new());
        for &accessor in plain.clone().flat_map(attributes_of) {
            let Some(view) = view_of(accessor) else { continue };
            let has_stride = document.buffer_views[view].byte_stride.is_some();
            if *first.entry(view).or_insert(accessor) != accessor && !has_stride {
                shared.insert(view);
            }
        }
        let mut held: BTreeMap<usize, BTreeSet<&str>> = BTreeMap::new();
        let mut hold = |view: usize, content: &'static str| _ = held.entry(view).or_default().insert(content);
        first.keys().for_each(|&view| hold(view, "vertices"));
        plain.filter_map(|primitive| view_of(primitive.indices?)).for_each(|view| hold(view, "indices"));
        let matrices = document.skins.iter().filter_map(|skin| view_of(skin.inverse_bind_matrices?));
        matrices.for_each(|view| hold(view, "inverse bind matrices"));
        document.images.iter().filter_map(|image| image.buffer_view).for_each(|view| hold(view, "pictures"));
        for (view, contents) in held.into_iter().filter(|(_, contents)| contents.len() > 1) {
            let contents: Vec<&str> = contents.into_iter().collect();
            self.tell(&format!("buffer view {view}"), &format!("it holds {}", contents.join(" and ")));
        }
        for view in shared {
            self.tell(&format!("buffer view {view}"), "several accessors of vertices share it, and it has no stride");
        }
    }

    /// A view of neither vertices nor indices, which has no stride and no target.
    pub(super) fn plain_view(&mut self, view: usize, place: &str) {
        let view = &self.document.buffer_views[view];
        if view.byte_stride.is_some() || view.target.is_some() {
            self.tell(place, "its buffer view has a stride or a target, which only those of vertices and indices have");
        }
    }

    fn view_of(&self, accessor: usize) -> Option<&BufferView> {
        self.document.buffer_views.get(self.document.accessors[accessor].buffer_view?)
    }

    fn purpose(&mut self, accessor: usize, expected: u32, rule: &str) {
        let target = self.view_of(accessor).and_then(|view| view.target);
        if target.is_some_and(|target| target != expected) {
            self.tell(&format!("accessor {accessor}"), rule);
        }
    }

    /// Whether vertices begin elsewhere than at multiples of four bytes.
    fn is_misaligned(&self, index: usize) -> bool {
        let accessor: &Accessor = &self.document.accessors[index];
        let size = Component::of(accessor.component_type).ok();
        let size = size.and_then(|component| element_size(&accessor.kind, component));
        let has_no_stride = self.view_of(index).is_some_and(|view| view.byte_stride.is_none());
        let is_packed = has_no_stride && size.is_some_and(|size| !size.is_multiple_of(4));
        is_packed || !accessor.byte_offset().is_multiple_of(4)
    }
}

/// The accessors of a primitive's attributes, and of those of its morph targets.
fn attributes_of(primitive: &Primitive) -> impl Iterator<Item = &usize> {
    primitive.targets.iter().chain([&primitive.attributes]).flat_map(|list| list.values())
}
