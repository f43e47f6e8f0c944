//! The ways of pictures to shade soft shadows, side by side, with their times and errors against the truth.
//!
//! The truth of a pixel is the visible fraction of the point that its middle sees, exact up to rounding for flat faces. Methods see a square light of the
//! rectangle's area and the scene's flat faces. Where blockers move, every frame has a depth map and boxes of its own; times are means of frames.

use std::time::Instant;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use umbriel_geometry::{Facets, Placement};
use umbriel_scene::{Extent, FamilyTree, Light, Member, Object, Scene, Shape};
use umbriel_shadow::{
    Cell, Detail, Place, Queries, SoftRequest, Verdict, soft_bake,
    soft_image::{Blocker, BoxKernel, DepthMap, LightSpace, OrientedBox, SoftMethod, SoftShader, outlines},
};
use umbriel_visibility::{RayCaster, SurfaceHit};

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
}

/// Why methods of pictures cannot take the scene under this light, if they cannot.
pub(super) fn obstacle(scene: &Scene, light: &Light) -> Option<String> {
    if !matches!(light.extent, Extent::Rectangle { .. }) {
        let name = &light.name;
        return Some(format!("light \"{name}\" is no rectangle; depth maps look along a rectangle's normal"));
    }
    let curved = scene.objects.iter().find(|object| matches!(object.shape, Shape::Analytic(_)));
    curved.map(|object| format!("object \"{}\" is curved; depth maps take flat faces only", object.name))
}

/// Compares methods, frame by frame.
pub(super) fn compare(scene: &Scene, light: usize, plan: &Plan) -> Result<Compared, Failure> {
    let mut compared = Stage::new(scene, light, plan)?.compare()?;
    for frame in 1..plan.args.frames {
        let moved = with_blockers_moved(scene, DVec3::from_array(plan.args.step) * f64::from(frame))?;
        let Compared { comparison, truth, shades } = Stage::new(&moved, light, plan)?.compare()?;
        compared.comparison.add_frame(&comparison);
        (compared.truth, compared.shades) = (truth, shades);
    }
    Ok(compared)
}

/// Whether an object blocks for the methods of pictures: single rectangles only receive.
fn is_blocker(object: &Object) -> bool {
    !matches!(object.shape, Shape::Rectangle(_))
}

fn with_blockers_moved(scene: &Scene, by: DVec3) -> Result<Scene, Failure> {
    let mut moved = scene.clone();
    if by == DVec3::ZERO {
        return Ok(moved);
    }
    for object in moved.objects.iter_mut().filter(|object| is_blocker(object)) {
        let refused = |reason: String| Failure::Refused(format!("--step moves \"{}\" too far: {reason}", object.name));
        let map = DAffine3 { translation: object.placement.map().translation + by, ..*object.placement.map() };
        let placement = Placement::new(map).map_err(|defect| refused(defect.to_string()))?;
        let placed = Object::new(object.name.clone(), object.shape.clone(), placement, object.sides);
        *object = placed.map_err(|defect| refused(defect.to_string()))?;
    }
    Ok(moved)
}

/// The scene made ready for all methods.
struct Stage<'a> {
    scene: &'a Scene,
    light: &'a Light,
    /// Its index.
    number: usize,
    plan: &'a Plan<'a>,
    hits: Vec<Option<SurfaceHit>>,
    points: Vec<Option<DVec3>>,
    facets: Vec<Facets>,
    space: LightSpace,
    /// Edge of the square light, metres.
    width: f64,
    /// Depth of the farthest receiver.
    farthest: f64,
}

