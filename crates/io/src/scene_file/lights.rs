//! Lights of a scene file. Area lights are taken as their centres, with a finding.

use glam::DVec3;
use toml::Spanned;
use umbriel_geometry::{LightSource, accept};
use umbriel_scene::{FindingKind, Light};

use super::{
    Places,
    entries::{LightEntry, SunEntry},
};
use crate::{error::LoadProblem, model::Model, options::UpAxis, sun::sun_from_angles};

/// Reads all lights.
pub(super) fn read(
    model: &mut Model,
    entries: &[Spanned<LightEntry>],
    places: &Places,
    up: UpAxis,
    north: f64,
) -> Result<(), LoadProblem> {
    for (number, spanned) in entries.iter().enumerate() {
        let entry = spanned.get_ref();
        let name = entry.name.clone().unwrap_or_else(|| format!("light{}", number + 1));
        let read = light_of(entry, up, north);
        let (source, has_area) =
            read.map_err(|message| places.at(spanned.span(), format!("light \"{name}\": {message}")))?;
        model.findings.add(FindingKind::AreaLightAsPoint, &name, usize::from(has_area));
        model.lights.push(Light { name, source });
    }
    Ok(())
}

/// The light, in the file's own axes, and whether it has an area.
fn light_of(entry: &LightEntry, up: UpAxis, north: f64) -> Result<(LightSource, bool), String> {
    let (source, area) = match (&entry.sun, &entry.point, &entry.rectangle) {
        (Some(sun), None, None) => {
            let diameter = size(sun.angular_diameter, "angular_diameter")?;
            if diameter >= 180.0 {
                return Err("angular_diameter must be less than 180 degrees".to_owned());
            }
            (LightSource::sun(direction_of(sun, up, north)?), diameter > 0.0)
        }
        (None, Some(point), None) => (LightSource::point(point.position), size(point.radius, "radius")? > 0.0),
        (None, None, Some(rectangle)) => {
            let [u, v] = [rectangle.u, rectangle.v].map(DVec3::from_array);
            let accepted = rectangle.u.iter().chain(&rectangle.v).all(|&coordinate| accept(coordinate).is_ok());
            if !accepted || u.cross(v) == DVec3::ZERO {
                return Err("u and v must be two half edges in different directions".to_owned());
            }
            (LightSource::point(rectangle.center), true)
        }
        _ => return Err("give exactly one of sun, point, rectangle".to_owned()),
    };
    Ok((source.map_err(|defect| defect.to_string())?, area))
}

/// The direction in which sunlight travels, in the file's own axes.
fn direction_of(sun: &SunEntry, up: UpAxis, north: f64) -> Result<[f64; 3], String> {
    match (sun.direction, sun.azimuth, sun.elevation) {
        (Some(direction), None, None) => Ok(direction),
        (None, Some(azimuth), Some(elevation)) => {
            if !azimuth.is_finite() || !(-90.0..=90.0).contains(&elevation) {
                return Err("azimuth must be finite and elevation between -90 and 90 degrees".to_owned());
            }
            let travel = DVec3::from_array(sun_from_angles(north + azimuth, elevation));
            // Angles speak of the scene with y up; the turn to that is exact, and so is the way back.
            Ok((up.turn().matrix3.transpose() * travel).to_array())
        }
        _ => Err("give either direction, or azimuth and elevation".to_owned()),
    }
}

/// A size that may be left out; 0 then.
fn size(value: Option<f64>, key: &str) -> Result<f64, String> {
    let value = value.unwrap_or(0.0);
    if value >= 0.0 && value.is_finite() { Ok(value) } else { Err(format!("{key} must be a finite number, 0 or more")) }
}
