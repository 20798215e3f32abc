//! What the window is opened with.

use framegraph::Debug;
use scumble::{Camera, Edits};
use scumble_scene::Scene;
use std::path::PathBuf;

/// Where the camera stands at first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// At one of the scene's cameras, by its number; it moves with the scene until the viewer takes it.
    Number(usize),
    /// At a place of its own.
    Fixed(Camera),
}

/// What the window is opened with.
#[derive(Clone, Debug)]
pub struct Options {
    /// The graph file.
    pub graph: PathBuf,
    /// A graph file whose frames stand beside it, without edits.
    pub compare: Option<PathBuf>,
    /// Milliseconds that frames should take.
    pub budget_ms: Option<f64>,
    /// The command line's changes to `graph`; they hold at every reload.
    pub edits: Edits,
    /// The scene, where the graph renders one.
    pub scene: Option<Scene>,
    /// Where the camera stands at first.
    pub camera: Start,
    /// A folder of shaders that take the place of those that passes were compiled with, and are watched.
    pub shaders: Option<PathBuf>,
    /// Width and height of the window in pixels.
    pub size: [u32; 2],
    /// A pixel of the image is so many pixels of the window wide and high, 1 or more.
    pub scale: u32,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Levers of the frame graph, but for `timestamps`: the window times frames when it shows times.
    pub levers: Debug,
    /// The adapter whose name contains this.
    pub adapter: Option<String>,
}
