//! Findings in words.

use std::fmt::Write;

use umbriel_scene::{Finding, FindingKind};

/// How many subjects of one kind are told by name.
const NAMED: usize = 5;
/// How many places of a subject are told.
const PLACED: usize = 3;

/// What a kind of finding means to a user.
fn meaning(kind: FindingKind) -> &'static str {
    match kind {
        FindingKind::OpenEdges => "open edges: the surface has a border there, so it counts as two-sided",
        FindingKind::InconsistentWinding => "open edges among them between triangles that are wound differently",
        FindingKind::ZeroAreaFaces => "triangles without area",
        FindingKind::DuplicateFaces => "triangles that repeat another one",
        FindingKind::NoSurface => "bodies none of whose surface lies in the box that cuts them",
        FindingKind::NoInside => {
            "quadrics without an inside (a plane, a line or a point counted twice): they block, and have no surface to light"
        }
        FindingKind::EmptyScene => "the scene holds no triangle and no body: nothing casts or receives a shadow",
        FindingKind::MaskAsOpaque => "triangles of a MASK material, taken as opaque",
        FindingKind::BlendAsOpaque => {
            "triangles of a material that light passes through (BLEND, d, Tr, map_d), taken as opaque"
        }
        FindingKind::BlendIgnored => "triangles of a BLEND material, which block nothing",
        FindingKind::SpotAsPoint => "spot lights, taken as point lights",
        FindingKind::AreaLightAsPoint => "lights with an extent, taken as their centres",
        FindingKind::UnknownExtension => "extensions or unknown elements that are not read",
        FindingKind::NotTriangles => "points, lines or nodes without a size, which have no surface",
        FindingKind::Deformation => {
            "skins, taken at their bind pose where their first joint stands, or morph targets, at their default weights"
        }
        FindingKind::UnreadShape => {
            "shapes without a body here (endless planes, capsules of two radii, hulls of meshes)"
        }
        FindingKind::BrokenRule => "rules of the file's format that are broken; it is read all the same",
        FindingKind::UnevenRows => {
            "rows that are not a line each: what follows a number that lacks or is too many is not where it belongs"
        }
        FindingKind::MissingTexture => {
            "triangles of a MASK material without a texture that is read, whose alpha counts as one"
        }
        FindingKind::MissingMaterials => "material libraries that are not there",
        FindingKind::LooksZUp => "the model looks z-up; read it with --up z if its +Z is up",
        FindingKind::NonPlanarPolygons => "polygons whose corners lie in no plane, triangulated all the same",
        FindingKind::CrossingPolygons => {
            "polygons that cross themselves or are too long to cut: triangles of them lie on each other or are turned over"
        }
        FindingKind::DuplicateObjects => "objects that repeat another one in the same place",
        FindingKind::OverlappingCells => {
            "pairs of cells or of portals that overlap; what is in two cells belongs to both"
        }
        FindingKind::SunsBelowHorizon => "suns at or below the horizon, which give no light",
        FindingKind::SunsFromBelow => "suns whose light does not travel downward, taken as they are",
        FindingKind::CutShort => {
            "lights under which the scene takes more than the typical effort, so that cells stay coarser than depth 8; a detail (as --boundary-depth 8) lets it take what it takes"
        }
        FindingKind::Crowded => {
            "objects (under each light) whose faces have so much over them that only some of it was measured: what is undecided there stays so at any depth, and estimates lean to lit; --time 10s measures more"
        }
        _ => "see the documentation of this kind of finding",
    }
}

/// One line a kind: how often, what, and where (the first few by name).
pub(crate) fn lines(findings: &[Finding]) -> Vec<String> {
    let mut kinds: Vec<FindingKind> = findings.iter().map(|finding| finding.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds.into_iter().map(|kind| line(kind, findings)).collect()
}

fn line(kind: FindingKind, findings: &[Finding]) -> String {
    let of_kind = || findings.iter().filter(|finding| finding.kind == kind);
    let count: usize = of_kind().map(|finding| finding.count).sum();
    let subjects: Vec<String> = of_kind().map(subject).filter(|subject| !subject.is_empty()).collect();
    let mut line = match kind {
        FindingKind::LooksZUp | FindingKind::EmptyScene => meaning(kind).to_owned(),
        _ => format!("{count} {}", meaning(kind)),
    };
    if !subjects.is_empty() {
        let _ = write!(line, " ({}", subjects[..subjects.len().min(NAMED)].join("; "));
        if subjects.len() > NAMED {
            let _ = write!(line, " and {} more", subjects.len() - NAMED);
        }
        line.push(')');
    }
    line
}

/// What a finding is about, with its first places.
fn subject(finding: &Finding) -> String {
    let mut text = finding.subject.clone();
    if !finding.places.is_empty() {
        text.push_str(if text.is_empty() { "at " } else { " at " });
        text.push_str(&finding.places[..finding.places.len().min(PLACED)].join(", "));
        if finding.count > PLACED {
            text.push_str(", ...");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_told_once_with_its_count() {
        let finding =
            |kind, subject: String, count| Finding { kind, subject, count, places: vec!["face 7".to_owned()] };
        let mut findings: Vec<Finding> =
            (0..8).map(|i| finding(FindingKind::OpenEdges, format!("house{i}"), 3)).collect();
        findings.push(finding(FindingKind::LooksZUp, String::new(), 1));
        let lines = lines(&findings);
        assert_eq!(lines.len(), 2);
        assert!(
            lines[0].starts_with("24 open edges") && lines[0].ends_with("house4 at face 7 and 3 more)"),
            "{}",
            lines[0]
        );
        assert!(lines[1].contains("--up z"));
    }
}
