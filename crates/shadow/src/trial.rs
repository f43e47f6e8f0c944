//! Which receivers come first where there is an end to what may be spent: if these take far more than their part of it, all would take too much, and little was spent in vain.
//!
//! About a sixteenth of them are tried, by their [`tickets`], but none whose box is far larger than the usual one: the floor under a thousand bodies may take more than all of
//! them. What those tried may spend is their part, of the receivers or of the faces, and [`DEVIATIONS`] more. Guarantee: which are tried, and what they may spend, goes by
//! boxes and faces, not by any order. What breaks it: nothing that is told; a scene that would have had enough is cut short where those tried are by chance far dearer than
//! the others of their size.

use umbriel_geometry::Aabb;

use crate::tickets;

/// Of so many receivers or more, one in 2^[`TRIED`] is tried.
const RECEIVERS: usize = 16;
const TRIED: u8 = 4;

/// Half the surface of a box, in those of the median, from which on a receiver is not tried.
const LARGE: f64 = 16.0;

/// Standard deviations by which those tried may be dearer than their part; receivers cost as unevenly as exponential waiting times.
const DEVIATIONS: f64 = 6.0;

/// Receivers, some of which come first.
#[derive(Debug)]
pub(crate) struct Trial {
    pub(crate) tried: Vec<usize>,
    pub(crate) others: Vec<usize>,
    /// The part of what all may spend that those tried may.
    pub(crate) part: f64,
}

impl Trial {
    /// Of these receivers, by their boxes and how many faces they have.
    pub(crate) fn of(receivers: Vec<usize>, bounds: impl Fn(usize) -> Aabb, faces: impl Fn(usize) -> usize) -> Self {
        if receivers.len() < RECEIVERS {
            return Self { tried: Vec::new(), others: receivers, part: 0.0 };
        }
        let mut sizes: Vec<f64> = receivers.iter().map(|&receiver| bounds(receiver).half_area()).collect();
        let middle = sizes.len() / 2;
        let most = LARGE * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
        let is_tried = |&receiver: &usize| {
            let bounds = bounds(receiver);
            bounds.half_area() <= most && tickets::halvings(tickets::of_box(&bounds)) >= TRIED
        };
        let (tried, others): (Vec<usize>, Vec<usize>) = receivers.into_iter().partition(is_tried);
        let faces_of = |some: &[usize]| some.iter().map(|&receiver| faces(receiver)).sum::<usize>() as f64;
        let (count, all) = (tried.len() as f64, (tried.len() + others.len()) as f64);
        let share = (count / all).max(faces_of(&tried) / (faces_of(&tried) + faces_of(&others)));
        let part = if tried.is_empty() { 0.0 } else { (share * (1.0 + DEVIATIONS / count.sqrt())).min(1.0) };
        Self { tried, others, part }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn small(receiver: usize) -> Aabb {
        let min = DVec3::new(0.754_877_666, 0.569_840_291, 0.438_579_021) * receiver as f64;
        Aabb { min, max: min + DVec3::ONE }
    }

    #[test]
    fn a_sixteenth_is_tried_and_may_spend_some_more() {
        let trial = Trial::of((0..4096).collect(), small, |_| 6);
        let (tried, share) = (trial.tried.len(), trial.tried.len() as f64 / 4096.0);
        assert!((192..320).contains(&tried) && tried + trial.others.len() == 4096, "{tried}");
        assert!(share < trial.part && trial.part < 1.5 * share, "{} of {share}", trial.part);
        let backwards = Trial::of((0..4096).rev().collect(), small, |_| 6);
        assert!(backwards.tried.iter().rev().eq(&trial.tried) && backwards.part == trial.part);
    }

    #[test]
    fn a_floor_is_not_tried_whatever_its_ticket() {
        // 64 m across, which has a ticket that is.
        let floor = Aabb { min: DVec3::new(-32.0, 0.0, -32.0), max: DVec3::new(32.0, 0.0, 32.0) };
        assert!(tickets::halvings(tickets::of_box(&floor)) >= TRIED);
        let bounds = |receiver: usize| if receiver == 0 { floor } else { small(receiver) };
        let trial = Trial::of((0..1000).collect(), bounds, |_| 6);
        assert!(!trial.tried.contains(&0) && trial.tried.len() > 30, "{}", trial.tried.len());
    }

    #[test]
    fn few_receivers_and_none_are_left_alone() {
        for count in [0, 1, 15] {
            let trial = Trial::of((0..count).collect(), small, |_| 6);
            assert_eq!((trial.tried.len(), trial.others.len(), trial.part), (0, count, 0.0));
        }
    }

    #[test]
    fn those_tried_may_spend_no_more_than_there_is() {
        let same = |_: usize| Aabb { min: DVec3::ZERO, max: DVec3::ONE };
        let trial = Trial::of((0..64).collect(), same, |_| 6);
        assert!(trial.part <= 1.0);
    }
}
