//! From the text of a WGSL file to ports and parameters.

use framegraph::{Binding, BindingAccess, BindingKind, Reflection};

use super::mistake::{Mistake, errors, placed};
use super::params::params;
use super::ports::{PORT_HELP, Ports, ports};
use super::scan::{Scanned, scan};
use crate::context::PassInfo;
use crate::kernel_plan::{Source, slot};
use crate::params::ParamDef;
use crate::pass::SkySide;
use crate::port::Port;
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

pub(super) fn read(
    name: &str,
    text: &str,
    registry: &Registry,
) -> Result<Facts, Vec<WgslPassError>> {
    let mut mistakes = Vec::new();
    let scanned = scan(text);
    let Ports {
        inputs,
        outputs,
        doubtful,
    } = ports(&scanned, registry, &mut mistakes);
    if outputs.is_empty() && mistakes.is_empty() {
        mistakes.push(Mistake {
            message: "the file has no output".to_owned(),
            at: None,
            help: PORT_HELP.to_owned(),
        });
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
    let (composed, reflection) = match reflect(name, text, registry, &info) {
        Ok(both) => both,
        Err(error) => {
            // What is told of the ports may be all that is wrong.
            if mistakes.is_empty() {
                mistakes.push(placed(name, text, &error));
            }
            return Err(errors(mistakes, text));
        }
    };
    let params = params(&scanned, &reflection, &info, &mut mistakes);
    let info = PassInfo {
        defs: params,
        ..info
    };
    for binding in &reflection.bindings {
        let mut wrong = |what: &str, help: &str| {
            mistakes.push(Mistake {
                message: format!("the binding `{}` {what}", binding.name),
                at: scanned.place(&binding.name),
                help: help.to_owned(),
            });
        };
        if let Some((what, help)) = cannot_be(binding, &info) {
            wrong(what, help);
            continue;
        }
        // The parameters are checked, and what a port with a mistake carries is not known.
        let is_uniform = matches!(binding.kind, BindingKind::Uniform(_));
        if is_uniform || doubtful.contains(&binding.name) {
            continue;
        }
        match slot(binding, &info, Some(&composed)) {
            Ok(slot) if matches!(slot.source, Source::ByHand) => wrong("is no port", PORT_HELP),
            Ok(_) => {}
            Err(error) => mistakes.push(placed(name, text, &error)),
        }
    }
    check_use(&scanned, &reflection, &info, &mut mistakes);
    if !mistakes.is_empty() {
        return Err(errors(mistakes, text));
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

/// The shader as it is compiled, and what it declares.
fn reflect(
    name: &str,
    text: &str,
    registry: &Registry,
    info: &PassInfo,
) -> Result<(Composed, Reflection), ShaderError> {
    let composed = compose_for(name, text, registry, info)?;
    let reflection = Reflection::of(composed.wgsl(), "main")
        .map_err(|e| composed.explain(&e.message, &e.labels))?;
    Ok((composed, reflection))
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

/// Why a binding can be no port, no parameters and no sampler.
fn cannot_be(binding: &Binding, info: &PassInfo) -> Option<(&'static str, &'static str)> {
    const RUST: &str = "a pass that needs more is written in Rust: `scumble new pass`";
    if binding.group != 0 {
        return Some((
            "is not in group 0, and a pass that is only WGSL binds no other",
            RUST,
        ));
    }
    let flat = wgpu::TextureViewDimension::D2;
    match &binding.kind {
        BindingKind::Storage { .. } => Some(("is a buffer, and ports are textures", RUST)),
        BindingKind::Sampled { dimension, .. } | BindingKind::StorageTexture { dimension, .. }
            if *dimension != flat =>
        {
            Some(("is no texture of two dimensions, and ports are", RUST))
        }
        BindingKind::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            ..
        } if info.input(&binding.name).is_some() => Some((
            "is an input, and the shader writes it",
            "call the variable of an output `out_NAME`",
        )),
        BindingKind::Uniform(_) if info.input(&binding.name).is_some() => {
            Some(("is a uniform, and ports are textures", PORT_HELP))
        }
        _ => None,
    }
}

/// Every port is used: an input that nobody reads misleads, an output that nobody writes fails in the first frame.
fn check_use(
    scanned: &Scanned<'_>,
    reflection: &Reflection,
    info: &PassInfo,
    mistakes: &mut Vec<Mistake>,
) {
    let used = |name: &str| reflection.bindings.iter().find(|b| b.name == name);
    let inputs = info.inputs.iter().filter(|port| used(port.name).is_none());
    let inputs = inputs.map(|port| (port.name.to_owned(), "`main` never reads the input"));
    let written = |name: &str| used(name).is_some_and(|b| b.access != BindingAccess::Read);
    let outputs = info.outputs.iter().map(|port| format!("out_{}", port.name));
    let outputs = outputs.filter(|name| !written(name));
    let outputs = outputs.map(|name| (name, "`main` never writes the output"));
    mistakes.extend(inputs.chain(outputs).map(|(name, what)| Mistake {
        message: format!("{what} `{name}`"),
        at: scanned.place(&name),
        help: "use it, or remove it and its comment".to_owned(),
    }));
}
