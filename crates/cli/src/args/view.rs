//! The command line of `scumble view`.

use super::values::{parse_positive, parse_size};
use super::{AdapterArgs, EditArgs, OptionalScene};
use crate::camera::CameraChoice;
use clap::Args;
use std::path::PathBuf;

/// WASD flies, Q and E go down and up, Shift is faster, a drag with the mouse looks around, Space plays and pauses.
/// What the graph is made of is watched: a change of it is built beside what runs and takes its place when it is good.
#[derive(Args)]
pub struct ViewArgs {
    /// The graph file
    #[arg(default_value = "graphs/svgf-2018.ron")]
    pub graph: PathBuf,
    #[command(flatten)]
    pub scene: OptionalScene,
    /// Where to start: a camera of the scene by its number, or `ex,ey,ez,tx,ty,tz,fov`: eye, target (metres),
    /// and the vertical field of view (degrees)
    #[arg(
        long,
        value_name = "N|EYE,TARGET,FOV",
        default_value = "0",
        allow_hyphen_values = true
    )]
    pub camera: CameraChoice,
    /// Take the shaders below this folder in the place of those that passes were compiled with, and watch them:
    /// passes/ of this repository
    #[arg(long, value_name = "DIR")]
    pub shaders: Option<PathBuf>,
    /// Width and height of the window in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub size: [u32; 2],
    /// A pixel of the image is so many pixels of the window wide and high: more for slow adapters
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=8))]
    pub scale: u32,
    /// Show a second graph beside it, the same frames on both sides of a line to drag, and how far they are apart: the
    /// second is the reference, and stays as its file says: --set and --bypass change the first
    #[arg(long, value_name = "GRAPH")]
    pub compare: Option<PathBuf>,
    /// Let every tracer spend as much as makes a frame take so many milliseconds
    #[arg(long, value_name = "MS", value_parser = parse_positive)]
    pub budget_ms: Option<f64>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    pub seed: u32,
    #[command(flatten)]
    pub edits: EditArgs,
    #[command(flatten)]
    pub adapter: AdapterArgs,
}
