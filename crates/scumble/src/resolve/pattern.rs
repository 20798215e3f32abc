//! Patterns of names: `*` stands for any characters, `/` among them.

/// Whether `pattern` matches the whole of `name`.
pub(super) fn matches(pattern: &str, name: &str) -> bool {
    let Some((head, rest)) = pattern.split_once('*') else {
        return pattern == name;
    };
    let Some(name) = name.strip_prefix(head) else {
        return false;
    };
    let ends = name.char_indices().map(|(i, _)| i).chain([name.len()]);
    ends.into_iter().any(|i| matches(rest, &name[i..]))
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn a_star_is_any_characters_or_none() {
        for (pattern, name) in [
            ("jbu", "jbu"),
            ("*/jbu", "e/jbu"),
            ("*/jbu", "a/b/jbu"),
            ("*", ""),
            ("e/*", "e/jbu"),
            ("*b*", "abc"),
        ] {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in [
            ("jbu", "e/jbu"),
            ("*/jbu", "jbu"),
            ("e/*", "s/jbu"),
            ("a*b", "abc"),
        ] {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }
}
