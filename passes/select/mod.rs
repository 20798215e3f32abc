#![doc = include_str!("README.md")]

use scumble::{
    BuildContext, BuildError, Bypass, NoParams, Pass, PassFrame, Port, RecordError, signal,
};

/// The pass; see the module.
pub struct Select {
    kernel: framegraph::ComputeKernel,
}

impl Pass for Select {
    type Params = NoParams;
    const NAME: &'static str = "select";
    const ABOUT: &'static str = "Chooses between two estimates of one signal by a mask";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value").full().about("taken where the mask is 0"),
            Port::any("other")
                .full()
                .about("taken elsewhere, where it has a sample"),
            Port::new("mask", signal::MASK).about("which is taken"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").full().about("one of both")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel("select/select.wgsl", include_str!("select.wgsl"), "main")?;
        Ok(Self { kernel })
    }

    fn record(&mut self, _p: &NoParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.full_size();
        frame.dispatch("select", &self.kernel).over(size)
    }
}
