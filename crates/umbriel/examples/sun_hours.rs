//! How much of the ground round a house the sun reaches in the course of a day, with bounds; and when it reaches a spot
//! behind the house.

use std::{error::Error, path::Path, time::Duration};

use umbriel::{geometry::LightSource, io, shadow};

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
    let loaded = io::load(&house, &io::LoadOptions::default())?;
    let mut suns = Vec::new();
    for hour in 7..=17 {
        let [azimuth, elevation] = sun_at(f64::from(hour));
        let source = LightSource::sun(loaded.sun_from_angles(azimuth, elevation))?;
        suns.push(shadow::TimedLight { source, duration: Duration::from_secs(3600) });
    }
    let scene = &loaded.scene;
    let ground = scene.objects.iter().position(|object| object.name == "floor").ok_or("there is no floor")?;

    // All objects cast shadows; only the ground is asked about.
    let detail = shadow::Detail::Depth { interior: 4, boundary: 9 };
    let request = shadow::Request { receivers: vec![ground], ..shadow::Request::everything(scene, detail) };
    let report = shadow::bake_hours(scene, &request, &suns, &shadow::Silent)?;
    // Single points need no cells, and their answers have no bounds: they are exact.
    let queries = shadow::Queries::new(scene);
    let spot = shadow::Place::Free { position: [0.0, 0.0, -3.5] };
    println!("ground of {} m² in the sun        3.5 m north of the middle of the house", report.objects[0].area);
    for ((hour, sun), shadow::LightSummary { lit, .. }) in (7..).zip(&suns).zip(&report.lights) {
        let said = if queries.lit(&spot, &sun.source)?.lit { "sun" } else { "shadow" };
        println!("{hour:>2} h   {:.3} to {:.3} m²    {said}", lit.lower, lit.upper);
    }
    let mean = report.objects[0].lit_hours;
    println!("in the mean {:.3} to {:.3} of {} hours", mean.lower, mean.upper, shadow::hours(report.duration));
    Ok(())
}
