//! `scumble scene`, as a shell sees it.

mod program;

use program::{scumble, text};

#[test]
fn info_as_json() {
    let run = scumble(&["scene", "info", "cornell", "--json", "--sky", "0.5,1,2"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["name"], "cornell");
    let sky = serde_json::json!({"kind": "constant", "radiance": [0.5, 1.0, 2.0]});
    assert_eq!(report["sky"], sky);
    assert_eq!(report["cameras"][0]["name"], "cornell");
}

#[test]
fn what_is_exported_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("new/cornell.glb").display().to_string();
    let run = scumble(&["scene", "export", "cornell", &file]);
    assert_eq!((run.code, text(&run.err)), (0, String::new()));
    let triangles = |scene: &str| {
        let run = scumble(&["scene", "info", scene, "--json"]);
        let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        report["triangles"].as_u64().unwrap()
    };
    assert_eq!(triangles(&file), triangles("cornell"));
}

#[test]
fn bad_scenes_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.glb").display().to_string();
    std::fs::write(&broken, "glTF").unwrap();
    let missing = "error: scene file `kichen.glb` does not exist; give a .glb or .gltf file or a \
                   built-in scene (atrium, cornell, furnace, moving)";
    let run = scumble(&["scene", "info", "kichen.glb"]);
    assert_eq!((run.code, text(&run.err)), (2, missing.into()));
    let run = scumble(&["scene", "info", &broken]);
    assert_eq!(run.code, 2);
    assert!(run.err.contains("broken.glb`: "), "{}", run.err);
    let out = folder.path().join("cornell.obj").display().to_string();
    let run = scumble(&["scene", "export", "cornell", &out]);
    let expected = format!("error: cannot export to `{out}`: the name must end in .glb or .gltf");
    assert_eq!((run.code, text(&run.err)), (2, expected));
    let below_a_file = format!("{broken}/cornell.glb");
    let run = scumble(&["scene", "export", "cornell", &below_a_file]);
    let expected = format!("error: `{broken}` is a file, not a folder to write to");
    assert_eq!((run.code, text(&run.err)), (2, expected));
    let run = scumble(&["scene", "info", "cornell", "--sky", "-1"]);
    assert_eq!(run.code, 2);
}
