//! Every decision of this layer reaches the level behind its filter: one smallest case each. NUMERICS.md, section 4, names
//! these tests.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use umbriel_geometry::{
    Aabb, Analytic, Convex, Cuboid, Dyadic, Facets, LightSource, Mesh, PlacedAnalytic, Placement, PlacementDefect,
    Point, Region, Relation, Ring, Sign,
    analytic::Surface,
    blocking::{Probe, polygon_blocks},
    decisions::Decisions,
};

/// An answer, and what settled the decisions behind it.
fn counted<T>(decide: impl FnOnce() -> T) -> (T, Decisions) {
    let before = Decisions::of_thread();
    let answer = decide();
    (answer, Decisions::of_thread() - before)
}

/// An answer that big numbers must have settled in part.
fn exactly<T>(decide: impl FnOnce() -> T) -> T {
    let (answer, decisions) = counted(decide);
    assert!(decisions.exact > 0, "{decisions:?}");
    answer
}

/// An answer without any exact arithmetic.
fn by_floats<T>(decide: impl FnOnce() -> T) -> T {
    let (answer, decisions) = counted(decide);
    assert!(decisions.double > 0 && decisions.double == decisions.all(), "{decisions:?}");
    answer
}

/// An answer that pairs of floats have settled in part, and exact arithmetic nothing of.
fn by_pairs<T>(decide: impl FnOnce() -> T) -> T {
    let (answer, decisions) = counted(decide);
    assert!(decisions.pair > 0 && decisions.expansion + decisions.exact == 0, "{decisions:?}");
    answer
}

fn sun(direction: [f64; 3]) -> LightSource {
    LightSource::sun(direction).expect("a sun")
}

fn triangle(corners: [[f64; 3]; 3]) -> [Point<'static>; 3] {
    corners.map(|corner| Point::exact(corner.into()))
}

fn turned() -> Placement {
    let map = DAffine3::from_quat(DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize());
    Placement::new(map).expect("regular")
}

#[test]
fn a_way_through_an_edge_is_told_by_pairs() {
    let corners = triangle([[0.0, 1.0, 0.0], [0.3, 1.0, 0.0], [0.0, 1.0, 0.3]]);
    let overhead = sun([0.1, -1.0, 0.1]);
    let blocks = |x: [f64; 3]| polygon_blocks(&corners, &Probe::<Dyadic>::at(x.into()), &overhead);
    assert!(by_floats(|| blocks([0.2, 0.0, 0.2])));
    assert!(!by_floats(|| blocks([1.2, 0.0, 0.2])));
    // A point on the light's plane through the slanted edge: a quarter of the way along it, exactly below.
    let half = triangle([[0.0, 1.0, 0.0], [0.5, 1.0, 0.0], [0.0, 1.0, 0.5]]);
    let slanted = sun([0.25, -1.0, 0.125]);
    let below = |ulps: i64| f64::from_bits(0.625f64.to_bits().wrapping_add_signed(ulps));
    let blocks = |ulps: i64| polygon_blocks(&half, &Probe::<Dyadic>::at([below(ulps), 0.0, 0.25].into()), &slanted);
    assert!(by_pairs(|| blocks(0)), "on the edge");
    assert!(!by_pairs(|| blocks(1)), "one ulp outside");
    assert!(by_pairs(|| blocks(-1)), "one ulp inside");
}

#[test]
fn a_way_through_an_edge_is_blocked_exactly() {
    // The middle of the way is the middle of an edge: L = a + (b − x), without rounding where all are in [1, 2).
    let (a, b, x) = ([1.1, 1.7, 1.3], [1.9, 1.2, 1.6], [1.4, 1.5, 1.8]);
    let corners = triangle([a, b, [1.2, 1.1, 1.9]]);
    let blocks = |ulps: i64| {
        let mut lamp: [f64; 3] = std::array::from_fn(|k| a[k] + (b[k] - x[k]));
        lamp[0] = f64::from_bits(lamp[0].to_bits().wrapping_add_signed(ulps));
        let light = LightSource::point(lamp).expect("a lamp");
        polygon_blocks(&corners, &Probe::<Dyadic>::at(x.into()), &light)
    };
    assert!(exactly(|| blocks(0)), "through the edge");
    assert_ne!(by_pairs(|| blocks(1)), by_pairs(|| blocks(-1)), "beside it on either side");
}

