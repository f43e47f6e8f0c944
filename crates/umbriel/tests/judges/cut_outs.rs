//! Triangles with holes: closed forms, and chance against a judge of their own.
//!
//! The judge intersects every ray with every triangle in plain floats (Möller and Trumbore 1997) and reads the texture by the
//! book. Where it is near a border of any kind, it says nothing.

use std::sync::Arc;

use crate::oracle::dice::Dice;
use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{
    Analytic, LightSource, Mesh, Placement, Rectangle,
    cut_out::{AlphaMap, CutOut, CutOutPart, Filter, TexturePoint, Wrap},
};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{
    CellMethod, Detail, FacePoint, ObjectReport, Place, Points, Queries, Report, Request, Sampling, Silent, Verdict,
    bake, for_each_sample,
};

fn object(name: &str, shape: Shape, map: DAffine3) -> Object {
    let placement = Placement::new(map).expect("regular");
    Object::new(name.into(), shape, placement, Sides::Two).expect("an object")
}

/// A square of two triangles over (−1..1)² at height zero, its texture coordinates 0 to `repeats`.
fn sheet(cut_out: CutOut, repeats: f64) -> Mesh {
    let corners = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]];
    let place = |[x, _, z]: [f64; 3]| [(x + 1.0) * 0.5 * repeats, (z + 1.0) * 0.5 * repeats];
    let vertices = corners.map(|corner| TexturePoint { place: place(corner), alpha: 1.0 }).to_vec();
    let part = CutOutPart { faces: 0..2, cut_out, first_vertex: 0, vertices };
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh");
    mesh.with_cut_outs(vec![part]).expect("cut-outs")
}

fn cut_out(map: AlphaMap, filter: Filter, wrap: [Wrap; 2]) -> CutOut {
    CutOut { map: Some(Arc::new(map)), filter, wrap, factor: 1.0, cutoff: 0.5 }
}

fn checkers(side: u32) -> AlphaMap {
    let texel = |k: u32| if (k % side + k / side).is_multiple_of(2) { AlphaMap::ONE } else { 0 };
    AlphaMap::new([side; 2], (0..side * side).map(texel).collect()).expect("a map")
}

/// A sheet one metre over a floor of 4 × 4 metres.
fn sheet_over_floor(mesh: Mesh, sun: [f64; 3]) -> Scene {
    let sun = LightSource::sun(sun).expect("a sun");
    let above = DAffine3::from_translation(DVec3::Y);
    Scene {
        objects: [
            object("floor", Shape::Rectangle(Rectangle { size: [4.0; 2] }), DAffine3::IDENTITY),
            object("sheet", Shape::Mesh(Arc::new(mesh)), above),
        ]
        .into(),
        lights: vec![Light::new("sun", sun)],
        ..Scene::default()
    }
}

fn baked(scene: &Scene, boundary: u8, method: CellMethod) -> Report {
    let detail = Detail::Depth { interior: boundary, boundary };
    let request = Request { keep_cells: true, method, ..Request::everything(scene, detail) };
    bake(scene, &request, &Silent).expect("nobody cancels")
}

fn of_object(report: &Report, object: usize) -> &ObjectReport {
    &report.lights[0].objects[object]
}

/// Whether a lower bound is all of an object's area but for its rounding outward.
fn is_all(report: &ObjectReport, lower: f64) -> bool {
    lower >= report.area - 2.0 * report.area_error && lower > 0.0
}

