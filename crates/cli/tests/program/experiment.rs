//! A tiny experiment, and what it found without what depends on the clock.

use super::{DIRECT, Run, scumble};
use serde_json::Value;
use std::path::PathBuf;

/// Direct light and one bounce, averaged over frames.
pub const TRACED: &str = r#"(
    version: 1,
    about: "traced",
    passes: [
        (use: "gbuffer"),
        (use: "path-trace", with: (max_bounces: 1)),
        (use: "recombine", in: {"irradiance": "path-trace.irradiance", "emission": "gbuffer.emission"}),
        (use: "progressive", in: {"value": "recombine.radiance"}),
    ],
    outputs: {"linear": "progressive.value"},
)"#;

/// A folder with an experiment: two graphs, SEEDS seeds.
pub struct Lab {
    folder: tempfile::TempDir,
}

impl Lab {
    pub fn new(seeds: u32) -> Lab {
        let lab = Lab {
            folder: tempfile::tempdir().unwrap(),
        };
        lab.write("direct.ron", DIRECT);
        lab.write("traced.ron", TRACED);
        lab.write("e.ron", &EXPERIMENT.replace("SEEDS", &seeds.to_string()));
        lab
    }

    /// With something else in the experiment.
    pub fn with(from: &str, to: &str) -> Lab {
        let lab = Lab::new(2);
        lab.change(from, to);
        lab
    }

    pub fn change(&self, from: &str, to: &str) {
        let text = std::fs::read_to_string(self.path("e.ron")).unwrap();
        assert!(text.contains(from), "no {from} in {text}");
        self.write("e.ron", &text.replace(from, to));
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn at(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    /// The arguments that run it into a folder here.
    pub fn args(&self, output: &str) -> [String; 4] {
        let (experiment, output) = (self.at("e.ron"), self.at(output));
        ["ablate".into(), experiment, "--output".into(), output]
    }

    pub fn ablate(&self, output: &str, more: &[&str]) -> Run {
        let args = self.args(output);
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        scumble(&[&args, more].concat())
    }
}

const EXPERIMENT: &str = r#"(
    version: 1,
    about: "a test",
    scenes: ["cornell"],
    base: "traced.ron",
    compare: ["direct.ron"],
    camera: [(still: 0, frames: 2)],
    seeds: SEEDS,
    budget: EqualRays(1),
    reference: (samples: 4, every: 2),
    metrics: [RelMse, Ssim, Flicker],
    size: (32, 24),
)"#;

/// What `results.json` of a folder says, without times.
pub fn results(folder: &std::path::Path) -> Value {
    let text = std::fs::read_to_string(folder.join("results.json")).unwrap();
    let mut results: Value = serde_json::from_str(&text).unwrap();
    let remove = |value: &mut Value, names: &[&str]| {
        for name in names {
            assert!(
                value.as_object_mut().unwrap().remove(*name).is_some(),
                "no {name}"
            );
        }
    };
    remove(&mut results, &["spent"]);
    for run in results["runs"].as_array_mut().unwrap() {
        remove(run, &["seconds", "passes"]);
    }
    for summary in results["summaries"].as_array_mut().unwrap() {
        remove(summary, &["frame_ms", "gpu_ms", "pass_ms"]);
    }
    results
}

/// Files of `runs/`, and when each was written.
pub fn records(folder: &std::path::Path) -> Vec<(PathBuf, std::time::SystemTime)> {
    let Ok(entries) = std::fs::read_dir(folder.join("runs")) else {
        return Vec::new();
    };
    let paths = entries.map(|entry| entry.unwrap().path());
    let whole = paths.filter(|path| path.extension().is_some_and(|e| e == "json"));
    let mut records: Vec<_> = whole
        .map(|path| {
            let written = path.metadata().unwrap().modified().unwrap();
            (path, written)
        })
        .collect();
    records.sort();
    records
}

/// Every file below a folder is whole: JSON that can be parsed, no leftover of a write.
pub fn assert_whole(folder: &std::path::Path) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            assert_whole(&path);
            continue;
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        assert_ne!(extension, "tmp", "{} is left", path.display());
        if extension == "json" {
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(
                serde_json::from_str::<Value>(&text).is_ok(),
                "{}",
                path.display()
            );
        }
    }
}
