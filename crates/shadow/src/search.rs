//! How single points find what is in their way to a light.
//!
//! *Problem.* [`Queries`] goes down trees of boxes with the shaft from a point to the light, and asks every face exactly that it comes
//! near. Where many points ask about one light, their segments end in one point, or run parallel: rays as a picture has them.
//! *Ways.* A BVH over all triangles ([`TriangleBvh`]), an octree seen from the light, from its root down, or looked up in maps of its
//! projection (Wei, Geng and Zhang 2015; [`Projection`]). [`Queries::prepare`] builds what a model of costs chooses, or what is
//! asked for.
//!
//! *Guarantee.* The same answers, exact. Trees hold the triangles of flat faces without holes; they tell what certainly blocks, and
//! ask about what is in doubt by the definition, with the point's own face known. Everything else (curved bodies, holes) is found by
//! shafts as before.
//!
//! *Cost.* [`SearchCosts`]: nanoseconds a point, a triangle and a place in a leaf, building included. Memory: some 100 bytes a triangle for the BVH, some
//! hundred and more for maps, at most [`ProjectionOptions::memory`].

use std::{
    ops::ControlFlow,
    sync::{Arc, OnceLock},
};

use umbriel_bvh::{BoxTree, Shaft, TriangleBvh};
use umbriel_geometry::{Aabb, LightSource, Mesh, Ring, blocking::Probe};
use umbriel_octree::{Projection, ProjectionOptions, ProjectionReport, Renewal, Viewpoint};
use umbriel_scene::first_alike;
use umbriel_visibility::Acceleration;

use crate::{
    bodies::{Bodies, Body},
    exact::{Own, face_blocks},
    query::Queries,
    rivals::triangles_of,
};

/// How points find what is in their way to a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// As ever: shafts through trees of boxes, many loose points through light space.
    Direct,
    /// By a BVH over all triangles.
    Bvh,
    /// By an octree seen from the light, from its root down.
    Octree,
    /// By maps of the octree's projection from the light.
    Projection,
}

/// How many points will be asked about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// Points asked one by one.
    Places(u64),
    /// Points by coordinates asked together ([`Queries::lit_many`]). Points of faces asked together need no preparing: from a few hundred of them on no way is
    /// sooner than light space, where faces that are turned away cost nothing and a face does not meet its own points.
    Loose(u64),
}

impl Expected {
    fn count(self) -> u64 {
        match self {
            Self::Places(count) | Self::Loose(count) => count,
        }
    }
}

/// What points cost one way, nanoseconds: so many among n triangles take points · (base + doubling · log₂ n) + touch · √(points · places) + triangle · n + item · places. The
/// last two are building.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointCost {
    /// Of any point.
    pub base: f64,
    /// More for each doubling of the triangles.
    pub doubling: f64,
    /// Of what is looked at for the first time, in no cache yet, or made finer because many will look at it: the geometric mean of points and places.
    pub touch: f64,
    /// Of each triangle, whatever the points.
    pub triangle: f64,
    /// Of each place of a triangle in an octree's leaves: large triangles have many, and meet much in light space too.
    pub item: f64,
}

impl PointCost {
    /// Nanoseconds for so many points.
    pub fn nanoseconds(&self, points: u64, clutter: Clutter) -> f64 {
        let (points, triangles) = (points as f64, clutter.triangles.max(1) as f64);
        let each = self.base + self.doubling * triangles.log2();
        points * each
            + self.touch * (points * clutter.items).sqrt()
            + self.triangle * triangles
            + self.item * clutter.items
    }
}

/// What stands between points and a light, as far as costs go.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clutter {
    /// Triangles that trees hold, or would.
    pub triangles: usize,
    /// Places that they are expected to have in an octree's leaves ([`ProjectionOptions::expected_items`]).
    pub items: f64,
}

impl Clutter {
    /// O(triangles): areas and perimeters are added up.
    fn of(bodies: &Bodies) -> Self {
        let flat = || (0..bodies.scene.objects.len()).filter_map(|object| Some((object, facets_of(bodies, object)?)));
        let bounds = flat().fold(Aabb::EMPTY, |all, (object, _)| all.union(bodies.bounds(object)));
        let corners = flat().flat_map(|(_, facets)| {
            let triangles = triangles_of(facets).into_iter();
            triangles.map(|(corners, _)| corners.map(|corner| facets.positions()[corner as usize]))
        });
        let (triangles, items) = ProjectionOptions::expected_items_of(corners, &bounds);
        Self { triangles, items }
    }
}

