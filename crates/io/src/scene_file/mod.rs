//! The scene file (TOML): bodies, meshes, lights, a camera, and the detail to compute with.
//!
//! ```toml
//! up = "y"                                      # or "z": everything in the file is turned, meshes included
//! north = 0.0                                   # degrees clockwise from −Z; azimuths are counted from there
//! sides = "auto"                                # or "one", "two"; also per object
//!
//! [[object]]
//! name = "floor"
//! rectangle = { size = [40.0, 40.0] }           # or box, convex, sphere, cone, ... (README); or mesh = "file" with node = "part"
//! translation = [0.0, 0.0, 0.0]                 # rotation = [x, y, z, w], scale = s or [x, y, z]; or matrix = [16 numbers]
//!
//! [[light]]
//! name = "sun"
//! sun = { azimuth = 135.0, elevation = 40.0 }   # or direction = [x, y, z]; or point = { position }, rectangle = { center, u, v }
//!
//! [[cell]]
//! name = "room"
//! points = [[0, 0, 0], [4, 0, 0], ...]          # their hull; or box = [[min], [max]], planes = [[nx, ny, nz, offset], ...] (n·x <= offset),
//!                                               # mesh = "file" (closed, convex) with node = "part", outdoors = true
//!
//! [[portal]]
//! name = "door"
//! cells = ["room", "hall"]
//! corners = [[4, 0, 1], [4, 0, 2], [4, 2, 2], [4, 2, 1]]  # a convex polygon in the boundaries of both
//!
//! [camera]
//! eye = [10.0, 8.0, 10.0]
//! target = [0.0, 0.0, 0.0]                      # up (default: the up axis); vertical_degrees (default 45) or height in metres
//!
//! [detail]
//! boundary_depth = 8                            # with interior_depth; or cell = metres, max_undecided = share, time = seconds,
//!                                               # memory = bytes, pixel_rows = rows of the camera's picture
//! ```
//!
//! An `[[object]]` or a `[[light]]` may have a `detail = { boundary_depth = 10 }` or `detail = { cell = 0.01 }` of its own.
//!
//! Strict: an unknown key is an error with its line and column, so is a body or light that is given twice or not at all.
//! An object's matrix stands to the left of the matrices inside its mesh file. A mesh file with several objects becomes
//! a family of objects `name/part`. What is found in a mesh file is told once, of the first object that takes the part.

mod entries;
mod exact;
mod lights;
mod meshes;
mod objects;
mod rooms;
mod tables;

use std::{path::Path, time::Duration};

use glam::DVec3;
use umbriel_scene::{Camera, Projection, Sides};

use crate::{
    error::{LoadError, LoadProblem},
    folder::Folder,
    load::{Reading, Stated},
    model::{Model, camera},
    options::{DetailSetting, LoadOptions, OwnSettings, UpAxis},
};
use entries::{CameraEntry, DetailEntry, SceneFile, SidesName, Up};
use tables::Word;

/// Degrees of view where a camera does not say.
const DEFAULT_VIEW_DEGREES: f64 = 45.0;
/// The greatest depth of an octree: three coordinates of 21 bits fit into a 64-bit code.
const MAX_DEPTH: u8 = 21;

/// Reads a scene file and the meshes that it names.
pub(crate) fn read(
    path: &Path,
    bytes: &[u8],
    folder: &Folder,
    options: &LoadOptions,
) -> Result<(Model, Stated), LoadError> {
    let in_file = |problem: LoadProblem| problem.in_file(path);
    let text = std::str::from_utf8(bytes).map_err(|fault| {
        let line = bytes[..fault.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count() + 1;
        in_file(LoadProblem::line(line, "the text is not UTF-8"))
    })?;
    let places = Places::new(text);
    let file: SceneFile = toml::from_str(text).map_err(|fault| in_file(places.fault(&fault)))?;
    let mut stated = state(&file, &places).map_err(in_file)?;
    let up = options.up.or(stated.up).unwrap_or_default();
    let north = options.north_degrees.unwrap_or(stated.north);
    let mut model = Model::default();
    let reading = Reading::new(options, options.up.or(stated.up));
    let context = objects::Context { path, places: &places, folder, reading };
    let mut files = meshes::MeshFiles::default();
    stated.own.objects = objects::read(&mut model, &file.object, &mut files, &context)?;
    rooms::read(&mut model, (&file.cell, &file.portal), &mut files, &context)?;
    stated.own.lights = lights::read(&mut model, &file.light, &places, up, north).map_err(in_file)?;
    if let Some(entry) = &file.camera {
        let eye = camera_of(entry.get_ref(), up);
        model.camera = Some(eye.map_err(|message| in_file(places.at(entry.span(), format!("camera: {message}"))))?);
    }
    Ok((model, stated))
}

/// What the file says about the scene as a whole.
fn state(file: &SceneFile, places: &Places) -> Result<Stated, LoadProblem> {
    let detail = file.detail.as_ref().map(|entry| {
        detail_of(entry.get_ref()).map_err(|message| places.at(entry.span(), format!("detail: {message}")))
    });
    let north = file.north.unwrap_or(0.0);
    if !north.is_finite() {
        return Err(LoadProblem::element("north", "it must be a finite number of degrees"));
    }
    Ok(Stated {
        up: file.up.map(|Word(up)| match up {
            Up::Y => UpAxis::Y,
            Up::Z => UpAxis::Z,
        }),
        north,
        sides: file.sides.map(sides_of),
        detail: detail.transpose()?,
        own: OwnSettings::default(),
    })
}

fn sides_of(Word(name): Word<SidesName>) -> Sides {
    match name {
        SidesName::Auto => Sides::Auto,
        SidesName::One => Sides::One,
        SidesName::Two => Sides::Two,
    }
}

fn detail_of(entry: &DetailEntry) -> Result<DetailSetting, &'static str> {
    const ONE: &str =
        "give one of boundary_depth (with interior_depth, if you like), cell, max_undecided, time, memory, pixel_rows";
    let &DetailEntry { interior_depth: interior, boundary_depth, cell, max_undecided, time, memory, pixel_rows } =
        entry;
    let time = time.map(|seconds| Duration::try_from_secs_f64(seconds).unwrap_or_default());
    let given = [
        boundary_depth.map(|boundary| DetailSetting::Depth { interior, boundary }),
        cell.map(|edge| DetailSetting::Cell { edge }),
        max_undecided.map(|share| DetailSetting::MaxUndecided { share }),
        time.map(|limit| DetailSetting::Time { limit }),
        memory.map(|bytes| DetailSetting::Memory { bytes }),
        pixel_rows.map(|rows| DetailSetting::Pixel { rows }),
    ];
    let mut given = given.into_iter().flatten();
    let (Some(setting), None) = (given.next(), given.next()) else { return Err(ONE) };
    let fault = match setting {
        DetailSetting::Depth { interior, boundary } if boundary > MAX_DEPTH || interior > Some(boundary) => {
            "boundary_depth must be 21 at most, and interior_depth at most boundary_depth"
        }
        DetailSetting::Depth { .. } => return Ok(setting),
        _ if interior.is_some() => ONE,
        DetailSetting::Cell { edge } if !(edge > 0.0 && edge.is_finite()) => "cell must be a positive number of metres",
        DetailSetting::MaxUndecided { share } if !(0.0..=1.0).contains(&share) => {
            "max_undecided must be a share between 0 and 1"
        }
        DetailSetting::Time { limit } if limit.is_zero() => "time must be a positive number of seconds",
        DetailSetting::Memory { bytes: 0 } => "memory must be 1 byte at least",
        DetailSetting::Pixel { rows: 0 } => "pixel_rows must be 1 at least",
        _ => return Ok(setting),
    };
    Err(fault)
}

