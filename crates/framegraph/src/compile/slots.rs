//! Which transients share memory: lifetimes over the plan's order, then interval colouring inside each
//! class of what can stand in for each other.
//!
//! Whoever comes takes a slot of its class that is free, in the order of first use: a new slot is made only
//! when all are taken, so there are as many as the most that live at once, and no assignment can do with
//! fewer.

use std::cmp::Reverse;
use std::collections::{HashMap, VecDeque};

use super::{NONE, Schedule, reset};
use crate::graph::{Caps, FrameGraph, Kind, Shape};
use crate::pool::{Hasher, bytes};
use crate::state::State;

/// What may share one texture or buffer, one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Class {
    /// A format without its sRGB suffix and a buffer's size rounded up to a power of two, unless `exact`.
    pub shape: Shape,
    /// The texture or buffer itself leaves the graph, by an export or to a foreign node: it has the
    /// format and the size that were asked for.
    pub exact: bool,
    /// Textures that are storage bindings stand apart, because that may turn off compression.
    pub storage: bool,
}

/// What one plan needs of a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ClassNeed {
    pub class: Class,
    /// Whether it is seen without the format's sRGB suffix, and whether with it.
    pub seen: [bool; 2],
    /// wgpu's bits of the usage of all in the class: more usage than a resource needs costs nothing, and
    /// leaves it open which slot it gets.
    pub usage: u32,
}

impl ClassNeed {
    /// The class with the format to make, and the format that views may have besides.
    pub fn real_shape(&self) -> (Shape, Option<wgpu::TextureFormat>) {
        let mut shape = self.class.shape;
        let mut also = None;
        match (&mut shape, self.seen) {
            (Shape::Texture { format, .. }, [true, true]) => also = Some(format.add_srgb_suffix()),
            (Shape::Texture { format, .. }, [false, true]) => *format = format.add_srgb_suffix(),
            _ => {}
        }
        (shape, also)
    }
}

/// One texture or buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    pub class: u32,
    /// The most that a tenant asks for.
    pub bytes: u64,
    /// The resource that is there first.
    pub first: u32,
}

/// A transient and the positions in the plan's order at which it is used first and last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tenant {
    pub resource: u32,
    pub class: u32,
    pub first: u32,
    /// `FOREVER` for what is exported.
    pub last: u32,
    pub slot: u32,
}

/// To the end of the plan, and beyond until the next is encoded.
pub(crate) const FOREVER: u32 = u32::MAX;

/// The transients of a plan, and the memory they share.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Slots {
    pub classes: Vec<ClassNeed>,
    /// In the order of their first tenants.
    pub slots: Vec<Slot>,
    /// The slots from the largest to the smallest.
    pub by_size: Vec<u32>,
    /// In the order of first use.
    pub tenants: Vec<Tenant>,
    /// For each resource its slot; `NONE` for what is not transient or not used.
    pub of: Vec<u32>,
}

impl Slots {
    /// Empties it for another graph.
    pub fn clear(&mut self) {
        self.classes.clear();
        self.slots.clear();
        self.by_size.clear();
        self.tenants.clear();
        self.of.clear();
    }
}

#[derive(Default)]
pub(crate) struct Lists {
    /// For each resource its place among the tenants, and whether it leaves the graph.
    place: Vec<u32>,
    exact: Vec<bool>,
    /// The number of each class.
    known: HashMap<Class, u32, Hasher>,
    assignment: Assignment,
}

