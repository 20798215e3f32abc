//! Equal rays: the counts of grid tracers, corrected by what the tracers of a frame counted.
//!
//! As many paths are not as many rays: some leave the scene early, and direct light takes two rays at each point. A
//! grid tracer has many paths at few pixels, so that its count can be set finely; one or two per pixel cannot.

use crate::budget::{is_count, mark};
use crate::device::Gpu;
use crate::error::LabError;
use crate::key::Key;
use crate::record::{read_json, write_json};
use crate::stage::{Pose, Stage};
use scumble::{Pipeline, ReportValue, Resolved, Value};
use std::collections::BTreeMap;
use std::path::Path;

/// Rays that each pass counted in a frame.
pub(crate) type Rays = BTreeMap<String, f64>;

/// What the passes of the last frame counted.
pub(crate) fn rays(pipeline: &Pipeline) -> Result<Rays, LabError> {
    let mut rays = Rays::new();
    for report in pipeline.reports()?.into_iter().filter(|r| r.key == "rays") {
        if let ReportValue::Number(count) = report.value {
            *rays.entry(report.pass).or_default() += count;
        }
    }
    Ok(rays)
}

/// What the passes count in the second frame of a path, taken from the folder where it was counted before.
pub(crate) fn counted(
    gpu: &Gpu,
    stage: &mut Stage,
    pipeline: &mut Pipeline,
    poses: &[Pose],
    mut key: Key,
    folder: &Path,
) -> Result<Rays, LabError> {
    let poses = &poses[..poses.len().min(2)];
    key.add("rays");
    for pose in poses {
        key.camera(&pose.camera).value(&pose.time);
    }
    let path = folder.join(format!("{}.json", key.name()));
    if let Some(kept) = read_json(&path) {
        return Ok(kept);
    }
    let mut last = Rays::new();
    stage.play(gpu, pipeline, poses, 0, |_, pipeline| {
        last = rays(pipeline)?;
        Ok(())
    })?;
    // Where it cannot be kept it is counted again.
    let _ = write_json(&path, &last);
    Ok(last)
}

/// Counts of the grid tracers, as `pass.parameter`, with which all tracers together count `target` rays as nearly as
/// whole counts can: what the others count is left to stand, and the rest is shared in proportion.
pub(crate) fn balanced(graph: &Resolved, rays: &Rays, target: f64) -> Vec<(String, Value)> {
    let mut grids = Vec::new();
    let mut on_grids = 0.0;
    for pass in graph.passes.iter().filter(|p| p.grid > 1 && !p.bypassed) {
        if let (Some(name), Some(counted)) = (mark(pass, is_count), rays.get(&pass.name))
            && let Some(Value::Int(count)) = pass.params.get(name)
            && *counted > 0.0
        {
            on_grids += counted;
            grids.push((pass, name, count));
        }
    }
    let elsewhere = rays.values().sum::<f64>() - on_grids;
    let scale = (target - elsewhere).max(0.0) / on_grids;
    let of = |(pass, name, count): (&scumble::ResolvedPass, &str, i64)| {
        let range = pass.params.def(name).and_then(|def| def.range);
        let (low, high) = range.unwrap_or((1.0, f64::from(u32::MAX)));
        let count = (count as f64 * scale).round().clamp(low, high);
        (format!("{}.{name}", pass.name), Value::Int(count as i64))
    };
    grids.into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scumble::{Edits, resolve_text};

    #[test]
    fn a_grid_makes_up_for_the_others() {
        let text = r#"(version: 1, passes: [
            (use: "gbuffer"), (use: "direct-lighting"), (use: "sparse-indirect", with: (samples: 200)),
            (use: "jbu", in: {"value": "sparse-indirect.irradiance", "grid_normal": "sparse-indirect.normal",
                "grid_view_z": "sparse-indirect.view_z", "pixel": "sparse-indirect.pixel"}),
            (use: "recombine", in: {"irradiance": "jbu.value", "direct": "direct-lighting.radiance"}),
        ], outputs: {"linear": "recombine.radiance"})"#;
        let registry = scumble_passes::registry();
        let graph = resolve_text("t.ron", text, &registry, &Edits::default()).unwrap();
        let rays = Rays::from([
            ("direct-lighting".to_owned(), 2000.0),
            ("sparse-indirect".to_owned(), 2500.0),
        ]);
        let count = |target: f64| match balanced(&graph, &rays, target).as_slice() {
            [(name, Value::Int(count))] if name == "sparse-indirect.samples" => *count,
            other => panic!("{other:?}"),
        };
        // 1500 rays are left of 3500: three fifths of 200 paths.
        assert_eq!(count(3500.0), 120);
        assert_eq!(count(4500.0), 200);
        // Less than one path it cannot have.
        assert_eq!(count(1000.0), 1);
    }
}
