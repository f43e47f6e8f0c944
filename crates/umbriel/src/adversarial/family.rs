//! Whole scenes of one kind of trouble each: a receiver, a few occluders, a light.
//!
//! Segments ask about one point; these scenes are for everything that looks at surfaces as a whole: cells, samples, many
//! points. Borders are met within [`REACH`](super::REACH) units in the last place where floats allow it, and triangles and bodies
//! are such that the usual constructions (normals, crossings, slopes) lose all their digits.

use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Placement, Rectangle};
use umbriel_scene::{Object, Scene, Shape, Sides};

use super::{Random, any_point, hull, mesh, standing};

/// A kind of trouble.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// Triangles from a millionth of the receiver to a million times its size.
    Scales,
    /// Planes that differ from the receiver's by units in the last place, under grazing light.
    Parallel,
    /// Triangles whose third corner lies on the opposite side, or nearly, far from the origin.
    Slivers,
    /// A fan of thin triangles with the light in their planes, or on their common line.
    Needles,
    /// Curved bodies that touch the receiver, each other, or a plane through the light.
    Contact,
    /// Closed bodies with flat faces that have faces, edges or corners in common, stand in each other and in the receiver, some with a
    /// corner moved; the light is in planes of theirs.
    Blocks,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Scales, Self::Parallel, Self::Slivers, Self::Needles, Self::Contact, Self::Blocks];
}

/// A scene without lights, and its light. Object 0 is the receiver that the others stand over.
#[derive(Clone, Debug)]
pub struct FamilyTrial {
    /// Two to five objects.
    pub scene: Scene,
    /// The light.
    pub light: LightSource,
}

/// A scene of a family.
pub fn family(family: Family, random: &mut Random) -> FamilyTrial {
    let (objects, light) = match family {
        Family::Scales => scales(random),
        Family::Parallel => parallel(random),
        Family::Slivers => slivers(random),
        Family::Needles => needles(random),
        Family::Contact => contact(random),
        Family::Blocks => blocks(random),
    };
    let trial = FamilyTrial { scene: Scene { objects: objects.into(), ..Scene::default() }, light };
    let factor = random.pick(&[0.0, 0.0, 0.0, 0.0, 2f64.powi(-180), 2f64.powi(-60), 2f64.powi(60), 2f64.powi(150)]);
    scaled(&trial, factor).unwrap_or(trial)
}

/// The same so many times as large, if its numbers are accepted.
fn scaled(trial: &FamilyTrial, factor: f64) -> Option<FamilyTrial> {
    let map = DAffine3::from_scale(DVec3::splat(factor));
    let moved = |object: &Object| object.moved(Placement::new(map * *object.placement.map()).ok()?).ok();
    let objects = trial.scene.objects.iter().map(moved).collect::<Option<Vec<Object>>>()?;
    let light = match trial.light.is_sun() {
        true => trial.light,
        false => LightSource::point((trial.light.xyz() * factor).to_array()).ok()?,
    };
    Some(FamilyTrial { scene: Scene { objects: objects.into(), ..Scene::default() }, light })
}

fn triangle(name: &str, corners: [DVec3; 3]) -> Object {
    standing(name.into(), mesh(&corners, &[[0, 1, 2]]), Sides::Two)
}

/// A level square round a point, as a rectangle or as two triangles.
fn floor(middle: DVec3, size: f64, random: &mut Random) -> Object {
    if random.below(2) == 0 {
        let placement = Placement::new(DAffine3::from_translation(middle)).expect("a translation");
        let shape = Shape::Rectangle(Rectangle { size: [size; 2] });
        return Object::new("receiver".into(), shape, placement, Sides::Auto).expect("a plain square");
    }
    let corner = |x: f64, z: f64| middle + DVec3::new(x, 0.0, z) * (size * 0.5);
    let corners = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    standing("receiver".into(), mesh(&corners, &[[0, 1, 2], [0, 2, 3]]), Sides::Two)
}

