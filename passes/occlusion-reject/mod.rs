#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, Texture};
use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, signal};
use wgpu::TextureFormat::Rgba32Float;

scumble::params! {
    /// What `occlusion-reject` can be told.
    pub struct OcclusionRejectParams {
        /// Passes of 3 x 3 over the window: 3 are 27 x 27.
        #[structural]
        pub levels: u32 = 3, in 2..=5;
        /// How much farther the farthest surface around must be than the nearest, and a point than those before it.
        pub limit: f32 = 1.1, in 1.0..=1000.0;
        /// Where a point and the nearest surface around moved no more than this against each other it stays, if position is wired.
        pub parallax: f32 = 0.0, in 0.0..=1000.0, unit "pixels";
        /// Whether points beyond an edge stay: those that nearer ones do not enclose.
        pub edge_test: bool = true;
    }
}

/// The pass; see the module.
pub struct OcclusionReject {
    single: ComputeKernel,
    dilate: ComputeKernel,
    reject: ComputeKernel,
    levels: u32,
}

impl Pass for OcclusionReject {
    type Params = OcclusionRejectParams;
    const NAME: &'static str = "occlusion-reject";
    const ABOUT: &'static str =
        "Takes back far points that show through the holes of near surfaces";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::new("view_z", signal::VIEW_Z).about("of samples and kept points, with holes"),
            Port::new("mask", signal::MASK)
                .optional()
                .about("not 0 where this frame has a sample, which stays; none without it"),
            Port::new("position", signal::POSITION).optional().about(
                "of the points; only what moved against what is before it can be hidden by it anew",
            ),
            Port::new("past_position", signal::POSITION)
                .optional()
                .about(
                    "of the same points in the previous frame; without it nothing moves by itself",
                ),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::new("view_z", signal::VIEW_Z).about("-1 also where a point was taken back")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("view_z", "view_z")]
    }

    fn build(ctx: &BuildContext<'_>, p: &OcclusionRejectParams) -> Result<Self, BuildError> {
        let extremes = include_str!("extremes.wgsl");
        let kernel = |file, wgsl, entry| ctx.kernel(file, wgsl, entry);
        Ok(Self {
            single: kernel("occlusion-reject/extremes.wgsl", extremes, "single")?,
            dilate: kernel("occlusion-reject/extremes.wgsl", extremes, "dilate")?,
            reject: kernel(
                "occlusion-reject/reject.wgsl",
                include_str!("reject.wgsl"),
                "reject",
            )?,
            levels: p.levels,
        })
    }

    fn record(
        &mut self,
        _p: &OcclusionRejectParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.full_size();
        // Windows of 1, 3, 9, ... texels; the last step is done where the points are looked at.
        let mut windows: Vec<Texture> = Vec::new();
        for level in 0..self.levels {
            let next = frame.transient("extremes", Rgba32Float, size);
            let dispatch = match windows.last() {
                None => frame.dispatch("extremes", &self.single),
                Some(&finer) => frame
                    .dispatch("dilate", &self.dilate)
                    .texture("extremes", finer),
            };
            let (dispatch, next) =
                set_steps(dispatch, level.saturating_sub(1), 0).write("next_extremes", next);
            dispatch.over(size)?;
            windows.push(next);
        }
        let (outer, inner) = (self.levels - 1, self.levels - 2);
        let mut dispatch = set_steps(frame.dispatch("reject", &self.reject), outer, inner);
        for (name, level) in [("extremes", outer), ("inner_extremes", inner)] {
            if let Some(&window) = windows.get(level as usize) {
                dispatch = dispatch.texture(name, window);
            }
        }
        dispatch.over(size)
    }
}

/// Steps between the windows of two levels.
fn set_steps<'d, 'a, 'f>(
    dispatch: scumble::Dispatch<'d, 'a, 'f>,
    level: u32,
    inner: u32,
) -> scumble::Dispatch<'d, 'a, 'f> {
    dispatch
        .set("step", 3u32.pow(level))
        .set("inner_step", 3u32.pow(inner))
}
