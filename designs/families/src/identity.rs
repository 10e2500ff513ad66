//! Identity of the design that a file belongs to.

use crate::Design;

/// Computes the BLAKE3 hash, in hex, of fabkit's version, the sensor's name and every parameter as `path=value`.
///
/// Two files with the same hash were made from the same geometry. Sources, notes and comments do not count; the chord
/// tolerance does not either, because it belongs to the file, not to the design.
pub fn design_hash(design: &Design) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut line = |key: &str, value: &str| {
        hasher.update(key.as_bytes());
        hasher.update(b"=");
        hasher.update(value.as_bytes());
        hasher.update(b"\n");
    };
    line("fabkit", env!("CARGO_PKG_VERSION"));
    line("sensor", &design.sensor.name);
    // A default describes what the family did before the parameter existed: leaving it out keeps the hashes of older
    // designs.
    for setting in design.parameters.iter().filter(|setting| !setting.is_default) {
        line(&setting.path, &setting.value);
    }
    hasher.finalize().to_hex().to_string()
}
