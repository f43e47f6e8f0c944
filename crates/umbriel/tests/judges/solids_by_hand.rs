//! The oracle's curved bodies, on cases with answers known by hand and against a numerical second opinion.

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Convex, Facets, LightSource, PlacedAnalytic, Placement};

use crate::oracle::{
    blocking::{Ellipsoid, Lamp, Place},
    body::placed,
    cases,
    curved::Curved,
    dice::Dice,
    graze::{Target, maps, segment, subjects},
    hull::hull,
    margin::clearly_blocks,
    number::{Binary, vector},
    solids::Solid,
};

/// Just above zero, as floats near one go.
const BIT: f64 = f64::EPSILON;

fn body(solid: Solid) -> Curved {
    placed(&solid, &Placement::IDENTITY, solid.is_closed())
}

/// Whether the body blocks the open segment from x to a point.
fn between(body: &Curved, x: [f64; 3], light: [f64; 3]) -> bool {
    body.blocks(&Place::new(vector(x)), &Lamp::new(&LightSource::point(light).expect("a light")))
}

/// Whether the body blocks the open ray from x along a vector.
fn along(body: &Curved, x: [f64; 3], way: [f64; 3]) -> bool {
    let sun = LightSource::sun(way.map(|coordinate| -coordinate)).expect("a sun");
    body.blocks(&Place::new(vector(x)), &Lamp::new(&sun))
}

#[test]
fn a_cylinder_blocks_along_its_rulings_and_in_the_planes_of_its_ends() {
    let cylinder = body(Solid::Cylinder(1.0, 2.0));
    assert!(along(&cylinder, [1.0, -3.0, 0.0], [0.0, 1.0, 0.0]), "along a ruling");
    assert!(!along(&cylinder, [1.0 + BIT, -3.0, 0.0], [0.0, 1.0, 0.0]), "beside it");
    assert!(along(&cylinder, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), "from the side, within the side");
    assert!(along(&cylinder, [1.0, 0.0, -5.0], [0.0, 0.0, 1.0]), "a tangent touches");
    assert!(!along(&cylinder, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]), "from where it touches");
    assert!(!along(&cylinder, [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]), "from the rim, up");
    assert!(along(&cylinder, [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]), "from the lower rim, up within the side");
    assert!(!along(&cylinder, [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]), "from the top, up");
    assert!(along(&cylinder, [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]), "from the top, down to the bottom");
    assert!(along(&cylinder, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]), "from the top, within the top");
    assert!(!along(&cylinder, [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]), "from the rim, outward in its plane");
    assert!(along(&cylinder, [-2.0, 1.0, 1.0], [1.0, 0.0, 0.0]), "in the top's plane, touching the rim");
    assert!(!along(&cylinder, [-2.0, 1.0, 1.0 + BIT], [1.0, 0.0, 0.0]), "past the rim");
    assert!(!along(&cylinder, [-2.0, 1.0 + BIT, 0.0], [1.0, 0.0, 0.0]), "just over the top");
    assert!(!between(&cylinder, [0.5, 0.5, 0.0], [0.0, -0.5, 0.5]), "both inside");
    assert!(between(&cylinder, [1.0, 0.0, 0.0], [-1.5, 0.0, 0.0]), "the far side counts");
    assert!(!between(&cylinder, [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), "the light on the far side");
    assert!(!between(&cylinder, [1.0, 1.0, 0.0], [1.0, 1.0, 0.0]), "the light at the point");
}

#[test]
fn a_cone_ends_at_its_apex() {
    let cone = body(Solid::Frustum(1.0, 0.0, 2.0));
    assert!(along(&cone, [-4.0, 1.0, 0.0], [1.0, 0.0, 0.0]), "through the apex");
    assert!(!along(&cone, [-4.0, 1.0 + BIT, 0.0], [1.0, 0.0, 0.0]), "over it");
    assert!(along(&cone, [-4.0, 1.0 - BIT, 0.0], [1.0, 0.0, 0.0]), "under it");
    assert!(
        !along(&cone, [0.0, 1.0, 0.0], [-1.0, 2.0, 0.0]),
        "from the apex along the other nappe, which is not there"
    );
    assert!(between(&cone, [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]), "along a generatrix, rim to apex");
    assert!(along(&cone, [2.0, -3.0, 0.0], [-1.0, 2.0, 0.0]), "along a generatrix from below");
    assert!(!between(&cone, [-1.0, 3.0, 0.0], [1.0, 3.0, 0.0]), "across the other nappe");
    assert!(along(&cone, [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]), "from the apex down to the base");
    assert!(!along(&cone, [0.0, -1.0, 0.0], [0.0, -1.0, 0.0]), "from the base, down");
}

