use glam::{DAffine3, DQuat, DVec3};
use std::f64::consts::PI;

use super::*;
use crate::{Approx, LightSource, Placement, Point, Ring, Sign, Surd, blocking::Probe};

fn bodies() -> Vec<Analytic> {
    vec![
        Analytic::Sphere { radius: 0.7 },
        Analytic::Ellipsoid { radii: [1.0, 0.3, 2.0] },
        Analytic::Cylinder { radius: 0.5, height: 2.0 },
        Analytic::Cone { radius: 0.8, height: 1.5 },
        Analytic::Frustum { bottom_radius: 0.4, top_radius: 1.1, height: 0.9 },
        Analytic::Capsule { radius: 0.6, height: 1.7 },
        Analytic::Paraboloid { radius: 1.2, height: 0.8 },
        Analytic::Hyperboloid { waist_radius: 0.3, end_radius: 1.0, height: 2.5 },
        Analytic::Disk { radius: 1.3 },
    ]
}

fn skewed() -> Placement {
    let turn = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 2.0, -0.3),
        DQuat::from_xyzw(0.5, 0.1, -0.7, 0.5).normalize(),
        DVec3::new(1e3, -3.0, 0.1),
    );
    let shear = DAffine3::from_cols_array(&[1.0, 0.2, 0.0, 0.1, 1.0, -0.4, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0]);
    Placement::new(turn * shear).expect("regular")
}

const PARAMETERS: [[f64; 2]; 6] = [[0.0, 0.0], [0.3, 0.9], [1.0, 0.5], [1e-9, 0.123], [1.0, 1.0], [0.5, 0.25]];

#[test]
fn faces_are_counted_as_they_are_made() {
    let matrix = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { [1.0, 2.0, -1.0, -1.0][i] } else { 0.0 }));
    let quadric = Analytic::Quadric { matrix, within: [[-1.0; 3], [1.0; 3]] };
    for body in bodies().into_iter().chain([quadric]) {
        let count = body.face_count();
        let placed = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
        assert_eq!(placed.charts().len(), count, "{body:?}");
    }
}

