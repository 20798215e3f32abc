//! Small passes whose results can be worked out by hand.

use framegraph::{ComputeKernel, First};
use scumble::{
    BuildContext, BuildError, Bypass, Filter, FirstFrame, NoParams, Pass, PassFrame, Port,
    RecordError, Registry, Stat, signal,
};

/// Every pass below.
pub fn registry() -> Registry {
    let mut registry = Registry::new();
    registry
        .add::<Ramp>()
        .add::<Blur>()
        .add::<Past<0>>()
        .add::<Past<1>>()
        .add::<Past<2>>()
        .add::<Down>()
        .add::<Up>();
    registry.add::<Mean>().add::<Delay>().add::<Gate>();
    registry
}

scumble::params! {
    /// What `ramp` can be told.
    pub struct RampParams {
        /// Factor.
        pub gain: f32 = 1.0, in 0.0..=1000.0;
        /// A turn that the shader gets in radians.
        pub angle: f32 = 0.0, in 0.0..=360.0, unit "deg";
        /// Rebuilds.
        #[structural] pub steps: u32 = 1, in 1..=8;
    }
}

/// Writes (gain (x + 100 y), angle, frame, steps), and a mask on request.
pub struct Ramp {
    kernel: ComputeKernel,
    built: std::sync::Arc<std::sync::atomic::AtomicU32>,
}

/// How often a ramp was built; lent by the host.
#[derive(Default)]
pub struct Builds(pub std::sync::Arc<std::sync::atomic::AtomicU32>);

const RAMP: &str = "
#include \"scumble/conventions.wgsl\"
struct Params { steps: u32, gain: f32, angle: f32, frame_index: u32, wants_mask: u32 }
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var out_value: texture_storage_2d<{{value.format}}, write>;
@group(0) @binding(2) var out_mask: texture_storage_2d<r32uint, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let v = params.gain * (f32(id.x) + 100.0 * f32(id.y));
    textureStore(out_value, id.xy, vec4f(v, params.angle, f32(params.frame_index), f32(params.steps)));
    if params.wants_mask != 0u { textureStore(out_mask, id.xy, vec4u(7u)); }
}";

impl Pass for Ramp {
    type Params = RampParams;
    const NAME: &'static str = "ramp";
    const ABOUT: &'static str = "A ramp";
    const README: &'static str = "v = gain (x + 100 y)";

    fn inputs() -> Vec<Port> {
        Vec::new()
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::new("value", signal::RADIANCE).about("the ramp"),
            Port::new("mask", signal::MASK).optional().about("sevens"),
        ]
    }

    fn build(ctx: &BuildContext<'_>, _p: &RampParams) -> Result<Self, BuildError> {
        let built = ctx
            .host::<Builds>()
            .map(|builds| builds.0.clone())
            .unwrap_or_default();
        built.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        Ok(Ramp {
            kernel: ctx.kernel("ramp.wgsl", RAMP, "main")?,
            built,
        })
    }

    fn record(
        &mut self,
        _p: &RampParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let built = self.built.load(std::sync::atomic::Ordering::Relaxed);
        frame.report("built", Stat::Number(f64::from(built)));
        let size = frame.full_size();
        frame.dispatch("ramp", &self.kernel).over(size)
    }
}

/// Mean of the 3x3 texels around each; a tap outside is not counted.
pub struct Blur(ComputeKernel);

const BLUR: &str = "
struct Params { has_weight: u32 }
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var weight: texture_2d<f32>;
@group(0) @binding(3) var out_value: texture_storage_2d<{{value.format}}, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(value));
    var sum = vec4f(0.0);
    for (var y = -1; y <= 1; y++) { for (var x = -1; x <= 1; x++) {
        let p = vec2i(id.xy) + vec2i(x, y);
        if all(p >= vec2i(0)) && all(p < size) { sum += vec4f(textureLoad(value, p, 0).rgb, 1.0); }
    } }
    let weight = select(1.0, textureLoad(weight, id.xy, 0).r, params.has_weight != 0u);
    textureStore(out_value, id.xy, vec4f(mix(textureLoad(value, id.xy, 0).rgb, sum.rgb / sum.a, weight), 1.0));
}";

