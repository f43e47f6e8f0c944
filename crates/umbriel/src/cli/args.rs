//! What was typed; nothing here opens a file.

use std::{path::PathBuf, time::Duration};

use clap::{Args as ClapArgs, Parser, Subcommand, ValueEnum};
use umbriel_io::duration_of_hours;

use crate::{
    cli::{
        acceleration::AccelerationChoice,
        reach::{VisibleFrom, visible_from},
        render_args::RenderArgs,
    },
    output::{csv::Rows, glb::Coloring},
};

/// Shadows in object space with a known error.
///
/// For every object and light of a scene (.toml, .gltf, .glb, .obj, .stl, .ply): which parts of its surface are lit, which are in
/// shadow, and exactly how much is still undecided.
#[derive(Debug, Parser)]
#[command(
    name = "umbriel",
    version,
    after_help = "Conventions: right-handed, y up, metres. Azimuth counts clockwise from north (-Z), east is +X.\n\
                  Exit codes: 0 done; 1 the files were read and their content is refused; 2 usage, a missing or \
                  unreadable file, a failed write; 130 interrupted."
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Tell what a scene holds: objects, lights, extents, and what is odd about it
    Info(InfoArgs),
    /// Compute the shadows: lit area of every object with bounds
    Bake(BakeArgs),
    /// Answer points exactly: lit or not
    Query(QueryArgs),
    /// Draw the scene with its computed shadows
    Render(RenderArgs),
    /// Compare ways to find hard shadows on one picture: times, errors, differences
    Compare(CompareArgs),
    /// Measure what time and memory buy: depths, samples and rivals, judged by exact answers all over the surface
    Tradeoff(TradeoffArgs),
    /// Soft shadows: lit, penumbra and umbra with bounds, and the ways of pictures with times and errors
    Soft(SoftArgs),
    /// Tell what about a scene limits the answers, and how much surface it concerns
    Doctor(DoctorArgs),
}

/// Which scene, and how to read it.
#[derive(Debug, ClapArgs)]
pub(crate) struct SceneArgs {
    /// Scene file (.toml) or model (.gltf, .glb, .obj, .stl, .ply)
    pub(crate) scene: PathBuf,
    /// Which axis points up; z: +Y becomes north [default: as the scene file says, else y]
    #[arg(long, value_name = "AXIS")]
    pub(crate) up: Option<Up>,
    /// Where north lies, degrees clockwise from -Z [default: as the scene file says, else 0]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = finite)]
    pub(crate) north: Option<f64>,
    /// Which sides of faces can be lit [default: as the scene file says, else auto]
    #[arg(long, value_name = "SIDES")]
    pub(crate) sides: Option<SidesChoice>,
    /// What BLEND materials of a glTF do to light [default: block]
    #[arg(long, value_name = "WHAT")]
    pub(crate) blend: Option<BlendChoice>,
    /// Take the shapes of colliders in place of meshes, as bodies given by formulas
    #[arg(long)]
    pub(crate) colliders: bool,
    /// Let the scene name files outside its own folder
    #[arg(long)]
    pub(crate) allow_outside: bool,
    /// Threads to compute with, 1 to 1024 [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// No progress bar
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// What BLEND materials do.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum BlendChoice {
    /// They block as if they were opaque
    Block,
    /// They block nothing
    Ignore,
}

/// Which lights.
#[derive(Debug, ClapArgs)]
pub(crate) struct LightArgs {
    /// Add a sun: azimuth and elevation in degrees
    #[arg(long, value_name = "AZ,EL", allow_hyphen_values = true, value_parser = angles)]
    pub(crate) sun: Vec<[f64; 2]>,
    /// Add a point light, metres
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
    pub(crate) point: Vec<[f64; 3]>,
    /// Use this light only (repeatable); added ones are called sun, sun_2, ..., point, point_2, ...
    #[arg(long, value_name = "NAME")]
    pub(crate) light: Vec<String>,
}

/// Many suns one after the other.
#[derive(Debug, ClapArgs)]
pub(crate) struct SunsArgs {
    /// Hours of sun under a table of suns instead of single lights: CSV with a header azimuth,elevation (degrees; none
    /// shines from the horizon or below) or x,y,z (the way the light travels), and if you like time and hours
    #[arg(long, value_name = "FILE", conflicts_with_all = ["sun", "point", "light", "time", "memory", "pixel"])]
    pub(crate) suns: Option<PathBuf>,
    /// Hours that each row of the table lasts, if it has no column hours [default: the step of its times, else 1]
    #[arg(long, value_name = "HOURS", requires = "suns", value_parser = hours, conflicts_with_all = ["sun", "point", "light"])]
    pub(crate) hours_each: Option<Duration>,
}

