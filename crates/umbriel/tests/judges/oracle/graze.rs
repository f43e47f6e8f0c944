//! Segments that just touch curved bodies, in exact numbers.
//!
//! The bodies have sizes with whole-number points on them (Pythagorean pairs and quadruples), so that tangents, rulings,
//! rims and contacts are exact. A segment is x = p + α·d, L = p + β·d with p on the surface (or on an axis, at an apex, a
//! centre), d a tangent, a chord to another such point, an axis or a ruling, and short fractions α, β, zero among them.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use umbriel_geometry::{Analytic, LightSource, Placement};

use super::{body::placed, curved::Curved, dice::Dice, number::vector, solids::Solid};

/// A body with exact points of interest.
#[derive(Clone, Debug)]
pub(crate) struct Subject {
    /// Its name in complaints.
    pub(crate) name: &'static str,
    /// What it is.
    pub(crate) body: Analytic,
    /// Points on it, and normals there (not of unit length).
    pub(crate) touching: Vec<(DVec3, DVec3)>,
    /// Apexes, centres, points of axes and in planes of rims.
    pub(crate) special: Vec<DVec3>,
}

const CIRCLE: [[f64; 2]; 6] = [[3.0, 4.0], [-4.0, 3.0], [5.0, 0.0], [0.0, -5.0], [4.0, -3.0], [-3.0, -4.0]];

const SPHERE: [[f64; 3]; 7] = [
    [15.0, 0.0, 0.0],
    [0.0, -15.0, 0.0],
    [9.0, 12.0, 0.0],
    [5.0, -10.0, 10.0],
    [-2.0, 5.0, 14.0],
    [2.0, 10.0, -11.0],
    [-10.0, -11.0, 2.0],
];

impl Subject {
    /// What it is, for the oracle.
    pub(crate) fn solid(&self) -> Solid {
        Solid::new(&self.body)
    }
}

/// The body with all its lengths times `k`; a general quadric stays as it is.
pub(crate) fn scaled(body: Analytic, k: f64) -> Analytic {
    match body {
        Analytic::Sphere { radius } => Analytic::Sphere { radius: radius * k },
        Analytic::Ellipsoid { radii } => Analytic::Ellipsoid { radii: radii.map(|radius| radius * k) },
        Analytic::Cylinder { radius, height } => Analytic::Cylinder { radius: radius * k, height: height * k },
        Analytic::Cone { radius, height } => Analytic::Cone { radius: radius * k, height: height * k },
        Analytic::Frustum { bottom_radius, top_radius, height } => {
            Analytic::Frustum { bottom_radius: bottom_radius * k, top_radius: top_radius * k, height: height * k }
        }
        Analytic::Capsule { radius, height } => Analytic::Capsule { radius: radius * k, height: height * k },
        Analytic::Paraboloid { radius, height } => Analytic::Paraboloid { radius: radius * k, height: height * k },
        Analytic::Hyperboloid { waist_radius, end_radius, height } => {
            Analytic::Hyperboloid { waist_radius: waist_radius * k, end_radius: end_radius * k, height: height * k }
        }
        Analytic::Disk { radius } => Analytic::Disk { radius: radius * k },
        other => other,
    }
}

impl Subject {
    /// The body with all its lengths times `k`, rounded, and its points too: nothing touches exactly any more.
    pub(crate) fn scaled(&self, k: f64) -> Self {
        let touching = self.touching.iter().map(|&(p, normal)| (p * k, normal)).collect();
        let special = self.special.iter().map(|&p| p * k).collect();
        Self { name: self.name, body: scaled(self.body, k), touching, special }
    }
}

/// Half the gradient of the frustum's or cylinder's side: (x, ρ·(low − high)/h, z).
fn along_side(solid_low: f64, high: f64, height: f64, heights: &[f64]) -> Vec<(DVec3, DVec3)> {
    let mut found = Vec::new();
    for &y in heights {
        let share = y / height + 0.5;
        let radius = solid_low + (high - solid_low) * share;
        for [x, z] in CIRCLE {
            let point = DVec3::new(x / 5.0 * radius, y, z / 5.0 * radius);
            let normal = DVec3::new(x * height, 5.0 * (solid_low - high), z * height);
            found.push((point, normal));
        }
    }
    found
}

