//! The scene file as written: every key that may stand in it, and no other.

use serde::Deserialize;
use umbriel_geometry::Analytic;

use super::{
    exact::exactly,
    tables::{Placed, Table, Word},
};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    pub(super) up: Option<Word<Up>>,
    pub(super) north: Option<f64>,
    pub(super) sides: Option<Word<SidesName>>,
    #[serde(default)]
    pub(super) object: Vec<Placed<ObjectEntry>>,
    #[serde(default)]
    pub(super) light: Vec<Placed<LightEntry>>,
    pub(super) camera: Option<Placed<CameraEntry>>,
    pub(super) detail: Option<Placed<DetailEntry>>,
    #[serde(default)]
    pub(super) cell: Vec<Placed<CellEntry>>,
    #[serde(default)]
    pub(super) portal: Vec<Placed<PortalEntry>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CellEntry {
    pub(super) name: Option<String>,
    #[serde(default, deserialize_with = "exactly")]
    pub(super) points: Option<Vec<[f64; 3]>>,
    #[serde(rename = "box")]
    #[serde(default, deserialize_with = "exactly")]
    pub(super) cuboid: Option<[[f64; 3]; 2]>,
    #[serde(default, deserialize_with = "exactly")]
    pub(super) planes: Option<Vec<[f64; 4]>>,
    pub(super) mesh: Option<String>,
    pub(super) node: Option<String>,
    pub(super) outdoors: Option<bool>,
    pub(super) rounding: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PortalEntry {
    pub(super) name: Option<String>,
    #[serde(deserialize_with = "exactly")]
    pub(super) cells: [String; 2],
    #[serde(deserialize_with = "exactly")]
    pub(super) corners: Vec<[f64; 3]>,
    pub(super) rounding: Option<f64>,
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
    pub(super) sides: Option<Word<SidesName>>,
    pub(super) detail: Option<Table<DetailEntry>>,
    #[serde(default, deserialize_with = "exactly")]
    pub(super) translation: Option<[f64; 3]>,
    #[serde(default, deserialize_with = "exactly")]
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<Scale>,
    #[serde(default, deserialize_with = "exactly")]
    pub(super) matrix: Option<[f64; 16]>,

    pub(super) mesh: Option<String>,
    pub(super) node: Option<String>,
    pub(super) rectangle: Option<Table<RectangleEntry>>,
    #[serde(rename = "box")]
    pub(super) cuboid: Option<Table<BoxEntry>>,
    pub(super) convex: Option<Table<ConvexEntry>>,
    pub(super) sphere: Option<Table<RadiusEntry>>,
    pub(super) disk: Option<Table<RadiusEntry>>,
    pub(super) ellipsoid: Option<Table<EllipsoidEntry>>,
    pub(super) cylinder: Option<Table<TurnedEntry>>,
    pub(super) cone: Option<Table<TurnedEntry>>,
    pub(super) capsule: Option<Table<TurnedEntry>>,
    pub(super) paraboloid: Option<Table<TurnedEntry>>,
    pub(super) frustum: Option<Table<FrustumEntry>>,
    pub(super) hyperboloid: Option<Table<HyperboloidEntry>>,
    pub(super) quadric: Option<Table<QuadricEntry>>,
    pub(super) boxes: Option<Vec<Table<PartBoxEntry>>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartBoxEntry {
    #[serde(deserialize_with = "exactly")]
    pub(super) center: [f64; 3],
    #[serde(deserialize_with = "exactly")]
    pub(super) half: [[f64; 3]; 3],
}

impl ObjectEntry {
    /// The analytic bodies that are given.
    pub(super) fn analytic(&self) -> impl Iterator<Item = Analytic> + '_ {
        let turned = |entry: &Option<Table<TurnedEntry>>| entry.as_ref().map(|body| (body.radius, body.height));
        [
            self.sphere.as_ref().map(|body| Analytic::Sphere { radius: body.radius }),
            self.disk.as_ref().map(|body| Analytic::Disk { radius: body.radius }),
            self.ellipsoid.as_ref().map(|body| Analytic::Ellipsoid { radii: body.radii }),
            turned(&self.cylinder).map(|(radius, height)| Analytic::Cylinder { radius, height }),
            turned(&self.cone).map(|(radius, height)| Analytic::Cone { radius, height }),
            turned(&self.capsule).map(|(radius, height)| Analytic::Capsule { radius, height }),
            turned(&self.paraboloid).map(|(radius, height)| Analytic::Paraboloid { radius, height }),
            self.frustum.as_deref().map(|&FrustumEntry { bottom_radius, top_radius, height }| Analytic::Frustum {
                bottom_radius,
                top_radius,
                height,
            }),
            self.hyperboloid.as_deref().map(|&HyperboloidEntry { waist_radius, end_radius, height }| {
                Analytic::Hyperboloid { waist_radius, end_radius, height }
            }),
            self.quadric.as_ref().map(|body| Analytic::Quadric { matrix: body.rows(), within: body.within }),
        ]
        .into_iter()
        .flatten()
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
    #[serde(deserialize_with = "exactly")]
    pub(super) size: [f64; 2],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxEntry {
    #[serde(deserialize_with = "exactly")]
    pub(super) size: [f64; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RadiusEntry {
    pub(super) radius: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EllipsoidEntry {
    #[serde(deserialize_with = "exactly")]
    pub(super) radii: [f64; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TurnedEntry {
    pub(super) radius: f64,
    pub(super) height: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FrustumEntry {
    pub(super) bottom_radius: f64,
    pub(super) top_radius: f64,
    pub(super) height: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HyperboloidEntry {
    pub(super) waist_radius: f64,
    pub(super) end_radius: f64,
    pub(super) height: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ConvexEntry {
    #[serde(deserialize_with = "exactly")]
    pub(super) points: Vec<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct QuadricEntry {
    #[serde(deserialize_with = "exactly")]
    pub(super) matrix: [f64; 16],
    #[serde(deserialize_with = "exactly")]
    pub(super) within: [[f64; 3]; 2],
}

impl QuadricEntry {
    /// The matrix; the file has it row by row.
    fn rows(&self) -> [[f64; 4]; 4] {
        std::array::from_fn(|row| std::array::from_fn(|column| self.matrix[4 * row + column]))
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightEntry {
    pub(super) name: Option<String>,
    pub(super) sun: Option<Table<SunEntry>>,
    pub(super) point: Option<Table<PointEntry>>,
    pub(super) rectangle: Option<Table<AreaEntry>>,
    pub(super) detail: Option<Table<DetailEntry>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SunEntry {
    #[serde(default, deserialize_with = "exactly")]
    pub(super) direction: Option<[f64; 3]>,
    pub(super) azimuth: Option<f64>,
    pub(super) elevation: Option<f64>,
    pub(super) angular_diameter: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PointEntry {
    #[serde(deserialize_with = "exactly")]
    pub(super) position: [f64; 3],
    pub(super) radius: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AreaEntry {
    #[serde(deserialize_with = "exactly")]
    pub(super) center: [f64; 3],
    #[serde(deserialize_with = "exactly")]
    pub(super) u: [f64; 3],
    #[serde(deserialize_with = "exactly")]
    pub(super) v: [f64; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraEntry {
    #[serde(deserialize_with = "exactly")]
    pub(super) eye: [f64; 3],
    #[serde(deserialize_with = "exactly")]
    pub(super) target: [f64; 3],
    #[serde(default, deserialize_with = "exactly")]
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
    pub(super) time: Option<f64>,
    pub(super) memory: Option<u64>,
    pub(super) pixel_rows: Option<u32>,
}
