//! The path tracer at full resolution, behind `direct-lighting` and `path-trace`.

use framegraph::{ComputeKernel, Texture};
use scumble::{BuildContext, BuildError, PassFrame, RecordError};
use scumble_scene::GpuScene;
use wgpu::TextureFormat::Rgba32Float;

use super::{Counter, rays_per_path, slices};

/// Which light the outputs hold.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Parts {
    pub direct: bool,
    /// Whether direct light has that of punctual lights.
    pub punctual: bool,
    pub indirect: bool,
}

/// What is traced in one frame.
pub(crate) struct Samples {
    pub per_pixel: u32,
    pub max_bounces: u32,
    pub parts: Parts,
    /// Pixels where it is 0 are left out.
    pub mask: Option<Texture>,
    /// Takes the place of pixel, frame and seed in the random numbers.
    pub seed: Option<Texture>,
    /// Tells the random numbers of one pass from another's.
    pub stream: u32,
    /// Most rays of one dispatch.
    pub ray_cap: u32,
}

/// Sums over a frame's samples, as `tracing/sums.wgsl` lays them out.
#[derive(Clone, Copy)]
pub(crate) struct Sums {
    pub irradiance: Texture,
    pub specular: Texture,
    pub squares: Texture,
}

/// Kernels of the tracer.
pub(crate) struct PixelTracer {
    trace: ComputeKernel,
    light: ComputeKernel,
    moments: ComputeKernel,
}

impl PixelTracer {
    pub fn build(ctx: &BuildContext<'_>) -> Result<Self, BuildError> {
        let scene = [(1, ctx.host::<GpuScene>()?.layout())];
        let resolve = include_str!("resolve.wgsl");
        Ok(Self {
            trace: ctx.kernel_with(
                "tracing/pixels.wgsl",
                include_str!("pixels.wgsl"),
                "main",
                &[],
                &scene,
            )?,
            light: ctx.kernel("tracing/resolve.wgsl", resolve, "resolve_light")?,
            moments: ctx.kernel("tracing/resolve.wgsl", resolve, "resolve_moments")?,
        })
    }

    /// Writes irradiance, specular, radiance and their moments; gives the sums for what else a pass makes of them.
    pub fn record(
        &self,
        samples: &Samples,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<Sums, RecordError> {
        let size = frame.full_size();
        let (mut rays, mut clamps) = (
            Counter::start("rays", frame),
            Counter::start("clamps", frame),
        );
        let sums = self.trace(samples, [&mut rays, &mut clamps], frame)?;
        let Some(surface_id) = frame.input("surface_id") else {
            return Err(RecordError::Failed("it has no surface_id".into()));
        };

        let light = frame.dispatch("resolve light", &self.light);
        clamps
            .bind(light)
            .texture("irradiance_sums", sums.irradiance)
            .texture("specular_sums", sums.specular)
            .texture("pixel_mask", samples.mask.unwrap_or(surface_id))
            .over(size)?;
        if ["irradiance_moments", "specular_moments", "radiance_moments"]
            .iter()
            .any(|port| frame.wants(port))
        {
            frame
                .dispatch("resolve moments", &self.moments)
                .texture("irradiance_sums", sums.irradiance)
                .texture("specular_sums", sums.specular)
                .texture("square_sums", sums.squares)
                .over(size)?;
        }
        rays.report(frame);
        clamps.report(frame);
        Ok(sums)
    }

    /// The samples of a frame, dispatch by dispatch.
    fn trace(
        &self,
        samples: &Samples,
        [rays, clamps]: [&mut Counter; 2],
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<Sums, RecordError> {
        let size = frame.full_size();
        let scene = frame.host::<GpuScene>()?.bind_group();
        let (Some(position), Some(surface_id)) =
            (frame.input("position"), frame.input("surface_id"))
        else {
            return Err(RecordError::Failed(
                "it has no position or no surface_id".into(),
            ));
        };
        let mut texture = |name| frame.transient(name, Rgba32Float, size);
        let mut pair = [
            [
                texture("irradiance sums"),
                texture("specular sums"),
                texture("square sums"),
            ],
            [
                texture("irradiance sums, next"),
                texture("specular sums, next"),
                texture("square sums, next"),
            ],
        ];
        let bounces = if samples.parts.indirect {
            samples.max_bounces
        } else {
            0
        };
        let work = slices(
            size,
            samples.per_pixel,
            rays_per_path(bounces),
            samples.ray_cap.into(),
            1,
        );
        for (i, slice) in work.iter().enumerate() {
            let [into, from] = &mut pair;
            // The first dispatch has nothing to add to; it does not look at what is bound there.
            let before = if i == 0 { [position; 3] } else { *from };
            let mut dispatch = frame
                .dispatch("trace", &self.trace)
                .group(1, scene)
                // Without a mask there is a sample wherever there is a surface; without a seed texture any will do.
                .texture("pixel_mask", samples.mask.unwrap_or(surface_id))
                .texture("pixel_seed", samples.seed.unwrap_or(surface_id))
                .set("use_pixel_seed", samples.seed.is_some())
                .set("stream", samples.stream)
                .set("bounces", bounces)
                .set("with_direct", samples.parts.direct)
                .set("with_punctual", samples.parts.punctual)
                .set("with_indirect", samples.parts.indirect)
                .set("first_row", slice.first_row)
                .set("slice_rows", slice.rows)
                .set("first_sample", slice.first_sample)
                .set("slice_samples", slice.samples)
                .set("has_sums", i > 0);
            dispatch = clamps.bind(rays.bind(dispatch));
            for (sum, name) in
                before
                    .into_iter()
                    .zip(["irradiance_sums", "specular_sums", "square_sums"])
            {
                dispatch = dispatch.texture(name, sum);
            }
            let next = [
                "next_irradiance_sums",
                "next_specular_sums",
                "next_square_sums",
            ];
            for (sum, name) in into.iter_mut().zip(next) {
                (dispatch, *sum) = dispatch.write(name, *sum);
            }
            dispatch.over(size)?;
            pair.swap(0, 1);
        }
        let [irradiance, specular, squares] = pair[1];
        Ok(Sums {
            irradiance,
            specular,
            squares,
        })
    }
}
