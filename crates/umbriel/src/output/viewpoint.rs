//! Where the picture is taken from when the scene has no camera.
//!
//! A sun is seen at work from anywhere; the default view will do. Lamps may stand in a room whose walls hide all that they
//! light. So views from all round are compared by how much of what they show is lit, and the first that shows enough is
//! taken; when the room is closed, the picture is taken inside it. Rays decide, rounded: this chooses a view and
//! proves nothing.

use glam::DVec3;
use umbriel_scene::{Camera, Projection, Scene};
use umbriel_visibility::{Ray, RayCaster, View};

/// The default view is kept when so much of the surface in it is lit; another one has to show more to be taken at once.
const ENOUGH: f64 = 0.25;
const MORE: f64 = 0.5;

/// Views that are tried when the default one shows too little: degrees above the horizon, then degrees east of south.
/// Low ones look into rooms that are open at a side.
const ELEVATIONS: [f64; 2] = [35.0, 12.0];
const TURNS: [f64; 8] = [30.0, -30.0, 0.0, 90.0, -90.0, 150.0, -150.0, 180.0];

/// Rays along each edge of a trial picture.
const TRIAL: u32 = 32;

/// Field of view inside a room, degrees: wide, as photographs of rooms are.
const INDOORS: f64 = 75.0;

/// The scene's own view if it has a camera, else one that shows something of what the chosen lights light.
pub(crate) fn choose(scene: &Scene, caster: &RayCaster, lights: &[usize], width: u32, height: u32) -> View {
    let default = View::of(scene, width, height);
    let lamps: Vec<DVec3> = lights.iter().map(|&light| scene.lights[light].source).map(|lamp| lamp.xyz()).collect();
    let has_sun = lights.iter().any(|&light| scene.lights[light].source.is_sun());
    if scene.camera.is_some() || has_sun || lights.is_empty() {
        return default;
    }
    let around = ELEVATIONS.into_iter().flat_map(|elevation| TURNS.map(|turn| (turn, elevation)));
    let around = around.map(|(turn, elevation)| View::around(scene, turn, elevation, width, height));
    let inside = lamps.iter().filter_map(|&lamp| indoors(caster, lamp, width, height));
    let mut best = (lit_share(caster, &default, &lamps), default);
    if best.0 >= ENOUGH {
        return default;
    }
    for view in around.chain(inside) {
        let share = lit_share(caster, &view, &lamps);
        if share >= MORE {
            return view;
        }
        if share > best.0 {
            best = (share, view);
        }
    }
    best.1
}

/// How much of the surface in the picture some lamp reaches from the side that is seen.
fn lit_share(caster: &RayCaster, view: &View, lamps: &[DVec3]) -> f64 {
    let step = |size: u32, i: u32| f64::from(size) * (f64::from(i) + 0.5) / f64::from(TRIAL);
    let rays = (0..TRIAL * TRIAL).map(|i| view.ray(step(view.width, i % TRIAL), step(view.height, i / TRIAL)));
    let (mut seen, mut lit) = (0.0, 0.0);
    for ray in rays {
        let Some(hit) = caster.nearest(&ray) else { continue };
        let point = ray.origin + hit.distance * ray.direction;
        let seen_side = -hit.normal.dot(ray.direction);
        seen += 1.0;
        if lamps.iter().any(|&lamp| (lamp - point).dot(hit.normal) * seen_side > 0.0 && reaches(caster, lamp, point)) {
            lit += 1.0;
        }
    }
    if seen > 0.0 { lit / seen } else { 0.0 }
}

/// Whether nothing stands between, as far as a rounded ray can tell: `point` lies on a surface, which it finds again.
fn reaches(caster: &RayCaster, lamp: DVec3, point: DVec3) -> bool {
    const SHORT_OF: f64 = 1.0 - 1.0 / 1_048_576.0;
    caster.nearest(&Ray::new(lamp, point - lamp)).is_none_or(|hit| hit.distance >= SHORT_OF)
}