/// What the ways of a kind of points cost: nanoseconds on one thread, building included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WayCosts {
    /// Shafts for points asked one by one, light space for those asked together.
    pub direct: PointCost,
    /// The BVH.
    pub bvh: PointCost,
    /// The octree.
    pub octree: PointCost,
    /// Maps.
    pub projection: PointCost,
}

/// What decides for [`Acceleration::Auto`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchCosts {
    /// For [`Expected::Places`] that ask for a lamp.
    pub lamp: WayCosts,
    /// For [`Expected::Places`] that ask for a sun: its octrees have one map where a lamp's may have six, and its segments are longer.
    pub sun: WayCosts,
    /// For [`Expected::Loose`].
    pub loose: WayCosts,
}

impl SearchCosts {
    /// As `cargo xtask calibrate` fits them on one thread, to the least times of four rounds (docs/projection.md).
    pub const MEASURED: Self = Self {
        lamp: WayCosts {
            direct: PointCost { base: 0.0, doubling: 52.7, touch: 315.3, triangle: 507.6, item: 2.9 },
            bvh: PointCost { base: 46.4, doubling: 27.4, touch: 3.2, triangle: 276.8, item: 2.2 },
            octree: PointCost { base: 305.7, doubling: 0.0, touch: 412.7, triangle: 1746.8, item: 166.6 },
            projection: PointCost { base: 277.5, doubling: 0.0, touch: 303.2, triangle: 155.7, item: 225.4 },
        },
        sun: WayCosts {
            direct: PointCost { base: 1066.3, doubling: 6.9, touch: 66.8, triangle: 530.7, item: 15.2 },
            bvh: PointCost { base: 230.8, doubling: 16.5, touch: 10.0, triangle: 272.0, item: 3.1 },
            octree: PointCost { base: 328.2, doubling: 0.0, touch: 401.6, triangle: 1113.4, item: 378.3 },
            projection: PointCost { base: 79.1, doubling: 14.9, touch: 347.3, triangle: 333.8, item: 216.8 },
        },
        loose: WayCosts {
            direct: PointCost { base: 30.5, doubling: 0.0, touch: 31.7, triangle: 475.0, item: 31.8 },
            bvh: PointCost { base: 3.7, doubling: 15.9, touch: 0.0, triangle: 281.1, item: 1.2 },
            octree: PointCost { base: 314.7, doubling: 0.0, touch: 158.4, triangle: 1709.7, item: 198.9 },
            projection: PointCost { base: 93.0, doubling: 0.0, touch: 258.5, triangle: 60.0, item: 242.7 },
        },
    };

    /// What the points that are expected cost.
    pub fn of(&self, expected: Expected, light: &LightSource) -> &WayCosts {
        match expected {
            Expected::Loose(_) => &self.loose,
            Expected::Places(_) if light.is_sun() => &self.sun,
            Expected::Places(_) => &self.lamp,
        }
    }
}

impl Default for SearchCosts {
    fn default() -> Self {
        Self::MEASURED
    }
}

/// How the points of a light find their way, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchChoice {
    /// What was chosen.
    pub chosen: Search,
    /// What trees hold, or would.
    pub clutter: Clutter,
    /// Points that are expected.
    pub points: u64,
    /// Nanoseconds that the model expects: direct, BVH, octree, projection.
    pub expected: [f64; 4],
    /// The octree that was built, if one was.
    pub built: Option<ProjectionReport>,
}

impl SearchChoice {
    const WAYS: [Search; 4] = [Search::Direct, Search::Bvh, Search::Octree, Search::Projection];

    /// What is quickest by the model, or what is asked for.
    pub fn new(asked: Acceleration, points: u64, clutter: Clutter, costs: &WayCosts) -> Self {
        let WayCosts { direct, bvh, octree, projection } = *costs;
        let expected = [direct, bvh, octree, projection].map(|cost| cost.nanoseconds(points, clutter));
        let chosen = match asked {
            Acceleration::Bvh => Search::Bvh,
            Acceleration::Octree => Search::Octree,
            Acceleration::Projection => Search::Projection,
            Acceleration::Auto => {
                let quicker = |a: usize, b: usize| if expected[b] < expected[a] { b } else { a };
                Self::WAYS[(1..4).fold(0, quicker)]
            }
        };
        Self { chosen, clutter, points, expected, built: None }
    }
}

