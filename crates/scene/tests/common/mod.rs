//! What several tests need.
#![allow(dead_code)] // Each test binary uses its own part.

use std::path::PathBuf;

use scumble_scene::{LoadOptions, Scene, SceneError, load_bytes};
use serde_json::{Value, json};

/// A file of the shared test scenes, or `None`, said loudly, where they are not at hand.
pub fn shared_scene(name: &str) -> Option<PathBuf> {
    let path = scumble_scene::shared(format!("scenes/{name}"));
    if path.is_none() {
        eprintln!(
            "SKIPPED: scenes/{name} is not there; set SCUMBLE_SHARED to the folder that has it"
        );
    }
    path
}

/// A .glb of this JSON and binary chunk.
pub fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = (12 + 8 + text.len() + 8 + binary.len()) as u32;
    let mut out = b"glTF".to_vec();
    out.extend(2u32.to_le_bytes());
    out.extend(length.to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text);
    out.extend((binary.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}

/// Loads a file from memory.
pub fn read(bytes: &[u8]) -> Result<Scene, SceneError> {
    load_bytes(bytes, "test", &LoadOptions::default())
}

/// What is wrong with a file.
pub fn message(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

/// A mesh `Tri` of one triangle: three positions, then three u16 indices.
pub fn triangle() -> (Value, Vec<u8>) {
    let mut binary = Vec::new();
    for value in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        binary.extend(value.to_le_bytes());
    }
    for index in [0u16, 1, 2] {
        binary.extend(index.to_le_bytes());
    }
    let document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"name": "Tri", "primitives": [
            {"attributes": {"POSITION": 0}, "indices": 1},
        ]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6},
        ],
        "buffers": [{"byteLength": 42}],
    });
    (document, binary)
}

/// The file of [`triangle`], changed.
pub fn with(change: impl FnOnce(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    let (mut document, mut binary) = triangle();
    change(&mut document, &mut binary);
    glb(&document, &binary)
}
