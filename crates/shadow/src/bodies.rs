//! The scene's bodies as the fine step needs them, each built when it is first asked for.

use std::{
    collections::HashMap,
    sync::{Arc, OnceLock},
};

use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Approx, Facets, Mesh, MeshArea, PlacedAnalytic, analytic::PatchArea};
use umbriel_scene::{Object, Scene, Shape};

use crate::{
    by_object::ByObject,
    fine::{EdgeTable, tree_of},
};

/// A placed body.
#[derive(Debug)]
pub(crate) enum Body {
    /// Planar faces.
    Flat(Facets),
    /// A body given by formulas.
    Analytic(Box<PlacedAnalytic>),
}

/// All bodies of a scene.
#[derive(Debug)]
pub(crate) struct Bodies<'a> {
    pub(crate) scene: &'a Scene,
    /// Which objects light may reach; all if nothing is said.
    reached: Option<Arc<[bool]>>,
    built: ByObject<Box<Built>>,
    /// What instances of a mesh share, by the address of the mesh: the scene keeps it where it is. Of meshes with one instance nothing.
    of_meshes: Arc<HashMap<usize, OfMesh>>,
    /// Which objects are instances of these meshes; empty if none is.
    instances: Arc<[bool]>,
    /// Those of all groups, where all but instances are kept.
    of_all: Option<&'a Self>,
}

/// What is built of a mesh for all of its instances.
#[derive(Debug, Default)]
struct OfMesh {
    edges: OnceLock<Arc<EdgeTable>>,
    tree: OnceLock<Arc<BoxTree>>,
    area: OnceLock<MeshArea>,
}

/// What is built of an object.
#[derive(Debug, Default)]
struct Built {
    body: OnceLock<Body>,
    edges: OnceLock<Arc<EdgeTable>>,
    /// Of the patches of a curved body.
    rough_areas: OnceLock<Vec<OnceLock<Approx>>>,
    /// Of a mesh without other instances.
    area: OnceLock<MeshArea>,
}

