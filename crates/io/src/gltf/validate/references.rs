//! References that nothing here follows: of extensions, and of nodes and scenes that are not shown.

use std::collections::{BTreeSet, HashSet};

use super::{Check, named};
use crate::{
    error::{LoadProblem, excerpt},
    gltf::{
        accessor::within,
        hierarchy,
        json::{Collider, Material, MeshPrimitives, Node, Primitive, Skin, TextureIndex, TextureReference, existing},
    },
};

impl Check<'_> {
    /// An index into a list of the document, which is told where nothing is there.
    fn refer(&mut self, (index, count): (usize, usize), kind: &str, place: &str) {
        if index >= count {
            self.tell(place, &format!("it names {kind} {index}, but there are {count}"));
        }
    }

    /// The same where an index is given.
    fn refer_some(&mut self, (index, count): (Option<usize>, usize), kind: &str, place: &str) {
        index.into_iter().for_each(|index| self.refer((index, count), kind, place));
    }

    /// Lights and instances of a node, in the scene or not.
    pub(super) fn node_extensions(&mut self, index: usize, node: &Node) -> Result<(), LoadProblem> {
        let document = self.document;
        let place = hierarchy::place(index, node);
        let told = |problem| within(problem, &place);
        if let Some(light) = &node.extensions().light {
            let lights = document.extensions.lights.as_ref().map_or(&[][..], |lights| &lights.lights);
            existing(lights, light.light, "light").map_err(told)?;
        }
        for name in node.extensions().instancing.iter().flat_map(|instancing| instancing.attributes.keys()) {
            let is_of_extension = name.split_once(':').is_some_and(|(extension, _)| document.uses(extension));
            let is_known = matches!(name.as_str(), "TRANSLATION" | "ROTATION" | "SCALE") || name.starts_with('_');
            if !is_known && !is_of_extension {
                self.tell(&place, &format!("{} is no attribute of instances", excerpt(name)));
            }
        }
        let mut instances = None;
        for &accessor in node.extensions().instancing.iter().flat_map(|instancing| instancing.attributes.values()) {
            let count = existing(&document.accessors, accessor, "accessor").map_err(told)?.count;
            if *instances.get_or_insert(count) != count {
                self.tell(&place, "the attributes of its instances differ in their number");
            }
        }
        let Some(body) = &node.extensions().rigid_body else { return Ok(()) };
        for collider in [&body.collider, &body.trigger].into_iter().flatten() {
            self.collider(collider, &place);
        }
        let joints = document.extensions.physics.physics_joints.len();
        if let Some(joint) = &body.joint {
            self.refer_some((joint.connected_node, document.nodes.len()), "node", &place);
            self.refer_some((joint.joint, joints), "joint", &place);
        }
        Ok(())
    }

    /// What is taken for a collision, or for a trigger, which no shadow hangs on.
    fn collider(&mut self, collider: &Collider, place: &str) {
        let extensions = &self.document.extensions;
        let shapes = extensions.implicit_shapes.as_ref().or(extensions.collision_shapes.as_ref());
        let shapes = shapes.map_or(0, |shapes| shapes.shapes.len());
        let geometry = collider.geometry.as_ref();
        let (meshes, nodes) = (self.document.meshes.len(), self.document.nodes.len());
        let physics = &extensions.physics;
        for (index, count, kind) in [
            (collider.shape, shapes, "shape"),
            (geometry.and_then(|geometry| geometry.shape), shapes, "shape"),
            (geometry.and_then(|geometry| geometry.mesh), meshes, "mesh"),
            (geometry.and_then(|geometry| geometry.node), nodes, "node"),
            (collider.physics_material, physics.physics_materials.len(), "physics material"),
            (collider.collision_filter, physics.collision_filters.len(), "collision filter"),
        ] {
            self.refer_some((index, count), kind, place);
        }
    }

    /// The roots of scenes. Those that are children are told of scenes that are not shown.
    pub(super) fn scenes(&mut self) -> Result<(), LoadProblem> {
        let document = self.document;
        for (index, scene) in document.scenes.iter().enumerate() {
            for &node in &scene.nodes {
                named(&document.nodes, node, "node", &format!("scene {index}"))?;
            }
        }
        let mut is_taken = vec![None; document.nodes.len()];
        let mut is_child = vec![false; document.nodes.len()];
        document.nodes.iter().flat_map(|node| &node.children).for_each(|&child| is_child[child] = true);
        for (index, scene) in document.scenes.iter().enumerate() {
            for &root in &scene.nodes {
                if is_child[root] || is_taken[root].replace(index) == Some(index) {
                    self.tell(
                        &format!("scene {index}"),
                        &format!("its node {root} is a child of another node or named twice"),
                    );
                }
            }
        }
        Ok(())
    }

    /// The joints of a skin hang on one root, and on its skeleton; its matrices are as many as they, or more.
    pub(super) fn skin(&mut self, skin: &Skin, branches: &[Branch], place: &str) {
        if skin.joints.windows(2).any(|two| branches[two[0]].root != branches[two[1]].root) {
            self.tell(place, "its joints have no common root");
        }
        let holds = |skeleton: usize| skin.joints.iter().all(|&joint| branches[skeleton].holds(&branches[joint]));
        if skin.skeleton.is_some_and(|skeleton| !holds(skeleton)) {
            self.tell(place, "its joints do not hang on its skeleton");
        }
        let Some(matrices) = skin.inverse_bind_matrices.map(|accessor| &self.document.accessors[accessor]) else {
            return;
        };
        if let Some(view) = matrices.buffer_view {
            self.plain_view(view, place);
        }
        if matrices.kind != "MAT4" || matrices.component_type != 5126 || matrices.count < skin.joints.len() {
            self.tell(place, "its inverse bind matrices are none of 32-bit floats, or fewer than its joints");
        }
    }

    /// Materials of variants.
    pub(super) fn variants(&mut self, primitive: &Primitive, place: &str) {
        let document = self.document;
        let variants = document.extensions.variants.as_ref().map_or(0, |variants| variants.variants.len());
        let Some(declared) = &primitive.extensions.variants else { return };
        if declared.mappings.is_empty() {
            self.tell(place, "its variants map nothing");
        }
        let mut mapped = HashSet::new();
        for mapping in &declared.mappings {
            self.refer((mapping.material, document.materials.len()), "material", place);
            if mapping.variants.is_empty() || !mapping.variants.iter().all(|variant| mapped.insert(variant)) {
                self.tell(place, "a mapping has no variants, or one that is mapped twice");
            }
            for &variant in &mapping.variants {
                self.refer((variant, variants), "variant", place);
            }
        }
    }

    /// The texture coordinates of the textures of a primitive's material.
    pub(super) fn coordinates(&mut self, primitive: &Primitive, material: &Material, place: &str) {
        let base = &material.pbr_metallic_roughness;
        let base_color = base.base_color_texture.as_ref().map(TextureReference::set);
        let others = [&material.normal_texture, &material.occlusion_texture, &material.emissive_texture];
        let of_extensions = material.extensions.iter().flat_map(|extension| &extension.textures);
        let others = others.into_iter().chain([&base.metallic_roughness_texture]).flatten().chain(of_extensions);
        for set in others.map(TextureIndex::set).chain(base_color).collect::<BTreeSet<_>>() {
            let name = format!("TEXCOORD_{set}");
            if !primitive.attributes.contains_key(&name) {
                self.tell(place, &format!("it has no {name}, which its material takes"));
            }
        }
    }

    /// Textures of materials' extensions, and pictures of textures'.
    pub(super) fn shading(&mut self) {
        let document = self.document;
        for (index, material) in document.materials.iter().enumerate() {
            for texture in material.extensions.iter().flat_map(|extension| &extension.textures) {
                self.refer((texture.index, document.textures.len()), "texture", &format!("material {index}"));
            }
            self.malformed(&material.extensions.malformed, &format!("material {index}"));
        }
        for (index, texture) in document.textures.iter().enumerate() {
            for image in texture.extensions.iter().filter_map(|extension| extension.source) {
                self.refer((image, document.images.len()), "image", &format!("texture {index}"));
            }
            self.malformed(&texture.extensions.malformed, &format!("texture {index}"));
        }
    }

    fn malformed(&mut self, extensions: &[String], place: &str) {
        for name in extensions {
            self.tell(place, &format!("its extension {name} is not as it should be"));
        }
    }
}

