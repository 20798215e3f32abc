//! RON decoded one level deep, its parts as slices of the text.

use std::fmt;

use ron::extensions::Extensions;
use ron::value::RawValue;
use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};

pub(super) fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

// First and last byte that is no space and no comment.
pub(super) fn significant(text: &str) -> (usize, usize) {
    let (mut start, mut end, mut at) = (text.len(), 0, 0);
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if c.is_whitespace() {
            c.len_utf8()
        } else {
            start = start.min(at);
            let length = if c == '"' { quoted(rest) } else { c.len_utf8() };
            end = at + length;
            length
        };
        at += length;
    }
    (start.min(end), end)
}

// Length of a block comment, which may hold others.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0usize, 0);
    while at < text.len() {
        if text[at..].starts_with("/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if text[at..].starts_with("*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                return at;
            }
        } else {
            at += text[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    text.len()
}

// Length of a quoted text.
fn quoted(text: &str) -> usize {
    let mut escaped = false;
    for (i, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return i + 1,
            _ => {}
        }
    }
    text.len()
}

/// A bracketed value.
pub(super) enum RawShape<'de> {
    Fields(Vec<(&'de str, &'de RawValue)>),
    Map(Vec<(&'de RawValue, &'de RawValue)>),
    Tuple(Vec<&'de RawValue>),
    List(Vec<&'de RawValue>),
    Other,
}

// A field name is an identifier, which RON gives as a slice of the text.
struct Identifier<'de>(&'de str);

impl<'de> Deserialize<'de> for Identifier<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct IdentifierVisitor;
        impl<'de> Visitor<'de> for IdentifierVisitor {
            type Value = Identifier<'de>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a field name")
            }

            fn visit_borrowed_str<E>(self, name: &'de str) -> Result<Self::Value, E> {
                Ok(Identifier(name))
            }
        }
        deserializer.deserialize_identifier(IdentifierVisitor)
    }
}

impl<'de> Deserialize<'de> for RawShape<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // Captured first: its first character says what it is, which the visitor is not told.
        let raw = <&RawValue>::deserialize(deserializer)?;
        let text = raw.get_ron();
        let (start, end) = significant(text);
        let inner = &text[start..end];
        let shape = match inner.chars().next() {
            Some('(') => Paren::deserialize_from(inner),
            Some('{') => options()
                .from_str(inner)
                .map(|Pairs(pairs)| RawShape::Map(pairs)),
            Some('[') => options().from_str(inner).map(RawShape::List),
            _ => Ok(RawShape::Other),
        };
        shape.map_err(serde::de::Error::custom)
    }
}

struct Pairs<'de>(Vec<(&'de RawValue, &'de RawValue)>);

impl<'de> Deserialize<'de> for Pairs<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PairsVisitor;
        impl<'de> Visitor<'de> for PairsVisitor {
            type Value = Pairs<'de>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a map")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut pairs = Vec::new();
                while let Some(pair) = map.next_entry()? {
                    pairs.push(pair);
                }
                Ok(Pairs(pairs))
            }
        }
        deserializer.deserialize_map(PairsVisitor)
    }
}

// `(…)`: with names or without.
struct Paren;

impl Paren {
    fn deserialize_from(text: &str) -> ron::error::SpannedResult<RawShape<'_>> {
        let mut deserializer = ron::Deserializer::from_str_with_options(text, &options())?;
        let shape = deserializer.deserialize_any(Paren);
        let shape = shape.map_err(|error| deserializer.span_error(error))?;
        Ok(shape)
    }
}

impl<'de> Visitor<'de> for Paren {
    type Value = RawShape<'de>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("fields or a tuple")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut fields = Vec::new();
        while let Some((Identifier(name), value)) = map.next_entry()? {
            fields.push((name, value));
        }
        Ok(RawShape::Fields(fields))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = seq.next_element()? {
            items.push(item);
        }
        Ok(RawShape::Tuple(items))
    }

    fn visit_unit<E>(self) -> Result<Self::Value, E> {
        Ok(RawShape::Tuple(Vec::new()))
    }
}
