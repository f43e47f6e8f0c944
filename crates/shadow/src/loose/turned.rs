//! Which half of the faces of solids is looked at.
//!
//! An open segment from a surface to a light that meets the surface of a solid enters the solid, if it begins outside of it, and leaves it, if the light is outside (NUMERICS.md,
//! "Solids"). So of the faces that are turned to the light and those that are turned away one half is left out: those that it would leave by, where all points lie on the solid itself or on
//! objects whose boxes have no point in common with it; else those that it would enter by. Points that are lit have none of the former before them, and so are told soonest.
//! Which meshes bound solids is found beforehand ([`Queries::find_solids`](crate::Queries::find_solids)). Edge-on faces are always kept.
//!
//! Guarantee: the faces that are kept hide a point if and only if all of them do; but where the kept ones are those that segments enter by, a point of the solid's own surface that one of
//! them touches must be asked about all. Cost: some nanoseconds a face.

use rayon::prelude::*;
use umbriel_geometry::{Facets, LightSource, Sign};

use crate::{
    embedded::{Embedded, front},
    query::Queries,
};

/// Faces that a thread takes at a time.
const AT_A_TIME: usize = 2048;

/// The faces of an object under a light; their backs are dark.
pub(super) struct Turned<'a> {
    facets: &'a Facets,
    /// Which way the right-hand normal of each looks: out of a solid, into it, or unknown.
    outward: &'a [Sign],
    /// Which way each turns as the light sees it, counter-clockwise positive.
    turns: Vec<Sign>,
    /// Which way those turn whose fronts are turned to the light.
    front: Sign,
    /// Whether those are kept that segments enter by.
    pub(super) is_entered: bool,
}

impl<'a> Turned<'a> {
    /// Of an object; `None` where no half of its faces is known to be enough. Exact.
    pub(super) fn of(
        queries: &'a Queries,
        (object, facets): (usize, &'a Facets),
        light: &LightSource,
        on_faces: bool,
    ) -> Option<Self> {
        // What is left out must be dark.
        let is_one_sided = queries.bodies.scene.objects[object].is_one_sided(|| true);
        let Embedded { outward, are_apart } = queries.solids(object).filter(|_| is_one_sided)?;
        let is_entered = on_faces && *are_apart;
        let is_outside = light.is_sun() || !queries.bodies.bounds(object).contains(light.xyz());
        (is_entered || is_outside).then(|| Self {
            facets,
            outward,
            turns: turns(facets, light),
            front: front(facets),
            is_entered,
        })
    }

    pub(super) fn turn(&self, face: usize) -> Sign {
        self.turns[face]
    }

    /// Whether it is looked at.
    #[inline(always)]
    pub(super) fn is_kept(&self, face: usize) -> bool {
        let turn = self.turns[face];
        turn == Sign::Zero || (turn == self.front) != self.is_entered || self.outward[face] != self.front
    }

    /// Whether at each of its edges as many of those that are kept begin as end there, as far as it is known. Of faces that are kept.
    pub(super) fn is_closed(&self, face: usize) -> bool {
        if self.is_entered {
            return false;
        }
        let front = self.front;
        let is_front = |side| self.facets.across(face, side).is_some_and(|beyond| self.turns[beyond as usize] == front);
        if self.outward[face] == front { (0..3).all(is_front) } else { self.facets.is_closed(face) }
    }
}

fn turns(facets: &Facets, light: &LightSource) -> Vec<Sign> {
    let mut turns = vec![Sign::Zero; facets.len()];
    turns.par_chunks_mut(AT_A_TIME).enumerate().for_each(|(part, turns)| {
        let (first, mut next) = (part * AT_A_TIME, 0);
        facets.for_each_turn::<8>(first..first + turns.len(), light, |turn| {
            turns[next] = turn;
            next += 1;
        });
    });
    turns
}

#[cfg(test)]
mod tests;
