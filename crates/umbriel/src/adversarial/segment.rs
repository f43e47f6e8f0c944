//! Segments that graze.
//!
//! A target is chosen on the border (a point of a plane, an edge, a vertex, a point where a curved body's tangent plane is
//! known), then a segment is drawn through it: its ends are rounded where they fall, and often moved by some more units in
//! the last place. So the exact answer is open each time, and nothing but exact signs tells it.

use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::{Analytic, LightSource, Placement};
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::Place;

use super::{Random, World, any_point, mesh, standing};

/// What a segment grazes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Aim {
    /// It starts in a triangle's plane, or nearly, and at times ends there too.
    Plane,
    /// It runs through an edge that two triangles share.
    Edge,
    /// It runs through a vertex that several triangles share.
    Vertex,
    /// It touches a curved body.
    Tangent,
    /// It starts on a face that lies in one plane with others, or nearly.
    Overlap,
}

impl Aim {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Plane, Self::Edge, Self::Vertex, Self::Tangent, Self::Overlap];
}

/// A question: is `place` lit by `light` in `scene`?
#[derive(Clone, Debug)]
pub struct SegmentTrial {
    /// One or two small objects, without lights.
    pub scene: Scene,
    /// Where the segment starts.
    pub place: Place,
    /// Where it ends.
    pub light: LightSource,
}

/// A segment that grazes what `aim` says.
pub fn segment(aim: Aim, random: &mut Random) -> SegmentTrial {
    match aim {
        Aim::Plane => in_plane(random),
        Aim::Edge => through_fan(random, |fan, random| {
            let along = random.pick_or(&[0.5, 0.25], 0.0, 1.0);
            fan[0] + (fan[1] - fan[0]) * along
        }),
        Aim::Vertex => through_fan(random, |fan, _| fan[0]),
        Aim::Tangent => tangent(random),
        Aim::Overlap => overlapping(random),
    }
}

fn free(position: DVec3) -> Place {
    Place::Free { position: position.to_array() }
}

fn scene(objects: Vec<Object>) -> Scene {
    Scene { objects: objects.into(), ..Scene::default() }
}

/// A lamp at a point, or a sun there if `towards` is a direction; `None` where the numbers are refused.
fn lamp(at: DVec3) -> Option<LightSource> {
    LightSource::point(at.to_array()).ok()
}

fn sun(towards: DVec3) -> Option<LightSource> {
    LightSource::sun((-towards).to_array()).ok()
}

/// Draws a segment along `direction` through `target`, which may be at its start.
fn through(target: DVec3, direction: DVec3, random: &mut Random) -> (DVec3, LightSource) {
    loop {
        let back = random.pick(&[0.0, 0.5, 1.0, 1.0, 3.0, 1e3]);
        let start = target - direction * back;
        let start = if random.below(2) == 0 { start } else { random.beside_point(start) };
        let ahead = random.pick(&[0.0, 0.5, 1.0, 2.0, 1e6]);
        let end = target + direction * ahead;
        let light = match random.below(4) {
            0 => sun(direction),
            1 => sun(random.beside_point(target - start)),
            2 => lamp(end),
            _ => lamp(random.beside_point(end)),
        };
        if let (Some(light), Ok(start)) = (light, umbriel_geometry::accept_point(start.to_array())) {
            return (start, light);
        }
    }
}

/// A triangle and a point of its plane, moved a little; the light is anywhere, or in the plane as well.
fn in_plane(random: &mut Random) -> SegmentTrial {
    let world = World::any(random);
    let corners = [(); 3].map(|()| world.place(any_point(random)));
    let in_plane = |random: &mut Random| {
        let [u, v] = [(); 2].map(|()| random.pick_or(&[0.0, 0.25, 0.5, 1.0, -1.0, 2.0], 0.0, 1.0));
        corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v
    };
    let target = in_plane(random);
    let start = random.beside_point(target);
    let light = loop {
        let other = in_plane(random);
        let found = match random.below(6) {
            0 => lamp(other),
            1 => lamp(random.beside_point(other)),
            2 => sun(corners[1] - corners[0]),
            3 => sun(random.beside_point(other - target)),
            4 => sun(any_point(random)),
            _ => lamp(world.place(any_point(random) * 2.0)),
        };
        if let Some(light) = found {
            break light;
        }
    };
    let object = standing("triangle".into(), mesh(&corners, &[[0, 1, 2]]), Sides::Two);
    // The point of the face that is nearest to that, and the point in space beside it.
    let place = if random.below(3) == 0 { Place::Surface { object: 0, face: 0, u: 0.25, v: 0.5 } } else { free(start) };
    SegmentTrial { scene: scene(vec![object]), place, light }
}

/// Two to six triangles round a vertex, at times a closed ring, and a segment through a point that `target` chooses of
/// the hub (number 0) and the rim.
fn through_fan(random: &mut Random, target: impl Fn(&[DVec3], &mut Random) -> DVec3) -> SegmentTrial {
    let world = World::any(random);
    let blades = 2 + random.below(5) as u32;
    let rim = blades + u32::from(random.below(2) == 0);
    let points: Vec<DVec3> = (0..=rim).map(|_| world.place(any_point(random))).collect();
    let triangles: Vec<[u32; 3]> = (0..blades).map(|k| [0, 1 + k, 1 + (k + 1) % rim]).collect();
    let target = target(&points, random);
    let direction = any_point(random) * world.scale;
    let (start, light) = through(target, direction, random);
    let object = standing("fan".into(), mesh(&points, &triangles), Sides::Two);
    SegmentTrial { scene: scene(vec![object]), place: free(start), light }
}

