//! Passes that do nothing, with ports of every kind.

use scumble::{
    BuildContext, BuildError, Bypass, Filter, FirstFrame, NoParams, Pass, PassFrame, Port,
    RecordError, Registry, signal,
};

scumble::choice! {
    /// How.
    pub enum Mode {
        /// By distance.
        #[default]
        Near,
        /// By time.
        Fresh,
    }
}

scumble::params! {
    /// Of the sparse tracer.
    pub struct SparseParams {
        /// Pixels between traced pixels.
        #[structural]
        pub spacing: u32 = 16, in 1..=64, unit "px";
        /// Paths per pixel.
        #[budget]
        pub samples: u32 = 100, in 1..=65536, unit "spp";
        /// Opening of the cone.
        pub cone: f32 = 45.0, in 0.0..=90.0, unit "deg";
        /// How to choose.
        pub mode: Mode = Mode::Near;
        /// Colour of the light.
        pub tint: [f32; 3] = [1.0, 1.0, 1.0], in 0.0..=10.0;
        /// Whether to move the grid.
        pub jitter: bool = true;
        /// Offset of the grid.
        pub shift: i32 = 0, in -8..=8, unit "px";
    }
}

scumble::params! {
    /// Of the blur.
    pub struct BlurParams {
        /// Distance of the taps.
        pub radius: u32 = 2, in 1..=16, unit "px";
        /// Width of the kernel.
        pub sigma: f32 = 1.0, in 0.0..=100.0;
    }
}

macro_rules! toy {
    ($type:ident, $name:literal, $params:ty, [$($input:expr),*], [$($output:expr),*], [$($bypass:expr),*] $(, grid $grid:expr)?) => {
        struct $type;

        impl Pass for $type {
            type Params = $params;
            const NAME: &'static str = $name;
            const ABOUT: &'static str = "A toy.";
            const README: &'static str = "A toy.";

            fn inputs() -> Vec<Port> {
                vec![$($input),*]
            }

            fn outputs() -> Vec<Port> {
                vec![$($output),*]
            }

            fn bypass() -> Vec<Bypass> {
                vec![$($bypass),*]
            }

            $(fn grid(params: &$params) -> Option<u32> {
                let grid: fn(&$params) -> u32 = $grid;
                Some(grid(params))
            })?

            fn build(_: &BuildContext<'_>, _: &$params) -> Result<Self, BuildError> {
                Ok(Self)
            }

            fn record(&mut self, _: &$params, _: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
                Ok(())
            }
        }
    };
}

const NORMAL: Port = Port::new("normal", signal::NORMAL);
const VIEW_Z: Port = Port::new("view_z", signal::VIEW_Z);
const IRRADIANCE: Port = Port::new("irradiance", signal::IRRADIANCE);
const RADIANCE: Port = Port::new("radiance", signal::RADIANCE);
const ALBEDO: Port = Port::new("albedo", signal::ALBEDO);
const VALUE: Port = Port::any("value");

toy!(
    Gbuffer,
    "gbuffer",
    NoParams,
    [],
    [
        ALBEDO,
        NORMAL,
        VIEW_Z,
        Port::new("emission", signal::EMISSION)
    ],
    []
);
toy!(
    Trace,
    "trace",
    NoParams,
    [NORMAL, VIEW_Z, Port::new("seed", signal::SEED).optional()],
    [IRRADIANCE, RADIANCE],
    []
);
toy!(
    Sparse,
    "sparse",
    SparseParams,
    [NORMAL, VIEW_Z],
    [
        IRRADIANCE.grid(),
        Port::new("specular", signal::SPECULAR).grid(),
        NORMAL.grid(),
        VIEW_Z.grid()
    ],
    [],
    grid | params | params.spacing
);
toy!(
    Blur,
    "blur",
    BlurParams,
    [VALUE, NORMAL.any_resolution(), VIEW_Z.any_resolution()],
    [VALUE],
    [Bypass::alias("value", "value")]
);
toy!(
    Clamp,
    "clamp",
    NoParams,
    [VALUE],
    [VALUE],
    [Bypass::alias("value", "value")]
);
toy!(
    Up,
    "up",
    BlurParams,
    [
        VALUE.grid(),
        Port::new("grid_normal", signal::NORMAL)
            .grid()
            .source("normal"),
        NORMAL
    ],
    [VALUE.full(), Port::new("mask", signal::MASK).optional()],
    [Bypass::resample("value", "value", Filter::Linear)]
);
toy!(
    Add,
    "add",
    NoParams,
    [Port::any("a"), Port::any("b")],
    [VALUE],
    []
);
toy!(
    Accumulate,
    "accumulate",
    NoParams,
    [
        VALUE.full(),
        Port::any("history")
            .full()
            .first(FirstFrame::Copy("value"))
            .optional()
    ],
    [VALUE.full().precise()],
    []
);
toy!(
    Mix,
    "mix",
    NoParams,
    [RADIANCE.optional(), IRRADIANCE.optional(), ALBEDO],
    [RADIANCE],
    []
);
toy!(
    Tone,
    "tone",
    NoParams,
    [RADIANCE],
    [Port::new("color", signal::DISPLAY)],
    []
);

pub fn registry() -> Registry {
    let mut registry = Registry::new();
    registry
        .add::<Gbuffer>()
        .add::<Trace>()
        .add::<Sparse>()
        .add::<Blur>()
        .add::<Clamp>();
    registry
        .add::<Up>()
        .add::<Add>()
        .add::<Accumulate>()
        .add::<Mix>()
        .add::<Tone>();
    registry
}
