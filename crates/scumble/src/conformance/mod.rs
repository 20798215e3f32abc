//! What every pass must keep, checked on synthetic inputs. Open to passes of other crates:
//!
//! ```no_run
//! # fn demo(device: wgpu::Device, queue: wgpu::Queue, registry: scumble::Registry) {
//! use scumble::conformance::{Fixture, check};
//!
//! let mut fixture = Fixture::new(&device, &queue);
//! let report = check(&registry, "my-filter", &mut fixture);
//! assert!(report.passed(), "{report}");
//! # }
//! ```

mod images;
mod rules;
mod run;

use std::fmt;
use std::sync::Arc;

use crate::frame_input::FrameInput;
use crate::host::Host;
use crate::port::Port;
use crate::registry::{PassType, Registry};

/// What passes are checked with.
pub struct Fixture {
    /// Where they run.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What the host lends; a pass that needs more is not run.
    pub host: Host,
    /// What each frame is told; its number counts up.
    pub input: FrameInput,
    /// Image sizes to run at.
    pub sizes: Vec<[u32; 2]>,
}

impl Fixture {
    /// A host that lends nothing, a still camera, and sizes from one pixel to 64 x 64, odd ones among them.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Fixture {
        Fixture {
            device: device.clone(),
            queue: queue.clone(),
            host: Host::new(),
            input: FrameInput::default(),
            sizes: vec![[1, 1], [1, 9], [7, 5], [33, 17], [64, 64]],
        }
    }
}

/// What must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// README, purpose, and a line for every port and parameter.
    Documented,
    /// The defaults obey their own ranges.
    Defaults,
    /// Bypasses name ports that exist, and aliases join ports of one signal and resolution.
    BypassDeclared,
    /// It builds with its defaults.
    Builds,
    /// It runs at every size, with and without its optional inputs; all numbers it writes are finite.
    Sizes,
    /// All numbers are finite where only sky is.
    Sky,
    /// All numbers are finite where no sample is.
    Holes,
    /// A texel that is NaN or infinite makes no other texel so.
    BadTexel,
    /// A constant image stays: for outputs that a bypass says to be a filtered input, that tell of light and not of
    /// samples or surfaces, and that are not declared to alter it ([`Port::alters`](crate::Port::alters)).
    Constant,
    /// A bypassed pass gives what its bypass declares.
    Bypass,
    /// Two runs give the same bits.
    SameBits,
}

/// How a rule went.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It holds.
    Passed,
    /// It does not apply, and why.
    Skipped(String),
    /// It does not hold: each counterexample.
    Failed(Vec<String>),
}

/// How a pass did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// The pass.
    pub pass: String,
    /// Each rule, in the order of [`Rule`].
    pub rules: Vec<(Rule, Outcome)>,
}

impl Report {
    /// Whether no rule failed.
    pub fn passed(&self) -> bool {
        !self
            .rules
            .iter()
            .any(|(_, outcome)| matches!(outcome, Outcome::Failed(_)))
    }

    /// How one rule went.
    pub fn outcome(&self, rule: Rule) -> Option<&Outcome> {
        self.rules
            .iter()
            .find(|(r, _)| *r == rule)
            .map(|(_, outcome)| outcome)
    }
}

impl Report {
    fn add(&mut self, rule: Rule, failures: Vec<String>) {
        let outcome = if failures.is_empty() {
            Outcome::Passed
        } else {
            Outcome::Failed(failures)
        };
        self.rules.push((rule, outcome));
    }

    fn skip(&mut self, rule: Rule, why: &str) {
        self.rules.push((rule, Outcome::Skipped(why.to_owned())));
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.pass)?;
        for (rule, outcome) in &self.rules {
            match outcome {
                Outcome::Passed => write!(f, "\n  ok      {rule:?}")?,
                Outcome::Skipped(why) => write!(f, "\n  skipped {rule:?}: {why}")?,
                Outcome::Failed(all) => {
                    for failure in all {
                        write!(f, "\n  FAILED  {rule:?}: {failure}")?;
                    }
                }
            }
        }
        Ok(())
    }
}

/// Checks one pass of a registry with its default parameters.
pub fn check(registry: &Registry, pass: &str, fixture: &mut Fixture) -> Report {
    if let Some(ty) = registry.get(pass) {
        return check_type(registry, ty, fixture);
    }
    let hint = crate::diagnostics::hint(pass, registry.iter().map(|ty| ty.name.as_str()));
    let failures = vec![format!("there is no pass `{pass}`{hint}")];
    Report {
        pass: pass.to_owned(),
        rules: vec![(Rule::Builds, Outcome::Failed(failures))],
    }
}

/// The same for a pass that need not be in the registry, such as a WGSL file; the registry lends signals and modules.
pub fn check_type(registry: &Registry, ty: &Arc<PassType>, fixture: &mut Fixture) -> Report {
    let mut report = Report {
        pass: ty.name.clone(),
        rules: Vec::new(),
    };
    let undeclared = !rules::bypass_declared(ty).is_empty();
    report.add(Rule::Documented, rules::documented(ty));
    report.add(Rule::Defaults, rules::defaults(ty));
    report.add(Rule::BypassDeclared, rules::bypass_declared(ty));
    let needs = ty.needs(&ty.defaults);
    if let Some(name) = needs.host.iter().find(|name| !fixture.host.has(name)) {
        report.skip(Rule::Builds, &format!("the fixture lends no {name}"));
        return report;
    }
    let mut bench = run::Bench::new(registry, ty.clone(), fixture);
    let broken = bench.builds();
    let stop = !broken.is_empty();
    report.add(Rule::Builds, broken);
    if stop {
        return report;
    }
    report.add(Rule::Sizes, bench.sizes());
    if ty.inputs.is_empty() {
        for rule in [Rule::Sky, Rule::Holes, Rule::BadTexel] {
            report.skip(rule, "it has no inputs");
        }
    } else {
        report.add(Rule::Sky, bench.finite(images::Content::Sky));
        report.add(Rule::Holes, bench.finite(images::Content::Holes));
        report.add(Rule::BadTexel, bench.bad_texel());
    }
    if ty.bypass.is_empty() || undeclared {
        for rule in [Rule::Constant, Rule::Bypass] {
            report.skip(rule, "no bypass says that an output is a filtered input");
        }
    } else {
        let altered = |port: &Port| !run::is_filtered(ty, port) || port.alters;
        match ty.outputs.iter().all(altered) {
            true => report.skip(
                Rule::Constant,
                "its outputs are declared to alter what comes in",
            ),
            false => report.add(Rule::Constant, bench.constant()),
        }
        report.add(Rule::Bypass, bench.bypass());
    }
    report.add(Rule::SameBits, bench.same_bits());
    report
}
