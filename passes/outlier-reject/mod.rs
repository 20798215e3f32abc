#![doc = include_str!("README.md")]

use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, signal};

scumble::params! {
    /// What `outlier-reject` can be told.
    pub struct OutlierRejectParams {
        /// Half the width of the neighbourhood: 1 is 3 x 3.
        pub radius: u32 = 1, in 1..=16, unit "texels";
        /// How many standard deviations from the mean a luminance may be.
        pub sigmas: f32 = 2.0, in 0.0..=100.0;
        /// The printed reading: mean and deviation count the texel itself, so that it can hide in its own deviation.
        pub include_center: bool = false;
        /// With fewer valid texels around, nothing is rejected.
        pub min_neighbours: u32 = 3, in 1..=1089;
    }
}

/// The pass; see the module.
pub struct OutlierReject {
    kernel: framegraph::ComputeKernel,
}

impl Pass for OutlierReject {
    type Params = OutlierRejectParams;
    const NAME: &'static str = "outlier-reject";
    const ABOUT: &'static str = "Scales texels whose luminance is far from that of their neighbours to the neighbours' mean";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value").about("what may hold outliers"),
            Port::new("view_z", signal::VIEW_Z)
                .any_resolution()
                .about("where there is a surface"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").about("without outliers")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &OutlierRejectParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel(
            "outlier-reject/outlier_reject.wgsl",
            include_str!("outlier_reject.wgsl"),
            "main",
        )?;
        Ok(Self { kernel })
    }

    fn record(
        &mut self,
        _p: &OutlierRejectParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        frame.dispatch("outlier-reject", &self.kernel).over(size)
    }
}
