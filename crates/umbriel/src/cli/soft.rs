//! `umbriel soft`: the ways of pictures to shade soft shadows, side by side, with their times and errors against the truth.
//!
//! The truth of a pixel is the visible fraction of the point that its middle sees, exact up to rounding for flat faces. Methods see a square light of the
//! rectangle's area and the scene's flat faces; curved bodies are in the truth only, so scenes with them are refused.

use std::{io::Write, path::Path, time::Instant};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::Facets;
use umbriel_io::write::{Picture, Staged, write_png};
use umbriel_scene::{Extent, FamilyTree, FindingKind, Light, Member, Object, Scene, Shape};
use umbriel_shadow::{
    Place, Queries,
    soft_image::{Blocker, BoxKernel, DepthMap, LightSpace, OrientedBox, SoftMethod, SoftShader, outlines},
};
use umbriel_visibility::{RayCaster, SurfaceHit};

use crate::{
    cli::{
        Failure,
        args::{MethodName, SoftArgs},
        plan,
    },
    output::{
        self, Format, Target,
        soft::{Comparison, Errors, Row},
        viewpoint,
    },
    progress::Interrupt,
};

/// How often each method is run; the fastest run counts.
const RUNS: usize = 3;

/// PCF's one kernel, a share of the light's size seen from the nearest receiver.
const PCF_SHARE: f64 = 0.25;

pub(crate) fn run(args: &SoftArgs) -> Result<(), Failure> {
    let files = output::targets(&args.output, &[Format::Png], &[&args.scene.scene])?;
    let json_file = args.json.as_deref().filter(|path| *path != Path::new("-"));
    if let Some(path) = json_file {
        output::check_file(path, &[&args.scene.scene])?;
    }
    let mut loaded = plan::load(&args.scene)?;
    let mut written = files.clone();
    written.extend(json_file.map(|path| Target { path: path.to_owned(), format: Format::Json }));
    output::check_unread(&written, &loaded.file.files)?;
    let interrupt = &Interrupt::install();
    let lights = plan::choose_lights(&mut loaded.file, &args.lights, &args.scene.scene)?;
    loaded.file.scene.findings.retain(|finding| finding.kind != FindingKind::AreaLightAsPoint);
    let scene = &loaded.file.scene;
    plan::tell_findings(scene, args.scene.quiet);
    let light = area_light(scene, &lights, &args.scene.scene)?;
    let stage = Stage::new(scene, light, args)?;
    interrupt.check()?;
    // Pictures need the truth everywhere; numbers are as good from some of it.
    let stride = if files.is_empty() { (stage.points.len() / args.truth.max(1)).max(1) } else { 1 };
    let truth = stage.truth(stride);
    interrupt.check()?;
    let (comparison, shades) = stage.compare(&truth, stride, &args.method);
    let strip = (!files.is_empty()).then(|| comparison.strip(args.size, &truth, &shades));
    let json = comparison.to_json();
    let mut staged = Vec::new();
    if let Some(strip) = &strip {
        for file in &files {
            staged.push(stage_picture(strip, &file.path)?);
        }
    }
    if let Some(path) = json_file {
        staged.push(Staged::new(path, |out| out.write_all(json.as_bytes()))?);
    }
    interrupt.check()?;
    output::commit_all(staged)?;
    let to_stdout = args.json.is_some() && json_file.is_none();
    output::print(&if to_stdout { json } else { comparison.to_text() })
}

fn stage_picture(strip: &Picture, path: &Path) -> Result<Staged, Failure> {
    Ok(Staged::new(path, |out| write_png(strip, out))?)
}

/// The first chosen light that is a rectangle.
fn area_light<'a>(scene: &'a Scene, lights: &[usize], file: &Path) -> Result<&'a Light, Failure> {
    let mut chosen = lights.iter().map(|&light| &scene.lights[light]);
    chosen.find(|light| matches!(light.extent, Extent::Rectangle { .. })).ok_or_else(|| {
        let text = "no chosen light is a rectangle; depth maps look along a rectangle's normal";
        Failure::Refused(format!("{}: {text}", file.display()))
    })
}

/// The scene made ready for all methods.
struct Stage<'a> {
    scene: &'a Scene,
    light: &'a Light,
    args: &'a SoftArgs,
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
    fn new(scene: &'a Scene, light: &'a Light, args: &'a SoftArgs) -> Result<Self, Failure> {
        let facets = scene.objects.iter().map(|object| object.facets().ok_or(object)).collect::<Result<Vec<_>, _>>();
        let facets = facets.map_err(|object| {
            Failure::Refused(format!("object \"{}\" is curved; depth maps take flat faces only", object.name))
        })?;
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
        Ok(Self { scene, light, args, hits, points, facets, space, width, farthest })
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

    /// Every method's time and errors, and its shades.
    fn compare(&self, truth: &[Option<f64>], stride: usize, chosen: &[MethodName]) -> (Comparison, Vec<Vec<f32>>) {
        let begun = Instant::now();
        let mut shader = SoftShader::new(DepthMap::new(self.space, &self.facets), self.width);
        let map_seconds = begun.elapsed().as_secs_f64();
        let names: Vec<MethodName> = if chosen.is_empty() { MethodName::ALL.to_vec() } else { chosen.to_vec() };
        let (mut rows, mut shades) = (Vec::new(), Vec::new());
        for name in names {
            let mut seconds = f64::INFINITY;
            let mut shade = Vec::new();
            for _ in 0..RUNS {
                let begun = Instant::now();
                let method = self.prepare(name, &mut shader);
                shade = shader.shade(&self.points, &method);
                seconds = seconds.min(begun.elapsed().as_secs_f64());
            }
            rows.push(Row { name: name.text(), seconds, errors: self.errors(truth, &shade, stride) });
            shades.push(shade);
        }
        let (given, left) = self.outline_corners();
        let comparison = Comparison {
            light: self.light.name.clone(),
            size: self.args.size,
            map: self.args.map,
            map_seconds,
            truth_points: truth.iter().flatten().count(),
            boxes: given,
            outline_corners: left,
            rows,
        };
        (comparison, shades)
    }

    /// What a method makes anew in every frame besides the depth map.
    fn prepare(&self, name: MethodName, shader: &mut SoftShader) -> SoftMethod {
        let boxes = |kernel, blockers| SoftMethod::Boxes { kernel, quality: 1.0, blockers, farthest: self.farthest };
        match name {
            MethodName::Pcf => SoftMethod::Pcf { radius: 0.5 * PCF_SHARE * self.width / self.farthest },
            MethodName::Pcss => SoftMethod::Pcss,
            MethodName::AverageDepth => {
                shader.prepare_average_depth(self.farthest);
                SoftMethod::AverageDepth
            }
            MethodName::BoxesFixed => boxes(BoxKernel::Fixed, self.blockers()),
            MethodName::Boxes => boxes(BoxKernel::OwnDistance, self.blockers()),
            MethodName::BoxesRefined => {
                let tolerance = self.args.tolerance.unwrap_or(0.25 * self.width);
                let refine =
                    |object: &Object| Blocker::refined(&self.space, object, self.farthest, self.width, tolerance);
                boxes(BoxKernel::OwnDistance, self.casters().into_iter().flatten().flat_map(refine).collect())
            }
        }
    }

    /// The objects that block, by families: everything but single rectangles, which receive.
    fn casters(&self) -> Vec<Vec<&Object>> {
        let families = &self.scene.families;
        let blocks = |object: &&Object| !matches!(object.shape, Shape::Rectangle(_));
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
