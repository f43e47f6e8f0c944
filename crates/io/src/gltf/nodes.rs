//! From nodes to objects, families, lights and the camera.

use std::{collections::BTreeSet, sync::Arc};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Placement, PlacementDefect};
use umbriel_scene::{Camera, Family, FindingKind, Member, Projection, Shape};

use super::{
    accessor::{Accessors, Component, within},
    hierarchy::{Hierarchy, Placed, TINY, place, without_tiny},
    json::{Document, Eye, ImplicitShape, Instancing, Node, element},
    lights,
    mesh::{LoadedMesh, Meshes},
    rooms::{self, Room},
    shapes::{self, Body},
    skins::Skins,
};
use crate::{
    error::LoadProblem,
    ledger::Quantity,
    model::{Model, ModelObject, camera},
    names::brief_name,
    options::Colliders,
    transform::{from_parts, has_no_surface},
};

/// Instances that may be given without any bytes, so that all stand in one place: more of them mean nothing but work.
const MOST_ALIKE: usize = 256;

/// Walks the nodes of the scene. With the model come the cameras that it looked at, whose faults it tells.
pub(super) fn read<'a>(
    document: &'a Document,
    hierarchy: &'a Hierarchy,
    accessors: &'a Accessors<'a>,
    mut meshes: Meshes<'a>,
    colliders: Colliders,
) -> Result<(Model, BTreeSet<usize>), LoadProblem> {
    let mut model = Model::default();
    for &node in &hierarchy.tiny {
        model.tell(&place(node, &document.nodes[node]), TINY);
    }
    let rooms = rooms::of_nodes(document, hierarchy, &mut meshes, &mut model.findings, accessors.ledger())?;
    let skins = Skins::new(document, hierarchy, accessors);
    let mut walk = Walk { document, accessors, meshes, skins, colliders, model, cameras: BTreeSet::new() };
    let mut objects_of = Vec::with_capacity(hierarchy.len());
    for (placed, room) in hierarchy.iter().zip(rooms) {
        let first = walk.model.objects.len();
        walk.take(&placed, room)?;
        objects_of.push(first..walk.model.objects.len());
        walk.see(&placed)?;
    }
    let Walk { mut model, meshes, skins, cameras, .. } = walk;
    model.findings.absorb(meshes.into_findings(), str::to_owned);
    model.findings.absorb(skins.into_findings(), str::to_owned);
    add_families(&mut model, document, hierarchy, &objects_of);
    Ok((model, cameras))
}

/// What is needed along the way, and what came of it so far.
struct Walk<'a> {
    document: &'a Document,
    accessors: &'a Accessors<'a>,
    meshes: Meshes<'a>,
    skins: Skins<'a>,
    colliders: Colliders,
    model: Model,
    /// Those that were looked at.
    cameras: BTreeSet<usize>,
}

impl Walk<'_> {
    /// Adds what a node is: a cell or portal, a body, or objects with its mesh.
    fn take(&mut self, placed: &Placed, room: Option<Box<Room>>) -> Result<(), LoadProblem> {
        let node = &self.document.nodes[placed.node];
        let shape = match (node.mesh, self.colliders) {
            (Some(_), Colliders::WithoutMesh) => Ok(None),
            _ => shapes::declared(self.document, node),
        };
        let shape = shape.map_err(|message| LoadProblem::element(place(placed.node, node), message))?;
        match (room.map(|room| *room), shape, node.mesh) {
            (Some(Room::Cell(cell)), ..) => self.model.cells.push(cell),
            (Some(Room::Portal(portal)), ..) => self.model.portals.push(portal),
            (None, None, None) => return Ok(()),
            (None, ..) if !placed.is_visible => return Ok(()),
            (None, Some(shape), _) => add_body(&mut self.model, placed, node, shape),
            (None, None, Some(mesh)) => {
                self.add_mesh(placed, node, mesh).map_err(|problem| within(problem, &place(placed.node, node)))?;
            }
        }
        self.model.check_size(self.accessors.ledger())
    }

    fn add_mesh(&mut self, placed: &Placed, node: &Node, mesh: usize) -> Result<(), LoadProblem> {
        let name = name_of(placed.node, node);
        let maps = instances(node, self.accessors)?;
        let mesh = self.meshes.get(mesh, node.weights.as_deref())?;
        let map = match node.skin {
            Some(skin) => self.skins.bind_map(skin)?,
            None => placed.map,
        };
        tell(&mut self.model, &name, node, mesh);
        let tiny = add_objects(&mut self.model, &name, map, maps, mesh);
        let subject = || format!("{}, EXT_mesh_gpu_instancing: {TINY}", place(placed.node, node));
        if tiny > 0 {
            self.model.findings.add(FindingKind::BrokenRule, &subject(), tiny);
        }
        Ok(())
    }

    /// Adds the light of a node, and its camera, if it is the first one.
    fn see(&mut self, placed: &Placed) -> Result<(), LoadProblem> {
        let node = &self.document.nodes[placed.node];
        let refused = |message: String| LoadProblem::element(place(placed.node, node), message);
        let lights = self.model.lights.len();
        lights::add(&mut self.model, self.document, placed).map_err(refused)?;
        if !placed.is_visible {
            self.model.lights.truncate(lights);
        }
        if let (Some(index), None) = (node.camera, &self.model.camera) {
            let declared = element(&self.document.cameras, index, "camera").map_err(refused)?;
            self.cameras.insert(index);
            match eye(declared, &placed.map) {
                Ok(camera) => self.model.camera = Some(camera),
                Err(fault) => {
                    self.model.tell(&place(placed.node, node), &format!("its camera is left out: {fault}"));
                }
            }
        }
        Ok(())
    }
}