/// A point with all its digits on a plane of symmetry, which holds an edge and the lamp.
#[test]
fn a_place_on_a_plane_of_symmetry_is_told_by_pairs() {
    let own = triangle([[1.5, 3.0, -0.5], [0.5, 3.0, -0.5], [1.5, 3.0, -1.5]]);
    let roof = triangle([[0.0, 3.1875, 0.0], [2.0, 3.1875, -2.0], [2.0, 3.1875, 0.0]]);
    let lamp = LightSource::point([-1.0, 4.0, 1.0]).expect("a lamp");
    let blocks = |u: f64, v: f64| polygon_blocks(&roof, &Probe::<Dyadic>::on_face(own, u, v), &lamp);
    // Its corner (1.5, −0.5) is off the plane x + z = 0, the middle of the opposite side on it.
    let on_plane = |u: f64| blocks(u, 1.0 - u);
    for u in [1.0 / 3.0, 0.1, 0.7] {
        let (_, decisions) = counted(|| on_plane(u));
        assert_eq!(decisions.exact, 0, "{u}: {decisions:?}");
    }
    let own = triangle([[0.5, 3.0, -0.5], [0.5, 3.0, -1.5], [1.5, 3.0, -0.5]]);
    let blocks = |u: f64, v: f64| polygon_blocks(&roof, &Probe::<Dyadic>::on_face(own, u, v), &lamp);
    for u in [1.0 / 3.0, 0.1, 0.45] {
        assert!(by_pairs(|| blocks(u, u)), "{u}: closed faces hold their edges");
        assert!(by_pairs(|| blocks(u, u.next_up())) != by_pairs(|| blocks(u, u.next_down())), "{u}");
    }
}

#[test]
fn a_way_in_the_plane_of_a_face_is_followed_exactly() {
    let wall = triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.5, 1.0, 0.5]]);
    let along = sun([1.0, 0.0, 1.0]);
    let blocks = |x: [f64; 3]| polygon_blocks(&wall, &Probe::<Dyadic>::at(x.into()), &along);
    assert!(exactly(|| blocks([2.0, 0.25, 2.0])), "behind the wall");
    assert!(!exactly(|| blocks([-2.0, 0.25, -2.0])), "before it");
}

#[test]
fn contact_with_a_neighbour_in_one_plane_needs_no_big_numbers() {
    // Two triangles of one slanted plane; no coordinate of the point is a float.
    let own = triangle([[0.0, 0.0, 0.0], [3.0, 1.0, 0.0], [0.0, 1.0, 3.0]]);
    let neighbour = triangle([[3.0, 1.0, 0.0], [3.0, 2.0, 3.0], [0.0, 1.0, 3.0]]);
    let probe: Probe = Probe::on_face(own, 0.1, 0.7);
    let (blocked, decisions) = counted(|| polygon_blocks(&neighbour, &probe, &sun([0.3, -1.0, 0.2])));
    assert!(!blocked && decisions.exact == 0, "{decisions:?}");
}

#[test]
fn contact_along_the_side_opposite_the_first_corner_needs_no_big_numbers() {
    let own = triangle([[0.1, 0.3, 0.7], [1.1, 1.7, 1.3], [1.9, 1.2, 0.6]]);
    let neighbour = triangle([[1.9, 1.2, 0.6], [1.1, 1.7, 1.3], [1.3, 2.9, 0.2]]);
    let probe: Probe = Probe::on_face(own, 0.25, 0.75);
    let (blocked, decisions) = counted(|| polygon_blocks(&neighbour, &probe, &sun([0.3, -1.0, 0.2])));
    assert!(!blocked && decisions.expansion + decisions.exact == 0, "{decisions:?}");
}

#[test]
fn a_place_on_a_turned_face_below_an_edge_is_told_by_pairs() {
    // Neither the corners of the face nor those of the blocker are floats.
    let floor = Facets::of_cuboid(&Cuboid { size: [2.0; 3] }, &turned());
    let corners = [0, 1, 2].map(|k| floor.point(floor.facet(0).corners()[k]));
    let middle: Probe = Probe::on_face([corners[0], corners[1], corners[2]], 0.25, 0.25);
    let at = middle.bounds.position;
    let blocker =
        triangle([[at.x, at.y + 1.0, at.z - 1.0], [at.x, at.y + 1.0, at.z + 1.0], [at.x + 1.0, at.y + 1.0, at.z]]);
    let blocked = by_pairs(|| polygon_blocks(&blocker, &middle, &sun([0.0, -1.0, 0.0])));
    // The blocker ends where the point's coordinate was rounded to.
    let exact = middle.exact().xyz[0].clone() - Dyadic::new(at.x);
    assert_eq!(blocked, exact.sign() != Sign::Negative);
}

