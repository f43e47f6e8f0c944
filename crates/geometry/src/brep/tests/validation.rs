use super::*;

fn cube() -> (Vec<DVec3>, Vec<Vec<u32>>) {
    let cube = Cuboid { size: [1.0, 2.0, 3.0] };
    (cube.corners().to_vec(), Cuboid::FACES.iter().map(|f| f.to_vec()).collect())
}

#[test]
fn a_box_is_a_valid_convex_body() {
    let body = Cuboid { size: [1.0, 2.0, 3.0] }.brep().expect("a box");
    assert_eq!(counts(&body), (8, 12, 6));
    check_structure(&body);
    let faces: Vec<Vec<u32>> = (0..6).map(|face| body.face(face).collect()).collect();
    assert_eq!(faces, Cuboid::FACES, "faces keep their order and first corners");
    assert_eq!(body.triangles().count(), 12);
}

#[test]
fn flat_boxes_are_refused() {
    let flat = Cuboid { size: [1.0, 0.0, 1.0] }.brep();
    assert_eq!(flat, Err(BrepDefect::Coincident { first: 0, second: 2 }));
    assert!(matches!(Cuboid { size: [-1.0, 1.0, 1.0] }.brep(), Err(BrepDefect::NotConvex { .. })), "inside out");
}

#[test]
fn defects_name_their_place() {
    let (vertices, mut faces) = cube();
    faces[3].reverse();
    let open = |faces: &[Vec<u32>]| match Brep::new(vertices.clone(), faces) {
        Err(BrepDefect::OpenEdge { face, from, to }) => Some((face, from, to)),
        _ => None,
    };
    let (face, from, to) = open(&faces).expect("a turned face");
    assert!(faces[face].contains(&from) && faces[face].contains(&to));
    faces.remove(3);
    assert_eq!(open(&faces), Some((0, 6, 2)), "the first edge of the hole");
    faces.push(faces[0].clone());
    assert_eq!(open(&faces).map(|edge| edge.0), Some(0), "a face twice");

    let (mut vertices, faces) = cube();
    vertices[7] = DVec3::new(-2.0, -3.0, -4.0);
    assert_eq!(Brep::new(vertices, &faces), Err(BrepDefect::NotPlanar { face: 1, vertex: 5 }));
    // An octahedron with one corner pushed through the middle.
    let octahedron =
        Brep::hull([DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z]).expect("a body");
    let faces: Vec<Vec<u32>> = (0..8).map(|face| octahedron.face(face).collect()).collect();
    let mut vertices = octahedron.vertices().to_vec();
    let pushed = vertices.iter().position(|&vertex| vertex == DVec3::Y).expect("a corner") as u32;
    vertices[pushed as usize] *= -0.5;
    let Err(BrepDefect::NotConvex { face, vertex }) = Brep::new(vertices, &faces) else { panic!("a dent") };
    assert!(faces[face].contains(&pushed) != (vertex == pushed), "the face or the vertex was pushed");
    for wrong in [vec![0, 4, 4, 2], vec![0, 4], vec![0, 4, 6, 8]] {
        let (vertices, mut faces) = cube();
        faces[0] = wrong;
        assert_eq!(Brep::new(vertices, &faces), Err(BrepDefect::Loop { face: 0 }));
    }
    let (mut vertices, faces) = cube();
    vertices.push(DVec3::ZERO);
    assert_eq!(Brep::new(vertices.clone(), &faces), Err(BrepDefect::Unused { vertex: 8 }));
    vertices[8].z = f64::INFINITY;
    assert!(matches!(Brep::new(vertices, &faces), Err(BrepDefect::Coordinate { vertex: 8, axis: 2, .. })));
}

#[test]
fn one_ulp_bends_a_face() {
    let (mut vertices, faces) = cube();
    vertices[7].x = vertices[7].x.next_up();
    assert_eq!(Brep::new(vertices.clone(), &faces), Err(BrepDefect::NotPlanar { face: 1, vertex: 5 }));
    // Its hull cuts the face +x in two along the edge that stays convex; +y and +z keep their planes.
    assert_eq!(counts(&Brep::hull(vertices).expect("a body")), (8, 13, 7));
}

#[test]
fn two_boxes_are_not_one_body() {
    let (mut vertices, mut faces) = cube();
    vertices.extend(vertices.clone().into_iter().map(|vertex| vertex + DVec3::X * 5.0));
    faces.extend(faces.clone().into_iter().map(|face| face.into_iter().map(|vertex| vertex + 8).collect()));
    assert_eq!(Brep::new(vertices, &faces), Err(BrepDefect::Apart { face: 6 }));
    assert_eq!(Brep::new(Vec::new(), &[]), Err(BrepDefect::Euler(0)));
}

#[test]
fn a_cut_face_is_not_whole() {
    let (vertices, mut faces) = cube();
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| faces[5][i]);
    faces[5] = vec![a, b, c];
    faces.push(vec![a, c, d]);
    assert_eq!(Brep::new(vertices, &faces), Err(BrepDefect::Partial { face: 5 }));
}

#[test]
fn a_doubled_polygon_is_flat() {
    let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let faces = [vec![0, 1, 2], vec![2, 1, 0]];
    assert_eq!(Brep::new(vertices, &faces), Err(BrepDefect::Flat(Flatness::Plane)));
}

#[test]
fn a_surface_that_winds_twice_is_refused() {
    let (vertices, triangles) = pentagram_pyramids();
    let faces: Vec<Vec<u32>> = triangles.iter().map(|triangle| triangle.to_vec()).collect();
    assert!(matches!(Brep::new(vertices, &faces), Err(BrepDefect::NotConvex { .. })));
}

proptest! {
    #[test]
    fn hulls_pass_as_they_are(cloud in lattice_cloud()) {
        if let Ok(body) = Brep::hull(cloud) {
            let faces: Vec<Vec<u32>> = (0..body.face_count()).map(|face| body.face(face).collect()).collect();
            let taken = Brep::new(body.vertices().to_vec(), &faces);
            prop_assert_eq!(taken.as_ref(), Ok(&body));
            // Any face turned, dropped or doubled is noticed.
            for face in 0..faces.len() {
                let mut turned = faces.clone();
                turned[face].reverse();
                prop_assert!(Brep::new(body.vertices().to_vec(), &turned).is_err());
                turned.remove(face);
                prop_assert!(Brep::new(body.vertices().to_vec(), &turned).is_err());
            }
        }
    }
}
