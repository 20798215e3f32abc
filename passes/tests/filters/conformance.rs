//! What every pass must keep.

use crate::common::gpu;
use scumble::conformance::Fixture;
use scumble_tests::keeps_the_rules;

/// Every pass of the registry that needs nothing from the host; those that need a scene are checked with the tracers.
#[test]
fn every_filter_keeps_the_rules() {
    let (device, queue) = gpu();
    let registry = scumble_passes::registry();
    let filters = registry
        .iter()
        .filter(|pass| pass.needs(&pass.defaults).host.is_empty());
    let mut checked = 0;
    for pass in filters {
        keeps_the_rules(&registry, pass, &mut Fixture::new(device, queue));
        checked += 1;
    }
    assert!(checked >= 6, "only {checked} filters were found");
}
