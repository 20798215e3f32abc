//! The command line.

mod denoise;
mod values;
mod view;

pub use denoise::{DenoiseArgs, DepthKind, MotionTarget, MotionUnits, NormalSpace, YAxis};
pub use view::ViewArgs;

use crate::camera::CameraChoice;
use crate::levers;
use crate::scene::SkyChoice;
use clap::{Args, Parser, Subcommand, ValueEnum};
use scumble_lab::{Allowance, Shard};
use scumble_metrics::Metric;
use std::path::PathBuf;
use values::{
    parse_port, parse_positive, parse_seconds, parse_set, parse_shard, parse_size, parse_step,
};

/// Interactive global illumination from render graphs: render, check and compare pipelines.
#[derive(Parser)]
#[command(name = "scumble", version)]
pub struct Cli {
    #[command(subcommand)]
    pub verb: Verb,
}

#[derive(Subcommand)]
pub enum Verb {
    /// Render frames of a scene with a graph
    #[command(after_help = levers::HELP)]
    Render(Box<RenderArgs>),
    /// Open a window: fly through a scene, edit its graph while it runs
    #[command(after_help = levers::HELP)]
    View(Box<ViewArgs>),
    /// Report every mistake of graph files, or what they resolve to, and of WGSL files that are passes
    #[command(after_help = levers::HELP)]
    Check(CheckArgs),
    /// Draw what a graph becomes: nodes, resources, compute passes, lifetimes. Needs no adapter
    #[command(after_help = levers::HELP)]
    Graph(GraphArgs),
    /// List the passes, or tell all about one, also of a WGSL file: ports, parameters, source
    Passes(PassesArgs),
    /// List what there is to render on, the best first
    Adapters(AdaptersArgs),
    /// Say what is in a scene, or write it as glTF
    #[command(subcommand)]
    Scene(SceneVerb),
    /// Denoise image sequences of any renderer with a graph that has inputs
    #[command(after_help = levers::HELP)]
    Denoise(Box<DenoiseArgs>),
    /// Make a pass or a graph to start from
    #[command(subcommand)]
    New(NewVerb),
    /// Measure how far an image, or each of numbered frames, is from a reference
    Compare(CompareArgs),
    /// Run an experiment: pipelines compared at equal cost, with references, seeds and intervals
    #[command(after_help = levers::HELP)]
    Ablate(AblateArgs),
    /// Write the form of graph or experiment files as JSON Schema, for editors and tools
    Schema(SchemaArgs),
    /// Write a script by which a shell completes commands and options
    Completions(CompletionsArgs),
}

#[derive(Args)]
pub struct RenderArgs {
    /// The graph file
    pub graph: PathBuf,
    #[command(flatten)]
    pub scene: OptionalScene,
    /// A camera of the scene by its number, or `ex,ey,ez,tx,ty,tz,fov`: eye, target (metres), and the
    /// vertical field of view (degrees)
    #[arg(
        long,
        value_name = "N|EYE,TARGET,FOV",
        default_value = "0",
        allow_hyphen_values = true
    )]
    pub camera: CameraChoice,
    /// How far the camera moves from frame to frame, in metres of the world, beside what the scene's animation does
    #[arg(
        long,
        value_name = "X,Y,Z",
        default_value = "0,0,0",
        allow_hyphen_values = true,
        value_parser = parse_step
    )]
    pub camera_step: [f32; 3],
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub size: [u32; 2],
    /// How many frames; a file gets the last one, a folder every one
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: u32,
    /// Number of the first frame: time, the camera's path and random numbers go on from there
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..1 << 24))]
    pub first_frame: u32,
    /// Seconds of animation per frame; at 0 time stands still
    #[arg(long, value_name = "SECONDS", default_value = "0", value_parser = parse_seconds)]
    pub frame_time: f32,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    pub seed: u32,
    #[command(flatten)]
    pub edits: EditArgs,
    /// Set `max_bounces` of every pass that has it: indirect bounces, 0 for direct light only
    #[arg(long, value_name = "N")]
    pub max_bounces: Option<u32>,
    /// Also write this output of a pass, as EXR and as a PNG to look at; may be given several times
    #[arg(long, value_name = "PASS.PORT", value_parser = parse_port)]
    pub dump: Vec<String>,
    /// Where to; may be given several times [default: out.png]. A .png takes the graph's output
    /// `display`, an .exr its output `linear`, both of the last frame. A folder (any name without such
    /// an extension) gets frame.0001.exr, frame.0001.png and so on. Folders that are not there are made
    #[arg(long, short, value_name = "FILE|DIR")]
    pub output: Vec<PathBuf>,
    /// Tell GPU time per pass, rays and memory
    #[arg(long)]
    pub stats: bool,
    #[command(flatten)]
    pub adapter: AdapterArgs,
    /// Say nothing but errors
    #[arg(long, short)]
    pub quiet: bool,
    /// Write what was done as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Args, Default)]
