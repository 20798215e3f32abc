#![doc = include_str!("README.md")]

use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, signal};

scumble::choice! {
    /// How far apart two depths are.
    pub enum DepthTerm {
        /// (z_p / z_q - 1)^2.
        #[default]
        Ratio,
        /// ln(z_p / z_q)^2, the same seen from either side.
        Log,
    }
}

scumble::params! {
    /// What `bilateral` can be told.
    pub struct BilateralParams {
        /// Half the width of the window: 2 is 5 x 5.
        pub radius: u32 = 2, in 1..=16, unit "texels";
        /// Weight of the squared distance; 1 / (2 sigma^2).
        pub lambda_pixel: f32 = 0.5, in 0.0..=100.0, unit "1/texel^2";
        /// Weight of the depth term.
        pub lambda_z: f32 = 100.0, in 0.0..=1000000.0;
        /// Weight of the squared distance of the unit normals.
        pub lambda_normal: f32 = 3.7, in 0.0..=10000.0;
        /// Which depth term.
        pub depth_term: DepthTerm = DepthTerm::Ratio;
    }
}

/// The pass; see the module.
pub struct Bilateral {
    kernel: framegraph::ComputeKernel,
}

impl Pass for Bilateral {
    type Params = BilateralParams;
    const NAME: &'static str = "bilateral";
    const ABOUT: &'static str = "Smooths a signal within surfaces, guided by depth and normals";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value").about("what is smoothed"),
            Port::new("normal", signal::NORMAL)
                .any_resolution()
                .about("guide"),
            Port::new("view_z", signal::VIEW_Z)
                .any_resolution()
                .about("guide, and where there is a surface"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").about("smoothed")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &BilateralParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel(
            "bilateral/bilateral.wgsl",
            include_str!("bilateral.wgsl"),
            "main",
        )?;
        Ok(Self { kernel })
    }

    fn record(
        &mut self,
        _p: &BilateralParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        frame.dispatch("bilateral", &self.kernel).over(size)
    }
}
