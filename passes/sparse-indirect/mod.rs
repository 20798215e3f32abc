//! Indirect light of few pixels by many paths, with the guides of those pixels.
//!
//! | input | signal |
//! |---|---|
//! | position, normal, geo_normal, albedo, material, surface_id, motion, view_z | of the same name |
//! | past_view_z | view_z, optional |
//!
//! | output (one texel per `spacing` x `spacing` pixels) | signal | |
//! |---|---|---|
//! | irradiance | irradiance | k_d left out |
//! | specular | specular | |
//! | radiance | radiance | both together, seen at the traced pixel: k_d / pi E + L_spec |
//! | hit_t | hit_t | 1e30 where no first segment hit anything |
//! | normal, view_z, surface_id, motion, past_view_z | of the same name | of the traced pixel |
//! | pixel | pixel | which pixel was traced |

use framegraph::{ComputeKernel, Texture};
use scumble::{BuildContext, BuildError, Needs, Pass, PassFrame, Port, RecordError, signal};
use scumble_scene::GpuScene;
use wgpu::TextureFormat::Rgba32Float;

use crate::gbuffer::radical_inverse;
use crate::tracing::{Counter, needs, primary_inputs, rays_per_path, slices};

scumble::params! {
    /// What `sparse-indirect` can be told.
    pub struct SparseIndirectParams {
        /// Pixels from one traced pixel to the next.
        #[structural]
        pub spacing: u32 = 16, in 1..=1024, unit "px";
        /// Paths per traced pixel and frame.
        #[budget]
        pub samples: u32 = 100, in 1..=65536, unit "spp";
        /// Indirect bounces.
        pub max_bounces: u32 = 4, in 0..=64;
        /// Which pixel of its cell is traced, along both axes; -1 is the centre, spacing / 2.
        pub phase: i32 = -1, in -1..=1023, unit "px";
        /// Whether each frame traces another pixel of every cell, by the Halton sequence; `phase` is not looked at then.
        pub move_phase: bool = false;
        /// Most rays of one dispatch; a frame of more is spread over several.
        pub ray_cap: u32 = 4_000_000, in 1024..=1_000_000_000, unit "rays";
    }
}

/// Threads of a workgroup of `trace.wgsl`.
const THREADS: u32 = 64;
/// Tells its random numbers from other passes'.
const STREAM: u32 = 0x7370_6172;

/// The pass `sparse-indirect`.
pub struct SparseIndirect {
    trace: ComputeKernel,
    light: ComputeKernel,
    radiance: ComputeKernel,
    guides: ComputeKernel,
    past: ComputeKernel,
}

impl Pass for SparseIndirect {
    type Params = SparseIndirectParams;
    const NAME: &'static str = "sparse-indirect";
    const ABOUT: &'static str = "Indirect light of few pixels by many paths, on a regular grid";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        let mut inputs = primary_inputs();
        inputs.push(Port::new("motion", signal::MOTION).about("copied to the grid"));
        inputs.push(Port::new("view_z", signal::VIEW_Z).about("copied to the grid"));
        inputs.push(
            Port::new("past_view_z", signal::VIEW_Z)
                .optional()
                .about("copied to the grid"),
        );
        inputs
    }

    fn outputs() -> Vec<Port> {
        let port = |name, signal, about| Port::new(name, signal).grid().optional().about(about);
        vec![
            port("irradiance", signal::IRRADIANCE, "indirect E, k_d left out"),
            port(
                "specular",
                signal::SPECULAR,
                "indirect radiance of the specular lobe",
            ),
            port(
                "radiance",
                signal::RADIANCE,
                "indirect light of both lobes as it is seen, albedo and all",
            ),
            port(
                "hit_t",
                signal::HIT_T,
                "mean length of the first segments that hit",
            ),
            port("normal", signal::NORMAL, "of the traced pixel"),
            port("view_z", signal::VIEW_Z, "of the traced pixel"),
            port("surface_id", signal::SURFACE_ID, "of the traced pixel"),
            port("motion", signal::MOTION, "of the traced pixel"),
            port(
                "past_view_z",
                signal::VIEW_Z,
                "of the traced pixel; 0 everywhere where the input is not wired",
            ),
            port("pixel", signal::PIXEL, "which pixel was traced"),
        ]
    }

    fn needs(_: &SparseIndirectParams) -> Needs {
        needs()
    }

    fn grid(p: &SparseIndirectParams) -> Option<u32> {
        Some(p.spacing)
    }

    fn build(ctx: &BuildContext<'_>, _: &SparseIndirectParams) -> Result<Self, BuildError> {
        let scene = [(1, ctx.host::<GpuScene>()?.layout())];
        let resolve = include_str!("resolve.wgsl");
        Ok(Self {
            trace: ctx.kernel_with(
                "sparse-indirect/trace.wgsl",
                include_str!("trace.wgsl"),
                "main",
                &[],
                &scene,
            )?,
            light: ctx.kernel("sparse-indirect/resolve.wgsl", resolve, "resolve_light")?,
            radiance: ctx.kernel("sparse-indirect/resolve.wgsl", resolve, "resolve_radiance")?,
            guides: ctx.kernel("sparse-indirect/resolve.wgsl", resolve, "copy_guides")?,
            past: ctx.kernel("sparse-indirect/resolve.wgsl", resolve, "copy_past")?,
        })
    }

    fn record(
        &mut self,
        p: &SparseIndirectParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let grid = frame.size_of("irradiance");
        let phase = phase(p, frame.input_frame().frame);
        let (mut rays, mut clamps) = (
            Counter::start("rays", frame),
            Counter::start("clamps", frame),
        );
        let [irradiance, specular] = self.trace(p, phase, [&mut rays, &mut clamps], frame)?;

        let light = frame.dispatch("resolve light", &self.light);
        clamps
            .bind(light)
            .texture("irradiance_sums", irradiance)
            .texture("specular_sums", specular)
            .set("grid_phase", phase)
            .over(grid)?;
        if frame.wants("radiance") {
            let radiance = frame.dispatch("resolve radiance", &self.radiance);
            clamps
                .bind(radiance)
                .texture("irradiance_sums", irradiance)
                .texture("specular_sums", specular)
                .set("grid_phase", phase)
                .over(grid)?;
        }
        if ["normal", "view_z", "surface_id", "motion"]
            .iter()
            .any(|port| frame.wants(port))
        {
            frame
                .dispatch("copy guides", &self.guides)
                .set("grid_phase", phase)
                .over(grid)?;
        }
        if frame.wants("past_view_z") {
            frame
                .dispatch("copy past", &self.past)
                .set("grid_phase", phase)
                .over(grid)?;
        }
        rays.report(frame);
        clamps.report(frame);
        Ok(())
    }
}