#[test]
fn half_of_a_checkerboard_is_shadow() {
    // Sun overhead and aslant: the shadow is the sheet's own form either way.
    for sun in [[0.0, -1.0, 0.0], [0.25, -1.0, -0.5]] {
        for side in [2, 4, 8] {
            let scene = sheet_over_floor(sheet(cut_out(checkers(side), Filter::Nearest, [Wrap::Repeat; 2]), 1.0), sun);
            let mut last = f64::INFINITY;
            for depth in 3..8 {
                let report = baked(&scene, depth, CellMethod::Auto);
                let floor = of_object(&report, 0);
                assert!(floor.lit.lower <= 14.0 && 14.0 <= floor.lit.upper, "{side} texels: {:?}", floor.lit);
                assert!(floor.undecided() <= last, "finer cells prove more");
                last = floor.undecided();
                let sheet = of_object(&report, 1);
                assert!(is_all(sheet, sheet.lit.lower) && sheet.area == 4.0, "holes count as area that is lit");
            }
            // What is left are the texels' borders and the diagonal: lines of some 4 · side metres, a cell wide.
            assert!(last < 4.0 * (f64::from(side) + 3.0) * 3.0 * 4.0 / 128.0, "{side} texels: {last} m² undecided");
            assert!((of_object(&baked(&scene, 7, CellMethod::Auto), 0).lit.estimate - 14.0).abs() < 0.05);
        }
    }
}

#[test]
fn a_ramp_reaches_the_cutoff_on_a_line() {
    // Two texels, clear and opaque: linear between their middles, ½ at x = 0; so half of the sheet blocks.
    let ramp = || AlphaMap::new([2, 1], vec![0, AlphaMap::ONE]).expect("a map");
    // Repeated, the texture falls again beyond its last middle, and reaches the cutoff once more at the sheet's border.
    for wrap in [Wrap::ClampToEdge, Wrap::Repeat, Wrap::MirroredRepeat] {
        let scene = sheet_over_floor(sheet(cut_out(ramp(), Filter::Linear, [wrap; 2]), 1.0), [0.0, -1.0, 0.0]);
        let floor_lit = of_object(&baked(&scene, 7, CellMethod::Auto), 0).lit;
        assert!(floor_lit.lower <= 14.0 && 14.0 <= floor_lit.upper, "{floor_lit:?}");
        let queries = Queries::new(&scene);
        let lit = |x: f64| {
            let place = Place::Surface { object: 0, face: 0, u: 0.5 + x / 4.0, v: 0.375 };
            queries.lit(&place, &scene.lights[0].source).expect("a point").lit
        };
        let below = |x: f64| (0.5 + x / 4.0).next_down() * 4.0 - 2.0;
        assert!(lit(-0.75) && lit(below(0.0)), "{wrap:?}");
        assert!(!lit(0.0) && !lit(0.25), "alpha at the cutoff is opaque");
    }
}

#[test]
fn a_square_in_the_middle_of_repeats() {
    // One texel of nine is opaque; three repeats: nine squares of (2/9)² m², mirrored or not.
    let mut texels = vec![0; 9];
    texels[4] = AlphaMap::ONE;
    for wrap in [Wrap::Repeat, Wrap::MirroredRepeat] {
        let map = AlphaMap::new([3, 3], texels.clone()).expect("a map");
        let scene = sheet_over_floor(sheet(cut_out(map, Filter::Nearest, [wrap; 2]), 3.0), [0.125, -1.0, 0.25]);
        let lit = of_object(&baked(&scene, 7, CellMethod::Auto), 0).lit;
        let truth = 16.0 - 9.0 * 4.0 / 81.0;
        assert!(lit.lower <= truth && truth <= lit.upper, "{lit:?} does not hold {truth}");
        assert!(lit.upper - lit.lower < 1.0, "{lit:?}");
    }
    // Clamped, only the first repeat has one.
    let map = AlphaMap::new([3, 3], texels).expect("a map");
    let scene = sheet_over_floor(sheet(cut_out(map, Filter::Nearest, [Wrap::ClampToEdge; 2]), 3.0), [0.0, -1.0, 0.0]);
    let lit = of_object(&baked(&scene, 7, CellMethod::Auto), 0).lit;
    let truth = 16.0 - 4.0 / 81.0;
    assert!(lit.lower <= truth && truth <= lit.upper, "{lit:?} does not hold {truth}");
}

