#![doc = include_str!("README.md")]

use framegraph::ComputeKernel;
use scumble::{BuildContext, BuildError, Pass, PassFrame, Port, RecordError, signal};

pub use crate::edges::DepthForm;

scumble::choice! {
    /// Of what the variance is.
    pub enum Of {
        /// Of a single sample, as both papers take it.
        #[default]
        Sample,
        /// Of the accumulated mean: smaller by the sum of the squared weights.
        Mean,
    }
}

scumble::params! {
    /// What `variance` can be told.
    pub struct VarianceParams {
        /// Of what the variance is.
        pub of: Of = Of::Sample;
        /// Below this age the estimate is spatial.
        pub spatial_age: f32 = 4.0, in 0.0..=65536.0, unit "samples";
        /// Half the width of the spatial window: 3 is 7 x 7.
        pub radius: u32 = 3, in 1..=8, unit "texels";
        /// Standard deviation of the window's Gaussian.
        pub sigma: f32 = 1.5, in 0.01..=1000.0, unit "texels";
        /// Exponent of the cosine between normals.
        pub sigma_normal: f32 = 64.0, in 0.0..=1024.0;
        /// Scale of the depth weight.
        pub sigma_depth: f32 = 1.0, in 0.0..=1000.0;
        /// Depth that always counts as equal, as a part of the distance.
        pub depth_epsilon: f32 = 0.005, in 0.0..=1.0;
        /// Which depth weight.
        pub depth_form: DepthForm = DepthForm::Slope;
        /// Whether a spatial estimate grows by spatial_age / age, so that young texels are filtered more.
        pub boost: bool = false;
        /// Whether the result is blurred by 3 x 3.
        pub prefilter: bool = true;
    }
}

/// The pass; see the module.
pub struct Variance {
    variance: ComputeKernel,
    prefilter: ComputeKernel,
}

impl Pass for Variance {
    type Params = VarianceParams;
    const NAME: &'static str = "variance";
    const ABOUT: &'static str =
        "Variance of luminance from accumulated moments, from the neighbourhood while they are few";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        let port = |name, signal| Port::new(name, signal).any_resolution();
        vec![
            port("moments", signal::MOMENTS).about("accumulated, or of this frame"),
            port("age", signal::AGE)
                .optional()
                .about("samples in the moments; 1 without it"),
            port("weights", signal::WEIGHTS)
                .optional()
                .about("sums of squared weights; those of one sample without it"),
            port("view_z", signal::VIEW_Z).about("guide"),
            port("normal", signal::NORMAL).about("guide"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::new("variance", signal::VARIANCE)
                .any_resolution()
                .about("of luminance"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &VarianceParams) -> Result<Self, BuildError> {
        let kernel = |file, wgsl| ctx.kernel(file, wgsl, "main");
        Ok(Self {
            variance: kernel("variance/variance.wgsl", include_str!("variance.wgsl"))?,
            prefilter: kernel("variance/prefilter.wgsl", include_str!("prefilter.wgsl"))?,
        })
    }

    fn record(
        &mut self,
        p: &VarianceParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("variance");
        // `of` is a word of WGSL.
        let of_mean = p.of == Of::Mean;
        if !p.prefilter {
            let dispatch = frame.dispatch("variance", &self.variance);
            return dispatch.set("of_mean", of_mean).over(size);
        }
        let raw = frame.transient("raw variance", wgpu::TextureFormat::R32Float, size);
        let (dispatch, raw) = frame
            .dispatch("variance", &self.variance)
            .set("of_mean", of_mean)
            .write("out_variance", raw);
        dispatch.over(size)?;
        frame
            .dispatch("prefilter", &self.prefilter)
            .texture("raw_variance", raw)
            .over(size)
    }
}
