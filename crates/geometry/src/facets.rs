//! Placed planar faces: what every flat body becomes before shadows are computed.
//!
//! A facet is a triangle or a parallelogram with its own parameter square: the point (u, v) is
//! A + u·(B − A) + v·(D − A), with A, B its first two corners and D its last.

mod joined;

use std::{
    collections::HashMap,
    ops::Deref,
    sync::{Arc, OnceLock},
};

use glam::DVec3;

use crate::{
    aabb::Aabb,
    approx::{Approx, sorted},
    brep::{Brep, Convex, Cuboid, HullDefect, canonical_loop},
    decisions::{Level, count},
    joints::Joints,
    light::LightSource,
    measures::TriangleMeasure,
    mesh::Mesh,
    parallelogram::{Parallelogram, area_between},
    placement::Placement,
    point::{Image, Point},
    predicates::{Target, float_light_filter, side_value},
    rectangle::Rectangle,
    ring::Sign,
    topology::Topology,
};

/// A planar face by its corners, counter-clockwise seen from its front (unless [`Facets::is_mirrored`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facet {
    /// Parameters u, v ≥ 0 with u + v ≤ 1.
    Triangle([u32; 3]),
    /// Parameters 0 ≤ u, v ≤ 1.
    Parallelogram([u32; 4]),
}

/// The corners of a facet, indices of points: three or four.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corners {
    /// The last repeats for a triangle.
    numbers: [u32; 4],
    count: u8,
}

impl Deref for Corners {
    type Target = [u32];

    #[inline]
    fn deref(&self) -> &[u32] {
        &self.numbers[..usize::from(self.count)]
    }
}

impl Facet {
    /// The corners, indices of points.
    #[inline]
    pub fn corners(&self) -> Corners {
        match *self {
            Self::Triangle([a, b, c]) => Corners { numbers: [a, b, c, c], count: 3 },
            Self::Parallelogram(numbers) => Corners { numbers, count: 4 },
        }
    }
}

/// Where a facet is measured from; see [`Facets::base`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Base {
    /// Which of the facet's corners: 0, 1 or 2.
    pub corner: u8,
    /// The lengths of the sides that meet there, to the next corner and to the last, metres, rounded.
    pub sides: [f64; 2],
}

/// The square of a vector's length, the squares of its coordinates added smallest first: the axes may change places
/// without changing the sum.
#[inline(always)]
pub fn length_squared(v: DVec3) -> f64 {
    let [least, middle, greatest] = sorted((v * v).to_array());
    (least + middle) + greatest
}

/// Where the points of facets are.
#[derive(Clone, Debug)]
enum Positions {
    /// A mesh that is not moved: its own vertices.
    OfMesh(Arc<Mesh>),
    Placed(Vec<DVec3>),
}

/// The faces by their points.
#[derive(Clone, Debug)]
enum Faces {
    /// The triangles of a mesh.
    OfMesh(Arc<Mesh>),
    Triangles(Vec<[u32; 3]>),
    Parallelograms(Vec<Parallelogram>),
}

/// The placed faces of one object. A mesh that is not moved is shared, not copied.
#[derive(Clone, Debug)]
pub struct Facets {
    positions: Positions,
    /// Empty when all positions are exact, else as long as `positions`.
    inexact: Vec<Image>,
    faces: Faces,
    mirrored: bool,
    /// Of triangles; those of the mesh where no vertices came together.
    joints: OnceLock<Arc<Joints>>,
    /// Of parallelograms.
    topology: OnceLock<Topology>,
}

impl Default for Facets {
    fn default() -> Self {
        Self::new(Positions::Placed(Vec::new()), Faces::Triangles(Vec::new()), false)
    }
}

impl Facets {
    fn new(positions: Positions, faces: Faces, mirrored: bool) -> Self {
        Self { positions, inexact: Vec::new(), faces, mirrored, joints: OnceLock::new(), topology: OnceLock::new() }
    }

    /// The triangles of a mesh, its vertices correctly rounded after placement. Facets and points are those of the mesh.
    /// O(vertices); nothing for the identity.
    pub fn of_mesh(mesh: impl Into<Arc<Mesh>>, placement: &Placement) -> Self {
        let mesh = mesh.into();
        let positions = if *placement == Placement::IDENTITY {
            Positions::OfMesh(Arc::clone(&mesh))
        } else {
            Positions::Placed(mesh.positions().iter().map(|&position| placement.round(position)).collect())
        };
        Self::new(positions, Faces::OfMesh(mesh), placement.is_mirrored())
    }