#[test]
fn clear_triangles_block_nothing_and_opaque_ones_as_any() {
    let plain = |alpha: u16| AlphaMap::new([4, 4], vec![alpha; 16]).expect("a map");
    let of = |alpha: u16| {
        let mesh = sheet(cut_out(plain(alpha), Filter::Linear, [Wrap::Repeat; 2]), 1.0);
        let scene = sheet_over_floor(mesh, [0.25, -1.0, -0.5]);
        let report = baked(&scene, 6, CellMethod::Auto);
        (of_object(&report, 0).lit, is_all(of_object(&report, 0), of_object(&report, 0).lit.lower))
    };
    assert!(of(0).1, "{:?}", of(0));
    let (whole, _) = of(AlphaMap::ONE);
    assert!(whole.lower <= 12.0 && 12.0 <= whole.upper && whole.upper - whole.lower < 1.5, "{whole:?}");
}

/// What a sheet was made from, for the judge.
struct Described {
    cut_out: CutOut,
    repeats: f64,
    texels: Vec<u16>,
}

/// Sheets at random over a floor (object 0) and beside a ball (object 1).
struct Chance {
    scene: Scene,
    /// Of the objects from number 2 on.
    sheets: Vec<Described>,
}

/// The ball's radius.
const RADIUS: f64 = 0.75;

impl Chance {
    fn new(dice: &mut Dice) -> Self {
        let mut chance = Self { scene: Scene::default(), sheets: Vec::new() };
        let floor = Shape::Rectangle(Rectangle { size: [8.0; 2] });
        let ball = Shape::from(Analytic::Sphere { radius: RADIUS });
        let aside = DAffine3::from_translation(DVec3::new(0.5, RADIUS, -1.0));
        chance.scene.objects = vec![object("floor", floor, DAffine3::IDENTITY), object("ball", ball, aside)].into();
        for _ in 0..1 + dice.below(3) {
            chance.add_sheet(dice);
        }
        let mut around = |reach: f64| dice.float(-reach, reach);
        let sun = LightSource::sun([around(0.5), -1.0, around(0.5)]);
        let lamp = LightSource::point([around(2.0), 4.5, around(2.0)]);
        let light = if dice.one_in(2) { sun } else { lamp };
        chance.scene.lights.push(Light::new("light", light.expect("a light")));
        chance
    }

    fn add_sheet(&mut self, dice: &mut Dice) {
        let size = [1 + dice.below(5) as u32, 1 + dice.below(5) as u32];
        let texels: Vec<u16> = (0..size[0] * size[1]).map(|_| (dice.below(4) * 21845) as u16).collect();
        let map = AlphaMap::new(size, texels.clone()).expect("a map");
        let wrap = [0; 2].map(|_| dice.pick(&[Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge]));
        let mut cut_out = cut_out(map, dice.pick(&[Filter::Nearest, Filter::Linear]), wrap);
        cut_out.cutoff = dice.float(0.3, 0.7);
        let repeats = dice.pick(&[1.0, 2.5, -1.5]);
        let mesh = sheet(cut_out.clone(), repeats);
        let mut around = |reach: f64| dice.float(-reach, reach);
        let turn = DQuat::from_xyzw(around(0.5), around(1.0), around(0.5), 1.0).normalize();
        let at = DVec3::new(around(1.5), 1.7 + around(0.5), around(1.5));
        let map = DAffine3::from_scale_rotation_translation(DVec3::splat(1.0 + around(0.5)), turn, at);
        let name = format!("sheet{}", self.sheets.len());
        self.scene.objects.push(object(&name, Shape::Mesh(Arc::new(mesh)), map));
        self.sheets.push(Described { cut_out, repeats, texels });
    }

    fn light(&self) -> &LightSource {
        &self.scene.lights[0].source
    }

    /// Whether light reaches a point of a flat face that is turned to it, by plain floats; `None` near any border.
    fn lit(&self, object: usize, face: usize, [u, v]: [f64; 2]) -> Option<bool> {
        let facets = self.scene.objects[object].facets()?;
        let corners = facets.facet(face).corners();
        let at = |k: usize| facets.positions()[corners[k] as usize];
        let x = at(0) + (at(1) - at(0)) * u + (at(corners.len() - 1) - at(0)) * v;
        let light = self.light();
        let towards = if light.is_sun() { light.xyz() * 100.0 } else { light.xyz() - x };
        let mut lit = passes_ball(self.scene.objects[1].placement.map().translation, x, towards)?;
        for number in 2..self.scene.objects.len() {
            lit &= self.passes_sheet(number, (number == object).then_some(face), x, towards)?;
        }
        Some(lit)
    }