#[test]
fn a_frustum_and_a_cup_are_each_other_upside_down() {
    let (frustum, cup) = (body(Solid::Frustum(2.0, 1.0, 2.0)), body(Solid::Frustum(1.0, 2.0, 2.0)));
    for (x, way, blocked) in [
        ([1.5, 0.0, -5.0], [0.0, 0.0, 1.0], true),
        ([1.5 + BIT, 0.0, -5.0], [0.0, 0.0, 1.0], false),
        ([2.0, -1.0, 0.0], [-1.0, 2.0, 0.0], true),
        ([1.0, 1.0, 0.0], [-1.0, 2.0, 0.0], false),
        ([2.0, 1.0, 0.0], [0.0, -1.0, 0.0], true),
        ([2.0 + 2.0 * BIT, 1.0, 0.0], [0.0, -1.0, 0.0], false),
        ([1.0, 1.0, 5.0], [0.0, 0.0, -1.0], true),
    ] {
        let flipped = |[a, b, c]: [f64; 3]| [a, -b, c];
        assert_eq!(along(&frustum, x, way), blocked, "{x:?} along {way:?}");
        assert_eq!(along(&cup, flipped(x), flipped(way)), blocked, "{x:?} along {way:?}, upside down");
    }
}

#[test]
fn capsules_and_paraboloids_touch_where_they_should() {
    let capsule = body(Solid::Capsule(1.0, 2.0));
    assert!(along(&capsule, [-4.0, 2.0, 0.0], [1.0, 0.0, 0.0]), "over the pole");
    assert!(!along(&capsule, [-4.0, 2.0 + 2.0 * BIT, 0.0], [1.0, 0.0, 0.0]));
    assert!(along(&capsule, [1.0, 1.0, -4.0], [0.0, 0.0, 1.0]), "where the side becomes the half sphere");
    assert!(!along(&capsule, [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]), "from there, up");
    assert!(!between(&capsule, [0.0, 1.0, 0.0], [0.0, 0.0, 0.5]), "no wall between side and half sphere");
    let paraboloid = body(Solid::Paraboloid(2.0, 4.0));
    // y = 2 − x² − z².
    assert!(along(&paraboloid, [-4.0, 2.0, 0.0], [1.0, 0.0, 0.0]), "over the apex");
    assert!(along(&paraboloid, [0.0, 3.0, 0.0], [0.0, -1.0, 0.0]), "down the axis");
    assert!(!along(&paraboloid, [0.0, 2.0, 0.0], [0.0, 1.0, 0.0]), "from the apex, up");
    assert!(along(&paraboloid, [1.0, 1.0, 0.0], [0.0, -1.0, 0.0]), "from the side, down to the base");
    assert!(along(&paraboloid, [3.0, -3.0, 0.0], [-2.0, 4.0, 0.0]), "the tangent at (1, 1)");
    assert!(!along(&paraboloid, [3.0, -3.0 + 4.0 * BIT, 0.0], [-2.0, 4.0, 0.0]), "above the tangent");
    assert!(along(&paraboloid, [3.0, -2.0, 0.0], [-1.0, 0.0, 0.0]), "in the base's plane");
}

#[test]
fn a_hyperboloid_shades_itself_and_blocks_along_its_rulings() {
    // x² + z² = 9 + y², |y| ≤ 4.
    let hyperboloid = body(Solid::Hyperboloid(3.0, 5.0, 8.0));
    assert!(along(&hyperboloid, [3.0, -8.0, -8.0], [0.0, 1.0, 1.0]), "along a ruling");
    assert!(!along(&hyperboloid, [3.0 + 2.0 * BIT, -8.0, -8.0], [0.0, 1.0, 1.0]), "beside it");
    assert!(!between(&hyperboloid, [3.0, -8.0, -8.0], [3.0, -4.0, -4.0]), "as far as the rim");
    assert!(along(&hyperboloid, [5.0, -4.0, 0.0], [0.0, 1.0, 0.0]), "from the lower rim up to the upper one");
    assert!(!between(&hyperboloid, [5.0, -4.0, 0.0], [5.0, 4.0, 0.0]), "past the waist");
    assert!(!between(&hyperboloid, [4.0, -1.0, 0.0], [4.0, 1.0, 0.0]), "outside, at the waist");
    assert!(along(&hyperboloid, [5.0, -4.0, 0.0], [-1.0, 1.5, 0.0]), "from the lower rim through the waist");
}

