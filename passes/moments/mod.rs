#![doc = include_str!("README.md")]

use framegraph::ComputeKernel;
use scumble::{BuildContext, BuildError, NoParams, Pass, PassFrame, Port, RecordError, signal};

/// The pass; see the module.
pub struct Moments {
    kernel: ComputeKernel,
}

impl Pass for Moments {
    type Params = NoParams;
    const NAME: &'static str = "moments";
    const ABOUT: &'static str =
        "Luminance and its square of one image, for a variance without history";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![Port::any("value").about("an estimate; a texel of alpha 0 has no value")]
    }

    fn outputs() -> Vec<Port> {
        let port = |name, signal| Port::new(name, signal).any_resolution().optional();
        vec![
            port("moments", signal::MOMENTS).about("of the value's luminance, as one sample"),
            port("age", signal::AGE).about("1 where there is a value, else 0"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel("moments/moments.wgsl", include_str!("moments.wgsl"), "main")?;
        Ok(Self { kernel })
    }

    fn record(&mut self, _p: &NoParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        frame.dispatch("moments", &self.kernel).over(size)
    }
}