/// A lamp there, or a sun that shines from there; anything above if the numbers are refused.
fn light_at(place: DVec3, middle: DVec3, random: &mut Random) -> LightSource {
    let sun = |towards: DVec3| LightSource::sun((-towards).to_array());
    let wanted = if random.below(2) == 0 { sun(place - middle) } else { LightSource::point(place.to_array()) };
    wanted.or(sun(DVec3::new(0.25, 1.0, 0.5))).expect("a sun above")
}

fn scales(random: &mut Random) -> (Vec<Object>, LightSource) {
    let mut objects = vec![floor(DVec3::ZERO, 4.0, random)];
    let above = DVec3::Y * random.pick(&[1e-6, 0.5, 2.0, 1e3]);
    let light = light_at(above + any_point(random) * random.pick(&[0.1, 1.0, 1e6]), DVec3::ZERO, random);
    for number in 0..1 + random.below(4) {
        let at = any_point(random) * 0.5 * DVec3::new(1.0, 0.25, 1.0) + DVec3::Y * random.pick(&[0.0, 1e-9, 0.5, 1.0]);
        let sizes = [1e-6, 1e-3, 1.0, 1e3, 1e6];
        let corner = |random: &mut Random| at + any_point(random) * random.pick(&sizes);
        let name = format!("{number}");
        objects.push(match random.below(6) {
            0 => body_at(name, at, Shape::Cuboid(Cuboid { size: [(); 3].map(|()| random.pick(&sizes)) })),
            1 => body_at(name, at, Shape::from(Analytic::Ellipsoid { radii: [(); 3].map(|()| random.pick(&sizes)) })),
            2 => standing(name, hull_or_mesh([(); 4].map(|()| corner(random))), Sides::Auto),
            _ => triangle(&name, [(); 3].map(|()| corner(random))),
        });
    }
    (objects, light)
}

/// A body with its middle there.
fn body_at(name: String, middle: DVec3, shape: Shape) -> Object {
    let placement = Placement::new(DAffine3::from_translation(middle)).expect("a translation");
    Object::new(name, shape, placement, Sides::Auto).expect("sizes far inside the accepted range")
}

