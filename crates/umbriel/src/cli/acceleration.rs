//! How rays are to find what they meet: what is typed, and what is told about the choice.

use clap::ValueEnum;
use umbriel_octree::ProjectionReport;
use umbriel_shadow::{Search, SearchChoice};
use umbriel_visibility::{Acceleration, Choice};

use crate::output;

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum AccelerationChoice {
    /// What should be quickest, by a model of costs
    Auto,
    /// A bounding volume hierarchy
    Bvh,
    /// An octree, from its root down
    Octree,
    /// Maps of an octree, projected from where the rays meet: the camera, or the light
    Projection,
}

impl AccelerationChoice {
    pub(crate) fn of_rays(self) -> Acceleration {
        match self {
            Self::Auto => Acceleration::Auto,
            Self::Bvh => Acceleration::Bvh,
            Self::Octree => Acceleration::Octree,
            Self::Projection => Acceleration::Projection,
        }
    }
}

/// Tells how a picture's rays find the triangles of meshes.
pub(crate) fn tell_eye(choices: &[Choice]) {
    let ways = [(Acceleration::Bvh, "BVH"), (Acceleration::Octree, "octree"), (Acceleration::Projection, "projection")];
    let told = ways.into_iter().enumerate().filter_map(|(place, (way, name))| eye_line(choices, place, way, name));
    told.for_each(|line| output::tell(&line));
}

/// Which meshes get one way, and what the model of costs expects of it and of the best other one.
fn eye_line(choices: &[Choice], place: usize, way: Acceleration, name: &str) -> Option<String> {
    let chosen = || choices.iter().filter(|choice| choice.chosen == way);
    let sum = |number: &dyn Fn(&Choice) -> f64| chosen().map(number).sum::<f64>();
    let [own, others] =
        [sum(&|choice| choice.expected[place]), sum(&|choice| least_but(&choice.expected, place))].map(milliseconds);
    let [rays, triangles] = [sum(&|choice| choice.sampled.rays as f64), sum(&|choice| choice.triangles as f64)];
    let is_unasked = way == Acceleration::Bvh && chosen().all(|choice| choice.sampled.sent == 0);
    let expected = if is_unasked {
        "too few rays for another way to pay".into()
    } else {
        format!("{rays} rays: {own:.0} ms expected on one thread, {others:.0} ms otherwise")
    };
    (chosen().count() > 0).then(|| {
        format!(
            "note: rays by {name} for {} meshes, {triangles} triangles, {expected}{}",
            chosen().count(),
            built(chosen().filter_map(|choice| choice.built))
        )
    })
}

/// So many lights are told of each by itself.
const TOLD: usize = 8;

/// Tells how the points under some lights, each with its name, find what is in their way; nothing about what is done as ever where no point asks.
pub(crate) fn tell_lights<'a>(lights: impl Iterator<Item = (&'a str, &'a SearchChoice)>) {
    let asked: Vec<_> = lights.filter(|(_, choice)| choice.points > 0).collect();
    asked.iter().take(TOLD).for_each(|(name, choice)| output::tell(&light_line(name, choice)));
    if asked.len() > TOLD {
        output::tell(&format!("note: points under {} lights more", asked.len() - TOLD));
    }
}

fn light_line(name: &str, choice: &SearchChoice) -> String {
    let SearchChoice { chosen, clutter, points, expected, .. } = choice;
    let (place, way) = match chosen {
        Search::Direct => (0, "directly"),
        Search::Bvh => (1, "by BVH"),
        Search::Octree => (2, "by octree"),
        Search::Projection => (3, "by projection"),
    };
    let [own, other] = [expected[place], least_but(expected, place)].map(milliseconds);
    format!(
        "note: points under {name} {way}: {points} points, {} triangles: {own:.0} ms expected on one thread, \
         {other:.0} ms otherwise{}",
        clutter.triangles,
        built(choice.built.into_iter())
    )
}

/// The leaves and the memory of octrees with their maps; nothing where none was built.
fn built(octrees: impl Iterator<Item = ProjectionReport>) -> String {
    let sums = octrees
        .fold((0, 0), |(leaves, bytes), octree| (leaves + octree.leaves, bytes + octree.tree_bytes + octree.map_bytes));
    match sums {
        (0, _) => String::new(),
        (leaves, bytes) => format!("; {leaves} leaves, {:.1} MiB", bytes as f64 / 1_048_576.0),
    }
}

/// The least of some numbers, but for one.
fn least_but(numbers: &[f64], place: usize) -> f64 {
    let others = numbers.iter().enumerate().filter(|(other, _)| *other != place);
    others.fold(f64::INFINITY, |least, (_, &number)| least.min(number))
}

fn milliseconds(nanoseconds: f64) -> f64 {
    nanoseconds / 1e6
}