impl Pass for Blur {
    type Params = NoParams;
    const NAME: &'static str = "blur";
    const ABOUT: &'static str = "Box filter";
    const README: &'static str = "mean over 3x3";

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value").about("what is blurred"),
            Port::new("weight", signal::VARIANCE)
                .any_resolution()
                .optional()
                .about("how much"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").about("blurred")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        Ok(Blur(ctx.kernel("blur.wgsl", BLUR, "main")?))
    }

    fn record(&mut self, _p: &NoParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        frame.dispatch("blur", &self.0).over(size)
    }
}

/// The sum of a value and last frame's sum, whose first rule is Clear(5), Skip (counts as 1000) or Copy(value).
pub struct Past<const RULE: u32>(ComputeKernel);

const PAST: &str = "
struct Params { has_past: u32 }
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var past: texture_2d<f32>;
@group(0) @binding(3) var out_value: texture_storage_2d<{{value.format}}, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let before = select(vec4f(1000.0), textureLoad(past, id.xy, 0), params.has_past != 0u);
    textureStore(out_value, id.xy, textureLoad(value, id.xy, 0) + before);
}";

impl<const RULE: u32> Pass for Past<RULE> {
    type Params = NoParams;
    const NAME: &'static str = ["past-clear", "past-skip", "past-copy"][RULE as usize];
    const ABOUT: &'static str = "Running sum";
    const README: &'static str = "s = v + s@prev";

    fn inputs() -> Vec<Port> {
        let rule = [
            FirstFrame::Clear([5.0; 4]),
            FirstFrame::Skip,
            FirstFrame::Copy("value"),
        ][RULE as usize];
        vec![
            Port::any("value").about("added"),
            Port::any("past").first(rule).about("the sum before"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").precise_if_kept().about("the sum")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        Ok(Past(ctx.kernel("past.wgsl", PAST, "main")?))
    }

    fn record(&mut self, _p: &NoParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        frame.dispatch("past", &self.0).over(size)
    }
}

scumble::params! {
    /// What `down` can be told.
    pub struct DownParams {
        /// Pixels per texel.
        #[structural] pub spacing: u32 = 4, in 1..=64, unit "px";
    }
}

/// Takes the traced pixel of each grid cell.
pub struct Down(ComputeKernel);

const DOWN: &str = "
struct Params { spacing: u32, full_size: vec2u }
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var out_value: texture_storage_2d<{{value.format}}, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = min(id.xy * params.spacing + params.spacing / 2u, params.full_size - 1u);
    textureStore(out_value, id.xy, textureLoad(value, p, 0));
}";

impl Pass for Down {
    type Params = DownParams;
    const NAME: &'static str = "down";
    const ABOUT: &'static str = "Full resolution to a grid";
    const README: &'static str = "v[i] = v(min(i n + n/2, size - 1))";

    fn inputs() -> Vec<Port> {
        vec![Port::any("value").full().about("at full resolution")]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").grid().about("at traced pixels")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::resample("value", "value", Filter::Nearest)]
    }

    fn grid(p: &DownParams) -> Option<u32> {
        Some(p.spacing)
    }

    fn build(ctx: &BuildContext<'_>, _p: &DownParams) -> Result<Self, BuildError> {
        Ok(Down(ctx.kernel("down.wgsl", DOWN, "main")?))
    }

    fn record(
        &mut self,
        _p: &DownParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let size = frame.size_of("grid value");
        assert_eq!(
            size,
            frame.full_size(),
            "a name that is no port has the full size"
        );
        let output = frame.output("value");
        let size = frame.graph().texture_size(output);
        frame.dispatch("down", &self.0).over(size)
    }
}

/// Repeats each grid texel over its cell.
pub struct Up(ComputeKernel);

const UP: &str = "
struct Params { spacing: u32 }
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var out_value: texture_storage_2d<{{value.format}}, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    textureStore(out_value, id.xy, textureLoad(value, id.xy / params.spacing, 0));
}";

