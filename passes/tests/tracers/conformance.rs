//! What every pass must keep, the tracing ones with a scene.

use std::sync::Arc;

use scumble::conformance::{Fixture, check};
use scumble_scene::GpuScene;

use crate::common::rig::gpu;
use crate::common::scenes::room;

#[test]
fn every_tracer_keeps_the_rules() {
    let (device, queue) = gpu();
    let registry = scumble_passes::registry();
    for pass in [
        "gbuffer",
        "direct-lighting",
        "path-trace",
        "sparse-indirect",
    ] {
        let mut fixture = Fixture::new(device, queue);
        // A path tracer compiles for seconds, and software Vulkan compiles anew for sizes that are powers of two.
        fixture.sizes = vec![[1, 1], [7, 5], [33, 17]];
        let scene = GpuScene::new(device, queue, Arc::new(room())).unwrap();
        fixture.host.insert("Scene", scene);
        let report = check(&registry, pass, &mut fixture);
        assert!(report.passed(), "{report}");
    }
}
