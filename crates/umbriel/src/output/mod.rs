//! Results turned into what files and terminals take; one form a file.

pub(crate) mod cells;
pub(crate) mod compare;
pub(crate) mod csv;
pub(crate) mod doctor;
pub(crate) mod drawing;
pub(crate) mod findings;
pub(crate) mod glb;
pub(crate) mod hours;
pub(crate) mod hours_picture;
pub(crate) mod json;
pub(crate) mod lamplight;
pub(crate) mod legend;
pub(crate) mod lightmap;
mod overlay;
pub(crate) mod picture;
pub(crate) mod side_by_side;
pub(crate) mod soft;
mod surface;
pub(crate) mod table;
mod target;
pub(crate) mod tradeoff;
pub(crate) mod viewpoint;
pub(crate) mod vtu;

use std::io::{self, Write};

pub(crate) use target::{
    Format, Target, add_target, check_file, check_unread, commit_all, file_of_object, targets, targets_and_json,
};

use crate::cli::Failure;

/// Writes text to standard output.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| Failure::of_output(&error))
}

/// Writes a line to standard error. That it cannot be written is nobody's business any more.
pub(crate) fn tell(text: &str) {
    let _ = writeln!(io::stderr(), "umbriel: {text}");
}
