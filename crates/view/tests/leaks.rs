//! Reloads leak nothing. A process of its own: what it holds is counted.

#[path = "running/rig.rs"]
mod rig;

use rig::{Folder, Rig, TINT, gpu, registry};

/// 200 reloads, every fourth of them broken: what is on the device, and what the process takes, are as after the first 40.
#[test]
fn two_hundred_reloads_leak_nothing() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut rig = Rig::new(&folder, &registry, gpu);
    let mut counts = Vec::new();
    let mut kilobytes = Vec::new();
    for i in 0..200u32 {
        let factor = format!("{}.0 * params.gain *", 1 + i % 5);
        let broken = if i % 4 == 3 { "}" } else { "" };
        folder.write(
            "tint.wgsl",
            &(TINT.replace("params.gain *", &factor) + broken),
        );
        rig.frame();
        rig.frame();
        assert_eq!(rig.running.problem().is_some(), i % 4 == 3, "{i}");
        if i % 40 == 38 {
            let memory = rig.running.pipeline().memory();
            let report = rig.stage.gpu.device.generate_allocator_report();
            let blocks = report.map(|report| report.allocations.len());
            counts.push((
                memory.transient,
                memory.history,
                memory.resources.len(),
                blocks,
            ));
            kilobytes.extend(resident());
        }
    }
    // The last good factor is that of the last but one.
    assert_eq!(rig.frame(), 401.0 * 4.0, "the count was never touched");
    assert!(counts.iter().all(|c| *c == counts[0]), "{counts:?}");
    // 4 MiB are 26 KiB per reload. Pages of allocators were 84 KiB in all; a shader that stayed would be more than 100 KiB
    // each time.
    if let (Some(first), Some(last)) = (kilobytes.first(), kilobytes.last()) {
        assert!(last - first < 4 * 1024, "resident KiB: {kilobytes:?}");
    }
}

/// KiB of memory that this process holds, where the system tells.
fn resident() -> Option<i64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}
