//! Lights of a scene file. What takes area lights as their centres is told by a finding.

use std::collections::BTreeMap;

use glam::DVec3;
use umbriel_geometry::LightSource;
use umbriel_scene::{Extent, FindingKind, Light};

use super::{
    Places,
    entries::{LightEntry, SunEntry},
    own_detail_of,
    tables::Placed,
};
use crate::{
    error::LoadProblem,
    model::Model,
    names::brief_name,
    options::{DetailSetting, UpAxis},
    sun::sun_from_angles,
};

/// Reads all lights. Answers the details that they have of their own.
pub(super) fn read(
    model: &mut Model,
    entries: &[Placed<LightEntry>],
    places: &Places,
    up: UpAxis,
    north: f64,
) -> Result<BTreeMap<usize, DetailSetting>, LoadProblem> {
    let mut own = BTreeMap::new();
    for (number, spanned) in entries.iter().enumerate() {
        let entry = spanned.get_ref();
        let name = entry.name.as_deref().map_or_else(|| format!("light{}", number + 1), brief_name);
        let refused = |message: String| places.at(spanned.span(), format!("light \"{name}\": {message}"));
        let (source, extent) = light_of(entry, up, north).map_err(refused)?;
        let light = Light::with_extent(&name, source, extent).map_err(|defect| refused(defect.to_string()))?;
        model.findings.add(FindingKind::AreaLightAsPoint, &name, usize::from(!light.extent.is_point()));
        if let Some(entry) = &entry.detail {
            let detail = own_detail_of(entry).map_err(|message| refused(format!("detail: {message}")))?;
            own.insert(model.lights.len(), detail);
        }
        model.lights.push(light);
    }
    Ok(own)
}

/// The light, in the file's own axes, and its extent. A size of zero is that of a point.
fn light_of(entry: &LightEntry, up: UpAxis, north: f64) -> Result<(LightSource, Extent), String> {
    let (source, extent) = match (&entry.sun, &entry.point, &entry.rectangle) {
        (Some(sun), None, None) => {
            let diameter = size(sun.angular_diameter, "angular_diameter")?;
            let extent = if diameter > 0.0 { Extent::Disk { angular_diameter: diameter } } else { Extent::Point };
            (LightSource::sun(direction_of(sun, up, north)?), extent)
        }
        (None, Some(point), None) => {
            let radius = size(point.radius, "radius")?;
            let extent = if radius > 0.0 { Extent::Sphere { radius } } else { Extent::Point };
            (LightSource::point(point.position), extent)
        }
        (None, None, Some(rectangle)) => {
            let [u, v] = [rectangle.u, rectangle.v].map(DVec3::from_array);
            (LightSource::point(rectangle.center), Extent::Rectangle { u, v })
        }
        _ => return Err("give exactly one of sun, point, rectangle".to_owned()),
    };
    Ok((source.map_err(|defect| defect.to_string())?, extent))
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
