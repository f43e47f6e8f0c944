//! Small scenes for the judges: whole numbers and short fractions, so that contacts and grazes are exact.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use umbriel_geometry::{Analytic, Convex, Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};

use super::{dice::Dice, solids::Solid};

/// A placed object with the sides of its kind.
pub(crate) fn object(name: &str, shape: Shape, map: DAffine3) -> Object {
    with_sides(name, shape, map, Sides::Auto)
}

/// A placed object.
pub(crate) fn with_sides(name: &str, shape: Shape, map: DAffine3, sides: Sides) -> Object {
    let placement = Placement::new(map).expect("a regular matrix");
    Object::new(name.into(), shape, placement, sides).expect("an accepted object")
}

/// A translation.
pub(crate) fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

/// A rectangle in the xz plane.
pub(crate) fn rectangle(x: f64, z: f64) -> Shape {
    Shape::Rectangle(Rectangle { size: [x, z] })
}

/// A box.
pub(crate) fn cuboid(x: f64, y: f64, z: f64) -> Shape {
    Shape::Cuboid(Cuboid { size: [x, y, z] })
}

/// A curved body.
pub(crate) fn analytic(body: Analytic) -> Shape {
    Shape::from(body)
}

/// A sphere.
pub(crate) fn sphere(radius: f64) -> Shape {
    analytic(Analytic::Sphere { radius })
}

/// A mesh of these triangles.
pub(crate) fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Shape {
    Shape::Mesh(Arc::new(Mesh::new(positions.to_vec(), triangles.to_vec()).expect("an accepted mesh")))
}

/// The hull of these points.
pub(crate) fn convex(points: &[[f64; 3]]) -> Shape {
    Shape::Convex(Arc::new(Convex::new(points.to_vec()).expect("points that span space")))
}

/// Whether not all parameters of its faces are points of it.
pub(crate) fn has_gaps(shape: &Shape) -> bool {
    matches!(shape.analytic(), Some(Analytic::Quadric { .. }))
}

/// Whether the faces are triangles, whose points have u + v ≤ 1.
pub(crate) fn has_triangles(shape: &Shape) -> bool {
    matches!(shape, Shape::Mesh(_) | Shape::Convex(_))
}

/// A scene of these objects without lights.
pub(crate) fn scene(objects: Vec<Object>) -> Scene {
    Scene { objects: objects.into(), ..Scene::default() }
}

/// The scene under one light.
pub(crate) fn lit_by(mut scene: Scene, source: LightSource) -> Scene {
    scene.lights = vec![Light::new("light", source)];
    scene
}

/// A closed L-shaped prism, two units high, wound outward: concave.
pub(crate) fn l_prism() -> Shape {
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let at_height = |y: f64| outline.map(|[x, z]| [x, y, z]);
    let positions: Vec<[f64; 3]> = at_height(0.0).into_iter().chain(at_height(2.0)).collect();
    let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    // The outline runs clockwise seen from above: as it stands the bottom looks down.
    let bottoms = caps.iter().copied();
    let tops = caps.iter().map(|&[a, b, c]| [a + 6, c + 6, b + 6]);
    let walls = (0..6).flat_map(|i| {
        let j = (i + 1) % 6;
        [[i, i + 6, j + 6], [i, j + 6, j]]
    });
    let triangles: Vec<[u32; 3]> = bottoms.chain(tops).chain(walls).collect();
    mesh(&positions, &triangles)
}

