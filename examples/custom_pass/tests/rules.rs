//! What every pass must keep.

use scumble::conformance::{Fixture, Outcome, check};

#[test]
fn diffusion_keeps_the_rules() {
    let adapter = wgpu::Instance::default().request_adapter(&Default::default());
    let adapter = pollster::block_on(adapter).expect("an adapter; Mesa's software driver is one");
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default())).unwrap();
    let mut registry = scumble_passes::registry();
    custom_pass::register(&mut registry);
    let report = check(&registry, "diffusion", &mut Fixture::new(&device, &queue));
    // Nothing failed, and nothing was left out.
    let all = report.rules.iter();
    assert!(
        all.clone().all(|(_, outcome)| *outcome == Outcome::Passed),
        "{report}"
    );
    assert!(all.count() > 8, "{report}");
}
