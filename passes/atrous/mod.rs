#![doc = include_str!("README.md")]

use framegraph::ComputeKernel;
use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, signal};

pub use crate::edges::DepthForm;

scumble::choice! {
    /// Weights of the taps before any edge.
    pub enum Kernel {
        /// [1 2 1]/4 in each axis.
        #[default]
        Three,
        /// [1 4 6 4 1]/16 in each axis, a cubic B-spline.
        Five,
    }
}

scumble::choice! {
    /// In which order the levels follow each other.
    pub enum Order {
        /// 0, then from the coarsest to 1: fine levels hide what coarse ones leave, and the finest can be fed back.
        #[default]
        FirstThenCoarse,
        /// 0, 1, 2, ...
        Ascending,
        /// ..., 2, 1, 0.
        Descending,
    }
}

scumble::choice! {
    /// How luminance keeps texels apart.
    pub enum Luminance {
        /// By sigma_luminance times the standard deviation.
        #[default]
        Deviation,
        /// By sigma_luminance times the variance, as Dundr 2018 prints it; not invariant to the scale of light.
        Variance,
        /// Not at all.
        Off,
    }
}

scumble::choice! {
    /// Whose variance the luminance weight takes.
    pub enum VarianceAt {
        /// That of the texel that is filtered.
        #[default]
        Centre,
        /// The smaller one of both texels.
        Minimum,
        /// The greater one of both texels: what a texel gives to a darker one it does not keep from it, either.
        Maximum,
    }
}

scumble::params! {
    /// What `atrous` can be told.
    pub struct AtrousParams {
        /// How many levels.
        #[structural]
        pub levels: u32 = 6, in 1..=12;
        /// In which order.
        #[structural]
        pub order: Order = Order::FirstThenCoarse;
        /// Weights of the taps.
        pub kernel: Kernel = Kernel::Three;
        /// Exponent of the cosine between normals.
        pub sigma_normal: f32 = 64.0, in 0.0..=1024.0;
        /// Scale of the depth weight.
        pub sigma_depth: f32 = 1.0, in 0.0..=1000.0;
        /// Depth that always counts as equal, as a part of the distance.
        pub depth_epsilon: f32 = 0.005, in 0.0..=1.0;
        /// Which depth weight.
        pub depth_form: DepthForm = DepthForm::Slope;
        /// Where depth changes by more than this part of itself per texel it has no weight; 0 is nowhere.
        pub slope_limit: f32 = 0.0, in 0.0..=1000.0, unit "1/texel";
        /// Scale of the luminance weight.
        pub sigma_luminance: f32 = 4.0, in 0.0..=1000000.0;
        /// Luminance that always counts as equal.
        pub luminance_epsilon: f32 = 0.01, in 0.0..=1000.0;
        /// luminance_epsilon falls as 1 / age up to this age.
        pub epsilon_age: f32 = 4.0, in 1.0..=65536.0, unit "samples";
        /// How luminance keeps texels apart.
        pub luminance: Luminance = Luminance::Deviation;
        /// Whose variance the luminance weight takes.
        pub variance_at: VarianceAt = VarianceAt::Centre;
        /// Whether each level blurs the variance by 3 x 3 first.
        pub blur_variance: bool = false;
        /// Whether texels of other surfaces weigh nothing, where surface_id is wired.
        pub match_surface: bool = false;
        /// The filter fades out until this age; 0 is never.
        pub fade_age: f32 = 0.0, in 0.0..=65536.0, unit "samples";
        /// From this age on `first` is unfiltered; 0 is never.
        pub feedback_age: f32 = 0.0, in 0.0..=65536.0, unit "samples";
    }
}

/// The pass; see the module.
pub struct Atrous {
    /// Of luminance, of each channel.
    level: [ComputeKernel; 2],
    first_level: [ComputeKernel; 2],
    order: Vec<u32>,
}

/// The levels as they are done.
fn order(levels: u32, order: Order) -> Vec<u32> {
    match order {
        Order::FirstThenCoarse => std::iter::once(0).chain((1..levels).rev()).collect(),
        Order::Ascending => (0..levels).collect(),
        Order::Descending => (0..levels).rev().collect(),
    }
}

