#![doc = include_str!("README.md")]

use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, signal};

pub use crate::edges::DepthForm;

scumble::params! {
    /// What `history-fix` can be told.
    pub struct HistoryFixParams {
        /// Texels of at most this age are filtered.
        pub young: f32 = 3.0, in 0.0..=65536.0, unit "samples";
        /// Distance of the taps at age 0; it shrinks by 1 + age.
        pub stride: f32 = 14.0, in 1.0..=64.0, unit "texels";
        /// Exponent of the cosine between normals.
        pub sigma_normal: f32 = 8.0, in 0.0..=1024.0;
        /// Scale of the depth weight.
        pub sigma_depth: f32 = 1.0, in 0.0..=1000.0;
        /// Depth that always counts as equal, as a part of the distance.
        pub depth_epsilon: f32 = 0.01, in 0.0..=1.0;
        /// Which depth weight; over so far only what a plane leaves unexplained tells surfaces apart.
        pub depth_form: DepthForm = DepthForm::Residual;
    }
}

/// The pass; see the module.
pub struct HistoryFix {
    kernel: framegraph::ComputeKernel,
}

impl Pass for HistoryFix {
    type Params = HistoryFixParams;
    const NAME: &'static str = "history-fix";
    const ABOUT: &'static str =
        "Gives texels whose history has just begun the mean of a wide, sparse neighbourhood";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        let guide = |name, signal| Port::new(name, signal).any_resolution();
        vec![
            Port::any("value").about("accumulated"),
            guide("age", signal::AGE).about("samples accumulated"),
            guide("view_z", signal::VIEW_Z).about("guide"),
            guide("normal", signal::NORMAL).about("guide"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").about("filtered where it is young")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &HistoryFixParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel(
            "history-fix/history_fix.wgsl",
            include_str!("history_fix.wgsl"),
            "main",
        )?;
        Ok(Self { kernel })
    }

    fn record(
        &mut self,
        _p: &HistoryFixParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        frame.dispatch("history fix", &self.kernel).over(size)
    }
}
