//! Curved and convex bodies where they are thinnest, largest, smallest and farthest, and lights where no formula likes them.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use umbriel_geometry::{Analytic, LightSource};
use umbriel_io::sun_from_angles;
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::for_each_sample;

use super::{judge, lamp, sampled, sun};
use crate::oracle::{
    Oracle,
    fixtures::{analytic, at, convex, cuboid, elsewhere, mesh, object, quadric, rectangle, scene, sphere, with_sides},
};

fn floor(size: f64) -> Object {
    object("floor", rectangle(size, size), DAffine3::IDENTITY)
}

fn turn() -> DAffine3 {
    DAffine3::from_quat(DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize())
}

/// One of each curved body, upright, in a row over a floor; none larger than two.
fn zoo() -> Vec<Object> {
    let cone = Analytic::Cone { radius: 0.7, height: 1.1 };
    let bowl = Analytic::Paraboloid { radius: 0.6, height: 0.9 };
    let waist = Analytic::Hyperboloid { waist_radius: 0.3, end_radius: 0.55, height: 1.3 };
    let capsule = Analytic::Capsule { radius: 0.3, height: 0.7 };
    let egg = Analytic::Ellipsoid { radii: [0.3, 0.6, 0.45] };
    let saddle = quadric([1.0, 0.0, -1.0], -0.5, 0.0, [0.5, 0.5, 0.5]);
    let hull = convex(&[[-0.4, 0.0, -0.3], [0.5, 0.1, -0.4], [0.3, 0.0, 0.6], [-0.1, 0.9, 0.1], [0.2, 0.7, 0.4]]);
    vec![
        floor(8.0),
        object("cone", analytic(cone), at(-3.0, 0.55, 0.0)),
        object("bowl", analytic(bowl), at(-1.5, 1.0, 0.3) * turn()),
        object("waist", analytic(waist), at(0.0, 1.0, -0.4)),
        object("capsule", analytic(capsule), at(1.5, 1.2, 0.2) * turn()),
        object("egg", analytic(egg), at(3.0, 0.6, -0.2)),
        with_sides("saddle", saddle, at(0.3, 2.2, 0.4), Sides::Two),
        object("disk", analytic(Analytic::Disk { radius: 0.8 }), at(-0.7, 2.5, -1.0) * turn()),
        object("hull", hull, at(0.9, 0.0, 1.4)),
    ]
}

fn lights() -> [LightSource; 4] {
    [sun([0.5, -1.0, 0.25]), sun([1.0, -1e-9, 0.3]), lamp([0.3, 3.5, 0.5]), lamp([0.0, 1.0, -0.4])]
}

fn scaled(light: &LightSource, scale: f64, offset: DVec3) -> LightSource {
    if light.is_sun() { *light } else { lamp((light.xyz() * scale + offset).to_array()) }
}

#[test]
fn curved_bodies_at_all_scales() {
    for exponent in [-180, -90, 90, 180] {
        let scale = 2f64.powi(exponent);
        let whole = elsewhere(&zoo(), scale, DVec3::ZERO);
        for light in lights() {
            let judged = judge("zoo", &whole, scaled(&light, scale, DVec3::ZERO));
            assert!(judged.cells > 50, "2^{exponent}, {light:?}: {judged:?}");
        }
    }
}

#[test]
fn curved_bodies_far_away() {
    for distance in [1e6, 1e9, 8e12] {
        let offset = DVec3::new(1.0, -1.0 / 3.0, 0.7) * distance;
        let whole = elsewhere(&zoo(), 1.0 / 3.0, offset);
        for light in lights() {
            judge("far zoo", &whole, scaled(&light, 1.0 / 3.0, offset));
        }
    }
}

#[test]
fn thin_and_flat_curved_bodies() {
    for ratio in [1e-9, 1e9] {
        let [long, wide] = if ratio > 1.0 { [1.0, 1e-9] } else { [1e-9, 1.0] };
        for (number, body) in [
            Analytic::Cone { radius: wide, height: long },
            Analytic::Frustum { bottom_radius: wide, top_radius: 0.3 * wide, height: long },
            Analytic::Frustum { bottom_radius: 1e-9, top_radius: wide, height: long },
            Analytic::Capsule { radius: wide, height: long },
            Analytic::Paraboloid { radius: wide, height: long },
            Analytic::Hyperboloid { waist_radius: 0.5 * wide, end_radius: wide, height: long },
            Analytic::Hyperboloid { waist_radius: 1e-9, end_radius: 1.0, height: long },
            Analytic::Ellipsoid { radii: [wide, long, 1.0] },
            Analytic::Ellipsoid { radii: [wide, wide, long] },
        ]
        .into_iter()
        .enumerate()
        {
            let height = 2.0 * long.max(wide);
            let map = if number % 2 == 0 { at(0.0, height, 0.0) } else { at(0.1, height, 0.2) * turn() };
            let whole = scene(vec![floor(8.0), object("thin", analytic(body), map)]);
            for light in [
                sun([0.0, -1.0, 0.0]),
                lamp([0.0, height, 0.0]),
                lamp([0.0, height + 0.5 * long, 0.0]),
                lamp([0.3, 3.0 * height, 0.1]),
            ] {
                judge("thin", &whole, light);
            }
        }
    }
}

