//! Matrices from what files say: a matrix, or translation, rotation and scale.

use glam::{DAffine3, DMat3, DVec3};
use robust::{Coord, orient2d};

use crate::triangulate::SIX_DIGITS;

/// How far rotations and matrices may be from what they should be before that is told: exporters write four decimals at the least,
/// each off by 5·10⁻⁵. A squared length of four such numbers (their sizes sum to 2 at most), and a product of two unit
/// columns (√3 each), is then off by less than 2^-12.
const FOUR_DECIMALS: f64 = 1.0 / 4096.0;
/// The last row of a column-major 4×4 matrix, less 0 0 0 1.
fn beyond_affine(m: &[f64; 16]) -> [f64; 4] {
    [m[3], m[7], m[11], m[15] - 1.0]
}

/// Whether the last row is 0 0 0 1.
pub(crate) fn is_affine(m: &[f64; 16]) -> bool {
    beyond_affine(m) == [0.0; 4]
}

/// Whether two columns of the matrix are not perpendicular, so that it is no rotation after scales.
pub(crate) fn is_skewed(m: &[f64; 16]) -> bool {
    let column = |i: usize| DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]).normalize_or_zero();
    (0..3).any(|i| column(i).dot(column((i + 1) % 3)).abs() > FOUR_DECIMALS)
}

/// Whether a quaternion has length one.
pub(crate) fn is_unit(rotation: [f64; 4]) -> bool {
    let squared: f64 = rotation.iter().map(|part| part * part).sum();
    (squared - 1.0).abs() <= FOUR_DECIMALS
}

/// As [`from_matrix`], of a matrix whose last row is 0 0 0 1 as closely as six digits say it (products of matrices in 32 bits
/// leave as much); who reads it tells that.
pub(crate) fn from_almost_affine(m: &[f64; 16]) -> Result<DAffine3, String> {
    let mut matrix = *m;
    if beyond_affine(m).iter().all(|rest| rest.abs() <= SIX_DIGITS) {
        [matrix[3], matrix[7], matrix[11], matrix[15]] = [0.0, 0.0, 0.0, 1.0];
    }
    from_matrix(&matrix)
}

/// The map of a column-major 4×4 matrix; its last row must be 0 0 0 1.
pub(crate) fn from_matrix(m: &[f64; 16]) -> Result<DAffine3, String> {
    if !is_affine(m) {
        return Err("the last row of its matrix (every fourth number) must be 0 0 0 1".to_owned());
    }
    let column = |i: usize| DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
    Ok(DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) })
}

