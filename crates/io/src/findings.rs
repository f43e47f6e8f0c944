//! What is worth knowing about the surfaces of a scene: open edges, edges whose faces are wound differently, faces without
//! area, faces given twice; bodies without any surface, and bodies given twice.
//!
//! All of it is decided exactly on the placed vertices, and every instance is looked at where it stands, since rounding
//! may join vertices in one place and not in another. Vertices that are equal in a mesh are equal wherever it stands; so
//! an instance in which rounding joins no others has the mesh's own topology, which is found once. O(n log n) in the
//! triangles of all meshes, O(n) in those of all instances unless rounding comes near to joining vertices.

use std::{
    collections::{BTreeMap, HashMap},
    sync::Arc,
};

use glam::DVec3;
use robust::{Coord, orient2d};
use umbriel_geometry::{Facets, Mesh, Placement};
use umbriel_scene::{Finding, FindingKind, Object, Scene, Shape, first_alike};

/// The findings about the surfaces of all triangle meshes of a scene, mesh by mesh: what is found about objects that
/// share a mesh is one finding, with the name of the first of them, its first places, and the count over all. Of other bodies
/// nothing is found but that the box which cuts one leaves nothing of it, or that one has no inside. Objects that repeat another one ([`first_alike`]) are found of all kinds.
pub fn surface_findings(scene: &Scene) -> Vec<Finding> {
    let firsts = first_alike(&scene.objects);
    let times = times(&scene.objects, &firsts);
    let mut place_of: HashMap<*const Mesh, usize> = HashMap::new();
    let mut groups: Vec<Group> = Vec::new();
    for (object, &times) in scene.objects.iter().zip(&times).filter(|(_, times)| **times > 0) {
        let Shape::Mesh(mesh) = &object.shape else { continue };
        let place = *place_of.entry(Arc::as_ptr(mesh)).or_insert_with(|| {
            groups.push(Group {
                own: Joints::of(mesh, &Placement::IDENTITY),
                gap: gap(mesh),
                found: Default::default(),
            });
            groups.len() - 1
        });
        groups[place].add(object, mesh, times);
    }
    let of_bodies = scene.objects.iter().filter_map(|object| {
        let kind = defect_of_body(object)?;
        Some(Finding { kind, subject: object.name.clone(), count: 1, places: Vec::new() })
    });
    let of_meshes = groups.into_iter().flat_map(|group| group.found.into_iter().flatten());
    of_meshes.chain(of_bodies).chain(repeated(scene, &firsts)).collect()
}

/// What is wrong with a body given by a formula.
fn defect_of_body(object: &Object) -> Option<FindingKind> {
    match &object.shape {
        Shape::Analytic(_) if object.bounds().is_empty() => Some(FindingKind::NoSurface),
        Shape::Analytic(body) if body.is_closed() && !body.has_inside() => Some(FindingKind::NoInside),
        _ => None,
    }
}

/// For each object how many instances of its mesh it stands for: of those in one place the first one for all.
fn times(objects: &[Object], firsts: &[usize]) -> Vec<usize> {
    let mesh_of =
        |object: usize| if let Shape::Mesh(mesh) = &objects[object].shape { Some(Arc::as_ptr(mesh)) } else { None };
    let mut times = vec![1; objects.len()];
    for (number, &first) in firsts.iter().enumerate().filter(|&(number, &first)| number != first) {
        if mesh_of(number) == mesh_of(first) {
            times[number] = 0;
            times[first] += 1;
        }
    }
    times
}

/// The objects that others repeat, with the names of these as places; for each object the first that is the same.
fn repeated(scene: &Scene, firsts: &[usize]) -> Vec<Finding> {
    let mut found: BTreeMap<usize, Finding> = BTreeMap::new();
    for (number, &first) in firsts.iter().enumerate().filter(|&(number, &first)| number != first) {
        let subject = || scene.objects[first].name.clone();
        let kind = FindingKind::DuplicateObjects;
        let finding =
            found.entry(first).or_insert_with(|| Finding { kind, subject: subject(), count: 0, places: Vec::new() });
        finding.count += 1;
        if finding.places.len() < Finding::PLACES {
            finding.places.push(scene.objects[number].name.clone());
        }
    }
    found.into_values().collect()
}

