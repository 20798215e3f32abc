//! Ports: the named textures that a pass reads and writes.

use crate::signal::Signal;

/// One input or output of a pass.
///
/// ```
/// use scumble::{Port, signal};
///
/// let inputs = [
///     Port::any("value").about("what is filtered"),
///     Port::new("grid_normal", signal::NORMAL).grid().source("normal"),
///     Port::new("mask", signal::MASK).optional(),
/// ];
/// assert!(inputs[2].optional);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port {
    /// Its name; unique among the inputs and among the outputs of a pass. Words are joined by `_`.
    pub name: &'static str,
    /// What it carries.
    pub signal: PortSignal,
    /// How large its texture is.
    pub resolution: Resolution,
    /// For an input: the pass runs without it, and it is never wired implicitly. For an output: the
    /// pass may skip the work when nobody reads it.
    pub optional: bool,
    /// For an input: the port name it looks for when it is not wired by name. Default: its own.
    pub source: Option<&'static str>,
    /// For an input: what a read of the previous frame gets when there is none.
    pub first: Option<FirstFrame>,
    /// For an output: stored in [`Signal::precise_format`].
    pub precise: bool,
    /// For an output: so stored where it outlives its frame, as what is read `@prev` and what the graph gives do.
    pub precise_if_kept: bool,
    /// For an output: its values are meant to be others than those that come in, even of a constant image.
    pub alters: bool,
    /// What it is, in one line.
    pub about: &'static str,
}

/// What a port carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortSignal {
    /// This signal.
    Is(Signal),
    /// The pass's one free signal of floating point texels: all such ports of a pass carry the same.
    Any,
}

/// How large a port's texture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Resolution {
    /// One texel per pixel.
    Full,
    /// One texel per n x n pixels, rounded up; all grid ports of a pass share n, and n = 1 is full.
    Grid,
    /// The pass's one free resolution: all such ports of a pass share it.
    Any,
}

/// What an input that reads the previous frame gets when there is none (first frame, resize, cut).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirstFrame {
    /// A texture of this value.
    Clear([f64; 4]),
    /// Nothing: the pass sees the input as not wired.
    Skip,
    /// This frame's texture of another input of the same pass.
    Copy(&'static str),
}

impl Port {
    /// A required port at full resolution.
    pub const fn new(name: &'static str, signal: Signal) -> Self {
        Self {
            name,
            signal: PortSignal::Is(signal),
            resolution: Resolution::Full,
            optional: false,
            source: None,
            first: None,
            precise: false,
            precise_if_kept: false,
            alters: false,
            about: "",
        }
    }

    /// A required port of any signal at any resolution.
    pub const fn any(name: &'static str) -> Self {
        let mut port = Self::new(name, crate::signal::RADIANCE);
        port.signal = PortSignal::Any;
        port.resolution = Resolution::Any;
        port
    }

    /// At one texel per n x n pixels.
    pub const fn grid(mut self) -> Self {
        self.resolution = Resolution::Grid;
        self
    }

    /// At full resolution (what [`Port::new`] gives; for [`Port::any`]).
    pub const fn full(mut self) -> Self {
        self.resolution = Resolution::Full;
        self
    }

    /// At the pass's free resolution.
    pub const fn any_resolution(mut self) -> Self {
        self.resolution = Resolution::Any;
        self
    }

    /// See [`Port::optional`].
    pub const fn optional(mut self) -> Self {
        self.optional = true;
        self
    }

    /// Looks for a port of this name when it is not wired by name.
    pub const fn source(mut self, name: &'static str) -> Self {
        self.source = Some(name);
        self
    }

    /// What a read of the previous frame gets when there is none.
    pub const fn first(mut self, rule: FirstFrame) -> Self {
        self.first = Some(rule);
        self
    }

    /// Stored in [`Signal::precise_format`].
    pub const fn precise(mut self) -> Self {
        self.precise = true;
        self
    }

    /// See [`Port::alters`].
    pub const fn alters(mut self) -> Self {
        self.alters = true;
        self
    }

    /// See [`Port::precise_if_kept`].
    pub const fn precise_if_kept(mut self) -> Self {
        self.precise_if_kept = true;
        self
    }

    /// What it is, in one line.
    pub const fn about(mut self, text: &'static str) -> Self {
        self.about = text;
        self
    }

    /// The port name that an input looks for when it is not wired by name.
    pub const fn source_name(&self) -> &'static str {
        match self.source {
            Some(name) => name,
            None => self.name,
        }
    }

    /// The texture format of this port when a free signal is bound to `free`; `None` for a free
    /// port while `free` is.
    pub fn format(&self, free: Option<Signal>) -> Option<wgpu::TextureFormat> {
        let signal = match self.signal {
            PortSignal::Is(signal) => signal,
            PortSignal::Any => free?,
        };
        Some(if self.precise {
            signal.precise_format()
        } else {
            signal.format()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal;

    #[test]
    fn the_format_of_a_free_port_is_that_of_the_bound_signal() {
        let port = Port::any("value").precise();
        assert_eq!(port.format(None), None);
        assert_eq!(
            port.format(Some(signal::IRRADIANCE)),
            Some(wgpu::TextureFormat::Rgba32Float)
        );
    }

    #[test]
    fn an_input_looks_for_its_own_name_unless_told() {
        assert_eq!(Port::new("normal", signal::NORMAL).source_name(), "normal");
        let grid = Port::new("grid_normal", signal::NORMAL).source("normal");
        assert_eq!(grid.source_name(), "normal");
    }
}
