//! What a pipeline tells about its last frame: time, memory, what passes report, the plan.

use framegraph::{Label, Memory};

use super::Pipeline;
use crate::pass_frame::Stat;

/// Something a pass told about the last frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The pass, by its name in the graph.
    pub pass: String,
    /// What it is about, such as `rays`.
    pub key: &'static str,
    /// The value.
    pub value: ReportValue,
}

/// The value of a [`Report`].
#[derive(Clone, Debug, PartialEq)]
pub enum ReportValue {
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
}

/// A texture that is kept across frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct History {
    /// `pass.port` or `pass/name`.
    pub name: String,
    /// Number of the frame in which it last started anew.
    pub since: u64,
    /// Why it did.
    pub reason: String,
}

/// Why the GPU's numbers cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot read back from the GPU: {0}")]
pub struct StatsError(pub String);

pub(super) fn report_key(pass: &str, key: &str) -> Label {
    Label::from(format!("report {pass} {key}"))
}

impl Pipeline {
    /// GPU milliseconds of each pass in the last frame, in the order of the graph, once
    /// `debug().timestamps` is on. Waits for the GPU; call it after submitting. Nodes that belong to no pass count as `other`.
    pub fn timings(&mut self) -> Vec<(String, f64)> {
        let names = self.passes.iter().map(|built| built.info.name.clone());
        let mut times: Vec<(String, f64)> = names
            .chain(["other".to_owned()])
            .map(|name| (name, 0.0))
            .collect();
        let measured = self.pool.timings();
        if measured.is_empty() {
            return Vec::new();
        }
        for timing in measured {
            let pass = timing.name.rsplit_once('/').map_or("", |(pass, _)| pass);
            let at = times
                .iter()
                .position(|(name, _)| name == pass)
                .unwrap_or(times.len() - 1);
            times[at].1 += timing.nanoseconds as f64 / 1e6;
        }
        if times.last().is_some_and(|(_, ms)| *ms == 0.0) {
            times.pop();
        }
        times
    }

    /// CPU milliseconds that it took to record each pass in the last frame, in the order of the graph, once
    /// `debug().timestamps` is on: all that can be told by pass where the device has no timestamps. It says
    /// nothing of how long the GPU works.
    pub fn recording_times(&self) -> Vec<(String, f64)> {
        let time = |built: &super::Built| {
            let milliseconds = built.recording.as_secs_f64() * 1e3;
            (built.info.name.clone(), milliseconds)
        };
        self.passes.iter().map(time).collect()
    }

    /// Bytes that the pipeline's textures and buffers take.
    pub fn memory(&self) -> Memory {
        self.pool.memory()
    }

    /// What passes told about the last frame. Waits for the GPU where a number is there; call it after submitting.
    ///
    /// # Errors
    /// When a counter cannot be read.
    pub fn reports(&self) -> Result<Vec<Report>, StatsError> {
        let mut reports = Vec::new();
        for built in &self.passes {
            for (key, stat) in &built.state.reports {
                let value = match stat {
                    Stat::Number(x) => ReportValue::Number(*x),
                    Stat::Text(text) => ReportValue::Text(text.clone()),
                    Stat::Buffer(_) => ReportValue::Number(self.counter(&built.info.name, key)?),
                };
                reports.push(Report {
                    pass: built.info.name.clone(),
                    key,
                    value,
                });
            }
        }
        Ok(reports)
    }

    fn counter(&self, pass: &str, key: &str) -> Result<f64, StatsError> {
        let Some(buffer) = self.pool.exported_buffer(&report_key(pass, key)) else {
            return Err(StatsError(format!(
                "`{key}` of pass `{pass}` was not written"
            )));
        };
        let bytes = crate::readback::buffer_bytes(&self.device, &self.queue, buffer, 4)
            .map_err(|e| StatsError(e.to_string()))?;
        let word = bytes
            .first_chunk::<4>()
            .map_or(0, |word| u32::from_le_bytes(*word));
        Ok(f64::from(word))
    }

    /// Every texture that is kept across frames, with when and why it last started anew: outputs
    /// that are read in the next frame as `pass.port`, a pass's own as `pass/name`.
    pub fn histories(&self) -> Vec<History> {
        let own = self.passes.iter().flat_map(|built| {
            let state = &built.state;
            state.histories.iter().map(move |label| {
                let forgotten = state.forgotten.iter().find(|(l, _, _)| l == label);
                (
                    label,
                    forgotten.map(|(_, since, reason)| (*since, reason.as_str())),
                )
            })
        });
        let inputs: Vec<Label> = (0..self.inputs.len())
            .filter(|i| self.is_kept(*i))
            .map(|i| self.input_label(i))
            .collect();
        let kept = self.feedback.iter().map(|f| &f.label).chain(&inputs);
        let all = kept.map(|label| (label, None)).chain(own);
        let history = |(label, forgotten): (&Label, Option<(u64, &str)>)| {
            let info = self.pool.history(label)?;
            let (since, reason) = match forgotten.filter(|(since, _)| *since > info.since) {
                Some((since, reason)) => (since, reason.to_owned()),
                None => (info.since, info.reset.to_string()),
            };
            Some(History {
                name: label.to_string(),
                since,
                reason,
            })
        };
        all.filter_map(history).collect()
    }

    /// Whether [`Pipeline::plan`] is kept for each frame; off at first, since it costs time.
    pub fn keep_plan(&mut self, keep: bool) {
        self.keep_plan = keep;
    }

    /// The plan of the last frame, to print or to draw, when [`Pipeline::keep_plan`] was on.
    pub fn plan(&self) -> Option<&framegraph::Snapshot> {
        self.plan.as_ref()
    }
}
