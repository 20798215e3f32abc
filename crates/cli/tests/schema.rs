//! `scumble schema` and `scumble completions`: the schemas take every file of the repository, and not what the program refuses.

mod program;

use program::scumble;
use scumble::diagnostics::SourceFile;
use scumble::file::{Node, Shape};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// RON as JSON, in the way that the schemas say.
fn to_json(node: &Node) -> Value {
    let list = |nodes: &[Node]| nodes.iter().map(to_json).collect();
    match node.shape() {
        Shape::Fields(fields) => fields
            .iter()
            .map(|(name, node)| (name.value.clone(), to_json(node)))
            .collect(),
        Shape::Map(entries) => {
            let key = |node: &Node| match node.shape() {
                Shape::Text(text) => text,
                other => panic!("{other:?} is a key"),
            };
            entries.iter().map(|(k, v)| (key(k), to_json(v))).collect()
        }
        Shape::Tuple(nodes) | Shape::List(nodes) => list(&nodes),
        Shape::Text(text) | Shape::Word(text) => json!(text),
        Shape::Bool(value) => json!(value),
        Shape::Int(value) => json!(value),
        Shape::Float(value) => json!(value),
        Shape::Other => {
            let text = node.span().text();
            let word = text.split('(').next().unwrap().trim();
            let inside = node.argument_of(word).unwrap_or_else(|| panic!("{text}"));
            let (inside, _) = Node::of_file(&SourceFile::new("inside", inside.to_owned())).unwrap();
            Value::Object(Map::from_iter([(word.to_owned(), to_json(&inside))]))
        }
    }
}

/// What is wrong with a value: the keywords of JSON Schema that the schemas use, and a panic at any other.
fn wrong(schema: &Value, value: &Value, whole: &Value, at: &str) -> Option<String> {
    let all = |parts: &Value| parts.as_array().unwrap().clone();
    let fits = |part: &Value| wrong(part, value, whole, at).is_none();
    for (keyword, says) in schema.as_object().unwrap() {
        let number = value.as_f64();
        let fine = match keyword.as_str() {
            "description" | "default" | "title" | "$schema" | "$defs" | "then" => true,
            annotation if annotation.starts_with("x-") => true,
            "$ref" => {
                let name = says.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
                if let Some(inner) = wrong(&whole["$defs"][name], value, whole, at) {
                    return Some(inner);
                }
                true
            }
            "type" => match says {
                Value::Array(types) => types.iter().any(|t| is(value, t)),
                one => is(value, one),
            },
            "const" => value == says,
            "enum" => all(says).contains(value),
            "minimum" => number.is_none_or(|n| n >= says.as_f64().unwrap()),
            "maximum" => number.is_none_or(|n| n <= says.as_f64().unwrap()),
            "exclusiveMinimum" => number.is_none_or(|n| n > says.as_f64().unwrap()),
            "minItems" => value
                .as_array()
                .is_none_or(|v| v.len() as u64 >= says.as_u64().unwrap()),
            "maxItems" => value
                .as_array()
                .is_none_or(|v| v.len() as u64 <= says.as_u64().unwrap()),
            "anyOf" => all(says).iter().any(fits),
            "oneOf" => all(says).iter().filter(|part| fits(part)).count() == 1,
            "allOf" => {
                if let Some(inner) = all(says)
                    .iter()
                    .find_map(|part| wrong(part, value, whole, at))
                {
                    return Some(inner);
                }
                true
            }
            "if" => match fits(says) {
                true => return wrong(&schema["then"], value, whole, at),
                false => true,
            },
            "required" => all(says)
                .iter()
                .all(|name| value.get(name.as_str().unwrap()).is_some()),
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    if let Some(inner) = wrong(says, item, whole, &format!("{at}[{i}]")) {
                        return Some(inner);
                    }
                }
                true
            }
            "properties" | "additionalProperties" => {
                for (name, item) in value.as_object().into_iter().flatten() {
                    let at = format!("{at}.{name}");
                    let known = schema.get("properties").and_then(|p| p.get(name));
                    let inner = match (keyword.as_str(), known, says) {
                        ("properties", Some(of), _) => wrong(of, item, whole, &at),
                        ("additionalProperties", None, Value::Bool(false)) => {
                            Some(format!("{at} is unknown"))
                        }
                        ("additionalProperties", None, of) => wrong(of, item, whole, &at),
                        _ => None,
                    };
                    if inner.is_some() {
                        return inner;
                    }
                }
                true
            }
            other => panic!("this test does not know `{other}`"),
        };
        if !fine {
            return Some(format!("{at}: {value} against {keyword} {says}"));
        }
    }
    None
}