impl<'a> Stage<'a> {
    fn new(scene: &'a Scene, number: usize, plan: &'a Plan<'a>) -> Result<Self, Failure> {
        let (light, args) = (&scene.lights[number], plan.args);
        if let Some(text) = obstacle(scene, light) {
            return Err(Failure::Refused(text));
        }
        let facets: Vec<Facets> = scene.objects.iter().filter_map(Object::facets).collect();
        let caster = RayCaster::new(scene);
        let [width, height] = args.size;
        let view = viewpoint::choose(scene, &caster, &[], width, height);
        let hits = caster.picture(&view);
        let row = width as usize;
        let point = |(number, hit): (usize, &Option<SurfaceHit>)| {
            hit.map(|hit| {
                let ray = view.ray((number % row) as f64 + 0.5, (number / row) as f64 + 0.5);
                ray.origin + ray.direction * hit.distance
            })
        };
        let points: Vec<Option<DVec3>> = hits.iter().enumerate().map(point).collect();
        let Extent::Rectangle { u, v } = light.extent else {
            return Err(Failure::Refused(format!("light \"{}\" is no rectangle", light.name)));
        };
        let origin = light.source.xyz();
        let normal = u.cross(v);
        let corners: Vec<DVec3> = facets.iter().flat_map(|facets| facets.positions().iter().copied()).collect();
        let side: f64 = corners.iter().map(|&corner| normal.dot(corner - origin)).sum();
        let forward = if side < 0.0 { -normal } else { normal };
        let space = LightSpace::round(origin, forward, corners.iter().copied(), args.map);
        let depths = points.iter().flatten().map(|&point| space.to_light(point).z);
        let farthest = depths.fold(0.0, f64::max);
        let width = 2.0 * normal.length().sqrt();
        Ok(Self { scene, light, number, plan, hits, points, facets, space, width, farthest })
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
    fn compare(&self) -> Result<Compared, Failure> {
        let args = self.plan.args;
        // Pictures need the truth everywhere; numbers are as good from some of it.
        let stride = if self.plan.needs_all { 1 } else { (self.points.len() / args.truth.max(1)).max(1) };
        let truth = self.truth(stride);
        let begun = Instant::now();
        let mut shader = SoftShader::new(DepthMap::new(self.space, &self.facets), self.width);
        let map_seconds = begun.elapsed().as_secs_f64();
        let names: &[MethodName] = if args.method.is_empty() { &MethodName::ALL } else { &args.method };
        let (mut rows, mut shades) = (Vec::new(), Vec::new());
        for &name in names {
            let (seconds, shade) = self.shade(name, &mut shader)?;
            rows.push(Row { name: name.text(), seconds, errors: self.errors(&truth, &shade, stride) });
            shades.push(shade);
        }
        let (given, left) = self.outline_corners();
        let comparison = Comparison {
            light: self.light.name.clone(),
            size: args.size,
            map: args.map,
            map_seconds,
            truth_points: truth.iter().flatten().count(),
            boxes: given,
            outline_corners: left,
            frames: 1,
            rows,
        };
        Ok(Compared { comparison, truth, shades })
    }

    /// Time and shades of a method.
    fn shade(&self, name: MethodName, shader: &mut SoftShader) -> Result<(f64, Vec<f32>), Failure> {
        let (mut seconds, mut shade) = (f64::INFINITY, Vec::new());
        for _ in 0..if self.plan.args.frames > 1 { 1 } else { RUNS } {
            let begun = Instant::now();
            let Some(method) = self.prepare(name, shader) else { return self.shade_by_cells() };
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
    fn prepare(&self, name: MethodName, shader: &mut SoftShader) -> Option<SoftMethod> {
        let boxes = |kernel, blockers| SoftMethod::Boxes { kernel, quality: 1.0, blockers, farthest: self.farthest };
        let method = match name {
            MethodName::Pcf => SoftMethod::Pcf { radius: 0.5 * PCF_SHARE * self.width / self.farthest },
            MethodName::Pcss => SoftMethod::Pcss,
            MethodName::AverageDepth => {
                shader.prepare_average_depth(self.farthest);
                SoftMethod::AverageDepth
            }
            MethodName::BoxesFixed => boxes(BoxKernel::Fixed, self.blockers()),
            MethodName::Boxes => boxes(BoxKernel::OwnDistance, self.blockers()),
            MethodName::Cells => return None,
            MethodName::BoxesRefined => {
                let tolerance = self.plan.args.tolerance.unwrap_or(0.25 * self.width);
                let refine =
                    |object: &Object| Blocker::refined(&self.space, object, self.farthest, self.width, tolerance);
                boxes(BoxKernel::OwnDistance, self.casters().into_iter().flatten().flat_map(refine).collect())
            }
        };
        Some(method)
    }

    /// The objects that block, by families: everything but single rectangles, which receive.
    fn casters(&self) -> Vec<Vec<&Object>> {
        let families = &self.scene.families;
        let blocks = |object: &&Object| is_blocker(object);
        let of = |member: &Member| objects_of(families, *member).into_iter().map(|number| &self.scene.objects[number]);
        let groups = families.roots.iter().map(|member| of(member).filter(blocks).collect());
        let groups: Vec<Vec<&Object>> = groups.filter(|group: &Vec<&Object>| !group.is_empty()).collect();
        // A scene of one's own making may have no families.
        if groups.is_empty() {
            self.scene.objects.iter().filter(blocks).map(|object| vec![object]).collect()
        } else {
            groups
        }
    }

    fn blockers(&self) -> Vec<Blocker> {
        let of = |group: &Vec<&Object>| {
            let boxes: Vec<OrientedBox> = group.iter().filter_map(|object| OrientedBox::of(object)).collect();
            Blocker::of(&outlines(&self.space, &boxes))
        };
        self.casters().iter().filter_map(of).collect()
    }

    /// How many boxes there are, and how many corners each outline that is left keeps.
    fn outline_corners(&self) -> (usize, Vec<usize>) {
        let groups = self.casters();
        let left = groups.iter().flat_map(|group| {
            let boxes: Vec<OrientedBox> = group.iter().filter_map(|object| OrientedBox::of(object)).collect();
            outlines(&self.space, &boxes).into_iter().map(|outline| outline.corners.len()).collect::<Vec<_>>()
        });
        (groups.iter().map(Vec::len).sum(), left.collect())
    }

    fn errors(&self, truth: &[Option<f64>], shade: &[f32], stride: usize) -> Errors {
        let pairs = truth.iter().zip(shade.iter().step_by(stride));
        // What looks away from the light is dark in any renderer, by its normal alone.
        let errors = pairs.zip(self.hits.iter().step_by(stride)).filter_map(|((truth, &shade), hit)| {
            let turned = hit.as_ref().is_some_and(|hit| self.is_turned_to_light(hit));
            truth.filter(|_| turned).map(|truth| (f64::from(shade) - truth).abs())
        });
        let errors = errors.collect();
        let touched = shade.iter().filter(|&&shade| shade < 1.0).count() as f64 / shade.len().max(1) as f64;
        Errors::of(errors, touched)
    }

    fn is_turned_to_light(&self, hit: &SurfaceHit) -> bool {
        let facets = &self.facets[hit.object];
        let corner = facets.facet(hit.face).corners()[0];
        hit.normal.dot(self.light.source.xyz() - facets.positions()[corner as usize]) > 0.0
    }
}

/// The objects below a member.
fn objects_of(tree: &FamilyTree, member: Member) -> Vec<usize> {
    match member {
        Member::Object(object) => vec![object],
        Member::Family(family) => {
            tree.families[family].members.iter().flat_map(|&member| objects_of(tree, member)).collect()
        }
    }
}