/// What trees hold of a scene, and what they do not.
#[derive(Debug)]
pub(crate) struct Flats {
    mesh: Arc<Mesh>,
    /// Object and face of each triangle.
    owners: Vec<(u32, u32)>,
    bvh: OnceLock<TriangleBvh>,
    /// The other objects, and a tree over their boxes.
    others: Vec<usize>,
    boxes: BoxTree,
}

impl Flats {
    pub(crate) fn new(bodies: &Bodies) -> Self {
        let (mut positions, mut triangles, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        let mut others = Vec::new();
        for (object, first) in first_alike(&bodies.scene.objects).into_iter().enumerate() {
            let Some(facets) = facets_of(bodies, object) else {
                others.push(object);
                continue;
            };
            // What it repeats is there: points of its own faces lie in the planes of those, and these do not block them.
            if first != object {
                continue;
            }
            let first = positions.len() as u32;
            positions.extend(facets.positions().iter().map(|position| position.to_array()));
            let mut cut = triangles_of(facets);
            cut.retain(|&(_, face)| !facets.is_repeat(face as usize));
            triangles.extend(cut.iter().map(|(corners, _)| corners.map(|corner| corner + first)));
            owners.extend(cut.iter().map(|&(_, face)| (object as u32, face)));
        }
        let boxes: Vec<Aabb> = others.iter().map(|&object| bodies.bounds(object)).collect();
        let mesh = Mesh::new(positions, triangles).expect("placed faces have accepted corners");
        Self { mesh: Arc::new(mesh), owners, bvh: OnceLock::new(), others, boxes: BoxTree::build(&boxes) }
    }

    /// Built by all threads: to be called before many ask at once, since one that helps to build it may take up another's question meanwhile and wait for itself.
    fn bvh(&self) -> &TriangleBvh {
        self.bvh.get_or_init(|| TriangleBvh::build(Arc::clone(&self.mesh)))
    }
}

/// The faces of a flat body without holes.
fn facets_of<'a>(bodies: &'a Bodies, object: usize) -> Option<&'a umbriel_geometry::Facets> {
    match bodies.get(object) {
        Body::Flat(facets) if !bodies.has_holes(object) => Some(facets),
        _ => None,
    }
}

/// What was built for a light.
#[derive(Debug)]
pub(crate) struct Lookup {
    pub(crate) light: LightSource,
    /// `None` for the BVH.
    octree: Option<Octree>,
}

#[derive(Debug)]
struct Octree {
    projection: Projection,
    is_looked_up: bool,
}