/// The hull of four points, or their triangles where they lie in a plane.
fn hull_or_mesh(corners: [DVec3; 4]) -> Shape {
    hull(&corners).unwrap_or_else(|| mesh(&corners, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
}

fn parallel(random: &mut Random) -> (Vec<Object>, LightSource) {
    let offset = random.pick(&[0.0, 0.0, 1e3, 1e6]);
    let [origin, a, b] = [any_point(random) + DVec3::splat(offset), any_point(random), any_point(random)];
    let in_plane = |random: &mut Random| {
        let [u, v] = [(); 2].map(|()| random.pick_or(&[0.0, 0.25, 0.5, 1.0], -0.5, 1.5));
        origin + a * u + b * v
    };
    let mut objects = vec![triangle("receiver", [origin, origin + a, origin + b])];
    for number in 0..1 + random.below(3) {
        let corners = [(); 3].map(|()| in_plane(random));
        objects.push(triangle(&format!("{number}"), corners.map(|corner| random.beside_point(corner))));
    }
    let normal = a.cross(b);
    let lift = random.pick(&[0.0, 1e-15, 1e-9, 1e-3, 1.0]);
    let place = in_plane(random) + normal * lift;
    let place = if random.below(2) == 0 { place } else { random.beside_point(place) };
    (objects, light_at(place, origin, random))
}

fn slivers(random: &mut Random) -> (Vec<Object>, LightSource) {
    let offset = DVec3::new(1.0, 0.5, -2.0) * random.pick(&[0.0, 1e3, 1e6, 1e9]);
    let mut objects = vec![floor(offset, 4.0, random)];
    let light = light_at(offset + any_point(random) + DVec3::Y * 5.0, offset, random);
    for number in 0..1 + random.below(4) {
        let over = |random: &mut Random| {
            offset + any_point(random) * DVec3::new(0.5, 0.125, 0.5) + DVec3::Y * random.pick(&[0.75, 0.0])
        };
        let [from, to] = [over(random), over(random)];
        let on_line = from + (to - from) * random.pick_or(&[0.5, 0.0, 1.0, 2.0], 0.0, 1.0);
        objects.push(triangle(&format!("{number}"), [from, to, random.beside_point(on_line)]));
    }
    (objects, light)
}

fn needles(random: &mut Random) -> (Vec<Object>, LightSource) {
    let mut objects = vec![floor(DVec3::ZERO, 4.0, random)];
    let hub = any_point(random) * DVec3::new(0.25, 0.125, 0.25) + DVec3::Y * 0.75;
    let along = any_point(random) * DVec3::new(0.25, 0.5, 0.25) + DVec3::Y * 0.5;
    // All blades hold the line from the hub along; the light is on it, or in the plane of one of them.
    let tip = hub + along * random.pick(&[0.5, 1.0]);
    let blades = 2 + random.below(6) as usize;
    let width = random.pick(&[1e-9, 1e-3, 0.5]);
    let mut points = vec![hub, tip];
    points.extend((0..blades).map(|_| {
        let aside = hub + along * random.between(-0.5, 1.5) + any_point(random) * width;
        random.beside_point(aside)
    }));
    let triangles: Vec<[u32; 3]> = (0..blades as u32).map(|k| [0, 1, 2 + k]).collect();
    let place = match random.below(3) {
        0 => hub + along * 4.0,
        1 => hub + along * 3.0 + (points[2] - hub) * 2.0,
        _ => tip,
    };
    objects.push(standing("needles".into(), mesh(&points, &triangles), Sides::Two));
    let place = if random.below(2) == 0 { place } else { random.beside_point(place) };
    (objects, light_at(place, hub, random))
}

/// A body that reaches from −1 to 1 along its axis, if its size is 1.
fn any_body(size: f64, random: &mut Random) -> Shape {
    let height = 2.0 * size;
    Shape::from(match random.below(9) {
        0 => Analytic::Cylinder { radius: size * 0.5, height },
        1 => Analytic::Cone { radius: size, height },
        2 => Analytic::Paraboloid { radius: size, height },
        3 => Analytic::Hyperboloid { waist_radius: size * 0.5, end_radius: size, height },
        4 => Analytic::Ellipsoid { radii: [size * 0.5, size, size * 2.0] },
        5 => Analytic::Capsule { radius: size * 0.5, height: size },
        6 => Analytic::Frustum { bottom_radius: size * 0.5, top_radius: size, height },
        7 => return Shape::Cuboid(Cuboid { size: [size, height, height] }),
        _ => Analytic::Sphere { radius: size },
    })
}

fn contact(random: &mut Random) -> (Vec<Object>, LightSource) {
    let offset = DVec3::new(1.0, 0.5, -2.0) * random.pick(&[0.0, 0.0, 1e3, 1e6]);
    let mut objects = vec![floor(offset, 4.0, random)];
    let size = random.pick_or(&[0.5, 0.25, 1.0], 0.1, 1.0);
    let turn = match random.below(4) {
        0 => DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0)),
        1 => DMat3::from_cols(DVec3::Y, DVec3::X, DVec3::Z),
        _ => DMat3::IDENTITY,
    };
    // The first one stands on the floor, each further one on the one before.
    let mut top = offset;
    for number in 0..1 + random.below(3) {
        let middle = top + DVec3::Y * size;
        let middle = if random.below(2) == 0 { middle } else { random.beside_point(middle) };
        let placement = Placement::new(DAffine3 { matrix3: turn, translation: middle }).expect("a regular matrix");
        let shape = any_body(size, random);
        objects.push(Object::new(format!("{number}"), shape, placement, Sides::Auto).expect("sizes near one"));
        top = middle + DVec3::Y * size;
    }
    let beside = DVec3::X * size * random.pick(&[0.5, 1.0, 0.0]);
    let place = match random.below(4) {
        0 => top + beside,
        1 => offset + beside + DVec3::Y * (2.0 * size),
        2 => offset + beside + DVec3::Z * 3.0,
        _ => top + any_point(random) + DVec3::Y * 4.0,
    };
    let place = if random.below(2) == 0 { place } else { random.beside_point(place) };
    (objects, light_at(place, offset, random))
}

