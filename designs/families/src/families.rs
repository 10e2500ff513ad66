//! The families of sensors, each registered here alone, and the built-in sensors: every file of `sensors/`.

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
pub(crate) const SENSORS: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/sensors.rs"));
