//! What the tests of whole pipelines and of single passes share: a renderer of graphs without a window, and what every
//! pass must keep.

#![forbid(unsafe_code)]

mod conformance;
mod rig;

use std::path::{Path, PathBuf};

use scumble::{FrameInput, Registry, Resolved};
use scumble_metrics::Image;
use scumble_scene::Scene;

pub use conformance::keeps_the_rules;
pub use rig::{Rig, gpu, scene_camera};

/// Renders graph files with every pass of the repository.
pub struct Renderer {
    /// The passes of the repository.
    pub registry: Registry,
}

/// A scene, the image of it, and the seed of its random numbers. The camera is the scene's first.
pub struct View {
    /// What is rendered.
    pub scene: Scene,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Frames rendered.
    pub frames: u32,
    /// Seed of the random numbers.
    pub seed: u32,
}

impl Renderer {
    /// On the device of [`gpu`].
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        Self {
            registry: scumble_passes::registry(),
        }
    }

    /// Renders the frames and gives each with the texels of these outputs.
    ///
    /// # Panics
    /// Where the graph cannot be built or rendered.
    pub fn render(
        &self,
        graph: Resolved,
        view: View,
        outputs: &[&str],
        mut each: impl FnMut(u32, &[Vec<[f32; 4]>]),
    ) {
        let mut rig = Rig::resolved(graph, view.scene, view.size);
        for frame in 0..view.frames {
            let input = FrameInput {
                frame,
                seed: view.seed,
                ..FrameInput::still(rig.camera)
            };
            rig.render(&input);
            let texels: Vec<_> = outputs.iter().map(|name| rig.read(name)).collect();
            each(frame, &texels);
        }
    }

    /// The last frame of one output.
    pub fn image(&self, graph: Resolved, view: View, output: &str) -> Image {
        let ([width, height], last) = (view.size, view.frames - 1);
        let mut data = Vec::new();
        self.render(graph, view, &[output], |frame, texels| {
            if frame == last {
                data = texels[0].iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            }
        });
        Image::new(width, height, data).unwrap()
    }
}

/// A file of the repository, by its path from the root.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// A file of `graphs/`.
pub fn graph_file(name: &str) -> PathBuf {
    repository("graphs").join(name)
}

/// The graph files of `graphs/`, by name.
pub fn graph_files() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(repository("graphs")).unwrap();
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "ron"));
    files.sort();
    files
}
