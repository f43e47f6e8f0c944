//! What `umbriel render` was typed with.

use std::path::PathBuf;

use clap::{Args as ClapArgs, ValueEnum};
use glam::DVec3;
use umbriel_scene::{Camera, Projection};

use crate::{
    cli::{
        acceleration::AccelerationChoice,
        args::{DetailArgs, LightArgs, SceneArgs, SunsArgs, color, finite, size},
    },
    output::picture::SUBPIXELS,
};

#[derive(Debug, ClapArgs)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) lights: LightArgs,
    #[command(flatten)]
    pub(crate) suns: SunsArgs,
    #[command(flatten)]
    pub(crate) detail: DetailArgs,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1200x800", value_parser = size)]
    pub(crate) size: [u32; 2],
    /// Show undecided cells in this colour instead of deciding their pixels exactly
    #[arg(long, value_name = "RRGGBB", num_args = 0..=1, require_equals = true, default_missing_value = "ff8c1a", value_parser = color, conflicts_with = "suns")]
    pub(crate) undecided: Option<[u8; 3]>,
    /// How the face in each pixel is found, by exact decisions: all methods give the same picture, and tell what they did
    /// [default: rounded rays, quicker with many shadows]
    #[arg(long, value_enum, value_name = "METHOD", conflicts_with_all = ["suns", "acceleration"])]
    pub(crate) method: Option<SurfaceMethod>,
    /// Where shadows come from: baked cells and exact queries, or shadow polygons that the lights cast once (scenes of flat faces)
    #[arg(long, value_enum, value_name = "HOW", default_value = "cells", conflicts_with_all = ["suns", "undecided", "lines"])]
    pub(crate) shadows: ShadowsChoice,
    /// Draw edges instead of surfaces, hidden parts left out, shadows hatched: to a .svg file
    #[arg(long, conflicts_with_all = ["suns", "acceleration", "method", "undecided"])]
    pub(crate) lines: bool,
    /// Dash hidden parts instead of leaving them out; with --lines or --method lines
    #[arg(long)]
    pub(crate) dashed: bool,
    /// Where the eye is and what it looks at, metres, and if you like the vertical field of view in degrees
    #[arg(long, value_name = "X,Y,Z,X,Y,Z[,DEG]", allow_hyphen_values = true, value_parser = camera)]
    pub(crate) camera: Option<Camera>,
    /// Samples along each edge of a pixel, 1 to 16, to smooth edges
    #[arg(long, value_name = "N", default_value_t = SUBPIXELS, value_parser = clap::value_parser!(u32).range(1..=16))]
    pub(crate) aa: u32,
    /// How the rays of the camera, and of points that no cell decides, find what they meet; the picture is the same
    #[arg(long, value_enum, value_name = "HOW", default_value = "auto")]
    pub(crate) acceleration: AccelerationChoice,
    /// Write the picture to a .png file, lines to a .svg file (repeatable)
    #[arg(short, long = "output", value_name = "FILE", required = true)]
    pub(crate) output: Vec<PathBuf>,
}

/// Where the shadows of a picture come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ShadowsChoice {
    /// Baked cells, and exact queries where these do not say
    Cells,
    /// Shadow polygons on every face
    Polygons,
}

/// A method of hidden surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SurfaceMethod {
    /// Depth buffer, by tiles
    Depth,
    /// Scan line, by intervals
    Scanline,
    /// Area subdivision
    Warnock,
    /// Ray casting through a tree of boxes
    Raycast,
    /// Ray casting through an octree
    Octree,
    /// Depth sort with splitting
    Sort,
    /// All of these, side by side
    All,
    /// Edges with hidden parts left out, as --lines
    Lines,
}

/// Vertical field of view where none is given, degrees.
const FIELD_OF_VIEW: f64 = 40.0;

/// Eye, target and field of view.
pub(crate) fn camera(text: &str) -> Result<Camera, String> {
    let numbers = text.split(',').map(finite).collect::<Result<Vec<f64>, String>>()?;
    let (place, vertical_degrees) = match numbers[..] {
        [a, b, c, d, e, f] => ([a, b, c, d, e, f], FIELD_OF_VIEW),
        [a, b, c, d, e, f, degrees] => ([a, b, c, d, e, f], degrees),
        _ => return Err(format!("{} numbers where 6 or 7 are needed", numbers.len())),
    };
    let [a, b, c, d, e, f] = place;
    let (eye, target) = (DVec3::new(a, b, c), DVec3::new(d, e, f));
    if eye == target {
        return Err("the eye looks at itself".to_owned());
    }
    if !(vertical_degrees > 0.0 && vertical_degrees < 180.0) {
        return Err("the field of view is not between 0 and 180 degrees".to_owned());
    }
    Ok(Camera { eye, target, up: DVec3::Y, projection: Projection::Perspective { vertical_degrees } })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_have_an_eye_and_a_target() {
        assert!(camera("1,2,3,4,5,6,50").is_ok() && camera("-1,2,3,4,5,6").is_ok());
        assert!(["1,2,3,1,2,3", "1,2,3,4,5", "1,2,3,4,5,6,180"].iter().all(|wrong| camera(wrong).is_err()));
    }
}
