//! Counters that kernels add to and that are shown beside a pass's time.

use framegraph::Buffer;
use scumble::{Dispatch, PassFrame, Stat};

/// A `u32` on the GPU, 0 at the beginning of the frame.
#[derive(Clone, Copy)]
pub(crate) struct Counter {
    name: &'static str,
    buffer: Buffer,
}

impl Counter {
    /// Starts at 0 in this frame; `name` is also the binding of kernels that add to it.
    pub fn start(name: &'static str, frame: &mut PassFrame<'_, '_>) -> Self {
        let label = frame.label(name);
        let graph = frame.graph();
        let buffer = graph.buffer(label.clone(), 4);
        Self {
            name,
            buffer: graph.fill_buffer(label, buffer, 0),
        }
    }

    /// Binds it to a kernel that adds to it.
    pub fn bind<'d, 'a, 'f>(&mut self, dispatch: Dispatch<'d, 'a, 'f>) -> Dispatch<'d, 'a, 'f> {
        let (dispatch, next) = dispatch.modify_buffer(self.name, self.buffer);
        self.buffer = next;
        dispatch
    }

    /// Shows what it counted.
    pub fn report(self, frame: &mut PassFrame<'_, '_>) {
        frame.report(self.name, Stat::Buffer(self.buffer));
    }
}
