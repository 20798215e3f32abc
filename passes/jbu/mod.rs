#![doc = include_str!("README.md")]

use scumble::{
    BuildContext, BuildError, Bypass, Filter, Pass, PassFrame, Port, RecordError, signal,
};

scumble::choice! {
    /// How far apart two depths are.
    pub enum DepthTerm {
        /// (z_p / z_q - 1)^2, the poster's.
        #[default]
        Ratio,
        /// ln(z_p / z_q)^2, the same seen from either side.
        Log,
        /// (n_q . (x_p - x_q) / z_q)^2, the distance to the tangent plane: it keeps planes together at grazing angles.
        Plane,
    }
}

scumble::choice! {
    /// What a pixel gets that no traced pixel resembles.
    pub enum Fallback {
        /// The same mean, its exponents shifted by the least: the least unlike traced pixels decide.
        #[default]
        Shifted,
        /// The value of the traced pixel nearest in the image.
        Nearest,
        /// 0.
        Zero,
    }
}

scumble::params! {
    /// What `jbu` can be told.
    pub struct JbuParams {
        /// Half the width of the window: 2 is 5 x 5 traced pixels.
        pub radius: u32 = 2, in 1..=8, unit "grid texels";
        /// Weight of the squared distance to the traced pixel; 1 / (2 sigma^2).
        pub lambda_pixel: f32 = 1.0, in 0.0..=100.0, unit "1/spacing^2";
        /// Weight of the depth term.
        pub lambda_z: f32 = 100.0, in 0.0..=1000000.0;
        /// Weight of the squared distance of the unit normals.
        pub lambda_normal: f32 = 3.7, in 0.0..=10000.0;
        /// Which depth term.
        pub depth_term: DepthTerm = DepthTerm::Ratio;
        /// A pixel whose least exponent is above this is unsupported.
        pub max_exponent: f32 = 5.0, in 0.0..=1000000.0;
        /// What an unsupported pixel gets.
        pub fallback: Fallback = Fallback::Shifted;
    }
}

/// The pass; see the module.
pub struct Jbu {
    kernel: framegraph::ComputeKernel,
}

impl Pass for Jbu {
    type Params = JbuParams;
    const NAME: &'static str = "jbu";
    const ABOUT: &'static str =
        "Joint bilateral upsampling of values traced at sparse pixels, guided by depth and normals";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value")
                .grid()
                .about("value at each traced pixel"),
            Port::new("grid_normal", signal::NORMAL)
                .grid()
                .source("normal")
                .about("normal at each traced pixel"),
            Port::new("grid_view_z", signal::VIEW_Z)
                .grid()
                .source("view_z")
                .about("depth at each traced pixel"),
            Port::new("pixel", signal::PIXEL)
                .grid()
                .about("which pixel was traced"),
            Port::new("normal", signal::NORMAL).about("guide at every pixel"),
            Port::new("view_z", signal::VIEW_Z).about("guide at every pixel"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::any("value").full().about("value at every pixel"),
            Port::new("mask", signal::MASK)
                .optional()
                .about("1 where no traced pixel supports the value"),
        ]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::resample("value", "value", Filter::Linear)]
    }

    fn build(ctx: &BuildContext<'_>, _p: &JbuParams) -> Result<Self, BuildError> {
        let kernel = ctx.kernel("jbu/jbu.wgsl", include_str!("jbu.wgsl"), "main")?;
        Ok(Self { kernel })
    }

    fn record(&mut self, _p: &JbuParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.full_size();
        frame.dispatch("jbu", &self.kernel).over(size)
    }
}
