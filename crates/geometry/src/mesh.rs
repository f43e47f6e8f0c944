//! Triangle meshes as read: positions and triangles, nothing welded, nothing dropped.

use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DVec3};

use crate::{
    aabb::Aabb,
    cut_out::{CutOutDefect, CutOutPart, CutOuts, FaceCutOut, Opacity},
    joints::Joints,
    number::{AXES, NumberDefect, accept_point},
    placement::rounded_image,
};

/// Why a mesh is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshDefect {
    /// A coordinate outside the accepted range.
    #[error("vertex {vertex}: coordinate {} {defect}", AXES[*.axis])]
    Coordinate {
        /// Which vertex.
        vertex: usize,
        /// 0, 1 or 2.
        axis: usize,
        /// What is wrong with it.
        defect: NumberDefect,
    },
    /// A triangle that names a vertex that is not there.
    #[error("triangle {triangle}: vertex {index} of {vertices}")]
    Index {
        /// Which triangle.
        triangle: usize,
        /// The index it holds.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// More vertices or triangles than 32-bit indices can name.
    #[error("more than 2^32 - 2 vertices or triangles")]
    TooMany,
}

/// A triangle mesh in its local coordinates. Counter-clockwise triangles face the viewer (right-hand rule).
///
/// Every position is accepted ([`crate::accept`]) and every index is in range: nothing left to fail.
#[derive(Clone, Debug)]
pub struct Mesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    cut_outs: Option<CutOuts>,
    /// Of the two above.
    joints: OnceLock<Arc<Joints>>,
}

impl PartialEq for Mesh {
    fn eq(&self, other: &Self) -> bool {
        let Self { positions, triangles, cut_outs, joints: _ } = self;
        (positions, triangles, cut_outs) == (&other.positions, &other.triangles, &other.cut_outs)
    }
}

impl Mesh {
    /// Checks and takes positions (metres, local coordinates) and triangles (indices into them).
    ///
    /// # Errors
    /// The first [`MeshDefect`].
    pub fn new(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshDefect> {
        if positions.len() >= u32::MAX as usize || triangles.len() >= u32::MAX as usize {
            return Err(MeshDefect::TooMany);
        }
        let accepted = positions.iter().enumerate().map(|(vertex, &position)| {
            accept_point(position).map_err(|(axis, defect)| MeshDefect::Coordinate { vertex, axis, defect })
        });
        let positions = accepted.collect::<Result<Vec<_>, _>>()?;
        let vertices = positions.len();
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&index| index as usize >= vertices) {
                return Err(MeshDefect::Index { triangle, index, vertices });
            }
        }
        Ok(Self { positions, triangles, cut_outs: None, joints: OnceLock::new() })
    }

    /// The same mesh with holes where `parts` say so. Cost: some looks at the map for each triangle of a part.
    ///
    /// # Errors
    /// [`CutOutDefect`].
    pub fn with_cut_outs(self, parts: Vec<CutOutPart>) -> Result<Self, CutOutDefect> {
        let cut_outs = CutOuts::new(parts, &self.triangles)?;
        Ok(Self { cut_outs, ..self })
    }

    /// The mesh of the images of its vertices under an affine map that may be singular, each correctly rounded; triangles
    /// and holes stay. For a regular map a [`crate::Placement`] does the same without a copy. O(vertices + triangles).
    ///
    /// # Errors
    /// The first image that is not accepted.
    pub fn mapped(&self, map: &DAffine3) -> Result<Self, MeshDefect> {
        let image = |(vertex, &position): (usize, &DVec3)| {
            let accepted = accept_point(rounded_image(map, position).to_array());
            accepted.map_err(|(axis, defect)| MeshDefect::Coordinate { vertex, axis, defect })
        };
        let positions = self.positions.iter().enumerate().map(image).collect::<Result<_, _>>()?;
        Ok(Self {
            positions,
            triangles: self.triangles.clone(),
            cut_outs: self.cut_outs.clone(),
            joints: OnceLock::new(),
        })
    }

    /// Whether any triangle has holes.
    pub fn has_holes(&self) -> bool {
        self.cut_outs.is_some()
    }

    /// Whether a triangle has holes.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[inline]
    pub fn opacity(&self, triangle: usize) -> Opacity {
        self.cut_outs.as_ref().map_or(Opacity::Opaque, |cut_outs| cut_outs.opacity(triangle))
    }

    /// How a triangle is cut out; `None` for one without a cut-out.
    pub fn cut_out(&self, triangle: usize) -> Option<FaceCutOut<'_>> {
        self.cut_outs.as_ref()?.face(triangle, self)
    }

    /// Vertex positions, local coordinates, metres.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Triangles, three indices into [`Mesh::positions`] each.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Whether a triangle has the corners of an earlier one, in whichever order ([`Facets::is_repeat`](crate::Facets::is_repeat)).
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn is_repeat(&self, triangle: usize) -> bool {
        self.joints().is_repeat(&self.triangles, triangle)
    }

    /// How many triangles are such.
    pub fn repeat_count(&self) -> usize {
        self.joints().repeat_count(&self.triangles)
    }

    /// Which vertices are equal, found when first asked for.
    pub(crate) fn joints(&self) -> &Arc<Joints> {
        self.joints.get_or_init(|| Arc::new(Joints::of(&self.positions)))
    }

    /// Which vertices are equal, if that was asked for.
    pub(crate) fn known_joints(&self) -> Option<&Arc<Joints>> {
        self.joints.get()
    }

    /// The bounding box of the vertices that triangles use, local coordinates.
    pub fn bounds(&self) -> Aabb {
        Aabb::of(self.triangles.iter().flatten().map(|&index| self.positions[index as usize]))
    }
}
