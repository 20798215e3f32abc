//! From bytes to a checked JSON document and its binary buffers.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use ::gltf::json;
use ::gltf::json::validation::{Error as Flaw, Validate};
use serde::Deserialize;

use super::uri;
use crate::error::SceneError;

/// Extensions without which a file may not be shown, and which are honoured here.
const SUPPORTED: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// A parsed file whose JSON refers only to what is there. Buffers are not checked.
pub(super) struct File<'a> {
    pub(super) root: json::Root,
    pub(super) more: More,
    pub(super) buffers: Vec<Cow<'a, [u8]>>,
    /// Where relative references start; `None` for a file in memory.
    pub(super) folder: Option<PathBuf>,
}

/// What the `gltf` crate does not keep.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct More {
    pub(super) scenes: Vec<MoreScene>,
    pub(super) materials: Vec<MoreMaterial>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct MoreScene {
    pub(super) extras: serde_json::Value,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct MoreMaterial {
    pub(super) extensions: serde_json::Map<String, serde_json::Value>,
    pub(super) normal_texture: MoreTexture,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct MoreTexture {
    pub(super) extensions: MoreTextureExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct MoreTextureExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(super) transform: Option<json::extensions::texture::TextureTransform>,
}

/// Reads a .glb or .gltf from memory.
pub(super) fn parse<'a>(bytes: &'a [u8], folder: Option<&Path>) -> Result<File<'a>, SceneError> {
    let (text, binary) = if bytes.starts_with(b"glTF") {
        split(bytes)?
    } else {
        (bytes, None)
    };
    let as_error = |error: serde_json::Error| SceneError::not_gltf(format!("JSON, {error}"));
    let mut root: json::Root = serde_json::from_slice(text).map_err(as_error)?;
    let more = serde_json::from_slice(text).map_err(as_error)?;
    if let Some(extension) = root
        .extensions_required
        .iter()
        .find(|name| !SUPPORTED.contains(&name.as_str()))
    {
        return Err(SceneError::UnsupportedExtension {
            extension: extension.clone(),
            supported: SUPPORTED.join(", "),
        });
    }
    // The crate knows fewer extensions than its features parse.
    root.extensions_required.clear();
    validate(&root)?;
    let buffers = buffers(&root, binary, folder)?;
    Ok(File {
        root,
        more,
        buffers,
        folder: folder.map(Path::to_owned),
    })
}

/// The JSON and binary chunks of a .glb (glTF 2.0, section 4.4).
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), SceneError> {
    let word = |at: usize| -> Result<u32, SceneError> {
        match bytes.get(at..at + 4) {
            Some(&[a, b, c, d]) => Ok(u32::from_le_bytes([a, b, c, d])),
            _ => Err(truncated("header", at + 4, bytes.len())),
        }
    };
    let version = word(4)?;
    if version != 2 {
        return Err(SceneError::not_gltf(format!(
            "the container has version {version}, only 2 is known"
        )));
    }
    let length = word(8)? as usize;
    if length > bytes.len() {
        return Err(truncated("container", length, bytes.len()));
    }
    let chunk = |at: usize, kind: &[u8; 4], part: &str| -> Result<&[u8], SceneError> {
        let length = word(at)? as usize;
        let found = word(at + 4)?.to_le_bytes();
        if found != *kind {
            return Err(SceneError::not_gltf(format!(
                "the {part} chunk at byte {at} has another type"
            )));
        }
        let rest = &bytes[at + 8..];
        rest.get(..length)
            .ok_or_else(|| truncated(&format!("{part} chunk"), length, rest.len()))
    };
    let text = chunk(12, b"JSON", "JSON")?;
    let at = 20 + text.len();
    if at >= length {
        return Ok((text, None));
    }
    Ok((text, Some(chunk(at, b"BIN\0", "binary")?)))
}

fn truncated(part: &str, expected: usize, found: usize) -> SceneError {
    SceneError::Truncated {
        part: part.to_owned(),
        expected: expected as u64,
        found: found as u64,
    }
}

/// Schema and references. Lists the first flaw and how many more there are.
fn validate(root: &json::Root) -> Result<(), SceneError> {
    // The crate looks up positions before it checks that they exist.
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let mut attributes = primitive.attributes.values();
            if let Some(index) = attributes.find(|a| a.value() >= root.accessors.len()) {
                return Err(SceneError::not_gltf(format!(
                    "meshes[{m}].primitives[{p}]: accessor {} does not exist",
                    index.value()
                )));
            }
        }
    }
    let mut flaws: Vec<String> = Vec::new();
    root.validate(root, json::Path::new, &mut |path, flaw| {
        let path = path().to_string();
        // Vertex attributes of applications are legal, and nothing here needs min and max.
        let harmless =
            path.contains("attributes") && flaw == Flaw::Invalid && !path.contains("componentType")
                || path.ends_with(".min")
                || path.ends_with(".max");
        if !harmless {
            flaws.push(format!("{path}: {flaw}"));
        }
    });
    match flaws.as_slice() {
        [] => Ok(()),
        [one] => Err(SceneError::not_gltf(one.clone())),
        [first, rest @ ..] => Err(SceneError::not_gltf(format!(
            "{first}, and {} more",
            rest.len()
        ))),
    }
}

/// The bytes of each buffer, at least as long as the file claims.
fn buffers<'a>(
    root: &json::Root,
    binary: Option<&'a [u8]>,
    folder: Option<&Path>,
) -> Result<Vec<Cow<'a, [u8]>>, SceneError> {
    let mut list = Vec::with_capacity(root.buffers.len());
    for (i, buffer) in root.buffers.iter().enumerate() {
        let bytes: Cow<'a, [u8]> = match (&buffer.uri, binary) {
            (Some(uri), _) => match uri::resolve(uri, folder, &format!("buffer {i}"))? {
                uri::Resolved::Data(bytes) => Cow::Owned(bytes),
                uri::Resolved::File(path) => match std::fs::read(&path) {
                    Ok(bytes) => Cow::Owned(bytes),
                    Err(error) => return Err(SceneError::Read { path, error }),
                },
            },
            (None, Some(binary)) if i == 0 => Cow::Borrowed(binary),
            (None, _) => {
                return Err(SceneError::not_gltf(format!(
                    "buffer {i} has no uri and there is no binary chunk for it"
                )));
            }
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            return Err(truncated(
                &format!("buffer {i}"),
                buffer.byte_length.0 as usize,
                bytes.len(),
            ));
        }
        list.push(bytes);
    }
    Ok(list)
}