#[test]
fn a_way_that_grazes_a_ball_is_blocked_exactly() {
    let ball = PlacedAnalytic::new(Analytic::Sphere { radius: 1.0 }, Placement::IDENTITY).expect("a ball");
    let overhead = sun([0.0, -1.0, 0.0]);
    let blocks = |x: [f64; 3]| ball.blocks(&Probe::<Dyadic>::at(x.into()), None, &overhead);
    assert!(by_floats(|| blocks([0.5, -3.0, 0.0])));
    assert!(by_pairs(|| blocks([1.0, -3.0, 0.0])), "the outline itself");
    assert!(!by_pairs(|| blocks([1.0f64.next_up(), -3.0, 0.0])), "one ulp outside");
    // A radius with all its digits: its square beside that of the way is longer than pairs are.
    let ball = PlacedAnalytic::new(Analytic::Sphere { radius: 0.1 }, Placement::IDENTITY).expect("a ball");
    let blocks = |x: f64| ball.blocks(&Probe::<Dyadic>::at(DVec3::new(x, -3.0, 0.0)), None, &overhead);
    assert!(exactly(|| blocks(0.1)), "the outline itself");
    assert!(by_pairs(|| blocks(0.1f64.next_down())) && !by_pairs(|| blocks(0.1f64.next_up())), "beside it");
}

#[test]
fn a_light_in_the_tangent_plane_is_told_exactly() {
    let ball = PlacedAnalytic::new(Analytic::Sphere { radius: 1.0 }, Placement::IDENTITY).expect("a ball");
    let part = ball.parts()[0].surface;
    assert!(matches!(part, Surface::Quadric(_)));
    let facing = |x: [f64; 3], light: &LightSource| ball.facing(part, &Probe::<Dyadic>::at(x.into()), light);
    assert_eq!(by_floats(|| facing([1.0, 0.0, 0.0], &sun([-1.0, -0.1, 0.0]))), Sign::Positive);
    assert_eq!(by_pairs(|| facing([0.6, 0.8, 0.0], &sun([0.8, -0.6, 1.0]))), Sign::Zero);
    // Factors that are no pairs.
    let egg = Analytic::Ellipsoid { radii: [0.1, 0.1, 0.3] };
    let egg = PlacedAnalytic::new(egg, Placement::IDENTITY).expect("an ellipsoid");
    let x = Probe::<Dyadic>::at(DVec3::new(0.06, 0.08, 0.0));
    assert_eq!(exactly(|| egg.facing(part, &x, &sun([0.08, -0.06, 1.0]))), Sign::Zero);
}

/// On the terminator the root of a sample's coordinates drops out of the sign: pairs tell it, wherever the body stands.
#[test]
fn points_of_patches_on_the_terminator_are_told_by_pairs() {
    let slant = sun([0.5, -1.0, 0.0]);
    let moved = Placement::new(DAffine3::from_translation(DVec3::new(0.1, 0.7, -0.3))).expect("regular");
    for placement in [Placement::IDENTITY, moved] {
        let ball = Analytic::Sphere { radius: 0.3 };
        let ball = PlacedAnalytic::new(ball, placement).expect("a ball");
        // Of the face +x the points at v, and there y is half of x.
        let chart = &ball.charts()[1];
        let facing =
            |u: f64, v: f64| ball.facing(chart.surface, &Probe::on_patch(chart, ball.placement(), u, v), &slant);
        for t in [0.1, 0.5, 0.9] {
            assert_eq!([(0.75, t), (t, 0.75)].map(|(u, v)| counted(|| facing(u, v)).1.exact), [0; 2]);
            assert_eq!(by_pairs(|| facing(0.75, t)), Sign::Zero, "{t}");
        }
        assert_eq!(by_pairs(|| facing(0.75f64.next_up(), 0.3)), Sign::Positive);
    }
}

#[test]
fn a_lamp_in_a_tip_is_told_exactly() {
    let cone = PlacedAnalytic::new(Analytic::Cone { radius: 0.3, height: 1.1 }, Placement::IDENTITY).expect("a cone");
    let lamp = |y: f64| LightSource::point([0.0, y, 0.0]).expect("a lamp");
    assert!(exactly(|| cone.is_tip(0, &lamp(0.55))));
    assert!(!exactly(|| cone.is_tip(0, &lamp(0.55f64.next_up()))));
    assert!(!by_floats(|| cone.is_tip(0, &lamp(0.6))));
}

