//! `umbriel render --lines`: a drawing of edges, as SVG.

use umbriel_io::{
    LoadedScene,
    write::{LineArt, LineLayer, Staged, write_svg},
};
use umbriel_visibility::{
    RayCaster,
    line_drawing::{Drawing, Ink, LineOptions, draw_lines},
};

use crate::{
    cli::{Failure, args::LightArgs, plan, render_args::RenderArgs},
    output::{self, Format, viewpoint},
    progress::Interrupt,
};

/// How strokes of one kind are drawn.
struct Pen {
    ink: Ink,
    name: &'static str,
    /// Pixels.
    width: f64,
    color: [u8; 3],
    dashes: Option<[f64; 2]>,
}

/// The lowest layer first.
const PENS: [Pen; 4] = [
    Pen { ink: Ink::Shadow, name: "shadow", width: 0.5, color: [120, 130, 150], dashes: None },
    Pen { ink: Ink::ShadowOutline, name: "shadow-outline", width: 0.7, color: [90, 100, 125], dashes: None },
    Pen { ink: Ink::Hidden, name: "hidden", width: 0.6, color: [150, 150, 150], dashes: Some([3.0, 3.0]) },
    Pen { ink: Ink::Visible, name: "visible", width: 1.1, color: [20, 20, 25], dashes: None },
];

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let files = output::targets(&args.output, &[Format::Svg], &[&args.scene.scene])?;
    let mut loaded = plan::load(&args.scene)?;
    output::check_unread(&files, &loaded.file.files)?;
    let interrupt = &Interrupt::install();
    let lights = choose_lights(args, &mut loaded.file)?;
    loaded.file.scene.camera = args.camera.or(loaded.file.scene.camera);
    let scene = &loaded.file.scene;
    plan::tell_findings(scene, args.scene.quiet);
    let [width, height] = args.size;
    let view = viewpoint::choose(scene, &RayCaster::new(scene), &lights, width, height);
    let options = LineOptions {
        keeps_hidden: args.dashed,
        lights: lights.iter().map(|&light| scene.lights[light].source).collect(),
        ..LineOptions::default()
    };
    let drawing = draw_lines(scene, &view, &options).map_err(|defect| Failure::Unusable(defect.to_string()))?;
    if drawing.left_out > 0 && !args.scene.quiet {
        output::tell(&format!("note: {} general quadrics are left out of the drawing", drawing.left_out));
    }
    if let (Some(defect), false) = (&drawing.no_outlines, args.scene.quiet) {
        output::tell(&format!("note: shadows are hatched without outlines: {defect}"));
    }
    let art = art(&drawing);
    let stage = |file: &output::Target| Staged::new(&file.path, |out| write_svg(&art, out));
    let staged = files.iter().map(stage).collect::<Result<Vec<_>, _>>()?;
    interrupt.check()?;
    output::commit_all(staged)
}

/// The lights whose shadows are hatched; a drawing needs none.
fn choose_lights(args: &RenderArgs, file: &mut LoadedScene) -> Result<Vec<usize>, Failure> {
    let LightArgs { sun, point, light } = &args.lights;
    let has_none = file.scene.lights.is_empty() && sun.is_empty() && point.is_empty() && light.is_empty();
    if has_none { Ok(Vec::new()) } else { plan::choose_lights(file, &args.lights, &args.scene.scene) }
}

fn art(drawing: &Drawing) -> LineArt {
    let layer = |Pen { ink, name, width, color, dashes }: Pen| {
        let of_ink = drawing.strokes.iter().filter(|stroke| stroke.ink == ink);
        LineLayer { name, color, width, dashes, strokes: of_ink.map(|stroke| stroke.ends).collect() }
    };
    let layers = PENS.map(layer).into_iter().filter(|layer| !layer.strokes.is_empty());
    LineArt { size: drawing.size, layers: layers.collect() }
}
