//! Path tracing at every pixel, with irradiance and the specular lobe apart.
//!
//! | input | signal | |
//! |---|---|---|
//! | position, normal, geo_normal, albedo, material, surface_id | of the same name | |
//! | mask | mask | optional; pixels where it is 0 are left out |
//! | seed | seed | optional; takes the place of pixel, frame and seed in the random numbers |
//!
//! | output | signal | |
//! |---|---|---|
//! | irradiance | irradiance | k_d left out |
//! | specular | specular | |
//! | radiance | radiance | k_d/pi E + L_spec |
//! | hit_t | hit_t | as the specular lobe sees it; 1e30 where no first segment hit anything |
//! | hit_weight | hit_weight | what hit_t rests on |
//! | irradiance_moments, specular_moments, radiance_moments | moments | of single samples |
//! | samples | age | paths traced for each pixel |

use framegraph::ComputeKernel;
use scumble::{BuildContext, BuildError, Needs, Pass, PassFrame, Port, RecordError, signal};

use crate::tracing::{self, PixelTracer, Samples};

scumble::choice! {
    /// Which light is traced.
    pub enum Parts {
        /// What reaches the visible point straight from an emitter.
        Direct,
        /// The rest.
        Indirect,
        /// All but what reaches the visible point straight from a punctual light: what an engine's shadow maps do not show.
        NotPunctual,
        /// All of it.
        #[default]
        Both,
    }
}

scumble::params! {
    /// What `path-trace` can be told.
    pub struct PathTraceParams {
        /// Paths per pixel and frame.
        #[budget]
        pub samples: u32 = 1, in 1..=65536, unit "spp";
        /// Indirect bounces; 0 leaves light straight from emitters alone.
        pub max_bounces: u32 = 4, in 0..=64;
        /// Which light is traced.
        pub parts: Parts = Parts::Both;
        /// Most rays of one dispatch; a frame of more is spread over several.
        pub ray_cap: u32 = 4_000_000, in 1024..=1_000_000_000, unit "rays";
    }
}

/// The pass `path-trace`.
pub struct PathTrace {
    tracer: PixelTracer,
    hit_t: ComputeKernel,
}

impl Pass for PathTrace {
    type Params = PathTraceParams;
    const NAME: &'static str = "path-trace";
    const ABOUT: &'static str = "Path tracing at every pixel, irradiance and specular lobe apart";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        let mut inputs = tracing::primary_inputs();
        inputs.push(
            Port::new("mask", signal::MASK)
                .optional()
                .about("pixels where it is 0 are left out"),
        );
        inputs.push(
            Port::new("seed", signal::SEED)
                .optional()
                .about("replaces pixel, frame and seed in random numbers"),
        );
        inputs
    }

    fn outputs() -> Vec<Port> {
        let mut outputs = tracing::light_outputs();
        outputs.push(
            Port::new("hit_t", signal::HIT_T)
                .optional()
                .about("mean length of the first segments that hit, as the specular lobe sees it"),
        );
        outputs.push(
            Port::new("hit_weight", signal::HIT_WEIGHT)
                .optional()
                .about("weight of the first segments in the specular lobe"),
        );
        outputs
    }

    fn needs(_: &PathTraceParams) -> Needs {
        tracing::needs()
    }

    fn build(ctx: &BuildContext<'_>, _: &PathTraceParams) -> Result<Self, BuildError> {
        Ok(Self {
            tracer: PixelTracer::build(ctx)?,
            hit_t: ctx.kernel("path-trace/hit_t.wgsl", include_str!("hit_t.wgsl"), "main")?,
        })
    }

    fn record(
        &mut self,
        p: &PathTraceParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let samples = Samples {
            per_pixel: p.samples,
            max_bounces: p.max_bounces,
            parts: tracing::Parts {
                direct: p.parts != Parts::Indirect,
                punctual: p.parts != Parts::NotPunctual,
                indirect: p.parts != Parts::Direct,
            },
            mask: frame.input("mask"),
            seed: frame.input("seed"),
            stream: 0x7061_7468,
            ray_cap: p.ray_cap,
        };
        let sums = self.tracer.record(&samples, frame)?;
        if frame.wants("hit_t") || frame.wants("hit_weight") {
            let size = frame.full_size();
            frame
                .dispatch("hit_t", &self.hit_t)
                .texture("irradiance_sums", sums.irradiance)
                .texture("specular_sums", sums.specular)
                .texture("square_sums", sums.squares)
                .over(size)?;
        }
        Ok(())
    }
}
