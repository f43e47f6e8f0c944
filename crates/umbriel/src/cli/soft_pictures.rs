//! The ways of pictures to shade soft shadows, side by side, with their times and errors against the truth.
//!
//! The truth of a pixel is the visible fraction of the point that its middle sees, exact up to rounding where
//! [`Queries::visible_fraction`] is. Methods see a square of the light's area (of a sun a square of its diameter) and the scene in a depth map. Where blockers move,
//! every frame has a depth map of its own, and boxes are placed anew; times are means of frames.

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::Facets;
use umbriel_scene::{Light, Object, Scene};
use umbriel_shadow::{
    Cell, Detail, Place, Queries, SoftRequest, Verdict, soft_bake,
    soft_image::{Blocker, BoxKernel, SoftMethod, SoftShader, SurfacePoint, light_space},
};
use umbriel_visibility::{
    RayCaster, SurfaceHit,
    depth_map::{CurvedBodies, DepthMap, LightSpace},
};

use super::soft_casters::{BoxCounts, Casters};
use crate::{
    cli::{
        Failure,
        args::{MethodName, SoftArgs},
    },
    output::{
        cells::CellMap,
        soft::{Comparison, Errors, Row},
        viewpoint,
    },
    progress::Bar,
};

/// How often each method is run on a still; the fastest run counts.
const RUNS: usize = 3;

/// PCF's one kernel, a share of the light's size seen from the nearest receiver.
const PCF_SHARE: f64 = 0.25;

/// How wide the interval of a box's penumbra may be, a share of that half way between the light and the farthest receiver.
const TOLERATED: f64 = 0.25;

/// What is compared, and how fine the object-space method is.
pub(super) struct Plan<'a> {
    pub(super) args: &'a SoftArgs,
    pub(super) detail: Detail,
    pub(super) bar: &'a Bar,
    /// Whether the truth of every pixel is needed.
    pub(super) needs_all: bool,
}

/// A comparison, and the last frame's truth and shades.
pub(super) struct Compared {
    pub(super) comparison: Comparison,
    pub(super) truth: Vec<Option<f64>>,
    pub(super) shades: Vec<Vec<f32>>,
    /// Which pixels show a surface.
    pub(super) is_surface: Vec<bool>,
}

/// Compares methods, frame by frame.
pub(super) fn compare(scene: &Scene, light: usize, plan: &Plan) -> Result<Compared, Failure> {
    let still = Stage::new(scene, light, plan)?;
    let casters = Casters::new(scene, &still.space);
    let mut compared = still.compare(&casters)?;
    for frame in 1..plan.args.frames {
        let moved = casters.moved(scene, DVec3::from_array(plan.args.step) * f64::from(frame))?;
        let Compared { comparison, truth, shades, is_surface } = Stage::new(&moved, light, plan)?.compare(&casters)?;
        compared.comparison.add_frame(&comparison);
        (compared.truth, compared.shades, compared.is_surface) = (truth, shades, is_surface);
    }
    Ok(compared)
}

/// The scene made ready for all methods.
struct Stage<'a> {
    scene: &'a Scene,
    light: &'a Light,
    /// Its index.
    number: usize,
    plan: &'a Plan<'a>,
    hits: Vec<Option<SurfaceHit>>,
    points: Vec<Option<SurfacePoint>>,
    flat: Vec<Facets>,
    curved: CurvedBodies,
    space: LightSpace,
    /// Of the light: see [`light_space`].
    width: f64,
    /// Depth of the farthest receiver.
    farthest: f64,
}

