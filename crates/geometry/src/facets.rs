//! Placed planar faces: what every flat body becomes before shadows are computed.
//!
//! A facet is a triangle or a parallelogram with its own parameter square: the point (u, v) is
//! A + u·(B − A) + v·(D − A), with A, B its first two corners and D its last.

use glam::DVec3;

use crate::{
    aabb::Aabb,
    approx::Approx,
    brep::{Convex, Cuboid, HullDefect},
    light::LightSource,
    mesh::Mesh,
    placement::Placement,
    point::{ExactPoint, Point},
    predicates::{Target, side_value},
    rectangle::Rectangle,
    ring::Sign,
    topology::{Topology, unify},
};

/// A planar face by its corners, counter-clockwise seen from its front (unless [`Facets::is_mirrored`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facet {
    /// Parameters u, v ≥ 0 with u + v ≤ 1.
    Triangle([u32; 3]),
    /// Parameters 0 ≤ u, v ≤ 1.
    Parallelogram([u32; 4]),
}

impl Facet {
    /// The corners, indices of points.
    pub fn corners(&self) -> &[u32] {
        match self {
            Self::Triangle(corners) => corners,
            Self::Parallelogram(corners) => corners,
        }
    }
}

/// The exact image of a corner that no float hits.
#[derive(Clone, Debug)]
struct Inexact {
    slack: DVec3,
    exact: ExactPoint,
}

/// The placed faces of one object. Equal positions are one point.
#[derive(Clone, Debug, Default)]
pub struct Facets {
    positions: Vec<DVec3>,
    /// Empty when all positions are exact, else as long as `positions`.
    inexact: Vec<Inexact>,
    facets: Vec<Facet>,
    mirrored: bool,
    topology: Topology,
}

impl Facets {
    /// The triangles of a mesh, its vertices correctly rounded after placement. Facets are in the order of the mesh's
    /// triangles. O(n log n).
    pub fn of_mesh(mesh: &Mesh, placement: &Placement) -> Self {
        let placed: Vec<DVec3> = mesh.positions().iter().map(|&position| placement.round(position)).collect();
        let (positions, place) = unify(&placed);
        let triangles = mesh.triangles().iter().map(|corners| corners.map(|corner| place[corner as usize]));
        let topology = Topology::of(triangles.clone());
        let facets = triangles.map(Facet::Triangle).collect();
        Self { positions, inexact: Vec::new(), facets, mirrored: placement.is_mirrored(), topology }
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
    /// corner. Faces, and corners within them, are in the order that [`crate::Brep::hull`] documents, so facets keep
    /// their numbers whatever the order of the points. Never mirrored. About O(n log n).
    ///
    /// # Errors
    /// [`HullDefect`] when the placed points leave the accepted range or, rounded, lie in one plane.
    pub fn of_convex(convex: &Convex, placement: &Placement) -> Result<Self, HullDefect> {
        let body = convex.placed(placement)?;
        let triangles: Vec<[u32; 3]> = body.triangles().collect();
        Ok(Self {
            positions: body.vertices().to_vec(),
            inexact: Vec::new(),
            topology: Topology::of(triangles.iter().copied()),
            facets: triangles.into_iter().map(Facet::Triangle).collect(),
            mirrored: false,
        })
    }

    fn of_parallelograms(corners: &[DVec3], faces: &[[u32; 4]], placement: &Placement) -> Self {
        let positions: Vec<DVec3> = corners.iter().map(|&corner| placement.round(corner)).collect();
        let inexact: Vec<Inexact> = corners.iter().map(|&corner| Inexact::new(placement, corner)).collect();
        let exact = inexact.iter().all(|point| point.slack == DVec3::ZERO);
        let halves = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect::<Vec<_>>();
        let mut topology = Topology::of(halves.iter().copied());
        topology.component_of = topology.component_of.iter().copied().step_by(2).collect();
        Self {
            positions,
            inexact: if exact { Vec::new() } else { inexact },
            facets: faces.iter().map(|&face| Facet::Parallelogram(face)).collect(),
            mirrored: placement.is_mirrored(),
            topology,
        }
    }

    /// Number of facets.
    pub fn len(&self) -> usize {
        self.facets.len()
    }

    /// Whether there are no facets.
    pub fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// A facet's corners.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn facet(&self, facet: usize) -> &Facet {
        &self.facets[facet]
    }

    /// All facets.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Facet> {
        self.facets.iter()
    }

    /// A corner, ready for predicates.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn point(&self, point: u32) -> Point<'_> {
        let position = self.positions[point as usize];
        match self.inexact.get(point as usize) {
            Some(inexact) => Point { position, slack: inexact.slack, exact: Some(&inexact.exact) },
            None => Point { position, slack: DVec3::ZERO, exact: None },
        }
    }

    /// The points' float positions, world coordinates in metres; within half an ulp of the exact ones.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Whether the placement reversed the windings: the front is then where the corners run clockwise.
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// Components and closedness; a parallelogram counts as two triangles.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Whether the facet belongs to a closed component.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn is_closed(&self, facet: usize) -> bool {
        self.topology.components[self.topology.component_of[facet] as usize].is_closed()
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
    pub fn turn(&self, facet: usize, light: &LightSource) -> Sign {
        let corners = self.facets[facet].corners();
        let [a, b, c] = [corners[0], corners[1], corners[corners.len() - 1]].map(|corner| self.point(corner));
        Sign::of(side_value(&a, &b, &c, Target::Light(light)).value)
    }

    /// The facet's area in square metres, with its bound: half the length of a cross product (twice that for a
    /// parallelogram). The squares are added smallest first, so the axes may change places without changing the sum.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn area(&self, facet: usize) -> Approx {
        let corners = self.facets[facet].corners();
        let [a, b, d] =
            [corners[0], corners[1], corners[corners.len() - 1]].map(|corner| self.point(corner).coordinates());
        let (u, v): ([Approx; 3], [Approx; 3]) =
            (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| d[i] - a[i]));
        let mut squares = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
            let component = u[i] * v[j] - u[j] * v[i];
            component * component
        });
        squares.sort_by(|x, y| x.value.total_cmp(&y.value));
        let doubled = (squares[0] + squares[1] + squares[2]).square_root();
        let half = if matches!(self.facets[facet], Facet::Triangle(_)) { 0.5 } else { 1.0 };
        Approx { value: doubled.value * half, error: doubled.error * half }
    }

    /// The box of a facet, rounded outward.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn facet_bounds(&self, facet: usize) -> Aabb {
        let points = self.facets[facet].corners().iter().map(|&corner| self.point(corner));
        points.fold(Aabb::EMPTY, |bounds, point| {
            bounds.union(Aabb { min: point.position, max: point.position }.widened(point.slack))
        })
    }

    /// The box of all facets, rounded outward.
    pub fn bounds(&self) -> Aabb {
        (0..self.len()).fold(Aabb::EMPTY, |bounds, facet| bounds.union(self.facet_bounds(facet)))
    }
}

impl Inexact {
    fn new(placement: &Placement, local: DVec3) -> Self {
        let exact = placement.exact(local);
        Self { slack: exact.bounded().slack, exact }
    }
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
