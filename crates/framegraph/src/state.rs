//! The states a resource passes through, and what they mean to wgpu.

use std::fmt;

/// How a node touches contents.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// Reads them.
    Read,
    /// Writes some of them; the rest stays.
    Modify,
    /// Writes every texel or byte; what was there is not needed.
    Overwrite,
}

impl Mode {
    pub(crate) fn writes(self) -> bool {
        self != Mode::Read
    }

    pub(crate) fn reads(self) -> bool {
        self != Mode::Overwrite
    }
}

/// What a range of a resource is used as during a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// Nothing yet this frame: a transient or a history before its first write.
    Undefined,
    /// What the engine left an imported resource in.
    External,
    /// What the last frame left a history in.
    Kept,
    /// Sampled or loaded by a shader.
    Sampled,
    /// A read-only storage binding.
    StorageRead,
    /// A write-only storage texture.
    StorageWrite,
    /// A storage buffer or texture that may be read and written.
    StorageReadWrite,
    /// A colour attachment.
    ColorTarget,
    /// A depth attachment.
    DepthTarget,
    /// Source of a copy.
    CopySource,
    /// Target of a copy, a fill or an upload.
    CopyTarget,
    /// A uniform buffer.
    Uniform,
    /// Arguments of an indirect dispatch.
    Indirect,
    /// Whatever a foreign node does with it.
    Foreign,
}

impl State {
    /// As wgpu tracks it.
    pub(crate) fn uses(self) -> Uses {
        match self {
            State::Undefined | State::External | State::Kept | State::Foreign => Uses(0),
            known => Uses(1 << known as u16),
        }
    }

    /// Whether wgpu will place a barrier between two known states: they differ, or an exclusive
    /// state follows itself (attachments too, as on Vulkan).
    pub fn needs_barrier(before: State, after: State) -> bool {
        before.uses().barrier(after.uses())
    }

    /// In the words of wgpu's tracker, of what can be batched.
    pub(crate) fn texture_uses(self) -> wgpu::TextureUses {
        use wgpu::TextureUses as U;
        match self {
            State::Sampled => U::RESOURCE,
            State::StorageRead => U::STORAGE_READ_ONLY,
            State::CopySource => U::COPY_SRC,
            _ => U::empty(),
        }
    }

    /// In the words of wgpu's tracker, of what can be batched.
    pub(crate) fn buffer_uses(self) -> wgpu::BufferUses {
        use wgpu::BufferUses as U;
        match self {
            State::StorageRead => U::STORAGE_READ_ONLY,
            State::Uniform => U::UNIFORM,
            State::CopySource => U::COPY_SRC,
            _ => U::empty(),
        }
    }

    pub(crate) fn texture_usage(self) -> wgpu::TextureUsages {
        use wgpu::TextureUsages as U;
        match self {
            State::Sampled => U::TEXTURE_BINDING,
            State::StorageRead | State::StorageWrite | State::StorageReadWrite => {
                U::STORAGE_BINDING
            }
            State::ColorTarget | State::DepthTarget => U::RENDER_ATTACHMENT,
            State::CopySource => U::COPY_SRC,
            State::CopyTarget => U::COPY_DST,
            _ => U::empty(),
        }
    }

    pub(crate) fn buffer_usage(self) -> wgpu::BufferUsages {
        use wgpu::BufferUsages as U;
        match self {
            State::StorageRead | State::StorageWrite | State::StorageReadWrite => U::STORAGE,
            State::Uniform => U::UNIFORM,
            State::Indirect => U::INDIRECT,
            State::CopySource => U::COPY_SRC,
            State::CopyTarget => U::COPY_DST,
            _ => U::empty(),
        }
    }
}

/// A bit for each state that a node puts something in; none where what it does is not known to the graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Uses(u16);

impl Uses {
    /// What only reads: wgpu places no barrier between two uses that are the same and only this.
    const INCLUSIVE: u16 = 1 << State::Sampled as u16
        | 1 << State::StorageRead as u16
        | 1 << State::CopySource as u16
        | 1 << State::Uniform as u16
        | 1 << State::Indirect as u16;

    /// Whether the barrier before them can stand anywhere after the last use. wgpu makes those for writes again, and
    /// uses arguments in a way of its own.
    pub fn can_be_batched(self) -> bool {
        let can = Uses::INCLUSIVE & !(1 << State::Indirect as u16);
        self.0.is_power_of_two() && self.0 & can != 0
    }

    /// Whether wgpu places a barrier between the two.
    pub fn barrier(self, after: Uses) -> bool {
        let known = self.0 != 0 && after.0 != 0;
        known && (self.0 != after.0 || after.0 & !Uses::INCLUSIVE != 0)
    }
}

impl std::ops::BitOr for Uses {
    type Output = Uses;

    fn bitor(self, other: Uses) -> Uses {
        Uses(self.0 | other.0)
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            State::Undefined => "undefined",
            State::External => "external",
            State::Kept => "kept",
            State::Sampled => "sampled",
            State::StorageRead => "storage-read",
            State::StorageWrite => "storage-write",
            State::StorageReadWrite => "storage-read-write",
            State::ColorTarget => "color-target",
            State::DepthTarget => "depth-target",
            State::CopySource => "copy-source",
            State::CopyTarget => "copy-target",
            State::Uniform => "uniform",
            State::Indirect => "indirect",
            State::Foreign => "foreign",
        })
    }
}
