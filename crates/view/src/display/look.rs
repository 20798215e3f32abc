//! How a signal asks to be shown.

use scumble::{PortSignal, Resolved, Signal, Source, signal};
use wgpu::TextureFormat as F;

/// How a signal asks to be shown; the numbers are those of `display.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Linear light: exposed and sRGB-encoded.
    Light = 0,
    /// sRGB-encoded already.
    Encoded = 1,
    /// A number, by its range.
    Scalar = 2,
    /// A distance, by its range; sky and holes are black.
    Depth = 3,
    /// Numbers of either sign around grey.
    Signed = 4,
    /// A packed unit vector.
    Normal = 5,
    /// Whole numbers, by their range.
    Integers = 6,
    /// An integer that names something: each has a colour of its own.
    Identity = 7,
    /// White where it is set.
    Mask = 8,
}

impl Look {
    /// What a signal asks for.
    ///
    /// ```
    /// use scumble::signal;
    /// use scumble_view::display::Look;
    /// assert_eq!(Look::of(signal::SURFACE_ID), Look::Identity);
    /// assert_eq!(Look::of(signal::MOTION), Look::Signed);
    /// ```
    pub fn of(signal: Signal) -> Look {
        let is = |all: &[Signal]| all.contains(&signal);
        if is(&[signal::DISPLAY]) {
            return Look::Encoded;
        }
        if is(&[signal::NORMAL, signal::GEO_NORMAL]) {
            return Look::Normal;
        }
        if is(&[signal::POSITION, signal::DISPLACEMENT]) {
            return Look::Signed;
        }
        if is(&[signal::VIEW_Z]) {
            return Look::Depth;
        }
        if is(&[signal::MASK]) {
            return Look::Mask;
        }
        match signal.format() {
            F::R32Uint => Look::Identity,
            F::Rg32Uint | F::Rgba32Uint => Look::Integers,
            F::R32Float | F::R16Float => Look::Scalar,
            F::Rg32Float | F::Rg16Float => Look::Signed,
            _ => Look::Light,
        }
    }

    /// Whether it is light, which is exposed.
    pub fn is_light(self) -> bool {
        matches!(self, Look::Light | Look::Encoded)
    }

    /// Whether a texel holds integers.
    pub fn is_integer(self) -> bool {
        matches!(
            self,
            Look::Normal | Look::Integers | Look::Identity | Look::Mask
        )
    }

    /// Whether a range is asked for, in false colour or not.
    pub fn has_range(self, false_colour: bool) -> bool {
        match self {
            Look::Mask => false,
            Look::Light | Look::Encoded | Look::Normal | Look::Identity => false_colour,
            Look::Scalar | Look::Depth | Look::Signed | Look::Integers => true,
        }
    }
}

/// Components of a texel of a format that a signal has.
pub fn components(format: wgpu::TextureFormat) -> u32 {
    match format {
        F::R16Float | F::R32Float | F::R32Uint => 1,
        F::Rg16Float | F::Rg32Float | F::Rg32Uint => 2,
        _ => 4,
    }
}

/// What `pass.port`, or an output of the graph by its name, carries.
pub fn signal_of(graph: &Resolved, name: &str) -> Option<Signal> {
    let (pass, port) = match graph.outputs.iter().find(|(output, _)| output == name) {
        Some((_, Source::GraphInput { input, .. })) => return Some(graph.inputs[*input].signal),
        Some((_, Source::Port { pass, port, .. })) => {
            let outputs = &graph.passes[*pass].ty.outputs;
            (*pass, outputs.iter().position(|p| p.name == port)?)
        }
        None => graph.find_output(name).ok()?,
    };
    let pass = &graph.passes[pass];
    match pass.ty.outputs[port].signal {
        PortSignal::Is(signal) => Some(signal),
        PortSignal::Any => pass.signal,
    }
}