fn name_of(index: usize, node: &Node) -> String {
    let name = node.name.as_deref().filter(|name| !name.is_empty());
    name.map_or_else(|| format!("node{index}"), brief_name)
}

/// What was taken otherwise than the file says, once for a node with all its instances.
fn tell(model: &mut Model, name: &str, node: &Node, mesh: &LoadedMesh) {
    let deforms = node.skin.is_some() || mesh.morphs;
    for (kind, count) in [
        (FindingKind::MaskAsOpaque, mesh.masked),
        (mesh.blend, mesh.blended),
        (FindingKind::NotTriangles, mesh.not_triangles),
        (FindingKind::Deformation, usize::from(deforms)),
    ] {
        model.findings.add(kind, name, count);
    }
}

/// One object, or one an instance; none for a mesh without triangles. Returns the instances with numbers below 2^-200.
fn add_objects(model: &mut Model, name: &str, map: DAffine3, maps: Option<Vec<DAffine3>>, mesh: &LoadedMesh) -> usize {
    if mesh.mesh.triangles().is_empty() {
        return 0;
    }
    let mut tiny = 0;
    let mut instance = |(number, own): (usize, DAffine3)| {
        let (map, count) = without_tiny(map * own);
        tiny += usize::from(count > 0);
        (format!("{name}#{number}"), map)
    };
    let placed: Vec<(String, DAffine3)> = match maps {
        None => vec![(name.to_owned(), map)],
        Some(maps) => maps.into_iter().enumerate().map(&mut instance).collect(),
    };
    // Exporters hide nodes and instances by a scale of zero: what is left is a point or a line.
    let is_hidden = |map: &DAffine3| has_no_surface(&map.matrix3);
    model.findings.add(FindingKind::NotTriangles, name, placed.iter().filter(|(_, map)| is_hidden(map)).count());
    model.objects.extend(placed.into_iter().filter(|(_, map)| !is_hidden(map)).map(|(name, map)| ModelObject {
        name,
        shape: Shape::Mesh(Arc::clone(&mesh.mesh)),
        map,
        sides: None,
        lightmap: mesh.lightmap.clone(),
        boxes: Vec::new(),
    }));
    tiny
}

/// The body that stands for a node, if its shape is one that is read.
fn add_body(model: &mut Model, placed: &Placed, node: &Node, shape: &ImplicitShape) {
    let name = name_of(placed.node, node);
    match shapes::body(shape) {
        Some(body) if body.is_flat() => model.findings.add(FindingKind::NotTriangles, &name, 1),
        Some(Body { map, .. }) if Placement::new(placed.map * map) == Err(PlacementDefect::Singular) => {
            model.findings.add(FindingKind::NotTriangles, &name, 1);
        }
        Some(Body { shape, map, sides }) => {
            model.objects.push(ModelObject {
                name,
                shape,
                map: placed.map * map,
                sides,
                lightmap: None,
                boxes: Vec::new(),
            });
        }
        None => model.findings.add(FindingKind::UnreadShape, &name, 1),
    }
}

