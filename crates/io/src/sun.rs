//! Directions from angles: rounded once, and from then on the rounded direction is the light.
//!
//! Sines and cosines come from `libm`, so that all platforms give the same bits. Quarter turns are exact: the angle is
//! first reduced to ±45° about the nearest one, which costs no rounding (a remainder is exact).

/// The direction in which sunlight travels, y up: azimuth in degrees clockwise from north (−Z; east is +X), elevation
/// in degrees above the horizon. The result has unit length up to rounding; it is not finite if an angle is not.
///
/// ```
/// assert_eq!(umbriel_io::sun_from_angles(90.0, 0.0), [-1.0, 0.0, 0.0]); // from the east
/// assert_eq!(umbriel_io::sun_from_angles(0.0, 90.0), [0.0, -1.0, 0.0]); // from the zenith
/// ```
pub fn sun_from_angles(azimuth: f64, elevation: f64) -> [f64; 3] {
    let (east, north) = sine_cosine(azimuth);
    let (up, level) = sine_cosine(elevation);
    // Towards the sun is (east·level, up, −north·level). Adding 0 turns −0 into 0.
    [-(east * level) + 0.0, -up + 0.0, north * level + 0.0]
}

/// Sine and cosine of an angle in degrees; exact at multiples of 90°.
fn sine_cosine(degrees: f64) -> (f64, f64) {
    let within_turn = degrees % 360.0;
    let quarters = libm::round(within_turn / 90.0);
    let rest = (within_turn - 90.0 * quarters).to_radians();
    let (sine, cosine) = (libm::sin(rest), libm::cos(rest));
    match (quarters as i32).rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact() {
        assert_eq!(sun_from_angles(0.0, 0.0), [0.0, 0.0, 1.0], "from the north, travelling south");
        assert_eq!(sun_from_angles(180.0, 0.0), [0.0, 0.0, -1.0]);
        assert_eq!(sun_from_angles(270.0, 0.0), [1.0, 0.0, 0.0]);
        assert_eq!(sun_from_angles(-90.0, 0.0), sun_from_angles(270.0, 0.0));
        assert_eq!(sun_from_angles(450.0, 0.0), [-1.0, 0.0, 0.0]);
        assert_eq!(sun_from_angles(123.0, -90.0), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn other_angles_are_close_to_their_formulas() {
        for azimuth in (-720..720).step_by(7).map(f64::from) {
            for elevation in (-90..=90).step_by(5).map(f64::from) {
                let (a, e) = (azimuth.to_radians(), elevation.to_radians());
                let expected = [-a.sin() * e.cos(), -e.sin(), a.cos() * e.cos()];
                let found = sun_from_angles(azimuth, elevation);
                for axis in 0..3 {
                    assert!((found[axis] - expected[axis]).abs() < 1e-14, "{azimuth} {elevation}");
                }
            }
        }
        assert!(sun_from_angles(f64::NAN, 0.0)[0].is_nan());
    }
}