    /// The one facet of a rectangle, the exact image of its corners.
    pub fn of_rectangle(rectangle: &Rectangle, placement: &Placement) -> Self {
        Self::of_parallelograms(&rectangle.corners(), &[[0, 1, 2, 3]], placement)
    }

    /// The six facets of a box in the order of [`Cuboid::FACES`], the exact image of its corners.
    pub fn of_cuboid(cuboid: &Cuboid, placement: &Placement) -> Self {
        Self::of_parallelograms(&cuboid.corners(), &Cuboid::FACES, placement)
    }

    /// The triangles of a convex body: its points placed and rounded, then their hull, each face as a fan from its first
    /// corner. Points are the vertices in the order in which they are given (the first of equal ones), loops start at their
    /// first point, and faces are in lexicographic order of their loops. As with a mesh, a mirroring placement turns the
    /// loops round. So neither numbers nor parameters depend on where the body lies. About O(n log n).
    ///
    /// # Errors
    /// [`HullDefect`] when the placed points leave the accepted range or, rounded, lie in one plane.
    pub fn of_convex(convex: &Convex, placement: &Placement) -> Result<Self, HullDefect> {
        let placed: Vec<DVec3> = convex.points().iter().map(|&point| placement.round(point)).collect();
        let body = Brep::hull(placed.iter().copied())?;
        let (positions, loops) = numbered_as_given(&body, &placed, placement.is_mirrored());
        let fan = |corners: &Vec<u32>| -> Vec<[u32; 3]> {
            corners[1..].windows(2).map(|edge| [corners[0], edge[0], edge[1]]).collect()
        };
        let triangles = Faces::Triangles(loops.iter().flat_map(fan).collect());
        Ok(Self::new(Positions::Placed(positions), triangles, placement.is_mirrored()))
    }

    fn of_parallelograms(corners: &[DVec3], faces: &[[u32; 4]], placement: &Placement) -> Self {
        let shared = Arc::new(*placement);
        let images: Vec<Image> = corners.iter().map(|&corner| Image::new(&shared, corner)).collect();
        let positions = images.iter().map(|image| image.point().position).collect();
        let are_floats = images.iter().all(|image| image.point().slack == DVec3::ZERO);
        let faces = faces.iter().map(|&face| Parallelogram::new(face, corners, placement)).collect();
        let facets = Self::new(Positions::Placed(positions), Faces::Parallelograms(faces), placement.is_mirrored());
        Self { inexact: if are_floats { Vec::new() } else { images }, ..facets }
    }

    /// Number of facets.
    pub fn len(&self) -> usize {
        match &self.faces {
            Faces::OfMesh(mesh) => mesh.triangles().len(),
            Faces::Triangles(faces) => faces.len(),
            Faces::Parallelograms(faces) => faces.len(),
        }
    }

    /// Whether there are no facets.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A facet's corners.
    ///
    /// # Panics
    /// If there is no such facet.
    #[inline]
    pub fn facet(&self, facet: usize) -> Facet {
        match &self.faces {
            Faces::OfMesh(mesh) => Facet::Triangle(mesh.triangles()[facet]),
            Faces::Triangles(faces) => Facet::Triangle(faces[facet]),
            Faces::Parallelograms(faces) => Facet::Parallelogram(faces[facet].corners),
        }
    }

    /// The mesh that the facets are the triangles of, if that is what they are.
    pub(crate) fn mesh(&self) -> Option<&Mesh> {
        match &self.faces {
            Faces::OfMesh(mesh) => Some(mesh),
            Faces::Triangles(_) | Faces::Parallelograms(_) => None,
        }
    }

