#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, First, HistoryTexture, Texture};
use scumble::{
    BuildContext, BuildError, Bypass, Dispatch, FirstFrame, Pass, PassFrame, Port, RecordError,
    signal,
};
use wgpu::TextureFormat::{R32Float, R32Uint, Rg32Float, Rgba16Float, Rgba32Float};

scumble::choice! {
    /// What tells that a texel of the previous frame shows the same surface.
    pub enum DepthTest {
        /// Its distance to the tangent plane of that texel.
        #[default]
        Plane,
        /// The difference of the depths.
        Depth,
    }
}

scumble::choice! {
    /// How the history is interpolated.
    pub enum Sampling {
        /// Bilinear over the valid texels of 2 x 2.
        #[default]
        Bilinear,
        /// Catmull-Rom over 4 x 4 where all are valid, which keeps detail under repeated motion; bilinear elsewhere.
        CatmullRom,
    }
}

scumble::params! {
    /// What `accumulate` can be told.
    pub struct AccumulateParams {
        /// Least weight of a new value, r0; 0 gives the mean of all samples.
        pub blend: f32 = 0.2, in 0.0..=1.0;
        /// The same for the moments.
        pub moments_blend: f32 = 0.2, in 0.0..=1.0;
        /// Age does not grow beyond this.
        pub max_age: f32 = 65536.0, in 1.0..=16777216.0, unit "samples";
        /// Which test of depth.
        pub depth_test: DepthTest = DepthTest::Plane;
        /// Largest distance, as a part of the distance from the camera.
        pub depth_tolerance: f32 = 0.01, in 0.0..=1.0;
        /// Least cosine between the normals.
        pub min_cosine: f32 = 0.9, in -1.0..=1.0;
        /// How the history is interpolated.
        pub sampling: Sampling = Sampling::Bilinear;
        /// Whether the 3 x 3 texels are searched where none of 2 x 2 is valid.
        pub search: bool = true;
    }
}

/// The pass; see the module.
pub struct Accumulate {
    reproject: ComputeKernel,
    accumulate: ComputeKernel,
    channels: ComputeKernel,
}

