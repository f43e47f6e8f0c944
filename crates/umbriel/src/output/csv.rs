//! A bake's sums as a table, one row an object and light.

use umbriel_io::write::Table;
use umbriel_scene::Scene;
use umbriel_shadow::Report;

/// The table; areas in square metres.
pub(crate) fn table(scene: &Scene, report: &Report) -> Table {
    let sampled = report.lights.iter().flat_map(|light| &light.objects).any(|object| object.samples.is_some());
    let mut header = vec!["light", "object", "area", "lit_lower", "lit_upper", "lit_estimate", "undecided"];
    if sampled {
        header.extend(["samples", "lit_samples"]);
    }
    let rows = report.lights.iter().flat_map(|light| {
        light.objects.iter().map(move |object| {
            let names = [&scene.lights[light.light].name, &scene.objects[object.object].name];
            let lit = &object.lit;
            let areas = [object.area, lit.lower, lit.upper, lit.estimate, object.undecided()];
            let mut row: Vec<String> = names.into_iter().cloned().collect();
            row.extend(areas.map(|area| area.to_string()));
            if sampled {
                let count = object.samples.unwrap_or_default();
                row.extend([count.samples.to_string(), count.lit.to_string()]);
            }
            row
        })
    });
    Table { header: header.into_iter().map(str::to_owned).collect(), rows: rows.collect() }
}
