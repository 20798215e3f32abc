#![doc = include_str!("README.md")]

use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, signal};

scumble::params! {
    /// What `firefly-clamp` can be told.
    pub struct FireflyClampParams {
        /// Half the width of the neighbourhood: 1 is 3 x 3.
        pub radius: u32 = 1, in 1..=8, unit "texels";
        /// Whether texels darker than all around become as bright as the darkest of them.
        pub lift: bool = true;
    }
}

/// The pass; see the module.
pub struct FireflyClamp {
    kernel: framegraph::ComputeKernel,
}

impl Pass for FireflyClamp {
    type Params = FireflyClampParams;
    const NAME: &'static str = "firefly-clamp";
    const ABOUT: &'static str = "Replaces texels brighter or darker than all their neighbours by the brightest or darkest of these";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        let guide = |name, signal| Port::new(name, signal).any_resolution();
        vec![
            Port::any("value").about("what may hold fireflies"),
            guide("samples", signal::AGE)
                .optional()
                .about("samples in each texel, 0 for none; 1 without it"),
            guide("view_z", signal::VIEW_Z).about("where there is a surface"),
            guide("surface_id", signal::SURFACE_ID)
                .optional()
                .about("only texels of the same surface are neighbours"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").about("without fireflies")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &FireflyClampParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel(
            "firefly-clamp/firefly_clamp.wgsl",
            include_str!("firefly_clamp.wgsl"),
            "main",
        )?;
        Ok(Self { kernel })
    }

    fn record(
        &mut self,
        _p: &FireflyClampParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        frame.dispatch("firefly clamp", &self.kernel).over(size)
    }
}
