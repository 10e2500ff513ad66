//! Reader of an array's `zarr.json` that trusts none of its content.

use serde_json::Value;

use super::{ZarrArray, ZarrType};

/// Maximum number of bytes of one sample: 64 million pixels of four bytes.
const MAX_SAMPLE_BYTES: u64 = 256_000_000;
/// Maximum number of samples of one array: all pairs of a thousand patterns.
const MAX_SAMPLES: u64 = 1_000_000;
/// Maximum number of chunks in one file.
const MAX_ENTRIES: u64 = 1 << 20;
/// Maximum number of a sample's axes: rows, columns and colours.
const MAX_AXES: usize = 3;

/// Reasons why a `zarr.json` is not one that [`ZarrArray::metadata`] writes.
///
/// ```
/// use fabkit_export::{InvalidMetadata, ZarrArray};
///
/// assert!(matches!(ZarrArray::from_metadata(b"["), Err(InvalidMetadata::Json(_))));
/// let complex = ZarrArray::from_metadata(br#"{"data_type": "complex64"}"#).unwrap_err();
/// assert_eq!(complex.to_string(), "`data_type` is not what fabkit writes");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidMetadata {
    /// Content that is not JSON.
    #[error("not JSON: {0}")]
    Json(String),
    /// Key that is missing or has another value than fabkit writes.
    #[error("`{0}` is not what fabkit writes")]
    Foreign(&'static str),
    /// Size outside its limits.
    #[error("{what} is {found}; {limit}")]
    Size {
        /// Name of the size, for example `chunk_shape[1]`.
        what: String,
        /// Value found.
        found: u64,
        /// Permitted values.
        limit: String,
    },
}

impl ZarrArray {
    /// Reads a document written by [`metadata`](Self::metadata), and no other: every size is checked before it is used
    /// in a computation.
    ///
    /// # Errors
    /// [`InvalidMetadata`].
    pub fn from_metadata(bytes: &[u8]) -> Result<Self, InvalidMetadata> {
        let json: Value = serde_json::from_slice(bytes)
            .map_err(|error| InvalidMetadata::Json(error.to_string()))?;
        let element = match json["data_type"].as_str() {
            Some("float32") => ZarrType::F32,
            Some("uint16") => ZarrType::U16,
            Some("uint8") => ZarrType::U8,
            _ => return Err(InvalidMetadata::Foreign("data_type")),
        };
        let sharding = &json["codecs"][0]["configuration"];
        let shape = sizes(&json["shape"], "shape")?;
        let shard = sizes(&json["chunk_grid"]["configuration"]["chunk_shape"], "chunk_grid")?;
        let chunk = sizes(&sharding["chunk_shape"], "codecs")?;
        // Chunks hold one sample each, hence the 1 in the chunk shape.
        let ([samples, sample_shape @ ..], [samples_per_shard, ..], [1, chunk_shape @ ..]) =
            (&shape[..], &shard[..], &chunk[..])
        else {
            return Err(InvalidMetadata::Foreign("shape"));
        };
        if chunk.len() != shape.len() || shard.len() != shape.len() || sample_shape.len() > MAX_AXES
        {
            return Err(InvalidMetadata::Foreign("shape"));
        }
        let names = json["dimension_names"].as_array();
        let names = names.filter(|names| names.len() == shape.len());
        let names = names.into_iter().flatten().map(|name| Some(name.as_str()?.to_owned()));
        let array = Self {
            element,
            samples: *samples,
            sample_shape: sample_shape.to_vec(),
            chunk_shape: chunk_shape.to_vec(),
            samples_per_shard: *samples_per_shard,
            dimensions: names
                .collect::<Option<Vec<String>>>()
                .ok_or(InvalidMetadata::Foreign("dimension_names"))?,
            attributes: json["attributes"].clone(),
        };
        array.check_sizes()?;
        array.check_rest(&json)?;
        Ok(array)
    }

