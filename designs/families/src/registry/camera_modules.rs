//! Purchasable camera modules. `camera.module` names one; its sizes apply where no later layer of the files sets
//! another.

use fabkit_text::{
    ParameterTable, TextLayer, TextPlace, WrittenText, YamlContent, YamlEntry, read_mapping,
    suggestion, to_printable,
};

use super::SENSOR;

/// Value of `camera.module` for a design without a module.
const NONE: &str = "none";

/// Section of the camera parameters of a family, and the key in it that names a module.
const SECTION: &str = "camera";
const KEY: &str = "module";

/// All modules: name, and text from `cameras/`.
const MODULES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/cameras.rs"));

/// Keys that one family names differently from the modules' files: (key in the file, key of the family).
const ALIASES: [(&str, &str); 2] =
    [("screw_spacing", "hole_spacing"), ("screw_spacing_y", "hole_spacing_y")];

/// Keys that identify the shape of a family's camera: a board, a block or a thin tube. A module that gives none of the
/// family's keys is of another kind.
const KINDS: [&str; 3] = ["board_size", "housing_size", "diameter"];

/// Returns the names of the modules, sorted.
///
/// ```
/// use fabkit_designs::{builtin_yaml, camera_modules, load};
/// assert!(camera_modules().any(|name| name == "ov9281-uvc-32"));
/// let yaml = builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let with = |module: &str| {
///     load("rtac0.yaml", yaml, &[format!("camera.module={module}")], &["fixtures"])
/// };
/// assert!(with("ov9281-uvc-32").is_ok());
/// // R-Tac0 is built around a board, and this module is a tube of 1.5 mm.
/// assert_eq!(with("comedia-muc103p").unwrap_err().problems[0].facts.code, "wrong_module");
/// # Ok::<(), &str>(())
/// ```
pub fn camera_modules() -> impl Iterator<Item = &'static str> {
    MODULES.iter().map(|(name, _)| *name)
}

/// Lays the sizes of the module that a document names below all values written in the same layer as that name or later.
pub(super) fn lay_module(document: &mut ParameterTable) {
    let path = format!("{SECTION}.{KEY}");
    let Some(written) = document.written(&path) else { return };
    let WrittenText::Scalar(name) = &written.text else { return };
    let (name, place) = (name.clone(), written.place.clone());
    if name == NONE {
        return;
    }
    let known = document.paths();
    let fitting: Vec<&str> =
        MODULES.iter().filter(|(_, yaml)| fits(yaml, &known)).map(|(name, _)| *name).collect();
    let mut refuse = |code, message: String, hint: String| {
        let found = place.problem(&path, &to_printable(&name), message);
        document.found.push(found.hint(hint).code(code));
    };
    let Some((name, yaml)) = MODULES.iter().find(|(module, _)| *module == name) else {
        let message = format!("`{}` is not a camera module", to_printable(&name));
        let names = fitting.into_iter().chain([NONE]);
        let hint = suggestion(&name, names, "this sensor takes one of");
        return refuse("unknown_module", message, hint);
    };
    if !fitting.contains(name) {
        let message = format!("{name} is another kind of camera than this sensor is built around");
        let hint = format!("it takes one of {}", fitting.join(", "));
        return refuse("wrong_module", message, hint);
    }
    let at = TextPlace::new(TextLayer::Base, &format!("{name}.yaml (camera module)"), &SENSOR);
    let mut section = section_of(yaml);
    if let Some(YamlEntry { value, .. }) = &mut section
        && let YamlContent::Map(entries) = &mut value.content
    {
        entries.retain_mut(|entry| is_taken(entry, &known));
    }
    // Below the layer that names the module, so that values of the same layer or later ones override it.
    document.merge_below(section.into_iter().collect(), &at, place.layer);
}

/// Returns the camera section of a module's file.
fn section_of(yaml: &str) -> Option<YamlEntry> {
    let place = TextPlace::new(TextLayer::Base, SECTION, &SENSOR);
    let all = read_mapping(yaml, &place, &mut Vec::new())?;
    all.into_iter().find(|entry| entry.key == SECTION)
}

/// Returns the keys that a module's file gives.
fn keys(yaml: &str) -> Vec<String> {
    match section_of(yaml).map(|section| section.value.content) {
        Some(YamlContent::Map(entries)) => entries.into_iter().map(|entry| entry.key).collect(),
        _ => Vec::new(),
    }
}

/// Returns whether a module is of the kind that a family with the parameters `known` is built around.
fn fits(yaml: &str, known: &[String]) -> bool {
    let keys = keys(yaml);
    KINDS.iter().any(|kind| is_known(kind, known) && keys.iter().any(|key| key == kind))
}

/// Returns whether a family has the camera parameter `key`.
fn is_known(key: &str, known: &[String]) -> bool {
    known
        .iter()
        .any(|path| path.strip_prefix(SECTION).and_then(|p| p.strip_prefix('.')) == Some(key))
}

/// Returns whether a family has the parameter; renames the entry to the family's own name for it where needed.
fn is_taken(entry: &mut YamlEntry, known: &[String]) -> bool {
    if let Some((_, alias)) = ALIASES.iter().find(|(key, _)| *key == entry.key)
        && !is_known(&entry.key, known)
    {
        entry.key = (*alias).to_owned();
    }
    is_known(&entry.key, known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_a_camera_with_sources() {
        for (name, yaml) in MODULES {
            let place = TextPlace::new(TextLayer::Base, name, &SENSOR);
            let mut found = Vec::new();
            read_mapping(yaml, &place, &mut found);
            assert!(found.is_empty(), "{name}: {found:#?}");
            let keys = keys(yaml);
            assert!(
                KINDS.iter().any(|kind| keys.iter().any(|key| key == kind)),
                "{name}: {keys:?}"
            );
            assert!(keys.iter().any(|key| key == "model"), "{name}");
        }
    }
}
