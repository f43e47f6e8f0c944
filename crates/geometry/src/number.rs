//! The range of numbers that the whole workspace accepts.
//!
//! A coordinate is 0 or has a magnitude between 2^-200 and 2^200. Inside that range no product of four coordinates
//! or coordinate differences overflows or underflows, so relative error bounds need no absolute part
//! (NUMERICS.md, "The accepted range").

use glam::DVec3;

/// Smallest accepted magnitude other than zero, 2^-200.
pub const MIN_MAGNITUDE: f64 = f64::from_bits((1023 - 200) << 52);
/// Largest accepted magnitude, 2^200.
pub const MAX_MAGNITUDE: f64 = f64::from_bits((1023 + 200) << 52);

/// What the coordinates of a point are called, by axis.
pub const AXES: [char; 3] = ['x', 'y', 'z'];

/// Why a number is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NumberDefect {
    /// NaN or infinity.
    #[error("is not finite")]
    NotFinite,
    /// Not zero, yet below 2^-200.
    #[error("is smaller than 2^-200 and not zero")]
    TooSmall,
    /// Above 2^200.
    #[error("is larger than 2^200")]
    TooLarge,
}

/// Takes a number of the accepted range; −0 becomes 0.
///
/// # Errors
/// The reason why the number is refused.
pub fn accept(value: f64) -> Result<f64, NumberDefect> {
    let magnitude = value.abs();
    if !value.is_finite() {
        Err(NumberDefect::NotFinite)
    } else if magnitude > MAX_MAGNITUDE {
        Err(NumberDefect::TooLarge)
    } else if magnitude != 0.0 && magnitude < MIN_MAGNITUDE {
        Err(NumberDefect::TooSmall)
    } else {
        Ok(value + 0.0)
    }
}

/// The greatest power of two that is not above a positive normal number; 0 below these, infinity for what is not finite.
pub fn power_of_two_below(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & f64::INFINITY.to_bits())
}

/// Takes a point or vector whose three coordinates are accepted ([`accept`]).
///
/// # Errors
/// The axis (0, 1, 2) of the first refused coordinate, and why.
pub fn accept_point(point: [f64; 3]) -> Result<DVec3, (usize, NumberDefect)> {
    let mut accepted = [0.0; 3];
    for (axis, &coordinate) in point.iter().enumerate() {
        accepted[axis] = accept(coordinate).map_err(|defect| (axis, defect))?;
    }
    Ok(DVec3::from_array(accepted))
}