/// A closed tetrahedron, wound outward.
pub(crate) fn tetrahedron() -> Shape {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    mesh(&positions, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
}

/// An open zigzag sheet with a hole, and a wall that stands on it and shares its vertices.
fn sheet_with_wall() -> Shape {
    let height = |i: u32, k: u32| if (i + k).is_multiple_of(2) { 0.0 } else { 0.5 };
    let mut positions: Vec<[f64; 3]> = Vec::new();
    for i in 0..4 {
        positions.extend((0..4).map(|k| [f64::from(i), height(i, k), f64::from(k)]));
    }
    let mut triangles = Vec::new();
    for (i, k) in (0..3).flat_map(|i| (0..3).map(move |k| (i, k))).filter(|&cell| cell != (1, 1)) {
        let corner = 4 * i + k;
        triangles.extend([[corner, corner + 1, corner + 5], [corner, corner + 5, corner + 4]]);
    }
    positions.extend([[0.0, 2.0, 0.0], [1.0, 2.0, 0.0]]);
    triangles.extend([[0, 4, 17], [0, 17, 16]]);
    mesh(&positions, &triangles)
}

/// Faces without area (a segment, a point), a face twice, and one turned round.
fn degenerate_mesh() -> Shape {
    let positions =
        [[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [3.0, 1.0, 0.0], [0.0, 2.0, 1.0], [0.0, 0.5, -1.0], [0.0, 0.5, -1.0]];
    mesh(&positions, &[[0, 1, 2], [3, 3, 3], [0, 1, 4], [0, 1, 5], [1, 0, 3], [3, 4, 3], [4, 0, 1]])
}

fn sheared() -> DAffine3 {
    let matrix = DMat3::from_cols(DVec3::new(1.0, 0.5, 0.0), DVec3::new(0.25, 1.0, 0.0), DVec3::new(0.0, -0.5, 1.5));
    DAffine3 { matrix3: matrix, translation: DVec3::new(-1.5, 1.0, -1.0) }
}

fn turned(x: f64, y: f64, z: f64) -> DAffine3 {
    let rotation = DQuat::from_xyzw(0.5, 0.1, -0.7, 0.5).normalize();
    DAffine3::from_rotation_translation(rotation, DVec3::new(x, y, z))
}

fn floor() -> Object {
    object("floor", rectangle(8.0, 8.0), DAffine3::IDENTITY)
}

/// The scene scaled by a power of two, then moved far away: no coordinate is short any more.
pub(crate) fn elsewhere(objects: &[Object], scale: f64, offset: DVec3) -> Scene {
    let map = DAffine3::from_translation(offset) * DAffine3::from_scale(DVec3::splat(scale));
    let moved =
        |object: &Object| with_sides(&object.name, object.shape.clone(), map * *object.placement.map(), object.sides);
    scene(objects.iter().map(moved).collect())
}

/// Bodies of revolution that rest on a floor, touch each other, stand on each other and stick in each other.
fn solids() -> Vec<Object> {
    let cylinder = |radius, height| analytic(Analytic::Cylinder { radius, height });
    let upside_down = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
    vec![
        floor(),
        object("drum", cylinder(1.0, 1.0), at(0.0, 0.5, 0.0)),
        object("tower on it", cylinder(0.5, 1.0), at(0.5, 1.5, 0.0)),
        object("cone beside", analytic(Analytic::Cone { radius: 1.0, height: 2.0 }), at(2.0, 1.0, 0.0)),
        object("paraboloid", analytic(Analytic::Paraboloid { radius: 1.0, height: 1.0 }), at(-2.0, 0.5, 0.0)),
        object(
            "cup",
            analytic(Analytic::Frustum { bottom_radius: 0.5, top_radius: 1.0, height: 1.0 }),
            at(0.0, 0.5, 2.0),
        ),
        object("hanging cone", analytic(Analytic::Cone { radius: 0.5, height: 1.0 }), at(0.0, 2.0, 2.0) * upside_down),
        object("capsule", analytic(Analytic::Capsule { radius: 0.5, height: 1.0 }), at(0.0, 1.0, -2.0)),
    ]
}

/// Hulls with faces of three to six corners, points to spare, mirrored and sheared.
fn hulls() -> Vec<Object> {
    let octahedron =
        [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let prism: Vec<[f64; 3]> =
        [[2.0, 0.0], [1.0, 1.0], [-1.0, 1.0], [-2.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [0.0, 1.0], [0.0, 0.0]]
            .iter()
            .flat_map(|&[x, z]| [[x, 0.0, z], [x, 1.0, z]])
            .collect();
    vec![
        floor(),
        object("octahedron", convex(&octahedron), at(0.0, 1.0, -2.0)),
        object("prism", convex(&prism), at(0.0, 0.0, 1.0)),
        object("mirrored", convex(&prism), at(-2.0, 1.5, -1.0) * DAffine3::from_scale(DVec3::new(-0.5, 0.5, 0.5))),
        object("sheared", convex(&octahedron), sheared()),
        with_sides("two-sided", convex(&octahedron), turned(2.0, 2.0, 0.0), Sides::Two),
    ]
}

/// a·x² + b·y² + c·z² + 2m·y + d ≤ 0 within a box about the origin.
pub(crate) fn quadric([a, b, c]: [f64; 3], m: f64, d: f64, [x, y, z]: [f64; 3]) -> Shape {
    let matrix = [[a, 0.0, 0.0, 0.0], [0.0, b, 0.0, m], [0.0, 0.0, c, 0.0], [0.0, m, 0.0, d]];
    analytic(Analytic::Quadric { matrix, within: [[-x, -y, -z], [x, y, z]] })
}

/// General quadrics cut by boxes: cylinders with flat sides, a saddle, two sheets, the outside of a ball.
fn cut_quadrics() -> Vec<Object> {
    let skew = [[1.0, 2.0, 3.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0], [0.0, -1.0, 0.0, -0.5]];
    let skew = Analytic::Quadric { matrix: skew, within: [[-0.5; 3], [0.5, 1.0, 0.5]] };
    vec![
        floor(),
        object("cylinder", quadric([1.0, 0.0, 1.0], 0.0, -1.0, [0.75, 1.0, 2.0]), at(0.0, 1.0, 0.0)),
        object("saddle", quadric([1.0, 0.0, -1.0], -0.5, 0.0, [1.0, 0.5, 1.0]), at(-2.0, 1.0, 1.0)),
        object("cones", quadric([1.0, -1.0, 1.0], 0.0, 0.0, [1.0, 1.0, 1.0]), at(2.0, 1.0, 1.0)),
        object("sheets", quadric([1.0, -1.0, 1.0], 0.0, 0.25, [1.0, 1.0, 1.0]), turned(2.0, 1.5, -2.0)),
        object("bored", quadric([-1.0, -1.0, -1.0], 0.0, 0.5, [0.5, 0.75, 0.5]), at(0.0, 2.0, -2.0)),
        with_sides("skew", analytic(skew), sheared(), Sides::Two),
    ]
}

/// Bodies that shade themselves, thin bodies, and sheared ones.
fn twisted() -> Vec<Object> {
    let stretched = DAffine3::from_scale(DVec3::new(-1.0, 2.0, 0.5));
    vec![
        floor(),
        object(
            "waisted",
            analytic(Analytic::Hyperboloid { waist_radius: 0.5, end_radius: 1.0, height: 2.0 }),
            at(0.0, 1.0, 0.0),
        ),
        object("plate", analytic(Analytic::Disk { radius: 1.0 }), at(0.0, 2.0, 0.0)),
        with_sides("one side", analytic(Analytic::Disk { radius: 0.5 }), turned(2.0, 1.0, -1.0), Sides::One),
        object("sheared", analytic(Analytic::Cylinder { radius: 0.5, height: 1.0 }), sheared()),
        object("egg", analytic(Analytic::Ellipsoid { radii: [0.5, 1.0, 0.75] }), at(2.0, 1.0, 1.0) * stretched),
        with_sides(
            "open",
            analytic(Analytic::Paraboloid { radius: 1.0, height: 1.0 }),
            turned(-2.0, 1.5, 2.0),
            Sides::Two,
        ),
        object("box", cuboid(1.0, 1.0, 1.0), at(0.0, 0.5, 2.0)),
    ]
}

/// All small scenes by name.
pub(crate) fn all() -> Vec<(&'static str, Scene)> {
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let standing = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y));
    let room = |sides| with_sides("room", cuboid(6.0, 4.0, 6.0), at(0.0, 2.0, 0.0), sides);
    let boxes = vec![
        floor(),
        object("a", cuboid(1.0, 1.0, 1.0), at(0.0, 0.5, 0.0)),
        object("beside", cuboid(2.0, 1.0, 1.0), at(1.5, 0.5, 0.0)),
        object("on top", cuboid(1.0, 0.5, 0.5), at(0.5, 1.25, 0.0)),
        object("turned", cuboid(1.0, 2.0, 0.5), turned(-1.5, 2.0, 1.0)),
    ];
    let coplanar = vec![
        floor(),
        object("tile", rectangle(2.0, 2.0), at(1.0, 0.0, 1.0)),
        with_sides("one", rectangle(2.0, 1.0), at(0.0, 1.0, 0.0), Sides::One),
        object("wall", rectangle(4.0, 2.0), at(0.0, 1.0, -1.0) * standing),
        object("wall beside", rectangle(4.0, 2.0), at(2.0, 2.0, -1.0) * standing),
    ];
    let instances = vec![
        floor(),
        object("plain", l_prism(), at(0.0, 0.0, -2.0)),
        object("mirrored", l_prism(), at(0.0, 0.0, 1.0) * mirror),
        object("sheared", l_prism(), sheared()),
        object("mirrored box", cuboid(1.0, 1.0, 1.0), at(-3.0, 1.0, 0.0) * mirror),
        with_sides("mirrored tile", rectangle(1.0, 1.0), at(2.0, 1.0, 2.0) * mirror, Sides::One),
        with_sides("two-sided", tetrahedron(), at(2.0, 0.5, -3.0) * mirror, Sides::Two),
    ];
    let spheres = vec![
        floor(),
        object("resting", sphere(1.0), at(0.0, 1.0, 0.0)),
        object("cut", sphere(1.0), at(2.0, 0.25, 1.0)),
        object("sheared", sphere(0.75), sheared()),
        with_sides("hollow", sphere(0.5), at(1.0, 2.5, -1.0), Sides::Two),
        object("box", cuboid(1.0, 1.0, 1.0), at(0.0, 0.5, 2.0)),
        object("mirrored", sphere(0.5), at(-2.0, 0.5, 2.0) * DAffine3::from_scale(DVec3::new(-1.0, 2.0, 0.5))),
    ];
    let indoors = vec![
        room(Sides::Two),
        object("table", cuboid(1.0, 1.0, 1.0), at(0.0, 0.5, 0.0)),
        object("ball", sphere(0.5), at(0.0, 1.5, 0.0)),
        object("corner", cuboid(1.0, 2.0, 1.0), at(2.5, 1.0, 2.5)),
        object("nail", degenerate_mesh(), at(0.0, 1.0, 1.5)),
    ];
    let through = vec![
        floor(),
        object("a", cuboid(2.0, 2.0, 2.0), at(0.0, 0.5, 0.0)),
        object("b", cuboid(1.0, 4.0, 1.0), at(0.5, 1.0, 0.5)),
        object("ball", sphere(1.0), at(-1.0, 1.0, -1.0)),
        object("tilted", cuboid(2.0, 0.5, 2.0), turned(0.0, 1.0, 0.0)),
    ];
    vec![
        ("far boxes", elsewhere(&boxes, 1.0, DVec3::new(1e6 + 0.1, -3e5, 7e5 / 3.0))),
        ("tiny far spheres", elsewhere(&spheres, 2f64.powi(-60), DVec3::new(1e-13, 3e-14, -7e-13))),
        ("tiniest spheres", elsewhere(&spheres, 2f64.powi(-100), DVec3::ZERO)),
        ("far crossings", elsewhere(&through, 2f64.powi(40), DVec3::new(-1e17, 1e16, 3e15))),
        ("boxes", scene(boxes)),
        ("coplanar", scene(coplanar)),
        ("instances", scene(instances)),
        ("sheet", scene(vec![object("sheet", sheet_with_wall(), at(-1.0, 0.0, -1.0)), floor()])),
        ("degenerate", scene(vec![object("mesh", degenerate_mesh(), DAffine3::IDENTITY), floor()])),
        ("spheres", scene(spheres)),
        ("indoors", scene(indoors)),
        ("closed room", scene(vec![room(Sides::One), object("ball", sphere(1.0), at(0.0, 1.0, 0.0)), floor()])),
        ("through", scene(through)),
        ("far solids", elsewhere(&solids(), 1.0, DVec3::new(1e6 + 0.1, -3e5, 7e5 / 3.0))),
        ("tiny solids", elsewhere(&twisted(), 2f64.powi(-60), DVec3::new(1e-13, 3e-14, -7e-13))),
        ("far hulls", elsewhere(&hulls(), 1.0 / 3.0, DVec3::new(1e6 + 0.1, -3e5, 7e5 / 3.0))),
        ("hulls", scene(hulls())),
        ("cut quadrics", scene(cut_quadrics())),
        ("solids", scene(solids())),
        ("twisted", scene(twisted())),
    ]
}

/// Points that light should graze: corners, middles of edges and faces, poles and centres.
pub(crate) fn features(scene: &Scene) -> Vec<[f64; 3]> {
    let mut features = Vec::new();
    for object in &scene.objects {
        let mut local: Vec<DVec3> = match &object.shape {
            Shape::Mesh(mesh) => mesh.positions().to_vec(),
            Shape::Rectangle(rectangle) => rectangle.corners().to_vec(),
            Shape::Cuboid(cuboid) => cuboid.corners().to_vec(),
            Shape::Convex(convex) => convex.points().to_vec(),
            Shape::Analytic(body) => Solid::new(body).features().into_iter().map(DVec3::from_array).collect(),
            _ => Vec::new(),
        };
        let middles: Vec<DVec3> = local.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
        local.extend(middles);
        features.extend(local.into_iter().map(|point| object.placement.map().transform_point3(point).to_array()));
    }
    features
}

/// A light for the point x: anywhere, on a grid, near x, or such that the segment just touches one of `features`.
pub(crate) fn tricky_light(dice: &mut Dice, x: [f64; 3], features: &[[f64; 3]]) -> LightSource {
    loop {
        let feature = dice.pick(features);
        let difference: [f64; 3] = std::array::from_fn(|i| feature[i] - x[i]);
        let reach = dice.pick(&[1.0, 1.5, 2.0, 3.0, 4.0, 0.5]);
        let through: [f64; 3] = std::array::from_fn(|i| x[i] + reach * difference[i]);
        let candidate = match dice.below(9) {
            0 => LightSource::point(dice.grid_point(16, 0.25)),
            1 => LightSource::point(std::array::from_fn(|_| dice.float(-5.0, 5.0))),
            2 => LightSource::sun(dice.grid_point(3, 1.0)),
            3 => LightSource::sun(std::array::from_fn(|_| dice.float(-1.0, 1.0))),
            4 => LightSource::sun(difference.map(|d| -d)),
            5 => LightSource::sun(difference.map(|d| dice.nudged(-d))),
            6 => LightSource::point(through),
            7 => LightSource::point(through.map(|coordinate| dice.nudged(coordinate))),
            _ => LightSource::point(std::array::from_fn(|i| x[i] + dice.grid(2, 1.0 / 1024.0))),
        };
        if let Ok(light) = candidate {
            return light;
        }
    }
}
