//! What frames cost: `--stats`.

use crate::failure::Failure;
use scumble::{Pipeline, Report, ReportValue};
use scumble_lab::Gpu;
use scumble_scene::GpuScene;
use serde_json::{Value, json};
use std::time::Duration;

/// The cost of each frame.
#[derive(Default)]
pub struct Stats {
    frames: Vec<Frame>,
}

struct Frame {
    /// GPU milliseconds of each pass; empty without timestamps.
    passes: Vec<(String, f64)>,
    /// Milliseconds to declare, compile and encode the frame.
    cpu_ms: f64,
    reports: Vec<Report>,
}

/// Bytes of GPU memory.
pub struct Memory {
    transient: u64,
    history: u64,
    upload: u64,
    scene: u64,
}

impl Memory {
    pub fn of(pipeline: &Pipeline, scene: Option<&GpuScene>) -> Memory {
        let memory = pipeline.memory();
        Memory {
            transient: memory.transient,
            history: memory.history,
            upload: memory.upload,
            scene: scene.map_or(0, GpuScene::memory),
        }
    }

    /// What grows with the image.
    fn frame(&self) -> u64 {
        self.transient + self.history
    }

    /// What an image of this size takes, and what to do where that is too much.
    pub fn needs(&self, size: [u32; 2]) -> String {
        let [width, height] = size;
        format!(
            "{width}x{height} pixels take about {} ({:.0} bytes per pixel) beside {} for the scene; \
             give a smaller --size",
            self::size(self.frame()),
            self.frame() as f64 / f64::from(width) / f64::from(height),
            self::size(self.scene),
        )
    }
}

impl Frame {
    fn gpu_ms(&self) -> Option<f64> {
        (!self.passes.is_empty()).then(|| self.passes.iter().map(|(_, ms)| ms).sum())
    }

    fn rays(&self) -> f64 {
        let rays = self.reports.iter().filter(|report| report.key == "rays");
        rays.map(|report| number(&report.value)).sum()
    }
}

fn number(value: &ReportValue) -> f64 {
    match value {
        ReportValue::Number(number) => *number,
        ReportValue::Text(_) => 0.0,
    }
}

impl Stats {
    /// Reads the frame that the GPU has just finished.
    pub fn add(&mut self, pipeline: &mut Pipeline, cpu: Duration) -> Result<(), Failure> {
        self.frames.push(Frame {
            passes: pipeline.timings(),
            cpu_ms: cpu.as_secs_f64() * 1e3,
            reports: pipeline.reports()?,
        });
        Ok(())
    }

    pub fn as_json(&self, memory: &Memory) -> Value {
        let frames = self.frames.iter().map(|frame| {
            let passes = frame
                .passes
                .iter()
                .map(|(name, ms)| json!({"name": name, "gpu_ms": ms}));
            let reports = frame.reports.iter().map(|report| {
                let value = match &report.value {
                    ReportValue::Number(number) => json!(number),
                    ReportValue::Text(text) => json!(text),
                };
                json!({"pass": report.pass, "key": report.key, "value": value})
            });
            json!({
                "passes": passes.collect::<Vec<_>>(),
                "gpu_ms": frame.gpu_ms(),
                "cpu_ms": frame.cpu_ms,
                "rays": frame.rays(),
                "reports": reports.collect::<Vec<_>>(),
            })
        });
        json!({
            "frames": frames.collect::<Vec<_>>(),
            "memory": {
                "frame_bytes": memory.frame(),
                "transient_bytes": memory.transient,
                "history_bytes": memory.history,
                "upload_bytes": memory.upload,
                "scene_bytes": memory.scene,
            },
        })
    }

    /// The last frame, as a table.
    pub fn as_text(&self, gpu: &Gpu, size: [u32; 2], memory: &Memory) -> String {
        let Some(frame) = self.frames.last() else {
            return String::new();
        };
        let mut text = format!("{}x{} on {}\n", size[0], size[1], gpu.name);
        if self.frames.len() == 1 {
            text += "  (the first frame: its times include what the driver compiles)\n";
        }
        let reported = |pass: &str| {
            let of_pass = frame.reports.iter().filter(|report| report.pass == pass);
            let shown = of_pass.map(|report| match &report.value {
                ReportValue::Number(number) => format!("{} {}", report.key, counted(*number)),
                ReportValue::Text(text) => format!("{}: {text}", report.key),
            });
            shown.collect::<Vec<_>>().join(", ")
        };
        for (name, ms) in &frame.passes {
            let line = format!("  {name:<24}{ms:>10.2} ms  {}", reported(name));
            text += &format!("{}\n", line.trim_end());
        }
        match frame.gpu_ms() {
            Some(ms) => {
                let rate = frame.rays() / ms / 1e3;
                text += &format!("  {:<24}{ms:>10.2} ms", "GPU, whole frame");
                text += &format!("  rays {}, {rate:.2} M/s\n", counted(frame.rays()));
            }
            None => text += "  this adapter has no timestamps: no GPU times\n",
        }
        text += &format!("  {:<24}{:>10.2} ms\n", "frame graph, CPU", frame.cpu_ms);
        let mib = |bytes: u64| bytes as f64 / 1024.0 / 1024.0;
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        text += &format!(
            "  memory: {:.1} MiB for the frame ({:.0} bytes per pixel, {:.1} MiB of it histories), \
             {:.1} MiB for the scene\n",
            mib(memory.frame()),
            memory.frame() as f64 / pixels,
            mib(memory.history),
            mib(memory.scene),
        );
        text
    }
}

/// Bytes to read at a glance.
pub fn size(bytes: u64) -> String {
    let (mut size, mut unit) = (bytes as f64, "bytes");
    for larger in ["KiB", "MiB", "GiB"] {
        if size >= 1024.0 {
            (size, unit) = (size / 1024.0, larger);
        }
    }
    match unit {
        "bytes" => format!("{bytes} bytes"),
        unit => format!("{size:.1} {unit}"),
    }
}

/// A count to read at a glance.
fn counted(number: f64) -> String {
    if number >= 1e6 {
        format!("{:.2} M", number / 1e6)
    } else {
        format!("{number}")
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_does_not_fit_is_said_in_bytes() {
        let memory = super::Memory {
            transient: 30 << 30,
            history: 8 << 30,
            upload: 0,
            scene: 3 << 19,
        };
        assert_eq!(
            memory.needs([16384, 16384]),
            "16384x16384 pixels take about 38.0 GiB (152 bytes per pixel) beside 1.5 MiB for the \
             scene; give a smaller --size"
        );
    }

    #[test]
    fn bytes() {
        assert_eq!(super::size(0), "0 bytes");
        assert_eq!(super::size(1023), "1023 bytes");
        assert_eq!(super::size(1536), "1.5 KiB");
        assert_eq!(super::size(54 << 30), "54.0 GiB");
    }

    #[test]
    fn counts() {
        assert_eq!(super::counted(0.0), "0");
        assert_eq!(super::counted(999_999.0), "999999");
        assert_eq!(super::counted(12_345_678.0), "12.35 M");
    }
}
