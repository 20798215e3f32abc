#![doc = include_str!("README.md")]

use framegraph::ComputeKernel;
use scumble::{BuildContext, BuildError, Pass, PassFrame, Port, RecordError, signal};

scumble::choice! {
    /// Which way.
    pub enum Operation {
        /// From outgoing light to what arrives.
        #[default]
        Divide,
        /// And back.
        Multiply,
    }
}

scumble::params! {
    /// What `specular-modulate` can be told.
    pub struct SpecularModulateParams {
        /// Which way.
        pub operation: Operation = Operation::Divide;
        /// What is reflected counts as no darker than this; at 1 nothing is divided out for it.
        pub least_albedo: f32 = 0.05, in 0.01..=1.0;
    }
}

/// The pass; see the module.
pub struct SpecularModulate {
    kernel: ComputeKernel,
}

impl Pass for SpecularModulate {
    type Params = SpecularModulateParams;
    const NAME: &'static str = "specular-modulate";
    const ABOUT: &'static str =
        "Divides specular light by the share that its surface reflects, or multiplies it again";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value")
                .full()
                .about("light of the specular lobe, with or without the share"),
            Port::new("position", signal::POSITION).about("of the surface"),
            Port::new("normal", signal::NORMAL).about("of the surface"),
            Port::new("material", signal::MATERIAL).about("F0 and perceptual roughness"),
            Port::new("albedo", signal::ALBEDO).about("the fourth channel is F90"),
            Port::new("reflected_albedo", signal::ALBEDO)
                .optional()
                .about("of what a mirror would show"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::any("value")
                .full()
                .precise()
                .about("the light without or with the share"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &SpecularModulateParams) -> Result<Self, BuildError> {
        let wgsl = include_str!("specular_modulate.wgsl");
        Ok(Self {
            kernel: ctx.kernel("specular-modulate/specular_modulate.wgsl", wgsl, "main")?,
        })
    }

    fn record(
        &mut self,
        _p: &SpecularModulateParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.full_size();
        frame.dispatch("specular modulate", &self.kernel).over(size)
    }
}