/// A point of the lattice with steps of a half over the receiver, at its height or a little above or below.
fn lattice_point(random: &mut Random) -> DVec3 {
    let mut step = |count: u64, first: f64| first + 0.5 * random.below(count) as f64;
    DVec3::new(step(8, -2.0), step(3, -0.5), step(8, -2.0))
}

/// A box between lattice points: as a box, its triangles, the hull of its corners, or the hull of four of them.
fn block(name: String, offset: DVec3, random: &mut Random) -> (Vec<DVec3>, Object) {
    let low = offset + lattice_point(random);
    let size = DVec3::from_array([(); 3].map(|()| random.pick(&[0.5, 0.5, 1.0, 2.0])));
    let corner = |k: usize| low + size * DVec3::from_array([0, 1, 2].map(|axis| (k >> axis & 1) as f64));
    let mut corners: Vec<DVec3> = (0..8).map(corner).collect();
    if random.below(4) == 0 {
        return (corners, body_at(name, low + size * 0.5, Shape::Cuboid(Cuboid { size: size.to_array() })));
    }
    if random.below(3) == 0 {
        let moved = random.below(8) as usize;
        corners[moved] = random.beside_point(corners[moved]);
    }
    let some = match random.below(4) {
        0 => hull(&corners),
        // Four corners no two of which share an edge span a tetrahedron.
        1 => hull(&[0, 3, 5, 6].map(|k| corners[k])),
        _ => None,
    };
    let triangles: Vec<[u32; 3]> = Cuboid::FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let object = standing(name, some.unwrap_or_else(|| mesh(&corners, &triangles)), Sides::Auto);
    (corners, object)
}

/// The same body once more, some steps of the lattice away.
fn instance(name: String, corners: &[DVec3], object: &Object, random: &mut Random) -> (Vec<DVec3>, Object) {
    let step = lattice_point(random);
    let placement = Placement::new(DAffine3::from_translation(step) * *object.placement.map());
    let moved = Object::new(name, object.shape.clone(), placement.expect("a translation"), object.sides);
    (corners.iter().map(|corner| corner + step).collect(), moved.expect("near where it was"))
}

fn blocks(random: &mut Random) -> (Vec<Object>, LightSource) {
    let offset = DVec3::new(1.0, 0.5, -2.0) * random.pick(&[0.0, 0.0, 1e3, 1e6]);
    let mut objects = vec![floor(offset, 4.0, random)];
    let (mut corners, mut last) = (Vec::new(), Vec::new());
    for number in 0..1 + random.below(4) {
        let (name, is_new) = (format!("{number}"), number == 0 || random.below(3) > 0);
        let (own, object) = match objects.last() {
            Some(object) if !is_new => instance(name, &last, object, random),
            _ => block(name, offset, random),
        };
        objects.push(object);
        corners.extend_from_slice(&own);
        last = own;
    }
    let corner = corners[random.below(corners.len() as u64) as usize];
    let place = match random.below(4) {
        0 => corner,
        1 => corner + lattice_point(random) + DVec3::Y,
        2 => offset + lattice_point(random) * 2.0 + DVec3::Y * 2.0,
        _ => corner + any_point(random),
    };
    let place = if random.below(2) == 0 { place } else { random.beside_point(place) };
    (objects, light_at(place, offset, random))
}