impl<'a> Stage<'a> {
    fn new(scene: &'a Scene, number: usize, plan: &'a Plan<'a>) -> Result<Self, Failure> {
        let (light, args) = (&scene.lights[number], plan.args);
        let flat: Vec<Facets> = scene.objects.iter().filter_map(Object::facets).collect();
        let curved = CurvedBodies::new(scene);
        let caster = RayCaster::new(scene);
        let [width, height] = args.size;
        let view = viewpoint::choose(scene, &caster, &[], width, height);
        let hits = caster.picture(&view);
        let row = width as usize;
        let point = |(number, hit): (usize, &Option<SurfaceHit>)| {
            hit.map(|hit| {
                let ray = view.ray((number % row) as f64 + 0.5, (number / row) as f64 + 0.5);
                SurfacePoint { position: ray.origin + ray.direction * hit.distance, normal: hit.normal }
            })
        };
        let points: Vec<Option<SurfacePoint>> = hits.iter().enumerate().map(point).collect();
        let corners = flat.iter().flat_map(|facets| facets.positions().iter().copied());
        let corners: Vec<DVec3> = corners.chain(curved.corners()).collect();
        let (space, width) = light_space(light, &corners, args.map)
            .ok_or_else(|| Failure::Refused(format!("light \"{}\" has no extent", light.name)))?;
        let depths = points.iter().flatten().map(|point| space.to_light(point.position).z);
        let farthest = depths.fold(0.0, f64::max);
        Ok(Self { scene, light, number, plan, hits, points, flat, curved, space, width, farthest })
    }

    /// The visible fraction at every `stride`th point; of points that are none, nothing.
    fn truth(&self, stride: usize) -> Vec<Option<f64>> {
        let queries = Queries::new(self.scene);
        let asked: Vec<&Option<SurfaceHit>> = self.hits.iter().step_by(stride).collect();
        let fraction = |hit: &&Option<SurfaceHit>| {
            let SurfaceHit { object, face, u, v, .. } = (**hit)?;
            let place = Place::Surface { object, face, u, v };
            queries.visible_fraction(&place, self.light).ok().map(|fraction| fraction.value)
        };
        asked.par_iter().map(fraction).collect()
    }

    /// Every method's time and errors, the truth, and the shades.
    fn compare(&self, casters: &Casters) -> Result<Compared, Failure> {
        let args = self.plan.args;
        // Pictures need the truth everywhere; numbers are as good from some of it.
        let stride = if self.plan.needs_all { 1 } else { (self.points.len() / args.truth.max(1)).max(1) };
        let truth = self.truth(stride);
        let begun = Instant::now();
        let mut shader = SoftShader::new(DepthMap::new(self.space, &self.flat, &self.curved), self.width);
        let map_seconds = begun.elapsed().as_secs_f64();
        let names: &[MethodName] = if args.method.is_empty() { &MethodName::ALL } else { &args.method };
        let (mut rows, mut shades) = (Vec::new(), Vec::new());
        for &name in names {
            let (seconds, shade) = self.shade(name, &mut shader, casters)?;
            rows.push(Row { name: name.text(), seconds, errors: self.errors(&truth, &shade, stride) });
            shades.push(shade);
        }
        let BoxCounts { boxes, left_out, corners } = casters.counts(self.scene, &self.space);
        let pairs = || truth.iter().zip(self.turned_to_light().step_by(stride)).filter(|(truth, _)| truth.is_some());
        let comparison = Comparison {
            light: self.light.name.clone(),
            size: args.size,
            map: args.map,
            map_seconds,
            truth_points: pairs().count(),
            turned_away: pairs().filter(|(_, is_turned)| !is_turned).count(),
            boxes,
            boxes_left_out: left_out,
            outline_corners: corners,
            frames: 1,
            rows,
        };
        let is_surface = self.points.iter().map(Option::is_some).collect();
        Ok(Compared { comparison, truth, shades, is_surface })
    }

    /// Time and shades of a method.
    fn shade(&self, name: MethodName, shader: &mut SoftShader, casters: &Casters) -> Result<(f64, Vec<f32>), Failure> {
        let (mut seconds, mut shade) = (f64::INFINITY, Vec::new());
        for _ in 0..if self.plan.args.frames > 1 { 1 } else { RUNS } {
            let begun = Instant::now();
            let Some(method) = self.prepare(name, shader, casters) else { return self.shade_by_cells() };
            shade = shader.shade(&self.points, &method);
            seconds = seconds.min(begun.elapsed().as_secs_f64());
        }
        Ok((seconds, shade))
    }

