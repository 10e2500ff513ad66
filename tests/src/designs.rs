//! The built-in sensors as the library builds them.

use fabkit_designs::{Design, builtin_names, builtin_yaml, load};

/// Every built-in sensor with its own values.
///
/// # Panics
/// If one does not load.
pub fn builtin_designs() -> Vec<Design> {
    let design = |name: &str| {
        let yaml = builtin_yaml(name).expect("named by the registry");
        load(name, yaml, &[]).unwrap_or_else(|e| panic!("{name}: {:#?}", e.problems))
    };
    builtin_names().into_iter().map(design).collect()
}
