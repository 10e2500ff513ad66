//! Report on a printer profile's application in an export.

use std::collections::BTreeMap;

use fabkit_application::export::{Manifest, UncompensatedBody};

/// Lists the parts to which the profile is applied despite another material, and those to which it is not applied.
/// Empty without a profile.
pub(super) fn format_profile_report(manifest: &Manifest) -> String {
    let Some(profile) = &manifest.profile else { return String::new() };
    let mut text = String::new();
    if !profile.applied_to_other_material.is_empty() {
        text += &format!(
            "warning: {} was measured on {} and is applied to other materials: {}\n",
            profile.name,
            profile.material,
            profile.applied_to_other_material.join(", ")
        );
    }
    let mut left: BTreeMap<(&str, &str, &str), Vec<&str>> = BTreeMap::new();
    for UncompensatedBody { part, process, material, because } in &profile.not_applied {
        left.entry((because, process, material)).or_default().push(part);
    }
    for ((because, process, material), parts) in left {
        let (of, more) = match (because, process) {
            ("other-material", _) => {
                let more = "; --process-for-any-material applies it all the same";
                (format!("another material, {material}"), more)
            }
            (_, "") => ("what is bought".to_owned(), ""),
            _ => (format!("{process} of {material}"), ""),
        };
        text += &format!(
            "{} ({} of {}) is not applied to {of}: {}{more}\n",
            profile.name,
            profile.process,
            profile.material,
            parts.join(", ")
        );
    }
    text
}