/// What `reproject.wgsl` reads, of this frame and of the one before: the inputs of every pass that looks back along motion.
pub(crate) fn reprojection_inputs() -> Vec<Port> {
    let guide = |name, signal| Port::new(name, signal).any_resolution();
    let before = |name, signal, about| {
        let port = guide(name, signal).optional();
        port.first(FirstFrame::Skip).about(about)
    };
    vec![
        guide("view_z", signal::VIEW_Z).about("where there is a surface"),
        guide("normal", signal::NORMAL).about("guide"),
        guide("motion", signal::MOTION).about("where history is"),
        guide("surface_id", signal::SURFACE_ID)
            .optional()
            .about("guide"),
        guide("past_view_z", signal::VIEW_Z)
            .optional()
            .about("distance of the same surface point in the previous frame; view_z without it"),
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

/// The rest of it, for texels that stand for one pixel of many.
pub(crate) fn pixel_inputs() -> Vec<Port> {
    let pixel = |name| Port::new(name, signal::PIXEL).any_resolution().optional();
    vec![
        pixel("pixel").about("which pixel each texel was traced at; cell centres without it"),
        pixel("previous_pixel")
            .first(FirstFrame::Skip)
            .about("pixel of the previous frame"),
    ]
}

impl Pass for Accumulate {
    type Params = AccumulateParams;
    const NAME: &'static str = "accumulate";
    const ABOUT: &'static str =
        "Temporal accumulation of a signal and its moments along motion, with tests of every texel";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        let guide = |name, signal| Port::new(name, signal).any_resolution();
        let mut inputs = vec![
            Port::any("value").about("this frame's estimate"),
            Port::any("history")
                .first(FirstFrame::Skip)
                .about("what is continued, of the previous frame: this pass's own value, or a filtered one"),
            guide("moments", signal::MOMENTS)
                .optional()
                .about("of single samples of the value; its own luminance without it"),
            guide("samples", signal::AGE)
                .optional()
                .about("samples in each texel's estimate, 0 for none; 1 without it"),
            guide("confidence", signal::CONFIDENCE)
                .optional()
                .about("how far the history may be trusted; wholly without it"),
        ];
        inputs.extend(reprojection_inputs());
        inputs.extend(pixel_inputs());
        inputs
    }

    fn outputs() -> Vec<Port> {
        let state = |name, signal| Port::new(name, signal).any_resolution().optional();
        vec![
            Port::any("value").precise_if_kept().about("accumulated"),
            state("moments", signal::MOMENTS).about("accumulated"),
            state("age", signal::AGE).about("samples accumulated"),
            state("weights", signal::WEIGHTS)
                .about("sums of squared weights of the samples in value and moments"),
            state("channel_means", signal::CHANNEL_MEANS)
                .about("of the value, never of a filtered history"),
            state("channel_squares", signal::CHANNEL_SQUARES)
                .about("of the value, never of a filtered history"),
        ]
    }

    fn bypass() -> Vec<Bypass> {
        vec![
            Bypass::alias("value", "value"),
            Bypass::alias("moments", "moments"),
            Bypass::alias("age", "samples"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &AccumulateParams) -> Result<Self, BuildError> {
        let kernel = |file, wgsl| ctx.kernel(file, wgsl, "main");
        Ok(Self {
            reproject: kernel("accumulate/reproject.wgsl", include_str!("reproject.wgsl"))?,
            accumulate: kernel(
                "accumulate/accumulate.wgsl",
                include_str!("accumulate.wgsl"),
            )?,
            channels: kernel("accumulate/channels.wgsl", include_str!("channels.wgsl"))?,
        })
    }

    fn record(
        &mut self,
        _p: &AccumulateParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        let footprint = frame.transient("footprint", Rgba16Float, size);
        let (dispatch, footprint) = frame
            .dispatch("reproject", &self.reproject)
            .write("footprint", footprint);
        dispatch.over(size)?;

        let mut state = |name, format| frame.history(name, format, size, First::Clear([0.0; 4]));
        let moments = [
            ("moments", state("moments", Rg32Float)),
            ("age", state("age", R32Float)),
            ("weights", state("weights", R32Uint)),
        ];
        let mut outputs = Vec::new();
        let previous_age = moments[1].1.previous.first().copied().flatten();
        let by_channel = frame.wants("channel_means") || frame.wants("channel_squares");
        let dispatch = frame
            .dispatch("accumulate", &self.accumulate)
            .texture("footprint", footprint);
        continued(dispatch, &moments, &mut outputs).over(size)?;
        if by_channel {
            let mut state = |name| frame.history(name, Rgba32Float, size, First::Clear([0.0; 4]));
            let channels = ["channel_means", "channel_squares"].map(|name| (name, state(name)));
            let mut dispatch = frame
                .dispatch("channels", &self.channels)
                .texture("footprint", footprint);
            if let Some(previous) = previous_age {
                dispatch = dispatch.texture("previous_age", previous);
            }
            continued(dispatch, &channels, &mut outputs).over(size)?;
        }
        for (name, texture) in outputs {
            frame.set_output(name, texture);
        }
        Ok(())
    }
}

/// Binds what is kept from frame to frame, and remembers what is written as an output.
fn continued<'d, 'a, 'f>(
    mut dispatch: Dispatch<'d, 'a, 'f>,
    kept: &[(&'static str, HistoryTexture)],
    outputs: &mut Vec<(&'static str, Texture)>,
) -> Dispatch<'d, 'a, 'f> {
    for (name, history) in kept {
        if let Some(previous) = history.previous.first().copied().flatten() {
            dispatch = dispatch.texture(&format!("previous_{name}"), previous);
        }
        let written;
        (dispatch, written) = dispatch.write(&format!("next_{name}"), history.current);
        outputs.push((*name, written));
    }
    dispatch
}
