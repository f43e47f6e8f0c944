//! A scene made ready for one picture: the faces that may be seen, each with its footprint, in the order of ties.
//!
//! **Back faces** are left out where the body is convex and closed by exact signs (a box, a hull, a mesh that
//! [`Brep::of_mesh`] takes) and the eye is strictly outside: then a ray enters the body by a face that is turned to the eye no
//! later than it meets one that is turned away. Both at once happens on the outline, where the tie rule may ask for the face
//! that is turned away; so this one stays if it shares a corner with a seen face of a higher number. Closed concave bodies
//! keep all faces: surfaces may run through themselves, and then a back face can be nearest.
//!
//! O(faces), and a sort of the corners of convex bodies.

use glam::DVec3;
use rayon::prelude::*;
use umbriel_bvh::Ray;
use umbriel_geometry::{Aabb, Brep, Facets, LightDefect, LightSource, Mesh, PlacedAnalytic, Sign};
use umbriel_scene::{Object, Scene};

use super::{
    footprint::{Footprint, Outline, footprint_of_box},
    frame::Frame,
    window::Window,
};
use crate::view::{EyeRays, View};

/// Why no picture can be taken.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShotDefect {
    /// A picture without pixels, or with edges above 2^15.
    #[error("a picture of {width} × {height} pixels: edges are from 1 to {most}", most = Shot::LARGEST_EDGE)]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A field of view or a height that is not positive and finite, or none of the known projections.
    #[error("the camera's field of view or height is not accepted")]
    Projection,
    /// The eye, or its direction.
    #[error("the camera's eye or direction: {0}")]
    Eye(LightDefect),
}

/// The surface of an object, placed.
#[derive(Debug)]
pub(super) enum Body {
    Flat(Facets),
    Curved(Box<PlacedAnalytic>),
    /// A shape that this layer does not know; it is not seen.
    Unknown,
}

/// A scene made ready for the picture of one view.
#[derive(Debug)]
pub struct Shot {
    rays: EyeRays,
    pub(super) frame: Frame,
    pub(super) eye: LightSource,
    pub(super) bodies: Vec<Body>,
    /// In the order of objects and their faces: of two at the same depth the lower one is seen.
    pub(super) footprints: Vec<Footprint>,
    faces: u64,
    removed: u64,
}

impl Shot {
    /// Largest edge of a picture, pixels.
    pub const LARGEST_EDGE: u32 = 1 << 15;

    /// Places all faces and finds what each may cover. O(faces); threads take objects.
    ///
    /// # Errors
    /// [`ShotDefect`].
    pub fn new(scene: &Scene, view: &View) -> Result<Self, ShotDefect> {
        Self::of_objects(scene, &Vec::from_iter(0..scene.objects.len()), view)
    }

    /// As [`Shot::new`], of some objects only, by their indices, ascending.
    ///
    /// # Errors
    /// [`ShotDefect`].
    ///
    /// # Panics
    /// If the scene does not have one of them.
    pub fn of_objects(scene: &Scene, objects: &[usize], view: &View) -> Result<Self, ShotDefect> {
        let View { width, height, .. } = *view;
        if [width, height].iter().any(|&edge| edge == 0 || edge > Self::LARGEST_EDGE) {
            return Err(ShotDefect::Size { width, height });
        }
        let frame = Frame::new(view);
        if !(frame.scale > 0.0 && frame.scale.is_finite()) {
            return Err(ShotDefect::Projection);
        }
        let eye = frame.eye()?;
        let picture = Window { left: 0, top: 0, right: width, bottom: height };
        let is_taken = |object: usize| objects.binary_search(&object).is_ok();
        let body = |(number, object): (usize, &Object)| if is_taken(number) { Body::of(object) } else { Body::Unknown };
        let bodies: Vec<Body> = scene.objects.par_iter().enumerate().map(body).collect();
        let scope = Scope { frame: &frame, picture, eye: &eye };
        let found: Vec<Found> =
            bodies.par_iter().enumerate().map(|(object, body)| scope.faces_of(object as u32, body)).collect();
        let faces = found.iter().map(|found| found.faces).sum();
        let removed = found.iter().map(|found| found.removed).sum();
        let footprints = found.into_iter().flat_map(|found| found.footprints).collect();
        Ok(Self { rays: view.rays(), frame, eye, bodies, footprints, faces, removed })
    }

    /// The view that it was made for.
    pub fn view(&self) -> &View {
        self.rays.view()
    }

    /// The rays of that view.
    pub fn rays(&self) -> &EyeRays {
        &self.rays
    }

    /// All faces of the scene; a curved body counts as one.
    pub fn faces(&self) -> u64 {
        self.faces
    }

    /// Faces that may be seen: in front of the eye, not edge-on, over a pixel centre.
    pub fn faces_in_picture(&self) -> usize {
        self.footprints.len()
    }

    /// Back faces of convex bodies that were left out.
    pub fn back_faces_removed(&self) -> u64 {
        self.removed
    }

