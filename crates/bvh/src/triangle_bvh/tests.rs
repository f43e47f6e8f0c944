use proptest::prelude::*;
use umbriel_geometry::{
    Dyadic, ExactPoint, Point,
    blocking::{Probe, exact_polygon_blocks, polygon_blocks},
    simd::Level,
};

use super::{build::MAX_DEPTH, *};
use crate::arbitrary::{light, point, whole_light, whole_point};

fn bvh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> TriangleBvh {
    let positions = positions.iter().map(DVec3::to_array).collect();
    TriangleBvh::build(Arc::new(Mesh::new(positions, triangles).expect("a sound mesh")))
}

fn soup(corners: Vec<[DVec3; 3]>) -> TriangleBvh {
    let triangles = (0..corners.len() as u32).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
    bvh(corners.into_iter().flatten().collect(), triangles)
}

/// What the definition says, by exact arithmetic alone, of all triangles.
fn blocked(corners: &[[DVec3; 3]], origin: DVec3, light: &LightSource) -> bool {
    let (x, light) = (ExactPoint::<Dyadic>::from_position(origin), ExactPoint::from_light(light));
    corners.iter().any(|corners| exact_polygon_blocks(&corners.map(ExactPoint::from_position), &x, &light))
}

/// What the tree says, at every level.
fn any_hits(bvh: &TriangleBvh, origin: DVec3, light: LightSource) -> Vec<bool> {
    let way = Way::towards(&light, origin, 0.0);
    let decide = |triangle| {
        let corners = bvh.corners(triangle).map(Point::exact);
        polygon_blocks::<Dyadic>(&corners, &Probe::at(origin), &light)
    };
    let at = |level| {
        simd::dispatch_at(
            level,
            &mut AnyHit { parts: &bvh.parts, way: &way, first: None, stack: &mut [(0, 0); MAX_DEPTH], decide },
        )
        .is_some()
    };
    Level::ALL.into_iter().map(at).collect()
}

/// How a scene is put into the world: by a power of two and a shift that keep whole numbers exact, or by ones that do not.
#[derive(Clone, Copy, Debug)]
struct World {
    scale: f64,
    shift: DVec3,
}

impl World {
    fn place(&self, point: DVec3) -> DVec3 {
        point * self.scale + self.shift
    }

    fn light(&self, light: LightSource) -> LightSource {
        let placed = self.place(light.xyz()).to_array();
        if light.is_sun() { light } else { LightSource::point(placed).expect("in range") }
    }
}

fn a_world() -> impl Strategy<Value = World> {
    let scale = prop_oneof![Just(1.0), Just(1024.0), Just(0.5f64.powi(60)), Just(2f64.powi(100)), 0.1..10.0f64];
    let shift = prop_oneof![Just(0.0), Just(1000.0), Just(-1e6), -10.0..10.0f64];
    (scale, shift).prop_map(|(scale, shift)| World { scale, shift: DVec3::new(1.0, -0.5, 2.0) * shift * scale })
}

/// Points of triangles, of their edges and corners, and points anywhere, near and far.
fn an_origin(corners: &[[DVec3; 3]], pick: prop::sample::Index, weights: [u8; 3], loose: DVec3, far: f64) -> DVec3 {
    let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
    match corners {
        [] => loose,
        _ if sum == 0.0 => loose * far,
        _ => {
            let [a, b, c] = corners[pick.index(corners.len())];
            let [u, v, w] = weights.map(|w| f64::from(w) / sum);
            a * u + b * v + c * w
        }
    }
}

