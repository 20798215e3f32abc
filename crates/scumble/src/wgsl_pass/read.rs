//! From the text of a WGSL file to ports and parameters.

use framegraph::{BindingKind, Member, MemberType, Reflection, Scalar};

use super::interned;
use super::scan::{Scanned, Text, scan};
use crate::context::PassInfo;
use crate::diagnostics::hint;
use crate::kernel_plan::{Fill, Source, fill_of, slots};
use crate::params::{ParamDef, ParamKind, Value};
use crate::pass::SkySide;
use crate::port::{Port, PortSignal, Resolution};
use crate::registry::{Registry, WgslPassError};
use crate::signal;
use crate::wgsl::{Composed, ShaderError, compose};

/// What a WGSL file states as a pass; it has an output.
pub(super) struct Facts {
    pub about: String,
    pub readme: String,
    pub inputs: Vec<Port>,
    pub outputs: Vec<Port>,
    pub params: Vec<ParamDef>,
}

const PORT_HELP: &str = "write `// port NAME: SIGNAL, full|grid|any[, optional][, precise][, source NAME]; what it is` above its binding";
const PARAM_HELP: &str = "write `// DEFAULT in MIN..MAX, UNIT; what it is` beside it";

pub(super) fn read(
    name: &str,
    text: &str,
    registry: &Registry,
) -> Result<Facts, Vec<WgslPassError>> {
    let mut errors = Vec::new();
    let scanned = scan(text);
    let (inputs, outputs) = ports(&scanned, registry, &mut errors);
    if outputs.is_empty() && errors.is_empty() {
        errors.push(error("the file has no output", None, PORT_HELP));
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let info = PassInfo {
        name: name.to_owned(),
        wired: vec![false; inputs.len()],
        inputs,
        outputs,
        defs: Vec::new(),
        signal: None,
        grid: 1,
        any_grid: 1,
        sky: SkySide::Direct,
    };
    let in_file = |e: &ShaderError| vec![placed(name, text, e)];
    let composed = compose_for(name, text, registry, &info).map_err(|e| in_file(&e))?;
    let reflection = Reflection::of(composed.wgsl(), "main")
        .map_err(|e| in_file(&composed.explain(&e.message, &e.labels)))?;
    let params = params(&scanned, &reflection, &info, &mut errors);
    let info = PassInfo {
        defs: params,
        ..info
    };
    match slots(&reflection, &info, Some(&composed)) {
        Err(e) => errors.push(placed(name, text, &e)),
        Ok(slots) => {
            for slot in slots
                .iter()
                .filter(|slot| matches!(slot.source, Source::ByHand))
            {
                let place = word_at(text, &slot.name);
                errors.push(error(
                    &format!("the binding `{}` is no port", slot.name),
                    place,
                    PORT_HELP,
                ));
            }
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let PassInfo {
        inputs,
        outputs,
        defs,
        ..
    } = info;
    let about = scanned
        .head
        .iter()
        .map(|line| line.trim())
        .find(|line| !line.is_empty());
    Ok(Facts {
        about: about.unwrap_or_default().to_owned(),
        readme: scanned.head.join("\n"),
        inputs,
        outputs,
        params: defs,
    })
}

fn compose_for(
    name: &str,
    text: &str,
    registry: &Registry,
    info: &PassInfo,
) -> Result<Composed, ShaderError> {
    let formats = info
        .outputs
        .iter()
        .map(|p| (format!("{}.format", p.name), info.format_of(p)));
    let formats: Vec<_> = formats
        .map(|(name, format)| (name, signal::wgsl_format(format)))
        .collect();
    let defines: Vec<_> = formats
        .iter()
        .map(|(name, format)| (name.as_str(), *format))
        .collect();
    compose(name, text, registry.modules(), &defines)
}

fn ports(
    scanned: &Scanned<'_>,
    registry: &Registry,
    errors: &mut Vec<WgslPassError>,
) -> (Vec<Port>, Vec<Port>) {
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for comment in &scanned.ports {
        let span = Some(comment.text.span.clone());
        let Some(variable) = comment.variable else {
            errors.push(error("no binding follows this port", span, PORT_HELP));
            continue;
        };
        match port(&comment.text, registry) {
            Err(e) => errors.push(e),
            Ok(port) if variable == port.name => inputs.push(port),
            Ok(port) if variable.strip_prefix("out_") == Some(port.name) => outputs.push(port),
            Ok(port) => {
                let help = format!(
                    "call the variable `{0}` for an input and `out_{0}` for an output",
                    port.name
                );
                let message = format!(
                    "the port `{}` stands at the variable `{variable}`",
                    port.name
                );
                errors.push(error(&message, span, &help));
            }
        }
    }
    (inputs, outputs)
}

/// `NAME: SIGNAL, RESOLUTION, …; about`
fn port(comment: &Text<'_>, registry: &Registry) -> Result<Port, WgslPassError> {
    let (stated, about) = comment.text.split_once(';').unwrap_or((comment.text, ""));
    let Some((name, rest)) = stated.split_once(':') else {
        return Err(error(
            "a port has a name, a colon, a signal and a resolution",
            Some(comment.span.clone()),
            PORT_HELP,
        ));
    };
    let mut words = rest.split(',').map(|word| comment.part(word).trimmed());
    let mut port = Port::any(interned(name.trim())).about(interned(about.trim()));
    let Some(word) = words.next() else {
        return Ok(port);
    };
    if word.text != "any" {
        let all = registry.signals();
        let Some(signal) = all.iter().find(|s| s.name() == word.text) else {
            let hint = hint(word.text, all.iter().map(|s| s.name()));
            return Err(error(
                &format!("there is no signal `{}`{hint}", word.text),
                Some(word.span),
                PORT_HELP,
            ));
        };
        port.signal = PortSignal::Is(*signal);
    }
    let Some(resolution) = words.next() else {
        return Err(error(
            "the port has no resolution",
            Some(word.span),
            PORT_HELP,
        ));
    };
    port.resolution = match resolution.text {
        "full" => Resolution::Full,
        "grid" => Resolution::Grid,
        "any" => Resolution::Any,
        other => {
            return Err(error(
                &format!("`{other}` is no resolution"),
                Some(resolution.span),
                PORT_HELP,
            ));
        }
    };
    for word in words {
        port = match (word.text, word.text.strip_prefix("source ")) {
            ("optional", _) => port.optional(),
            ("precise", _) => port.precise(),
            (_, Some(source)) => port.source(interned(source.trim())),
            (other, None) => {
                return Err(error(
                    &format!("a port cannot be `{other}`"),
                    Some(word.span),
                    PORT_HELP,
                ));
            }
        };
    }
    Ok(port)
}

fn params(
    scanned: &Scanned<'_>,
    reflection: &Reflection,
    info: &PassInfo,
    errors: &mut Vec<WgslPassError>,
) -> Vec<ParamDef> {
    let mut defs: Vec<ParamDef> = Vec::new();
    for binding in reflection.bindings.iter().filter(|b| b.group == 0) {
        let BindingKind::Uniform(layout) = &binding.kind else {
            continue;
        };
        for member in &layout.members {
            if fill_of(&member.name, info).0 != Fill::ByHand {
                continue;
            }
            match scanned
                .members
                .iter()
                .find(|(name, _)| *name == member.name)
            {
                None => {
                    let message = format!(
                        "nothing fills the member `{}`, and it has no default",
                        member.name
                    );
                    errors.push(error(&message, None, PARAM_HELP));
                }
                Some((_, comment)) => match param(member, comment) {
                    Ok(def) => defs.push(def),
                    Err(e) => errors.push(e),
                },
            }
        }
    }
    defs
}

/// `DEFAULT in MIN..MAX, UNIT; about`
fn param(member: &Member, comment: &Text<'_>) -> Result<ParamDef, WgslPassError> {
    let wrong = |what: &str| {
        error(
            &format!("the parameter `{}` {what}", member.name),
            Some(comment.span.clone()),
            PARAM_HELP,
        )
    };
    let (stated, about) = comment.text.split_once(';').unwrap_or((comment.text, ""));
    // A vector's default has commas of its own.
    let end = stated
        .find(')')
        .map_or_else(|| stated.find([',', ' ']), |i| Some(i + 1))
        .unwrap_or(stated.len());
    let (default, rest) = stated.split_at(end);
    let (range, unit) = rest.split_once(',').unwrap_or((rest, ""));
    let (kind, default) =
        value(&member.ty, default.trim()).ok_or_else(|| wrong("has no default of its type"))?;
    let range = match range.trim().strip_prefix("in ") {
        None if range.trim().is_empty() => None,
        None => return Err(wrong("has something between its default and its unit")),
        Some(range) => {
            let (low, high) = range
                .split_once("..")
                .ok_or_else(|| wrong("has a range without `..`"))?;
            let bound = |text: &str| text.trim().trim_start_matches('=').parse::<f64>().ok();
            let both = bound(low)
                .zip(bound(high))
                .filter(|(low, high)| low <= high);
            Some(both.ok_or_else(|| wrong("has a range that is none"))?)
        }
    };
    let unit = Some(unit.trim())
        .filter(|unit| !unit.is_empty())
        .map(interned);
    let def = ParamDef {
        name: interned(&member.name),
        about: interned(about.trim()),
        kind,
        default,
        range,
        unit,
        structural: false,
        budget: false,
    };
    match def.check(&def.default) {
        Ok(()) => Ok(def),
        Err(e) => Err(error(
            &e.to_string(),
            Some(comment.span.clone()),
            PARAM_HELP,
        )),
    }
}

fn value(ty: &MemberType, text: &str) -> Option<(ParamKind, Value)> {
    Some(match (ty, text) {
        (MemberType::U32, "true" | "false") => (ParamKind::Bool, Value::Bool(text == "true")),
        (MemberType::U32, _) => (
            ParamKind::Int { signed: false },
            Value::Int(text.parse().ok()?),
        ),
        (MemberType::I32, _) => (
            ParamKind::Int { signed: true },
            Value::Int(text.parse().ok()?),
        ),
        (MemberType::F32, _) => (ParamKind::Float, Value::Float(text.parse().ok()?)),
        (
            MemberType::Vec {
                n,
                scalar: Scalar::F32,
            },
            _,
        ) => {
            let inside = text.strip_prefix('(')?.strip_suffix(')')?;
            let values: Option<Vec<f64>> =
                inside.split(',').map(|x| x.trim().parse().ok()).collect();
            (ParamKind::Vector(*n as usize), Value::Vector(values?))
        }
        _ => return None,
    })
}

fn error(message: &str, span: Option<std::ops::Range<usize>>, help: &str) -> WgslPassError {
    WgslPassError {
        message: message.to_owned(),
        span,
        help: Some(help.to_owned()),
    }
}

/// An error of the shader at its place in this file; one in an included file keeps its own text.
fn placed(name: &str, text: &str, e: &ShaderError) -> WgslPassError {
    match e.labels.first().filter(|label| label.at.file == name) {
        None => WgslPassError {
            message: e.to_string(),
            span: None,
            help: None,
        },
        Some(label) => {
            let line = text
                .split_inclusive('\n')
                .take(label.at.line - 1)
                .map(str::len)
                .sum::<usize>();
            let bytes = |chars: usize| {
                label
                    .line_text
                    .chars()
                    .take(chars)
                    .map(char::len_utf8)
                    .sum::<usize>()
            };
            let (from, to) = (
                bytes(label.at.column - 1),
                bytes(label.at.column - 1 + label.length),
            );
            WgslPassError {
                message: e.message.clone(),
                span: Some(line + from..line + to),
                help: None,
            }
        }
    }
}

fn word_at(text: &str, word: &str) -> Option<std::ops::Range<usize>> {
    let start = text.find(&format!(" {word}:"))? + 1;
    Some(start..start + word.len())
}
