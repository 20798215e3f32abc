//! Light that reaches the visible point straight from an emitter.
//!
//! | input | signal |
//! |---|---|
//! | position, normal, geo_normal, albedo, material, surface_id | of the same name |
//!
//! | output | signal | |
//! |---|---|---|
//! | irradiance | irradiance | k_d left out |
//! | specular | specular | |
//! | radiance | radiance | k_d/pi E + L_spec |
//! | irradiance_moments, specular_moments, radiance_moments | moments | of single samples |
//! | samples | age | paths traced for each pixel |

use scumble::{BuildContext, BuildError, Needs, Pass, PassFrame, Port, RecordError};

use crate::tracing::{Parts, PixelTracer, Samples};

scumble::params! {
    /// What `direct-lighting` can be told.
    pub struct DirectLightingParams {
        /// Light samples, and as many BRDF samples, per pixel and frame.
        #[budget]
        pub samples: u32 = 1, in 1..=65536, unit "spp";
        /// Most rays of one dispatch; a frame of more is spread over several.
        pub ray_cap: u32 = 4_000_000, in 1024..=1_000_000_000, unit "rays";
    }
}

/// The pass `direct-lighting`.
pub struct DirectLighting(PixelTracer);

impl Pass for DirectLighting {
    type Params = DirectLightingParams;
    const NAME: &'static str = "direct-lighting";
    const ABOUT: &'static str = "Light that reaches the visible point straight from an emitter";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        crate::tracing::primary_inputs()
    }

    fn outputs() -> Vec<Port> {
        crate::tracing::light_outputs()
    }

    fn needs(_: &DirectLightingParams) -> Needs {
        crate::tracing::needs()
    }

    fn build(ctx: &BuildContext<'_>, _: &DirectLightingParams) -> Result<Self, BuildError> {
        Ok(Self(PixelTracer::build(ctx)?))
    }

    fn record(
        &mut self,
        p: &DirectLightingParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let samples = Samples {
            per_pixel: p.samples,
            max_bounces: 0,
            parts: Parts {
                direct: true,
                punctual: true,
                indirect: false,
            },
            mask: None,
            seed: None,
            stream: 0x6469_7265,
            ray_cap: p.ray_cap,
        };
        self.0.record(&samples, frame)?;
        Ok(())
    }
}
