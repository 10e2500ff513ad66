//! Camera modules that can be bought: `camera.module` names one, and its sizes hold where nobody who
//! wrote later has written another.

use fabkit_text::{
    Content, Document, Entry, Place, TextLayer, WrittenText, mapping_of, shown, suggestion,
};

use super::SENSOR;

/// What a design takes that names no module.
const NONE: &str = "none";

/// The section of a family's parameters that tells of the camera, and the key in it that names a module.
const SECTION: &str = "camera";
const KEY: &str = "module";

/// Every module: its name, and its text in `cameras/`.
const MODULES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/cameras.rs"));

/// What one family calls otherwise than the modules' files.
const ALIASES: [(&str, &str); 2] =
    [("screw_spacing", "hole_spacing"), ("screw_spacing_y", "hole_spacing_y")];

/// Keys of what a family's camera is: a board, a block or a thin tube. A module that says none of those
/// that the family has is of another kind.
const KINDS: [&str; 3] = ["board_size", "housing_size", "diameter"];

/// Names of the modules, sorted.
pub fn camera_modules() -> impl Iterator<Item = &'static str> {
    MODULES.iter().map(|(name, _)| *name)
}

/// Lays the sizes of the module that a document names under whatever was written with or after that name.
pub(super) fn lay_module(document: &mut Document) {
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
        let found = place.problem(&path, &shown(&name), message);
        document.found.push(found.hint(hint).code(code));
    };
    let Some((name, yaml)) = MODULES.iter().find(|(module, _)| *module == name) else {
        let message = format!("`{}` is not a camera module", shown(&name));
        let names = fitting.into_iter().chain([NONE]);
        let hint = suggestion(&name, names, "this sensor takes one of");
        return refuse("unknown_module", message, hint);
    };
    if !fitting.contains(name) {
        let message = format!("{name} is another kind of camera than this sensor is built around");
        let hint = format!("it takes one of {}", fitting.join(", "));
        return refuse("wrong_module", message, hint);
    }
    let at = Place::new(TextLayer::Base, &format!("{name}.yaml (camera module)"), &SENSOR);
    let mut section = section_of(yaml);
    if let Some(Entry { value, .. }) = &mut section
        && let Content::Map(entries) = &mut value.content
    {
        entries.retain_mut(|entry| is_taken(entry, &known));
    }
    document.lay_under(section.into_iter().collect(), &at, place.layer);
}

/// What a module's file says of the camera.
fn section_of(yaml: &str) -> Option<Entry> {
    let place = Place::new(TextLayer::Base, SECTION, &SENSOR);
    let all = mapping_of(yaml, &place, &mut Vec::new())?;
    all.into_iter().find(|entry| entry.key == SECTION)
}

/// The keys that a module's file gives.
fn keys(yaml: &str) -> Vec<String> {
    match section_of(yaml).map(|section| section.value.content) {
        Some(Content::Map(entries)) => entries.into_iter().map(|entry| entry.key).collect(),
        _ => Vec::new(),
    }
}

/// Whether a module is of the kind that a family, whose parameters are known, is built around.
fn fits(yaml: &str, known: &[String]) -> bool {
    let keys = keys(yaml);
    KINDS.iter().any(|kind| is_known(kind, known) && keys.iter().any(|key| key == kind))
}

fn is_known(key: &str, known: &[String]) -> bool {
    known
        .iter()
        .any(|path| path.strip_prefix(SECTION).and_then(|p| p.strip_prefix('.')) == Some(key))
}

/// Whether a family has the parameter, if need be under the name that it has for it.
fn is_taken(entry: &mut Entry, known: &[String]) -> bool {
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
            let place = Place::new(TextLayer::Base, name, &SENSOR);
            let mut found = Vec::new();
            mapping_of(yaml, &place, &mut found);
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
