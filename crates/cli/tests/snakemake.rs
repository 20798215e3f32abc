//! `workflows/Snakefile` on two local jobs: the results are those of one run.
//!
//! Needs Snakemake: that of SCUMBLE_SNAKEMAKE, else `snakemake`.

mod program;

use program::experiment::{Lab, results};
use std::path::Path;
use std::process::Command;

#[test]
fn shards_on_snakemake_are_the_whole() {
    let snakemake = std::env::var("SCUMBLE_SNAKEMAKE").unwrap_or_else(|_| "snakemake".into());
    let version = Command::new(&snakemake).arg("--version").output();
    if !version.is_ok_and(|run| run.status.success()) {
        eprintln!(
            "SKIPPED: there is no `{snakemake}`: `pip install snakemake`, and name it in SCUMBLE_SNAKEMAKE"
        );
        return;
    }
    let lab = Lab::new(2);
    let snakefile = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../workflows/Snakefile");
    let run = |jobs: &str| {
        let mut command = Command::new(&snakemake);
        command
            .arg("--snakefile")
            .arg(&snakefile)
            .args(["--cores", jobs, "--config"]);
        command.args([
            format!("experiment={}", lab.at("e.ron")),
            format!("output={}", lab.at("out")),
            format!("scumble={}", env!("CARGO_BIN_EXE_scumble")),
            "shards=2".to_owned(),
        ]);
        // It keeps notes in a folder beside where it runs, and a cache at home.
        let done = command
            .current_dir(lab.path(""))
            .env("XDG_CACHE_HOME", lab.at("cache"))
            .output()
            .unwrap();
        (
            done.status.success(),
            String::from_utf8_lossy(&done.stderr).into_owned(),
        )
    };
    let (fine, said) = run("2");
    assert!(fine, "{said}");
    assert_eq!(lab.ablate("whole", &["--quiet"]).code, 0);
    assert_eq!(results(&lab.path("out")), results(&lab.path("whole")));
    for shard in ["1", "2"] {
        let of_part = results(&lab.path("out/shards").join(shard));
        assert_eq!(of_part["runs"].as_array().unwrap().len(), 2, "a half each");
    }

    // What gives nothing fails the workflow, and the rest is there.
    lab.change(r#"["cornell"]"#, r#"["nowhere.glb", "cornell"]"#);
    let (fine, said) = run("2");
    assert!(!fine && said.contains("nowhere.glb"), "{said}");
    let found = results(&lab.path("out"));
    assert_eq!(found["runs"].as_array().unwrap().len(), 4);
    assert_eq!(found["failures"].as_array().unwrap().len(), 1);
}
