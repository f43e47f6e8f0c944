//! What is wrong with a document apart from what was read of it.
//!
//! Whoever reads an element checks what is needed to read it; here is the rest, so that a file that is broken somewhere
//! does not pass because nobody looked there: references to elements that are not there, and ranges that leave their
//! buffers, are refused; what only extensions for shading refer to, and rules that are broken without harm (alignment,
//! strides, numbers of vertices, and those of [`rules`]), are told.
//! Only declarations are looked at, no bytes, so the time is linear in the text.

mod attributes;
mod homes;
pub(super) mod kinds;
mod motion;
mod references;
mod rules;
mod uses;

use std::collections::BTreeSet;

use umbriel_scene::FindingKind;

use super::{
    accessor::Component,
    json::{Accessor, BufferView, Document, MeshPrimitives, Primitive, Sparse, existing},
    views::compression,
};
use crate::{error::LoadProblem, model::Findings};

/// Checks a document that was read without fault. Of `cameras` the projection was looked at where they were read.
pub(super) fn check(document: &Document, cameras: &BTreeSet<usize>) -> Result<Findings, LoadProblem> {
    let mut check = Check { document, findings: Findings::default() };
    check.buffers();
    for (index, view) in document.buffer_views.iter().enumerate() {
        check.view(view, &format!("buffer view {index}"))?;
    }
    for (index, accessor) in document.accessors.iter().enumerate() {
        check.accessor(accessor, &format!("accessor {index}"))?;
    }
    for (index, mesh) in document.meshes.iter().enumerate() {
        check.mesh(mesh, &format!("mesh {index}"))?;
    }
    check.shared_views();
    check.nodes()?;
    check.skins()?;
    check.scenes()?;
    check.animations()?;
    check.textures()?;
    check.extensions();
    check.looks(cameras);
    Ok(check.findings)
}

struct Check<'a> {
    document: &'a Document,
    findings: Findings,
}

/// Names an element that has to be there.
fn named<T>(list: &[T], index: usize, kind: &str, place: &str) -> Result<(), LoadProblem> {
    existing(list, index, kind).map(|_| ()).map_err(|problem| super::accessor::within(problem, place))
}