impl Pass for Up {
    type Params = NoParams;
    const NAME: &'static str = "up";
    const ABOUT: &'static str = "A grid to full resolution";
    const README: &'static str = "v(p) = v[p / n]";

    fn inputs() -> Vec<Port> {
        vec![Port::any("value").grid().about("on a grid")]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").full().about("at full resolution")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::resample("value", "value", Filter::Linear)]
    }

    fn build(ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        Ok(Up(ctx.kernel("up.wgsl", UP, "main")?))
    }

    fn record(&mut self, _p: &NoParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.full_size();
        frame.dispatch("up", &self.0).over(size)
    }
}

/// Running mean that restarts when something upstream changes: rgb the sum, a the count.
pub struct Mean {
    kernel: ComputeKernel,
    revision: Option<u64>,
}

pub const MEAN: &str = "
@group(0) @binding(0) var value: texture_2d<f32>;
@group(0) @binding(1) var before: texture_2d<f32>;
@group(0) @binding(2) var out_value: texture_storage_2d<{{value.format}}, write>;
@group(0) @binding(3) var after: texture_storage_2d<rgba32float, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let sum = textureLoad(before, id.xy, 0) + vec4f(textureLoad(value, id.xy, 0).rgb, 1.0);
    textureStore(after, id.xy, sum);
    textureStore(out_value, id.xy, vec4f(sum.rgb / sum.a, sum.a));
}";

impl Pass for Mean {
    type Params = NoParams;
    const NAME: &'static str = "mean";
    const ABOUT: &'static str = "Running mean";
    const README: &'static str = "mean over frames";

    fn inputs() -> Vec<Port> {
        vec![Port::any("value").about("one sample")]
    }

    fn outputs() -> Vec<Port> {
        vec![
            Port::any("value")
                .precise()
                .about("the mean; a is the count"),
        ]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        Ok(Mean {
            kernel: ctx.kernel("mean.wgsl", MEAN, "main")?,
            revision: None,
        })
    }

    fn record(&mut self, _p: &NoParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let upstream = frame.upstream();
        if self.revision.replace(upstream.revision) != Some(upstream.revision) {
            let reason = upstream
                .changed
                .clone()
                .unwrap_or_else(|| "first frame".to_owned());
            frame.reset_history("sum", &reason);
            frame.report("restarted", Stat::Text(reason));
        }
        let size = frame.size_of("value");
        let sum = frame.history(
            "sum",
            wgpu::TextureFormat::Rgba32Float,
            size,
            First::Clear([0.0; 4]),
        );
        let before = sum.previous[0].ok_or_else(|| RecordError::Failed("no past".to_owned()))?;
        let dispatch = frame
            .dispatch("mean", &self.kernel)
            .texture("before", before);
        dispatch.write("after", sum.current).0.over(size)
    }
}

/// Last frame's value, forgotten on a cut of time; the value is kept in a node of its own.
pub struct Delay {
    keep: ComputeKernel,
    show: ComputeKernel,
    time: f32,
}

const DELAY: &str = "
@group(0) @binding(0) var value: texture_2d<f32>;
@group(0) @binding(1) var kept: texture_2d<f32>;
@group(0) @binding(2) var out_value: texture_storage_2d<{{value.format}}, write>;
@group(0) @binding(3) var next: texture_storage_2d<rgba32float, write>;
@compute @workgroup_size(8, 8)
fn keep(@builtin(global_invocation_id) id: vec3u) {
    textureStore(next, id.xy, textureLoad(value, id.xy, 0));
}
@compute @workgroup_size(8, 8)
fn show(@builtin(global_invocation_id) id: vec3u) {
    textureStore(out_value, id.xy, textureLoad(kept, id.xy, 0));
}";

