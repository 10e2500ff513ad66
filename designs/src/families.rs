//! The families of sensors, and the built-in sensors: one line here registers each.

mod cap;
mod dome;

use crate::FamilyEntry;

/// Every family.
pub(crate) const FAMILIES: &[FamilyEntry] =
    &[FamilyEntry::of::<cap::CapFamily>(), FamilyEntry::of::<dome::DomeFamily>()];

/// Every built-in sensor: its name, and its text in `sensors/`.
pub(crate) const SENSORS: &[(&str, &str)] = &[
    ("rtac0", include_str!("../sensors/rtac0.yaml")),
    ("shadowtac", include_str!("../sensors/shadowtac.yaml")),
    ("shadowtac-published-cad", include_str!("../sensors/shadowtac-published-cad.yaml")),
];