#[test]
fn a_disk_is_closed_and_thin() {
    let disk = body(Solid::Disk(5.0));
    assert!(along(&disk, [3.0, -1.0, 4.0], [0.0, 1.0, 0.0]), "through the rim");
    assert!(!along(&disk, [3.0, -1.0, 4.0 + 4.0 * BIT], [0.0, 1.0, 0.0]));
    assert!(!along(&disk, [3.0, 0.0, 1.0], [0.0, 1.0, 0.0]), "contact");
    assert!(along(&disk, [7.0, 0.0, 5.0], [-1.0, 0.0, 0.0]), "in its plane, touching the rim");
    assert!(!along(&disk, [5.0, 0.0, 0.0], [1.0, 0.0, 0.0]), "from the rim, outward");
    assert!(along(&disk, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), "from the middle, within");
}

#[test]
fn a_quadric_is_closed_where_its_box_cuts_it() {
    // A cylinder of radius 5 about y, cut at |x| ≤ 4 and |y| ≤ 3.
    let cylinder = [[1.0, 0.0, 0.0, 0.0], [0.0; 4], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, -25.0]];
    let cut = body(Solid::Quadric(cylinder, [[-4.0, -3.0, -6.0], [4.0, 3.0, 6.0]]));
    assert!(between(&cut, [4.5, 0.0, 0.0], [3.0, 0.0, 0.0]), "the flat face at x = 4");
    assert!(between(&cut, [4.5, 0.0, 3.0], [3.0, 0.0, 3.0]), "its edge with the cylinder");
    assert!(!between(&cut, [4.5, 0.0, 3.25], [3.875, 0.0, 3.25]), "beyond that edge the face is open");
    assert!(between(&cut, [0.0, 4.0, 4.0], [0.0, 2.0, 4.0]), "the lid");
    assert!(!between(&cut, [0.0, 4.0, 5.5], [0.0, 2.0, 5.5]), "in the box, outside the cylinder");
    assert!(along(&cut, [4.0, 3.0, 7.0], [0.0, 0.0, -1.0]), "along the box's edge");
    assert!(along(&cut, [5.0, 3.0, 0.0], [-1.0, 0.0, 0.0]), "in the lid's plane");
    assert!(!along(&cut, [4.0, 0.0, 0.0], [1.0, 0.0, 0.0]), "from the flat face, out");
    let plane = [[1.0, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4], [0.0; 4]];
    let sheet = body(Solid::Quadric(plane, [[-2.0; 3], [2.0; 3]]));
    assert!(between(&sheet, [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), "a doubled plane is there");
    assert!(!between(&sheet, [-1.0, 2.5, 0.0], [1.0, 2.5, 0.0]), "within its box");
}

#[test]
fn hulls_have_the_faces_that_they_should() {
    let corners: Vec<[f64; 3]> = (0..8).map(|k| std::array::from_fn(|axis| f64::from(k >> axis & 1))).collect();
    let spare = [[0.5, 0.5, 0.0], [0.5, 0.0, 0.0], [0.5, 0.5, 0.5], [0.0, 0.0, 0.0]];
    let cube = hull(&[&corners[..], &spare[..]].concat(), false);
    assert_eq!(cube.len(), 12, "six faces of two triangles each");
    let outward = |[a, b, c]: &[[f64; 3]; 3]| {
        let [a, b, c] = [*a, *b, *c].map(DVec3::from_array);
        (b - a).cross(c - a).dot(a - DVec3::splat(0.5)) > 0.0
    };
    assert!(cube.iter().all(outward));
    assert_eq!(cube[0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]], "from points 0, 1 and 5");
    assert_eq!(hull(&corners[..4], false), Vec::<[[f64; 3]; 3]>::new(), "a square has no inside");
    let mut dice = Dice::new("hulls", 0);
    for _ in 0..300 {
        let points: Vec<[f64; 3]> = (0..4 + dice.below(8)).map(|_| dice.grid_point(2, 1.0)).collect();
        let Ok(convex) = Convex::new(points.clone()) else { continue };
        let facets = Facets::of_convex(&convex, &Placement::IDENTITY).expect("a body");
        let ours = hull(&points, false);
        assert_eq!(ours.len(), facets.len(), "{points:?}");
        for (number, triangle) in ours.iter().enumerate() {
            let corners = facets.facet(number).corners();
            let theirs: Vec<[f64; 3]> =
                corners.iter().map(|&corner| facets.point(corner).position.to_array()).collect();
            assert_eq!(theirs[..], triangle[..], "face {number} of {points:?}");
        }
    }
}

