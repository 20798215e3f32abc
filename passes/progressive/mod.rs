#![doc = include_str!("README.md")]

use framegraph::First;
use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, Stat, signal};

scumble::params! {
    /// What `progressive` can be told.
    pub struct ProgressiveParams {
        /// A texel with this many samples takes no more; 0 is no end.
        pub max_frames: u32 = 0, in 0..=16777216, unit "frames";
    }
}

/// The pass; see the module.
pub struct Progressive {
    kernel: framegraph::ComputeKernel,
    /// What is averaged: changes when it may not be mixed with what came before.
    revision: Option<u64>,
    frames: u32,
    reason: String,
}

impl Pass for Progressive {
    type Params = ProgressiveParams;
    const NAME: &'static str = "progressive";
    const ABOUT: &'static str =
        "Running mean of a signal over the frames in which nothing upstream changed";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value").about("one estimate per frame"),
            Port::new("view_z", signal::VIEW_Z)
                .any_resolution()
                .optional()
                .about("a hole here is a texel without a sample"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::any("value")
                .precise()
                .about("mean of the estimates since the last change"),
        ]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &ProgressiveParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel(
            "progressive/progressive.wgsl",
            include_str!("progressive.wgsl"),
            "main",
        )?;
        Ok(Self {
            kernel,
            revision: None,
            frames: 0,
            reason: String::new(),
        })
    }

    fn record(
        &mut self,
        _p: &ProgressiveParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let upstream = frame.upstream();
        let restart = self.revision != Some(upstream.revision);
        if restart {
            self.revision = Some(upstream.revision);
            self.reason = upstream
                .changed
                .clone()
                .unwrap_or_else(|| "first frame".to_owned());
            self.frames = 0;
        }
        self.frames += 1;
        frame.report("frames", Stat::Number(f64::from(self.frames)));
        frame.report("restarted", Stat::Text(self.reason.clone()));

        let size = frame.size_of("value");
        let mean = frame.history(
            "mean",
            wgpu::TextureFormat::Rgba32Float,
            size,
            First::Clear([0.0; 4]),
        );
        let mut dispatch = frame
            .dispatch("progressive", &self.kernel)
            .set("restart", restart);
        if let Some(previous) = mean.previous.first().copied().flatten() {
            dispatch = dispatch.texture("previous_mean", previous);
        }
        dispatch.write("next_mean", mean.current).0.over(size)
    }
}
