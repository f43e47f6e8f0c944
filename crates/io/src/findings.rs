//! What is worth knowing about the surfaces of a scene: open edges, faces without area, faces given twice.
//!
//! All three are decided exactly on the placed vertices. O(n log n) in the triangles of all objects together: every
//! instance is looked at where it stands, since rounding may join vertices in one place and not in another.

use glam::DVec3;
use robust::{Coord, orient2d};
use umbriel_geometry::{Facet, Facets};
use umbriel_scene::{Finding, FindingKind, Object, Scene, Shape};

/// The findings about the surfaces of all triangle meshes of a scene, object by object. Rectangles, boxes and spheres
/// are what they are: nothing is found about them.
pub fn surface_findings(scene: &Scene) -> Vec<Finding> {
    scene.objects.iter().flat_map(findings_of).collect()
}

fn findings_of(object: &Object) -> Vec<Finding> {
    let (Shape::Mesh(_), Some(facets)) = (&object.shape, object.facets()) else { return Vec::new() };
    let open_edges = facets.topology().components.iter().map(|component| component.open_edges).sum();
    let zero_area = facets.iter().filter(|facet| !has_area(&facets, facet)).count();
    let counts = [
        (FindingKind::OpenEdges, open_edges),
        (FindingKind::ZeroAreaFaces, zero_area),
        (FindingKind::DuplicateFaces, duplicates(&facets)),
    ];
    let found = counts.into_iter().filter(|&(_, count)| count > 0);
    found.map(|(kind, count)| Finding { kind, subject: object.name.clone(), count }).collect()
}

/// A triangle has no area exactly when its three projections along the axes have none.
fn has_area(facets: &Facets, facet: &Facet) -> bool {
    let corners = facet.corners();
    let [a, b, c] = [0, 1, 2].map(|corner| facets.positions()[corners[corner] as usize]);
    (0..3).any(|axis| {
        let seen = |v: DVec3| Coord { x: v[(axis + 1) % 3], y: v[(axis + 2) % 3] };
        orient2d(seen(a), seen(b), seen(c)) != 0.0
    })
}

/// How many triangles have the same three corners as an earlier one, in whichever order.
fn duplicates(facets: &Facets) -> usize {
    let mut corners: Vec<Vec<u32>> = facets.iter().map(|facet| facet.corners().to_vec()).collect();
    corners.iter_mut().for_each(|corners| corners.sort_unstable());
    corners.sort_unstable();
    corners.windows(2).filter(|pair| pair[0] == pair[1]).count()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use umbriel_geometry::{Mesh, Placement, Rectangle};
    use umbriel_scene::Sides;

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
    fn a_closed_mesh_is_clean() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mut scene = Scene::default();
        let mesh = Mesh::new(positions, triangles).expect("a mesh");
        scene.objects.push(object("tetrahedron", Shape::Mesh(Arc::new(mesh))));
        assert!(surface_findings(&scene).is_empty());
    }
}
