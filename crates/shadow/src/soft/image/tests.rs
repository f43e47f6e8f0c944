use std::{f64::consts::FRAC_PI_4, sync::Arc};

use glam::{DAffine3, DVec2, DVec3};
use umbriel_geometry::{
    Analytic, Cuboid, Facets, LightSource, Mesh, Placement, Rectangle,
    simd::{Level, dispatch_at},
};
use umbriel_scene::{Extent, Light, Object, PartBox, Shape, Sides};
use umbriel_visibility::depth_map::{CurvedBodies, DepthMap, LightSpace};

use super::{
    receiver::{CountNearer, Receiver},
    *,
};

const MAP: usize = 512;

fn plate(edge: f64, height: f64) -> Facets {
    let placement = Placement::new(DAffine3::from_translation(DVec3::Y * height)).expect("regular");
    Facets::of_rectangle(&Rectangle { size: [edge; 2] }, &placement)
}

fn corners_of(facets: &[Facets]) -> Vec<DVec3> {
    facets.iter().flat_map(|facets| facets.positions().to_vec()).collect()
}

/// A light at the height 10 over a floor and a plate at the height 5.
fn shader(width: f64) -> SoftShader {
    let faces = [plate(20.0, 0.0), plate(4.0, 5.0)];
    let space = LightSpace::round(DVec3::Y * 10.0, DVec3::NEG_Y, corners_of(&faces), MAP);
    let mut shader = SoftShader::new(DepthMap::new(space, &faces, &CurvedBodies::default()), width);
    shader.prepare_average_depth(10.0);
    shader
}

fn upward(position: DVec3) -> Option<SurfacePoint> {
    Some(SurfacePoint { position, normal: DVec3::Y })
}

fn on_floor(x: f64) -> Option<SurfacePoint> {
    upward(DVec3::new(x, 0.0, 0.0))
}

fn box_between(low: DVec3, high: DVec3, map: &DAffine3) -> OrientedBox {
    OrientedBox { corners: PartBox::between(low, high).placed(map) }
}

fn outlines(space: &LightSpace, boxes: &[OrientedBox]) -> Vec<Outline> {
    visible_outlines(&boxes.iter().filter_map(|oriented| Outline::of(space, oriented)).collect::<Vec<_>>())
}

fn object(shape: Shape, map: DAffine3) -> Object {
    Object::new("body".into(), shape, Placement::new(map).expect("regular"), Sides::Auto).expect("a body")
}

fn blocker(shader: &SoftShader) -> Blocker {
    let oriented = box_between(DVec3::new(-2.0, 4.9, -2.0), DVec3::new(2.0, 5.0, 2.0), &DAffine3::IDENTITY);
    Blocker::of(&outlines(&shader.map().space, &[oriented])).expect("a blocker")
}

#[test]
fn a_box_without_an_extent_blocks_nothing() {
    let space = shader(2.0).map().space;
    let flat = |size: DVec3| box_between(DVec3::Y, DVec3::Y + size, &DAffine3::IDENTITY);
    // A point and a line have no face turned to the light; a rectangle has one.
    assert!([DVec3::ZERO, DVec3::X].iter().all(|&size| Outline::of(&space, &flat(size)).is_none()));
    assert!(Outline::of(&space, &flat(DVec3::new(1.0, 0.0, 1.0))).is_some());
    assert_eq!(Blocker::of(&[]), None);
}

#[test]
fn all_kernels_give_the_penumbra_of_a_straight_edge() {
    // The plate's edge at x = 2 throws a penumbra of the light's width, as it stands half way: from x = 4 − w/2 to 4 + w/2.
    let width = 2.0;
    let shader = shader(width);
    let farthest = 10.0;
    let boxes = |kernel| SoftMethod::Boxes { kernel, quality: 1.0, blockers: vec![blocker(&shader)], farthest };
    let methods = [SoftMethod::Pcss, SoftMethod::AverageDepth, boxes(BoxKernel::Fixed), boxes(BoxKernel::OwnDistance)];
    for (method, tolerance) in methods.into_iter().zip([0.03, 0.2, 0.05, 0.05]) {
        for k in 0..=24 {
            let x = 2.0 + 0.15 * f64::from(k);
            let truth = ((x - 3.0) / 2.0).clamp(0.0, 1.0);
            let shade = f64::from(shader.shade(&[on_floor(x)], &method)[0]);
            assert!((shade - truth).abs() <= tolerance, "{method:?} at {x}: {shade} is not {truth}");
        }
    }
}