impl Lists {
    /// Finds lifetimes and classes of all transients that are used, and assigns their slots.
    pub fn slots(&mut self, graph: &FrameGraph<'_>, s: &mut Schedule) {
        self.tenants(graph, &s.order, &mut s.slots.tenants);
        let Slots {
            classes,
            slots,
            by_size,
            tenants,
            of,
        } = &mut s.slots;
        self.known.clear();
        for tenant in &mut *tenants {
            let resource = tenant.resource as usize;
            let shape = &graph.resources[resource].shape;
            let usage = s.usage[resource].unwrap_or(0) | free_usage(shape, &graph.caps);
            let class = class(shape, usage, self.exact[resource], &graph.caps);
            tenant.class = *self.known.entry(class).or_insert_with(|| {
                classes.push(ClassNeed {
                    class,
                    seen: [false; 2],
                    usage: 0,
                });
                classes.len() as u32 - 1
            });
            let need = &mut classes[tenant.class as usize];
            need.usage |= usage;
            if let Shape::Texture { format, .. } = shape {
                need.seen[format.is_srgb() as usize] = true;
            }
        }
        let reuse = !graph.debug.no_reuse;
        (self.assignment).assign(tenants, classes.len(), reuse, slots);
        reset(of, graph.resources.len(), NONE);
        for tenant in &*tenants {
            of[tenant.resource as usize] = tenant.slot;
            let slot = &mut slots[tenant.slot as usize];
            slot.bytes = slot
                .bytes
                .max(bytes(&graph.resources[tenant.resource as usize].shape));
        }
        by_size.extend(0..slots.len() as u32);
        by_size.sort_unstable_by_key(|&slot| (Reverse(slots[slot as usize].bytes), slot));
    }

    /// The lifetimes of all transients that are used, and for each resource whether it leaves the graph.
    /// A lifetime is of the whole resource: wgpu cannot give out a part of a texture.
    fn tenants(&mut self, graph: &FrameGraph<'_>, order: &[u32], tenants: &mut Vec<Tenant>) {
        let Lists { place, exact, .. } = self;
        reset(place, graph.resources.len(), NONE);
        reset(exact, graph.resources.len(), false);
        for (at, &n) in (0..).zip(order) {
            let node = &graph.nodes[n as usize];
            for a in &graph.accesses[node.accesses.start as usize..node.accesses.end as usize] {
                let resource = a.resource as usize;
                if !matches!(graph.resources[resource].kind, Kind::Transient) {
                    continue;
                }
                exact[resource] |= a.state == State::Foreign;
                if place[resource] == NONE {
                    place[resource] = tenants.len() as u32;
                    tenants.push(Tenant {
                        resource: a.resource,
                        class: 0,
                        first: at,
                        last: at,
                        slot: 0,
                    });
                }
                tenants[place[resource] as usize].last = at;
            }
        }
        for export in &graph.exports {
            let resource = export.raw.resource as usize;
            exact[resource] = true;
            if let Some(tenant) = tenants.get_mut(place[resource] as usize) {
                tenant.last = FOREVER;
            }
        }
    }
}

#[derive(Default)]
struct Assignment {
    /// For each position the first tenant that is there for the last time, and for each tenant the next.
    leaving: Vec<u32>,
    next: Vec<u32>,
    /// For each class the slots that nobody has.
    free: Vec<VecDeque<u32>>,
}

impl Assignment {
    /// Gives each tenant, sorted by first use, a slot of its class that nobody else has meanwhile, and lists
    /// the slots, yet without their sizes. Without `reuse` each gets its own.
    fn assign(
        &mut self,
        tenants: &mut [Tenant],
        classes: usize,
        reuse: bool,
        slots: &mut Vec<Slot>,
    ) {
        let Assignment {
            leaving,
            next,
            free,
        } = self;
        leaving.clear();
        reset(next, tenants.len(), NONE);
        for (i, tenant) in (0..tenants.len() as u32).zip(&*tenants).rev() {
            if tenant.last != FOREVER {
                let at = tenant.last as usize;
                leaving.resize(leaving.len().max(at + 1), NONE);
                next[i as usize] = std::mem::replace(&mut leaving[at], i);
            }
        }
        free.resize_with(free.len().max(classes), VecDeque::new);
        free.iter_mut().for_each(VecDeque::clear);
        let mut at = 0;
        for i in 0..tenants.len() {
            let Tenant {
                resource,
                class,
                first,
                ..
            } = tenants[i];
            while reuse && at < first {
                let mut gone = leaving.get(at as usize).copied().unwrap_or(NONE);
                while let Some(tenant) = tenants.get(gone as usize) {
                    free[tenant.class as usize].push_back(tenant.slot);
                    gone = next[gone as usize];
                }
                at += 1;
            }
            // The one that has been free for longest: what its last tenant did is likely to be over, and
            // the barrier between the two waits for nothing.
            tenants[i].slot = free[class as usize].pop_front().unwrap_or_else(|| {
                slots.push(Slot {
                    class,
                    bytes: 0,
                    first: resource,
                });
                slots.len() as u32 - 1
            });
        }
    }
}

