#![doc = include_str!("README.md")]

use framegraph::ComputeKernel;
use scumble::{BuildContext, BuildError, Pass, PassFrame, Port, RecordError, signal};

scumble::choice! {
    /// Which way.
    pub enum Operation {
        /// From outgoing light to what is left without emission and albedo.
        #[default]
        Divide,
        /// And back.
        Multiply,
    }
}

scumble::params! {
    /// What `albedo-modulate` can be told.
    pub struct AlbedoModulateParams {
        /// Which way.
        pub operation: Operation = Operation::Divide;
        /// Albedo below this counts as this, in each channel.
        pub least: f32 = 0.05, in 0.0001..=1.0;
    }
}

/// The pass; see the module.
pub struct AlbedoModulate {
    kernel: ComputeKernel,
}

impl Pass for AlbedoModulate {
    type Params = AlbedoModulateParams;
    const NAME: &'static str = "albedo-modulate";
    const ABOUT: &'static str =
        "Takes emission and albedo of the surface out of its light, or brings them back";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value")
                .about("light, with or without emission and albedo; alpha 0 is no value"),
            Port::new("albedo", signal::ALBEDO)
                .any_resolution()
                .optional()
                .about("of the surface; 1 without it"),
            Port::new("emission", signal::EMISSION)
                .any_resolution()
                .optional()
                .about("what the surface emits, taken off before and added after; 0 without it"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::any("value")
                .precise()
                .about("the light without or with them"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &AlbedoModulateParams) -> Result<Self, BuildError> {
        let wgsl = include_str!("albedo_modulate.wgsl");
        Ok(Self {
            kernel: ctx.kernel("albedo-modulate/albedo_modulate.wgsl", wgsl, "main")?,
        })
    }

    fn record(
        &mut self,
        _p: &AlbedoModulateParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        frame.dispatch("albedo modulate", &self.kernel).over(size)
    }
}