fn a_triangle() -> impl Strategy<Value = [DVec3; 3]> {
    (point(), proptest::array::uniform3(point())).prop_map(|(at, corners)| corners.map(|corner| at + corner * 0.25))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn any_hit_is_that_of_a_loop(
        corners in proptest::collection::vec(proptest::array::uniform3(whole_point()), 0..60),
        pick in any::<prop::sample::Index>(), weights in proptest::array::uniform3(0u8..3), loose in whole_point(),
        far in prop_oneof![Just(1.0), Just(100.0), Just(1e9)], light in whole_light(), world in a_world(),
    ) {
        let origin = world.place(an_origin(&corners, pick, weights, loose, far));
        let (corners, light) = (placed(&corners, &world), world.light(light));
        let bvh = soup(corners.clone());
        let fast = TriangleBvh::build_with(Arc::clone(&bvh.mesh), BuildQuality::Fast);
        let expected = blocked(&corners, origin, &light);
        for bvh in [&bvh, &fast] {
            prop_assert_eq!(bvh.check(), Ok(()));
            prop_assert_eq!(any_hits(bvh, origin, light), [expected; 3]);
        }
        prop_assert_eq!(bvh.any_hit(&Segment::new(origin, light)), expected);
    }

    #[test]
    fn a_segment_through_an_edge_or_corner_is_blocked_exactly(
        corners in proptest::collection::vec(a_triangle(), 1..60), pick in any::<prop::sample::Index>(),
        weights in proptest::array::uniform3(0u8..3), beyond in 0.25..4.0f64, light in light(), world in a_world(),
        ulps in -2i32..=2,
    ) {
        // From the light through a point of a triangle, corners and edges included, and a few ulps beside.
        let target = an_origin(&corners, pick, weights, DVec3::ZERO, 1.0);
        let away = if light.is_sun() { -light.xyz() } else { target - light.xyz() };
        let origin = world.place(target + away * beyond);
        let origin = DVec3::new(stepped(origin.x, ulps), origin.y, origin.z);
        let (corners, light) = (placed(&corners, &world), world.light(light));
        let bvh = soup(corners.clone());
        let expected = blocked(&corners, origin, &light);
        prop_assert_eq!(any_hits(&bvh, origin, light), [expected; 3]);
        // The answer does not depend on what was asked before.
        let mut towards = bvh.towards(light);
        for other in [origin, target, origin] {
            prop_assert_eq!(towards.any_hit(other), blocked(&corners, other, &light));
        }
    }

    #[test]
    fn many_segments_are_answered_as_single_ones(
        corners in proptest::collection::vec(a_triangle(), 0..60), light in light(), world in a_world(),
        picks in proptest::collection::vec((any::<prop::sample::Index>(), proptest::array::uniform3(0u8..3)), 0..50),
        loose in point(), thickness in prop_oneof![Just(0.0), Just(1e-9), Just(0.01), Just(0.3)],
        far in prop_oneof![9 => Just(1.0), 1 => Just(1e4)],
    ) {
        // Behind points of triangles as the light sees them, and on them.
        let behind = |(n, &(pick, weights)): (usize, &(prop::sample::Index, [u8; 3]))| {
            let target = an_origin(&corners, pick, weights, loose, far);
            let away = if light.is_sun() { -light.xyz() } else { target - light.xyz() };
            world.place(target + away * (thickness * (n % 3) as f64))
        };
        let origins: Vec<DVec3> = picks.iter().enumerate().map(behind).collect();
        let (corners, light) = (placed(&corners, &world), world.light(light));
        let bvh = soup(corners.clone());
        let expected: Vec<bool> = origins.iter().map(|&origin| blocked(&corners, origin, &light)).collect();
        for level in Level::ALL {
            for order in [vec![], morton_order(&origins)] {
                let mut found = vec![false; origins.len()];
                let segments = Segments { bvh: &bvh, light };
                simd::dispatch_at(level, AnyHits { segments, origins: &origins, order: &order, blocked: &mut found });
                prop_assert_eq!(&found, &expected, "{:?}", level);
            }
        }
    }

    #[test]
    fn the_order_of_points_is_a_permutation(points in proptest::collection::vec(point(), 0..300)) {
        let mut order = morton_order(&points);
        order.sort_unstable();
        prop_assert!(order.into_iter().eq(0..points.len() as u32));
    }

    #[test]
    fn a_point_known_roughly_leaves_only_doubts_to_the_caller(
        corners in proptest::collection::vec(a_triangle(), 0..40), origin in point(), light in light(),
        slack in prop_oneof![Just(1e-12), Just(1e-6), Just(1e-3), Just(0.1), Just(100.0), Just(1e30)],
        away in prop_oneof![3 => Just(1.0), 3 => Just(4.0), 1 => Just(1e3), 1 => Just(1e40)],
        offset in proptest::array::uniform3(-1.0..=1.0f64),
    ) {
        let bvh = soup(corners.clone());
        let origin = origin * away;
        let truth = origin + DVec3::from_array(offset) * slack * 0.999;
        let found = bvh.towards(light).any_hit_where(origin, slack, |triangle| {
            blocked(&[bvh.corners(triangle)], truth, &light)
        });
        prop_assert_eq!(found, blocked(&corners, truth, &light));
    }

    #[test]
    fn nearest_hit_is_that_of_a_loop(
        corners in proptest::collection::vec(a_triangle(), 0..150),
        copies in 0usize..5, origin in point(), direction in point(), t_max in prop_oneof![Just(f64::INFINITY), 0.0..3.0f64],
    ) {
        // Coincident triangles: the lower one wins.
        let corners: Vec<_> = corners.iter().chain(&corners[..copies.min(corners.len())]).copied().collect();
        let single = |(index, &corners): (usize, &[DVec3; 3])| {
            soup(vec![corners]).nearest_hit(origin, direction, t_max).map(|hit| Hit { triangle: index as u32, ..hit })
        };
        let nearer = |a: Hit, b: Hit| if b.t < a.t { b } else { a };
        let expected = corners.iter().enumerate().filter_map(single).reduce(nearer);
        prop_assert_eq!(soup(corners).nearest_hit(origin, direction, t_max), expected);
    }

    #[test]
    fn rays_in_bundles_hit_what_they_hit_alone(
        corners in proptest::collection::vec(a_triangle(), 0..400), eye in point(), towards in point(),
        origins in bundle_of(point()), directions in bundle_of(point()), ends in bundle_of(prop_oneof![Just(f64::INFINITY), 0.0..3.0f64]),
        spreads in [prop_oneof![Just(0.0), Just(1e-3), Just(0.1), Just(10.0)], prop_oneof![Just(0.0), Just(1e-3), Just(0.1), Just(10.0)]],
        away in prop_oneof![Just(1.0), Just(30.0), Just(1e4)], scale in prop_oneof![Just(1.0), Just(2f64.powi(-90)), Just(1e50)],
    ) {
        // From one point, side by side, or in any direction; from among the triangles, from outside, from far away.
        let bvh = soup(corners.iter().map(|corners| corners.map(|corner| corner * scale)).collect());
        let rays = origins.iter().zip(&directions).map(|(origin, direction)| {
            Ray::new((eye * away + *origin * spreads[0]) * scale, towards - eye * (away - 1.0) + *direction * spreads[1])
        });
        let rays: Vec<(Ray, f64)> = rays.zip(ends).map(|(ray, end)| (ray, end * scale * away)).collect();
        let alone: Vec<_> = rays.iter().map(|(ray, end)| bvh.nearest_hit(ray.origin, ray.direction, *end)).collect();
        let hits = alone.iter().flatten().count() as u32;
        prop_assert_eq!(bvh.nearest_hits(&rays), &alone[..]);
        prop_assert_eq!(bvh.nearest_hits_steps(&rays).hits, hits);
        for level in Level::ALL {
            let mut searches = [const { None }; BUNDLE];
            if let Some(mut bundle) = Bundle::<false>::new(&bvh, &rays[..BUNDLE], &mut searches) {
                // Rays that go apart are given up among so many triangles.
                if !simd::dispatch_at(level, &mut bundle) {
                    continue;
                }
                let found: Vec<_> = searches.iter().map(|search| search.as_ref().and_then(|search| search.hit)).collect();
                prop_assert_eq!(&found, &alone[..BUNDLE], "{:?}", level);
            }
        }
    }

    #[test]
    fn a_hit_is_where_it_says(corners in a_triangle(), weights in [0.0..1.0f64, 0.0..1.0], origin in point()) {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let [u, v] = if weights[0] + weights[1] > 1.0 { weights.map(|w| 1.0 - w) } else { weights };
        let target = a + (b - a) * u + (c - a) * v;
        // Only rays that see the triangle well: the tolerance below is for those.
        let steepness = normal.normalize_or_zero().dot((target - origin).normalize_or_zero()).abs();
        prop_assume!(normal.length() > 1e-2 && steepness > 0.1 && (u > 0.01 && v > 0.01 && u + v < 0.99));
        let hit = soup(vec![corners]).nearest_hit(origin, target - origin, f64::INFINITY).expect("aimed at it");
        prop_assert!((hit.t - 1.0).abs() < 1e-9 && (hit.u - u).abs() < 1e-9 && (hit.v - v).abs() < 1e-9, "{hit:?}");
    }

    #[test]
    fn no_ray_leaves_a_closed_surface(
        heights in proptest::collection::vec(0.25..4.0f64, 26), inside in proptest::array::uniform3(-0.05..0.05f64),
        edge in any::<prop::sample::Index>(), along in 0.0..=1.0f64,
    ) {
        // The 26 lattice directions around a cube, each pushed out by another length, joined over the cube's faces.
        let (positions, triangles) = star(&heights);
        let origin = DVec3::from_array(inside) * 0.1;
        let corners = triangles[edge.index(triangles.len())].map(|index| positions[index as usize]);
        let target = corners[0] + (corners[1] - corners[0]) * along;
        let bvh = bvh(positions, triangles);
        prop_assert!(bvh.nearest_hit(origin, target - origin, f64::INFINITY).is_some());
    }
}