/// The traced pixel of every cell in a frame.
fn phase(p: &SparseIndirectParams, frame: u32) -> [u32; 2] {
    if !p.move_phase {
        return [u32::try_from(p.phase).unwrap_or(p.spacing / 2); 2].map(|v| v.min(p.spacing - 1));
    }
    // The first point of the sequence, (0, 0), is left out.
    [2, 3].map(|base| {
        let along = radical_inverse(frame.wrapping_add(1), base) * p.spacing as f32;
        (along as u32).min(p.spacing - 1)
    })
}

impl SparseIndirect {
    /// The samples of a frame, dispatch by dispatch; gives their sums (irradiance, specular).
    fn trace(
        &self,
        p: &SparseIndirectParams,
        phase: [u32; 2],
        [rays, clamps]: [&mut Counter; 2],
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<[Texture; 2], RecordError> {
        let grid = frame.size_of("irradiance");
        let scene = frame.host::<GpuScene>()?.bind_group();
        let Some(position) = frame.input("position") else {
            return Err(RecordError::Failed("it has no position".into()));
        };
        let mut texture = |name| frame.transient(name, Rgba32Float, grid);
        let mut pair = [
            [texture("irradiance sums"), texture("specular sums")],
            [
                texture("irradiance sums, next"),
                texture("specular sums, next"),
            ],
        ];
        // As many threads share a texel as have a sample to trace.
        let lanes = p.samples.next_power_of_two().min(THREADS);
        let groups = [grid[0].div_ceil(THREADS / lanes), grid[1], 1];
        let work = slices(
            grid,
            p.samples,
            rays_per_path(p.max_bounces),
            p.ray_cap.into(),
            lanes,
        );
        for (i, slice) in work.iter().enumerate() {
            let [into, from] = &mut pair;
            // The first dispatch has nothing to add to; it does not look at what is bound there.
            let before = if i == 0 { [position; 2] } else { *from };
            let mut dispatch = frame
                .dispatch("trace", &self.trace)
                .group(1, scene)
                .set("stream", STREAM)
                .set("bounces", p.max_bounces)
                .set("grid_phase", phase)
                .set("lanes", lanes)
                .set("first_row", slice.first_row)
                .set("slice_rows", slice.rows)
                .set("first_sample", slice.first_sample)
                .set("slice_samples", slice.samples)
                .set("has_sums", i > 0);
            dispatch = clamps.bind(rays.bind(dispatch));
            for (sum, name) in before.into_iter().zip(["irradiance_sums", "specular_sums"]) {
                dispatch = dispatch.texture(name, sum);
            }
            for (sum, name) in into
                .iter_mut()
                .zip(["next_irradiance_sums", "next_specular_sums"])
            {
                (dispatch, *sum) = dispatch.write(name, *sum);
            }
            dispatch.workgroups(groups)?;
            pair.swap(0, 1);
        }
        Ok(pair[1])
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn lanes_divide_a_workgroup() {
        for samples in [1u32, 2, 3, 8, 63, 64, 65, 100, 65536] {
            let lanes = samples.next_power_of_two().min(super::THREADS);
            assert_eq!(super::THREADS % lanes, 0);
        }
    }
}