/// How fine.
#[derive(Debug, Default, ClapArgs)]
pub(crate) struct DetailArgs {
    /// Depth in an object's octree at which cells stay undecided, 0 to 21 [default: 8]
    #[arg(long, value_name = "N", value_parser = depth(), conflicts_with_all = ["cell", "max_undecided", "time", "memory", "pixel"])]
    pub(crate) boundary_depth: Option<u8>,
    /// Finest depth at which decided cells are stored [default: 4]
    #[arg(long, value_name = "N", value_parser = depth(), requires = "boundary_depth")]
    pub(crate) interior_depth: Option<u8>,
    /// Edge of the smallest cell, metres
    #[arg(long, value_name = "METRES", value_parser = positive, conflicts_with_all = ["max_undecided", "time", "memory", "pixel"])]
    pub(crate) cell: Option<f64>,
    /// Divide until at most this share (0 to 1) of the surface is undecided
    #[arg(long, value_name = "SHARE", value_parser = share, conflicts_with_all = ["time", "memory", "pixel"])]
    pub(crate) max_undecided: Option<f64>,
    /// Divide where it tells most for as long as this after loading: 500ms, 2s, 1.5min
    #[arg(long, value_name = "TIME", value_parser = time, conflicts_with_all = ["memory", "pixel"])]
    pub(crate) time: Option<Duration>,
    /// Divide where it tells most as long as a light's cells fit: 64MB, 2GB, 512MiB
    #[arg(long, value_name = "SIZE", value_parser = bytes, conflicts_with = "pixel")]
    pub(crate) memory: Option<u64>,
    /// Divide until cells are no larger than two pixels of a camera, and none is smaller than one: scene for the scene's own camera, or the eye, what it looks at,
    /// metres, and if you like the vertical field of view in degrees
    #[arg(long, value_name = "CAMERA", allow_hyphen_values = true, value_parser = visible_from)]
    pub(crate) pixel: Option<VisibleFrom>,
    /// Rows of the picture whose pixels --pixel means
    #[arg(long, value_name = "N", requires = "pixel", default_value = "1080", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) pixel_rows: u32,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct InfoArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct BakeArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) lights: LightArgs,
    #[command(flatten)]
    pub(crate) suns: SunsArgs,
    #[command(flatten)]
    pub(crate) detail: DetailArgs,
    /// Also sample about this many points, spread by area
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), conflicts_with = "spacing")]
    pub(crate) samples: Option<u64>,
    /// Also sample points at most this far apart, metres
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub(crate) spacing: Option<f64>,
    /// Only objects whose name matches, with * and ? (repeatable); all objects cast shadows
    #[arg(long, value_name = "GLOB")]
    pub(crate) receiver: Vec<String>,
    /// Only objects that a camera may see, through portals where the scene has cells: scene for the scene's own camera, or
    /// the eye, what it looks at, metres, and if you like the vertical field of view in degrees; pictures are 3:2
    #[arg(long, value_name = "CAMERA", allow_hyphen_values = true, value_parser = visible_from, conflicts_with = "suns")]
    pub(crate) visible_from: Option<VisibleFrom>,
    /// Write results to a .json, .csv, .vtu, .glb or .png file (repeatable); .png: light maps
    #[arg(short, long = "output", value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// Write results as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) forms: FormArgs,
}

