//! What a pass is.

use std::fmt;

use crate::context::{BuildContext, BuildError};
use crate::params::{ErasedParams, Params};
use crate::pass_frame::{PassFrame, RecordError};
use crate::port::Port;

/// One stage of a pipeline: ports, parameters, and how to declare its work of a frame.
///
/// `README.md` of the crate shows a whole filter.
pub trait Pass: Sized + Send + 'static {
    /// What it can be told; [`NoParams`](crate::NoParams) for nothing.
    type Params: Params;
    /// The name that graph files use.
    const NAME: &'static str;
    /// What it is for, in one line.
    const ABOUT: &'static str;
    /// What it computes: equation, source, limits. `include_str!("README.md")`.
    const README: &'static str;

    /// What it reads.
    fn inputs() -> Vec<Port>;
    /// What it writes.
    fn outputs() -> Vec<Port>;
    /// For each output what stands in for it when the pass is bypassed. Bypassing a pass with an
    /// output that has none, and that is read, is an error.
    fn bypass() -> Vec<Bypass> {
        Vec::new()
    }
    /// What it needs from the host and the device.
    fn needs(_params: &Self::Params) -> Needs {
        Needs::default()
    }
    /// For a pass that makes a grid: pixels per texel and axis of its grid outputs.
    fn grid(_params: &Self::Params) -> Option<u32> {
        None
    }
    /// Makes kernels and whatever lives as long as the pass. Called again when a structural
    /// parameter changed.
    ///
    /// # Errors
    /// A shader is wrong, or the host lends not what the pass needs.
    fn build(ctx: &BuildContext<'_>, params: &Self::Params) -> Result<Self, BuildError>;
    /// Declares the work of one frame.
    ///
    /// # Errors
    /// What the frame lacks; mistakes in the declaration are collected by the frame graph.
    fn record(
        &mut self,
        params: &Self::Params,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError>;
}

/// What stands in for an output of a bypassed pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bypass {
    /// The output.
    pub output: &'static str,
    /// The input it becomes.
    pub input: &'static str,
    /// How.
    pub how: BypassKind,
}

/// How an input becomes an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BypassKind {
    /// It is the same texture.
    Alias,
    /// It is brought to the output's resolution.
    Resample(Filter),
}

/// How texels between texels are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Between the nearest four, by distance.
    Linear,
}

impl Bypass {
    /// `output` is the texture of `input`: signal and resolution match.
    pub const fn alias(output: &'static str, input: &'static str) -> Bypass {
        Bypass {
            output,
            input,
            how: BypassKind::Alias,
        }
    }

    /// `output` is `input` at another resolution.
    pub const fn resample(output: &'static str, input: &'static str, filter: Filter) -> Bypass {
        Bypass {
            output,
            input,
            how: BypassKind::Resample(filter),
        }
    }
}

/// What a pass needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Needs {
    /// Names of what the host must lend, such as `Scene`.
    pub host: Vec<&'static str>,
    /// Features of the device.
    pub features: wgpu::Features,
    /// Limits the device must reach.
    pub limits: wgpu::Limits,
}

impl Default for Needs {
    /// Nothing from the host, no feature, and of the limits those that a small filter needs: 4
    /// storage textures, 8 storage buffers and 32 bytes of colour attachments.
    fn default() -> Needs {
        let limits = wgpu::Limits {
            max_storage_buffers_per_shader_stage: 8,
            ..wgpu::Limits::downlevel_defaults()
        };
        Needs {
            host: Vec::new(),
            features: wgpu::Features::empty(),
            limits,
        }
    }
}

impl Needs {
    /// The limits that a device with no more than `allowed` does not reach, by name.
    pub fn beyond(&self, allowed: &wgpu::Limits) -> Vec<(&'static str, u64)> {
        let mut beyond = Vec::new();
        let add = |name, needed, _| beyond.push((name, needed));
        self.limits.check_limits_with_fail_fn(allowed, false, add);
        beyond
    }

    /// The same, and `name` of the host.
    #[must_use]
    pub fn with_host(mut self, name: &'static str) -> Needs {
        self.host.push(name);
        self
    }
}

/// On which side of the line between direct and indirect light sky light stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SkySide {
    /// Sky light that reaches the visible point is direct light.
    #[default]
    Direct,
    /// Sky light that reaches the visible point is indirect light.
    Indirect,
}

impl fmt::Display for SkySide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// A built pass without its type.
pub trait AnyPass: Send {
    /// See [`Pass::record`].
    ///
    /// # Errors
    /// Those of the pass; parameters of another type.
    fn record(
        &mut self,
        params: &ErasedParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError>;
}

impl<P: Pass> AnyPass for P {
    fn record(
        &mut self,
        params: &ErasedParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        match params.downcast_ref::<P::Params>() {
            Some(params) => Pass::record(self, params, frame),
            None => Err(RecordError::Failed(wrong_params(P::NAME))),
        }
    }
}

/// [`Pass::build`] without the type.
///
/// # Errors
/// Those of the pass; parameters of another type.
pub fn build_any<P: Pass>(
    ctx: &BuildContext<'_>,
    params: &ErasedParams,
) -> Result<Box<dyn AnyPass>, BuildError> {
    match params.downcast_ref::<P::Params>() {
        Some(params) => Ok(Box::new(P::build(ctx, params)?)),
        None => Err(BuildError::Failed(wrong_params(P::NAME))),
    }
}

fn wrong_params(pass: &str) -> String {
    format!("the parameters are not those of `{pass}`")
}
