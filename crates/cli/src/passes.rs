//! `scumble passes`: what there is to put into a graph.

use crate::args::{PassesArgs, SceneChanges};
use crate::camera::CameraChoice;
use crate::failure::Failure;
use crate::{report, scene};
use scumble::conformance::{Fixture, Outcome, Report, Rule, check_type};
use scumble::{
    Bypass, BypassKind, Filter, FrameInput, Needs, ParamDef, PassType, Port, PortSignal, Registry,
    Resolution,
};
use scumble_lab::{Gpu, device};
use scumble_scene::GpuScene;
use serde_json::json;
use std::path::Path;
use std::sync::Arc;

pub fn run(args: &PassesArgs, registry: &Registry) -> Result<(), Failure> {
    let Some(name) = &args.name else {
        let mut passes: Vec<_> = registry.iter().collect();
        passes.sort_by_key(|pass| &pass.name);
        if args.json {
            report::json(&passes.iter().map(|pass| as_json(pass)).collect());
        } else {
            let width = passes.iter().map(|pass| pass.name.len()).max().unwrap_or(0);
            for pass in passes {
                report::line(format_args!("{:<width$}  {}", pass.name, pass.about));
            }
        }
        return Ok(());
    };
    let pass = if name.ends_with(".wgsl") {
        Arc::new(scumble::read_wgsl_pass(name, registry).map_err(Failure::Graph)?)
    } else {
        registered(name, registry)?
    };
    let report = match args.test {
        true => Some(test(args, &pass, registry)?),
        false => None,
    };
    if args.json {
        let mut told = as_json(&pass);
        if let Some(report) = &report {
            told["test"] = rules(report);
        }
        report::json(&told);
    } else {
        report::line(as_text(&pass).trim_end());
        if let Some(report) = &report {
            report::line(format_args!("\n{report}"));
        }
    }
    match report {
        Some(report) if !report.passed() => Err(Failure::Rules { name: name.clone() }),
        _ => Ok(()),
    }
}

fn registered(name: &str, registry: &Registry) -> Result<Arc<PassType>, Failure> {
    if let Some(pass) = registry.get(name) {
        return Ok(pass.clone());
    }
    let hint = match registry.nearest(name) {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => "`scumble passes` lists them".to_owned(),
    };
    Err(Failure::UnknownPass {
        name: name.to_owned(),
        hint,
    })
}

/// The conformance suite; a pass that traces gets the Cornell box.
fn test(args: &PassesArgs, pass: &Arc<PassType>, registry: &Registry) -> Result<Report, Failure> {
    let adapter = device::adapter(args.adapter.adapter.as_deref())?;
    let needs = pass.needs(&pass.defaults);
    let gpu = Gpu::open(&adapter, needs.features & adapter.features())?;
    let mut fixture = Fixture::new(&gpu.device, &gpu.queue);
    if needs.host.contains(&"Scene") {
        let scene = scene::load(Path::new("cornell"), &SceneChanges::default())?;
        let scene = GpuScene::new(&gpu.device, &gpu.queue, Arc::new(scene))?;
        fixture.input = FrameInput::still(CameraChoice::Number(0).of(scene.cameras())?);
        fixture.host.insert("Scene", scene);
    }
    let report = check_type(registry, pass, &mut fixture);
    gpu.check()?;
    Ok(report)
}

fn rules(report: &Report) -> serde_json::Value {
    let rule = |(rule, outcome): &(Rule, Outcome)| {
        let (outcome, why) = match outcome {
            Outcome::Passed => ("passed", Vec::new()),
            Outcome::Skipped(why) => ("skipped", vec![why.clone()]),
            Outcome::Failed(all) => ("failed", all.clone()),
        };
        json!({"rule": format!("{rule:?}"), "outcome": outcome, "why": why})
    };
    report.rules.iter().map(rule).collect()
}

fn signal(port: &Port) -> &'static str {
    match port.signal {
        PortSignal::Is(signal) => signal.name(),
        PortSignal::Any => "any",
    }
}

fn resolution(port: &Port) -> &'static str {
    match port.resolution {
        Resolution::Full => "full",
        Resolution::Grid => "grid",
        Resolution::Any => "any",
    }
}

fn range(def: &ParamDef) -> String {
    let unit = def.unit.map(|unit| format!(" {unit}")).unwrap_or_default();
    match def.range {
        Some((low, high)) if low == f64::NEG_INFINITY && high == f64::INFINITY => {
            format!("{}{unit}", def.kind)
        }
        Some((low, high)) => format!("{low} to {high}{unit}"),
        None => format!("{}{unit}", def.kind),
    }
}

