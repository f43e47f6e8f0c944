//! Objects that are one body given several times.

use std::{
    collections::HashMap,
    hash::{Hash, Hasher},
    mem::discriminant,
    sync::Arc,
};

use glam::DVec3;
use umbriel_geometry::Mesh;

use crate::object::{Object, Shape};

/// For each object the first one that is the same body in the same place, itself where there is none before it: the shapes and the placements have the same
/// numbers, so that the same faces stand in the same order at the same points. Two meshes may be given apart; with holes, these are equal too.
/// Names, sides and boxes are no part of a body. A body that two placements bring to one place by different numbers counts as two.
///
/// Cost: some 100 ns an object, and a look at those meshes that have the sizes and a few vertices of another one.
#[allow(clippy::mutable_key_type, reason = "what a mesh finds out later about itself is no part of its numbers")]
pub fn first_alike<'a>(objects: impl IntoIterator<Item = &'a Object>) -> Vec<usize> {
    let objects: Vec<&Object> = objects.into_iter().collect();
    let firsts = first_meshes(&objects);
    let mut known: HashMap<Body, usize> = HashMap::with_capacity(objects.len());
    let bodies = objects.into_iter().map(|object| {
        let mesh = mesh_of(object).map(Arc::as_ptr);
        Body { object, mesh: mesh.map(|mesh| firsts.get(&mesh).copied().unwrap_or(mesh)) }
    });
    bodies.enumerate().map(|(number, body)| *known.entry(body).or_insert(number)).collect()
}

fn mesh_of(object: &Object) -> Option<&Arc<Mesh>> {
    if let Shape::Mesh(mesh) = &object.shape { Some(mesh) } else { None }
}

/// For each mesh that has the same numbers as one before it, the first of these.
#[allow(clippy::mutable_key_type, reason = "what a mesh finds out later about itself is no part of its numbers")]
fn first_meshes(objects: &[&Object]) -> HashMap<*const Mesh, *const Mesh> {
    let mut meshes: Vec<&Mesh> = objects.iter().filter_map(|object| mesh_of(object)).map(|mesh| &**mesh).collect();
    // Instances mostly follow each other.
    meshes.dedup_by(|one, other| std::ptr::eq(*one, *other));
    let glances: Vec<Glance> = meshes.iter().map(|mesh| Glance::of(mesh)).collect();
    let mut counts: HashMap<&Glance, u32> = HashMap::with_capacity(meshes.len());
    for glance in &glances {
        *counts.entry(glance).or_default() += 1;
    }
    let mut known: HashMap<Numbers, *const Mesh> = HashMap::new();
    let mut firsts: HashMap<*const Mesh, *const Mesh> = HashMap::new();
    for (mesh, _) in meshes.into_iter().zip(&glances).filter(|(_, glance)| counts[glance] > 1) {
        firsts.entry(mesh).or_insert_with(|| *known.entry(Numbers(mesh)).or_insert(mesh));
    }
    firsts
}

/// What a look at a few of its numbers tells of a mesh: meshes that differ in it are not equal.
#[derive(PartialEq, Eq, Hash)]
struct Glance {
    vertices: usize,
    triangles: usize,
    /// The vertices at the beginning, in the middle and at the end; −0 is 0.
    places: [[u64; 3]; 3],
}

impl Glance {
    fn of(mesh: &Mesh) -> Self {
        let positions = mesh.positions();
        let (vertices, triangles) = (positions.len(), mesh.triangles().len());
        let place = |index: usize| positions.get(index).map_or([0; 3], |place| place.to_array().map(bits));
        Self { vertices, triangles, places: [0, vertices / 2, vertices.saturating_sub(1)].map(place) }
    }
}

/// A mesh by its numbers.
#[derive(PartialEq)]
struct Numbers<'a>(&'a Mesh);

/// No number of a mesh is NaN.
impl Eq for Numbers<'_> {}

impl Hash for Numbers<'_> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        hash_points(self.0.positions(), state);
        self.0.triangles().as_flattened().hash(state);
    }
}

/// An object by its shape and placement.
struct Body<'a> {
    object: &'a Object,
    /// The first mesh that is equal to its own.
    mesh: Option<*const Mesh>,
}

impl PartialEq for Body<'_> {
    fn eq(&self, other: &Self) -> bool {
        let is_same_shape = match (&self.object.shape, &other.object.shape) {
            (Shape::Mesh(_), Shape::Mesh(_)) => self.mesh == other.mesh,
            (Shape::Rectangle(a), Shape::Rectangle(b)) => a == b,
            (Shape::Cuboid(a), Shape::Cuboid(b)) => a == b,
            (Shape::Convex(a), Shape::Convex(b)) => a == b,
            (Shape::Analytic(a), Shape::Analytic(b)) => a == b,
            _ => false,
        };
        is_same_shape && self.object.placement == other.object.placement
    }
}

/// No number of an object is NaN.
impl Eq for Body<'_> {}