/// As many as one bundle and a bit.
fn bundle_of<T: std::fmt::Debug>(one: impl Strategy<Value = T>) -> impl Strategy<Value = Vec<T>> {
    proptest::collection::vec(one, BUNDLE + 3)
}

fn placed(corners: &[[DVec3; 3]], world: &World) -> Vec<[DVec3; 3]> {
    corners.iter().map(|corners| corners.map(|corner| world.place(corner))).collect()
}

fn stepped(value: f64, ulps: i32) -> f64 {
    let step = |value: f64, _| if ulps < 0 { value.next_down() } else { value.next_up() };
    (0..ulps.abs()).fold(value, step)
}

/// A closed surface around the origin with 26 corners and 48 triangles.
fn star(heights: &[f64]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let lattice: Vec<DVec3> = (0..27)
        .filter(|&n| n != 13)
        .map(|n| DVec3::new(f64::from(n % 3 - 1), f64::from(n / 3 % 3 - 1), f64::from(n / 9 - 1)))
        .collect();
    let index = |p: DVec3| lattice.iter().position(|&q| q == p).expect("on the lattice") as u32;
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let at = |i: f64, j: f64| {
                let mut p = DVec3::ZERO;
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, i, j);
                index(p)
            };
            for (i, j) in [(-1.0, -1.0), (-1.0, 0.0), (0.0, -1.0), (0.0, 0.0)] {
                let [a, b, c, d] = [at(i, j), at(i + 1.0, j), at(i + 1.0, j + 1.0), at(i, j + 1.0)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    let positions = lattice.iter().zip(heights).map(|(p, height)| p.normalize() * *height).collect();
    (positions, triangles)
}

#[test]
fn corners_of_no_triangle_do_not_count() {
    let far = [[1e30, 0.0, 0.0], [0.3, 0.1, 0.7]];
    let positions = [[0.25, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 0.5, 1.0]];
    let mesh = Mesh::new([&positions[..], &far].concat(), vec![[0, 1, 2]]).expect("a mesh");
    let bvh = TriangleBvh::build(Arc::new(mesh));
    assert_eq!(bvh.check(), Ok(()));
    assert!(bvh.parts.corner_error <= f32::EPSILON / 4.0, "{}", bvh.parts.corner_error);
}

#[test]
fn codes_are_sorted_by_their_low_bits_and_keep_their_order() {
    for (count, bits) in [(0u32, 30), (1, 30), (1000, 0), (1000, 5), (5000, 12), (5000, 21), (5000, 30)] {
        let mut pairs: Vec<(u32, u32)> = (0..count).map(|n| (n.wrapping_mul(2_654_435_761) >> 2, n)).collect();
        let mut expected = pairs.clone();
        expected.sort_by_key(|&(code, _)| code & ((1 << bits) - 1));
        morton::sort(&mut pairs, &mut vec![(0, 0); count as usize], bits);
        assert_eq!(pairs, expected, "{count} by {bits} bits");
    }
}

#[test]
fn the_mesh_is_shared() {
    let mesh = Arc::new(Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).expect("a mesh"));
    let trees = [TriangleBvh::build(Arc::clone(&mesh)), TriangleBvh::build(Arc::clone(&mesh))];
    assert_eq!(Arc::strong_count(&mesh), 1 + trees.len());
}

