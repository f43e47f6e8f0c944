//! How the rays of a view find the triangles of a mesh: by a BVH, by an octree, or looked up in the octree's projection.
//!
//! All ways give the same hits. Which is quickest depends on the mesh, on the view, and on how many rays there are: a projection is built for
//! one viewpoint, so its building must pay in one picture. The BVH is there: some rays of the view are sent through it, and what they look at is
//! counted ([`StepCost`]; counts, not times, so the choice is the same everywhere). What these rays hit and how cluttered they find the BVH says what they will cost
//! in an octree too; building goes with the places of triangles in leaves, whose number integral geometry expects ([`LookupCost`],
//! [`ProjectionOptions::expected_items`]). `cargo xtask calibrate` measures the coefficients.

use std::sync::Arc;

use glam::DAffine3;
use umbriel_bvh::{Hit, Ray, Steps, TriangleBvh};
use umbriel_geometry::Mesh;
use umbriel_octree::{Projection, ProjectionOptions, ProjectionReport, Viewpoint};

use crate::view::Beam;

/// How rays find the triangles of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Acceleration {
    /// By a bounding volume hierarchy.
    Bvh,
    /// By an octree, from its root down.
    Octree,
    /// By maps of an octree's projection from the viewpoint.
    Projection,
    /// By what a [`CostModel`] says is quickest.
    #[default]
    Auto,
}

/// What a ray costs in a BVH that is there, nanoseconds; rays of a picture go sixteen at a time, and what these look at together counts once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepCost {
    /// Of any ray.
    pub ray: f64,
    /// Of a node of eight boxes.
    pub node: f64,
    /// Of a pack of eight triangles.
    pub pack: f64,
    /// Of a triangle that is measured.
    pub triangle: f64,
}

impl StepCost {
    /// Nanoseconds a ray, where so many rays looked at all of this.
    pub fn nanoseconds(&self, steps: Steps, rays: usize) -> f64 {
        let [nodes, packs, triangles] = [steps.nodes, steps.packs, steps.triangles].map(f64::from);
        self.ray + (self.node * nodes + self.pack * packs + self.triangle * triangles) / rays.max(1) as f64
    }
}

/// What rays cost in an octree that is to be built, nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookupCost {
    /// Of any ray.
    pub ray: f64,
    /// Of a node that a ray looks at in the BVH: what is cluttered there is so here.
    pub node: f64,
    /// Of a ray that hits something.
    pub hit: f64,
    /// Of what is looked at for the first time, in no cache yet, or made finer because many rays will look at it: the geometric mean of rays and places of
    /// triangles.
    pub touch: f64,
    /// Of building: each expected place of a triangle in a leaf.
    pub item: f64,
}

impl LookupCost {
    /// Nanoseconds for rays that are expected among so many places of triangles, building included.
    pub fn nanoseconds(&self, sampled: &Sampled, items: f64) -> f64 {
        let counts = Self::counts(sampled, items);
        let costs = [self.ray, self.node, self.hit, self.touch, self.item];
        counts.iter().zip(costs).map(|(count, cost)| count * cost).sum()
    }

    /// How often each of the costs arises, in the order of the fields.
    pub fn counts(sampled: &Sampled, items: f64) -> [f64; 5] {
        let share = sampled.rays as f64 / sampled.sent.max(1) as f64;
        let [nodes, hits] = [sampled.steps.nodes, sampled.steps.hits].map(|count| share * f64::from(count));
        [sampled.rays as f64, nodes, hits, (sampled.rays as f64 * items).sqrt(), items]
    }
}

/// What decides for [`Acceleration::Auto`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostModel {
    /// The BVH, which is there already.
    pub bvh: StepCost,
    /// The octree, built.
    pub octree: LookupCost,
    /// The projection, built.
    pub projection: LookupCost,
}

impl CostModel {
    /// As `cargo xtask calibrate` fits them on one thread, to the least times of four rounds (docs/projection.md).
    pub const MEASURED: Self = Self {
        bvh: StepCost { ray: 79.0, node: 161.1, pack: 10.3, triangle: 31.2 },
        octree: LookupCost { ray: 128.4, node: 136.3, hit: 120.1, touch: 216.9, item: 508.4 },
        projection: LookupCost { ray: 39.2, node: 117.7, hit: 106.0, touch: 163.9, item: 264.4 },
    };