#[test]
fn leaning_tips_and_suns_along_their_sides() {
    let shear = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.25), DVec3::new(0.0, 0.0, 1.5)));
    let mirror = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
    let cones = quadric([1.0, -1.0, 1.0], 0.0, 0.0, [1.0, 1.0, 1.0]);
    let shapes = [
        analytic(Analytic::Cone { radius: 1.0, height: 2.0 }),
        cones,
        analytic(Analytic::Paraboloid { radius: 0.5, height: 2.0 }),
    ];
    for shape in shapes {
        for map in [at(0.0, 2.0, 0.0) * shear, at(0.0, 2.0, 0.0) * mirror, at(0.5, 2.0, 0.0) * turn()] {
            let tip = match shape.analytic() {
                Some(Analytic::Quadric { .. }) => DVec3::ZERO,
                _ => DVec3::Y,
            };
            let along = |x: f64, z: f64| map.transform_vector3(DVec3::new(x, -2.0, z));
            let tip = map.transform_point3(tip);
            let sides = if map.matrix3.determinant() < 0.0 { Sides::Two } else { Sides::Auto };
            let whole = scene(vec![floor(8.0), with_sides("tip", shape.clone(), map, sides)]);
            for light in [
                lamp(tip.to_array()),
                lamp([tip.x, tip.y.next_up(), tip.z]),
                lamp([tip.x, tip.y.next_down(), tip.z]),
                // A generatrix that goes on through the tip.
                lamp((tip - along(1.0, 0.0)).to_array()),
                sun(along(1.0, 0.0).to_array()),
            ] {
                judge("tip", &whole, light);
            }
        }
    }
}

#[test]
fn suns_at_the_horizon_over_curved_bodies() {
    let whole = scene(zoo());
    for elevation in [1e-9, 0.0, -1e-9, 90.0] {
        for azimuth in [0.0, 90.0, 230.0] {
            judge("horizon", &whole, sun(sun_from_angles(azimuth, elevation)));
        }
    }
}

#[test]
fn lamps_on_and_beside_curved_bodies_under_any_matrix() {
    let ball = |map: DAffine3| {
        scene(vec![
            floor(8.0),
            object("ball", sphere(0.75), map),
            object("egg", analytic(Analytic::Ellipsoid { radii: [0.5, 1.0, 0.25] }), at(2.0, 2.0, 1.0) * map),
        ])
    };
    for map in [at(0.0, 1.5, 0.0), at(0.1, 1.7, -0.3) * turn(), at(0.0, 1e6 + 0.1, 0.0)] {
        let whole = ball(map);
        for direction in [DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.8, 0.0), DVec3::new(0.3, -0.2, 0.7).normalize()] {
            for reach in [0.75, 0.75_f64.next_up(), 0.75 + 1e-15, 0.75 - 1e-15, 1e-15] {
                judge("on a ball", &whole, lamp(map.transform_point3(direction * reach).to_array()));
            }
        }
    }
}

#[test]
fn plates_an_ulp_thick_turned_and_hulled() {
    let ulp = f64::EPSILON;
    let corners: Vec<[f64; 3]> =
        (0..8).map(|k| [(k & 1) as f64, if k & 2 == 0 { 1.0 } else { 1.0 + ulp }, (k >> 2) as f64]).collect();
    let plates = [
        object("turned", cuboid(2.0, ulp, 2.0), at(0.0, 1.5, 0.0) * turn()),
        object("hull", convex(&corners), DAffine3::IDENTITY),
        object("cylinder", analytic(Analytic::Cylinder { radius: 1.0, height: ulp }), at(0.0, 1.5, 0.0) * turn()),
        object("ball", sphere(1.0), at(0.0, 1.5, 0.0) * DAffine3::from_scale(DVec3::new(1.0, ulp, 1.0))),
    ];
    for plate in plates {
        let whole = scene(vec![floor(8.0), plate]);
        for light in [
            sun([0.0, -1.0, 0.0]),
            sun([1.0, -1.0, 0.25]),
            sun([1.0, 0.0, 0.5]),
            lamp([0.25, 1.0, 0.5]),
            lamp([0.25, 1.0 + ulp, 0.5]),
            lamp([0.0, 1.5, 0.0]),
            lamp([0.5, 3.0, 0.5]),
        ] {
            judge("plate", &whole, light);
        }
    }
}

