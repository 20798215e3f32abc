//! The name of something new, in the forms that files need.

use crate::failure::Failure;
use scumble::Registry;
use std::fmt;

/// Words of small letters and digits, joined by hyphens.
pub struct Name(String);

/// What no crate can be called: Rust's words, and the crates that it uses.
const TAKEN: &str = "abstract as async await become box break const continue core crate do dyn else enum extern false final fn \
    for framegraph gen if impl in let loop macro match mod move mut override priv pub ref return scumble scumble-cli \
    scumble-passes self static std struct super test trait true try type typeof unsafe unsized use virtual where while yield";

impl Name {
    pub fn parse(text: &str) -> Result<Name, Failure> {
        let bad = || Failure::BadName {
            name: text.to_owned(),
            help: help(text),
        };
        let is_word = |word: &str| {
            !word.is_empty()
                && word
                    .chars()
                    .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
        };
        let letter = text.starts_with(|c: char| c.is_ascii_lowercase());
        if letter && text.len() <= 64 && text.split('-').all(is_word) {
            Ok(Name(text.to_owned()))
        } else {
            Err(bad())
        }
    }

    /// Refuses what cargo would, and the names of passes that there are.
    pub fn check_crate(&self, registry: &Registry) -> Result<(), Failure> {
        let taken = match registry.get(&self.0) {
            Some(_) => "there is a pass of that name already",
            None if TAKEN.split_whitespace().any(|word| word == self.0) => {
                "no crate can be called so"
            }
            None => return Ok(()),
        };
        Err(Failure::BadName {
            name: self.0.clone(),
            help: format!("{taken}; try my-{}", self.0),
        })
    }

    /// `my_filter`
    pub fn snake(&self) -> String {
        self.0.replace('-', "_")
    }

    /// `MyFilter`
    fn type_name(&self) -> String {
        let words = self.0.split('-');
        words
            .map(|word| word[..1].to_uppercase() + &word[1..])
            .collect()
    }

    /// The template with its `@name@`, `@snake@` and `@Type@` filled in.
    pub fn put_into(&self, template: &str) -> String {
        template
            .replace("@name@", &self.0)
            .replace("@snake@", &self.snake())
            .replace("@Type@", &self.type_name())
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// What a name looks like; the nearest to `text` where there is one.
fn help(text: &str) -> String {
    let near: String = text
        .chars()
        .map(|c| match c.is_ascii_alphanumeric() {
            true => c.to_ascii_lowercase(),
            false => '-',
        })
        .collect();
    let words = near
        .trim_start_matches(|c: char| !c.is_ascii_lowercase())
        .split('-')
        .filter(|word| !word.is_empty());
    let near = words.collect::<Vec<_>>().join("-");
    let near = match near.is_empty() || near.len() > 64 {
        true => "my-filter",
        false => &near,
    };
    format!(
        "a name begins with a letter, and is of small letters, digits and hyphens, such as {near}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_three_forms() {
        let name = Name::parse("my-2nd-filter").unwrap();
        assert_eq!(
            name.put_into("@name@ @snake@ @Type@"),
            "my-2nd-filter my_2nd_filter My2ndFilter"
        );
    }

    #[test]
    fn other_names_are_refused_with_one_that_would_do() {
        for (bad, near) in [
            ("", "my-filter"),
            ("My_Filter", "my-filter"),
            ("a b", "a-b"),
            ("../x", "x"),
            ("a--b", "a-b"),
            ("-a", "a"),
            ("2d", "d"),
            ("filter.wgsl", "filter-wgsl"),
            ("é", "my-filter"),
        ] {
            let error = Name::parse(bad).err().unwrap().to_string();
            assert!(error.ends_with(&format!("such as {near}")), "{error}");
        }
        assert!(Name::parse(&"a".repeat(65)).is_err());
    }

    #[test]
    fn crates_are_called_neither_as_words_of_rust_nor_as_passes() {
        let registry = scumble_passes::registry();
        let refused = |name| Name::parse(name).unwrap().check_crate(&registry).is_err();
        assert!(refused("fn") && refused("scumble") && refused("atrous"));
        assert!(!refused("my-filter"));
    }
}
