//! Identity of the design that a file belongs to.

use std::fmt::{self, Debug, Write};

use fabkit_geometry::Sensor;

use crate::Design;

/// Computes the BLAKE3 hash, in hex, of fabkit's version, the sensor's name and every parameter as `path=value`.
///
/// Two files with the same hash were made from the same geometry. Sources, notes and comments do not count; the chord
/// tolerance does not either, because it belongs to the file, not to the design.
///
/// ```
/// use fabkit_designs::{builtin_yaml, design_hash, load};
/// let yaml = builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let hash = |overrides: &[String]| {
///     load("rtac0.yaml", yaml, overrides, &["fixtures"]).map(|design| design_hash(&design))
/// };
/// // The same value in another unit makes the same parts.
/// assert_eq!(hash(&["shell.wall=0.15 cm".into()])?, hash(&[])?);
/// assert_ne!(hash(&["shell.wall=1.6 mm".into()])?, hash(&[])?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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

/// Computes the BLAKE3 hash of everything that a built sensor holds: bodies, chain, orders, camera, light, labels.
///
/// Two sensors with the same hash are made, checked, drawn and simulated alike. The hash goes over the sensor's fields as
/// they are declared, so that a new field counts without being listed here. It is valid within one process only.
///
/// ```
/// use fabkit_designs::{built_hash, builtin_yaml, load};
/// let yaml = builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let hash = |overrides: &[String]| {
///     load("rtac0.yaml", yaml, overrides, &["fixtures"]).map(|design| built_hash(&design.sensor))
/// };
/// assert_eq!(hash(&["shell.wall=0.15 cm".into()])?, hash(&[])?);
/// assert_ne!(hash(&["shell.wall=1.6 mm".into()])?, hash(&[])?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn built_hash(sensor: &Sensor) -> [u8; 32] {
    debug_hash(sensor)
}

/// Computes the BLAKE3 hash of all fields of a value, as they are declared. It is valid within one process only.
///
/// ```
/// use fabkit_designs::debug_hash;
/// assert_eq!(debug_hash(&(1, "a")), debug_hash(&(1, "a")));
/// assert_ne!(debug_hash(&(1, "a")), debug_hash(&(1, "b")));
/// ```
pub fn debug_hash(value: &dyn Debug) -> [u8; 32] {
    struct Hashed(blake3::Hasher);
    impl Write for Hashed {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            self.0.update(text.as_bytes());
            Ok(())
        }
    }
    let mut hashed = Hashed(blake3::Hasher::new());
    // Writing into a hasher cannot fail.
    let _ = write!(hashed, "{value:?}");
    *hashed.0.finalize().as_bytes()
}
