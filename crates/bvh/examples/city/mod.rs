//! Ten thousand boxes drawn from fixed seeds: suburbs, a downtown, houses of five parts, and a heap that floats.

use glam::DVec3;
use umbriel_bvh::{Families, Member};
use umbriel_geometry::{Aabb, LightDefect, LightSource};

/// Metres from one lot to the next.
const LOT: f64 = 20.0;

/// Boxes and how they lie together.
pub(crate) struct Plan {
    /// What it is.
    pub(crate) name: &'static str,
    /// World coordinates, metres.
    pub(crate) boxes: Vec<Aabb>,
    /// None, unless the plan is one of houses with parts.
    pub(crate) families: Families,
}

/// All plans, ten thousand boxes each.
pub(crate) fn plans() -> [Plan; 5] {
    let houses = houses();
    let loose = Plan { name: "the same, no families", boxes: houses.boxes.clone(), families: Families::default() };
    [lots("suburbs", [0.2, 0.4], [3.0, 9.0], 1), lots("downtown", [0.7, 1.0], [15.0, 120.0], 2), houses, loose, heap()]
}

/// A high sun, a low one, a street lamp in the middle, and a lamp above all roofs.
pub(crate) fn lights() -> Result<[(&'static str, LightSource); 4], LightDefect> {
    Ok([
        ("sun at 60°", LightSource::sun([0.3, -1.0, 0.49])?),
        ("sun at 8°", LightSource::sun([0.6, -0.14, -0.8])?),
        ("street lamp", LightSource::point([1000.25, 5.0, 1000.25])?),
        ("lamp on a tower", LightSource::point([1000.25, 200.0, 1000.25])?),
    ])
}

/// A ground and 9,999 buildings, one a lot; the shares of a lot's width and the heights that they have at least and
/// at most.
fn lots(name: &'static str, widths: [f64; 2], heights: [f64; 2], seed: u64) -> Plan {
    let mut random = Random(seed);
    let building = |lot: u32| {
        let size = DVec3::new(random.between(widths) * LOT, random.between(heights), random.between(widths) * LOT);
        standing(corner_of(lot, 100), size)
    };
    let buildings: Vec<Aabb> = (0..9_999).map(building).collect();
    Plan { name, boxes: ground().chain(buildings).collect(), families: Families::default() }
}

/// A ground and 2,000 houses of walls, two roofs, a chimney and a shed, in quarters of twenty.
fn houses() -> Plan {
    let mut random = Random(3);
    let mut boxes = Vec::from_iter(ground());
    let mut families = Families { members: vec![Vec::new(); 100], roots: vec![Member::Object(0)] };
    families.roots.extend((0..100).map(Member::Family));
    // The last of the 10,000 boxes is taken by the ground.
    for house in 0..2_000 {
        let (corner, width, height) = (corner_of(house, 45), random.between([8.0, 14.0]), random.between([5.0, 12.0]));
        let part = |from: [f64; 3], size: [f64; 3]| standing(corner + DVec3::from_array(from), DVec3::from_array(size));
        let parts = [
            part([0.0; 3], [width, height, width]),
            part([-0.5, height, -0.5], [width + 1.0, 1.0, width + 1.0]),
            part([1.0, height + 1.0, 1.0], [width - 2.0, 1.0, width - 2.0]),
            part([2.0, height + 2.0, 2.0], [0.75, 1.5, 0.75]),
            part([width + 1.0, 0.0, 0.0], [2.5, 2.25, 2.5]),
        ];
        let first = boxes.len() as u32;
        boxes.extend(parts.into_iter().take(10_000 - boxes.len()));
        let family = families.members.len() as u32;
        families.members[house as usize / 20].push(Member::Family(family));
        families.members.push((first..boxes.len() as u32).map(Member::Object).collect());
    }
    Plan { name: "houses of five parts", boxes, families }
}

/// Boxes that float anywhere and meet one another now and then.
fn heap() -> Plan {
    let mut random = Random(4);
    let mut point = |range: [f64; 2]| DVec3::new(random.between(range), random.between(range), random.between(range));
    let boxes = (0..10_000).map(|_| standing(point([0.0, 2000.0]), point([5.0, 60.0]))).collect();
    Plan { name: "floating heap", boxes, families: Families::default() }
}

fn ground() -> impl Iterator<Item = Aabb> {
    std::iter::once(standing(DVec3::ZERO, DVec3::new(100.0 * LOT, 0.0, 100.0 * LOT)))
}

/// Where a lot begins in a square of lots.
fn corner_of(lot: u32, across: u32) -> DVec3 {
    DVec3::new(f64::from(lot % across), 0.0, f64::from(lot / across)) * LOT
}

fn standing(corner: DVec3, size: DVec3) -> Aabb {
    Aabb { min: corner, max: corner + size }
}

/// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
struct Random(u64);

impl Random {
    fn between(&mut self, [least, most]: [f64; 2]) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        least + (most - least) * (((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64)
    }
}
