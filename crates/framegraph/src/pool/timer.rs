//! GPU time of each node, by timestamp queries.

use crate::handle::Label;

/// GPU time of one node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeTiming {
    /// The node's name.
    pub name: Label,
    /// From the start of the node to its end. While nodes are timed they wait for each other, so that
    /// none is charged with another's work and the sum is the frame; the first dispatch of a pipeline
    /// may include its compilation by the driver.
    pub nanoseconds: u64,
}

/// Two queries per node; wgpu's query sets hold at most this many.
const PER_SET: u32 = wgpu::QUERY_SET_MAX_QUERIES;

#[derive(Default)]
pub(crate) struct Timer {
    sets: Vec<wgpu::QuerySet>,
    resolve: Option<wgpu::Buffer>,
    read: Option<wgpu::Buffer>,
    names: Vec<Label>,
    /// Nobody reads it: a barrier on it is what nodes wait at.
    wait: Option<wgpu::Buffer>,
}

impl Timer {
    /// Forgets the last plan's measurements.
    pub fn begin(&mut self, device: &wgpu::Device, nodes: usize) {
        self.names.clear();
        if nodes == 0 {
            return;
        }
        self.wait.get_or_insert_with(|| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("framegraph wait"),
                size: 4,
                usage: wgpu::BufferUsages::STORAGE,
                mapped_at_creation: false,
            })
        });
        while (self.sets.len() * PER_SET as usize) < 2 * nodes {
            self.sets
                .push(device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("framegraph timestamps"),
                    ty: wgpu::QueryType::Timestamp,
                    count: PER_SET,
                }));
        }
    }

    /// The query set of a node's two timestamps, and the index of the first.
    pub fn node(&mut self, name: &Label) -> Option<(wgpu::QuerySet, u32)> {
        let query = 2 * self.names.len() as u32;
        let set = self.sets.get((query / PER_SET) as usize)?.clone();
        self.names.push(name.clone());
        Some((set, query % PER_SET))
    }

    /// A barrier between a timestamp and the dispatch beside it. Independent dispatches have none of their
    /// own: on a GPU they overlap, and llvmpipe writes a timestamp only when a barrier makes it.
    pub fn wait(&self, pass: &mut wgpu::ComputePass<'_>) {
        // Writable storage twice in a row: the one transition that wgpu never leaves out.
        let state = wgpu::BufferUses::STORAGE_READ_WRITE;
        let waited = self
            .wait
            .iter()
            .map(|buffer| wgpu::BufferTransition { buffer, state });
        pass.transition_resources(waited, std::iter::empty());
    }

    /// Records the copy of all queries to a buffer that can be read.
    pub fn end(&mut self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder) {
        let queries = 2 * self.names.len() as u32;
        if queries == 0 {
            return;
        }
        let size = u64::from(queries.next_multiple_of(PER_SET)) * 8;
        if self.resolve.as_ref().is_none_or(|b| b.size() < size) {
            let buffer = |usage| {
                Some(device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("framegraph timestamps"),
                    size,
                    usage,
                    mapped_at_creation: false,
                }))
            };
            self.resolve = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
            self.read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        }
        let (Some(resolve), Some(read)) = (&self.resolve, &self.read) else {
            return;
        };
        for (i, set) in self.sets.iter().enumerate() {
            let first = i as u32 * PER_SET;
            if first < queries {
                let count = (queries - first).min(PER_SET);
                encoder.resolve_query_set(set, 0..count, resolve, u64::from(first) * 8);
            }
        }
        encoder.copy_buffer_to_buffer(resolve, 0, read, 0, u64::from(queries) * 8);
    }

    /// Waits for the GPU and reads the measurements, once.
    pub fn read(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Vec<NodeTiming> {
        let names = std::mem::take(&mut self.names);
        let Some(buffer) = self.read.as_ref().filter(|_| !names.is_empty()) else {
            return Vec::new();
        };
        let slice = buffer.slice(..names.len() as u64 * 16);
        let (send, receive) = std::sync::mpsc::channel();
        slice.map_async(wgpu::MapMode::Read, move |result| {
            // The receiver only goes away together with the wish to know.
            let _ = send.send(result);
        });
        if device.poll(wgpu::PollType::wait_indefinitely()).is_err()
            || !matches!(receive.try_recv(), Ok(Ok(())))
        {
            return Vec::new();
        }
        let period = f64::from(queue.get_timestamp_period());
        let timings = match slice.get_mapped_range() {
            Ok(bytes) => names
                .into_iter()
                .zip(bytes.chunks_exact(16))
                .map(|(name, pair)| {
                    let tick = |at: usize| {
                        let mut word = [0; 8];
                        word.copy_from_slice(&pair[at..at + 8]);
                        u64::from_le_bytes(word)
                    };
                    let ticks = tick(8).saturating_sub(tick(0));
                    NodeTiming {
                        name,
                        nanoseconds: (ticks as f64 * period) as u64,
                    }
                })
                .collect(),
            Err(_) => Vec::new(),
        };
        buffer.unmap();
        timings
    }
}