fn disk_points(y: f64, radius: f64) -> Vec<(DVec3, DVec3)> {
    let on_rim = CIRCLE.iter().map(|[x, z]| DVec3::new(x / 5.0 * radius, y, z / 5.0 * radius));
    let inside = [DVec3::new(0.0, y, 0.0), DVec3::new(radius / 2.0, y, radius / 4.0)];
    on_rim.chain(inside).map(|point| (point, DVec3::Y)).collect()
}

fn on_axis(height: f64) -> Vec<DVec3> {
    [0.0, 0.5, -0.5, 1.0, -1.0].map(|share| DVec3::new(0.0, share * height, 0.0)).to_vec()
}

fn ellipsoid(name: &'static str, radii: [f64; 3]) -> Subject {
    let stretch = DVec3::from_array(radii) / 15.0;
    let point = |p: [f64; 3]| (DVec3::from_array(p) * stretch, DVec3::from_array(p) / stretch);
    let is_sphere = radii.iter().all(|&radius| radius == radii[0]);
    let body = if is_sphere { Analytic::Sphere { radius: radii[0] } } else { Analytic::Ellipsoid { radii } };
    Subject { name, body, touching: SPHERE.map(point).to_vec(), special: on_axis(radii[1]) }
}

fn with_ends(name: &'static str, low: f64, high: f64, height: f64) -> Subject {
    let body = match (low, high) {
        (radius, 0.0) => Analytic::Cone { radius, height },
        (low, high) if low == high => Analytic::Cylinder { radius: low, height },
        (bottom_radius, top_radius) => Analytic::Frustum { bottom_radius, top_radius, height },
    };
    let half = height / 2.0;
    let mut touching = along_side(low, high, height, &[-half, 0.0, half / 2.0, half]);
    touching.extend(disk_points(-half, low));
    touching.extend(disk_points(half, high));
    Subject { name, body, touching, special: on_axis(height) }
}

fn capsule() -> Subject {
    let (radius, height) = (15.0, 12.0);
    let mut touching = along_side(radius, radius, height, &[-6.0, 0.0, 1.0, 6.0]);
    for p in SPHERE.map(DVec3::from_array) {
        touching.push((p + DVec3::new(0.0, 6.0_f64.copysign(p.y), 0.0), p));
    }
    Subject { name: "capsule", body: Analytic::Capsule { radius, height }, touching, special: on_axis(height) }
}

/// Radius 5, height 25: y = 12.5 − x² − z².
fn paraboloid() -> Subject {
    let mut touching = disk_points(-12.5, 5.0);
    for [x, z] in [[0.0, 0.0], [1.0, 0.0], [0.5, -2.0], [-3.0, 1.0], [3.0, 4.0], [-4.0, 3.0], [0.0, 5.0]] {
        touching.push((DVec3::new(x, 12.5 - x * x - z * z, z), DVec3::new(2.0 * x, 1.0, 2.0 * z)));
    }
    Subject {
        name: "paraboloid",
        body: Analytic::Paraboloid { radius: 5.0, height: 25.0 },
        touching,
        special: on_axis(25.0),
    }
}

/// Waist 3, ends 5, height 8: x² + z² = 9 + y². Its rulings join touching points.
fn hyperboloid() -> Subject {
    let mut touching = [disk_points(-4.0, 5.0), disk_points(4.0, 5.0)].concat();
    let points =
        [[3.0, 0.0, 0.0], [3.0, 1.0, 1.0], [3.0, -1.0, 1.0], [3.0, 2.0, 2.0], [2.0, 2.0, -3.0], [0.0, 0.0, -3.0]];
    let ends =
        [[3.0, 4.0, 4.0], [3.0, 4.0, -4.0], [3.0, -4.0, 4.0], [-3.0, 4.0, -4.0], [5.0, -4.0, 0.0], [4.0, 4.0, -3.0]];
    for p in points.into_iter().chain(ends) {
        touching.push((DVec3::from_array(p), DVec3::new(p[0], -p[1], p[2])));
    }
    Subject {
        name: "hyperboloid",
        body: Analytic::Hyperboloid { waist_radius: 3.0, end_radius: 5.0, height: 8.0 },
        touching,
        special: on_axis(8.0),
    }
}

