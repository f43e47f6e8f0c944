//! `umbriel info`: what a scene holds, and what is odd about it.

use std::{collections::HashSet, fmt::Write, sync::Arc};

use glam::DVec3;
use umbriel_geometry::Aabb;
use umbriel_scene::{Finding, FindingKind, Object, Projection, Scene, Shape};

use crate::{
    cli::{Failure, args::InfoArgs, plan, reach},
    output::{self, findings, table::number},
};

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let mut loaded = plan::load(&args.scene)?;
    let on_surfaces = loaded.find_on_surfaces();
    let findings = plan::all_findings(&loaded.file.scene, on_surfaces);
    output::print(&text(&loaded.file.scene, loaded.file.north_degrees, &findings))
}

fn text(scene: &Scene, north_degrees: f64, all: &[Finding]) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = counts(&mut text, scene);
    let _ = extents(&mut text, scene, north_degrees);
    let _ = lights(&mut text, scene);
    let _ = objects(&mut text, scene, all);
    let _ = reach::graph_text(&mut text, &scene.cells);
    let _ = told(&mut text, all);
    text
}

fn counts(text: &mut String, scene: &Scene) -> std::fmt::Result {
    let meshes = || scene.objects.iter().filter_map(mesh_of);
    let distinct: HashSet<_> = meshes().map(Arc::as_ptr).collect();
    let mut stored = HashSet::new();
    let in_memory: usize = meshes().filter(|mesh| stored.insert(Arc::as_ptr(mesh))).map(|m| m.triangles().len()).sum();
    let placed: usize = meshes().map(|mesh| mesh.triangles().len()).sum();
    writeln!(text, "objects     {}", scene.objects.len())?;
    writeln!(text, "  meshes    {} of {} geometries", meshes().count(), distinct.len())?;
    writeln!(text, "  analytic  {}", scene.objects.len() - meshes().count())?;
    writeln!(text, "triangles   {placed} placed, {in_memory} in memory")?;
    writeln!(text, "families    {}", scene.families.families.len())
}

fn extents(text: &mut String, scene: &Scene, north_degrees: f64) -> std::fmt::Result {
    let bounds = scene.objects.iter().map(Object::bounds).fold(Aabb::EMPTY, Aabb::union);
    if bounds.is_empty() {
        return writeln!(text, "bounds      none: there is no surface");
    }
    writeln!(text, "bounds      {} to {} m", point(bounds.min), point(bounds.max))?;
    let size = bounds.size();
    writeln!(text, "extents     {} x {} x {} m (y is up)", number(size.x), number(size.y), number(size.z))?;
    if north_degrees != 0.0 {
        writeln!(text, "north       {north_degrees} degrees clockwise from -Z")?;
    }
    Ok(())
}

fn lights(text: &mut String, scene: &Scene) -> std::fmt::Result {
    writeln!(text, "lights      {}", scene.lights.len())?;
    for light in &scene.lights {
        let xyz = light.source.xyz();
        if light.source.is_sun() {
            writeln!(text, "  {}: sun, its light travels along {}", light.name, point(DVec3::ZERO - xyz))?;
        } else {
            writeln!(text, "  {}: point at {}", light.name, point(xyz))?;
        }
    }
    let Some(camera) = scene.camera else { return writeln!(text, "camera      none; render frames the scene") };
    let projection = match camera.projection {
        Projection::Perspective { vertical_degrees } => format!("{} degrees high", number(vertical_degrees)),
        Projection::Orthographic { height } => format!("parallel, {} m high", number(height)),
        _ => "of an unknown kind".to_owned(),
    };
    writeln!(text, "camera      at {}, towards {}, {projection}", point(camera.eye), point(camera.target))
}

/// How many objects are listed one by one.
const LISTED: usize = 100;

fn objects(text: &mut String, scene: &Scene, findings: &[Finding]) -> std::fmt::Result {
    // Objects that share a mesh share the finding.
    let told: HashSet<&str> = findings
        .iter()
        .filter(|finding| finding.kind == FindingKind::OpenEdges)
        .map(|finding| finding.subject.as_str())
        .collect();
    let with_finding = scene.objects.iter().filter(|object| told.contains(object.name.as_str()));
    let open: HashSet<_> = with_finding.filter_map(mesh_of).map(Arc::as_ptr).collect();
    writeln!(text, "surfaces")?;
    for object in scene.objects.iter().take(LISTED) {
        let size = object.bounds().size();
        let kind = match &object.shape {
            Shape::Mesh(mesh) => {
                let state = if open.contains(&Arc::as_ptr(mesh)) { "open" } else { "closed" };
                format!("{} triangles, {state}", mesh.triangles().len())
            }
            Shape::Rectangle(_) => "rectangle".to_owned(),
            Shape::Cuboid(_) => "box".to_owned(),
            Shape::Convex(body) => format!("hull of {} points", body.points().len()),
            Shape::Analytic(body) => body.name().to_owned(),
            _ => "body".to_owned(),
        };
        writeln!(text, "  {}: {kind}, {} x {} x {} m", object.name, number(size.x), number(size.y), number(size.z))?;
    }
    match scene.objects.len().saturating_sub(LISTED) {
        0 => Ok(()),
        more => writeln!(text, "  and {more} more"),
    }
}

fn told(text: &mut String, all: &[Finding]) -> std::fmt::Result {
    let lines = findings::lines(all);
    if lines.is_empty() {
        return writeln!(text, "findings    none");
    }
    writeln!(text, "findings")?;
    lines.iter().try_for_each(|line| writeln!(text, "  {line}"))
}

fn mesh_of(object: &Object) -> Option<&Arc<umbriel_geometry::Mesh>> {
    match &object.shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    }
}

fn point(point: DVec3) -> String {
    format!("({}, {}, {})", number(point.x), number(point.y), number(point.z))
}
