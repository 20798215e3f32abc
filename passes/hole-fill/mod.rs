#![doc = include_str!("README.md")]

use framegraph::{ComputeKernel, Texture};
use scumble::{BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, signal};
use wgpu::TextureFormat::{Rgba16Float, Rgba32Float};

scumble::params! {
    /// What `hole-fill` can be told: nothing.
    pub struct HoleFillParams {}
}

/// The pass; see the module.
pub struct HoleFill {
    down_first: ComputeKernel,
    down: ComputeKernel,
    up: ComputeKernel,
    shape: ComputeKernel,
    colours: ComputeKernel,
    motion: ComputeKernel,
}

/// What a level of the pyramid is made of, and in which format.
const PARTS: [(&str, wgpu::TextureFormat); 4] = [
    ("shape", Rgba32Float),
    ("albedo", Rgba16Float),
    ("emission", Rgba16Float),
    ("motion", Rgba32Float),
];

struct Level {
    size: [u32; 2],
    parts: [Texture; 4],
}

fn signals() -> [(&'static str, scumble::Signal, bool); 6] {
    [
        ("view_z", signal::VIEW_Z, false),
        ("normal", signal::NORMAL, false),
        ("albedo", signal::ALBEDO, true),
        ("emission", signal::EMISSION, true),
        ("motion", signal::MOTION, true),
        ("past_view_z", signal::VIEW_Z, true),
    ]
}

impl Pass for HoleFill {
    type Params = HoleFillParams;
    const NAME: &'static str = "hole-fill";
    const ABOUT: &'static str = "Fills the holes of a G-buffer that has fewer samples than pixels";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        signals()
            .map(|(name, signal, optional)| Port {
                optional,
                ..Port::new(name, signal).about("with holes, where view_z is -1")
            })
            .into()
    }

    fn outputs() -> Vec<Port> {
        signals()
            .map(|(name, signal, _)| Port::new(name, signal).optional().about("without holes"))
            .into()
    }

    fn bypass() -> Vec<Bypass> {
        signals()
            .map(|(name, _, _)| Bypass::alias(name, name))
            .into()
    }

    fn build(ctx: &BuildContext<'_>, _p: &HoleFillParams) -> Result<Self, BuildError> {
        let kernel = |entry| {
            ctx.kernel(
                "hole-fill/pyramid.wgsl",
                include_str!("pyramid.wgsl"),
                entry,
            )
        };
        Ok(Self {
            down_first: kernel("down_first")?,
            down: kernel("down")?,
            up: kernel("up")?,
            shape: kernel("fill_shape")?,
            colours: kernel("fill_colours")?,
            motion: kernel("fill_motion")?,
        })
    }

    fn record(
        &mut self,
        _p: &HoleFillParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let full = frame.full_size();
        let mut levels: Vec<Level> = Vec::new();
        let mut size = full;
        // Down to one texel; an image of one texel has nothing to be filled from but itself.
        loop {
            size = size.map(|n| n.div_ceil(3));
            let next = PARTS.map(|(_, format)| frame.transient("level", format, size));
            let kernel = if levels.is_empty() {
                &self.down_first
            } else {
                &self.down
            };
            let fine = levels.last().map(|level| level.parts);
            let parts = record_level(frame, "down", kernel, [("fine", fine)], next, size)?;
            levels.push(Level { size, parts });
            if size == [1, 1] {
                break;
            }
        }
        let mut coarse = levels.pop().map(|level| level.parts);
        while let Some(level) = levels.pop() {
            let next = PARTS.map(|(_, format)| frame.transient("filled", format, level.size));
            let from = [("fine", Some(level.parts)), ("coarse", coarse)];
            coarse = Some(record_level(frame, "up", &self.up, from, next, level.size)?);
        }
        for (label, kernel, ports) in [
            ("fill shape", &self.shape, ["view_z", "normal"]),
            ("fill colours", &self.colours, ["albedo", "emission"]),
            ("fill motion", &self.motion, ["motion", "past_view_z"]),
        ] {
            if ports.iter().any(|port| frame.wants(port)) {
                let mut dispatch = frame.dispatch(label, kernel);
                for (part, texture) in coarse.iter().flat_map(named) {
                    // Each entry point looks at the shape and at one part more.
                    if kernel
                        .reflection()
                        .binding(&format!("coarse_{part}"))
                        .is_some()
                    {
                        dispatch = dispatch.texture(&format!("coarse_{part}"), texture);
                    }
                }
                dispatch.over(full)?;
            }
        }
        Ok(())
    }
}

fn named(parts: &[Texture; 4]) -> impl Iterator<Item = (&'static str, Texture)> {
    PARTS.map(|(name, _)| name).into_iter().zip(*parts)
}

/// One level from what is finer or coarser.
fn record_level<const N: usize>(
    frame: &mut PassFrame<'_, '_>,
    label: &'static str,
    kernel: &ComputeKernel,
    from: [(&str, Option<[Texture; 4]>); N],
    mut into: [Texture; 4],
    size: [u32; 2],
) -> Result<[Texture; 4], RecordError> {
    let mut dispatch = frame.dispatch(label, kernel);
    for (side, parts) in from {
        for (part, texture) in parts.iter().flat_map(named) {
            dispatch = dispatch.texture(&format!("{side}_{part}"), texture);
        }
    }
    for ((part, _), texture) in PARTS.iter().zip(&mut into) {
        (dispatch, *texture) = dispatch.write(&format!("next_{part}"), *texture);
    }
    dispatch.over(size)?;
    Ok(into)
}
