#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, First};
use scumble::{BuildContext, BuildError, Pass, PassFrame, Port, RecordError, signal};
use wgpu::TextureFormat::{Rg32Float, Rgba32Float};

scumble::params! {
    /// What `guide-variance` can be told.
    pub struct GuideVarianceParams {
        /// Least weight of a new sample; 0 gives the variance of all.
        pub blend: f32 = 0.05, in 0.0..=1.0;
        /// How far beyond the distances around a pixel its mean distance may lie, as a part of itself.
        pub depth_tolerance: f32 = 0.05, in 0.0..=1.0;
    }
}

/// The pass; see the module.
pub struct GuideVariance {
    kernel: ComputeKernel,
}

impl Pass for GuideVariance {
    type Params = GuideVarianceParams;
    const NAME: &'static str = "guide-variance";
    const ABOUT: &'static str =
        "Variance of normal, depth and albedo within a pixel, over jittered frames";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::new("view_z", signal::VIEW_Z).about("of this frame's sample in each pixel"),
            Port::new("normal", signal::NORMAL).about("of this frame's sample in each pixel"),
            Port::new("motion", signal::MOTION).about("where the samples before are"),
            Port::new("albedo", signal::ALBEDO)
                .optional()
                .about("of this frame's sample in each pixel"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::new("guide_variance", signal::GUIDE_VARIANCE)
                .about("0 for a pixel with one sample; for `atrous`"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &GuideVarianceParams) -> Result<Self, BuildError> {
        Ok(Self {
            kernel: ctx.kernel(
                "guide-variance/guide_variance.wgsl",
                include_str!("guide_variance.wgsl"),
                "main",
            )?,
        })
    }

    fn record(
        &mut self,
        _p: &GuideVarianceParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.full_size();
        let mut state = |name, format| frame.history(name, format, size, First::Clear([0.0; 4]));
        let histories = [
            ("normal_mean", state("normal_mean", Rgba32Float)),
            ("means", state("means", Rgba32Float)),
            ("rest", state("rest", Rg32Float)),
        ];
        let mut dispatch = frame.dispatch("guide variance", &self.kernel);
        for (name, history) in histories {
            if let Some(previous) = history.previous.first().copied().flatten() {
                dispatch = dispatch.texture(&format!("previous_{name}"), previous);
            }
            (dispatch, _) = dispatch.write(&format!("next_{name}"), history.current);
        }
        dispatch.over(size)
    }
}