    /// The exact ray through the centre of a pixel.
    pub(super) fn ray(&self, [column, row]: [u32; 2]) -> Ray {
        self.rays.of_pixel((column, row))
    }

    /// The world box of a face, rounded outward.
    pub(super) fn bounds(&self, face: u32) -> Aabb {
        let footprint = &self.footprints[face as usize];
        match &self.bodies[footprint.object as usize] {
            Body::Flat(facets) => facets.facet_bounds(footprint.face as usize),
            Body::Curved(body) => body.bounds(),
            Body::Unknown => Aabb::EMPTY,
        }
    }
}

impl Body {
    fn of(object: &Object) -> Self {
        let curved = || object.analytic().map(|body| Self::Curved(Box::new(body)));
        object.facets().map(Self::Flat).or_else(curved).unwrap_or(Self::Unknown)
    }
}

/// What the footprints of a body are made with.
struct Scope<'a> {
    frame: &'a Frame,
    picture: Window,
    eye: &'a LightSource,
}

/// The footprints of a body.
#[derive(Default)]
struct Found {
    footprints: Vec<Footprint>,
    faces: u64,
    removed: u64,
}

impl Scope<'_> {
    fn faces_of(&self, object: u32, body: &Body) -> Found {
        match body {
            Body::Flat(facets) => self.flat_faces_of(object, facets),
            Body::Curved(body) => {
                let footprint = footprint_of_box(self.frame, &self.picture, &body.bounds());
                let footprints = footprint.map(|footprint| Footprint { object, ..footprint });
                Found { footprints: footprints.into_iter().collect(), faces: 1, removed: 0 }
            }
            Body::Unknown => Found::default(),
        }
    }

    fn flat_faces_of(&self, object: u32, facets: &Facets) -> Found {
        let (positions, slack) = (facets.positions(), facets.slack());
        let is_hidden = self.back_faces(facets);
        let footprint = |face: usize| {
            if is_hidden.get(face).copied().unwrap_or(false) {
                return None;
            }
            let numbers = facets.facet(face).corners();
            let mut corners = [DVec3::ZERO; 4];
            corners.iter_mut().zip(numbers.iter()).for_each(|(corner, &number)| *corner = positions[number as usize]);
            let outline = Outline { corners: &corners[..numbers.len()], slack };
            let (_, footprint) = outline.footprint(self.frame, &self.picture, || facets.turn(face, self.eye))?;
            Some(Footprint { object, face: face as u32, ..footprint })
        };
        let footprints = (0..facets.len()).into_par_iter().filter_map(footprint).collect();
        let removed = is_hidden.iter().filter(|&&is_hidden| is_hidden).count() as u64;
        Found { footprints, faces: facets.len() as u64, removed }
    }

    /// The back faces that can be left out, see the header; empty where none can.
    fn back_faces(&self, facets: &Facets) -> Vec<bool> {
        if !self.is_ahead(facets) || !is_convex(facets) {
            return Vec::new();
        }
        let sides: Vec<Sign> = (0..facets.len()).map(|face| facets.light_side(face, self.eye)).collect();
        if !sides.contains(&Sign::Positive) {
            return Vec::new();
        }
        let corners = |face: usize| {
            let numbers = facets.facet(face).corners();
            (0..numbers.len()).map(move |k| facets.first_at(numbers[k]) as usize)
        };
        let mut highest_front: Vec<Option<usize>> = vec![None; facets.positions().len()];
        for face in (0..facets.len()).filter(|&face| sides[face] == Sign::Positive) {
            corners(face).for_each(|corner| highest_front[corner] = Some(face));
        }
        let is_hidden = |face: usize| {
            sides[face] == Sign::Negative && corners(face).all(|corner| highest_front[corner] < Some(face))
        };
        (0..facets.len()).map(is_hidden).collect()
    }

    /// Whether rays that start in a plane start in front of the whole body. Those from an eye outside of it do.
    fn is_ahead(&self, facets: &Facets) -> bool {
        let ahead = |&position: &DVec3| {
            let point = self.frame.point(position);
            point.z > self.frame.blur(point, facets.slack())
        };
        !self.frame.is_parallel || facets.positions().iter().all(ahead)
    }
}

/// More faces than this are not asked whether they are convex: few convex bodies of a scene have so many.
const MOST_CONVEX: usize = 1 << 16;

/// Whether the faces bound a convex body and look outward, by exact signs.
fn is_convex(facets: &Facets) -> bool {
    let Some(triangles) = facets.triangles() else { return facets.len() == 6 };
    if facets.len() < 4 || facets.len() > MOST_CONVEX || facets.is_mirrored() || !facets.is_closed(0) {
        return false;
    }
    let positions = facets.positions().iter().map(|position| position.to_array()).collect();
    Mesh::new(positions, triangles.to_vec()).is_ok_and(|mesh| Brep::of_mesh(&mesh).is_ok())
}
