//! Light maps: for every texel of a mesh's layout, how much of the surface that lies on it is lit.
//!
//! Each texel has 4 × 4 points on a lattice. A triangle of the layout takes the points that it holds (decided exactly,
//! edges included; the first triangle has a point on a common edge); the point's place on the face is either in a
//! decided cell or asked exactly. A texel is the lit share of its taken points, the mean over the lights. Texels
//! without any take the mean of their neighbours for a few rounds, so that a lookup between texels does not bleed.

use std::{
    ops::Range,
    sync::atomic::{AtomicU64, Ordering},
};

use rayon::prelude::*;
use umbriel_geometry::{Dyadic, LightSource, Ring, Sign, decisions::decide};
use umbriel_io::{LightmapLayout, write::GrayPicture};
use umbriel_scene::Scene;
use umbriel_shadow::{Cancelled, Expected, Place, Progress, Queries, Report, SearchChoice, SearchCosts, Verdict};
use umbriel_visibility::Acceleration;

use crate::output::{cells::CellMap, picture::open_points};

/// Points of a texel along each of its edges.
const LATTICE: usize = 4;

/// How many texels beyond the layout's triangles are filled.
const MARGIN: usize = 4;

/// All that light maps of one bake are made from.
pub(crate) struct Lightmaps<'a> {
    scene: &'a Scene,
    report: &'a Report,
    queries: Queries<'a>,
    edge: u32,
}

/// A light map, and what of the layout did not fit it.
#[derive(Debug)]
pub(crate) struct Lightmap {
    pub(crate) picture: GrayPicture,
    /// Triangles that reach beyond the picture.
    pub(crate) outside: usize,
    /// Points that lie strictly inside two triangles: two parts of the surface on one place.
    pub(crate) overlaps: usize,
}

/// A light, and the cells of the object under it.
struct Lamp {
    source: LightSource,
    cells: CellMap,
}

impl<'a> Lightmaps<'a> {
    /// Ready to make square pictures with edges of so many texels.
    pub(crate) fn new(scene: &'a Scene, report: &'a Report, edge: u32) -> Self {
        Self { scene, report, queries: Queries::new(scene), edge }
    }

    /// Makes ready for the points that no cell decides, on the maps of these objects; answers what was chosen for each light, and why.
    pub(crate) fn prepare(&mut self, objects: &[usize], asked: Acceleration) -> Vec<SearchChoice> {
        let mut points = vec![0; self.scene.objects.len()];
        objects.iter().for_each(|&object| points[object] = u64::from(self.edge).pow(2) * (LATTICE * LATTICE) as u64);
        let (queries, scene) = (&mut self.queries, self.scene);
        let lights = self.report.lights.iter().map(|light| {
            let expected = Expected::Places(open_points(light, &points));
            queries.prepare(&scene.lights[light.light].source, expected, asked, &SearchCosts::MEASURED)
        });
        lights.collect()
    }

    /// The map of a receiver, by its place in the report's lists. Cost: a lookup a point and light, and an exact query
    /// where the cells do not say; rows of texels in parallel.
    pub(crate) fn make(
        &self,
        receiver: usize,
        layout: &LightmapLayout,
        progress: &dyn Progress,
    ) -> Result<Lightmap, Cancelled> {
        let reports = self.report.lights.iter().map(|light| (light.light, &light.objects[receiver]));
        let lamps: Vec<Lamp> = (reports.clone())
            .map(|(light, object)| Lamp { source: self.scene.lights[light].source, cells: CellMap::new(&object.cells) })
            .collect();
        let object = reports.map(|(_, object)| object.object).next().unwrap_or_default();
        let edge = self.edge as usize;
        let done = AtomicU64::new(0);
        let row = |(row, faces): (usize, Vec<u32>)| {
            if progress.is_cancelled() {
                return Err(Cancelled);
            }
            let row = Row::new(layout, &faces, row, edge);
            let lit = |face: u32, uv: [f64; 2]| lamps.iter().filter(|lamp| self.is_lit(lamp, object, face, uv)).count();
            let shares = row.shares(layout, |face, uv| lit(face, uv) as f64 / lamps.len() as f64);
            progress.advance("light map", done.fetch_add(1, Ordering::Relaxed) + 1, u64::from(self.edge));
            Ok((shares, row.overlaps))
        };
        let rows = faces_of_rows(layout, edge).into_par_iter().enumerate().map(row);
        let rows = rows.collect::<Result<Vec<_>, Cancelled>>()?;
        let overlaps = rows.iter().map(|(_, overlaps)| overlaps).sum();
        let texels: Vec<Option<f64>> = rows.into_iter().flat_map(|(shares, _)| shares).collect();
        let pixels = dilated(texels, edge).into_iter().map(|share| (255.0 * share).round() as u8);
        let picture = GrayPicture { width: self.edge, height: self.edge, pixels: pixels.collect() };
        Ok(Lightmap { picture, outside: outside(layout), overlaps })
    }