/// The map x ↦ T + R·(S·x).
pub(crate) fn from_parts(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> Result<DAffine3, String> {
    let turn = rotation_matrix(rotation)?;
    let scaled = DMat3::from_cols(turn.x_axis * scale[0], turn.y_axis * scale[1], turn.z_axis * scale[2]);
    Ok(DAffine3 { matrix3: scaled, translation: DVec3::from_array(translation) })
}

/// Whether the map leaves no surface of anything: its image is a line or a point. Exact.
pub(crate) fn has_no_surface(m: &DMat3) -> bool {
    let minor = |a: DVec3, b: DVec3, axis: usize| {
        let seen = |v: DVec3| Coord { x: v[axis], y: v[(axis + 1) % 3] };
        orient2d(seen(a), seen(b), Coord { x: 0.0, y: 0.0 })
    };
    let pairs = [(m.x_axis, m.y_axis), (m.y_axis, m.z_axis), (m.z_axis, m.x_axis)];
    pairs.iter().all(|&(a, b)| (0..3).all(|axis| minor(a, b, axis) == 0.0))
}

/// The rotation of a quaternion x, y, z, w of any length but zero.
///
/// Homogeneous: every entry is divided by the squared length, so that nothing is normalised beforehand and quarter
/// turns (two equal components, two zeros) come out exact.
pub(crate) fn rotation_matrix([x, y, z, w]: [f64; 4]) -> Result<DMat3, String> {
    let squared = x * x + y * y + z * z + w * w;
    if !squared.is_normal() {
        return Err("its rotation is no quaternion: its length is zero or out of range".to_owned());
    }
    let entry = |value: f64| value / squared;
    Ok(DMat3::from_cols(
        DVec3::new(entry(x * x - y * y - z * z + w * w), entry(2.0 * (x * y + z * w)), entry(2.0 * (x * z - y * w))),
        DVec3::new(entry(2.0 * (x * y - z * w)), entry(y * y - x * x - z * z + w * w), entry(2.0 * (y * z + x * w))),
        DVec3::new(entry(2.0 * (x * z + y * w)), entry(2.0 * (y * z - x * w)), entry(z * z - x * x - y * y + w * w)),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turn = from_parts([0.0; 3], [0.0, half, 0.0, half], [1.0; 3]).expect("a rotation");
        assert_eq!(turn.transform_vector3(DVec3::X), DVec3::NEG_Z);
        assert_eq!(turn.transform_vector3(DVec3::new(1.0, 2.0, 3.0)), DVec3::new(3.0, 2.0, -1.0));
        assert!(rotation_matrix([0.0; 4]).is_err());
        assert!(rotation_matrix([f64::NAN, 0.0, 0.0, 1.0]).is_err());
    }

    #[test]
    fn parts_agree_with_the_published_formula() {
        let rotation = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        let (scale, translation) = (DVec3::new(2.0, -3.0, 0.5), DVec3::new(1.0, 2.0, 3.0));
        let theirs = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
        let longer = rotation.to_array().map(|component| 3.0 * component);
        let ours = from_parts(translation.to_array(), longer, scale.to_array()).expect("a rotation");
        assert!(ours.abs_diff_eq(theirs, 1e-14));
    }

    #[test]
    fn lines_and_points_have_no_surface() {
        let of = |columns: [[f64; 3]; 3]| has_no_surface(&DMat3::from_cols_array_2d(&columns));
        assert!(of([[0.0; 3]; 3]) && of([[1.0, 2.0, 3.0], [0.0; 3], [-2.0, -4.0, -6.0]]));
        assert!(!of([[1.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]]) && !of([[1.0, 2.0, 3.0], [1.0, 2.0, 3.5], [0.0; 3]]));
        // The products differ by less than an ulp.
        assert!(!of([[0.1, 0.3, 0.0], [0.2, 0.6f64.next_up(), 0.0], [0.0; 3]]));
    }

    #[test]
    fn a_projective_matrix_is_refused() {
        let mut matrix = [0.0; 16];
        (0..4).for_each(|i| matrix[5 * i] = 1.0);
        matrix[12] = 7.0;
        assert_eq!(from_matrix(&matrix), Ok(DAffine3::from_translation(DVec3::new(7.0, 0.0, 0.0))));
        matrix[3] = 1e-9;
        assert!(from_matrix(&matrix).is_err());
        assert_eq!(from_almost_affine(&matrix), Ok(DAffine3::from_translation(DVec3::new(7.0, 0.0, 0.0))));
        matrix[3] = 0.1;
        assert!(from_almost_affine(&matrix).is_err());
    }

    #[test]
    fn what_is_written_with_four_decimals_is_neither_skewed_nor_stretched() {
        let turn = glam::DMat4::from_quat(glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0));
        let scaled = turn * glam::DMat4::from_scale(DVec3::new(2.0, 0.0, 3.0));
        let written = scaled.to_cols_array().map(|entry| (entry * 1e4).round() / 1e4);
        assert!(!is_skewed(&written));
        let mut skewed = scaled.to_cols_array();
        skewed[0] += 0.01;
        assert!(is_skewed(&skewed));
        assert!(is_unit([0.1826, 0.3651, 0.5477, 0.7303]) && !is_unit([0.0, 0.0, 0.0, 2.0]));
    }
}
