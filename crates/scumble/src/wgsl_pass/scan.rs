//! What a WGSL file says in comments and names, with the places.

use std::ops::Range;

/// What is found line by line; what the shader means is for naga to say.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Scanned<'t> {
    /// The comment at the top, without slashes.
    pub head: Vec<&'t str>,
    pub ports: Vec<PortComment<'t>>,
    /// Variables with a binding.
    pub bindings: Vec<Text<'t>>,
    /// Members of `Params`, each on a line of its own.
    pub members: Vec<MemberLine<'t>>,
}

/// A `// port …` comment and the variable it stands at.
#[derive(Debug, PartialEq)]
pub(super) struct PortComment<'t> {
    /// After `port`.
    pub text: Text<'t>,
    /// `None` when no binding follows.
    pub variable: Option<&'t str>,
}

/// A member of `Params` and the comment beside it.
#[derive(Debug, PartialEq)]
pub(super) struct MemberLine<'t> {
    pub name: Text<'t>,
    pub comment: Option<Text<'t>>,
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

    /// The parts between commas, those in parentheses left alone, each without blanks around it.
    pub fn listed(&self) -> Vec<Text<'t>> {
        let mut depth = 0usize;
        let parts = self.text.split(|c| {
            match c {
                '(' => depth += 1,
                ')' => depth = depth.saturating_sub(1),
                _ => {}
            }
            c == ',' && depth == 0
        });
        parts.map(|part| self.part(part).trimmed()).collect()
    }
}

impl Scanned<'_> {
    /// Where the variable or member of that name is declared.
    pub fn place(&self, name: &str) -> Option<Range<usize>> {
        let members = self.members.iter().map(|member| &member.name);
        let mut all = self.bindings.iter().chain(members);
        all.find(|known| known.text == name)
            .map(|found| found.span.clone())
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
        if let Some(variable) = binding(code) {
            scanned.bindings.push(whole.part(variable));
            scanned.ports.extend(pending.take().map(|text| PortComment {
                text,
                variable: Some(variable),
            }));
        }
        if let (true, Some((name, _))) = (in_params, code.split_once(':')) {
            // Attributes stand before the name.
            let name = name.split_whitespace().next_back().unwrap_or(name);
            scanned.members.push(MemberLine {
                name: whole.part(name),
                comment: comment.map(|comment| whole.part(comment).trimmed()),
            });
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
        let text = "// Brightens.\n//   out = value\nstruct Params {\n    @align(16) gain: f32, // 2.0; factor\n    seed: u32,\n}\n\
                    // port value: any, any\n@group(0) @binding(1) var value: texture_2d<f32>;\n\
                    @group(0) @binding(2) var out_value: texture_2d<f32>; // port value: any, full\n// port lost: any\n";
        let scanned = scan(text);
        assert_eq!(scanned.head, ["Brightens.", "  out = value"]);
        let [gain, seed] = &scanned.members[..] else {
            panic!("{:?}", scanned.members)
        };
        assert_eq!((gain.name.text, seed.name.text), ("gain", "seed"));
        let comment = gain.comment.as_ref().unwrap();
        assert_eq!(&text[comment.span.clone()], "2.0; factor");
        assert_eq!(seed.comment, None);
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
        assert_eq!(&text[scanned.place("out_value").unwrap()], "out_value");
        assert_eq!(scanned.place("gain"), Some(gain.name.span.clone()));
        assert_eq!(scanned.place("value.format"), None);
    }

    #[test]
    fn lists_keep_vectors_whole() {
        let text = "radiance, full, first (0, 1, 2, 3)";
        let whole = Text {
            text,
            span: 0..text.len(),
        };
        let parts = whole.listed();
        let texts: Vec<_> = parts.iter().map(|part| part.text).collect();
        assert_eq!(texts, ["radiance", "full", "first (0, 1, 2, 3)"]);
        assert_eq!(&text[parts[1].span.clone()], "full");
    }
}