    fn is_lit(&self, lamp: &Lamp, object: usize, face: u32, [u, v]: [f64; 2]) -> bool {
        match lamp.cells.at(face, u, v) {
            Some(Verdict::Lit) => true,
            Some(Verdict::Shadowed) => false,
            Some(Verdict::Undecided) | None => {
                let place = Place::Surface { object, face: face as usize, u, v };
                self.queries.lit(&place, &lamp.source).is_ok_and(|answer| answer.lit)
            }
        }
    }
}

type Triangle = [[f64; 2]; 3];

/// The whole numbers k with 0 ≤ k < `end` whose places (k + ½)/`end` may lie between the least and the greatest of a
/// triangle's coordinates; rounded outward.
fn steps(triangle: &Triangle, axis: usize, end: usize) -> Range<usize> {
    let along = triangle.map(|corner| corner[axis] * end as f64);
    let (least, most) = along.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), at| (l.min(at), m.max(at)));
    // Casting saturates at 0 and at the greatest number.
    let (first, last) = ((least.floor() as usize).saturating_sub(1), most.ceil() as usize);
    if most < 0.0 { 0..0 } else { first.min(end)..last.saturating_add(1).min(end) }
}

/// For every row of texels the triangles of the layout that may lie on it, ascending.
fn faces_of_rows(layout: &LightmapLayout, edge: usize) -> Vec<Vec<u32>> {
    let mut rows = vec![Vec::new(); edge];
    for (face, triangle) in layout.triangles.iter().enumerate() {
        if orientation(triangle[0], triangle[1], triangle[2]) != Sign::Zero {
            rows[steps(triangle, 1, edge)].iter_mut().for_each(|row| row.push(face as u32));
        }
    }
    rows
}

/// A row of texels: which triangle has which point of its lattice.
struct Row {
    number: usize,
    edge: usize,
    /// `LATTICE` lines of `edge` × `LATTICE` points: the triangle, and whether the point is strictly inside it.
    owners: Vec<Option<(u32, bool)>>,
    overlaps: usize,
}

impl Row {
    fn new(layout: &LightmapLayout, faces: &[u32], number: usize, edge: usize) -> Self {
        let mut row = Self { number, edge, owners: vec![None; LATTICE * LATTICE * edge], overlaps: 0 };
        for &face in faces {
            row.take(face, &layout.triangles[face as usize]);
        }
        row
    }

    /// Points along an edge of the whole picture.
    fn side(&self) -> usize {
        self.edge * LATTICE
    }

    /// The place of a point of the row's lattice in the layout.
    fn point(&self, line: usize, column: usize) -> [f64; 2] {
        [column, self.number * LATTICE + line].map(|step| (step as f64 + 0.5) / self.side() as f64)
    }

    /// Gives a triangle the points that it holds, edges included, as far as they are free.
    fn take(&mut self, face: u32, triangle: &Triangle) {
        let [a, b, c] = *triangle;
        let turn = orientation(a, b, c);
        for line in 0..LATTICE {
            for column in steps(triangle, 0, self.side()) {
                let point = self.point(line, column);
                let signs = [orientation(b, c, point), orientation(c, a, point), orientation(a, b, point)];
                if signs.contains(&turn.flipped()) {
                    continue;
                }
                let is_inside = !signs.contains(&Sign::Zero);
                let place = line * self.side() + column;
                match self.owners[place] {
                    None => self.owners[place] = Some((face, is_inside)),
                    Some((_, other_is_inside)) => self.overlaps += usize::from(is_inside && other_is_inside),
                }
            }
        }
    }

    /// For every texel the mean of `lit` over its points; `None` for texels without any.
    fn shares(&self, layout: &LightmapLayout, lit: impl Fn(u32, [f64; 2]) -> f64) -> Vec<Option<f64>> {
        let mut sums = vec![(0.0, 0u32); self.edge];
        for (place, owner) in self.owners.iter().enumerate() {
            let (line, column) = (place / self.side(), place % self.side());
            let Some((face, _)) = *owner else { continue };
            let uv = parameters(&layout.triangles[face as usize], self.point(line, column));
            if let Some(uv) = uv {
                sums[column / LATTICE].0 += lit(face, uv);
                sums[column / LATTICE].1 += 1;
            }
        }
        sums.into_iter().map(|(sum, count)| (count > 0).then(|| sum / f64::from(count))).collect()
    }
}