/// The detail of a single object or light.
fn own_detail_of(entry: &DetailEntry) -> Result<DetailSetting, &'static str> {
    match detail_of(entry)? {
        setting @ (DetailSetting::Depth { .. } | DetailSetting::Cell { .. }) => Ok(setting),
        _ => Err(
            "an object or a light has a boundary_depth (with interior_depth, if you like) or a cell of its own; all else is for the scene",
        ),
    }
}

fn camera_of(entry: &CameraEntry, up: UpAxis) -> Result<Camera, &'static str> {
    let projection = match (entry.vertical_degrees, entry.height) {
        (Some(_), Some(_)) => return Err("give vertical_degrees or height, not both"),
        (None, Some(height)) => Projection::Orthographic { height },
        (degrees, None) => Projection::Perspective { vertical_degrees: degrees.unwrap_or(DEFAULT_VIEW_DEGREES) },
    };
    let default_up = match up {
        UpAxis::Y => DVec3::Y,
        UpAxis::Z => DVec3::Z,
    };
    let up = entry.up.map_or(default_up, DVec3::from_array);
    camera(DVec3::from_array(entry.eye), DVec3::from_array(entry.target), up, projection)
}

/// Lines and columns of the text.
pub(super) struct Places<'a> {
    text: &'a str,
    /// Where each line begins.
    lines: Vec<usize>,
    /// How many characters stand before every [`STEP`]-th byte: a file may be one line, and all of its entries have places.
    characters: Vec<usize>,
}

/// Bytes between marks.
const STEP: usize = 1024;

impl<'a> Places<'a> {
    fn new(text: &'a str) -> Self {
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(newline, _)| newline + 1)).collect();
        let sum = |sum: &mut usize, bytes| Some(std::mem::replace(sum, *sum + begun(bytes)));
        Self { text, lines, characters: text.as_bytes().chunks(STEP).scan(0, sum).collect() }
    }

    /// A problem at the beginning of a span.
    fn at(&self, span: std::ops::Range<usize>, message: impl Into<String>) -> LoadProblem {
        let (line, column) = self.line_and_column(span);
        LoadProblem::Text { line, column: Some(column), message: message.into() }
    }

    /// Where a span begins, counted from 1.
    fn line_and_column(&self, span: std::ops::Range<usize>) -> (usize, usize) {
        let line = self.lines.partition_point(|&line| line <= span.start).max(1);
        let begin = self.lines[line - 1];
        (line, self.characters_before(span.start) - self.characters_before(begin) + 1)
    }

    fn characters_before(&self, at: usize) -> usize {
        let at = at.min(self.text.len());
        let mark = (at / STEP).min(self.characters.len().saturating_sub(1));
        let bytes = &self.text.as_bytes()[mark * STEP..at];
        self.characters.get(mark).map_or(0, |before| before + begun(bytes))
    }

    /// What the TOML parser refuses.
    fn fault(&self, fault: &toml::de::Error) -> LoadProblem {
        let words = [
            ("\n", ", "),
            (" as i128", ""),
            ("expected u8", "expected a whole number from 0 to 21"),
            ("expected f64", "expected a number"),
            // Lists of tables are all that this format has of sequences at its top.
            ("invalid type: map, expected a sequence", "write it with two brackets, [[...]]"),
        ];
        let message =
            words.iter().fold(fault.message().to_owned(), |message, (told, word)| message.replace(told, word));
        match fault.span() {
            Some(span) => self.at(span, message),
            None => LoadProblem::element("scene file", message),
        }
    }
}

/// How many characters begin in these bytes of UTF-8.
fn begun(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte & 0xc0 != 0x80).count()
}

#[cfg(test)]
mod tests;
