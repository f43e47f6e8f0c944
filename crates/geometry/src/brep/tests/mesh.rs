use super::*;
use crate::Mesh;

fn mesh_of(body: &Brep) -> Mesh {
    let positions = body.vertices().iter().map(|vertex| vertex.to_array()).collect();
    Mesh::new(positions, body.triangles().collect()).expect("accepted")
}

/// Every triangle with corners of its own, as formats without indices give it.
fn unindexed(mesh: &Mesh) -> Mesh {
    let corners = mesh.triangles().iter().flatten();
    let positions: Vec<[f64; 3]> = corners.map(|&corner| mesh.positions()[corner as usize].to_array()).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh::new(positions, triangles).expect("accepted")
}

fn split_at(mesh: &Mesh, triangle: usize, point: DVec3) -> Mesh {
    let mut positions: Vec<[f64; 3]> = mesh.positions().iter().map(|p| p.to_array()).collect();
    let mut triangles = mesh.triangles().to_vec();
    let (new, [a, b, c]) = (positions.len() as u32, triangles.swap_remove(triangle));
    positions.push(point.to_array());
    triangles.extend([[a, b, new], [b, c, new], [c, a, new]]);
    Mesh::new(positions, triangles).expect("accepted")
}

proptest! {
    #[test]
    fn triangulated_bodies_come_back(cloud in lattice_cloud()) {
        if let Ok(body) = Brep::hull(cloud) {
            prop_assert_eq!(Brep::of_mesh(&mesh_of(&body)), Ok(body.clone()));
            prop_assert_eq!(Brep::of_mesh(&unindexed(&mesh_of(&body))), Ok(body));
        }
    }

    #[test]
    fn dents_and_holes_are_found(cloud in lattice_cloud(), pick in 0..100_usize) {
        let Ok(body) = Brep::hull(cloud) else { return Ok(()) };
        let mesh = mesh_of(&body);
        let triangle = pick % mesh.triangles().len();
        let corners = mesh.triangles()[triangle].map(|corner| mesh.positions()[corner as usize]);
        // Times 1/4 the corners' sums are exact: a point in the triangle's plane, and one ulp inside the body.
        let flat = corners[0] * 0.25 + corners[1] * 0.25 + corners[2] * 0.5;
        prop_assert_eq!(Brep::of_mesh(&split_at(&mesh, triangle, flat)), Ok(body.clone()));
        let centre = body.vertices().iter().sum::<DVec3>() / body.vertices().len() as f64;
        let dent = Brep::of_mesh(&split_at(&mesh, triangle, flat + (centre - flat) / 1024.0));
        let is_named = matches!(dent, Err(ConvexMeshDefect::InwardBend { .. }));
        prop_assert!(is_named, "{:?}", dent);
        let mut triangles = mesh.triangles().to_vec();
        let gone = triangles.swap_remove(triangle);
        let open = Brep::of_mesh(&Mesh::new(mesh.positions().iter().map(|p| p.to_array()).collect(), triangles).expect("accepted"));
        match open {
            Err(ConvexMeshDefect::OpenEdge { from, to, .. }) => {
                prop_assert!(gone.contains(&from) && gone.contains(&to));
            }
            other => prop_assert!(false, "{:?}", other),
        }
    }
}

#[test]
fn slivers_pieces_and_nothing() {
    let body = Cuboid { size: [2.0; 3] }.brep().expect("a box");
    let mesh = mesh_of(&body);
    let twice = |offset: DVec3| {
        let positions = mesh.positions().iter().copied().chain(mesh.positions().iter().map(|&p| p + offset));
        let shifted = mesh.triangles().iter().map(|triangle| triangle.map(|corner| corner + 8));
        let triangles = mesh.triangles().iter().copied().chain(shifted).collect();
        Brep::of_mesh(&Mesh::new(positions.map(|p| p.to_array()).collect(), triangles).expect("accepted"))
    };
    assert_eq!(twice(DVec3::X * 3.0), Err(ConvexMeshDefect::Apart { triangle: 12 }));
    assert!(matches!(twice(DVec3::ZERO), Err(ConvexMeshDefect::OpenEdge { .. })), "every edge twice");
    let empty = Mesh::new(Vec::new(), vec![]).expect("accepted");
    assert_eq!(Brep::of_mesh(&empty), Err(ConvexMeshDefect::Flat(Flatness::Nothing)));
    // A point on an edge splits its two triangles with a sliver between: the sliver has no plane.
    let mut positions: Vec<[f64; 3]> = mesh.positions().iter().map(|p| p.to_array()).collect();
    let mut triangles = mesh.triangles().to_vec();
    let [a, b, c] = triangles.swap_remove(0);
    let middle = (mesh.positions()[a as usize] + mesh.positions()[b as usize]) * 0.5;
    positions.push(middle.to_array());
    triangles.extend([[a, 8, c], [8, b, c], [a, b, 8]]);
    let sliver = Brep::of_mesh(&Mesh::new(positions.clone(), triangles.clone()).expect("accepted"));
    assert_eq!(sliver, Err(ConvexMeshDefect::NoArea { triangle: triangles.len() - 1 }));
    // A triangle that names one vertex twice is no surface.
    let mut with_needle = mesh.triangles().to_vec();
    with_needle.push([0, 0, 1]);
    positions.pop();
    assert_eq!(
        Brep::of_mesh(&Mesh::new(positions, with_needle).expect("accepted")).map(|b| counts(&b)),
        Ok((8, 12, 6))
    );
}

#[test]
fn a_mesh_that_winds_twice_is_refused() {
    let (vertices, triangles) = pentagram_pyramids();
    let mesh = Mesh::new(vertices.iter().map(|v| v.to_array()).collect(), triangles).expect("accepted");
    assert!(matches!(Brep::of_mesh(&mesh), Err(ConvexMeshDefect::Wound { .. })), "{:?}", Brep::of_mesh(&mesh));
}

#[test]
fn a_fin_in_the_plane_of_a_face_is_a_fold() {
    let body = Cuboid { size: [2.0; 3] }.brep().expect("a box");
    let mesh = mesh_of(&body);
    // The first face is slit along its diagonal, one side of the slit in two edges; a fin is put into the slit.
    let mut triangles = mesh.triangles().to_vec();
    let ([a, _, c], [_, _, d], middle, tip) = (triangles[0], triangles[1], 8, 9);
    assert_eq!(triangles[1], [a, c, d]);
    triangles[1] = [a, middle, d];
    triangles.extend([[middle, c, d], [a, c, tip], [middle, a, tip], [c, middle, tip]]);
    let finned = |at: DVec3| {
        let positions = mesh.positions().iter().chain([&DVec3::NEG_X, &at]).map(|p| p.to_array()).collect();
        Brep::of_mesh(&Mesh::new(positions, triangles.clone()).expect("accepted"))
    };
    for in_plane in [DVec3::new(-1.0, 9.0, 0.5), DVec3::new(-1.0, 0.25, 0.5)] {
        assert!(matches!(finned(in_plane), Err(ConvexMeshDefect::Fold { .. })), "{:?}", finned(in_plane));
    }
    for off_plane in [DVec3::new(-3.0, 9.0, 0.5), DVec3::ZERO] {
        // Folded at the tip, and bent inward at the slit.
        let bent =
            matches!(finned(off_plane), Err(ConvexMeshDefect::Fold { .. } | ConvexMeshDefect::InwardBend { .. }));
        assert!(bent, "{:?}", finned(off_plane));
    }
    assert!(finned(DVec3::new(-1.0, 0.0, 0.0)).is_err(), "a fin without area");
}
