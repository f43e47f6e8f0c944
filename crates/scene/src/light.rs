//! Lights: where their light comes from, and how far round that point they reach.

use glam::{DMat3, DVec3};
use umbriel_geometry::{LightSource, NumberDefect, accept};

/// How far a light reaches round its centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Extent {
    /// A point, or a sun whose rays are parallel.
    #[default]
    Point,
    /// A ball round a point light.
    Sphere {
        /// Metres; positive.
        radius: f64,
    },
    /// A parallelogram round a point light; it shines to both sides.
    Rectangle {
        /// First half edge, world coordinates, metres.
        u: DVec3,
        /// Second half edge, not parallel to the first.
        v: DVec3,
    },
    /// A sun's disk in the sky.
    Disk {
        /// Degrees, above 0 and below 180.
        angular_diameter: f64,
    },
}

/// Why an extent is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExtentDefect {
    /// A number outside of the accepted range.
    #[error("a number of its extent {0}")]
    Number(NumberDefect),
    /// A size that is not positive.
    #[error("its radius or angular diameter must be positive")]
    Size,
    /// A disk that fills half of the sky or more.
    #[error("angular_diameter must be less than 180 degrees")]
    WideDisk,
    /// Half edges without an area.
    #[error("u and v must be two half edges in different directions")]
    NoArea,
    /// A ball or rectangle round a sun, a disk round a point.
    #[error("a sun has an angular diameter, a point light a radius or half edges")]
    Kind,
}

/// A named light.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Unique within the scene.
    pub name: String,
    /// Where its light comes from; of an area light, its centre.
    pub source: LightSource,
    /// How far it reaches round that.
    pub extent: Extent,
}

impl Light {
    /// A light without an extent.
    pub fn new(name: impl Into<String>, source: LightSource) -> Self {
        Self { name: name.into(), source, extent: Extent::Point }
    }

    /// A light with an extent.
    ///
    /// # Errors
    /// [`ExtentDefect`].
    pub fn with_extent(name: impl Into<String>, source: LightSource, extent: Extent) -> Result<Self, ExtentDefect> {
        extent.check(&source)?;
        Ok(Self { name: name.into(), source, extent })
    }
}

impl Extent {
    /// Whether this is a point.
    pub fn is_point(&self) -> bool {
        *self == Self::Point
    }

    /// The extent in other coordinates: half edges go with the map; a ball's radius by the cube root of how much volumes
    /// grow, which is exact for rotations and turned axes.
    #[must_use]
    pub fn mapped(&self, map: &DMat3) -> Self {
        match *self {
            Self::Sphere { radius } => {
                let growth = map.determinant().abs();
                Self::Sphere { radius: if growth == 1.0 { radius } else { radius * growth.cbrt() } }
            }
            Self::Rectangle { u, v } => Self::Rectangle { u: *map * u, v: *map * v },
            other => other,
        }
    }

    fn check(&self, source: &LightSource) -> Result<(), ExtentDefect> {
        let number = |value: f64| accept(value).map_err(ExtentDefect::Number);
        let size = |value: f64| if number(value)? > 0.0 { Ok(()) } else { Err(ExtentDefect::Size) };
        match *self {
            Self::Point => Ok(()),
            Self::Sphere { .. } | Self::Rectangle { .. } if source.is_sun() => Err(ExtentDefect::Kind),
            Self::Disk { .. } if !source.is_sun() => Err(ExtentDefect::Kind),
            Self::Sphere { radius } => size(radius),
            Self::Rectangle { u, v } => {
                u.to_array().into_iter().chain(v.to_array()).try_for_each(|value| number(value).map(drop))?;
                if u.cross(v) == DVec3::ZERO { Err(ExtentDefect::NoArea) } else { Ok(()) }
            }
            Self::Disk { angular_diameter } if angular_diameter >= 180.0 => Err(ExtentDefect::WideDisk),
            Self::Disk { angular_diameter } => size(angular_diameter),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extents_are_checked() {
        let point = LightSource::point([0.0; 3]).expect("a point");
        let sun = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
        let check = |source, extent| Light::with_extent("light", source, extent).map(drop);
        let rectangle = |u, v| Extent::Rectangle { u, v };
        assert_eq!(check(point, Extent::Sphere { radius: 0.5 }), Ok(()));
        assert_eq!(check(point, rectangle(DVec3::X, DVec3::Y)), Ok(()));
        assert_eq!(check(sun, Extent::Disk { angular_diameter: 0.53 }), Ok(()));
        assert_eq!(check(sun, Extent::Sphere { radius: 1.0 }), Err(ExtentDefect::Kind));
        assert_eq!(check(point, Extent::Disk { angular_diameter: 1.0 }), Err(ExtentDefect::Kind));
        assert_eq!(check(sun, Extent::Disk { angular_diameter: 180.0 }), Err(ExtentDefect::WideDisk));
        assert_eq!(check(point, Extent::Sphere { radius: -1.0 }), Err(ExtentDefect::Size));
        assert_eq!(check(point, rectangle(DVec3::X, DVec3::X * 3.0)), Err(ExtentDefect::NoArea));
        assert!(matches!(check(point, Extent::Sphere { radius: f64::NAN }), Err(ExtentDefect::Number(_))));
    }

    #[test]
    fn extents_turn_with_the_axes() {
        let turn = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
        let rectangle = Extent::Rectangle { u: DVec3::Y, v: DVec3::Z };
        assert_eq!(rectangle.mapped(&turn), Extent::Rectangle { u: DVec3::NEG_Z, v: DVec3::Y });
        let sphere = Extent::Sphere { radius: 0.3 };
        assert_eq!(sphere.mapped(&turn), sphere);
        assert_eq!(sphere.mapped(&(DMat3::IDENTITY * 2.0)), Extent::Sphere { radius: 0.6 });
    }
}
