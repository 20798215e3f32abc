//! Time per pass, rays per second, frame-graph CPU time and bytes per pixel of whole frames.

use crate::command::{self, Done, cargo, failure, output};
use crate::setup;
use serde_json::Value;

/// One measured frame.
struct Bench {
    name: &'static str,
    about: &'static str,
    graph: &'static str,
    size: &'static str,
    set: &'static [&'static str],
}

const BENCHES: [Bench; 3] = [
    Bench {
        name: "paper",
        about: "Boughida et al. 2016: 1024x1024, 16x16, 100 samples, one direct sample",
        graph: "graphs/upsample-2016.ron",
        size: "1024x1024",
        set: &["direct-lighting.samples=1"],
    },
    Bench {
        name: "path-trace-1spp",
        about: "1 path per pixel",
        graph: "graphs/path-trace-1spp.ron",
        size: "1024x1024",
        set: &[],
    },
    Bench {
        name: "direct-only",
        about: "G-buffer and direct light",
        graph: "graphs/direct-only.ron",
        size: "1024x1024",
        set: &[],
    },
];

/// The benchmark, and the package, of the frame graph alone.
const GRAPH: &str = "framegraph";

/// The benchmark of the error metrics.
const METRICS: &str = "metrics";

/// The benchmark of what a pipeline adds to the frame graph.
const PIPELINE: &str = "pipeline";

/// Frames rendered, and how many at the start are left out: they compile the shaders and make the
/// resources.
const FRAMES: usize = 7;
const WARM_UP: usize = 2;

/// Runs the benchmark of that name, or all, with optimised code.
pub fn run(name: Option<&str>) -> Done {
    let graph = name.is_none_or(|n| n == GRAPH);
    let metrics = name.is_none_or(|n| n == METRICS);
    let pipeline = name.is_none_or(|n| n == PIPELINE);
    let chosen: Vec<_> = BENCHES
        .iter()
        .filter(|b| name.is_none_or(|n| n == b.name))
        .collect();
    if chosen.is_empty() && !graph && !metrics && !pipeline {
        let known = BENCHES.iter().map(|b| b.name);
        let known: Vec<_> = known.chain([GRAPH, METRICS, PIPELINE]).collect();
        let name = name.unwrap_or_default();
        return Err(failure(format!(
            "no benchmark '{name}'; there are {}",
            known.join(", ")
        )));
    }
    if metrics {
        println!("\n{METRICS}: wall time of each error metric at 1920x1080, two threads");
        let args = [
            "run",
            "--quiet",
            "--release",
            "--package",
            "scumble-metrics",
        ];
        command::run(cargo(&[&args[..], &["--example", "time"]].concat()))?;
    }
    if chosen.is_empty() && !graph && !pipeline {
        return Ok(());
    }
    setup::run()?;
    if graph {
        for (example, about) in [
            (
                "cpu",
                "CPU time of the frame graph beside hand-written wgpu",
            ),
            ("transitions", "barriers that are made as one"),
        ] {
            println!("\n{GRAPH}: {about}");
            let args = ["run", "--quiet", "--release", "--package", GRAPH];
            command::run(cargo(&[&args[..], &["--example", example]].concat()))?;
        }
    }
    if pipeline {
        println!("\n{PIPELINE}: CPU time of a pipeline beside the frame graph alone");
        let args = ["run", "--quiet", "--release", "--package", "scumble-cli"];
        command::run(cargo(&[&args[..], &["--example", "cost"]].concat()))?;
    }
    for bench in chosen {
        println!("\n{}: {}", bench.name, bench.about);
        let frames = FRAMES.to_string();
        let file = format!("out/bench/{}.exr", bench.name);
        let mut args = vec![
            "run",
            "--quiet",
            "--release",
            "--package",
            "scumble-cli",
            "--",
        ];
        args.extend([
            "render",
            bench.graph,
            "--scene",
            "atrium",
            "--size",
            bench.size,
        ]);
        args.extend([
            "--frames", &frames, "--stats", "--json", "--quiet", "--output", &file,
        ]);
        args.extend(bench.set.iter().flat_map(|s| ["--set", s]));
        let report = output(cargo(&args))?;
        let report: Value = serde_json::from_str(&report)
            .map_err(|e| failure(format!("scumble render --json: {e}")))?;
        print!("{}", table(&report));
    }
    Ok(())
}

/// The report of `scumble render --stats --json` as medians over the measured frames.
fn table(report: &Value) -> String {
    let none = Vec::new();
    let frames = report["stats"]["frames"].as_array().unwrap_or(&none);
    let frames = frames.get(WARM_UP..).unwrap_or_default();
    let over = |f: &dyn Fn(&Value) -> Option<f64>| median(frames.iter().filter_map(f).collect());
    let mut text = format!("  on {}\n", report["adapter"].as_str().unwrap_or("?"));
    let passes = frames
        .first()
        .and_then(|f| f["passes"].as_array())
        .unwrap_or(&none);
    for (i, pass) in passes.iter().enumerate() {
        let ms = over(&|f| f["passes"][i]["gpu_ms"].as_f64());
        let name = pass["name"].as_str().unwrap_or("?");
        text += &format!("  {name:<28} {} ms\n", shown(ms));
    }
    let gpu = over(&|f| f["gpu_ms"].as_f64());
    let rays = over(&|f| f["rays"].as_f64());
    text += &format!("  {:<28} {} ms\n", "GPU, whole frame", shown(gpu));
    text += &format!(
        "  {:<28} {} ms\n",
        "frame graph, CPU",
        shown(over(&|f| f["cpu_ms"].as_f64()))
    );
    if let (Some(gpu), Some(rays)) = (gpu, rays) {
        text += &format!("  {:<28} {:.3} M\n", "rays per second", rays / gpu / 1000.0);
    }
    let pixels = report["size"][0]
        .as_f64()
        .zip(report["size"][1].as_f64())
        .map(|(w, h)| w * h);
    let bytes = report["stats"]["memory"]["frame_bytes"].as_f64();
    if let Some((bytes, pixels)) = bytes.zip(pixels) {
        text += &format!("  {:<28} {:.1}\n", "bytes per pixel", bytes / pixels);
    }
    text
}

fn shown(value: Option<f64>) -> String {
    value.map_or_else(|| "       ?".into(), |v| format!("{v:8.3}"))
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let middle = values.get(n / 2)?;
    Some(if n.is_multiple_of(2) {
        (values[n / 2 - 1] + middle) / 2.0
    } else {
        *middle
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn medians_leave_the_warm_up_out() {
        let frame = |ms: f64| {
            serde_json::json!({"gpu_ms": ms, "cpu_ms": 0.5, "rays": 4e6,
                               "passes": [{"name": "gbuffer", "gpu_ms": ms / 2.0}]})
        };
        let frames = [900.0, 900.0, 3.0, 2.0, 4.0, 8.0].map(frame);
        let report = serde_json::json!({
            "adapter": "A", "size": [10, 10],
            "stats": {"frames": frames, "memory": {"frame_bytes": 4800}},
        });
        let expected = "  on A\n\
            \x20 gbuffer                         1.750 ms\n\
            \x20 GPU, whole frame                3.500 ms\n\
            \x20 frame graph, CPU                0.500 ms\n\
            \x20 rays per second              1142.857 M\n\
            \x20 bytes per pixel              48.0\n";
        assert_eq!(super::table(&report), expected);
    }
}