    /// Time of the object-space result on all surfaces, and the shades that its cells give.
    fn shade_by_cells(&self) -> Result<(f64, Vec<f32>), Failure> {
        let begun = Instant::now();
        let everything = SoftRequest::everything(self.scene, self.plan.detail);
        let request = SoftRequest { lights: vec![self.number], keep_cells: true, ..everything };
        let report = soft_bake(self.scene, &request, self.plan.bar)?;
        let maps: Vec<CellMap<f32>> = report[0]
            .objects
            .iter()
            .map(|object| {
                CellMap::with(object.cells.iter().map(|cell| {
                    let (face, corner, level, i, j) = (cell.face, cell.corner, cell.level, cell.i, cell.j);
                    (Cell { face, corner, level, i, j, verdict: Verdict::Undecided }, cell.estimate as f32)
                }))
            })
            .collect();
        let shade = |hit: &Option<SurfaceHit>| match hit {
            Some(hit) => maps[hit.object].at(hit.face as u32, hit.u, hit.v).unwrap_or(1.0),
            None => 1.0,
        };
        let shades = self.hits.par_iter().map(shade).collect();
        Ok((begun.elapsed().as_secs_f64(), shades))
    }

    /// What a method of pictures makes anew in every frame besides the depth map; `None` for cells, which have no use for one.
    fn prepare(&self, name: MethodName, shader: &mut SoftShader, casters: &Casters) -> Option<SoftMethod> {
        let (scene, space, farthest, width) = (self.scene, &self.space, self.farthest, self.width);
        let boxes = |kernel, blockers: Vec<Blocker>| SoftMethod::Boxes { kernel, quality: 1.0, blockers, farthest };
        let method = match name {
            MethodName::Pcf => {
                SoftMethod::Pcf { radius: 0.5 * PCF_SHARE * space.width_on_image(width, 0.5 * farthest, farthest) }
            }
            MethodName::Pcss => SoftMethod::Pcss,
            MethodName::AverageDepth => {
                shader.prepare_average_depth(farthest);
                SoftMethod::AverageDepth
            }
            MethodName::BoxesFixed => boxes(BoxKernel::Fixed, casters.blockers(scene, space)),
            MethodName::Boxes => boxes(BoxKernel::OwnDistance, casters.blockers(scene, space)),
            MethodName::Cells => return None,
            MethodName::BoxesRefined => {
                let widest = space.penumbra(width, 0.5 * farthest, farthest);
                let tolerance = self.plan.args.tolerance.unwrap_or(TOLERATED * widest);
                boxes(BoxKernel::OwnDistance, casters.refined(scene, space, farthest, [width, tolerance]))
            }
        };
        Some(method)
    }

    fn errors(&self, truth: &[Option<f64>], shade: &[f32], stride: usize) -> Errors {
        let pairs = truth.iter().zip(shade.iter().step_by(stride)).zip(self.turned_to_light().step_by(stride));
        // What looks away from the light is dark in any renderer, by its normal alone.
        let errors = pairs.filter_map(|((truth, &shade), is_turned)| {
            truth.filter(|_| is_turned).map(|truth| (f64::from(shade) - truth).abs())
        });
        let errors = errors.collect();
        let touched = shade.iter().filter(|&&shade| shade < 1.0).count() as f64 / shade.len().max(1) as f64;
        Errors::of(errors, touched)
    }

    /// Of all pixels: whether they see a face by its front that is turned to the light's middle.
    fn turned_to_light(&self) -> impl Iterator<Item = bool> + '_ {
        let light = self.light.source.xyz();
        self.points.iter().map(move |point| {
            point.is_some_and(|SurfacePoint { position, normal }| {
                let towards = if self.light.source.is_sun() { light } else { light - position };
                normal.dot(towards) > 0.0
            })
        })
    }
}