fn disk() -> Subject {
    Subject {
        name: "disk",
        body: Analytic::Disk { radius: 5.0 },
        touching: disk_points(0.0, 5.0),
        special: on_axis(2.0),
    }
}

/// A quadric q = p·D·p + 2·m·p + d with points of the box where q has the sign that puts them on the surface.
fn quadric(name: &'static str, matrix: [[f64; 4]; 4], half: [f64; 3]) -> Subject {
    let value = |p: DVec3| {
        let x = [p.x, p.y, p.z, 1.0];
        (0..4).map(|i| (0..4).map(|j| x[i] * matrix[i][j] * x[j]).sum::<f64>()).sum::<f64>()
    };
    let gradient = |p: DVec3| {
        let x = [p.x, p.y, p.z, 1.0];
        DVec3::from_array(std::array::from_fn(|i| (0..4).map(|j| (matrix[i][j] + matrix[j][i]) * x[j]).sum::<f64>()))
    };
    let half = DVec3::from_array(half);
    let mut touching = Vec::new();
    let reach = |k: usize| -(half[k] as i32)..=half[k] as i32;
    for (x, y, z) in reach(0).flat_map(|x| reach(1).flat_map(move |y| reach(2).map(move |z| (x, y, z)))) {
        let p = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
        if value(p) == 0.0 {
            touching.push((p, gradient(p)));
        }
        let on_face = (0..3).find(|&k| p[k].abs() == half[k]);
        if let Some(axis) = on_face.filter(|_| value(p) <= 0.0 && (x + 2 * y + 3 * z) % 4 == 0) {
            touching.push((p, DVec3::AXES[axis]));
        }
    }
    let body = Analytic::Quadric { matrix, within: [(-half).to_array(), half.to_array()] };
    Subject { name, body, touching, special: on_axis(half.y) }
}

/// All bodies that segments are aimed at.
pub(crate) fn subjects() -> Vec<Subject> {
    let of_diagonal = |a: f64, b: f64, c: f64, m: f64, d: f64| {
        [[a, 0.0, 0.0, 0.0], [0.0, b, 0.0, m], [0.0, 0.0, c, 0.0], [0.0, m, 0.0, d]]
    };
    // Not symmetric, with all terms: (x + y)² + 2z² + 3xz − y − 4.
    let skew = [[1.0, 2.0, 3.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0], [0.0, -1.0, 0.0, -4.0]];
    vec![
        ellipsoid("sphere", [15.0; 3]),
        ellipsoid("ellipsoid", [15.0, 30.0, 7.5]),
        with_ends("cylinder", 5.0, 5.0, 8.0),
        with_ends("cone", 5.0, 0.0, 8.0),
        with_ends("frustum", 10.0, 5.0, 8.0),
        with_ends("cup", 5.0, 10.0, 4.0),
        capsule(),
        paraboloid(),
        hyperboloid(),
        disk(),
        quadric("cut cylinder", of_diagonal(1.0, 0.0, 1.0, 0.0, -25.0), [4.0, 3.0, 6.0]),
        quadric("double cone", of_diagonal(1.0, -1.0, 1.0, 0.0, 0.0), [5.0, 5.0, 5.0]),
        quadric("two sheets", of_diagonal(1.0, -1.0, 1.0, 0.0, 9.0), [4.0, 5.0, 4.0]),
        quadric("saddle", of_diagonal(1.0, 0.0, -1.0, -0.5, 0.0), [3.0, 4.0, 3.0]),
        quadric("crossed planes", of_diagonal(1.0, 0.0, -1.0, 0.0, 0.0), [2.0, 3.0, 4.0]),
        quadric("slab", of_diagonal(0.0, 1.0, 0.0, 0.0, -4.0), [3.0, 5.0, 2.0]),
        quadric("sheet", of_diagonal(1.0, 0.0, 0.0, 0.0, 0.0), [2.0, 2.0, 2.0]),
        quadric("outside of a ball", of_diagonal(-1.0, -1.0, -1.0, 0.0, 9.0), [3.0, 4.0, 3.0]),
        quadric("skew", skew, [3.0, 3.0, 3.0]),
    ]
}

