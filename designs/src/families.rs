//! The families of sensors, and the built-in sensors: one line here registers each.

mod cap;
mod dome;
mod half_ellipsoid;
mod pin_tip;
mod sheet_mold;

use crate::FamilyEntry;

/// Every family.
pub(crate) const FAMILIES: &[FamilyEntry] = &[
    FamilyEntry::of::<cap::CapFamily>(),
    FamilyEntry::of::<dome::DomeFamily>(),
    FamilyEntry::of::<half_ellipsoid::HalfEllipsoidFamily>(),
    FamilyEntry::of::<pin_tip::PinTipFamily>(),
    FamilyEntry::of::<sheet_mold::SheetMoldFamily>(),
];

/// Every built-in sensor: its name, and its text in `sensors/`.
pub(crate) const SENSORS: &[(&str, &str)] = &[
    ("fluidic", include_str!("../sensors/fluidic.yaml")),
    ("rtac0", include_str!("../sensors/rtac0.yaml")),
    ("rtac0-published-2025", include_str!("../sensors/rtac0-published-2025.yaml")),
    ("shadowtac", include_str!("../sensors/shadowtac.yaml")),
    ("shadowtac-published-cad", include_str!("../sensors/shadowtac-published-cad.yaml")),
    ("tactip", include_str!("../sensors/tactip.yaml")),
    ("uvdtact", include_str!("../sensors/uvdtact.yaml")),
];