    fn passes_sheet(&self, number: usize, own: Option<usize>, x: DVec3, to: DVec3) -> Option<bool> {
        let object = &self.scene.objects[number];
        let (Shape::Mesh(mesh), facets) = (&object.shape, object.facets()?) else { return None };
        let mut passes = true;
        for triangle in (0..2).filter(|&triangle| Some(triangle) != own) {
            let corners = mesh.triangles()[triangle];
            let [a, b, c] = corners.map(|corner| facets.positions()[corner as usize]);
            let (e, f) = (b - a, c - a);
            let (p, q) = (to.cross(f), (x - a).cross(e));
            let scale = e.dot(p);
            let (u, v, along) = ((x - a).dot(p) / scale, to.dot(q) / scale, f.dot(q) / scale);
            let margins = [u, v, 1.0 - u - v, along, 1.0 - along];
            if margins.iter().any(|margin| *margin < -1e-7) {
                continue;
            }
            if margins.iter().any(|margin| margin.is_nan() || *margin < 1e-7) {
                return None;
            }
            let [a, b, c] = corners.map(|corner| mesh.positions()[corner as usize]);
            passes &= !self.sheets[number - 2].is_opaque(a + (b - a) * u + (c - a) * v)?;
        }
        Some(passes)
    }
}

impl Described {
    /// Whether the sheet is opaque at a point of its own coordinates, by the book; `None` near the border of a texel or the cutoff.
    fn is_opaque(&self, met: DVec3) -> Option<bool> {
        let size = self.cut_out.map.as_ref()?.size();
        let [u, v] = [(met.x, 0), (met.z, 1)].map(|(x, axis)| (x + 1.0) * 0.5 * self.repeats * f64::from(size[axis]));
        let wrapped = |index: f64, axis: usize| {
            let (n, i) = (f64::from(size[axis]), index);
            let texel = match self.cut_out.wrap[axis] {
                Wrap::Repeat => i - (i / n).floor() * n,
                Wrap::ClampToEdge => i.max(0.0).min(n - 1.0),
                // There and back again: a triangle wave.
                Wrap::MirroredRepeat => {
                    let m = i - (i / (2.0 * n)).floor() * 2.0 * n;
                    if m < n { m } else { 2.0 * n - 1.0 - m }
                }
            };
            texel as usize
        };
        let alpha = |i: f64, j: f64| f64::from(self.texels[wrapped(j, 1) * size[0] as usize + wrapped(i, 0)]) / 65535.0;
        let value = if self.cut_out.filter == Filter::Nearest {
            if [u, v].iter().any(|x| (x - x.round()).abs() < 1e-6) {
                return None;
            }
            alpha(u.floor(), v.floor())
        } else {
            let (i, j) = ((u - 0.5).floor(), (v - 0.5).floor());
            let (s, t) = (u - 0.5 - i, v - 0.5 - j);
            let line = |j: f64| alpha(i, j) * (1.0 - s) + alpha(i + 1.0, j) * s;
            line(j) * (1.0 - t) + line(j + 1.0) * t
        };
        ((value - self.cut_out.cutoff).abs() > 1e-6).then_some(value >= self.cut_out.cutoff)
    }
}

fn passes_ball(centre: DVec3, x: DVec3, to: DVec3) -> Option<bool> {
    let t = ((centre - x).dot(to) / to.length_squared()).clamp(0.0, 1.0);
    let distance = (x + to * t - centre).length() - RADIUS;
    (distance.abs() > 1e-6).then_some(distance > 0.0)
}