/// A view inside the room of a lamp: from the place farthest from it, a little lower, past the lamp. `None` when it is
/// not in a room.
fn indoors(caster: &RayCaster, lamp: DVec3, width: u32, height: u32) -> Option<View> {
    const DIRECTIONS: u32 = 32;
    // Not quite to the wall.
    const SHARE: f64 = 0.9;
    let mut farthest: Option<DVec3> = None;
    for i in 0..DIRECTIONS {
        let angle = f64::from(i) / f64::from(DIRECTIONS) * std::f64::consts::TAU;
        let direction = DVec3::new(angle.sin(), -0.1, angle.cos());
        let Some(hit) = caster.nearest(&Ray::new(lamp, direction)) else { continue };
        let eye = lamp + SHARE * hit.distance * direction;
        if farthest.is_none_or(|other| eye.distance_squared(lamp) > other.distance_squared(lamp)) {
            farthest = Some(eye);
        }
    }
    let eye = farthest.filter(|eye| eye.is_finite() && *eye != lamp)?;
    // What the lamp lights is mostly below it and beyond.
    let floor = caster.nearest(&Ray::new(lamp, DVec3::NEG_Y)).map_or(lamp, |hit| lamp - hit.distance * DVec3::Y);
    let target = lamp.lerp(floor, 0.5);
    if (target - eye).cross(DVec3::Y) == DVec3::ZERO {
        return None;
    }
    let projection = Projection::Perspective { vertical_degrees: INDOORS };
    Some(View { camera: Camera { eye, target, up: DVec3::Y, projection }, width, height })
}

#[cfg(test)]
mod tests {
    use umbriel_geometry::{Cuboid, LightSource, Placement, Rectangle};
    use umbriel_scene::{Light, Object, Shape, Sides};

    use super::*;

    fn scene(shapes: Vec<Shape>, lamp: LightSource) -> Scene {
        let object = |shape| Object::new("o".into(), shape, Placement::IDENTITY, Sides::Two).expect("an object");
        let objects = shapes.into_iter().map(object).collect();
        Scene { objects, lights: vec![Light::new("lamp", lamp)], ..Default::default() }
    }

    fn chosen(scene: &Scene) -> View {
        choose(scene, &RayCaster::new(scene), &[0], 60, 40)
    }

    #[test]
    fn a_closed_room_is_seen_from_inside() {
        let lamp = LightSource::point([0.5, 0.8, 0.0]).expect("a lamp");
        for scale in [1.0, 2.0f64.powi(-40)] {
            let lamp = LightSource::point((lamp.xyz() * scale).to_array()).expect("a lamp");
            let room = scene(vec![Shape::Cuboid(Cuboid { size: [4.0 * scale, 2.0 * scale, 6.0 * scale] })], lamp);
            let eye = chosen(&room).camera.eye.abs() / scale;
            assert!(eye.x < 2.0 && eye.y < 1.0 && eye.z < 3.0, "{eye}");
        }
    }

    #[test]
    fn a_floor_under_a_lamp_or_a_sun_has_the_default_view() {
        for light in [LightSource::point([0.0, 3.0, 0.0]), LightSource::sun([0.0, 1.0, 0.0])] {
            let floor = scene(vec![Shape::Rectangle(Rectangle { size: [4.0, 4.0] })], light.expect("a light"));
            assert_eq!(chosen(&floor), View::of(&floor, 60, 40));
        }
    }

    #[test]
    fn a_surface_lit_from_below_is_seen_from_where_most_is_lit() {
        // Nothing that this view can show is lit; it must still be a view.
        let lamp = LightSource::point([0.0, -3.0, 0.0]).expect("a lamp");
        let floor = scene(vec![Shape::Rectangle(Rectangle { size: [4.0, 4.0] })], lamp);
        assert_eq!(chosen(&floor), View::of(&floor, 60, 40));
    }
}
