#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, Texture};
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

scumble::choice! {
    /// From which neighbours the variance of a young texel is taken.
    pub enum Spatial {
        /// All of one window.
        #[default]
        Window,
        /// The narrowest of 3^2, 9^2, 27^2, ... texels that holds enough samples.
        Hierarchical,
    }
}

scumble::params! {
    /// What `variance` can be told.
    pub struct VarianceParams {
        /// Of what the variance is.
        pub of: Of = Of::Sample;
        /// Below this age the estimate is spatial.
        pub spatial_age: f32 = 4.0, in 0.0..=65536.0, unit "samples";
        /// From which neighbours the spatial estimate is.
        pub spatial: Spatial = Spatial::Window;
        /// Half the width of the spatial window: 3 is 7 x 7.
        pub radius: u32 = 3, in 1..=8, unit "texels";
        /// Standard deviation of the window's Gaussian.
        pub sigma: f32 = 1.5, in 0.01..=1000.0, unit "texels";
        /// How wide the hierarchy may grow: 3^levels texels.
        pub levels: u32 = 3, in 1..=6;
        /// The hierarchy stops where a window is worth so many samples, 1 / S2.
        pub least_samples: f32 = 8.0, in 1.0..=65536.0, unit "samples";
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
    /// Of luminance.
    luminance: Kernels,
    /// Of each channel.
    channels: Kernels,
    begin: ComputeKernel,
    widen: ComputeKernel,
}

struct Kernels {
    variance: ComputeKernel,
    prefilter: ComputeKernel,
}

impl Variance {
    /// The means, the squares and the weights of the windows that the hierarchy settles on.
    fn hierarchy(
        &self,
        p: &VarianceParams,
        by_channel: bool,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<[Texture; 2], RecordError> {
        let size = frame.size_of("moments");
        let mut level: Option<[Texture; 2]> = None;
        for step in 0..=p.levels {
            let [means, squares] = ["level means", "level squares"]
                .map(|name| frame.transient(name, wgpu::TextureFormat::Rgba32Float, size));
            let (label, kernel) = match level {
                None => ("texels", &self.begin),
                Some(_) => ("widen", &self.widen),
            };
            let mut dispatch = frame
                .dispatch(label, kernel)
                .set("of_mean", false)
                .set("by_channel", by_channel)
                .set("step", 3u32.pow(step.saturating_sub(1)));
            if let Some([means, squares]) = level {
                dispatch = dispatch
                    .texture("level_means", means)
                    .texture("level_squares", squares);
            }
            let (dispatch, means) = dispatch.write("next_means", means);
            let (dispatch, squares) = dispatch.write("next_squares", squares);
            dispatch.over(size)?;
            level = Some([means, squares]);
        }
        level.ok_or_else(|| RecordError::Failed("no level".into()))
    }

    fn estimate(
        &self,
        p: &VarianceParams,
        of_channels: bool,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("moments");
        let wired = ["channel_means", "channel_squares"].map(|port| frame.input(port));
        let by_channel = of_channels && wired.iter().all(Option::is_some);
        let Some(moments) = frame.input("moments") else {
            return Err(RecordError::Failed("it has no moments".into()));
        };
        let level = match p.spatial {
            // Not looked at.
            Spatial::Window => [moments; 2],
            Spatial::Hierarchical => self.hierarchy(p, by_channel, frame)?,
        };
        let (kernels, out, format) = match of_channels {
            false => (
                &self.luminance,
                "out_variance",
                wgpu::TextureFormat::R32Float,
            ),
            true => (
                &self.channels,
                "out_channel_variance",
                wgpu::TextureFormat::Rgba32Float,
            ),
        };
        let raw = p
            .prefilter
            .then(|| frame.transient("raw variance", format, size));
        let mut dispatch = frame
            .dispatch("variance", &kernels.variance)
            // `of` is a word of WGSL.
            .set("of_mean", p.of == Of::Mean)
            .set("by_channel", by_channel)
            .set("step", 0u32)
            .texture("level_means", level[0])
            .texture("level_squares", level[1]);
        let Some(raw) = raw else {
            return dispatch.over(size);
        };
        let written;
        (dispatch, written) = dispatch.write(out, raw);
        dispatch.over(size)?;
        frame
            .dispatch("prefilter", &kernels.prefilter)
            .texture("raw_variance", written)
            .over(size)
    }
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
            port("channel_means", signal::CHANNEL_MEANS)
                .optional()
                .about("for channel_variance"),
            port("channel_squares", signal::CHANNEL_SQUARES)
                .optional()
                .about("for channel_variance"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::new("variance", signal::VARIANCE)
                .any_resolution()
                .about("of luminance"),
            Port::new("channel_variance", signal::CHANNEL_VARIANCE)
                .any_resolution()
                .optional()
                .about("of red, green and blue; thrice that of luminance where they are not wired"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &VarianceParams) -> Result<Self, BuildError> {
        let kernel = |file, wgsl, entry| ctx.kernel(file, wgsl, entry);
        let variance = |entry| {
            kernel(
                "variance/variance.wgsl",
                include_str!("variance.wgsl"),
                entry,
            )
        };
        let prefilter = |entry| {
            kernel(
                "variance/prefilter.wgsl",
                include_str!("prefilter.wgsl"),
                entry,
            )
        };
        let kernels = |entry| {
            Ok::<_, BuildError>(Kernels {
                variance: variance(entry)?,
                prefilter: prefilter(entry)?,
            })
        };
        Ok(Self {
            luminance: kernels("main")?,
            channels: kernels("channels")?,
            begin: variance("begin")?,
            widen: variance("widen")?,
        })
    }

    fn record(
        &mut self,
        p: &VarianceParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        self.estimate(p, false, frame)?;
        if frame.wants("channel_variance") {
            self.estimate(p, true, frame)?;
        }
        Ok(())
    }
}
