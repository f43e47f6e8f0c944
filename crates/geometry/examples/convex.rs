//! A convex body made three ways, each exact: as the hull of points, from its faces' half-spaces, from a mesh. Then what
//! a lamp sees of it, and what lies in its shadow.

use std::error::Error;

use glam::DVec3;
use umbriel_geometry::{Brep, HalfSpace, LightSource, Mesh, Point};

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    // A thousand lattice points inside or on an octahedron; six of them are its vertices.
    let lattice = (0..2197).map(|n| DVec3::new((n % 13) as f64, (n / 13 % 13) as f64, (n / 169) as f64) - 6.0);
    let body = Brep::hull(lattice.filter(|point| point.abs().element_sum() <= 6.0))?;
    let counts = |body: &Brep| (body.vertices().len(), body.edge_count(), body.face_count());
    println!("vertices, edges, faces of the hull: {:?}", counts(&body));

    let signs = (0..8).map(|n| [0, 1, 2].map(|axis| if n >> axis & 1 == 0 { 1.0 } else { -1.0 }));
    let sides: Vec<HalfSpace> = signs.map(|normal| HalfSpace { normal, offset: 6.0 }).collect();
    println!("the same of the half-spaces: {}", Brep::of_half_spaces(&sides)? == body);

    let positions = body.vertices().iter().map(|vertex| vertex.to_array()).collect();
    let mesh = Mesh::new(positions, body.triangles().collect())?;
    println!("the same of its triangles: {}", Brep::of_mesh(&mesh)? == body);

    // What cannot be a body says why.
    let flat = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
    println!("a square: {}", Brep::hull(flat).map_or_else(|defect| defect.to_string(), |_| "a body?".to_owned()));
    println!(
        "seven of the sides: {}",
        match Brep::of_half_spaces(&sides[1..]) {
            Ok(larger) => format!("a body that reaches to {}", larger.bounds().max),
            Err(defect) => defect.to_string(),
        }
    );

    // A lamp right above a vertex, in the planes of no face, sees the upper four; at 6 m it is that vertex.
    for height in [6.0, 6.0_f64.next_up(), 12.0] {
        let lamp = LightSource::point([0.0, height, 0.0])?;
        let Some(silhouette) = body.silhouette(&lamp) else {
            println!("a lamp at {height} m touches the body and sees no face");
            continue;
        };
        // The ground below, to the edge of the shadow and one step beyond it.
        let reach = 6.0 * (height + 6.0) / height;
        let lies_in_shadow = |x: f64| silhouette.covers([Point::exact(DVec3::new(x, -6.0, 0.0))]);
        println!(
            "a lamp at {height} m sees {} faces with {} edges round them; ground at {reach} m in shadow: {}, beyond: {}",
            silhouette.seen_faces().len(),
            silhouette.outline().len(),
            lies_in_shadow(reach),
            lies_in_shadow(reach.next_up() + 1.0)
        );
    }
    Ok(())
}
