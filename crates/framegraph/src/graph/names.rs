//! Nodes and imports by name, for a frame that is repeated: found once, and kept until the graph is declared anew.

use std::collections::HashMap;

use super::{FrameGraph, List, Node, Resource};
use crate::handle::Label;
use crate::pool::Hasher;

/// In place of an index where several have a name.
const SEVERAL: u32 = u32::MAX;

/// Why a name stands for nothing.
pub(super) enum Unnamed {
    None,
    Several,
}

#[derive(Default)]
pub(crate) struct Names {
    nodes: HashMap<Label, u32, Hasher>,
    imports: HashMap<Label, u32, Hasher>,
    known: bool,
}

impl Names {
    pub fn clear(&mut self) {
        if std::mem::take(&mut self.known) {
            self.nodes.clear();
            self.imports.clear();
        }
    }

    fn fill(&mut self, nodes: &List<Node>, resources: &List<Resource>) {
        if std::mem::replace(&mut self.known, true) {
            return;
        }
        // What stands in for a node has its name.
        for (i, n) in (0..).zip(nodes).filter(|(_, n)| !n.stands_in) {
            put(&mut self.nodes, &n.label, i);
        }
        for (i, r) in (0..).zip(resources).filter(|(_, r)| r.is_imported()) {
            put(&mut self.imports, &r.label, i);
        }
    }
}

fn put(names: &mut HashMap<Label, u32, Hasher>, label: &Label, index: u32) {
    names
        .entry(label.clone())
        .and_modify(|i| *i = SEVERAL)
        .or_insert(index);
}

fn get(names: &HashMap<Label, u32, Hasher>, name: &str) -> Result<u32, Unnamed> {
    match names.get(name) {
        None => Err(Unnamed::None),
        Some(&SEVERAL) => Err(Unnamed::Several),
        Some(&index) => Ok(index),
    }
}

impl FrameGraph<'_> {
    pub(super) fn node_named(&mut self, name: &str) -> Result<u32, Unnamed> {
        self.names.fill(&self.nodes, &self.resources);
        get(&self.names.nodes, name)
    }

    pub(super) fn import_named(&mut self, name: &str) -> Result<u32, Unnamed> {
        self.names.fill(&self.nodes, &self.resources);
        get(&self.names.imports, name)
    }
}
