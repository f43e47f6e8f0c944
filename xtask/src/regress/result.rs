//! What is stored of a result, and how two of them differ.

use serde::{Deserialize, Serialize};
use umbriel_io::surface_findings;
use umbriel_scene::Scene;
use umbriel_shadow::{Cell, ObjectReport, Report, Verdict};

/// A scene under all its lights.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneResult {
    lights: Vec<LightResult>,
    findings: Vec<String>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LightResult {
    name: String,
    objects: Vec<ObjectResult>,
}

/// An object under a light. Floats are written with all their digits.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectResult {
    name: String,
    area: f64,
    lower: f64,
    upper: f64,
    estimate: f64,
    cells: Counts,
    /// FNV-1a, 64 bits, over face, corner, level, i, j (little endian) and verdict of every stored cell.
    hash: String,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Counts {
    lit: usize,
    shadowed: usize,
    undecided: usize,
}

impl SceneResult {
    pub(super) fn of(scene: &Scene, report: &Report) -> Self {
        let lights = report.lights.iter().map(|light| LightResult {
            name: scene.lights[light.light].name.clone(),
            objects: light.objects.iter().map(|object| ObjectResult::of(scene, object)).collect(),
        });
        let mut findings = scene.findings.clone();
        findings.extend(surface_findings(scene));
        let told =
            findings.iter().map(|finding| format!("{} {} {}", finding.kind.name(), finding.subject, finding.count));
        Self { lights: lights.collect(), findings: told.collect() }
    }

    /// What differs from a stored result, a line each.
    pub(super) fn differences(&self, stored: &Self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.findings != stored.findings {
            lines.push(format!("findings: {:?}, stored {:?}", self.findings, stored.findings));
        }
        let names = |result: &Self| result.lights.iter().map(|light| light.name.clone()).collect::<Vec<_>>();
        if names(self) != names(stored) {
            lines.push(format!("lights: {:?}, stored {:?}", names(self), names(stored)));
            return lines;
        }
        for (light, stored) in self.lights.iter().zip(&stored.lights) {
            light.add_differences(stored, &mut lines);
        }
        lines
    }
}

impl LightResult {
    fn add_differences(&self, stored: &Self, lines: &mut Vec<String>) {
        for object in &self.objects {
            match stored.objects.iter().find(|other| other.name == object.name) {
                None => lines.push(format!("{}, {}: new", self.name, object.name)),
                Some(other) if other != object => {
                    lines.push(format!("{}, {}: {}", self.name, object.name, object.changes(other).join("; ")));
                }
                Some(_) => {}
            }
        }
        let is_gone = |other: &&ObjectResult| self.objects.iter().all(|object| object.name != other.name);
        lines.extend(stored.objects.iter().filter(is_gone).map(|other| format!("{}, {}: gone", self.name, other.name)));
    }
}

impl ObjectResult {
    fn of(scene: &Scene, object: &ObjectReport) -> Self {
        let mut cells = Counts::default();
        for cell in &object.cells {
            match cell.verdict {
                Verdict::Lit => cells.lit += 1,
                Verdict::Shadowed => cells.shadowed += 1,
                Verdict::Undecided => cells.undecided += 1,
            }
        }
        Self {
            name: scene.objects[object.object].name.clone(),
            area: object.area,
            lower: object.lit.lower,
            upper: object.lit.upper,
            estimate: object.lit.estimate,
            cells,
            hash: format!("{:016x}", hash(&object.cells)),
        }
    }

    fn changes(&self, stored: &Self) -> Vec<String> {
        let numbers = [
            ("area", self.area, stored.area),
            ("lower", self.lower, stored.lower),
            ("upper", self.upper, stored.upper),
            ("estimate", self.estimate, stored.estimate),
        ];
        let differing = numbers.into_iter().filter(|(_, new, old)| new != old);
        let mut changes: Vec<String> =
            differing.map(|(name, new, old)| format!("{name} {new}, stored {old} ({:+.3e})", new - old)).collect();
        if self.cells != stored.cells {
            changes.push(format!("cells {:?}, stored {:?}", self.cells, stored.cells));
        } else if self.hash != stored.hash {
            changes.push("as many cells of each verdict, but other ones".to_owned());
        }
        changes
    }
}

fn hash(cells: &[Cell]) -> u64 {
    let words = |cell: &Cell| [cell.face, u32::from(cell.corner), u32::from(cell.level), cell.i, cell.j];
    let bytes = cells.iter().flat_map(|cell| {
        words(cell)
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .chain(std::iter::once(cell.verdict as u8))
            .collect::<Vec<u8>>()
    });
    fnv1a(bytes)
}

/// Fowler, Noll & Vo's hash, variant 1a, 64 bits.
fn fnv1a(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result(lower: f64) -> SceneResult {
        let cells = Counts { lit: 3, shadowed: 2, undecided: 1 };
        let object = ObjectResult {
            name: "floor".into(),
            area: 4.0,
            lower,
            upper: 3.0,
            estimate: 2.75,
            cells,
            hash: "0".into(),
        };
        SceneResult { lights: vec![LightResult { name: "sun".into(), objects: vec![object] }], findings: Vec::new() }
    }

    #[test]
    fn the_hash_is_the_published_one() {
        assert_eq!(fnv1a([]), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(*b"foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn differences_name_light_object_and_number() {
        assert!(result(2.5).differences(&result(2.5)).is_empty());
        let [line] = &result(2.5).differences(&result(2.0))[..] else { panic!("one line") };
        assert_eq!(line, "sun, floor: lower 2.5, stored 2 (+5.000e-1)");
    }

    #[test]
    fn all_digits_survive_storing() {
        let exact = result(0.1 + 0.2);
        let text = serde_json::to_string(&exact).expect("text");
        assert_eq!(serde_json::from_str::<SceneResult>(&text).expect("a result"), exact);
    }
}