    /// Nanoseconds for rays that are expected among triangles with so many places in leaves: BVH, octree, projection.
    pub fn expected(&self, sampled: &Sampled, items: f64) -> [f64; 3] {
        let bvh = sampled.rays as f64 * self.bvh.nanoseconds(sampled.steps, sampled.sent);
        let [octree, projection] = [self.octree, self.projection].map(|cost| cost.nanoseconds(sampled, items));
        [bvh, octree, projection]
    }

    /// The way for which the fewest nanoseconds are expected; the BVH of equals.
    pub fn quickest([bvh, octree, projection]: [f64; 3]) -> Acceleration {
        if octree.min(projection) >= bvh {
            Acceleration::Bvh
        } else if octree < projection {
            Acceleration::Octree
        } else {
            Acceleration::Projection
        }
    }
}

impl Default for CostModel {
    fn default() -> Self {
        Self::MEASURED
    }
}

/// Triangles that octrees are built of in one picture, of a kibibyte or two each, where there is more than one octree.
const IN_OCTREES: usize = 1 << 18;

/// What is known of the rays that may meet an object; nothing where the picture has so few rays that there is nothing to choose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampled {
    /// How many rays are expected.
    pub rays: u64,
    /// What some of them looked at in the BVH.
    pub steps: Steps,
    /// How many that were.
    pub sent: usize,
}

/// How the rays of a view find the triangles of an object, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Index into the scene's objects.
    pub object: usize,
    /// What was chosen; never [`Acceleration::Auto`].
    pub chosen: Acceleration,
    /// Triangles of the object.
    pub triangles: usize,
    /// What rays are expected.
    pub sampled: Sampled,
    /// Nanoseconds that the model expects: BVH, octree, projection.
    pub expected: [f64; 3],
    /// What was built, if anything.
    pub built: Option<ProjectionReport>,
}

impl Choice {
    /// What is quickest by the model, or what is asked for. O(triangles) where an octree may pay, else O(1).
    pub fn new(object: usize, acceleration: Acceleration, mesh: &Mesh, sampled: Sampled, costs: &CostModel) -> Self {
        let triangles = mesh.triangles().len();
        // There are as many places as triangles at least. Only where so few would pay they are counted.
        let mut expected = costs.expected(&sampled, triangles as f64);
        if CostModel::quickest(expected) != Acceleration::Bvh {
            expected = costs.expected(&sampled, ProjectionOptions::expected_items(mesh));
        }
        let chosen = match acceleration {
            Acceleration::Auto => CostModel::quickest(expected),
            asked => asked,
        };
        Self { object, chosen, triangles, sampled, expected, built: None }
    }

    /// The octrees that spare the most time for each triangle are built, others not: thousands of instances in one place each expect all rays of a picture.
    pub(crate) fn limit_octrees(choices: &mut [Self]) {
        let spared = |choice: &Self| {
            let [bvh, others @ ..] = choice.expected;
            (bvh - others.into_iter().fold(f64::INFINITY, f64::min)) / choice.triangles.max(1) as f64
        };
        let mut octrees: Vec<&mut Self> =
            choices.iter_mut().filter(|choice| choice.chosen != Acceleration::Bvh).collect();
        octrees.sort_by(|a, b| spared(b).total_cmp(&spared(a)).then(a.object.cmp(&b.object)));
        let mut triangles = 0;
        for (rank, choice) in octrees.into_iter().enumerate() {
            triangles += choice.triangles;
            if rank > 0 && triangles > IN_OCTREES {
                choice.chosen = Acceleration::Bvh;
            }
        }
    }
}

/// A mesh made ready for the rays of a view.
#[derive(Debug)]
pub(crate) struct Prepared {
    projection: Projection,
    is_looked_up: bool,
}

