#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, Texture};
use scumble::{BuildContext, BuildError, Pass, PassFrame, Port, RecordError, signal};

scumble::choice! {
    /// Where the exposure comes from.
    pub enum Exposure {
        /// The image: its log-average luminance becomes `key`.
        #[default]
        Automatic,
        /// `ev` alone.
        Manual,
    }
}

scumble::choice! {
    /// From scene-linear to display-linear values.
    pub enum Curve {
        /// The value itself, clamped.
        None,
        /// c / (1 + luminance). Reinhard et al. 2002, equation 3.
        Reinhard,
        /// Narkowicz 2015, a fit to the luminance of ACES, per channel.
        #[default]
        Aces,
        /// Sobotka's AgX, base look, in the approximation of Wrensch 2023.
        Agx,
    }
}

scumble::params! {
    /// What `tonemap` can be told.
    pub struct TonemapParams {
        /// Where the exposure comes from.
        pub exposure: Exposure = Exposure::Automatic;
        /// Radiance is multiplied by 2^ev, on top of the automatic exposure where that is chosen.
        pub ev: f32 = 0.0, in -32.0..=32.0, unit "EV";
        /// What the automatic exposure makes of the log-average luminance.
        pub key: f32 = 0.18, in 0.001..=10.0;
        /// Which curve.
        pub curve: Curve = Curve::Aces;
    }
}

/// Pixels of a tile of the reduction, per side.
const TILE: u32 = 16;

/// The pass; see the module.
pub struct Tonemap {
    tile: ComputeKernel,
    whole: ComputeKernel,
    curve: ComputeKernel,
}

impl Pass for Tonemap {
    type Params = TonemapParams;
    const NAME: &'static str = "tonemap";
    const ABOUT: &'static str = "Exposure, tone curve and sRGB encoding";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![Port::new("radiance", signal::RADIANCE).about("scene-linear")]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::new("color", signal::DISPLAY).about("sRGB-encoded, in [0, 1]")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &TonemapParams) -> Result<Self, BuildError> {
        let exposure = include_str!("exposure.wgsl");
        Ok(Self {
            tile: ctx.kernel("tonemap/exposure.wgsl", exposure, "tile")?,
            whole: ctx.kernel("tonemap/exposure.wgsl", exposure, "whole")?,
            curve: ctx.kernel("tonemap/tonemap.wgsl", include_str!("tonemap.wgsl"), "main")?,
        })
    }

    fn record(
        &mut self,
        p: &TonemapParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let exposure = match p.exposure {
            Exposure::Automatic => self.measure(p, frame)?,
            Exposure::Manual => {
                let exposure = frame.transient("exposure", wgpu::TextureFormat::R32Float, [1, 1]);
                frame.graph().clear_texture(
                    "exposure",
                    exposure,
                    [f64::from(p.ev.exp2()), 0.0, 0.0, 0.0],
                )
            }
        };
        let size = frame.full_size();
        frame
            .dispatch("tonemap", &self.curve)
            .texture("exposure", exposure)
            .over(size)
    }
}

impl Tonemap {
    fn measure(
        &self,
        p: &TonemapParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<Texture, RecordError> {
        let [width, height] = frame.full_size().map(|n| n.div_ceil(TILE));
        let tiles = frame.transient("tiles", wgpu::TextureFormat::Rg32Float, [width, height]);
        let exposure = frame.transient("exposure", wgpu::TextureFormat::R32Float, [1, 1]);
        let (dispatch, tiles) = frame
            .dispatch("log-luminance", &self.tile)
            .write("tiles", tiles);
        dispatch.workgroups([width, height, 1])?;
        let (dispatch, exposure) = frame
            .dispatch("exposure", &self.whole)
            .texture("tile_sums", tiles)
            .set("factor", p.ev.exp2())
            .write("exposure", exposure);
        dispatch.workgroups([1, 1, 1])?;
        Ok(exposure)
    }
}
