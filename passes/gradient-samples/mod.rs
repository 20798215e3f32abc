#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, First};
use scumble::{BuildContext, BuildError, FirstFrame, Pass, PassFrame, Port, RecordError, signal};
use wgpu::TextureFormat::{R32Uint, Rgba16Float};

pub use crate::accumulate::DepthTest;

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
        let before = |name, signal, about| {
            Port::new(name, signal)
                .optional()
                .first(FirstFrame::Skip)
                .about(about)
        };
        vec![
            Port::new("view_z", signal::VIEW_Z).about("where there is a surface"),
            Port::new("normal", signal::NORMAL).about("guide"),
            Port::new("motion", signal::MOTION).about("where the surface point was"),
            Port::new("surface_id", signal::SURFACE_ID)
                .optional()
                .about("guide"),
            Port::new("past_view_z", signal::VIEW_Z).optional().about(
                "distance of the same surface point in the previous frame; view_z without it",
            ),
            before(
                "previous_view_z",
                signal::VIEW_Z,
                "view_z of the previous frame",
            ),
            before(
                "previous_normal",
                signal::NORMAL,
                "normal of the previous frame",
            ),
            before(
                "previous_surface_id",
                signal::SURFACE_ID,
                "surface_id of the previous frame",
            ),
        ]
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