#[test]
fn the_plate_does_not_shadow_itself() {
    let shader = shader(1.0);
    let point = upward(DVec3::new(0.3, 5.0, 0.2));
    for method in [SoftMethod::Pcf { radius: 0.01 }, SoftMethod::Pcss, SoftMethod::AverageDepth] {
        assert_eq!(shader.shade(&[point], &method), [1.0], "{method:?}");
    }
    assert_eq!(shader.shade(&[None], &SoftMethod::Pcss), [1.0]);
}

#[test]
fn a_box_seen_from_above_has_four_corners_and_askew_six() {
    let space = LightSpace::round(DVec3::Y * 10.0, DVec3::NEG_Y, [], 64);
    let size = DVec3::splat(0.5);
    let at = |place: DVec3| box_between(place - size, place + size, &DAffine3::IDENTITY);
    assert_eq!(outlines(&space, &[at(DVec3::ZERO)])[0].corners.len(), 4);
    assert_eq!(outlines(&space, &[at(DVec3::new(5.0, 0.0, 4.0))])[0].corners.len(), 6);
    // A small box behind a large one vanishes; before it, it stays.
    let large = box_between(DVec3::new(-2.0, 4.0, -2.0), DVec3::new(2.0, 5.0, 2.0), &DAffine3::IDENTITY);
    assert_eq!(outlines(&space, &[at(DVec3::ZERO), large]).len(), 1);
    assert_eq!(outlines(&space, &[at(DVec3::Y * 7.0), large]).len(), 2);
}

#[test]
fn boxes_follow_their_placement() {
    let turned = DAffine3::from_rotation_y(FRAC_PI_4);
    let oriented = box_between(DVec3::NEG_ONE, DVec3::ONE, &turned);
    let reach = oriented.corners.iter().map(|corner| corner.x).fold(0.0, f64::max);
    assert!((reach - 2f64.sqrt()).abs() < 1e-12);
    assert_eq!(Cuboid { size: [2.0; 3] }.corners().len(), 8);
}

/// A floor that is tilted against a lamp, and what all methods make of a point of it, with and without its normal.
#[test]
fn a_tilted_floor_does_not_darken_itself() {
    let placement = Placement::new(DAffine3::from_rotation_x(1.1)).expect("regular");
    let aside = Placement::new(DAffine3::from_translation(DVec3::new(2.0, 5.0, 0.0))).expect("regular");
    let faces = [(8.0, &placement), (0.2, &aside)]
        .map(|(edge, placement)| Facets::of_rectangle(&Rectangle { size: [edge; 2] }, placement));
    let lamp = LightSpace::round(DVec3::Y * 10.0, DVec3::NEG_Y, corners_of(&faces), MAP);
    let sun = LightSpace::parallel(DVec3::NEG_Y, corners_of(&faces), MAP);
    let along = placement.map().matrix3 * DVec3::Z;
    for space in [lamp, sun] {
        let mut shader = SoftShader::new(DepthMap::new(space, &faces, &CurvedBodies::default()), 0.2);
        shader.prepare_average_depth(16.0);
        let tilted = |normal| Some(SurfacePoint { position: along * 2.0, normal });
        let blocker = Blocker::of(&outlines(
            &space,
            &[box_between(DVec3::new(-3.0, 8.9, -3.0), DVec3::new(3.0, 9.0, 3.0), &DAffine3::IDENTITY)],
        ));
        let blockers = vec![blocker.expect("a blocker")];
        let boxes = |kernel| SoftMethod::Boxes { kernel, quality: 1.0, blockers: blockers.clone(), farthest: 16.0 };
        let wide = SoftMethod::Pcf { radius: 20.0 * space.texel() };
        for method in [wide, boxes(BoxKernel::Fixed), boxes(BoxKernel::OwnDistance)] {
            let shade = |normal| shader.shade(&[tilted(normal)], &method)[0];
            assert_eq!(shade(placement.map().matrix3 * DVec3::Y), 1.0, "{method:?}");
            assert!(shade(DVec3::ZERO) < 0.9, "{method:?}: without its plane it would");
        }
        for method in [SoftMethod::Pcss, SoftMethod::AverageDepth] {
            assert_eq!(shader.shade(&[tilted(placement.map().matrix3 * DVec3::Y)], &method), [1.0], "{method:?}");
        }
    }
}

