//! The families of sensors, and the built-in sensors: one line here registers each.

mod dome;
mod pin_tip;
mod sheet_mold;

use crate::FamilyEntry;

/// Every family.
pub(crate) const FAMILIES: &[FamilyEntry] = &[
    FamilyEntry::of::<dome::DomeFamily>(),
    FamilyEntry::of::<pin_tip::PinTipFamily>(),
    FamilyEntry::of::<sheet_mold::SheetMoldFamily>(),
];

/// Every built-in sensor: its name, and its text in `sensors/`.
pub(crate) const SENSORS: &[(&str, &str)] = &[
    ("fluidic", include_str!("../sensors/fluidic.yaml")),
    ("rtac0", include_str!("../sensors/rtac0.yaml")),
    ("tactip", include_str!("../sensors/tactip.yaml")),
];
