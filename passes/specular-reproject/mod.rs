#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, First};
use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, signal};

scumble::params! {
    /// What `specular-reproject` can be told.
    pub struct SpecularReprojectParams {
        /// Half the width of the window that hit distances are averaged over: 3 is 7 x 7.
        pub radius: u32 = 3, in 0..=8, unit "texels";
        /// Whether convex surfaces bring the image nearer.
        pub curvature: bool = true;
        /// Factor on the confidence in the image's motion; at 0 the surface's is kept.
        pub strength: f32 = 1.0, in 0.0..=1.0;
        /// Where the previous frame's image was farther off than this part of its distance plus the roughness, there is no history.
        pub image_tolerance: f32 = 0.2, in 0.0..=1000.0;
    }
}

/// The pass; see the module.
pub struct SpecularReproject {
    kernel: ComputeKernel,
}

impl Pass for SpecularReproject {
    type Params = SpecularReprojectParams;
    const NAME: &'static str = "specular-reproject";
    const ABOUT: &'static str =
        "Motion of reflections: where the previous frame showed the same image";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        let reflected = |name, signal, about| Port::new(name, signal).optional().about(about);
        vec![
            Port::new("position", signal::POSITION).about("of the surface"),
            Port::new("normal", signal::NORMAL).about("of the surface"),
            Port::new("view_z", signal::VIEW_Z).about("where there is a surface"),
            Port::new("motion", signal::MOTION).about("of the surface"),
            Port::new("past_view_z", signal::VIEW_Z)
                .about("distance of the same surface point in the previous frame"),
            Port::new("material", signal::MATERIAL).about("F0 and perceptual roughness"),
            Port::new("surface_id", signal::SURFACE_ID)
                .about("where hit distances may be averaged"),
            Port::new("hit_t", signal::HIT_T).about("how far off what is reflected was hit"),
            Port::new("hit_weight", signal::HIT_WEIGHT).about("what hit_t rests on"),
            reflected(
                "reflected_view_z",
                signal::VIEW_Z,
                "of the mirror's image; -1 where it is not known",
            ),
            reflected(
                "reflected_hit_t",
                signal::HIT_T,
                "takes the place of hit_t where it is known",
            ),
            reflected(
                "reflected_displacement",
                signal::DISPLACEMENT,
                "how the reflected point moved",
            ),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::new("motion", signal::MOTION).about("of what is reflected"),
            Port::new("past_view_z", signal::VIEW_Z)
                .about("distance of the surface point that reflected it; -1 where none did"),
            Port::new("image", signal::VIEW_Z)
                .optional()
                .about("distance along the view axis of the image in a flat mirror; 0 where it is not known"),
        ]
    }

    fn bypass() -> Vec<Bypass> {
        vec![
            Bypass::alias("motion", "motion"),
            Bypass::alias("past_view_z", "past_view_z"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &SpecularReprojectParams) -> Result<Self, BuildError> {
        let wgsl = include_str!("specular_reproject.wgsl");
        Ok(Self {
            kernel: ctx.kernel("specular-reproject/specular_reproject.wgsl", wgsl, "main")?,
        })
    }

    fn record(
        &mut self,
        _p: &SpecularReprojectParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.full_size();
        let format = wgpu::TextureFormat::R32Float;
        let image = frame.history("image", format, size, First::Clear([0.0; 4]));
        let mut dispatch = frame.dispatch("specular reproject", &self.kernel);
        if let Some(previous) = image.previous.first().copied().flatten() {
            dispatch = dispatch.texture("previous_image", previous);
        }
        let (dispatch, next) = dispatch.write("next_image", image.current);
        dispatch.over(size)?;
        frame.set_output("image", next);
        Ok(())
    }
}
