//! From the text of a WGSL file to ports and parameters.

use framegraph::{Binding, BindingAccess, BindingKind, Reflection};

use super::mistake::{Mistake, errors, placed};
use super::params::params;
use super::ports::{PORT_HELP, ports};
use super::scan::{Scanned, scan};
use crate::context::PassInfo;
use crate::kernel_plan::{Source, slots};
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
    let (inputs, outputs) = ports(&scanned, registry, &mut mistakes);
    if outputs.is_empty() && mistakes.is_empty() {
        mistakes.push(Mistake {
            message: "the file has no output".to_owned(),
            at: None,
            help: PORT_HELP.to_owned(),
        });
    }
    if !mistakes.is_empty() {
        return Err(errors(mistakes, text));
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
    let in_file = |e: &ShaderError| errors(vec![placed(name, text, e)], text);
    let composed = compose_for(name, text, registry, &info).map_err(|e| in_file(&e))?;
    let reflection = Reflection::of(composed.wgsl(), "main")
        .map_err(|e| in_file(&composed.explain(&e.message, &e.labels)))?;
    let params = params(&scanned, &reflection, &info, &mut mistakes);
    let info = PassInfo {
        defs: params,
        ..info
    };
    let bound = check_bindings(&scanned, &reflection, &info, &mut mistakes);
    if bound {
        check_use(&scanned, &reflection, &info, &mut mistakes);
    }
    match slots(&reflection, &info, Some(&composed)) {
        Err(e) => mistakes.push(placed(name, text, &e)),
        Ok(slots) if bound => {
            let by_hand = slots.iter().filter(|s| matches!(s.source, Source::ByHand));
            mistakes.extend(by_hand.map(|slot| Mistake {
                message: format!("the binding `{}` is no port", slot.name),
                at: scanned.place(&slot.name),
                help: PORT_HELP.to_owned(),
            }));
        }
        Ok(_) => {}
    }
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

/// Whether everything that the shader binds can be a port, the parameters or a sampler.
fn check_bindings(
    scanned: &Scanned<'_>,
    reflection: &Reflection,
    info: &PassInfo,
    mistakes: &mut Vec<Mistake>,
) -> bool {
    let before = mistakes.len();
    for binding in &reflection.bindings {
        if let Some((what, help)) = cannot_be(binding, info) {
            mistakes.push(Mistake {
                message: format!("the binding `{}` {what}", binding.name),
                at: scanned.place(&binding.name),
                help: help.to_owned(),
            });
        }
    }
    mistakes.len() == before
}

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
