//! Points of the surface with exact answers, and how far other answers are from them.

use rayon::prelude::*;
use umbriel_geometry::LightSource;
use umbriel_scene::Scene;

use super::nearest::NearestPoint;
use crate::{
    Detail, Place, Queries, Request, SamplePoint, Sampling, Verdict, for_each_sample,
    rivals::{Polygons, RivalPoint},
};

/// How far answers are from the truth, by points spread evenly over the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Points that were judged.
    pub points: u64,
    /// Points that are said to be lit and are not, or the other way round.
    pub wrong: u64,
    /// Points of which nothing is said.
    pub undecided: u64,
    /// The largest distance from a wrong or undecided point to the nearest judged point of the same object where the other answer is
    /// true, metres: how far the border of the shadow may be from where it is stated. The size of the object's box where that answer is true
    /// nowhere on it; 0 if every answer is right. The spacing of the judged points is part of it.
    pub border_distance: f64,
}

impl Score {
    /// The share of the surface on which nothing right is said.
    pub fn error(&self) -> f64 {
        (self.wrong + self.undecided) as f64 / self.points.max(1) as f64
    }
}

/// Judged points with the truth about one light.
pub struct Judge {
    pub(super) samples: Vec<SamplePoint>,
    pub(super) points: Vec<RivalPoint>,
    lit: Vec<bool>,
    /// Per object: the dark points and the lit ones.
    trees: Vec<[NearestPoint; 2]>,
    /// Per object: the diagonal of its box, metres.
    sizes: Vec<f64>,
}

impl Judge {
    /// About `count` points, spread by area over all objects, and the exact answer to each. Some microseconds a point.
    pub fn new(scene: &Scene, polygons: &Polygons, light: &LightSource, count: u64) -> Self {
        Self::of_samples(scene, polygons, light, spread(scene, count))
    }

    /// The points of [`Judge::new`] alone: nobody is judged by them. Some tenths of a microsecond a point.
    pub fn without_answers(scene: &Scene, polygons: &Polygons, count: u64) -> Self {
        let (samples, points) = with_normals(polygons, spread(scene, count));
        Self { samples, points, lit: Vec::new(), trees: Vec::new(), sizes: Vec::new() }
    }

    /// At places of one's own; those without a normal, the tips of cones, are left out.
    ///
    /// # Panics
    /// If a place names an object or a face that there is not.
    pub fn of_samples(scene: &Scene, polygons: &Polygons, light: &LightSource, samples: Vec<SamplePoint>) -> Self {
        let (samples, points) = with_normals(polygons, samples);
        let queries = Queries::new(scene);
        let is_lit = |&SamplePoint { object, face, u, v, .. }: &SamplePoint| {
            queries.lit(&Place::Surface { object, face, u, v }, light).is_ok_and(|answer| answer.lit)
        };
        let lit: Vec<bool> = samples.par_iter().map(is_lit).collect();
        let mut apart = vec![[Vec::new(), Vec::new()]; scene.objects.len()];
        for (point, &lit) in points.iter().zip(&lit) {
            apart[point.object as usize][usize::from(lit)].push(point.position);
        }
        let trees = apart.into_par_iter().map(|sides| sides.map(NearestPoint::new)).collect();
        let sizes = scene.objects.iter().map(|object| object.bounds().size().length()).collect();
        Self { samples, points, lit, trees, sizes }
    }

    /// How many points there are.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The points as rivals take them.
    pub fn points(&self) -> &[RivalPoint] {
        &self.points
    }

    /// The points by face and parameters.
    pub fn samples(&self) -> &[SamplePoint] {
        &self.samples
    }

    /// The truth.
    pub fn lit(&self) -> &[bool] {
        &self.lit
    }

    /// How far an answer to each point is from the truth.
    ///
    /// # Panics
    /// If there are points and the truth about them was not asked for ([`Judge::without_answers`]).
    pub fn score(&self, stated: impl Fn(usize) -> Verdict + Sync) -> Score {
        let of_point = |number: usize| {
            let (lit, point) = (self.lit[number], &self.points[number]);
            let wrong = if lit { Verdict::Shadowed } else { Verdict::Lit };
            let stated = stated(number);
            let (is_wrong, is_undecided) = (stated == wrong, stated == Verdict::Undecided);
            let border_distance = if is_wrong || is_undecided { self.distance_to(point, !lit) } else { 0.0 };
            Score { points: 1, wrong: is_wrong.into(), undecided: is_undecided.into(), border_distance }
        };
        let sum = |a: Score, b: Score| Score {
            points: a.points + b.points,
            wrong: a.wrong + b.wrong,
            undecided: a.undecided + b.undecided,
            border_distance: a.border_distance.max(b.border_distance),
        };
        (0..self.len()).into_par_iter().map(of_point).reduce(Score::default, sum)
    }

    /// How far the nearest judged point of the object is where this is true.
    fn distance_to(&self, point: &RivalPoint, is_lit: bool) -> f64 {
        let object = point.object as usize;
        self.trees[object][usize::from(is_lit)].distance(point.position).unwrap_or(self.sizes[object])
    }
}

/// About `count` points, spread by area over all objects.
fn spread(scene: &Scene, count: u64) -> Vec<SamplePoint> {
    let request = Request { sampling: Some(Sampling::Count(count)), ..Request::everything(scene, Detail::Faces) };
    let mut samples = Vec::new();
    for_each_sample(scene, &request, |sample| samples.push(sample));
    samples
}

/// The places that have a normal, and the points there.
fn with_normals(polygons: &Polygons, samples: Vec<SamplePoint>) -> (Vec<SamplePoint>, Vec<RivalPoint>) {
    samples.into_iter().filter_map(|sample| Some((sample, polygons.point(&sample)?))).unzip()
}

impl std::fmt::Debug for Judge {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Judge").field("points", &self.points.len()).finish_non_exhaustive()
    }
}
