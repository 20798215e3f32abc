//! What the camera sees: guides and materials of the visible point of every pixel.
//!
//! | input | signal | |
//! |---|---|---|
//! | mask | mask | optional; pixels where it is 0 become holes |
//!
//! | output | signal |
//! |---|---|
//! | albedo, normal, geo_normal, view_z, position, motion, material, surface_id, emission | of the same name |
//! | past_view_z | view_z |
//! | past_position | position |

mod sampling;

use framegraph::{ComputeKernel, Load, RasterKernel, Texture};
use scumble::{
    BuildContext, BuildError, Needs, Pass, PassFrame, Port, RasterOptions, RecordError, signal,
};
use scumble_scene::GpuScene;
use wgpu::TextureFormat::{Depth32Float, Rgba32Uint};

use crate::tracing::{Counter, slices};
use sampling::Sampling;
pub(crate) use sampling::radical_inverse;

scumble::choice! {
    /// How the visible triangle is found.
    pub enum Source {
        /// By rasterisation, in one render pass.
        #[default]
        Raster,
        /// By primary rays; only where the mask is not 0.
        RayTraced,
    }
}

scumble::choice! {
    /// Where in a pixel the sample is taken.
    pub enum Jitter {
        /// At the centre.
        #[default]
        Off,
        /// At the point of the Halton sequence (bases 2 and 3) that belongs to the frame.
        Halton,
        /// Where the host says; at the centre when it says nothing.
        Host,
    }
}

scumble::params! {
    /// What `gbuffer` can be told.
    pub struct GbufferParams {
        /// How the visible triangle is found.
        pub source: Source = Source::Raster;
        /// Where in a pixel the sample is taken.
        pub jitter: Jitter = Jitter::Off;
    }
}

/// Most primary rays of one dispatch.
const RAY_CAP: u64 = 4_000_000;

/// The pass `gbuffer`.
pub struct Gbuffer {
    raster: RasterKernel,
    primary_rays: ComputeKernel,
    material: ComputeKernel,
    shape: ComputeKernel,
    motion: ComputeKernel,
}

impl Pass for Gbuffer {
    type Params = GbufferParams;
    const NAME: &'static str = "gbuffer";
    const ABOUT: &'static str = "What the camera sees: guides and materials of every visible point";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::new("mask", signal::MASK)
                .optional()
                .about("pixels where it is 0 become holes"),
        ]
    }

    fn outputs() -> Vec<Port> {
        let port = |name, signal, about| Port::new(name, signal).optional().about(about);
        vec![
            port("albedo", signal::ALBEDO, "k_d; the fourth channel is F90"),
            port("normal", signal::NORMAL, "shading normal"),
            port("geo_normal", signal::GEO_NORMAL, "normal of the triangle"),
            port(
                "view_z",
                signal::VIEW_Z,
                "1e30 where the sky is, -1 in a hole",
            ),
            port("position", signal::POSITION, "world space"),
            port(
                "motion",
                signal::MOTION,
                "of camera, nodes, skins and morph targets",
            ),
            port(
                "past_view_z",
                signal::VIEW_Z,
                "of the same surface point in the previous frame; -1 behind its camera",
            ),
            port(
                "past_position",
                signal::POSITION,
                "of the same surface point in the previous frame",
            ),
            port("material", signal::MATERIAL, "F0 and perceptual roughness"),
            port("surface_id", signal::SURFACE_ID, "0 where the sky is"),
            port(
                "emission",
                signal::EMISSION,
                "of the visible surface or of the sky",
            ),
        ]
    }

    fn needs(_: &GbufferParams) -> Needs {
        crate::tracing::needs()
    }

    fn build(ctx: &BuildContext<'_>, _: &GbufferParams) -> Result<Self, BuildError> {
        let scene = [(1, ctx.host::<GpuScene>()?.layout())];
        let resolve = |entry| {
            ctx.kernel_with(
                "gbuffer/resolve.wgsl",
                include_str!("resolve.wgsl"),
                entry,
                &[],
                &scene,
            )
        };
        let raster = RasterOptions {
            targets: &[Rgba32Uint],
            depth: Some(Depth32Float),
            groups: &scene,
            ..RasterOptions::default()
        };
        let rays = include_str!("primary_rays.wgsl");
        Ok(Self {
            raster: ctx.raster(
                "gbuffer/raster.wgsl",
                include_str!("raster.wgsl"),
                ["vertex", "fragment"],
                &raster,
            )?,
            primary_rays: ctx.kernel_with(
                "gbuffer/primary_rays.wgsl",
                rays,
                "main",
                &[],
                &scene,
            )?,
            material: resolve("resolve_material")?,
            shape: resolve("resolve_shape")?,
            motion: resolve("resolve_motion")?,
        })
    }

    fn record(
        &mut self,
        p: &GbufferParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let sampling = Sampling::new(frame.input_frame(), p.jitter, frame.full_size());
        let visibility = match p.source {
            Source::Raster => self.rasterise(&sampling, frame)?,
            Source::RayTraced => self.trace(&sampling, frame)?,
        };
        self.resolve(&sampling, visibility, frame)
    }
}