/// A segment in the world: its start and its light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    /// The start.
    pub(crate) x: [f64; 3],
    /// The end.
    pub(crate) light: LightSource,
}

/// A placed subject.
#[derive(Clone, Debug)]
pub(crate) struct Target {
    /// Where it stands.
    pub(crate) placement: Placement,
    /// The oracle's body.
    pub(crate) curved: Curved,
}

impl Target {
    /// The subject under a map.
    pub(crate) fn new(subject: &Subject, map: DAffine3) -> Self {
        let placement = Placement::new(map).expect("a regular matrix");
        let solid = subject.solid();
        let curved = placed(&solid, &placement, solid.is_closed());
        Self { placement, curved }
    }

    /// The image of a segment, its ends rounded to the nearest floats.
    pub(crate) fn carried(&self, local: &LocalSegment) -> Segment {
        let (x, end) = self.ends(local);
        Segment { x, light: light(end, local.is_sun).expect("an accepted light") }
    }

    /// The image's start, and the light's position or its direction.
    fn ends(&self, local: &LocalSegment) -> ([f64; 3], [f64; 3]) {
        let start = self.image(local.x);
        let end = if local.is_sun { self.turned(local.x - local.towards) } else { self.image(local.towards) };
        (start, end)
    }

    /// The nearest floats of the exact image.
    fn image(&self, local: DVec3) -> [f64; 3] {
        let at = super::blocking::Place::new(vector(local.to_array()));
        self.curved.image(&at).rational.map(|coordinate| coordinate.to_nearest() + 0.0)
    }

    /// The nearest floats of the exact image of a vector.
    fn turned(&self, local: DVec3) -> [f64; 3] {
        let vector = vector(local.to_array());
        std::array::from_fn(|i| super::number::dot(&self.curved.rows[i], &vector).to_nearest() + 0.0)
    }
}

/// Placements that keep short numbers exact, and some that do not.
pub(crate) fn maps() -> Vec<DAffine3> {
    let linear = |columns: [[f64; 3]; 3]| DMat3::from_cols_array_2d(&columns);
    let only = |matrix3: DMat3| DAffine3 { matrix3, translation: DVec3::new(0.5, -3.0, 7.0) };
    let shear = linear([[1.0, 0.5, 0.0], [0.25, 1.0, 0.0], [0.0, -0.5, 1.5]]);
    let turn = DQuat::from_xyzw(0.5, 0.1, -0.7, 0.5).normalize();
    let far = DVec3::new(1e6, -2_500_000.25, 333_333.5);
    vec![
        DAffine3::IDENTITY,
        DAffine3::from_translation(far),
        only(shear),
        only(linear([[0.0, 2.0, 0.0], [0.0, 0.0, -0.25], [4.0, 0.0, 0.0]])),
        DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
        DAffine3 { matrix3: shear * -2f64.powi(-40), translation: DVec3::splat(2f64.powi(-38)) },
        DAffine3::from_scale(DVec3::splat(2f64.powi(40))),
        only(linear([[3.0, 4.0, 0.0], [-4.0, 3.0, 0.0], [0.0, 0.0, 5.0]])),
        DAffine3::from_rotation_translation(turn, DVec3::new(0.1, 0.2, 0.3)),
        DAffine3::from_rotation_translation(turn, far),
        DAffine3::from_scale_rotation_translation(DVec3::new(0.1, 3.7, -1.3), turn, DVec3::ZERO),
        DAffine3 { matrix3: linear([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 10.0]]), translation: far },
    ]
}

/// A segment in local coordinates: its start, a point of its way, and whether it goes on for ever.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalSegment {
    x: DVec3,
    towards: DVec3,
    is_sun: bool,
}

