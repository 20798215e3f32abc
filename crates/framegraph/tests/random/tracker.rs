//! wgpu's tracking of what memory is used as within one encoder, after its source.
//!
//! In wgpu-core 30 `UsageScope` (`track/mod.rs`) joins the uses of one dispatch, render pass or copy, and
//! `insert_or_barrier_update` (`track/buffer.rs`, `track/texture.rs`) compares them with those before: buffers whole,
//! textures for each mip and layer. The first use in an encoder is inserted, and settled when it is submitted. Later
//! ones have a barrier unless `skip_barrier` (`track/mod.rs`) finds the same use as before, all of it ordered; what is
//! ordered on Vulkan say `get_ordered_buffer_usages` and `get_ordered_texture_usages` (`vulkan/adapter.rs` of wgpu-hal).

use std::collections::{HashMap, HashSet};

use framegraph::{Plan, State};

use crate::frame::{Frame, Shape};

/// wgpu's words for what something is used as.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Uses {
    Buffer(wgpu::BufferUses),
    Texture(wgpu::TextureUses),
    /// What foreign code does is not known to the plan.
    Foreign,
}

pub struct Tracker<'a> {
    frame: &'a Frame,
    uses: HashMap<usize, Uses>,
    /// For a resource the one that had its slot before.
    before: HashMap<usize, usize>,
}

impl<'a> Tracker<'a> {
    pub fn new(frame: &'a Frame, plan: &Plan<'_>) -> Self {
        let named = |name: &str| frame.resources.iter().position(|r| r.name == name);
        let mut before = HashMap::new();
        for slot in plan.memory().slots {
            for pair in slot.tenants.windows(2) {
                before.extend(named(&pair[1].name).zip(named(&pair[0].name)));
            }
        }
        Tracker {
            frame,
            uses: HashMap::new(),
            before,
        }
    }

    /// What the memory of a place was used as last in the encoder.
    fn last(&self, mut place: usize) -> Option<Uses> {
        loop {
            if let Some(&uses) = self.uses.get(&place) {
                return Some(uses);
            }
            place = 16 * self.before.get(&(place / 16))? + place % 16;
        }
    }

    /// The places that have a barrier in front of a step that uses them so.
    pub fn step(&mut self, uses: &[(usize, State)]) -> HashSet<usize> {
        let mut joined: HashMap<usize, Uses> = HashMap::new();
        for &(place, state) in uses {
            let shape = self.frame.resources[place / 16].shape;
            let next = match shape {
                _ if state == State::Foreign => Uses::Foreign,
                Shape::Buffer { .. } => Uses::Buffer(buffer_use(state)),
                Shape::Texture { .. } => Uses::Texture(texture_use(state)),
            };
            let all = match (joined.get(&place), next) {
                (Some(Uses::Buffer(a)), Uses::Buffer(b)) => Uses::Buffer(*a | b),
                (Some(Uses::Texture(a)), Uses::Texture(b)) => Uses::Texture(*a | b),
                _ => next,
            };
            joined.insert(place, all);
        }
        let barrier = |(place, after): (&usize, &Uses)| match (self.last(*place)?, *after) {
            (Uses::Foreign, _) | (_, Uses::Foreign) => None,
            (before, after) => (before != after || !ordered(before)).then_some(*place),
        };
        let barriers = joined.iter().filter_map(barrier).collect();
        self.uses.extend(joined);
        barriers
    }
}

/// Whether uses keep their order without a barrier.
fn ordered(uses: Uses) -> bool {
    match uses {
        Uses::Buffer(u) => (wgpu::BufferUses::INCLUSIVE | wgpu::BufferUses::MAP_WRITE).contains(u),
        Uses::Texture(u) => wgpu::TextureUses::INCLUSIVE.contains(u),
        Uses::Foreign => false,
    }
}

fn texture_use(state: State) -> wgpu::TextureUses {
    use wgpu::TextureUses as U;
    match state {
        State::Sampled => U::RESOURCE,
        State::StorageRead => U::STORAGE_READ_ONLY,
        State::StorageWrite => U::STORAGE_WRITE_ONLY,
        State::StorageReadWrite => U::STORAGE_READ_WRITE,
        State::ColorTarget => U::COLOR_TARGET,
        State::CopySource => U::COPY_SRC,
        State::CopyTarget => U::COPY_DST,
        state => panic!("no texture is used as {state}"),
    }
}

fn buffer_use(state: State) -> wgpu::BufferUses {
    use wgpu::BufferUses as U;
    match state {
        State::StorageRead => U::STORAGE_READ_ONLY,
        State::StorageReadWrite => U::STORAGE_READ_WRITE,
        State::Uniform => U::UNIFORM,
        State::Indirect => U::INDIRECT,
        State::CopySource => U::COPY_SRC,
        State::CopyTarget => U::COPY_DST,
        state => panic!("no buffer is used as {state}"),
    }
}
