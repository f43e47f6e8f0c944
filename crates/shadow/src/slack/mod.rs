//! The slack box of a point given by floats: all the points that round to it, half an ulp a coordinate.
//!
//! A point of a surface can hardly be said in floats. So a point with a normal stands for its box, and the question is
//! put to a point of a surface inside it, found exactly.

mod curved;
mod flat;

use glam::DVec3;
use umbriel_geometry::{Aabb, Decide, ExactPoint, LightSource, Point, Sign};

use crate::query::Precision;

/// A point and half an ulp round it.
#[derive(Clone, Copy)]
pub(crate) struct SlackBox {
    position: DVec3,
    /// Half an ulp of each coordinate; zero for a zero coordinate.
    half: DVec3,
    /// The box, rounded outward.
    pub(crate) bounds: Aabb,
}

impl SlackBox {
    /// The box of `position`, whose coordinates came in as floats of `precision`.
    pub(crate) fn new(position: DVec3, precision: Precision) -> Self {
        let ulp = |coordinate: f64| {
            let size = coordinate.abs();
            match precision {
                _ if size == 0.0 => 0.0,
                Precision::Double => size.next_up() - size,
                Precision::Single => f64::from((size as f32).next_up()) - f64::from(size as f32),
            }
        };
        let half = DVec3::from_array(position.to_array().map(|coordinate| 0.5 * ulp(coordinate)));
        Self { position, half, bounds: Aabb { min: position, max: position }.widened(half) }
    }

    /// The box as a filter sees any point inside it.
    pub(crate) fn whole(&self) -> Point<'static> {
        Point::within(self.position, self.half)
    }

    /// How far inside one of the box's planes a point lies, times its weight.
    fn inside_by<T: Decide>(&self, x: &ExactPoint<T>, plane: usize) -> T {
        let axis = plane / 2;
        let half = T::number(self.half[axis]);
        let offset = x.xyz[axis].clone() - x.w.clone() * T::number(self.position[axis]);
        let reach = x.w.clone() * half;
        if plane.is_multiple_of(2) { reach - offset } else { reach + offset }
    }

    /// Whether a point is in the box, if that is known.
    fn holds<T: Decide>(&self, x: &ExactPoint<T>) -> Option<bool> {
        for plane in 0..6 {
            if self.inside_by(x, plane).decide()? == Sign::Negative {
                return Some(false);
            }
        }
        Some(true)
    }
}

/// What a normal asks for: a point of a surface whose side that can be lit makes an acute angle with it.
pub(crate) struct Meaning<'a> {
    /// World coordinates, of any length but zero.
    pub(crate) normal: DVec3,
    /// Whether only the outer side can be lit; else it is the one that looks at the light.
    pub(crate) is_one_sided: bool,
    pub(crate) light: &'a LightSource,
}
