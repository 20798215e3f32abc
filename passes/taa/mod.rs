#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, First};
use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, signal};

pub use crate::accumulate::Sampling;

scumble::choice! {
    /// Where colours are blended.
    pub enum Space {
        /// x / (1 + max(x)), for linear light: a bright pixel does not outweigh its neighbours.
        #[default]
        Reversible,
        /// As they are, for what is tone mapped.
        Display,
    }
}

scumble::choice! {
    /// How the history is kept near the new colours.
    pub enum Rectify {
        /// Not at all.
        Off,
        /// Each channel into the box.
        #[default]
        Clamp,
        /// Towards the middle of the box until it is inside, which keeps its hue.
        Clip,
        /// By the colour of 3 x 3 that is nearest to it.
        Nearest,
    }
}

scumble::choice! {
    /// In which axes the box stands.
    pub enum Colors {
        /// Red, green, blue.
        Rgb,
        /// Luma and two differences: a box along the greys is smaller.
        #[default]
        YCoCg,
    }
}

scumble::choice! {
    /// What the box holds.
    pub enum Bounds {
        /// The least and greatest of 3 x 3.
        #[default]
        MinMax,
        /// Their mean +- gamma standard deviations.
        Variance,
    }
}

scumble::choice! {
    /// Whose motion leads to the history.
    pub enum Follow {
        /// The pixel's own.
        Own,
        /// The longest of 3 x 3.
        Longest,
        /// That of the nearest surface of 3 x 3: the edge of what stands in front moves with it. Without `view_z` it is `Longest`.
        #[default]
        Nearest,
    }
}

scumble::params! {
    /// What `taa` can be told.
    pub struct TaaParams {
        /// Least weight of the new colour, r0.
        pub blend: f32 = 0.1, in 0.0..=1.0;
        /// Whether the first frames weigh alike until 1 / n is r0; else the very first weighs most for long.
        pub warm_up: bool = true;
        /// Where colours are blended.
        pub space: Space = Space::Reversible;
        /// How the history is kept near the new colours.
        pub rectify: Rectify = Rectify::Clamp;
        /// In which axes the box stands.
        pub colors: Colors = Colors::YCoCg;
        /// What the box holds.
        pub bounds: Bounds = Bounds::MinMax;
        /// Half the size of a variance box.
        pub gamma: f32 = 1.25, in 0.0..=100.0, unit "standard deviations";
        /// By how much of itself the box grows.
        pub slack: f32 = 0.0, in 0.0..=100.0;
        /// How the history is interpolated.
        pub sampling: Sampling = Sampling::CatmullRom;
        /// Whose motion leads to the history, so that the edges of what moves are anti-aliased, too.
        pub follow: Follow = Follow::Nearest;
    }
}

/// The pass; see the module.
pub struct Taa {
    kernel: ComputeKernel,
}

impl Pass for Taa {
    type Params = TaaParams;
    const NAME: &'static str = "taa";
    const ABOUT: &'static str = "Temporal anti-aliasing: a running blend along motion, kept near the colours of the neighbourhood";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value").about("colours of this frame"),
            Port::new("motion", signal::MOTION)
                .any_resolution()
                .about("where history is"),
            Port::new("view_z", signal::VIEW_Z)
                .any_resolution()
                .optional()
                .about("which surface is the nearest; without it the longest motion is followed"),
            Port::new("samples", signal::AGE)
                .any_resolution()
                .optional()
                .about("0 where this frame has no sample; without it all have"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").about("anti-aliased")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &TaaParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel("taa/taa.wgsl", include_str!("taa.wgsl"), "main")?;
        Ok(Self { kernel })
    }

    fn record(&mut self, _p: &TaaParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        let format = frame.output_format("value");
        let history = frame.history("history", format, size, First::Clear([0.0; 4]));
        let mut dispatch = frame.dispatch("taa", &self.kernel);
        if let Some(previous) = history.previous.first().copied().flatten() {
            dispatch = dispatch.texture("previous_value", previous);
        }
        let (dispatch, next) = dispatch.write("next_value", history.current);
        dispatch.over(size)?;
        frame.set_output("value", next);
        Ok(())
    }
}
