//! Filters: what was done to attributes before compression, undone in place.
//!
//! The formulas are the specification's, in 32-bit floats; it grants them one unit of the result, the exponential filter
//! is exact. Components that no encoder writes have unspecified results: here they saturate.

use super::super::json::MeshoptFilter;

/// Undoes a filter on elements of `stride` bytes.
pub(super) fn apply(filter: MeshoptFilter, stride: usize, elements: &mut [u8]) {
    let elements = elements.chunks_exact_mut(stride);
    match filter {
        MeshoptFilter::None => {}
        MeshoptFilter::Octahedral => elements.for_each(|element| signed(element, unit_vector)),
        MeshoptFilter::Quaternion => elements.for_each(|element| signed(element, quaternion)),
        MeshoptFilter::Exponential => elements.for_each(|element| element.chunks_exact_mut(4).for_each(float)),
        MeshoptFilter::Color => elements.for_each(color),
    }
}

/// Rewrites four signed components of one or two bytes; `change` gets what stands for 1 as well.
fn signed(element: &mut [u8], change: fn([i32; 4], f32) -> [i32; 4]) {
    if let Ok(bytes) = <[u8; 4]>::try_from(&*element) {
        let changed = change(bytes.map(|byte| i32::from(byte as i8)), f32::from(i8::MAX));
        element.copy_from_slice(&changed.map(|component| component as u8));
    } else {
        let component = |i: usize| i32::from(i16::from_le_bytes([element[2 * i], element[2 * i + 1]]));
        let changed = change(std::array::from_fn(component), f32::from(i16::MAX));
        let bytes = changed.map(|component| (component as i16).to_le_bytes());
        element.copy_from_slice(bytes.as_flattened());
    }
}

/// Three components of a unit vector from two on an octahedron.
fn unit_vector([x, y, one, rest]: [i32; 4], scale: f32) -> [i32; 4] {
    let (x, y) = (x as f32 / one as f32, y as f32 / one as f32);
    let z = 1.0 - x.abs() - y.abs();
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let length = (x * x + y * y + z * z).sqrt();
    let component = |value: f32| (value / length * scale).round() as i32;
    [component(x), component(y), component(z), rest]
}

/// Four components of a quaternion from the three smaller ones.
fn quaternion([x, y, z, code]: [i32; 4], scale: f32) -> [i32; 4] {
    let range = std::f32::consts::FRAC_1_SQRT_2 / (code | 3) as f32;
    let [x, y, z] = [x, y, z].map(|component| component as f32 * range);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut turned = [w, x, y, z].map(|component| (component * scale).round() as i32);
    turned.rotate_right((code & 3) as usize);
    turned
}

/// A float from 24 bits of mantissa and 8 of exponent; exact where the exponent is in its range of ±100.
fn float(bytes: &mut [u8]) {
    let code = i32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let (exponent, mantissa) = (code >> 24, code << 8 >> 8);
    // Both factors are floats or doubles exactly, and so is their product.
    let value = f64::from(mantissa) * f64::from_bits(((1023 + i64::from(exponent)) as u64) << 52);
    bytes.copy_from_slice(&(value as f32).to_le_bytes());
}

/// Red, green, blue and alpha from luma and two chroma differences (YCoCg).
fn color(element: &mut [u8]) {
    let wide = element.len() == 8;
    let signed = |i: usize| match wide {
        true => i32::from(i16::from_le_bytes([element[2 * i], element[2 * i + 1]])),
        false => i32::from(element[i] as i8),
    };
    let most: i32 = if wide { 0xffff } else { 0xff };
    let (luma, orange, green, code) = (signed(0) & most, signed(1), signed(2), signed(3) & most);
    // The highest bit of the fourth component says how many bits there are.
    let scale = (1_u32 << (32 - code.leading_zeros())) as i32 - 1;
    let alpha = code & scale >> 1;
    let components = [luma + orange - green, luma + green, luma - orange - green, alpha << 1 | alpha & 1];
    let unit = most as f32 / scale as f32;
    for (i, component) in components.into_iter().enumerate() {
        let value = (component as f32 * unit).round() as i32;
        if wide {
            element[2 * i..2 * i + 2].copy_from_slice(&(value as u16).to_le_bytes());
        } else {
            element[i] = value as u8;
        }
    }
}
