//! The options of `scumble denoise`.

use super::values::{parse_fov, parse_map};
use super::{AdapterArgs, EditArgs};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Images are matched to the graph's inputs by the names that Blender, Mitsuba and Arnold give to layers and files
/// (docs/denoise.md has them); --map names the others. Numbers are turned into Scumble's conventions: world-space normals, depth along
/// the view axis, motion in parts of the image from where a surface was to where it is. What is known of a name is said for each input;
/// the options --normals, --depth and --motion-… say otherwise.
#[derive(Args)]
pub struct DenoiseArgs {
    /// The graph file, such as graphs/denoise-svgf.ron
    pub graph: PathBuf,
    /// The folder with the images (.exr, .pfm, .hdr, .png), numbered as in beauty.0001.exr
    #[arg(long, value_name = "DIR")]
    pub input: PathBuf,
    /// What feeds which input of the graph: files of the folder, #### for the number, and the layer of an .exr after a colon, as in
    /// radiance=beauty.####.exr,normal=aovs.####.exr:nn. `position` may be given for depth and motion
    #[arg(long, value_name = "INPUT=FILE[:LAYER],…", value_delimiter = ',', value_parser = parse_map)]
    pub map: Vec<(String, String)>,
    /// Where to: frame.0001.exr of the graph's output `linear`, frame.0001.png of `display`, with the numbers of the input
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
    /// The cameras of the frames (JSON, see docs/denoise.md): for motion where there are no vectors, and for depth that is distance
    #[arg(long, value_name = "FILE")]
    pub cameras: Option<PathBuf>,
    /// The vertical field of view in degrees, where depth is distance and there are no cameras
    #[arg(long, value_name = "DEGREES", conflicts_with = "cameras", value_parser = parse_fov)]
    pub fov: Option<f32>,
    /// Neither the camera nor anything else moves
    #[arg(long)]
    pub still: bool,
    /// The space of normals
    #[arg(long, value_enum)]
    pub normals: Option<NormalSpace>,
    /// What depth is
    #[arg(long, value_enum)]
    pub depth: Option<DepthKind>,
    /// The unit of motion
    #[arg(long, value_enum)]
    pub motion_units: Option<MotionUnits>,
    /// Where motion points to
    #[arg(long, value_enum)]
    pub motion_target: Option<MotionTarget>,
    /// Which way the second component of motion goes
    #[arg(long, value_enum)]
    pub motion_y: Option<YAxis>,
    /// Take frames that are black all over as they are; otherwise they count as broken, and the history goes on without them
    #[arg(long)]
    pub keep_black: bool,
    #[command(flatten)]
    pub edits: EditArgs,
    #[command(flatten)]
    pub adapter: AdapterArgs,
    /// Say nothing but errors
    #[arg(long, short)]
    pub quiet: bool,
    /// Write what was done as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NormalSpace {
    World,
    /// Right-handed, looking along -Z
    Camera,
    /// Z is ahead, as in Blender's denoising data
    CameraForward,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DepthKind {
    /// Along the view axis
    Z,
    /// From the camera's eye
    Distance,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MotionUnits {
    Pixels,
    /// The image is 1 wide and 1 high
    Uv,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MotionTarget {
    /// From where the surface was to where it is
    Now,
    /// From where the surface is to where it was
    Previous,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum YAxis {
    Up,
    Down,
}
