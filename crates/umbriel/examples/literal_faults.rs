//! How often the method of Xie et al. (2001) is wrong when it is read literally, and by which of its rules: `literal_faults SCENE [AZIMUTH ELEVATION]`, points
//! spread over the surface. Depths 4 and 8, the source's.

use std::path::Path;

use umbriel::{
    geometry::LightSource,
    io::{LoadOptions, load},
    shadow::{
        rivals::{Literal, Polygons},
        tradeoff::Judge,
    },
};

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, angles @ ..] = &arguments[..] else { return Err("name a scene".into()) };
    let number = |place: usize, usual: f64| angles.get(place).map_or(Ok(usual), |angle| angle.parse::<f64>());
    let scene = load(Path::new(file), &LoadOptions::default())?;
    let sun = LightSource::sun(scene.sun_from_angles(number(0, 135.0)?, number(1, 40.0)?))?;
    let polygons = Polygons::new(&scene.scene, 16);
    let judge = Judge::new(&scene.scene, &polygons, &sun, 200_000);
    let method = Literal { interior: 4, boundary: 8, most_rays: 400_000_000 };
    let faults = method.faults(&polygons, &sun, judge.points(), judge.lit())?;
    let share = |count: u64| format!("{:.3} %", 100.0 * count as f64 / faults.points as f64);
    println!("{} points, wrong {}", faults.points, share(faults.wrong()));
    for (name, count) in [
        ("eight false hits", faults.eight_hits),
        ("dark border", faults.dark_border),
        ("eight false misses", faults.eight_misses),
        ("no member of the receiver", faults.membership),
        ("lit border", faults.lit_border),
        ("own shadow", faults.own_shadow),
    ] {
        println!("  {name:<26}{}", share(count));
    }
    Ok(())
}
