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
    values: [ComputeKernel; 4],
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
        let value = Port::any("value").full().optional();
        signals()
            .map(|(name, signal, optional)| Port {
                optional,
                ..Port::new(name, signal).about("with holes, where view_z is -1")
            })
            .into_iter()
            .chain([value.about("with texels that have no value, where alpha is 0")])
            .collect()
    }

    fn outputs() -> Vec<Port> {
        let value = Port::any("value").full();
        signals()
            .map(|(name, signal, _)| Port::new(name, signal))
            .into_iter()
            .chain([value])
            .map(|port| port.optional().about("without holes"))
            .collect()
    }

    fn bypass() -> Vec<Bypass> {
        let names = signals().map(|(name, _, _)| name);
        names
            .into_iter()
            .chain(["value"])
            .map(|name| Bypass::alias(name, name))
            .collect()
    }

    fn build(ctx: &BuildContext<'_>, _p: &HoleFillParams) -> Result<Self, BuildError> {
        let kernel = |entry| {
            ctx.kernel(
                "hole-fill/pyramid.wgsl",
                include_str!("pyramid.wgsl"),
                entry,
            )
        };
        let values =
            |entry| ctx.kernel("hole-fill/values.wgsl", include_str!("values.wgsl"), entry);
        Ok(Self {
            values: [
                values("down_values")?,
                values("down_level")?,
                values("up_level")?,
                values("fill_values")?,
            ],
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
        if frame.wants("value") {
            self.fill_values(frame)?;
        }
        if !signals().iter().any(|(name, ..)| frame.wants(name)) {
            return Ok(());
        }
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

impl HoleFill {
    /// The texels without a value, from a pyramid of those that have one.
    fn fill_values(&self, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let [down_values, down_level, up_level, fill] = &self.values;
        let full = frame.full_size();
        let mut levels: Vec<([u32; 2], Texture)> = Vec::new();
        let mut size = full;
        loop {
            size = size.map(|n| n.div_ceil(3));
            let next = frame.transient("value level", Rgba32Float, size);
            let dispatch = match levels.last() {
                None => frame.dispatch("down values", down_values),
                Some(&(_, fine)) => frame
                    .dispatch("down values", down_level)
                    .texture("fine_value", fine),
            };
            let (dispatch, next) = dispatch.write("next_value", next);
            dispatch.over(size)?;
            levels.push((size, next));
            if size == [1, 1] {
                break;
            }
        }
        let Some((_, mut coarse)) = levels.pop() else {
            return Ok(());
        };
        while let Some((size, fine)) = levels.pop() {
            let next = frame.transient("value filled", Rgba32Float, size);
            let (dispatch, next) = frame
                .dispatch("up values", up_level)
                .texture("fine_value", fine)
                .texture("coarse_value", coarse)
                .write("next_value", next);
            dispatch.over(size)?;
            coarse = next;
        }
        frame
            .dispatch("fill values", fill)
            .texture("coarse_value", coarse)
            .over(full)
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