/// Where a node stands among all, when each is counted before its children and with all below it.
#[derive(Clone, Copy)]
pub(super) struct Branch {
    /// The node that it hangs on in the end.
    root: usize,
    /// Its number.
    first: usize,
    /// The number behind the last one below it.
    end: usize,
}

impl Branch {
    /// Whether another is this one or below it.
    fn holds(&self, other: &Self) -> bool {
        (self.first..self.end).contains(&other.first)
    }
}

/// The branch of every node. There are no cycles.
pub(super) fn branches_of(nodes: &[Node]) -> Vec<Branch> {
    let mut branches: Vec<Branch> = (0..nodes.len()).map(|root| Branch { root, first: 0, end: 0 }).collect();
    let mut is_child = vec![false; nodes.len()];
    nodes.iter().flat_map(|node| &node.children).for_each(|&child| is_child[child] = true);
    let mut open: Vec<usize> = (0..nodes.len()).filter(|&node| !is_child[node]).collect();
    let mut counted = Vec::with_capacity(nodes.len());
    while let Some(node) = open.pop() {
        (branches[node].first, branches[node].end) = (counted.len(), counted.len() + 1);
        counted.push(node);
        for &child in &nodes[node].children {
            branches[child].root = branches[node].root;
            open.push(child);
        }
    }
    // Children are counted after their parents, so the way back meets them first.
    for node in counted.into_iter().rev() {
        let ends = nodes[node].children.iter().map(|&child| branches[child].end);
        branches[node].end = ends.fold(branches[node].end, usize::max);
    }
    branches
}

/// Whether all primitives of a mesh say which joints move them, and how much.
pub(super) fn is_moved_by_joints(mesh: &MeshPrimitives) -> bool {
    let has = |primitive: &Primitive, name: &str| primitive.attributes.contains_key(name);
    mesh.primitives.iter().all(|primitive| has(primitive, "JOINTS_0") && has(primitive, "WEIGHTS_0"))
}
