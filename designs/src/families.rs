//! The families of sensors, and the built-in sensors: one line here registers each.

mod dome;
mod pin_tip;

use crate::FamilyEntry;

/// Every family.
pub(crate) const FAMILIES: &[FamilyEntry] =
    &[FamilyEntry::of::<dome::DomeFamily>(), FamilyEntry::of::<pin_tip::PinTipFamily>()];

/// Every built-in sensor: its name, and its text in `sensors/`.
pub(crate) const SENSORS: &[(&str, &str)] = &[
    ("rtac0", include_str!("../sensors/rtac0.yaml")),
    ("tactip", include_str!("../sensors/tactip.yaml")),
];