pub struct EditArgs {
    /// Set a parameter, as in a graph file's `set`; may be given several times
    #[arg(long, value_name = "PASS.PARAM=VALUE", value_parser = parse_set)]
    pub set: Vec<(String, String)>,
    /// Bypass a pass; may be given several times
    #[arg(long, value_name = "PASS")]
    pub bypass: Vec<String>,
}

#[derive(Args)]
pub struct AdapterArgs {
    /// Render on the adapter whose name contains this, else the one that SCUMBLE_ADAPTER names, else
    /// the best
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
}

#[derive(Args)]
pub struct OptionalScene {
    /// A .glb or .gltf file, or atrium, cornell, furnace or moving
    #[arg(long, value_name = "FILE|NAME")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub changes: SceneChanges,
}

#[derive(Args, Default)]
pub struct SceneChanges {
    /// Replace every material
    #[arg(long, value_enum)]
    pub material_override: Option<Override>,
    /// Replace the sky: one radiance, three, or a latitude-longitude image (.hdr, .exr, .png)
    #[arg(long, value_name = "RADIANCE|R,G,B|FILE")]
    pub sky: Option<SkyChoice>,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Override {
    /// Lambert with the base colour
    Lambert,
}

#[derive(Args)]
pub struct CheckArgs {
    /// The graph files, and WGSL files that are passes
    #[arg(required = true)]
    pub graphs: Vec<PathBuf>,
    #[command(flatten)]
    pub edits: EditArgs,
    /// Also check that an adapter can run every pass; without a name, the one that `render` uses
    #[arg(long, value_name = "NAME", num_args = 0..=1)]
    pub adapter: Option<Option<String>>,
    /// Say nothing but mistakes
    #[arg(long, short)]
    pub quiet: bool,
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}

/// The plan of one frame: which nodes the passes declare, in which order they run, which share a compute
/// pass and why others do not, which version of which resource goes where, and how long it lives.
#[derive(Args)]
pub struct GraphArgs {
    /// The graph file
    pub graph: PathBuf,
    /// svg is a picture for browsers, dot is for Graphviz, json for other tools, text to read and compare
    #[arg(long, value_enum, default_value = "svg")]
    pub format: PlanFormat,
    /// Where to, instead of the standard output
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub size: [u32; 2],
    /// The number of the frame. In frame 0 there is no history yet
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..1000))]
    pub frame: u32,
    #[command(flatten)]
    pub edits: EditArgs,
    /// Set `max_bounces` of every pass that has it: indirect bounces, 0 for direct light only
    #[arg(long, value_name = "N")]
    pub max_bounces: Option<u32>,
    #[command(flatten)]
    pub scene: OptionalScene,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum PlanFormat {
    Svg,
    Dot,
    Json,
    Text,
}

#[derive(Args)]
pub struct PassesArgs {
    /// The pass to tell about: its name, or the path of a WGSL file that is one
    pub name: Option<String>,
    /// Also run the conformance suite on it: any size, sky and holes, texels that are not finite, constant images
    #[arg(long, requires = "name")]
    pub test: bool,
    #[command(flatten)]
    pub adapter: AdapterArgs,
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}

/// RON is read as JSON so: a struct or map is an object, a tuple or list an array, a word a string, and word(x) the
/// object {"word": x}.
#[derive(Args)]
pub struct SchemaArgs {
    /// Of which files
    pub of: SchemaOf,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum SchemaOf {
    /// Graphs, with the parameters of every pass
    Graph,
    /// Experiments
    Experiment,
}

/// For bash: `scumble completions bash > ~/.local/share/bash-completion/completions/scumble`
#[derive(Args)]
pub struct CompletionsArgs {
    /// The shell
    pub shell: clap_complete::Shell,
}

#[derive(Args)]
pub struct AdaptersArgs {
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Subcommand)]
pub enum NewVerb {
    /// Make a filter: a crate with a program that has it beside all other passes, or one WGSL file
    Pass(NewPassArgs),
    /// Make a graph file that renders a scene
    Graph(NewGraphArgs),
}

#[derive(Args)]
pub struct NewPassArgs {
    /// Its name: small letters, digits and hyphens
    pub name: String,
    /// Only a WGSL file: no Rust
    #[arg(long)]
    pub wgsl: bool,
}

#[derive(Args)]
pub struct NewGraphArgs {
    /// Its name: small letters, digits and hyphens
    pub name: String,
}

#[derive(Subcommand)]
pub enum SceneVerb {
    /// Say what is in a scene
    Info(SceneInfoArgs),
    /// Write a scene as .glb or .gltf
    Export(SceneExportArgs),
}