/// What is found about the objects that share a mesh.
struct Group {
    own: Joints,
    gap: f64,
    found: [Option<Finding>; 4],
}

impl Group {
    /// Adds an object, which stands for so many in one place.
    fn add(&mut self, object: &Object, mesh: &Arc<Mesh>, times: usize) {
        let placed: Vec<DVec3> = mesh.positions().iter().map(|&position| object.placement.round(position)).collect();
        let kept_apart = stay_apart(self.gap, &object.placement, &placed) || distinct(&placed) == self.own.positions;
        let moved = (!kept_apart).then(|| Joints::of(mesh, &object.placement));
        let joints = moved.as_ref().unwrap_or(&self.own);
        let flat = without_area(mesh, &placed);
        let faults = [
            (FindingKind::OpenEdges, &joints.open_edges),
            (FindingKind::InconsistentWinding, &joints.turned_edges),
            (FindingKind::ZeroAreaFaces, &flat),
            (FindingKind::DuplicateFaces, &joints.duplicates),
        ];
        for (found, (kind, faults)) in self.found.iter_mut().zip(faults).filter(|(_, (_, faults))| faults.count > 0) {
            let finding = || Finding { kind, subject: object.name.clone(), count: 0, places: faults.places() };
            found.get_or_insert_with(finding).count += times * faults.count;
        }
    }
}

/// How often something was found, and the first faces where it was.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Faults {
    count: usize,
    /// Ascending.
    faces: Vec<u32>,
}

impl Faults {
    /// From the faces at fault, in any order; one that is at fault twice counts twice.
    fn at(faces: impl Iterator<Item = u32>) -> Self {
        let mut faces: Vec<u32> = faces.collect();
        let count = faces.len();
        faces.sort_unstable();
        faces.dedup();
        faces.truncate(Finding::PLACES);
        Self { count, faces }
    }

    fn places(&self) -> Vec<String> {
        self.faces.iter().map(|face| format!("face {face}")).collect()
    }
}

/// The least difference other than zero between two vertices in the same coordinate: vertices that are not equal are at
/// least so far apart, by the largest coordinate of their difference. Rounded to the nearest.
fn gap(mesh: &Mesh) -> f64 {
    let of_axis = |axis: usize| {
        let mut values: Vec<f64> = mesh.positions().iter().map(|position| position[axis]).collect();
        values.sort_unstable_by(f64::total_cmp);
        let gaps = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|&gap| gap > 0.0);
        gaps.fold(f64::INFINITY, f64::min)
    };
    (0..3).map(of_axis).fold(f64::INFINITY, f64::min)
}

/// Whether vertices that are `gap` apart are sure to stay apart when placed and rounded; may say no in vain.
///
/// |d| ≤ ‖A⁻¹‖·|A·d| by the largest coordinate, and rounding moves two points together by one ulp of the largest placed
/// coordinate at most, which is 2^-52 of it. Twice that is left for the roundings of both sides.
fn stay_apart(gap: f64, placement: &Placement, placed: &[DVec3]) -> bool {
    let inverse = placement.inverse_bounds().map(|row| row.iter().sum()).into_iter().fold(0.0, f64::max);
    let largest = placed.iter().fold(DVec3::ZERO, |largest, at| largest.max(at.abs())).max_element();
    gap > 2.0 * inverse * largest * f64::EPSILON
}

/// How the triangles of a mesh hang together.
#[derive(Clone, Debug)]
struct Joints {
    positions: usize,
    /// Edges whose directed uses do not cancel.
    open_edges: Faults,
    /// Edges that just two triangles use, both in one direction; they are open, too.
    turned_edges: Faults,
    /// Triangles that have the same three corners as an earlier one, in whichever order.
    duplicates: Faults,
}

