//! What is worth knowing about the surfaces of a scene: open edges, faces without area, faces given twice.
//!
//! All three are decided exactly on the placed vertices, and every instance is looked at where it stands, since rounding
//! may join vertices in one place and not in another. Vertices that are equal in a mesh are equal wherever it stands; so
//! an instance with as many distinct positions as its mesh has the mesh's own topology, which is found once.
//! O(n log n) in the triangles of all meshes and the vertices of all instances.

use std::{collections::HashMap, sync::Arc};

use glam::DVec3;
use robust::{Coord, orient2d};
use umbriel_geometry::{Facets, Mesh, Placement};
use umbriel_scene::{Finding, FindingKind, Scene, Shape};

/// The findings about the surfaces of all triangle meshes of a scene, object by object. Rectangles, boxes and spheres
/// are what they are: nothing is found about them.
pub fn surface_findings(scene: &Scene) -> Vec<Finding> {
    let mut own: HashMap<*const Mesh, Joints> = HashMap::new();
    let mut findings = Vec::new();
    for object in &scene.objects {
        let Shape::Mesh(mesh) = &object.shape else { continue };
        let local = *own.entry(Arc::as_ptr(mesh)).or_insert_with(|| Joints::of(mesh, &Placement::IDENTITY));
        let placed: Vec<DVec3> = mesh.positions().iter().map(|&position| object.placement.round(position)).collect();
        let joined_by_rounding = distinct(&placed) != local.positions;
        let joints = if joined_by_rounding { Joints::of(mesh, &object.placement) } else { local };
        let counts = [
            (FindingKind::OpenEdges, joints.open_edges),
            (FindingKind::ZeroAreaFaces, without_area(mesh, &placed)),
            (FindingKind::DuplicateFaces, joints.duplicates),
        ];
        let found = counts.into_iter().filter(|&(_, count)| count > 0);
        findings.extend(found.map(|(kind, count)| Finding { kind, subject: object.name.clone(), count }));
    }
    findings
}

/// How the triangles of a mesh hang together.
#[derive(Clone, Copy, Debug)]
struct Joints {
    positions: usize,
    open_edges: usize,
    /// How many triangles have the same three corners as an earlier one, in whichever order.
    duplicates: usize,
}

impl Joints {
    fn of(mesh: &Mesh, placement: &Placement) -> Self {
        let facets = Facets::of_mesh(mesh, placement);
        let mut corners: Vec<Vec<u32>> = facets.iter().map(|facet| facet.corners().to_vec()).collect();
        corners.iter_mut().for_each(|corners| corners.sort_unstable());
        corners.sort_unstable();
        Self {
            positions: distinct(facets.positions()),
            open_edges: facets.topology().components.iter().map(|component| component.open_edges).sum(),
            duplicates: corners.windows(2).filter(|pair| pair[0] == pair[1]).count(),
        }
    }
}

/// The number of different positions.
fn distinct(positions: &[DVec3]) -> usize {
    // Accepted numbers hold no −0, so equal numbers have equal bits.
    let mut keys: Vec<_> = positions.iter().map(|position| position.to_array().map(f64::to_bits)).collect();
    keys.sort_unstable();
    keys.dedup();
    keys.len()
}

/// How many triangles have no area: exactly those whose projections along all three axes have none.
fn without_area(mesh: &Mesh, placed: &[DVec3]) -> usize {
    let has_area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| placed[corner as usize]);
        (0..3).any(|axis| {
            let seen = |v: DVec3| Coord { x: v[(axis + 1) % 3], y: v[(axis + 2) % 3] };
            orient2d(seen(a), seen(b), seen(c)) != 0.0
        })
    };
    mesh.triangles().iter().filter(|corners| !has_area(corners)).count()
}

#[cfg(test)]
mod tests {
    use umbriel_geometry::Rectangle;
    use umbriel_scene::{Object, Sides};

    use super::*;

    fn object(name: &str, shape: Shape) -> Object {
        Object::new(name.to_owned(), shape, Placement::IDENTITY, Sides::Auto).expect("an object")
    }

    #[test]
    fn open_flat_and_doubled_triangles_are_found() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.1, 0.1, 0.0], [0.2, 0.2, 0.0]];
        let triangles = vec![[0, 1, 2], [0, 3, 4], [2, 0, 1]];
        let mesh = Mesh::new(positions, triangles).expect("a mesh");
        let mut scene = Scene::default();
        scene.objects.push(object("mesh", Shape::Mesh(Arc::new(mesh))));
        scene.objects.push(object("floor", Shape::Rectangle(Rectangle { size: [1.0, 1.0] })));
        let found: Vec<_> = surface_findings(&scene).iter().map(|f| (f.kind, f.count)).collect();
        // 0.1 and 0.2 times (1, 1) are exactly in line with the origin; the doubled edges do not cancel.
        let expected = [(FindingKind::OpenEdges, 6), (FindingKind::ZeroAreaFaces, 1), (FindingKind::DuplicateFaces, 1)];
        assert_eq!(found, expected);
        assert!(surface_findings(&scene).iter().all(|finding| finding.subject == "mesh"));
    }

    #[test]
    fn rounding_far_away_joins_vertices() {
        // 1 and 1 + 2^-52 are one number once 2^30 is added: the triangle becomes a line there.
        let positions = vec![[1.0, 0.0, 0.0], [1.0 + f64::EPSILON, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Arc::new(Mesh::new(positions, vec![[0, 1, 2]]).expect("a mesh"));
        let far = glam::DAffine3::from_translation(DVec3::new(1_073_741_824.0, 0.0, 0.0));
        let mut scene = Scene::default();
        for (name, map) in [("near", glam::DAffine3::IDENTITY), ("far", far)] {
            let placement = Placement::new(map).expect("regular");
            let shape = Shape::Mesh(Arc::clone(&mesh));
            scene.objects.push(Object::new(name.to_owned(), shape, placement, Sides::Auto).expect("an object"));
        }
        let found: Vec<_> = surface_findings(&scene).into_iter().map(|f| (f.kind, f.subject, f.count)).collect();
        // Both uses of the one edge that is left cancel.
        let expected =
            [(FindingKind::OpenEdges, "near".to_owned(), 3), (FindingKind::ZeroAreaFaces, "far".to_owned(), 1)];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_closed_mesh_is_clean() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mut scene = Scene::default();
        let mesh = Mesh::new(positions, triangles).expect("a mesh");
        scene.objects.push(object("tetrahedron", Shape::Mesh(Arc::new(mesh))));
        assert!(surface_findings(&scene).is_empty());
    }
}
