//! Faces in many patches, and faces that reach beyond the window.

use super::{
    faces::{Face, Rect},
    group::own_solid,
    layout::FaceLattice,
    patch::{EDGE, Extent, Frame, Patch},
    sampler::Sampler,
};
use crate::{fine::lattice::Lattice, receivers::flat_corners};

/// Rows and columns of a block: patches that are decided together.
pub(super) const BLOCK: u32 = 4 * EDGE;

/// A face in many patches, or one that reaches beyond the window.
pub(super) struct Large {
    face: Face,
    pub(super) lattice: Lattice,
    frame: Frame,
    extent: Extent,
    /// The convex solid whose faces do not block its samples; −2 for none.
    solid: i32,
    /// Whether the view's window holds all of it.
    is_inside: bool,
}

impl Large {
    pub(super) fn new(sampler: &Sampler, face: Face) -> Self {
        let FaceLattice { lattice, corner, .. } = sampler.lattice(face);
        let view = &sampler.view;
        let corners = flat_corners(sampler.objects[face.source as usize].facets, face.number as usize, corner);
        let corners = [corners[0], corners[1], corners[3]].map(|corner| corner.position);
        let points = corners.map(|corner| view.homogeneous(corner));
        let scale =
            if view.is_sun() { 1.0 } else { 1.0 / points.iter().fold(f64::MIN_POSITIVE, |z, point| z.max(point[2])) };
        let homogeneous = [0, 1, 2].map(|k| {
            let depth = if view.is_sun() { view.depth_of_sun(corners[k]) } else { -view.depth_scale_of_lamp() * scale };
            let [x, y, z] = points[k].map(|x| x * scale);
            [x, y, z, depth]
        });
        let extent = match sampler.faces.clipped(face) {
            Some([]) => Extent { rect: Rect::EVERYWHERE, depths: [f32::NEG_INFINITY, f32::INFINITY] },
            Some(images) => Extent::of_images(images),
            None => {
                let (corners, count) = sampler.faces.corners(face);
                Extent::of_images(&corners[..count])
            }
        };
        let is_inside = sampler.faces.clipped(face).is_none() && view.holds(&extent.rect);
        let frame = Frame::of_corners(homogeneous, &lattice);
        Self { face, lattice, frame, extent, solid: own_solid(sampler, face, None), is_inside }
    }

    /// Adds the patches of the block that begins at a row and a column.
    #[inline(always)]
    pub(super) fn add(&self, sampler: &Sampler, [row, column]: [u32; 2], patches: &mut Vec<Patch>) {
        let counts = self.lattice.counts();
        let starts = |k: usize, first: u32| (first..counts[k].min(first + BLOCK)).step_by(EDGE as usize);
        let view = (!self.is_inside).then_some(&sampler.view);
        for row in starts(0, row) {
            for column in starts(1, column) {
                let origin = [row, column];
                let patch = Patch::part((self.face, origin), &self.frame, &self.extent, &self.lattice, view);
                if let Some(patch) = patch {
                    patches.push(Patch { solid: self.solid, ..patch });
                }
            }
        }
    }
}
