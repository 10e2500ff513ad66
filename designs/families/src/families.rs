//! The families of sensors, and the built-in sensors: one line here registers each.

mod cap;
mod dome;
mod flat_gel;
mod half_ellipsoid;
mod pin_tip;
mod sheet_mold;

use crate::FamilyEntry;

/// Every family.
pub(crate) const FAMILIES: &[FamilyEntry] = &[
    FamilyEntry::of::<cap::CapFamily>(),
    FamilyEntry::of::<dome::DomeFamily>(),
    FamilyEntry::of::<flat_gel::FlatGelFamily>(),
    FamilyEntry::of::<half_ellipsoid::HalfEllipsoidFamily>(),
    FamilyEntry::of::<pin_tip::PinTipFamily>(),
    FamilyEntry::of::<sheet_mold::SheetMoldFamily>(),
];

/// Every built-in sensor: its name, and its text in `sensors/`.
pub(crate) const SENSORS: &[(&str, &str)] = &[
    ("9dtact", include_str!("../sensors/9dtact.yaml")),
    ("digit-like", include_str!("../sensors/digit-like.yaml")),
    ("fluidic", include_str!("../sensors/fluidic.yaml")),
    ("gelsight-like", include_str!("../sensors/gelsight-like.yaml")),
    ("rtac0", include_str!("../sensors/rtac0.yaml")),
    ("rtac0-published-2025", include_str!("../sensors/rtac0-published-2025.yaml")),
    ("shadowtac", include_str!("../sensors/shadowtac.yaml")),
    ("shadowtac-published-cad", include_str!("../sensors/shadowtac-published-cad.yaml")),
    ("tactip", include_str!("../sensors/tactip.yaml")),
    ("uvdtact", include_str!("../sensors/uvdtact.yaml")),
];
