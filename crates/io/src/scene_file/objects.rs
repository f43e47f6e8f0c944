//! Objects of a scene file: bodies, and meshes from other files.

use std::{collections::BTreeMap, path::Path, sync::Arc};

use glam::DAffine3;
use umbriel_geometry::{Convex, Cuboid, Placement, Rectangle};
use umbriel_scene::{Member, PartBox, Shape, Sides};

use super::{
    Places,
    entries::{ObjectEntry, Scale},
    meshes::{MeshFile, MeshFiles},
    own_detail_of, sides_of,
    tables::Placed,
};
use crate::{
    error::{LoadError, excerpt},
    folder::Folder,
    load::Reading,
    model::{Model, ModelObject},
    names::brief_name,
    options::DetailSetting,
    transform::{from_matrix, from_parts},
};

/// What entries are read with.
pub(super) struct Context<'a> {
    /// The scene file.
    pub(super) path: &'a Path,
    pub(super) places: &'a Places<'a>,
    pub(super) folder: &'a Folder,
    pub(super) reading: Reading,
}

/// Reads all objects; a mesh file that several of them name is read once, and its geometry shared. Answers the details that objects have of their own.
pub(super) fn read(
    model: &mut Model,
    entries: &[Placed<ObjectEntry>],
    files: &mut MeshFiles,
    context: &Context,
) -> Result<BTreeMap<usize, DetailSetting>, LoadError> {
    let path = context.path;
    let mut own = BTreeMap::new();
    for (number, spanned) in entries.iter().enumerate() {
        let entry = spanned.get_ref();
        let name = entry.name.as_deref().map_or_else(|| format!("object{}", number + 1), brief_name);
        let refused =
            |message: String| context.places.at(spanned.span(), format!("object \"{name}\": {message}")).in_file(path);
        let map = map_of(entry).map_err(refused)?;
        Placement::new(map).map_err(|defect| refused(defect.to_string()))?;
        let sides = entry.sides.map(sides_of);
        if entry.quadric.as_ref().is_some_and(|body| !is_symmetric(&body.matrix)) {
            model.tell(&name, "its matrix is not symmetric: the symmetric part of it is the body");
        }
        let detail = entry.detail.as_deref().map(own_detail_of).transpose();
        let detail = detail.map_err(|message| refused(format!("detail: {message}")))?;
        let first = model.objects.len();
        match body_of(entry).map_err(refused)? {
            Body::Shape(shape) => {
                model.families.roots.push(Member::Object(model.objects.len()));
                let boxes = boxes_of(entry, DAffine3::IDENTITY).map_err(refused)?;
                model.objects.push(ModelObject { name, shape, map, sides, lightmap: None, boxes });
            }
            Body::Mesh(file) => {
                let place = format!("object \"{name}\"");
                let is_turned = entry.rotation.is_some() || entry.matrix.is_some();
                let file = files.get((file, &place), is_turned, context)?;
                take_in(model, file, entry, &name, (map, sides)).map_err(refused)?;
                model.check_size(context.folder.ledger()).map_err(|problem| problem.in_file(path))?;
            }
        }
        own.extend(
            detail.into_iter().flat_map(|detail| (first..model.objects.len()).map(move |object| (object, detail))),
        );
    }
    Ok(own)
}

fn is_symmetric(matrix: &[f64; 16]) -> bool {
    (0..16).all(|at| matrix[at] == matrix[at % 4 * 4 + at / 4])
}

/// The bodies that are no meshes, as the file names them.
const BODIES: &str = "rectangle, box, sphere, ellipsoid, cylinder, cone, frustum, capsule, paraboloid, hyperboloid, disk, \
                      convex, quadric";

enum Body<'a> {
    Shape(Shape),
    Mesh(&'a str),
}

fn body_of(entry: &ObjectEntry) -> Result<Body<'_>, String> {
    let convex = entry.convex.as_ref().map(|body| Convex::new(body.points.clone())).transpose();
    let convex = convex.map_err(|defect| format!("convex: {defect}"))?;
    let shapes = [
        entry.rectangle.as_ref().map(|body| Shape::Rectangle(Rectangle { size: body.size })),
        entry.cuboid.as_ref().map(|body| Shape::Cuboid(Cuboid { size: body.size })),
        convex.map(|body| Shape::Convex(Arc::new(body))),
    ];
    let shapes = shapes.into_iter().flatten().chain(entry.analytic().map(Shape::from));
    let mut bodies = shapes.map(Body::Shape).chain(entry.mesh.as_deref().map(Body::Mesh));
    let (Some(body), None) = (bodies.next(), bodies.next()) else {
        return Err(format!("give exactly one body: {BODIES} or mesh"));
    };
    if entry.node.is_some() && !matches!(body, Body::Mesh(_)) {
        return Err("node picks a part of a mesh file; there is no mesh here".to_owned());
    }
    Ok(body)
}

/// The boxes that an entry gives its object, in the coordinates of the shape; `inner` leads from these to the entry's own.
fn boxes_of(entry: &ObjectEntry, inner: DAffine3) -> Result<Vec<PartBox>, String> {
    let to_shape = inner.inverse();
    let boxes = entry.boxes.iter().flatten().enumerate().map(|(number, part)| {
        let half = part.half.map(|half| to_shape.transform_vector3(half.into()));
        let center = to_shape.transform_point3(part.center.into());
        let is_finite = center.is_finite() && half.iter().all(|half| half.is_finite());
        is_finite.then_some(PartBox { center, half }).ok_or_else(|| format!("boxes: box {number} is not finite"))
    });
    boxes.collect()
}

fn map_of(entry: &ObjectEntry) -> Result<DAffine3, String> {
    if let Some(matrix) = &entry.matrix {
        if entry.translation.is_some() || entry.rotation.is_some() || entry.scale.is_some() {
            return Err("give either matrix, or translation, rotation and scale".to_owned());
        }
        return from_matrix(matrix);
    }
    let scale = match entry.scale {
        None => [1.0; 3],
        Some(Scale::Uniform(scale)) => [scale; 3],
        Some(Scale::Each(scale)) => scale,
    };
    from_parts(entry.translation.unwrap_or([0.0; 3]), entry.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]), scale)
}

/// Adds a mesh file, or the part of it that the entry picks.
fn take_in(
    model: &mut Model,
    file: &mut MeshFile,
    entry: &ObjectEntry,
    name: &str,
    (map, sides): (DAffine3, Option<Sides>),
) -> Result<(), String> {
    let mut part = match &entry.node {
        None => file.whole(),
        Some(node) => file
            .node(node)
            .ok_or_else(|| format!("its mesh file has no node \"{}\"; it has {}", excerpt(node), file.some_names()))?,
    };
    if part.objects.is_empty() {
        let file = entry.mesh.as_deref().unwrap_or_default();
        return Err(format!("its mesh file \"{}\" holds no triangle", excerpt(file)));
    }
    if entry.boxes.is_some() {
        let [object] = part.objects.as_mut_slice() else {
            let count = part.objects.len();
            return Err(format!("boxes are those of one object; its mesh has {count}: pick one by node"));
        };
        object.boxes = boxes_of(entry, object.map)?;
    }
    model.take_in(part, name, map, sides, entry.node.is_some())
}