#[test]
fn proofs_and_queries_are_true_by_chance() {
    let (mut judged, mut proved) = (0, [0; 2]);
    for case in 0..25 {
        let mut dice = Dice::new("cut-outs", case);
        let chance = Chance::new(&mut dice);
        let method = dice.pick(&[CellMethod::Auto, CellMethod::Quadtree, CellMethod::Borders]);
        let report = baked(&chance.scene, 5, method);
        let queries = Queries::new(&chance.scene);
        for object in report.lights[0].objects.iter().filter(|object| object.object != 1) {
            let is_mesh = object.object > 1;
            for _ in 0..150.min(object.cells.len()) {
                let cell = object.cells[dice.index(object.cells.len())];
                let is_cut = is_mesh && cell.i + cell.j + 1 == 1 << cell.level;
                let [u, v] = cell.point(dice.parameters(is_cut));
                let face = cell.face as usize;
                let Some(truth) = chance.lit(object.object, face, [u, v]) else { continue };
                judged += 1;
                let place = Place::Surface { object: object.object, face, u, v };
                let answer = queries.lit(&place, chance.light()).expect("a point").lit;
                assert_eq!(answer, truth, "case {case}: {place:?}");
                match cell.verdict {
                    Verdict::Undecided => {}
                    verdict => {
                        proved[usize::from(truth)] += 1;
                        assert_eq!(verdict == Verdict::Lit, truth, "case {case}: {cell:?} at {place:?}");
                    }
                }
            }
        }
    }
    assert!(judged > 2500 && proved.iter().all(|&count| count > 300), "{judged} judged, {proved:?} dark and lit");
}

#[test]
fn samples_cells_and_loose_points_agree_with_queries() {
    for case in 0..12 {
        let chance = Chance::new(&mut Dice::new("cut-out samples", case));
        let (scene, queries) = (&chance.scene, Queries::new(&chance.scene));
        let mut count = vec![(0, 0); scene.objects.len()];
        let (mut loose, mut oriented, mut on_faces) = (Vec::new(), Vec::new(), Vec::new());
        let samples = Some(Sampling::Count(3000));
        let request = |detail| Request { sampling: samples, ..Request::everything(scene, detail) };
        for_each_sample(scene, &request(Detail::Faces), |point| {
            let place = Place::Surface { object: point.object, face: point.face, u: point.u, v: point.v };
            let lit = queries.lit(&place, chance.light()).expect("a point").lit;
            count[point.object].0 += 1;
            count[point.object].1 += u64::from(lit);
            on_faces.push(FacePoint::new(point.object, point.face, point.u, point.v));
            if point.object == 0 {
                // Above the floor, in space.
                loose.push([8.0 * point.u - 4.0, 0.25 + point.v, 8.0 * point.v - 4.0]);
            }
            // On the surface, as floats put it: holes of a sheet are surface as well.
            if let Some(facets) = scene.objects[point.object].facets() {
                let corners = facets.facet(point.face).corners();
                let at = |k: usize| facets.positions()[corners[k] as usize];
                let [x, y, z] =
                    (at(0) + (at(1) - at(0)) * point.u + (at(corners.len() - 1) - at(0)) * point.v).to_array();
                oriented.push([x, y, z, 0.1, 1.0, 0.2]);
            }
        });
        for detail in [Detail::Faces, Detail::Depth { interior: 4, boundary: 4 }] {
            let report = bake(scene, &request(detail), &Silent).expect("nobody cancels");
            for (object, counted) in report.lights[0].objects.iter().zip(&count) {
                let samples = object.samples.expect("samples");
                assert_eq!((samples.samples, samples.lit), *counted, "case {case}, {detail:?}, {}", object.object);
            }
        }
        for points in [Points::FreeDouble(&loose), Points::OrientedDouble(&oriented), Points::OnFaces(&on_faces)] {
            let many = queries.lit_many(points, chance.light(), &Silent).expect("points");
            for (index, lit) in many.into_iter().enumerate() {
                let place = points.place(index);
                let single = queries.lit(&place, chance.light()).expect("a point").lit;
                assert_eq!(lit, single, "case {case}: {place:?}");
            }
        }
    }
}