#[test]
fn turned_boxes_that_touch() {
    // Faces, edges and corners that would be shared but for rounding, and boxes in one place twice.
    let map = at(0.1, 1.7, -0.3) * turn();
    let beside = |x: f64, y: f64, z: f64| map * at(x, y, z);
    let whole = scene(vec![
        floor(8.0),
        object("a", cuboid(1.0, 1.0, 1.0), map),
        object("face", cuboid(1.0, 1.0, 1.0), beside(1.0, 0.0, 0.0)),
        object("edge", cuboid(1.0, 1.0, 1.0), beside(-1.0, 1.0, 0.0)),
        object("corner", cuboid(1.0, 1.0, 1.0), beside(1.0, 1.0, 1.0)),
        object("again", cuboid(1.0, 1.0, 1.0), map),
        object("inside", cuboid(0.5, 1.0, 0.5), map),
        object("drum", analytic(Analytic::Cylinder { radius: 0.5, height: 1.0 }), beside(0.0, 1.0, 0.0)),
    ]);
    let corner = map.transform_point3(DVec3::splat(0.5)).to_array();
    let edge = map.transform_point3(DVec3::new(0.5, 0.5, 0.0)).to_array();
    for light in [
        lamp(corner),
        lamp(edge),
        lamp(map.transform_point3(DVec3::new(0.5, 0.1, 0.2)).to_array()),
        sun(map.transform_vector3(DVec3::NEG_Y).to_array()),
        sun(map.transform_vector3(DVec3::new(1.0, -1.0, 0.0)).to_array()),
        lamp(map.translation.to_array()),
        lamp([0.0, 5.0, 0.0]),
    ] {
        judge("turned boxes", &whole, light);
    }
}

/// A lamp within rounding of a sample: half an ulp before the middle of a box's side, or beside that of a tilted square. In a lattice with
/// odd counts the middle is a sample.
#[test]
fn samples_within_rounding_of_a_lamp() {
    let ulp = f64::EPSILON;
    let side = 1.0 - ulp;
    let beside = object("box", cuboid(side, 1.0, 1.0), at(1.5, 0.5, 0.5));
    let boxes = scene(vec![floor(8.0), beside]);
    let square = object("square", rectangle(2.0, 2.0), at(0.1, 1.7, -0.3) * turn());
    let squares = scene(vec![floor(8.0), square]);
    let middle = DVec3::new(0.1, 1.7, -0.3);
    let mut lit = 0;
    for (whole, lamps) in [
        (&boxes, [DVec3::new(1.0, 0.5, 0.5), DVec3::new(1.0 - ulp, 0.5, 0.5), DVec3::new(1.0, 0.5 + ulp, 0.5)]),
        (&squares, [middle, middle + DVec3::Y * ulp, middle - DVec3::new(ulp, ulp, 0.0)]),
    ] {
        let oracle = Oracle::new(whole);
        for position in lamps {
            let light = lamp(position.to_array());
            for count in [40, 100, 1000] {
                let (whole, request, report) = sampled(whole, light, count);
                let mut next = [0_u64; 2];
                for_each_sample(&whole, &request, |sample| {
                    let index = next[sample.object];
                    next[sample.object] += 1;
                    let place = oracle.point(sample.object, sample.face, [sample.u, sample.v]).approximate();
                    if (DVec3::from_array(place) - position).length() > 16.0 * ulp {
                        return;
                    }
                    let answers = report.lights[0].objects[sample.object].answers.as_ref().expect("samples");
                    let truth = oracle.sample_is_lit(&sample, &light);
                    assert_eq!(answers.is_lit(index), truth, "{sample:?} under {light:?}");
                    lit += usize::from(truth);
                });
            }
        }
    }
    assert!(lit >= 3, "{lit}");
}

/// A closed fan: two cones of `blades` triangles each with a common rim.
fn spindle(blades: u32) -> Shape {
    let angle = |k: u32| f64::from(k) * (2.0 * std::f64::consts::PI / f64::from(blades));
    let accepted = |x: f64| if x.abs() < 1e-12 { 0.0 } else { x };
    let rim = (0..blades).map(|k| [angle(k).cos(), 0.0, angle(k).sin()]);
    let positions: Vec<[f64; 3]> = rim.chain([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]).map(|p| p.map(accepted)).collect();
    let blade = |k: u32| [[blades, (k + 1) % blades, k], [blades + 1, k, (k + 1) % blades]];
    mesh(&positions, &(0..blades).flat_map(blade).collect::<Vec<_>>())
}

fn spindles(blades: u32) -> Scene {
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 0.5, 1.0));
    scene(vec![
        floor(8.0),
        object("spindle", spindle(blades), at(0.0, 1.0, 0.0)),
        object("turned", spindle(blades), at(2.0, 2.0, 0.5) * turn()),
        object("mirrored", spindle(blades), at(-2.0, 2.0, 0.5) * mirror),
    ])
}

#[test]
fn lamps_round_the_hubs_of_closed_fans() {
    let whole = spindles(150);
    for light in [
        lamp([0.0, 2.0, 0.0]),
        lamp([0.0, 2.0_f64.next_down(), 0.0]),
        lamp([0.0, 1.0, 0.0]),
        lamp([1.0, 1.0, 0.0]),
        lamp([0.0, 0.0, 0.0]),
        sun([0.0, -1.0, 0.0]),
        sun([1.0, -1.0, 0.0]),
        sun([1.0, 0.0, 0.0]),
    ] {
        judge("fans", &whole, light);
    }
}