impl Queries<'_> {
    /// Makes ready for points that ask about `light`: builds what `asked` says, or the model of costs; answers what was chosen, and
    /// why. Answers do not change, and other lights stay possible.
    ///
    /// O(triangles × levels) for an octree, O(n log n) for the BVH, which all lights share.
    pub fn prepare(
        &mut self,
        light: &LightSource,
        expected: Expected,
        asked: Acceleration,
        costs: &SearchCosts,
    ) -> SearchChoice {
        let choice = SearchChoice::new(asked, expected.count(), Clutter::of(&self.bodies), costs.of(expected, light));
        self.lookups.retain(|lookup| lookup.light != *light);
        let is_looked_up = choice.chosen == Search::Projection;
        let octree = match choice.chosen {
            Search::Direct => return choice,
            Search::Bvh => None,
            Search::Octree | Search::Projection => {
                let options = ProjectionOptions {
                    max_level: ProjectionOptions::level_for(choice.clutter.triangles)
                        + if is_looked_up { 0 } else { 2 },
                    // Without maps to speak of where nothing is looked up.
                    rays: if is_looked_up { choice.points } else { 0 },
                    memory: ProjectionOptions::memory_for(choice.clutter.triangles),
                    ..ProjectionOptions::default()
                };
                let built = Projection::build(Arc::clone(&self.flats().mesh), Viewpoint::of_light(light), &options);
                built.ok().map(|projection| Octree { projection, is_looked_up })
            }
        };
        let chosen = if octree.is_some() { choice.chosen } else { Search::Bvh };
        let report = octree.as_ref().map(|octree| octree.projection.report());
        if chosen == Search::Bvh {
            self.flats().bvh();
        }
        self.lookups.push(Lookup { light: *light, octree });
        SearchChoice { chosen, built: report, ..choice }
    }

    /// Makes ready as `former` is, whose scene had some objects elsewhere: maps are renewed only where something moved
    /// ([`Projection::renewed`]). Answers what was made anew, one for each light with an octree.
    pub fn prepare_after(&mut self, former: &Queries) -> Vec<Renewal> {
        let mut renewals = Vec::new();
        for Lookup { light, octree } in &former.lookups {
            let renewed = octree.as_ref().and_then(|Octree { projection, is_looked_up }| {
                let (projection, renewal) = projection.renewed(Arc::clone(&self.flats().mesh)).ok()?;
                renewals.push(renewal);
                Some(Octree { projection, is_looked_up: *is_looked_up })
            });
            if renewed.is_none() {
                self.flats().bvh();
            }
            self.lookups.retain(|lookup| lookup.light != *light);
            self.lookups.push(Lookup { light: *light, octree: renewed });
        }
        renewals
    }

    fn flats(&self) -> &Flats {
        self.flats.get_or_init(|| Flats::new(&self.bodies))
    }

    /// What was made ready for a light.
    pub(crate) fn lookup(&self, light: &LightSource) -> Option<&Lookup> {
        self.lookups.iter().find(|lookup| lookup.light == *light)
    }

    /// Whether any face meets the open segment from the point to the light of the lookup.
    pub(crate) fn is_blocked_by<R: Ring>(&self, lookup: &Lookup, probe: &Probe<R>, own: Own) -> bool {
        let (flats, light) = (self.flats(), &lookup.light);
        let (position, slack) = (probe.bounds.position, probe.bounds.slack.max_element());
        let decide = |triangle: u32| {
            let (object, face) = flats.owners[triangle as usize];
            face_blocks(&self.bodies, (object as usize, face as usize), probe, own, light)
        };
        let is_blocked = match &lookup.octree {
            None => flats.bvh().towards(*light).any_hit_where(position, slack, decide),
            Some(Octree { projection, is_looked_up: true }) => {
                projection.segments().any_hit_where(position, slack, decide)
            }
            Some(Octree { projection, .. }) => projection.segments_by_descent().any_hit_where(position, slack, decide),
        };
        is_blocked || !flats.others.is_empty() && self.is_blocked_by_others(flats, probe, own, light)
    }

    fn is_blocked_by_others<R: Ring>(&self, flats: &Flats, probe: &Probe<R>, own: Own, light: &LightSource) -> bool {
        let shaft = Shaft::new(&probe.bounds.bounds(), light);
        let blocks = |other: u32| match self.object_blocks(flats.others[other as usize], &shaft, probe, own, light) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        flats.boxes.for_each_in_shaft(&shaft, blocks).is_break()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_quickest_to_build_serves_few_points_and_what_is_quick_many() {
        let clutter = |triangles: usize| Clutter { triangles, items: 5.0 * triangles as f64 };
        let sun = LightSource::sun([0.0, 1.0, 0.0]).expect("up");
        let choice = |asked, expected: Expected, triangles| {
            SearchChoice::new(asked, expected.count(), clutter(triangles), SearchCosts::MEASURED.of(expected, &sun))
        };
        let chosen = |expected, triangles| choice(Acceleration::Auto, expected, triangles).chosen;
        assert_eq!(chosen(Expected::Places(3), 1 << 20), Search::Bvh);
        assert_eq!(chosen(Expected::Places(1 << 17), 1 << 14), Search::Bvh);
        assert_eq!(chosen(Expected::Places(1 << 20), 1 << 10), Search::Projection);
        assert_eq!(chosen(Expected::Loose(1 << 22), 1 << 16), Search::Direct, "light space is quick");
        let lamp = LightSource::point([0.0, 1.0, 0.0]).expect("a lamp");
        let of = |expected, light| SearchCosts::MEASURED.of(expected, light).bvh;
        assert_eq!(of(Expected::Places(1), &sun), SearchCosts::MEASURED.sun.bvh);
        assert_eq!(of(Expected::Places(1), &lamp), SearchCosts::MEASURED.lamp.bvh);
        assert_eq!(of(Expected::Loose(1), &lamp), SearchCosts::MEASURED.loose.bvh);
        assert_ne!(SearchCosts::MEASURED.sun, SearchCosts::MEASURED.lamp);
        let asked = choice(Acceleration::Octree, Expected::Places(1), 1 << 20);
        assert_eq!(asked.chosen, Search::Octree, "what is asked for is done");
    }
}
