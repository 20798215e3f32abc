//! Where the levers for debugging touch a plan: which resources are clobbered before a node, and which are
//! captured after one. They only point into the plan: order, steps and slots are the same without them.

use super::{FOREVER, Slots};
use crate::debug::{Capture, CaptureWhen};
use crate::error::{Code, Warning, suggest};
use crate::graph::{FrameGraph, Import, Kind, Shape};
use crate::plan::Plan;
use crate::pool::copyable;

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Marks {
    /// Position in the order, and what is clobbered before that node; sorted.
    pub clobber: Vec<(u32, u32)>,
    /// Sorted by where they are taken.
    pub capture: Vec<CaptureMark>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CaptureMark {
    /// How many nodes have run.
    pub after: u32,
    pub resource: u32,
    pub version: u32,
    pub capture: Capture,
}

impl Marks {
    /// How many nodes from a position on can be recorded before something has to be done between two; at
    /// least one.
    pub fn together(&self, at: u32) -> u32 {
        let clobber = self.clobber[self.clobber.partition_point(|c| c.0 <= at)..].first();
        let capture = self.capture[self.capture.partition_point(|c| c.after <= at)..].first();
        let next = clobber
            .map(|c| c.0)
            .into_iter()
            .chain(capture.map(|c| c.after))
            .min();
        next.map_or(u32::MAX, |next| next - at)
    }

    /// What to clobber before the node at a position.
    pub fn clobbered(&self, at: u32) -> impl Iterator<Item = u32> {
        let from = self.clobber.partition_point(|c| c.0 < at);
        self.clobber[from..]
            .iter()
            .take_while(move |c| c.0 == at)
            .map(|c| c.1)
    }

    /// What to capture when so many nodes have run.
    pub fn captured(&self, after: u32) -> impl Iterator<Item = &CaptureMark> {
        let from = self.capture.partition_point(|c| c.after < after);
        self.capture[from..]
            .iter()
            .take_while(move |c| c.after == after)
    }
}

impl Plan<'_> {
    /// The marks, and why some captures cannot be taken. Names decide them, which decide nothing else of a
    /// plan, so they are found for each frame that asks.
    pub(crate) fn marks(&self) -> (Marks, Vec<Warning>) {
        let (graph, order, slots) = (&self.graph, &*self.schedule.order, &self.schedule.slots);
        let (mut marks, mut warnings) = (Marks::default(), Vec::new());
        if graph.debug.clobber {
            let transient = slots.tenants.iter().map(|t| (t.first, t.resource));
            marks.clobber = transient.chain(currents(graph, order)).collect();
            marks.clobber.sort_unstable();
        }
        for capture in &graph.debug.capture {
            let search = Search {
                graph,
                order,
                slots,
                capture,
            };
            if let Err(message) = search.all(&mut marks.capture) {
                warnings.push(Warning {
                    code: Code::Capture,
                    message: format!("`{capture}` is not captured: {message}"),
                    site: None,
                });
            }
        }
        marks.capture.sort_by_key(|c| c.after);
        (marks, warnings)
    }
}

/// The first use of each history's new frame.
fn currents(graph: &FrameGraph<'_>, order: &[u32]) -> Vec<(u32, u32)> {
    let mut first: Vec<(u32, u32)> = Vec::new();
    for (at, &n) in (0..).zip(order) {
        for i in graph.nodes[n as usize].accesses.clone() {
            let resource = graph.accesses[i as usize].resource;
            let current = matches!(graph.resources[resource as usize].kind, Kind::Current(_));
            if current && first.iter().all(|f| f.1 != resource) {
                first.push((at, resource));
            }
        }
    }
    first
}

struct Search<'a, 'f> {
    graph: &'a FrameGraph<'f>,
    order: &'a [u32],
    slots: &'a Slots,
    capture: &'a Capture,
}