/// Twice the area of a triangle, rounded.
fn doubled_area([a, b, c]: Triangle) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Which way three points turn. Exact: a filter, then dyadic numbers.
fn orientation(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Sign {
    let (left, right) = ((b[0] - a[0]) * (c[1] - a[1]), (b[1] - a[1]) * (c[0] - a[0]));
    // Each product carries three roundings, their difference one more: four halves of EPSILON, taken twice.
    let bound = 4.0 * f64::EPSILON * (left.abs() + right.abs());
    let value = left - right;
    // Where products may have underflowed or overflowed the bound says nothing.
    let is_certain = value.abs() > bound && bound > f64::MIN_POSITIVE;
    decide(is_certain.then(|| Sign::of(value)), || {
        let [a, b, c] = [a, b, c].map(|point| point.map(Dyadic::new));
        let difference = |p: &[Dyadic; 2], axis: usize| p[axis].clone() - a[axis].clone();
        (difference(&b, 0) * difference(&c, 1) - difference(&b, 1) * difference(&c, 0)).sign()
    })
}

/// (u, v) on its face of a point in a triangle of the layout: rounded, then brought back onto the face. `None` where the
/// triangle is too thin or too large for floats.
fn parameters(triangle: &Triangle, point: [f64; 2]) -> Option<[f64; 2]> {
    let [a, b, c] = *triangle;
    let whole = doubled_area(*triangle);
    let share = |part: Triangle| Some(doubled_area(part) / whole).filter(|share| share.is_finite());
    let (u, v) = (share([a, point, c])?.clamp(0.0, 1.0), share([a, b, point])?.clamp(0.0, 1.0));
    let room = 1.0 - u;
    // The difference may have been rounded up: the float below it is on the face, zero is anyway.
    Some([u, if v < room { v } else { room.next_down().max(0.0) }])
}

/// Fills the texels round the covered ones from their eight neighbours, one ring a round; the rest is 0.
fn dilated(mut texels: Vec<Option<f64>>, edge: usize) -> Vec<f64> {
    let around = |at: usize| at.saturating_sub(1)..(at + 2).min(edge);
    for _ in 0..MARGIN {
        let mean = |texel: usize| {
            let (row, column) = (texel / edge, texel % edge);
            let neighbours = around(row).flat_map(|row| around(column).map(move |column| row * edge + column));
            let (mut sum, mut count) = (0.0, 0u32);
            for share in neighbours.filter_map(|neighbour| texels[neighbour]) {
                sum += share;
                count += 1;
            }
            (count > 0).then(|| sum / f64::from(count))
        };
        texels = (0..texels.len()).map(|texel| texels[texel].or_else(|| mean(texel))).collect();
    }
    texels.into_iter().map(Option::unwrap_or_default).collect()
}

/// Triangles that reach beyond the picture.
fn outside(layout: &LightmapLayout) -> usize {
    let inside = |triangle: &&[[f64; 2]; 3]| triangle.iter().flatten().all(|at| (0.0..=1.0).contains(at));
    layout.triangles.len() - layout.triangles.iter().filter(inside).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbriel_geometry::{Analytic, Mesh, Placement, decisions::Decisions};
    use umbriel_scene::{Light, Object, Shape, Sides};
    use umbriel_shadow::{Detail, Request, Silent, bake};

    /// A floor of 8 × 8 as two triangles, a ball of radius 1 over its middle, the sun overhead.
    fn noon(suns: &[[f64; 3]]) -> Scene {
        let corners = vec![[-4.0, 0.0, -4.0], [-4.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, -4.0]];
        let floor = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh");
        let raised = Placement::new(glam::DAffine3::from_translation(glam::DVec3::Y * 2.0)).expect("regular");
        let object = |name: &str, shape, placement| Object::new(name.into(), shape, placement, Sides::Auto);
        let floor = object("floor", Shape::Mesh(floor.into()), Placement::IDENTITY).expect("a floor");
        let ball = object("ball", Shape::from(Analytic::Sphere { radius: 1.0 }), raised).expect("a ball");
        let light = |direction: &[f64; 3]| Light::new("sun", LightSource::sun(*direction).expect("a sun"));
        Scene { objects: [floor, ball].into(), lights: suns.iter().map(light).collect(), ..Scene::default() }
    }

    /// The floor on the left half of the picture, shrunk, seen from above: −z above.
    fn layout() -> LightmapLayout {
        let [a, b, c, d] = [[0.0625, 0.125], [0.0625, 0.875], [0.4375, 0.875], [0.4375, 0.125]];
        LightmapLayout { triangles: vec![[a, b, c], [a, c, d]] }
    }

    fn lightmap(scene: &Scene, layout: &LightmapLayout, edge: u32, depth: u8) -> Lightmap {
        let detail = Detail::Depth { interior: depth, boundary: depth };
        let request = Request { keep_cells: true, ..Request::everything(scene, detail) };
        let report = bake(scene, &request, &Silent).expect("not cancelled");
        Lightmaps::new(scene, &report, edge).make(0, layout, &Silent).expect("not cancelled")
    }

    #[test]
    fn points_on_a_line_are_told_exactly() {
        let before = Decisions::of_thread();
        let turns = [0.2, 0.2f64.next_up(), 0.2f64.next_down()].map(|y| orientation([0.1; 2], [0.3; 2], [0.2, y]));
        assert_eq!(turns, [Sign::Zero, Sign::Positive, Sign::Negative]);
        assert_eq!((Decisions::of_thread() - before).exact, 3, "one ulp is beyond the filter");
    }

    #[test]
    fn the_shadow_of_a_ball_is_a_disk() {
        let scene = noon(&[[0.0, -1.0, 0.0]]);
        let edge = 64;
        let map = lightmap(&scene, &layout(), edge, 5);
        assert_eq!((map.outside, map.overlaps), (0, 0));
        // The floor has 24 × 48 texels there: a third of a metre wide, a sixth high.
        for (row, column) in (8..56).flat_map(|row| (4..28).map(move |column| (row, column))) {
            let points = (0..16).map(|k| {
                let along = |texel: usize, from: f64, part: usize, size: f64| {
                    (texel as f64 + (part as f64 + 0.5) / 4.0 - from) / size * 8.0 - 4.0
                };
                (along(column, 4.0, k % 4, 24.0), along(row, 8.0, k / 4, 48.0))
            });
            let lit = points.filter(|(x, z)| x * x + z * z > 1.0).count() as f64;
            let texel = map.picture.pixels[row * edge as usize + column];
            assert_eq!(texel, (255.0 * lit / 16.0).round() as u8, "row {row}, column {column}");
        }
    }

    #[test]
    fn cells_change_nothing() {
        let scene = noon(&[[0.3, -1.0, 0.2]]);
        let maps = [0, 3, 7].map(|depth| lightmap(&scene, &layout(), 32, depth).picture);
        assert!(maps[0] == maps[1] && maps[1] == maps[2]);
    }

    #[test]
    fn lights_are_averaged_and_borders_are_filled() {
        // The second sun stands below: the closed ball is lit, the open floor is two-sided and lit from below.
        let scene = noon(&[[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]);
        let map = lightmap(&scene, &layout(), 64, 4).picture;
        let texel = |row: usize, column: usize| map.pixels[row * 64 + column];
        assert_eq!((texel(32, 16), texel(10, 6)), (128, 255), "under the ball one of two suns");
        assert_eq!((texel(10, 0), texel(10, 31), texel(10, 32)), (255, 255, 0), "four texels of margin");
    }

    #[test]
    fn layouts_that_do_not_fit_are_told() {
        let scene = noon(&[[0.0, -1.0, 0.0]]);
        let mut twice = layout();
        twice.triangles[1] = twice.triangles[0];
        let map = lightmap(&scene, &twice, 16, 3);
        assert!(map.overlaps > 100, "{}", map.overlaps);
        let mut wild = layout();
        wild.triangles[1] = [[-1e308, 0.0], [1e308, 1e308], [f64::MIN_POSITIVE, -1e308]];
        wild.triangles[0] = [[0.2, 0.2], [0.2, 0.2], [0.3, 0.3]];
        let map = lightmap(&scene, &wild, 16, 3);
        assert_eq!((map.outside, map.overlaps), (1, 0));
    }

    #[test]
    fn parameters_stay_on_the_face() {
        let triangle = [[0.1, 0.7], [0.9, 0.3], [0.3, 0.1]];
        for (a, b) in [(0.0, 0.0), (1e-20, 1.0), (0.3, 0.7), (1.0, 0.0), (0.2, 0.3)] {
            let at = |axis: usize| {
                triangle[0][axis]
                    + a * (triangle[1][axis] - triangle[0][axis])
                    + b * (triangle[2][axis] - triangle[0][axis])
            };
            let [u, v] = parameters(&triangle, [at(0), at(1)]).expect("a place");
            assert!((u - a).abs() < 1e-15 && (v - b).abs() < 1e-15, "({u}, {v})");
            assert!((Dyadic::new(1.0) - Dyadic::new(u) - Dyadic::new(v)).sign() != Sign::Negative);
        }
    }
}