#[test]
fn a_sun_throws_penumbrae_of_its_diameter() {
    // The plate's edge at x = 2, five metres over the floor.
    let faces = [plate(20.0, 0.0), plate(4.0, 5.0)];
    let source = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    let light = Light::with_extent("sun", source, Extent::Disk { angular_diameter: 20.0 }).expect("a light");
    let (space, width) = light_space(&light, &corners_of(&faces), MAP).expect("an extent");
    assert!((width - 2.0 * 10f64.to_radians().tan()).abs() < 1e-15);
    let mut shader = SoftShader::new(DepthMap::new(space, &faces, &CurvedBodies::default()), width);
    shader.prepare_average_depth(10.0);
    let far = space.to_light(DVec3::ZERO).z;
    let boxes = |kernel| SoftMethod::Boxes { kernel, quality: 1.0, blockers: vec![blocker(&shader)], farthest: far };
    let methods = [SoftMethod::Pcss, SoftMethod::AverageDepth, boxes(BoxKernel::Fixed), boxes(BoxKernel::OwnDistance)];
    for (method, tolerance) in methods.into_iter().zip([0.03, 0.2, 0.05, 0.05]) {
        for k in 0..=24 {
            let x = 0.5 + 0.125 * f64::from(k);
            let truth = (0.5 + (x - 2.0) / (5.0 * width)).clamp(0.0, 1.0);
            let shade = f64::from(shader.shade(&[on_floor(x)], &method)[0]);
            assert!((shade - truth).abs() <= tolerance, "{method:?} at {x}: {shade} is not {truth}");
        }
    }
}