impl Search<'_, '_> {
    /// The capture of each resource of the name; the reason why not when there is none at all.
    fn all(&self, marks: &mut Vec<CaptureMark>) -> Result<(), String> {
        let named = |i: &u32| self.graph.resources[*i as usize].label == self.capture.resource;
        let mut reason = None;
        let mut found = false;
        for resource in (0..self.graph.resources.len() as u32).filter(named) {
            match self.one(resource) {
                Ok((after, version)) => {
                    found = true;
                    marks.push(CaptureMark {
                        after,
                        resource,
                        version,
                        capture: self.capture.clone(),
                    });
                }
                Err(why) => reason = Some(why),
            }
        }
        match (found, reason) {
            (true, _) => Ok(()),
            (false, Some(reason)) => Err(reason),
            (false, None) => {
                let names = self.graph.resources.iter().map(|r| r.label.as_str());
                let help = suggest(&self.capture.resource, names);
                Err(format!("no resource has this name; {help}"))
            }
        }
    }

    /// After how many nodes it is taken, and its version then.
    fn one(&self, resource: u32) -> Result<(u32, u32), String> {
        let r = &self.graph.resources[resource as usize];
        if let Shape::Texture { format, .. } = r.shape
            && copyable(format).is_none()
        {
            return Err(format!("{format:?} cannot be copied to a buffer"));
        }
        let import = match r.kind {
            Kind::Imported(i) => self.graph.imports.get(i as usize),
            _ => None,
        };
        let refuses = match import {
            Some(Import::Texture(t)) => {
                !t.usage().contains(wgpu::TextureUsages::COPY_SRC) || t.sample_count() > 1
            }
            Some(Import::Buffer(b)) => !b.usage().contains(wgpu::BufferUsages::COPY_SRC),
            None => false,
        };
        if refuses {
            return Err(
                "it is imported and cannot be copied: make it with COPY_SRC and one sample".into(),
            );
        }
        let exported = self
            .graph
            .exports
            .iter()
            .any(|e| e.raw.resource == resource);
        let used = |n: &u32| {
            let accesses = self.graph.nodes[*n as usize].accesses.clone();
            accesses
                .into_iter()
                .any(|i| self.graph.accesses[i as usize].resource == resource)
        };
        if !exported && !self.order.iter().any(used) {
            return Err("nothing that runs uses it".into());
        }
        // After how many nodes each version is there.
        let start = r.is_defined().then_some((0, 0));
        let writes: Vec<(u32, u32)> = start.into_iter().chain(self.writes(resource)).collect();
        match &self.capture.when {
            CaptureWhen::Last => {
                let last = writes.last().copied();
                last.ok_or_else(|| "nothing that runs writes it".into())
            }
            CaptureWhen::Version(version) => {
                // What stands in for a node that is off makes the same version, later.
                let found = writes.iter().rev().find(|w| w.1 == *version).copied();
                found.ok_or_else(|| {
                    let all: Vec<String> = writes.iter().map(|w| w.1.to_string()).collect();
                    format!("its versions that run are [{}]", all.join(", "))
                })
            }
            CaptureWhen::After(node) => {
                let name = |n: u32| self.graph.nodes[n as usize].label.as_str();
                let Some(at) = self.order.iter().position(|&n| name(n) == node.as_str()) else {
                    let names = self.order.iter().map(|&n| name(n));
                    return Err(format!(
                        "no node that runs has this name; {}",
                        suggest(node, names)
                    ));
                };
                let at = at as u32 + 1;
                let Some(&(_, version)) = writes.iter().rev().find(|w| w.0 <= at) else {
                    return Err(format!("nothing has written it when `{node}` has run"));
                };
                let tenant = self.slots.tenants.iter().find(|t| t.resource == resource);
                match tenant {
                    Some(t) if t.last != FOREVER && t.last + 1 < at => Err(format!(
                        "its last use is over when `{node}` has run, and its memory may be another's"
                    )),
                    _ => Ok((at, version)),
                }
            }
        }
    }

    /// After how many nodes a version is there, and which, for each write that runs.
    fn writes(&self, resource: u32) -> impl Iterator<Item = (u32, u32)> {
        (1..).zip(self.order).flat_map(move |(after, &n)| {
            let accesses = self.graph.nodes[n as usize].accesses.clone();
            let own = accesses.map(|i| &self.graph.accesses[i as usize]);
            let writes = own.filter(move |a| a.resource == resource && a.mode.writes());
            writes.map(move |a| (after, a.version + 1))
        })
    }
}
