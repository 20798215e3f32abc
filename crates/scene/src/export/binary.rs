//! The binary buffer of a glTF file with the views and accessors into it.

use bytemuck::Pod;
use serde_json::{Value, json};

/// A growing buffer. Every view starts at a multiple of four bytes.
#[derive(Default)]
pub(super) struct Binary {
    pub(super) bytes: Vec<u8>,
    pub(super) views: Vec<Value>,
    pub(super) accessors: Vec<Value>,
}

const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

impl Binary {
    /// Adds bytes; returns the index of their view.
    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.views.push(json!({
            "buffer": 0,
            "byteOffset": self.bytes.len(),
            "byteLength": bytes.len(),
        }));
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    /// Adds rows of floats; returns the index of their accessor.
    pub(super) fn floats<const N: usize>(&mut self, rows: &[[f32; N]]) -> usize
    where
        [f32; N]: Pod,
    {
        let index = self.accessor(rows, F32, kind(N));
        // Required for positions and key times, right for all.
        let extreme = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..N)
                .map(|c| rows.iter().map(|row| row[c]).reduce(pick).unwrap_or(0.0))
                .collect()
        };
        self.accessors[index]["min"] = json!(extreme(f32::min));
        self.accessors[index]["max"] = json!(extreme(f32::max));
        index
    }

    /// Adds indices; returns the index of their accessor.
    pub(super) fn indices(&mut self, indices: &[u32]) -> usize {
        self.accessor(indices, U32, "SCALAR")
    }

    /// Adds rows of four joints; returns the index of their accessor.
    pub(super) fn joints(&mut self, rows: &[[u16; 4]]) -> usize {
        self.accessor(rows, U16, "VEC4")
    }

    fn accessor<T: Pod>(&mut self, rows: &[T], component: u32, kind: &str) -> usize {
        let view = self.view(bytemuck::cast_slice(rows));
        self.accessors.push(json!({
            "bufferView": view,
            "componentType": component,
            "count": rows.len(),
            "type": kind,
        }));
        self.accessors.len() - 1
    }
}

fn kind(components: usize) -> &'static str {
    match components {
        1 => "SCALAR",
        2 => "VEC2",
        3 => "VEC3",
        4 => "VEC4",
        _ => "MAT4",
    }
}
