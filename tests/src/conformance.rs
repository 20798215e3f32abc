//! The conformance suite over the passes of the repository, with the skips that each pass declares.

use scumble::conformance::{Fixture, Outcome, Report, Rule, check};
use scumble::{PassType, Registry};

/// Checks a pass.
///
/// # Panics
/// Where a rule fails, and where one is skipped for another reason than the pass's own declaration: it has no inputs to
/// feed, or says of no output that it is a filtered input.
pub fn keeps_the_rules(registry: &Registry, pass: &PassType, fixture: &mut Fixture) {
    let report = check(registry, &pass.name, fixture);
    assert!(report.passed(), "{report}");
    assert_eq!(skipped(&report), expected_skips(pass), "{report}");
}

fn skipped(report: &Report) -> Vec<(Rule, &str)> {
    let rules = report.rules.iter();
    rules
        .filter_map(|(rule, outcome)| match outcome {
            Outcome::Skipped(why) => Some((*rule, why.as_str())),
            Outcome::Passed | Outcome::Failed(_) => None,
        })
        .collect()
}

fn expected_skips(pass: &PassType) -> Vec<(Rule, &'static str)> {
    let mut expected = Vec::new();
    if pass.inputs.is_empty() {
        let why = "it has no inputs";
        expected.extend([Rule::Sky, Rule::Holes, Rule::BadTexel].map(|rule| (rule, why)));
    }
    if pass.bypass.is_empty() {
        let why = "no bypass says that an output is a filtered input";
        expected.extend([Rule::Constant, Rule::Bypass].map(|rule| (rule, why)));
    }
    expected
}
