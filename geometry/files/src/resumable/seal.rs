//! JSON documents whose last key is the hash of everything before it. Any flipped bit is noticed, and every JSON reader
//! reads them.

use serde_json::{Map, Value};

/// Text between the document and its hash, and text after the hash.
const HASH_PREFIX: &str = ",\n  \"blake3\": \"";
const HASH_SUFFIX: &str = "\"\n}\n";
/// Length of a BLAKE3 hash in hex.
const HASH_LENGTH: usize = 64;

/// Reason why a sealed document is not accepted.
///
/// ```
/// use fabkit_files::resumable::{SealError, seal_text, unseal};
///
/// assert_eq!(unseal(b"{\n  \"seed\": 7\n}\n"), Err(SealError::Missing));
/// let sealed = String::from_utf8(seal_text("{\n  \"seed\": 7\n}"))?;
/// let edited = sealed.replace("7,", "8,");
/// assert_eq!(unseal(edited.as_bytes()), Err(SealError::Mismatch));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SealError {
    /// Document that does not end with a hash.
    #[error("it does not end with its checksum")]
    Missing,
    /// Document that ends with a wrong hash.
    #[error("its checksum is another")]
    Mismatch,
}

/// Serializes a document with its hash in the last line.
///
/// ```
/// use fabkit_files::resumable::{seal, unseal};
///
/// let document = serde_json::json!({ "format": "mine", "version": 1 });
/// let mut bytes = seal(document.as_object().unwrap());
/// assert_eq!(unseal(&bytes)?, document);
/// bytes[5] ^= 1;
/// assert!(unseal(&bytes).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn seal(document: &Map<String, Value>) -> Vec<u8> {
    seal_text(&format!("{:#}", Value::Object(document.clone())))
}

/// Adds the hash to a document that is text already: a non-empty object with one key per line.
///
/// ```
/// use fabkit_files::resumable::{seal_text, unseal};
///
/// let sealed = String::from_utf8(seal_text("{\n  \"seed\": 7\n}\n"))?;
/// assert!(sealed.starts_with("{\n  \"seed\": 7,\n  \"blake3\": \""));
/// assert_eq!(unseal(sealed.as_bytes())?["seed"], 7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn seal_text(text: &str) -> Vec<u8> {
    let text = text.trim_end_matches('\n');
    // The hash takes the place of the closing brace.
    let mut text = text.strip_suffix('}').unwrap_or(text).trim_end_matches('\n').to_owned();
    let hash = blake3::hash(text.as_bytes()).to_hex();
    text += HASH_PREFIX;
    text += &hash;
    text += HASH_SUFFIX;
    text.into_bytes()
}

/// Checks the hash and returns the document without it.
///
/// # Errors
/// [`SealError`].
pub fn unseal(bytes: &[u8]) -> Result<Value, SealError> {
    let end = HASH_PREFIX.len() + HASH_LENGTH + HASH_SUFFIX.len();
    let (body, seal) = bytes.split_at(bytes.len().saturating_sub(end));
    let hash = blake3::hash(body).to_hex();
    if seal == [HASH_PREFIX.as_bytes(), hash.as_bytes(), HASH_SUFFIX.as_bytes()].concat() {
        // The hashed part ends before the closing brace.
        let text = [body, b"}"].concat();
        return serde_json::from_slice(&text).map_err(|_| SealError::Missing);
    }
    // Either end of a seal shows that there was one, which is now damaged.
    let is_sealed =
        seal.starts_with(HASH_PREFIX.as_bytes()) || seal.ends_with(HASH_SUFFIX.as_bytes());
    Err(if is_sealed { SealError::Mismatch } else { SealError::Missing })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn every_flipped_bit_and_every_cut_is_noticed() {
        let document = json!({ "a": { "b": [1, 2.5, "}\n}"] }, "z": { "files": {} } });
        let sealed = seal(document.as_object().unwrap());
        let whole: Value = serde_json::from_slice(&sealed).unwrap();
        assert_eq!(whole["a"], document["a"], "it is JSON");
        assert_eq!(unseal(&sealed), Ok(document));
        for bit in 0..8 * sealed.len() {
            let mut flipped = sealed.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(unseal(&flipped).is_err(), "{bit}");
        }
        for length in 0..sealed.len() {
            assert!(unseal(&sealed[..length]).is_err(), "{length}");
        }
        assert!(unseal(&[&sealed[..], b"\n"].concat()).is_err());
    }
}