/// A body of revolution or an ellipsoid, with a point of its side and the gradient there: x² + z² = ρ², ρ² a polynomial of the height.
fn touched(random: &mut Random) -> (Analytic, DVec3, DVec3) {
    let [radius, height] = [(); 2].map(|()| random.pick_or(&[1.0, 2.0, 0.5, 3.0], 0.1, 1.1));
    let y = random.pick_or(&[0.0, 0.25, -0.5], -0.5, 0.5) * height;
    let taper = radius / height;
    // ρ², and half its derivative by y.
    let (body, squared, slope) = match random.below(8) {
        0 => {
            let (point, outward) = on_ball(radius, y * (2.0 * radius / height), random);
            return (Analytic::Sphere { radius }, point, outward);
        }
        1 => {
            // Points stretch, gradients shrink.
            let radii = DVec3::new(radius, height, random.pick(&[0.5, 1.0, 3.0]));
            let (point, outward) = on_ball(1.0, y * (2.0 / height), random);
            return (Analytic::Ellipsoid { radii: radii.to_array() }, point * radii, outward / radii);
        }
        2 => {
            let top_radius = radius * random.pick(&[0.5, 1.0, 2.0]);
            let taper = (top_radius - radius) / height;
            let reach = radius + taper * (y + height * 0.5);
            (Analytic::Frustum { bottom_radius: radius, top_radius, height }, reach * reach, reach * taper)
        }
        3 => (Analytic::Capsule { radius, height }, radius * radius, 0.0),
        4 => (Analytic::Cylinder { radius, height }, radius * radius, 0.0),
        5 => {
            let reach = taper * (height * 0.5 - y);
            (Analytic::Cone { radius, height }, reach * reach, -reach * taper)
        }
        6 => {
            let rate = radius * taper;
            (Analytic::Paraboloid { radius, height }, rate * (height * 0.5 - y), -0.5 * rate)
        }
        _ => {
            let end_radius = radius * random.pick(&[1.0, 1.25, 2.0]);
            let rate = 4.0 * (end_radius * end_radius - radius * radius) / (height * height);
            let body = Analytic::Hyperboloid { waist_radius: radius, end_radius, height };
            (body, radius * radius + rate * y * y, rate * y)
        }
    };
    let (point, outward) = on_circle(squared.max(0.0).sqrt(), y, random);
    (body, point, outward - DVec3::Y * slope)
}

/// A point of a ball round the origin, and the vector to it.
fn on_ball(radius: f64, y: f64, random: &mut Random) -> (DVec3, DVec3) {
    let (point, _) = on_circle((radius * radius - y * y).max(0.0).sqrt(), y, random);
    (point, point)
}

/// A point of the circle at this height, and the vector to it from the axis.
fn on_circle(radius: f64, y: f64, random: &mut Random) -> (DVec3, DVec3) {
    let t = random.pick_or(&[0.0, 1.0, 0.5, -2.0, 1.0 / 3.0], -1.0, 1.0);
    let (cosine, sine) = ((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t));
    let out = DVec3::new(cosine * radius, 0.0, sine * radius);
    (out + DVec3::Y * y, out)
}

/// A placed body and a segment in the tangent plane of one of its points.
fn tangent(random: &mut Random) -> SegmentTrial {
    let (body, point, gradient) = touched(random);
    let along = gradient.cross(any_point(random));
    let world = World::any(random);
    let stretch = match random.below(3) {
        0 => DVec3::new(1.0, -2.0, 0.5),
        1 => DVec3::new(-1.5, 1.0, 0.3),
        _ => DVec3::ONE,
    };
    let map = DAffine3 { matrix3: DMat3::from_diagonal(stretch * world.scale), translation: world.offset };
    let (start, light) = through(map.transform_point3(point), map.transform_vector3(along), random);
    let placement = Placement::new(map).expect("a regular matrix");
    let object = Object::new("body".into(), Shape::from(body), placement, Sides::Auto);
    let object = object.expect("sizes far inside the accepted range");
    SegmentTrial { scene: scene(vec![object]), place: free(start), light }
}

/// Two triangles over a common lattice plane, the second one often moved by some units in the last place; the segment
/// starts on the first.
fn overlapping(random: &mut Random) -> SegmentTrial {
    let lattice = |random: &mut Random| DVec3::from_array([(); 3].map(|()| random.below(9) as f64 / 2.0 - 2.0));
    let [origin, a, b] = [(); 3].map(|()| lattice(random));
    let corner = |random: &mut Random| {
        let [i, j] = [(); 2].map(|()| random.below(7) as f64 - 3.0);
        origin + a * i + b * j
    };
    let corners = [(); 6].map(|()| corner(random));
    let elsewhere = corner(random);
    let beyond = random.pick(&[corners[0], corners[3], elsewhere]);
    let moves = random.below(2) == 0;
    let second: Vec<DVec3> = corners[3..].iter().map(|&p| if moves { random.beside_point(p) } else { p }).collect();
    let light = loop {
        let found = match random.below(5) {
            0 => lamp(beyond),
            1 => lamp(random.beside_point(beyond)),
            2 => sun(beyond - corners[1]),
            3 => sun(any_point(random)),
            _ => lamp(any_point(random) * 2.0),
        };
        if let Some(light) = found {
            break light;
        }
    };
    let whole = |name: &str, points: &[DVec3]| standing(name.into(), mesh(points, &[[0, 1, 2]]), Sides::Two);
    let objects = vec![whole("below", &corners[..3]), whole("above", &second)];
    let [u, v] = random.pick(&[[0.0, 0.0], [0.5, 0.5], [0.25, 0.25], [1.0, 0.0], [0.375, 0.125]]);
    SegmentTrial { scene: scene(objects), place: Place::Surface { object: 0, face: 0, u, v }, light }
}