impl Prepared {
    /// What was chosen; or the BVH after all, where the view cannot be projected.
    pub(crate) fn new(choice: Choice, bvh: &TriangleBvh, to_local: &DAffine3, beam: &Beam) -> (Choice, Option<Self>) {
        let is_looked_up = choice.chosen == Acceleration::Projection;
        if choice.chosen == Acceleration::Bvh {
            return (choice, None);
        }
        let viewpoint = match *beam {
            Beam::Perspective { eye, forward, right, up } => Viewpoint::Picture {
                eye: to_local.transform_point3(eye),
                forward: to_local.transform_vector3(forward),
                right: to_local.transform_vector3(right),
                up: to_local.transform_vector3(up),
            },
            Beam::Parallel { direction } => Viewpoint::Parallel(to_local.transform_vector3(direction)),
        };
        let options = ProjectionOptions {
            max_level: ProjectionOptions::level_for(choice.triangles) + if is_looked_up { 0 } else { 2 },
            // Without maps to speak of where nothing is looked up.
            rays: if is_looked_up { choice.sampled.rays } else { 0 },
            memory: ProjectionOptions::memory_for(choice.triangles),
            ..ProjectionOptions::default()
        };
        match Projection::build(Arc::clone(bvh.mesh()), viewpoint, &options) {
            Ok(projection) => {
                let built = Some(projection.report());
                (Choice { built, ..choice }, Some(Self { projection, is_looked_up }))
            }
            Err(_) => (Choice { chosen: Acceleration::Bvh, ..choice }, None),
        }
    }

    /// The nearest hit of a local ray; `None` for one that is not of the view.
    pub(crate) fn nearest_hit(&self, ray: &Ray, t_max: f64) -> Option<Option<Hit>> {
        let Ray { origin, direction, .. } = *ray;
        let found = if self.is_looked_up {
            self.projection.nearest_hit(origin, direction, t_max)
        } else {
            self.projection.nearest_hit_by_descent(origin, direction, t_max)
        };
        found.ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many small triangles side by side.
    fn strip(triangles: usize) -> Mesh {
        let positions = (0..triangles + 2).map(|k| [(k / 2) as f64, (k % 2) as f64, 0.0]).collect();
        Mesh::new(positions, (0..triangles as u32).map(|k| [k, k + 1, k + 2]).collect()).expect("a strip")
    }

    #[test]
    fn octrees_of_one_picture_have_a_limit() {
        let choice = |object: usize, triangles: usize, spared: f64| Choice {
            object,
            chosen: Acceleration::Projection,
            triangles,
            sampled: Sampled::default(),
            expected: [spared, 2.0, 0.0],
            built: None,
        };
        let kept = |mut choices: Vec<Choice>| {
            Choice::limit_octrees(&mut choices);
            let kept = choices.into_iter().filter(|choice| choice.chosen == Acceleration::Projection);
            kept.map(|choice| choice.object).collect::<Vec<_>>()
        };
        assert_eq!(kept(vec![choice(0, 1 << 22, 1.0)]), [0], "a single one is built however large it is");
        let third = IN_OCTREES / 3;
        let many = [5.0, 7.0, 7.0, 9.0, 1.0].into_iter().enumerate();
        assert_eq!(kept(many.map(|(object, spared)| choice(object, third, spared)).collect()), [1, 2, 3]);
    }

    #[test]
    fn many_rays_pay_for_a_projection_and_few_do_not() {
        let steps = Steps { nodes: 500, packs: 300, triangles: 200, hits: 9 };
        let choice = |acceleration, rays, triangles| {
            let sampled = Sampled { rays, steps, sent: 10 };
            Choice::new(0, acceleration, &strip(triangles), sampled, &CostModel::MEASURED)
        };
        let chosen = |rays, triangles| choice(Acceleration::Auto, rays, triangles).chosen;
        assert_eq!(chosen(1 << 26, 1 << 10), Acceleration::Projection);
        assert_eq!(chosen(1 << 8, 1 << 16), Acceleration::Bvh);
        assert_eq!(chosen(0, 1), Acceleration::Bvh);
        // The same boxes and packs looked at, but everything hit, or nothing: that is what looking up costs.
        let seen = |hits| {
            let sampled =
                Sampled { rays: 1 << 21, steps: Steps { nodes: 8, packs: 30, triangles: 10, hits }, sent: 10 };
            Choice::new(0, Acceleration::Auto, &strip(1 << 18), sampled, &CostModel::MEASURED).chosen
        };
        assert_eq!([seen(10), seen(2)], [Acceleration::Bvh, Acceleration::Projection]);
        let asked = choice(Acceleration::Octree, 1, 1 << 16);
        assert_eq!(asked.chosen, Acceleration::Octree, "what is asked for is done");
    }
}