#[test]
fn points_in_the_plane_of_a_cap_are_told_exactly() {
    // A cylinder's planes: the lower cap first.
    let local = |y: f64| [DVec3::new(3.0, y, 0.1), DVec3::new(-0.7, y, 5.0), DVec3::new(0.3, y, -0.9)];
    let cylinder = |placement| PlacedAnalytic::new(Analytic::Cylinder { radius: 0.3, height: 1.1 }, placement);
    let level = cylinder(Placement::IDENTITY).expect("a cylinder");
    let at = |y: f64| local(y).map(Point::exact);
    assert!(!by_floats(|| level.plane_holds(0, &at(-0.5))));
    assert!(by_pairs(|| level.plane_holds(0, &at(-0.55))));
    assert!(!by_pairs(|| level.plane_holds(0, &at((-0.55f64).next_up()))));
    let (placed, images) = (cylinder(turned()).expect("a cylinder"), local(-0.55).map(|point| turned().exact(point)));
    let points: Vec<Point> = images.iter().map(|image| image.bounded()).collect();
    assert!(exactly(|| placed.plane_holds(0, &points)));
}

/// What the planes of the caps, and the quadric, are at a lamp in the plane of the lower cap: zero there, with a sign elsewhere.
#[test]
fn values_at_a_lamp_in_the_plane_of_a_cap_are_sharp() {
    let values = |placement: Placement, lamp: [f64; 3]| {
        let body = PlacedAnalytic::new(Analytic::Cylinder { radius: 0.3, height: 1.1 }, placement).expect("a cylinder");
        let (values, decisions) = counted(|| body.light_values(&LightSource::point(lamp).expect("a lamp")));
        (values[1].iter().map(|value| (value.sign(), value.error == 0.0)).collect::<Vec<_>>(), decisions)
    };
    let (planes, decisions) = values(Placement::IDENTITY, [3.0, -0.55, 0.1]);
    assert_eq!((planes[0], planes[1].0), ((Some(Sign::Zero), true), Some(Sign::Positive)));
    assert_eq!((decisions.pair, decisions.exact), (1, 0));
    // Sheared by a third: the caps stay level, and the lamp is one float above the lower one.
    let sheared = DMat3::from_cols(DVec3::X, DVec3::new(1.0 / 3.0, 1.0, 0.0), DVec3::Z);
    let sheared = Placement::new(DAffine3::from_mat3(sheared)).expect("regular");
    let (planes, _) = values(sheared, [3.0, (-0.55f64).next_up(), 0.1]);
    assert_eq!((planes[0].0, planes[1].0), (Some(Sign::Positive), Some(Sign::Positive)));
}

#[test]
fn the_border_of_a_sheet_is_told_exactly() {
    let mut matrix = [[0.0; 4]; 4];
    (matrix[0][0], matrix[2][2]) = (0.3, -0.3);
    let body = Analytic::Quadric { matrix, within: [[-1.0; 3], [1.0; 3]] };
    let body = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a quadric");
    // The side y = 1, where |x| ≤ |z|; as a sheet the cylinder has the point where both gradients are one.
    let side = &body.charts()[9];
    assert!(by_floats(|| side.has_point(0.1, 0.5)) != by_floats(|| side.has_point(0.5, 0.1)));
    assert!(exactly(|| side.has_point(0.1, 0.1)), "on the border");
}

#[test]
fn a_point_on_a_curved_surface_is_told_exactly() {
    let cone = PlacedAnalytic::new(Analytic::Cone { radius: 1.0, height: 2.0 }, turned()).expect("a cone");
    assert_eq!(by_floats(|| cone.side(&Point::exact(DVec3::ZERO), false)), Sign::Negative);
    // The apex: its image is no float, and exactly on the surface.
    let apex = turned().exact(DVec3::Y);
    assert_eq!(exactly(|| cone.side(&apex.bounded(), false)), Sign::Zero);
}

#[test]
fn a_flattening_matrix_is_told_exactly() {
    let columns = [DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.7, 0.5, 0.1), DVec3::new(0.2, 0.4, 0.6)];
    let place = |third: DVec3| {
        let matrix = DMat3::from_cols(columns[0], columns[1], third);
        Placement::new(DAffine3 { matrix3: matrix, translation: DVec3::ZERO })
    };
    assert!(by_floats(|| place(DVec3::Z)).is_ok());
    assert_eq!(exactly(|| place(columns[0] * 2.0)), Err(PlacementDefect::Singular));
    let mut near = columns[0] * 2.0;
    near.z = near.z.next_up();
    assert!(exactly(|| place(near)).is_ok(), "one ulp off is regular");
}

