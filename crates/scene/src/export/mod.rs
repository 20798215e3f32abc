//! Writing a scene as glTF 2.0, such that loading it gives the same scene again.
//!
//! The sky goes into the extras of the scene. Images are PNG: inside of a .glb, beside a .gltf.

mod binary;
mod material;
mod nodes;

use std::path::Path;

use serde_json::{Value, json};

use self::binary::Binary;
use crate::error::SceneError;
use crate::gltf::SKY_KEY;
use crate::model::{Scene, Sky};

/// Writes `scene` as .glb or as .gltf with its .bin and .png files beside it.
///
/// # Errors
/// When the name ends otherwise or a file cannot be written.
pub fn export(scene: &Scene, path: &Path) -> Result<(), SceneError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("glb") => write(path, &to_glb(scene)?),
        Some("gltf") => write_gltf(scene, path),
        _ => Err(SceneError::Format {
            path: path.to_owned(),
        }),
    }
}

/// `scene` as the bytes of a .glb.
///
/// # Errors
/// When a texture cannot be encoded.
pub fn to_glb(scene: &Scene) -> Result<Vec<u8>, SceneError> {
    let mut binary = Binary::default();
    let mut images = Vec::new();
    for texture in &scene.textures {
        let view = binary.view(&material::png(texture)?);
        images.push(json!({"name": texture.name, "mimeType": "image/png", "bufferView": view}));
    }
    let document = document(scene, &mut binary, images, None);
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let bytes = binary.bytes;
    let mut out = Vec::with_capacity(28 + text.len() + bytes.len());
    out.extend(b"glTF");
    out.extend(2u32.to_le_bytes());
    out.extend(((28 + text.len() + bytes.len()) as u32).to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text);
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(bytes);
    Ok(out)
}

fn write_gltf(scene: &Scene, path: &Path) -> Result<(), SceneError> {
    let stem = path
        .file_stem()
        .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let beside = |name: &str| path.with_file_name(name);
    let mut binary = Binary::default();
    let mut images = Vec::new();
    for (i, texture) in scene.textures.iter().enumerate() {
        let name = format!("{stem}.{i}.png");
        write(&beside(&name), &material::png(texture)?)?;
        images.push(json!({"name": texture.name, "uri": uri(&name)}));
    }
    let name = format!("{stem}.bin");
    let document = document(scene, &mut binary, images, Some(uri(&name)));
    write(&beside(&name), &binary.bytes)?;
    write(path, document.to_string().as_bytes())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), SceneError> {
    std::fs::write(path, bytes).map_err(|error| SceneError::Write {
        path: path.to_owned(),
        error,
    })
}

fn uri(name: &str) -> String {
    let keep = |byte: u8| byte.is_ascii_alphanumeric() || b".-_".contains(&byte);
    name.bytes()
        .map(|byte| {
            if keep(byte) {
                char::from(byte).to_string()
            } else {
                format!("%{byte:02X}")
            }
        })
        .collect()
}

fn document(scene: &Scene, binary: &mut Binary, images: Vec<Value>, uri: Option<String>) -> Value {
    let mut extensions = Vec::new();
    let materials: Vec<Value> = scene
        .materials
        .iter()
        .map(|material| material::material(material, &mut extensions))
        .collect();
    let nodes::Parts {
        nodes,
        roots,
        meshes,
        cameras,
        lights,
        skins,
        animations,
    } = nodes::parts(scene, binary);
    let mut root_scene = json!({"name": scene.name, "nodes": roots});
    if let Some(sky) = sky(&scene.sky, binary) {
        root_scene["extras"] = json!({SKY_KEY: sky});
    }
    let mut document = json!({
        "asset": {"version": "2.0", "generator": "scumble"},
        "scene": 0,
        "scenes": [root_scene],
    });
    if !lights.is_empty() {
        extensions.push("KHR_lights_punctual");
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": lights}});
    }
    extensions.sort_unstable();
    extensions.dedup();
    let (samplers, textures) = material::textures(&scene.textures);
    let mut buffer = json!({"byteLength": binary.bytes.len()});
    if let Some(uri) = uri {
        buffer["uri"] = json!(uri);
    }
    let extensions: Vec<Value> = extensions.into_iter().map(Value::from).collect();
    for (key, list) in [
        ("extensionsUsed", extensions),
        ("nodes", nodes),
        ("meshes", meshes),
        ("materials", materials),
        ("textures", textures),
        ("samplers", samplers),
        ("images", images),
        ("cameras", cameras),
        ("skins", skins),
        ("animations", animations),
        ("accessors", std::mem::take(&mut binary.accessors)),
        ("bufferViews", std::mem::take(&mut binary.views)),
        ("buffers", vec![buffer]),
    ] {
        // glTF forbids empty lists.
        if !list.is_empty() {
            document[key] = Value::Array(list);
        }
    }
    document
}

fn sky(sky: &Sky, binary: &mut Binary) -> Option<Value> {
    if sky.is_black() {
        return None;
    }
    Some(match sky {
        Sky::Constant(radiance) => json!({"radiance": radiance.to_array()}),
        Sky::Equirect {
            width,
            height,
            rgb,
            scale,
            rotation,
        } => json!({
            "accessor": binary.floats(rgb),
            "width": width,
            "height": height,
            "scale": scale,
            "rotation": rotation,
        }),
    })
}
