#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, First, Texture};
use scumble::{
    BuildContext, BuildError, Bypass, FirstFrame, Pass, PassFrame, Port, RecordError, Signal,
    signal,
};
use wgpu::TextureFormat::{R32Uint, Rg32Uint, Rgba32Float};

scumble::params! {
    /// What `scatter-reproject` can be told.
    pub struct ScatterReprojectParams {
        /// Least number of the eight pixels around that must show one surface for a gap between them to show it; 9 leaves gaps.
        pub gap_neighbours: u32 = 3, in 1..=9, unit "pixels";
        /// Distances that count as one surface there, as a part of the distance.
        pub depth_tolerance: f32 = 0.05, in 0.0..=1.0;
    }
}

/// The pass; see the module.
pub struct ScatterReproject {
    nearest: ComputeKernel,
    first: ComputeKernel,
    choose: ComputeKernel,
    fill: ComputeKernel,
    shape: ComputeKernel,
    colours: ComputeKernel,
}

/// What is kept from frame to frame: name, the name of its history, signal, whether its port is optional.
const KEPT: [(&str, &str, Signal, bool); 7] = [
    ("view_z", "kept view_z", signal::VIEW_Z, false),
    ("normal", "kept normal", signal::NORMAL, false),
    ("position", "kept position", signal::POSITION, false),
    (
        "past_position",
        "kept past_position",
        signal::POSITION,
        true,
    ),
    ("albedo", "kept albedo", signal::ALBEDO, true),
    ("emission", "kept emission", signal::EMISSION, true),
    ("surface_id", "kept surface_id", signal::SURFACE_ID, true),
];

/// What is found anew in each frame.
const FOUND: [(&str, Signal, bool); 2] = [
    ("motion", signal::MOTION, false),
    ("past_view_z", signal::VIEW_Z, true),
];

/// A guide of the frame before and of this one.
struct Kept {
    name: &'static str,
    previous: Texture,
    current: Texture,
}