#[test]
fn a_ray_without_direction_hits_nothing() {
    let bvh = soup(vec![[DVec3::X, DVec3::Y, DVec3::Z]]);
    assert_eq!(bvh.nearest_hit(DVec3::ZERO, DVec3::ZERO, f64::INFINITY), None);
    assert_eq!(bvh.nearest_hit(DVec3::ZERO, DVec3::ONE, 0.3), None, "the triangle is at 1/3");
    let rays = [DVec3::ZERO, DVec3::ONE, DVec3::ONE].map(|direction| Ray::new(DVec3::ZERO, direction));
    let hits = bvh.nearest_hits(&[(rays[0], 1.0), (rays[1], 1.0), (rays[2], 0.3)]);
    assert_eq!(
        hits.iter().map(Option::is_some).collect::<Vec<_>>(),
        [false, true, false],
        "one without direction takes none with it"
    );
    assert!(bvh.nearest_hits(&[]).is_empty());
    assert!(!bvh.is_empty() && bvh.len() == 1);
    assert!(!bvh.any_hit(&Segment::new(DVec3::ONE, LightSource::point([1.0; 3]).expect("a lamp"))), "at the lamp");
}

#[test]
fn trees_of_all_sizes_are_sound() {
    for count in [0, 1, 7, 8, 9, 63, 64, 65, 1000, 20_000] {
        // Spread out, in one line, and all in one place.
        for spread in [DVec3::new(1.0, 0.7, 0.3), DVec3::X, DVec3::ZERO] {
            let at = |n: u32| spread * f64::from(n.wrapping_mul(2_654_435_761) >> 8) * 1e-5;
            let corners = (0..count).map(|n| [at(n), at(n) + DVec3::X, at(n) + DVec3::Y]).collect();
            let good = soup(corners);
            let fast = TriangleBvh::build_with(Arc::clone(&good.mesh), BuildQuality::Fast);
            assert_eq!((good.check(), fast.check()), (Ok(()), Ok(())), "{count} along {spread}");
        }
    }
}