/// With parameters at their defaults.
fn needs(pass: &PassType) -> String {
    let needs = pass.needs(&pass.defaults);
    let or_none = |all: Vec<String>, none: &str| match all.is_empty() {
        true => none.to_owned(),
        false => all.join(", "),
    };
    let host = needs.host.iter().map(|name| format!("a {name}"));
    let features = needs.features.iter_names().map(|(name, _)| name.to_owned());
    let limits: Vec<String> = match needs.beyond(&wgpu::Limits::default()).as_slice() {
        // A list of fifteen that every desktop has says less than their name.
        [] if !needs.beyond(&Needs::default().limits).is_empty() => {
            vec!["the default limits of WebGPU".to_owned()]
        }
        _ => {
            let limits = needs.beyond(&Needs::default().limits).into_iter();
            limits
                .map(|(name, needed)| format!("{name} {needed}"))
                .collect()
        }
    };
    let device = features.chain(limits).collect();
    format!(
        "  {:<22}{}\n  {:<22}{}\n",
        "of the host",
        or_none(host.collect(), "nothing"),
        "of the device",
        or_none(device, "nothing special"),
    )
}

fn as_text(pass: &PassType) -> String {
    let mut text = format!("{}: {}\n", pass.name, pass.about);
    for (title, ports) in [("inputs", &pass.inputs), ("outputs", &pass.outputs)] {
        if ports.is_empty() {
            continue;
        }
        text += &format!("\n{title}\n");
        for port in ports {
            let optional = if port.optional { ", optional" } else { "" };
            let kind = format!("{}, {}{optional}", signal(port), resolution(port));
            text += &format!("  {:<22}{kind:<28}{}\n", port.name, port.about);
        }
    }
    if !pass.params().is_empty() {
        text += "\nparameters\n";
        for def in pass.params() {
            let structural = if def.structural {
                "; a change rebuilds the pass"
            } else {
                ""
            };
            let allowed = format!("{} (default {})", range(def), def.default);
            text += &format!("  {:<22}{allowed}{structural}\n", def.name);
            let about = def.about.trim();
            if !about.is_empty() {
                text += &format!("  {:<22}{}\n", "", about.replace('\n', " "));
            }
        }
    }
    text += &format!("\nneeds\n{}", needs(pass));
    text += &match pass.bypass.as_slice() {
        [] => "\nIt cannot be bypassed where its outputs are read.\n".to_owned(),
        all => {
            let each = all.iter().map(|b| match b.how {
                BypassKind::Alias => format!("{} is the input {}", b.output, b.input),
                BypassKind::Resample(_) => {
                    format!("{} is the input {}, resampled", b.output, b.input)
                }
            });
            format!("\nBypassed: {}.\n", each.collect::<Vec<_>>().join(", "))
        }
    };
    format!("{text}\n{}\n", pass.readme.trim())
}

fn as_json(pass: &PassType) -> serde_json::Value {
    let ports = |ports: &[Port]| -> serde_json::Value {
        let port = |port: &Port| {
            json!({
                "name": port.name,
                "signal": signal(port),
                "resolution": resolution(port),
                "optional": port.optional,
                "looks_for": port.source,
                "about": port.about,
            })
        };
        ports.iter().map(port).collect()
    };
    let parameter = |def: &ParamDef| {
        json!({
            "name": def.name,
            "about": def.about,
            "takes": def.kind.to_string(),
            "default": def.default.to_json(),
            "range": def.range.map(|(low, high)| [low, high]),
            "unit": def.unit,
            "structural": def.structural,
        })
    };
    let bypass = |bypass: &Bypass| {
        let how = match bypass.how {
            BypassKind::Alias => "alias",
            BypassKind::Resample(Filter::Nearest) => "resample nearest",
            BypassKind::Resample(Filter::Linear) => "resample linear",
        };
        json!({"output": bypass.output, "input": bypass.input, "how": how})
    };
    let needs = pass.needs(&pass.defaults);
    let features = needs.features.iter_names().map(|(name, _)| name);
    let limits: serde_json::Map<_, _> = needs
        .beyond(&Needs::default().limits)
        .into_iter()
        .map(|(name, needed)| (name.to_owned(), needed.into()))
        .collect();
    json!({
        "name": pass.name,
        "about": pass.about,
        "inputs": ports(&pass.inputs),
        "outputs": ports(&pass.outputs),
        "parameters": pass.params().iter().map(parameter).collect::<Vec<_>>(),
        "schema": ParamDef::schema_of(pass.params()),
        "needs": {
            "host": needs.host,
            "features": features.collect::<Vec<_>>(),
            "limits": limits,
        },
        "bypass": pass.bypass.iter().map(bypass).collect::<Vec<_>>(),
        "readme": pass.readme,
    })
}
