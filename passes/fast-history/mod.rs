#![doc = include_str!("README.md")]

use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, signal};

scumble::params! {
    /// What `fast-history` can be told.
    pub struct FastHistoryParams {
        /// Half the width of the neighbourhood: 2 is 5 x 5.
        pub radius: u32 = 2, in 1..=8, unit "texels";
        /// How many standard deviations the slow history may be from the mean of the fast one.
        pub sigmas: f32 = 2.0, in 0.0..=100.0;
    }
}

/// The pass; see the module.
pub struct FastHistory {
    kernel: framegraph::ComputeKernel,
}

impl Pass for FastHistory {
    type Params = FastHistoryParams;
    const NAME: &'static str = "fast-history";
    const ABOUT: &'static str =
        "Keeps a long history near a short one, so that it follows changes of light";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value").about("accumulated over many frames"),
            Port::any("fast").about("the same, accumulated over few"),
            Port::new("view_z", signal::VIEW_Z)
                .any_resolution()
                .about("where there is a surface"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").about("near the fast one")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &FastHistoryParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel(
            "fast-history/fast_history.wgsl",
            include_str!("fast_history.wgsl"),
            "main",
        )?;
        Ok(Self { kernel })
    }

    fn record(
        &mut self,
        _p: &FastHistoryParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        frame.dispatch("fast history", &self.kernel).over(size)
    }
}
