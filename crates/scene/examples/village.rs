//! A scene made by a program: instances that share a mesh, bodies given by formulas, the hull of points, families, a
//! light and a camera. Then what the layers above see of it, and what is refused.

use std::{error::Error, sync::Arc};

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{Analytic, Convex, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Camera, Family, FamilyTree, Light, Member, Object, Projection, Scene, Shape, Sides};

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let scene = village()?;
    println!("object    faces  open at the border  size, m");
    for object in &scene.objects {
        // Flat bodies have facets, curved ones forms; both know whether they enclose something.
        let is_closed = match (object.facets(), object.analytic()) {
            (Some(facets), _) => (0..facets.len()).all(|facet| facets.is_closed(facet)),
            (None, Some(body)) => body.body().is_closed(),
            (None, None) => false,
        };
        let bounds = object.bounds();
        let size = bounds.max - bounds.min;
        let border = if is_closed { "" } else { "yes" };
        println!("{:<9} {:>5}  {border:<18}  {size:.3}", object.name, object.face_count());
    }
    for family in &scene.families.families {
        println!("family {}: {} members", family.name, family.members.len());
    }
    let roofs = scene.objects.iter().filter_map(|object| match &object.shape {
        Shape::Mesh(mesh) => Some(Arc::as_ptr(mesh)),
        _ => None,
    });
    println!("the roofs share one mesh: {}", roofs.collect::<std::collections::HashSet<_>>().len() == 1);

    let thin = Shape::from(Analytic::Hyperboloid { waist_radius: 2.0, end_radius: 1.0, height: 1.0 });
    let refused = Object::new("barrel".into(), thin, Placement::IDENTITY, Sides::Auto);
    println!(
        "a barrel is no hyperboloid: {}",
        refused.map_or_else(|defect| defect.to_string(), |_| "taken".to_owned())
    );
    let flat = Placement::new(DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)));
    println!("a placement without height: {}", flat.map_or_else(|defect| defect.to_string(), |_| "taken".to_owned()));
    Ok(())
}

fn village() -> Result<Scene, Box<dyn Error>> {
    let at = |x, y, z| Placement::new(DAffine3::from_translation(DVec3::new(x, y, z)));
    let object = |name: &str, shape, placement| Object::new(name.into(), shape, placement, Sides::Auto);
    let mut objects = vec![
        object("ground", Shape::Rectangle(Rectangle { size: [30.0, 30.0] }), Placement::IDENTITY)?,
        object("silo", Shape::from(Analytic::Cylinder { radius: 2.0, height: 7.0 }), at(8.0, 3.5, 0.0)?)?,
        object("pool", Shape::from(Analytic::Disk { radius: 3.0 }), at(-9.0, 0.1, 5.0)?)?,
        object("rock", Shape::Convex(Arc::new(Convex::new(rock())?)), at(9.0, 0.0, 9.0)?)?,
    ];
    // Three houses, each turned another way, with one mesh for all roofs and one family a house.
    let roof = Arc::new(roof()?);
    let mut families = FamilyTree { roots: (0..objects.len()).map(Member::Object).collect(), ..FamilyTree::default() };
    for number in 0..3 {
        let turn = DQuat::from_rotation_y(0.5 * f64::from(number));
        let place = |y: f64| {
            let foot = DVec3::new(-6.0 + 6.0 * f64::from(number), y, -6.0);
            Placement::new(DAffine3::from_rotation_translation(turn, foot))
        };
        let walls = Shape::Cuboid(umbriel_geometry::Cuboid { size: [3.0, 2.0, 4.0] });
        families.roots.push(Member::Family(families.families.len()));
        let members = vec![Member::Object(objects.len()), Member::Object(objects.len() + 1)];
        families.families.push(Family { name: format!("house {number}"), members });
        objects.push(object(&format!("walls {number}"), walls, place(1.0)?)?);
        objects.push(object(&format!("roof {number}"), Shape::Mesh(Arc::clone(&roof)), place(2.0)?)?);
    }
    let projection = Projection::Perspective { vertical_degrees: 40.0 };
    let camera = Camera { eye: DVec3::new(20.0, 12.0, 25.0), target: DVec3::ZERO, up: DVec3::Y, projection };
    let sun = Light::new("sun", LightSource::sun([-0.5, -1.0, -0.3])?);
    Ok(Scene { objects: objects.into(), families, lights: vec![sun], camera: Some(camera), ..Scene::default() })
}

/// A ridge over 3 m × 4 m, open below.
fn roof() -> Result<Mesh, umbriel_geometry::MeshDefect> {
    let eaves = [[-1.5, 0.0, -2.0], [1.5, 0.0, -2.0], [1.5, 0.0, 2.0], [-1.5, 0.0, 2.0]];
    let ridge = [[0.0, 1.5, -2.0], [0.0, 1.5, 2.0]];
    let triangles = vec![[0, 3, 5], [0, 5, 4], [2, 1, 4], [2, 4, 5], [1, 0, 4], [3, 2, 5]];
    Mesh::new(eaves.into_iter().chain(ridge).collect(), triangles)
}

/// Points whose hull is the rock; those inside change nothing.
fn rock() -> Vec<[f64; 3]> {
    let corner = |n: u32| [f64::from(n * 7 % 5) - 2.0, f64::from(n * 11 % 4), f64::from(n * 13 % 6) - 2.5];
    (0..40).map(corner).collect()
}