/// What files hold, where there is a choice.
#[derive(Debug, ClapArgs)]
pub(crate) struct FormArgs {
    /// What a row of a .csv file stands for
    #[arg(long, value_name = "ROWS", default_value = "objects")]
    pub(crate) csv: Rows,
    /// What has one colour in a .glb file
    #[arg(long, value_name = "BY", default_value = "cell")]
    pub(crate) color: Coloring,
    /// Edge of light maps in texels, 1 to 8192
    #[arg(long, value_name = "N", default_value = "512", value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub(crate) lightmap_size: u32,
    /// How the points of light maps that no cell decides find what is in their way; the maps are the same
    #[arg(long, value_enum, value_name = "HOW", default_value = "auto", conflicts_with = "suns")]
    pub(crate) acceleration: AccelerationChoice,
    /// Which texture coordinates of a glTF lay out light maps: 1 for TEXCOORD_1 (an OBJ has one set)
    #[arg(long, value_name = "SET", default_value = "1")]
    pub(crate) lightmap_texcoord: u32,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct QueryArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) lights: LightArgs,
    /// Points: CSV with a header x,y,z or x,y,z,nx,ny,nz or object,face,u,v; or .npy, N x 3 or N x 6, f4 or f8
    #[arg(long, value_name = "FILE")]
    pub(crate) points: PathBuf,
    /// How points find what is in their way to a light; the answers are the same
    #[arg(long, value_enum, value_name = "HOW", default_value = "auto")]
    pub(crate) acceleration: AccelerationChoice,
    /// Also write, in a column LIGHT_error, by how much the truth may differ from the share of a light with an extent
    #[arg(long)]
    pub(crate) errors: bool,
    /// Write the answers to a .csv file (1 lit, 0 not; of a light with an extent the share that is seen), or to .npy, a byte a point and light
    /// (repeatable) [default: standard output, CSV]
    #[arg(short, long = "output", value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct SoftArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) lights: LightArgs,
    #[command(flatten)]
    pub(crate) detail: DetailArgs,
    /// Areas only of objects whose name matches, with * and ? (repeatable); all objects cast shadows
    #[arg(long, value_name = "GLOB")]
    pub(crate) receiver: Vec<String>,
    /// Method of the picture under the first area light (repeatable) [default: all]
    #[arg(long, value_name = "METHOD")]
    pub(crate) method: Vec<MethodName>,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = size)]
    pub(crate) size: [u32; 2],
    /// Edge of the depth map in texels, 16 to 8192
    #[arg(long, value_name = "N", default_value = "2048", value_parser = map_edge)]
    pub(crate) map: usize,
    /// About how many pixels have their truth computed; all of them for a picture
    #[arg(long, value_name = "N", default_value = "20000")]
    pub(crate) truth: usize,
    /// How wide the interval of a box's penumbra may be before boxes-refined takes the parts of the box, metres [default: a quarter of the light]
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub(crate) tolerance: Option<f64>,
    /// Frames in which everything moves that has another object behind it from the light; times are means
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) frames: u32,
    /// How far it moves from frame to frame, metres
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", allow_hyphen_values = true, value_parser = numbers::<3>)]
    pub(crate) step: [f64; 3],
    /// Write results as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write the picture by the only method, or of several the truth and all of them side by side, errors below, to a .png file (repeatable)
    #[arg(short, long = "output", value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
}

/// A way to shade a picture with soft shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodName {
    /// One kernel for all pixels
    Pcf,
    /// The blocker's depth searched in the depth map
    Pcss,
    /// The blocker's depth from mean and variance (VSSM)
    AverageDepth,
    /// Kernels from boxes, fixed at the frame's start
    BoxesFixed,
    /// Kernels from boxes, at each point's own distance
    Boxes,
    /// As boxes, with boxes replaced by their parts where they leave too much open
    BoxesRefined,
    /// Cells with bounds in object space, at the detail; no depth map
    Cells,
}

impl MethodName {
    pub(crate) const ALL: [Self; 7] =
        [Self::Pcf, Self::Pcss, Self::AverageDepth, Self::BoxesFixed, Self::Boxes, Self::BoxesRefined, Self::Cells];

    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Pcf => "pcf",
            Self::Pcss => "pcss",
            Self::AverageDepth => "average-depth",
            Self::BoxesFixed => "boxes-fixed",
            Self::Boxes => "boxes",
            Self::BoxesRefined => "boxes-refined",
            Self::Cells => "cells",
        }
    }
}

#[derive(Debug, ClapArgs)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) lights: LightArgs,
    #[command(flatten)]
    pub(crate) detail: DetailArgs,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "600x400", value_parser = size)]
    pub(crate) size: [u32; 2],
    /// Only these ways (repeatable) [default: all]
    #[arg(long, value_enum, value_name = "WAY")]
    pub(crate) method: Vec<Way>,
    /// Edge of the shadow map in texels, 16 to 8192 (repeatable) [default: 512 and 2048]
    #[arg(long, value_name = "N", value_parser = map_edge)]
    pub(crate) map: Vec<usize>,
    /// How often each patch of a curved body is divided along its edges, for the rivals, 1 to 512
    #[arg(long, value_name = "N", default_value = "16", value_parser = clap::value_parser!(u32).range(1..=512))]
    pub(crate) divisions: u32,
    /// Write results as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write the truth and all methods side by side, differences marked, to a .png file (repeatable)
    #[arg(short, long = "output", value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
}