    /// All facets.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Facet> {
        (0..self.len()).map(|facet| self.facet(facet))
    }

    /// All facets as triangles, if that is what they are.
    pub fn triangles(&self) -> Option<&[[u32; 3]]> {
        match &self.faces {
            Faces::OfMesh(mesh) => Some(mesh.triangles()),
            Faces::Triangles(faces) => Some(faces),
            Faces::Parallelograms(_) => None,
        }
    }

    /// A corner, ready for predicates.
    ///
    /// # Panics
    /// If there is no such point.
    #[inline]
    pub fn point(&self, point: u32) -> Point<'_> {
        let position = self.positions()[point as usize];
        self.inexact.get(point as usize).map_or(Point::exact(position), Image::point)
    }

    /// The points' float positions, world coordinates in metres; within half an ulp of the exact ones.
    #[inline]
    pub fn positions(&self) -> &[DVec3] {
        match &self.positions {
            Positions::OfMesh(mesh) => mesh.positions(),
            Positions::Placed(positions) => positions,
        }
    }

    /// How far a float position may be from the exact one in any coordinate, metres; 0 where all are exact.
    pub fn slack(&self) -> f64 {
        self.inexact.iter().map(|image| image.point().slack.max_element()).fold(0.0, f64::max)
    }

    /// Whether all points are where their float positions are; [`Facets::slack`] says how far they are off else.
    pub fn are_floats(&self) -> bool {
        self.inexact.is_empty()
    }

    /// Whether the placement reversed the windings: the front is then where the corners run clockwise.
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// The corner from which a facet is measured and divided: of a triangle the one opposite the longest side, which gives the
    /// compactest parts. Of equally long sides it is the one whose corner has the lowest number, so that it is the
    /// same corner whichever the facet's corners begin with, and wherever it lies.
    ///
    /// # Panics
    /// If there is no such facet.
    #[inline(always)]
    pub fn base(&self, facet: usize) -> Base {
        if let Faces::Parallelograms(faces) = &self.faces {
            return Base { corner: 0, sides: faces[facet].sides };
        }
        self.measure(facet).base()
    }

    /// The corners of a triangle; of a parallelogram all but the last one.
    #[inline(always)]
    fn triangle(&self, facet: usize) -> [u32; 3] {
        match &self.faces {
            Faces::OfMesh(mesh) => mesh.triangles()[facet],
            Faces::Triangles(faces) => faces[facet],
            Faces::Parallelograms(faces) => [0, 1, 2].map(|corner| faces[facet].corners[corner]),
        }
    }

    /// A facet's corners from its base on ([`Facets::base`]).
    ///
    /// # Panics
    /// If there is no such facet.
    #[inline(always)]
    pub fn from_base(&self, facet: usize) -> Facet {
        let mut corners = self.facet(facet);
        if let Facet::Triangle(corners) = &mut corners {
            corners.rotate_left(usize::from(self.base(facet).corner));
        }
        corners
    }

    /// Components and closedness; a parallelogram counts as two triangles. The first call is O(n).
    pub fn topology(&self) -> &Topology {
        match &self.faces {
            Faces::OfMesh(mesh) => self.joints().topology(mesh.triangles()),
            Faces::Triangles(faces) => self.joints().topology(faces),
            Faces::Parallelograms(faces) => self.topology.get_or_init(|| {
                let halves: Vec<_> = faces.iter().flat_map(|face| halves(face.corners)).collect();
                let mut topology = Topology::of(halves.iter().copied());
                topology.component_of = topology.component_of.iter().copied().step_by(2).collect();
                topology
            }),
        }
    }

    /// Whether the facet belongs to a closed component. The first call finds the components.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn is_closed(&self, facet: usize) -> bool {
        let topology = self.topology();
        topology.components[topology.component_of[facet] as usize].is_closed()
    }

    /// On which side of the facet the light lies: positive before its front. Exact. Zero for a facet without area.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn light_side(&self, facet: usize, light: &LightSource) -> Sign {
        let turn = self.turn(facet, light);
        if self.mirrored { turn.flipped() } else { turn }
    }

    /// Which way the placed corners turn as seen from the light: positive counter-clockwise. The same as
    /// [`Facets::light_side`] unless the placement mirrors.
    ///
    /// # Panics
    /// If there is no such facet.
    #[inline]
    pub fn turn(&self, facet: usize, light: &LightSource) -> Sign {
        let corners = self.facet(facet).corners();
        let corners = [corners[0], corners[1], corners[corners.len() - 1]];
        if self.are_floats() {
            let [a, b, c] = corners.map(|corner| self.positions()[corner as usize]);
            let side = float_light_filter(a, b, c, light);
            if side.value.abs() > side.error {
                count(Level::Double, 1);
                return Sign::of(side.value);
            }
        }
        let [a, b, c] = corners.map(|corner| self.point(corner));
        Sign::of(side_value(&a, &b, &c, Target::Light(light)).value)
    }

    /// The facet's area in square metres, with its bound: of a triangle half the length of the cross product of the sides at its base, of
    /// the exact image of a parallelogram that of its sides. The squares are added smallest first, so the axes may change places without
    /// changing the sum.
    ///
    /// # Panics
    /// If there is no such facet.
    #[inline(always)]
    pub fn area(&self, facet: usize) -> Approx {
        if let Faces::Parallelograms(faces) = &self.faces {
            return faces[facet].area;
        }
        let measure = self.measure(facet);
        measure.area().unwrap_or_else(|| {
            let mut corners = self.triangle(facet);
            corners.rotate_left(usize::from(measure.base().corner));
            let [a, b, c] = corners.map(|corner| self.positions()[corner as usize]);
            let side = |end: DVec3| [0, 1, 2].map(|axis| Approx::exact(end[axis]) - Approx::exact(a[axis]));
            let doubled = area_between(side(b), side(c));
            Approx { value: 0.5 * doubled.value, error: 0.5 * doubled.error }
        })
    }

    #[inline(always)]
    fn measure(&self, facet: usize) -> TriangleMeasure {
        let corners = self.triangle(facet);
        TriangleMeasure::new(corners, corners.map(|corner| self.positions()[corner as usize]))
    }

    /// The areas of all facets.
    pub fn areas(&self) -> impl ExactSizeIterator<Item = Approx> {
        (0..self.len()).map(|facet| self.area(facet))
    }

    /// The box of a facet, rounded outward.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn facet_bounds(&self, facet: usize) -> Aabb {
        let corners = self.facet(facet).corners();
        corners.iter().map(|&corner| self.point(corner).bounds()).fold(Aabb::EMPTY, Aabb::union)
    }

    /// The box of all facets, rounded outward.
    pub fn bounds(&self) -> Aabb {
        (0..self.len()).fold(Aabb::EMPTY, |bounds, facet| bounds.union(self.facet_bounds(facet)))
    }
}

