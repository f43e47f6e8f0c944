//! What the tests draw: numbers from a coarse grid beside continuous ones, so that boxes touch, coincide and are flat.

use glam::DVec3;
use proptest::prelude::*;
use umbriel_geometry::{Aabb, LightSource};

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![(-8i32..=8).prop_map(|n| f64::from(n) * 0.25), -2.0..2.0f64]
}

pub(crate) fn point() -> impl Strategy<Value = DVec3> {
    [number(), number(), number()].prop_map(DVec3::from_array)
}

pub(crate) fn a_box() -> impl Strategy<Value = Aabb> {
    let extent = prop_oneof![Just(DVec3::ZERO), point().prop_map(|p| p.abs() * 0.2)];
    let filled = (point(), extent).prop_map(|(min, size)| Aabb { min, max: min + size });
    prop_oneof![19 => filled, 1 => Just(Aabb::EMPTY)]
}

pub(crate) fn boxes() -> impl Strategy<Value = Vec<Aabb>> {
    proptest::collection::vec(a_box(), 0..200)
}

pub(crate) fn light() -> impl Strategy<Value = LightSource> {
    (point(), any::<bool>()).prop_map(|(p, sun)| light_at(p, sun))
}

/// A point whose coordinates are small whole numbers: sums of products of them are exact.
pub(crate) fn whole_point() -> impl Strategy<Value = DVec3> {
    proptest::array::uniform3(-6i32..=6).prop_map(|p| DVec3::from_array(p.map(f64::from)))
}

/// A box with whole corners; flat ones included.
pub(crate) fn whole_box() -> impl Strategy<Value = Aabb> {
    (whole_point(), whole_point()).prop_map(|(a, b)| Aabb::of([a, b]))
}

/// A light with whole coordinates.
pub(crate) fn whole_light() -> impl Strategy<Value = LightSource> {
    (whole_point(), any::<bool>()).prop_map(|(p, sun)| light_at(p, sun))
}

/// A sun or a point light; a sun overhead where there is no direction.
fn light_at(p: DVec3, sun: bool) -> LightSource {
    let made = if sun { LightSource::sun(p.to_array()) } else { LightSource::point(p.to_array()) };
    made.unwrap_or_else(|_| LightSource::sun([0.0, -1.0, 0.0]).expect("a sun overhead"))
}
