//! Histories of edits: objects come, go and move; many touch, overlap and coincide.
//!
//! What an editor does to a scene, for programs that keep results from one state to the next: after every edit the answers
//! must be those of the state as it stands, whatever it was before.

use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, Placement, Rectangle};
use umbriel_scene::{Object, Scene, Shape, Sides};

use super::{Random, hull, mesh};

/// One change of a scene.
#[derive(Clone, Debug)]
pub enum Edit {
    /// An object is put at the end of the list.
    Add(Box<Object>),
    /// The object with this number goes; later ones move up.
    Remove(usize),
    /// The object with this number stands elsewhere.
    Move {
        /// Which one.
        object: usize,
        /// Where it stands now.
        to: Placement,
    },
}

impl Edit {
    /// Does it.
    ///
    /// # Panics
    /// When the scene does not have the object, or the placement is too much for it.
    pub fn apply(&self, scene: &mut Scene) {
        match self {
            Self::Add(object) => scene.objects.push((**object).clone()),
            Self::Remove(object) => drop(scene.objects.remove(*object)),
            Self::Move { object, to } => {
                let moved = scene.objects[*object].moved(*to);
                scene.objects[*object] = moved.expect("a placement for this object");
            }
        }
    }
}

/// Edits to be applied one after the other, from an empty scene on. There are never more than twelve objects; from the first edit
/// on there is at least one, and names stay unique.
pub fn history(edits: usize, random: &mut Random) -> Vec<Edit> {
    let mut count = 0;
    let shared = tetrahedron(1.0);
    let mut edit = |number: usize| {
        let choice = if count < 2 { 0 } else { random.below(4) };
        if choice == 0 && count < 12 {
            count += 1;
            return Edit::Add(Box::new(any_object(format!("object {number}"), &shared, random)));
        }
        let object = random.below(count as u64) as usize;
        if choice == 1 || count == 12 {
            count -= 1;
            return Edit::Remove(object);
        }
        Edit::Move { object, to: any_placement(random) }
    };
    (0..edits).map(&mut edit).collect()
}

fn corners_of_tetrahedron(size: f64) -> [DVec3; 4] {
    [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| p * size)
}

fn tetrahedron(size: f64) -> Shape {
    mesh(&corners_of_tetrahedron(size), &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
}

/// Some body; `shared` is the mesh of all instances.
fn any_object(name: String, shared: &Shape, random: &mut Random) -> Object {
    let size = random.pick(&[1.0, 2.0, 4.0]);
    let shape = match random.below(8) {
        0 => Shape::Rectangle(Rectangle { size: [size, 2.0] }),
        1 => Shape::Cuboid(Cuboid { size: [size, 1.0, 2.0] }),
        2 => Shape::from(Analytic::Sphere { radius: size / 2.0 }),
        3 => Shape::from(Analytic::Ellipsoid { radii: [size / 2.0, 0.5, 1.0] }),
        4 => hull(&corners_of_tetrahedron(size)).expect("a tetrahedron"),
        5 => tetrahedron(size),
        6 => shared.clone(),
        _ => mesh(&[DVec3::ZERO, DVec3::Z * size, DVec3::X * size], &[[0, 1, 2]]),
    };
    let sides = random.pick(&[Sides::Auto, Sides::Auto, Sides::One, Sides::Two]);
    Object::new(name, shape, any_placement(random), sides).expect("sizes near one")
}

/// On a coarse lattice, so that objects often touch; axes are exchanged and mirrored at times.
fn any_placement(random: &mut Random) -> Placement {
    let translation = DVec3::from_array([(); 3].map(|()| random.below(9) as f64 / 2.0 - 2.0));
    let matrix3 = match random.below(4) {
        0 => DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
        1 => DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
        _ => DMat3::IDENTITY,
    };
    Placement::new(DAffine3 { matrix3, translation }).expect("a regular matrix")
}
