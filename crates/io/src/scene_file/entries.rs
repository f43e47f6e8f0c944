//! The scene file as written: every key that may stand in it, and no other.

use serde::Deserialize;
use toml::{Spanned, Value};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    pub(super) up: Option<Up>,
    pub(super) north: Option<f64>,
    pub(super) sides: Option<SidesName>,
    #[serde(default)]
    pub(super) object: Vec<Spanned<ObjectEntry>>,
    #[serde(default)]
    pub(super) light: Vec<Spanned<LightEntry>>,
    pub(super) camera: Option<Spanned<CameraEntry>>,
    pub(super) detail: Option<Spanned<DetailEntry>>,
    #[serde(default)]
    pub(super) cell: Vec<Spanned<Value>>,
    #[serde(default)]
    pub(super) portal: Vec<Spanned<Value>>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Up {
    Y,
    Z,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum SidesName {
    Auto,
    One,
    Two,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectEntry {
    pub(super) name: Option<String>,
    pub(super) sides: Option<SidesName>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<Scale>,
    pub(super) matrix: Option<[f64; 16]>,

    pub(super) mesh: Option<String>,
    pub(super) node: Option<String>,
    pub(super) rectangle: Option<RectangleEntry>,
    #[serde(rename = "box")]
    pub(super) cuboid: Option<BoxEntry>,
    pub(super) sphere: Option<SphereEntry>,

    // Bodies of the format that are not read yet; kept apart from keys that nobody knows.
    pub(super) ellipsoid: Option<Value>,
    pub(super) cylinder: Option<Value>,
    pub(super) cone: Option<Value>,
    pub(super) frustum: Option<Value>,
    pub(super) capsule: Option<Value>,
    pub(super) paraboloid: Option<Value>,
    pub(super) hyperboloid: Option<Value>,
    pub(super) disk: Option<Value>,
    pub(super) convex: Option<Value>,
    pub(super) quadric: Option<Value>,
}

impl ObjectEntry {
    /// The body that is not read yet, if one is given.
    pub(super) fn unread_body(&self) -> Option<&'static str> {
        let bodies = [
            ("ellipsoid", &self.ellipsoid),
            ("cylinder", &self.cylinder),
            ("cone", &self.cone),
            ("frustum", &self.frustum),
            ("capsule", &self.capsule),
            ("paraboloid", &self.paraboloid),
            ("hyperboloid", &self.hyperboloid),
            ("disk", &self.disk),
            ("convex", &self.convex),
            ("quadric", &self.quadric),
        ];
        bodies.into_iter().find(|(_, value)| value.is_some()).map(|(name, _)| name)
    }
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "scale must be a number or three numbers")]
pub(super) enum Scale {
    Uniform(f64),
    Each([f64; 3]),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RectangleEntry {
    pub(super) size: [f64; 2],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxEntry {
    pub(super) size: [f64; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereEntry {
    pub(super) radius: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightEntry {
    pub(super) name: Option<String>,
    pub(super) sun: Option<SunEntry>,
    pub(super) point: Option<PointEntry>,
    pub(super) rectangle: Option<AreaEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SunEntry {
    pub(super) direction: Option<[f64; 3]>,
    pub(super) azimuth: Option<f64>,
    pub(super) elevation: Option<f64>,
    pub(super) angular_diameter: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PointEntry {
    pub(super) position: [f64; 3],
    pub(super) radius: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AreaEntry {
    pub(super) center: [f64; 3],
    pub(super) u: [f64; 3],
    pub(super) v: [f64; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraEntry {
    pub(super) eye: [f64; 3],
    pub(super) target: [f64; 3],
    pub(super) up: Option<[f64; 3]>,
    pub(super) vertical_degrees: Option<f64>,
    pub(super) height: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DetailEntry {
    pub(super) interior_depth: Option<u8>,
    pub(super) boundary_depth: Option<u8>,
    pub(super) cell: Option<f64>,
    pub(super) max_undecided: Option<f64>,
}
