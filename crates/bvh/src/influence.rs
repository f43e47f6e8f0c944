//! The influence of one box on another (Xie, Yu, Hao and Sun, "The new algorithm of shadow volume with LOD", Journal of
//! the National University of Defense Technology 23(3), 2001), and the proof that there is none.
//!
//! `[A] → [B]` says that part of box B lies in the shadow space of box A: some segment from B to the light meets A
//! ([`may_shadow`]; the header of `shaft.rs` shows that the test is exact up to rounding, which goes outward).
//!
//! The source excludes `[B] → [A]` once `[A] → [B]` is found. That is sound only for separated boxes, so it is proved
//! here by separation ([`cannot_shadow`]), from the boxes and the light alone:
//!
//! *Let a plane x_k = c have the closed box A on its closed low side and the closed box B on its closed high side, and
//! let the light be strictly below: L_k < c, or d_k < 0 for a sun with vector d towards it. Then nothing in B shadows
//! anything in A.* A point a of A has a_k ≤ c. Every other point of the open segment from a to the light lies strictly
//! below c: its coordinate is a proper mean of a_k ≤ c and L_k < c, or a_k + s d_k with s > 0. B lies at or above c,
//! so it can meet the segment at a itself at most, and contact never blocks. The mirrored statement holds as well. ∎
//!
//! A plane that separates exists on axis k if and only if A⁺ ≤ B⁻ there; taking c = B⁻ demands least of the light.
//! Only numbers of the input are compared: the proof needs no rounding at all.
//!
//! No separation is left unused: where a plane x_k = c separates two boxes and the light is not in it, the light is
//! strictly on one side, and the box on the other side cannot shadow the one on the light's side. So of two separated
//! boxes at least one direction is excluded, as the source has it, and boxes that overlap exclude nothing in either
//! direction, whatever the light: disjoint boxes are always separated by an axis-aligned plane.

use glam::DVec3;
use umbriel_geometry::{Aabb, LightSource};

use crate::shaft::Shaft;

/// Whether part of the closed box `receiver` may lie in the shadow space of the closed box `occluder`: `[A] → [B]`.
///
/// No is a proof; yes is exact up to rounding ([`Shaft::may_meet`]). Boxes that share a point influence each other.
/// Empty boxes have no influence. Monotone in both boxes. Cost: that of a [`Shaft`] and one test; for many occluders of
/// one receiver keep the shaft.
pub fn may_shadow(occluder: &Aabb, receiver: &Aabb, light: &LightSource) -> bool {
    !occluder.is_empty() && !receiver.is_empty() && Shaft::new(receiver, light).may_meet(occluder)
}

/// Whether an axis-aligned plane proves that nothing in `occluder` shadows anything in `receiver`.
///
/// True is a proof (see the header of the module), false says nothing. Sharper than a no of [`may_shadow`] in one
/// case: boxes that merely touch. Monotone: what holds for two boxes holds for all boxes inside them.
/// Cost: 12 comparisons.
#[inline]
pub fn cannot_shadow(occluder: &Aabb, receiver: &Aabb, light: &LightSource) -> bool {
    let xyz = light.xyz();
    // A sun's vector points away from the plane; a point light stands beyond the occluder's side of it.
    let (low, high) = if light.is_sun() { (DVec3::ZERO, DVec3::ZERO) } else { (occluder.min, occluder.max) };
    let below = xyz.cmplt(low) & receiver.max.cmple(occluder.min);
    let above = xyz.cmpgt(high) & occluder.max.cmple(receiver.min);
    (below | above).any()
}

#[cfg(test)]
mod tests;