impl<'a> Bodies<'a> {
    /// Nothing is built yet.
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let all: Vec<u32> = (0..scene.objects.len() as u32).collect();
        Self::bare(scene).sharing(&all)
    }

    /// As [`Bodies::new`], before it is known what instances share.
    pub(crate) fn bare(scene: &'a Scene) -> Self {
        Self {
            scene,
            reached: None,
            built: ByObject::new(scene.objects.len()),
            of_meshes: Arc::default(),
            instances: Arc::default(),
            of_all: None,
        }
    }

    /// With what instances share, those of these objects; none of the others is asked for.
    pub(crate) fn sharing(self, objects: &[u32]) -> Self {
        let of_meshes = shared_meshes(self.scene, objects);
        let mut instances = vec![false; if of_meshes.is_empty() { 0 } else { self.scene.objects.len() }];
        let mesh = |object: u32| mesh_of(&self.scene.objects[object as usize]);
        let is_instance = |&&object: &&u32| mesh(object).is_some_and(|mesh| of_meshes.contains_key(&address(mesh)));
        objects.iter().filter(is_instance).for_each(|&object| instances[object as usize] = true);
        Self { of_meshes: of_meshes.into(), instances: instances.into(), ..self }
    }

    /// For a group of receivers: instances that are asked for here are placed here, and forgotten with it.
    pub(crate) fn of_group(all: &'a Self) -> Self {
        Self {
            scene: all.scene,
            reached: all.reached.clone(),
            built: ByObject::new(all.scene.objects.len()),
            of_meshes: Arc::clone(&all.of_meshes),
            instances: Arc::clone(&all.instances),
            of_all: Some(all),
        }
    }

    /// With what is known of the objects that light may reach, one entry an object.
    pub(crate) fn reached(self, reached: Vec<bool>) -> Self {
        Self { reached: Some(reached.into()), ..self }
    }

    /// The object's world box, rounded outward.
    pub(crate) fn bounds(&self, object: usize) -> Aabb {
        self.scene.objects[object].bounds()
    }

    /// Whether it is known that no light reaches an object.
    pub(crate) fn is_dark(&self, object: usize) -> bool {
        self.reached.as_ref().is_some_and(|reached| !reached[object])
    }

    /// The object's body.
    pub(crate) fn get(&self, object: usize) -> &Body {
        self.built(object).body.get_or_init(|| {
            let object = &self.scene.objects[object];
            match object.analytic() {
                Some(body) => Body::Analytic(Box::new(body)),
                None => Body::Flat(object.facets().unwrap_or_default()),
            }
        })
    }

    fn built(&self, object: usize) -> &Built {
        match self.of_all {
            Some(all) if !self.is_instance(object) => all.built(object),
            _ => self.built.get_or_init(object, Box::default),
        }
    }

    /// Whether any mesh has several instances.
    pub(crate) fn has_instances(&self) -> bool {
        !self.instances.is_empty()
    }

    /// Whether the object is one of several instances of a mesh.
    pub(crate) fn is_instance(&self, object: usize) -> bool {
        self.instances.get(object).is_some_and(|&is_instance| is_instance)
    }

    /// Whether the object is placed, or would be kept for all of the bake.
    pub(crate) fn is_kept(&self, object: usize) -> bool {
        self.of_all.is_none() || !self.is_instance(object) || self.is_placed(object)
    }

    fn is_placed(&self, object: usize) -> bool {
        self.built.get(object).is_some_and(|built| built.body.get().is_some())
    }

    /// The object's body; an instance that is not placed yet only while it is looked at.
    pub(crate) fn look_at<T>(&self, object: usize, look: impl FnOnce(&Body) -> T) -> T {
        if self.is_instance(object) && !self.is_placed(object) {
            look(&Body::Flat(self.scene.objects[object].facets().unwrap_or_default()))
        } else {
            look(self.get(object))
        }
    }

    /// Number of the object's faces; of a mesh without placing it.
    pub(crate) fn face_count(&self, object: usize) -> usize {
        if let Shape::Mesh(mesh) = &self.scene.objects[object].shape {
            return mesh.triangles().len();
        }
        match self.get(object) {
            Body::Flat(facets) => facets.len(),
            Body::Analytic(body) => body.charts().len(),
        }
    }

    /// Number of the object's faces without those that repeat others, where none has holes; of an instance without placing it.
    pub(crate) fn distinct_faces(&self, object: usize) -> usize {
        let repeats = match (&self.scene.objects[object].shape, self.is_instance(object)) {
            (Shape::Mesh(mesh), _) if mesh.has_holes() => 0,
            (Shape::Mesh(mesh), true) => mesh.repeat_count(),
            _ => match self.get(object) {
                Body::Flat(facets) => facets.repeat_count(),
                Body::Analytic(_) => 0,
            },
        };
        self.face_count(object) - repeats
    }

    /// Whether an object is given by formulas.
    pub(crate) fn is_analytic(&self, object: usize) -> bool {
        matches!(self.scene.objects[object].shape, Shape::Analytic(_)) && matches!(self.get(object), Body::Analytic(_))
    }

    /// Whether an object has holes, so that what stands in the way is not all that blocks.
    pub(crate) fn has_holes(&self, object: usize) -> bool {
        matches!(&self.scene.objects[object].shape, Shape::Mesh(mesh) if mesh.has_holes())
    }

    /// Which of an object's flat faces share edges; the same for all lights.
    pub(crate) fn edges(&self, object: usize, facets: &Facets) -> &EdgeTable {
        self.built(object).edges.get_or_init(|| self.edges_of(object, facets))
    }

    /// As [`Bodies::edges`], kept for all instances of a mesh whose points are joined alike, else not.
    pub(crate) fn edges_of(&self, object: usize, facets: &Facets) -> Arc<EdgeTable> {
        let table = || Arc::new(EdgeTable::of(facets));
        match self.of_mesh(object).filter(|_| facets.are_joined_as_in_mesh()) {
            Some((_, of_mesh)) => Arc::clone(of_mesh.edges.get_or_init(table)),
            None => table(),
        }
    }

    /// The mesh of an object that is one of several instances, and what all of these share.
    fn of_mesh(&self, object: usize) -> Option<(&Arc<Mesh>, &OfMesh)> {
        let mesh = mesh_of(&self.scene.objects[object])?;
        Some((mesh, self.of_meshes.get(&address(mesh))?))
    }

    /// The area of a patch of a curved body within wide bounds ([`PatchArea::of_whole_roughly`]), none of one without points; found once for all
    /// lights.
    pub(crate) fn rough_area(&self, object: usize, body: &PlacedAnalytic, patch: usize) -> Approx {
        if self.bounds(object).is_empty() {
            return Approx::exact(0.0);
        }
        let areas =
            self.built(object).rough_areas.get_or_init(|| body.charts().iter().map(|_| OnceLock::new()).collect());
        *areas[patch].get_or_init(|| PatchArea::new(&body.charts()[patch], body.placement()).of_whole_roughly())
    }

    /// The area of all faces of a mesh within bounds ([`MeshArea`]), without placing it; `None` of what is no mesh.
    pub(crate) fn rough_mesh_area(&self, object: usize) -> Option<Approx> {
        let mesh = mesh_of(&self.scene.objects[object])?;
        let area = match self.of_meshes.get(&address(mesh)) {
            Some(of_mesh) => &of_mesh.area,
            None => &self.built(object).area,
        };
        let placement = &self.scene.objects[object].placement;
        Some(area.get_or_init(|| MeshArea::of(mesh)).placed(placement, &self.bounds(object)))
    }

    /// The mesh of an object that is one of several instances, and the tree that all of these share.
    pub(crate) fn instance(&self, object: usize) -> Option<(&Arc<Mesh>, &Arc<BoxTree>)> {
        let (mesh, of_mesh) = self.of_mesh(object)?;
        Some((mesh, of_mesh.tree.get_or_init(|| Arc::new(tree_of(mesh)))))
    }

    /// The number of a facet's component among those of its object: facets that share edges have the same. Of an instance, which is placed for a while, all count as one.
    pub(crate) fn component(&self, object: usize, facet: usize) -> u32 {
        if self.is_instance(object) {
            return 0;
        }
        match self.get(object) {
            Body::Flat(facets) => facets.topology().component_of[facet],
            Body::Analytic(_) => 0,
        }
    }

    /// Whether a face can be lit on one side only.
    pub(crate) fn is_one_sided(&self, object: usize, face: usize) -> bool {
        let is_closed = || match self.get(object) {
            Body::Flat(facets) => facets.is_closed(face),
            Body::Analytic(body) => body.body().is_closed(),
        };
        self.scene.objects[object].is_one_sided(is_closed)
    }
}

fn mesh_of(object: &Object) -> Option<&Arc<Mesh>> {
    if let Shape::Mesh(mesh) = &object.shape { Some(mesh) } else { None }
}

fn address(mesh: &Arc<Mesh>) -> usize {
    Arc::as_ptr(mesh).addr()
}

/// The meshes that several objects are instances of, some of `objects` among them. Others are not looked at unless one of these meshes has another owner.
fn shared_meshes(scene: &Scene, objects: &[u32]) -> HashMap<usize, OfMesh> {
    let meshes = objects.iter().filter_map(|&object| mesh_of(&scene.objects[object as usize]));
    let owned = meshes.filter(|mesh| Arc::strong_count(mesh) > 1);
    let mut instances: HashMap<usize, u32> = owned.map(|mesh| (address(mesh), 0)).collect();
    let mut open = instances.len();
    let mut meshes = scene.objects.iter().filter_map(mesh_of);
    while let Some(mesh) = meshes.next().filter(|_| open > 0) {
        if let Some(count) = instances.get_mut(&address(mesh)) {
            *count += 1;
            open -= usize::from(*count == 2);
        }
    }
    instances.retain(|_, count| *count > 1);
    instances.into_keys().map(|mesh| (mesh, OfMesh::default())).collect()
}