impl Pass for Delay {
    type Params = NoParams;
    const NAME: &'static str = "delay";
    const ABOUT: &'static str = "Last frame's value";
    const README: &'static str = "v@prev";

    fn inputs() -> Vec<Port> {
        vec![Port::any("value").about("now")]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").about("then")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        let kernel = |entry| ctx.kernel("delay.wgsl", DELAY, entry);
        Ok(Delay {
            keep: kernel("keep")?,
            show: kernel("show")?,
            time: 0.0,
        })
    }

    fn record(&mut self, _p: &NoParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.size_of("value");
        let time = frame.input_frame().time;
        if time != self.time {
            self.time = time;
            frame.reset_history("kept", "the time changed");
        }
        let kept = frame.history(
            "kept",
            wgpu::TextureFormat::Rgba32Float,
            size,
            First::Clear([-1.0; 4]),
        );
        let before = kept.previous[0].ok_or_else(|| RecordError::Failed("no past".to_owned()))?;
        frame
            .dispatch("show", &self.show)
            .texture("kept", before)
            .over(size)?;
        frame
            .dispatch("keep", &self.keep)
            .write("next", kept.current)
            .0
            .over(size)
    }
}

scumble::params! {
    /// What `gate` can be told.
    pub struct GateParams {
        /// Which mistake to make.
        #[structural] pub mistake: u32 = 0, in 0..=20;
    }
}

/// Makes one of many mistakes.
pub struct Gate(ComputeKernel);

impl Pass for Gate {
    type Params = GateParams;
    const NAME: &'static str = "gate";
    const ABOUT: &'static str = "Makes mistakes";
    const README: &'static str = "none";

    fn inputs() -> Vec<Port> {
        vec![Port::any("value").about("anything")]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").about("the same")]
    }

    fn build(ctx: &BuildContext<'_>, p: &GateParams) -> Result<Self, BuildError> {
        let good = "
struct Params { mistake: u32, factor: f32 }
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var out_value: texture_storage_2d<{{value.format}}, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    textureStore(out_value, id.xy, params.factor * f32(params.mistake) * textureLoad(value, id.xy, 0));
}";
        let text = match p.mistake {
            1 => good.replace("params.factor", "params.fctor"),
            2 => good
                .replace("{ mistake: u32", "{ mistake: f32")
                .replace("f32(params.mistake)", "params.mistake"),
            3 => good.replace("{{value.format}}", "rgba8unorm"),
            4 => good.replace("texture_2d<f32>", "texture_2d<u32>").replace(
                "textureLoad(value, id.xy, 0)",
                "vec4f(textureLoad(value, id.xy, 0))",
            ),
            5 => good.replace("main(", "start("),
            6 => format!("#include \"scumble/conventons.wgsl\"\n{good}"),
            7 => good.replace("factor", "mistak"),
            8 => good
                .replace("value: texture_2d<f32>", "valu: texture_2d<f32>")
                .replace("textureLoad(value", "textureLoad(valu"),
            _ => good.to_owned(),
        };
        Ok(Gate(ctx.kernel("gate/gate.wgsl", &text, "main")?))
    }

    fn record(&mut self, p: &GateParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.full_size();
        match p.mistake {
            9 => frame.dispatch("gate", &self.0).set("facto", 1.0).over(size),
            10 => frame
                .dispatch("gate", &self.0)
                .set("factor", 1u32)
                .over(size),
            11 => {
                frame.input("vlue");
                frame
                    .dispatch("gate", &self.0)
                    .set("factor", 1.0)
                    .over(size)
            }
            12 => Ok(()),
            13 => {
                let value = frame.output("value");
                frame
                    .dispatch("gate", &self.0)
                    .set("factor", 1.0)
                    .texture("value", value)
                    .over(size)
            }
            7 | 14 => frame.dispatch("gate", &self.0).over(size),
            _ => frame
                .dispatch("gate", &self.0)
                .set("factor", 1.0)
                .over(size),
        }
    }
}
