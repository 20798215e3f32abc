//! What every pass must keep.

use crate::common::gpu;
use scumble::conformance::{Fixture, Outcome, Rule, check};

#[test]
fn every_filter_keeps_the_rules() {
    let (device, queue) = gpu();
    let registry = scumble_passes::registry();
    let filters = [
        "accumulate",
        "atrous",
        "bilateral",
        "jbu",
        "outlier-reject",
        "progressive",
        "recombine",
        "sample-mask",
        "taa",
        "tonemap",
        "variance",
    ];
    for pass in filters {
        let report = check(&registry, pass, &mut Fixture::new(device, queue));
        assert!(report.passed(), "{report}");
        // `recombine`, `sample-mask`, `tonemap` and `variance` cannot be bypassed; everything else applies to every filter.
        let bypass = [Rule::Constant, Rule::Bypass];
        for (rule, outcome) in &report.rules {
            let fed =
                pass != "sample-mask" || ![Rule::Sky, Rule::Holes, Rule::BadTexel].contains(rule);
            let may_skip = !fed
                || bypass.contains(rule)
                    && ["recombine", "sample-mask", "tonemap", "variance"].contains(&pass);
            assert_eq!(matches!(outcome, Outcome::Skipped(_)), may_skip, "{report}");
        }
    }
}