/// A way to find hard shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Way {
    /// Cells with proofs
    Bake,
    /// Exact answers to the points that pixels see
    Points,
    /// One ray a point
    Rays,
    /// Shadow volumes
    Volume,
    /// Shadow maps
    Map,
    /// The source's method as its words go
    Literal,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct TradeoffArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) lights: LightArgs,
    /// About how many points of the surface have exact answers to judge by
    #[arg(long, value_name = "N", default_value = "1000000", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) points: u64,
    /// The deepest boundary depth that is tried, 1 to 21
    #[arg(long, value_name = "N", default_value = "12", value_parser = clap::value_parser!(u8).range(1..=21))]
    pub(crate) max_depth: u8,
    /// A kind of setting is not made finer after one run of it took longer, seconds
    #[arg(long, value_name = "SECONDS", default_value = "2", value_parser = positive)]
    pub(crate) limit: f64,
    /// How often each setting runs; the quickest run counts
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) runs: u32,
    /// The share of the surface that may be wrong or undecided in what is recommended
    #[arg(long, value_name = "SHARE", default_value = "0.001", value_parser = share)]
    pub(crate) error: f64,
    /// How often each patch of a curved body is divided along its edges, for the rivals, 1 to 512
    #[arg(long, value_name = "N", default_value = "16", value_parser = clap::value_parser!(u32).range(1..=512))]
    pub(crate) divisions: u32,
    /// Run this one setting and print the bytes that it held at most, nothing else
    #[arg(long, value_name = "SETTING", hide = true)]
    pub(crate) peak_of: Option<String>,
    /// Write results as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write results to a .csv or .json file, charts to an .svg or .png file (repeatable)
    #[arg(short, long = "output", value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct DoctorArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) lights: LightArgs,
    #[command(flatten)]
    pub(crate) detail: DetailArgs,
    /// Write what is found as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Up {
    Y,
    Z,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum SidesChoice {
    /// One side for closed surfaces, both for everything else
    Auto,
    /// The side the winding says
    One,
    /// The side turned to the light
    Two,
}

fn depth() -> impl clap::builder::TypedValueParser<Value = u8> {
    clap::value_parser!(u8).range(0..=21)
}

pub(crate) fn finite(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "not a finite number".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err("not above zero".to_owned()) })
}

/// A positive number with one of these units behind it, in the first one's terms.
fn with_unit(text: &str, units: &[(&str, f64)]) -> Result<f64, String> {
    let end = text.rfind(|last: char| last.is_ascii_digit() || last == '.').map_or(0, |last| last + 1);
    let (number, unit) = text.split_at(end);
    let known = || units.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let (_, scale) =
        units.iter().find(|(name, _)| *name == unit.trim()).ok_or_else(|| format!("no unit among {}", known()))?;
    positive(number).map(|number| number * scale)
}

fn time(text: &str) -> Result<Duration, String> {
    let seconds = with_unit(text, &[("s", 1.0), ("ms", 1e-3), ("min", 60.0), ("h", 3600.0)])?;
    // Ten years; what is longer has no end.
    Duration::try_from_secs_f64(seconds).ok().filter(|time| time.as_secs() < 315_360_000).ok_or("too long".to_owned())
}

fn bytes(text: &str) -> Result<u64, String> {
    let units = [
        ("B", 1.0),
        ("kB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("KiB", 1024.0),
        ("MiB", 1_048_576.0),
        ("GiB", 1_073_741_824.0),
    ];
    with_unit(text, &units).map(|bytes| bytes as u64)
}

fn hours(text: &str) -> Result<Duration, String> {
    finite(text).and_then(|value| duration_of_hours(value).ok_or_else(|| "not between 0 and 1000000".to_owned()))
}

fn share(text: &str) -> Result<f64, String> {
    let inside =
        |value: f64| if (0.0..=1.0).contains(&value) { Ok(value) } else { Err("not between 0 and 1".to_owned()) };
    finite(text).and_then(inside)
}

/// N numbers with commas between them.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let parts = text.split(',').map(finite).collect::<Result<Vec<f64>, String>>()?;
    parts.try_into().map_err(|parts: Vec<f64>| format!("{} numbers where {N} are needed", parts.len()))
}

/// Azimuth and elevation.
fn angles(text: &str) -> Result<[f64; 2], String> {
    let angles = numbers(text)?;
    let above = (-90.0..=90.0).contains(&angles[1]);
    if above { Ok(angles) } else { Err("the elevation is not between -90 and 90 degrees".to_owned()) }
}

/// Largest edge of a picture, pixels.
const LARGEST_EDGE: u32 = 16_384;

pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let edge = |part: &str| part.parse().ok().filter(|edge| (1..=LARGEST_EDGE).contains(edge));
    text.split_once('x')
        .and_then(|(width, height)| Some([edge(width)?, edge(height)?]))
        .ok_or_else(|| format!("not a size like 1200x800, with edges from 1 to {LARGEST_EDGE}"))
}

fn map_edge(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|edge| (16..=8192).contains(edge)).ok_or_else(|| "not between 16 and 8192".to_owned())
}

pub(crate) fn color(text: &str) -> Result<[u8; 3], String> {
    let digits = text.trim_start_matches('#');
    let value = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6 && !digits.starts_with('+'));
    let [_, red, green, blue] = value.ok_or("not a colour like ff8c1a: six hexadecimal digits")?.to_be_bytes();
    Ok([red, green, blue])
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Args::command().debug_assert();
    }

    #[test]
    fn values_may_begin_with_a_minus() {
        let args = ["umbriel", "bake", "a.obj", "--sun", "-90,30", "--point", "-1,-2.5,3e1", "--north", "-12"];
        let Command::Bake(bake) = Args::try_parse_from(args).expect("parsed").command else { panic!("not a bake") };
        assert_eq!((bake.lights.sun, bake.lights.point), (vec![[-90.0, 30.0]], vec![[-1.0, -2.5, 30.0]]));
        assert_eq!(bake.scene.north, Some(-12.0));
    }

    #[test]
    fn units_stand_behind_numbers() {
        assert_eq!(
            ["1e-3s", " 2.5 min", ".5h"].map(time),
            [1, 150_000, 1_800_000].map(|ms| Ok(Duration::from_millis(ms)))
        );
        assert_eq!(bytes("1.5KiB"), Ok(1536));
        assert_eq!(["5", "s", "1e400s", "1 s s"].map(|text| time(text).is_err()), [true; 4]);
    }

    #[test]
    fn nonsense_is_refused() {
        for wrong in [
            "--sun 1",
            "--sun 1,2,3",
            "--sun 0,91",
            "--sun 0,-90.5",
            "--point 1,2,nan",
            "--cell 0",
            "--cell 1 --boundary-depth 3",
            "--interior-depth 3",
            "--boundary-depth 22",
            "--max-undecided 1.5",
            "--time 5",
            "--time 5s --memory 1MB",
            "--memory 1MB --cell 1",
            "--pixel scene --cell 1",
            "--pixel-rows 100",
            "--pixel 1,2,3",
            "--pixel scene --suns a.csv",
            "--time 1s --suns a.csv",
            "--samples 0",
            "--samples 5 --spacing 1",
            "--csv lights",
            "--color light",
            "--lightmap-size 0",
            "--lightmap-size 9000",
            "--threads 0",
            "--threads 1025",
            "--up x",
            "--hours-each 1",
            "--suns a.csv --hours-each -1",
            "--suns a.csv --sun 1,2",
            "--suns a.csv --light noon",
        ] {
            let args = ["umbriel", "bake", "a.obj"].into_iter().chain(wrong.split(' '));
            assert_eq!(Args::try_parse_from(args).expect_err(wrong).exit_code(), 2);
        }
    }

    #[test]
    fn times_and_sizes_have_units() {
        assert_eq!(time("500ms"), Ok(Duration::from_millis(500)));
        assert_eq!((time("1.5min"), time("2 s")), (Ok(Duration::from_secs(90)), Ok(Duration::from_secs(2))));
        assert_eq!((bytes("2GB"), bytes("512MiB")), (Ok(2_000_000_000), Ok(512 << 20)));
        assert!(["5", "ms", "-1s", "0s", "1e9h", "3 weeks"].iter().all(|wrong| time(wrong).is_err()));
        assert!(["5", "GB", "-1MB", "1 byte"].iter().all(|wrong| bytes(wrong).is_err()));
    }

    #[test]
    fn sizes_and_colours() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        assert!(["640", "0x3", "3x-1", "20000x1", "3x4x5"].iter().all(|wrong| size(wrong).is_err()));
        assert_eq!(color("#0a0B0c"), Ok([10, 11, 12]));
        assert!(["12345", "orange", "+12345"].iter().all(|wrong| color(wrong).is_err()));
        let plain = Args::try_parse_from(["umbriel", "render", "a.obj", "-o", "a.png", "--undecided"]).expect("parsed");
        let Command::Render(render) = plain.command else { panic!("not a render") };
        assert_eq!(render.undecided, Some([0xff, 0x8c, 0x1a]));
    }
}
