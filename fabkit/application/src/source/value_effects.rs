//! Effects of the values that a user sets on a design.

use fabkit_fixtures::{ValueEffects, find_value_effects};
use serde_json::{Value, json};

use super::{Source, Target};

impl Target<'_> {
    /// Finds the values of files and overrides that change nothing, and those that are no lengths but change the size of the
    /// whole. Nothing for a design that cannot be loaded: whoever loads it reports why.
    ///
    /// ```
    /// use fabkit_application::source::Target;
    ///
    /// let target = Target::new("rtac0");
    /// let found = target.value_effects(&["mount.width=31 mm".into()]);
    /// assert_eq!(found.effects[0].path(), "mount.width");
    /// assert_eq!(found.effects[0].code(), "value_without_effect");
    /// assert!(target.value_effects(&["shell.wall=1.6 mm".into()]).effects.is_empty());
    /// assert!(target.value_effects(&["no.such_value=1".into()]).effects.is_empty());
    /// ```
    pub fn value_effects(&self, overrides: &[String]) -> ValueEffects {
        // Without values of the user there is nothing to compare: a built-in sensor costs no time here.
        if self.is_builtin() && overrides.is_empty() {
            return ValueEffects::default();
        }
        self.source().map(|source| source.value_effects(overrides)).unwrap_or_default()
    }
}

impl Source {
    /// Finds the same as [`Target::value_effects`] for a source.
    pub fn value_effects(&self, overrides: &[String]) -> ValueEffects {
        find_value_effects(self.sensor_text(), overrides).unwrap_or_default()
    }
}

/// Returns effects as JSON: code, path and one sentence each.
pub fn value_effects_json(found: &ValueEffects) -> Value {
    let effects = found.effects.iter();
    effects
        .map(|one| json!({ "code": one.code(), "path": one.path(), "message": one.to_string() }))
        .collect()
}
