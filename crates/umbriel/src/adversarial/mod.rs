//! Input that aims at the borders of every decision, for tests (feature `test-support`).
//!
//! Random input hardly ever meets a border, so it proves little: two random lines miss each other by far. What is made
//! here lies on a border, or within [`REACH`] units in the last place of it: segments that graze planes, edges, vertices
//! and curved bodies, or start where surfaces overlap ([`segment`]); shadows whose outline runs through a corner of a cell
//! ([`outline_through_corner`]); whole scenes of one kind of trouble ([`family`]); and histories of edits ([`history`]) for whoever keeps results of one state for the next. No
//! answer comes with it: the judge must be another one than what is judged.
//!
//! Everything is made from a [`Random`], so a seed says it all. Cost: below a microsecond a number, some for a scene.
//!
//! ```
//! use umbriel::{adversarial::{Aim, Random, segment}, shadow::Queries};
//!
//! let grazing = segment(Aim::Edge, &mut Random::new(7));
//! let queries = Queries::new(&grazing.scene);
//! let answer = queries.lit(&grazing.place, &grazing.light)?;
//! assert!(!answer.in_space);
//! # Ok::<(), umbriel::shadow::QueryDefect>(())
//! ```

mod corner;
mod family;
mod history;
mod random;
mod segment;

use std::sync::Arc;

use glam::DVec3;
use umbriel_geometry::{Convex, MIN_MAGNITUDE, Mesh, Placement};
use umbriel_scene::{Object, Shape, Sides};

pub use corner::{CornerTrial, outline_through_corner};
pub use family::{Family, FamilyTrial, family};
pub use history::{Edit, history};
pub use random::Random;
pub use segment::{Aim, SegmentTrial, segment};

/// How far from the border coordinates are moved, in units of their last place.
pub const REACH: u64 = 32;

/// A way to put small numbers into the world: none, far from the origin, tiny, huge.
#[derive(Clone, Copy, Debug)]
struct World {
    scale: f64,
    offset: DVec3,
}

impl World {
    fn any(random: &mut Random) -> Self {
        let near = Self { scale: 1.0, offset: DVec3::ZERO };
        match random.below(6) {
            0 => {
                let exponent = (random.below(121) as i32 - 60) * random.pick(&[1, 1, 3]);
                Self { scale: 2f64.powi(exponent), ..near }
            }
            1 => Self { offset: DVec3::new(1e6, -3e5, 7e4) * random.between(0.1, 1.0), ..near },
            2 => Self { scale: random.between(0.1, 10.0), ..near },
            _ => near,
        }
    }

    fn place(&self, point: DVec3) -> DVec3 {
        point * self.scale + self.offset
    }
}

/// A point on a lattice (coincidences are exact and frequent), or anywhere.
fn any_point(random: &mut Random) -> DVec3 {
    let on_lattice = random.below(2) == 0;
    let mut coordinate = || if on_lattice { random.below(17) as f64 / 2.0 - 4.0 } else { random.between(-4.0, 4.0) };
    DVec3::new(coordinate(), coordinate(), coordinate())
}

/// An object as it stands, of a shape that is accepted.
fn standing(name: String, shape: Shape, sides: Sides) -> Object {
    Object::new(name, shape, Placement::IDENTITY, sides).expect("coordinates far inside the accepted range")
}

/// The number, or zero where it is too small to be accepted: what differences of tiny numbers leave.
fn accepted(number: f64) -> f64 {
    if number.abs() < MIN_MAGNITUDE { 0.0 } else { number }
}

/// A mesh of these points and triangles.
fn mesh(points: &[DVec3], triangles: &[[u32; 3]]) -> Shape {
    let positions = points.iter().map(|point| point.to_array().map(accepted)).collect();
    Shape::Mesh(Arc::new(Mesh::new(positions, triangles.to_vec()).expect("numbers and indices in range")))
}

/// The hull of these points; `None` where they have none.
fn hull(points: &[DVec3]) -> Option<Shape> {
    let points = points.iter().map(|point| point.to_array().map(accepted)).collect();
    Convex::new(points).ok().map(|convex| Shape::Convex(convex.into()))
}
