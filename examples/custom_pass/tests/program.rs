//! The program with one pass more, as a shell sees it.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

fn program(args: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_custom_pass"));
    let run = command
        .args(args)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")))
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{args:?}: {error}");
    String::from_utf8(run.stdout).unwrap()
}

#[test]
fn it_is_among_the_passes_with_its_parameters_and_its_signal() {
    let all = program(&["passes"]);
    assert!(
        all.contains("diffusion ") && all.contains("atrous "),
        "{all}"
    );
    let told: Value = serde_json::from_str(&program(&["passes", "diffusion", "--json"])).unwrap();
    assert_eq!(told["outputs"][1]["signal"], "conduction");
    assert_eq!(told["parameters"][1]["name"], "lambda");
    assert_eq!(told["schema"]["properties"]["lambda"]["maximum"], 0.25);
}

#[test]
fn it_is_in_the_schema_of_graphs() {
    let schema = program(&["schema", "graph"]);
    assert!(
        schema.contains("\"diffusion\"") && schema.contains("\"kappa\""),
        "{schema}"
    );
}

#[test]
fn a_graph_uses_it() {
    let wired = program(&["check", "diffused.ron"]);
    assert!(
        wired.contains("recombine") && wired.contains("irradiance <- diffusion.value"),
        "{wired}"
    );
}
