//! `// port …` comments: what a binding carries.

use super::interned;
use super::mistake::{Mistake, wrong};
use super::scan::{PortComment, Scanned, Text};
use crate::diagnostics::{hint, listed};
use crate::port::{FirstFrame, Port, PortSignal, Resolution};
use crate::registry::Registry;

pub(super) const PORT_HELP: &str = "write `// port NAME: SIGNAL, full|grid|any; what it is` above its binding, an output's called `out_NAME`";
const INPUT_HELP: &str = "before the `;` an input may be `optional`, have a `source NAME`, and `first skip`, `first copy NAME` or \
     `first VALUE` for reads of the previous frame";
const OUTPUT_HELP: &str =
    "before the `;` an output may be `alters`, `precise` or `precise if kept`";

/// What a file says of its ports.
#[derive(Default)]
pub(super) struct Ports {
    /// In the order of the file.
    pub inputs: Vec<Port>,
    /// In the order of the file.
    pub outputs: Vec<Port>,
    /// Variables of ports with a mistake: what they carry is not known.
    pub doubtful: Vec<String>,
}

/// Every port with a binding, those with mistakes too: so all else can still be checked.
pub(super) fn ports(
    scanned: &Scanned<'_>,
    registry: &Registry,
    mistakes: &mut Vec<Mistake>,
) -> Ports {
    let mut ports = Ports::default();
    for comment in &scanned.ports {
        let Some(variable) = comment.variable else {
            let message = "no binding follows this port";
            mistakes.push(wrong(message, &comment.text.span, PORT_HELP));
            continue;
        };
        let before = mistakes.len();
        let output = variable.strip_prefix("out_");
        let port = Port::any(interned(output.unwrap_or(variable)));
        let port = stated(port, comment, output.is_some(), registry, mistakes);
        match output {
            Some(_) => ports.outputs.push(port),
            None => ports.inputs.push(port),
        }
        if mistakes.len() > before {
            ports.doubtful.push(variable.to_owned());
        }
    }
    check_copies(scanned, &ports, mistakes);
    ports
}

/// `NAME: SIGNAL, RESOLUTION, …; about`
fn stated(
    mut port: Port,
    comment: &PortComment<'_>,
    output: bool,
    registry: &Registry,
    mistakes: &mut Vec<Mistake>,
) -> Port {
    let comment = &comment.text;
    let (stated, about) = comment.text.split_once(';').unwrap_or((comment.text, ""));
    port = port.about(interned(about.trim()));
    let Some((name, rest)) = stated.split_once(':') else {
        let message = "a port has a name, a colon, a signal and a resolution";
        mistakes.push(wrong(message, &comment.span, PORT_HELP));
        return port;
    };
    if name.trim() != port.name {
        let variable = if output { "out_" } else { "" };
        let message = format!(
            "the port `{}` stands at the variable `{variable}{}`",
            name.trim(),
            port.name
        );
        let help = "call the variable of an input as the port, and that of an output `out_NAME`";
        mistakes.push(wrong(&message, &comment.span, help));
    }
    let words = comment.part(rest).listed();
    match signal(&words[0], registry) {
        Ok(signal) => port.signal = signal,
        Err(mistake) => mistakes.push(mistake),
    }
    match words.get(1).map(|word| (word, resolution(word.text))) {
        Some((_, Some(resolution))) => port.resolution = resolution,
        Some((word, None)) => {
            let message = format!("`{}` is no resolution", word.text);
            mistakes.push(wrong(&message, &word.span, PORT_HELP));
        }
        None => {
            let message = "the port has no resolution";
            mistakes.push(wrong(message, &words[0].span, PORT_HELP));
        }
    }
    for word in words.iter().skip(2) {
        let mut refused = |message: String| {
            let help = if output { OUTPUT_HELP } else { INPUT_HELP };
            mistakes.push(wrong(&message, &word.span, help));
        };
        port = match (output, word.text, word.text.split_once(' ')) {
            (false, "optional", _) => port.optional(),
            (false, _, Some(("source", source))) => port.source(interned(source.trim())),
            (false, _, Some(("first", rule))) => match first(rule.trim()) {
                Some(rule) => port.first(rule),
                None => {
                    refused(format!("`{}` is no rule for the first frame", rule.trim()));
                    port
                }
            },
            (true, "alters", _) => port.alters(),
            (true, "precise", _) => port.precise(),
            (true, "precise if kept", _) => port.precise_if_kept(),
            (_, other, _) => {
                let which = if output { "an output" } else { "an input" };
                refused(format!("{which} cannot be `{other}`"));
                port
            }
        };
    }
    port
}

fn resolution(word: &str) -> Option<Resolution> {
    match word {
        "full" => Some(Resolution::Full),
        "grid" => Some(Resolution::Grid),
        "any" => Some(Resolution::Any),
        _ => None,
    }
}

fn signal(word: &Text<'_>, registry: &Registry) -> Result<PortSignal, Mistake> {
    if word.text == "any" {
        return Ok(PortSignal::Any);
    }
    let all = registry.signals();
    match all.iter().find(|s| s.name() == word.text) {
        Some(signal) => Ok(PortSignal::Is(*signal)),
        None => {
            let hint = hint(word.text, all.iter().map(|s| s.name()));
            let message = format!("there is no signal `{}`{hint}", word.text);
            Err(wrong(&message, &word.span, PORT_HELP))
        }
    }
}

/// What a read of the previous frame gets when there is none: `skip`, `copy PORT`, a number or four.
fn first(rule: &str) -> Option<FirstFrame> {
    if rule == "skip" {
        return Some(FirstFrame::Skip);
    }
    if let Some(port) = rule.strip_prefix("copy ") {
        return Some(FirstFrame::Copy(interned(port.trim())));
    }
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let Some(inside) = rule.strip_prefix('(').and_then(|r| r.strip_suffix(')')) else {
        return Some(FirstFrame::Clear([number(rule)?; 4]));
    };
    let numbers: Option<Vec<f64>> = inside.split(',').map(number).collect();
    Some(FirstFrame::Clear(numbers?.try_into().ok()?))
}

/// What is copied in the first frame is another input of the same signal and resolution.
fn check_copies(scanned: &Scanned<'_>, ports: &Ports, mistakes: &mut Vec<Mistake>) {
    let inputs = &ports.inputs;
    let doubtful = |name: &str| ports.doubtful.iter().any(|port| port == name);
    for port in inputs {
        let Some(FirstFrame::Copy(name)) = port.first else {
            continue;
        };
        if doubtful(port.name) || doubtful(name) {
            continue;
        }
        let fits = |other: &&Port| {
            other.name != port.name
                && (other.signal, other.resolution) == (port.signal, port.resolution)
        };
        let fitting: Vec<_> = inputs.iter().filter(fits).map(|other| other.name).collect();
        if fitting.contains(&name) {
            continue;
        }
        let comment = scanned
            .ports
            .iter()
            .find(|c| c.variable == Some(port.name))
            .map(|comment| comment.text.span.clone());
        let message = format!(
            "in the first frame `{}` copies `{name}`, which is no input of its signal and resolution",
            port.name
        );
        let help = match fitting.is_empty() {
            true => "there is none: give a value, or skip".to_owned(),
            false => format!("such are {}", listed(&fitting)),
        };
        mistakes.push(Mistake {
            message,
            at: comment,
            help,
        });
    }
}
