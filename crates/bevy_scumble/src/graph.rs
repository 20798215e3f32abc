//! Graph files as assets.

use crate::guides;
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, AssetPath, LoadContext, ReadAssetBytesError};
use bevy::prelude::*;
use bevy::reflect::TypePath;
use scumble::{Diagnostics, Edits, Registry, Resolved, resolve_text};
use std::collections::HashSet;
use std::sync::Arc;

/// The output that is added to what Bevy drew.
pub(crate) const OUTPUT: &str = "indirect";

/// A graph, ready to be built.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct Graph {
    pub(crate) resolved: Arc<Resolved>,
}

impl Graph {
    /// A graph for [`IndirectLight`](crate::IndirectLight), from wherever it came.
    ///
    /// # Errors
    /// When it has no output `indirect`, or asks for an input that this plugin does not feed.
    pub fn new(resolved: Resolved) -> Result<Self, GraphError> {
        if !resolved.outputs.iter().any(|(name, _)| name == OUTPUT) {
            return Err(GraphError::NoOutput);
        }
        for input in resolved.inputs.iter().filter(|input| !input.optional) {
            let fed = guides::ALL.iter().find(|guide| guide.name == input.name);
            if fed.is_none_or(|guide| guide.signal != input.signal || input.grid != 1) {
                return Err(GraphError::Input(input.name.clone()));
            }
        }
        Ok(Self {
            resolved: Arc::new(resolved),
        })
    }

    /// What the graph is made of.
    pub fn resolved(&self) -> &Resolved {
        &self.resolved
    }
}

/// Why a file is no graph for this plugin.
#[derive(Debug, thiserror::Error)]
pub enum GraphError {
    /// It could not be read.
    #[error("it cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// A file that it uses could not be read.
    #[error("a file that it uses cannot be read: {0}")]
    Used(#[from] ReadAssetBytesError),
    /// It is no text.
    #[error("it is not UTF-8 text")]
    Text(#[from] std::string::FromUtf8Error),
    /// Every mistake in it.
    #[error("{0}")]
    Mistakes(#[from] Diagnostics),
    /// There would be nothing to add.
    #[error("it has no output `{OUTPUT}`, the light that is added to what Bevy drew")]
    NoOutput,
    /// An input that nothing feeds.
    #[error(
        "nothing feeds its input `{0}`: there are {names} at full resolution, each with the signal of its name",
        names = guides::names()
    )]
    Input(String),
}

/// Loads `.ron` files as [`Graph`]s, with the graph and WGSL files that they use.
///
/// A file that changes on the disk is loaded anew, and so is one that uses it, where Bevy watches its assets; one with a mistake
/// is reported, and what was there before goes on.
#[derive(TypePath)]
pub struct GraphLoader {
    registry: Arc<Registry>,
}

impl GraphLoader {
    /// For graphs of these passes.
    pub fn new(registry: Arc<Registry>) -> Self {
        Self { registry }
    }
}

impl AssetLoader for GraphLoader {
    type Asset = Graph;
    type Settings = ();
    type Error = GraphError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<Graph, GraphError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let text = String::from_utf8(bytes)?;
        let path = context.path().clone_owned();
        let mut registry = Registry::clone(&self.registry);
        let mut seen = HashSet::new();
        let mut unread = used(&path, &text);
        while let Some(next) = unread.pop() {
            if seen.insert(next.clone()) {
                let text = String::from_utf8(context.read_asset_bytes(&next).await?)?;
                unread.extend(used(&next, &text));
                registry.add_file(next.path(), text);
            }
        }
        let name = path.path().display().to_string();
        Graph::new(resolve_text(&name, &text, &registry, &Edits::default())?)
    }

    fn extensions(&self) -> &[&str] {
        &["ron"]
    }
}

/// The files that a graph names in quotes: what ends like a graph or a shader. Paths are relative to that of the text. What a
/// shader includes is no file but a module of the registry.
fn used(path: &AssetPath<'_>, text: &str) -> Vec<AssetPath<'static>> {
    if path.path().extension().is_none_or(|e| e != "ron") {
        return Vec::new();
    }
    let quoted = text.lines().flat_map(|line| {
        let code = line.split("//").next().unwrap_or_default();
        code.split('"').skip(1).step_by(2)
    });
    quoted
        .filter(|name| name.ends_with(".ron") || name.ends_with(".wgsl"))
        .filter_map(|name| path.resolve_embed_str(name).ok())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_used_are_found() {
        let text = r#"(use: "gbuffer"), // (use: "./left-out.ron")
            (use: "./chain.ron", in: {"value": "a.b"}), (use: "../filters/mine.wgsl"), extends: "base.ron""#;
        let expected = ["graphs/chain.ron", "filters/mine.wgsl", "graphs/base.ron"];
        assert_eq!(
            used(&AssetPath::parse("graphs/a.ron"), text),
            expected.map(AssetPath::parse)
        );
        let shader = "#include \"scumble/conventions.wgsl\"";
        assert!(used(&AssetPath::parse("filters/mine.wgsl"), shader).is_empty());
    }
}
