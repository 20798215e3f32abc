#![doc = include_str!("README.md")]

use scumble::{BuildContext, BuildError, NoParams, Pass, PassFrame, Port, RecordError, signal};

/// The pass; see the module.
pub struct Recombine {
    kernel: framegraph::ComputeKernel,
}

impl Pass for Recombine {
    type Params = NoParams;
    const NAME: &'static str = "recombine";
    const ABOUT: &'static str = "Adds emission, direct light, albedo / pi times indirect irradiance, and other indirect light";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::new("emission", signal::EMISSION)
                .optional()
                .about("L_e of the visible surface, or the sky"),
            Port::new("direct", signal::RADIANCE)
                .optional()
                .about("L_dir, light straight from emitters"),
            Port::new("irradiance", signal::IRRADIANCE)
                .optional()
                .about("E_ind, indirect irradiance"),
            Port::new("specular", signal::SPECULAR)
                .optional()
                .about("L_spec,ind, indirect light by the specular lobe"),
            Port::new("indirect", signal::RADIANCE)
                .optional()
                .about("indirect light that was not parted, albedo and all"),
            Port::new("albedo", signal::ALBEDO).about("k_d"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::new("radiance", signal::RADIANCE).about("L, towards the eye")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel(
            "recombine/recombine.wgsl",
            include_str!("recombine.wgsl"),
            "main",
        )?;
        Ok(Self { kernel })
    }

    fn record(&mut self, _p: &NoParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.full_size();
        frame.dispatch("recombine", &self.kernel).over(size)
    }
}