impl Check<'_> {
    /// Tells a rule that is broken.
    fn tell(&mut self, place: &str, rule: &str) {
        self.findings.add(FindingKind::BrokenRule, &format!("{place}: {rule}"), 1);
    }

    fn view(&mut self, view: &BufferView, place: &str) -> Result<(), LoadProblem> {
        let inside = |buffer: usize, offset: usize, length: usize| -> Result<(), LoadProblem> {
            named(&self.document.buffers, buffer, "buffer", place)?;
            let declared = &self.document.buffers[buffer];
            let end = offset.checked_add(length).filter(|&end| end <= declared.byte_length);
            end.map(|_| ()).ok_or_else(|| {
                let message = format!("its {length} bytes from byte {offset} on leave buffer {buffer}");
                LoadProblem::element(place, message)
            })
        };
        inside(view.buffer, view.byte_offset, view.byte_length)?;
        if view.byte_length == 0 {
            self.tell(place, "it has no bytes");
        }
        if let Some((_, stream)) = compression(view) {
            inside(stream.buffer, stream.byte_offset, stream.byte_length)?;
            if view.stride(stream.byte_stride) != stream.byte_stride {
                self.tell(place, "its stride is not that of its compressed content");
            }
        }
        if view.byte_stride.is_some_and(|stride| !(4..=252).contains(&stride) || !stride.is_multiple_of(4)) {
            self.tell(place, "its stride is not one of 4, 8, ... 252");
        }
        if view.byte_stride.is_some_and(|stride| stride > view.byte_length) {
            self.tell(place, "its stride is more than its bytes");
        }
        if view.target.is_some_and(|target| !matches!(target, 34962 | 34963)) {
            self.tell(place, "its target is none of glTF's");
        }
        Ok(())
    }

    fn accessor(&mut self, accessor: &Accessor, place: &str) -> Result<(), LoadProblem> {
        let sparse = accessor.sparse.iter().flat_map(|sparse| [sparse.indices.buffer_view, sparse.values.buffer_view]);
        for view in sparse.chain(accessor.buffer_view) {
            named(&self.document.buffer_views, view, "buffer view", place)?;
        }
        let (size, component) = match element(accessor) {
            Ok(element) => element,
            // One whose elements are read was refused before.
            Err(fault) => {
                self.tell(place, &fault);
                return Ok(());
            }
        };
        if let Some(view) = accessor.buffer_view {
            self.elements(view, accessor.byte_offset(), (size, component.size()), accessor.count, place)?;
        }
        if accessor.count == 0 {
            self.tell(place, "it has no elements");
        }
        if accessor.normalized && matches!(component, Component::U32 | Component::F32) {
            self.tell(place, "its components cannot be normalised");
        }
        if accessor.is_offset_without_view() {
            self.tell(place, "it has a byteOffset and no bufferView");
        }
        if ![&accessor.min, &accessor.max].into_iter().flatten().all(|bound| components(&accessor.kind) == bound.len())
        {
            self.tell(place, "its min or max is not one number for each of its components");
        }
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        self.sparse(sparse, accessor, (size, component), place)
    }

    /// Elements of an accessor that stand elsewhere.
    fn sparse(
        &mut self,
        sparse: &Sparse,
        accessor: &Accessor,
        (size, component): (usize, Component),
        place: &str,
    ) -> Result<(), LoadProblem> {
        if sparse.count > accessor.count {
            let message = format!("{} of its {} elements are sparse", sparse.count, accessor.count);
            return Err(LoadProblem::element(place, message));
        }
        let place = format!("{place}, sparse");
        if sparse.count == 0 {
            self.tell(&place, "it has no elements");
        }
        let (at, from) = (&sparse.indices, &sparse.values);
        let index = Component::of(at.component_type).map_err(|message| LoadProblem::element(&place, message))?.size();
        self.elements(at.buffer_view, at.byte_offset, (index, index), sparse.count, &place)?;
        self.elements(from.buffer_view, from.byte_offset, (size, component.size()), sparse.count, &place)?;
        for view in [at.buffer_view, from.buffer_view] {
            self.plain_view(view, &place);
        }
        Ok(())
    }

    /// Elements of `size` bytes in a view that is there, made of components of `unit` bytes.
    fn elements(
        &mut self,
        view: usize,
        offset: usize,
        (size, unit): (usize, usize),
        count: usize,
        place: &str,
    ) -> Result<(), LoadProblem> {
        let declared = &self.document.buffer_views[view];
        let stride = declared.stride(size);
        let end = match count {
            0 => Some(offset),
            _ => (count - 1).checked_mul(stride).and_then(|last| last.checked_add(size)?.checked_add(offset)),
        };
        let refused = |message: String| Err(LoadProblem::element(format!("{place}, buffer view {view}"), message));
        if stride < size {
            return refused(format!("its stride of {stride} bytes is less than an element's {size}"));
        }
        if end.is_none_or(|end| end > declared.byte_length) {
            return refused(format!("{count} elements of {size} bytes do not fit into it"));
        }
        let start = declared.byte_offset.wrapping_add(offset);
        if !offset.is_multiple_of(unit) || !start.is_multiple_of(unit) || !stride.is_multiple_of(unit) {
            self.tell(place, "its components are not aligned");
        }
        Ok(())
    }

    fn mesh(&mut self, mesh: &MeshPrimitives, place: &str) -> Result<(), LoadProblem> {
        if mesh.primitives.is_empty() {
            self.tell(place, "it has no primitives");
        }
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            self.primitive(primitive, &format!("{place}, primitive {number}"))?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, place: &str) -> Result<(), LoadProblem> {
        let accessors = &self.document.accessors;
        let targets = primitive.targets.iter().flat_map(|target| target.values());
        for &accessor in primitive.attributes.values().chain(targets.clone()).chain(&primitive.indices) {
            named(accessors, accessor, "accessor", place)?;
        }
        if let Some(material) = primitive.material {
            named(&self.document.materials, material, "material", place)?;
            self.coordinates(primitive, &self.document.materials[material], place);
        }
        if let Some(draco) = &primitive.extensions.draco {
            named(&self.document.buffer_views, draco.buffer_view, "buffer view", place)?;
        }
        if primitive.mode.is_some_and(|mode| mode > 6) {
            return Err(LoadProblem::element(place, "its mode is none of glTF's (0 to 6)"));
        }
        let mut counts = primitive.attributes.values().chain(targets).map(|&index| accessors[index].count);
        let first = counts.next();
        if counts.any(|count| Some(count) != first) {
            self.tell(place, "its attributes differ in their number of vertices");
        }
        if primitive.attributes.is_empty() {
            self.tell(place, "it has no attributes");
        } else if !primitive.attributes.contains_key("POSITION") {
            self.tell(place, "it has no POSITION");
        }
        if primitive.targets.iter().any(|target| target.is_empty()) {
            self.tell(place, "a morph target of it has no attributes");
        }
        let is_own = |name: &String| primitive.attributes.contains_key(name);
        if !primitive.targets.iter().flat_map(|target| target.keys()).all(is_own) {
            self.tell(place, "a morph target moves an attribute that it does not have");
        }
        self.views_of(primitive);
        self.formats(primitive, place);
        self.variants(primitive, place);
        Ok(())
    }

    fn nodes(&mut self) -> Result<(), LoadProblem> {
        let document = self.document;
        let moved: Vec<bool> = document.meshes.iter().map(references::is_moved_by_joints).collect();
        for (index, node) in document.nodes.iter().enumerate() {
            let place = super::hierarchy::place(index, node);
            let references = [
                (node.mesh, document.meshes.len(), "mesh"),
                (node.skin, document.skins.len(), "skin"),
                (node.camera, document.cameras.len(), "camera"),
            ];
            for (index, count, kind) in references {
                if let Some(index) = index.filter(|&index| index >= count) {
                    let message = format!("it names {kind} {index}, but there are {count}");
                    return Err(LoadProblem::element(place, message));
                }
            }
            super::shapes::declared(document, node).map_err(|message| LoadProblem::element(place, message))?;
            self.node(index, node);
            self.node_extensions(index, node)?;
            if node.skin.is_some() && node.mesh.is_some_and(|mesh| !moved[mesh]) {
                let place = super::hierarchy::place(index, node);
                self.tell(&place, "it has a skin, but its mesh has no joints or no weights");
            }
        }
        Ok(())
    }

    fn skins(&mut self) -> Result<(), LoadProblem> {
        let document = self.document;
        let branches = references::branches_of(&document.nodes);
        for (index, skin) in document.skins.iter().enumerate() {
            let place = format!("skin {index}");
            for &joint in &skin.joints {
                named(&document.nodes, joint, "node", &place)?;
            }
            if let Some(skeleton) = skin.skeleton {
                named(&document.nodes, skeleton, "node", &place)?;
            }
            if let Some(accessor) = skin.inverse_bind_matrices {
                named(&document.accessors, accessor, "accessor", &place)?;
            }
            let mut joints = skin.joints.clone();
            joints.sort_unstable();
            joints.dedup();
            if joints.is_empty() || joints.len() < skin.joints.len() {
                self.tell(&place, "it has no joints, or one of them twice");
            }
            self.skin(skin, &branches, &place);
        }
        Ok(())
    }

    /// Only pictures of MASK materials matter to shadows, but the numbers of all do to the file.
    fn textures(&mut self) -> Result<(), LoadProblem> {
        let document = self.document;
        for (index, material) in document.materials.iter().enumerate() {
            let place = format!("material {index}");
            let base = &material.pbr_metallic_roughness;
            if let Some(texture) = &base.base_color_texture {
                named(&document.textures, texture.index, "texture", &place)?;
            }
            let others = [&material.normal_texture, &material.occlusion_texture, &material.emissive_texture];
            for texture in others.into_iter().chain([&base.metallic_roughness_texture]).flatten() {
                named(&document.textures, texture.index, "texture", &place)?;
            }
            let factors = [base, material.base_color()].map(|base| base.base_color_factor);
            if factors.iter().flatten().flatten().any(|part| !(0.0..=1.0).contains(part)) {
                self.tell(&place, "its base colour is not between 0 and 1");
            }
            if material.alpha_cutoff.is_some_and(|cutoff| cutoff < 0.0) {
                self.tell(&place, "its cutoff is below 0");
            }
        }
        for (index, sampler) in document.samplers.iter().enumerate() {
            if !super::textures::is_regular(sampler) {
                self.tell(&format!("sampler {index}"), "its filters or wraps are none of glTF's");
            }
        }
        for (index, texture) in document.textures.iter().enumerate() {
            if let Some(image) = texture.source {
                named(&document.images, image, "image", &format!("texture {index}"))?;
            }
            if let Some(sampler) = texture.sampler {
                named(&document.samplers, sampler, "sampler", &format!("texture {index}"))?;
            }
        }
        for (index, image) in document.images.iter().enumerate() {
            if let Some(view) = image.buffer_view {
                named(&document.buffer_views, view, "buffer view", &format!("image {index}"))?;
            }
        }
        self.shading();
        Ok(())
    }
}

/// The bytes of an accessor's element, and what it is made of.
fn element(accessor: &Accessor) -> Result<(usize, Component), String> {
    let component = Component::of(accessor.component_type)?;
    let size = element_size(&accessor.kind, component);
    let unknown = || format!("its type {} is none of glTF's", crate::error::excerpt(&accessor.kind));
    Ok((size.ok_or_else(unknown)?, component))
}

/// The components of an element.
fn components(kind: &str) -> usize {
    element_size(kind, Component::F32).map_or(0, |size| size / Component::F32.size())
}

/// The bytes of an element; columns of matrices begin at multiples of four bytes.
pub(super) fn element_size(kind: &str, component: Component) -> Option<usize> {
    let size = component.size();
    let matrix = |side: usize| (side - 1) * (side * size).next_multiple_of(4) + side * size;
    match kind {
        "SCALAR" => Some(size),
        "VEC2" => Some(2 * size),
        "VEC3" => Some(3 * size),
        "VEC4" => Some(4 * size),
        "MAT2" => Some(matrix(2)),
        "MAT3" => Some(matrix(3)),
        "MAT4" => Some(matrix(4)),
        _ => None,
    }
}