fn is(value: &Value, kind: &Value) -> bool {
    match kind.as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        other => panic!("{other} is no type"),
    }
}

fn schema(of: &str) -> Value {
    let run = scumble(&["schema", of]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    serde_json::from_str(&run.out).unwrap()
}

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(folder);
    let paths = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    paths
        .filter(|path| path.extension().is_some_and(|e| e == "ron"))
        .collect()
}

#[test]
fn every_file_of_the_repository_conforms() {
    for (of, folder, least) in [
        ("graph", "graphs", 25),
        ("experiment", "graphs/experiments", 4),
    ] {
        let schema = schema(of);
        let files = files(folder);
        assert!(files.len() >= least, "only {} files", files.len());
        for file in files {
            let (node, _) = Node::read(&file).unwrap();
            let mistake = wrong(&schema, &to_json(&node), &schema, "");
            assert_eq!(mistake, None, "{}", file.display());
        }
    }
}

/// What the program refuses: a name that is not there, a value out of range, a field that is missing.
#[test]
fn mistakes_do_not_conform() {
    let graph = schema("graph");
    let pass = |text: &str| {
        let text = format!("(version: 1, passes: [{text}])");
        let (node, _) = Node::of_file(&SourceFile::new("a.ron", text)).unwrap();
        wrong(&graph, &to_json(&node), &graph, "")
    };
    assert_eq!(
        pass(r#"(use: "sparse-indirect", with: (spacing: 8))"#),
        None
    );
    for (text, part) in [
        (
            r#"(use: "sparse-indirect", with: (spacinng: 8))"#,
            "spacinng is unknown",
        ),
        (r#"(use: "sparse-indirect", with: (spacing: 0))"#, "minimum"),
        (
            r#"(use: "sparse-indirect", in: {"colour": "a.b"})"#,
            "colour is unknown",
        ),
        (r#"(as: "a")"#, "required"),
        (r#"(use: "taa", name: "a")"#, "name is unknown"),
    ] {
        let mistake = pass(text).unwrap_or_else(|| panic!("{text} conforms"));
        assert!(mistake.contains(part), "{text}: {mistake}");
    }
    let experiment = schema("experiment");
    let text = std::fs::read_to_string(&files("graphs/experiments")[0]).unwrap();
    for (from, to) in [
        ("metrics: [", "metrics: [Lpips, "),
        ("version: 1", "version: 2"),
        ("seeds: ", "seeds: -"),
        ("camera: [", "kamera: ["),
    ] {
        assert!(text.contains(from));
        let changed = SourceFile::new("e.ron", text.replace(from, to));
        let (node, _) = Node::of_file(&changed).unwrap();
        assert_ne!(
            wrong(&experiment, &to_json(&node), &experiment, ""),
            None,
            "{to}"
        );
    }
}

/// Every field that the schema of experiments names is one that the program knows.
#[test]
fn fields_of_the_schema_are_those_of_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("e.ron");
    let refused = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let run = scumble(&["ablate", path.to_str().unwrap(), "--dry-run"]);
        assert_eq!(run.code, 2);
        run.err.contains("has no field")
    };
    let schema = schema("experiment");
    let names = |schema: &Value| -> Vec<String> {
        let properties = schema["properties"].as_object().unwrap();
        properties.keys().cloned().collect()
    };
    let fields = |names: &[String]| {
        let fields = names.iter().map(|name| format!("{name}: \"\""));
        fields.collect::<Vec<_>>().join(", ")
    };
    let top: Vec<String> = names(&schema)
        .into_iter()
        .filter(|n| n != "version" && n != "quick")
        .collect();
    let quick = names(&schema["properties"]["quick"]);
    assert!(!refused(&format!(
        "(version: 1, {}, quick: ({}))",
        fields(&top),
        fields(&quick)
    )));
    assert!(refused("(version: 1, quick: (version: 1))"));
}

#[test]
fn shells_complete_every_verb() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let run = scumble(&["completions", shell]);
        assert_eq!((run.code, run.err.as_str()), (0, ""));
        for word in ["ablate", "compare", "schema", "fail-above"] {
            assert!(run.out.contains(word), "{shell} does not complete {word}");
        }
    }
}