#[derive(Args)]
pub struct SceneInfoArgs {
    /// A .glb or .gltf file, or atrium, cornell, furnace or moving
    #[arg(value_name = "FILE|NAME")]
    pub scene: PathBuf,
    #[command(flatten)]
    pub changes: SceneChanges,
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub struct SceneExportArgs {
    /// A .glb or .gltf file, or atrium, cornell, furnace or moving
    #[arg(value_name = "FILE|NAME")]
    pub scene: PathBuf,
    #[command(flatten)]
    pub changes: SceneChanges,
    /// The file to write; folders that are not there are made
    pub output: PathBuf,
}

/// mse, rmse, relmse, smape, mape, energy and hdr_flip (which exposes and tone maps by itself) are of
/// linear values; psnr, ssim, ms_ssim and flip of values clamped to [0, 1] and sRGB-encoded. PNG files are
/// decoded to linear first, but stay tone mapped. ssim takes images from 11x11, ms_ssim from 161x161. Of numbered frames every
/// metric is given as mean and worst, in JSON by frame too, with flicker: how much display luminance
/// changes from frame to frame. In JSON the psnr of equal images, which is infinite, is null.
#[derive(Args)]
pub struct CompareArgs {
    /// The image (.exr, .png, .hdr or .pfm), or numbered ones: a folder or a pattern such as
    /// frame.####.exr
    #[arg(value_name = "A")]
    pub image: PathBuf,
    /// The reference, or a numbered one for each; one image is the reference of all frames
    #[arg(value_name = "B")]
    pub reference: PathBuf,
    /// mse, rmse, relmse, psnr, ssim, ms_ssim, flip, hdr_flip, smape, mape or energy; may be given several
    /// times [default: all]
    #[arg(long)]
    pub metric: Vec<Metric>,
    /// Paint the error of each pixel by the first --metric, else by flip: a .png; of frames, a folder
    #[arg(long, value_name = "PNG|DIR")]
    pub map: Option<PathBuf>,
    /// The map's colours
    #[arg(long, value_enum, default_value = "magma", requires = "map")]
    pub map_colors: MapColors,
    /// The error that has the map's last colour [default: 1 for flip, hdr_flip and ssim (1 - SSIM), else
    /// the 99th percentile of the first map]
    #[arg(long, value_name = "X", requires = "map", value_parser = parse_positive)]
    pub map_max: Option<f64>,
    /// Exit with 1 where the metric, an error, is above this, in any frame; of energy, its distance from 1
    #[arg(long, value_name = "X", conflicts_with = "fail_below")]
    pub fail_above: Option<f64>,
    /// Exit with 1 where the metric, a similarity, is below this, in any frame
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub fail_below: Option<f64>,
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum MapColors {
    /// Black, purple, orange, pale yellow
    Magma,
    /// Purple, teal, green, yellow
    Viridis,
}

/// Every run is kept in the output folder as soon as it is finished, and what is there already is not run again: an
/// experiment that was interrupted goes on where it was. What fails is said at the end, with exit code 2; the rest
/// is done.
#[derive(Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct AblateArgs {
    #[command(subcommand)]
    pub verb: Option<AblateVerb>,
    /// The experiment file
    #[arg(required = true)]
    pub experiment: Option<PathBuf>,
    /// Run the short form that the file gives in `quick`
    #[arg(long)]
    pub quick: bool,
    /// Say what would be run, and how long it would take
    #[arg(long)]
    pub dry_run: bool,
    /// Where records, references and results go [default: results/ and the experiment's name]
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Run one of N parts; put together by `ablate merge`
    #[arg(long, value_name = "I/N", default_value = "1/1", value_parser = parse_shard)]
    pub shard: Shard,
    /// Compare with the results.json of an earlier run, and exit with 1 where something is worse than --fail-above
    /// allows
    #[arg(long, value_name = "FILE", requires = "fail_above")]
    pub baseline: Option<PathBuf>,
    /// How much worse than the baseline a metric may be, of its value or by itself, such as relmse=5% or flip=0.002; also
    /// rays_per_pixel, frame_ms, gpu_ms and memory. More than that fails where the 95 % interval says that it
    /// is no chance. May be given several times, or separated by commas
    #[arg(
        long,
        value_name = "METRIC=LIMIT",
        requires = "baseline",
        value_delimiter = ','
    )]
    pub fail_above: Vec<Allowance>,
    #[command(flatten)]
    pub adapter: AdapterArgs,
    /// Say nothing but errors
    #[arg(long, short)]
    pub quiet: bool,
    /// Write what was done as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Subcommand)]
pub enum AblateVerb {
    /// Put the parts of an experiment into one folder, with the results of all
    Merge(MergeArgs),
    /// Write the report, and results.json and results.csv, of a folder of results once more
    Report(ReportArgs),
}

#[derive(Args)]
pub struct ReportArgs {
    /// The folder of an experiment's results
    #[arg(value_name = "DIR")]
    pub results: PathBuf,
}

#[derive(Args)]
pub struct MergeArgs {
    /// The output folders of the parts
    #[arg(required = true, value_name = "DIR")]
    pub parts: Vec<PathBuf>,
    /// Where to
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        <Cli as clap::CommandFactory>::command().debug_assert();
    }
}
