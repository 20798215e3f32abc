//! What several tests need.
#![allow(dead_code)] // Each test binary uses its own part.

use std::path::PathBuf;

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
pub fn glb(json: &serde_json::Value, binary: &[u8]) -> Vec<u8> {
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
