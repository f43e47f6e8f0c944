//! Which points and facets of placed faces are the same, and which facets meet along an edge: told by the positions of points, as [`Joints`] finds them.

use std::sync::Arc;

use super::{Faces, Facet, Facets, Positions};
use crate::joints::{self, Joints};

impl Facets {
    /// The first point that lies exactly where this one does: edges and faces with equal ends are told by it. Corners of
    /// parallelograms are all apart, even where their floats agree. The first call looks at all points.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn first_at(&self, point: u32) -> u32 {
        self.joints().first_at(point)
    }

    /// For each point the first one at its position ([`Facets::first_at`]); `None` where no two corners of triangles share one.
    pub fn firsts(&self) -> Option<&[u32]> {
        self.joints().firsts()
    }

    /// Whether the same points are equal as in the mesh, so that what points joined by their positions make (edges, surfaces) is that of the mesh. The
    /// first call looks at all points.
    pub fn are_joined_as_in_mesh(&self) -> bool {
        let joints = self.joints();
        matches!(&self.faces, Faces::OfMesh(mesh) if mesh.known_joints().is_some_and(|of_mesh| Arc::ptr_eq(joints, of_mesh)))
    }

    pub(super) fn joints(&self) -> &Arc<Joints> {
        self.joints.get_or_init(|| match (&self.faces, &self.positions) {
            (Faces::OfMesh(mesh), Positions::OfMesh(_)) => Arc::clone(mesh.joints()),
            (Faces::OfMesh(mesh), Positions::Placed(positions)) => {
                let own = Joints::of(positions);
                // Held by these facets and one object, the mesh has no other instance.
                let is_shared = Arc::strong_count(mesh) > 2;
                if is_shared && own.are_those_of(mesh.joints()) { Arc::clone(mesh.joints()) } else { Arc::new(own) }
            }
            (Faces::Triangles(_), _) => Arc::new(Joints::of(self.positions())),
            (Faces::Parallelograms(_), _) => Arc::default(),
        })
    }

    /// Whether a triangle has the corners of an earlier one, in whichever order: it is the same set of points. The first call looks at all of them; a
    /// parallelogram never is.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn is_repeat(&self, facet: usize) -> bool {
        self.triangles().is_some_and(|triangles| self.joints().is_repeat(triangles, facet))
    }

    /// Whether a triangle has the corners of an earlier one in the same order: it is divided and measured the same. The first call looks at all of them; a
    /// parallelogram never is.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn is_copy(&self, facet: usize) -> bool {
        self.triangles().is_some_and(|triangles| self.joints().is_copy(triangles, facet))
    }

    /// The later triangles that are such copies of this one, ascending.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn copies(&self, facet: usize) -> impl Iterator<Item = usize> {
        self.triangles().into_iter().flat_map(move |triangles| self.joints().copies(triangles, facet))
    }

    /// How many facets are repeats.
    pub fn repeat_count(&self) -> usize {
        self.triangles().map_or(0, |triangles| self.joints().repeat_count(triangles))
    }

    /// The triangle beyond side `side` of a triangle (from that corner to the next one), if these two alone use the edge, in opposite directions; points
    /// are told by position. `None` of a parallelogram. The first call is O(n).
    ///
    /// # Panics
    /// If there is no such facet or side.
    #[inline]
    pub fn across(&self, facet: usize, side: usize) -> Option<u32> {
        let beyond = self.joints().across(self.triangles()?)[facet][side];
        (beyond != joints::NONE).then_some(beyond)
    }

    /// A facet with its corners replaced by the first points at their positions ([`Facets::first_at`]).
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn welded(&self, facet: usize) -> Facet {
        match self.facet(facet) {
            Facet::Triangle(corners) => Facet::Triangle(corners.map(|corner| self.first_at(corner))),
            Facet::Parallelogram(corners) => Facet::Parallelogram(corners.map(|corner| self.first_at(corner))),
        }
    }
}
