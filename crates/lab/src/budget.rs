//! What a graph may spend: paths per pixel, through the one parameter that each tracer marks as its budget.

use scumble::{ParamDef, ParamKind, Resolved, ResolvedPass, Source, Value};

/// What a tracer spends.
#[derive(Clone, Debug, PartialEq)]
pub struct Spending {
    /// The pass.
    pub pass: String,
    /// Paths per pixel of the image and frame; where a mask that is no budget of its own leaves pixels out, per
    /// pixel that it leaves in.
    pub paths: f64,
    /// Whether such a mask does.
    pub masked: bool,
}

/// The parameter of a pass that is its budget and of that kind.
pub(crate) fn mark(pass: &ResolvedPass, kind: fn(ParamKind) -> bool) -> Option<&'static str> {
    let marked = |def: &&ParamDef| def.budget && kind(def.kind);
    let def = pass.params.defs().iter().find(marked);
    def.map(|def| def.name)
}

pub(crate) fn is_count(kind: ParamKind) -> bool {
    matches!(kind, ParamKind::Int { .. })
}

fn is_rate(kind: ParamKind) -> bool {
    matches!(kind, ParamKind::Float)
}

/// The pass that makes the mask of a tracer, if there is one.
fn masker(graph: &Resolved, tracer: usize) -> Option<usize> {
    let inputs = &graph.passes[tracer].inputs;
    let (_, source) = inputs.iter().find(|(name, _)| name == "mask")?;
    match source.as_ref()? {
        Source::Port { pass, .. } => Some(*pass),
        Source::GraphInput { .. } => None,
    }
}

/// Paths of one unit of a tracer's count, per pixel of the image.
fn density(pass: &ResolvedPass) -> f64 {
    1.0 / (f64::from(pass.grid.max(1)) * f64::from(pass.grid.max(1)))
}

/// The parameters that [`spend`] sets, as `pass.parameter`.
pub fn budget_params(graph: &Resolved) -> Vec<String> {
    let of = |pass: &ResolvedPass| {
        let name = mark(pass, |kind| is_count(kind) || is_rate(kind))?;
        Some(format!("{}.{name}", pass.name))
    };
    graph.passes.iter().filter_map(of).collect()
}

/// What every tracer of a graph spends.
pub fn spending(graph: &Resolved) -> Vec<Spending> {
    let tracers = graph.passes.iter().enumerate().filter(|(_, p)| !p.bypassed);
    let of = |(i, pass): (usize, &ResolvedPass)| {
        let Some(Value::Int(count)) = pass.params.get(mark(pass, is_count)?) else {
            return None;
        };
        let masker = masker(graph, i).map(|m| &graph.passes[m]);
        let rate = masker.and_then(|m| m.params.get(mark(m, is_rate)?));
        let rate_or_whole = match rate {
            Some(Value::Float(rate)) => rate,
            _ => 1.0,
        };
        Some(Spending {
            pass: pass.name.clone(),
            paths: count as f64 * density(pass) * rate_or_whole,
            masked: masker.is_some() && rate.is_none(),
        })
    };
    tracers.filter_map(of).collect()
}

/// Makes every tracer spend `paths` per pixel of the image and frame: its count is that over what one unit of
/// it is worth (a grid of spacing n traces a pixel of n^2), rounded, at least 1. Below 1 the rate of a mask
/// that has one as its budget is `paths`. Gives what is spent then, which is not `paths` where the
/// parameters' ranges end.
pub fn spend(graph: &mut Resolved, paths: f64) -> Vec<Spending> {
    for i in 0..graph.passes.len() {
        let Some(count) = mark(&graph.passes[i], is_count) else {
            continue;
        };
        let wanted = paths / density(&graph.passes[i]);
        if let Some(m) = masker(graph, i)
            && let Some(rate) = mark(&graph.passes[m], is_rate)
        {
            let value = Value::Float(wanted.min(1.0));
            set(&mut graph.passes[m], rate, value);
        }
        let value = Value::Int(wanted.round().max(1.0) as i64);
        set(&mut graph.passes[i], count, value);
    }
    spending(graph)
}

/// What [`spend`] sets, as `pass.parameter` and value.
pub fn spent_params(graph: &Resolved, paths: f64) -> Vec<(String, Value)> {
    let mut graph = graph.clone();
    spend(&mut graph, paths);
    budget_values(&graph)
}

/// The parameters that [`spend`] sets, with their values.
pub(crate) fn budget_values(graph: &Resolved) -> Vec<(String, Value)> {
    let of = |param: String| {
        let (pass, name) = param.rsplit_once('.')?;
        let value = graph.pass(pass)?.1.params.get(name)?;
        Some((param, value))
    };
    budget_params(graph).into_iter().filter_map(of).collect()
}

/// Sets a parameter as near to a value as its range allows.
fn set(pass: &mut ResolvedPass, name: &str, value: Value) {
    let range = pass.params.def(name).and_then(|def| def.range);
    let (low, high) = range.unwrap_or((f64::MIN, f64::MAX));
    let value = match value {
        Value::Int(n) => Value::Int(n.clamp(low as i64, high as i64)),
        Value::Float(x) => Value::Float(x.clamp(low, high)),
        other => other,
    };
    // Inside its range a number is taken.
    let _ = pass.params.set(name, &value);
}

#[cfg(test)]
mod tests {
    use super::*;
    use scumble::{Edits, resolve_text};

    fn graph(passes: &str) -> Resolved {
        let text = format!(
            "(version: 1, passes: [(use: \"gbuffer\"), {passes}], outputs: {{\"linear\": \"recombine.radiance\"}})"
        );
        let registry = scumble_passes::registry();
        match resolve_text("t.ron", &text, &registry, &Edits::default()) {
            Ok(graph) => graph,
            Err(mistakes) => panic!("{mistakes}"),
        }
    }

    const TRACED: &str = r#"(use: "sample-mask"), (use: "path-trace", in: {"mask": "sample-mask.mask"}),
        (use: "recombine", in: {"irradiance": "path-trace.irradiance"})"#;

    #[test]
    fn a_rate_below_one_and_samples_above() {
        let mut traced = graph(TRACED);
        for (paths, samples) in [(0.25, 1), (1.0, 1), (3.0, 3)] {
            let spent = spend(&mut traced, paths);
            assert_eq!(spent.len(), 1);
            // The rate is an f32, which holds these exactly.
            assert_eq!(spent[0].paths, paths);
            assert!(!spent[0].masked);
            let (_, pass) = traced.pass("path-trace").unwrap();
            assert_eq!(pass.params.get("samples"), Some(Value::Int(samples)));
        }
        assert_eq!(
            budget_params(&traced),
            ["sample-mask.rate", "path-trace.samples"]
        );
    }

    #[test]
    fn a_grid_spends_its_spacing_squared() {
        let mut sparse = graph(
            r#"(use: "direct-lighting"), (use: "sparse-indirect", with: (spacing: 8)),
            (use: "jbu", in: {"value": "sparse-indirect.irradiance", "grid_normal": "sparse-indirect.normal",
                "grid_view_z": "sparse-indirect.view_z", "pixel": "sparse-indirect.pixel"}),
            (use: "recombine", in: {"irradiance": "jbu.value", "direct": "direct-lighting.radiance"})"#,
        );
        let spent = spend(&mut sparse, 0.5);
        let paths = |name: &str| spent.iter().find(|s| s.pass == name).unwrap().paths;
        // 32 paths at one pixel of 64; one at each is the least that direct light can be had for.
        assert_eq!(paths("sparse-indirect"), 0.5);
        assert_eq!(paths("direct-lighting"), 1.0);
    }
}
