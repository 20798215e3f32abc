//! What memory a pool holds, and what a plan needs.

use std::fmt;

use super::bytes;
use crate::compile::{ClassNeed, FOREVER, Tenant};
use crate::graph::Shape;
use crate::handle::Label;
use crate::plan::Plan;

/// Bytes of the textures and buffers that a pool holds, as their formats and sizes give them; a
/// driver may add padding. Imported resources are not counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// Of resources that live within a frame.
    pub transient: u64,
    /// Of all frames of all histories.
    pub history: u64,
    /// Of the buffer for uniform data and uploads; its staging memory comes on top.
    pub upload: u64,
    /// Each of them.
    pub resources: Vec<ResourceMemory>,
}

/// One texture or buffer of a pool.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResourceMemory {
    /// Of the resource that comes there first in the plan that was given it last, or of the history.
    pub name: Label,
    /// Size and format.
    pub shape: String,
    /// Bytes.
    pub bytes: u64,
    /// Whether it is a frame of a history.
    pub history: bool,
}

/// Bytes that the transients of a plan need, as their formats and sizes give them, and who shares them.
/// `Display` prints it all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlanMemory {
    /// If each had its own.
    pub without_reuse: u64,
    /// The most that is live at once: less is impossible, whatever could share memory with whatever.
    pub lower_bound: u64,
    /// The first node at which that much is live.
    pub peak: Option<Label>,
    /// Of all slots. wgpu gives out whole textures and buffers, so what is free in one class is of no use
    /// to another.
    pub achieved: u64,
    /// Of all frames of the histories that the plan declares.
    pub histories: u64,
    /// In the order of first use.
    pub classes: Vec<ClassMemory>,
    /// In the order of first use.
    pub slots: Vec<SlotMemory>,
}

/// Transients that can stand in for each other: textures of the same size, mips, layers, format but for
/// sRGB, and both or neither a storage binding; buffers of up to the same power of two. What is exported
/// or given to a foreign node keeps exactly its format and size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClassMemory {
    /// What they have in common.
    pub shape: String,
    /// Its slots.
    pub slots: usize,
    /// The most of its transients that live at once: with fewer slots none can do.
    pub least: usize,
    /// Of its slots.
    pub bytes: u64,
}

/// One texture or buffer that transients share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlotMemory {
    /// Index into [`PlanMemory::classes`].
    pub class: usize,
    /// As many as the largest that lives there asked for.
    pub bytes: u64,
    /// Who lives there, in order.
    pub tenants: Vec<TenantMemory>,
}

/// A transient that lives in a slot from one node to another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TenantMemory {
    /// The resource.
    pub name: Label,
    /// Its index in the order of declaration.
    pub resource: u32,
    /// Bytes that were asked for.
    pub bytes: u64,
    /// Position of the node that uses it first, in [`Plan::order`].
    pub first: u32,
    /// Position of the node that uses it last; `None` for what is exported, which stays until the next encode.
    pub last: Option<u32>,
    /// The names of those two nodes.
    pub nodes: (Label, Option<Label>),
}

