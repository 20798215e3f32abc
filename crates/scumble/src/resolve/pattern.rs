//! Patterns of names: `*` stands for any characters, `/` among them.

/// Whether `pattern` matches the whole of `name`.
pub(super) fn matches(pattern: &str, name: &str) -> bool {
    let Some((head, rest)) = pattern.split_once('*') else {
        return pattern == name;
    };
    let Some(mut name) = name.strip_prefix(head) else {
        return false;
    };
    let (middle, tail) = rest.rsplit_once('*').unwrap_or(("", rest));
    // The first place of each part leaves the most for those after it.
    for part in middle.split('*') {
        match name.find(part) {
            Some(at) => name = &name[at + part.len()..],
            None => return false,
        }
    }
    name.ends_with(tail)
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn a_star_is_any_characters_or_none() {
        let good = [
            ("jbu", "jbu"),
            ("*/jbu", "e/jbu"),
            ("*/jbu", "a/b/jbu"),
            ("*", ""),
            ("e/*", "e/jbu"),
            ("*b*", "abc"),
            ("a*a*a", "aaa"),
            ("*é*", "né"),
        ];
        for (pattern, name) in good {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        let bad = [
            ("jbu", "e/jbu"),
            ("*/jbu", "jbu"),
            ("e/*", "s/jbu"),
            ("a*b", "abc"),
            ("a*a*a", "aa"),
            ("ab*b", "ab"),
        ];
        for (pattern, name) in bad {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }
}