    /// Checks every size against its limit.
    fn check_sizes(&self) -> Result<(), InvalidMetadata> {
        let limit = |what: &str, found: u64, most: u64| {
            if (1..=most).contains(&found) {
                Ok(())
            } else {
                let limit = format!("it is from 1 to {most}");
                Err(InvalidMetadata::Size { what: what.into(), found, limit })
            }
        };
        limit("the number of samples", self.samples, MAX_SAMPLES)?;
        let mut bytes = self.element.size() as u64;
        for (axis, (size, chunk)) in self.sample_shape.iter().zip(&self.chunk_shape).enumerate() {
            limit(&format!("shape[{}]", axis + 1), *size, MAX_SAMPLE_BYTES)?;
            limit(&format!("chunk_shape[{}]", axis + 1), *chunk, *size)?;
            // Both factors are at most 2.56e8, so the product fits into 64 bits.
            bytes *= size;
            limit("a sample's number of bytes", bytes, MAX_SAMPLE_BYTES)?;
        }
        limit("the number of samples in a file", self.samples_per_shard, MAX_ENTRIES)?;
        // There are at most as many chunks as bytes: the product is below 2^48.
        let entries = self.samples_per_shard * self.chunks_per_sample();
        limit("the number of chunks in a file", entries, MAX_ENTRIES)
    }

    /// Checks everything but the values read above.
    fn check_rest(&self, json: &Value) -> Result<(), InvalidMetadata> {
        let expected = self.document();
        let keys = ["zarr_format", "node_type", "chunk_grid", "chunk_key_encoding", "fill_value"];
        for key in keys.into_iter().chain(["codecs", "dimension_names"]) {
            if json[key] != expected[key] {
                return Err(InvalidMetadata::Foreign(key));
            }
        }
        // Unknown keys may change the meaning of the rest, such as extensions and storage transformers.
        if *json == expected { Ok(()) } else { Err(InvalidMetadata::Foreign("a key of the array")) }
    }
}

fn sizes(value: &Value, what: &'static str) -> Result<Vec<u64>, InvalidMetadata> {
    let sizes = value.as_array().map(|sizes| sizes.iter().map(Value::as_u64).collect());
    sizes.flatten().ok_or(InvalidMetadata::Foreign(what))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn array() -> ZarrArray {
        ZarrArray {
            element: ZarrType::F32,
            samples: 10,
            sample_shape: vec![72, 96],
            chunk_shape: vec![72, 24],
            samples_per_shard: 16,
            dimensions: ["half", "row", "column"].map(String::from).to_vec(),
            attributes: json!({ "unit": "mm" }),
        }
    }

    #[test]
    fn what_was_written_is_read_and_nothing_else() {
        let array = array();
        let bytes = array.metadata().unwrap();
        assert_eq!(ZarrArray::from_metadata(&bytes).unwrap(), array);
        let text = String::from_utf8(bytes).unwrap();
        let whole: Value = serde_json::from_str(&text).unwrap();
        let grid = "/chunk_grid/configuration/chunk_shape";
        let chunk = "/codecs/0/configuration/chunk_shape";
        let numbers = [0, 73, 1_000_000, 1 << 31, 1 << 62, u64::MAX];
        for (axis, number) in (0..3).flat_map(|axis| numbers.map(|number| (axis, number))) {
            for pointer in ["/shape", grid, chunk] {
                let mut json = whole.clone();
                json.pointer_mut(pointer).unwrap()[axis] = json!(number);
                let text = json.to_string();
                // Some changes are valid in themselves: only the plan determines the number of samples.
                let is_sound = match (pointer, axis, number) {
                    ("/shape", 0, number) => (1..=1_000_000).contains(&number),
                    ("/shape", 2, 73) => true,
                    (_, 0, 73) => pointer == grid,
                    _ => false,
                };
                assert_eq!(ZarrArray::from_metadata(text.as_bytes()).is_ok(), is_sound, "{text}");
            }
        }
        let edits = [
            ("/fill_value", json!(1.0)),
            ("/codecs/0/name", json!("blosc")),
            ("/codecs/0/configuration/codecs/2", json!({ "name": "crc32" })),
            ("/chunk_key_encoding/configuration/separator", json!(".")),
            ("/data_type", json!("float64")),
            ("/dimension_names", json!(["half"])),
            ("/zarr_format", json!(2)),
            ("/shape", json!([])),
        ];
        for (pointer, value) in edits {
            let mut json = whole.clone();
            *json.pointer_mut(pointer).unwrap() = value;
            assert!(ZarrArray::from_metadata(json.to_string().as_bytes()).is_err(), "{pointer}");
        }
        let more = text.replacen('{', "{\"storage_transformers\": [],", 1);
        assert!(ZarrArray::from_metadata(more.as_bytes()).is_err());
        assert!(ZarrArray::from_metadata(b"no JSON").is_err());
    }
}
