//! How much of the ground round a house the sun reaches in the course of a day, with bounds; and when it reaches a spot
//! behind the house.

use std::{error::Error, path::Path};

use umbriel::{geometry::LightSource, io, scene::Light, shadow};

/// Degrees north.
const LATITUDE: f64 = 51.0;

/// Where the sun stands on the day of the equinox at an hour of solar time: azimuth and elevation, degrees.
fn sun_at(hour: f64) -> [f64; 2] {
    let (turn, latitude) = ((hour - 12.0) * 15.0_f64.to_radians(), LATITUDE.to_radians());
    let elevation = (latitude.cos() * turn.cos()).asin();
    [180.0 + turn.sin().atan2(turn.cos() * latitude.sin()).to_degrees(), elevation.to_degrees()]
}

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let house = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/house.toml");
    let mut loaded = io::load(&house, &io::LoadOptions::default())?;
    let mut suns = Vec::new();
    for hour in 7..=17 {
        let [azimuth, elevation] = sun_at(f64::from(hour));
        let source = LightSource::sun(loaded.sun_from_angles(azimuth, elevation))?;
        suns.push(Light { name: format!("{hour} h"), source });
    }
    loaded.scene.lights = suns;
    let scene = &loaded.scene;
    let ground = scene.objects.iter().position(|object| object.name == "floor").ok_or("there is no floor")?;

    // All objects cast shadows; only the ground is asked about.
    let detail = shadow::Detail::Depth { interior: 4, boundary: 9 };
    let request = shadow::Request { receivers: vec![ground], ..shadow::Request::everything(scene, detail) };
    let report = shadow::bake(scene, &request, &shadow::Silent)?;
    // Single points need no cells, and their answers have no bounds: they are exact.
    let queries = shadow::Queries::new(scene);
    let spot = shadow::Place::Free { position: [0.0, 0.0, -3.5] };
    println!(
        "ground of {} m² in the sun        3.5 m north of the middle of the house",
        report.lights[0].objects[0].area
    );
    for light in &report.lights {
        let (lit, sun) = (light.objects[0].lit, &scene.lights[light.light]);
        let is_lit = queries.lit(&spot, &sun.source)?.lit;
        let said = if is_lit { "sun" } else { "shadow" };
        println!("{:>4}   {:.3} to {:.3} m²    {said}", sun.name, lit.lower, lit.upper);
    }
    Ok(())
}