impl Pass for Atrous {
    type Params = AtrousParams;
    const NAME: &'static str = "atrous";
    const ABOUT: &'static str = "Edge-avoiding a-trous wavelet filter, guided by variance";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        let port = |name, signal| Port::new(name, signal).any_resolution();
        vec![
            Port::any("value").about("what is filtered; a texel of alpha 0 has no value"),
            port("view_z", signal::VIEW_Z).about("guide, and where there is a surface"),
            port("normal", signal::NORMAL).about("guide"),
            port("variance", signal::VARIANCE)
                .optional()
                .about("of the value's luminance; without it luminance does not guide"),
            port("channel_variance", signal::CHANNEL_VARIANCE)
                .optional()
                .about("of red, green and blue, which guide in the place of luminance"),
            port("surface_id", signal::SURFACE_ID)
                .optional()
                .about("guide"),
            port("age", signal::AGE)
                .optional()
                .about("samples in the value; 1 without it"),
            port("guide_variance", signal::GUIDE_VARIANCE)
                .optional()
                .about("of the guides within a texel: where they vary they keep less apart"),
            port("reflected_view_z", signal::VIEW_Z)
                .optional()
                .about("second guide, of what the surface reflects; no guide where it is -1"),
            port("reflected_normal", signal::NORMAL)
                .optional()
                .about("second guide"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::any("value").about("filtered"),
            Port::any("first")
                .optional()
                .about("after the first level, for the history of the next frame"),
            Port::new("variance", signal::VARIANCE)
                .any_resolution()
                .optional()
                .about("of the filtered value's luminance"),
        ]
    }

    fn bypass() -> Vec<Bypass> {
        vec![
            Bypass::alias("value", "value"),
            Bypass::alias("first", "value"),
            Bypass::alias("variance", "variance"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, p: &AtrousParams) -> Result<Self, BuildError> {
        let kernel = |entry| ctx.kernel("atrous/atrous.wgsl", include_str!("atrous.wgsl"), entry);
        Ok(Self {
            level: [kernel("level")?, kernel("level_by_channel")?],
            first_level: [kernel("first_level")?, kernel("first_level_by_channel")?],
            order: order(p.levels, p.order),
        })
    }

    fn record(
        &mut self,
        _p: &AtrousParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        let Some(mut value) = frame.input("value") else {
            return Err(RecordError::Failed("it has no value".into()));
        };
        let mut variance = frame.input("variance");
        let mut channels = frame.input("channel_variance");
        let by_channel = channels.is_some();
        let format = frame.output_format("value");
        for (i, level) in self.order.iter().enumerate() {
            let kernels = match i == 0 && frame.wants("first") {
                true => &self.first_level,
                false => &self.level,
            };
            let next_channels = channels
                .map(|_| frame.transient("level channels", wgpu::TextureFormat::Rgba32Float, size));
            // The last level writes the outputs.
            let between = (i + 1 < self.order.len()).then(|| {
                [
                    frame.transient("level value", format, size),
                    frame.transient("level variance", wgpu::TextureFormat::R32Float, size),
                ]
            });
            let mut dispatch = frame
                .dispatch("level", &kernels[usize::from(by_channel)])
                .set("step", 1u32 << level)
                .set("has_level_variance", variance.is_some())
                .texture("level_value", value)
                // Not looked at where there is none.
                .texture("level_variance", variance.unwrap_or(value))
                .set("by_channel", by_channel)
                .texture("level_channels", channels.unwrap_or(value));
            if let Some(next) = next_channels {
                let written;
                (dispatch, written) = dispatch.write("next_channels", next);
                channels = Some(written);
            }
            if let Some([next_value, next_variance]) = between {
                (dispatch, value) = dispatch.write("out_value", next_value);
                let written;
                (dispatch, written) = dispatch.write("out_variance", next_variance);
                variance = variance.map(|_| written);
            }
            dispatch.over(size)?;
        }
        Ok(())
    }
}
