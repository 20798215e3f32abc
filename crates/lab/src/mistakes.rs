//! What is known to be wrong with an experiment before anything is rendered.

use crate::plan::Plan;
use crate::scene::{find_camera, load_scene, scene_file};
use scumble::Resolved;
use scumble::diagnostics::{Diagnostic, Diagnostics, Spanned, code};
use scumble_scene::BUILTIN_NAMES;

impl Plan {
    /// Every mistake in the graphs and in the scenes, which are loaded for it. What they leave can still run.
    pub fn mistakes(&self) -> Diagnostics {
        let mut mistakes = Diagnostics::new();
        for scene in &self.experiment.scenes {
            self.check_scene(scene, &mut mistakes);
        }
        let graphs = self.variants.iter().map(|variant| &variant.graph);
        for graph in graphs.chain([&self.reference]) {
            if let Err(found) = graph {
                mistakes.extend(found.clone());
            }
        }
        mistakes
    }

    /// The scene is there, it can be loaded, and it has the cameras that paths begin as.
    fn check_scene(&self, scene: &Spanned<String>, mistakes: &mut Diagnostics) {
        let name = scene.value.as_str();
        let file = self.experiment.file(name);
        if !BUILTIN_NAMES.contains(&name) && !scene_file(&file).is_file() {
            let missing = Diagnostic::new(code::BAD_NAME, format!("there is no scene `{name}`"));
            let built_in = BUILTIN_NAMES.iter().copied();
            mistakes.push(missing.at(&scene.span, "").suggest(
                name,
                built_in,
                "besides .glb and .gltf files there are",
            ));
            return;
        }
        let cameras = match load_scene(&file, false, None) {
            Ok(scene) => scene.cameras,
            Err(error) => {
                let broken = Diagnostic::new(code::UNREADABLE, error.to_string());
                mistakes.push(broken.at(&scene.span, ""));
                return;
            }
        };
        for path in &self.experiment.cameras {
            if let Err(missing) = find_camera(&cameras, path.camera.value) {
                let missing = Diagnostic::new(code::BAD_NAME, missing.to_string());
                let missing = missing.at(&path.camera.span, "");
                mistakes.push(missing.at(&scene.span, "the scene"));
            }
        }
    }
}

/// A graph that can run by itself, and gives what is measured; `path` is where the experiment names it.
pub(crate) fn whole(graph: Resolved, path: &Spanned<String>) -> Result<Resolved, Diagnostics> {
    let wrong = |message: String, help: String| {
        let wrong = Diagnostic::new(code::BAD_NAME, message);
        Err(wrong.at(&path.span, "").help(help).into())
    };
    let needed: Vec<_> = (graph.inputs.iter())
        .filter(|input| !input.optional)
        .map(|input| format!("`{}`", input.name))
        .collect();
    if !needed.is_empty() {
        return wrong(
            format!("`{}` is a part for other graphs", path.value),
            format!(
                "nothing feeds its inputs {}: name a graph that uses it",
                needed.join(", ")
            ),
        );
    }
    if graph.outputs.iter().all(|(name, _)| name != "linear") {
        return wrong(
            format!("`{}` has no output `linear`", path.value),
            "that is what is measured: name a graph that has it".to_owned(),
        );
    }
    Ok(graph)
}
