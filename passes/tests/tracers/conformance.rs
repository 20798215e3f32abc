//! What every pass must keep, the tracing ones with a scene.

use std::sync::Arc;

use scumble::conformance::Fixture;
use scumble_scene::GpuScene;
use scumble_tests::keeps_the_rules;

use crate::common::rig::gpu;
use crate::common::scenes::room;

/// Every pass of the registry that needs something from the host, which can only be a scene: without it the rules would be
/// skipped, and that is not expected of any pass.
#[test]
fn every_tracer_keeps_the_rules() {
    let (device, queue) = gpu();
    let registry = scumble_passes::registry();
    let tracers = registry
        .iter()
        .filter(|pass| !pass.needs(&pass.defaults).host.is_empty());
    let mut checked = 0;
    for pass in tracers {
        let mut fixture = Fixture::new(device, queue);
        // A path tracer compiles for seconds, and software Vulkan compiles anew for sizes that are powers of two.
        fixture.sizes = vec![[1, 1], [7, 5], [33, 17]];
        let scene = GpuScene::new(device, queue, Arc::new(room())).unwrap();
        fixture.host.insert("Scene", scene);
        keeps_the_rules(&registry, pass, &mut fixture);
        checked += 1;
    }
    assert!(checked >= 4, "only {checked} tracers were found");
}
