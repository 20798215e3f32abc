//! The comments of a WGSL file that mean something, with their places.

use std::ops::Range;

/// What the comments say.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Scanned<'t> {
    /// The comment at the top, without slashes.
    pub head: Vec<&'t str>,
    pub ports: Vec<PortComment<'t>>,
    /// Comments beside members of `Params`.
    pub members: Vec<(&'t str, Text<'t>)>,
}

/// A `// port …` comment and the variable it stands at.
#[derive(Debug, PartialEq)]
pub(super) struct PortComment<'t> {
    /// After `port`.
    pub text: Text<'t>,
    /// `None` when no binding follows.
    pub variable: Option<&'t str>,
}

/// A piece of the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Text<'t> {
    pub text: &'t str,
    pub span: Range<usize>,
}

impl<'t> Text<'t> {
    /// A part of this piece.
    pub fn part(&self, text: &'t str) -> Text<'t> {
        let start = self.span.start + (text.as_ptr() as usize - self.text.as_ptr() as usize);
        Text {
            text,
            span: start..start + text.len(),
        }
    }

    /// The piece without blanks around it.
    pub fn trimmed(&self) -> Text<'t> {
        self.part(self.text.trim())
    }
}

pub(super) fn scan(text: &str) -> Scanned<'_> {
    let mut scanned = Scanned::default();
    let whole = Text {
        text,
        span: 0..text.len(),
    };
    let (mut at_head, mut in_params) = (true, false);
    let mut pending: Option<Text<'_>> = None;
    for line in text.lines() {
        let (code, comment) = line
            .split_once("//")
            .map_or((line, None), |(code, comment)| (code, Some(comment)));
        at_head &= code.trim().is_empty();
        let port = comment.and_then(|c| c.trim().strip_prefix("port "));
        if let (true, Some(comment), None) = (at_head, comment, port) {
            scanned
                .head
                .push(comment.strip_prefix(' ').unwrap_or(comment));
        }
        if let Some(port) = port {
            let text = pending.replace(whole.part(port));
            scanned.ports.extend(text.map(|text| PortComment {
                text,
                variable: None,
            }));
        }
        if let Some(variable) = binding(code)
            && let Some(text) = pending.take()
        {
            scanned.ports.push(PortComment {
                text,
                variable: Some(variable),
            });
        }
        if let (true, Some(comment), Some((name, _))) = (in_params, comment, code.split_once(':')) {
            scanned
                .members
                .push((name.trim(), whole.part(comment).trimmed()));
        }
        in_params |= code.trim_start().starts_with("struct Params");
        in_params &= !code.contains('}');
    }
    scanned.ports.extend(pending.map(|text| PortComment {
        text,
        variable: None,
    }));
    scanned
}

/// The variable that a line binds.
fn binding(code: &str) -> Option<&str> {
    let after = code.split_once("@binding")?.1.split_once("var")?.1;
    let after = if after.starts_with('<') {
        after.split_once('>')?.1
    } else {
        after
    };
    Some(after.split_once(':')?.0.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_found_where_they_mean_something() {
        let text = "// Brightens.\n//   out = value\nstruct Params {\n    gain: f32, // 2.0; factor\n    seed: u32,\n}\n\
                    // port value: any, any\n@group(0) @binding(1) var value: texture_2d<f32>;\n\
                    @group(0) @binding(2) var out_value: texture_2d<f32>; // port value: any, full\n// port lost: any\n";
        let scanned = scan(text);
        assert_eq!(scanned.head, ["Brightens.", "  out = value"]);
        assert_eq!(scanned.members[0].0, "gain");
        assert_eq!(&text[scanned.members[0].1.span.clone()], "2.0; factor");
        let ports: Vec<_> = scanned
            .ports
            .iter()
            .map(|p| (p.text.text, p.variable))
            .collect();
        assert_eq!(
            ports,
            [
                ("value: any, any", Some("value")),
                ("value: any, full", Some("out_value")),
                ("lost: any", None)
            ]
        );
        assert_eq!(
            &text[scanned.ports[1].text.span.clone()],
            "value: any, full"
        );
    }
}
