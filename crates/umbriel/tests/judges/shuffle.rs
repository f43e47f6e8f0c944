//! Scenes whose objects or triangles stand in another order, and what is said of them in the first one.

use std::sync::Arc;

use umbriel_geometry::Mesh;
use umbriel_scene::{Object, Scene, Shape};
use umbriel_shadow::{ObjectReport, Place};

use crate::oracle::{dice::Dice, fixtures::scene};

/// A scene in a random order.
pub(crate) struct Shuffled {
    pub(crate) scene: Scene,
    /// Where each object went.
    objects: Vec<usize>,
    /// Where each triangle of a mesh went, for each object of the first scene; empty where they stayed.
    triangles: Vec<Vec<usize>>,
}

impl Shuffled {
    /// The objects in another order.
    pub(crate) fn objects(whole: &Scene, dice: &mut Dice) -> Self {
        let order = dice.order(whole.objects.len());
        let objects = order.iter().map(|&object| whole.objects[object].clone()).collect();
        Self { scene: scene(objects), objects: inverse(&order), triangles: vec![Vec::new(); order.len()] }
    }

    /// The triangles of each mesh in another order.
    pub(crate) fn triangles(whole: &Scene, dice: &mut Dice) -> Self {
        let mut shuffled =
            Self { scene: whole.clone(), objects: (0..whole.objects.len()).collect(), triangles: Vec::new() };
        for object in &mut shuffled.scene.objects {
            let Shape::Mesh(mesh) = &object.shape else {
                shuffled.triangles.push(Vec::new());
                continue;
            };
            let order = dice.order(mesh.triangles().len());
            let triangles = order.iter().map(|&triangle| mesh.triangles()[triangle]).collect();
            *object = with_triangles(object, mesh, triangles);
            shuffled.triangles.push(inverse(&order));
        }
        shuffled
    }

    /// The same place in the shuffled scene.
    pub(crate) fn place(&self, place: &Place) -> Place {
        match *place {
            Place::Surface { object, face, u, v } => {
                let face = self.triangles[object].get(face).copied().unwrap_or(face);
                Place::Surface { object: self.objects[object], face, u, v }
            }
            other => other,
        }
    }

    /// The shuffled scene's reports, one an object, as those of the first scene. Answers of samples stay in their order.
    pub(crate) fn back(&self, reports: &[ObjectReport]) -> Vec<ObjectReport> {
        let back = |(object, &place): (usize, &usize)| {
            let mut report = reports[place].clone();
            report.object = object;
            let first = inverse(&self.triangles[object]);
            if !first.is_empty() {
                report.cells.iter_mut().for_each(|cell| cell.face = first[cell.face as usize] as u32);
                report.cells.sort_by_key(|cell| cell.face);
            }
            report
        };
        self.objects.iter().enumerate().map(back).collect()
    }
}

/// The object with other triangles over the same corners.
pub(crate) fn with_triangles(object: &Object, mesh: &Mesh, triangles: Vec<[u32; 3]>) -> Object {
    let positions = mesh.positions().iter().map(|position| position.to_array()).collect();
    let shape = Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("the same corners")));
    Object::new(object.name.clone(), shape, object.placement, object.sides).expect("the same surface")
}

/// Where each number is in an order.
fn inverse(order: &[usize]) -> Vec<usize> {
    let mut places = vec![0; order.len()];
    order.iter().enumerate().for_each(|(place, &number)| places[number] = place);
    places
}
