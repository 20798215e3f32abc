//! `scumble schema`: the form of graph and experiment files as JSON Schema (draft 2020-12), for editors and tools that
//! write them.
//!
//! RON is to be read as JSON so: a struct or map is an object, a tuple or list an array, a word a string, and
//! `word(x)` the object `{"word": x}`.

use crate::args::{SchemaArgs, SchemaOf};
use crate::failure::Failure;
use crate::report;
use scumble::Registry;
use scumble_lab::Measure;
use serde_json::{Map, Value, json};

pub fn run(args: &SchemaArgs, registry: &Registry) -> Result<(), Failure> {
    report::json(&match args.of {
        SchemaOf::Graph => graph(registry),
        SchemaOf::Experiment => experiment(),
    });
    Ok(())
}

/// An object of these fields and no others.
fn fields(needed: &[&str], properties: Value) -> Value {
    json!({
        "type": "object",
        "properties": properties,
        "required": needed,
        "additionalProperties": false,
    })
}

fn about(mut schema: Value, text: &str) -> Value {
    schema["description"] = json!(text);
    schema
}

/// An object with any keys.
fn map_of(schema: Value) -> Value {
    json!({"type": "object", "additionalProperties": schema})
}

fn list_of(schema: Value) -> Value {
    json!({"type": "array", "items": schema})
}

/// A list that is not empty.
fn some_of(schema: Value) -> Value {
    json!({"type": "array", "items": schema, "minItems": 1})
}

fn text(about: &str) -> Value {
    json!({"type": "string", "description": about})
}

/// A whole number from 1 on.
fn count(about: &str) -> Value {
    json!({"type": "integer", "minimum": 1, "description": about})
}

/// The value of some parameter.
fn any_value() -> Value {
    json!({"type": ["boolean", "number", "string", "array"]})
}

fn whole(title: &str, mut schema: Value, definitions: Value) -> Value {
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!(title);
    schema["$defs"] = definitions;
    schema
}

/// A graph file, with the parameters of every registered pass.
fn graph(registry: &Registry) -> Value {
    let mut passes: Vec<_> = registry.iter().collect();
    passes.sort_by_key(|pass| &pass.name);
    let with_of = passes.iter().map(|pass| {
        let params = pass.params().iter();
        let params: Map<String, Value> = params
            .map(|def| (def.name.to_owned(), def.schema()))
            .collect();
        let inputs = pass.inputs.iter();
        let inputs: Map<String, Value> = inputs
            .map(|port| (port.name.to_string(), text(port.about)))
            .collect();
        json!({
            "if": {"properties": {"use": {"const": pass.name}}, "required": ["use"]},
            "then": {"properties": {
                "with": fields(&[], Value::Object(params)),
                "in": fields(&[], Value::Object(inputs)),
            }},
        })
    });
    let mut pass = fields(
        &["use"],
        json!({
            "use": text("A registered pass, or the path of a graph file or WGSL file, relative to this file"),
            "as": text("Its name here; without it that of its kind"),
            "with": about(map_of(any_value()), "Parameters; angles in degrees"),
            "in": about(map_of(text("")), "What each input reads: `pass.port`, an input of the graph, with `@prev` last frame's"),
        }),
    );
    pass["allOf"] = with_of.collect();
    let signals = registry.signals().iter().map(|signal| signal.name());
    let signals: Vec<&str> = ["any"].into_iter().chain(signals).collect();
    let input = fields(
        &["signal"],
        json!({
            "signal": {"enum": signals},
            "resolution": {"anyOf": [{"enum": ["full", "grid", "any"]}, fields(&["grid"], json!({"grid": count("Spacing in pixels")}))]},
            "source": text("The name that is looked for where nothing is wired"),
            "optional": {"type": "boolean"},
        }),
    );
    let insert = fields(
        &["pass", "on"],
        json!({"pass": {"$ref": "#/$defs/pass"}, "on": text("The edge that it is put on: `a.port -> b.port`")}),
    );
    let names = |about_it: &str| {
        about(
            list_of(text("A pass, or a pattern such as `*/jbu`")),
            about_it,
        )
    };
    let file = fields(
        &["version"],
        json!({
            "version": {"const": 1},
            "about": text("A sentence"),
            "sky": {"enum": ["Direct", "Indirect"], "description": "On which side the sky's light stands"},
            "extends": text("The graph that this one is a variant of"),
            "inputs": about(map_of(json!({"$ref": "#/$defs/input"})), "What it is fed when it is used as a pass, or by a host"),
            "passes": list_of(json!({"$ref": "#/$defs/pass"})),
            "outputs": about(map_of(text("`pass.port`")), "What it gives; `display` and `linear` become files"),
            "set": about(map_of(any_value()), "Parameters as `pass.parameter`"),
            "bypass": names("Passes that are left out"),
            "insert": list_of(insert),
            "replace": map_of(json!({"$ref": "#/$defs/pass"})),
            "remove": names("Passes that are taken away"),
        }),
    );
    whole(
        "Graph file of Scumble",
        file,
        json!({"pass": pass, "input": input}),
    )
}

