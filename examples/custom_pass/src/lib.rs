#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

use scumble::{
    BuildContext, BuildError, Bypass, Pass, PassFrame, Port, RecordError, Registry, Signal,
    SignalDef, signal,
};

/// What [`CONDUCTION`] is.
static CONDUCTION_DEF: SignalDef = SignalDef {
    name: "conduction",
    format: wgpu::TextureFormat::R32Float,
    convention: "how freely light flows between a texel and its neighbours: 1 where it is flat, 0 at an edge",
};

/// A signal that Scumble does not have: graphs can name it, and wires between it and others are refused.
pub const CONDUCTION: Signal = Signal::new(&CONDUCTION_DEF);

scumble::params! {
    /// What `diffusion` can be told.
    pub struct DiffusionParams {
        /// How often light flows.
        pub iterations: u32 = 4, in 1..=64;
        /// How much of the difference flows at once.
        pub lambda: f32 = 0.2, in 0.0..=0.25;
        /// The contrast above which an edge is kept, as a part of the luminance around it.
        pub kappa: f32 = 0.1, in 0.001..=10.0;
    }
}

/// The pass; see the crate.
pub struct Diffusion {
    kernel: framegraph::ComputeKernel,
}

impl Pass for Diffusion {
    type Params = DiffusionParams;
    const NAME: &'static str = "diffusion";
    const ABOUT: &'static str = "Smooths what is nearly flat and keeps edges";
    const README: &'static str = include_str!("../README.md");

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value").about("what is smoothed"),
            Port::new("view_z", signal::VIEW_Z)
                .any_resolution()
                .about("where there is a surface"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::any("value").about("smoothed"),
            Port::new("conduction", CONDUCTION)
                .any_resolution()
                .optional()
                .about("how flat it is"),
        ]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _: &DiffusionParams) -> Result<Self, BuildError> {
        let text = include_str!("diffusion.wgsl");
        let kernel = ctx.kernel("diffusion.wgsl", text, "main")?;
        Ok(Self { kernel })
    }

    fn record(
        &mut self,
        params: &DiffusionParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        let format = frame.output_format("value");
        let Some(mut value) = frame.input("value") else {
            return Err(RecordError::Failed("it has no value".into()));
        };
        for i in 1..=params.iterations {
            // The last one writes the outputs.
            let next = (i < params.iterations).then(|| {
                [
                    frame.transient("value", format, size),
                    frame.transient("conduction", CONDUCTION.format(), size),
                ]
            });
            let mut dispatch = frame.dispatch("flow", &self.kernel).texture("value", value);
            if let Some([next, conduction]) = next {
                (dispatch, value) = dispatch.write("out_value", next);
                (dispatch, _) = dispatch.write("out_conduction", conduction);
            }
            dispatch.over(size)?;
        }
        Ok(())
    }
}

/// Adds the pass and its signal to those of a registry.
pub fn register(registry: &mut Registry) {
    registry.add_signal(CONDUCTION).add::<Diffusion>();
}
