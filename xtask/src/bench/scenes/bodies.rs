//! Parts that generated scenes are put together from.

use glam::DVec3;

use crate::fixtures::meshes::{TriangleMesh, cube};

impl TriangleMesh {
    /// Takes in another mesh.
    pub(crate) fn append(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
    }

    /// Moves every vertex.
    pub(crate) fn map(mut self, place: impl Fn(DVec3) -> DVec3) -> Self {
        self.positions.iter_mut().for_each(|position| *position = place(*position));
        self
    }

    /// Turns the surface inside out.
    pub(crate) fn flipped(mut self) -> Self {
        self.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        self
    }
}

/// A rectangle at a height, looking up, from one corner (x, z) to the opposite one.
pub(crate) fn ground(min: [f64; 2], max: [f64; 2], height: f64) -> TriangleMesh {
    let corners = [[min[0], min[1]], [min[0], max[1]], [max[0], max[1]], [max[0], min[1]]];
    let positions = corners.map(|[x, z]| DVec3::new(x, height, z)).to_vec();
    TriangleMesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

/// A closed box.
pub(crate) fn cuboid(min: DVec3, max: DVec3) -> TriangleMesh {
    cube().map(|corner| DVec3::select(corner.cmplt(DVec3::ZERO), min, max))
}

/// Which ends of a sheet meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Closing {
    /// None.
    Open,
    /// The first parameter is an angle.
    Tube,
    /// Both are.
    Torus,
}

/// The image of the unit square under `place`, in `counts` steps: two triangles each.
///
/// It looks to ∂/∂second × ∂/∂first. A tube's ends get a point in the middle each, so it is closed.
pub(crate) fn sheet(counts: [u32; 2], closing: Closing, place: impl Fn(f64, f64) -> DVec3) -> TriangleMesh {
    let rows = counts[0] + u32::from(closing == Closing::Open);
    let columns = counts[1] + u32::from(closing != Closing::Torus);
    let mut mesh = TriangleMesh::default();
    let at = |i: u32, j: u32| (i % rows) * columns + j % columns;
    for i in 0..rows {
        let u = f64::from(i) / f64::from(counts[0]);
        mesh.positions.extend((0..columns).map(|j| place(u, f64::from(j) / f64::from(counts[1]))));
    }
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    if closing == Closing::Tube {
        for (end, is_first) in [(0, true), (counts[1], false)] {
            let rim = |i: u32| at(i, end);
            let middle = (0..rows).map(|i| mesh.positions[rim(i) as usize]).sum::<DVec3>() / f64::from(rows);
            let tip = mesh.positions.len() as u32;
            mesh.positions.push(middle);
            let fan = (0..rows).map(|i| if is_first { [rim(i), rim(i + 1), tip] } else { [rim(i + 1), rim(i), tip] });
            mesh.triangles.extend(fan);
        }
    }
    mesh
}