impl Gbuffer {
    /// The visibility buffer by rasterisation, in one render pass.
    fn rasterise(
        &self,
        sampling: &Sampling,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<Texture, RecordError> {
        let size = frame.full_size();
        let scene = frame.host::<GpuScene>()?;
        let visibility = frame.transient("visibility", Rgba32Uint, size);
        let depth = frame.transient("depth", Depth32Float, size);
        let clip_from_world = [("clip_from_world", sampling.clip_from_world().into())];
        let params = frame.uniform_bytes(self.raster.reflection(), "params", &clip_from_world)?;
        let label = frame.label("raster");
        let mut node = frame.graph().raster(label, &self.raster);
        node.uniform("params", &params)
            .bind_group(1, scene.bind_group());
        let visibility = node.color(0, visibility, Load::Clear(wgpu::Color::TRANSPARENT));
        // Reverse-z: 0 is infinitely far.
        node.depth(depth, Load::Clear(0.0));
        node.draw(move |pass| {
            for draw in scene.draws() {
                pass.draw(0..draw.vertex_count, draw.instance..draw.instance + 1);
            }
        });
        Ok(visibility)
    }

    /// The visibility buffer by primary rays.
    fn trace(
        &self,
        sampling: &Sampling,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<Texture, RecordError> {
        let size = frame.full_size();
        let scene = frame.host::<GpuScene>()?.bind_group();
        let mut rays = Counter::start("rays", frame);
        let visibility = frame.transient("visibility", Rgba32Uint, size);
        let label = frame.label("no visibility");
        let mut visibility = frame.graph().clear_texture(label, visibility, [0.0; 4]);
        for slice in slices(size, 1, 1, RAY_CAP, 1) {
            let dispatch = frame
                .dispatch("primary rays", &self.primary_rays)
                .group(1, scene);
            let dispatch = sampling
                .set(rays.bind(dispatch))
                .set("first_row", slice.first_row);
            let (dispatch, next) = dispatch.modify("next_visibility", visibility);
            visibility = next;
            dispatch.over([size[0], slice.rows])?;
        }
        rays.report(frame);
        Ok(visibility)
    }

    /// The signals that are read, from the visibility buffer.
    fn resolve(
        &self,
        sampling: &Sampling,
        visibility: Texture,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.full_size();
        let scene = frame.host::<GpuScene>()?.bind_group();
        let mut clamps = Counter::start("clamps", frame);
        let any =
            |frame: &PassFrame<'_, '_>, ports: &[&str]| ports.iter().any(|port| frame.wants(port));
        if any(frame, &["albedo", "material", "emission"]) {
            let dispatch = frame
                .dispatch("resolve material", &self.material)
                .group(1, scene);
            let dispatch = clamps.bind(sampling.set(dispatch));
            dispatch.texture("visibility", visibility).over(size)?;
        }
        if any(frame, &["normal", "geo_normal", "surface_id", "view_z"]) {
            let dispatch = frame.dispatch("resolve shape", &self.shape).group(1, scene);
            sampling
                .set(dispatch)
                .texture("visibility", visibility)
                .over(size)?;
        }
        if any(
            frame,
            &["position", "motion", "past_view_z", "past_position"],
        ) {
            let dispatch = frame
                .dispatch("resolve motion", &self.motion)
                .group(1, scene);
            sampling
                .set(dispatch)
                .texture("visibility", visibility)
                .over(size)?;
        }
        clamps.report(frame);
        Ok(())
    }
}