/// A parallelogram as two triangles.
fn halves([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// The vertices of the hull of `points` in the order of these, and the loops of its faces, from their first vertex on, sorted;
/// clockwise seen from outside if the points are `mirrored`.
fn numbered_as_given(body: &Brep, points: &[DVec3], mirrored: bool) -> (Vec<DVec3>, Vec<Vec<u32>>) {
    let mut firsts: HashMap<[u64; 3], usize> = HashMap::with_capacity(points.len());
    for (number, point) in points.iter().enumerate() {
        // Accepted numbers hold no −0, so equal numbers have equal bits.
        firsts.entry(point.to_array().map(f64::to_bits)).or_insert(number);
    }
    let first = |vertex: u32| firsts[&body.vertices()[vertex as usize].to_array().map(f64::to_bits)];
    let mut order: Vec<u32> = (0..body.vertices().len() as u32).collect();
    order.sort_unstable_by_key(|&vertex| first(vertex));
    let mut number = vec![0; order.len()];
    (0..).zip(&order).for_each(|(new, &vertex)| number[vertex as usize] = new);
    let mut loops: Vec<Vec<u32>> = (0..body.face_count())
        .map(|face| {
            let mut corners: Vec<u32> = body.face(face).map(|vertex| number[vertex as usize]).collect();
            if mirrored {
                corners.reverse();
            }
            canonical_loop(corners)
        })
        .collect();
    loops.sort_unstable();
    (order.iter().map(|&vertex| body.vertices()[vertex as usize]).collect(), loops)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DQuat};

    #[test]
    fn a_mirrored_box_keeps_its_outside() {
        let sun = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
        for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(2.0, -3.0, 0.5)] {
            let placement = Placement::new(DAffine3::from_scale(scale)).expect("regular");
            let facets = Facets::of_cuboid(&Cuboid { size: [1.0; 3] }, &placement);
            let lit = (0..6).filter(|&f| facets.light_side(f, &sun) == Sign::Positive).collect::<Vec<_>>();
            let top = if scale.y < 0.0 { 2 } else { 3 };
            assert_eq!(lit, [top], "only the upper side faces the sun");
            assert!((0..6).all(|f| facets.is_closed(f)));
        }
    }

    #[test]
    fn rotated_corners_know_their_slack() {
        let turned = DAffine3::from_quat(DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize());
        let facets = Facets::of_rectangle(&Rectangle { size: [3.0, 1.0] }, &Placement::new(turned).expect("regular"));
        assert!(facets.point(0).exact.is_some(), "no float is the corner");
        assert!(!facets.is_closed(0));
        let square = Facets::of_rectangle(&Rectangle { size: [3.0, 1.0] }, &Placement::IDENTITY);
        assert!(square.point(0).exact.is_none());
    }
}