#[test]
fn packets_over_a_fine_surface_agree_with_single_segments() {
    // A bumpy sheet, fine enough for deep trees, and points on it in rows.
    let height = |i: u32, j: u32| 0.03 * f64::from((i * i + 3 * j) % 17) + 0.02 * f64::from((i + j * j) % 11);
    let side = 120;
    let positions =
        (0..side * side).map(|n| DVec3::new(f64::from(n % side), height(n % side, n / side), f64::from(n / side)));
    let quads = (0..side * side).filter(|n| n % side + 1 < side && n / side + 1 < side);
    let triangles = quads.flat_map(|n| [[n, n + side, n + 1], [n + 1, n + side, n + side + 1]]).collect();
    let good = bvh(positions.collect(), triangles);
    let bvh = TriangleBvh::build_with(Arc::clone(&good.mesh), BuildQuality::Fast);
    assert_eq!((good.check(), bvh.check()), (Ok(()), Ok(())));
    let point = |n: u32| {
        let [a, b, c] = bvh.corners(n % bvh.len() as u32);
        a * 0.25 + b * 0.25 + c * 0.5
    };
    for light in [LightSource::sun([0.9, -0.4, 0.3]), LightSource::point([60.0, 9.0, 61.0])] {
        let light = light.expect("in range");
        let origins: Vec<DVec3> = (0..5000).map(point).chain((0..5000).map(|n| point(n * 7919))).collect();
        let single: Vec<bool> = origins.iter().map(|&origin| bvh.any_hit(&Segment::new(origin, light))).collect();
        assert_eq!(bvh.towards(light).any_hits(&origins), single);
        assert_eq!(good.towards(light).any_hits(&origins), single);
        assert_eq!(bvh.towards(light).any_hits_unordered(&origins), single);
        let (hits, all) = (single.iter().filter(|&&hit| hit).count(), single.len());
        assert!(hits > all / 10 && hits < all * 9 / 10, "{hits} of {all}");
    }
}

#[test]
fn a_ray_that_leaves_along_a_face_does_not_meet_it_where_it_begins() {
    // From a corner of a wall, away from the wall but in its plane up to rounding: the other half has no weights to speak of.
    let (origin, along) =
        (DVec3::new(240.0, 0.0, 272.0), DVec3::new(84.4263183701209, 130.77806391038533, 25.11415799617521));
    let wall = [[82.0, 0.0, 225.0], [240.0, 165.0, 272.0], [82.0, 165.0, 225.0]].map(DVec3::from_array);
    for turn in 0..3 {
        let corners = [0, 1, 2].map(|k| wall[(k + turn) % 3]);
        assert_eq!(soup(vec![corners]).nearest_hit(origin, along, f64::INFINITY), None);
    }
}

/// The true point is nearer to the tree than the one that stands for it: what lies between is not passed over.
#[test]
fn a_rough_point_outside_stops_before_all_that_the_true_one_meets() {
    let corner = |x: f64, y: f64| DVec3::new(x, y, 0.3);
    let [a, b, c, d] = [corner(-0.5, -0.99), corner(0.5, -0.99), corner(0.5, 0.99), corner(-0.5, 0.99)];
    let (bvh, sun) = (soup(vec![[a, b, c], [a, c, d]]), LightSource::sun([0.0, 0.25, 1.0]).expect("a sun"));
    let mut is_asked = false;
    bvh.towards(sun).any_hit_where(DVec3::new(0.0, 2.0, 4.0), 0.1, |_| {
        is_asked = true;
        false
    });
    assert!(is_asked);
}