#[test]
fn what_has_something_behind_it_blocks() {
    let map = |height| DAffine3::from_translation(DVec3::Y * height);
    let rectangle = |size| Shape::Rectangle(Rectangle { size: [size; 2] });
    let slab = Shape::Cuboid(Cuboid { size: [20.0, 1.0, 20.0] });
    let ball = Shape::from(Analytic::Sphere { radius: 0.5 });
    let space = LightSpace::round(DVec3::new(1.0, 10.0, 2.0), DVec3::NEG_Y, [], MAP);
    let hide = |objects: &[Object]| {
        let trees: Vec<BoxTree> = objects.iter().map(BoxTree::of).collect();
        hide_others(&space, objects, &trees)
    };
    // A sheet over a floor; a ball that stands on a slab; a slab alone.
    assert_eq!(hide(&[object(rectangle(20.0), map(0.0)), object(rectangle(2.0), map(3.0))]), [false, true]);
    assert_eq!(hide(&[object(slab.clone(), map(-0.5)), object(ball, map(0.5))]), [false, true]);
    assert_eq!(hide(&[object(slab, map(0.0))]), [false]);
    // Two squares side by side in the plane of one box, and one of them lifted.
    let squares = |height: f64| {
        let square = |x: f64, y: f64| [[x, y, 0.0], [x + 1.0, y, 0.0], [x + 1.0, y, 1.0], [x, y, 1.0]];
        let positions = [square(0.0, 0.0), square(2.0, height)].concat();
        let triangles = vec![[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]];
        object(Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh"))), map(0.0))
    };
    assert!(!may_hide_itself(&squares(0.0)));
    let lifted = |height: f64| may_hide_itself(&squares(height));
    assert!(!lifted(1.0), "both still lie in faces of the box");
}

#[test]
fn parts_of_boxes_hold_what_their_boxes_hold() {
    // A staircase of small triangles.
    let corners = (0..64).flat_map(|k| {
        let at = f64::from(k) * 0.25;
        [[at, at, 0.0], [at + 0.2, at, 0.1], [at, at + 0.2, 0.3]]
    });
    let triangles = (0..64).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let mesh = Mesh::new(corners.collect(), triangles).expect("a mesh");
    let positions = mesh.positions().to_vec();
    let body = object(Shape::Mesh(Arc::new(mesh)), DAffine3::from_rotation_z(0.3));
    assert!(may_hide_itself(&body));
    let given = [(4.0, 4.3), (12.0, 4.5)].map(|(middle, half)| PartBox {
        center: DVec3::new(middle, middle, 0.15),
        half: [DVec3::new(half, half, 0.0), DVec3::new(-1.0, 1.0, 0.0), DVec3::Z],
    });
    let boxed = body.clone().with_boxes(given.to_vec()).expect("boxes that hold it");
    assert!(body.clone().with_boxes(vec![given[0]]).is_err(), "half of it is outside");
    let space = LightSpace::round(DVec3::new(0.0, 40.0, 0.0), DVec3::NEG_Y, [], 64);
    for (object, roots) in [(&body, 1), (&boxed, 2)] {
        let tree = BoxTree::of(object);
        let map = object.placement.map();
        assert_eq!(tree.cut(map, &space, |_| true).outlines.len(), roots);
        let coarse = tree.cut(map, &space, |[near, far]| far - near < 6.0).outlines;
        let fine = tree.cut(map, &space, |[near, far]| far - near < 1.0).outlines;
        assert!(fine.len() > coarse.len() && coarse.len() > roots, "{} {}", coarse.len(), fine.len());
        assert!(fine.iter().all(|outline| outline.depths()[1] - outline.depths()[0] < 1.0));
        // No vertex is lost.
        for outlines in [&coarse, &fine] {
            for &point in &positions {
                let seen = space.to_light(map.transform_point3(point));
                let held = outlines.iter().any(|outline| {
                    let [near, far] = outline.depths();
                    seen.z >= near - 1e-9 && seen.z <= far + 1e-9
                });
                assert!(held, "{point}");
            }
        }
    }
}

#[test]
fn all_levels_of_instructions_count_alike() {
    let shader = shader(1.0);
    let (map, space) = (shader.map(), &shader.map().space);
    let mut hidden = 0;
    for (x, radius) in [(3.9, 3.0), (4.1, 40.0), (-3.8, 17.3), (0.0, 0.4)] {
        let point = SurfacePoint { position: DVec3::X * x, normal: DVec3::new(0.1, 1.0, -0.2) };
        let receiver = Receiver::new(space, &point).expect("before the light");
        let window = map.window(receiver.place, radius).expect("on the map");
        let limit = receiver.limit(space, &window);
        let count = |level| dispatch_at(level, CountNearer::<true> { map, window: &window, limit });
        let plain = count(Level::Scalar);
        Level::ALL.into_iter().for_each(|level| assert_eq!(count(level), plain, "{level:?}"));
        hidden += plain.count;
    }
    assert!(hidden > 0);
}

/// Nine boxes side by side, seen askew: each of the middle one's corners is hidden by some neighbour, but together they cover it and none does alone.
#[test]
fn boxes_that_hide_each_others_corners_leave_no_hole() {
    let size = DVec3::new(0.55, 1.0, 0.55);
    let at = |x: i32, z: i32| DVec3::new(f64::from(x), 3.0 + 0.25 * f64::from((x + 2 * z).rem_euclid(4)), f64::from(z));
    let places: Vec<DVec3> = (-2..=2).flat_map(|x| (-2..=2).map(move |z| at(x, z))).collect();
    let boxes = places.iter().map(|&place| box_between(place - size, place + size, &DAffine3::IDENTITY));
    let space = LightSpace::round(DVec3::new(2.0, 10.0, 1.0), DVec3::NEG_Y, [], 64);
    let whole: Vec<Outline> = boxes.filter_map(|oriented| Outline::of(&space, &oriented)).collect();
    let rectangles = |outlines: &[Outline]| -> Vec<[DVec2; 2]> {
        let blockers = outlines.iter().filter_map(|outline| Blocker::of(std::slice::from_ref(outline)));
        blockers.map(|blocker| blocker.rectangle(&space, 0.0, 0.0)).collect()
    };
    let holds = |rectangles: &[[DVec2; 2]], place: DVec2| {
        rectangles.iter().any(|[low, high]| place.cmpge(*low).all() && place.cmple(*high).all())
    };
    let (all, covering, visible) =
        (rectangles(&whole), rectangles(&covering_outlines(&whole)), rectangles(&visible_outlines(&whole)));
    let mut holes = 0;
    for k in 0..10_000 {
        let place = DVec2::new(f64::from(k % 100), f64::from(k / 100)) / 50.0 - DVec2::ONE;
        assert!(!whole.iter().any(|outline| outline.covers(place)) || holds(&covering, place), "{place}");
        holes += usize::from(holds(&all, place) && !holds(&visible, place));
    }
    assert!(holes > 0, "corners alone would leave holes: {} of {}", visible.len(), all.len());
}