impl Plan<'_> {
    /// Which slots the transients share, and what that saves. Needs no GPU.
    pub fn memory(&self) -> PlanMemory {
        let (graph, schedule) = (&self.graph, &*self.schedule);
        let slots = &schedule.slots;
        let name = |at: u32| {
            let node = *schedule.order.get(at as usize)?;
            Some(graph.nodes[node as usize].label.clone())
        };
        let mut memory = PlanMemory {
            classes: slots.classes.iter().map(ClassMemory::new).collect(),
            ..PlanMemory::default()
        };
        for slot in &slots.slots {
            let class = slot.class as usize;
            memory.slots.push(SlotMemory {
                class,
                bytes: slot.bytes,
                tenants: Vec::new(),
            });
            memory.classes[class].slots += 1;
            memory.classes[class].bytes += slot.bytes;
            memory.achieved += slot.bytes;
        }
        let asked = |t: &Tenant| bytes(&graph.resources[t.resource as usize].shape);
        for t in &slots.tenants {
            let Some(first) = name(t.first) else { continue };
            memory.without_reuse += asked(t);
            memory.slots[t.slot as usize].tenants.push(TenantMemory {
                name: graph.resources[t.resource as usize].label.clone(),
                resource: t.resource,
                bytes: asked(t),
                first: t.first,
                last: (t.last != FOREVER).then_some(t.last),
                nodes: (first, name(t.last)),
            });
        }
        let (lower_bound, at) = most(&slots.tenants, 1, |t| (0, asked(t)))[0];
        (memory.lower_bound, memory.peak) = (lower_bound, at.and_then(name));
        let bounds = most(&slots.tenants, slots.classes.len(), |t| {
            (t.class as usize, 1)
        });
        for (class, (least, _)) in memory.classes.iter_mut().zip(bounds) {
            class.least = least as usize;
        }
        for h in &graph.histories {
            memory.histories += bytes(&h.shape) * u64::from(h.frames + 1);
        }
        memory
    }
}

/// For each group the most weight that lives at once, and the first position where it does, which is where
/// something begins.
fn most(
    tenants: &[Tenant],
    groups: usize,
    weight: impl Fn(&Tenant) -> (usize, u64),
) -> Vec<(u64, Option<u32>)> {
    let mut leaving: Vec<&Tenant> = tenants.iter().collect();
    leaving.sort_by_key(|t| t.last);
    let mut leaving = leaving.into_iter().peekable();
    let mut live = vec![0; groups];
    let mut most = vec![(0, None); groups];
    for t in tenants {
        while let Some(gone) = leaving.next_if(|gone| gone.last < t.first) {
            let (group, weight) = weight(gone);
            live[group] -= weight;
        }
        let (group, weight) = weight(t);
        live[group] += weight;
        if live[group] > most[group].0 {
            most[group] = (live[group], Some(t.first));
        }
    }
    most
}

impl ClassMemory {
    fn new(need: &ClassNeed) -> Self {
        let (shape, also) = need.real_shape();
        let mut text = match (shape, need.class.exact) {
            (Shape::Buffer { bytes }, false) => format!("at most {bytes} bytes"),
            _ => shape.to_string(),
        };
        if let Some(format) = also {
            text += &format!(" or {format:?}");
        }
        if need.class.storage {
            text += ", storage";
        }
        if need.class.exact {
            text += ", exact";
        }
        ClassMemory {
            shape: text,
            slots: 0,
            least: 0,
            bytes: 0,
        }
    }
}

impl fmt::Display for PlanMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "without reuse {} bytes", self.without_reuse)?;
        write!(f, "lower bound {} bytes", self.lower_bound)?;
        match &self.peak {
            Some(node) => writeln!(f, ", at {node}")?,
            None => writeln!(f)?,
        }
        writeln!(f, "achieved {} bytes", self.achieved)?;
        writeln!(f, "histories {} bytes", self.histories)?;
        for (i, class) in self.classes.iter().enumerate() {
            writeln!(
                f,
                "class {}: {} slots, at least {}, {} bytes",
                class.shape, class.slots, class.least, class.bytes
            )?;
            for (n, slot) in self.slots.iter().enumerate().filter(|(_, s)| s.class == i) {
                write!(f, "  slot {n}, {} bytes:", slot.bytes)?;
                for (k, tenant) in slot.tenants.iter().enumerate() {
                    let comma = if k > 0 { "," } else { "" };
                    write!(f, "{comma} {} ({}", tenant.name, tenant.nodes.0)?;
                    match (&tenant.nodes.1, tenant.last) {
                        (_, Some(last)) if last == tenant.first => write!(f, ")")?,
                        (Some(last), _) => write!(f, " to {last})")?,
                        (None, _) => write!(f, " to the end)")?,
                    }
                }
                writeln!(f)?;
            }
        }
        Ok(())
    }
}
