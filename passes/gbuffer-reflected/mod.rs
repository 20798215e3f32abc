#![doc = include_str!("README.md")]

use framegraph::ComputeKernel;
use scumble::{BuildContext, BuildError, Needs, Pass, PassFrame, Port, RecordError, signal};
use scumble_scene::GpuScene;
use wgpu::TextureFormat::Rgba32Uint;

use crate::tracing::{self, Counter, slices};

scumble::params! {
    /// What `gbuffer-reflected` can be told.
    pub struct GbufferReflectedParams {
        /// Rougher surfaces are no mirrors: nothing is traced from them.
        pub max_roughness: f32 = 0.25, in 0.0..=1.0;
        /// Most rays of one dispatch; a frame of more is spread over several.
        pub ray_cap: u32 = 4_000_000, in 1024..=1_000_000_000, unit "rays";
    }
}

/// The pass; see the module.
pub struct GbufferReflected {
    rays: ComputeKernel,
    shape: ComputeKernel,
    content: ComputeKernel,
}

impl Pass for GbufferReflected {
    type Params = GbufferReflectedParams;
    const NAME: &'static str = "gbuffer-reflected";
    const ABOUT: &'static str =
        "What a mirror in place of every smooth surface shows: its guides and its motion";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::new("position", signal::POSITION).about("of the surface"),
            Port::new("normal", signal::NORMAL).about("of the mirror"),
            Port::new("geo_normal", signal::GEO_NORMAL).about("off which rays start"),
            Port::new("material", signal::MATERIAL).about("what is smooth enough"),
            Port::new("surface_id", signal::SURFACE_ID).about("nothing is traced where it is 0"),
        ]
    }

    fn outputs() -> Vec<Port> {
        let port = |name, signal, about| Port::new(name, signal).optional().about(about);
        vec![
            port(
                "normal",
                signal::NORMAL,
                "of the reflected point, facing the mirror",
            ),
            port(
                "view_z",
                signal::VIEW_Z,
                "of the mirror's image; 1e30 where it shows the sky, -1 where there is no mirror",
            ),
            port(
                "surface_id",
                signal::SURFACE_ID,
                "of the reflected point; 0 without one",
            ),
            port(
                "hit_t",
                signal::HIT_T,
                "from the mirror to the reflected point; 1e30 without one",
            ),
            port(
                "albedo",
                signal::ALBEDO,
                "k_d + F0 of the reflected point; 1 where it emits, and without one",
            ),
            port(
                "displacement",
                signal::DISPLACEMENT,
                "of the reflected point; 0 without one",
            ),
        ]
    }

    fn needs(_: &GbufferReflectedParams) -> Needs {
        tracing::needs()
    }

    fn build(ctx: &BuildContext<'_>, _: &GbufferReflectedParams) -> Result<Self, BuildError> {
        let scene = [(1, ctx.host::<GpuScene>()?.layout())];
        let kernel = |file, wgsl, entry| ctx.kernel_with(file, wgsl, entry, &[], &scene);
        let resolve = include_str!("resolve.wgsl");
        Ok(Self {
            rays: kernel(
                "gbuffer-reflected/mirror_rays.wgsl",
                include_str!("mirror_rays.wgsl"),
                "main",
            )?,
            shape: kernel("gbuffer-reflected/resolve.wgsl", resolve, "resolve_shape")?,
            content: kernel("gbuffer-reflected/resolve.wgsl", resolve, "resolve_content")?,
        })
    }

    fn record(
        &mut self,
        p: &GbufferReflectedParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.full_size();
        let scene = frame.host::<GpuScene>()?.bind_group();
        let mut rays = Counter::start("rays", frame);
        let mut visibility = frame.transient("visibility", Rgba32Uint, size);
        for (i, slice) in slices(size, 1, 1, p.ray_cap.into(), 1).iter().enumerate() {
            let dispatch = frame.dispatch("mirror rays", &self.rays).group(1, scene);
            let dispatch = rays.bind(dispatch).set("first_row", slice.first_row);
            // The first one has nothing to keep: all rows are written.
            let (dispatch, next) = if i == 0 {
                dispatch.write("next_visibility", visibility)
            } else {
                dispatch.modify("next_visibility", visibility)
            };
            visibility = next;
            dispatch.over([size[0], slice.rows])?;
        }
        rays.report(frame);
        for (label, kernel, ports) in [
            (
                "resolve shape",
                &self.shape,
                &["normal", "view_z", "surface_id", "hit_t"][..],
            ),
            (
                "resolve content",
                &self.content,
                &["albedo", "displacement"][..],
            ),
        ] {
            if ports.iter().any(|port| frame.wants(port)) {
                frame
                    .dispatch(label, kernel)
                    .group(1, scene)
                    .texture("visibility", visibility)
                    .over(size)?;
            }
        }
        Ok(())
    }
}