/// The maps of a node's instances, if it has EXT_mesh_gpu_instancing.
fn instances(node: &Node, accessors: &Accessors) -> Result<Option<Vec<DAffine3>>, LoadProblem> {
    let Some(Instancing { attributes }) = &node.extensions().instancing else { return Ok(None) };
    let refused = |message: String| LoadProblem::element("EXT_mesh_gpu_instancing", message);
    let (mut translations, mut rotations, mut scales) = (None, None, None);
    for (name, &accessor) in attributes.iter() {
        match name.as_str() {
            "TRANSLATION" => translations = Some(accessors.vectors::<3>(floats(accessors, accessor, false)?)?),
            "ROTATION" => rotations = Some(accessors.vectors::<4>(floats(accessors, accessor, true)?)?),
            "SCALE" => scales = Some(accessors.vectors::<3>(floats(accessors, accessor, false)?)?),
            _ => {}
        }
    }
    let counts = [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let mut counts = counts.into_iter().flatten();
    // Attributes of others alone are instances, too, all of them where the node stands.
    let others = attributes.values().next().map(|&accessor| accessors.declared(accessor));
    let others = others.transpose()?.map(|(declared, _)| declared.count);
    let Some(count) = counts.next().or(others) else {
        return Err(refused("it has none of TRANSLATION, ROTATION, SCALE".to_owned()));
    };
    if counts.any(|other| other != count) {
        return Err(refused("its attributes differ in their number of instances".to_owned()));
    }
    accessors.ledger().check(Quantity::Parts, count as u64)?;
    let has_bytes = |&accessor: &usize| {
        accessors
            .declared(accessor)
            .is_ok_and(|(declared, _)| declared.buffer_view.is_some() || declared.sparse.is_some())
    };
    if count > MOST_ALIKE && !attributes.values().any(has_bytes) {
        return Err(refused(format!("{count} instances in one place; at most {MOST_ALIKE} are read")));
    }
    let map = |i: usize| {
        let translation = translations.as_ref().map_or([0.0; 3], |list| list[i]);
        let rotation = rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |list| list[i]);
        let scale = scales.as_ref().map_or([1.0; 3], |list| list[i]);
        from_parts(translation, rotation, scale).map_err(|message| refused(format!("instance {i}: {message}")))
    };
    (0..count).map(map).collect::<Result<_, _>>().map(Some)
}

/// The accessor, if its components are what an instance attribute allows: floats, or for rotations also normalised
/// signed integers.
fn floats(accessors: &Accessors, index: usize, normalized_too: bool) -> Result<usize, LoadProblem> {
    let (accessor, component) = accessors.declared(index)?;
    let small = matches!(component, Component::I8 | Component::I16) && accessor.normalized && normalized_too;
    if component == Component::F32 || small {
        Ok(index)
    } else {
        let message = "instances need 32-bit floats, or for ROTATION normalised signed integers of 8 or 16 bits";
        Err(LoadProblem::element(format!("accessor {index}"), message))
    }
}

/// A camera, which looks along the node's −Z.
fn eye(declared: &Eye, map: &DAffine3) -> Result<Camera, String> {
    let projection = match (&declared.perspective, &declared.orthographic) {
        (Some(perspective), None) => Projection::Perspective { vertical_degrees: perspective.yfov.to_degrees() },
        (None, Some(orthographic)) => Projection::Orthographic { height: 2.0 * orthographic.ymag.abs() },
        _ => return Err("it is not either perspective or orthographic".to_owned()),
    };
    let from = map.transform_point3(DVec3::ZERO);
    let forward = map.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
    let up = map.transform_vector3(DVec3::Y).normalize_or_zero();
    camera(from, from + forward, up, projection).map_err(str::to_owned)
}

/// Nodes with children, and instanced nodes, become families; branches without objects are left out.
fn add_families(model: &mut Model, document: &Document, hierarchy: &Hierarchy, objects_of: &[std::ops::Range<usize>]) {
    // Children come after their parents, so the way back meets them first.
    let mut below: Vec<usize> = objects_of.iter().map(ExactSizeIterator::len).collect();
    for i in (0..hierarchy.len()).rev() {
        if let Some(parent) = hierarchy.placed(i).parent {
            below[parent] += below[i];
        }
    }
    let mut family_of = vec![None; hierarchy.len()];
    let tree = &mut model.families;
    for (i, node) in hierarchy.iter().enumerate().filter(|&(i, _)| below[i] > 0) {
        let declared = &document.nodes[node.node];
        let parent: Option<usize> = node.parent.and_then(|parent| family_of[parent]);
        let is_family = !declared.children.is_empty() || declared.extensions().instancing.is_some();
        let family = if is_family {
            tree.families.push(Family { name: name_of(node.node, declared), members: Vec::new() });
            family_of[i] = Some(tree.families.len() - 1);
            push_member(tree, parent, Member::Family(tree.families.len() - 1));
            family_of[i]
        } else {
            parent
        };
        for object in objects_of[i].clone() {
            push_member(tree, family, Member::Object(object));
        }
    }
}

fn push_member(tree: &mut umbriel_scene::FamilyTree, family: Option<usize>, member: Member) {
    match family {
        Some(family) => tree.families[family].members.push(member),
        None => tree.roots.push(member),
    }
}