impl Pass for ScatterReproject {
    type Params = ScatterReprojectParams;
    const NAME: &'static str = "scatter-reproject";
    const ABOUT: &'static str =
        "Keeps the surface points of a G-buffer with holes, scattered forward from frame to frame";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        let kept = KEPT
            .iter()
            .map(|&(name, _, signal, optional)| (name, signal, optional));
        kept.chain(FOUND)
            .map(|(name, signal, optional)| Port {
                optional,
                ..Port::new(name, signal).about("of this frame's samples; no sample where view_z is -1")
            })
            .chain([Port::new("previous_view_z", signal::VIEW_Z)
                .optional()
                .first(FirstFrame::Skip)
                .about("what a later pass left of this one's view_z in the previous frame: holes are forgotten")])
            .collect()
    }

    fn outputs() -> Vec<Port> {
        let kept = KEPT.iter().map(|&(name, _, signal, _)| (name, signal));
        kept.chain(FOUND.map(|(name, signal, _)| (name, signal)))
            .map(|(name, signal)| {
                Port::new(name, signal).optional().about(
                    "of samples, kept points and filled gaps; a direction is the position of sky",
                )
            })
            .collect()
    }

    fn bypass() -> Vec<Bypass> {
        let kept = KEPT.iter().map(|&(name, ..)| name);
        kept.chain(FOUND.map(|(name, ..)| name))
            .map(|name| Bypass::alias(name, name))
            .collect()
    }

    fn build(ctx: &BuildContext<'_>, _p: &ScatterReprojectParams) -> Result<Self, BuildError> {
        let scatter = include_str!("scatter.wgsl");
        let gather = include_str!("gather.wgsl");
        let kernel = |file, wgsl, entry| ctx.kernel(file, wgsl, entry);
        Ok(Self {
            nearest: kernel("scatter-reproject/scatter.wgsl", scatter, "nearest")?,
            first: kernel("scatter-reproject/scatter.wgsl", scatter, "first")?,
            choose: kernel(
                "scatter-reproject/choose.wgsl",
                include_str!("choose.wgsl"),
                "choose",
            )?,
            fill: kernel(
                "scatter-reproject/gaps.wgsl",
                include_str!("gaps.wgsl"),
                "fill",
            )?,
            shape: kernel("scatter-reproject/gather.wgsl", gather, "gather_shape")?,
            colours: kernel("scatter-reproject/gather.wgsl", gather, "gather_colours")?,
        })
    }

    fn record(
        &mut self,
        _p: &ScatterReprojectParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.full_size();
        let mut kept = keep(frame)?;
        let previous = |name: &str| kept.iter().find(|k| k.name == name).map(|k| k.previous);
        let missing = || RecordError::Failed("it keeps no guides".into());
        let [z, x, past, n] = ["view_z", "position", "past_position", "normal"].map(previous);
        let ((Some(z), Some(x)), (Some(past), Some(n))) = ((z, x), (past, n)) else {
            return Err(missing());
        };

        // Which texel of the frame before falls into each pixel.
        let mut minimum = |name| {
            let (label, bytes) = (
                frame.label(name),
                4 * u64::from(size[0]) * u64::from(size[1]),
            );
            let graph = frame.graph();
            let buffer = graph.buffer(label.clone(), bytes);
            graph.fill_buffer(label, buffer, u32::MAX)
        };
        let (depths, sources) = (minimum("depths"), minimum("sources"));
        let landing = frame.transient("landing", Rg32Uint, size);
        let (dispatch, landing) = frame
            .dispatch("nearest", &self.nearest)
            .texture("kept_view_z", z)
            .texture("kept_position", x)
            .texture("kept_past_position", past)
            .write("next_landing", landing);
        let (dispatch, depths) = dispatch.modify_buffer("depths", depths);
        dispatch.over(size)?;
        let (dispatch, sources) = frame
            .dispatch("first", &self.first)
            .texture("landing", landing)
            .buffer("depths", depths)
            .modify_buffer("sources", sources);
        dispatch.over(size)?;

        // What each pixel shows.
        let choice = frame.transient("choice", R32Uint, size);
        let place = frame.transient("place", Rgba32Float, size);
        let (dispatch, choice) = frame
            .dispatch("choose", &self.choose)
            .texture("kept_position", x)
            .texture("kept_past_position", past)
            .buffer("depths", depths)
            .buffer("sources", sources)
            .write("next_choice", choice);
        let (dispatch, place) = dispatch.write("next_place", place);
        dispatch.over(size)?;
        let shown = frame.transient("shown", R32Uint, size);
        let (mut dispatch, shown) = frame
            .dispatch("fill gaps", &self.fill)
            .texture("choice", choice)
            .texture("place", place)
            .texture("kept_view_z", z)
            .texture("kept_normal", n)
            .write("next_choice", shown);
        let mut position = place;
        for guide in kept.iter_mut().filter(|k| k.name == "position") {
            (dispatch, guide.current) = dispatch.write("next_position", guide.current);
            position = guide.current;
        }
        dispatch.over(size)?;

        // Its guides.
        let shape = ["view_z", "normal", "past_position"].as_slice();
        let colours = ["albedo", "emission", "surface_id"].as_slice();
        for (label, kernel, names) in [
            ("gather shape", &self.shape, shape),
            ("gather colours", &self.colours, colours),
        ] {
            if names == colours && !names.iter().any(|name| frame.wants(name)) {
                continue;
            }
            let mut dispatch = frame.dispatch(label, kernel).texture("choice", shown);
            if names == shape {
                dispatch = dispatch
                    .texture("shown_position", position)
                    .texture("kept_position", x)
                    .texture("kept_past_position", past)
                    .texture("kept_normal", n);
            }
            for guide in kept.iter_mut().filter(|k| names.contains(&k.name)) {
                if names == colours {
                    dispatch = dispatch.texture(&format!("kept_{}", guide.name), guide.previous);
                }
                let next = format!("next_{}", guide.name);
                (dispatch, guide.current) = dispatch.write(&next, guide.current);
            }
            dispatch.over(size)?;
        }
        for guide in kept {
            if frame.wants(guide.name) {
                frame.set_output(guide.name, guide.current);
            }
        }
        Ok(())
    }
}

/// The guides, kept where there is need: a guide that is not wired, or that nobody reads, is written to a texture of this frame.
fn keep(frame: &mut PassFrame<'_, '_>) -> Result<Vec<Kept>, RecordError> {
    let size = frame.full_size();
    let mut kept = Vec::new();
    for (name, history, signal, optional) in KEPT {
        let format = signal.format();
        let needed = match name {
            "past_position" => true,
            _ => frame.wants(name),
        };
        let (previous, current) = if !optional || (needed && frame.input(name).is_some()) {
            let history = frame.history(history, format, size, First::Clear([0.0; 4]));
            (history.previous.first().copied().flatten(), history.current)
        } else {
            // The shader does not look at what is bound for it.
            let float = if signal.is_float() {
                "view_z"
            } else {
                "normal"
            };
            (frame.input(float), frame.transient(history, format, size))
        };
        let Some(previous) = previous else {
            return Err(RecordError::Failed(format!("it has no past {name}")));
        };
        kept.push(Kept {
            name,
            previous,
            current,
        });
    }
    Ok(kept)
}
