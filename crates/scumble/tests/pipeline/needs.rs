//! What passes need is asked for before anything runs, and what they count is read after.

use framegraph::ComputeKernel;
use scumble::{
    BuildContext, BuildError, Needs, NoParams, Pass, PassFrame, Pipeline, Port, RecordError,
    ReportValue, Stat, signal,
};

use crate::rig::{Rig, Row, gpu, graph};
use crate::toys::registry;

/// Needs more than any device has, and a moon.
struct Greedy;

impl Pass for Greedy {
    type Params = NoParams;
    const NAME: &'static str = "greedy";
    const ABOUT: &'static str = "Needs too much";
    const README: &'static str = "nothing";

    fn inputs() -> Vec<Port> {
        Vec::new()
    }

    fn outputs() -> Vec<Port> {
        vec![Port::new("value", signal::RADIANCE).about("nothing")]
    }

    fn needs(_p: &NoParams) -> Needs {
        let mut needs = Needs::default().with_host("Moon");
        needs.features = wgpu::Features::TEXTURE_COMPRESSION_ASTC_HDR;
        needs.limits.max_storage_textures_per_shader_stage = 100_000;
        needs
    }

    fn build(_ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        Ok(Greedy)
    }

    fn record(&mut self, _p: &NoParams, _frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        Ok(())
    }
}

/// Needs a moon only, and takes it for one of another type.
struct Moonlit;

impl Pass for Moonlit {
    type Params = NoParams;
    const NAME: &'static str = "moonlit";
    const ABOUT: &'static str = "Needs a moon";
    const README: &'static str = "nothing";

    fn inputs() -> Vec<Port> {
        Vec::new()
    }

    fn outputs() -> Vec<Port> {
        vec![Port::new("value", signal::RADIANCE).about("nothing")]
    }

    fn needs(_p: &NoParams) -> Needs {
        Needs::default().with_host("Moon")
    }

    fn build(ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        ctx.host::<u64>()?;
        Ok(Moonlit)
    }

    fn record(&mut self, _p: &NoParams, _frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        Ok(())
    }
}

/// Counts its threads.
struct Count(ComputeKernel);

const COUNT: &str = "
@group(0) @binding(0) var<storage, read_write> counter: atomic<u32>;
@group(0) @binding(1) var out_value: texture_storage_2d<{{value.format}}, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(out_value)) { return; }
    atomicAdd(&counter, 1u);
    textureStore(out_value, id.xy, vec4f(0.0));
}";

impl Pass for Count {
    type Params = NoParams;
    const NAME: &'static str = "count";
    const ABOUT: &'static str = "Counts pixels";
    const README: &'static str = "n = width height";

    fn inputs() -> Vec<Port> {
        Vec::new()
    }

    fn outputs() -> Vec<Port> {
        vec![Port::new("value", signal::RADIANCE).about("zeros")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &NoParams) -> Result<Self, BuildError> {
        Ok(Count(ctx.kernel("count.wgsl", COUNT, "main")?))
    }

    fn record(&mut self, _p: &NoParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let (size, label) = (frame.full_size(), frame.label("counter"));
        let counter = frame.graph().buffer(label.clone(), 4);
        let counter = frame.graph().fill_buffer(label, counter, 0);
        let (dispatch, counter) = frame
            .dispatch("count", &self.0)
            .modify_buffer("counter", counter);
        dispatch.over(size)?;
        frame.report("pixels", Stat::Buffer(counter));
        Ok(())
    }
}

#[test]
fn an_adapter_that_cannot_run_a_pass_is_told_which_and_why() {
    let Some((device, queue)) = gpu() else { return };
    let mut registry = registry();
    registry.add::<Greedy>();
    let resolved = graph(&registry, &[("g", "greedy", &[])], &[("out", "g.value")]);
    let requirements = Pipeline::requirements(&resolved);
    assert_eq!(requirements.host, ["Moon"]);
    assert_eq!(
        requirements.limits.max_storage_textures_per_shader_stage,
        100_000
    );
    let host = scumble::Host::new();
    let error = Pipeline::new(device, queue, &registry, resolved, &host, [4, 4]).unwrap_err();
    let there = device.limits().max_storage_textures_per_shader_stage;
    let expected = format!(
        "pass `g` cannot run: this device has no TEXTURE_COMPRESSION_ASTC_HDR\n\
         pass `g` cannot run: it needs max_storage_textures_per_shader_stage 100000, and this device has {there}"
    );
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_host_that_lacks_something_is_told_what() {
    let Some((device, queue)) = gpu() else { return };
    let mut registry = registry();
    registry.add::<Moonlit>();
    let message = |host: &scumble::Host| {
        let resolved = graph(&registry, &[("m", "moonlit", &[])], &[("out", "m.value")]);
        Pipeline::new(device, queue, &registry, resolved, host, [4, 4])
            .unwrap_err()
            .to_string()
    };
    let mut host = scumble::Host::new();
    assert_eq!(
        message(&host),
        "pass `m` cannot run: it needs a Moon, and the host lends none"
    );
    host.insert("Moon", "of another type");
    assert_eq!(message(&host), "pass `m` (moonlit): the host lends no u64");
}

#[test]
fn counters_are_read_after_the_frame() {
    let Some(_) = gpu() else { return };
    let mut registry = registry();
    registry.add::<Count>();
    let rows: &[Row] = &[("n", "count", &[])];
    let mut rig = Rig::try_new(
        &registry,
        graph(&registry, rows, &[("out", "n.value")]),
        [13, 7],
    )
    .unwrap();
    for frame in 0..2 {
        rig.frame(frame, "out");
        let reports = rig.pipeline.reports().unwrap();
        assert_eq!((reports[0].pass.as_str(), reports[0].key), ("n", "pixels"));
        assert_eq!(reports[0].value, ReportValue::Number(91.0), "frame {frame}");
    }
}
