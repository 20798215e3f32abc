//! The conformance suite finds what is wrong, and nothing where all is right.

use framegraph::ComputeKernel;
use scumble::conformance::{Fixture, Outcome, Rule, check};
use scumble::{
    BuildContext, BuildError, Bypass, Needs, Pass, PassFrame, Port, RecordError, Registry, signal,
};

use crate::rig::gpu;
use crate::toys::registry;

scumble::params! {
    /// What `bad` can be told.
    pub struct BadParams {
        /// Out of its own range.
        pub gain: f32 = 2.0, in 0.0..=1.0;
    }
}

/// Brightens by a sum over all texels of a row, divides by depth, and says nothing about itself.
struct Bad(ComputeKernel);

const BAD: &str = "
@group(0) @binding(0) var value: texture_2d<f32>;
@group(0) @binding(1) var view_z: texture_2d<f32>;
@group(0) @binding(2) var out_value: texture_storage_2d<{{value.format}}, write>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    var sum = vec4f(0.0);
    for (var x = 0u; x < textureDimensions(value).x; x++) { sum += textureLoad(value, vec2u(x, id.y), 0); }
    let z = textureLoad(view_z, id.xy, 0).r;
    textureStore(out_value, id.xy, sum / (z + 1.0));
}";

impl Pass for Bad {
    type Params = BadParams;
    const NAME: &'static str = "bad";
    const ABOUT: &'static str = "";
    const README: &'static str = "";

    fn inputs() -> Vec<Port> {
        vec![
            Port::any("value"),
            Port::new("view_z", signal::VIEW_Z)
                .any_resolution()
                .about("depth"),
        ]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::any("value").full().about("brighter")]
    }

    fn bypass() -> Vec<Bypass> {
        vec![Bypass::alias("value", "value")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &BadParams) -> Result<Self, BuildError> {
        Ok(Bad(ctx.kernel("bad.wgsl", BAD, "main")?))
    }

    fn record(&mut self, _p: &BadParams, frame: &mut PassFrame<'_, '_>) -> Result<(), RecordError> {
        let size = frame.full_size();
        frame.dispatch("bad", &self.0).over(size)
    }
}

/// Needs what the fixture lends not.
struct Lonely;

impl Pass for Lonely {
    type Params = scumble::NoParams;
    const NAME: &'static str = "lonely";
    const ABOUT: &'static str = "Needs a moon";
    const README: &'static str = "nothing";

    fn inputs() -> Vec<Port> {
        Vec::new()
    }

    fn outputs() -> Vec<Port> {
        Vec::new()
    }

    fn needs(_p: &scumble::NoParams) -> Needs {
        Needs::default().with_host("Moon")
    }

    fn build(_ctx: &BuildContext<'_>, _p: &scumble::NoParams) -> Result<Self, BuildError> {
        Ok(Lonely)
    }

    fn record(
        &mut self,
        _p: &scumble::NoParams,
        _frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        Ok(())
    }
}

#[test]
fn right_passes_pass() {
    let Some((device, queue)) = gpu() else { return };
    let mut fixture = Fixture::new(device, queue);
    fixture.sizes = vec![[1, 1], [7, 5]];
    for (pass, spreads) in [
        ("ramp", false),
        ("down", false),
        ("up", false),
        ("mean", false),
        ("blur", true),
    ] {
        let report = check(&registry(), pass, &mut fixture);
        // A plain box filter does spread a bad texel, and nothing else is wrong with it.
        let failed: Vec<_> = report
            .rules
            .iter()
            .filter(|(_, o)| matches!(o, Outcome::Failed(_)))
            .map(|(rule, _)| *rule)
            .collect();
        assert_eq!(
            failed,
            if spreads {
                vec![Rule::BadTexel]
            } else {
                vec![]
            },
            "{report}"
        );
        assert_eq!(report.passed(), !spreads);
    }
}

#[test]
fn what_is_wrong_is_found() {
    let Some((device, queue)) = gpu() else { return };
    let mut registry = Registry::new();
    registry.add::<Bad>().add::<Lonely>();
    let mut fixture = Fixture::new(device, queue);
    fixture.sizes = vec![[1, 1], [7, 5]];
    let report = check(&registry, "bad", &mut fixture);
    let failures = |rule| match report.outcome(rule) {
        Some(Outcome::Failed(all)) => all.join("\n"),
        other => panic!("{rule:?}: {other:?}\n{report}"),
    };
    assert_eq!(failures(Rule::Documented).lines().count(), 3, "{report}");
    assert!(failures(Rule::Defaults).contains("`gain` must be from 0 to 1"));
    assert!(failures(Rule::BypassDeclared).contains("which has another resolution"));
    // 0 / (-1 + 1)
    assert!(failures(Rule::Holes).contains("`value` holds"));
    assert!(failures(Rule::BadTexel).contains("one texel of `value` is inf"));
    assert_eq!(report.outcome(Rule::Sizes), Some(&Outcome::Passed));
    assert_eq!(report.outcome(Rule::SameBits), Some(&Outcome::Passed));

    let report = check(&registry, "lonely", &mut fixture);
    assert_eq!(
        report.outcome(Rule::Builds),
        Some(&Outcome::Skipped("the fixture lends no Moon".to_owned()))
    );
    let report = check(&registry, "lonly", &mut fixture);
    assert!(
        report
            .to_string()
            .contains("there is no pass `lonly`; did you mean `lonely`?"),
        "{report}"
    );
}