impl Hash for Body<'_> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        hash_numbers(self.object.placement.map().to_cols_array(), state);
        discriminant(&self.object.shape).hash(state);
        match &self.object.shape {
            Shape::Mesh(_) => self.mesh.hash(state),
            Shape::Rectangle(rectangle) => hash_numbers(rectangle.size, state),
            Shape::Cuboid(cuboid) => hash_numbers(cuboid.size, state),
            Shape::Convex(body) => hash_points(body.points(), state),
            Shape::Analytic(body) => {
                discriminant(&**body).hash(state);
                hash_numbers(body.numbers(), state);
            }
        }
    }
}

/// Numbers that are equal have one hash, −0 and 0 as well.
fn hash_numbers<H: Hasher>(numbers: impl IntoIterator<Item = f64>, state: &mut H) {
    numbers.into_iter().for_each(|number| state.write_u64(bits(number)));
}

/// The bits of a number; those of 0 for −0, which it equals.
fn bits(number: f64) -> u64 {
    (number + 0.0).to_bits()
}

fn hash_points<H: Hasher>(points: &[DVec3], state: &mut H) {
    points.iter().for_each(|point| hash_numbers(point.to_array(), state));
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;
    use umbriel_geometry::{Analytic, Convex, Cuboid, Placement, Rectangle};

    use super::*;
    use crate::object::Sides;

    fn mesh(last: [f64; 3]) -> Shape {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], last];
        Shape::Mesh(Arc::new(Mesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).expect("a mesh")))
    }

    fn hull(height: f64) -> Shape {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, height, 0.0]];
        Shape::Convex(Arc::new(Convex::new(points).expect("a hull")))
    }

    #[test]
    fn bodies_are_told_by_their_numbers_and_their_place() {
        let shared = mesh([0.0, 0.0, 1.0]);
        let shapes = [
            shared.clone(),
            mesh([0.0, 0.0, 2.0]),
            Shape::Rectangle(Rectangle { size: [2.0, 2.0] }),
            Shape::Cuboid(Cuboid { size: [2.0; 3] }),
            Shape::from(Analytic::Sphere { radius: 2.0 }),
            Shape::from(Analytic::Disk { radius: 2.0 }),
            Shape::from(Analytic::Sphere { radius: 2.5 }),
            hull(1.0),
            hull(2.0),
        ];
        let object = |shape: &Shape, x: f64, sides: Sides| {
            let placement = Placement::new(DAffine3::from_translation(DVec3::X * x)).expect("regular");
            Object::new(format!("at {x}"), shape.clone(), placement, sides).expect("an object")
        };
        let given: Vec<Object> = shapes.iter().map(|shape| object(shape, 0.0, Sides::Auto)).collect();
        let moved = shapes.iter().map(|shape| object(shape, 1.0, Sides::Auto));
        // Meshes and hulls given anew, and looked at from other sides.
        let again = [mesh([0.0, 0.0, 1.0]), mesh([0.0, 0.0, 2.0]), hull(2.0), shared];
        let again = again.iter().map(|shape| object(shape, 0.0, Sides::Two));
        let turned = shapes[2..6].iter().map(|shape| object(shape, -0.0, Sides::One));
        let objects: Vec<Object> = given.iter().cloned().chain(moved).chain(again).chain(turned).collect();
        let expected: Vec<usize> = (0..18).chain([0, 1, 8, 0]).chain(2..6).collect();
        assert_eq!(first_alike(&objects), expected);
        assert!(first_alike(&[]).is_empty());
    }

    #[test]
    fn meshes_that_differ_where_no_glance_falls_are_two() {
        let mesh = |second: f64| {
            let positions = vec![[0.0; 3], [second, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            Mesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).expect("a mesh")
        };
        assert!(Glance::of(&mesh(1.0)) == Glance::of(&mesh(2.0)));
        let object = |second: f64| {
            let shape = Shape::Mesh(Arc::new(mesh(second)));
            Object::new("mesh".into(), shape, Placement::IDENTITY, Sides::Auto).expect("an object")
        };
        assert_eq!(first_alike(&[1.0, 2.0, 1.0].map(object)), [0, 1, 0]);
    }

    #[test]
    fn zeros_of_both_signs_are_one_number_in_every_shape() {
        let hash = |zero: f64| {
            let matrix = [[1.0, 0.0, zero, 0.0], [0.0, 1.0, 0.0, 0.0], [zero, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, -1.0]];
            let shape = Shape::from(Analytic::Quadric { matrix, within: [[-1.0, zero, -1.0], [1.0; 3]] });
            let object = Object::new("quadric".into(), shape, Placement::IDENTITY, Sides::Auto).expect("an object");
            let mut state = std::hash::DefaultHasher::new();
            Body { object: &object, mesh: None }.hash(&mut state);
            state.finish()
        };
        assert_eq!(hash(0.0), hash(-0.0));
        assert_ne!(hash(0.0), hash(0.5));
    }
}