impl Joints {
    fn of(mesh: &Arc<Mesh>, placement: &Placement) -> Self {
        let facets = Facets::of_mesh(Arc::clone(mesh), placement);
        let triangle = |facet: usize| {
            let facet = facets.welded(facet);
            let corners = facet.corners();
            [corners[0], corners[1], corners[2]]
        };
        let faces: Vec<[u32; 3]> = (0..facets.len()).map(triangle).collect();
        // Sorted copies of millions of triangles, one after the other.
        let duplicates = duplicates(&faces);
        let uses = edge_uses(&faces);
        let edges = || uses.chunk_by(|a, b| a.ends == b.ends);
        let is_open =
            |edge: &&[EdgeUse]| edge.iter().map(|usage| if usage.is_upward { 1 } else { -1 }).sum::<i64>() != 0;
        let is_turned = |edge: &&[EdgeUse]| edge.len() == 2 && edge[0].is_upward == edge[1].is_upward;
        Self {
            positions: distinct(facets.positions()),
            open_edges: Faults::at(edges().filter(is_open).map(|edge| edge[0].face)),
            turned_edges: Faults::at(edges().filter(is_turned).map(|edge| edge[0].face)),
            duplicates,
        }
    }
}

/// One use of an edge by a triangle.
struct EdgeUse {
    /// Its ends, the lower first.
    ends: [u32; 2],
    is_upward: bool,
    face: u32,
}

/// The uses of all edges, those of one edge together and by face.
fn edge_uses(faces: &[[u32; 3]]) -> Vec<EdgeUse> {
    let mut uses = Vec::with_capacity(3 * faces.len());
    for (face, &[a, b, c]) in faces.iter().enumerate() {
        let edges = [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from != to);
        uses.extend(edges.map(|(from, to)| EdgeUse {
            ends: [from.min(to), from.max(to)],
            is_upward: from < to,
            face: face as u32,
        }));
    }
    uses.sort_unstable_by_key(|usage| (usage.ends, usage.face));
    uses
}

fn duplicates(faces: &[[u32; 3]]) -> Faults {
    let sorted = |(face, &(mut corners)): (usize, &[u32; 3])| {
        corners.sort_unstable();
        (corners, face as u32)
    };
    let mut faces: Vec<([u32; 3], u32)> = faces.iter().enumerate().map(sorted).collect();
    faces.sort_unstable();
    Faults::at(faces.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1))
}

/// The number of different positions.
fn distinct(positions: &[DVec3]) -> usize {
    // Accepted numbers hold no −0, so equal numbers have equal bits.
    let mut keys: Vec<_> = positions.iter().map(|position| position.to_array().map(f64::to_bits)).collect();
    keys.sort_unstable();
    keys.dedup();
    keys.len()
}