/// An experiment file.
fn experiment() -> Value {
    let changes = || about(map_of(any_value()), "Parameters as `pass.parameter`");
    let passes = |about_it: &str| {
        about(
            list_of(text("A pass, or a pattern such as `*/jbu`")),
            about_it,
        )
    };
    let graph = json!({"anyOf": [
        text("The path of a graph, relative to the experiment"),
        fields(&["graph"], json!({
            "graph": text("The path of a graph, relative to the experiment"),
            "name": text("What results call it"),
            "set": changes(),
            "bypass": passes("Passes that are left out"),
        })),
    ]});
    let factor = json!({"anyOf": [
        text("A pass that is bypassed"),
        fields(&["set"], json!({"set": changes()})),
    ]});
    let ablate = fields(
        &[],
        json!({
            "one_out": passes("Each is bypassed by itself"),
            "one_in": passes("All are bypassed, then all but each"),
            "factorial": {"type": "array", "items": factor, "maxItems": 6, "description": "Made in every combination"},
        }),
    );
    let camera_number = json!({"type": "integer", "minimum": 0});
    let metres = json!({"type": "number"});
    let orbit = fields(
        &["degrees"],
        json!({"camera": camera_number, "degrees": {"type": "number"}, "distance": metres}),
    );
    let camera = fields(
        &["frames"],
        json!({
            "name": text("What results call it"),
            "still": about(camera_number, "The number of a camera of the scene"),
            "orbit": about(orbit, "About the vertical axis through a point ahead"),
            "frames": count("How many"),
            "frame_time": {"type": "number", "minimum": 0, "description": "Seconds of animation per frame"},
        }),
    );
    let metrics: Vec<&str> = Measure::all().map(Measure::word).collect();
    let amount = json!({"type": "number", "exclusiveMinimum": 0, "maximum": 65536});
    let seed = json!({"type": "integer", "minimum": 0, "maximum": u32::MAX});
    let properties = json!({
        "version": {"const": 1},
        "about": text("The question"),
        "scenes": about(some_of(text("A built-in scene, or a glTF file")), "The scenes"),
        "material_override": {"const": "Lambert"},
        "base": {"$ref": "#/$defs/graph"},
        "compare": list_of(json!({"$ref": "#/$defs/graph"})),
        "ablate": ablate,
        "sweep": about(map_of(some_of(any_value())), "Parameters of the base and their values, in every combination"),
        "camera": some_of(camera),
        "seeds": {"anyOf": [
            {"type": "integer", "minimum": 1, "maximum": 10_000},
            some_of(seed),
        ]},
        "budget": {"anyOf": [
            {"const": "None"},
            fields(&["EqualRays"], json!({"EqualRays": about(amount.clone(), "Paths per pixel and frame")})),
            fields(&["EqualTime"], json!({"EqualTime": about(amount, "Milliseconds of a frame")})),
        ]},
        "reference": fields(&[], json!({
            "samples": count("Paths per pixel"),
            "every": count("One at every so many frames"),
            "graph": text("The graph, `graphs/reference.ron` unless it is given"),
            "files": text("Images instead: a pattern with `{scene}`, `{camera}` and `####`"),
        })),
        "metrics": some_of(json!({"enum": metrics})),
        "size": {"type": "array", "items": count("Pixels"), "minItems": 2, "maxItems": 2},
    });
    let quick: Map<String, Value> = scumble_lab::Experiment::QUICK
        .iter()
        .map(|name| ((*name).to_owned(), properties[name].clone()))
        .collect();
    let mut properties = properties;
    properties["quick"] = about(fields(&[], Value::Object(quick)), "What `--quick` changes");
    let needed = [
        "version",
        "scenes",
        "base",
        "camera",
        "seeds",
        "reference",
        "metrics",
        "size",
    ];
    whole(
        "Experiment file of Scumble",
        fields(&needed, properties),
        json!({"graph": graph}),
    )
}
