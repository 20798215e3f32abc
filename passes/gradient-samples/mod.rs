#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, First};
use scumble::{BuildContext, BuildError, Pass, PassFrame, Port, RecordError, signal};
use wgpu::TextureFormat::{R32Uint, Rgba16Float};

pub use crate::accumulate::DepthTest;
use crate::accumulate::reprojection_inputs;

scumble::params! {
    /// What `gradient-samples` can be told.
    pub struct GradientSamplesParams {
        /// How a texel of the previous frame is tested by depth, as in `accumulate`.
        pub depth_test: DepthTest = DepthTest::Plane;
        /// Largest distance, as a part of the distance from the camera, as in `accumulate`.
        pub depth_tolerance: f32 = 0.01, in 0.0..=1.0;
        /// Least cosine between the normals, as in `accumulate`.
        pub min_cosine: f32 = 0.9, in -1.0..=1.0;
    }
}

/// The pass; see the module.
pub struct GradientSamples {
    reproject: ComputeKernel,
    seeds: ComputeKernel,
}

impl Pass for GradientSamples {
    type Params = GradientSamplesParams;
    const NAME: &'static str = "gradient-samples";
    const ABOUT: &'static str =
        "Seeds of a frame's random numbers, one pixel in 3 x 3 with that of the previous frame";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        reprojection_inputs().into_iter().map(Port::full).collect()
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::new("seed", signal::SEED).about("for path-trace"),
            Port::new("source", signal::PIXEL).about(
                "the pixel of the previous frame whose seed it is; 4294967295 for a new seed",
            ),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &GradientSamplesParams) -> Result<Self, BuildError> {
        let kernel = |file, wgsl| ctx.kernel(file, wgsl, "main");
        Ok(Self {
            reproject: kernel(
                "accumulate/reproject.wgsl",
                include_str!("../accumulate/reproject.wgsl"),
            )?,
            seeds: kernel("gradient-samples/seeds.wgsl", include_str!("seeds.wgsl"))?,
        })
    }

    fn record(
        &mut self,
        _p: &GradientSamplesParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.full_size();
        let Some(normal) = frame.input("normal") else {
            return Err(RecordError::Failed("it has no normal".into()));
        };
        let footprint = frame.transient("footprint", Rgba16Float, size);
        let (dispatch, footprint) = frame
            .dispatch("reproject", &self.reproject)
            .set("sampling", 0u32)
            .set("search", false)
            .set("has_pixel", false)
            .set("has_previous_pixel", false)
            // Not looked at: texels are pixels.
            .texture("pixel", normal)
            .texture("previous_pixel", normal)
            .write("footprint", footprint);
        dispatch.over(size)?;

        let seeds = frame.history("seeds", R32Uint, size, First::Clear([0.0; 4]));
        let mut dispatch = frame
            .dispatch("seeds", &self.seeds)
            .texture("footprint", footprint);
        if let Some(previous) = seeds.previous.first().copied().flatten() {
            dispatch = dispatch.texture("previous_seeds", previous);
        }
        let (dispatch, written) = dispatch.write("next_seeds", seeds.current);
        dispatch.over(size)?;
        frame.set_output("seed", written);
        Ok(())
    }
}
