//! What cells, portals and cameras leave of a scene: receivers that get an answer, objects that a picture is drawn from.

use std::fmt::Write;

use umbriel_scene::{Camera, CellGraph, Region, Scene};
use umbriel_shadow::reached_receivers;
use umbriel_visibility::{
    View,
    portals::{Reach, Start, reach_of_eye},
};

use crate::{
    cli::{Failure, plan, render_args},
    output,
};

/// The camera whose sight chooses receivers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum VisibleFrom {
    /// The scene's own.
    Scene,
    Typed(Camera),
}

/// As typed: `scene`, or eye, target and if you like the field of view.
pub(crate) fn visible_from(text: &str) -> Result<VisibleFrom, String> {
    if text == "scene" { Ok(VisibleFrom::Scene) } else { render_args::camera(text).map(VisibleFrom::Typed) }
}

/// The camera that is meant; `option` is what asked for it.
pub(crate) fn camera(scene: &Scene, eye: VisibleFrom, option: &str) -> Result<Camera, Failure> {
    let camera = match eye {
        VisibleFrom::Typed(camera) => Some(camera),
        VisibleFrom::Scene => scene.camera,
    };
    camera.ok_or_else(|| Failure::Refused(format!("{option}: the scene has no camera")))
}

/// The form of the picture that a camera's sight is taken from: that of `render` where no size is given.
const ASPECT: [u32; 2] = [3, 2];

/// The receivers: those whose names match, else those that the lights may reach; of these what the camera may see.
pub(crate) fn choose_receivers(
    scene: &Scene,
    patterns: &[String],
    lights: &[usize],
    eye: Option<VisibleFrom>,
    quiet: bool,
) -> Result<Vec<usize>, Failure> {
    let mut receivers = plan::choose_receivers(scene, patterns)?;
    let all = receivers.len();
    if patterns.is_empty() && !scene.cells.is_empty() {
        receivers = reached_receivers(scene, lights);
        if !quiet {
            let dark = all - receivers.len();
            output::tell(&format!("note: no light reaches {dark} of {all} objects through portals; they are left out"));
        }
    }
    if let Some(eye) = eye {
        let camera = camera(scene, eye, "--visible-from scene")?;
        let reach = reach(scene, &View { camera, width: ASPECT[0], height: ASPECT[1] })?;
        let seen: Vec<usize> = reach.indices().collect();
        receivers.retain(|receiver| seen.binary_search(receiver).is_ok());
        if !quiet {
            output::tell(&format!("note: the camera may see {} of the receivers; {}", receivers.len(), told(&reach)));
        }
    }
    // A scene without a surface was told as such.
    if receivers.is_empty() && !scene.objects.is_empty() {
        return Err(Failure::Refused("no light reaches any of the receivers that were asked for".to_owned()));
    }
    Ok(receivers)
}

/// The objects that a picture is drawn from: all, or in a scene with cells what the eye may reach.
pub(crate) fn submitted(scene: &Scene, view: &View, quiet: bool) -> Result<Vec<usize>, Failure> {
    if scene.cells.is_empty() {
        return Ok((0..scene.objects.len()).collect());
    }
    let reach = reach(scene, view)?;
    if !quiet {
        let (some, all) = (reach.objects.len(), scene.objects.len());
        output::tell(&format!("note: {some} of {all} objects are drawn; {}", told(&reach)));
    }
    Ok(reach.indices().collect())
}

fn reach(scene: &Scene, view: &View) -> Result<Reach, Failure> {
    let unusable = || Failure::Unusable("the camera's eye or direction is not accepted".to_owned());
    reach_of_eye(scene, view).ok_or_else(unusable)
}

/// How a search went.
fn told(reach: &Reach) -> String {
    match reach.start {
        Start::Cells => format!("it sees {} cells through {} passages of portals", reach.cells.len(), reach.passages),
        Start::NoCells => "there are no cells, so what its frustum meets counts".to_owned(),
        Start::OutsideCells => "the eye is in no cell, so what its frustum meets counts".to_owned(),
        Start::Parallel => "a parallel view is in no cell, so what its frustum meets counts".to_owned(),
        _ => "the eye sees cells in too many ways, so what its frustum meets counts".to_owned(),
    }
}

/// How many cells are listed one by one.
const LISTED: usize = 50;

/// The graph of cells and portals, for people; nothing without cells.
pub(crate) fn graph_text(text: &mut String, graph: &CellGraph) -> std::fmt::Result {
    if graph.is_empty() {
        return Ok(());
    }
    let (cells, portals) = (graph.cells(), graph.portals());
    writeln!(text, "cells       {}, {} portals between them", cells.len(), portals.len())?;
    if graph.loose_objects() > 0 {
        writeln!(text, "  {} objects are in no cell: no portal leads to them", graph.loose_objects())?;
    }
    for (number, cell) in cells.iter().enumerate().take(LISTED) {
        let kind = match &cell.region {
            Region::Convex(body) => format!("{} faces", body.face_count()),
            _ => "outdoors".to_owned(),
        };
        let other = |portal: &u32| {
            let portal = &portals[*portal as usize];
            let other = portal.cells[usize::from(portal.cells[0] == number)];
            format!("{} by {}", cells[other].name, portal.name)
        };
        let ways: Vec<String> = graph.portals_of(number).iter().take(LISTED).map(other).collect();
        let more = if graph.portals_of(number).len() > LISTED { ", ..." } else { "" };
        let ways = if ways.is_empty() { "nowhere".to_owned() } else { ways.join(", ") };
        writeln!(text, "  {}: {kind}, {} objects, to {ways}{more}", cell.name, graph.objects_in(number).len())?;
    }
    match cells.len().saturating_sub(LISTED) {
        0 => Ok(()),
        more => writeln!(text, "  and {more} more"),
    }
}
