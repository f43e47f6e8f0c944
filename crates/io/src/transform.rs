//! Matrices from what files say: a matrix, or translation, rotation and scale.

use glam::{DAffine3, DMat3, DVec3};

/// The map of a column-major 4×4 matrix; its last row must be 0 0 0 1.
pub(crate) fn from_matrix(m: &[f64; 16]) -> Result<DAffine3, String> {
    if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
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

/// The rotation of a quaternion x, y, z, w of any length but zero.
///
/// Homogeneous: every entry is divided by the squared length, so that nothing is normalised beforehand and quarter
/// turns (two equal components, two zeros) come out exact.
fn rotation_matrix([x, y, z, w]: [f64; 4]) -> Result<DMat3, String> {
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
    fn a_projective_matrix_is_refused() {
        let mut matrix = [0.0; 16];
        (0..4).for_each(|i| matrix[5 * i] = 1.0);
        matrix[12] = 7.0;
        assert_eq!(from_matrix(&matrix), Ok(DAffine3::from_translation(DVec3::new(7.0, 0.0, 0.0))));
        matrix[3] = 0.1;
        assert!(from_matrix(&matrix).is_err());
    }
}