fn class(shape: &Shape, usage: u32, exact: bool, caps: &Caps) -> Class {
    let storage =
        (wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::STORAGE_ATOMIC).bits();
    let mut class = Class {
        shape: *shape,
        exact: false,
        storage: false,
    };
    match &mut class.shape {
        Shape::Texture { format, .. } => {
            class.storage = usage & storage != 0;
            // Without a sibling the format is exact anyway.
            class.exact = exact && format.remove_srgb_suffix() != format.add_srgb_suffix();
            if caps.view_formats && !exact {
                *format = format.remove_srgb_suffix();
            }
        }
        Shape::Buffer { bytes } => {
            class.exact = exact;
            if !exact {
                *bytes = bytes.next_power_of_two();
            }
        }
    }
    class
}

/// Usage that every transient has: it costs nothing, and lets anything be captured and clobbered without
/// a change of the plan.
fn free_usage(shape: &Shape, caps: &Caps) -> u32 {
    match shape {
        Shape::Texture { format, .. } => {
            let copies = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST;
            let features = format.guaranteed_format_features(caps.features);
            (copies & features.allowed_usages).bits()
        }
        Shape::Buffer { .. } => {
            (wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST).bits()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn assign(tenants: &mut [Tenant], classes: usize, reuse: bool) -> Vec<Slot> {
        let mut slots = Vec::new();
        Assignment::default().assign(tenants, classes, reuse, &mut slots);
        slots
    }

    fn tenant((class, first, length): (u32, u32, u32)) -> Tenant {
        Tenant {
            resource: 0,
            class,
            first,
            last: first + length,
            slot: NONE,
        }
    }

    /// As drawn: `c` cannot take the slot of `a`, which ends where `c` begins; `d` takes the one that
    /// was free first.
    /// ```text
    /// a 0--1
    /// b  -1
    /// c   1---3
    /// d     2-3
    /// ```
    #[test]
    fn a_tenant_that_reads_the_last_keeps_off_its_slot() {
        let mut all = [(0, 0, 1), (0, 1, 0), (0, 1, 2), (0, 2, 1)].map(tenant);
        assert_eq!(assign(&mut all, 1, true).len(), 3);
        assert_eq!(all.map(|t| t.slot), [0, 1, 2, 0]);
        assert_eq!(assign(&mut all, 1, false).len(), 4);
        assert_eq!(all.map(|t| t.slot), [0, 1, 2, 3]);
    }

    /// Reuse must be checked against all tenants: `b` and `c` both fit after `a`, but not both at once.
    #[test]
    fn two_that_live_together_do_not_share_the_slot_of_a_third() {
        let mut all = [(0, 0, 0), (0, 1, 3), (0, 2, 2)].map(tenant);
        assign(&mut all, 1, true);
        assert_eq!(all.map(|t| t.slot), [0, 0, 1]);
    }

    /// What is exported is never given back.
    #[test]
    fn an_export_keeps_its_slot() {
        let mut all = [(0, 0, 0), (0, 5, 0)].map(tenant);
        all[0].last = FOREVER;
        assert_eq!(assign(&mut all, 1, true).len(), 2);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// From the definition, for all pairs and all positions.
        #[test]
        fn assignment_is_sound_and_optimal(
            mut all in prop::collection::vec((0u32..4, 0u32..40, 0u32..12).prop_map(tenant), 0..80),
        ) {
            all.sort_by_key(|t| t.first);
            let slots = assign(&mut all, 4, true);
            for (i, a) in all.iter().enumerate() {
                prop_assert_eq!(slots[a.slot as usize].class, a.class);
                for b in &all[..i] {
                    let together = a.first <= b.last && b.first <= a.last;
                    prop_assert!(a.slot != b.slot || !together, "{:?} {:?}", a, b);
                }
            }
            for class in 0..4 {
                let live = |at: u32| {
                    all.iter().filter(|t| t.class == class && t.first <= at && at <= t.last).count()
                };
                let most = (0..60).map(live).max().unwrap_or(0);
                prop_assert_eq!(slots.iter().filter(|s| s.class == class).count(), most);
            }
        }
    }
}
