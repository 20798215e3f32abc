//! What was meant by a name that does not exist.

use std::cmp::Reverse;

use super::listed;

/// The candidate that `name` was most likely meant to be; `None` when none is near.
///
/// That is the one with the fewest wrong, missing, added or swapped letters (Damerau 1964), when these
/// are at most a third of all and whatever their case (of several such the one that begins most
/// alike); otherwise the first that has `name` as one of its words.
///
/// ```
/// use scumble::diagnostics::nearest;
///
/// assert_eq!(nearest("jub", ["gbuffer", "jbu"]), Some("jbu"));
/// assert_eq!(nearest("jbu", ["e", "e/jbu", "s/jbu"]), Some("e/jbu"));
/// assert_eq!(nearest("bloom", ["gbuffer", "jbu"]), None);
/// ```
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = name.to_lowercase();
    let candidates: Vec<(&str, String)> = candidates
        .into_iter()
        .map(|candidate| (candidate, candidate.to_lowercase()))
        .collect();
    let slips = candidates.iter().filter_map(|(candidate, lower)| {
        let letters = wanted.chars().count().max(lower.chars().count());
        let wrong = strsim::damerau_levenshtein(&wanted, lower);
        let alike = wanted.chars().zip(lower.chars());
        let alike = alike.take_while(|(a, b)| a == b).count();
        (wrong <= letters / 3).then_some(((wrong, Reverse(alike)), *candidate))
    });
    let has_word = |lower: &str| {
        lower
            .split(['/', '-', '_', '.'])
            .any(|word| !word.is_empty() && word == wanted)
    };
    match slips.min_by_key(|(rank, _)| *rank) {
        Some((_, candidate)) => Some(candidate),
        None => candidates
            .iter()
            .find(|(_, lower)| has_word(lower))
            .map(|(candidate, _)| *candidate),
    }
}

/// The end of a one-line message about an unknown name: "; did you mean `x`?", or all that there is.
pub(crate) fn hint<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    match nearest(name, candidates.iter().copied()) {
        Some(nearest) => format!("; did you mean `{nearest}`?"),
        None if candidates.is_empty() => "; there are none".to_owned(),
        None => format!("; there are {}", listed(&candidates)),
    }
}

#[cfg(test)]
mod tests {
    use super::{hint, nearest};

    const PASSES: [&str; 11] = [
        "gbuffer",
        "direct-lighting",
        "sparse-indirect",
        "path-trace",
        "outlier-reject",
        "bilateral",
        "jbu",
        "recombine",
        "progressive",
        "tonemap",
        "e/jbu",
    ];

    #[test]
    fn slips_of_the_pen() {
        for (name, meant) in [
            ("jub", "jbu"),
            ("JBU", "jbu"),
            ("jb", "jbu"),
            ("gbufer", "gbuffer"),
            ("g-buffer", "gbuffer"),
            ("bilatral", "bilateral"),
            ("path_trace", "path-trace"),
            ("tone-map", "tonemap"),
            ("directlight", "direct-lighting"),
        ] {
            assert_eq!(nearest(name, PASSES), Some(meant), "{name}");
        }
    }

    #[test]
    fn of_two_slips_the_one_that_begins_alike() {
        let signals = ["radiance", "irradiance"];
        assert_eq!(nearest("iradiance", signals), Some("irradiance"));
        assert_eq!(nearest("raddiance", signals), Some("radiance"));
    }

    #[test]
    fn one_word_of_a_name() {
        assert_eq!(nearest("sparse", PASSES), Some("sparse-indirect"));
        assert_eq!(nearest("jbu", ["e/jbu", "s/jbu"]), Some("e/jbu"));
        assert_eq!(nearest("", ["-a"]), None);
    }

    #[test]
    fn what_is_far_away_is_not_meant() {
        for name in ["taa", "svgf", "x", "bloom", "firefly-clamp", "traced", ""] {
            assert_eq!(nearest(name, PASSES), None, "{name}");
        }
        assert_eq!(nearest("a", ["b", "ab"]), None, "half of it is wrong");
    }

    #[test]
    fn the_end_of_a_message() {
        assert_eq!(hint("jub", PASSES), "; did you mean `jbu`?");
        assert_eq!(hint("x", ["a", "b"]), "; there are `a`, `b`");
        assert_eq!(hint("x", []), "; there are none");
    }
}
