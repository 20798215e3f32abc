//! What is known to be wrong with an experiment before anything is rendered.

use crate::plan::Plan;
use crate::scene::scene_file;
use scumble::Resolved;
use scumble::diagnostics::{Diagnostic, Diagnostics, Spanned, code};
use scumble_scene::BUILTIN_NAMES;
use std::path::Path;

impl Plan {
    /// Every mistake in the graphs, and every scene that is not there. What they leave can still run.
    pub fn mistakes(&self) -> Diagnostics {
        let mut mistakes = Diagnostics::new();
        for scene in &self.experiment.scenes {
            let name = scene.value.as_str();
            if !BUILTIN_NAMES.contains(&name) && !scene_file(Path::new(name)).is_file() {
                let missing =
                    Diagnostic::new(code::BAD_NAME, format!("there is no scene `{name}`"));
                let built_in = BUILTIN_NAMES.iter().copied();
                mistakes.push(missing.at(&scene.span, "").suggest(
                    name,
                    built_in,
                    "besides .glb and .gltf files there are",
                ));
            }
        }
        for variant in &self.variants {
            if let Err(found) = &variant.graph {
                mistakes.extend(found.clone());
            }
        }
        mistakes
    }
}

/// A graph that can run by itself; `path` is where the experiment names it.
pub(crate) fn whole(graph: Resolved, path: &Spanned<String>) -> Result<Resolved, Diagnostics> {
    let needed: Vec<_> = (graph.inputs.iter())
        .filter(|input| !input.optional)
        .map(|input| format!("`{}`", input.name))
        .collect();
    if needed.is_empty() {
        return Ok(graph);
    }
    let message = format!("`{}` is a part for other graphs", path.value);
    let mut mistakes = Diagnostics::new();
    mistakes.push(
        Diagnostic::new(code::BAD_NAME, message)
            .at(&path.span, "")
            .help(format!(
                "nothing feeds its inputs {}: name a graph that uses it",
                needed.join(", ")
            )),
    );
    Err(mistakes)
}
