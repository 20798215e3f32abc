//! The rules that need no device.

use crate::pass::BypassKind;
use crate::registry::PassType;

pub(super) fn documented(ty: &PassType) -> Vec<String> {
    let mut missing = Vec::new();
    let mut need = |text: &str, what: String| {
        if text.trim().is_empty() {
            missing.push(what);
        }
    };
    need(
        &ty.about,
        "it does not say in one line what it is for".to_owned(),
    );
    need(&ty.readme, "it has no README".to_owned());
    for (kind, ports) in [("input", &ty.inputs), ("output", &ty.outputs)] {
        for port in ports {
            need(
                port.about,
                format!("the {kind} `{}` does not say what it is", port.name),
            );
        }
    }
    for def in ty.params() {
        need(
            def.about,
            format!("the parameter `{}` does not say what it is", def.name),
        );
    }
    missing
}

pub(super) fn defaults(ty: &PassType) -> Vec<String> {
    let wrong =
        |def: &crate::params::ParamDef| def.check(&def.default).err().map(|e| e.to_string());
    ty.params().iter().filter_map(wrong).collect()
}

pub(super) fn bypass_declared(ty: &PassType) -> Vec<String> {
    let mut wrong = Vec::new();
    for rule in &ty.bypass {
        let (output, input) = (rule.output, rule.input);
        let (Some(to), Some(from)) = (ty.output(output), ty.input(input)) else {
            wrong.push(format!(
                "the bypass of `{output}` by `{input}` names a port that does not exist"
            ));
            continue;
        };
        if to.signal != from.signal {
            wrong.push(format!(
                "the bypass of `{output}` by `{input}` joins two signals"
            ));
        }
        if rule.how == BypassKind::Alias && to.resolution != from.resolution {
            wrong.push(format!("the output `{output}` is an alias of `{input}`, which has another resolution: resample"));
        }
    }
    wrong
}
