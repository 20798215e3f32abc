#![doc = include_str!("README.md")]

use framegraph::ComputeKernel;
use scumble::{BuildContext, BuildError, FirstFrame, Pass, PassFrame, Port, RecordError, signal};
use wgpu::TextureFormat::{Rg32Float, Rgba16Float, Rgba32Float};

pub use crate::accumulate::DepthTest;
use crate::accumulate::{pixel_inputs, reprojection_inputs};
pub use crate::edges::DepthForm;

scumble::params! {
    /// What `temporal-gradient` can be told.
    pub struct TemporalGradientParams {
        /// Half the width of the window that both estimates are filtered over: 3 is 7 x 7.
        pub radius: u32 = 3, in 1..=8, unit "texels";
        /// Standard deviation of the window's Gaussian.
        pub sigma: f32 = 2.0, in 0.01..=1000.0, unit "texels";
        /// Half the width of the neighbourhood whose filtered histories make the range.
        pub range: u32 = 1, in 0..=8, unit "texels";
        /// How many standard deviations outside the range are still noise.
        pub noise_sigmas: f32 = 1.0, in 0.0..=1000.0;
        /// How many standard deviations outside the range drop the history.
        pub change_sigmas: f32 = 3.0, in 0.0..=1000.0;
        /// Part of the luminance that counts as a standard deviation more.
        pub tolerance: f32 = 0.01, in 0.0..=1.0;
        /// Half the width of the window of gradient samples, where there are any: 2 is 5 x 5 strata of 3 x 3 texels.
        pub strata: u32 = 2, in 1..=8, unit "strata";
        /// Exponent of the cosine between normals; low, so that small and curved things have neighbours to tell their noise by.
        pub sigma_normal: f32 = 8.0, in 0.0..=1024.0;
        /// Scale of the depth weight.
        pub sigma_depth: f32 = 1.0, in 0.0..=1000.0;
        /// Depth that always counts as equal, as a part of the distance.
        pub depth_epsilon: f32 = 0.02, in 0.0..=1.0;
        /// Which depth weight.
        pub depth_form: DepthForm = DepthForm::Slope;
        /// How a texel of the previous frame is tested by depth, as in `accumulate`.
        pub depth_test: DepthTest = DepthTest::Plane;
        /// Largest distance, as a part of the distance from the camera, as in `accumulate`.
        pub depth_tolerance: f32 = 0.01, in 0.0..=1.0;
        /// Least cosine between the normals, as in `accumulate`.
        pub min_cosine: f32 = 0.9, in -1.0..=1.0;
    }
}

/// The pass; see the module.
pub struct TemporalGradient {
    reproject: ComputeKernel,
    past: ComputeKernel,
    estimate: ComputeKernel,
    confidence: ComputeKernel,
    differences: ComputeKernel,
    samples: ComputeKernel,
}

impl Pass for TemporalGradient {
    type Params = TemporalGradientParams;
    const NAME: &'static str = "temporal-gradient";
    const ABOUT: &'static str =
        "How far a history may be trusted, by how far new samples lie outside of it";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        let guide = |name, signal| Port::new(name, signal).any_resolution();
        let mut inputs = vec![
            Port::any("value").about("this frame's estimate"),
            Port::any("history")
                .first(FirstFrame::Skip)
                .about("what would be continued, of the previous frame"),
            guide("samples", signal::AGE)
                .optional()
                .about("samples in each texel's estimate, 0 for none; 1 without it"),
            guide("source", signal::PIXEL)
                .optional()
                .about("of gradient-samples: whose random numbers each texel has; its samples then tell alone"),
            Port::any("previous_value")
                .optional()
                .first(FirstFrame::Skip)
                .about("the estimate of the previous frame, for source"),
            guide("previous_variance", signal::VARIANCE)
                .optional()
                .first(FirstFrame::Skip)
                .about("of a frame's estimate, as it was in the previous frame"),
        ];
        inputs.extend(reprojection_inputs());
        inputs.extend(pixel_inputs());
        inputs
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::new("confidence", signal::CONFIDENCE)
                .any_resolution()
                .about("1 where the history goes on, 0 where it is of another light"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &TemporalGradientParams) -> Result<Self, BuildError> {
        let kernel = |file, wgsl| ctx.kernel(file, wgsl, "main");
        Ok(Self {
            reproject: kernel(
                "accumulate/reproject.wgsl",
                include_str!("../accumulate/reproject.wgsl"),
            )?,
            past: kernel("temporal-gradient/past.wgsl", include_str!("past.wgsl"))?,
            estimate: kernel(
                "temporal-gradient/estimate.wgsl",
                include_str!("estimate.wgsl"),
            )?,
            confidence: kernel(
                "temporal-gradient/confidence.wgsl",
                include_str!("confidence.wgsl"),
            )?,
            differences: kernel(
                "temporal-gradient/differences.wgsl",
                include_str!("differences.wgsl"),
            )?,
            samples: kernel(
                "temporal-gradient/samples.wgsl",
                include_str!("samples.wgsl"),
            )?,
        })
    }

    fn record(
        &mut self,
        _p: &TemporalGradientParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("confidence");
        if frame.input("source").is_some() && frame.input("previous_value").is_some() {
            return self.by_samples(frame, size);
        }
        let footprint = frame.transient("footprint", Rgba16Float, size);
        let (dispatch, footprint) = frame
            .dispatch("reproject", &self.reproject)
            // Bilinear; a texel that only the search finds knows too little of where it was to accuse its history.
            .set("sampling", 0u32)
            .set("search", false)
            .write("footprint", footprint);
        dispatch.over(size)?;

        let past = frame.transient("past", Rg32Float, size);
        let (dispatch, past) = frame
            .dispatch("past", &self.past)
            .texture("footprint", footprint)
            .write("past", past);
        dispatch.over(size)?;

        let estimate = frame.transient("estimate", Rgba32Float, size);
        let (dispatch, estimate) = frame
            .dispatch("estimate", &self.estimate)
            .texture("past", past)
            .write("estimate", estimate);
        dispatch.over(size)?;

        frame
            .dispatch("confidence", &self.confidence)
            .texture("estimate", estimate)
            .over(size)
    }
}

impl TemporalGradient {
    /// From texels whose random numbers are those of the previous frame.
    fn by_samples(&self, frame: &mut PassFrame<'_, '_>, size: [u32; 2]) -> Result<(), RecordError> {
        let strata = size.map(|n| n.div_ceil(3));
        let differences = frame.transient("differences", Rgba32Float, strata);
        let (dispatch, differences) = frame
            .dispatch("differences", &self.differences)
            .write("differences", differences);
        dispatch.over(strata)?;
        frame
            .dispatch("samples", &self.samples)
            .texture("differences", differences)
            .over(size)
    }
}