#[test]
fn lit_sides_are_outward() {
    let lamp = |position| Lamp::new(&LightSource::point(position).expect("a light"));
    let at = |position| Place::new(vector(position));
    let cone = body(Solid::Frustum(1.0, 0.0, 2.0));
    assert_eq!(cone.light_side(1, &at([0.5, 0.0, 0.0]), &lamp([2.0, 0.0, 0.0])), 1);
    assert_eq!(cone.light_side(1, &at([0.5, 0.0, 0.0]), &lamp([-0.5, 2.0, 0.0])), 0, "on the generatrix");
    assert_eq!(cone.light_side(1, &at([0.0, 1.0, 0.0]), &lamp([0.0, 3.0, 0.0])), 0, "the apex has no side");
    assert_eq!(cone.light_side(0, &at([0.5, -1.0, 0.0]), &lamp([0.0, -3.0, 0.0])), 1);
    let mirror = Placement::new(DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0))).expect("regular");
    let solid = Solid::Disk(1.0);
    assert_eq!(placed(&solid, &mirror, true).light_side(0, &at([0.0; 3]), &lamp([0.0, 1.0, 0.0])), -1);
    let mirrored = placed(&Solid::Cylinder(1.0, 2.0), &mirror, true);
    assert_eq!(mirrored.light_side(2, &at([0.0, -1.0, 0.0]), &lamp([0.0, -2.0, 0.0])), 1, "the top, now below");
    assert_eq!(mirrored.light_side(1, &at([1.0, 0.5, 0.0]), &lamp([2.0, 0.5, 0.0])), 1);
}

#[test]
fn two_ways_to_meet_a_sphere_agree() {
    let subject = &subjects()[0];
    for (place, map) in maps().into_iter().enumerate() {
        let target = Target::new(subject, map);
        let radius = Binary::new(15.0);
        let ellipsoid = Ellipsoid::new(&target.curved.rows, target.curved.origin.clone(), &radius);
        for number in 0..cases(300) {
            let segment = segment(subject, &target, &mut Dice::new("two ways", number));
            let (x, lamp) = (Place::new(vector(segment.x)), Lamp::new(&segment.light));
            assert_eq!(target.curved.blocks(&x, &lamp), ellipsoid.blocks(&x, &lamp), "placement {place}: {segment:?}");
        }
    }
}

#[test]
fn points_of_faces_lie_on_their_pieces() {
    for subject in subjects() {
        let (solid, curved) = (subject.solid(), body(subject.solid()));
        let mut dice = Dice::new("faces", 0);
        for face in (0..200).map(|number| number % solid.face_count()) {
            let Some((piece, local)) = solid.point(face, dice.parameters(false)) else { continue };
            assert!(curved.piece_holds(piece, &local), "{}: face {face}", subject.name);
        }
    }
}

#[test]
fn faces_are_where_the_library_says() {
    for subject in subjects() {
        let solid = subject.solid();
        let placed = PlacedAnalytic::new(subject.body, Placement::IDENTITY).expect("an accepted body");
        let mut dice = Dice::new("charts", 0);
        for (face, chart) in (0..20).flat_map(|_| placed.charts().iter().enumerate()) {
            let parameters = dice.parameters(false);
            let exact = chart.exact_point(&Placement::IDENTITY, parameters[0], parameters[1]);
            let point = solid.point(face, parameters);
            assert_eq!(exact.is_some(), point.is_some(), "{}: face {face} at {parameters:?}", subject.name);
            let Some((_, local)) = point else { continue };
            let (ours, theirs) = (DVec3::from_array(local.approximate()), chart.point(parameters[0], parameters[1]));
            assert!(ours.distance(theirs) < 1e-12 * 30.0, "{}: face {face}: {ours} and {theirs}", subject.name);
        }
        assert_eq!(placed.charts().len(), solid.face_count(), "{}", subject.name);
    }
}

#[test]
fn the_oracle_agrees_with_sampling_where_sampling_is_clear() {
    for subject in subjects() {
        let curved = body(subject.solid());
        let mut counts = [0; 2];
        for number in 0..cases(400) {
            let mut dice = Dice::new("sampling", number);
            let mut any = || DVec3::from_array(std::array::from_fn(|_| dice.float(-12.0, 12.0)));
            let (x, light) = (any(), any());
            let is_sun = number % 3 == 0;
            let Some(clear) = clearly_blocks(&subject.solid(), x, light, is_sun) else { continue };
            counts[usize::from(clear)] += 1;
            let (x, light) = (x.to_array(), light.to_array());
            let exact = if is_sun { along(&curved, x, light) } else { between(&curved, x, light) };
            assert_eq!(exact, clear, "{}: {x:?} to {light:?}, sun {is_sun}", subject.name);
        }
        let has_inside = !["disk", "sheet"].contains(&subject.name);
        assert!(!has_inside || counts.iter().all(|&count| count >= 10), "{}: {counts:?}", subject.name);
    }
}
