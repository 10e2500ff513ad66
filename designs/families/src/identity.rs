//! Which design a file belongs to.

use crate::Design;

/// BLAKE3, in hex, over fabkit's version, the sensor's name and every parameter as `path=value`.
///
/// Two files with the same hash were made from the same geometry. Sources, notes and comments do
/// not count; the chord tolerance does not either, because it belongs to the file, not the design.
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
    // What a family does by default it did before it could do otherwise.
    for setting in design.parameters.iter().filter(|setting| !setting.is_default) {
        line(&setting.path, &setting.value);
    }
    hasher.finalize().to_hex().to_string()
}
