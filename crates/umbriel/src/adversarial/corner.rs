//! Shadows whose outline runs through a corner of a cell.
//!
//! From a corner of the receiver's quadtree, go some way towards the light; there an occluder has an edge, a vertex, or the
//! outline of a curved body, within [`REACH`](super::REACH) units in the last place. All cells round that corner then
//! have a point that is lit or not by a hair.

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Placement, Rectangle};
use umbriel_scene::{Object, Scene, Shape, Sides};

use super::{Random, World, any_point, hull, mesh, standing};

/// A scene to bake, and where to look.
#[derive(Clone, Debug)]
pub struct CornerTrial {
    /// The receiver (object 0, one face) and an occluder, without lights.
    pub scene: Scene,
    /// The light.
    pub light: LightSource,
    /// The corner in the receiver's parameters: multiples of 2^-`level`.
    pub corner: [f64; 2],
    /// The level from which on it is a corner of cells.
    pub level: u8,
}

/// A receiver, and an occluder whose outline, seen from the light, runs through a corner of the receiver's cells.
pub fn outline_through_corner(random: &mut Random) -> CornerTrial {
    let world = World::any(random);
    loop {
        let level = 1 + random.below(5) as u8;
        let cells = 1u64 << level;
        let steps = [random.below(cells + 1), random.below(cells + 1)];
        let is_square = random.below(2) == 0;
        let is_beyond = !is_square && steps[0] + steps[1] > cells;
        let corner = steps.map(|k| if is_beyond { cells - k } else { k } as f64 / cells as f64);
        let (receiver, at) = if is_square { square(corner, &world, random) } else { triangle(corner, &world, random) };
        let Some((light, towards)) = light_over(at, &world, random) else { continue };
        let share = random.pick(&[0.5, 0.25, 0.75, 0.1]);
        let target = at + towards * share;
        let shape = match random.below(7) {
            0 | 1 => body_beside(target, towards, &world, random),
            2 => Some(tetrahedron_at(target, &world, random)),
            3 => box_at(target, &world, random),
            _ => Some(triangle_at(target, &world, random)),
        };
        let Some(occluder) = shape else { continue };
        let scene = Scene { objects: [receiver, occluder].into(), ..Scene::default() };
        return CornerTrial { scene, light, corner, level };
    }
}

/// A level square under everything else, and its point with these parameters, rounded.
fn square([u, v]: [f64; 2], world: &World, random: &mut Random) -> (Object, DVec3) {
    let size = random.pick(&[4.0, 8.0, 3.0]) * world.scale;
    let shape = Shape::Rectangle(Rectangle { size: [size; 2] });
    let placement = Placement::new(DAffine3::from_translation(world.offset)).expect("a translation");
    let object = Object::new("receiver".into(), shape, placement, Sides::Auto).expect("a plain square");
    let facets = object.facets().expect("a flat object");
    let corner = |k: usize| facets.point(facets.facet(0).corners()[k]).position;
    let at = corner(0) + (corner(1) - corner(0)) * u + (corner(3) - corner(0)) * v;
    (object, at)
}

/// A triangle there. Its longest side lies opposite the first corner, so cells count from that one.
fn triangle([u, v]: [f64; 2], world: &World, random: &mut Random) -> (Object, DVec3) {
    let size = random.pick(&[4.0, 8.0, 3.0]);
    let corners = [DVec3::ZERO, DVec3::X * size, DVec3::new(0.0, 0.125, size)].map(|p| world.place(p));
    let at = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
    (standing("receiver".into(), mesh(&corners, &[[0, 1, 2]]), Sides::Two), at)
}

/// A light above, and the way to it: to the lamp itself, or some way along a sun's direction.
fn light_over(at: DVec3, world: &World, random: &mut Random) -> Option<(LightSource, DVec3)> {
    let above = any_point(random) * DVec3::new(1.0, 0.5, 1.0) + DVec3::Y * 4.0;
    if random.below(2) == 0 {
        let sun = LightSource::sun((-above).to_array()).ok()?;
        return Some((sun, above * world.scale));
    }
    let lamp = at + above * world.scale;
    LightSource::point(lamp.to_array()).ok().map(|light| (light, lamp - at))
}

/// A triangle with an edge through the point, or a vertex in it.
fn triangle_at(point: DVec3, world: &World, random: &mut Random) -> Object {
    let corners = corners_at(point, world, random);
    standing("triangle".into(), mesh(&corners[..3], &[[0, 1, 2]]), Sides::Two)
}

/// A tetrahedron with an edge through the point, or a vertex in it: a closed mesh, flat or inside out at times, or the hull.
fn tetrahedron_at(point: DVec3, world: &World, random: &mut Random) -> Object {
    let corners = corners_at(point, world, random);
    let hull = if random.below(2) == 0 { hull(&corners) } else { None };
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    standing("tetrahedron".into(), hull.unwrap_or_else(|| mesh(&corners, &faces)), Sides::Auto)
}

/// An upright box with a vertex in the point, or an edge through it, or nearly.
fn box_at(point: DVec3, world: &World, random: &mut Random) -> Option<Object> {
    let size = DVec3::from_array([(); 3].map(|()| random.pick(&[0.5, 0.25, 1.0]))) * world.scale;
    let mut away = DVec3::from_array([(); 3].map(|()| random.pick(&[-0.5, 0.5])));
    if random.below(2) == 0 {
        away[random.below(3) as usize] *= 0.5;
    }
    let placement = Placement::new(DAffine3::from_translation(random.beside_point(point + size * away))).ok()?;
    Object::new("box".into(), Shape::Cuboid(Cuboid { size: size.to_array() }), placement, Sides::Auto).ok()
}

fn corners_at(point: DVec3, world: &World, random: &mut Random) -> [DVec3; 4] {
    let mut aside = || any_point(random) * world.scale * 0.5;
    let [along, second, third] = [aside(), aside(), aside()];
    let behind = random.pick(&[0.0, 0.5, 1.0]);
    let corners = [point - along * behind, point + along, point + second, point + third];
    if random.below(3) == 0 { corners } else { corners.map(|corner| random.beside_point(corner)) }
}

/// A ball or an ellipsoid that the way touches, or nearly; `None` where the chosen side is that of the way itself.
fn body_beside(point: DVec3, way: DVec3, world: &World, random: &mut Random) -> Option<Object> {
    let shares = random.pick(&[DVec3::ONE, DVec3::new(1.0, 0.5, 2.0)]);
    // Sideways where the body is a unit ball.
    let aside = (way / shares).cross(any_point(random)).try_normalize()?;
    let radii = shares * (random.pick(&[0.5, 0.25, 1.0]) * world.scale);
    let centre = random.beside_point(point + aside * radii);
    let body = if shares == DVec3::ONE {
        Analytic::Sphere { radius: radii.x }
    } else {
        Analytic::Ellipsoid { radii: radii.to_array() }
    };
    let placement = Placement::new(DAffine3::from_translation(centre)).ok()?;
    Object::new("body".into(), Shape::from(body), placement, Sides::Auto).ok()
}
