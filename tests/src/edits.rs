//! How far a sensor follows its user: what of its edits is refused.

use fabkit_designs::parameters::{Kind, Problem, Setting};
use fabkit_designs::{builtin_yaml, load};

/// One parameter of a built-in sensor changed alone.
#[derive(Clone, Debug)]
pub struct Edit {
    /// Dotted path of the parameter.
    pub path: String,
    /// What it is set to.
    pub value: String,
    /// Why that is refused; empty where it is not.
    pub problems: Vec<Problem>,
}

/// What becomes of a sensor with each of its numeric parameters changed alone, down and up by a share;
/// counts at least by one.
///
/// # Panics
/// If there is no such sensor, or it does not load.
pub fn edits(sensor: &str, share: f64) -> Vec<Edit> {
    let yaml = builtin_yaml(sensor).expect("a built-in sensor");
    let refused = |overrides: &[String]| match load(sensor, yaml, overrides, &["fixtures"]) {
        Ok(design) => Ok(design),
        Err(invalid) => Err(invalid.problems),
    };
    let design = refused(&[]).unwrap_or_else(|problems| panic!("{sensor}: {problems:#?}"));
    let mut edits = Vec::new();
    for setting in &design.parameters {
        for value in [-share, share].into_iter().filter_map(|by| changed(setting, by)) {
            let path = setting.path.clone();
            let problems = refused(&[format!("{path}={value}")]).err().unwrap_or_default();
            edits.push(Edit { path, value, problems });
        }
    }
    edits
}

/// The value more by a share, as it would be written; nothing for texts and lists, or if it is 0.
fn changed(setting: &Setting, by: f64) -> Option<String> {
    let (number, unit) = match setting.value.split_once(' ') {
        Some((number, unit)) => (number, format!(" {unit}")),
        None => (setting.value.as_str(), String::new()),
    };
    let number: f64 = match setting.kind {
        Kind::Length | Kind::Angle | Kind::Count | Kind::Number => number.parse().ok()?,
        Kind::Switch | Kind::Text | Kind::List => return None,
    };
    if number == 0.0 {
        return None;
    }
    let other = match setting.kind {
        Kind::Count => number + (number * by).abs().round().max(1.0) * by.signum(),
        // To a micrometre, as somebody would write it.
        _ => (number * (1.0 + by) * 1e6).round() / 1e6,
    };
    Some(format!("{other}{unit}"))
}