/// The triangles without area: exactly those whose projections along all three axes have none.
fn without_area(mesh: &Mesh, placed: &[DVec3]) -> Faults {
    let has_area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| placed[corner as usize]);
        (0..3).any(|axis| {
            let seen = |v: DVec3| Coord { x: v[(axis + 1) % 3], y: v[(axis + 2) % 3] };
            orient2d(seen(a), seen(b), seen(c)) != 0.0
        })
    };
    let flat = mesh.triangles().iter().enumerate().filter(|(_, corners)| !has_area(corners));
    Faults::at(flat.map(|(face, _)| face as u32))
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3};
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
        let expected = [
            (FindingKind::OpenEdges, 6),
            (FindingKind::InconsistentWinding, 3),
            (FindingKind::ZeroAreaFaces, 1),
            (FindingKind::DuplicateFaces, 1),
        ];
        assert_eq!(found, expected);
        let places: Vec<_> = surface_findings(&scene).iter().map(|finding| finding.places.join(", ")).collect();
        assert_eq!(places, ["face 0, face 1", "face 0", "face 1", "face 2"]);
        assert!(surface_findings(&scene).iter().all(|finding| finding.subject == "mesh"));
    }

    #[test]
    fn triangles_within_an_ulp_of_a_line_are_told_exactly() {
        // Corners beside the line x = y whose differences from the others round to the same.
        let corner = |k: u32| 0.5 + f64::from(k) * 2f64.powi(-53);
        let mut positions = vec![[12.0, 12.0, 0.0], [24.0, 24.0, 0.0]];
        positions.extend((0..256).map(|k| [corner(k / 16), corner(k % 16), 0.0]));
        let triangles = (0..256).map(|k| [0, 1, 2 + k]).collect();
        let mesh = Mesh::new(positions, triangles).expect("a mesh");
        let flat = without_area(&mesh, mesh.positions());
        assert_eq!(flat, Faults::at((0..16).map(|k| 17 * k)));
    }

    #[test]
    fn rounding_far_away_joins_vertices() {
        // 1 and 1 + 2^-52 are one number once 2^30 is added: the triangle becomes a line there.
        let positions = vec![[1.0, 0.0, 0.0], [1.0 + f64::EPSILON, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Arc::new(Mesh::new(positions, vec![[0, 1, 2]]).expect("a mesh"));
        let far = DAffine3::from_translation(DVec3::new(1_073_741_824.0, 0.0, 0.0));
        let mut scene = Scene::default();
        for (name, map) in [("near", DAffine3::IDENTITY), ("far", far)] {
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
    fn instances_are_told_once() {
        let mesh =
            Arc::new(Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).expect("a mesh"));
        let mut scene = Scene::default();
        for number in 0..7 {
            scene.objects.push(object(&format!("leaf#{number}"), Shape::Mesh(Arc::clone(&mesh))));
        }
        let found = surface_findings(&scene);
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].kind, &*found[0].subject, found[0].count), (FindingKind::OpenEdges, "leaf#0", 21));
        assert_eq!((found[1].kind, &*found[1].subject, found[1].count), (FindingKind::DuplicateObjects, "leaf#0", 6));
        assert_eq!(found[1].places, ["leaf#1", "leaf#2", "leaf#3", "leaf#4", "leaf#5"]);
    }

    #[test]
    fn vertices_are_known_to_stay_apart_only_where_they_do() {
        let at = |x: f64| vec![DVec3::splat(x)];
        let scaled = |scale: DVec3| Placement::new(DAffine3::from_scale(scale)).expect("regular");
        assert!(stay_apart(0.1, &Placement::IDENTITY, &at(1000.0)));
        assert!(!stay_apart(f64::EPSILON, &Placement::IDENTITY, &at(1.0)));
        let flat = |share: f64| scaled(DVec3::new(1.0, 1.0, share));
        assert!(stay_apart(0.1, &flat(1e-12), &at(1.0)) && !stay_apart(0.1, &flat(1e-15), &at(1.0)));
    }

    #[test]
    fn needles_join_vertices_that_no_inverse_in_floats_tells() {
        // The columns are nearly parallel: floats make an inverse of this matrix that is 10^5 times too small.
        let matrix3 = DMat3::from_cols_array_2d(&[
            [0.9144652231682989, 0.7713461635755045, 1.3991075526609589],
            [0.94045245323253, 0.7932662431208143, 1.4388673285625195],
            [0.6853951105353164, 0.5781268394221618, 1.0486363543551827],
        ]);
        let positions = vec![[0.0; 3], [0.11915734063336464, -0.8446576452635816, 1.0], [1.0, 1.0, 3.0]];
        let mesh = Mesh::new(positions, vec![[0, 1, 2]]).expect("a mesh");
        let placement = Placement::new(DAffine3 { matrix3, translation: DVec3::splat(1024.0) }).expect("regular");
        let needle = Object::new("needle".to_owned(), Shape::Mesh(Arc::new(mesh)), placement, Sides::Auto);
        let scene = Scene { objects: [needle.expect("an object")].into(), ..Scene::default() };
        let found: Vec<_> = surface_findings(&scene).into_iter().map(|finding| (finding.kind, finding.count)).collect();
        assert_eq!(found, [(FindingKind::ZeroAreaFaces, 1)], "two of its corners are one");
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
