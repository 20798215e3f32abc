//! References out of a glTF file: data URIs and relative paths.

use std::path::{Path, PathBuf};

use crate::error::SceneError;

/// What a URI stands for.
pub(super) enum Resolved {
    /// The bytes it carries.
    Data(Vec<u8>),
    /// A file that may not exist.
    File(PathBuf),
}

/// Resolves `uri` from `folder`; `what` names it in errors.
pub(super) fn resolve(
    uri: &str,
    folder: Option<&Path>,
    what: &str,
) -> Result<Resolved, SceneError> {
    if let Some(rest) = uri.strip_prefix("data:") {
        let data = rest
            .split_once(";base64,")
            .and_then(|(_, data)| decode_base64(data));
        return data.map(Resolved::Data).ok_or_else(|| {
            SceneError::invalid(what, "its data URI is not valid base64; embed it again")
        });
    }
    if uri.contains("://") {
        return Err(SceneError::invalid(
            what,
            format!("`{uri}` is not a local file; download it and refer to the copy"),
        ));
    }
    match folder {
        Some(folder) => Ok(Resolved::File(folder.join(decode_percent(uri)))),
        None => Err(SceneError::invalid(
            what,
            format!("it is in the file `{uri}`, which a scene in memory cannot refer to"),
        )),
    }
}

fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(text.len() * 3 / 4);
    let (mut bits, mut count) = (0u32, 0);
    for &character in text {
        let value = match character {
            b'A'..=b'Z' => character - b'A',
            b'a'..=b'z' => character - b'a' + 26,
            b'0'..=b'9' => character - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}

fn decode_percent(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let code = text
            .get(at + 1..at + 3)
            .filter(|_| bytes[at] == b'%')
            .and_then(|hex| u8::from_str_radix(hex, 16).ok());
        out.push(code.unwrap_or(bytes[at]));
        at += if code.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes() {
        assert_eq!(decode_base64("TWFu"), Some(b"Man".to_vec()));
        assert_eq!(decode_base64("TWE="), Some(b"Ma".to_vec()));
        assert_eq!(decode_base64("TQ=="), Some(b"M".to_vec()));
        assert_eq!(decode_base64("T!=="), None);
        assert_eq!(decode_percent("a%20b%2F%zz%"), "a b/%zz%");
    }
}
