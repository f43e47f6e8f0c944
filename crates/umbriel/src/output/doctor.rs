//! A diagnosis for people, and as JSON: names and order of the fields are a contract.

use std::fmt::Write;

use serde::Serialize;
use umbriel_scene::{Finding, Scene};
use umbriel_shadow::doctor::{Defect, Diagnosis, Note, Place, Total};

use super::{findings, table::number};

const SCHEMA: u32 = 1;

/// How many places of one kind are told by name.
const NAMED: usize = 3;

/// Where lines are broken, columns.
const WIDTH: usize = 100;

/// The readable form: one block a kind, the largest area first.
pub(crate) fn text(scene: &Scene, diagnosis: &Diagnosis) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = heading(&mut text, diagnosis);
    diagnosis.totals().iter().for_each(|total| {
        let _ = block(&mut text, scene, total);
    });
    let read = findings::lines(&scene.findings);
    if !read.is_empty() {
        text.push_str("\nwhile reading\n");
        read.iter().for_each(|line| text.push_str(&wrapped(line)));
    }
    if diagnosis.defects.is_empty() && read.is_empty() {
        text.push_str("nothing found that limits the answers\n");
    }
    text
}

fn heading(text: &mut String, diagnosis: &Diagnosis) -> std::fmt::Result {
    let Diagnosis { objects, faces, curved, area, .. } = diagnosis;
    write!(text, "{}, {} of {} m²", counted(*objects, "object"), counted(*faces, "flat face"), number(*area))?;
    if *curved > 0 {
        write!(text, "; {}, exact by definition", counted(*curved, "curved object"))?;
    }
    text.push('\n');
    Ok(())
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn block(text: &mut String, scene: &Scene, total: &Total) -> std::fmt::Result {
    let title = total.kind.name().replace('_', " ");
    write!(text, "\n{title:<26}{:>9}", total.count)?;
    if total.area > 0.0 {
        write!(text, "{:>14} m²{:>8} %", number(total.area), percent(total.share))?;
    }
    text.push('\n');
    text.push_str(&wrapped(total.kind.consequence()));
    let mut places: Vec<&str> = total.places.iter().take(NAMED).map(|&place| name(scene, place)).collect();
    let more = format!("{} more", total.places.len().saturating_sub(NAMED));
    if total.places.len() > NAMED {
        places.push(&more);
    }
    let note = total.note.map_or(String::new(), |note| format!("; {}", told(scene, note)));
    text.push_str(&wrapped(&format!("at: {}{note}", places.join(", "))));
    Ok(())
}

fn percent(share: f64) -> String {
    if share < 5e-5 { "< 0.01".to_owned() } else { format!("{:.2}", 100.0 * share) }
}

fn told(scene: &Scene, note: Note) -> String {
    match note {
        Note::Rounding(rounding) => format!("off by up to {} m", number(rounding)),
        Note::Depth(depth) => format!("from --boundary-depth {depth} on nearly all of it is divided"),
        Note::Body(object) => format!("inside {}", scene.objects[object].name),
        _ => "see the documentation".to_owned(),
    }
}

fn name(scene: &Scene, place: Place) -> &str {
    match place {
        Place::Object(object) => &scene.objects[object].name,
        Place::Light(light) => &scene.lights[light].name,
    }
}

/// Words in lines that are indented and not too long.
fn wrapped(words: &str) -> String {
    let mut text = String::new();
    let mut column = 0;
    for word in words.split_whitespace() {
        let length = word.chars().count();
        if column == 0 || column + 1 + length > WIDTH {
            text.push_str(if column == 0 { "  " } else { "\n  " });
            column = 2;
        } else {
            text.push(' ');
            column += 1;
        }
        text.push_str(word);
        column += length;
    }
    text.push('\n');
    text
}

/// The whole document.
#[derive(Debug, Serialize)]
pub(crate) struct Document<'a> {
    schema: u32,
    umbriel: &'static str,
    scene: SceneCounts,
    totals: Vec<TotalEntry>,
    findings: Vec<Entry<'a>>,
}

#[derive(Debug, Serialize)]
struct SceneCounts {
    objects: usize,
    curved: usize,
    faces: usize,
    area: f64,
    lights: usize,
}

#[derive(Debug, Serialize)]
struct TotalEntry {
    kind: &'static str,
    places: usize,
    count: usize,
    area: f64,
    share: f64,
    consequence: &'static str,
}

#[derive(Debug, Serialize)]
struct Entry<'a> {
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    object: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    light: Option<&'a str>,
    count: usize,
    area: Option<f64>,
    share: Option<f64>,
    consequence: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    rounding: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    boundary_depth: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    inside: Option<&'a str>,
}

impl<'a> Document<'a> {
    pub(crate) fn new(scene: &'a Scene, diagnosis: &Diagnosis) -> Self {
        let total = |total: Total| TotalEntry {
            kind: total.kind.name(),
            places: total.places.len(),
            count: total.count,
            area: total.area,
            share: total.share,
            consequence: total.kind.consequence(),
        };
        let found = diagnosis.defects.iter().map(|defect| Entry::of_defect(scene, defect));
        Self {
            schema: SCHEMA,
            umbriel: env!("CARGO_PKG_VERSION"),
            scene: SceneCounts {
                objects: diagnosis.objects,
                curved: diagnosis.curved,
                faces: diagnosis.faces,
                area: diagnosis.area,
                lights: scene.lights.len(),
            },
            totals: diagnosis.totals().into_iter().map(total).collect(),
            findings: found.chain(scene.findings.iter().map(Entry::of_finding)).collect(),
        }
    }

    pub(crate) fn to_text(&self) -> String {
        // Plain structs with string keys: serialising them has no way to fail.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

impl<'a> Entry<'a> {
    fn of_defect(scene: &'a Scene, defect: &Defect) -> Self {
        let name = name(scene, defect.place);
        let is_object = matches!(defect.place, Place::Object(_));
        let mut entry = Self {
            kind: defect.kind.name(),
            object: is_object.then_some(name),
            light: (!is_object).then_some(name),
            count: defect.count,
            area: Some(defect.area),
            share: Some(defect.share),
            consequence: defect.kind.consequence().to_owned(),
            rounding: None,
            boundary_depth: None,
            inside: None,
        };
        match defect.note {
            Some(Note::Rounding(rounding)) => entry.rounding = Some(rounding),
            Some(Note::Depth(depth)) => entry.boundary_depth = Some(depth),
            Some(Note::Body(object)) => entry.inside = Some(&scene.objects[object].name),
            _ => {}
        }
        entry
    }

    /// What the reader has found; it knows of no areas.
    fn of_finding(finding: &'a Finding) -> Self {
        Self {
            kind: finding.kind.name(),
            object: Some(&finding.subject),
            light: None,
            count: finding.count,
            area: None,
            share: None,
            consequence: findings::lines(std::slice::from_ref(finding)).concat(),
            rounding: None,
            boundary_depth: None,
            inside: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_between_words() {
        let text = wrapped(&"word ".repeat(50));
        assert!(text.lines().all(|line| line.starts_with("  word") && line.chars().count() <= WIDTH));
        assert_eq!(text.split_whitespace().count(), 50);
    }

    #[test]
    fn small_shares_are_not_none() {
        assert_eq!([0.0, 1e-6, 0.5, 1.0].map(percent), ["< 0.01", "< 0.01", "50.00", "100.00"]);
    }
}
