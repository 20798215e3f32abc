//! Addresses of ports: `gbuffer.normal`, `e/jbu.mask`, `atrous.first@prev`, `value`.

use std::fmt;

/// The address of a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WireRef {
    /// The pass; `None` for an input (or, at the end of a wire, an output) of the graph.
    pub pass: Option<String>,
    /// The port.
    pub port: String,
    /// The value of the frame before.
    pub previous: bool,
}

impl WireRef {
    /// Reads an address; an error says what is wrong with it.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let (address, previous) = match text.split_once('@') {
            None => (text, false),
            Some((address, "prev")) => (address, true),
            Some((_, other)) => {
                return Err(format!("after `@` only `prev` can stand, not `{other}`"));
            }
        };
        let (pass, port) = match address.rsplit_once('.') {
            Some((pass, port)) => (Some(pass), port),
            None => (None, address),
        };
        for name in pass.into_iter().chain([port]) {
            if !name.split('/').all(is_name) {
                return Err(format!("`{name}` is no name"));
            }
        }
        Ok(Self {
            pass: pass.map(str::to_owned),
            port: port.to_owned(),
            previous,
        })
    }
}

impl fmt::Display for WireRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(pass) = &self.pass {
            write!(f, "{pass}.")?;
        }
        let previous = if self.previous { "@prev" } else { "" };
        write!(f, "{}{previous}", self.port)
    }
}

/// Whether a text may be the name of a pass, an input or an output.
pub(super) fn is_name(text: &str) -> bool {
    let allowed = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
    !text.is_empty() && text.chars().all(allowed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_come_back_as_written() {
        for text in ["gbuffer.normal", "e/jbu.mask", "atrous.first@prev", "value"] {
            assert_eq!(
                WireRef::parse(text).map(|r| r.to_string()),
                Ok(text.to_owned())
            );
        }
    }

    #[test]
    fn what_is_no_address_is_refused() {
        for text in [
            "",
            "a.",
            ".b",
            "a.b@next",
            "a b.c",
            "a..b",
            "e//jbu.x",
            "a.b@prev@prev",
        ] {
            assert!(WireRef::parse(text).is_err(), "{text}");
        }
    }
}
