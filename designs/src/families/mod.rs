//! The families of sensors, and the built-in sensors: one line here registers each.

use crate::FamilyEntry;

/// Every family.
pub(crate) const FAMILIES: &[FamilyEntry] = &[];

/// Every built-in sensor: its name, and its text in `sensors/`.
pub(crate) const SENSORS: &[(&str, &str)] = &[];
