//! What a graph needs, known before a device exists.

use super::error::{PipelineError, Unmet};
use crate::host::Host;
use crate::pass::Needs;
use crate::resolve::Resolved;

/// What a graph needs from the device and the host.
#[derive(Clone, Debug)]
pub struct Requirements {
    /// Every feature that some pass needs.
    pub features: wgpu::Features,
    /// The least limits that suit every pass.
    pub limits: wgpu::Limits,
    /// Names of what the host must lend.
    pub host: Vec<&'static str>,
    /// What each pass needs, by its name in the graph.
    pub passes: Vec<(String, Needs)>,
}

impl Requirements {
    /// What the passes of a graph need; bypassed ones need nothing.
    pub fn of(resolved: &Resolved) -> Requirements {
        let running = resolved.passes.iter().filter(|pass| !pass.bypassed);
        let passes: Vec<_> = running
            .map(|pass| (pass.name.clone(), pass.ty.needs(&pass.params)))
            .collect();
        let mut all = Requirements {
            features: wgpu::Features::empty(),
            limits: Needs::default().limits,
            host: Vec::new(),
            passes: Vec::new(),
        };
        for (_, needs) in &passes {
            all.features |= needs.features;
            all.limits = all.limits.or_better_values_from(&needs.limits);
            all.host.extend(&needs.host);
        }
        all.host.sort_unstable();
        all.host.dedup();
        all.passes = passes;
        all
    }

    /// Whether an adapter can run every pass.
    ///
    /// # Errors
    /// [`PipelineError::Requirements`] with each pass that cannot run and what it lacks.
    pub fn check_adapter(&self, adapter: &wgpu::Adapter) -> Result<(), PipelineError> {
        self.check(adapter.features(), &adapter.limits())
    }

    pub(super) fn check(
        &self,
        features: wgpu::Features,
        limits: &wgpu::Limits,
    ) -> Result<(), PipelineError> {
        let mut unmet = Vec::new();
        for (pass, needs) in &self.passes {
            let mut add = |what| {
                unmet.push(Unmet {
                    pass: pass.clone(),
                    what,
                })
            };
            let missing = needs.features - features;
            if !missing.is_empty() {
                let names: Vec<_> = missing.iter_names().map(|(name, _)| name).collect();
                add(format!("this device has no {}", names.join(", ")));
            }
            needs
                .limits
                .check_limits_with_fail_fn(limits, false, |name, needed, there| {
                    add(format!(
                        "it needs {name} {needed}, and this device has {there}"
                    ));
                });
        }
        if unmet.is_empty() {
            Ok(())
        } else {
            Err(PipelineError::Requirements(unmet))
        }
    }

    pub(super) fn check_host(&self, host: &Host) -> Result<(), PipelineError> {
        let mut unmet = Vec::new();
        for (pass, needs) in &self.passes {
            for name in needs.host.iter().filter(|name| !host.has(name)) {
                unmet.push(Unmet {
                    pass: pass.clone(),
                    what: format!("it needs a {name}, and the host lends none"),
                });
            }
        }
        if unmet.is_empty() {
            Ok(())
        } else {
            Err(PipelineError::Requirements(unmet))
        }
    }
}