#[test]
fn a_vertex_between_two_floats_is_rounded_exactly() {
    // 1 + 2^-53 lies in the middle between 1 and the next float; y is moved by a hair of z.
    let half = f64::EPSILON / 2.0;
    let map = DAffine3 { matrix3: DMat3::IDENTITY, translation: DVec3::new(1.0, 1.0, 1.0) };
    let columns = DMat3::from_cols(DVec3::new(1.0, 0.0, 0.0), DVec3::Y, DVec3::new(0.0, half.powi(3), 1.0));
    let placement = Placement::new(DAffine3 { matrix3: columns, ..map }).expect("regular");
    assert_eq!(by_floats(|| placement.round(DVec3::new(0.25, 0.5, 0.75))), DVec3::new(1.25, 1.5, 1.75));
    assert_eq!(by_floats(|| placement.round(DVec3::new(-1.0, 0.5, 0.0))).x, 0.0, "zero, without rounding");
    assert_eq!(by_floats(|| placement.round(DVec3::new(half, 0.5, 0.0))).x, 1.0, "the middle itself, to even");
    assert_eq!(exactly(|| placement.round(DVec3::new(0.5, half, 1.0))).y, 1.0f64.next_up(), "above the middle");
    assert_eq!(exactly(|| placement.round(DVec3::new(0.5, half, -1.0))).y, 1.0, "below it");
}

#[test]
fn points_of_a_hull_on_one_line_are_told_exactly() {
    // From the origin differences are floats, and products of two of them pairs.
    let line = [[0.0; 3], [0.1; 3], [0.3; 3], [0.7; 3]].to_vec();
    assert!(by_pairs(|| Convex::new(line)).is_err());
    // Differences that begin at 1 and end beside 2^-110: their products are no pairs.
    let line = [[0.1 * 2f64.powi(-60); 3], [0.7; 3], [1.1; 3], [3.3; 3]].to_vec();
    assert!(exactly(|| Convex::new(line)).is_err());
}

#[test]
fn a_cell_that_a_face_touches_is_met_exactly() {
    let slanted =
        Mesh::new(vec![[3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]], vec![[0, 1, 2]]).expect("a triangle");
    let facets = Facets::of_mesh(slanted, &Placement::IDENTITY);
    let cell = |max: f64| Aabb { min: DVec3::splat(max - 0.3), max: DVec3::splat(max) };
    assert!(!by_floats(|| facets.meets(0, &cell(0.8))));
    assert!(exactly(|| facets.meets(0, &cell(1.0))), "a corner of the cell on the face");
    assert!(!exactly(|| facets.meets(0, &cell(1.0f64.next_down()))), "one ulp before it");
}

#[test]
fn a_corner_that_is_no_float_is_compared_exactly() {
    let facets = Facets::of_cuboid(&Cuboid { size: [3.3; 3] }, &turned());
    let corner = facets.point(0);
    assert!(corner.slack.min_element() > 0.0, "no float");
    // A cell that begins where the corner rounds to, on every axis.
    let cell = Aabb { min: corner.position, max: corner.position + DVec3::splat(0.25) };
    exactly(|| (0..6).filter(|&part| facets.meets(part, &cell)).count());
}

#[test]
fn a_ray_through_an_edge_is_counted_exactly() {
    let facets = Facets::of_cuboid(&Cuboid { size: [2.0; 3] }, &turned());
    let corner = facets.point(0).position;
    // The way along +x from far before the solid passes within an ulp of a corner.
    let outside = DVec3::new(corner.x - 9.0, corner.y, corner.z);
    assert!(!exactly(|| facets.encloses(outside)));
    assert!(facets.encloses(DVec3::ZERO));
}

#[test]
fn a_cell_that_touches_a_ball_is_met_exactly() {
    let ball = PlacedAnalytic::new(Analytic::Sphere { radius: 1.0 }, Placement::IDENTITY).expect("a ball");
    let cell = |min: f64| Aabb { min: DVec3::new(min, -0.5, -0.5), max: DVec3::new(min + 1.0, 0.5, 0.5) };
    assert_eq!(by_floats(|| ball.relation(&cell(1.5))), Relation::Outside);
    assert_eq!(exactly(|| ball.relation(&cell(1.0))), Relation::Boundary, "one point in common");
    assert_eq!(exactly(|| ball.relation(&cell(1.0f64.next_up()))), Relation::Outside);
}