/// A segment that was aimed at a feature, or any segment; its ends differ.
pub(crate) fn segment(subject: &Subject, target: &Target, dice: &mut Dice) -> Segment {
    loop {
        let local = if dice.one_in(4) { any_segment(subject, dice) } else { aimed(subject, dice) };
        let (mut start, mut end) = target.ends(&local);
        if dice.one_in(3) {
            start = start.map(|coordinate| dice.nudged(coordinate));
            end = end.map(|coordinate| dice.nudged(coordinate));
        }
        let is_empty = !local.is_sun && start == end;
        if let Some(light) = light(end, local.is_sun).filter(|_| !is_empty) {
            return Segment { x: start, light };
        }
    }
}

/// A segment that was aimed at a feature, with short numbers, and not empty.
pub(crate) fn short_segment(subject: &Subject, dice: &mut Dice) -> LocalSegment {
    loop {
        let local = aimed(subject, dice);
        if local.x != local.towards {
            return local;
        }
    }
}

/// A light for the world point x: beyond a feature, at it, along an axis or a normal, or anywhere; at times an ulp off.
pub(crate) fn aimed_light(subject: &Subject, target: &Target, x: [f64; 3], dice: &mut Dice) -> LightSource {
    loop {
        let (p, normal) = subject.touching[dice.index(subject.touching.len())];
        let feature = match dice.below(4) {
            0 => target.image(dice.pick(&subject.special)),
            1 => target.image(p + normal * dice.pick(&[0.5, -0.5, 2.0])),
            _ => target.image(p),
        };
        let is_sun = dice.one_in(3);
        let reach = dice.pick(&[1.0, 0.5, 1.5, 2.0, 4.0]);
        let mut end: [f64; 3] = match (is_sun, dice.below(5)) {
            (true, 0) => target.turned(dice.pick(&DVec3::AXES) * dice.pick(&[1.0, -1.0])),
            (true, _) => std::array::from_fn(|i| x[i] - feature[i]),
            (false, 0) => target.image(DVec3::from_array(std::array::from_fn(|_| dice.float(-20.0, 20.0)))),
            (false, _) => std::array::from_fn(|i| x[i] + reach * (feature[i] - x[i])),
        };
        if dice.one_in(3) {
            end = end.map(|coordinate| dice.nudged(coordinate));
        }
        if let Some(light) = light(end, is_sun) {
            return light;
        }
    }
}

fn light(end: [f64; 3], is_sun: bool) -> Option<LightSource> {
    if is_sun { LightSource::sun(end).ok() } else { LightSource::point(end).ok() }
}

fn any_segment(subject: &Subject, dice: &mut Dice) -> LocalSegment {
    let any = |dice: &mut Dice| DVec3::from_array(std::array::from_fn(|_| dice.float(-20.0, 20.0)));
    let (x, is_sun) = (any(dice), dice.one_in(3));
    let towards = if dice.one_in(2) { any(dice) } else { subject.touching[dice.index(subject.touching.len())].0 };
    LocalSegment { x, towards, is_sun }
}

fn aimed(subject: &Subject, dice: &mut Dice) -> LocalSegment {
    let (p, normal) = subject.touching[dice.index(subject.touching.len())];
    let (q, _) = subject.touching[dice.index(subject.touching.len())];
    let along = match dice.below(6) {
        0 | 1 => normal.cross(DVec3::from_array(dice.grid_point(2, 1.0))),
        2 | 3 => q - p,
        4 => dice.pick(&subject.special) - p,
        _ => dice.pick(&DVec3::AXES) * dice.pick(&[1.0, -1.0]),
    };
    let base = if dice.one_in(6) { dice.pick(&subject.special) } else { p };
    let step = dice.pick(&[0.0, -1.0, -0.5, -2.0, 0.5, 1.0, -0.25]);
    let reach = dice.pick(&[0.0, 1.0, 0.5, 2.0, 3.0, 0.25, 1.0]);
    LocalSegment { x: base + along * step, towards: base + along * reach, is_sun: dice.one_in(3) }
}