#[test]
fn points_of_charts_lie_exactly_on_the_surface_and_in_the_bounds() {
    for body in bodies() {
        let placed = PlacedAnalytic::new(body, skewed()).expect("a body");
        let (bounds, forms) = (placed.bounds(), placed.exact_forms().lifted::<Surd>());
        for (face, chart) in placed.charts().iter().enumerate() {
            let part = placed.parts().iter().find(|part| part.surface == chart.surface).expect("a part");
            for [u, v] in PARAMETERS {
                let x = chart.exact_point(placed.placement(), u, v).expect("on the surface");
                let local = forms.pull_back(&x.xyz, &x.w);
                let value = match chart.surface {
                    Surface::Quadric(index) => forms.quadric(index, &local, &local),
                    Surface::Plane(index) => forms.plane(index, &local),
                };
                assert_eq!(value.sign(), Sign::Zero, "{body:?}, face {face} at ({u}, {v})");
                assert!(placed.part_holds(part, &x), "{body:?}, face {face} at ({u}, {v})");
                let bounded = chart.bounded_point(placed.placement(), u, v);
                assert!(bounds.contains(bounded.position), "{body:?}, face {face} at ({u}, {v})");
                for axis in 0..3 {
                    let number = |value: f64| Surd::from_f64(value) * x.w.clone();
                    let (slack, rest) = (bounded.slack[axis], bounded.rest[axis]);
                    let off = x.xyz[axis].clone() - number(bounded.position[axis]);
                    let beyond = off.clone() - number(rest);
                    let left = number(slack) - number(rest.abs());
                    for (off, most) in [(off, number(slack)), (beyond, left)] {
                        for off in [off.clone(), -off] {
                            let room = (most.clone() - off).sign();
                            assert_ne!(room, Sign::Negative, "{body:?} {face} ({u}, {v}) {axis}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn patches_look_outward_and_hulls_hold_their_cells() {
    for body in bodies() {
        let placed = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
        for (face, chart) in placed.charts().iter().enumerate() {
            for ([u, v], edge) in
                [([0.25, 0.5], 0.25), ([0.0, 0.0], 1.0), ([0.75, 0.75], 0.25), ([0.5, 0.5], 2f64.powi(-12))]
            {
                let step = 1e-6;
                let x = chart.point(u + 0.3 * edge, v + 0.3 * edge);
                let along_u = chart.point(u + 0.3 * edge + step, v + 0.3 * edge) - x;
                let along_v = chart.point(u + 0.3 * edge, v + 0.3 * edge + step) - x;
                let exact = chart.exact_point(&Placement::IDENTITY, u + 0.3 * edge, v + 0.3 * edge).expect("surface");
                let outward = placed.outward(chart.surface, &exact).map(|c| match c.sign() {
                    Sign::Negative => -1.0,
                    Sign::Zero => 0.0,
                    Sign::Positive => 1.0,
                });
                let normal = along_u.cross(along_v);
                let agrees = (0..3).all(|k| normal[k] * outward[k] >= -1e-3 * normal.length());
                assert!(agrees, "{body:?}, face {face}: {normal} against {outward:?}");
                let hull = chart.hull([u, v], edge);
                // No point of the cell beyond the hull in any of many directions.
                for k in 0..200 {
                    let angle = f64::from(k) * 2.399_963;
                    let y = 1.0 - (f64::from(k) + 0.5) / 100.0;
                    let direction =
                        DVec3::new(angle.cos() * (1.0 - y * y).sqrt(), y, angle.sin() * (1.0 - y * y).sqrt());
                    let reach = hull.points.iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
                    for s in 0..=4 {
                        for t in 0..=4 {
                            let p = chart.point(u + edge * f64::from(s) / 4.0, v + edge * f64::from(t) / 4.0);
                            assert!(
                                p.dot(direction) <= reach + 4.0 * hull.slack.dot(direction.abs()),
                                "{body:?}, face {face}, {direction}"
                            );
                        }
                    }
                }
            }
        }
    }
}

fn total_area(body: Analytic, placement: &Placement, level: u32) -> Approx {
    let placed = PlacedAnalytic::new(body, *placement).expect("a body");
    let edge = 0.5f64.powi(level as i32);
    let mut sum = Approx::exact(0.0);
    for chart in placed.charts() {
        let area = PatchArea::new(chart, placement);
        for i in 0..1 << level {
            for j in 0..1 << level {
                sum = sum + area.of_cell([f64::from(i) * edge, f64::from(j) * edge], edge);
            }
        }
    }
    sum
}

#[test]
fn areas_hold_the_closed_forms() {
    let e = 3f64.sqrt() / 2.0;
    let (a, b, h) = (0.3f64, 1.0f64, 2.5f64);
    // Hyperboloid: 2π·∫ √(r² + (r r')²) dy with r² = a² + k·y², so 2π·∫ √(a² + k(1 + k)·y²) dy over −h/2..h/2.
    let k = 4.0 * (b * b - a * a) / (h * h);
    let m = (k * (1.0 + k)).sqrt();
    let antiderivative = |y: f64| 0.5 * (y * (a * a + m * m * y * y).sqrt() + a * a / m * (m * y / a).asinh());
    let paraboloid =
        |r: f64, h: f64| PI * r / (6.0 * h * h) * ((r * r + 4.0 * h * h).powf(1.5) - r.powi(3)) + PI * r * r;
    let cases = [
        (Analytic::Sphere { radius: 0.7 }, 4.0 * PI * 0.49),
        (Analytic::Ellipsoid { radii: [1.0, 1.0, 2.0] }, 2.0 * PI * (1.0 + 2.0 / e * e.asin())),
        (Analytic::Cylinder { radius: 0.5, height: 2.0 }, 2.0 * PI * 0.5 * 2.5),
        (Analytic::Cone { radius: 0.8, height: 1.5 }, PI * 0.8 * (0.8 + 0.8f64.hypot(1.5))),
        (
            Analytic::Frustum { bottom_radius: 0.4, top_radius: 1.1, height: 0.9 },
            PI * (0.16 + 1.21 + 1.5 * 0.7f64.hypot(0.9)),
        ),
        (Analytic::Capsule { radius: 0.6, height: 1.7 }, 4.0 * PI * 0.36 + 2.0 * PI * 0.6 * 1.7),
        (Analytic::Paraboloid { radius: 1.2, height: 0.8 }, paraboloid(1.2, 0.8)),
        (
            Analytic::Hyperboloid { waist_radius: a, end_radius: b, height: h },
            2.0 * PI * (antiderivative(h / 2.0) - antiderivative(-h / 2.0)) + 2.0 * PI * b * b,
        ),
        (Analytic::Disk { radius: 1.3 }, PI * 1.69),
    ];
    for (body, truth) in cases {
        for level in [0, 3] {
            let sum = total_area(body, &Placement::IDENTITY, level);
            let slack = truth * 1e-14;
            assert!(sum.lower() - slack <= truth && truth <= sum.upper() + slack, "{body:?}: {sum:?} holds {truth}");
            assert!(sum.error < 1e-8 * truth, "{body:?} at level {level}: {sum:?}");
        }
    }
}

#[test]
fn areas_of_flat_and_thin_bodies_are_bounded() {
    // Of spheroids: flat ones 2π·(1 + c²·atanh(e)/e), thin ones 2πc²·(1 + asin(e)/(c·e)), with the axes 1 and c.
    for c in [1e-2, 1e-9] {
        let e = (1.0f64 - c * c).sqrt();
        // atanh(e) = ln((1 + e)/c), which does not cancel.
        let flat = 2.0 * PI * (1.0 + c * c * ((1.0 + e) / c).ln() / e);
        let thin = 2.0 * PI * c * c * (1.0 + e.asin() / (c * e));
        for (radii, truth) in [([1.0, c, 1.0], flat), ([c, 1.0, 1.0], flat), ([c, 1.0, c], thin), ([c, c, 1.0], thin)] {
            let sum = total_area(Analytic::Ellipsoid { radii }, &Placement::IDENTITY, 2);
            let slack = truth * 1e-14;
            assert!(sum.lower() - slack <= truth && truth <= sum.upper() + slack, "{radii:?}: {sum:?} holds {truth}");
            assert!(sum.error < 1e-8 * truth, "{radii:?}: {sum:?}");
        }
    }
    // A hyperboloid that is all but a ring, and one that is all but two cones.
    for (waist_radius, height) in [(0.5, 1e-9), (1e-6, 2.0)] {
        let body = Analytic::Hyperboloid { waist_radius, end_radius: 0.75, height };
        let sum = total_area(body, &Placement::IDENTITY, 2);
        assert!(sum.error < 1e-8 * sum.value, "{body:?}: {sum:?}");
    }
}

#[test]
fn areas_of_skewed_bodies_do_not_depend_on_the_level() {
    for body in bodies() {
        let (coarse, fine) = (total_area(body, &skewed(), 0), total_area(body, &skewed(), 3));
        assert!((coarse.value - fine.value).abs() <= coarse.error + fine.error, "{body:?}: {coarse:?} {fine:?}");
        assert!(coarse.error < 1e-6 * coarse.value, "{body:?}: {coarse:?}");
    }
}

#[test]
fn the_inside_is_where_it_is_said_to_be() {
    let side = |body: Analytic, x: [f64; 3]| {
        let placed = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
        placed.side(&Point::exact(x.into()), false)
    };
    let capsule = Analytic::Capsule { radius: 1.0, height: 2.0 };
    assert_eq!(side(capsule, [0.0, 1.0, 0.0]), Sign::Negative, "the seam's middle");
    assert_eq!(side(capsule, [1.0, 1.0, 0.0]), Sign::Zero, "the seam");
    assert_eq!(side(capsule, [0.0, 2.0, 0.0]), Sign::Zero, "the pole");
    assert_eq!(side(capsule, [0.0, 2.0f64.next_up(), 0.0]), Sign::Positive);
    let cone = Analytic::Cone { radius: 1.0, height: 2.0 };
    assert_eq!(side(cone, [0.0, 1.0, 0.0]), Sign::Zero, "the apex");
    assert_eq!(side(cone, [0.0, 1.5, 0.0]), Sign::Positive, "the other nappe is not there");
    assert_eq!(side(cone, [0.5, 0.0, 0.0]), Sign::Zero);
    assert_eq!(side(Analytic::Disk { radius: 1.0 }, [0.0; 3]), Sign::Zero);
    assert_eq!(side(Analytic::Disk { radius: 1.0 }, [0.0, 1e-9, 0.0]), Sign::Positive);
}

#[test]
fn segments_meet_closed_surfaces() {
    let blocks = |body: Analytic, x: [f64; 3], light: &LightSource| {
        let placed = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
        placed.blocks(&Probe::<Surd>::at(x.into()), None, light)
    };
    let sun = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun overhead");
    let level = LightSource::sun([1.0, 0.0, 0.0]).expect("a level sun");
    let sphere = Analytic::Sphere { radius: 1.0 };
    assert!(blocks(sphere, [1.0, -2.0, 0.0], &sun), "a tangent touches");
    assert!(!blocks(sphere, [1.0f64.next_up(), -2.0, 0.0], &sun));
    assert!(blocks(sphere, [0.0; 3], &sun), "from inside");
    assert!(!blocks(sphere, [0.0, 1.0, 0.0], &sun), "contact on the lit side");
    assert!(blocks(sphere, [0.0, -1.0, 0.0], &sun), "the other root counts");
    let lamp = |y| LightSource::point([0.0, y, 0.0]).expect("a lamp");
    assert!(!blocks(sphere, [0.0, 0.5, 0.0], &lamp(-0.5)), "both inside");
    assert!(blocks(sphere, [0.0, -2.0, 0.0], &lamp(1.0)), "the lamp on the far surface");
    assert!(!blocks(sphere, [0.0, 2.0, 0.0], &lamp(1.0)), "the lamp on the near surface");
    assert!(!blocks(sphere, [0.0, 3.0, 0.0], &lamp(2.0)), "the sphere lies behind the lamp");
    let cylinder = Analytic::Cylinder { radius: 1.0, height: 2.0 };
    assert!(blocks(cylinder, [0.5, -2.0, 0.0], &sun), "through both ends");
    assert!(blocks(cylinder, [1.0, -2.0, 0.0], &sun), "along the side");
    assert!(!blocks(cylinder, [1.0f64.next_up(), -2.0, 0.0], &sun), "beside it");
    assert!(blocks(cylinder, [2.0, 0.0, 1.0], &level), "a tangent");
    assert!(!blocks(cylinder, [2.0, 0.0, 1.0f64.next_up()], &level));
    assert!(blocks(cylinder, [2.0, 1.0, 0.0], &level), "in the top's plane");
    assert!(!blocks(cylinder, [2.0, 1.0f64.next_up(), 0.0], &level));
    assert!(!blocks(cylinder, [0.0, 1.0, 0.0], &sun), "contact on the top");
    assert!(blocks(cylinder, [0.0, 0.0, 0.0], &sun), "from inside");
    let cone = Analytic::Cone { radius: 1.0, height: 2.0 };
    assert!(blocks(cone, [2.0, 1.0, 0.0], &level), "through the apex alone");
    assert!(!blocks(cone, [2.0, 1.0f64.next_up(), 0.0], &level));
    let ruling = LightSource::point([-1.0, 3.0, 0.0]).expect("a lamp");
    assert!(blocks(cone, [2.0, -3.0, 0.0], &ruling), "along a generatrix");
    let hyperboloid = Analytic::Hyperboloid { waist_radius: 1.0, end_radius: 2.0, height: 4.0 };
    assert!(
        !blocks(hyperboloid, [1.5, 0.0, 5.0], &LightSource::point([1.5, 0.0, -5.0]).expect("a lamp")),
        "past the waist"
    );
    assert!(blocks(hyperboloid, [0.5, 0.0, 5.0], &LightSource::point([0.5, 0.0, -5.0]).expect("a lamp")));
    let disk = Analytic::Disk { radius: 1.0 };
    assert!(blocks(disk, [2.0, 0.0, 0.0], &level), "edge-on");
    assert!(blocks(disk, [2.0, 0.0, 1.0], &level), "edge-on, at the rim");
    assert!(!blocks(disk, [2.0, 0.0, 1.0f64.next_up()], &level));
    assert!(blocks(disk, [1.0, -1.0, 0.0], &sun), "the rim");
    assert!(!blocks(disk, [0.5, 0.0, 0.0], &sun), "contact");
    assert!(blocks(disk, [0.5, 0.0, 0.0], &level), "from inside, in the plane");
    let paraboloid = Analytic::Paraboloid { radius: 1.0, height: 1.0 };
    assert!(blocks(paraboloid, [2.0, 0.5, 0.0], &level), "a tangent at the apex");
    assert!(!blocks(paraboloid, [2.0, 0.5f64.next_up(), 0.0], &level));
    assert!(blocks(paraboloid, [0.25, -2.0, 0.0], &sun), "along the axis's direction: one root");
}

#[test]
fn rays_find_the_place_they_are_aimed_at() {
    for body in bodies() {
        let placed = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
        for (face, chart) in placed.charts().iter().enumerate() {
            for [u, v] in [[0.5, 0.5], [0.1, 0.8], [0.97, 0.02]] {
                let x = chart.point(u, v);
                let exact = chart.exact_point(&Placement::IDENTITY, u, v).expect("surface");
                let normal = placed.outward(chart.surface, &exact).map(|c| c.rational().to_nearest());
                let outward = match chart.surface {
                    Surface::Plane(_) => DVec3::from_array(normal),
                    Surface::Quadric(_) => {
                        let step = 1e-7;
                        (chart.point(u + step, v) - x).cross(chart.point(u, v + step) - x)
                    }
                };
                let outward = outward.normalize();
                let hit = placed.nearest_local_hit(x + outward, -outward).expect("aimed at");
                assert_eq!(hit.face, face, "{body:?} {u} {v}");
                assert!((hit.distance - 1.0).abs() < 1e-6, "{body:?}: {hit:?}");
                assert!((hit.u - u).abs() < 1e-6 && (hit.v - v).abs() < 1e-6, "{body:?} ({u}, {v}): {hit:?}");
                assert!(hit.normal.normalize().dot(outward) > 1.0 - 1e-6, "{body:?}: {hit:?}");
            }
        }
    }
}

fn quadrics() -> Vec<Analytic> {
    let quadric = |matrix, within| Analytic::Quadric { matrix, within };
    let diagonal = |a: f64, b: f64, c: f64, d: f64| {
        [[a, 0.0, 0.0, 0.0], [0.0, b, 0.0, 0.0], [0.0, 0.0, c, 0.0], [0.0, 0.0, 0.0, d]]
    };
    // Mixed terms, a linear one, and an unsymmetric way to write them.
    let slanted = [[1.0, 0.8, 0.0, 0.1], [0.0, 2.0, -0.5, 0.0], [0.3, 0.0, 1.5, 0.0], [0.0, -0.4, 0.0, -1.0]];
    vec![
        quadric(diagonal(1.0, 1.0, 1.0, -1.0), [[-2.0; 3], [2.0; 3]]),
        quadric(diagonal(1.0, 1.0, 1.0, -1.0), [[-2.0, 0.0, -2.0], [2.0; 3]]),
        quadric(diagonal(1.0, 0.0, 1.0, -0.25), [[-1.0; 3], [1.0; 3]]),
        quadric(diagonal(1.0, -1.0, 1.0, 0.1), [[-1.0, -1.0, -1.0], [1.0, 1.5, 1.0]]),
        quadric(slanted, [[-0.7, -1.0, -1.0], [1.0, 0.6, 2.0]]),
        // The slab |x + y| ≤ 1/2: the gradient has two equal coordinates everywhere.
        quadric([[1.0, 1.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [0.0; 4], [0.0, 0.0, 0.0, -0.25]], [[-1.0; 3], [1.0; 3]]),
    ]
}

#[test]
fn around_the_middle_of_a_quadric_without_surface_no_cell_has_any() {
    // All gradients are zero in the middle: of a hyperboloid around y, over which it has no sheet along y, and of a body without points.
    let diagonal = |y: f64, constant: f64| {
        let rows = [1.0, y, 1.0, constant].into_iter().enumerate();
        let mut matrix = [[0.0; 4]; 4];
        rows.for_each(|(k, factor)| matrix[k][k] = factor);
        matrix
    };
    for (matrix, faces) in [(diagonal(-1.0, -0.25), 2..4), (diagonal(1.0, 0.5), 0..6)] {
        let body = Analytic::Quadric { matrix, within: [[-1.0; 3], [1.0; 3]] };
        let placed = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
        for face in faces {
            let chart = &placed.charts()[face];
            for cell in 0..64 {
                let (edge, at) = (1.0 / 128.0, [cell % 8, cell / 8].map(|k| 0.5 + f64::from(k - 4) / 128.0));
                assert_eq!(chart.occupied(at, edge), Occupied::Nowhere, "{body:?}, face {face} at {at:?}");
            }
        }
    }
}

#[test]
fn patches_of_quadrics_lie_on_the_surface_and_their_hulls_hold_them() {
    for body in quadrics() {
        let placed = PlacedAnalytic::new(body, Placement::IDENTITY).expect("a body");
        let forms = placed.exact_forms().lifted::<Surd>();
        let mut found = 0;
        for (face, chart) in placed.charts().iter().enumerate() {
            for cell in 0..64 {
                let (edge, at) = (0.125, [f64::from(cell % 8) / 8.0, f64::from(cell / 8) / 8.0]);
                let (hull, occupied) = (chart.hull(at, edge), chart.occupied(at, edge));
                for [s, t] in [[0.0, 0.0], [0.5, 0.5], [0.9, 0.2], [0.3, 1.0]] {
                    let [u, v] = [at[0] + s * edge, at[1] + t * edge];
                    let Some(exact) = chart.exact_point(&Placement::IDENTITY, u, v) else {
                        assert_ne!(occupied, Occupied::Whole, "{body:?}, face {face} at ({u}, {v})");
                        continue;
                    };
                    found += 1;
                    assert_ne!(occupied, Occupied::Nowhere, "{body:?}, face {face} at ({u}, {v})");
                    let local = forms.pull_back(&exact.xyz, &exact.w);
                    let value = match chart.surface {
                        Surface::Quadric(index) => forms.quadric(index, &local, &local),
                        Surface::Plane(index) => forms.plane(index, &local),
                    };
                    assert_eq!(value.sign(), Sign::Zero, "{body:?}, face {face} at ({u}, {v})");
                    let point = chart.point(u, v);
                    let (again, [p, q]) = placed.locate(chart.surface, point).expect("a place");
                    let on_border = placed.charts()[again].point(p, q).distance(point) < 1e-12;
                    assert!(
                        again == face && (p - u).abs() + (q - v).abs() < 1e-12 || on_border,
                        "{body:?} {face} {again}"
                    );
                    for k in 0..100 {
                        let angle = f64::from(k) * 2.399_963;
                        let y = 1.0 - (f64::from(k) + 0.5) / 50.0;
                        let direction =
                            DVec3::new(angle.cos() * (1.0 - y * y).sqrt(), y, angle.sin() * (1.0 - y * y).sqrt());
                        let reach = hull.points.iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
                        assert!(
                            point.dot(direction) <= reach + 4.0 * hull.slack.dot(direction.abs()),
                            "{body:?}, face {face}, {direction}"
                        );
                    }
                }
            }
        }
        assert!(found > 100, "{body:?}: {found}");
    }
}

#[test]
fn areas_of_quadrics_hold_the_closed_forms() {
    let bodies = quadrics();
    // The slab's two planes, 1.5·√2 wide and 2 high; of its sides, two squares without two triangles each, and four strips.
    let planes = 2.0 * 2.0 * 1.5 * 2f64.sqrt();
    let sides = 2.0 * (4.0 - 1.5 * 1.5) + 4.0 * 2.0 * 1.0 * 0.5;
    for (body, truth) in [
        (bodies[0], 4.0 * PI),
        (bodies[1], 3.0 * PI),
        (bodies[2], 2.0 * PI * 0.5 * 2.0 + 2.0 * PI * 0.25),
        (bodies[5], planes + sides),
    ] {
        for (level, width) in [(5, 0.3), (7, 0.08)] {
            let sum = total_area(body, &Placement::IDENTITY, level);
            assert!(sum.lower() <= truth && truth <= sum.upper(), "{body:?}: {sum:?} holds {truth}");
            assert!(sum.error < width * truth, "{body:?} at level {level}: {sum:?}");
        }
    }
}
